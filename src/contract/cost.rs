//! What a run will cost, before it is made.

use super::job::Job;
use super::resolve::CostAnswer;
use super::units::significant;
use crate::physics::bearing::Bearing;
use crate::physics::contact::hertz::raceway_contacts;
use crate::physics::contact::traction::TractionLaw;
use crate::physics::kinematics::ideal_orbit_ratio;
use crate::simulation::equilibrium::StaticLoads;
use crate::simulation::model::Model;
use crate::simulation::scene::Scene;

/// Time of one ball in one evaluation of the equations, and of each strip of its two contacts on top [s]:
/// measured on one core of a shared server.
const SECONDS_PER_BALL: f64 = 0.2e-6;
const SECONDS_PER_STRIP: f64 = 0.06e-6;
/// Longest estimate [s]; a run that long is never finished.
const LONGEST: f64 = 1e12;
/// Evaluations a step of the explicit method.
const EVALUATIONS: f64 = 6.0;
/// The explicit method is stable up to these products of step and rate of decay, and of step and
/// angular frequency [-].
const STABLE_DECAY: f64 = 3.3;
const STABLE_OSCILLATION: f64 = 1.0;
/// Judging the accuracy repeats a part of the run.
const ACCURACY_SHARE: f64 = 1.5;

/// Stability holds the explicit method to short steps, however smooth the motion is: those of the most
/// loaded ball, between its raceways or while traction takes it to its rolling spin. Good to a factor of 3.
pub fn estimate(job: &Job, at_rest: Option<&StaticLoads>) -> CostAnswer {
    let scene = job.scene();
    let states = Model::new(scene, &job.needs).mechanism().layout.dimension();
    let balls = scene.bearing.parameters.ball_count as f64;
    let orbit = ideal_orbit_ratio(&scene.bearing) * scene.operating_speed();
    let load = at_rest.map_or(0.0, |loads| loads.max_ball_load) + centrifugal_load(&scene.bearing, orbit);
    let stable = STABLE_DECAY / spin_rate(scene, load).max(1e3);
    let resolved = STABLE_OSCILLATION / ball_frequency(&scene.bearing, load).max(1e3);
    let step = job.settings.fixed_step.unwrap_or(stable.min(resolved));
    let time = job.settings.settle + job.settings.duration;
    let evaluation = balls * (SECONDS_PER_BALL + 2.0 * job.needs.raceway.strips as f64 * SECONDS_PER_STRIP);
    let wall_time = ACCURACY_SHARE * time / step * EVALUATIONS * evaluation;
    CostAnswer { states: states as u64, estimated_wall_time_s: significant(wall_time.min(LONGEST), 2) }
}

/// Centrifugal force of a ball [N] at an orbit speed [rad/s].
fn centrifugal_load(bearing: &Bearing, orbit: f64) -> f64 {
    bearing.ball_mass * 0.5 * bearing.parameters.pitch_diameter * orbit * orbit
}

/// Angular frequency of a ball between its raceways under a load [rad/s]: tangent stiffness 1.5 K^(2/3) Q^(1/3) each.
fn ball_frequency(bearing: &Bearing, load: f64) -> f64 {
    let tangent = raceway_contacts(bearing).map(|contact| 1.5 * contact.stiffness.powf(2.0 / 3.0) * load.cbrt());
    ((tangent.inner + tangent.outer) / bearing.ball_mass).sqrt()
}

/// Rate at which traction takes a ball under a load to its rolling spin [1/s]: its inertia is m d²/10, so a
/// force F at d/2 changes the surface speed at 2.5 F/m, on two contacts.
fn spin_rate(scene: &Scene, load: f64) -> f64 {
    5.0 * traction_slope(&scene.lubricant.traction) * load / scene.bearing.ball_mass
}

/// Slope of the traction coefficient over the slip speed at rest [s/m].
fn traction_slope(law: &TractionLaw) -> f64 {
    match *law {
        TractionLaw::FourParameter { maximum, at_slip, .. } => 3.1 * maximum / at_slip,
        TractionLaw::Coulomb { coefficient, regularisation } => coefficient / regularisation,
        TractionLaw::SlideRoll { .. } | TractionLaw::Eyring { .. } => 1.0,
    }
}
