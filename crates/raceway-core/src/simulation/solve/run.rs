//! The main story: equilibrium, integrate, observe.

use std::cell::Cell;
use std::time::Instant;

use crate::numerics::ode::Integrator;
use crate::simulation::error::estimate::{self, LEAST_EVALUATIONS, UNRESOLVED};
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::error::report::MotionKind;
use crate::simulation::error::stationarity;
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::Model;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::{Integrated, STEPS_PER_LOOK, Span, Stepping, integrate};
use crate::simulation::model::observer::Observer;
use crate::simulation::model::terms::{Grounds, Needs};
use crate::simulation::recording::record::Recording;
use crate::simulation::result::metrics::SolverReport;
use crate::simulation::result::run_result::{Account, RunResult};
use crate::simulation::solve::fixed_step::{self, Stepped};
use crate::simulation::solve::ladder::{self};
use crate::simulation::solve::startup::{self, Beginning, Shared};

/// Simulates the scene. Deterministic: the same arguments give the same bits apart from `wall_time`.
pub fn run(scene: &Scene, settings: &RunSettings, control: &Control<'_>) -> Result<RunResult, SimulationError> {
    let begin = Instant::now();
    // A rung that is given up is followed by another: what was told is not taken back.
    let furthest = Cell::new(0.0);
    let progress = |share: f64| {
        furthest.set(f64::max(share, furthest.get()));
        (control.progress)(furthest.get());
    };
    let control = &Control { progress: &progress, ..*control };
    let (reduced, found) = ladder::run(scene, settings, control)?;
    let result = match reduced {
        Some(result) => result,
        // The dynamics have the rest of the progress, so that it does not stand until they have come as far.
        None => control.part((furthest.get(), 1.0), |control| dynamics(scene, settings, &found, begin, control))?,
    };
    (control.progress)(1.0);
    Ok(result)
}

/// The dynamics: settled once, then in steps of a fixed length where these serve, else under error control. `found`: what other rungs
/// have shown.
fn dynamics(
    scene: &Scene,
    settings: &RunSettings,
    found: &[String],
    begin: Instant,
    control: &Control<'_>,
) -> Result<RunResult, SimulationError> {
    let needs = ladder::needs(scene, &settings.outputs, settings.rung, settings.model_tolerance_db)?;
    let model = Model::new(scene, &needs);
    // With all that judgement has left out.
    let whole_needs = ladder::needs(scene, &settings.outputs, settings.rung, 0.0)?;
    let whole_model = (whole_needs != needs).then(|| Model::new(scene, &whole_needs));
    let whole = whole_model.as_ref().map(|model| (model, &whole_needs));
    let whole_or_model = whole_model.as_ref().unwrap_or(&model);
    let shared = Shared::of(scene, whole_or_model, settings);
    let to_come = JUDGED_TIMES * (settings.settle - shared.time + settings.duration);
    let settled = MADE * shared.time / (shared.time + to_come);
    let beginning = control.part((0.0, settled), |control| Beginning::after(&shared, whole_or_model, control))?;
    let setup = Setup { model: &model, needs: &needs, settings, beginning: &beginning, whole };
    let allowed_db = SHARE_OF_ERROR * settings.model_tolerance_db;
    let may_step = fixed_step::may_choose(settings);
    let tells_chaos = !ladder::tilts_late(scene);
    let share = match may_step {
        true if tells_chaos && !model.mechanism().leans() => STEPPED_SHARE,
        true => TRIED_SHARE,
        false => 0.0,
    };
    let stepped = settled + share * (MADE - settled);
    let in_steps =
        control.part((settled, stepped), |control| fixed_step::attempt(&setup, allowed_db, tells_chaos, control))?;
    let in_vain = match in_steps {
        Ok(Stepped { attempt, accuracy, settings, model, needs }) => {
            let setup = Setup { model, needs, settings: &settings, ..setup };
            return summarise(scene, &setup, &attempt, accuracy, (found, None), begin, control);
        }
        Err(why) => Some(why).filter(|_| may_step),
    };
    let tighter = settings.tightened.map(|tolerance| RunSettings { relative_tolerance: tolerance, ..settings.clone() });
    let (setup, made, accuracy) =
        control.part((stepped, MADE), |control| under_error_control(setup, tighter.as_ref(), allowed_db, control))?;
    let setup = Setup { settings, ..setup };
    summarise(scene, &setup, &made, accuracy, (found, in_vain.as_deref()), begin, control)
}

