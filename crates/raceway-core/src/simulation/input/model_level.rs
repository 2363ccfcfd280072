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
