//! Reasons why a reduced model does not apply.

use crate::numerics::periodic::NoOrbit;
use crate::simulation::input::scene::Term;

/// Reason why a reduced model cannot represent a scene, its outputs or its motion.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Inapplicable {
    #[error("waves of the inner ring (scene.surfaces.inner) turn with the spindle and not with the balls")]
    InnerWaves,
    #[error(
        "balls differ (scene.surfaces.balls, scene.surfaces.every_ball), so that no motion repeats with every ball"
    )]
    UnequalBalls,
    #[error(
        "pockets are unevenly spaced (scene.bearing.cage.pocket_spacing_mrad), so that no motion repeats with every ball"
    )]
    UnevenPockets,
    #[error(
        "local defects (scene.surfaces) drive balls along their raceways and hold them back, and this model lets balls roll ideally"
    )]
    Defects,
    #[error("a ball has a defect (scene.surfaces.balls), which may part it from its raceways at any place")]
    BallDefects,
    #[error(
        "a ball may leave its raceways over a defect (scene.surfaces.{ring}.defects): a contact has {load:.2} N there, and the path takes {needed:.2} N of them"
    )]
    BallLeavesDefect { ring: &'static str, load: f64, needed: f64 },
    #[error("an axial load acts")]
    AxialLoad,
    #[error("the spindle moves along X")]
    SpindleMovesAlongX,
    #[error("the spindle is held off its centre along X")]
    SpindleOffCentre,
    #[error("the spindle is misaligned")]
    Misaligned,
    #[error("the spindle tilts (spindle.tilt is free)")]
    SpindleTilts,
    #[error("a defect lies beside the groove's bottom (across_mm) and pushes balls along X")]
    DefectBesideBottom,
    #[error("waves of a groove along the axis (axial_waviness) push balls along X")]
    AxialWaves,
    #[error("a defect of a ball lies beside the ball's equator (latitude_deg) and pushes the ball along X")]
    DefectBesideTrack,
    #[error(
        "waves of balls (scene.surfaces.balls, every_ball) turn with the balls, and no passage repeats the last one"
    )]
    BallWaves,
    #[error(
        "lines of balls that differ or are uneven lie close to lines of the shaft, so that their beat needs the speed of the cage, and this model lets balls roll ideally"
    )]
    CageBeatsWithShaft,
    #[error("without a cage balls touch each other, and this model has no contact between balls")]
    NoCage,
    #[error(
        "operation.initial_perturbation moves balls along their radius, where this model keeps them in equilibrium"
    )]
    InitialPerturbation,
    #[error("rolling friction and pressure forces of the film act on the spindle")]
    Hydrodynamics,
    #[error("raceways with a viscous damper have no condensed law")]
    ViscousDamper,
    #[error("the pocket film empirical-11 is stiff and undamped, so that fixed steps are unstable")]
    StiffPocketFilm,
    #[error("terms.{} is on", .0.name())]
    TermOn(Term),
    #[error("terms.{} is off", .0.name())]
    TermOff(Term),
    #[error("contacts are asked for (`outputs.metrics` without \"contacts\" does not)")]
    ContactsRequested,
    #[error("the cage's motion is asked for (`outputs.metrics` without \"cage\" does not)")]
    CageRequested,
    #[error("the life from the loads of the balls is asked for (`outputs.metrics` without \"life\" does not)")]
    LifeRequested,
    #[error("the friction torque is asked for (`outputs.metrics` without \"friction\" does not)")]
    FrictionRequested,
    #[error("a channel besides y and z of the spindle is asked for")]
    OtherChannels,
    #[error("an output asks for motion along X")]
    ChannelAlongX,
    #[error("the outer ring turns (operation.outer_speed_rpm), and this model has equations for one that stands")]
    OuterRingTurns,
    #[error("the speed changes")]
    SpeedChanges,
    #[error("a load varies (operation.loads), and not with every ball")]
    LoadsVary,
    #[error("nothing turns")]
    AtRest,
    #[error("unbalance turns with the spindle and not with the balls")]
    Unbalance,
    #[error("nothing holds the spindle: where it rests it touches no ball")]
    NothingHolds,
    #[error("the spindle on its contacts is too fast: it needs steps of {step:.1e} s")]
    FastSpindle { step: f64 },
    #[error("spindle, cage or traction are too fast: they need steps of {step:.1e} s")]
    FastMotion { step: f64 },
    #[error("a ball passes every {passage:.1e} s, which takes {steps} steps of {step:.1e} s")]
    LongPassage { passage: f64, steps: usize, step: f64 },
    #[error(transparent)]
    NoPeriodicOrbit(NoOrbit),
    #[error("its motion does not repeat with the balls: a disturbance grows by a factor of {growth:.3} in one passage")]
    UnstableOrbit { growth: f64 },
    #[error("the motion that repeats with the balls depends on the steps: its levels by {change:.1e}")]
    UnresolvedOrbit { change: f64 },
    #[error("a run from rest settles on another motion than the one that repeats with the balls")]
    OtherOrbit,
}
