//! Recorded signals, window by window. A full window adds its moments and spectra to those of the run, and its values are dropped.
//! So the memory of a run does not grow with its duration. Requested series go to their receiver with each window. A run of one
//! window keeps its values and computes moments and spectra on request.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use crate::numerics::lanes::{LANES, Lanes, larger};
use crate::numerics::spectrum::{EnvelopeAnalysis, filtered};
use crate::numerics::statistics::{self, CentralMoments};
use crate::simulation::input::channel::{Axis, Channel, Motion};
use crate::simulation::input::settings::Outputs;
use crate::simulation::recording::bands::Bands;
use crate::simulation::recording::sampling::ACCELERATIONS;
use crate::simulation::recording::sampling::BAND;
use crate::simulation::recording::sampling::BATCHES;
use crate::simulation::recording::sampling::RATE;
use crate::simulation::recording::sampling::REPEATED;
use crate::simulation::recording::sampling::kept_values;
use crate::simulation::recording::series::SeriesRecording;
use crate::simulation::recording::spectra::ChannelSpectra;

/// Values at either end of one window of several that the statistics in the band of levels omit. The band limit takes a window as
/// periodic and overshoots where the ends do not meet. Further in, the overshoot is below a hundredth of the step between the ends.
const EDGE: usize = 128;

/// Values of a series outside windows that are passed on together.
const PASSED_ON: usize = 4096;

/// Length unit of a window where there are several: transforms of other lengths can take three times the time and memory.
const GRAIN: usize = 64;

/// Division of the recorded values into the smallest number of windows of equal length. The remainder at the end, less than `GRAIN`
/// values a window, appears in series alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Windows {
    pub count: usize,
    /// Values of one window.
    pub length: usize,
}

impl Windows {
    /// Windows of `values` recorded values, each of at most `longest` [s].
    pub fn of(values: usize, longest: f64) -> Self {
        let count = values.div_ceil(kept_values(longest)).max(1);
        let grain = if count > 1 { GRAIN } else { 1 };
        Self { count, length: values / count / grain * grain }
    }

    /// Number of values that a window keeps from its start. All windows together keep about as many as one window holds, but the
    /// first keeps at least the time that is repeated for the error estimate.
    fn excerpt(&self, window: usize) -> usize {
        let share = self.length / self.count;
        if window == 0 { share.max(kept_values(REPEATED)).min(self.length) } else { share }
    }
}

/// Statistics of a signal in the band of levels, window by window.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct InBand {
    pub moments: CentralMoments,
    /// Largest magnitude before the band limit.
    pub largest: f64,
    /// Mean squares of `BATCHES` batches of each window.
    pub mean_squares: Vec<f64>,
    /// Bands of an acceleration; without meaning for other signals.
    pub bands: Bands,
}

impl InBand {
    /// Statistics of a run of one window, with bands between these edges [Hz].
    pub(crate) fn of(signal: &[f64], edges: &[f64]) -> Self {
        Self::within(signal, 0, edges)
    }

    /// Statistics of one window without `edge` values at either end.
    fn within(signal: &[f64], edge: usize, edges: &[f64]) -> Self {
        let mut bands = Bands::default();
        let in_band = filtered(signal, RATE, BAND, |bins| bands = Bands::of(bins, edges));
        let in_band = in_band.get(edge..in_band.len().saturating_sub(edge)).unwrap_or_default();
        // The band limit removes the mean, and windows differ in their means.
        Self {
            moments: CentralMoments::of(in_band).shifted(statistics::mean(signal)),
            largest: largest_magnitude(signal),
            mean_squares: statistics::mean_squares(in_band, BATCHES),
            bands,
        }
    }

    fn join(&mut self, other: Self) {
        self.moments = self.moments.joined(other.moments);
        self.largest = self.largest.max(other.largest);
        self.mean_squares.extend(other.mean_squares);
        self.bands.join(&other.bands);
    }
}

