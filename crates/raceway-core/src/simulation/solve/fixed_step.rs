//! The dynamics in steps of a fixed length, where `auto` may choose: tried first, for they take a fraction of what error control
//! takes, and kept where a quarter of the step tells the same level.

use crate::numerics::ode::Method;
use crate::simulation::error::estimate::{self, FORGETS};
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::error::report::MotionKind;
use crate::simulation::input::control::Control;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::Model;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::model::terms::Needs;
use crate::simulation::solve::run::{Attempt, MAIN_SHARE, Setup};

/// First step that is tried [s]: levels of the article's bearing err by 0.02 dB at most.
pub const STEP: f64 = 7.5e-6;
/// The same where the spindle moves along the axis, whose contacts lean with it: three quarters, for errors like those.
const AXIAL_STEP: f64 = 5.5e-6;
/// Step by which a reduced rung is checked [s]: half of the first, a fifth of its error.
const CHECKING_STEP: f64 = 0.5 * STEP;
/// Shortest step that is tried [s]: below it error control takes no longer.
const SHORTEST: f64 = 1e-6;
/// Order by which the error falls with the step, rounded down, and share of the allowed error that the next step aims at.
const ORDER: f64 = 2.0;
const AIM: f64 = 0.5;
/// The next step over the last, at most, and after steps that blew up.
const LARGEST_CHANGE: f64 = 0.75;
const SHORTENED: f64 = 0.5;
/// Attempts, the first one included: progress before each, and what each adds.
const PROGRESS: [(f64, f64); 3] = [(0.0, 0.8), (0.8, 0.1), (0.9, 0.1)];

/// Whether steps are tried: where the method is free and no tolerance was asked for.
pub fn may_choose(settings: &RunSettings) -> bool {
    settings.method == Method::Auto && settings.fixed_step.is_none() && settings.tightened.is_some()
}

/// Whether steps are tried of these equations.
pub(crate) fn serves(model: &Model, settings: &RunSettings) -> bool {
    may_choose(settings) && model.mechanism().raceway.inner.is_damped()
}

/// Steps to get to a later time by, the longest first: where they blow up, shorter ones mostly do not.
pub(crate) fn lengths(model: &Model) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(first_step(model)), |step| Some(SHORTENED * step)).take_while(|step| *step >= SHORTEST)
}

/// In steps of a length [s].
pub(crate) fn by(step: f64) -> Stepping {
    Stepping { method: Method::SemiImplicit, relative_tolerance: 0.0, fixed_step: Some(step), most_evaluations: None }
}

/// [s]
fn first_step(model: &Model) -> f64 {
    if model.mechanism().layout.axial_spindle { AXIAL_STEP } else { STEP }
}

/// The run by which a reduced rung is checked, in steps; `None`: not where a tolerance was asked for.
pub(crate) fn checking(settings: &RunSettings) -> Option<RunSettings> {
    may_choose(settings).then(|| in_steps(settings, CHECKING_STEP))
}

/// The same run in steps of a length [s].
fn in_steps(settings: &RunSettings, step: f64) -> RunSettings {
    RunSettings { method: Method::SemiImplicit, fixed_step: Some(step), tightened: None, ..settings.clone() }
}

/// Progress within an attempt whose motion has turned out to be chaotic.
const JUDGED: f64 = 0.6;
/// How often it is made again, each in half of the step.
const SAMPLES: i32 = 2;
/// Most growth of a disturbance in one step [e-folds] that is taken for chaos: beyond the limit of stability it grows many times as
/// fast.
const SLOW_GROWTH: f64 = 0.05;

/// Chaos: nothing is left to compare but statistics. The run is made again in half of the step [s], with all terms, and is the result where
/// both samples show the same levels; else in half of that, as long runs ask for, whose levels scatter less than steps change
/// them. Else why error control has to: so it has where contacts lean, whose light oscillations all steps may have damped.
fn another_sample<'a>(
    setup: &Setup<'a>,
    step: f64,
    mut before: Attempt,
    judged: &AccuracyReport,
    allowed_db: f64,
    control: &Control<'_>,
) -> Result<Result<Stepped<'a>, String>, SimulationError> {
    let grows_slowly = judged.divergence_rate * step < SLOW_GROWTH;
    let forgets = judged.divergence_rate * setup.settings.duration > FORGETS;
    if let Some((what, _)) = judged.in_doubt(&setup.settings.outputs) {
        return Ok(Err(what));
    }
    if setup.model.mechanism().leans() || !grows_slowly || !forgets {
        let why = match (grows_slowly, forgets) {
            (false, _) => "motions that start next to each other part faster than chaos has them part",
            (true, false) => "disturbances grow, but the run is too short to be a sample of chaos",
            (true, true) => "disturbances do not die out, and contacts lean along the axis",
        };
        return Ok(Err(why.into()));
    }
    let (model, needs) = setup.whole.unwrap_or((setup.model, setup.needs));
    for halvings in 1..=SAMPLES {
        let settings = in_steps(setup.settings, step / f64::from(1 << halvings));
        let sample = Setup { model, needs, settings: &settings, whole: None, beginning: setup.beginning };
        let share = |samples: i32| f64::from((1 << samples) - 1) / f64::from((1 << SAMPLES) - 1);
        let attempt = match sample.attempt(&Stepping::of(&settings), (share(halvings - 1), share(halvings)), control) {
            Ok(attempt) => attempt,
            Err(stopped @ SimulationError::Stopped { .. }) => return Err(stopped),
            Err(error) => return Ok(Err(error.to_string())),
        };
        if let Some(accuracy) = estimate::of_samples(&before.recording, &attempt.recording, judged, allowed_db) {
            let because =
                "the motion is chaotic and shows the same levels, to three standard errors, in twice the step";
            return Ok(Ok(Stepped { attempt: kept(attempt, because), accuracy, settings, model, needs }));
        }
        before = attempt;
    }
    Ok(Err("the motion is chaotic, and shows other levels in other steps".into()))
}

