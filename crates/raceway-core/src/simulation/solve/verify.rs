//! One comparison: what a run deviates by from its reference, and whether that covers the run.

use std::rc::Rc;

use crate::numerics::ode::Method;
use crate::simulation::error::codes::{ErrorBasis, Gap, Refinement};
use crate::simulation::error::comparison::{Deviation, level_errors, quantity_errors, twice};
use crate::simulation::error::lyapunov::{self, DivergenceEstimate, MotionKind, Pairs};
use crate::simulation::error::stationarity::{is_stationary, scattering_level};
use crate::simulation::error::thresholds::{
    BALL_DRIFT, CAGE_SPEED_CHANGE, DIVERGENCE_CAGE_TURNS, IN_PLANE_SINE, INERTIA_OVER_PRELOAD, LEAVING_PLANE_PER_S,
    LEAVING_WINDOW_S, LONG_WINDOW_S, MIN_DECAY_EFOLDS, MIN_WINDOW_SETTLE_S, OUT_OF_PLANE_SINE, WINDOW_PASSAGES,
};
use crate::simulation::input::channel::Channel;
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::condensed_contact;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::model::radially_condensed::{self, RadiallyCondensed};
use crate::simulation::model::system::Model;
use crate::simulation::recording::record::{Quantities, Recording};
use crate::simulation::recording::sampling::{ACCELERATIONS, RATE, REPEATED, kept_values};
use crate::simulation::recording::windows::Windows;
use crate::simulation::solve::attempt::{
    Attempt, Dynamics, MIN_EVALUATIONS, Problem, record, run, window_settings, without_signals,
};
use crate::simulation::solve::eligibility::{ball_passage, tilt_risk, window_time};
use crate::simulation::solve::fixed_step;
use crate::simulation::solve::plan::{Candidate, Reference};
use crate::simulation::solve::startup::InitialState;

/// Window of the leanest models, whose richer model costs little, over that of the condensed one [-].
const LEAN_WINDOW: f64 = 2.0;
/// Relative tolerance of the dynamics that verify a reduced model [-]; errs by some 2e-4 dB.
const WINDOW_TOLERANCE: f64 = 1e-4;
/// Initial distance of two trajectories [m], and the size of the spindle's displacements [m].
const DISPLACEMENT: f64 = 1e-10;
const STATIC_DISPLACEMENT: f64 = 1e-6;
/// Step of a repetition over that of a run in steps of a fixed length [-]. Long steps of `semi_implicit` damp light oscillations above the
/// band as half of them do, and a quarter shows it.
const HALF_STEP: f64 = 0.5;
const QUARTER_STEP: f64 = 0.25;
/// Tolerance of a repetition over that of the run [-], and the tightest that double precision resolves.
const TIGHTER: f64 = 0.1;
pub(crate) const TIGHTEST: f64 = 1e-13;
/// Fewest values that are compared.
pub(crate) const MIN_VALUES: usize = 200;
/// Evaluations of a verification over those of the run, at most [-].
const MOST_EVALUATIONS: u64 = 10;

/// What a comparison has shown.
#[derive(Debug, Default)]
pub(crate) struct Verification {
    /// `None`: unknown.
    pub deviation: Option<Deviation>,
    pub basis: ErrorBasis,
    pub divergence: Option<DivergenceEstimate>,
    /// Rms of the difference of the signals over that of the run [-].
    pub noise: f64,
    /// The whole recorded time was repeated.
    pub is_whole: bool,
    /// What the window does not cover.
    pub gap: Option<Gap>,
    /// Deviation of the whole run in finer steps.
    pub course: Option<Deviation>,
    /// The repetition failed.
    pub failure: Option<SimulationError>,
    /// Only a part [s] could be repeated, and why.
    pub part: Option<(f64, SimulationError)>,
}

impl Verification {
    pub fn motion(&self) -> Option<MotionKind> {
        self.divergence.and_then(|divergence| divergence.motion())
    }

    pub fn is_chaotic(&self) -> bool {
        self.motion() == Some(MotionKind::Diverging)
    }
}

