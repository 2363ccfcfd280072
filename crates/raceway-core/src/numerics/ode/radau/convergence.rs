//! The convergence of Newton's iteration.

/// Convergence of Newton's iteration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Convergence {
    /// Ratio of successive increments; 0 where one was enough.
    pub(super) contraction: f64,
    /// Remaining distance to the solution over the last increment [-].
    pub(super) remainder: f64,
}

impl Convergence {
    pub(super) const UNKNOWN: Self = Self { contraction: 0.0, remainder: 1.0 };
}
