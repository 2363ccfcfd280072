//! Surfaces of the raceways in a model: waves as the contacts of the most loaded ball average them.

use std::f64::consts::TAU;

use crate::physics::bearing::PerRaceway;
use crate::physics::kinematics;
use crate::physics::raceway::RacewayContact;
use crate::physics::surface::SurfaceProfile;
use crate::physics::surface::waviness::{AveragingContact, INNER, OUTER, RacewaySurface, SortedWaves};
use crate::simulation::input::scene::Scene;
use crate::simulation::model::equilibrium::equilibrium;
use crate::simulation::model::mechanism::Mechanism;

/// Waves of one raceway, and the contact that averages them.
#[derive(Debug, Clone, PartialEq)]
pub struct RacewayWaves {
    /// Load of the most loaded ball [N].
    pub load: f64,
    pub contact: AveragingContact,
    pub waves: SortedWaves,
}

/// The waves of a scene on its ideal mechanism; `None` where every raceway is an ideal circle.
///
/// The contact is that of the most loaded ball of the static equilibrium at the largest speed, fixed for the run. Without an
/// equilibrium nothing is averaged.
pub fn waves(ideal: &Mechanism, scene: &Scene) -> Option<PerRaceway<RacewayWaves>> {
    let surfaces = &scene.surfaces;
    if surfaces.are_ideal() {
        return None;
    }
    let speed = scene.operating_speed();
    let loads = equilibrium(ideal, speed).map(|rest| rest.loads).unwrap_or_default();
    let most = |of: fn(&PerRaceway<f64>) -> f64| loads.iter().map(of).fold(0.0, f64::max);
    let orbit = kinematics::ideal_orbit_ratio(&scene.bearing);
    let one = |contact: &RacewayContact, surface: &RacewaySurface, load: f64, turns: f64, index: u64| {
        let (_, half_width) = contact.hertz().semi_axes(load);
        let turns = (turns * speed / TAU).abs();
        let contact = AveragingContact { half_width, radius: contact.bottom_radius(), turns };
        RacewayWaves { load, contact, waves: contact.sorted(surface, index, surfaces.seed) }
    };
    let (raceway, surface) = (&ideal.raceway, &surfaces.raceway);
    Some(PerRaceway {
        inner: one(&raceway.inner, &surface.inner, most(|load| load.inner), 1.0 - orbit, INNER),
        outer: one(&raceway.outer, &surface.outer, most(|load| load.outer), orbit, OUTER),
    })
}

/// An ideal mechanism with the surfaces of its scene.
pub(crate) fn with_surfaces(ideal: Mechanism, scene: &Scene) -> Mechanism {
    let Some(waves) = waves(&ideal, scene) else { return ideal };
    let profile = |of: &RacewayWaves| SurfaceProfile::of_waves(&of.waves.averaged());
    let (inner, outer) = (profile(&waves.inner), profile(&waves.outer));
    let wave_frequency = waves.inner.waves.highest_frequency().max(waves.outer.waves.highest_frequency());
    let PerRaceway { inner: inner_contact, outer: outer_contact } = ideal.raceway;
    let raceway = PerRaceway { inner: inner_contact.with_surface(inner), outer: outer_contact.with_surface(outer) };
    Mechanism { raceway, wave_frequency, ..ideal }
}