/// Recorded signal of one channel [SI].
#[derive(Debug, Clone)]
pub struct Signal {
    pub channel: Channel,
    /// Values of the current window.
    window: Vec<f64>,
    /// True if the windows are needed beside the series.
    has_windows: bool,
    /// Number of the requested series of this channel.
    series: Option<usize>,
    /// Values of the series that are in no window and have not been passed on.
    rest: Vec<f64>,
    /// First values of each window, for accelerations; all values in a run of one window.
    pub excerpts: Vec<Vec<f64>>,
    /// Moments at all recorded frequencies; of several windows only where `counts_all`.
    all: OnceLock<CentralMoments>,
    counts_all: bool,
    in_band: OnceLock<InBand>,
    spectra: OnceLock<ChannelSpectra>,
    /// True if levels or metrics need the statistics in the band.
    counts_in_band: bool,
    asked_for_spectra: bool,
    envelope: EnvelopeAnalysis,
    /// Edges of the bands of an acceleration [Hz].
    band_edges: Vec<f64>,
    /// Values of the first of several windows, where plots need them.
    first: Option<Vec<f64>>,
}

impl Signal {
    fn new(channel: Channel, outputs: &Outputs, values: usize) -> Self {
        let windows = Windows::of(values, outputs.longest_window);
        let has_harmonics = outputs.envelope_harmonics && ACCELERATIONS.contains(&channel);
        let asked_for_spectra = has_harmonics || outputs.spectra.contains(&channel);
        let has_windows = windows.count == 1 || asked_for_spectra || is_evaluated(channel);
        Self {
            channel,
            window: Vec::with_capacity(if has_windows { windows.length } else { 0 }),
            has_windows,
            series: outputs.series.iter().position(|series| *series == channel),
            rest: Vec::new(),
            excerpts: Vec::new(),
            all: OnceLock::new(),
            counts_all: true,
            in_band: OnceLock::new(),
            spectra: OnceLock::new(),
            counts_in_band: ACCELERATIONS.contains(&channel)
                || (outputs.vibration && matches!(channel, Channel::Spindle(..))),
            asked_for_spectra,
            envelope: outputs.envelope,
            band_edges: outputs.band_edges.clone(),
            first: (windows.count > 1 && outputs.keep_signals() && is_plotted(channel)).then(Vec::new),
        }
    }

    /// Every recorded value; `None` where the windows were dropped.
    pub fn values(&self) -> Option<&[f64]> {
        match self.excerpts.as_slice() {
            [only] => Some(only),
            _ => None,
        }
    }

    /// Values of the first window.
    pub(crate) fn first_window(&self) -> &[f64] {
        self.first.as_deref().or_else(|| self.values()).unwrap_or_default()
    }

    /// Moments of all windows, at all recorded frequencies.
    pub fn all(&self) -> &CentralMoments {
        self.all.get_or_init(|| self.values().map(CentralMoments::of).unwrap_or_default())
    }

    /// Statistics in the band of levels, for the spindle's motion.
    pub(crate) fn in_band(&self) -> &InBand {
        self.in_band
            .get_or_init(|| self.values().map(|values| InBand::of(values, &self.band_edges)).unwrap_or_default())
    }

    /// Spectra in the channel's unit; `None` where they are not requested.
    pub fn spectra(&self) -> Option<&ChannelSpectra> {
        let values = self.values().unwrap_or_default();
        self.asked_for_spectra
            .then(|| self.spectra.get_or_init(|| ChannelSpectra::of(self.channel, values, self.envelope)))
    }

    /// Adds the current window to the statistics of the run, and empties it.
    fn reduce(&mut self, windows: Windows, index: usize) {
        if windows.count == 1 {
            self.excerpts.push(std::mem::take(&mut self.window));
            return;
        }
        if !self.has_windows {
            return;
        }
        if self.counts_all {
            join(&mut self.all, CentralMoments::of(&self.window), |all, window| *all = all.joined(window));
        }
        if self.counts_in_band {
            join(&mut self.in_band, InBand::within(&self.window, EDGE, &self.band_edges), InBand::join);
        }
        if self.asked_for_spectra {
            let spectra = ChannelSpectra::of(self.channel, &self.window, self.envelope);
            join(&mut self.spectra, spectra, |all, window| all.join(&window));
        }
        if ACCELERATIONS.contains(&self.channel) {
            self.excerpts.push(self.window.iter().copied().take(windows.excerpt(index)).collect());
        }
        if let Some(first) = self.first.as_mut().filter(|_| index == 0) {
            first.clone_from(&self.window);
        }
        self.window.clear();
    }
}

