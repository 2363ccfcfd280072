//! Detection of fixed steps beyond the limit of stability. Such a run may stay bounded, because fast modes saturate,
//! and still be wrong.

/// Longest step of Dormand–Prince times the rate of a mode that decays.
pub(crate) const DORMAND_PRINCE: f64 = 3.3;
/// Longest step of the predictor and corrector of `fine_abm` times the rate of the part that is not integrated exactly.
pub(crate) const FINE_ABM: f64 = 1.28;

/// Steps between two samples of the rate.
pub const STEPS_PER_LOOK: u64 = 128;
/// Share of samples beyond the limit from which a run counts as unstable; single impacts exceed the limit, too.
const SHARE: f64 = 0.03;
/// Share of the exceeding samples below the reported rate.
const NAMED_SHARE: f64 = 0.5;

/// The fastest rate that a step has seen, and its limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stability {
    /// |λ| [1/time]
    pub rate: f64,
    /// Largest step times rate at which the method is stable.
    pub limit: f64,
}

/// A fixed step beyond the limit of stability.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the fixed step lies beyond the limit of stability: h = {step:.3e} s, fastest rate |λ| = {rate:.1e} 1/s, h·|λ| = {:.1} where at most {limit} \
     is stable, in {:.0} % of the steps looked at; the largest stable step is {:.1e} s",
    step * seen.rate,
    100.0 * share,
    self.largest_stable(),
    rate = seen.rate,
    limit = seen.limit
)]
pub struct UnstableStep {
    pub step: f64,
    /// Typical rate among the samples beyond the limit, and its limit.
    pub seen: Stability,
    /// Share of the samples beyond the limit [-].
    pub share: f64,
}

impl UnstableStep {
    /// Largest stable step.
    pub fn largest_stable(&self) -> f64 {
        self.seen.limit / self.seen.rate
    }
}

/// Watches a run of fixed steps.
#[derive(Debug, Clone)]
pub struct StabilityWatch {
    step: f64,
    looks: u64,
    /// Samples beyond the limit.
    beyond: Vec<Stability>,
}

impl StabilityWatch {
    /// `step`: the fixed step.
    pub fn new(step: f64) -> Self {
        Self { step, looks: 0, beyond: Vec::new() }
    }

    /// Records the sample of a step.
    pub fn look(&mut self, seen: Stability) {
        self.looks += 1;
        let reach = self.step * seen.rate;
        if reach.is_nan() || reach > seen.limit {
            self.beyond.push(seen);
        }
    }

    /// The unstable step, where it lay beyond the limit in more than a few per cent of the samples.
    pub fn unstable(&self) -> Option<UnstableStep> {
        let share = self.beyond.len() as f64 / self.looks.max(1) as f64;
        if share <= SHARE {
            return None;
        }
        let mut seen = self.beyond.clone();
        seen.sort_by(|a, b| a.rate.total_cmp(&b.rate));
        let seen = *seen.get((seen.len() as f64 * NAMED_SHARE) as usize)?;
        Some(UnstableStep { step: self.step, seen, share })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_fast_looks_are_impacts_and_many_are_an_instability() {
        let watched = |fast: u32| {
            let mut watch = StabilityWatch::new(1e-6);
            for k in 0..100 {
                watch.look(Stability { rate: if k < fast { 5e6 } else { 1e6 }, limit: DORMAND_PRINCE });
            }
            watch.unstable()
        };
        assert_eq!(watched(2), None);
        let unstable = watched(10).unwrap();
        let seen = Stability { rate: 5e6, limit: DORMAND_PRINCE };
        assert_eq!(unstable, UnstableStep { step: 1e-6, seen, share: 0.1 });
        assert!((unstable.largest_stable() - 6.6e-7).abs() < 1e-12);
        assert_eq!(StabilityWatch::new(1e-6).unstable(), None);
    }
}
