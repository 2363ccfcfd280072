//! The main story: equilibrium, integrate, observe.

use std::cell::Cell;
use std::time::Instant;

use super::accuracy::{self, LEAST_EVALUATIONS, UNRESOLVED};
use super::channel::Channel;
use super::distance::LevelErrors;
use super::equilibrium::equilibrium;
use super::ladder;
pub use super::ladder::Rung;
use super::metrics::{self, AccuracyReport, MotionKind, SolverReport, Summary};
use super::model::{Mechanism, Model};
use super::needs::{Grounds, LeftOut, Needs, Unmet};
use super::observe::{Observer, Recording};
use super::scene::Scene;
use super::settling::{self, Beginning, Shared};
use super::state::{BallState, Layout, SpindleState};
use super::stepped::{self, Stepped};
use super::views::Views;
pub use crate::numerics::ode::Method;
use crate::numerics::ode::stability::{self, StabilityWatch};
use crate::numerics::ode::{Choice, IntegrationError, Integrator, Statistics};
use crate::numerics::spectrum::Spectrum;

/// What a run must produce; it decides what the model must contain.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    pub vibration: bool,
    pub contacts: bool,
    pub cage: bool,
    /// Amplitude and envelope spectra of these.
    pub spectra: Vec<Channel>,
    /// Full time series of these.
    pub series: Vec<Channel>,
}

impl Outputs {
    /// Whether any signal is kept; what pictures show is kept with them.
    pub fn keep_signals(&self) -> bool {
        !(self.spectra.is_empty() && self.series.is_empty())
    }
}

/// How to simulate. Times in seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    pub method: Method,
    pub rung: Option<Rung>,
    pub relative_tolerance: f64,
    /// The tolerance that is taken instead, and the run made again, where `model_tolerance_db` or a load or speed that is
    /// asked for turns out to need it; `None`: the tolerance stands.
    pub tightened: Option<f64>,
    /// How much a level may change by what is left out by judgement [dB]; 0: identities and conventions only.
    pub model_tolerance_db: f64,
    /// Step without error control [s]; only for methods that take fixed steps.
    pub fixed_step: Option<f64>,
    /// Simulated before anything is kept.
    pub settle: f64,
    /// Simulated and kept.
    pub duration: f64,
    pub outputs: Outputs,
}

impl RunSettings {
    /// The tightest relative tolerance that the run may take by itself.
    pub fn tightest(&self) -> f64 {
        self.tightened.unwrap_or(self.relative_tolerance)
    }
}

/// How a run talks to whoever waits for it.
pub struct Control<'a> {
    /// Looked at every few hundred steps; true ends the run.
    pub stop: &'a dyn Fn() -> bool,
    /// Told the finished share, 0–1, every few hundred steps.
    pub progress: &'a dyn Fn(f64),
    /// Shown how the run goes, every few hundred steps.
    pub live: &'a dyn Fn(&Live<'_>),
}

impl<'a> Control<'a> {
    /// Nobody looks on.
    pub const fn until(stop: &'a dyn Fn() -> bool) -> Self {
        Self { stop, progress: &|_| (), live: &|_| () }
    }

    /// The same for a run whose levels are not those of the result.
    pub fn aside(&self) -> Self {
        Self { live: &|_| (), ..*self }
    }
}

/// What a run is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// A reduced rung beside a richer one.
    Checking,
    /// Before anything is kept.
    Settling,
    /// What the result is made of.
    Recording,
    /// How far the result can be trusted.
    Judging,
}

/// How a run goes.
pub struct Live<'a> {
    pub phase: Phase,
    /// rms of the spindle's accelerations in y and z [m/s²] over what has been kept in this window, above the band, too; `None` before. Computed when it
    /// is asked for.
    pub accelerations: &'a dyn Fn() -> Option<[f64; 2]>,
}

impl Live<'static> {
    /// Of a phase that keeps nothing.
    pub fn of(phase: Phase) -> Self {
        Self { phase, accelerations: &|| None }
    }
}

/// A signal at a uniform rate, in the channel's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub channel: Channel,
    /// Time of the first value since the start of the run [s].
    pub start: f64,
    /// Time between values [s].
    pub step: f64,
    pub values: Vec<f64>,
}

/// Spectra of one channel, in the channel's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelSpectra {
    pub channel: Channel,
    pub amplitude: Spectrum,
    pub envelope: Spectrum,
}

/// All that a run leaves behind.
#[derive(Debug, Clone, PartialEq)]
pub struct RunResult {
    pub summary: Summary,
    pub spectra: Vec<ChannelSpectra>,
    pub series: Vec<Series>,
    /// For pictures, where any signal is asked for.
    pub views: Views,
    pub left_out: Vec<LeftOut>,
}

