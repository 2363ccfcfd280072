//! Start-up of a run. The spindle vibrates freely on its contacts until their damping has removed this initial transient. Few contacts act across
//! the load, so vibration in that direction decays many times more slowly than along the load. All attempts at a run of the dynamics share the
//! start-up phase, except for the last turns of the cage.

use crate::simulation::error::codes::Warning;
use crate::simulation::error::thresholds::MIN_DECAY_EFOLDS;
use crate::simulation::solve::eligibility;
use nalgebra::{Matrix3, Vector3};

use crate::numerics::ode::{Method, Statistics};
use crate::physics::kinematics::{self, RingSpeeds};
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::equilibrium::{equilibrium, start_state};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::{Span, Stepping, integrate};
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::model::{FadingDamping, Mechanism, Model};
use crate::simulation::solve::fixed_step;

/// Decay after which free vibration is treated as gone [e-folds]. A vibration five times as strong as the stationary one then adds less than 0.05
/// dB to its level.
pub const SETTLED_EFOLDS: f64 = 4.0;
/// Longest settling time that is allowed for this decay [s].
pub const MAX_SETTLE_S: f64 = 5.0;
/// Turns of the cage in which balls, cage and film settle [-], and the range of the resulting time [s].
pub const SETTLE_CAGE_TURNS: f64 = 3.0;
pub const CAGE_SETTLE_RANGE_S: [f64; 2] = [0.02, 1.0];
/// Settling time beyond `turning_time`, over `turning_time`, from which the attempts share the first part of it [-].
const SHARED: f64 = 2.0;
/// Least shared part of the settling time if contacts have a contact angle and all carry load [-], and shortest shared time [s]. The cage then
/// vibrates along its axis, on films that hardly damp this motion.
const AXIAL_SHARED: f64 = 2.0 / 3.0;
const LEAST_SHARED: f64 = 0.01;
/// Decay rate of the spindle's free vibration from which the attractor is unique [1/s]. Below 5/s, some vibrations grow slowly by themselves after
/// a quiet start, or reach a different motion after a strongly disturbed start.
const UNIQUE_DECAY_PER_S: f64 = 10.0;
/// Time after which the axial vibration of the cage has mostly decayed [s].
const CAGE_SETTLE_S: f64 = 2.0;
/// Time after which the tilting of cage and balls has mostly ended [s].
const TILT_SETTLE_S: f64 = 4.0;
/// Rate of the damping at the start [1/s]. Vibration falls by at least 7 e-folds before the damping has faded, and steps of 7.5 µs resolve it.
const START_DAMPING_PER_S: f64 = 2000.0;

/// Positions of unequal balls over a turn of the cage whose equilibria are averaged [-]. In seven scenes of 7 to 32 balls their mean decay is within
/// 5 % of that of every half ball spacing; 8 positions are up to 18 % off, 2 up to all of it. An equilibrium of many balls takes milliseconds.
const UNEQUAL_POSITIONS: usize = 16;

/// Error control of the start-up phase, used if all fixed steps diverge. Its error decays with the initial transient.
const STARTUP_TOLERANCE: Stepping =
    Stepping { method: Method::Auto, relative_tolerance: 1e-3, fixed_step: None, most_evaluations: None };

/// Static equilibrium of the spindle on its contacts.
struct StaticSupport {
    /// Slowest decay rate of the free vibration of the spindle [1/s].
    decay: f64,
    /// Every ball carries load at every position, so that no ball knocks.
    all_carry: bool,
    /// Contacts have a contact angle, and there is a cage that vibrates along the axis.
    has_axial_motion_or_tilt: bool,
}

impl StaticSupport {
    /// The attractor is unique.
    fn has_one_attractor(&self) -> bool {
        self.all_carry && self.decay > UNIQUE_DECAY_PER_S
    }

