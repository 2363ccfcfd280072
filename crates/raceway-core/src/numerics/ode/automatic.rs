//! The choice between an explicit and a stiff method by their cost, repeated along the run.
//!
//! Dormand–Prince starts. Its last two stages have the same time. The quotient of the differences of their slopes and
//! of their states is an estimate of the fastest rate |λ| (Hairer & Wanner, *Solving Ordinary Differential Equations
//! II*, §IV.2). Where its steps are no longer small against 1/|λ|, a fast mode may limit them, and Gear's method is
//! tried. The method that needs fewer evaluations per time is kept. Gear's method reads |λ| off its Jacobian, so that
//! it sees when stability would hold the other one less. No clock is read: the same run chooses alike everywhere.

use super::dormand_prince::DormandPrince;
use super::gear::Gear;
use super::integrator::{Choice, ChoiceReason, IntegrationError, Integrator, Statistics};
use super::stability::DORMAND_PRINCE as STABLE;
use super::system::OdeSystem;
use super::tolerances::Tolerances;

/// h·|λ| of Dormand–Prince above which Gear's method is tried, and above which stability limits the step.
const WORTH_A_TRIAL: f64 = 0.3;
const HELD: f64 = 2.8;
/// Number of samples of h·|λ| in favour of a trial before it is made, and of consecutive samples against it that reset
/// the count.
const LOOKS: u32 = 4;
const FREE_LOOKS: u32 = 6;
const STEPS_PER_LOOK: u64 = 4;
/// Evaluations of a step of Dormand–Prince.
const STAGES: f64 = 6.0;
/// Cost of one of Gear's evaluations in explicit ones: 2.7 for linear algebra times 1.3 for the smaller steps that give
/// the same error at the same tolerance. The first factor lies between 1.7 with the oldest instructions, whose
/// evaluations are slow, and 3.2 with the newest. One number for all, so that the same run makes the same choice on
/// every machine.
const STIFF_EVALUATION: f64 = 3.5;
/// Steps over which a cost is measured, after those that a method needs to get going; doubled with every change of mind.
const EXPLICIT_WINDOW: u64 = 100;
const STIFF_WINDOW: u64 = 400;
const EXPLICIT_WARM_UP: u64 = 20;
const STIFF_WARM_UP: u64 = 100;
const MAX_DOUBLINGS: u32 = 6;
/// The fastest rate seen fades by this factor a window.
const FADING: f64 = 0.7;
/// A change must promise this gain.
const GAIN: f64 = 1.2;

#[allow(clippy::large_enum_variant)] // One lives, and for the whole run.
enum Active<'a, S: OdeSystem + ?Sized> {
    Explicit(Box<DormandPrince<'a, S>>),
    Stiff(Box<Gear<'a, S>>),
}

/// Either method, with the measured cost of both.
pub(crate) struct Automatic<'a, S: OdeSystem + ?Sized> {
    system: &'a S,
    tolerances: Tolerances,
    active: Active<'a, S>,
    /// Work of the methods that ran before.
    past: Statistics,
    changes: u32,
    /// Looks that spoke for a trial, and those in a row since that did not.
    looks: u32,
    free_looks: u32,
    /// Stability held the explicit step when it was seen last.
    held: bool,
    /// Fastest rate seen last [1/time].
    fastest: f64,
    /// Evaluations per time when they were counted last, Gear's made comparable.
    explicit_cost: Option<f64>,
    stiff_cost: Option<f64>,
    /// Work when the count began.
    mark: Option<Statistics>,
}

impl<'a, S: OdeSystem + ?Sized> Automatic<'a, S> {
    /// Starts at `(time, state)` with the explicit method.
    pub(crate) fn new(system: &'a S, time: f64, state: &[f64], tolerances: Tolerances) -> Self {
        let explicit = DormandPrince::new(system, time, state, tolerances.clone(), None);
        Self {
            system,
            tolerances,
            active: Active::Explicit(Box::new(explicit)),
            past: Statistics::default(),
            changes: 0,
            looks: 0,
            free_looks: 0,
            held: false,
            fastest: 0.0,
            explicit_cost: None,
            stiff_cost: None,
            mark: None,
        }
    }

    fn integrator(&self) -> &dyn Integrator {
        match &self.active {
            Active::Explicit(method) => method.as_ref(),
            Active::Stiff(method) => method.as_ref(),
        }
    }

