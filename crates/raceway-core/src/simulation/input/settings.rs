//! What a run is asked for, and how to simulate it.

use crate::numerics::ode::Method;
use crate::simulation::input::channel::Channel;
use crate::simulation::input::model_level::ModelLevel;

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

impl Outputs {
    /// Levels and lines of the spindle's vibration, no signals.
    pub fn vibration() -> Self {
        Self { vibration: true, contacts: false, cage: false, spectra: Vec::new(), series: Vec::new() }
    }

    /// Whether the answer has to do with levels of the spindle.
    pub fn are_of_levels(&self) -> bool {
        self.vibration || self.spectra.iter().any(|channel| matches!(channel, Channel::Spindle(..)))
    }

    /// Whether any signal is kept; what pictures show is kept with them.
    pub fn keep_signals(&self) -> bool {
        !(self.spectra.is_empty() && self.series.is_empty())
    }
}

/// How to simulate. Times in seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    pub method: Method,
    pub rung: Option<ModelLevel>,
    pub relative_tolerance: f64,
    /// The tolerance that is taken instead, and the run made again, where `model_tolerance_db` or a load or speed that is
    /// asked for turns out to need it; `None`: the tolerance stands.
    pub tightened: Option<f64>,
    /// How much a level may change by what is left out by judgement [dB]; 0: identities and conventions only.
    pub model_tolerance_db: f64,
    /// Step without error control [s]; only for methods that take fixed steps.
    pub fixed_step: Option<f64>,
    /// Simulated before anything is kept.
    pub settle: f64,
    /// Simulated and kept.
    pub duration: f64,
    pub outputs: Outputs,
}

impl RunSettings {
    /// A run by automatic choice of model and method at the default tolerances; times in seconds.
    pub fn new(settle: f64, duration: f64, outputs: Outputs) -> Self {
        Self {
            method: Method::Auto,
            rung: None,
            relative_tolerance: 1e-5,
            tightened: None,
            model_tolerance_db: 0.05,
            fixed_step: None,
            settle,
            duration,
            outputs,
        }
    }

    /// The tightest relative tolerance that the run may take by itself.
    pub fn tightest(&self) -> f64 {
        self.tightened.unwrap_or(self.relative_tolerance)
    }
}
