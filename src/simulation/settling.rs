//! How long the start of a run rings: the spindle vibrates freely on its contacts until their damping has taken that away. Across the
//! load few contacts lean far, and that vibration stays many times longer than the one along it. All attempts at a run of the
//! dynamics share what of that time comes before the last turns of the cage.

use super::equilibrium::equilibrium;
use super::model::{Mechanism, Model};
use super::needs::Needs;
use super::run::{self, Control, Live, Outputs, Phase, RunSettings, SimulationError, Span};
use super::scene::Scene;
use super::stepped;
use crate::numerics::ode::Statistics;
use crate::physics::kinematics;

/// e-folds after which free vibration has gone: one five times as strong as the steady one adds less than 0.05 dB to its level then.
const GONE: f64 = 4.0;
/// Fewer leave a vibration that may still add tenths of a decibel, or more.
const RINGS: f64 = 2.0;
/// Longest time that is waited for it [s].
const LONGEST: f64 = 5.0;
/// Times of decay beyond which nobody could wait [s].
const ENDLESS: f64 = 1000.0;
/// Turns of the cage in which balls, cage and film have settled, and within which of these times [s].
const TURNS: f64 = 3.0;
const TURNING: [f64; 2] = [0.02, 1.0];
/// How much longer a run settles, over that, whose attempts share the first part of it.
const SHARED: f64 = 2.0;

/// Slowest rate at which free vibration of the spindle in its plane decays [1/s], by the damping of its contacts at rest under load, weight
/// and centrifugal force at the operating speed; `None` where it does not rest on contacts that damp it. What moves it along its axis is not seen.
pub fn decay_rate(scene: &Scene) -> Option<f64> {
    // Which outputs are asked for does not matter to what holds the spindle.
    let outputs = Outputs { vibration: true, contacts: false, cage: false, spectra: vec![], series: vec![] };
    let mut mechanism = Mechanism::new(scene, &Needs::of(scene, &outputs, None).ok()?);
    let law = scene.raceway_damping.resolve();
    // Balls go round: a place with one of them under the load, and the one halfway to the next.
    let mut damping = [0.0; 3];
    let halfway = 0.5 * std::f64::consts::TAU / mechanism.layout.balls as f64;
    for turned in [0.0, halfway] {
        mechanism.start = mechanism.start.turned(turned);
        let rest = equilibrium(&mechanism, scene.operating_speed()).ok()?;
        for (ball, load) in rest.loads.iter().enumerate().filter(|(_, load)| load.inner > 0.0) {
            // Two contacts in series: half of the damping of one; the mean of two places.
            let both = 0.25 * (law.chi * load.inner + law.viscous);
            let (cosine, sine) = (mechanism.start.cosine[ball], mechanism.start.sine[ball]);
            damping[0] += both * cosine * cosine;
            damping[1] += both * cosine * sine;
            damping[2] += both * sine * sine;
        }
    }
    let [yy, yz, zz] = damping;
    let least = 0.5 * (yy + zz) - (0.5 * (yy - zz)).hypot(yz);
    Some(0.5 * least / mechanism.spindle_mass).filter(|rate| *rate > 0.0)
}

/// Time that a vibration which a run starts with is given to go [s], at most `LONGEST`; `None` as for [`decay_rate`], and at changing
/// speed, where waiting would leave out what is asked for.
pub fn settling_time(scene: &Scene) -> Option<f64> {
    let rate = decay_rate(scene).filter(|_| scene.operation.speed.is_constant())?;
    Some((GONE / rate).min(LONGEST))
}

/// Time in which balls and cage settle [s], however long the spindle rings.
pub fn turning_time(scene: &Scene) -> f64 {
    let turn = kinematics::ideal_frequencies(&scene.bearing, scene.operating_speed()).cage;
    if turn > 0.0 { (TURNS / turn).clamp(TURNING[0], TURNING[1]) } else { TURNING[0] }
}

/// How much of settling the attempts at a run share [s]; 0: nothing.
pub fn shared_time(scene: &Scene, model: &Model, settings: &RunSettings) -> f64 {
    let last = turning_time(scene);
    let is_long = settings.settle > (1.0 + SHARED) * last && scene.operation.speed.is_constant();
    if is_long && stepped::serves(model, settings) { settings.settle - last } else { 0.0 }
}

/// Where the attempts at a run begin.
#[derive(Debug, Clone)]
pub(super) struct Beginning {
    /// [s]
    pub time: f64,
    pub state: Vec<f64>,
    /// What led to it.
    pub work: Statistics,
}

impl Beginning {
    /// In equilibrium, at no time.
    pub fn at_rest(model: &Model) -> Result<Self, SimulationError> {
        Ok(Self { time: 0.0, state: run::start_state(model)?, work: Statistics::default() })
    }

    /// Late in a long time to settle, where the method is free: in long steps, which leave what rings as it is (levels that still rang after a
    /// second, and a quarter of the step, differed by 0.0015 dB at most), so that attempts and their repetitions have no more before
    /// them than balls and cage need to settle.
    pub fn of(
        scene: &Scene,
        model: &Model,
        settings: &RunSettings,
        control: &Control<'_>,
    ) -> Result<Self, SimulationError> {
        let start = Self::at_rest(model)?;
        let end = shared_time(scene, model, settings);
        if end == 0.0 {
            return Ok(start);
        }
        let span = Span { start: 0.0, end, checkpoint: end, share: (0.0, 1.0) };
        (control.live)(&Live::of(Phase::Settling));
        match run::integrate(model, &start.state, &stepped::longest(model), &span, control, |_| ()) {
            Ok(settled) => Ok(Self { time: end, state: settled.checkpoint, work: settled.statistics }),
            Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
            // Too stiff for long steps: every attempt settles by itself.
            Err(_) => Ok(start),
        }
    }
}

/// What a run says whose vibration may still be that of its start after so long [s].
pub fn rings_on(scene: &Scene, settle: f64) -> Option<String> {
    let rate = decay_rate(scene).filter(|rate| settle * rate < RINGS)?;
    let enough = (GONE / rate).min(LONGEST);
    let way_out = match scene.operation.speed.is_constant() {
        true => format!("Try {enough:.2} s"),
        false => format!("Hold the first speed for {enough:.2} s before anything is kept"),
    };
    let decays = match 1.0 / rate {
        time if time > ENDLESS => format!("more than {ENDLESS} s"),
        time => format!("about {time:.3} s"),
    };
    Some(format!(
        "the start may still ring: free vibration of the spindle falls to 1/e in {decays} on contacts that damp it so little, and settle_s \
         is {settle:?} s. {way_out}"
    ))
}
