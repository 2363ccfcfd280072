//! The levels of the model, from full dynamics to a periodic orbit of the spindle alone.

/// A level of the model, `rung` in requests and results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelLevel {
    /// Six degrees of freedom of every ball and of the cage.
    Full,
    /// No motion along the axis, no tilt.
    Planar,
    /// Planar, and every ball in radial equilibrium between its raceways.
    RadiallyCondensed,
    /// The spindle alone; balls orbit at equal spacing.
    SpindleOnly,
    /// The spindle alone, on an orbit that repeats with every ball.
    Periodic,
}

impl ModelLevel {
    /// All levels, the richest first.
    pub const ALL: [Self; 5] = [Self::Full, Self::Planar, Self::RadiallyCondensed, Self::SpindleOnly, Self::Periodic];
    /// Reduced levels, the leanest first.
    pub const REDUCED: [Self; 3] = [Self::Periodic, Self::SpindleOnly, Self::RadiallyCondensed];

    /// The name in requests and results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Planar => "planar",
            Self::RadiallyCondensed => "radially_condensed",
            Self::SpindleOnly => "spindle_only",
            Self::Periodic => "periodic",
        }
    }

    /// Whether it leaves out more than identities allow, and has an integrator of its own.
    pub fn is_reduced(self) -> bool {
        Self::REDUCED.contains(&self)
    }
}
