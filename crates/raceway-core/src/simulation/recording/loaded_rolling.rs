//! Kinematic orbit speed of the balls that carry load, averaged over balls and time.

use crate::physics::bearing::PerRaceway;

/// Smallest share of balls that carry load, on average, for which a kinematic cage speed is stated [-].
const LEAST_LOADED_SHARE: f64 = 0.1;

/// Mean orbit ratio of rolling at the loaded contact angles, weighted by the load on the outer raceway. A ball carries load where it touches
/// both raceways: the outer one alone holds it against the centrifugal force and does not drive it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct LoadedRolling {
    /// Sum of the loads [N], and of the loads times the ratios.
    weight: f64,
    weighted: f64,
    /// Numbers of observed balls with load and of all observed balls.
    loaded: f64,
    seen: f64,
}

impl LoadedRolling {
    /// Adds one ball at one time; `ratio`: its orbit speed of rolling over the spindle speed [-].
    #[inline(always)]
    pub(crate) fn add(&mut self, load: PerRaceway<f64>, ratio: impl FnOnce() -> Option<f64>) {
        self.seen += 1.0;
        if let Some(ratio) = (load.inner > 0.0 && load.outer > 0.0).then(ratio).flatten() {
            self.loaded += 1.0;
            self.weight += load.outer;
            self.weighted += load.outer * ratio;
        }
    }

    /// `seen` observations of balls, `loaded` of them with load, whose outer loads sum to `weight` [N], with one ratio.
    pub(crate) fn of(seen: f64, loaded: f64, weight: f64, ratio: f64) -> Self {
        Self { weight, weighted: weight * ratio, loaded, seen }
    }

    pub(crate) fn join(&mut self, other: Self) {
        self.weight += other.weight;
        self.weighted += other.weighted;
        self.loaded += other.loaded;
        self.seen += other.seen;
    }

    /// The mean [-]; `None` where on average too few balls carry load.
    pub(crate) fn mean(&self) -> Option<f64> {
        (self.weight > 0.0 && self.loaded >= LEAST_LOADED_SHARE * self.seen).then(|| self.weighted / self.weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_weight_the_ratio_and_few_loaded_balls_give_none() {
        let mut rolling = LoadedRolling::default();
        assert_eq!(rolling.mean(), None);
        rolling.add(PerRaceway { inner: 10.0, outer: 30.0 }, || Some(0.4));
        rolling.add(PerRaceway { inner: 10.0, outer: 10.0 }, || Some(0.5));
        rolling.add(PerRaceway { inner: 0.0, outer: 90.0 }, || unreachable!("the centrifugal force alone"));
        assert_eq!(rolling.mean(), Some(0.425));
        rolling.join(LoadedRolling::of(17.0, 0.0, 0.0, 0.0));
        assert_eq!(rolling.mean(), Some(0.425), "2 of 20 balls");
        rolling.join(LoadedRolling::of(1.0, 0.0, 0.0, 0.0));
        assert_eq!(rolling.mean(), None);
    }
}
