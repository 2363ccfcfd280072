//! The interface of an integration method: steps, states, statistics and errors.

use super::method::Method;
use super::stability::Stability;

/// A method that advances one system step by step. It holds the system and the present state.
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
    /// Quantities of the system at `time()` besides its state that the last step computed, in the system's own layout.
    /// `None` where the method has states only.
    fn sight(&self) -> Option<&[f64]> {
        None
    }
    /// Restarts without history where the right-hand side jumps, at the next larger time. At the time of the jump
    /// itself, the right-hand side still has the value before it.
    fn restart(&mut self);
    /// Work done so far.
    fn statistics(&self) -> Statistics;
    /// The method that runs, with the reason where the integrator chose it.
    fn choice(&self) -> Choice;
    /// Fastest rate and limit of stability as the last step shows them; `None` where it shows none or there is no
    /// limit. Evaluations for it count as work.
    fn stability(&mut self) -> Option<Stability> {
        None
    }
}

/// Which method runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    pub method: Method,
    /// `None` where nothing was chosen.
    pub reason: Option<ChoiceReason>,
}

/// Why an integrator runs a method. Rates and evaluations per unit of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ChoiceReason {
    /// Explicit steps need fewer evaluations at this tolerance than `gear`, made comparable by the cost of its algebra.
    ExplicitIsCheaper { explicit: f64, stiff: f64, rate: f64, changes: u32 },
    /// Explicit steps are short against the fastest rate.
    NotStiff { rate: f64, changes: u32 },
    /// The rate would limit explicit steps to `limit`; the mean step of `gear` is `step`.
    Stiff { rate: f64, limit: f64, step: f64, changes: u32 },
    /// Fixed steps, implicit in the stiff terms, are tried before error control.
    TriedFirst { step: f64 },
}

/// Work done by an integrator.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Statistics {
    pub steps: u64,
    /// Rejected steps, for any reason.
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
    /// Counts an accepted step; `cut`: shortened to end at a stop.
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
    #[error("an impact at t = {time:.9} s is too short for fixed steps of {step:.3e} s")]
    Impact { time: f64, step: f64, component: usize },
    #[error("stopped by the caller at t = {time:.9} s")]
    Stopped { time: f64 },
}
