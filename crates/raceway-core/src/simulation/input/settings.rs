//! Settings of a run and its requested outputs.

use crate::numerics::ode::Method;
use crate::numerics::spectrum::{EnvelopeAnalysis, EnvelopeKind};
use crate::physics::kinematics::ideal_frequencies;
use crate::simulation::input::channel::Channel;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;

/// Default of the analysed envelope: its band lies above the shaft and ball-pass lines, where impacts excite resonances.
pub const ENVELOPE: EnvelopeAnalysis = EnvelopeAnalysis { band: (2_000.0, 20_000.0), kind: EnvelopeKind::Magnitude };

/// Edges of the bands in which bearing vibration is stated as velocity [Hz] (ISO 15242-1).
pub const BAND_EDGES: [f64; 4] = [50.0, 300.0, 1800.0, 10_000.0];

/// Requested outputs. They decide which terms the model must contain.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    pub vibration: bool,
    pub contacts: bool,
    pub cage: bool,
    /// Means of the loads of the balls, from which a life follows.
    pub life: bool,
    /// Powers of contacts, pockets and drag.
    pub friction: bool,
    /// Channels with amplitude and envelope spectra.
    pub spectra: Vec<Channel>,
    /// Channels with a full time series.
    pub series: Vec<Channel>,
    pub envelope: EnvelopeAnalysis,
    /// Rising edges of the bands in which accelerations are summed [Hz].
    pub band_edges: Vec<f64>,
    /// True if the envelopes of the accelerations are read at the rates of defects.
    pub envelope_harmonics: bool,
    /// Longest window of spectra and statistics [s].
    pub longest_window: f64,
}

/// Longest window [s]: a run of the longest default duration on ideal raceways is one.
const LONGEST_WINDOW: f64 = 1.0;
/// Turns of the cage in a window of spectra of raceways that are no circles [-], whose lines differ by the speed of the cage, and its
/// longest time [s]: the thirteen channels of a run then take 85 MB.
const SURFACE_TURNS: f64 = 8.0;
const LONGEST_SURFACE_WINDOW: f64 = 8.0;

/// Longest window of spectra of a scene [s].
pub fn longest_window(scene: &Scene) -> f64 {
    let cage = ideal_frequencies(&scene.bearing, scene.operating_speeds()).cage;
    match scene.surfaces.are_ideal() || cage <= 0.0 {
        true => LONGEST_WINDOW,
        false => (SURFACE_TURNS / cage).clamp(LONGEST_WINDOW, LONGEST_SURFACE_WINDOW),
    }
}

impl Outputs {
    /// Levels and lines of the spindle's vibration, no signals.
    pub fn vibration() -> Self {
        Self {
            vibration: true,
            contacts: false,
            cage: false,
            life: false,
            friction: false,
            spectra: Vec::new(),
            series: Vec::new(),
            envelope: ENVELOPE,
            band_edges: BAND_EDGES.to_vec(),
            envelope_harmonics: false,
            longest_window: LONGEST_WINDOW,
        }
    }

    /// Returns whether an output depends on the vibration levels of the spindle.
    pub(crate) fn include_levels(&self) -> bool {
        self.vibration || self.spectra.iter().any(|channel| matches!(channel, Channel::Spindle(..)))
    }

    /// Returns whether any spectrum is computed.
    pub(crate) fn have_spectra(&self) -> bool {
        self.envelope_harmonics || !self.spectra.is_empty()
    }

    /// The same metrics of the motion, without spectra and series.
    pub(crate) fn without_signals(&self) -> Self {
        Self { spectra: Vec::new(), series: Vec::new(), envelope_harmonics: false, ..self.clone() }
    }

    /// Returns whether any signal is kept. The data of plots are kept together with signals.
    pub(crate) fn keep_signals(&self) -> bool {
        !(self.spectra.is_empty() && self.series.is_empty())
    }
}

/// Settings of a run. Times in seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    pub method: Method,
    pub rung: Option<ModelLevel>,
    pub relative_tolerance: f64,
    /// Tighter tolerance of a second run, where `model_tolerance_db` or a requested load or speed needs it; `None`: the tolerance
    /// is not changed.
    pub tightened: Option<f64>,
    /// Allowed change of a level by the terms that are omitted by judgement [dB]; 0: identities and conventions only.
    pub model_tolerance_db: f64,
    /// Fixed step without error control [s], for methods that support one.
    pub fixed_step: Option<f64>,
    /// Simulated time before the recording.
    pub settle: f64,
    /// Recorded time.
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

    /// The scene as the run sees it: speeds and loads after its end do not count.
    pub(crate) fn seen(&self, scene: &Scene) -> Scene {
        scene.until(self.settle + self.duration)
    }

    /// The tightest relative tolerance that the run may choose [-].
    pub(crate) fn tightest(&self) -> f64 {
        self.tightened.unwrap_or(self.relative_tolerance)
    }
}
