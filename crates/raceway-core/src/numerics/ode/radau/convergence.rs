//! The convergence of Newton's iteration.

/// How well Newton's iteration goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Convergence {
    /// Ratio of successive increments; 0 where one was enough.
    pub(super) contraction: f64,
    /// What is left to go, over the last increment.
    pub(super) remainder: f64,
}

impl Convergence {
    pub(super) const UNKNOWN: Self = Self { contraction: 0.0, remainder: 1.0 };
}
