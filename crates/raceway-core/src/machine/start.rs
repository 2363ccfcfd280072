//! The state that a run starts from.

use nalgebra::{Complex, DVector};

use super::equations::MachineDynamics;
use super::input::{Machine, MachineError};
use crate::rotor::unbalance::response;
use crate::simulation::model::equilibrium::on_ring;
use crate::simulation::model::state::{BallState, SpindleState};

/// The shaft at its operating point, moving as its unbalance and linear bearings make it; balls in equilibrium at the place of their ring, in
/// ideal rolling.
pub fn start_state(machine: &Machine, dynamics: &MachineDynamics) -> Result<Vec<f64>, MachineError> {
    let frame = &dynamics.frame;
    let operating = &frame.system.operating[0];
    let speed = machine.rotor.speed;
    let whirl = response(&frame.system, &machine.rotor.unbalances, speed);
    let (angle, _, _) = dynamics.speed.at(0.0);
    let turned = whirl.map(|value| value * Complex::from_polar(1.0, angle));
    let place = frame.from_analysis(&(&operating.coordinates + turned.map(|value| value.re)));
    let velocity =
        frame.from_analysis(&DVector::from_iterator(turned.len(), turned.iter().map(|value| -speed * value.im)));
    let mut state = Vec::new();
    for (index, bearing) in dynamics.bearings.iter().enumerate() {
        let SpindleState { position: [x, y, z], tilt: [about_y, about_z], .. } =
            dynamics.ring(index, &place, &velocity);
        let force = operating.rings[index].largest_loads.iter().copied().fold(0.0, f64::max);
        let mechanism = bearing.dynamics.mechanism();
        let rest = on_ring(mechanism, speed, [x, y, z, about_y, about_z], force)
            .map_err(|source| MachineError::Bearing { bearing: index, source })?;
        let mut part = vec![0.0; mechanism.layout.dimension()];
        for (ball, &(axial, radial)) in rest.balls.iter().enumerate() {
            mechanism.layout.set_ball(&mut part, ball, &BallState { axial, radial, ..BallState::default() });
        }
        state.extend_from_slice(&part[..bearing.entries()]);
    }
    state.extend(place);
    state.extend(velocity);
    Ok(state)
}
