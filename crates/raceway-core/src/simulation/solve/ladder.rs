//! The ladder of models: on which rung a scene is simulated, and whether the next richer rung confirms it.
//!
//! The two upper rungs, `full` and `planar`, are the dynamics of `model/dynamics.rs`. The reduced ones below keep less: what they
//! leave out is checked on a short stretch, from the same start, against the next richer rung. Where nothing is asked for by
//! name, the leanest rung that can give the outputs and that its check confirms within `model_tolerance_db` makes the result.

mod check;

use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::recording::sampling::ACCELERATIONS;
use std::cell::Cell;
use std::time::Instant;

use crate::numerics::ode::Method;
use crate::numerics::ode::Statistics;
use crate::simulation::error::comparison::{self, Distance};
use crate::simulation::error::estimate::{self};
use crate::simulation::error::lyapunov::{self, Pairs, Parted};
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::error::report::Doubt;
use crate::simulation::error::report::MotionKind;
use crate::simulation::error::stationarity::{self, Stretches};
use crate::simulation::input::channel::Channel;
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::scene::{Scene, Term, TermChoice};
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::Mechanism;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::radially_condensed::{self, Pace, RadiallyCondensed};
use crate::simulation::model::spindle_runs;
use crate::simulation::model::terms::{Grounds, LeftOut, Needs, Unmet};
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::RATE;
use crate::simulation::recording::sampling::kept_values;
use crate::simulation::recording::windows::Windows;
use crate::simulation::result::metrics::SolverReport;
use crate::simulation::result::run_result::{Account, RunResult};
use crate::simulation::solve::judgement;
use crate::simulation::solve::startup;
pub use check::check_time;
use check::{Check, Reached, check, check_settings, thrown_about, uneven};

/// Share of the progress that a check stands for.
const CHECK_SHARE: f64 = 0.1;
/// Progress before a later stretch, which uneven levels are held against.
const PARTED: f64 = 0.95;
/// Share of the progress that is left which a rung has that was not asked for by name: another may have to follow.
const TRIED_SHARE: f64 = 0.8;
/// Largest share of a run that its check may be; a shorter run is simulated on the richer rung at once.
const WORTH_IT: f64 = 0.3;
/// Share of the tolerance that a rung may use whose check is by a reduced one, which uses the rest [-].
const SHARE_OF_LEAN: f64 = 0.7;
/// Viscosity over speed of the shaft [Pa s²] from which on such tilt was seen to change levels (from 2.6e-5 on); a rung
/// that is checked in the plane would not see it.
const TILTS: f64 = 2.5e-5;
/// The same from which on steps of the dynamics were seen to take for chaos what is none: levels a decibel off.
const TILTS_LATE: f64 = 3.5e-5;
/// Mass of a cage over that of its balls, and its offset over a ball's diameter, up to which a crown cage that tilts leaves levels
/// alone: of 166 lean runs below none was quietly wrong, of those beyond one or two of a hundred, by up to 4.5 dB.
const HEAVY_CAGE: f64 = 1.0;
const FAR_CAGE: f64 = 0.5;
/// How far apart two motions start that show whether the motion is chaotic [m], and the size of the spindle's displacements [m].
const DISPLACEMENT: f64 = 1e-10;
const STATIC_DISPLACEMENT: f64 = 1e-6;
/// States of the rungs that integrate the spindle alone.
const SPINDLE_STATES: usize = 4;
impl ModelLevel {
    /// All, the richest first.
    pub const ALL: [Self; 5] = [Self::Full, Self::Planar, Self::RadiallyCondensed, Self::SpindleOnly, Self::Periodic];
    const REDUCED: [Self; 3] = [Self::Periodic, Self::SpindleOnly, Self::RadiallyCondensed];

