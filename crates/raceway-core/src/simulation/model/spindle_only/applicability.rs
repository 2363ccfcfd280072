//! Applicability of the model of the spindle alone to a scene and its outputs.

use crate::physics::contact::damping::DampingLaw;
use crate::physics::spindle::AxialHold;
use crate::simulation::input::channel::{Axis, Channel};
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::terms::ActiveTerms;

/// Reason why the spindle alone cannot represent a scene and its outputs; `None`: it can.
pub fn inapplicability(scene: &Scene, needs: &ActiveTerms, outputs: &Outputs) -> Option<String> {
    let channels = || outputs.spectra.iter().chain(&outputs.series);
    let of_spindle = |channel: &Channel| matches!(channel, Channel::Spindle(Axis::Y | Axis::Z, _));
    let reason = if scene.operation.load[0] != 0.0 {
        "an axial load acts"
    } else if needs.axial_spindle {
        "the spindle moves along X"
    } else if scene.spindle.axial != AxialHold::Fixed && scene.spindle.axial != AxialHold::Offset(0.0) {
        "the spindle is held off its centre along X"
    } else if scene.operation.misalignment != [0.0; 2] {
        "the spindle is misaligned"
    } else if !needs.cage {
        "without a cage nothing keeps the balls apart"
    } else if needs.raceway.hydrodynamics {
        "rolling friction and pressure forces of the film act on the spindle"
    } else if matches!(scene.raceway_damping, DampingLaw::Viscous { coefficient } if coefficient != 0.0) {
        "raceways with a viscous damper have no condensed law"
    } else if outputs.contacts {
        "contacts are asked for (`outputs.metrics` without \"contacts\" does not)"
    } else if outputs.cage {
        "the cage's motion is asked for (`outputs.metrics` without \"cage\" does not)"
    } else if !channels().all(of_spindle) {
        "a channel besides y and z of the spindle is asked for"
    } else {
        return None;
    };
    Some(reason.into())
}