    /// Equilibrium under load, weight and centrifugal force at the operating speed; `None` if the spindle has no equilibrium.
    fn of(scene: &Scene) -> Option<Self> {
        // The requested outputs do not change the static support.
        let outputs = Outputs::vibration();
        let mut mechanism = Mechanism::new(scene, &ActiveTerms::of(scene, &outputs, None).ok()?);
        let law = scene.raceway_damping.resolve();
        // The balls orbit. Positions are averaged: one ball below the load, and half a ball spacing further; more where balls differ.
        let (mut damping, mut all_carry) = (Matrix3::zeros(), true);
        let balls = mechanism.layout.balls;
        let halfway = 0.5 * std::f64::consts::TAU / balls as f64;
        // A step of an odd number of half spacings puts balls below the load and beside it in turn.
        let (positions, step) = match scene.has_unequal_balls() {
            true => (UNEQUAL_POSITIONS, (2 * balls / UNEQUAL_POSITIONS) | 1),
            false => (2, 1),
        };
        for position in 0..positions {
            mechanism.start = mechanism.start.turned(if position == 0 { 0.0 } else { step as f64 * halfway });
            let rest = equilibrium(&mechanism, scene.operating_speeds()).ok()?;
            let [x, y, z] = rest.spindle;
            for (ball, load) in rest.loads.iter().enumerate() {
                if load.inner <= 0.0 {
                    all_carry = false;
                    continue;
                }
                // Two contacts in series have half of the damping of one.
                let both = 0.5 / positions as f64 * (law.chi * load.inner + law.viscous);
                let (cosine, sine) = (mechanism.start.cosine[ball], mechanism.start.sine[ball]);
                let (axial, radial) = rest.balls[ball];
                let radius = mechanism.pitch_radius + radial - (y * cosine + z * sine);
                let (_, (along, outwards)) = mechanism.raceway.inner.penetration::<false>(axial - x, radius);
                let towards = Vector3::new(along, outwards * cosine, outwards * sine);
                damping += both * towards * towards.transpose();
            }
        }
        let least = match mechanism.layout.axial_spindle {
            true => damping.symmetric_eigenvalues().min(),
            false => damping.fixed_view::<2, 2>(1, 1).into_owned().symmetric_eigenvalues().min(),
        };
        let has_axial_motion_or_tilt = mechanism.has_axial_motion_or_tilt() && mechanism.layout.cage;
        Some(Self { decay: 0.5 * least / mechanism.spindle_mass, all_carry, has_axial_motion_or_tilt })
    }
}

/// Slowest decay rate of the free vibration of the spindle by the damping of its contacts at rest [1/s]. Axial vibration is included if the spindle
/// moves along its axis. `None` if the spindle does not rest on contacts that damp it.
pub fn decay_rate(scene: &Scene) -> Option<f64> {
    StaticSupport::of(scene).map(|rest| rest.decay).filter(|rate| *rate > 0.0)
}

/// Settling time for the decay of the initial transient [s], at most `MAX_SETTLE_S`. It includes the axial vibration of the cage if the start is
/// not damped. `None` as for [`decay_rate`], and where speed or loads change, because settling would skip a part of their course.
pub fn settling_time(scene: &Scene) -> Option<f64> {
    let rest = StaticSupport::of(scene).filter(|rest| rest.decay > 0.0 && scene.operation.is_steady())?;
    let of_cage =
        if rest.has_axial_motion_or_tilt && rest.all_carry && !rest.has_one_attractor() { CAGE_SETTLE_S } else { 0.0 };
    Some((SETTLED_EFOLDS / rest.decay).clamp(of_cage, MAX_SETTLE_S))
}

/// Time in which balls and cage settle [s], by turns of the cage relative to the outer ring, independent of the decay of the spindle's vibration.
pub fn turning_time(scene: &Scene) -> f64 {
    let turn = scene.operating_speeds().relative().abs() / std::f64::consts::TAU
        * kinematics::ideal_orbit_ratio(&scene.bearing);
    if turn > 0.0 {
        (SETTLE_CAGE_TURNS / turn).clamp(CAGE_SETTLE_RANGE_S[0], CAGE_SETTLE_RANGE_S[1])
    } else {
        CAGE_SETTLE_RANGE_S[0]
    }
}

/// Start-up phase that all attempts reuse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartupPhase {
    /// End of the phase, counted from the start of the run [s]; 0: no shared phase.
    pub time: f64,
    /// Additional damping that fades out before the phase ends; `None`: no additional damping.
    damping: Option<FadingDamping>,
}

impl StartupPhase {
    const NOTHING: Self = Self { time: 0.0, damping: None };

    /// Start-up phase of a run. Attempts share nothing if the initial transient has not decayed, if the attractor may not be unique, or if the start is perturbed. The
    /// recorded motion then belongs to one start, and each attempt has to begin from that start.
    pub fn of(scene: &Scene, model: &Model, settings: &RunSettings) -> Self {
        let (settle, turning) = (settings.settle, turning_time(scene));
        let mechanism = model.mechanism();
        let is_forgotten = mechanism.raceway.inner.is_damped() && mechanism.perturbation.is_none();
        if !scene.operation.is_steady() || !is_forgotten || settings.fixed_step.is_some() {
            return Self::NOTHING;
        }
        let time = settle - turning.min(settle * (1.0 - AXIAL_SHARED));
        let turns = mechanism.rotation.speeds(0.0) != RingSpeeds::default();
        if mechanism.has_axial_motion_or_tilt()
            && turns
            && time >= LEAST_SHARED
            && StaticSupport::of(scene).is_some_and(|rest| rest.has_one_attractor())
        {
            // The damping fades slowly compared with every vibration, also that of a heavy spindle.
            let end = turning.max(0.5 * time).min(time);
            return Self { time, damping: Some(FadingDamping { rate: START_DAMPING_PER_S, end }) };
        }
        if settle <= (1.0 + SHARED) * turning || !fixed_step::is_free(settings) {
            return Self::NOTHING;
        }
        // The default settling time is rounded to three digits, hence 0.99.
        let forgets = settling_time(scene).is_some_and(|time| settle >= 0.99 * time);
        if forgets { Self { time: settle - turning, damping: None } } else { Self::NOTHING }
    }
}

