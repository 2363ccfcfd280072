//! The levels of the model, from full dynamics to a periodic orbit of the spindle alone.

/// A rung of the ladder of models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelLevel {
    /// Six degrees of freedom of every ball and of the cage.
    Full,
    /// No motion along the axis, no tilt.
    Planar,
    /// Planar, and every ball in radial equilibrium between its raceways.
    RadiallyCondensed,
    /// The balls go round equally spaced.
    SpindleOnly,
    /// The same, repeating with every ball.
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

    /// Whether the level is one of `REDUCED`.
    pub fn is_reduced(self) -> bool {
        Self::REDUCED.contains(&self)
    }
}
