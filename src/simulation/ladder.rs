//! The ladder of models: on which rung a scene is simulated, and whether the next richer rung confirms it.
//!
//! The two upper rungs, `full` and `planar`, are the dynamics of `model/dynamics.rs`. The reduced ones below keep less: what they
//! leave out is checked on a short stretch, from the same start, against the next richer rung. Where nothing is asked for by
//! name, the leanest rung that can give the outputs and that its check confirms within `model_tolerance_db` makes the result.

use std::time::Instant;

use super::accuracy;
use super::channel::Channel;
use super::distance::{self, Distance};
use super::divergence::{self, Pairs, Parted};
use super::judgement;
use super::metrics::{AccuracyReport, MotionKind, QuantityErrors, SolverReport};
use super::model::radially_condensed::{self, RadiallyCondensed};
use super::model::{Mechanism, Model, condensed_contact};
use super::needs::{Grounds, LeftOut, Needs, Unmet};
use super::observe::{Quantities, RATE, Recording, kept_values};
use super::reduced;
use super::run::{
    self, Control, Live, Method, Outputs, Phase, RunResult, RunSettings, Setup, SimulationError, Stepping,
};
use super::scene::{Scene, Term, TermChoice};
use super::stepped;
use super::windows::Windows;
use crate::numerics::ode::Statistics;
use crate::physics::kinematics;

/// A rung of the ladder of models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rung {
    /// Six degrees of freedom of every ball and of the cage.
    Full,
    /// No motion along the axis, no tilt.
    Planar,
    /// Planar, and every ball in radial equilibrium between its raceways.
    RadiallyCondensed,
    /// The balls go round equally spaced.
    SpindleOnly,
    /// The same, repeating with every ball.
    Periodic,
}

/// Shortest stretch of a check, and of what comes before it [s]; and the ball passages that they hold at least.
const CHECKED: f64 = 6e-3;
const CHECK_SETTLES: f64 = 2e-3;
const CHECKED_PASSAGES: f64 = 3.0;
/// Share of the progress that a check stands for.
const CHECK_SHARE: f64 = 0.1;
/// How much longer a check is that costs little.
const LONGER: f64 = 4.0;
/// Largest share of a run that its check may be; a shorter run is simulated on the richer rung at once.
const WORTH_IT: f64 = 0.3;
/// Share of the tolerance that a rung may use whose check is by a reduced one, which uses the rest [-].
const SHARE_OF_LEAN: f64 = 0.7;
/// Share of the tolerance by which longer steps of the condensed rung may move its levels over a check [-]. They move those of the
/// run as much: what both miss is in the distance from the dynamics.
const SHARE_OF_STEPS: f64 = 0.5;
/// Change of the cage's speed after a check, and of the balls' places in their pockets as a share of their spacing, from which on the
/// check tells nothing of the run: levels were off by decibels at twenty and three per cent, by a twentieth at one and a half.
const SLIPPED: f64 = 5e-3;
/// Rms of the spindle's inertia over the force that holds it, from which on a check tells nothing of the run: of 160 random scenes of 10 to 200 N
/// (`benches/drawn_scenes.rs`), thirty lay beyond, four of these were off by 0.08 to 0.4 dB for 0.01 stated; another by 4. All of them take longer to come to rest
/// than a check.
const THROWN: f64 = 0.1;
/// Damping times the time of a check [e-folds] from which on the check shows how the spindle comes to rest.
const COMES_TO_REST: f64 = 2.0;
const WANDERED: f64 = 1e-2;
/// Sine of a contact angle below which balls count as in the plane [-]; the rate at which larger ones grow from which on the balls are leaving it [1/s]: tilt
/// that grew to degrees and decibels grew by 18 to 70 a second, and where it did not, the angles of a check's halves were up to a tenth
/// apart over 8 ms. And the least stretch that tells such a rate [s].
const IN_PLANE: f64 = 5e-4;
const LEAVING: f64 = 12.0;
const TELLS_LEAVING: f64 = 0.025;
const LONG_CHECK: f64 = 0.03;
/// Viscosity over speed of the shaft [Pa s²] from which on such tilt was seen to grow (from 6e-5 on); a rung
/// that is checked in the plane would not see it.
const TILTS: f64 = 5e-5;
/// How far apart two motions start that show whether the motion is chaotic [m], and the size of the spindle's displacements [m].
const DISPLACEMENT: f64 = 1e-10;
const STATIC_DISPLACEMENT: f64 = 1e-6;
/// States of the rungs that integrate the spindle alone.
const SPINDLE_STATES: usize = 4;
/// Relative tolerance of the dynamics in a check: errs by some 2e-4 dB.
const CHECK_TOLERANCE: f64 = 1e-4;

