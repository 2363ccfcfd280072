//! The static state a run starts from: the minimum of the potential of raceway contacts, applied loads,
//! gravity and centrifugal force over the places of spindle and balls. Traction, cage and drag are left to the run.

mod search;

pub(crate) use search::on_ring;
pub use search::{Equilibrium, equilibrium, spindle_stiffness};

use crate::physics::bearing::PerRaceway;
use crate::physics::operation::InitialPerturbation;
use crate::physics::raceway::RacewayContact;
use crate::simulation::input::scene::Scene;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::model::state::{BallState, CageState, Layout, SpindleState};
use crate::simulation::model::system::Model;
use crate::simulation::model::terms::ActiveTerms;

/// Equilibrium of the raceways at rest under the applied loads and the weight of the spindle: first ball under +Y.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticLoads {
    /// Displacement from the centred position along the radial force, clearance included [m].
    pub radial_displacement: f64,
    /// Displacement along the axial load [m]; 0 where the axial direction is held.
    pub axial_displacement: f64,
    /// Load of each ball on the inner raceway [N].
    pub ball_loads: Vec<f64>,
    /// Load of each ball on both raceways [N].
    pub raceway_loads: Vec<PerRaceway<f64>>,
    /// Radial force on the spindle, its weight included [N].
    pub radial_load: f64,
    /// Magnitude of the force along X that the balls carry [N]: the applied one, or what a held spindle takes.
    pub axial_load: f64,
    /// Largest load of a ball on the inner raceway [N].
    pub max_ball_load: f64,
    /// Largest pressure on either raceway [Pa].
    pub max_pressure: f64,
}

/// Equilibrium of spindle and balls under load, gravity and centrifugal force; cage centred, ideal orbit and rolling. An initial
/// perturbation adds a velocity to each ball and to the cage; planar states omit its part along X.
pub fn start_state(model: &Model) -> Result<Vec<f64>, SimulationError> {
    let mechanism = model.mechanism();
    let layout = mechanism.layout;
    let rest = equilibrium(mechanism, mechanism.rotation.speeds(0.0))?;
    let mut state = vec![0.0; layout.dimension()];
    for (ball, &(axial, radial)) in rest.balls.iter().enumerate() {
        layout.set_ball(&mut state, ball, &BallState { axial, radial, ..BallState::default() });
    }
    layout
        .set_spindle(&mut state, &SpindleState { position: rest.spindle, tilt: rest.tilt, ..SpindleState::default() });
    if let Some(perturbation) = mechanism.perturbation {
        perturb(&layout, &mut state, perturbation);
    }
    Ok(state)
}

/// Sets the velocities of an initial perturbation: balls along the axis, the radius and the orbit, the cage along X, Y, Z.
fn perturb(layout: &Layout, state: &mut [f64], perturbation: InitialPerturbation) {
    let mut velocities = perturbation.velocities();
    for (ball, [axial_velocity, radial_velocity, arc_velocity]) in (0..layout.balls).zip(velocities.by_ref()) {
        let moved = BallState { axial_velocity, radial_velocity, arc_velocity, ..layout.ball(state, ball) };
        layout.set_ball(state, ball, &moved);
    }
    for velocity in velocities.take(1) {
        layout.set_cage(state, &CageState { velocity, ..CageState::default() });
    }
}

/// Equilibrium of a scene's raceways at rest under its applied loads and the weight of the spindle. The weights of the balls are small beside them.
pub fn static_loads(scene: &Scene, needs: &ActiveTerms) -> Result<StaticLoads, SimulationError> {
    let mut mechanism = Mechanism::new(scene, needs);
    mechanism.load[1] += mechanism.spindle_mass * std::mem::take(&mut mechanism.gravity);
    let rest = equilibrium(&mechanism, 0.0)?;
    let pressure = |contact: &RacewayContact, load: f64| contact.hertz().max_pressure(load);
    let max_pressure = rest
        .loads
        .iter()
        .flat_map(|load| {
            [pressure(&mechanism.raceway.inner, load.inner), pressure(&mechanism.raceway.outer, load.outer)]
        })
        .fold(0.0, f64::max);
    let [x, y, z] = mechanism.load;
    let radial = y.hypot(z);
    let axial_load = if mechanism.layout.axial_spindle { x.abs() } else { carried_along_axis(&rest) };
    let along = if radial > 0.0 { (rest.spindle[1] * y + rest.spindle[2] * z) / radial } else { 0.0 };
    let ball_loads: Vec<f64> = rest.loads.iter().map(|load| load.inner).collect();
    Ok(StaticLoads {
        radial_displacement: along,
        axial_displacement: if x == 0.0 { rest.spindle[0] } else { rest.spindle[0] * x.signum() },
        max_ball_load: ball_loads.iter().copied().fold(0.0, f64::max),
        ball_loads,
        raceway_loads: rest.loads,
        radial_load: radial,
        axial_load,
        max_pressure,
    })
}

/// Share of the balls' loads below which their sum along the axis is rounding [-].
const ROUNDING: f64 = 1e-9;

/// Magnitude of the sum of the balls' forces along the axis [N].
fn carried_along_axis(rest: &Equilibrium) -> f64 {
    let forces = rest.loads.iter().zip(&rest.angles).map(|(load, angle)| load.inner * angle.inner.0);
    let loads: f64 = rest.loads.iter().map(|load| load.inner).sum();
    let sum = forces.sum::<f64>().abs();
    if sum > ROUNDING * loads { sum } else { 0.0 }
}
