//! Amplitude and envelope spectra, and band limits, of sampled signals.

use std::sync::{LazyLock, Mutex, PoisonError};

use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;

use super::special::sinc;
use super::statistics::mean;

/// One-sided amplitude spectrum: entry `k` belongs to frequency `k · resolution`, and a sine of
/// amplitude 1 on a bin reads 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// [Hz]
    pub resolution: f64,
    pub amplitude: Vec<f64>,
    /// Name of the window.
    pub window: &'static str,
    /// Spectra whose mean power this is the root of.
    pub averages: usize,
}

impl Spectrum {
    /// Root of the mean power of all the spectra that both are made of, which are of signals of one length and rate.
    pub fn join(&mut self, other: &Self) {
        let averages = self.averages + other.averages;
        let [own, others] = [self.averages, other.averages].map(|part| (part as f64 / averages as f64).sqrt());
        for (own_amplitude, amplitude) in self.amplitude.iter_mut().zip(&other.amplitude) {
            let (one, other) = (own * *own_amplitude, others * amplitude);
            *own_amplitude = (one * one + other * other).sqrt();
        }
        self.averages = averages;
    }
}

/// Noise bandwidth of the Hann window in bins: the squares of the entries of a line add up to its square times this.
pub const HANN_BANDWIDTH: f64 = 1.5;

/// Amplitude spectrum of a signal sampled at `rate` [Hz], mean removed, under a periodic Hann window.
///
/// n values give n/2 + 1 entries, rate/n apart; no values give none. A tone between two bins reads up to 1.4 dB low:
/// see `interpolated_peak`.
pub(crate) fn amplitude_spectrum(signal: &[f64], rate: f64) -> Spectrum {
    let n = signal.len();
    if n == 0 {
        return Spectrum { resolution: 0.0, amplitude: Vec::new(), window: "hann", averages: 1 };
    }
    amplitudes(&bins_about_mean(signal), n, rate)
}

/// [`amplitude_spectrum`] of a signal that is not empty and may hold a part of a period only, of which the mean is no constant: the mean under
/// the window is removed instead.
pub(crate) fn amplitude_spectrum_of_part(signal: &[f64], rate: f64) -> Spectrum {
    let mut bins = bins_about_mean(signal);
    if let [constant, first, ..] = bins.as_mut_slice() {
        *constant = first.re.into();
    }
    amplitudes(&bins, signal.len(), rate)
}

/// Fourier transform of a signal that is not empty, less its mean.
fn bins_about_mean(signal: &[f64]) -> Vec<Complex64> {
    let mean = mean(signal);
    forward(&mut signal.iter().map(|x| x - mean).collect::<Vec<_>>())
}

/// Amplitude spectrum of `n` values from their transform.
fn amplitudes(bins: &[Complex64], n: usize, rate: f64) -> Spectrum {
    // 2 over the sum of the window, n/2.
    let one_sided = 4.0 / n as f64;
    let magnitude = |bin: Complex64| bin.norm_sqr().sqrt();
    let mut amplitude = vec![0.0; bins.len()];
    // Between the ends each bin has its neighbours in the row.
    for (amplitude, around) in amplitude.iter_mut().skip(1).zip(bins.windows(3)) {
        *amplitude = one_sided * magnitude(0.5 * around[1] - 0.25 * (around[0] + around[2]));
    }
    for k in [0, bins.len() - 1] {
        amplitude[k] = one_sided * magnitude(hann(bins, n, k));
    }
    // The first entry and, for an even count, the last have no mirror image.
    amplitude[0] *= 0.5;
    if n.is_multiple_of(2) {
        amplitude[n / 2] *= 0.5;
    }
    Spectrum { resolution: rate / n as f64, amplitude, window: "hann", averages: 1 }
}