/// Why a run failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// The scene cannot be given what the request chose.
    #[error(transparent)]
    Unmet(#[from] Unmet),
    /// A reduced rung cannot represent the scene, or not this motion of it.
    #[error("the rung {rung} does not serve: {reason}")]
    Unable { rung: &'static str, reason: String },
    #[error("no static equilibrium was found to start from: {0}")]
    NoEquilibrium(String),
    #[error("{source} ({entry})")]
    Integration {
        source: IntegrationError,
        /// The state component in words, such as "radial velocity of ball 3".
        entry: String,
    },
    /// At the pace so far the run would never end.
    #[error(
        "given up at t = {time:e} s of {end} s: steps of {step:.1e} s in the mean would take some {evaluations:.0e} evaluations of \
         the equations, more than {MOST_EVALUATIONS:.0e}"
    )]
    Endless { time: f64, end: f64, step: f64, evaluations: f64 },
    /// `Control::stop` asked for it.
    #[error("stopped at t = {time} s")]
    Stopped { time: f64 },
    /// It took more evaluations of the equations than it may.
    #[error("stopped at t = {time} s after {evaluations} evaluations of the equations")]
    Exhausted { time: f64, evaluations: u64 },
}

/// Evaluations of a run that count as endless: more than a day of one core.
const MOST_EVALUATIONS: f64 = 3e10;
/// Evaluations before that is judged, so that a rough start is forgiven.
const PACE: u64 = 2_000_000;
/// Steps between two looks at `Control`.
pub(super) const STEPS_PER_LOOK: u64 = 256;
/// Evaluations between two looks at `Control`: a step of an implicit method takes many.
const EVALUATIONS_PER_LOOK: u64 = 6 * STEPS_PER_LOOK;

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
    if let Some(result) = reduced {
        (control.progress)(1.0);
        return Ok(result);
    }
    // The dynamics have the rest of the progress, so that it does not stand until they have come as far.
    let before = furthest.get();
    let rest = |share: f64| (control.progress)(before + (1.0 - before) * share);
    let control = &Control { progress: &rest, ..*control };
    let needs = ladder::needs(scene, &settings.outputs, settings.rung, settings.model_tolerance_db)?;
    let model = Model::new(scene, &needs);
    // With all that judgement has left out.
    let whole_needs = ladder::needs(scene, &settings.outputs, settings.rung, 0.0)?;
    let whole_model = (whole_needs != needs).then(|| Model::new(scene, &whole_needs));
    let whole = whole_model.as_ref().map(|model| (model, &whole_needs));
    let whole_or_model = whole_model.as_ref().unwrap_or(&model);
    let shared = Shared::of(scene, whole_or_model, settings);
    let to_come = JUDGED_TIMES * (settings.settle - shared.time + settings.duration);
    let settled = shared.time / (shared.time + to_come);
    let settling = |share: f64| (control.progress)(settled * share);
    let settling = &Control { progress: &settling, ..*control };
    let beginning = Beginning::after(&shared, whole_or_model, settling)?;
    let rest = |share: f64| (control.progress)(settled + (1.0 - settled) * share);
    let control = &Control { progress: &rest, ..*control };
    let tighter = settings.tightened.map(|tolerance| RunSettings { relative_tolerance: tolerance, ..settings.clone() });
    // Progress counts all that may have to be done: an end that comes early is better than one that stands.
    let attempts = [true, whole.is_some(), tighter.is_some()].into_iter().filter(|may_come| *may_come).count() as f64;
    let mut setup = Setup { model: &model, needs: &needs, settings, beginning: &beginning, whole };
    // Most of the progress: it mostly serves.
    let allowed_db = SHARE_OF_ERROR * settings.model_tolerance_db;
    let stepped_share = if stepped::may_choose(settings) { STEPPED_SHARE } else { 0.0 };
    let progress = |share: f64| (control.progress)(stepped_share * share);
    let in_steps = &Control { progress: &progress, ..*control };
    let in_vain = match stepped::attempt(&setup, allowed_db, !ladder::tilts_late(scene), in_steps)? {
        Ok(Stepped { attempt, accuracy, settings, model, needs }) => {
            (control.progress)(1.0);
            setup = Setup { model, needs, settings: &settings, ..setup };
            return Ok(summarise(scene, &setup, &attempt, accuracy, (&found, None), begin));
        }
        Err(why) => Some(why).filter(|_| stepped::may_choose(settings)),
    };
    let attempt = |setup: &Setup<'_>, before: f64, most_evaluations: Option<u64>| {
        let progress =
            |share: f64| (control.progress)(stepped_share + (1.0 - stepped_share) * (before + share) / attempts);
        let control = &Control { progress: &progress, ..*control };
        let stepping = Stepping { most_evaluations, ..Stepping::of(setup.settings) };
        let first = setup.attempt(&stepping, (0.0, MAIN_SHARE), control)?;
        accuracy::judge(setup, first, control)
    };
    // Another one that costs too much is given up: what is known has to do, and says how well.
    let again = |setup: &Setup<'_>, before: f64, made: &Attempt| {
        let most = ATTEMPTING * made.integrated.statistics.rhs_evaluations.max(LEAST_EVALUATIONS);
        match attempt(setup, before, Some(most)) {
            Ok(judged) => Ok(Some(judged)),
            Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
            Err(_) => Ok(None),
        }
    };
    let (mut made, mut accuracy) = attempt(&setup, 0.0, None)?;
    // A run that has been tightened for the noise of its steps is not run at a looser tolerance again.
    let looser = |made: &Attempt| tighter.as_ref().filter(|_| made.relative_tolerance == settings.relative_tolerance);
    // Where contacts lean, hardly anything moves, and a loose tolerance may take the noise of its steps for chaos.
    let believed = |accuracy: &AccuracyReport| {
        tighter.is_none() || !model.mechanism().leans() || accuracy.motion != Some(MotionKind::Diverging)
    };
    let serves = |accuracy: &AccuracyReport| believed(accuracy) && accuracy.within(&settings.outputs, allowed_db);
    if let Some((model, needs)) = whole
        && !serves(&accuracy)
    {
        // Nobody knows then whether terms or steps are to blame: steps are judged anew, with all terms.
        let unresolved = accuracy.level_error_db().is_some_and(|error| error >= UNRESOLVED);
        let settings = looser(&made).filter(|_| !unresolved).unwrap_or(settings);
        let with_all = Setup { model, needs, settings, whole: None, ..setup };
        if let Some(judged) = again(&with_all, 1.0, &made)? {
            setup = with_all;
            (made, accuracy) = judged;
        }
    }
    if let Some(tighter) = looser(&made)
        && !serves(&accuracy)
    {
        let tightened = Setup { settings: tighter, whole: None, ..setup };
        if let Some(judged) = again(&tightened, attempts - 1.0, &made)? {
            setup = tightened;
            (made, accuracy) = judged;
        }
    }
    (control.progress)(1.0);
    Ok(summarise(scene, &Setup { settings, ..setup }, &made, accuracy, (&found, in_vain.as_deref()), begin))
}

