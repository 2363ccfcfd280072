//! Runs of the article's case, each made once for all tests that look at it: 20 ms to settle, 30 ms kept.

use std::sync::OnceLock;

use raceway::numerics::ode::Method;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::result::lines::Line;
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::run;
use serde_json::json;

use crate::scenes::{article, changed, scene};

pub const Y: Channel = Channel::Spindle(Axis::Y, Motion::Acceleration);
pub const Z: Channel = Channel::Spindle(Axis::Z, Motion::Acceleration);

/// 20 ms to settle, 30 ms kept, all metrics, spectra of both accelerations.
pub fn settings() -> RunSettings {
    RunSettings {
        method: Method::Auto,
        rung: None,
        relative_tolerance: 1e-5,
        // The dynamics; the ladder below them has tests of its own.
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: 0.02,
        duration: 0.03,
        outputs: Outputs { vibration: true, contacts: true, cage: true, spectra: vec![Y, Z], series: Vec::new() },
    }
}

/// A control that never stops a run and hears nothing.
pub fn patient() -> Control<'static> {
    Control::until(&|| false)
}

/// The article's case.
pub fn balanced() -> &'static RunResult {
    static RUN: OnceLock<RunResult> = OnceLock::new();
    RUN.get_or_init(|| run(&scene(&article()), &settings(), &patient()).unwrap())
}

/// The same with the unbalance of grade G 6.3.
pub fn unbalanced() -> &'static RunResult {
    static RUN: OnceLock<RunResult> = OnceLock::new();
    RUN.get_or_init(|| {
        let scene = scene(&changed(article(), json!({ "spindle": { "balance_grade": 6.3 } })));
        run(&scene, &settings(), &patient()).unwrap()
    })
}

/// The lines of a channel, strongest first.
pub fn lines(result: &RunResult, channel: Channel) -> Vec<&Line> {
    result.summary.lines.iter().filter(|(of, _)| *of == channel).map(|(_, line)| line).collect()
}

/// The line of that label.
pub fn line<'a>(result: &'a RunResult, channel: Channel, label: &str) -> Option<&'a Line> {
    lines(result, channel).into_iter().find(|line| line.label == label)
}
