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
    let mechanism = mechanism(scene, &needs);
    Ok((equations(scene, &mechanism), mechanism))
}

/// The equations of a scene that they can represent, with all balls starting farther by an angle [rad].
pub(crate) fn turned_model(scene: &Scene, outputs: &Outputs, by: f64) -> Result<SpindleOnly, SimulationError> {
    let mut mechanism = mechanism(scene, &ActiveTerms::of(scene, outputs, Some(ModelLevel::Full))?);
    mechanism.start = mechanism.start.turned(by);
    Ok(equations(scene, &mechanism))
}

fn mechanism(scene: &Scene, needs: &ActiveTerms) -> Mechanism {
    let mut ideal = Mechanism::new(scene, needs);
    // Heights by longitude are those of balls in their plane.
    ideal.layout.planar |= scene.surfaces.have_uneven_balls();
    with_surfaces(ideal, scene)
}

fn equations(scene: &Scene, mechanism: &Mechanism) -> SpindleOnly {
    SpindleOnly::new(mechanism, scene.raceway_damping.resolve().chi, mechanism.orbit_ratio, Corrections::ALL)
}