/// Share of `model_tolerance_db` that the error which a run states may be, before it is made again with all terms, and at a
/// tighter tolerance where it may choose that: the estimate may be off by as much.
const SHARE_OF_ERROR: f64 = 0.5;

/// Another attempt may take this many times the evaluations of the last, and at least so many times this.
const ATTEMPTING: u64 = 30;

/// Times that a run is worth with all that judges it, in progress.
const JUDGED_TIMES: f64 = 5.0;

/// Share of the progress that steps of a fixed length stand for, where they are tried first.
const STEPPED_SHARE: f64 = 0.8;

/// Share of the progress that the main integration stands for; the rest judges its accuracy.
pub(super) const MAIN_SHARE: f64 = 0.85;

/// Equilibrium of spindle and balls under load, gravity and centrifugal force; cage centred, ideal orbit and rolling.
pub fn start_state(model: &Model) -> Result<Vec<f64>, SimulationError> {
    let mechanism = model.mechanism();
    let layout = mechanism.layout;
    let rest = equilibrium(mechanism, mechanism.speed.at(0.0).1)?;
    let mut state = vec![0.0; layout.dimension()];
    for (ball, &(axial, radial)) in rest.balls.iter().enumerate() {
        layout.set_ball(&mut state, ball, &BallState { axial, radial, ..BallState::default() });
    }
    layout.set_spindle(&mut state, &SpindleState { position: rest.spindle, velocity: [0.0; 3] });
    Ok(state)
}

/// What is the same in all attempts at a run.
#[derive(Clone, Copy)]
pub(super) struct Setup<'a> {
    pub model: &'a Model,
    pub needs: &'a Needs,
    pub settings: &'a RunSettings,
    pub beginning: &'a Beginning,
    /// The equations with all that judgement has left out of `model`; `None`: nothing.
    pub whole: Option<(&'a Model, &'a Needs)>,
}

