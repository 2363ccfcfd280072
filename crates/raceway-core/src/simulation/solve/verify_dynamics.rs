//! Verification of a run of the dynamics: a repetition in finer steps or at a tighter tolerance.

use crate::numerics::ode::Method;
use crate::simulation::error::codes::{ErrorBasis, Refinement};
use crate::simulation::error::comparison::{Deviation, level_errors, quantity_errors, twice};
use crate::simulation::error::convergence::{Spacing, error_over_deviation};
use crate::simulation::error::lyapunov;
use crate::simulation::error::stationarity::is_stationary;
use crate::simulation::error::thresholds::{INDEPENDENT_NOISE, WINDOW_PASSAGES};
use crate::simulation::input::control::Control;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::{PART, RATE, REPEATED, kept_values};
use crate::simulation::solve::attempt::{Attempt, Dynamics, MIN_EVALUATIONS, Problem, run};
use crate::simulation::solve::eligibility::{
    longest_load_period, longest_passage, representative_time, turn_of_unequal_balls,
};
use crate::simulation::solve::verification::{MIN_VALUES, TIGHTEST, Verification, along_the_run, or_failure};

/// Tolerance of a repetition over that of the run [-].
const TIGHTER: f64 = 0.1;
/// Evaluations of a verification over those of the run, at most [-].
const MOST_EVALUATIONS: u64 = 10;
pub(crate) fn by_refinement(
    attempt: &Attempt,
    problem: &Problem<'_>,
    control: &Control<'_>,
) -> Result<Verification, SimulationError> {
    let Problem { scene, settings, .. } = *problem;
    let Some(trajectory) = &attempt.trajectory else { return Ok(Verification::default()) };
    let dynamics = problem.dynamics(control)?;
    let method = if attempt.step.is_some() { trajectory.choice.method } else { settings.method };
    let method = if settings.method == Method::Auto && attempt.step.is_none() { Method::Auto } else { method };
    let own = RunSettings {
        method,
        fixed_step: attempt.step,
        relative_tolerance: attempt.tolerance.unwrap_or(settings.relative_tolerance),
        ..settings.clone()
    };
    let most = MOST_EVALUATIONS * attempt.work.rhs_evaluations.max(MIN_EVALUATIONS);
    let window = refined_window(scene, settings);
    let estimated = lyapunov::divergence_rate(
        &dynamics.model,
        &own,
        settings.settle,
        &trajectory.checkpoint,
        window,
        most,
        control,
    );
    let (divergence, mut failure) = match or_failure(estimated)? {
        Ok(divergence) => (Some(divergence), None),
        Err(failure) => (None, Some(failure)),
    };
    (control.progress)(0.2);
    let mut verification = Verification { divergence, ..Verification::default() };
    let decays = divergence.is_some_and(|divergence| divergence.growth < 0.0);
    let has_axial_motion_or_tilt = dynamics.model.mechanism().has_axial_motion_or_tilt();
    let forgets = if has_axial_motion_or_tilt { decays } else { !verification.is_chaotic() };
    if method == Method::SemiImplicit && !forgets {
        // The cause is chaos, instability of the step, or slow motion that keeps oscillations damped by the step. No repetition shows the error.
        verification.failure = failure;
        return Ok(verification);
    }
    // The whole time is compared where the motion passes through different states, or is sensitive.
    let is_windowed = scene.operation.is_steady() && !verification.is_chaotic();
    let is_even = is_stationary(&attempt.recording, &settings.outputs, settings.model_tolerance_db);
    let mut window = match (is_windowed, is_even) {
        (false, _) => settings.duration,
        (true, false) => settings.duration.min(whole_parts(representative_time(scene))),
        (true, true) => refined_window(scene, settings),
    };
    let repetitions = Repetitions { dynamics, most, control };
    let other = RunSettings { method: independent(trajectory.choice.method), fixed_step: None, ..own.clone() };
    let mut repeating = if damps(trajectory.choice.method) { &other } else { &own };
    let mut repeated = or_failure(repetitions.run(window, repeating, &finer(repeating)))?;
    if repeated.is_err() && repeating.method != own.method {
        // The run's own method still shows its error, if the other one takes too many evaluations.
        repeating = &own;
        repeated = or_failure(repetitions.run(window, repeating, &finer(repeating)))?;
    }
    if let Err(why) = &repeated
        && window > REPEATED
    {
        // The first window still gives an error estimate.
        match or_failure(repetitions.run(REPEATED, repeating, &finer(repeating)))? {
            Ok(recording) => {
                verification.part = Some((REPEATED, why.clone()));
                (repeated, window) = (Ok(recording), REPEATED);
                failure = None;
            }
            Err(_) => failure = Some(why.clone()),
        }
    } else if let Err(why) = &repeated {
        failure = failure.or(Some(why.clone()));
    }
    (control.progress)(0.8);
    verification.failure = failure.filter(|_| verification.part.is_none());
    verification.is_whole = window >= settings.duration;
    let Ok(Some(again)) = repeated else { return Ok(verification) };
    let compared = |again: &Recording| {
        let signals = twice(&attempt.recording, again);
        let unseen = (1.0 - window / settings.duration).max(0.0).sqrt();
        let noise = signals.iter().map(|(_, twice)| twice.noise()).fold(0.0, f64::max);
        let deviation = Deviation {
            levels: level_errors(&signals, |twice| twice.error_db(unseen)),
            quantities: Some(quantity_errors(&attempt.recording.parts, &again.parts)),
        };
        (noise, deviation)
    };
    let (mut noise, mut deviation) = compared(&again);
    // Independent samples of a sensitive motion show no order.
    if repeating.method == own.method && !verification.is_chaotic() && noise <= INDEPENDENT_NOISE {
        match repetitions.order(window, repeating, &attempt.recording, &again)? {
            Some(factor) => deviation = deviation.times(factor),
            None => match or_failure(repetitions.run(window, &other, &finer(&other)))? {
                Ok(Some(confirming)) => {
                    repeating = &other;
                    (noise, deviation) = compared(&confirming);
                }
                Ok(None) => return Ok(verification),
                Err(why) => return Ok(Verification { failure: Some(why), ..verification }),
            },
        }
    }
    (control.progress)(1.0);
    verification.noise = noise;
    verification.deviation =
        Some(if is_windowed && is_even { along_the_run(deviation, &attempt.recording) } else { deviation });
    verification.basis =
        ErrorBasis::Repetition { refinement: refinement(repeating), window, recorded: settings.duration };
    Ok(verification)
}

