//! The check of a reduced rung: a short run of it beside one of the next richer rung, and what of the run such a check cannot tell.

use super::record;
use crate::numerics::ode::Method;
use crate::numerics::statistics::CentralMoments;
use crate::physics::kinematics;
use crate::simulation::error::comparison::{self, Distance};
use crate::simulation::input::channel::Channel;
use crate::simulation::input::control::Control;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::model::radially_condensed::RadiallyCondensed;
use crate::simulation::model::terms::Needs;
use crate::simulation::model::{Model, condensed_contact};
use crate::simulation::recording::record::Quantities;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::ACCELERATIONS;
use crate::simulation::recording::sampling::BATCHES;
use crate::simulation::solve::fixed_step;
use crate::simulation::solve::run::Setup;
use crate::simulation::solve::startup::Beginning;

/// Stretch of a check, and what comes before it [s], which takes long enough for the run's start to be forgotten: over 6 ms after 2, single
/// levels that were off by a tenth of a decibel and more showed a fifth of that. Of a short run they are this share, and at least so
/// long; and a check holds so many ball passages at least.
const CHECKED: f64 = 12e-3;
const CHECK_SETTLES: f64 = 10e-3;
const SHARE_OF_RUN: f64 = 0.1;
const LEAST_CHECKED: f64 = 6e-3;
const LEAST_SETTLED: f64 = 2e-3;
const CHECKED_PASSAGES: f64 = 3.0;
/// How much longer a check is that costs little.
const LONGER: f64 = 2.0;
/// Share of the tolerance by which longer steps of the condensed rung may move its levels over a check [-]. They move those of the
/// run as much: what both miss is in the distance from the dynamics.
const SHARE_OF_STEPS: f64 = 0.5;
/// Change of the cage's speed after a check, and of the balls' places in their pockets as a share of their spacing, from which on the
/// check tells nothing of the run: levels were off by decibels at twenty and three per cent, by a twentieth at one and a half.
const SLIPPED: f64 = 5e-3;
const WANDERED: f64 = 1e-2;
/// Rms of the spindle's inertia over the force that holds it, from which on a check tells nothing of a run on which the spindle comes
/// to rest slowly: levels of heavy, lightly loaded spindles were off by a tenth of a decibel to four (`tests/limits/ladder.rs`).
const THROWN: f64 = 0.1;
/// Damping times the time of a check [e-folds] from which on the check shows how the spindle comes to rest.
const COMES_TO_REST: f64 = 2.0;
/// Scatter of a level along a run [dB], over its batches, from which on the stretch of a check does not stand for the rest: lightly loaded spindles that
/// beat or come to rest over tenths of a second had levels of 0.02 to 0.1 dB off that stated a fifth of that.
const UNEVEN: f64 = 1.5;
/// Sine of a contact angle below which balls count as in the plane [-]; the rate at which larger ones grow from which on the balls are leaving it [1/s]: tilt
/// that grew to degrees and decibels grew by 18 to 70 a second, and where it did not, the angles of a check's halves were up to a tenth
/// apart over 8 ms. And the least stretch that tells such a rate [s].
const IN_PLANE: f64 = 5e-4;
/// The same from which on they are out of it, whether it grows or not: of twenty scenes levels were off by 0.02 to 0.4 dB above it, and by
/// 0.04 dB at most below.
const OUT_OF_PLANE: f64 = 2.5e-3;
const LEAVING: f64 = 12.0;
const TELLS_LEAVING: f64 = 0.025;
const LONG_CHECK: f64 = 0.03;
/// Relative tolerance of the dynamics in a check: errs by some 2e-4 dB.
const CHECK_TOLERANCE: f64 = 1e-4;

/// Times of a check: before the stretch that is compared, and of that [s].
fn check_times(scene: &Scene, settings: &RunSettings) -> (f64, f64) {
    let orbit = (kinematics::ideal_orbit_ratio(&scene.bearing) * scene.operating_speed()).abs();
    let passage = std::f64::consts::TAU / (scene.bearing.parameters.ball_count as f64 * orbit);
    let share = SHARE_OF_RUN * (settings.settle + settings.duration);
    let settle = share.clamp(LEAST_SETTLED, CHECK_SETTLES);
    (passage.max(settle), (CHECKED_PASSAGES * passage).max(share.clamp(LEAST_CHECKED, CHECKED)))
}

