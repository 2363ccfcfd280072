//! What a run will cost, before it is made.

use super::job::Job;
use super::resolve::CostAnswer;
use crate::physics::contact::traction::TractionLaw;
use crate::physics::kinematics::ideal_orbit_ratio;
use crate::simulation::equilibrium::StaticLoads;
use crate::simulation::model::Model;

/// Time of one ball in one evaluation of the equations, and of each strip of its two contacts on top [s]:
/// measured on one core of a server of 2023.
const SECONDS_PER_BALL: f64 = 0.4e-6;
const SECONDS_PER_STRIP: f64 = 0.04e-6;
/// Evaluations a step of the explicit method.
const EVALUATIONS: f64 = 6.0;
/// The explicit method is stable up to this product of step and rate [-].
const STABLE: f64 = 3.3;
/// The check of the accuracy repeats a part of the run.
const ACCURACY_SHARE: f64 = 1.25;

/// Stability holds the explicit method to steps of about 3.3 over the rate at which traction takes the
/// most loaded ball to its rolling spin, however smooth the motion is.
pub fn estimate(job: &Job, at_rest: Option<&StaticLoads>) -> CostAnswer {
    let scene = job.scene();
    let model = Model::new(scene, &job.needs);
    let ball_mass = scene.bearing.ball_mass;
    let orbit = ideal_orbit_ratio(&scene.bearing) * scene.operating_speed();
    let centrifugal = ball_mass * 0.5 * scene.bearing.parameters.pitch_diameter * orbit * orbit;
    let load = at_rest.map_or(0.0, |loads| loads.max_ball_load) + centrifugal;
    // Inertia about the centre is m d²/10: a force at d/2 changes the surface speed at 2.5 F/m, on two contacts.
    let rate = 5.0 * traction_slope(&scene.lubricant.traction) * load / ball_mass;
    let passes = scene.bearing.parameters.ball_count as f64 * orbit;
    let step = job.settings.fixed_step.unwrap_or_else(|| (STABLE / rate.max(1e3)).min(1.0 / passes.max(1e3)));
    let time = job.settings.settle + job.settings.duration;
    let balls = scene.bearing.parameters.ball_count as f64;
    let evaluation = balls * (SECONDS_PER_BALL + 2.0 * job.needs.raceway.strips as f64 * SECONDS_PER_STRIP);
    let wall_time = ACCURACY_SHARE * time / step * EVALUATIONS * evaluation;
    CostAnswer {
        states: model.mechanism().layout.dimension() as u64,
        estimated_wall_time_s: if wall_time.is_finite() { super::units::significant(wall_time, 2) } else { f64::MAX },
    }
}

/// Slope of the traction coefficient over the slip speed at rest [s/m].
fn traction_slope(law: &TractionLaw) -> f64 {
    match *law {
        TractionLaw::FourParameter { maximum, at_slip, .. } => 3.1 * maximum / at_slip,
        TractionLaw::Coulomb { coefficient, regularisation } => coefficient / regularisation,
        TractionLaw::SlideRoll { .. } | TractionLaw::Eyring { .. } => 1.0,
    }
}
