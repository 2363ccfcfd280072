//! A stored spectrum in other units, and its sums over bands.

use std::f64::consts::TAU;

use raceway_core::simulation::recording::bands::LOWEST_BIN;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::signals::{SpectrumAnswer, SpectrumKind, SpectrumScaling};
use crate::contract::json::numbers::{rounded, short};

/// Lowest frequency of a spectrum that is integrated over time [Hz]: below, drift divided by the frequency hides the vibration.
const LOWEST_INTEGRATED_HZ: f64 = 10.0;

/// Motion that a spectrum shows.
// The discriminant counts derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpectrumQuantity {
    Displacement,
    Velocity,
    Acceleration,
}

impl SpectrumQuantity {
    const ALL: [Self; 3] = [Self::Displacement, Self::Velocity, Self::Acceleration];

    pub(super) fn name(self) -> &'static str {
        ["displacement", "velocity", "acceleration"][self as usize]
    }

    /// Unit of its channels, and its size [SI].
    fn unit(self) -> (&'static str, f64) {
        [("µm", 1e-6), ("mm/s", 1e-3), ("m/s²", 1.0)][self as usize]
    }

    /// The motion of a channel; `None` of forces, speeds and angles.
    pub(super) fn of(channel: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| channel.ends_with(&format!(".{}", quantity.name())))
    }
}

/// Vibration in bands of a stored spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BandsAnswer {
    /// The channel, an acceleration.
    #[schema(example = "spindle.y.acceleration")]
    pub channel: String,
    /// Frequency resolution of the spectrum [Hz].
    #[schema(minimum = 0)]
    pub resolution_hz: f64,
    /// Noise bandwidth of the window [bins]: a mean square is the sum of amplitude²/2 over it.
    #[schema(example = 1.5)]
    pub window_noise_bandwidth_bins: f64,
    /// The bands, in ascending order.
    pub bands: Vec<SpectrumBandAnswer>,
}

/// Vibration in a band of a stored spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SpectrumBandAnswer {
    /// Lower end of the band [Hz]; it belongs to the band.
    #[schema(minimum = 0)]
    pub from_hz: f64,
    /// Upper end of the band [Hz]; it belongs to the next one.
    #[schema(minimum = 0)]
    pub to_hz: f64,
    /// Root mean square of the velocity [µm/s].
    #[schema(minimum = 0)]
    pub velocity_rms_um_s: f64,
    /// Root mean square of the acceleration [m/s²].
    #[schema(minimum = 0)]
    pub acceleration_rms_m_s2: f64,
    /// Share of the acceleration's mean square within two bins of the ends [-]: a line there lies partly in the next band.
    #[schema(minimum = 0, maximum = 1)]
    pub edge_share: f64,
}

impl SpectrumAnswer {
    /// The amplitude spectrum of another motion of the same point; bins that integration would spoil are left out. The error names what is wrong.
    pub fn of_quantity(mut self, wanted: SpectrumQuantity) -> Result<Self, String> {
        if self.kind == SpectrumKind::Envelope {
            return Err(
                "quantity: an envelope has no other quantity; leave it out or ask for kind=amplitude".to_owned()
            );
        }
        let Some(own) = SpectrumQuantity::of(&self.channel) else {
            return Err(format!("quantity: channel `{}` is no displacement, velocity or acceleration", self.channel));
        };
        let order = wanted as i32 - own as i32;
        if order < 0 {
            let lowest = LOWEST_INTEGRATED_HZ.max(LOWEST_BIN * self.resolution_hz);
            let first = self.frequency_hz.partition_point(|frequency| *frequency < lowest);
            (self.frequency_hz, self.amplitude) = (self.frequency_hz.split_off(first), self.amplitude.split_off(first));
        }
        let ((unit, size), (_, own_size)) = (wanted.unit(), own.unit());
        if order != 0 {
            for (amplitude, frequency) in self.amplitude.iter_mut().zip(&self.frequency_hz) {
                *amplitude = rounded(*amplitude * own_size / size * (TAU * frequency).powi(order), Self::DIGITS);
            }
        }
        self.unit = unit.to_owned();
        Ok(self)
    }

