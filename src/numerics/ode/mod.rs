//! Ordinary differential equations `dy/dt = f(t, y)`: what an integrator needs to know of a system,
//! what it reports, and how it fails. One method a file; none knows what a bearing is.

pub mod dormand_prince;
pub mod step_size;

/// A system `dy/dt = f(t, y)`. It never changes during a run: all that moves is in `y`.
pub trait OdeSystem {
    /// Number of entries of `y`.
    fn dimension(&self) -> usize;
    /// Writes `f(time, state)` into `derivative`; both slices have `dimension()` entries.
    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]);
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
    /// Forgets what it knows of the past, after the right-hand side has jumped.
    fn restart(&mut self);
    /// Work done so far.
    fn statistics(&self) -> Statistics;
}

/// Work done by an integrator.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Statistics {
    pub steps: u64,
    pub rejected_steps: u64,
    pub rhs_evaluations: u64,
    pub jacobian_evaluations: u64,
    pub factorizations: u64,
    /// Shortest accepted step, steps cut to end at a stop left out [s]; 0 before the first.
    pub least_step: f64,
    /// Time advanced [s]; over `steps` this is the mean step.
    pub advanced: f64,
}

/// Why an integration ended early. Times in seconds.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IntegrationError {
    #[error("step size fell to {step:e} s at t = {time} s; state component {component} resists the error test")]
    StepTooSmall { time: f64, step: f64, component: usize },
    #[error("state component {component} is no longer finite at t = {time} s (step {step:e} s)")]
    NotFinite { time: f64, step: f64, component: usize },
    #[error("stopped by the caller at t = {time} s")]
    Stopped { time: f64 },
}