    /// The name in requests and results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Planar => "planar",
            Self::RadiallyCondensed => "radially_condensed",
            Self::SpindleOnly => "spindle_only",
            Self::Periodic => "periodic",
        }
    }

    /// Whether it leaves out more than identities allow, and has an integrator of its own.
    pub fn is_reduced(self) -> bool {
        Self::REDUCED.contains(&self)
    }

    /// By how much it may differ from the next richer rung [dB]. The leaner ones are checked against a reduced one, which has a
    /// part of the tolerance of its own.
    fn allowed(self, model_tolerance_db: f64) -> f64 {
        match self {
            Self::SpindleOnly | Self::Periodic => SHARE_OF_LEAN * model_tolerance_db,
            _ => model_tolerance_db,
        }
    }

    /// The integrator of a reduced rung.
    fn own_method(self) -> &'static str {
        match self {
            Self::Periodic => "shooting",
            Self::SpindleOnly => "adams_moulton",
            _ => "semi_implicit",
        }
    }

    /// Why a reduced rung cannot have this scene or give these outputs; `None`: it can, or it is none.
    fn refusal(self, scene: &Scene, needs: &Needs, outputs: &Outputs) -> Option<String> {
        // The leaner rungs are checked against this one.
        let condensed = || radially_condensed::unable(scene, outputs).map(str::to_owned);
        match self {
            Self::Full | Self::Planar => None,
            Self::RadiallyCondensed => condensed(),
            Self::SpindleOnly => spindle_runs::unable(scene, needs, outputs).or_else(condensed),
            Self::Periodic => spindle_runs::unable_periodic(scene, needs, outputs).or_else(condensed),
        }
    }
}

/// What the equations of a scene hold on a rung asked for by name, or on the dynamics that the scene needs: these without single
/// terms that it can do without by judgement. Reduced rungs, which would save nothing by that, have all.
pub fn needs(
    scene: &Scene,
    outputs: &Outputs,
    rung: Option<ModelLevel>,
    model_tolerance_db: f64,
) -> Result<Needs, Unmet> {
    let Some(rung) = rung.filter(|rung| rung.is_reduced()) else {
        if rung == Some(ModelLevel::Full) && scene.terms.get(Term::CageTilt) == TermChoice::Off {
            return Err(Unmet::ModelLevel { rung: ModelLevel::Full, reason: "terms.cage_tilt is off".into() });
        }
        return Ok(judgement::within(Needs::of(scene, outputs, rung)?, scene, outputs, model_tolerance_db));
    };
    if let Some(reason) = rung.refusal(scene, &Needs::of(scene, outputs, Some(ModelLevel::Full))?, outputs) {
        return Err(Unmet::ModelLevel { rung, reason });
    }
    let mut needs = Needs::of(scene, outputs, Some(ModelLevel::Planar))?;
    needs.left_out.retain(|left_out| left_out.term != Term::CageTilt.name() || left_out.by == Grounds::Identity);
    let tilts = !needs.left_out.iter().any(|left_out| left_out.term == Term::CageTilt.name());
    needs.left_out.extend(omissions(rung, tilts));
    Ok(needs)
}

/// What a reduced rung leaves out by judgement; the bound is that of its check, of all together.
fn omissions(rung: ModelLevel, tilts: bool) -> Vec<LeftOut> {
    let one = |term: Term, reason: &str| LeftOut {
        term: term.name(),
        reason: format!("rung {}: {reason}", rung.name()),
        by: Grounds::Judgement,
        bound: None,
    };
    let mut all = vec![one(Term::BallRadialDynamics, "balls are in radial equilibrium between their raceways")];
    if tilts {
        all.push(one(Term::CageTilt, "no ball or cage leaves the plane"));
    }
    if rung != ModelLevel::RadiallyCondensed {
        all.push(one(Term::Cage, "balls go round equally spaced, at the speed of ideal rolling"));
        all.push(one(Term::BallSpinDynamics, "balls roll ideally"));
    }
    all
}

/// The rungs that are tried, the leanest first; the last one is sure to serve.
pub fn tried(scene: &Scene, settings: &RunSettings) -> Result<Vec<ModelLevel>, Unmet> {
    if let Some(rung) = settings.rung {
        return Ok(vec![rung]);
    }
    let dynamics = Needs::of(scene, &settings.outputs, None)?;
    let mut rungs = if not_tried(scene, settings, &dynamics).is_none() {
        let serves = |rung: &ModelLevel| {
            (*rung == ModelLevel::RadiallyCondensed || lean_not_tried(scene).is_none())
                && rung.refusal(scene, &dynamics, &settings.outputs).is_none()
        };
        ModelLevel::REDUCED.into_iter().filter(serves).collect()
    } else {
        Vec::new()
    };
    rungs.push(dynamics.rung);
    Ok(rungs)
}