/// Compares an attempt with its reference.
pub(crate) fn verify(
    candidate: &Candidate,
    attempt: &Attempt,
    previous: Option<&(Rc<Attempt>, Verification)>,
    problem: &Problem<'_>,
    control: &Control<'_>,
) -> Result<Verification, SimulationError> {
    (control.live)(&Live::of(Phase::Judging));
    let control = &control.without_live();
    match (candidate.reference, previous) {
        (Reference::RicherModel, _) => by_richer_model(candidate.level, attempt, problem, control),
        (Reference::IndependentSample, Some((before, verified))) => Ok(Verification {
            deviation: Some(Deviation::of_samples(&before.recording, &attempt.recording)),
            basis: ErrorBasis::BatchMeans { refinement: Refinement::Step(1.0 / HALF_STEP) },
            divergence: verified.divergence,
            is_whole: true,
            ..Verification::default()
        }),
        (Reference::LooserRun, Some((before, verified))) => {
            let tolerance = attempt.tolerance.unwrap_or(TIGHTEST);
            let recorded = problem.settings.duration;
            let refinement = Refinement::Tolerance(tolerance, problem.settings.method);
            Ok(Verification {
                deviation: Some(Deviation::of_runs(&before.recording, &attempt.recording)),
                basis: ErrorBasis::Repetition { refinement, window: recorded, recorded },
                divergence: verified.divergence,
                is_whole: true,
                ..Verification::default()
            })
        }
        _ => by_refinement(attempt, problem, control),
    }
}

/// A result, or why there is none: a run is not lost because its verification fails. Only a stop is passed on.
pub(crate) fn or_failure<T>(result: Result<T, SimulationError>) -> Result<Result<T, SimulationError>, SimulationError> {
    match result {
        Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
        result => Ok(result),
    }
}

// --- a reduced model against a richer one ---------------------------------------------------------------------------------

fn by_richer_model(
    level: ModelLevel,
    attempt: &Attempt,
    problem: &Problem<'_>,
    control: &Control<'_>,
) -> Result<Verification, SimulationError> {
    let Problem { scene, settings, .. } = *problem;
    let is_condensed = level == ModelLevel::RadiallyCondensed;
    let stepped = RunSettings { fixed_step: attempt.step, ..settings.clone() };
    let short = window_of(level, scene, settings);
    let window = short.duration;
    let windowed = control.part((0.0, 0.5), |control| compare_window(level, &short, attempt, problem, control));
    let compared = match or_failure(windowed)? {
        Ok(compared) => compared,
        Err(failure) => return Ok(Verification { failure: Some(failure), ..Verification::default() }),
    };
    let Compared { mut deviation, own, richer, richer_level, leaves } = compared;
    let whole = is_condensed && !is_stationary(&attempt.recording, &settings.outputs, settings.model_tolerance_db);
    // The whole time where the motion is neither periodic nor stationary.
    let mut course = None;
    if is_condensed {
        let finer = |settings: &RunSettings| finer_run(scene, settings, &stepped, control);
        if whole {
            let finer = or_failure(control.part((0.5, 0.75), |_| finer(settings)))?.ok().flatten();
            let of = |finer: &Recording| Deviation::of_recordings(&attempt.recording, finer, 0.0);
            course = finer.as_ref().map(|finer| of(finer).of_asked(&settings.outputs));
        } else {
            if let Some(by_steps) = attempt.step_deviation {
                deviation = deviation.larger(&by_steps);
            } else if let Some(finer) = or_failure(finer(&short))?.ok().flatten() {
                let by_steps = Deviation::of_recordings(&own, &finer, 0.0).of_asked(&settings.outputs);
                deviation = deviation.larger(&by_steps);
            }
            // The same once the run has settled, over a turn of the cage.
            let settled = RunSettings { duration: settled_window(scene, settings), ..settings.clone() };
            if let Some(finer) = or_failure(control.part((0.5, 0.75), |_| finer(&settled)))?.ok().flatten() {
                let unseen = (1.0 - settled.duration / settings.duration).max(0.0).sqrt();
                let signals = twice(&attempt.recording, &finer);
                deviation.levels = deviation.levels.larger(level_errors(&signals, |twice| twice.error_db(unseen)));
            }
        }
    }
    let turns = scene.operating_speed() != 0.0;
    let divergence = match or_failure(control.part((0.75, 1.0), |control| {
        let first = if is_condensed { &attempt.recording } else { &richer };
        let of = if is_condensed { &stepped } else { &short };
        divergence(scene, of, first, whole || !is_condensed, control)
    }))? {
        // Where nothing turns, two trajectories may stay apart for ever.
        Ok(divergence) => Some(divergence).filter(|_| turns),
        Err(_) => None,
    };
    let unknown = if !scene.operation.speed.is_constant() {
        Some(Gap::SpeedChanges)
    } else if settings.duration < window {
        Some(Gap::ShortRecord)
    } else {
        // Where levels deviate too far, they show it themselves.
        leaves.filter(|_| deviation.within(&settings.outputs, settings.model_tolerance_db))
    };
    let gap = unknown.or_else(|| uncovered(level, scene, settings, &own, &attempt.recording, course.as_ref()));
    Ok(Verification {
        deviation: Some(deviation).filter(|_| unknown.is_none()),
        basis: ErrorBasis::RicherModel { level: richer_level, window },
        divergence,
        is_whole: whole,
        gap,
        course,
        ..Verification::default()
    })
}

