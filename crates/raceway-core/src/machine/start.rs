//! The state that a run starts from.

use super::equations::MachineDynamics;
use super::input::{Machine, MachineError, StepsOfLoss};
use crate::physics::frames::{Azimuth, Tilt, add};
use crate::rotor::deflection::deflection;
use crate::rotor::response::{of_load, of_unbalance};
use crate::simulation::model::Mechanism;
use crate::simulation::model::equilibrium::on_ring;
use crate::simulation::model::state::{BallState, SpindleState};

/// The shaft at its operating point, moving as unbalance and harmonic loads make it on linear bearings; balls in equilibrium at the place of
/// their ring, in ideal rolling. Where an inner ring has no load, the shaft starts without this motion: that of a shaft which the bearing does not
/// hold may be larger than its clearance.
pub fn start_state(machine: &Machine, dynamics: &MachineDynamics) -> Result<Vec<f64>, MachineError> {
    let frame = &dynamics.frame;
    let rest = deflection(&frame.system, &machine.rotor)?;
    let speed = machine.rotor.speed;
    let mut velocity = rest.map(|_| 0.0);
    let mut place = rest;
    let mut operating = frame.system.operating.iter().take(1).flat_map(|point| &point.rings);
    if operating.all(|ring| ring.largest_loads[0] > 0.0) {
        // At time 0 the shaft has turned by no angle.
        let whirl = of_unbalance(&frame.system, &machine.rotor.unbalances, speed);
        place += whirl.map(|value| value.re);
        velocity -= whirl.map(|value| speed * value.im);
        for (amplitude, frequency) in machine.rotor.loads.iter().filter_map(|load| of_load(&frame.system, load, speed))
        {
            place += amplitude.map(|value| value.re);
            velocity -= amplitude.map(|value| frequency * value.im);
        }
    }
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

/// Axial place and radius less the pitch radius of a ball with these over an outer ring, along the ring's own axis.
fn carried(ring: &SpindleState, mechanism: &Mechanism, ball: usize, (axial, radial): (f64, f64)) -> (f64, f64) {
    let radius = mechanism.pitch_radius + radial;
    let azimuth = Azimuth::new(mechanism.start_azimuth(ball));
    let [about_y, about_z] = ring.tilt;
    let place = Tilt::new(about_y, about_z).to_inertial(azimuth.to_inertial([axial, radius, 0.0]));
    let [x, y, z] = add(place, ring.position);
    (x, y.hypot(z) - mechanism.pitch_radius)
}