/// What the dynamics simulate to check a reduced rung [s].
pub fn check_time(scene: &Scene, settings: &RunSettings) -> f64 {
    let (settle, duration) = check_times(scene, settings);
    settle + duration
}

/// What a reduced rung has shown beside the next richer one.
#[derive(Debug, Clone)]
pub(crate) struct Check {
    against: ModelLevel,
    /// [s]
    stretch: f64,
    pub distance: Distance,
    /// Where the reduced rung's own slow motions had come to.
    pub reached: Reached,
    /// The step it was made with, where that is not the rung's own [s].
    pub step: Option<f64>,
    /// Why it tells nothing of the run.
    pub fault: Option<String>,
}

/// How far slow motions have gone: slip of the cage, and balls that wander in their pockets. What they change shows later than a
/// check from the start.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Reached {
    /// [rad/s]
    cage_speed: f64,
    /// [m]
    wander: Option<f64>,
}

impl Reached {
    pub fn of(recording: &Recording) -> Self {
        Self { cage_speed: recording.cage_speed, wander: recording.wander }
    }

    /// What has gone on after the check; `None`: nothing that matters.
    pub fn gone_on(&self, later: &Self, scene: &Scene) -> Option<String> {
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
pub(crate) fn thrown_about(scene: &Scene, settings: &RunSettings, recording: &Recording) -> Option<String> {
    let rms = |channel| recording.of(channel).map_or(0.0, |signal| signal.in_band().moments.rms());
    let [x, y, z] = ACCELERATIONS.map(rms);
    let mass = scene.spindle.mass;
    let held = (scene.operation.load[1] + mass * scene.gravity).hypot(scene.operation.load[2]);
    let share = mass * x.hypot(y).hypot(z) / held.max(f64::MIN_POSITIVE);
    let model = || RadiallyCondensed::new(scene, &settings.outputs);
    let damping = || model().map_or(0.0, |model| model.spindle_damping());
    (share > THROWN && damping() * check_time(scene, settings) < COMES_TO_REST).then(|| {
        format!("the spindle is thrown about, by {:.0} % (rms) of what load and weight hold it with", 100.0 * share)
    })
}

/// Whether a level goes up and down along the run by so much that its beginning does not stand for the rest; `None`: it does.
pub(crate) fn uneven(recording: &Recording) -> Option<String> {
    let scatter = |channel: &Channel| {
        let parts = comparison::in_parts(&recording.of(*channel)?.in_band().mean_squares, BATCHES);
        let levels: Vec<f64> = parts.iter().map(|square| 10.0 * square.max(f64::MIN_POSITIVE).log10()).collect();
        Some((*channel, CentralMoments::of(&levels).rms()))
    };
    let all = comparison::judged(recording).into_iter().filter_map(|channel| scatter(&channel));
    let (channel, scatter) = all.max_by(|(_, a), (_, b)| a.total_cmp(b)).filter(|(_, scatter)| *scatter > UNEVEN)?;
    Some(format!("the level of {channel} scatters by {scatter:.1} dB along the run"))
}

impl Check {
    /// Whether everything that was asked for differs by no more than is allowed beside so many decibels of the level.
    pub fn confirms(&self, outputs: &Outputs, tolerance_db: f64) -> bool {
        self.distance.within(outputs, tolerance_db)
    }

    /// One that could not be made.
    pub fn failed(fault: String) -> Self {
        let distance = Distance::UNKNOWN;
        Self {
            against: ModelLevel::Full,
            stretch: 0.0,
            distance,
            reached: Reached::default(),
            step: None,
            fault: Some(fault),
        }
    }

    pub fn how(&self) -> String {
        match &self.fault {
            Some(fault) => format!("no error is stated: {fault}"),
            None => format!("model and integration together: {}, {}", self.words(), comparison::WORST),
        }
    }

    pub fn words(&self) -> String {
        self.told(&self.distance.words())
    }

    /// The same where it does not confirm.
    pub fn words_beyond(&self, outputs: &Outputs, tolerance_db: f64) -> String {
        self.told(&self.distance.words_beyond(outputs, tolerance_db))
    }

    fn told(&self, distance: &str) -> String {
        if let Some(fault) = &self.fault {
            return format!("not checked: {fault}");
        }
        format!("{:.3} ms on the rung {}, from the same start: {distance}", 1e3 * self.stretch, self.against.name())
    }
}

/// The short run of a check.
pub(crate) fn check_settings(rung: ModelLevel, scene: &Scene, settings: &RunSettings) -> RunSettings {
    let (settle, duration) = check_times(scene, settings);
    // A rung that was asked for by name may be of a run that is shorter than a ball passage.
    // And what the start does is in the check where it is in the run.
    let (mut settle, mut duration) = (settle.min(settings.settle), duration.min(settings.duration.max(LEAST_CHECKED)));
    if rung != ModelLevel::RadiallyCondensed {
        // The richer rung costs little; and a periodic motion is none from the start.
        settle = settle.max(settings.settle).max(LEAST_SETTLED);
        duration = settings.duration.min(LONGER * duration).max(duration);
    }
    let outputs = Outputs { spectra: Vec::new(), series: Vec::new(), ..settings.outputs.clone() };
    RunSettings { method: Method::Auto, fixed_step: None, settle, duration, outputs, ..settings.clone() }
}

/// A short run of the rung beside one of the next richer rung.
pub(crate) fn check(
    rung: ModelLevel,
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<Check, SimulationError> {
    let quiet = Control::until(control.stop);
    let short = check_settings(rung, scene, settings);
    let duration = short.duration;
    let mut own = record(rung, scene, &short, &quiet)?.recording;
    let mut leaves = None;
    let (against, richer) = if rung == ModelLevel::RadiallyCondensed {
        let needs = Needs::of(scene, &short.outputs, None)?;
        let model = Model::new(scene, &needs);
        let beginning = Beginning::at_rest(&model)?;
        let tolerance = settings.tightest().max(CHECK_TOLERANCE);
        let stepping = Stepping { relative_tolerance: tolerance, ..Stepping::of(&short) };
        let by = |settings: &RunSettings, stepping: &Stepping| {
            let setup = Setup { model: &model, needs: &needs, settings, beginning: &beginning, whole: None };
            Ok(setup.attempt(stepping, (0.0, 1.0), control)?.recording)
        };
        let attempt = |settings: &RunSettings| {
            let Some(stepped) = fixed_step::checking(settings) else { return by(settings, &stepping) };
            match by(&stepped, &Stepping::of(&stepped)) {
                // What is too stiff for steps of a fixed length blows up.
                Err(SimulationError::Integration { .. }) => by(settings, &stepping),
                recording => recording,
            }
        };
        let richer = attempt(&short)?;
        leaves = leaving_the_plane(&richer, duration);
        if duration < TELLS_LEAVING && leaves.is_some() {
            // So short a stretch takes chance for growth.
            let long = RunSettings { duration: LONG_CHECK, ..short.clone() };
            leaves = leaving_the_plane(&attempt(&long)?, LONG_CHECK);
        }
        (needs.rung, richer)
    } else {
        (ModelLevel::RadiallyCondensed, record(ModelLevel::RadiallyCondensed, scene, &short, &quiet)?.recording)
    };
    let unseen = (1.0 - duration / settings.duration).max(0.0).sqrt();
    let mut distance = Distance::of_recordings(&own, &richer, unseen);
    let mut step = None;
    // Of a speed that varies the stretch tells nothing later.
    if rung == ModelLevel::RadiallyCondensed
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
    distance = distance.of_asked(&settings.outputs);
    if rung == ModelLevel::RadiallyCondensed
        && let Some(errors) = &mut distance.quantities
    {
        // The run's largest load is at another approach than that of the check, where the law of its contacts errs otherwise.
        errors.max_load += condensed_contact::LOAD_ERROR;
    }
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
    (leaves || after > OUT_OF_PLANE).then(|| {
        let degrees = |sine: f64| sine.asin().to_degrees();
        format!(
            "balls leave the plane: contact angles of {:.2}°, then {:.2}° within {:.0} ms",
            degrees(before),
            degrees(after),
            1e3 * stretch
        )
    })
}
