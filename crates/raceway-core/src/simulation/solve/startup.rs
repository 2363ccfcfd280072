//! How long the start of a run rings: the spindle vibrates freely on its contacts until their damping has taken that away. Across the
//! load few contacts lean far, and that vibration stays many times longer than the one along it. All attempts at a run of the
//! dynamics share what of that time comes before the last turns of the cage.

use crate::simulation::error::codes::Warning;
use crate::simulation::error::thresholds::MIN_DECAY_EFOLDS;
use crate::simulation::solve::eligibility;
use nalgebra::{Matrix3, Vector3};

use crate::numerics::ode::{Method, Statistics};
use crate::physics::kinematics;
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

/// e-folds after which free vibration has gone: one five times as strong as the steady one adds less than 0.05 dB to its level then.
const SETTLED_EFOLDS: f64 = 4.0;
/// Longest time that is waited for it [s].
const MAX_SETTLE_S: f64 = 5.0;
/// Turns of the cage in which balls, cage and film have settled, and within which of these times [s].
const SETTLE_CAGE_TURNS: f64 = 3.0;
const CAGE_SETTLE_RANGE_S: [f64; 2] = [0.02, 1.0];
/// How much longer a run settles, over that, whose attempts share the first part of it.
const SHARED: f64 = 2.0;
/// Share of settling, however short it is, where contacts lean and all of them carry, and the shortest time that is shared [s]: the cage rings
/// along its axis then, on films that hardly damp it there.
const AXIAL_SHARED: f64 = 2.0 / 3.0;
const LEAST_SHARED: f64 = 0.01;
/// Decay of the spindle's free vibration from which on there is one motion, whatever it came from [1/s]. Below 5/s some grow by themselves, slowly
/// from a quiet start, or come to another motion from a lively one.
const UNIQUE_DECAY_PER_S: f64 = 10.0;
/// Time after which the cage, too, mostly rings no more [s].
const CAGE_SETTLE_S: f64 = 2.0;
/// Time after which cage and balls mostly tilt no more [s].
const TILT_SETTLE_S: f64 = 4.0;
/// Rate of the damping at the start [1/s]: vibration falls by 7 e-folds or more before it has faded, and steps of 7.5 µs resolve it.
const START_DAMPING_PER_S: f64 = 2000.0;

/// How attempts come to share it where all steps of a fixed length blow up: what it leaves behind is forgotten.
const STARTUP_TOLERANCE: Stepping =
    Stepping { method: Method::Auto, relative_tolerance: 1e-3, fixed_step: None, most_evaluations: None };

/// How the spindle rests on its contacts.
struct StaticSupport {
    /// Slowest rate at which its free vibration decays [1/s].
    decay: f64,
    /// Each ball carries load wherever it stands, so that none knocks.
    all_carry: bool,
    /// Contacts lean, and there is a cage that rings along the axis.
    has_axial_motion_or_tilt: bool,
}

impl StaticSupport {
    /// Whatever a run starts from, it comes to the same motion.
    fn has_one_attractor(&self) -> bool {
        self.all_carry && self.decay > UNIQUE_DECAY_PER_S
    }