/// Window of a repetition, and initial time over which neighbouring trajectories are followed [s].
fn refined_window(scene: &Scene, settings: &RunSettings) -> f64 {
    let passages = WINDOW_PASSAGES * longest_passage(scene);
    let window = if passages.is_finite() { passages.max(REPEATED) } else { REPEATED };
    let turns = turn_of_unequal_balls(scene).max(longest_load_period(scene));
    settings.duration.min(whole_parts(window.max(turns)))
}

/// The time of whole parts [s], at least the given one: the means of a part that is cut short are not those of the run.
fn whole_parts(time: f64) -> f64 {
    let part = PART as f64 / RATE;
    (time / part).ceil() * part
}

/// True if a method damps fast motion, so that tighter tolerances of the same method share this error.
fn damps(method: Method) -> bool {
    matches!(method, Method::Gear | Method::Radau)
}

/// A method of another kind.
fn independent(method: Method) -> Method {
    if method == Method::Radau { Method::Gear } else { Method::Radau }
}

/// Step and tolerance of a repetition over those of a run [-].
struct Change {
    step: f64,
    tolerance: f64,
}

/// Third runs, which show the order of a method.
const COARSER: Change = Change { step: 2.0, tolerance: 1.0 / TIGHTER };

/// Repetitions in finer steps. Half of a long step of `semi_implicit` damps light oscillations above the band as the step itself does; a
/// quarter shows this damping.
fn finer(settings: &RunSettings) -> Change {
    Change { step: if settings.method == Method::SemiImplicit { 0.25 } else { 0.5 }, tolerance: TIGHTER }
}

/// Refinement of a repetition.
fn refinement(settings: &RunSettings) -> Refinement {
    let Change { step, tolerance } = finer(settings);
    match settings.fixed_step {
        Some(_) => Refinement::Step(step),
        None => Refinement::Tolerance((tolerance * settings.relative_tolerance).max(TIGHTEST), settings.method),
    }
}

/// Repetitions of a run from its initial state.
struct Repetitions<'a> {
    dynamics: &'a Dynamics,
    /// Limit on the evaluations of each.
    most: u64,
    control: &'a Control<'a>,
}

impl Repetitions<'_> {
    /// A repetition over a window [s]; `None`: too short to compare.
    fn run(&self, window: f64, settings: &RunSettings, change: &Change) -> Result<Option<Recording>, SimulationError> {
        if kept_values(window) < MIN_VALUES {
            return Ok(None);
        }
        let again = RunSettings {
            duration: window,
            // The sampling follows the steps of the repetition, because peaks lie between the samples of longer steps.
            fixed_step: settings.fixed_step.map(|step| change.step * step),
            outputs: settings.outputs.without_signals(),
            ..settings.clone()
        };
        let stepping = Stepping {
            method: settings.method,
            relative_tolerance: (change.tolerance * settings.relative_tolerance).max(TIGHTEST),
            fixed_step: again.fixed_step,
            most_evaluations: Some(self.most),
        };
        Ok(Some(run(self.dynamics, &again, &stepping, self.control)?.recording))
    }

    /// Error of a run over its deviation from a finer repetition by the same method [-], by the channel whose deviations fall least;
    /// `None`: no order is shown.
    fn order(
        &self,
        window: f64,
        settings: &RunSettings,
        recording: &Recording,
        finer: &Recording,
    ) -> Result<Option<f64>, SimulationError> {
        let Ok(Some(coarser)) = or_failure(self.run(window, settings, &COARSER))? else { return Ok(None) };
        let of_finer = twice(recording, finer);
        let ratios = twice(recording, &coarser).into_iter().filter_map(|(channel, coarser)| {
            let (_, finer) = of_finer.iter().find(|(of, _)| *of == channel)?;
            Some(coarser.difference()? / finer.difference()?)
        });
        let least = ratios.fold(f64::INFINITY, f64::min);
        let (by, spacing) = match settings.fixed_step {
            Some(_) if settings.method == Method::SemiImplicit => (COARSER.step, Spacing::Squared),
            Some(_) => (COARSER.step, Spacing::Equal),
            None => (COARSER.tolerance, Spacing::Equal),
        };
        Ok(error_over_deviation(least, by, spacing))
    }
}
