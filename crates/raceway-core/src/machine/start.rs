//! The state that a run starts from.

use nalgebra::DVector;

use super::equations::MachineDynamics;
use super::frame::Frame;
use super::input::{Machine, MachineError, StepsOfLoss};
use crate::physics::frames::{Azimuth, Tilt, add};
use crate::rotor::deflection::deflection;
use crate::rotor::input::Rotor;
use crate::rotor::response::{of_load, of_unbalance};
use crate::simulation::model::Mechanism;
use crate::simulation::model::equilibrium::on_ring;
use crate::simulation::model::state::{BallState, SpindleState};

/// The shaft at its operating point, moving as unbalance and harmonic loads make it on linear bearings; balls in equilibrium at the place of
/// their ring, in ideal rolling.
pub fn start_state(machine: &Machine, dynamics: &MachineDynamics) -> Result<Vec<f64>, MachineError> {
    let frame = &dynamics.frame;
    let rest = deflection(&frame.system, &machine.rotor)?;
    let (place, velocity) = match forced_motion(machine, frame, &rest) {
        moving if is_within_clearances(machine, dynamics, &moving) => moving,
        _ => (rest.clone(), rest * 0.0),
    };
    let (place, velocity) = (place.as_slice(), velocity.as_slice());
    let mut state = Vec::new();
    for (index, bearing) in dynamics.bearings.iter().enumerate() {
        let (name, rings) = (&machine.bearings[index].name, dynamics.rings(index, place, velocity));
        if let Some(cause) = bearing.loss_of_ring(name, rings.apart()) {
            return Err(MachineError::Lost { time: 0.0, cause, steps: StepsOfLoss::AtStart, fastest: None });
        }
        let ([x, y, z], [about_y, about_z]) = rings.apart();
        let force = frame.system.operating[0].rings[index].largest_loads.iter().copied().fold(0.0, f64::max);
        let mechanism = bearing.dynamics.mechanism();
        let rest = on_ring(mechanism, mechanism.rotation.speeds(0.0), [x, y, z, about_y, about_z], force)
            .map_err(|source| MachineError::Bearing { bearing: name.clone(), source })?;
        let mut part = vec![0.0; mechanism.layout.dimension()];
        for (ball, &at_rest) in rest.balls.iter().enumerate() {
            let (axial, radial) = match &rings.outer {
                None => at_rest,
                Some(ring) => carried(ring, mechanism, ball, at_rest),
            };
            mechanism.layout.set_ball(&mut part, ball, &BallState { axial, radial, ..BallState::default() });
        }
        state.extend_from_slice(&part[..bearing.entries()]);
    }
    state.extend(place);
    state.extend(velocity);
    Ok(state)
}

/// Place and velocity of the coordinates at time 0, as unbalance and harmonic loads move them about a place of rest on linear bearings.
fn forced_motion(machine: &Machine, frame: &Frame, rest: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
    let speed = machine.rotor.speed;
    // At time 0 the shaft has turned by no angle.
    let whirl = of_unbalance(&frame.system, &machine.rotor.unbalances, speed);
    let mut place = rest + whirl.map(|value| value.re);
    let mut velocity = whirl.map(|value| -speed * value.im);
    for (amplitude, frequency) in machine.rotor.loads.iter().filter_map(|load| of_load(&frame.system, load, speed)) {
        place += amplitude.map(|value| value.re);
        velocity -= amplitude.map(|value| frequency * value.im);
    }
    (place, velocity)
}

/// True unless the motion presses an unloaded inner ring harder than all loads together do. Such a ring has no stiffness at rest, so that the linear
/// motion may go beyond its clearance.
fn is_within_clearances(
    machine: &Machine,
    dynamics: &MachineDynamics,
    (place, velocity): &(DVector<f64>, DVector<f64>),
) -> bool {
    let Rotor { speed, unbalances, loads, bearings, .. } = &machine.rotor;
    let Some(operating) = dynamics.frame.system.operating.first() else { return true };
    let unbalance: f64 = unbalances.iter().map(|plane| plane.product * speed * speed).sum();
    let harmonic: f64 = loads.iter().filter_map(|placed| placed.load.harmonic()).map(|load| load.amplitude).sum();
    let at_rest = operating.rings.iter().map(|ring| ring.largest_loads[0]).fold(0.0, f64::max);
    let largest = unbalance + harmonic + at_rest;
    let mut free = operating.rings.iter().enumerate().filter(|(_, ring)| ring.largest_loads[0] == 0.0);
    free.all(|(index, _)| {
        let ([x, y, z], [about_y, about_z]) = dynamics.rings(index, place.as_slice(), velocity.as_slice()).apart();
        let moved = bearings[index].mounted.bearing.at(&[x, y, z, about_y, about_z], *speed);
        moved.is_ok_and(|ring| ring.largest_loads[0] <= largest)
    })
}

/// Axial place and radius less the pitch radius of a ball with these over an outer ring, along the ring's own axis.
fn carried(ring: &SpindleState, mechanism: &Mechanism, ball: usize, (axial, radial): (f64, f64)) -> (f64, f64) {
    let radius = mechanism.pitch_radius + radial;
    let azimuth = Azimuth::new(mechanism.start_azimuth(ball));
    let [about_y, about_z] = ring.tilt;
    let place = Tilt::new(about_y, about_z).to_inertial(azimuth.to_inertial([axial, radius, 0.0]));
    let [x, y, z] = add(place, ring.position);
    (x, y.hypot(z) - mechanism.pitch_radius)
}