/// Why no reduced rung is tried; `None`: nothing else is asked for, and a check would tell and be worth it.
fn not_tried(scene: &Scene, settings: &RunSettings, needs: &Needs) -> Option<&'static str> {
    let dynamics = [Term::BallRadialDynamics, Term::BallSpinDynamics, Term::CageTilt];
    if settings.method != Method::Auto || settings.fixed_step.is_some() {
        Some("a method or a fixed step was asked for")
    } else if settings.model_tolerance_db == 0.0 {
        Some("model_tolerance_db is 0")
    } else if dynamics.iter().any(|term| scene.terms.get(*term) == TermChoice::On) {
        Some("a term that it leaves out is on")
    } else if needs.raceway.hydrodynamics {
        Some("hydrodynamic forces act, whose tilting of balls and cage takes longer to show than a check")
    } else if !scene.operation.speed.is_constant() {
        Some("the speed varies, and a check from the start tells nothing of later speeds")
    } else if check_time(scene, settings) > WORTH_IT * (settings.settle + settings.duration) {
        Some("its check would take too large a part of the run")
    } else {
        None
    }
}

/// Why no rung leaner than the condensed one is tried: what tilt may do there, their planar check does not see; `None`: nothing
/// speaks against it.
fn lean_not_tried(scene: &Scene) -> Option<&'static str> {
    if may_tilt(scene, TILTS) {
        Some("so slow with so viscous a lubricant, cage and balls may tilt, which their planar check does not see")
    } else if cage_may_tilt_balls(scene) {
        Some("so heavy a cage, or one so far off its balls, may tilt them, which their planar check does not see")
    } else {
        None
    }
}

/// Whether cage and balls may begin to tilt late in a run; from there on they mostly do at once, and no reduced rung serves.
pub fn tilts_late(scene: &Scene) -> bool {
    may_tilt(scene, TILTS_LATE)
}

/// Whether they may do so slowly, over seconds, under hydrodynamic forces.
pub fn tilts_slowly(scene: &Scene) -> bool {
    may_tilt(scene, TILTS)
}

fn may_tilt(scene: &Scene, limit: f64) -> bool {
    scene.lubricant.viscosity > limit * scene.operating_speed().abs()
}

/// Whether the weight and inertia of the cage, which act beside the plane of its balls, may take these out of it.
fn cage_may_tilt_balls(scene: &Scene) -> bool {
    let (cage, bearing) = (&scene.cage, &scene.bearing);
    let balls = bearing.parameters.ball_count as f64 * bearing.ball_mass;
    !cage.is_symmetric()
        && (cage.mass > HEAVY_CAGE * balls || cage.offset.abs() > FAR_CAGE * bearing.parameters.ball_diameter)
}

/// The result of the leanest reduced rung that serves; `None`: the dynamics have to. With what the others have shown, in words.
pub(crate) fn run(
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Option<RunResult>, Vec<String>), SimulationError> {
    let begin = Instant::now();
    let mut found = Vec::new();
    let dynamics = Needs::of(scene, &settings.outputs, None)?;
    if let (None, Some(reason)) = (settings.rung, not_tried(scene, settings, &dynamics)) {
        found.push(format!("no reduced rung was tried: {reason}"));
    } else if let (None, Some(reason)) = (settings.rung, lean_not_tried(scene)) {
        found.push(format!("spindle_only and periodic were not tried: {reason}"));
    }
    let (told, share_of_rest) = (Cell::new(0.0), if settings.rung.is_some() { 1.0 } else { TRIED_SHARE });
    for rung in tried(scene, settings)?.into_iter().filter(|rung| rung.is_reduced()) {
        // What follows a rung that is given up has the rest of the progress.
        let before = told.get();
        let progress = |share: f64| {
            told.set(before + share_of_rest * (1.0 - before) * share);
            (control.progress)(told.get());
        };
        match on_rung(rung, scene, settings, begin, &Control { progress: &progress, ..*control }) {
            Ok(Ok(result)) => return Ok((Some(result), found)),
            Ok(Err(check)) => found.push(format!("{} was not confirmed: {check}", rung.name())),
            Err(stopped @ SimulationError::Stopped { .. }) => return Err(stopped),
            Err(error) if settings.rung.is_some() => return Err(error),
            Err(SimulationError::Unable { reason, .. }) => {
                found.push(format!("{} does not serve: {reason}", rung.name()))
            }
            Err(error) => found.push(format!("{} failed: {error}", rung.name())),
        }
    }
    Ok((None, found))
}