/// The short run that verifies a reduced model.
fn window_of(level: ModelLevel, scene: &Scene, settings: &RunSettings) -> RunSettings {
    let short = window_settings(scene, settings);
    if level == ModelLevel::RadiallyCondensed {
        return short;
    }
    // The richer model costs little; and a periodic motion is none from the start.
    let settle = short.settle.max(settings.settle).max(MIN_WINDOW_SETTLE_S);
    let duration = settings.duration.min(LEAN_WINDOW * short.duration).max(short.duration);
    RunSettings { settle, duration, ..short }
}

/// A window on both models.
struct Compared {
    deviation: Deviation,
    own: Recording,
    richer: Recording,
    richer_level: ModelLevel,
    leaves: Option<Gap>,
}

fn compare_window(
    level: ModelLevel,
    short: &RunSettings,
    attempt: &Attempt,
    problem: &Problem<'_>,
    control: &Control<'_>,
) -> Result<Compared, SimulationError> {
    let Problem { scene, settings, .. } = *problem;
    let quiet = Control::until(control.stop);
    let own_settings = RunSettings { fixed_step: attempt.step, ..short.clone() };
    let own = record(level, scene, &own_settings, &quiet)?.0;
    let mut leaves = None;
    let (richer_level, richer) = if level == ModelLevel::RadiallyCondensed {
        let terms = crate::simulation::model::terms::ActiveTerms::of(scene, &short.outputs, None)?;
        let model = Model::new(scene, &terms);
        let start = InitialState::at_rest(&model)?;
        let dynamics = Dynamics { model, terms, start };
        let richer = dynamics_window(&dynamics, short, settings, control)?;
        leaves = leaving_plane(&richer, short.duration);
        if short.duration < LEAVING_WINDOW_S && leaves.is_some() {
            // So short a window takes chance for growth.
            let long = RunSettings { duration: LONG_WINDOW_S, ..short.clone() };
            leaves = leaving_plane(&dynamics_window(&dynamics, &long, settings, control)?, LONG_WINDOW_S);
        }
        (dynamics.terms.rung, richer)
    } else {
        let richer = record(ModelLevel::RadiallyCondensed, scene, short, &quiet)?.0;
        (ModelLevel::RadiallyCondensed, richer)
    };
    let unseen = (1.0 - short.duration / settings.duration).max(0.0).sqrt();
    let mut deviation = Deviation::of_recordings(&own, &richer, unseen).of_asked(&settings.outputs);
    if level == ModelLevel::RadiallyCondensed
        && let Some(errors) = &mut deviation.quantities
    {
        // The largest load of the run is at another approach than that of the window, where the law of its contacts errs otherwise.
        errors.max_load += condensed_contact::LOAD_ERROR;
    }
    Ok(Compared { deviation, own, richer, richer_level, leaves })
}

