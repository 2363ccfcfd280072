//! The main story: equilibrium, integrate, observe.

use super::channel::Channel;
use super::metrics::Summary;
use super::needs::LeftOut;
use super::scene::Scene;
use crate::numerics::ode::IntegrationError;
use crate::numerics::spectrum::Spectrum;

/// Which integrator advances the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The run chooses and says what it chose.
    Auto,
    DormandPrince,
}

/// A rung of the ladder of models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rung {
    Full,
    Planar,
}

/// What a run must produce; it decides what the model must contain.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    pub vibration: bool,
    pub contacts: bool,
    pub cage: bool,
    /// Amplitude and envelope spectra of these.
    pub spectra: Vec<Channel>,
    /// Full time series of these.
    pub series: Vec<Channel>,
}

/// How to simulate. Times in seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    pub method: Method,
    pub rung: Option<Rung>,
    pub relative_tolerance: f64,
    /// How much a level may change by what is left out by judgement [dB]; 0: identities and conventions only.
    pub model_tolerance_db: f64,
    /// Step of Dormand–Prince without error control [s].
    pub fixed_step: Option<f64>,
    /// Simulated before anything is kept.
    pub settle: f64,
    /// Simulated and kept.
    pub duration: f64,
    pub outputs: Outputs,
}

/// How a run talks to whoever waits for it.
pub struct Control<'a> {
    /// Looked at every few hundred steps; true ends the run.
    pub stop: &'a dyn Fn() -> bool,
    /// Told the finished share, 0–1, every few hundred steps.
    pub progress: &'a dyn Fn(f64),
}

/// A signal at a uniform rate, in the channel's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub channel: Channel,
    /// Time of the first value since the start of the run [s].
    pub start: f64,
    /// Time between values [s].
    pub step: f64,
    pub values: Vec<f64>,
}

/// Spectra of one channel, in the channel's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelSpectra {
    pub channel: Channel,
    pub amplitude: Spectrum,
    pub envelope: Spectrum,
}

/// All that a run leaves behind.
#[derive(Debug, Clone, PartialEq)]
pub struct RunResult {
    pub summary: Summary,
    pub spectra: Vec<ChannelSpectra>,
    pub series: Vec<Series>,
    pub left_out: Vec<LeftOut>,
}

/// Why a run failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    #[error("no static equilibrium was found to start from: {0}")]
    NoEquilibrium(String),
    #[error("{source} ({entry})")]
    Integration {
        source: IntegrationError,
        /// The state component in words, such as "radial velocity of ball 3".
        entry: String,
    },
    /// `Control::stop` asked for it.
    #[error("stopped at t = {time} s")]
    Stopped { time: f64 },
}

/// Simulates the scene. Deterministic: the same arguments give the same bits apart from `wall_time`.
pub fn run(scene: &Scene, settings: &RunSettings, control: &Control<'_>) -> Result<RunResult, SimulationError> {
    let _ = (scene, settings, control);
    unimplemented!()
}
