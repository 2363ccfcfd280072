//! The equations of the spindle alone for a scene, or why they do not apply.

use super::equations::{Corrections, SpindleOnly};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::model::surfaces::with_surfaces;
use crate::simulation::model::terms::ActiveTerms;

/// The equations and the mechanism of a scene; an error where `inapplicability` finds a reason against them.
pub(crate) fn scene_model(
    scene: &Scene,
    settings: &RunSettings,
    rung: &'static str,
    inapplicability: fn(&Scene, &ActiveTerms, &Outputs) -> Option<Inapplicable>,
) -> Result<(SpindleOnly, Mechanism), SimulationError> {
    let needs = ActiveTerms::of(scene, &settings.outputs, Some(ModelLevel::Full))?;
    if let Some(reason) = inapplicability(scene, &needs, &settings.outputs) {
        return Err(SimulationError::NotApplicable { rung, reason });
    }
    let mut ideal = Mechanism::new(scene, &needs);
    // Heights by longitude are those of balls in their plane.
    ideal.layout.planar |= scene.surfaces.have_uneven_balls();
    let mechanism = with_surfaces(ideal, scene);
    Ok((
        SpindleOnly::new(&mechanism, scene.raceway_damping.resolve().chi, mechanism.orbit_ratio, Corrections::ALL),
        mechanism,
    ))
}