/// Bin `k` of `n` real values under the window ½ − ½ cos(2πi/n), from their bins without it. The window has three
/// spectral lines, so that a bin and its two neighbours give the result without a cosine per value.
fn hann(bins: &[Complex64], n: usize, k: usize) -> Complex64 {
    // Bins beyond the ends are mirror images of those within.
    let bin = |k: isize| {
        let k = k.rem_euclid(n as isize) as usize;
        if k < bins.len() { bins[k] } else { bins[n - k].conj() }
    };
    let k = k as isize;
    0.5 * bin(k) - 0.25 * (bin(k - 1) + bin(k + 1))
}

/// Amplitude spectrum of the envelope: the signal passes the band (from, to) [Hz], and the magnitude of its analytic
/// signal, mean removed, is analysed. A carrier in the band with amplitude A (1 + m cos Ωt) reads A·m at Ω.
#[cfg(test)]
pub(crate) fn envelope_spectrum(signal: &[f64], rate: f64, band: (f64, f64)) -> Spectrum {
    let n = signal.len();
    if n == 0 {
        return amplitude_spectrum(signal, rate);
    }
    envelope(forward(&mut signal.to_vec()), n, rate, EnvelopeAnalysis { band, kind: EnvelopeKind::Magnitude })
}

/// Quantity whose spectrum is taken: the envelope, or its square. The square of the envelope of a few tones has no lines beyond their differences.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EnvelopeKind {
    /// Magnitude of the analytic signal.
    #[default]
    Magnitude,
    /// Its square.
    Squared,
}

/// Envelope whose spectrum is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvelopeAnalysis {
    /// Lower and upper end of the band that the signal passes first [Hz].
    pub band: (f64, f64),
    pub kind: EnvelopeKind,
}

/// Both spectra of a signal from one transform: [`amplitude_spectrum`] and, to rounding, [`envelope_spectrum`].
pub(crate) fn amplitude_and_envelope(signal: &[f64], rate: f64, analysis: EnvelopeAnalysis) -> (Spectrum, Spectrum) {
    let n = signal.len();
    if n == 0 {
        return (amplitude_spectrum(signal, rate), amplitude_spectrum(signal, rate));
    }
    let bins = bins_about_mean(signal);
    (amplitudes(&bins, n, rate), envelope(bins, n, rate, analysis))
}

/// Amplitude spectrum of the envelope of `n` values, from their transform.
fn envelope(mut bins: Vec<Complex64>, n: usize, rate: f64, analysis: EnvelopeAnalysis) -> Spectrum {
    let EnvelopeAnalysis { band, kind } = analysis;
    // The mean and, for an even count, the last bin have no quarter turn.
    let frequency = |k: usize| k as f64 * rate / n as f64;
    let from = bins_below(bins.len(), |k| k == 0 || frequency(k) < band.0);
    let to = bins_below(bins.len(), |k| frequency(k) <= band.1 && 2 * k != n);
    bins[..from].fill(Complex64::ZERO);
    bins[to..].fill(Complex64::ZERO);
    // The analytic signal is the passed signal plus i times the same a quarter turn later.
    let mut quarter_turn: Vec<Complex64> = bins.iter().map(|bin| Complex64::new(bin.im, -bin.re)).collect();
    let in_phase = inverse(&mut bins, n);
    let in_quadrature = inverse(&mut quarter_turn, n);
    let squares = in_phase.iter().zip(&in_quadrature).map(|(re, im)| re * re + im * im);
    let envelope: Vec<f64> = match kind {
        EnvelopeKind::Magnitude => squares.map(f64::sqrt).collect(),
        EnvelopeKind::Squared => squares.collect(),
    };
    amplitude_spectrum(&envelope, rate)
}

/// Number of bins up to the first for which `is_below` does not hold, `is_below` falling once with rising number.
fn bins_below(bins: usize, is_below: impl Fn(usize) -> bool) -> usize {
    let (mut below, mut beyond) = (0, bins);
    while below < beyond {
        let middle = below.midpoint(beyond);
        if is_below(middle) { below = middle + 1 } else { beyond = middle }
    }
    below
}

