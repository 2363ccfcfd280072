//! Verification of a reduced model: a window of a richer model, and finer steps.

use crate::physics::kinematics::RingSpeeds;
use crate::simulation::error::codes::{ErrorBasis, Gap, Ineligible};
use crate::simulation::error::comparison::{Deviation, level_errors, quantity_errors, twice};
use crate::simulation::error::convergence::error_of_counted_order;
use crate::simulation::error::lyapunov::{self, DivergenceEstimate, Pairs};
use crate::simulation::error::stationarity::{is_stationary, scattering_level, together};
use crate::simulation::error::thresholds::{
    BALL_DRIFT, CAGE_SPEED_CHANGE, DIVERGENCE_CAGE_TURNS, IN_PLANE_SINE, INERTIA_OVER_PRELOAD, LEAVING_PLANE_PER_S,
    MIN_DECAY_EFOLDS, MIN_WINDOW_SETTLE_S, OUT_OF_PLANE_SHARE, TILT_WINDOW_S, WINDOW_PASSAGES,
};
use crate::simulation::input::channel::Channel;
use crate::simulation::input::control::Control;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::condensed_contact;
use crate::simulation::model::equilibrium::equilibrium;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::model::radially_condensed::{self, RadiallyCondensed};
use crate::simulation::model::system::Model;
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::recording::record::{Quantities, Recording};
use crate::simulation::recording::sampling::{ACCELERATIONS, RATE, REPEATED, kept_values};
use crate::simulation::recording::windows::Windows;
use crate::simulation::solve::attempt::{Attempt, Dynamics, Problem, record, run, window_settings};
use crate::simulation::solve::eligibility::{ball_passage, representative_time, tilt_risk, window_time};
use crate::simulation::solve::fixed_step;
use crate::simulation::solve::startup::InitialState;
use crate::simulation::solve::verification::{Verification, along_the_run, or_failure};

/// Window of the leanest models over that of the condensed model [-]. Their richer model costs little.
const LEAN_WINDOW: f64 = 2.0;
/// Relative tolerance of the dynamics that verify a reduced model [-]; its level error is about 2e-4 dB.
const WINDOW_TOLERANCE: f64 = 1e-4;
/// Initial distance of two trajectories [m], and the size of the spindle's displacements [m].
const DISPLACEMENT: f64 = 1e-10;
const STATIC_DISPLACEMENT: f64 = 1e-6;