impl Rung {
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
            Self::SpindleOnly => reduced::unable(scene, needs, outputs).or_else(condensed),
            Self::Periodic => reduced::unable_periodic(scene, needs, outputs).or_else(condensed),
        }
    }
}

/// What the equations of a scene hold on a rung asked for by name, or on the dynamics that the scene needs: these without single
/// terms that it can do without by judgement. Reduced rungs, which would save nothing by that, have all.
pub fn needs(scene: &Scene, outputs: &Outputs, rung: Option<Rung>, model_tolerance_db: f64) -> Result<Needs, Unmet> {
    let Some(rung) = rung.filter(|rung| rung.is_reduced()) else {
        if rung == Some(Rung::Full) && scene.terms.get(Term::CageTilt) == TermChoice::Off {
            return Err(Unmet::Rung { rung: Rung::Full, reason: "terms.cage_tilt is off".into() });
        }
        return Ok(judgement::within(Needs::of(scene, outputs, rung)?, scene, outputs, model_tolerance_db));
    };
    if let Some(reason) = rung.refusal(scene, &Needs::of(scene, outputs, Some(Rung::Full))?, outputs) {
        return Err(Unmet::Rung { rung, reason });
    }
    let mut needs = Needs::of(scene, outputs, Some(Rung::Planar))?;
    needs.left_out.retain(|left_out| left_out.term != Term::CageTilt.name() || left_out.by == Grounds::Identity);
    let tilts = !needs.left_out.iter().any(|left_out| left_out.term == Term::CageTilt.name());
    needs.left_out.extend(omissions(rung, tilts));
    Ok(needs)
}

/// What a reduced rung leaves out by judgement; the bound is that of its check, of all together.
fn omissions(rung: Rung, tilts: bool) -> Vec<LeftOut> {
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
    if rung != Rung::RadiallyCondensed {
        all.push(one(Term::Cage, "balls go round equally spaced, at the speed of ideal rolling"));
        all.push(one(Term::BallSpinDynamics, "balls roll ideally"));
    }
    all
}

/// The rungs that are tried, the leanest first; the last one is sure to serve.
pub fn tried(scene: &Scene, settings: &RunSettings) -> Result<Vec<Rung>, Unmet> {
    if let Some(rung) = settings.rung {
        return Ok(vec![rung]);
    }
    let dynamics = Needs::of(scene, &settings.outputs, None)?;
    let mut rungs = if not_tried(scene, settings, &dynamics).is_none() {
        let serves = |rung: &Rung| {
            (*rung == Rung::RadiallyCondensed || lean_not_tried(scene).is_none())
                && rung.refusal(scene, &dynamics, &settings.outputs).is_none()
        };
        Rung::REDUCED.into_iter().filter(serves).collect()
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
    } else if check_time(scene) > WORTH_IT * (settings.settle + settings.duration) {
        Some("its check would take too large a part of the run")
    } else {
        None
    }
}

/// Why no rung leaner than the condensed one is tried; `None`: nothing speaks against it.
fn lean_not_tried(scene: &Scene) -> Option<&'static str> {
    let tilts = scene.lubricant.viscosity > TILTS * scene.operating_speed().abs();
    tilts.then_some(
        "at so low a speed so viscous a lubricant may let cage and balls tilt, which their check would not see",
    )
}

/// Times of a check: before the stretch that is compared, and of that [s].
fn check_times(scene: &Scene) -> (f64, f64) {
    let orbit = (kinematics::ideal_orbit_ratio(&scene.bearing) * scene.operating_speed()).abs();
    let passage = std::f64::consts::TAU / (scene.bearing.parameters.ball_count as f64 * orbit);
    (passage.max(CHECK_SETTLES), (CHECKED_PASSAGES * passage).max(CHECKED))
}

/// What the dynamics simulate to check a reduced rung [s].
pub fn check_time(scene: &Scene) -> f64 {
    let (settle, duration) = check_times(scene);
    settle + duration
}