    /// The spectrum with its values as asked for.
    pub fn scaled(mut self, scaling: SpectrumScaling) -> Self {
        let mean_square = 0.5 / (self.window_noise_bandwidth_bins * self.resolution_hz);
        let value = |amplitude: f64| match scaling {
            SpectrumScaling::Amplitude => amplitude,
            SpectrumScaling::Rms => amplitude / std::f64::consts::SQRT_2,
            SpectrumScaling::Psd => mean_square * amplitude * amplitude,
        };
        if scaling != SpectrumScaling::Amplitude {
            self.amplitude.iter_mut().for_each(|amplitude| *amplitude = rounded(value(*amplitude), Self::DIGITS));
        }
        if scaling == SpectrumScaling::Psd {
            self.unit = format!("({})²/Hz", self.unit);
        }
        self.scaling = scaling;
        self
    }

    /// Vibration between rising edges [Hz]. The error names what is wrong.
    pub fn bands(&self, edges: &[f64]) -> Result<BandsAnswer, String> {
        if SpectrumQuantity::of(&self.channel) != Some(SpectrumQuantity::Acceleration) {
            return Err(format!("channel: `{}` is no acceleration", self.channel));
        }
        let lowest = LOWEST_BIN * self.resolution_hz;
        let highest = self.frequency_hz.last().copied().unwrap_or_default();
        let mut bands = Vec::with_capacity(edges.len().saturating_sub(1));
        for edge in edges {
            if !(lowest..=highest).contains(edge) {
                let [edge, lowest, highest] = [*edge, lowest, highest].map(short);
                return Err(format!(
                    "edges_hz: {edge} Hz: must be {lowest} to {highest} Hz, which the spectrum resolves"
                ));
            }
        }
        for ends in edges.windows(2) {
            let [from, to] = [ends[0], ends[1]];
            if from >= to {
                return Err(format!("edges_hz: {to} Hz is not above {from} Hz: edges rise"));
            }
            bands.push(self.band(from, to));
        }
        Ok(BandsAnswer {
            channel: self.channel.clone(),
            resolution_hz: self.resolution_hz,
            window_noise_bandwidth_bins: self.window_noise_bandwidth_bins,
            bands,
        })
    }

