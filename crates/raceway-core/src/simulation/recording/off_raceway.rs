//! Time that balls in the load zone do not touch a raceway.

use crate::physics::bearing::PerRaceway;

/// Share of the time in the load zone in which balls do not touch a raceway [-].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffShare {
    /// Of all balls together.
    pub mean: f64,
    /// Of the ball with the largest share.
    pub largest: f64,
}

/// Times of each ball in the load zone, and off each raceway there, in one unit.
#[derive(Debug, Clone)]
pub(crate) struct OffTime {
    loaded: Vec<f64>,
    off: PerRaceway<Vec<f64>>,
}

impl OffTime {
    pub(crate) fn new(balls: usize) -> Self {
        let none = vec![0.0; balls];
        Self { loaded: none.clone(), off: PerRaceway { inner: none.clone(), outer: none } }
    }

    /// Adds an interval that a ball spends in the load zone under these loads [N].
    pub(crate) fn add(&mut self, ball: usize, interval: f64, load: PerRaceway<f64>) {
        self.loaded[ball] += interval;
        self.off.inner[ball] += if load.inner > 0.0 { 0.0 } else { interval };
        self.off.outer[ball] += if load.outer > 0.0 { 0.0 } else { interval };
    }

    /// Shares of both raceways; `None` where no ball came into the load zone.
    pub(crate) fn shares(&self) -> Option<PerRaceway<OffShare>> {
        let loaded: f64 = self.loaded.iter().sum();
        let of = |off: &Vec<f64>| OffShare {
            mean: off.iter().sum::<f64>() / loaded,
            largest: off
                .iter()
                .zip(&self.loaded)
                .filter(|(_, all)| **all > 0.0)
                .fold(0.0, |most, (off, all)| f64::max(most, off / all)),
        };
        (loaded > 0.0).then(|| PerRaceway { inner: of(&self.off.inner), outer: of(&self.off.outer) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ball 1 flies a quarter of its time, ball 2 never, ball 3 is never in the zone.
    #[test]
    fn shares_count_the_time_in_the_load_zone() {
        let mut time = OffTime::new(3);
        assert_eq!(time.shares(), None);
        let pressed = PerRaceway { inner: 3.0, outer: 4.0 };
        time.add(0, 3.0, pressed);
        time.add(0, 1.0, PerRaceway { inner: 0.0, outer: 1.0 });
        time.add(1, 4.0, pressed);
        let shares = time.shares().unwrap();
        assert_eq!((shares.inner, shares.outer.largest), (OffShare { mean: 0.125, largest: 0.25 }, 0.0));
    }
}