/// The result of a reduced rung; `Err`: what its check has shown instead, where it was not asked for by name.
fn on_rung(
    rung: ModelLevel,
    scene: &Scene,
    settings: &RunSettings,
    begin: Instant,
    control: &Control<'_>,
) -> Result<Result<RunResult, String>, SimulationError> {
    // The check decides, so it comes first.
    (control.live)(&Live::of(Phase::Checking));
    let checked = control.aside().part((0.0, CHECK_SHARE), |control| check(rung, scene, settings, control));
    let check = match checked {
        Ok(check) => check,
        // A rung by name is run whatever its check shows.
        Err(error) if settings.rung.is_some() && !matches!(error, SimulationError::Stopped { .. }) => {
            Check::failed(error.to_string())
        }
        Err(error) => return Err(error),
    };
    let allowed = rung.allowed(settings.model_tolerance_db);
    if !check.confirms(&settings.outputs, allowed) && settings.rung.is_none() {
        return Ok(Err(check.words_beyond(&settings.outputs, allowed)));
    }
    let stepped = RunSettings { fixed_step: settings.fixed_step.or(check.step), ..settings.clone() };
    let finer_pace = finer_pace(rung, scene, &stepped)?;
    // What follows the run takes as long, by finer steps the more of them there are.
    let again = finer_pace.map_or(0.0, |(_, steps)| steps);
    let rest = (PARTED - CHECK_SHARE) / (1.0 + 2.0 * again);
    let (run, repeated) = (CHECK_SHARE + rest, CHECK_SHARE + (1.0 + again) * rest);
    let made = control.part((CHECK_SHARE, run), |control| record(rung, scene, &stepped, control))?;
    (control.live)(&Live::of(Phase::Judging));
    let finer = control.aside().part((run, repeated), |control| finer(finer_pace, scene, &stepped, control));
    let finer = match finer {
        Err(error) if settings.rung.is_none() || matches!(error, SimulationError::Stopped { .. }) => return Err(error),
        finer => finer.ok().flatten(),
    };
    let of_outputs =
        |finer: &Finer| Distance::of_recordings(&made.recording, &finer.recording, 0.0).of_asked(&settings.outputs);
    let apart = finer.as_ref().map(of_outputs);
    let another_course = apart
        .filter(|apart| !apart.within(&settings.outputs, settings.model_tolerance_db))
        .map(|apart| apart.words_beyond(&settings.outputs, settings.model_tolerance_db))
        .map(|words| format!("finer steps take another course over the whole run ({words})"));
    let unseen = if rung != ModelLevel::RadiallyCondensed {
        lean_not_tried(scene).map(str::to_owned)
    } else if check.fault.is_none() {
        check.reached.gone_on(&Reached::of(&made.recording), scene)
    } else {
        None
    };
    let unseen = unseen.or_else(|| thrown_about(scene, settings, &made.recording));
    // What finer steps tell is known, and more than that.
    let may_be_uneven = rung == ModelLevel::RadiallyCondensed && check.fault.is_none() && another_course.is_none();
    let unseen = unseen.or_else(|| uneven(&made.recording).filter(|_| may_be_uneven));
    if let (Some(what), None) = (unseen.as_ref().or(another_course.as_ref()), settings.rung) {
        return Ok(Err(format!("{what}, and the check tells nothing of that")));
    }
    let turns = scene.operating_speed() != 0.0;
    let pair = |control: &Control<'_>| parted(rung, scene, &stepped, &made, finer.as_ref(), control);
    let parted = match control.aside().part((repeated, PARTED), pair) {
        Err(stopped @ SimulationError::Stopped { .. }) => return Err(stopped),
        // Where nothing turns, two motions may stay apart for ever.
        parted => parted.ok().filter(|_| turns),
    };
    if parted.and_then(|parted| parted.motion()) == Some(MotionKind::Diverging) && settings.rung.is_none() {
        return Ok(Err(
            "on it two motions that start next to each other part, and no check tells of the statistics of chaos"
                .into(),
        ));
    }
    // It has left no state to go on from, and begins anew.
    let later = |of: &RunSettings| {
        control.aside().part((PARTED, 1.0), |control| Ok(record(rung, scene, of, control)?.recording))
    };
    let is_steady = scene.operation.speed.is_constant();
    let stretches = is_steady.then(|| stationarity::stretches(rung, &made.recording, &stepped, later)).transpose()?;
    let shown = Shown { check, apart, another_course, unseen, parted, stretches };
    Ok(Ok(summarise(rung, scene, settings, &made, shown, begin)?))
}