/// The run, made again with all terms, and at a tighter tolerance where it may choose that, until what it states lies within so many
/// decibels; and what it was made with.
fn under_error_control<'a>(
    setup: Setup<'a>,
    tighter: Option<&'a RunSettings>,
    allowed_db: f64,
    control: &Control<'_>,
) -> Result<(Setup<'a>, Attempt, AccuracyReport), SimulationError> {
    let (mut setup, settings) = (setup, setup.settings);
    // Progress counts all that may have to be done: an end that comes early is better than one that stands.
    let attempts = [true, setup.whole.is_some(), tighter.is_some()].into_iter().filter(|may_come| *may_come).count();
    let attempt = |setup: &Setup<'_>, before: usize, most_evaluations: Option<u64>| {
        let part = (before as f64 / attempts as f64, (before + 1) as f64 / attempts as f64);
        control.part(part, |control| {
            let stepping = Stepping { most_evaluations, ..Stepping::of(setup.settings) };
            let first = setup.attempt(&stepping, (0.0, MAIN_SHARE), control)?;
            estimate::judge(setup, first, control)
        })
    };
    // Another one that costs too much is given up: what is known has to do, and says how well.
    let again = |setup: &Setup<'_>, before: usize, made: &Attempt| {
        let most = ATTEMPTING * made.integrated.statistics.rhs_evaluations.max(LEAST_EVALUATIONS);
        match attempt(setup, before, Some(most)) {
            Ok(judged) => Ok(Some(judged)),
            Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
            Err(_) => Ok(None),
        }
    };
    let (mut made, mut accuracy) = attempt(&setup, 0, None)?;
    // A run that has been tightened for the noise of its steps is not run at a looser tolerance again.
    let looser = |made: &Attempt| tighter.filter(|_| made.relative_tolerance == settings.relative_tolerance);
    // Where contacts lean, hardly anything moves, and a loose tolerance may take the noise of its steps for chaos.
    let leans = setup.model.mechanism().leans();
    let believed =
        |accuracy: &AccuracyReport| tighter.is_none() || !leans || accuracy.motion != Some(MotionKind::Diverging);
    let known = |made: &Attempt, accuracy: &AccuracyReport| {
        accuracy.good_as_any(&made.recording, &settings.outputs, allowed_db)
    };
    let serves = |made: &Attempt, accuracy: &AccuracyReport| {
        believed(accuracy) && (known(made, accuracy).is_some() || accuracy.within(&settings.outputs, allowed_db))
    };
    if let Some((model, needs)) = setup.whole
        && !serves(&made, &accuracy)
    {
        // Nobody knows then whether terms or steps are to blame: steps are judged anew, with all terms.
        let unresolved = accuracy.level_error_db().is_some_and(|error| error >= UNRESOLVED);
        let settings = looser(&made).filter(|_| !unresolved).unwrap_or(settings);
        let with_all = Setup { model, needs, settings, whole: None, ..setup };
        if let Some(judged) = again(&with_all, 1, &made)? {
            setup = with_all;
            (made, accuracy) = judged;
        }
    }
    if let Some(tighter) = looser(&made)
        && !serves(&made, &accuracy)
    {
        let tightened = Setup { settings: tighter, whole: None, ..setup };
        if let Some(judged) = again(&tightened, attempts - 1, &made)? {
            setup = tightened;
            (made, accuracy) = judged;
        }
    }
    let accuracy = known(&made, &accuracy).map_or(accuracy, |(known, _)| known);
    Ok((setup, made, accuracy))
}

/// Share of `model_tolerance_db` that the error which a run states may be, before it is made again with all terms, and at a
/// tighter tolerance where it may choose that: the estimate may be off by as much.
const SHARE_OF_ERROR: f64 = 0.5;

/// Another attempt may take this many times the evaluations of the last, and at least so many times this.
const ATTEMPTING: u64 = 5;

/// Progress where a run is made and judged: what is left is for a later stretch, which uneven levels are held against.
const MADE: f64 = 0.9;

/// Times that a run is worth with all that judges it, in progress.
const JUDGED_TIMES: f64 = 5.0;

/// Share of the progress that steps of a fixed length stand for, where they are tried first: most of it where they mostly serve.
const STEPPED_SHARE: f64 = 0.8;
const TRIED_SHARE: f64 = 0.3;

/// Share of the progress that the main integration stands for; the rest judges its accuracy.
pub(crate) const MAIN_SHARE: f64 = 0.85;

/// What is the same in all attempts at a run.
#[derive(Clone, Copy)]
pub(crate) struct Setup<'a> {
    pub model: &'a Model,
    pub needs: &'a Needs,
    pub settings: &'a RunSettings,
    pub beginning: &'a Beginning,
    /// The equations with all that judgement has left out of `model`; `None`: nothing.
    pub whole: Option<(&'a Model, &'a Needs)>,
}

/// The whole run at one tolerance.
pub(crate) struct Attempt {
    pub relative_tolerance: f64,
    pub integrated: Integrated,
    pub recording: Recording,
}

impl Setup<'_> {
    /// Integrates the whole run; `share`: progress at its start and at its end.
    pub fn attempt(
        &self,
        stepping: &Stepping,
        share: (f64, f64),
        control: &Control<'_>,
    ) -> Result<Attempt, SimulationError> {
        let mut observer = Observer::new(self.model, self.needs, self.settings);
        let Beginning { time, state, .. } = self.beginning;
        let span = Span { start: *time, end: observer.end(), checkpoint: self.settings.settle, share };
        let settle = self.settings.settle;
        let mut steps = 0_u64;
        let after_step = |step: &dyn Integrator| {
            observer.after(step);
            steps += 1;
            if steps.is_multiple_of(STEPS_PER_LOOK) {
                let phase = if step.time() < settle { Phase::Settling } else { Phase::Recording };
                (control.live)(&Live { phase, accelerations: &|| observer.accelerations() });
            }
        };
        let integrated = integrate(self.model, state, stepping, &span, control, after_step)?;
        let relative_tolerance = stepping.relative_tolerance;
        Ok(Attempt { relative_tolerance, integrated, recording: observer.finish() })
    }
}