    /// Vibration from a frequency up to another one [Hz].
    pub(super) fn band(&self, from: f64, to: f64) -> SpectrumBandAnswer {
        let [mut acceleration, mut velocity, mut at_ends] = [0.0; 3];
        let bins = self.frequency_hz.iter().zip(&self.amplitude).filter(|(f, _)| (from..to).contains(*f));
        for (frequency, amplitude) in bins {
            let square = 0.5 * amplitude * amplitude / self.window_noise_bandwidth_bins;
            acceleration += square;
            velocity += square / (TAU * frequency).powi(2);
            if (frequency - from).min(to - frequency) <= 2.0 * self.resolution_hz {
                at_ends += square;
            }
        }
        let digits = |value: f64| rounded(value, Self::DIGITS);
        SpectrumBandAnswer {
            from_hz: from,
            to_hz: to,
            velocity_rms_um_s: digits(1e6 * velocity.sqrt()),
            acceleration_rms_m_s2: digits(acceleration.sqrt()),
            edge_share: if acceleration > 0.0 { digits(at_ends / acceleration) } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Hann spectrum of tones [Hz, m/s²] of 1 s; between bins by the spectral lines of the window.
    fn spectrum(tones: &[(f64, f64)]) -> SpectrumAnswer {
        let line = |x: f64| match x.abs() {
            x if x < 1e-9 => 1.0,
            x if (x - 1.0).abs() < 1e-9 => 0.5,
            x => (TAU / 2.0 * x).sin() / (TAU / 2.0 * x * (1.0 - x * x)),
        };
        let at = |bin: usize| tones.iter().map(|(f, a)| (a * line(bin as f64 - f)).powi(2)).sum::<f64>().sqrt();
        SpectrumAnswer {
            channel: "spindle.y.acceleration".to_owned(),
            kind: SpectrumKind::Amplitude,
            scaling: SpectrumScaling::Amplitude,
            unit: "m/s²".to_owned(),
            window: "hann".to_owned(),
            window_noise_bandwidth_bins: 1.5,
            averages: 1,
            resolution_hz: 1.0,
            mean_step_s: 0.0,
            damped_above_hz: 0.0,
            frequency_hz: Vec::new(),
            amplitude: (0..12_000).map(at).collect(),
        }
        .with_frequencies()
    }

    const EDGES: [f64; 4] = [50.0, 300.0, 1800.0, 10_000.0];

    #[test]
    fn tones_add_up_in_their_bands() {
        let found = spectrum(&[(100.0, 1.0), (800.0, 1.0), (5000.0, 1.0)]).bands(&EDGES).unwrap();
        for (band, velocity) in found.bands.iter().zip([1125.395, 140.674, 22.508]) {
            assert!((band.velocity_rms_um_s / velocity - 1.0).abs() < 1e-3, "{band:?}");
            assert!((band.acceleration_rms_m_s2 - 0.5_f64.sqrt()).abs() < 1e-4, "{band:?}");
            assert!(band.edge_share < 1e-9, "{band:?}");
        }
    }

    /// A tone half a bin off reads 1.424 dB low, and its band is unchanged.
    #[test]
    fn bands_do_not_depend_on_the_place_between_bins() {
        let on = spectrum(&[(5000.0, 10.0)]);
        let off = spectrum(&[(5000.5, 10.0)]);
        let highest = |of: &SpectrumAnswer| of.amplitude.iter().copied().fold(0.0, f64::max);
        assert!((20.0 * (highest(&off) / highest(&on)).log10() + 1.424).abs() < 1e-3);
        let band = |of: &SpectrumAnswer| of.bands(&EDGES).unwrap().bands[2].clone();
        assert!((band(&off).velocity_rms_um_s / 225.057 - 1.0).abs() < 1e-3);
        assert!((band(&on).acceleration_rms_m_s2 / band(&off).acceleration_rms_m_s2 - 1.0).abs() < 1e-3);
        let beside = spectrum(&[(299.0, 1.0)]).bands(&EDGES).unwrap();
        assert!(beside.bands[0].edge_share > 0.99, "{beside:?}");
    }

    #[test]
    fn scalings_keep_the_mean_square() {
        let of = spectrum(&[(159.155, 9.80665)]);
        let square: f64 = of.clone().scaled(SpectrumScaling::Psd).amplitude.iter().sum();
        assert!((square / (9.80665_f64.powi(2) / 2.0) - 1.0).abs() < 1e-3, "{square}");
        let rms = of.clone().scaled(SpectrumScaling::Rms);
        assert!((rms.amplitude[159] / of.amplitude[159] - 0.5_f64.sqrt()).abs() < 1e-4);
        assert_eq!(of.clone().scaled(SpectrumScaling::Psd).unit, "(m/s²)²/Hz");
        assert_eq!(of.clone().scaled(SpectrumScaling::Amplitude), of);
    }

    #[test]
    fn motions_follow_by_the_frequency() {
        let of = spectrum(&[(100.0, 1.0)]);
        let at_100 = |quantity| {
            let found = of.clone().of_quantity(quantity).unwrap();
            let bin = found.frequency_hz.iter().position(|frequency| *frequency == 100.0).unwrap();
            (found.amplitude[bin], found.unit, found.frequency_hz[0])
        };
        let (velocity, unit, first) = at_100(SpectrumQuantity::Velocity);
        assert!((velocity / (1e3 / (TAU * 100.0)) - 1.0).abs() < 1e-3 && unit == "mm/s" && first == 10.0);
        let (displacement, unit, _) = at_100(SpectrumQuantity::Displacement);
        assert!((displacement / (1e6 / (TAU * 100.0).powi(2)) - 1.0).abs() < 1e-3 && unit == "µm");
        assert_eq!(at_100(SpectrumQuantity::Acceleration), (1.0, "m/s²".to_owned(), 0.0));
    }

    #[test]
    fn wrong_questions_are_named() {
        let of = spectrum(&[(100.0, 1.0)]);
        let detail = |edges: &[f64]| of.bands(edges).unwrap_err();
        assert!(detail(&[1.0, 300.0]).contains("1 Hz: must be 2 to 11999 Hz"), "{}", detail(&[1.0, 300.0]));
        assert!(detail(&[300.0, 300.0]).contains("not above"));
        let envelope = SpectrumAnswer { kind: SpectrumKind::Envelope, ..of.clone() };
        assert!(envelope.of_quantity(SpectrumQuantity::Velocity).unwrap_err().contains("envelope"));
        let force = SpectrumAnswer { channel: "A.force.y".to_owned(), ..of };
        assert!(force.clone().of_quantity(SpectrumQuantity::Velocity).unwrap_err().contains("`A.force.y`"));
        assert!(force.bands(&[50.0, 300.0]).is_err());
    }
}
