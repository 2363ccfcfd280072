//! The levels of the model, from full dynamics to a periodic orbit of the spindle alone.

/// Model level, called `rung` in requests and results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelLevel {
    /// Six degrees of freedom of every ball and of the cage.
    Full,
    /// Six degrees of freedom less axial motion and tilt.
    Planar,
    /// Planar, with every ball in radial equilibrium between its raceways.
    RadiallyCondensed,
    /// Spindle alone, on equally spaced balls in radial equilibrium.
    SpindleOnly,
    /// Steady motion of `SpindleOnly`, which repeats with every ball.
    Periodic,
}

impl ModelLevel {
    /// All levels, the richest first.
    pub const ALL: [Self; 5] = [Self::Full, Self::Planar, Self::RadiallyCondensed, Self::SpindleOnly, Self::Periodic];
    /// Models that leave out more than identities allow and have an integrator of their own, the cheapest first.
    pub(crate) const REDUCED: [Self; 3] = [Self::Periodic, Self::SpindleOnly, Self::RadiallyCondensed];

    /// The name of the level in requests and results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Planar => "planar",
            Self::RadiallyCondensed => "radially_condensed",
            Self::SpindleOnly => "spindle_only",
            Self::Periodic => "periodic",
        }
    }

    /// Returns whether the level is one of `REDUCED`.
    pub fn is_reduced(self) -> bool {
        Self::REDUCED.contains(&self)
    }
}
