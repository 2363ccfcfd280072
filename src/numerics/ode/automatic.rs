//! The choice between an explicit and a stiff method, by what they cost, looked at again and again.
//!
//! Dormand–Prince starts. Its last two stages sit at the same time, so that the quotient of their slopes' and their
//! states' differences shows the fastest rate |λ| (Hairer & Wanner, *Solving Ordinary Differential Equations II*, §IV.2): once
//! h·|λ| stays at the limit of stability, the step no longer follows the accuracy asked for, and Gear's method takes over.
//! It counts its evaluations and reads |λ| off its Jacobian; when they are more than the explicit method's would be, that one
//! comes back. No clock is read: the same run chooses alike everywhere.

use super::dormand_prince::DormandPrince;
use super::gear::Gear;
use super::stability::DORMAND_PRINCE as STABLE;
use super::{Choice, IntegrationError, Integrator, OdeSystem, Statistics, Tolerances};

/// h·|λ| from which a step of Dormand–Prince counts as held by stability.
const HELD: f64 = 2.8;
/// Looks at h·|λ| in a row that find it held, each after so many steps.
const HELD_LOOKS: u32 = 4;
const STEPS_PER_LOOK: u64 = 8;
/// Steps between two looks at a Jacobian, and how many of these in a row must find the mean step held: where what is fast
/// saturates, the stages see less than there is.
const STEPS_PER_JACOBIAN: u64 = 256;
const HELD_JACOBIANS: u32 = 2;
/// Evaluations of a step of Dormand–Prince.
const STAGES: f64 = 6.0;
/// What linear algebra adds to the cost of Gear's evaluations, as a factor.
const LINEAR_ALGEBRA: f64 = 1.7;
/// Steps of Gear's method over which its cost is measured, and those that it needs to get going.
const WINDOW: u64 = 400;
const WARM_UP: u64 = 100;
/// A change must promise this gain.
const GAIN: f64 = 1.2;

#[allow(clippy::large_enum_variant)] // One lives, and for the whole run.
enum Active<'a, S: OdeSystem + ?Sized> {
    Explicit(DormandPrince<'a, S>),
    Stiff(Gear<'a, S>),
}

/// Where a count of Gear's cost began.
#[derive(Clone, Copy)]
struct Mark {
    evaluations: u64,
    advanced: f64,
    steps: u64,
}

/// Either method, and what is known of both.
pub struct Automatic<'a, S: OdeSystem + ?Sized> {
    system: &'a S,
    tolerances: Tolerances,
    active: Active<'a, S>,
    /// Work of the methods that ran before.
    past: Statistics,
    changes: u32,
    /// Looks in a row at which stability held the explicit step.
    held_looks: u32,
    /// The same of Jacobians, and time advanced when the last one was looked at.
    held_jacobians: u32,
    looked_at: f64,
    /// Fastest rate seen last [1/time].
    fastest: f64,
    /// Evaluations per time of Gear's method when it was measured last.
    stiff_cost: Option<f64>,
    mark: Option<Mark>,
}

impl<'a, S: OdeSystem + ?Sized> Automatic<'a, S> {
    /// Starts at `(time, state)` with the explicit method.
    pub fn new(system: &'a S, time: f64, state: &[f64], tolerances: Tolerances) -> Self {
        let explicit = DormandPrince::new(system, time, state, tolerances.clone(), None);
        Self {
            system,
            tolerances,
            active: Active::Explicit(explicit),
            past: Statistics::default(),
            changes: 0,
            held_looks: 0,
            held_jacobians: 0,
            looked_at: 0.0,
            fastest: 0.0,
            stiff_cost: None,
            mark: None,
        }
    }

    fn integrator(&self) -> &dyn Integrator {
        match &self.active {
            Active::Explicit(method) => method,
            Active::Stiff(method) => method,
        }
    }

    /// Evaluations per time of the explicit method where stability holds it.
    fn explicit_cost(&self) -> f64 {
        STAGES * self.fastest / STABLE
    }

    /// Looks at the method that runs and changes it where the other is cheaper.
    fn reconsider(&mut self) {
        let work = self.integrator().statistics();
        match &self.active {
            Active::Explicit(method) => {
                if work.steps == 0 || !work.steps.is_multiple_of(STEPS_PER_LOOK) {
                    return;
                }
                let step = method.time() - method.previous_time();
                self.fastest = method.fastest_rate();
                self.held_looks = if step * self.fastest > HELD { self.held_looks + 1 } else { 0 };
                if work.steps.is_multiple_of(STEPS_PER_JACOBIAN) {
                    let mean = (work.advanced - self.looked_at) / STEPS_PER_JACOBIAN as f64;
                    self.looked_at = work.advanced;
                    self.fastest = method.stability().map_or(self.fastest, |seen| seen.rate);
                    self.held_jacobians = if mean * self.fastest > HELD { self.held_jacobians + 1 } else { 0 };
                }
                let cheaper = self.stiff_cost.is_none_or(|cost| self.explicit_cost() > GAIN * cost);
                if (self.held_looks >= HELD_LOOKS || self.held_jacobians >= HELD_JACOBIANS) && cheaper {
                    let method = Gear::new(self.system, method.time(), method.state(), self.tolerances.clone());
                    self.change(work, Active::Stiff(method));
                }
            }
            Active::Stiff(method) => {
                let here = Mark { evaluations: work.rhs_evaluations, advanced: work.advanced, steps: work.steps };
                let Some(mark) = self.mark else {
                    if work.steps >= WARM_UP {
                        self.mark = Some(here);
                    }
                    return;
                };
                if here.steps < mark.steps + WINDOW {
                    return;
                }
                let cost =
                    LINEAR_ALGEBRA * (here.evaluations - mark.evaluations) as f64 / (here.advanced - mark.advanced);
                self.fastest = method.fastest_rate();
                self.stiff_cost = Some(cost);
                self.mark = Some(here);
                if cost > GAIN * self.explicit_cost() {
                    let tolerances = self.tolerances.clone();
                    let method = DormandPrince::new(self.system, method.time(), method.state(), tolerances, None);
                    self.change(work, Active::Explicit(method));
                }
            }
        }
    }

