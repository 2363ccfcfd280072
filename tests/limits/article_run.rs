//! Runs of the article's case, each executed once for all tests: 20 ms of settling, 30 ms recorded.

use std::sync::OnceLock;

use raceway::numerics::ode::Method;
use raceway::simulation::error::codes::Warning;
use raceway::simulation::error::report::AccuracyReport;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::result::lines::Line;
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::simulate;
use serde_json::json;

use crate::scenes::{article, changed, scene};

pub const Y: Channel = Channel::Spindle(Axis::Y, Motion::Acceleration);
pub const Z: Channel = Channel::Spindle(Axis::Z, Motion::Acceleration);

/// Settings: 20 ms of settling, 30 ms recorded, all metrics, spectra of both accelerations.
pub fn settings() -> RunSettings {
    RunSettings {
        method: Method::Auto,
        rung: None,
        relative_tolerance: 1e-5,
        // The full model. The reduced models have tests of their own.
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: 0.02,
        duration: 0.03,
        outputs: Outputs { contacts: true, cage: true, spectra: vec![Y, Z], ..Outputs::vibration() },
    }
}

/// A control that never aborts a run and ignores its progress.
pub fn patient() -> Control<'static> {
    Control::until(&|| false)
}

/// The article's case.
pub fn balanced() -> &'static RunResult {
    static RUN: OnceLock<RunResult> = OnceLock::new();
    RUN.get_or_init(|| simulate(&scene(&article()), &settings(), &patient()).unwrap())
}

/// The article's case with an unbalance of grade G 6.3.
pub fn unbalanced() -> &'static RunResult {
    static RUN: OnceLock<RunResult> = OnceLock::new();
    RUN.get_or_init(|| {
        let scene = scene(&changed(article(), json!({ "spindle": { "balance_grade": 6.3 } })));
        simulate(&scene, &settings(), &patient()).unwrap()
    })
}

/// Lines of a channel, the strongest first.
pub fn lines(result: &RunResult, channel: Channel) -> Vec<&Line> {
    result.summary.lines.iter().filter(|(of, _)| *of == channel).map(|(_, line)| line).collect()
}

/// The line with a label.
pub fn line<'a>(result: &'a RunResult, channel: Channel, label: &str) -> Option<&'a Line> {
    lines(result, channel).into_iter().find(|line| line.label == label)
}

/// Warnings of vibration of the start.
pub fn transients(accuracy: &AccuracyReport) -> Vec<&Warning> {
    accuracy.warnings.iter().filter(|warning| is_transient(warning)).collect()
}

/// All other warnings.
pub fn doubts(accuracy: &AccuracyReport) -> Vec<&Warning> {
    accuracy.warnings.iter().filter(|warning| !is_transient(warning) && !warning.is_remark()).collect()
}

fn is_transient(warning: &Warning) -> bool {
    matches!(warning, Warning::StartTransient { .. } | Warning::CageTransient { .. } | Warning::TiltTransient { .. })
}