    /// Under load, weight and centrifugal force at the operating speed; `None` where nothing holds it.
    fn of(scene: &Scene) -> Option<Self> {
        // Which outputs are asked for does not matter to what holds the spindle.
        let outputs = Outputs { vibration: true, contacts: false, cage: false, spectra: vec![], series: vec![] };
        let mut mechanism = Mechanism::new(scene, &ActiveTerms::of(scene, &outputs, None).ok()?);
        let law = scene.raceway_damping.resolve();
        // Balls go round: a place with one of them under the load, and the one halfway to the next.
        let (mut damping, mut all_carry) = (Matrix3::zeros(), true);
        let halfway = 0.5 * std::f64::consts::TAU / mechanism.layout.balls as f64;
        for turned in [0.0, halfway] {
            mechanism.start = mechanism.start.turned(turned);
            let rest = equilibrium(&mechanism, scene.operating_speed()).ok()?;
            let [x, y, z] = rest.spindle;
            for (ball, load) in rest.loads.iter().enumerate() {
                if load.inner <= 0.0 {
                    all_carry = false;
                    continue;
                }
                // Two contacts in series: half of the damping of one; the mean of two places.
                let both = 0.25 * (law.chi * load.inner + law.viscous);
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

/// Slowest rate at which free vibration of the spindle decays [1/s], along its axis, too, where it moves there: by the damping of its
/// contacts at rest; `None` where it does not rest on contacts that damp it.
pub fn decay_rate(scene: &Scene) -> Option<f64> {
    StaticSupport::of(scene).map(|rest| rest.decay).filter(|rate| *rate > 0.0)
}

/// Time that a vibration which a run starts with is given to go [s], that of the cage along its axis, too, where no start is damped at first; at
/// most `MAX_SETTLE_S`; `None` as for [`decay_rate`], and at changing
/// speed, where waiting would leave out what is asked for.
pub fn settling_time(scene: &Scene) -> Option<f64> {
    let rest = StaticSupport::of(scene).filter(|rest| rest.decay > 0.0 && scene.operation.speed.is_constant())?;
    let of_cage =
        if rest.has_axial_motion_or_tilt && rest.all_carry && !rest.has_one_attractor() { CAGE_SETTLE_S } else { 0.0 };
    Some((SETTLED_EFOLDS / rest.decay).clamp(of_cage, MAX_SETTLE_S))
}

/// Time in which balls and cage settle [s], however long the spindle rings.
pub fn turning_time(scene: &Scene) -> f64 {
    let turn = kinematics::ideal_frequencies(&scene.bearing, scene.operating_speed()).cage;
    if turn > 0.0 {
        (SETTLE_CAGE_TURNS / turn).clamp(CAGE_SETTLE_RANGE_S[0], CAGE_SETTLE_RANGE_S[1])
    } else {
        CAGE_SETTLE_RANGE_S[0]
    }
}

/// What of settling the attempts at a run share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartupPhase {
    /// From the start [s]; 0: nothing.
    pub time: f64,
    /// Until it has faded.
    damping: Option<FadingDamping>,
}

impl StartupPhase {
    const NOTHING: Self = Self { time: 0.0, damping: None };

    /// Of a run. Where the start still rings, or may lead to one motion or to another, what is kept is of that one start, and each attempt
    /// has to come from there.
    pub fn of(scene: &Scene, model: &Model, settings: &RunSettings) -> Self {
        let (settle, turning) = (settings.settle, turning_time(scene));
        let mechanism = model.mechanism();
        if !mechanism.speed.is_constant() || !mechanism.raceway.inner.is_damped() || settings.fixed_step.is_some() {
            return Self::NOTHING;
        }
        let time = settle - turning.min(settle * (1.0 - AXIAL_SHARED));
        let turns = mechanism.speed.at(0.0).1 != 0.0;
        if mechanism.has_axial_motion_or_tilt()
            && turns
            && time >= LEAST_SHARED
            && StaticSupport::of(scene).is_some_and(|rest| rest.has_one_attractor())
        {
            // It fades slowly beside all vibration, that of a heavy spindle, too.
            let end = turning.max(0.5 * time).min(time);
            return Self { time, damping: Some(FadingDamping { rate: START_DAMPING_PER_S, end }) };
        }
        if settle <= (1.0 + SHARED) * turning || !fixed_step::is_free(settings) {
            return Self::NOTHING;
        }
        // By default, to three digits.
        let forgets = settling_time(scene).is_some_and(|time| settle >= 0.99 * time);
        if forgets { Self { time: settle - turning, damping: None } } else { Self::NOTHING }
    }
}

/// Where the attempts at a run begin.
#[derive(Debug, Clone)]
pub struct InitialState {
    /// [s]
    pub time: f64,
    /// What only the start has set going has been taken away.
    pub is_damped: bool,
    pub state: Vec<f64>,
    /// What led to it.
    pub work: Statistics,
}

impl InitialState {
    /// In equilibrium, at no time.
    pub fn at_rest(model: &Model) -> Result<Self, SimulationError> {
        Ok(Self { time: 0.0, is_damped: false, state: start_state(model)?, work: Statistics::default() })
    }

    /// After what attempts share, so that they and their repetitions have no more before them than the last of settling. In long steps,
    /// which leave what rings as it is (levels that still rang after a second, and a quarter of the step, differed by
    /// 0.0015 dB at most), or in shorter ones, or under error control where the long ones blow up.
    pub fn after(shared: &StartupPhase, model: &Model, control: &Control<'_>) -> Result<Self, SimulationError> {
        let start = Self::at_rest(model)?;
        let &StartupPhase { time, damping } = shared;
        if time == 0.0 {
            return Ok(start);
        }
        let damped = damping.map(|damping| model.damped(damping));
        let model = damped.as_ref().unwrap_or(model);
        let span = Span { start: 0.0, end: time, checkpoint: time, share: (0.0, 1.0) };
        (control.live)(&Live::of(Phase::Settling));
        let in_steps = fixed_step::lengths(model).map(fixed_step::by);
        for stepping in in_steps.chain([STARTUP_TOLERANCE]) {
            match integrate(model, &start.state, &stepping, &span, control, |_| ()) {
                Ok(settled) => {
                    let is_damped = damping.is_some();
                    return Ok(Self { time, is_damped, state: settled.checkpoint, work: settled.statistics });
                }
                Err(stopped @ SimulationError::Stopped { .. }) => return Err(stopped),
                Err(_) => {}
            }
        }
        // Every attempt settles by itself.
        Ok(start)
    }
}

/// Warnings of vibration of the start in the recorded time. `keeps_start`: neither chaos nor damping has removed it.
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

/// Warning of free vibration of the spindle that may still be that of the start.
pub fn start_transient(scene: &Scene, settle: f64) -> Option<Warning> {
    let rate = decay_rate(scene).filter(|rate| settle * rate < MIN_DECAY_EFOLDS)?;
    let constant_speed = scene.operation.speed.is_constant();
    Some(Warning::StartTransient { time_constant: 1.0 / rate, settle, required: SETTLED_EFOLDS / rate, constant_speed })
}
