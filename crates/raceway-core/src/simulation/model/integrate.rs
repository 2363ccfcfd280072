//! From one time to another by one method, and why that may fail.

use crate::numerics::ode::stability::{self, StabilityWatch};
use crate::numerics::ode::{Choice, IntegrationError, Integrator, Method, Statistics};
use crate::simulation::input::control::Control;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::Model;
use crate::simulation::model::failure::MOST_EVALUATIONS;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::state::Layout;
use crate::simulation::model::terms::Unmet;

/// Evaluations before that is judged, so that a rough start is forgiven.
const PACE: u64 = 2_000_000;
/// Steps between two looks at `Control`.
pub(crate) const STEPS_PER_LOOK: u64 = 256;
/// Evaluations between two looks at `Control`: a step of an implicit method takes many.
const EVALUATIONS_PER_LOOK: u64 = 6 * STEPS_PER_LOOK;

/// By which method, and how finely.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stepping {
    pub method: Method,
    pub relative_tolerance: f64,
    /// [s]
    pub fixed_step: Option<f64>,
    /// Evaluations of the equations it may take; `None`: as many as it likes.
    pub most_evaluations: Option<u64>,
}

impl Stepping {
    pub fn of(settings: &RunSettings) -> Self {
        Self {
            method: settings.method,
            relative_tolerance: settings.relative_tolerance,
            fixed_step: settings.fixed_step,
            most_evaluations: None,
        }
    }
}

/// From where to where, what to remember on the way, and which share of the progress that is.
pub(crate) struct Span {
    pub start: f64,
    pub end: f64,
    /// The state at this time is kept.
    pub checkpoint: f64,
    /// Progress at its start and at its end.
    pub share: (f64, f64),
}

/// What an integration leaves behind.
pub(crate) struct Integrated {
    pub statistics: Statistics,
    /// What ran at the end.
    pub choice: Choice,
    /// State at the checkpoint.
    pub checkpoint: Vec<f64>,
    /// State at the end.
    pub end: Vec<f64>,
    /// In words, where a fixed step lies beyond the limit of stability.
    pub unstable: Option<String>,
}

/// Times at which steps end exactly: kinks of the speed between two times, and the later one [s].
pub(crate) fn stops(model: &Model, from: f64, to: f64) -> Vec<f64> {
    let kinks = model.mechanism().speed.kinks().filter(|kink| *kink > from && *kink < to);
    kinks.chain([to]).collect()
}

/// Integrates a span, showing the integrator to `after_step` after each step. Steps end exactly where
/// the speed profile has a kink, and the method starts afresh there.
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
    if model.mechanism().speed.kinks().any(|kink| kink == span.start) {
        integrator.restart();
    }
    let mut next_look = EVALUATIONS_PER_LOOK;
    for stop in stops {
        while integrator.time() < stop {
            if let Err(source) = integrator.step(stop) {
                let error = SimulationError::integration(source, &layout);
                return Err(error.because(watch.as_ref().and_then(StabilityWatch::warning)));
            }
            if integrator.previous_time() < span.checkpoint && span.checkpoint <= integrator.time() {
                integrator.interpolate(span.checkpoint, &mut checkpoint);
            }
            after_step(integrator.as_ref());
            if let Some(watch) = &mut watch
                && integrator.statistics().steps.is_multiple_of(stability::STEPS_PER_LOOK)
                && let Some(seen) = integrator.stability()
            {
                watch.look(seen);
            }
            let evaluations = integrator.statistics().rhs_evaluations;
            if evaluations >= next_look {
                next_look = evaluations + EVALUATIONS_PER_LOOK;
                let time = integrator.time();
                if (control.stop)() {
                    return Err(SimulationError::Stopped { time });
                }
                if stepping.most_evaluations.is_some_and(|most| evaluations > most) {
                    return Err(SimulationError::Exhausted { time, evaluations });
                }
                let done = (integrator.time() - span.start) / (span.end - span.start);
                endless(&integrator.statistics(), done, span)?;
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
        unstable: watch.and_then(|watch| watch.warning()),
    })
}

/// Refuses to go on where the pace so far would take forever. Counts and no clock: the same run ends alike everywhere.
/// `done`: the finished share of the span.
fn endless(work: &Statistics, done: f64, span: &Span) -> Result<(), SimulationError> {
    let evaluations = work.rhs_evaluations as f64 / done;
    if work.rhs_evaluations < PACE || evaluations <= MOST_EVALUATIONS {
        return Ok(());
    }
    let time = span.start + done * (span.end - span.start);
    let step = work.advanced / work.steps.max(1) as f64;
    Err(SimulationError::Endless { time, end: span.end, step, evaluations })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_would_take_forever_is_given_up_in_words() {
        let span = Span { start: 0.0, end: 0.1, checkpoint: 0.0, share: (0.0, 1.0) };
        let work = |evaluations: u64| Statistics {
            steps: evaluations / 6,
            rhs_evaluations: evaluations,
            advanced: 1e-9,
            ..Statistics::default()
        };
        assert_eq!(endless(&work(1_000_000), 1e-8, &span), Ok(()));
        assert_eq!(endless(&work(3_000_000), 1e-3, &span), Ok(()));
        let words = endless(&work(3_000_000), 1e-8, &span).unwrap_err().to_string();
        assert!(words.contains("given up at t = 1.000e-9 s of 0.1 s") && words.contains("3e14 evaluations"), "{words}");
        // Not even a number that says how far it is.
        assert!(endless(&work(3_000_000), 0.0, &span).is_err());
    }
}
