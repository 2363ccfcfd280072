//! Codes with numbers that a run reports about itself. The text of each code is defined outside this crate.

use crate::numerics::ode::Method;
use crate::numerics::ode::stability::UnstableStep;
use crate::physics::surface::waviness::Omission;
use crate::simulation::error::errors::{LevelErrors, QuantityErrors};
use crate::simulation::input::channel::Channel;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::inapplicable::Inapplicable;

/// A number whose error is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    Level,
    MaxLoad,
    Slip,
    CageSpeed,
    PocketLoad,
    CageOrbit,
}

/// An estimated error: of a level [dB], of any other number as a share of it [-].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuantityError {
    pub quantity: Quantity,
    pub error: f64,
    /// Of a level, the channel that has this error.
    pub channel: Option<Channel>,
}

/// Refinement of a repetition over the run that it verifies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refinement {
    /// Step of the repetition over that of the run [-].
    Step(f64),
    /// Relative tolerance of the repetition [-], and its method.
    Tolerance(f64, Method),
}

impl Refinement {
    /// Step of the repetition over that of the run [-].
    pub fn step(&self) -> Option<f64> {
        match self {
            Self::Step(share) => Some(*share),
            Self::Tolerance(..) => None,
        }
    }
}

/// Basis of the stated errors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ErrorBasis {
    /// No error is stated.
    #[default]
    None,
    /// Nothing moves: no level can be compared.
    Silence,
    /// Difference from a richer model over a window [s].
    RicherModel { level: ModelLevel, window: f64 },
    /// Difference from a repetition over a window [s] of the recorded time [s].
    Repetition { refinement: Refinement, window: f64, recorded: f64 },
    /// Chaotic motion: standard error by batch means, or the difference from another sample if that is larger.
    BatchMeans { refinement: Refinement },
}

/// Effect that one window of verification does not cover.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gap {
    /// The cage speed changed after the window, as a share of it [-].
    CageSpeedChanged(f64),
    /// Balls moved on in their pockets after the window, as a share of their spacing [-].
    BallsDrifted(f64),
    /// Inertia of the spindle exceeds the share of its static load [-] up to which it stays on its balls.
    InertiaExceedsPreload(f64),
    /// The level scatters along the recorded time [dB].
    LevelScatters(Channel, f64),
    /// Balls leave the plane: contact angles before and after [rad], over a window [s].
    BallsLeavePlane { before: f64, after: f64, window: f64 },
    /// The lubricant is so viscous at this speed that cage and balls may tilt.
    MayTilt,
    /// The crown cage is so heavy, or so far from the plane of the balls, that it may tilt them.
    HeavyCage,
    /// The speed changes.
    SpeedChanges,
    /// A load changes and does not repeat.
    LoadsChange,
    /// The recorded time is shorter than a window of verification.
    ShortRecord,
    /// Neighbouring trajectories diverge.
    Chaos,
}

/// Cause of the rejection of a candidate.
#[derive(Debug, Clone, PartialEq)]
pub enum Cause {
    /// The candidate failed.
    Failed(SimulationError),
    /// The verification deviates by more than is allowed.
    Deviation { levels: LevelErrors, quantities: Option<QuantityErrors>, beyond: Vec<Quantity> },
    /// The window of verification does not cover the run.
    NotCovered(Gap),
    /// Under refinement the whole run takes a different course.
    CourseDiffers { levels: LevelErrors, quantities: Option<QuantityErrors>, beyond: Vec<Quantity> },
    /// Disturbances grow faster than in chaotic motion: the step is unstable.
    Instability,
    /// Disturbances grow, and the recorded time is too short to be a sample of chaos.
    ShortChaos,
    /// Disturbances do not decay, and axial motion or tilt keeps light oscillations that long steps damp.
    NoDecay,
    /// Levels of the chaotic motion depend on the step.
    SamplesDiffer,
    /// The repetition failed.
    NotVerified(SimulationError),
}

/// A candidate that did not become the result.
#[derive(Debug, Clone, PartialEq)]
pub struct Rejection {
    pub level: ModelLevel,
    /// The integrator, if it is not the model's own.
    pub method: Option<Method>,
    /// [s]; `None`: error control, or the model's own step.
    pub step: Option<f64>,
    /// Relative tolerance of error control [-].
    pub tolerance: Option<f64>,
    pub cause: Cause,
}

/// Cause of uncertain numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Uncertainty {
    /// Refinement still changes them.
    Steps,
    /// The smallest disturbance leads to other peaks.
    Sensitive,
    /// The recorded time is a short sample of chaotic motion.
    ShortSample,
    /// The levels vary along the recorded time.
    Uneven,
}

