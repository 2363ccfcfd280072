//! Codes with numbers that a run reports about itself. The text of each is defined outside this crate.

use super::channel::MachineChannel;
use super::input::Loss;
use crate::rotor::omission::SystemTerm;
use crate::simulation::error::codes::Warning;
use crate::simulation::input::model_level::ModelLevel;

/// A reason to doubt a number of a run, or a remark. Bearings count from 0.
#[derive(Debug, Clone, PartialEq)]
pub enum MachineWarning {
    /// Free motion of the start decays with this time constant [s], infinite where nothing damps it; `settle` [s] is too short, `required` [s]
    /// is enough.
    StartTransient { time_constant: f64, settle: f64, required: f64, constant_speed: bool },
    /// A level rises or falls throughout the recorded time [dB].
    NotStationary { channel: MachineChannel, change_db: f64 },
    /// The strongest line of all accelerations has no label: no order, ball passage or load makes it. Surfaces are ideal. Its frequency [Hz] and amplitude [m/s²].
    UnnamedLine { channel: MachineChannel, frequency: f64, amplitude: f64 },
    /// Half steps still change a level by more than is allowed [dB].
    Uncertain { channel: MachineChannel, error_db: f64, allowed_db: f64, step: f64, last: LastStep },
    /// Only a first window [s] was repeated, and something changes after it. Half steps of `step` [s] would show the error.
    PartlyVerified { window: f64, change: LaterChange, step: f64 },
    /// The largest pressure in a bearing [Pa] deforms its raceways permanently.
    Overloaded { bearing: usize, load: f64, pressure: f64 },
    /// The shaft presses an angular-contact bearing with a force [N] against its open side, where the model has a groove.
    OpenSide { bearing: usize, load: f64 },
    /// A limit of what the run can say about the surfaces of a bearing.
    Surface { bearing: usize, warning: Warning },
    /// Longer steps were tried and rejected.
    StepRejected(RejectedStep),
    /// The selected model level deviates from `full` by more than is allowed.
    ModelNotConfirmed(LevelDeviation),
    /// A leaner model was tried, and a richer one took its place.
    LevelRejected(LevelDeviation),
    /// A leaner model gave no result, and a richer one took its place.
    LevelNotEligible { model: LeanModel, reason: String },
}

/// A model that leaves something out: its level, and terms of the system around the bearings.
#[derive(Debug, Clone, PartialEq)]
pub struct LeanModel {
    pub level: ModelLevel,
    pub without: Vec<SystemTerm>,
}

/// Largest deviation of a level from `full` [dB], over the time that was repeated [s].
#[derive(Debug, Clone, PartialEq)]
pub struct LevelDeviation {
    pub model: LeanModel,
    pub channel: MachineChannel,
    pub error_db: f64,
    pub allowed_db: f64,
    pub window: f64,
}

/// Reason why no shorter step was tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LastStep {
    /// The request selected the step.
    Selected,
    /// The step is the shortest.
    Shortest,
    /// Twice this step had no larger error: the motion is irregular, and both levels are samples of it.
    Irregular,
}

/// Change after the verified time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LaterChange {
    Speed,
    /// Place of a load in the list of the scene. `at`: begin of a shock [s].
    Load {
        place: usize,
        at: Option<f64>,
    },
}

/// A step that did not become that of the result.
#[derive(Debug, Clone, PartialEq)]
pub struct RejectedStep {
    /// [s]
    pub step: f64,
    pub cause: StepCause,
    /// True if the bearings are too stiff for such steps, against the inertia of the shaft at their places.
    pub stiff_bearings: bool,
}

/// Cause of the rejection of a step.
#[derive(Debug, Clone, PartialEq)]
pub enum StepCause {
    /// The motion was lost at a time [s].
    Lost { time: f64, loss: Loss },
    /// Half steps change a level [dB].
    Deviation { channel: MachineChannel, error_db: f64 },
}