/// `found`: what other rungs have shown; `in_vain`: why steps did not serve.
fn summarise(
    scene: &Scene,
    setup: &Setup<'_>,
    attempt: &Attempt,
    accuracy: AccuracyReport,
    (found, in_vain): (&[String], Option<&str>),
    begin: Instant,
    control: &Control<'_>,
) -> Result<RunResult, SimulationError> {
    let &Setup { model, needs, settings, .. } = setup;
    let main = &attempt.integrated;
    let leaves_plane = || Needs::of(scene, &settings.outputs, None).is_ok_and(|own| own.rung == ModelLevel::Full);
    attempt.recording.evaluate(&settings.outputs);
    let is_steady = scene.operation.speed.is_constant();
    let later =
        |of: &RunSettings| control.part((MADE, 1.0), |control| stationarity::of_dynamics(setup, attempt, of, control));
    let stretches = || stationarity::stretches(needs.rung, &attempt.recording, settings, later);
    let stretches = is_steady.then(stretches).transpose()?;
    let mut check = match needs.rung {
        ModelLevel::Planar if settings.rung.is_some() && leaves_plane() => {
            "planar motion was asked for: what tilt and motion along the axis change here is in no error that is stated"
                .to_owned()
        }
        ModelLevel::Planar => "planar motion: see left_out for why no motion along the axis is needed".to_owned(),
        _ => "the full dynamics: nothing richer to check against".to_owned(),
    };
    let mut left_out = needs.left_out.clone();
    // What the repetition with all terms has shown, of all of them and the integration together, if it is more than was foreseen.
    for (bound, _) in
        left_out.iter_mut().filter(|one| one.by == Grounds::Judgement).filter_map(|one| one.bound.as_mut())
    {
        *bound = bound.max(accuracy.level_error_db().unwrap_or(0.0));
    }
    if setup.whole.is_some() {
        check = format!("{check}; what judgement has left out is in the repetition that tells the error of the level");
    }
    for words in found {
        check = format!("{check}; {words}");
    }
    let solver = SolverReport {
        method: main.choice.method.name(),
        method_reason: reason(setup, attempt, in_vain),
        rung: needs.rung.name(),
        check,
        statistics: setup.beginning.work.and(&main.statistics),
        wall_time: begin.elapsed().as_secs_f64(),
        simulated_time: settings.settle + settings.duration,
        states: model.mechanism().layout.dimension(),
        strips: needs.raceway.strips,
        relative_tolerance: settings.fixed_step.is_none().then_some(attempt.relative_tolerance),
    };
    let (mechanism, recording) = (model.mechanism(), &attempt.recording);
    let accuracy = accuracy.of_stretch(recording, stretches.as_ref(), &settings.outputs);
    // Neither chaos nor what was damped keeps its start.
    let keeps_start = !setup.beginning.is_damped && accuracy.motion != Some(MotionKind::Diverging);
    let rings = || startup::rings_on(scene, settings.settle).or_else(|| startup::cage_rings_on(scene, model, settings));
    let settling = keeps_start.then(rings).flatten();
    let all: Vec<String> = settling.into_iter().chain(startup::tilts_on(scene, needs, settings.settle)).collect();
    let settling = (!all.is_empty()).then(|| all.join("; "));
    let account = Account { solver, accuracy, scatter: stretches.map(|of| of.scatter), settling, left_out };
    Ok(RunResult::new(scene, settings, mechanism, recording, account))
}

/// Why this method, and why another tolerance than the one asked for. `in_vain`: why steps of a fixed length, tried before, did not serve.
fn reason(setup: &Setup<'_>, attempt: &Attempt, in_vain: Option<&str>) -> String {
    let &Setup { settings, beginning, .. } = setup;
    let method = attempt.integrated.choice.reason.clone().unwrap_or_else(|| "asked for".into());
    let method = match beginning.work.steps {
        0 => method,
        steps => {
            let step = 1e6 * beginning.work.advanced / steps as f64;
            let damped = if beginning.is_damped { ", damped at first" } else { "" };
            format!("{method}; settled once{damped}, over the first {:.3} s, in steps of {step:.2} µs", beginning.time)
        }
    };
    let (asked, taken) = (settings.relative_tolerance, attempt.relative_tolerance);
    let method = match in_vain {
        Some(why) => format!("steps of a fixed length did not serve ({why}); {method}"),
        None => method,
    };
    if settings.tightened == Some(taken) {
        format!("{method}; tolerance {taken:.0e}, for at {asked:.0e} the level was not certain enough")
    } else if settings.tightened.is_some() && taken == asked {
        format!("{method}; tolerance {taken:.0e}, for the level needs no tighter one")
    } else if taken == asked {
        method
    } else {
        format!("{method}; tolerance {taken:.0e} for {asked:.0e}, which left more noise than level")
    }
}