/// A window of the dynamics, in fixed steps where they are free and do not blow up.
fn dynamics_window(
    dynamics: &Dynamics,
    short: &RunSettings,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<Recording, SimulationError> {
    let tolerance = settings.tightest().max(WINDOW_TOLERANCE);
    let controlled = || {
        let stepping = Stepping { relative_tolerance: tolerance, ..Stepping::of(short) };
        Ok(run(dynamics, short, &stepping, control)?.recording)
    };
    let Some(stepped) = fixed_step::verifying(&RunSettings { tightened: settings.tightened, ..short.clone() }) else {
        return controlled();
    };
    match run(dynamics, &stepped, &Stepping::of(&stepped), control) {
        Err(SimulationError::Integration { .. }) => controlled(),
        attempt => Ok(attempt?.recording),
    }
}

/// A run of the condensed model in finer steps than those of `stepped`; `None`: they would be too many.
fn finer_run(
    scene: &Scene,
    settings: &RunSettings,
    stepped: &RunSettings,
    control: &Control<'_>,
) -> Result<Option<Recording>, SimulationError> {
    let model = RadiallyCondensed::new(scene, &settings.outputs)?;
    let Some(step_ratio) = model.finer_step_ratio(stepped) else { return Ok(None) };
    let finer = RunSettings { fixed_step: Some(step_ratio.step()), ..settings.clone() };
    Ok(Some(radially_condensed::simulate_perturbed(scene, [0.0; 2], &finer, control)?.0))
}

/// Divergence of a trajectory of the condensed model that starts next to a recorded one. `whole`: over all of it; else over a window, as
/// long as a disturbance does not seem to grow.
fn divergence(
    scene: &Scene,
    settings: &RunSettings,
    first: &Recording,
    whole: bool,
    control: &Control<'_>,
) -> Result<DivergenceEstimate, SimulationError> {
    let over = |duration: f64| {
        let short = RunSettings { duration, ..settings.clone() };
        let other = radially_condensed::simulate_perturbed(scene, [DISPLACEMENT; 2], &short, control)?.0;
        let both = |channel: &Channel| Some((&*first.of(*channel)?.excerpts, &*other.of(*channel)?.excerpts));
        let pairs: Vec<Pairs<'_>> = ACCELERATIONS.iter().filter_map(both).collect();
        let spacing = Windows::of(kept_values(duration)).length;
        Ok(lyapunov::of_signals(&pairs, spacing, DISPLACEMENT / STATIC_DISPLACEMENT, settings.settle, RATE))
    };
    let window = settled_window(scene, settings);
    if whole || window >= settings.duration {
        return over(settings.duration);
    }
    let estimate = over(window)?;
    match estimate.may_grow(settings.duration) {
        true => over(settings.duration),
        false => Ok(estimate),
    }
}

/// Window of the recorded time that shows the error of steps, and whether neighbouring trajectories diverge [s]: a turn of the cage.
fn settled_window(scene: &Scene, settings: &RunSettings) -> f64 {
    let passages = scene.bearing.parameters.ball_count as f64 * DIVERGENCE_CAGE_TURNS;
    let turn = WINDOW_PASSAGES.max(passages) * ball_passage(scene);
    window_time(scene, settings).max(REPEATED).max(turn).min(settings.duration)
}

/// What happens in a run that its window of verification does not cover.
fn uncovered(
    level: ModelLevel,
    scene: &Scene,
    settings: &RunSettings,
    window: &Recording,
    recording: &Recording,
    course: Option<&Deviation>,
) -> Option<Gap> {
    let is_condensed = level == ModelLevel::RadiallyCondensed;
    let slow = if is_condensed {
        slow_motion(window, recording, scene)
    } else {
        tilt_risk(scene).map(|risk| match risk {
            crate::simulation::error::codes::Ineligible::HeavyCage => Gap::HeavyCage,
            _ => Gap::MayTilt,
        })
    };
    // What finer steps show is known, and more than that.
    let is_known = course.is_some_and(|course| !course.within(&settings.outputs, settings.model_tolerance_db));
    slow.or_else(|| inertia_exceeds_preload(scene, settings, recording)).or_else(|| {
        let scatters = scattering_level(recording).filter(|_| is_condensed && !is_known);
        scatters.map(|(channel, scatter)| Gap::LevelScatters(channel, scatter))
    })
}

/// Slow motions that went on after the window: slip of the cage, and balls that drift in their pockets.
fn slow_motion(window: &Recording, recording: &Recording, scene: &Scene) -> Option<Gap> {
    let slipped = (recording.cage_speed - window.cage_speed).abs() / window.cage_speed.max(f64::MIN_POSITIVE);
    let p = &scene.bearing.parameters;
    let spacing = 0.5 * std::f64::consts::TAU * p.pitch_diameter / p.ball_count as f64;
    let drift = window
        .largest_pocket_offset
        .zip(recording.largest_pocket_offset)
        .map_or(0.0, |(before, after)| (after - before) / spacing);
    if slipped > CAGE_SPEED_CHANGE {
        Some(Gap::CageSpeedChanged(slipped))
    } else {
        (drift > BALL_DRIFT).then_some(Gap::BallsDrifted(drift))
    }
}

/// Whether the spindle may leave its balls at times, and comes to rest slowly: the consequences show long after a window.
fn inertia_exceeds_preload(scene: &Scene, settings: &RunSettings, recording: &Recording) -> Option<Gap> {
    let rms = |channel| recording.of(channel).map_or(0.0, |signal| signal.in_band().moments.rms());
    let [x, y, z] = ACCELERATIONS.map(rms);
    let mass = scene.spindle.mass;
    let held = (scene.operation.load[1] + mass * scene.gravity).hypot(scene.operation.load[2]);
    let share = mass * x.hypot(y).hypot(z) / held.max(f64::MIN_POSITIVE);
    let model = || RadiallyCondensed::new(scene, &settings.outputs);
    let damping = || model().map_or(0.0, |model| model.spindle_damping());
    let comes_to_rest = || damping() * window_time(scene, settings) >= MIN_DECAY_EFOLDS;
    (share > INERTIA_OVER_PRELOAD && !comes_to_rest()).then_some(Gap::InertiaExceedsPreload(share))
}

/// Whether a motion that begins in the plane may leave it. Planar motion solves the equations but for a small tilt by the crown's seat,
/// which grows in a viscous grease at low speed.
fn leaving_plane(recording: &Recording, window: f64) -> Option<Gap> {
    let most = |parts: &[Quantities]| parts.iter().fold(0.0, |most, part| f64::max(most, part.out_of_plane));
    let (first, second) = recording.parts.split_at(recording.parts.len() / 2);
    let (before, after) = (most(first), most(second));
    let rate = (after / before).ln() / (0.5 * window);
    let grows = after > IN_PLANE_SINE && before > 0.0 && rate > LEAVING_PLANE_PER_S;
    (grows || after > OUT_OF_PLANE_SINE).then(|| Gap::BallsLeavePlane {
        before: before.asin(),
        after: after.asin(),
        window,
    })
}

// --- a run of the dynamics against a refined one --------------------------------------------------------------------------

fn by_refinement(
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
        // Chaos, instability of the step, or slow motions that keep what steps have damped: no repetition shows the error.
        verification.failure = failure;
        return Ok(verification);
    }
    let steady = scene.operation.speed.is_constant()
        && is_stationary(&attempt.recording, &settings.outputs, settings.model_tolerance_db);
    // The whole time where the motion is neither periodic nor stationary.
    let is_windowed = steady && !verification.is_chaotic();
    let mut window = if is_windowed { refined_window(scene, settings) } else { settings.duration };
    let mut repeated = or_failure(repeat(window, &own, dynamics, most, control))?;
    if let Err(why) = &repeated
        && window > REPEATED
    {
        // A part is better than nothing.
        match or_failure(repeat(REPEATED, &own, dynamics, most, control))? {
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
    (control.progress)(1.0);
    verification.failure = failure.filter(|_| verification.part.is_none());
    verification.is_whole = window >= settings.duration;
    let Ok(Some(again)) = repeated else { return Ok(verification) };
    let signals = twice(&attempt.recording, &again);
    let unseen = (1.0 - window / settings.duration).max(0.0).sqrt();
    verification.noise = signals.iter().map(|(_, twice)| twice.noise()).fold(0.0, f64::max);
    verification.deviation = Some(Deviation {
        levels: level_errors(&signals, |twice| twice.error_db(unseen)),
        quantities: Some(quantity_errors(&attempt.recording.parts, &again.parts)),
    });
    verification.basis = ErrorBasis::Repetition { refinement: refinement(&own), window, recorded: settings.duration };
    Ok(verification)
}

/// Window of a repetition, and time over which neighbouring trajectories are followed at first [s].
fn refined_window(scene: &Scene, settings: &RunSettings) -> f64 {
    let passages = WINDOW_PASSAGES * ball_passage(scene);
    settings.duration.min(if passages.is_finite() { passages.max(REPEATED) } else { REPEATED })
}

/// How a repetition is refined.
fn refinement(settings: &RunSettings) -> Refinement {
    match settings.fixed_step {
        Some(_) if settings.method == Method::SemiImplicit => Refinement::Step(QUARTER_STEP),
        Some(_) => Refinement::Step(HALF_STEP),
        None => {
            let tolerance = (TIGHTER * settings.relative_tolerance).max(TIGHTEST);
            Refinement::Tolerance(tolerance, lyapunov::judging(settings.method))
        }
    }
}

/// Repeats a run from its initial state over a window [s]; `None`: too short to compare.
fn repeat(
    window: f64,
    settings: &RunSettings,
    dynamics: &Dynamics,
    most_evaluations: u64,
    control: &Control<'_>,
) -> Result<Option<Recording>, SimulationError> {
    if kept_values(window) < MIN_VALUES {
        return Ok(None);
    }
    let again = RunSettings {
        duration: window,
        // Sampled as often as its own steps require: peaks lie between the samples of longer ones.
        fixed_step: settings.fixed_step.zip(refinement(settings).step()).map(|(step, share)| share * step),
        outputs: without_signals(&settings.outputs),
        ..settings.clone()
    };
    let stepping = Stepping {
        method: lyapunov::judging(settings.method),
        relative_tolerance: (TIGHTER * settings.relative_tolerance).max(TIGHTEST),
        fixed_step: again.fixed_step,
        most_evaluations: Some(most_evaluations),
    };
    Ok(Some(run(dynamics, &again, &stepping, control)?.recording))
}
