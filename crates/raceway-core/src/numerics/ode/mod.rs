//! Ordinary differential equations `dy/dt = f(t, y)`: what an integrator needs to know of a system,
//! what it reports, and how it fails. One method a file; none knows what a bearing is.

pub mod adams;
pub mod adams_moulton;
pub mod arrowhead;
pub mod automatic;
pub mod dormand_prince;
pub mod fine_abm;
pub mod gear;
pub mod phi;
pub mod radau;
pub mod stability;
pub mod step_size;
pub mod structure;
#[cfg(test)]
mod test_problems;

use automatic::Automatic;
use dormand_prince::DormandPrince;
use fine_abm::{FineAbm, LinearPart};
use gear::Gear;
use radau::Radau;
use stability::Stability;
use structure::{Jacobian, Structure, dense_differences};

/// A system `dy/dt = f(t, y)`. It never changes during a run: all that moves is in `y`.
pub trait OdeSystem {
    /// Number of entries of `y`.
    fn dimension(&self) -> usize;
    /// Writes `f(time, state)` into `derivative`; both slices have `dimension()` entries.
    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]);

    /// Which entries of `∂f/∂y` may differ from zero. Unless told otherwise: all.
    fn structure(&self) -> Structure {
        Structure::dense(self.dimension())
    }

    /// A linearly implicit method with steps of a fixed length that knows how the system answers to its own motion; `None`: it
    /// has none.
    fn own_method<'a>(&'a self, time: f64, state: &[f64], step: f64) -> Option<Box<dyn Integrator + 'a>> {
        let _ = (time, state, step);
        None
    }

    /// Writes `∂f/∂y` at `(time, state)`, where `f` is `rate`, and returns the evaluations of `f` it took.
    /// Unless told otherwise by difference quotients over `displacement`, which a system that knows better may ignore.
    fn jacobian(&self, time: f64, state: &[f64], rate: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        dense_differences(self, time, state, rate, displacement, jacobian)
    }
}

/// Error tolerances: component `i` may err by `absolute[i] + relative[i] · |y_i|` a step.
#[derive(Debug, Clone)]
pub struct Tolerances {
    pub relative: Vec<f64>,
    pub absolute: Vec<f64>,
}

impl Tolerances {
    /// The same relative and absolute tolerance for each of `dimension` components.
    pub fn uniform(dimension: usize, relative: f64, absolute: f64) -> Self {
        Self { relative: vec![relative; dimension], absolute: vec![absolute; dimension] }
    }

    /// What each component of a state may err by in a step.
    #[inline(always)]
    pub fn all_allowed<'a>(&'a self, state: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let each = self.absolute.iter().zip(&self.relative).zip(state);
        each.map(|((absolute, relative), size)| absolute + relative * size.abs())
    }

    /// What component `i` may err by in a step where it is of this size.
    #[inline]
    pub fn allowed(&self, i: usize, size: f64) -> f64 {
        self.absolute[i] + self.relative[i] * size.abs()
    }
}

/// The methods by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Chooses between the others, and may change its mind on the way.
    Auto,
    /// Backward differentiation of variable step and order 1–5.
    Gear,
    /// Precise integration with exponential Adams–Bashforth–Moulton.
    FineAbm,
    /// Explicit Runge–Kutta of order 5.
    DormandPrince,
    /// Implicit Runge–Kutta of order 5: the reference.
    Radau,
    /// A linearly implicit method with fixed steps that the system brings along; only `auto` may choose it.
    SemiImplicit,
}

impl Method {
    /// All that a scene can be run by.
    pub const NAMED: [Self; 4] = [Self::Gear, Self::FineAbm, Self::DormandPrince, Self::Radau];

    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gear => "gear",
            Self::FineAbm => "fine_abm",
            Self::DormandPrince => "dormand_prince",
            Self::Radau => "radau",
            Self::SemiImplicit => "semi_implicit",
        }
    }

    /// Can run with steps of a fixed size.
    pub fn takes_fixed_steps(self) -> bool {
        matches!(self, Self::DormandPrince | Self::FineAbm | Self::SemiImplicit)
    }

    /// The method at the start of its way. `fixed_step` [s]: only for methods that take fixed steps.
    pub fn start<'a, S: OdeSystem + ?Sized>(
        self,
        system: &'a S,
        time: f64,
        state: &[f64],
        tolerances: Tolerances,
        fixed_step: Option<f64>,
    ) -> Box<dyn Integrator + 'a> {
        match self {
            Self::Gear => Box::new(Gear::new(system, time, state, tolerances)),
            Self::Radau => Box::new(Radau::new(system, time, state, tolerances)),
            Self::FineAbm => Box::new(FineAbm::new(system, time, state, tolerances, fixed_step, LinearPart::Blocks)),
            Self::DormandPrince => Box::new(DormandPrince::new(system, time, state, tolerances, fixed_step)),
            Self::SemiImplicit => match fixed_step.and_then(|step| system.own_method(time, state, step)) {
                Some(own) => own,
                None => Self::Gear.start(system, time, state, tolerances, None),
            },
            Self::Auto => Box::new(Automatic::new(system, time, state, tolerances)),
        }
    }
}