/// The signal without its mean and without anything above `highest` [Hz]; same length, same rate.
///
/// An ideal filter in the frequency domain treats the signal as periodic. Different end values would cause an overshoot of a tenth of their
/// difference. The straight line through the ends, which lies within the band, is therefore subtracted first and added again.
pub(crate) fn band_limited(signal: &[f64], rate: f64, highest: f64) -> Vec<f64> {
    filtered(signal, rate, highest, |_| {})
}

/// Fourier transform of a signal less the straight line through its ends.
pub(crate) struct Bins<'a> {
    bins: &'a [Complex64],
    values: usize,
    rate: f64,
    /// Rise of the line from one value to the next.
    rise: f64,
}

impl Bins<'_> {
    /// Frequency between two bins [Hz].
    pub fn resolution(&self) -> f64 {
        self.rate / self.values as f64
    }

    /// Number of the bin after the last one that has two neighbours.
    pub fn interior(&self) -> usize {
        self.bins.len().saturating_sub(1)
    }

    /// Square of the amplitude of a bin of the signal with its line, under a Hann window, from bin 2 to the last that has two neighbours.
    pub fn hann_square(&self, bin: usize) -> f64 {
        let around = &self.bins[bin - 1..=bin + 1];
        let (n, k) = (self.values as f64, bin as f64);
        // The bins of the line are rise · n/2 · (i cot(πk/n) − 1). The cotangent is nearly n/(πk), whose second difference is closed.
        let line = -self.rise * n * n / (4.0 * std::f64::consts::PI * k * (k * k - 1.0));
        let windowed = 0.5 * around[1] - 0.25 * (around[0] + around[2]) + Complex64::new(0.0, line);
        (4.0 / n * windowed).norm_sqr()
    }
}