    /// Cost of the explicit method now [evaluations per time].
    fn explicit_cost(&self) -> Option<f64> {
        if self.held { Some(STAGES * self.fastest / STABLE) } else { self.explicit_cost }
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
                let rate = method.fastest_rate();
                self.fastest = rate.max(FADING * self.fastest);
                let ratio = step * rate;
                self.look(ratio);
                let Some(cost) = self.measure(work, EXPLICIT_WARM_UP, EXPLICIT_WINDOW) else { return };
                self.explicit_cost = Some(cost);
                self.held = ratio > HELD;
                if self.looks >= LOOKS && self.stiff_cost.is_none_or(|stiff| cost > GAIN * stiff) {
                    let Active::Explicit(method) = &self.active else { return };
                    let method = Gear::new(self.system, method.time(), method.state(), self.tolerances.clone());
                    self.change(work, Active::Stiff(Box::new(method)));
                }
            }
            Active::Stiff(_) => {
                let Some(cost) = self.measure(work, STIFF_WARM_UP, STIFF_WINDOW) else { return };
                let Active::Stiff(method) = &self.active else { return };
                let cost = STIFF_EVALUATION * cost;
                // A rate that was fast will be fast again, because balls return to the loaded zone.
                self.fastest = method.fastest_rate().max(FADING * self.fastest);
                self.stiff_cost = Some(cost);
                if self.explicit_cost().is_some_and(|explicit| cost > GAIN * explicit) {
                    let tolerances = self.tolerances.clone();
                    let method = DormandPrince::new(self.system, method.time(), method.state(), tolerances, None);
                    self.change(work, Active::Explicit(Box::new(method)));
                }
            }
        }
    }

    /// Takes note of the explicit method's h·|λ|.
    fn look(&mut self, ratio: f64) {
        if ratio > WORTH_A_TRIAL {
            (self.looks, self.free_looks) = (self.looks + 1, 0);
        } else {
            self.free_looks += 1;
            if self.free_looks >= FREE_LOOKS {
                self.looks = 0;
            }
        }
    }

    /// Evaluations per time, once a window is full.
    fn measure(&mut self, work: Statistics, warm_up: u64, window: u64) -> Option<f64> {
        let Some(mark) = self.mark else {
            if work.steps >= warm_up {
                self.mark = Some(work);
            }
            return None;
        };
        if work.steps < mark.steps + (window << self.changes.min(MAX_DOUBLINGS)) {
            return None;
        }
        self.mark = Some(work);
        Some((work.rhs_evaluations - mark.rhs_evaluations) as f64 / (work.advanced - mark.advanced))
    }

    fn change(&mut self, work: Statistics, active: Active<'a, S>) {
        self.past = self.past.and(&work);
        self.active = active;
        (self.changes, self.looks, self.free_looks, self.mark) = (self.changes + 1, 0, 0, None);
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
        self.mark = None;
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
        let changes = self.changes;
        let reason = match (&self.active, self.stiff_cost, self.explicit_cost()) {
            (Active::Explicit(_), Some(stiff), Some(explicit)) => {
                ChoiceReason::ExplicitIsCheaper { explicit, stiff, rate, changes }
            }
            (Active::Explicit(_), ..) => ChoiceReason::NotStiff { rate, changes },
            (Active::Stiff(method), ..) => {
                let work = method.statistics();
                let step = work.advanced / work.steps.max(1) as f64;
                ChoiceReason::Stiff { rate, limit, step, changes }
            }
        };
        Choice { method: self.integrator().choice().method, reason: Some(reason) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::ode::method::Method;
    use crate::numerics::ode::structure::Jacobian;
    use crate::numerics::ode::system::dense_differences;

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
        assert!(work.steps > 20 && worst < 1e-4, "{worst:e}");
    }

    #[test]
    fn stiff_problems_change_to_gear_and_say_why() {
        let (choice, work, worst) = run(&Follower { before: 1e5, after: 1e5 }, 1e-6, 40.0);
        assert_eq!(choice.method, Method::Gear, "{choice:?}");
        let Some(ChoiceReason::Stiff { rate, .. }) = choice.reason else { panic!("{choice:?}") };
        assert!((rate / 1e5 - 1.0).abs() < 0.05, "{rate}");
        // Explicit steps would be 1.2 million.
        assert!(work.rhs_evaluations < 30_000 && worst < 1e-4, "{work:?} {worst:e}");
    }

    #[test]
    fn a_problem_that_stops_being_stiff_comes_back() {
        let (choice, _, worst) = run(&Follower { before: 1e4, after: 2.0 }, 1e-6, 8000.0);
        assert_eq!(choice.method, Method::DormandPrince, "{choice:?}");
        let Some(ChoiceReason::ExplicitIsCheaper { changes, .. } | ChoiceReason::NotStiff { changes, .. }) =
            choice.reason
        else {
            panic!("{choice:?}")
        };
        assert!(changes > 1, "{changes}");
        assert!(worst < 1e-2, "{worst:e}");
    }
}