/// A method that advances one system step by step. It knows the system and its own place in it.
pub trait Integrator {
    /// One accepted step that ends at `limit` at the latest (exactly there when it would pass it).
    fn step(&mut self, limit: f64) -> Result<(), IntegrationError>;
    /// End of the last step.
    fn time(&self) -> f64;
    /// Start of the last step.
    fn previous_time(&self) -> f64;
    /// State at `time()`.
    fn state(&self) -> &[f64];
    /// State at a time within the last step.
    fn interpolate(&self, time: f64, state: &mut [f64]);
    /// What the last step has found of the system at `time()` besides its state, in numbers that the system knows the meaning of; `None`
    /// where the method knows nothing but states.
    fn sight(&self) -> Option<&[f64]> {
        None
    }
    /// Forgets what it knows of the past where the right-hand side jumps, and goes on at the next larger time: at the jump itself
    /// a right-hand side is the one that led there.
    fn restart(&mut self);
    /// Work done so far.
    fn statistics(&self) -> Statistics;
    /// What runs, and why where the integrator chose it itself.
    fn choice(&self) -> Choice;
    /// What the last step shows of the limit of stability; `None` where it shows nothing, or there is no limit. What is
    /// evaluated for that counts as work.
    fn stability(&mut self) -> Option<Stability> {
        None
    }
}

/// Which method runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    pub method: Method,
    /// Why; `None` where nothing was chosen.
    pub reason: Option<String>,
}

/// Work done by an integrator.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Statistics {
    pub steps: u64,
    /// Steps tried in vain, for whatever reason.
    pub rejected_steps: u64,
    /// Those among them for which Newton's iteration did not converge.
    pub newton_failures: u64,
    /// All evaluations of the right-hand side, those for Jacobians included.
    pub rhs_evaluations: u64,
    pub jacobian_evaluations: u64,
    pub factorizations: u64,
    /// Shortest accepted step, steps cut to end at a stop left out [s]; 0 before the first.
    pub least_step: f64,
    /// Time advanced [s]; over `steps` this is the mean step.
    pub advanced: f64,
}

impl Statistics {
    /// Takes down an accepted step; `cut`: to end at a stop.
    pub(crate) fn accept(&mut self, step: f64, cut: bool) {
        self.steps += 1;
        self.advanced += step;
        if !cut {
            self.least_step = shorter(self.least_step, step);
        }
    }

    /// The work of two methods that ran one after the other.
    pub fn and(&self, next: &Self) -> Self {
        Self {
            steps: self.steps + next.steps,
            rejected_steps: self.rejected_steps + next.rejected_steps,
            newton_failures: self.newton_failures + next.newton_failures,
            rhs_evaluations: self.rhs_evaluations + next.rhs_evaluations,
            jacobian_evaluations: self.jacobian_evaluations + next.jacobian_evaluations,
            factorizations: self.factorizations + next.factorizations,
            least_step: shorter(self.least_step, next.least_step),
            advanced: self.advanced + next.advanced,
        }
    }
}

/// The shorter of two steps; 0: none yet.
fn shorter(one: f64, other: f64) -> f64 {
    match (one, other) {
        (0.0, step) | (step, 0.0) => step,
        _ => one.min(other),
    }
}

/// Why an integration ended early. Times in seconds.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IntegrationError {
    #[error("step size fell to {step:.3e} s at t = {time:.9} s; state component {component} resists the error test")]
    StepTooSmall { time: f64, step: f64, component: usize },
    #[error("state component {component} is no longer finite at t = {time:.9} s (step {step:.3e} s)")]
    NotFinite { time: f64, step: f64, component: usize },
    #[error("stopped by the caller at t = {time:.9} s")]
    Stopped { time: f64 },
}