/// What is known of the errors of a run.
struct Shown {
    check: Check,
    /// What finer steps differ by over the whole run, and whether that is too much, in words.
    apart: Option<Distance>,
    another_course: Option<String>,
    /// What went on after the check, which tells nothing of it.
    unseen: Option<String>,
    /// Two motions that start next to each other.
    parted: Option<Parted>,
    /// At constant speed.
    stretches: Option<Stretches>,
}

/// A run of the condensed rung again, by finer steps: a check sees its beginning only, and slow motions that go another way with every
/// step length show here, as does chaos.
struct Finer {
    settings: RunSettings,
    recording: Recording,
}

/// Finer steps of a run, and how many of them go into one of its own; `None`: of another rung, or one that has none.
fn finer_pace(rung: ModelLevel, scene: &Scene, settings: &RunSettings) -> Result<Option<(Pace, f64)>, SimulationError> {
    if rung != ModelLevel::RadiallyCondensed {
        return Ok(None);
    }
    let model = RadiallyCondensed::new(scene, &settings.outputs)?;
    let steps = |pace: Pace| (pace, model.pace_for(settings).step() / pace.step());
    Ok(model.finer_pace(settings).map(steps))
}

fn finer(
    pace: Option<(Pace, f64)>,
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<Option<Finer>, SimulationError> {
    let Some((pace, _)) = pace else { return Ok(None) };
    let settings = RunSettings { fixed_step: Some(pace.step()), ..settings.clone() };
    let recording = beside(scene, [0.0; 2], &settings, control)?;
    Ok(Some(Finer { settings, recording }))
}

/// A run of the condensed rung whose spindle starts so far beside its equilibrium (y, z) [m].
fn beside(
    scene: &Scene,
    displacement: [f64; 2],
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<Recording, SimulationError> {
    Ok(radially_condensed::simulate_beside(scene, displacement, settings, control)?.0)
}

/// What a reduced rung has left behind, and its first-order states.
struct Made {
    recording: Recording,
    statistics: Statistics,
    states: usize,
}

fn record(
    rung: ModelLevel,
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<Made, SimulationError> {
    let (recording, statistics) = match rung {
        ModelLevel::Periodic => spindle_runs::simulate_periodic(scene, settings, control)?,
        ModelLevel::SpindleOnly => spindle_runs::simulate(scene, settings, control)?,
        _ => radially_condensed::simulate(scene, settings, control)?,
    };
    let states = match rung {
        ModelLevel::Periodic | ModelLevel::SpindleOnly => SPINDLE_STATES,
        _ => RadiallyCondensed::new(scene, &settings.outputs)?.states(),
    };
    Ok(Made { recording, statistics, states })
}

/// Do two motions on the condensed rung that start next to each other part? On a leaner rung over the time of its check.
fn parted(
    rung: ModelLevel,
    scene: &Scene,
    settings: &RunSettings,
    made: &Made,
    finer: Option<&Finer>,
    control: &Control<'_>,
) -> Result<Parted, SimulationError> {
    let of = |one: &Recording, settings: &RunSettings| {
        let other = beside(scene, [DISPLACEMENT; 2], settings, control)?;
        let both = |channel: &Channel| Some((&*one.of(*channel)?.excerpts, &*other.of(*channel)?.excerpts));
        let pairs: Vec<Pairs<'_>> = ACCELERATIONS.iter().filter_map(both).collect();
        let spacing = Windows::of(kept_values(settings.duration)).length;
        Ok(lyapunov::of_signals(&pairs, spacing, DISPLACEMENT / STATIC_DISPLACEMENT, settings.settle, RATE))
    };
    match finer {
        Some(finer) => of(&finer.recording, &finer.settings),
        None if rung == ModelLevel::RadiallyCondensed => of(&made.recording, settings),
        None => {
            let (short, quiet) = (check_settings(rung, scene, settings), Control::until(control.stop));
            of(&beside(scene, [0.0; 2], &short, &quiet)?, &short)
        }
    }
}

fn summarise(
    rung: ModelLevel,
    scene: &Scene,
    settings: &RunSettings,
    made: &Made,
    Shown { check, apart, another_course, unseen, parted, stretches }: Shown,
    begin: Instant,
) -> Result<RunResult, SimulationError> {
    let mut needs = needs(scene, &settings.outputs, Some(rung), settings.model_tolerance_db)?;
    let distance = match (&unseen, apart) {
        (Some(_), _) => Distance::UNKNOWN,
        (None, Some(apart)) => check.distance.larger(&apart),
        (None, None) => check.distance,
    };
    let bound = distance.levels.worst().map(|error| (error, "dB"));
    for left_out in needs.left_out.iter_mut().filter(|left_out| left_out.by == Grounds::Judgement) {
        left_out.bound = bound;
    }
    let allowed = rung.allowed(settings.model_tolerance_db);
    let confirmed = check.confirms(&settings.outputs, allowed);
    let warning = (!confirmed).then(|| {
        let words = check.words_beyond(&settings.outputs, allowed);
        // A share of a decimal number is seldom one.
        let allowed = (1e6 * allowed).round() / 1e6;
        format!("the rung {} was asked for and is not confirmed within {allowed} dB: {words}", rung.name())
    });
    let solver = SolverReport {
        method: rung.own_method(),
        method_reason: "the rung's own, for no other integrates it".into(),
        rung: rung.name(),
        check: check.words(),
        statistics: made.statistics,
        wall_time: begin.elapsed().as_secs_f64(),
        simulated_time: settings.settle + settings.duration,
        relative_tolerance: None,
        states: made.states,
        strips: needs.raceway.strips,
    };
    made.recording.evaluate(&settings.outputs);
    let motion = parted.and_then(|parted| parted.motion());
    let by_chance = motion == Some(MotionKind::Diverging);
    let chaotic =
        by_chance.then(|| "the motion is chaotic, and no check from the start tells of its statistics".to_owned());
    let how = match &unseen {
        Some(what) => format!("no error is stated: {what}"),
        None => check.how(),
    };
    let not_known = unseen.map(|what| format!("{what}: the error of the level is not known"));
    let warning = warning.or(not_known).or(chaotic).or(another_course);
    let is_known = distance.levels.worst().is_some();
    let (level_errors, how) = if by_chance && is_known {
        let how =
            format!("the motion is chaotic: standard error of the level by ten batch means, or {how}, if that is more");
        (distance.levels.larger(estimate::sampling_errors(&made.recording)), how)
    } else {
        (distance.levels, how)
    };
    let accuracy = AccuracyReport {
        level_errors,
        quantity_errors: distance.quantities.filter(|_| !by_chance),
        how,
        motion,
        divergence_rate: parted.map_or(0.0, |parted| parted.rate),
        is_sample: false,
        doubt: warning.map(Doubt::Failed),
        warning: None,
    }
    .of_stretch(&made.recording, stretches.as_ref(), &settings.outputs);
    let mechanism = Mechanism::new(scene, &needs);
    // The rung that repeats a passage has no start, and chaos forgets it by itself.
    let keeps_start = rung != ModelLevel::Periodic && !by_chance;
    let settling = keeps_start.then(|| startup::rings_on(scene, settings.settle)).flatten();
    let account =
        Account { solver, accuracy, scatter: stretches.map(|of| of.scatter), settling, left_out: needs.left_out };
    Ok(RunResult::new(scene, settings, &mechanism, &made.recording, account))
}