/// Returns whether metrics or plots are made of the channel. Of the others only spectra and series are asked for.
fn is_evaluated(channel: Channel) -> bool {
    matches!(channel, Channel::Spindle(..)) || is_plotted(channel)
}

/// Returns whether a plot shows the channel over time, or as a part of an orbit.
fn is_plotted(channel: Channel) -> bool {
    matches!(channel, Channel::Spindle(Axis::Y | Axis::Z, _) | Channel::CageDisplacement(Axis::Y | Axis::Z))
}

/// Largest magnitude of a signal, eight values side by side.
fn largest_magnitude(signal: &[f64]) -> f64 {
    let mut largest = Lanes::<LANES>::default();
    let (eights, rest) = signal.as_chunks::<LANES>();
    for values in eights {
        for lane in 0..LANES {
            largest[lane] = larger(values[lane].abs(), largest[lane]);
        }
    }
    rest.iter().map(|value| value.abs()).chain(largest.0).fold(0.0, f64::max)
}

/// Adds the statistics of a window to those of the windows before.
fn join<T>(before: &mut OnceLock<T>, window: T, add: impl FnOnce(&mut T, T)) {
    match before.get_mut() {
        Some(all) => add(all, window),
        None => *before = OnceLock::from(window),
    }
}

/// Rotation of a point (y, z) about its mean, from +Y towards +Z.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Whirl {
    /// Angle turned [rad].
    angle: f64,
    /// Number of intervals between values.
    steps: usize,
}

impl Whirl {
    pub fn of(y: &[f64], z: &[f64]) -> Self {
        let (mean_y, mean_z) = (statistics::mean(y), statistics::mean(z));
        // The mean itself has no azimuth.
        let mut centred = y.iter().zip(z).map(|(y, z)| (y - mean_y, z - mean_z)).filter(|point| *point != (0.0, 0.0));
        let steps = y.len().saturating_sub(1);
        let Some(first) = centred.next() else { return Self { angle: 0.0, steps } };
        let (mut last, mut turns) = (first, 0_i64);
        // An azimuth jumps by 2π where the point passes +Y or −Y on the side of −Y: a turn for each such passage, no arc tangent.
        for point in centred {
            let ((y0, z0), (y1, z1)) = (last, point);
            let across = y0 * z1 - z0 * y1;
            turns += i64::from(z0 >= 0.0 && z1 < 0.0 && across > 0.0);
            turns -= i64::from(z0 < 0.0 && z1 >= 0.0 && across < 0.0);
            last = point;
        }
        let azimuth = |(y, z): (f64, f64)| z.atan2(y);
        Self { angle: azimuth(last) - azimuth(first) + TAU * turns as f64, steps }
    }

    fn joined(self, other: Self) -> Self {
        Self { angle: self.angle + other.angle, steps: self.steps + other.steps }
    }

    /// Mean rate [rad/s].
    pub fn rate(&self) -> f64 {
        if self.steps > 0 { self.angle * RATE / self.steps as f64 } else { 0.0 }
    }
}

/// Recorder of several channels that are sampled at the same times.
#[derive(Debug, Clone)]
pub(crate) struct Recorder {
    windows: Windows,
    /// Number of values to record.
    values: usize,
    /// Number of values recorded so far.
    taken: usize,
    /// Number of finished windows.
    done: usize,
    signals: Vec<Signal>,
    /// Whirl of the body whose displacement is recorded, over several windows.
    whirl: Option<Whirl>,
    /// Receiver of the requested series.
    series: Option<SeriesRecording>,
}

