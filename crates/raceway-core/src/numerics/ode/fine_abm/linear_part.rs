//! The part that is integrated exactly, and how long it has served.

/// The part that is integrated exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinearPart {
    /// Positions from velocities, all that is linear with constant coefficients in a bearing. The article names the two methods
    /// it combines but no matrix; this one leaves every contact force in `f`. Without pairs: the classical method.
    Kinematic,
    /// Each block of the Jacobian on its diagonal, and the corner, renewed as they change.
    Blocks,
}

/// Steps before a linear part is renewed again; doubled each time that it is outdated at once, up to the most.
pub(super) const MIN_PATIENCE: u64 = 4;
pub(super) const MAX_PATIENCE: u64 = 256;

/// Age of the linear part.
pub(super) struct Renewal {
    /// It has been taken since the start.
    pub(super) taken: bool,
    /// Steps since then, and before it is renewed again.
    pub(super) age: u64,
    pub(super) patience: u64,
}

impl Renewal {
    pub(super) fn new() -> Self {
        Self { taken: false, age: 0, patience: MIN_PATIENCE }
    }
}