/// What a reduced rung has shown beside the next richer one.
#[derive(Debug, Clone)]
struct Check {
    against: Rung,
    /// [s]
    stretch: f64,
    distance: Distance,
    /// Where the reduced rung's own slow motions had come to.
    reached: Reached,
    /// The step it was made with, where that is not the rung's own [s].
    step: Option<f64>,
    /// Why it tells nothing of the run.
    fault: Option<String>,
}

/// How far slow motions have gone: slip of the cage, and balls that wander in their pockets. What they change shows later than a
/// check from the start.
#[derive(Debug, Clone, Copy, Default)]
struct Reached {
    /// [rad/s]
    cage_speed: f64,
    /// [m]
    wander: Option<f64>,
}

impl Reached {
    fn of(recording: &Recording) -> Self {
        Self { cage_speed: recording.cage_speed, wander: recording.wander }
    }

    /// What has gone on after the check; `None`: nothing that matters.
    fn gone_on(&self, later: &Self, scene: &Scene) -> Option<String> {
        let slipped = (later.cage_speed - self.cage_speed).abs() / self.cage_speed.max(f64::MIN_POSITIVE);
        let p = &scene.bearing.parameters;
        let spacing = 0.5 * std::f64::consts::TAU * p.pitch_diameter / p.ball_count as f64;
        let wandered = self.wander.zip(later.wander).map_or(0.0, |(before, after)| (after - before) / spacing);
        if slipped > SLIPPED {
            Some(format!("the cage's speed changed by {:.1} % after the check", 100.0 * slipped))
        } else if wandered > WANDERED {
            Some(format!(
                "balls went {:.1} % of their spacing further in their pockets after the check",
                100.0 * wandered
            ))
        } else {
            None
        }
    }
}

/// Whether the spindle is thrown about against what holds it, and comes to rest slowly: then it may leave its balls at times, and what
/// becomes of that shows long after a check; `None`: it does not.
fn thrown_about(scene: &Scene, outputs: &Outputs, recording: &Recording) -> Option<String> {
    let rms = |channel| recording.of(channel).map_or(0.0, |signal| signal.in_band().moments.rms());
    let [x, y, z] = distance::ACCELERATIONS.map(rms);
    let mass = scene.spindle.mass;
    let held = (scene.operation.load[1] + mass * scene.gravity).hypot(scene.operation.load[2]);
    let share = mass * x.hypot(y).hypot(z) / held.max(f64::MIN_POSITIVE);
    let damping = RadiallyCondensed::new(scene, outputs).map_or(0.0, |model| model.spindle_damping());
    (share > THROWN && damping * check_time(scene) < COMES_TO_REST).then(|| {
        format!("the spindle is thrown about, by {:.0} % (rms) of what load and weight hold it with", 100.0 * share)
    })
}

impl Check {
    /// Whether everything that was asked for differs by no more than is allowed beside so many decibels of the level.
    fn confirms(&self, outputs: &Outputs, tolerance_db: f64) -> bool {
        self.distance.within(outputs, tolerance_db)
    }

    /// One that could not be made.
    fn failed(fault: String) -> Self {
        let distance = Distance::UNKNOWN;
        Self {
            against: Rung::Full,
            stretch: 0.0,
            distance,
            reached: Reached::default(),
            step: None,
            fault: Some(fault),
        }
    }

    fn how(&self) -> String {
        match &self.fault {
            Some(fault) => format!("no error is stated: {fault}"),
            None => format!("model and integration together: {}, {}", self.words(), distance::WORST),
        }
    }

    fn words(&self) -> String {
        if let Some(fault) = &self.fault {
            return format!("not checked: {fault}");
        }
        let against = format!("{:.3} ms on the rung {}, from the same start", 1e3 * self.stretch, self.against.name());
        match (self.distance.levels.worst(), self.distance.quantities) {
            (Some(level), Some(q)) => {
                // Those that were not asked for are 0.
                let others = [("slip", q.max_slip), ("pocket load", q.max_pocket_load), ("cage orbit", q.orbit_radius)];
                let others: String = others
                    .into_iter()
                    .filter(|(_, error)| *error > 0.0)
                    .map(|(name, error)| format!(", {name} {:.2} %", 100.0 * error))
                    .collect();
                let (load, speed) = (100.0 * q.max_load, 100.0 * q.cage_speed);
                format!(
                    "{against}: level {level:.4} dB, largest load {load:.3} %, cage speed {speed:.4} %{others} apart"
                )
            }
            (Some(level), None) => format!("{against}: level {level:.4} dB apart"),
            (None, _) => format!("{against}: nothing moves that could be compared"),
        }
    }
}

