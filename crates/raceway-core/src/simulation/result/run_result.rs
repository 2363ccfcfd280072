//! The result of a run, assembled from its recording and the reports of the solver.

use crate::simulation::error::report::AccuracyReport;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::Mechanism;
use crate::simulation::model::contact_resonance::contact_resonances;
use crate::simulation::model::terms::LeftOut;
use crate::simulation::recording::plot_data::{Impact, PlotData};
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::spectra::ChannelSpectra;
use crate::simulation::result::metrics::{self, SolverReport, Spectra, Summary};
use crate::simulation::result::series::Series;

/// Result of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunResult {
    pub summary: Summary,
    pub spectra: Vec<ChannelSpectra>,
    pub series: Vec<Series>,
    /// Data of plots, where any signal is requested.
    pub plot_data: PlotData,
    pub left_out: Vec<LeftOut>,
}

/// Provenance of a result: solver, accuracy, omitted terms.
pub(crate) struct Provenance {
    pub solver: SolverReport,
    pub accuracy: AccuracyReport,
    pub left_out: Vec<LeftOut>,
}

impl RunResult {
    /// Assembles the requested outputs from a recording.
    pub(crate) fn new(
        scene: &Scene,
        settings: &RunSettings,
        mechanism: &Mechanism,
        recording: &Recording,
        provenance: Provenance,
    ) -> Self {
        let Provenance { solver, accuracy, left_out } = provenance;
        let outputs = &settings.outputs;
        let channels = || if outputs.vibration { metrics::vibration(recording) } else { Vec::new() };
        let (balls, is_steady) = (scene.bearing.parameters.ball_count, scene.operation.is_steady());
        let impact = || Impact::of(recording, balls).filter(|_| scene.surfaces.have_defects());
        let plot_data = || PlotData { impact: impact(), ..PlotData::of(recording, balls, is_steady) };
        let (spectra, plot_data) = match outputs.keep_signals() {
            true => (metrics::spectra(recording, settings), plot_data()),
            false => (Vec::new(), PlotData::default()),
        };
        let lines = |kind| match outputs.vibration {
            true => metrics::lines(scene, recording, &spectra, kind, &accuracy),
            false => Vec::new(),
        };
        let summary = Summary {
            channels: channels(),
            contacts: outputs.contacts.then(|| metrics::contacts(mechanism, recording)),
            cage: if outputs.cage { metrics::cage(scene, recording) } else { None },
            load_means: recording.load_means,
            friction: metrics::friction(scene, recording),
            relative_speed: recording.speeds.relative,
            frequencies: metrics::frequencies(scene, recording),
            lines: lines(Spectra::Amplitude),
            envelope_lines: lines(Spectra::Envelope),
            envelope_harmonics: metrics::envelope_harmonics(scene, recording, settings, &accuracy),
            resonances: match outputs.vibration && !scene.surfaces.are_ideal() {
                true => contact_resonances(mechanism, scene.operating_speeds()),
                false => Vec::new(),
            },
            solver,
            accuracy,
        };
        Self { summary, spectra, series: metrics::series(recording, settings), plot_data, left_out }
    }
}
