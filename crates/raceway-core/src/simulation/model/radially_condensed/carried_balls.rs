//! Defects over which a ball may leave its raceways. It is then not in equilibrium between them.
//!
//! A ball follows the edge of an outer defect only while the inner raceway presses it with more than its mass times the centripetal
//! acceleration of its path. An outer defect has to carry balls at its own azimuth. An inner defect passes all azimuths and has to carry a
//! ball where the load is largest: elsewhere less load changes, and a ball outside the load zone does not touch it.

use crate::physics::bearing::PerRaceway;
use crate::physics::surface::defects::Recess;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::model::surfaces::{averaged_surfaces, ball_loads_at};
use crate::simulation::model::terms::ActiveTerms;

/// Least load of a ball in a defect, over the load that makes it follow the edge [-].
const LOAD_RESERVE: f64 = 2.0;

/// The first defect that a ball may leave, by the loads of the static equilibrium; `None`: all defects carry their balls.
pub(super) fn ball_leaves(scene: &Scene, outputs: &Outputs) -> Option<Inapplicable> {
    if !scene.surfaces.have_defects() {
        return None;
    }
    // A scene without a model or an equilibrium has an error of its own.
    let needs = ActiveTerms::of(scene, outputs, Some(ModelLevel::Planar)).ok()?;
    let ideal = Mechanism::new(scene, &needs);
    let PerRaceway { inner, outer } = averaged_surfaces(&ideal, scene)?;
    let leaves = |ring: &'static str, recess: &Recess, beside: f64| {
        let load = load_within(&ideal, recess, beside);
        let needed = LOAD_RESERVE * ideal.ball_mass * recess.edge_acceleration();
        (load < needed).then_some(Inapplicable::BallLeavesDefect { ring, load, needed })
    };
    let least = |recess: &Recess| {
        let loads = recess.azimuths().map(|azimuth| ball_loads_at(&ideal, scene, azimuth).inner);
        loads.into_iter().fold(f64::INFINITY, f64::min)
    };
    let on_outer = outer.defects.iter().find_map(|recess| leaves("outer", recess, least(recess)));
    on_outer.or_else(|| inner.defects.iter().find_map(|recess| leaves("inner", recess, inner.load)))
}

/// Load of a ball in the deepest place of a defect [N], where it has a load `beside` the defect [N]: the fall takes a part of the approach of
/// both contacts.
fn load_within(ideal: &Mechanism, recess: &Recess, beside: f64) -> f64 {
    let depth = ideal.raceway.map(|contact| (beside / contact.hertz().stiffness).cbrt().powi(2));
    let left = ((depth.inner + depth.outer - recess.deepest()) / (depth.inner + depth.outer)).max(0.0);
    beside * left * left.sqrt()
}