    fn change(&mut self, work: Statistics, active: Active<'a, S>) {
        self.past = self.past.and(&work);
        self.active = active;
        (self.changes, self.held_looks, self.held_jacobians, self.mark) = (self.changes + 1, 0, 0, None);
        self.looked_at = 0.0;
    }
}

impl<S: OdeSystem + ?Sized> Integrator for Automatic<'_, S> {
    fn step(&mut self, limit: f64) -> Result<(), IntegrationError> {
        // Now, and not after the last step: that could still be asked for states within it.
        self.reconsider();
        match &mut self.active {
            Active::Explicit(method) => method.step(limit),
            Active::Stiff(method) => method.step(limit),
        }
    }

    fn time(&self) -> f64 {
        self.integrator().time()
    }

    fn previous_time(&self) -> f64 {
        self.integrator().previous_time()
    }

    fn state(&self) -> &[f64] {
        self.integrator().state()
    }

    fn interpolate(&self, time: f64, state: &mut [f64]) {
        self.integrator().interpolate(time, state);
    }

    fn restart(&mut self) {
        self.stiff_cost = None;
        match &mut self.active {
            Active::Explicit(method) => method.restart(),
            Active::Stiff(method) => method.restart(),
        }
    }

    fn statistics(&self) -> Statistics {
        self.past.and(&self.integrator().statistics())
    }

    fn choice(&self) -> Choice {
        let rate = self.fastest;
        let limit = STABLE / rate;
        let mut reason = match (&self.active, self.stiff_cost) {
            (Active::Explicit(_), None) => {
                format!("not stiff: the fastest rate seen, {rate:.1e} 1/s, does not hold the explicit steps back")
            }
            (Active::Explicit(_), Some(cost)) => format!(
                "stiff, but cheaper explicitly: {:.1e} evaluations a second at the limit of stability, steps of \
                 {limit:.1e} s for |λ| = {rate:.1e} 1/s, against {cost:.1e} of gear at this tolerance",
                self.explicit_cost()
            ),
            (Active::Stiff(method), _) => {
                let work = method.statistics();
                let step = work.advanced / work.steps.max(1) as f64;
                format!(
                    "stiff: the fastest rate |λ| = {rate:.1e} 1/s would hold explicit steps to {limit:.1e} s; \
                     gear's are {step:.1e} s in the mean, h·|λ| = {:.1}",
                    step * rate
                )
            }
        };
        if self.changes > 1 {
            reason += &format!("; changed {} times", self.changes);
        }
        Choice { method: self.integrator().choice().method, reason: Some(reason) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::ode::Method;
    use crate::numerics::ode::structure::{Jacobian, dense_differences};

    /// y' = −rate (y − cos t) − sin t beside an oscillator of frequency 1; the rate may change at t = 20.
    struct Follower {
        before: f64,
        after: f64,
    }
    impl OdeSystem for Follower {
        fn dimension(&self) -> usize {
            3
        }
        fn derivative(&self, time: f64, y: &[f64], dy: &mut [f64]) {
            let rate = if time < 20.0 { self.before } else { self.after };
            dy.copy_from_slice(&[-rate * (y[0] - time.cos()) - time.sin(), y[2], -y[1]]);
        }
        fn jacobian(&self, time: f64, y: &[f64], f: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
            dense_differences(self, time, y, f, displacement, jacobian)
        }
    }

    fn run(system: &Follower, tolerance: f64, stop: f64) -> (Choice, Statistics, f64) {
        let tolerances = Tolerances::uniform(3, tolerance, tolerance);
        let mut method = Automatic::new(system, 0.0, &[1.0, 1.0, 0.0], tolerances);
        let mut worst = 0.0_f64;
        while method.time() < stop {
            method.step(stop).unwrap();
            worst = worst.max((method.state()[0] - method.time().cos()).abs());
        }
        (method.choice(), method.statistics(), worst)
    }

    #[test]
    fn gentle_problems_stay_explicit() {
        let (choice, work, worst) = run(&Follower { before: 1.0, after: 1.0 }, 1e-6, 40.0);
        assert_eq!(choice.method, Method::DormandPrince, "{choice:?}");
        assert!(work.jacobian_evaluations == 0 && worst < 1e-4, "{worst:e}");
    }

    #[test]
    fn stiff_problems_change_to_gear_and_say_why() {
        let (choice, work, worst) = run(&Follower { before: 1e5, after: 1e5 }, 1e-6, 40.0);
        assert_eq!(choice.method, Method::Gear, "{choice:?}");
        assert!(choice.reason.is_some_and(|reason| reason.contains("1.0e5")));
        // Explicit steps would be 1.2 million.
        assert!(work.rhs_evaluations < 30_000 && worst < 1e-4, "{work:?} {worst:e}");
    }

    #[test]
    fn a_problem_that_stops_being_stiff_comes_back() {
        let (choice, _, worst) = run(&Follower { before: 1e4, after: 2.0 }, 1e-6, 400.0);
        assert_eq!(choice.method, Method::DormandPrince, "{choice:?}");
        assert!(choice.reason.is_some_and(|reason| reason.contains("changed")));
        assert!(worst < 1e-3, "{worst:e}");
    }
}
