//! Damping that helps a start to settle.

/// Damping of the spindle, and of the cage along its axis and in tilt, where little else damps them: each loses so much of its velocity. At first it stays,
/// then it fades, slowly beside all vibration, so that the end shakes nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FadingDamping {
    /// At first [1/s]; free vibration decays at half of it.
    pub rate: f64,
    /// When it has gone [s].
    pub end: f64,
}

/// Share of the time through which it stays.
const STAYS: f64 = 0.5;

impl FadingDamping {
    /// At a time [1/s].
    pub fn at(&self, time: f64) -> f64 {
        let faded = ((time / self.end - STAYS) / (1.0 - STAYS)).clamp(0.0, 1.0);
        self.rate * (1.0 - faded) * (1.0 - faded) * (1.0 + 2.0 * faded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stays_then_fades_without_a_kink_and_is_gone() {
        let damping = FadingDamping { rate: 2000.0, end: 0.1 };
        assert_eq!([0.0, 0.05, 0.1, 7.0].map(|time| damping.at(time)), [2000.0, 2000.0, 0.0, 0.0]);
        assert!((damping.at(0.075) - 1000.0).abs() < 1e-9);
        let slope = |time: f64| (damping.at(time + 1e-6) - damping.at(time - 1e-6)) / 2e-6;
        assert!([0.05, 0.1].iter().all(|kink| slope(*kink).abs() < 10.0) && slope(0.075) < -5e4);
    }
}
