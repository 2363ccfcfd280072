//! Defects over which a ball may leave a raceway. It is then not in equilibrium between them.
//!
//! The path over a defect asks a ball for a radial acceleration r̈. Its contacts carry it there while both of their loads are positive:
//! Q_i + a_e m r̈ on the inner raceway and Q_i + F − m (1 − a_e) r̈ on the outer one. F is the centrifugal force, and a_e the share of the
//! outer contact in an approach. Q_i is the load at the approach D − y, which is left where the ball has fallen by y. The ball moves with
//! r̈ = (1 − a_e) ÿ over an outer defect and with −a_e ÿ over an inner one.
//!
//! An outer defect has to carry balls at its own azimuth. An inner defect passes all azimuths and has to carry a ball where the load is
//! largest: elsewhere less load changes, and a ball outside the load zone does not touch it.

use crate::physics::bearing::PerRaceway;
use crate::physics::surface::defects::Recess;
use crate::physics::surface::path_over;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::condensed_contact::CondensedContact;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::model::surfaces::{averaged_surfaces, ball_loads_at};
use crate::simulation::model::terms::ActiveTerms;

/// The first defect that a ball may leave, by the loads of the static equilibrium; `None`: all defects carry their balls.
pub(super) fn ball_leaves(scene: &Scene, outputs: &Outputs) -> Option<Inapplicable> {
    if !scene.surfaces.have_defects() {
        return None;
    }
    // A scene without a model or an equilibrium has an error of its own.
    let needs = ActiveTerms::of(scene, outputs, Some(ModelLevel::Planar)).ok()?;
    let ideal = Mechanism::new(scene, &needs);
    let PerRaceway { inner, outer } = averaged_surfaces(&ideal, scene)?;
    let largest = PerRaceway { inner: inner.load, outer: outer.load };
    let least = |recess: &Recess| {
        let loads = recess.azimuths().map(|azimuth| ball_loads_at(&ideal, scene, azimuth));
        loads.into_iter().min_by(|a, b| a.inner.total_cmp(&b.inner)).unwrap_or_default()
    };
    let leaves = |ring: &'static str, recess: &Recess, beside: PerRaceway<f64>, moved: fn(f64) -> f64| {
        let Hold { load, needed } = weakest_hold(&ideal, recess, &beside, moved);
        (load <= needed).then_some(Inapplicable::BallLeavesDefect { ring, load, needed })
    };
    let on_outer = outer.defects.iter().find_map(|recess| leaves("outer", recess, least(recess), |share| 1.0 - share));
    on_outer.or_else(|| inner.defects.iter().find_map(|recess| leaves("inner", recess, largest, |share| -share)))
}

/// Load of a contact without the inertia of the ball, and what the acceleration of the ball takes from it, negative where it adds [N].
struct Hold {
    load: f64,
    needed: f64,
}

/// The least reserve of both contacts on the path over a defect. `beside`: loads of the ball where it has not fallen [N]; `moved`: r̈/ÿ at a share
/// a_e of the outer contact.
fn weakest_hold(ideal: &Mechanism, recess: &Recess, beside: &PerRaceway<f64>, moved: fn(f64) -> f64) -> Hold {
    let stiffness = ideal.raceway.map(|contact| contact.hertz().stiffness);
    let penetration = |load: f64, stiffness: f64| (load / stiffness).cbrt().powi(2);
    let approach = penetration(beside.inner, stiffness.inner) + penetration(beside.outer, stiffness.outer);
    let pair = CondensedContact::new(stiffness);
    let free = pair.unloaded(0.0, 0.0, 0.0, beside.outer - beside.inner);
    let mass_per_curvature = ideal.ball_mass * recess.contact.speed * recess.contact.speed;
    let holds = path_over(recess).flat_map(|(fall, curvature)| {
        let left = pair.load(approach - fall, &free);
        let share = left.outer_share;
        let inertia = mass_per_curvature * curvature * moved(share);
        [
            Hold { load: left.load, needed: -share * inertia },
            Hold { load: left.load + free.force, needed: (1.0 - share) * inertia },
        ]
    });
    let reserve = |hold: &Hold| hold.load - hold.needed;
    holds.min_by(|a, b| reserve(a).total_cmp(&reserve(b))).unwrap_or(Hold { load: 0.0, needed: 0.0 })
}
