//! Reasons why a term is not in the equations.

use crate::simulation::input::model_level::ModelLevel;

/// Reason why a term is not in the equations of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OmissionReason {
    /// The request switches a term of this name off.
    SwitchedOff(&'static str),
    /// A homogeneous ball looks the same from every side.
    HomogeneousBalls,
    /// Balls in the plane do not turn about their contact normals.
    BallsStayInPlane,
    /// Nothing acts along X, and the cage is symmetric.
    NothingActsAlongX,
    /// The request selects planar motion.
    PlanarSelected,
    /// The spindle is held along X.
    SpindleHeld,
    /// The gravitational acceleration is 0.
    NoGravity,
    /// The coefficient of friction is 0.
    NoFriction,
    /// Neither air nor lubricant fills the bearing.
    NothingFills,
    /// The cage is guided by its balls.
    GuidedByBalls,
    /// The spindle is balanced.
    Balanced,
    /// The lubricant has no viscosity, or there is none.
    NoViscousFilm,
    /// Neglected for grease, as in the article.
    NeglectedForGrease,
    /// The request omits the film of the pockets.
    NoPocketFilm,
    /// A wedge film needs viscosity.
    WedgeNeedsViscosity,
    /// A film between balls needs viscosity.
    FilmNeedsViscosity,
    /// No output shows it.
    NoOutput,
    /// The linear analysis bounds the change of the vibration.
    VibrationHardlyChanges,
    /// A reduced model condenses it.
    Condensed(ModelLevel, Condensation),
}

/// Motion that a reduced model condenses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condensation {
    /// Balls are in radial equilibrium between their raceways.
    RadialEquilibrium,
    /// No ball or cage leaves the plane.
    StaysInPlane,
    /// Moments of the balls are linear in the tilt of the ring, which moves no ball.
    LinearMoments,
    /// Balls orbit at equal spacing, at the speed of ideal rolling.
    EqualSpacing,
    /// Balls roll ideally.
    IdealRolling,
}
