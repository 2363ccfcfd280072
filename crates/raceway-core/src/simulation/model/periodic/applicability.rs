//! Applicability of the periodic model to a scene and its outputs.

use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::spindle_only;
use crate::simulation::model::terms::ActiveTerms;

/// Reason why a scene has no motion that repeats with every ball, or cannot show its outputs; `None`: it may have one.
pub fn inapplicability(scene: &Scene, needs: &ActiveTerms, outputs: &Outputs) -> Option<Inapplicable> {
    let reason = if !scene.operation.rotation().outer_stands() {
        Inapplicable::OuterRingTurns
    } else if scene.surfaces.have_defects() {
        Inapplicable::Defects
    } else if scene.surfaces.have_axial_waves() {
        Inapplicable::AxialWaves
    } else if !scene.surfaces.raceway.inner.is_ideal() {
        Inapplicable::InnerWaves
    } else if scene.surfaces.have_uneven_balls() {
        Inapplicable::BallWaves
    } else if !scene.surfaces.balls.is_empty() {
        Inapplicable::UnequalBalls
    } else if !scene.pocket_deviations.is_empty() {
        Inapplicable::UnevenPockets
    } else if !scene.operation.speed.is_constant() {
        Inapplicable::SpeedChanges
    } else if scene.operation.varying_loads().is_some() {
        Inapplicable::LoadsVary
    } else if scene.operating_speed() == 0.0 {
        Inapplicable::AtRest
    } else if needs.unbalance {
        Inapplicable::Unbalance
    } else {
        return spindle_only::inapplicability(scene, needs, outputs);
    };
    Some(reason)
}