/// Warning to the user of a result.
#[derive(Debug, Clone, PartialEq)]
pub enum Warning {
    /// Errors of numbers are large.
    Uncertain { cause: Uncertainty, errors: Vec<QuantityError> },
    /// Refinement still changes a level [dB], so that its error is unknown. `is_selected`: the request selected the method, the step or the
    /// tolerance.
    NotResolved { change_db: f64, is_selected: bool },
    /// A level rises or falls throughout the recorded time [dB].
    NotStationary { channel: Channel, change_db: f64 },
    /// Levels are so low that their changes along the recorded time do not count: rms of their channels [m/s²].
    StationarityNotChecked { channels: Vec<(Channel, f64)> },
    /// A chaotic motion: time in which disturbances grow e-fold, and recorded time that is required [s].
    ShortChaoticSample { growth_time: f64, required: f64 },
    /// The recorded time [s] is shorter than an error estimate needs [s].
    RecordTooShort { recorded: f64, required: f64 },
    /// The repetition failed: no error is known.
    NotVerified(SimulationError),
    /// Only a first window [s] could be repeated.
    PartlyVerified { window: f64, cause: SimulationError },
    /// A later window could not be recorded.
    LaterWindowFailed(SimulationError),
    /// The selected model level is not confirmed within [dB].
    ModelNotConfirmed { level: ModelLevel, allowed_db: f64, cause: Cause },
    /// The window of verification does not cover the run: no error is stated.
    ErrorUnknown(Gap),
    /// The fixed step lies beyond the limit of stability.
    UnstableStep(UnstableStep),
    /// Free vibration of the start decays with this time constant [s]; `settle` [s] is too short, `required` [s] is enough.
    StartTransient { time_constant: f64, settle: f64, required: f64, constant_speed: bool },
    /// The cage may still vibrate along its axis; a settling time [s] that is enough.
    CageTransient { settle: f64, required: f64 },
    /// Cage and balls may still begin to tilt; a settling time [s] that is enough.
    TiltTransient { settle: f64, required: f64 },
    /// The band of the envelope leaves out the resonance that a defect excites most; this band would hold it [Hz].
    MissedResonance { resonance: f64, band: (f64, f64), advised: (f64, f64) },
    /// A defect of the outer raceway at this azimuth [rad], and `others`, where the inner raceway presses on no ball.
    UnloadedDefect { azimuth: f64, others: usize },
    /// A ball cannot follow the troughs of waves; the most curved one has an amplitude above the largest that it follows [m].
    BridgedTroughs { part: SurfacePart, order: u32, amplitude: f64, largest: f64 },
    /// Heights within the contact on a raceway, rms, exceed the minimum film [m].
    RoughContact { part: SurfacePart, roughness: f64, film: f64 },
    /// A given wave of this order, and `others` of the same part, are not in the model.
    WavesLeftOut { part: SurfacePart, order: u32, others: usize, reason: Omission },
    /// The contacts of a ball run at a latitude of it [rad]: waves above this order lose more than a warned error there.
    TrackOffEquator { ball: usize, latitude: f64, order: u32 },
    /// Spectra over a window [s] do not separate lines that differ by the cage speed [Hz]. A window is at most `longest` [s].
    MergedCageLines { cage: f64, window: f64, required: f64, longest: f64 },
}

/// A rolling surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfacePart {
    Inner,
    Outer,
    /// Number of the ball, from 1.
    Ball(usize),
}

impl Warning {
    /// True if it is no reason to doubt a number.
    pub fn is_remark(&self) -> bool {
        matches!(
            self,
            Self::LaterWindowFailed(_)
                | Self::StationarityNotChecked { .. }
                | Self::MissedResonance { .. }
                | Self::UnloadedDefect { .. }
                | Self::WavesLeftOut { .. }
        )
    }
}

/// Reason why no reduced model, or no model leaner than the condensed one, is a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ineligible {
    /// A method, a step or a tolerance was selected.
    MethodSelected,
    /// `model_tolerance_db` is 0.
    NoModelError,
    /// A term that the model omits is on.
    TermOn,
    /// Hydrodynamic forces act: they tilt balls and cage later than a window shows.
    Hydrodynamics,
    /// The speed changes: a window shows nothing of later speeds.
    SpeedChanges,
    /// A load changes and does not repeat: a window shows nothing of later loads.
    LoadsChange,
    /// The window of verification would be too large a part of the run.
    ShortRun,
    /// The lubricant is so viscous at this speed that cage and balls may tilt, which a planar window does not show.
    MayTilt,
    /// The crown cage is so heavy, or so far from the plane of the balls, that it may tilt them, which a planar window does not show.
    HeavyCage,
}

/// A model level that is not a candidate of a run, and the reason.
#[derive(Debug, Clone, PartialEq)]
pub struct NotEligible {
    pub levels: Vec<ModelLevel>,
    pub reason: NotEligibleReason,
}

/// Reason why a level is not a candidate.
#[derive(Debug, Clone, PartialEq)]
pub enum NotEligibleReason {
    Known(Ineligible),
    /// The level cannot represent the scene or its outputs.
    CannotRepresent(Inapplicable),
}
