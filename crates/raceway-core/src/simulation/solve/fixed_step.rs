//! Selection and refinement of fixed steps.

use crate::numerics::ode::Method;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::model::system::Model;

/// First step that is tried [s]; *steps*: levels of the article's bearing err by at most 0.02 dB.
pub const STEP: f64 = 7.5e-6;
/// First step where the spindle moves along the axis [s]; *steps*: the same errors.
pub const AXIAL_STEP: f64 = 5.5e-6;
/// Step of the dynamics that verify a reduced model [s]: a fifth of the error of the first step.
const VERIFYING_STEP: f64 = 0.5 * STEP;
/// Shortest step that is tried [s]: below it error control takes no longer.
pub const SHORTEST: f64 = 1e-6;
/// Next step over a step that failed [-].
pub const HALVED: f64 = 0.5;
/// Order by which the error falls with the step, rounded down [-].
const ORDER: f64 = 2.0;
/// Share of the allowed error that the next step aims at [-], and largest ratio of the next step to the last [-].
const AIM: f64 = 0.5;
const LARGEST_CHANGE: f64 = 0.75;

/// True if no method, step or tolerance was selected.
pub fn is_free(settings: &RunSettings) -> bool {
    settings.method == Method::Auto && settings.fixed_step.is_none() && settings.tightened.is_some()
}

/// True if fixed steps can be tried. Undamped contacts keep vibrating, and long steps would damp this vibration. Fast defects need steps
/// so short that error control takes no longer.
pub fn is_eligible(model: &Model, settings: &RunSettings) -> bool {
    is_free(settings) && model.mechanism().raceway.inner.is_damped() && lengths(model).next().is_some()
}

/// The first step that is tried [s]. It resolves the waves of the raceways, the loads and the path over each defect.
pub fn first_step(model: &Model) -> f64 {
    let mechanism = model.mechanism();
    let step = if mechanism.layout.axial_spindle { AXIAL_STEP } else { STEP };
    step.min(mechanism.longest_excited_step()).min(mechanism.defect_step)
}

/// Steps that can be tried, the longest first. None of them is built for a spindle that tilts.
pub(crate) fn lengths(model: &Model) -> impl Iterator<Item = f64> {
    let first = (!model.mechanism().layout.tilting_spindle).then(|| first_step(model));
    std::iter::successors(first, |step| Some(HALVED * step)).take_while(|step| *step >= SHORTEST)
}

/// Next step after a step whose error exceeds the allowed one by a factor `excess` [s].
pub fn refined(step: f64, excess: f64) -> f64 {
    step * (AIM / excess).powf(1.0 / ORDER).min(LARGEST_CHANGE)
}

/// Integration by a step of a fixed length [s].
pub(crate) fn by(step: f64) -> Stepping {
    Stepping { method: Method::SemiImplicit, relative_tolerance: 0.0, fixed_step: Some(step), most_evaluations: None }
}

/// The same run in steps of a fixed length [s].
pub fn in_steps(settings: &RunSettings, step: f64) -> RunSettings {
    RunSettings { method: Method::SemiImplicit, fixed_step: Some(step), tightened: None, ..settings.clone() }
}

/// Settings of the dynamics that verify a reduced model in fixed steps; `None` if a step was selected.
pub fn verifying(settings: &RunSettings, model: &Model) -> Option<RunSettings> {
    let mechanism = model.mechanism();
    let step = VERIFYING_STEP.min(mechanism.defect_step).min(0.5 * mechanism.longest_load_step());
    (is_free(settings) && step >= SHORTEST).then(|| in_steps(settings, step))
}
