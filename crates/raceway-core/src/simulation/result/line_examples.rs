//! Frequencies and spectra that the tests of lines share.

use super::line_sources::LineSources;
use crate::numerics::spectrum::{Spectrum, amplitude_spectrum};
use crate::physics::kinematics::CharacteristicFrequencies;

pub const RATE: f64 = 102_400.0;

/// The bearing of the article with seven balls at 50 000 r/min.
pub fn seven_balls() -> CharacteristicFrequencies {
    let (shaft, cage) = (833.333, 327.634);
    CharacteristicFrequencies {
        shaft,
        cage,
        outer_ring: 0.0,
        ball_pass: 7.0 * cage,
        ball_pass_outer: 7.0 * cage,
        ball_pass_inner: 7.0 * (shaft - cage),
        ball_spin: 1860.8,
    }
}

pub fn without_whirl(frequencies: CharacteristicFrequencies) -> LineSources<'static> {
    LineSources { frequencies, ..LineSources::of_shaft(0.0, &[]) }
}

/// Tones (frequency, amplitude) over 0.1 s in Gaussian-like noise of the given rms.
pub fn spectrum_of(tones: &[(f64, f64)], noise: f64) -> Spectrum {
    let mut seed = 0x2545_f491_4f6c_dd1d_u64;
    let mut uniform = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let signal: Vec<f64> = (0..10_240)
        .map(|i| {
            let time = i as f64 / RATE;
            let tones: f64 = tones.iter().map(|(f, a)| a * (std::f64::consts::TAU * f * time + f).sin()).sum();
            tones + noise * (0..12).map(|_| uniform()).sum::<f64>()
        })
        .collect();
    amplitude_spectrum(&signal, RATE)
}