pub(crate) fn by_richer_model(
    level: ModelLevel,
    attempt: &Attempt,
    problem: &Problem<'_>,
    control: &Control<'_>,
) -> Result<Verification, SimulationError> {
    let Problem { scene, settings, .. } = *problem;
    let is_condensed = level == ModelLevel::RadiallyCondensed;
    let stepped = RunSettings { fixed_step: attempt.step, ..settings.clone() };
    let windowed = control.part((0.0, 0.5), |control| compared(level, attempt, problem, control));
    let compared = match or_failure(windowed)? {
        Ok(compared) => compared,
        Err(failure) => return Ok(Verification { failure: Some(failure), ..Verification::default() }),
    };
    let Compared { short, mut deviation, own, richer, richer_level, leaves } = compared;
    let window = short.duration;
    let is_uneven = is_condensed && !is_stationary(&attempt.recording, &settings.outputs, settings.model_tolerance_db);
    // Motion that is neither periodic nor stationary is compared over a time that represents it.
    let represented = match scene.operation.is_steady() {
        true => settings.duration.min(representative_time(scene)),
        false => settings.duration,
    };
    let mut course = None;
    if is_condensed {
        let finer = |settings: &RunSettings| finer_run(scene, settings, &stepped, control);
        let step_error = step_error_over_deviation(scene, &stepped)?;
        // Largest loads and slips follow single moments, and show no order.
        let by_steps = |of: Deviation| Deviation { levels: of.levels.map(|error| step_error * error), ..of };
        if is_uneven {
            let over = RunSettings { duration: represented, ..settings.clone() };
            let finer = or_failure(control.part((0.5, 0.75), |_| finer(&over)))?.ok().flatten();
            let unseen = (1.0 - represented / settings.duration).max(0.0).sqrt();
            let of = |finer: &Recording| match represented < settings.duration {
                true => of_beginning(&attempt.recording, finer, unseen),
                false => Deviation::of_recordings(&attempt.recording, finer, unseen),
            };
            course = finer.as_ref().map(|finer| by_steps(of(finer)).of_asked(&settings.outputs));
        } else {
            if let Some(of_trial) = attempt.step_deviation {
                deviation = deviation.larger(&by_steps(of_trial));
            } else if let Some(finer) = or_failure(finer(&short))?.ok().flatten() {
                let of_finer = by_steps(Deviation::of_recordings(&own, &finer, 0.0));
                deviation = deviation.larger(&of_finer.of_asked(&settings.outputs));
            }
            deviation = along_the_run(deviation, &attempt.recording);
            // The settled run is compared in the same way, over a turn of the cage.
            let settled = RunSettings { duration: settled_window(scene, settings), ..settings.clone() };
            if let Some(finer) = or_failure(control.part((0.5, 0.75), |_| finer(&settled)))?.ok().flatten() {
                let unseen = (1.0 - settled.duration / settings.duration).max(0.0).sqrt();
                let signals = twice(&attempt.recording, &finer);
                deviation.levels =
                    deviation.levels.larger(level_errors(&signals, |twice| Some(step_error * twice.error_db(unseen)?)));
            }
        }
    }
    let turns = scene.operating_speeds() != RingSpeeds::default();
    let divergence = match or_failure(control.part((0.75, 1.0), |control| {
        let first = if is_condensed { &attempt.recording } else { &richer };
        let of = if is_condensed { &stepped } else { &short };
        let window = match (is_condensed, is_uneven) {
            (true, true) => represented,
            (true, false) => settled_window(scene, of),
            (false, _) => of.duration,
        };
        divergence(scene, of, first, window, control)
    }))? {
        // If nothing turns, two trajectories may keep a constant distance for ever.
        Ok(divergence) => Some(divergence).filter(|_| turns),
        Err(_) => None,
    };
    let unknown = if !scene.operation.has_constant_speeds() {
        Some(Gap::SpeedChanges)
    } else if !scene.operation.is_steady() {
        Some(Gap::LoadsChange)
    } else if settings.duration < window {
        Some(Gap::ShortRecord)
    } else {
        // If the levels deviate too far, this deviation is reported, not balls that leave the plane.
        leaves.filter(|_| deviation.within(&settings.outputs, settings.model_tolerance_db))
    };
    let gap = unknown.or_else(|| uncovered(level, scene, settings, &own, &attempt.recording, course.as_ref()));
    Ok(Verification {
        deviation: Some(deviation).filter(|_| unknown.is_none()),
        basis: ErrorBasis::RicherModel { level: richer_level, window },
        divergence,
        is_whole: is_uneven && represented >= settings.duration,
        gap,
        course,
        ..Verification::default()
    })
}

/// Deviation of the beginning of a run from its repetition. `unseen`: root of the share of the run that was not repeated.
fn of_beginning(run: &Recording, again: &Recording, unseen: f64) -> Deviation {
    let beginning = &run.parts[..again.parts.len().min(run.parts.len())];
    Deviation {
        levels: level_errors(&twice(run, again), |twice| twice.error_db(unseen)),
        quantities: Some(quantity_errors(&[together(beginning)], &[together(&again.parts)])),
    }
}

/// The short run that verifies a reduced model.
fn window_of(level: ModelLevel, scene: &Scene, settings: &RunSettings) -> RunSettings {
    let short = window_settings(scene, settings);
    if level == ModelLevel::RadiallyCondensed {
        return short;
    }
    // The richer model costs little. A periodic motion is not periodic during the initial transient.
    let settle = short.settle.max(settings.settle).max(MIN_WINDOW_SETTLE_S);
    let duration = settings.duration.min(LEAN_WINDOW * short.duration).max(short.duration);
    RunSettings { settle, duration, ..short }
}

/// A window on both models.
struct Compared {
    short: RunSettings,
    deviation: Deviation,
    own: Recording,
    richer: Recording,
    richer_level: ModelLevel,
    leaves: Option<Gap>,
}

