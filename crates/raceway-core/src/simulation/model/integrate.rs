//! Integration of the dynamics from one time to another by one method.

use crate::numerics::ode::stability::{self, StabilityWatch, UnstableStep};
use crate::numerics::ode::{Choice, Integrator, Method, Statistics};
use crate::simulation::input::control::Control;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::failure::MAX_EVALUATIONS;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::rolling_limit::end_of_step;
use crate::simulation::model::system::Model;

/// Evaluations before the total number is projected, so that a rough start does not count.
const MIN_EVALUATIONS_FOR_PROJECTION: u64 = 2_000_000;
/// Steps between two polls of `Control`.
pub(crate) const STEPS_PER_LOOK: u64 = 256;
/// Bisections of the step in which the spindle leaves the bearing.
const BISECTIONS: usize = 40;
/// Evaluations between two polls of `Control`: a step of an implicit method takes many.
const EVALUATIONS_PER_POLL: u64 = 6 * STEPS_PER_LOOK;

/// Method and accuracy of an integration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stepping {
    pub method: Method,
    pub relative_tolerance: f64,
    /// Step without error control [s].
    pub fixed_step: Option<f64>,
    /// Largest number of evaluations of the equations; `None`: unlimited.
    pub most_evaluations: Option<u64>,
}

impl Stepping {
    /// Method and accuracy that the settings of a run request.
    pub(crate) fn of(settings: &RunSettings) -> Self {
        Self {
            method: settings.method,
            relative_tolerance: settings.relative_tolerance,
            fixed_step: settings.fixed_step,
            most_evaluations: None,
        }
    }
}

/// Time span of an integration, its checkpoint and its share of the progress.
pub(crate) struct Span {
    pub start: f64,
    pub end: f64,
    /// Time at which the state is stored [s].
    pub checkpoint: f64,
    /// Progress at its start and at its end.
    pub share: (f64, f64),
}

/// Outcome of an integration.
pub(crate) struct Integrated {
    pub statistics: Statistics,
    /// Integrator at the end.
    pub choice: Choice,
    /// State at the checkpoint.
    pub checkpoint: Vec<f64>,
    /// State at the end.
    pub end: Vec<f64>,
    /// Warning where a fixed step lies beyond the limit of stability.
    pub unstable: Option<UnstableStep>,
}

/// Times at which steps end exactly: kinks of speed and loads between two times, and the later one [s].
pub(crate) fn stops(model: &Model, from: f64, to: f64) -> Vec<f64> {
    let kinks = model.mechanism().kinks().into_iter().filter(|kink| *kink > from && *kink < to);
    kinks.chain([to]).collect()
}

/// Integrates a span and passes the integrator to `after_step` after each step. Steps end exactly where the speed or a load
/// has a kink, and the method starts again there.
pub(crate) fn integrate(
    model: &Model,
    start: &[f64],
    stepping: &Stepping,
    span: &Span,
    control: &Control<'_>,
    mut after_step: impl FnMut(&dyn Integrator),
) -> Result<Integrated, SimulationError> {
    let layout = model.mechanism().layout;
    let tolerances = layout.tolerances(stepping.relative_tolerance);
    let mut integrator = stepping.method.start(model, span.start, start, tolerances, stepping.fixed_step);
    let mut watch = stepping.fixed_step.map(StabilityWatch::new);
    let mut checkpoint = start.to_vec();
    let stops = stops(model, span.start, span.end);
    if model.mechanism().kinks().contains(&span.start) {
        integrator.restart();
    }
    let mut next_poll = EVALUATIONS_PER_POLL;
    for stop in stops {
        while integrator.time() < stop {
            let end = match stepping.fixed_step {
                Some(_) => stop,
                None => end_of_step(model.mechanism(), integrator.time(), integrator.state(), stop),
            };
            if let Err(source) = integrator.step(end) {
                let error = SimulationError::integration(source, &layout);
                return Err(error.because(watch.as_ref().and_then(StabilityWatch::unstable)));
            }
            if integrator.previous_time() < span.checkpoint && span.checkpoint <= integrator.time() {
                integrator.interpolate(span.checkpoint, &mut checkpoint);
            }
            if stepping.fixed_step.is_none() || integrator.statistics().steps.is_multiple_of(STEPS_PER_LOOK) {
                check_departure(model, integrator.as_ref())?;
            }
            after_step(integrator.as_ref());
            if let Some(watch) = &mut watch
                && integrator.statistics().steps.is_multiple_of(stability::STEPS_PER_LOOK)
                && let Some(seen) = integrator.stability()
            {
                watch.look(seen);
            }
            let evaluations = integrator.statistics().rhs_evaluations;
            if evaluations >= next_poll {
                next_poll = evaluations + EVALUATIONS_PER_POLL;
                let time = integrator.time();
                if (control.stop)() {
                    return Err(SimulationError::Stopped { time });
                }
                if stepping.most_evaluations.is_some_and(|most| evaluations > most) {
                    return Err(SimulationError::EvaluationLimit { time, evaluations });
                }
                let done = (integrator.time() - span.start) / (span.end - span.start);
                check_projected_evaluations(&integrator.statistics(), done, span)?;
                (control.progress)(span.share.0 + done * (span.share.1 - span.share.0));
            }
        }
        if stop < span.end {
            integrator.restart();
        }
    }
    Ok(Integrated {
        statistics: integrator.statistics(),
        choice: integrator.choice(),
        checkpoint,
        end: integrator.state().to_vec(),
        unstable: watch.and_then(|watch| watch.unstable()),
    })
}

