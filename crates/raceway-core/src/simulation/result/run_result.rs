//! What a run leaves behind.

use crate::numerics::spectrum::Spectrum;
use crate::simulation::error::comparison::LevelErrors;
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::input::channel::Channel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::Mechanism;
use crate::simulation::model::terms::LeftOut;
use crate::simulation::recording::plot_data::Views;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::spectra::ChannelSpectra;
use crate::simulation::result::metrics::{self, SolverReport, Summary};

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

/// All that a run leaves behind.
#[derive(Debug, Clone, PartialEq)]
pub struct RunResult {
    pub summary: Summary,
    pub spectra: Vec<ChannelSpectra>,
    pub series: Vec<Series>,
    /// For pictures, where any signal is asked for.
    pub views: Views,
    pub left_out: Vec<LeftOut>,
}

/// What a result says of itself.
pub(crate) struct Account {
    pub solver: SolverReport,
    pub accuracy: AccuracyReport,
    /// Of the levels, from stretch to stretch; none at changing speed.
    pub scatter: Option<LevelErrors>,
    /// Of a start that may still ring.
    pub settling: Option<String>,
    pub left_out: Vec<LeftOut>,
}

impl RunResult {
    /// Everything that the outputs ask for, from what a run has shown.
    pub(crate) fn new(
        scene: &Scene,
        settings: &RunSettings,
        mechanism: &Mechanism,
        recording: &Recording,
        account: Account,
    ) -> Self {
        let Account { solver, accuracy, scatter, settling, left_out } = account;
        let outputs = &settings.outputs;
        let channels = || if outputs.vibration { metrics::vibration(recording) } else { Vec::new() };
        let (balls, is_steady) = (scene.bearing.parameters.ball_count, scene.operation.speed.is_constant());
        let views = || Views::of(recording, balls, is_steady);
        let (spectra, views) = match outputs.keep_signals() {
            true => (metrics::spectra(recording, settings), views()),
            false => (Vec::new(), Views::default()),
        };
        let frequencies = metrics::frequencies(scene, recording);
        let summary = Summary {
            scatter: scatter.unwrap_or_default(),
            settling,
            channels: channels(),
            contacts: outputs.contacts.then(|| metrics::contacts(mechanism, recording)),
            cage: if outputs.cage { metrics::cage(scene, recording) } else { None },
            frequencies,
            lines: if outputs.vibration { metrics::lines(scene, &spectra, &frequencies) } else { Vec::new() },
            solver,
            accuracy,
        };
        Self { summary, spectra, series: metrics::series(recording, settings), views, left_out }
    }
}
