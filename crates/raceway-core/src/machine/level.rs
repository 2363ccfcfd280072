//! Bearings of a machine on the level `radially_condensed`: machines that it can represent, and its equations.

use std::array::from_fn;

use super::bearing::{BearingOnShaft, CondensedBearing, TiltHold, scene_on_shaft};
use super::equations::MachineDynamics;
use super::inapplicable::MachineInapplicable;
use super::input::{Machine, MachineError};
use crate::physics::contact::damping::DampingFactor;
use crate::physics::spindle::{AxialHold, SpindleTilt};
use crate::physics::statics::Matrix;
use crate::physics::statics::ring::RingState;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::radially_condensed::{self, RadiallyCondensed};

/// Model level of the bearings of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum LevelChoice {
    #[default]
    Full,
    RadiallyCondensed,
    /// `radially_condensed` where `full` shows no larger error of a level [dB], else `full`.
    Within(f64),
}

/// Reason why `radially_condensed` cannot represent the bearings of a machine; `None`: it can.
pub fn inapplicability(machine: &Machine) -> Option<MachineInapplicable> {
    let of_machine = if machine.bearings.is_empty() {
        Some(MachineInapplicable::NoBearing)
    } else if machine.rotor.shaft.is_axially_free {
        Some(MachineInapplicable::AxiallyFree)
    } else if !machine.speed.is_constant() {
        Some(MachineInapplicable::SpeedChanges)
    } else {
        None
    };
    of_machine.or_else(|| (0..machine.bearings.len()).find_map(|index| of_bearing(machine, index)))
}

fn of_bearing(machine: &Machine, index: usize) -> Option<MachineInapplicable> {
    let (of, placed) = (&machine.bearings[index], &machine.rotor.bearings[index]);
    let bearing = || of.name.clone();
    let [x, _, _, about_y, about_z] = placed.mounted.outer;
    if placed.has_moving_outer_ring() {
        Some(MachineInapplicable::OuterRingMoves { bearing: bearing() })
    } else if [x, about_y, about_z] != [0.0; 3] || placed.mounted.spring.is_some() {
        Some(MachineInapplicable::OuterRingOff { bearing: bearing() })
    } else {
        let scene = in_plane(scene_on_shaft(machine, index, [0.0; 3]));
        let reason = radially_condensed::inapplicability(&scene, &Outputs::vibration())?;
        Some(MachineInapplicable::Bearing { bearing: bearing(), reason })
    }
}

/// The scene of a bearing whose ring moves in the plane alone.
fn in_plane(mut scene: Scene) -> Scene {
    (scene.spindle.axial, scene.spindle.tilt) = (AxialHold::Fixed, SpindleTilt::Held);
    scene.operation.load[0] = 0.0;
    // The load contains the weight that the bearing carries.
    scene.operation.load[1] -= scene.spindle.mass * scene.gravity;
    scene
}

impl MachineDynamics {
    /// The machine with its bearings on `radially_condensed`, or the reason why that cannot represent it.
    pub fn radially_condensed(mut self, machine: &Machine) -> Result<Self, MachineError> {
        if let Some(reason) = inapplicability(machine) {
            return Err(MachineError::NotApplicable(reason));
        }
        for (index, bearing) in self.bearings.iter_mut().enumerate() {
            let model = model(machine, index, bearing)?;
            let tilt = tilt_hold(&self.frame.system.operating[0].rings[index], &machine.rotor.bearings[index].damping);
            bearing.condensed = Some(CondensedBearing { model, tilt });
        }
        Ok(self)
    }
}

fn model(machine: &Machine, index: usize, bearing: &BearingOnShaft) -> Result<RadiallyCondensed, MachineError> {
    let scene = in_plane(scene_on_shaft(machine, index, bearing.largest_load));
    let of = &machine.bearings[index];
    RadiallyCondensed::new(&scene, &Outputs::vibration())
        .map(|model| model.turned(of.start_azimuth))
        .map_err(|source| MachineError::Bearing { bearing: of.name.clone(), source })
}

fn tilt_hold(ring: &RingState, damping: &DampingFactor) -> TiltHold {
    let of_tilt = |matrix: &Matrix| from_fn(|row| from_fn(|column| matrix[3 + row][3 + column]));
    TiltHold {
        rest: from_fn(|axis| ring.pose[3 + axis]),
        moment: from_fn(|axis| ring.wrench[3 + axis]),
        stiffness: of_tilt(&ring.stiffness.mean),
        damping: of_tilt(&ring.damping(damping)),
    }
}