/// Refuses a state in which no ball can hold the spindle any more.
///
/// Steps of error control grow as soon as nothing holds the spindle, so that each of them is checked. The limit is passed within the
/// last step; the error states the time by bisection.
fn check_departure(model: &Model, integrator: &dyn Integrator) -> Result<(), SimulationError> {
    let m = model.mechanism();
    let of = |state: &[f64]| {
        let spindle = m.layout.spindle(state);
        m.departure(spindle.position, spindle.tilt)
    };
    let Some(mut departure) = of(integrator.state()) else { return Ok(()) };
    let (mut before, mut time) = (integrator.previous_time(), integrator.time());
    let mut state = vec![0.0; m.layout.dimension()];
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (before + time);
        integrator.interpolate(middle, &mut state);
        match of(&state) {
            Some(earlier) => (time, departure) = (middle, earlier),
            None => before = middle,
        }
    }
    Err(SimulationError::SpindleLeft { time, departure })
}

/// Aborts a run whose projected number of evaluations is too large. The projection counts evaluations instead of time, so that the same
/// run ends alike on every machine. `done`: the finished share of the span.
fn check_projected_evaluations(work: &Statistics, done: f64, span: &Span) -> Result<(), SimulationError> {
    let evaluations = work.rhs_evaluations as f64 / done;
    if work.rhs_evaluations < MIN_EVALUATIONS_FOR_PROJECTION || evaluations <= MAX_EVALUATIONS {
        return Ok(());
    }
    let time = span.start + done * (span.end - span.start);
    let step = work.advanced / work.steps.max(1) as f64;
    Err(SimulationError::TooManyEvaluations { time, end: span.end, step, evaluations })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_with_too_many_projected_evaluations_is_aborted() {
        let span = Span { start: 0.0, end: 0.1, checkpoint: 0.0, share: (0.0, 1.0) };
        let work = |evaluations: u64| Statistics {
            steps: evaluations / 6,
            rhs_evaluations: evaluations,
            advanced: 1e-9,
            ..Statistics::default()
        };
        assert_eq!(check_projected_evaluations(&work(1_000_000), 1e-8, &span), Ok(()));
        assert_eq!(check_projected_evaluations(&work(3_000_000), 1e-3, &span), Ok(()));
        let words = check_projected_evaluations(&work(3_000_000), 1e-8, &span).unwrap_err().to_string();
        assert!(words.contains("aborted at t = 1.000e-9 s of 0.1 s") && words.contains("3e14 evaluations"), "{words}");
        // No progress at all is an error, too.
        assert!(check_projected_evaluations(&work(3_000_000), 0.0, &span).is_err());
    }
}