/// Initial state of all attempts at a run.
#[derive(Debug, Clone)]
pub struct InitialState {
    /// [s]
    pub time: f64,
    /// Damping has removed the vibration that only the start excited.
    pub is_damped: bool,
    pub state: Vec<f64>,
    /// Work of the integration up to this state.
    pub work: Statistics,
}

impl InitialState {
    /// Equilibrium at time 0.
    pub fn at_rest(model: &Model) -> Result<Self, SimulationError> {
        Ok(Self { time: 0.0, is_damped: false, state: start_state(model)?, work: Statistics::default() })
    }

    /// State after the shared phase, in the steps that serve.
    pub fn after(shared: &StartupPhase, model: &Model, control: &Control<'_>) -> Result<Self, SimulationError> {
        Self::after_in(shared, None, model, control)
    }

    /// State after the shared phase. Attempts and their repetitions only have the rest of the settling time before them. Long fixed steps are tried
    /// first, because they hardly change undamped vibration. Levels that had not settled after a second differed by at most 0.0015 dB between this
    /// step and a quarter of it. If the long steps diverge, shorter ones follow, then error control. `stepping`: only these steps.
    pub(crate) fn after_in(
        shared: &StartupPhase,
        stepping: Option<Stepping>,
        model: &Model,
        control: &Control<'_>,
    ) -> Result<Self, SimulationError> {
        let start = Self::at_rest(model)?;
        let &StartupPhase { time, damping } = shared;
        if time == 0.0 {
            return Ok(start);
        }
        let damped = damping.map(|damping| model.damped(damping));
        let model = damped.as_ref().unwrap_or(model);
        let span = Span { start: 0.0, end: time, checkpoint: time, share: (0.0, 1.0) };
        (control.live)(&Live::of(Phase::Settling));
        let steppings = match stepping {
            Some(stepping) => vec![stepping],
            None => fixed_step::lengths(model).map(fixed_step::by).chain([STARTUP_TOLERANCE]).collect(),
        };
        for stepping in steppings {
            match integrate(model, &start.state, &stepping, &span, control, |_| ()) {
                Ok(settled) => {
                    let is_damped = damping.is_some();
                    return Ok(Self { time, is_damped, state: settled.checkpoint, work: settled.statistics });
                }
                Err(stopped @ SimulationError::Stopped { .. }) => return Err(stopped),
                Err(_) => {}
            }
        }
        // No integration succeeded: every attempt settles by itself.
        Ok(start)
    }
}

/// Warnings of an initial transient in the recorded time. `keeps_start`: neither chaos nor damping has removed it.
pub fn warnings(scene: &Scene, terms: &ActiveTerms, settle: f64, keeps_start: bool) -> Vec<Warning> {
    let vibration = || start_transient(scene, settle).or_else(|| cage_transient(scene, terms, settle));
    let tilt = || {
        let may_tilt = terms.rung == ModelLevel::Full && terms.raceway.hydrodynamics && eligibility::may_tilt(scene);
        (may_tilt && settle < TILT_SETTLE_S).then_some(Warning::TiltTransient { settle, required: TILT_SETTLE_S })
    };
    keeps_start.then(vibration).flatten().into_iter().chain(tilt()).collect()
}

/// Warning of a cage that may still vibrate along its axis, where contacts with a contact angle all carry load.
fn cage_transient(scene: &Scene, terms: &ActiveTerms, settle: f64) -> Option<Warning> {
    let mechanism = Mechanism::new(scene, terms);
    let may_vibrate = mechanism.has_axial_motion_or_tilt() && mechanism.layout.cage && settle < CAGE_SETTLE_S;
    may_vibrate.then(|| StaticSupport::of(scene)).flatten().filter(|support| support.all_carry)?;
    Some(Warning::CageTransient { settle, required: CAGE_SETTLE_S })
}

/// Warning of free vibration of the spindle that may remain from the start.
pub fn start_transient(scene: &Scene, settle: f64) -> Option<Warning> {
    let rate = decay_rate(scene).filter(|rate| settle * rate < MIN_DECAY_EFOLDS)?;
    let constant_speed = scene.operation.has_constant_speeds();
    Some(Warning::StartTransient { time_constant: 1.0 / rate, settle, required: SETTLED_EFOLDS / rate, constant_speed })
}