impl Recorder {
    pub(crate) fn new(channels: impl IntoIterator<Item = Channel>, outputs: &Outputs, values: usize) -> Self {
        Self {
            windows: Windows::of(values, outputs.longest_window),
            values,
            taken: 0,
            done: 0,
            signals: channels.into_iter().map(|channel| Signal::new(channel, outputs, values)).collect(),
            whirl: None,
            series: None,
        }
    }

    /// The recorder with a receiver of the requested series.
    pub(crate) fn with_series(self, series: Option<SeriesRecording>) -> Self {
        Self { series, ..self }
    }

    /// The series that it has passed on.
    pub(crate) fn series(&self) -> Option<SeriesRecording> {
        self.series.clone()
    }

    /// A recorder of signals behind a low-pass filter, whose total variance the observer knows: it computes no moments at all recorded
    /// frequencies over several windows.
    pub(crate) fn behind_filter(channels: impl IntoIterator<Item = Channel>, outputs: &Outputs, values: usize) -> Self {
        let mut recorder = Self::new(channels, outputs, values);
        recorder.signals.iter_mut().for_each(|signal| signal.counts_all = false);
        recorder
    }

    /// rms of the spindle's accelerations in y and z over the current window [m/s²]; `None` while it is empty.
    pub(crate) fn accelerations(&self) -> Option<[f64; 2]> {
        let of = |channel: Channel| {
            let window = &self.signals.iter().find(|signal| signal.channel == channel)?.window;
            (!window.is_empty()).then(|| CentralMoments::of(window).rms())
        };
        let along = |axis| of(Channel::Spindle(axis, Motion::Acceleration));
        Some([along(Axis::Y)?, along(Axis::Z)?])
    }

    /// Records one value of each channel; values after the last are ignored.
    pub(crate) fn push(&mut self, frame: &[f64]) {
        self.take(1, |_, channel| frame[channel]);
    }

    /// Records several values of each channel, frame after frame.
    pub(crate) fn extend<const N: usize>(&mut self, frames: &[[f64; N]]) {
        self.take(frames.len(), |place, channel| frames[place][channel]);
    }

    /// Records `count` values, channel after channel up to the end of a window.
    #[inline(always)]
    fn take(&mut self, count: usize, value: impl Fn(usize, usize) -> f64) {
        let count = count.min(self.values - self.taken);
        let has_receiver = self.series.is_some();
        let mut from = 0;
        while from < count {
            let window_end = (self.done + 1) * self.windows.length;
            if self.taken == window_end {
                self.reduce();
                continue;
            }
            // The remainder after the last window appears in series alone.
            let counts = self.done < self.windows.count;
            let to = if counts { count.min(from + window_end - self.taken) } else { count };
            for (channel, signal) in self.signals.iter_mut().enumerate() {
                let values = (from..to).map(|place| value(place, channel));
                if counts && signal.has_windows {
                    signal.window.extend(values);
                } else if has_receiver && signal.series.is_some() {
                    signal.rest.extend(values);
                }
            }
            self.taken += to - from;
            from = to;
        }
        if has_receiver {
            self.pass_on_rests(PASSED_ON);
        }
    }

    /// Passes on the values outside windows of each series that has at least `least` of them.
    fn pass_on_rests(&mut self, least: usize) {
        let Some(receiver) = &self.series else { return };
        for signal in self.signals.iter_mut().filter(|signal| signal.rest.len() >= least) {
            if let Some(series) = signal.series {
                receiver.write(series, signal.channel, &signal.rest);
                signal.rest.clear();
            }
        }
    }

    fn reduce(&mut self) {
        if self.windows.count > 1 {
            let window = |channel: Channel| self.signals.iter().find(|s| s.channel == channel).map(|s| &s.window);
            let orbit = |place: fn(Axis) -> Channel| window(place(Axis::Y)).zip(window(place(Axis::Z)));
            let spindle = |axis| Channel::Spindle(axis, Motion::Displacement);
            // A recorder holds the channels of cage and balls, or those of the spindle.
            if let Some((y, z)) = orbit(Channel::CageDisplacement).or_else(|| orbit(spindle)) {
                self.whirl = Some(self.whirl.unwrap_or_default().joined(Whirl::of(y, z)));
            }
        }
        for signal in &mut self.signals {
            if let (Some(receiver), Some(series)) = (&self.series, signal.series) {
                receiver.write(series, signal.channel, &signal.window);
            }
            signal.reduce(self.windows, self.done);
        }
        self.done += 1;
    }