/// A window on both models, a longer one where balls leave the plane or are likely to: their tilt changes slowly.
fn compared(
    level: ModelLevel,
    attempt: &Attempt,
    problem: &Problem<'_>,
    control: &Control<'_>,
) -> Result<Compared, SimulationError> {
    let Problem { scene, settings, .. } = *problem;
    let short = window_of(level, scene, settings);
    let long = RunSettings { duration: TILT_WINDOW_S.min(settings.duration), ..short.clone() };
    let compare = |window| compare_window(level, window, attempt, problem, control);
    if level != ModelLevel::RadiallyCondensed || short.duration >= long.duration {
        return compare(short);
    }
    if tilt_risk(scene).is_none() {
        let found = compare(short)?;
        if out_of_plane(&found.richer.parts) <= IN_PLANE_SINE {
            return Ok(found);
        }
    }
    compare(long)
}

fn compare_window(
    level: ModelLevel,
    short: RunSettings,
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
        let terms = ActiveTerms::of(scene, &short.outputs, None)?;
        let model = Model::new(scene, &terms);
        let start = InitialState::at_rest(&model)?;
        let dynamics = Dynamics { model, terms, start };
        let richer = dynamics_window(&dynamics, &short, settings, control)?;
        leaves = leaving_plane(scene, &dynamics.model, &richer, short.duration)?;
        (dynamics.terms.rung, richer)
    } else {
        let richer = record(ModelLevel::RadiallyCondensed, scene, &short, &quiet)?.0;
        (ModelLevel::RadiallyCondensed, richer)
    };
    let unseen = (1.0 - short.duration / settings.duration).max(0.0).sqrt();
    let mut deviation = Deviation::of_recordings(&own, &richer, unseen).of_asked(&settings.outputs);
    if level == ModelLevel::RadiallyCondensed
        && let Some(errors) = &mut deviation.quantities
    {
        // The largest load of the run occurs at a different approach from that in the window. There, the law of the contacts has a different error.
        errors.max_load += condensed_contact::LOAD_ERROR;
    }
    Ok(Compared { short, deviation, own, richer, richer_level, leaves })
}

/// Window of the dynamics. Fixed steps are used if no step is selected and the integration does not diverge; otherwise error control.
pub(crate) fn dynamics_window(
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
    let Some(stepped) =
        fixed_step::verifying(&RunSettings { tightened: settings.tightened, ..short.clone() }, &dynamics.model)
    else {
        return controlled();
    };
    match run(dynamics, &stepped, &Stepping::of(&stepped), control) {
        Err(SimulationError::Integration { .. }) => controlled(),
        attempt => Ok(attempt?.recording),
    }
}

/// Run of the condensed model in finer steps than those of `stepped`; `None`: too many steps.
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

/// Error of a run of the condensed model by its steps, over its deviation from the finer run [-].
fn step_error_over_deviation(scene: &Scene, stepped: &RunSettings) -> Result<f64, SimulationError> {
    let model = RadiallyCondensed::new(scene, &stepped.outputs)?;
    let finer = model.finer_step_ratio(stepped);
    Ok(finer.map_or(1.0, |finer| error_of_counted_order(model.step_ratio_for(stepped).step() / finer.step())))
}

/// Divergence of a trajectory of the condensed model that starts next to a recorded one: over a window [s], and over the whole recorded time where
/// a disturbance appears to grow.
fn divergence(
    scene: &Scene,
    settings: &RunSettings,
    first: &Recording,
    window: f64,
    control: &Control<'_>,
) -> Result<DivergenceEstimate, SimulationError> {
    let over = |duration: f64| {
        let short = RunSettings { duration, ..settings.clone() };
        let other = radially_condensed::simulate_perturbed(scene, [DISPLACEMENT; 2], &short, control)?.0;
        let both = |channel: &Channel| Some((&*first.of(*channel)?.excerpts, &*other.of(*channel)?.excerpts));
        let pairs: Vec<Pairs<'_>> = ACCELERATIONS.iter().filter_map(both).collect();
        let spacing = Windows::of(kept_values(duration), settings.outputs.longest_window).length;
        Ok(lyapunov::of_signals(&pairs, spacing, DISPLACEMENT / STATIC_DISPLACEMENT, settings.settle, RATE))
    };
    if window >= settings.duration {
        return over(settings.duration);
    }
    let estimate = over(window)?;
    match estimate.may_grow(settings.duration) {
        true => over(settings.duration),
        false => Ok(estimate),
    }
}

