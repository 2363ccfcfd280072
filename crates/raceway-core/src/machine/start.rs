//! The bearings of a machine about its operating point, and the state that a run starts from.

use nalgebra::{Complex, DVector};

use super::equations::{BearingOnShaft, MachineDynamics};
use super::frame::Frame;
use super::input::{Machine, MachineError};
use crate::physics::spindle::{AxialHold, SpindleInertia, SpindleTilt};
use crate::rotor::unbalance::response;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::Mechanism;
use crate::simulation::model::dynamics::Full;
use crate::simulation::model::equilibrium::on_ring;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::state::{BallState, SpindleState};
use crate::simulation::model::surfaces::with_surfaces;
use crate::simulation::model::terms::ActiveTerms;

/// Balls and cage of each bearing, with the terms that its load about the operating point needs.
pub(super) fn bearings(machine: &Machine, frame: &Frame) -> Result<Vec<BearingOnShaft>, MachineError> {
    let mut bearings = Vec::with_capacity(machine.bearings.len());
    for (index, (moving, placed)) in machine.bearings.iter().zip(&machine.rotor.bearings).enumerate() {
        let [x, y, z, _, _] = frame.system.operating[0].rings[index].wrench;
        let mut scene = moving.scene.clone();
        scene.operation.speed = machine.speed.clone();
        // The shaft presses with the opposite of what the balls exert.
        scene.operation.load = [-x, -y, -z];
        scene.operation.misalignment = [0.0; 2];
        scene.gravity = machine.rotor.gravity;
        scene.spindle.axial = AxialHold::Free;
        scene.spindle.tilt = SpindleTilt::Free(SpindleInertia { transverse: 1.0, axial: 1.0 });
        let failed = |source: SimulationError| MachineError::Bearing { bearing: index, source };
        let terms = ActiveTerms::of(&scene, &Outputs::vibration(), Some(ModelLevel::Full))
            .map_err(|choice| failed(choice.into()))?;
        let mut mechanism = with_surfaces(Mechanism::new(&scene, &terms), &scene);
        mechanism.start = mechanism.start.turned(moving.start_azimuth);
        bearings.push(BearingOnShaft { dynamics: Full::new(mechanism), mounted: placed.mounted.clone() });
    }
    Ok(bearings)
}

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
