//! Rigid discs on a shaft.

/// A rigid disc, thin along the shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Place along the shaft [m].
    pub at: f64,
    /// [kg]
    pub mass: f64,
    /// About a diameter [kg m²].
    pub transverse_inertia: f64,
    /// About the shaft's axis [kg m²].
    pub axial_inertia: f64,
}

/// An eccentric mass on a shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnbalancePlane {
    /// Place along the shaft [m].
    pub at: f64,
    /// Mass times eccentricity [kg m].
    pub product: f64,
    /// Angle from +Y towards +Z when the shaft's angle is 0 [rad].
    pub phase: f64,
}