/// Window of the recorded time that shows the step error and the divergence of neighbouring trajectories [s]: a turn of the cage.
fn settled_window(scene: &Scene, settings: &RunSettings) -> f64 {
    let passages = scene.bearing.parameters.ball_count as f64 * DIVERGENCE_CAGE_TURNS;
    let turn = WINDOW_PASSAGES.max(passages) * ball_passage(scene);
    window_time(scene, settings).max(REPEATED).max(turn).min(settings.duration)
}

/// Effect in a run that its window of verification does not cover; `None` if the window covers the run.
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
            Ineligible::HeavyCage => Gap::HeavyCage,
            _ => Gap::MayTilt,
        })
    };
    // A deviation of the whole run in finer steps shows more than the scatter, and is reported instead.
    let is_known = course.is_some_and(|course| !course.within(&settings.outputs, settings.model_tolerance_db));
    slow.or_else(|| inertia_exceeds_preload(scene, settings, recording)).or_else(|| {
        let scatters = scattering_level(recording).filter(|_| is_condensed && !is_known);
        scatters.map(|(channel, scatter)| Gap::LevelScatters(channel, scatter))
    })
}

/// Slow motions that continued after the window: slip of the cage, and drift of the balls in their pockets.
fn slow_motion(window: &Recording, recording: &Recording, scene: &Scene) -> Option<Gap> {
    let slipped =
        (recording.speeds.cage - window.speeds.cage).abs() / window.speeds.relative_cage.max(f64::MIN_POSITIVE);
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

/// Reports a spindle that may leave its balls at times and comes to rest slowly. The consequences appear long after a window.
fn inertia_exceeds_preload(scene: &Scene, settings: &RunSettings, recording: &Recording) -> Option<Gap> {
    let rms = |channel| recording.of(channel).map_or(0.0, |signal| signal.in_band().moments.rms());
    let [x, y, z] = ACCELERATIONS.map(rms);
    let mass = scene.spindle.mass;
    let [_, load_y, load_z, ..] = scene.operation.start_load();
    let held = (load_y + mass * scene.gravity).hypot(load_z);
    let share = mass * x.hypot(y).hypot(z) / held.max(f64::MIN_POSITIVE);
    let model = || RadiallyCondensed::new(scene, &settings.outputs);
    let damping = || model().map_or(0.0, |model| model.spindle_damping());
    let comes_to_rest = || damping() * window_time(scene, settings) >= MIN_DECAY_EFOLDS;
    (share > INERTIA_OVER_PRELOAD && !comes_to_rest()).then_some(Gap::InertiaExceedsPreload(share))
}

/// Largest sine of a contact angle [-].
fn out_of_plane(parts: &[Quantities]) -> f64 {
    parts.iter().fold(0.0, |most, part| most.max(part.out_of_plane))
}

/// Reports a motion that begins in the plane and may leave it. Planar motion solves the equations except for a small tilt by the seat of the crown,
/// which grows in a viscous grease at low speed.
fn leaving_plane(
    scene: &Scene,
    model: &Model,
    recording: &Recording,
    window: f64,
) -> Result<Option<Gap>, SimulationError> {
    let (first, second) = recording.parts.split_at(recording.parts.len() / 2);
    let (before, after) = (out_of_plane(first), out_of_plane(second));
    let rate = (after / before).ln() / (0.5 * window);
    let grows = after > IN_PLANE_SINE && before > 0.0 && rate > LEAVING_PLANE_PER_S;
    let most = before.max(after);
    let leaves = grows || (most > IN_PLANE_SINE && shortening(scene, model, most)? > OUT_OF_PLANE_SHARE);
    Ok(leaves.then(|| Gap::BallsLeavePlane { before: before.asin(), after: after.asin(), window }))
}

/// Share of the approach of the most loaded ball at rest by which a contact angle shortens it [-]: the groove centres lie (1 − cos α) of their
/// distance closer.
fn shortening(scene: &Scene, model: &Model, sine: f64) -> Result<f64, SimulationError> {
    let mechanism = model.mechanism();
    let loads = equilibrium(mechanism, mechanism.rotation.speeds(0.0))?.loads;
    let load = loads.iter().fold(0.0, |most, load| f64::max(most, load.inner));
    let depth = |stiffness: f64| (load / stiffness).powf(2.0 / 3.0);
    let stiffness = mechanism.raceway.map(|contact| contact.hertz().stiffness);
    Ok(0.5 * sine * sine * scene.bearing.groove_centre_distance / (depth(stiffness.inner) + depth(stiffness.outer)))
}
