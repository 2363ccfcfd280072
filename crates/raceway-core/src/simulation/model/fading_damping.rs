//! Additional damping of the start-up phase.

/// Damping of the spindle, and of the cage along its axis and in tilt, where little else damps them. The rate stays constant at first, then
/// fades slowly compared with all vibration, so that its end excites nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FadingDamping {
    /// Initial rate [1/s]; free vibration decays at half of it.
    pub rate: f64,
    /// Time at which the damping has become 0 [s].
    pub end: f64,
}

/// Share of the time with the initial rate [-].
const CONSTANT_SHARE: f64 = 0.5;

impl FadingDamping {
    /// Rate at a time [1/s].
    pub(crate) fn at(&self, time: f64) -> f64 {
        let faded = ((time / self.end - CONSTANT_SHARE) / (1.0 - CONSTANT_SHARE)).clamp(0.0, 1.0);
        self.rate * (1.0 - faded) * (1.0 - faded) * (1.0 + 2.0 * faded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_is_constant_then_fades_to_zero_without_a_kink() {
        let damping = FadingDamping { rate: 2000.0, end: 0.1 };
        assert_eq!([0.0, 0.05, 0.1, 7.0].map(|time| damping.at(time)), [2000.0, 2000.0, 0.0, 0.0]);
        assert!((damping.at(0.075) - 1000.0).abs() < 1e-9);
        let slope = |time: f64| (damping.at(time + 1e-6) - damping.at(time - 1e-6)) / 2e-6;
        assert!([0.05, 0.1].iter().all(|kink| slope(*kink).abs() < 10.0) && slope(0.075) < -5e4);
    }
}
