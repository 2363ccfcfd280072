//! Powers of the contacts and drags of a bearing, averaged over the recorded time.

use crate::physics::bearing::PerRaceway;

/// Power that one raceway takes [W].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RacewayPowers {
    /// Traction: slip, spin and conformity.
    pub sliding: f64,
    /// Resistance of the inlet to rolling.
    pub rolling: f64,
    /// Normal loads: damping, and at one time the elastic energy that the contacts store.
    pub normal: f64,
}

/// Powers at one time, or their means [W].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Powers {
    pub raceway: PerRaceway<RacewayPowers>,
    /// Contacts of the balls with the cage.
    pub pockets: f64,
    /// Contacts between balls.
    pub neighbours: f64,
    /// Guiding land of the cage.
    pub land: f64,
    /// Drag on the orbit of the balls, and churning of their spin.
    pub drag: f64,
    pub churning: f64,
    /// Supplied by the drives of both rings.
    pub drive: f64,
    /// Supplied by loads, unbalance and weights.
    pub applied: f64,
}

/// Mean powers of a record.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PowerBalance {
    pub mean: Powers,
    /// Mean rate of the kinetic energy [W].
    pub stored: f64,
}

impl RacewayPowers {
    fn entries(&self) -> [f64; 3] {
        [self.sliding, self.rolling, self.normal]
    }

    fn sum(&self) -> f64 {
        self.entries().iter().sum()
    }
}

impl Powers {
    /// Number of powers.
    const COUNT: usize = 13;

    fn entries(&self) -> [f64; Self::COUNT] {
        let ([a, b, c], [d, e, f]) = (self.raceway.inner.entries(), self.raceway.outer.entries());
        let Self { pockets, neighbours, land, drag, churning, drive, applied, .. } = *self;
        [a, b, c, d, e, f, pockets, neighbours, land, drag, churning, drive, applied]
    }

    fn of_entries(
        [a, b, c, d, e, f, pockets, neighbours, land, drag, churning, drive, applied]: [f64; Self::COUNT],
    ) -> Self {
        let one = |sliding, rolling, normal| RacewayPowers { sliding, rolling, normal };
        let raceway = PerRaceway { inner: one(a, b, c), outer: one(d, e, f) };
        Self { raceway, pockets, neighbours, land, drag, churning, drive, applied }
    }

    /// Power that all places take [W].
    pub fn losses(&self) -> f64 {
        let raceways = self.raceway.inner.sum() + self.raceway.outer.sum();
        raceways + self.pockets + self.neighbours + self.land + self.drag + self.churning
    }
}

impl PowerBalance {
    /// Supply of drives, loads and weights less storage and losses [W]: 0 but for the integration over time.
    pub fn gap(&self) -> f64 {
        self.mean.drive + self.mean.applied - self.stored - self.mean.losses()
    }
}

/// Sums of powers over time, by the trapezoid between observed times.
#[derive(Debug, Clone, Default)]
pub(crate) struct PowerRecorder {
    sums: [f64; Powers::COUNT],
    /// First and last observed time [s] with the kinetic energy [J].
    first: Option<(f64, f64)>,
    last: Option<(f64, f64, [f64; Powers::COUNT])>,
}

impl PowerRecorder {
    /// Adds the powers at a time [s], later than the last one, with the kinetic energy [J].
    pub(crate) fn add(&mut self, time: f64, powers: &Powers, energy: f64) {
        let now = powers.entries();
        if let Some((before, _, then)) = &self.last {
            let half = 0.5 * (time - before);
            self.sums.iter_mut().zip(now.iter().zip(then)).for_each(|(sum, (now, then))| *sum += half * (now + then));
        }
        self.first.get_or_insert((time, energy));
        self.last = Some((time, energy, now));
    }

    /// The means; `None` where less than two times were observed.
    pub(crate) fn finish(&self) -> Option<PowerBalance> {
        let ((begin, first), (end, last, _)) = (self.first?, self.last?);
        let over = end - begin;
        (over > 0.0).then(|| PowerBalance {
            mean: Powers::of_entries(self.sums.map(|sum| sum / over)),
            stored: (last - first) / over,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_weighted_by_time() {
        let at = |drive: f64| Powers { drive, pockets: 2.0, ..Powers::default() };
        let mut recorder = PowerRecorder::default();
        recorder.add(1.0, &at(1.0), 5.0);
        assert_eq!(recorder.finish(), None);
        recorder.add(2.0, &at(3.0), 6.0);
        recorder.add(4.0, &at(3.0), 11.0);
        let balance = recorder.finish().unwrap();
        assert!(
            (balance.mean.drive - 8.0 / 3.0).abs() < 1e-15 && balance.stored == 2.0 && balance.mean.losses() == 2.0
        );
        assert!((balance.gap() - (8.0 / 3.0 - 4.0)).abs() < 1e-14);
    }

    #[test]
    fn entries_are_read_back() {
        let entries: [f64; Powers::COUNT] = std::array::from_fn(|k| k as f64);
        let powers = Powers::of_entries(entries);
        assert_eq!(powers.entries(), entries);
        assert_eq!(powers.losses() + powers.drive + powers.applied, entries.iter().sum());
    }
}
