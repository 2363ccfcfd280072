//! How long the start of a run rings: the spindle vibrates freely on its contacts until their damping has taken that away. Across the
//! load few contacts lean far, and that vibration stays many times longer than the one along it.

use super::equilibrium::equilibrium;
use super::model::Mechanism;
use super::needs::Needs;
use super::run::Outputs;
use super::scene::Scene;

/// e-folds after which free vibration has gone: one five times as strong as the steady one adds less than 0.05 dB to its level then.
const GONE: f64 = 4.0;
/// Fewer leave a vibration that may still add tenths of a decibel, or more.
const RINGS: f64 = 2.0;
/// Longest time that is waited for it [s].
const LONGEST: f64 = 5.0;
/// Times of decay beyond which nobody could wait [s].
const ENDLESS: f64 = 1000.0;

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
