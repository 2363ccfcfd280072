//! Verification of planar dynamics where the request omits the tilt of balls and cage: a window of the full dynamics.

use crate::simulation::error::codes::{Cause, Gap, Warning};
use crate::simulation::error::comparison::Deviation;
use crate::simulation::error::errors::LevelErrors;
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::input::control::Control;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::{Term, TermChoice};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::system::Model;
use crate::simulation::model::terms::{ActiveTerms, Justification};
use crate::simulation::recording::record::Recording;
use crate::simulation::solve::attempt::{Dynamics, Problem, window_settings};
use crate::simulation::solve::eligibility::may_tilt;
use crate::simulation::solve::judge::deviates;
use crate::simulation::solve::startup::InitialState;
use crate::simulation::solve::verification::or_failure;
use crate::simulation::solve::verify_reduced::dynamics_window;

/// Adds the deviation from the full dynamics to the report of a planar run, and the window of this comparison [s]. `None`: the run is not planar, or
/// nothing tilts the balls.
pub(crate) fn with_omitted_tilt(
    report: AccuracyReport,
    terms: &ActiveTerms,
    problem: &Problem<'_>,
    control: &Control<'_>,
) -> Result<(AccuracyReport, Option<f64>), SimulationError> {
    let is_tilt = |term: &str| term == Term::CageTilt.name();
    let omits = terms.left_out.iter().any(|omitted| is_tilt(omitted.term) && omitted.by == Justification::Convention);
    if terms.rung != ModelLevel::Planar || !omits {
        return Ok((report, None));
    }
    if may_tilt(problem.scene) {
        // Tilt grows for seconds.
        let report = AccuracyReport { level_errors: LevelErrors::default(), quantity_errors: None, ..report };
        return Ok((report.with(Warning::ErrorUnknown(Gap::MayTilt)), None));
    }
    let settings = problem.settings;
    let short = window_settings(problem.scene, settings);
    let (tolerance, window) = (settings.model_tolerance_db, short.duration);
    let not_confirmed = |cause| Warning::ModelNotConfirmed { level: ModelLevel::Planar, allowed_db: tolerance, cause };
    let windowed = |level| -> Result<Recording, SimulationError> {
        let mut scene = problem.scene.clone();
        scene.terms.set(Term::CageTilt, TermChoice::Auto);
        let terms = ActiveTerms::of(&scene, &short.outputs, Some(level))?;
        let model = Model::new(&scene, &terms);
        let start = InitialState::at_rest(&model)?;
        dynamics_window(&Dynamics { model, terms, start }, &short, settings, control)
    };
    let both = windowed(ModelLevel::Planar).and_then(|planar| Ok((planar, windowed(ModelLevel::Full)?)));
    let mut report = report;
    match or_failure(both)? {
        Ok((planar, full)) => {
            let unseen = (1.0 - window / settings.duration).max(0.0).sqrt();
            let deviation = Deviation::of_recordings(&planar, &full, unseen).of_asked(&settings.outputs);
            report.level_errors = report.level_errors.larger(deviation.levels);
            report.quantity_errors = report.quantity_errors.zip(deviation.quantities).map(|(a, b)| a.larger(&b));
            if !deviation.within(&settings.outputs, tolerance) {
                report.warnings.push(not_confirmed(deviates(&deviation, &settings.outputs, tolerance)));
            }
        }
        Err(failure) => report.warnings.push(not_confirmed(Cause::NotVerified(failure))),
    }
    Ok((report, Some(window)))
}
