//! Applicability of the model of the spindle alone to a scene and its outputs.

use crate::physics::contact::damping::DampingLaw;
use crate::physics::spindle::{AxialHold, SpindleTilt};
use crate::simulation::input::channel::{Axis, Channel};
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::terms::ActiveTerms;

/// Returns true where one pattern turns with the cage or the balls and another with the shaft. Five turns of a cage take nearly as long as two of
/// the shaft, so that a spectrum rarely separates their lines.
fn cage_beats_with_shaft(scene: &Scene) -> bool {
    let of_cage = scene.has_unequal_balls() || scene.surfaces.have_uneven_balls();
    let of_shaft =
        scene.spindle.unbalance_product(scene.operating_speed()) != 0.0 || !scene.surfaces.raceway.inner.is_ideal();
    of_cage && of_shaft
}

/// Reason why the spindle alone cannot represent a scene and its outputs; `None`: it can.
pub fn inapplicability(scene: &Scene, needs: &ActiveTerms, outputs: &Outputs) -> Option<Inapplicable> {
    let channels = || outputs.spectra.iter().chain(&outputs.series);
    let of_spindle = |channel: &Channel| matches!(channel, Channel::Spindle(Axis::Y | Axis::Z, _));
    let reason = if !scene.operation.rotation().outer_stands() {
        Inapplicable::OuterRingTurns
    } else if scene.surfaces.have_defects() {
        Inapplicable::Defects
    } else if scene.surfaces.have_axial_waves() {
        Inapplicable::AxialWaves
    } else if scene.operation.acts_along_x() {
        Inapplicable::AxialLoad
    } else if needs.axial_spindle {
        Inapplicable::SpindleMovesAlongX
    } else if scene.spindle.axial != AxialHold::Fixed && scene.spindle.axial != AxialHold::Offset(0.0) {
        Inapplicable::SpindleOffCentre
    } else if scene.operation.misalignment != [0.0; 2] {
        Inapplicable::Misaligned
    } else if scene.spindle.tilt != SpindleTilt::Held {
        Inapplicable::SpindleTilts
    } else if !needs.cage {
        Inapplicable::NoCage
    } else if needs.raceway.hydrodynamics {
        Inapplicable::Hydrodynamics
    } else if matches!(scene.raceway_damping, DampingLaw::Viscous { coefficient } if coefficient != 0.0) {
        Inapplicable::ViscousDamper
    } else if cage_beats_with_shaft(scene) {
        Inapplicable::CageBeatsWithShaft
    } else if outputs.contacts {
        Inapplicable::ContactsRequested
    } else if outputs.cage {
        Inapplicable::CageRequested
    } else if outputs.life {
        Inapplicable::LifeRequested
    } else if outputs.friction {
        Inapplicable::FrictionRequested
    } else if !channels().all(of_spindle) {
        Inapplicable::OtherChannels
    } else {
        return None;
    };
    Some(reason)
}