/// With the reason why it serves.
fn kept(mut attempt: Attempt, because: &str) -> Attempt {
    if let Some(reason) = &mut attempt.integrated.choice.reason {
        reason.push_str(&format!(", and kept because {because}"));
    }
    attempt
}

/// A run in steps that serve.
pub(crate) struct Stepped<'a> {
    pub attempt: Attempt,
    pub accuracy: AccuracyReport,
    pub settings: RunSettings,
    /// The equations that ran.
    pub model: &'a Model,
    pub needs: &'a Needs,
}

/// A run in steps that serve, or why error control has to. `allowed_db`: error of the level that serves, as stated; `tells_chaos`: whether
/// a motion that is chaotic in steps is believed to be.
pub(crate) fn attempt<'a>(
    setup: &Setup<'a>,
    allowed_db: f64,
    tells_chaos: bool,
    control: &Control<'_>,
) -> Result<Result<Stepped<'a>, String>, SimulationError> {
    if !may_choose(setup.settings) {
        return Ok(Err("a method, a step or a tolerance was asked for".into()));
    }
    if !serves(setup.model, setup.settings) {
        return Ok(Err("what rings undamped rings on, but not in long steps, whatever part of them".into()));
    }
    let mut beyond = String::new();
    let Some(mut step) = setup.beginning.step else {
        return Ok(Err("however short, they blow up while the run settles".into()));
    };
    let mut parts = PROGRESS.into_iter().enumerate();
    let mut next = parts.next();
    while let Some((number, (before, part))) = next {
        let settings = in_steps(setup.settings, step);
        // The repetition at a quarter of the step takes about as long as the run.
        let later = |share: f64| (share - MAIN_SHARE) / (1.0 - MAIN_SHARE);
        let halves = |share: f64| if share < MAIN_SHARE { 0.5 * share / MAIN_SHARE } else { 0.5 + 0.5 * later(share) };
        let progress = |share: f64| (control.progress)(before + part * halves(share));
        let judging = &Control { progress: &progress, ..*control };
        // Where the first did not serve, nobody knows whether steps or terms left out are to blame: both are mended.
        let (model, needs, whole) = match setup.whole.filter(|_| number > 0) {
            Some((model, needs)) => (model, needs, None),
            None => (setup.model, setup.needs, setup.whole),
        };
        let tried = Setup { model, needs, settings: &settings, whole, beginning: setup.beginning };
        let judged = tried
            .attempt(&Stepping::of(&settings), (0.0, MAIN_SHARE), judging)
            .and_then(|first| estimate::judge(&tried, first, judging));
        let (attempt, accuracy) = match judged {
            Ok(judged) => judged,
            Err(stopped @ SimulationError::Stopped { .. }) => return Err(stopped),
            // What is too stiff for the step blows up, mostly soon.
            Err(_) if SHORTENED * step >= SHORTEST => {
                step *= SHORTENED;
                continue;
            }
            Err(error) => return Ok(Err(error.to_string())),
        };
        next = parts.next();
        if accuracy.motion == Some(MotionKind::Diverging) {
            if !tells_chaos {
                let why = "the motion seems chaotic in them, and where a viscous lubricant lets cage and balls tilt it may not be";
                return Ok(Err(why.into()));
            }
            return control.part((before + part * JUDGED, before + part), |control| {
                another_sample(setup, step, attempt, &accuracy, allowed_db, control)
            });
        }
        let Some(excess) = accuracy.excess(&settings.outputs, allowed_db) else {
            return Ok(Err(accuracy.in_doubt(&settings.outputs).map_or(accuracy.how, |(what, _)| what)));
        };
        if let Some((accuracy, because)) = accuracy.good_as_any(&attempt.recording, &settings.outputs, allowed_db) {
            return Ok(Ok(Stepped { attempt: kept(attempt, because), accuracy, settings, model, needs }));
        }
        if let Some((what, _)) = accuracy.in_doubt(&settings.outputs) {
            return Ok(Err(what));
        }
        beyond = accuracy.words_beyond(&settings.outputs, allowed_db);
        step *= (AIM / excess).powf(1.0 / ORDER).min(LARGEST_CHANGE);
        if step < SHORTEST {
            break;
        }
    }
    Ok(Err(format!("a quarter of the step tells more than is allowed: {beyond}")))
}