/// The whole run at one tolerance.
pub(super) struct Attempt {
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

/// By which method, and how finely.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stepping {
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
pub(super) struct Span {
    pub start: f64,
    pub end: f64,
    /// The state at this time is kept.
    pub checkpoint: f64,
    /// Progress at its start and at its end.
    pub share: (f64, f64),
}

/// What an integration leaves behind.
pub(super) struct Integrated {
    pub statistics: Statistics,
    /// What ran at the end.
    pub choice: Choice,
    /// State at the checkpoint.
    pub checkpoint: Vec<f64>,
    /// In words, where a fixed step lies beyond the limit of stability.
    pub unstable: Option<String>,
}

/// Times at which steps end exactly: kinks of the speed between two times, and the later one [s].
pub(super) fn stops(model: &Model, from: f64, to: f64) -> Vec<f64> {
    let kinks = model.mechanism().speed.kinks().filter(|kink| *kink > from && *kink < to);
    kinks.chain([to]).collect()
}

/// Integrates a span, showing the integrator to `after_step` after each step. Steps end exactly where
/// the speed profile has a kink, and the method starts afresh there.
pub(super) fn integrate(
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

/// `found`: what other rungs have shown; `in_vain`: why steps did not serve.
fn summarise(
    scene: &Scene,
    setup: &Setup<'_>,
    attempt: &Attempt,
    accuracy: AccuracyReport,
    (found, in_vain): (&[String], Option<&str>),
    begin: Instant,
) -> RunResult {
    let &Setup { model, needs, settings, .. } = setup;
    let main = &attempt.integrated;
    let leaves_plane = || Needs::of(scene, &settings.outputs, None).is_ok_and(|own| own.rung == Rung::Full);
    let mut check = match needs.rung {
        Rung::Planar if settings.rung.is_some() && leaves_plane() => {
            "planar motion was asked for: what tilt and motion along the axis change here is in no error that is stated"
                .to_owned()
        }
        Rung::Planar => "planar motion: see left_out for why no motion along the axis is needed".to_owned(),
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
    recording.evaluate(&settings.outputs);
    let accuracy = accuracy.of_stretch(recording, scene.operation.speed.is_constant());
    let mut result = RunResult::new(scene, settings, mechanism, recording, solver, accuracy, left_out);
    let rings = || settling::cage_rings_on(scene, model, settings.settle);
    let settling = result.summary.settling.take().or_else(rings);
    // Neither chaos nor what was damped keeps its start.
    let forgets = setup.beginning.is_damped || result.summary.accuracy.motion == Some(MotionKind::Diverging);
    result.summary.settling = settling.filter(|_| !forgets);
    result
}

impl RunResult {
    /// Everything that the outputs ask for, from what a run has shown.
    pub(super) fn new(
        scene: &Scene,
        settings: &RunSettings,
        mechanism: &Mechanism,
        recording: &Recording,
        solver: SolverReport,
        accuracy: AccuracyReport,
        left_out: Vec<LeftOut>,
    ) -> Self {
        let outputs = &settings.outputs;
        let channels = || if outputs.vibration { metrics::vibration(recording) } else { Vec::new() };
        let (balls, is_steady) = (scene.bearing.parameters.ball_count, scene.operation.speed.is_constant());
        let views = || Views::of(recording, balls, is_steady);
        let (spectra, views) = match outputs.keep_signals() {
            true => (metrics::spectra(recording, settings), views()),
            false => (Vec::new(), Views::default()),
        };
        let frequencies = metrics::frequencies(scene, recording);
        // The rung that repeats a passage has no start, and chaos forgets it by itself.
        let starts = solver.rung != Rung::Periodic.name() && accuracy.motion != Some(MotionKind::Diverging);
        let summary = Summary {
            scatter: if is_steady { accuracy::scatter(recording) } else { LevelErrors::default() },
            settling: starts.then(|| settling::rings_on(scene, settings.settle)).flatten(),
            channels: channels(),
            contacts: outputs.contacts.then(|| metrics::contacts(mechanism, recording)),
            cage: if outputs.cage { metrics::cage(scene, recording) } else { None },
            frequencies,
            lines: if outputs.vibration { metrics::lines(scene, &spectra, &frequencies) } else { Vec::new() },
            solver,
            accuracy,
        };
        Self { summary, spectra, series: metrics::series(recording, settings), views, left_out }
    }
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

impl SimulationError {
    /// The same with a cause that is known.
    fn because(self, cause: Option<String>) -> Self {
        match (self, cause) {
            (Self::Integration { source, entry }, Some(cause)) => {
                Self::Integration { source, entry: format!("{entry}; {cause}") }
            }
            (error, _) => error,
        }
    }

    pub(super) fn integration(source: IntegrationError, layout: &Layout) -> Self {
        let component = match source {
            IntegrationError::Stopped { time } => return Self::Stopped { time },
            IntegrationError::StepTooSmall { component, .. } | IntegrationError::NotFinite { component, .. } => {
                component
            }
        };
        Self::Integration { entry: layout.name(component), source }
    }
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
        assert!(words.contains("given up at t = 1e-9 s of 0.1 s") && words.contains("3e14 evaluations"), "{words}");
        // Not even a number that says how far it is.
        assert!(endless(&work(3_000_000), 0.0, &span).is_err());
    }
}