/// [`band_limited`]; `look` sees the whole transform.
pub(crate) fn filtered(signal: &[f64], rate: f64, highest: f64, look: impl FnOnce(&Bins<'_>)) -> Vec<f64> {
    let (n, [Some(first), Some(last)]) = (signal.len(), [signal.first(), signal.last()]) else { return Vec::new() };
    let rise = if n > 1 { (last - first) / (n - 1) as f64 } else { 0.0 };
    let middle = 0.5 * (n - 1) as f64;
    let line = |i: usize| rise * (i as f64 - middle);
    let mut bent: Vec<f64> = signal.iter().enumerate().map(|(i, value)| value - line(i)).collect();
    let mut bins = forward(&mut bent);
    look(&Bins { bins: &bins, values: n, rate, rise });
    bins[0] = Complex64::ZERO;
    let cut = bins_below(bins.len(), |k| k as f64 * rate / n as f64 <= highest);
    bins[cut..].fill(Complex64::ZERO);
    let mut left = inverse_unscaled(&mut bins, n);
    for (i, value) in left.iter_mut().enumerate() {
        *value = *value / n as f64 + line(i);
    }
    left
}

/// Frequency [Hz] and amplitude of the tone whose strongest bin is `bin`, from that bin and its two neighbours.
///
/// Exact for a single tone under a Hann window. With δ the tone's distance from the bin in bins, the entries are
/// A·w(δ + 1), A·w(δ), A·w(δ − 1), w(x) = sin πx / (πx (1 − x²)). Hence δ = 2 (a₊ − a₋)/(a₋ + 2a₀ + a₊). The first and last
/// entries have no two neighbours and are returned as they stand, a bin outside the spectrum as amplitude 0.
pub(crate) fn interpolated_peak(spectrum: &Spectrum, bin: usize) -> (f64, f64) {
    let frequency = |bin: f64| bin * spectrum.resolution;
    let amplitude = &spectrum.amplitude;
    if bin == 0 || bin + 1 >= amplitude.len() {
        return (frequency(bin as f64), amplitude.get(bin).copied().unwrap_or(0.0));
    }
    let (before, at, after) = (amplitude[bin - 1], amplitude[bin], amplitude[bin + 1]);
    let sum = before + 2.0 * at + after;
    if sum <= 0.0 {
        return (frequency(bin as f64), 0.0);
    }
    // A tone is at most half a bin from its strongest bin; noise may give a larger offset.
    let offset = (2.0 * (after - before) / sum).clamp(-0.5, 0.5);
    (frequency(bin as f64 + offset), at / hann_main_lobe(offset))
}

/// Distance between the places of a tone by either neighbour of its strongest bin [Hz]. It is 0 for a steady tone under a Hann window, and grows where
/// a line is broad, stands in noise or has others beside it.
///
/// From a₊/a₀ = (1 + δ)/(2 − δ) and a₋/a₀ = (1 − δ)/(2 + δ), as in [`interpolated_peak`].
pub(crate) fn spread_of_place(spectrum: &Spectrum, bin: usize) -> f64 {
    let offset = |neighbour: usize| {
        let ratio = spectrum.amplitude.get(neighbour)? / spectrum.amplitude.get(bin)?;
        Some((2.0 * ratio - 1.0) / (ratio + 1.0))
    };
    let places = bin.checked_sub(1).and_then(offset).zip(offset(bin + 1));
    places.map_or(f64::INFINITY, |(before, after)| spectrum.resolution * (after + before).abs())
}

/// Reading of a bin for a tone of amplitude 1 that lies `offset` bins away, |offset| < 1.
fn hann_main_lobe(offset: f64) -> f64 {
    sinc(offset) / (1.0 - offset * offset)
}

/// Plans of the last few lengths: all signals of a run share one or two, most runs share theirs, and a plan takes longer than
/// its transform.
static PLANS: LazyLock<Mutex<(Vec<usize>, RealFftPlanner<f64>)>> = LazyLock::new(Mutex::default);

/// Lengths of which plans are kept.
const LENGTHS: usize = 8;

/// A plan for signals of a length.
fn planned<P>(length: usize, plan: impl FnOnce(&mut RealFftPlanner<f64>, usize) -> P) -> P {
    // Plans stay valid after a panic in another thread.
    let mut plans = PLANS.lock().unwrap_or_else(PoisonError::into_inner);
    let (lengths, planner) = &mut *plans;
    if !lengths.contains(&length) {
        if lengths.len() == LENGTHS {
            (*lengths, *planner) = (Vec::new(), RealFftPlanner::new());
        }
        lengths.push(length);
    }
    plan(planner, length)
}

/// Fourier transform of a signal that is not empty, without window.
#[cfg(test)]
pub(crate) fn transform(signal: &[f64]) -> Vec<Complex64> {
    forward(&mut signal.to_vec())
}

/// Fourier transform of a signal that is not empty; overwrites it.
fn forward(signal: &mut [f64]) -> Vec<Complex64> {
    let transform = planned(signal.len(), RealFftPlanner::plan_fft_forward);
    let mut bins = transform.make_output_vec();
    transform.process(signal, &mut bins).expect("buffers have the plan's lengths");
    bins
}

/// The `n` values that `forward` takes to these bins; overwrites them.
fn inverse(bins: &mut [Complex64], n: usize) -> Vec<f64> {
    let mut signal = inverse_unscaled(bins, n);
    signal.iter_mut().for_each(|x| *x /= n as f64);
    signal
}

/// `n` times those values; overwrites the bins.
fn inverse_unscaled(bins: &mut [Complex64], n: usize) -> Vec<f64> {
    // The entries without a mirror image are real; rounding may say otherwise.
    bins[0].im = 0.0;
    if n.is_multiple_of(2) {
        bins[n / 2].im = 0.0;
    }
    let transform = planned(n, RealFftPlanner::plan_fft_inverse);
    let mut signal = transform.make_output_vec();
    transform.process(bins, &mut signal).expect("buffers have the plan's lengths");
    signal
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::numerics::statistics::rms;

    const RATE: f64 = 102_400.0;

    fn tone(n: usize, frequency: f64, amplitude: f64, phase: f64) -> Vec<f64> {
        (0..n).map(|i| amplitude * (TAU * frequency * i as f64 / RATE + phase).sin()).collect()
    }

    fn strongest(spectrum: &Spectrum) -> usize {
        (0..spectrum.amplitude.len()).max_by(|&a, &b| spectrum.amplitude[a].total_cmp(&spectrum.amplitude[b])).unwrap()
    }

    /// Of 3.5 periods the mean is no constant: neither the first entry nor the second show one.
    #[test]
    fn part_of_a_period_has_no_constant() {
        let signal = tone(1000, 3.5 * RATE / 1000.0, 1.0, 0.0);
        let [whole, part] = [amplitude_spectrum, amplitude_spectrum_of_part].map(|of| of(&signal, RATE).amplitude);
        assert!(whole[0] > 0.08 && part[0] < 1e-12 && part[1] < 0.04, "{} {} {}", whole[0], part[0], part[1]);
        assert_eq!(whole[2..], part[2..]);
    }

    #[test]
    fn unit_sine_on_a_bin_reads_one_for_any_length() {
        for n in [64, 1000, 1001, 997, 4096] {
            let signal: Vec<f64> = tone(n, 10.0 * RATE / n as f64, 1.0, 0.3).iter().map(|x| x + 5.0).collect();
            let spectrum = amplitude_spectrum(&signal, RATE);
            assert_eq!(spectrum.amplitude.len(), n / 2 + 1);
            assert!((spectrum.resolution - RATE / n as f64).abs() < 1e-9);
            assert_eq!(strongest(&spectrum), 10);
            assert!((spectrum.amplitude[10] - 1.0).abs() < 1e-10, "n = {n}: {}", spectrum.amplitude[10]);
            assert!(spectrum.amplitude[0] < 1e-10 && spectrum.amplitude[14] < 1e-10);
        }
    }

    #[test]
    fn joined_spectra_show_the_mean_power_of_all() {
        let of = |amplitude: f64| amplitude_spectrum(&tone(1000, 1024.0, amplitude, 0.2), RATE);
        let mut joined = of(3.0);
        joined.join(&of(1.0));
        joined.join(&of(2.0));
        assert_eq!((joined.averages, joined.resolution, joined.amplitude.len()), (3, 102.4, 501));
        assert!((joined.amplitude[10] - (14.0_f64 / 3.0).sqrt()).abs() < 1e-12, "{}", joined.amplitude[10]);
    }

    #[test]
    fn alternating_signal_reads_its_amplitude_in_the_last_bin() {
        let signal: Vec<f64> = (0..64).map(|i| if i % 2 == 0 { 2.0 } else { -2.0 }).collect();
        assert!((amplitude_spectrum(&signal, RATE).amplitude[32] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn signals_of_up_to_three_values_do_not_panic() {
        for n in 0..4 {
            let signal = vec![1.5; n];
            let entries = if n == 0 { 0 } else { n / 2 + 1 };
            assert_eq!(amplitude_spectrum(&signal, RATE).amplitude, vec![0.0; entries]);
            assert_eq!(envelope_spectrum(&signal, RATE, (0.0, 2e4)).amplitude.len(), entries);
            assert_eq!(band_limited(&signal, RATE, 2e4), vec![0.0; n]);
            let spectrum = amplitude_spectrum(&signal, RATE);
            for bin in 0..4 {
                assert_eq!(interpolated_peak(&spectrum, bin).1, 0.0);
            }
        }
    }

    #[test]
    fn tone_between_bins_is_interpolated_to_its_frequency_and_amplitude() {
        let n = 10_240;
        for fraction in [-0.5, -0.4, -0.25, -0.1, 0.0, 0.1, 0.25, 0.33, 0.4, 0.49, 0.5] {
            for phase in [0.0, 1.0, 2.5] {
                let frequency = (229.0 + fraction) * RATE / n as f64;
                let spectrum = amplitude_spectrum(&tone(n, frequency, 3.0, phase), RATE);
                let (found, amplitude) = interpolated_peak(&spectrum, strongest(&spectrum));
                assert!((found - frequency).abs() < 0.02 * spectrum.resolution, "{found} for {frequency}");
                assert!((amplitude / 3.0 - 1.0).abs() < 0.005, "{amplitude} at fraction {fraction}");
            }
        }
    }

    #[test]
    fn envelope_of_a_modulated_carrier_shows_the_modulation() {
        let n = 10_240;
        let (carrier, modulation, rest) =
            (tone(n, 8000.0, 2.0, 0.0), tone(n, 350.0, 0.25, 0.4), tone(n, 800.0, 5.0, 0.0));
        let signal: Vec<f64> = (0..n).map(|i| carrier[i] * (1.0 + modulation[i]) + rest[i]).collect();
        let spectrum = envelope_spectrum(&signal, RATE, (6000.0, 10_000.0));
        assert_eq!(strongest(&spectrum), 35);
        assert!((spectrum.amplitude[35] - 0.5).abs() < 1e-6);
        assert!(spectrum.amplitude[80] < 1e-6, "what lies outside the band is not seen");
    }

    /// Two tones 350 Hz apart, of amplitudes 2 and 0.5: the square of their envelope is 4.25 + 2 cos, with one line.
    #[test]
    fn the_squared_envelope_of_two_tones_has_one_line() {
        let n = 10_240;
        let (one, other) = (tone(n, 8000.0, 2.0, 0.0), tone(n, 8350.0, 0.5, 0.4));
        let signal: Vec<f64> = one.iter().zip(&other).map(|(one, other)| one + other).collect();
        let of = |kind| amplitude_and_envelope(&signal, RATE, EnvelopeAnalysis { band: (6000.0, 10_000.0), kind }).1;
        let (magnitude, squared) = (of(EnvelopeKind::Magnitude), of(EnvelopeKind::Squared));
        assert!((squared.amplitude[35] - 2.0).abs() < 1e-6 && squared.amplitude[70] < 1e-9);
        assert!(magnitude.amplitude[70] > 0.02, "the magnitude has harmonics");
    }

    /// Whether or not the ends meet; where they did not, the last value used to be off by half of the step between them.
    #[test]
    fn band_limit_keeps_the_band_and_removes_mean_and_rest() {
        const EDGE: usize = 64;
        for n in [10_240, 10_241] {
            for fraction in [0.0, 0.25, 0.5] {
                let kept = tone(n, (100.0 + fraction) * RATE / n as f64, 1.0, 0.7);
                let removed = tone(n, 2500.0 * RATE / n as f64, 4.0, 0.0);
                let mean = kept.iter().sum::<f64>() / n as f64;
                let off = |limited: &[f64]| -> Vec<f64> {
                    limited.iter().zip(&kept).map(|(found, value)| (found - (value - mean)).abs()).collect()
                };
                let largest = |off: &[f64]| off.iter().fold(0.0, |most, off| f64::max(most, *off));
                let alone: Vec<f64> = kept.iter().map(|value| 9.0 + value).collect();
                let alone = off(&band_limited(&alone, RATE, 20_000.0));
                assert!(largest(&alone) < 0.03, "{n} {fraction}: {}", largest(&alone));
                let signal: Vec<f64> = (0..n).map(|i| 9.0 + kept[i] + removed[i]).collect();
                let both = off(&band_limited(&signal, RATE, 20_000.0));
                let inside = largest(&both[EDGE..n - EDGE]);
                assert!(inside < 0.02, "{n} {fraction}: {inside} of 4 left");
                let everything = band_limited(&signal, RATE, RATE);
                assert!((rms(&everything) - rms(&signal)).abs() < 1e-9);
            }
        }
    }
}