    /// The signals, and the whirl of cage or spindle over several windows.
    pub(crate) fn finish(mut self) -> (Vec<Signal>, Option<Whirl>) {
        if self.done < self.windows.count {
            self.reduce();
        }
        self.pass_on_rests(1);
        (self.signals, self.whirl)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::simulation::input::control::Control;
    use crate::simulation::input::series_sink::SeriesSink;
    use crate::simulation::recording::series::SeriesInMemory;

    #[test]
    fn the_recorded_time_is_cut_into_few_equal_windows() {
        let of = |duration: f64| Windows::of(kept_values(duration), 1.0);
        assert_eq!(of(1.0), Windows { count: 1, length: 102_400 });
        assert_eq!(of(1.5), Windows { count: 2, length: 76_800 });
        assert_eq!(of(2.5), Windows { count: 3, length: 85_312 });
        assert_eq!(of(20.0), Windows { count: 20, length: 102_400 });
        assert_eq!(of(1e-6), Windows { count: 1, length: 1 });
        assert_eq!(Windows::of(kept_values(20.0), 4.0), Windows { count: 5, length: 409_600 });
        assert_eq!((of(0.5).excerpt(0), of(20.0).excerpt(3), of(1000.0).excerpt(0)), (51_200, 5_120, 1_024));
    }

    /// Tones, drift and a burst of 2.5 s: three windows give the statistics of the whole signal.
    #[test]
    fn statistics_of_windows_equal_those_of_the_whole_signal() {
        let values = kept_values(2.5);
        let signal = |i: usize| {
            let t = i as f64 / RATE;
            let tone = |f: f64, a: f64| a * (std::f64::consts::TAU * f * t).sin();
            tone(229.0, 2.0) + tone(7013.3, 0.5) * (1.0 + tone(90.0, 0.4)) + 0.1 * t + tone(11.0, 3e-3).abs()
        };
        let whole: Vec<f64> = (0..values).map(signal).collect();
        let channel = Channel::Spindle(Axis::Y, Motion::Acceleration);
        let outputs = Outputs { spectra: vec![channel], ..Outputs::vibration() };
        let mut recorder = Recorder::new([channel], &outputs, values + 1);
        whole.iter().chain([&9.0, &9.0]).for_each(|value| recorder.push(&[*value]));
        let (signals, whirl) = recorder.finish();
        let seen = &signals[0];
        assert_eq!((seen.values(), seen.excerpts.len(), seen.in_band().mean_squares.len()), (None, 3, 30));
        assert_eq!(seen.excerpts[2][..10], whole[2 * 85_312..2 * 85_312 + 10]);
        assert_eq!(whirl, None);
        let alone = InBand::of(&whole, &[]).moments;
        let decibels = 20.0 * (seen.in_band().moments.rms() / alone.rms()).log10();
        assert!(decibels.abs() < 1e-3, "{decibels} dB");
        let kurtosis = |moments: &CentralMoments| moments.kurtosis().unwrap();
        assert!((kurtosis(&seen.in_band().moments) / kurtosis(&alone) - 1.0).abs() < 1e-3);
        assert!((seen.all().rms() / statistics::rms(&whole[..3 * 85_312]) - 1.0).abs() < 1e-12);
        let (spectra, at_once) = (seen.spectra().unwrap(), ChannelSpectra::of(channel, &whole, outputs.envelope));
        assert_eq!((spectra.amplitude.averages, at_once.amplitude.averages), (3, 1));
        let line = |spectrum: &crate::numerics::spectrum::Spectrum, frequency: f64| {
            let bin = (frequency / spectrum.resolution).round() as usize;
            crate::numerics::spectrum::interpolated_peak(spectrum, bin)
        };
        for (frequency, amplitude) in [(229.0, 2.0), (7013.3, 0.5)] {
            let (found, height) = line(&spectra.amplitude, frequency);
            let (_, before) = line(&at_once.amplitude, frequency);
            assert!((found - frequency).abs() < 0.02 && (height / amplitude - 1.0).abs() < 2e-3, "{found}: {height}");
            assert!((height / before - 1.0).abs() < 2e-3, "{height} for {before}");
        }
        let (of_all, of_whole) = (line(&spectra.envelope, 90.0).1, line(&at_once.envelope, 90.0).1);
        assert!((of_all / of_whole - 1.0).abs() < 2e-3, "{of_all} for {of_whole}");
    }

    #[test]
    fn a_requested_series_is_passed_on_to_the_last_value() {
        let values = 2 * kept_values(1.0) + 1;
        let channel = Channel::CageSpeed;
        let outputs = Outputs { vibration: false, series: vec![channel], ..Outputs::vibration() };
        let memory = Arc::new(SeriesInMemory::default());
        let sink: Arc<dyn SeriesSink> = memory.clone();
        let control = Control { series: Some(&sink), ..Control::until(&|| false) };
        let rejected = SeriesRecording::begin(&outputs, &control).unwrap();
        rejected.write(0, channel, &[f64::NAN]);
        assert!(!rejected.is_finite(0));
        drop(rejected);
        let recorder = Recorder::new([channel, Channel::BallSpin(0)], &outputs, values);
        let mut recorder = recorder.with_series(SeriesRecording::begin(&outputs, &control));
        (0..values).for_each(|i| recorder.push(&[i as f64, 0.0]));
        let series = recorder.series().unwrap();
        let (signals, _) = recorder.finish();
        assert_eq!((series.length(0), series.is_finite(0)), (values, true));
        series.keep();
        drop(series);
        let kept = &memory.take()[&0];
        assert_eq!((kept.len(), kept[values - 1]), (values, channel.scale() * (values - 1) as f64));
        assert!(memory.take().is_empty(), "the rejected recording is gone");
        assert!(signals.iter().all(|signal| signal.values().is_none() && signal.excerpts.is_empty()));
    }

    #[test]
    fn a_centre_on_a_circle_whirls_at_its_rate() {
        let angles = (0..2048).map(|k| 300.0 * f64::from(k) / RATE);
        let (y, z): (Vec<f64>, Vec<f64>) = angles.map(|a| (3.0 + a.cos(), a.sin() - 1.0)).unzip();
        let whirl = Whirl::of(&y, &z);
        assert!((whirl.rate() / 300.0 - 1.0).abs() < 0.05);
        assert!((whirl.joined(whirl).rate() / whirl.rate() - 1.0).abs() < 1e-12);
        assert_eq!(Whirl::of(&y[..1], &z[..1]).rate(), 0.0);
    }

    /// The sum of the angles between successive points, each within half a turn, on an irregular path either way.
    #[test]
    fn whirl_is_the_sum_of_the_angles_between_points() {
        for direction in [1.0, -1.0] {
            let angle = |k: i32| direction * (0.02 * f64::from(k) + 2.0 * (0.13 * f64::from(k)).sin());
            let radius = |k: i32| 1.0 + 0.9 * (0.37 * f64::from(k)).cos();
            let (y, z): (Vec<f64>, Vec<f64>) =
                (0..3000).map(|k| (radius(k) * angle(k).cos(), radius(k) * angle(k).sin())).unzip();
            let (mean_y, mean_z) = (statistics::mean(&y), statistics::mean(&z));
            let points: Vec<(f64, f64)> = y.iter().zip(&z).map(|(y, z)| (y - mean_y, z - mean_z)).collect();
            let between = |pair: &[(f64, f64)]| {
                let ((y0, z0), (y1, z1)) = (pair[0], pair[1]);
                (y0 * z1 - z0 * y1).atan2(y0 * y1 + z0 * z1)
            };
            let sum: f64 = points.windows(2).map(between).sum();
            assert!((Whirl::of(&y, &z).angle - sum).abs() < 1e-9, "{sum}");
        }
    }
}