/// The result of the leanest reduced rung that serves; `None`: the dynamics have to. With what the others have shown, in words.
pub(super) fn run(
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
    for rung in tried(scene, settings)?.into_iter().filter(|rung| rung.is_reduced()) {
        match on_rung(rung, scene, settings, begin, control) {
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
    rung: Rung,
    scene: &Scene,
    settings: &RunSettings,
    begin: Instant,
    control: &Control<'_>,
) -> Result<Result<RunResult, String>, SimulationError> {
    let part = |from: f64, to: f64| move |share: f64| (control.progress)(from + share * (to - from));
    let (checking, running) = (part(0.0, CHECK_SHARE), part(CHECK_SHARE, 1.0));
    // The check decides, so it comes first.
    (control.live)(&Live::of(Phase::Checking));
    let check = match check(rung, scene, settings, &Control { progress: &checking, ..control.aside() }) {
        Ok(check) => check,
        // A rung by name is run whatever its check shows.
        Err(error) if settings.rung.is_some() && !matches!(error, SimulationError::Stopped { .. }) => {
            Check::failed(error.to_string())
        }
        Err(error) => return Err(error),
    };
    let confirmed = check.confirms(&settings.outputs, rung.allowed(settings.model_tolerance_db));
    if !confirmed && settings.rung.is_none() {
        return Ok(Err(check.words()));
    }
    let stepped = RunSettings { fixed_step: settings.fixed_step.or(check.step), ..settings.clone() };
    let made = record(rung, scene, &stepped, &Control { progress: &running, ..*control })?;
    (control.live)(&Live::of(Phase::Judging));
    let gone_on = (rung == Rung::RadiallyCondensed && check.fault.is_none())
        .then(|| check.reached.gone_on(&Reached::of(&made.recording), scene))
        .flatten()
        .or_else(|| thrown_about(scene, &settings.outputs, &made.recording));
    if let (Some(what), None) = (&gone_on, settings.rung) {
        return Ok(Err(format!("{what}, and the check tells nothing of that")));
    }
    let turns = scene.operating_speed() != 0.0;
    let parted = match parted(rung, scene, &stepped, &made, control) {
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
    Ok(Ok(summarise(rung, scene, settings, &made, (&check, gone_on), parted, begin)?))
}

/// What a reduced rung has left behind, and its first-order states.
struct Made {
    recording: Recording,
    statistics: Statistics,
    states: usize,
}

fn record(rung: Rung, scene: &Scene, settings: &RunSettings, control: &Control<'_>) -> Result<Made, SimulationError> {
    let (recording, statistics) = match rung {
        Rung::Periodic => reduced::simulate_periodic(scene, settings, control)?,
        Rung::SpindleOnly => reduced::simulate(scene, settings, control)?,
        _ => radially_condensed::simulate(scene, settings, control)?,
    };
    let states = match rung {
        Rung::Periodic | Rung::SpindleOnly => SPINDLE_STATES,
        _ => RadiallyCondensed::new(scene, &settings.outputs)?.states(),
    };
    Ok(Made { recording, statistics, states })
}

/// The short run of a check.
fn check_settings(rung: Rung, scene: &Scene, settings: &RunSettings) -> RunSettings {
    let (settle, duration) = check_times(scene);
    // A rung that was asked for by name may be of a run that is shorter than a ball passage.
    let (mut settle, mut duration) =
        (settle.min(settings.settle.max(CHECK_SETTLES)), duration.min(settings.duration.max(CHECKED)));
    if rung != Rung::RadiallyCondensed {
        // The richer rung costs little; and a periodic motion is none from the start.
        settle = settle.max(settings.settle);
        duration = settings.duration.min(LONGER * duration).max(duration);
    }
    let outputs = Outputs { spectra: Vec::new(), series: Vec::new(), ..settings.outputs.clone() };
    RunSettings { method: Method::Auto, fixed_step: None, settle, duration, outputs, ..settings.clone() }
}

/// A short run of the rung beside one of the next richer rung.
fn check(rung: Rung, scene: &Scene, settings: &RunSettings, control: &Control<'_>) -> Result<Check, SimulationError> {
    let quiet = Control::until(control.stop);
    let short = check_settings(rung, scene, settings);
    let duration = short.duration;
    let mut own = record(rung, scene, &short, &quiet)?.recording;
    let mut leaves = None;
    let (against, richer) = if rung == Rung::RadiallyCondensed {
        let needs = Needs::of(scene, &short.outputs, None)?;
        let model = Model::new(scene, &needs);
        let start = run::start_state(&model)?;
        let tolerance = settings.tightest().max(CHECK_TOLERANCE);
        let stepping = Stepping { relative_tolerance: tolerance, ..Stepping::of(&short) };
        let by = |settings: &RunSettings, stepping: &Stepping| {
            let setup = Setup { model: &model, needs: &needs, settings, start: &start, whole: None };
            Ok(setup.attempt(stepping, (0.0, 1.0), control)?.recording)
        };
        let attempt = |settings: &RunSettings| {
            let Some(stepped) = stepped::checking(settings) else { return by(settings, &stepping) };
            match by(&stepped, &Stepping::of(&stepped)) {
                // What is too stiff for steps of a fixed length blows up.
                Err(SimulationError::Integration { .. }) => by(settings, &stepping),
                recording => recording,
            }
        };
        let richer = attempt(&short)?;
        leaves = leaving_the_plane(&richer, duration);
        if leaves.is_some() && duration < TELLS_LEAVING {
            // So short a stretch takes chance for growth.
            let long = RunSettings { duration: LONG_CHECK, ..short.clone() };
            leaves = leaving_the_plane(&attempt(&long)?, LONG_CHECK);
        }
        (needs.rung, richer)
    } else {
        (Rung::RadiallyCondensed, record(Rung::RadiallyCondensed, scene, &short, &quiet)?.recording)
    };
    let unseen = (1.0 - duration / settings.duration).max(0.0).sqrt();
    let mut distance = Distance::of_recordings(&own, &richer, unseen);
    let mut step = None;
    // Of a speed that varies the stretch tells nothing later.
    if rung == Rung::RadiallyCondensed
        && settings.fixed_step.is_none()
        && scene.operation.speed.is_constant()
        && let Some((longer, stepped)) = longer_step(scene, &short, &own, &quiet)
    {
        let by_it = Distance::of_recordings(&stepped, &richer, unseen);
        if by_it.within(&settings.outputs, settings.model_tolerance_db) {
            (own, distance, step) = (stepped, by_it, Some(longer));
        }
    }
    let reached = Reached::of(&own);
    let outputs = &settings.outputs;
    distance.quantities =
        distance.quantities.filter(|_| outputs.contacts || outputs.cage).map(|errors| QuantityErrors {
            // The run's largest load is at another approach than that of the check, where the law of its contacts errs otherwise.
            max_load: errors.max_load
                + if rung == Rung::RadiallyCondensed { condensed_contact::LOAD_ERROR } else { 0.0 },
            max_slip: if outputs.contacts { errors.max_slip } else { 0.0 },
            max_pocket_load: if outputs.cage { errors.max_pocket_load } else { 0.0 },
            orbit_radius: if outputs.cage { errors.orbit_radius } else { 0.0 },
            ..errors
        });
    let fault = if !scene.operation.speed.is_constant() {
        Some("the speed varies, and a check from the start tells nothing of later speeds".to_owned())
    } else if settings.duration < duration {
        Some("less is kept than a check compares".to_owned())
    } else {
        // Where levels are too far apart, they say so themselves.
        leaves.filter(|_| distance.within(&settings.outputs, settings.model_tolerance_db))
    };
    if fault.is_some() {
        distance = Distance::UNKNOWN;
    }
    Ok(Check { against, stretch: duration, distance, reached, step, fault })
}

/// The longest step of the condensed rung [s] that leaves it where its own steps take it, and the stretch of a check made with
/// it; `None`: its own.
fn longer_step(scene: &Scene, short: &RunSettings, own: &Recording, control: &Control<'_>) -> Option<(f64, Recording)> {
    let model = RadiallyCondensed::new(scene, &short.outputs).ok()?;
    model.longer_paces().find_map(|pace| {
        let (stepped, _) = model.run(short, pace, control).ok()?;
        let apart = Distance::of_recordings(&stepped, own, 0.0);
        apart.within(&short.outputs, SHARE_OF_STEPS * short.model_tolerance_db).then(|| (pace.step(), stepped))
    })
}

/// Why a motion that begins in the plane may not stay there, from a stretch of it [s]; `None`: nothing speaks against it. Planar motion solves the
/// equations but for a small tilt by the crown's seat, which in a viscous grease at low speed grows.
fn leaving_the_plane(recording: &Recording, stretch: f64) -> Option<String> {
    let most = |parts: &[Quantities]| parts.iter().fold(0.0, |most, part| f64::max(most, part.out_of_plane));
    let (first, second) = recording.parts.split_at(recording.parts.len() / 2);
    let (before, after) = (most(first), most(second));
    let rate = (after / before).ln() / (0.5 * stretch);
    let leaves = after > IN_PLANE && before > 0.0 && rate > LEAVING;
    leaves.then(|| {
        let degrees = |sine: f64| sine.asin().to_degrees();
        format!(
            "balls leave the plane: contact angles of {:.2}°, then {:.2}° within {:.0} ms",
            degrees(before),
            degrees(after),
            1e3 * stretch
        )
    })
}

/// Do two motions on the condensed rung that start next to each other part? On a leaner rung over the time of its check.
fn parted(
    rung: Rung,
    scene: &Scene,
    settings: &RunSettings,
    made: &Made,
    control: &Control<'_>,
) -> Result<Parted, SimulationError> {
    let quiet = Control::until(control.stop);
    let beside = |displacement, settings: &RunSettings| {
        radially_condensed::simulate_beside(scene, displacement, settings, &quiet).map(|(recording, _)| recording)
    };
    let of = |one: &Recording, other: &Recording, settings: &RunSettings| {
        let both = |channel: &Channel| Some((&*one.of(*channel)?.excerpts, &*other.of(*channel)?.excerpts));
        let pairs: Vec<Pairs<'_>> = distance::ACCELERATIONS.iter().filter_map(both).collect();
        let spacing = Windows::of(kept_values(settings.duration)).length;
        divergence::of_signals(&pairs, spacing, DISPLACEMENT / STATIC_DISPLACEMENT, settings.settle, RATE)
    };
    if rung == Rung::RadiallyCondensed {
        return Ok(of(&made.recording, &beside([DISPLACEMENT; 2], settings)?, settings));
    }
    let short = check_settings(rung, scene, settings);
    Ok(of(&beside([0.0; 2], &short)?, &beside([DISPLACEMENT; 2], &short)?, &short))
}

fn summarise(
    rung: Rung,
    scene: &Scene,
    settings: &RunSettings,
    made: &Made,
    (check, gone_on): (&Check, Option<String>),
    parted: Option<Parted>,
    begin: Instant,
) -> Result<RunResult, SimulationError> {
    let mut needs = needs(scene, &settings.outputs, Some(rung), settings.model_tolerance_db)?;
    let bound = check.distance.levels.worst().map(|error| (error, "dB"));
    for left_out in needs.left_out.iter_mut().filter(|left_out| left_out.by == Grounds::Judgement) {
        left_out.bound = bound;
    }
    let allowed = rung.allowed(settings.model_tolerance_db);
    let confirmed = check.confirms(&settings.outputs, allowed);
    let warning = (!confirmed).then(|| {
        format!("the rung {} was asked for and is not confirmed within {} dB: {}", rung.name(), allowed, check.words())
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
    let warning = warning.or(gone_on.map(|what| format!("{what}: the error of the level is not known"))).or(chaotic);
    let (mut level_errors, mut how) = (check.distance.levels, check.how());
    if by_chance {
        level_errors = level_errors.larger(accuracy::sampling_errors(&made.recording));
        how =
            format!("the motion is chaotic: standard error of the level by ten batch means, or {how}, if that is more");
    }
    let accuracy = AccuracyReport {
        level_errors,
        quantity_errors: check.distance.quantities.filter(|_| !by_chance),
        how,
        motion,
        divergence_rate: parted.map_or(0.0, |parted| parted.rate),
        warning,
    }
    .with_settling(&made.recording, scene.operation.speed.is_constant());
    let mechanism = Mechanism::new(scene, &needs);
    Ok(RunResult::new(scene, settings, &mechanism, &made.recording, solver, accuracy, needs.left_out))
}
