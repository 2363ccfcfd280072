//! Surfaces of the raceways in a model: waves and defects as the contacts of the most loaded ball average them.

use std::f64::consts::TAU;

use crate::physics::bearing::PerRaceway;
use crate::physics::kinematics;
use crate::physics::raceway::RacewayContact;
use crate::physics::surface::SurfaceProfile;
use crate::physics::surface::defects::{PassingContact, Recess};
use crate::physics::surface::waviness::{
    AveragingContact, INNER, OUTER, RacewaySurface, SortedWaves, smallest_half_width,
};
use crate::simulation::input::scene::Scene;
use crate::simulation::model::equilibrium::equilibrium;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::model::surface_sites::{LoadZone, SurfaceSites};

/// Waves and defects of one raceway, and the contact that averages them.
#[derive(Debug, Clone, PartialEq)]
pub struct AveragedSurface {
    /// Load of the most loaded ball [N].
    pub load: f64,
    pub contact: AveragingContact,
    pub waves: SortedWaves,
    pub defects: Vec<Recess>,
}

/// The surfaces of a scene on its ideal mechanism; `None` where every raceway is an ideal circle.
///
/// The contact is that of the most loaded ball of the static equilibrium at the largest speed, fixed for the run. Without an
/// equilibrium nothing is averaged.
pub fn averaged_surfaces(ideal: &Mechanism, scene: &Scene) -> Option<PerRaceway<AveragedSurface>> {
    let surfaces = &scene.surfaces;
    if surfaces.are_ideal() {
        return None;
    }
    let speed = scene.operating_speed();
    let loads = equilibrium(ideal, speed).map(|rest| rest.loads).unwrap_or_default();
    let most = |of: fn(&PerRaceway<f64>) -> f64| loads.iter().map(of).fold(0.0, f64::max);
    let orbit = kinematics::ideal_orbit_ratio(&scene.bearing);
    let one = |raceway: &RacewayContact, surface: &RacewaySurface, load: f64, turns: f64, index: u64| {
        let (_, half_width) = raceway.hertz().semi_axes(load);
        let turns = (turns * speed / TAU).abs();
        let contact = AveragingContact { half_width, radius: raceway.bottom_radius(), turns };
        let passing = passing_contact(raceway, load, turns);
        let felt = surface.defects.iter().filter(|defect| defect.depth > 0.0);
        AveragedSurface {
            load,
            contact,
            waves: contact.sorted(surface, index, surfaces.seed),
            defects: felt.map(|defect| Recess { defect: *defect, contact: passing }).collect(),
        }
    };
    let (raceway, surface) = (&ideal.raceway, &surfaces.raceway);
    Some(PerRaceway {
        inner: one(&raceway.inner, &surface.inner, most(|load| load.inner), 1.0 - orbit, INNER),
        outer: one(&raceway.outer, &surface.outer, most(|load| load.outer), orbit, OUTER),
    })
}

/// Loads of a ball that passes an azimuth of the outer ring [rad], on ideal raceways at the largest speed [N]; 0 without an equilibrium.
pub fn ball_loads_at(ideal: &Mechanism, scene: &Scene, azimuth: f64) -> PerRaceway<f64> {
    let turned = Mechanism { start: ideal.start.turned(azimuth), ..ideal.clone() };
    let loads = equilibrium(&turned, scene.operating_speed()).map(|rest| rest.loads).unwrap_or_default();
    loads.first().copied().unwrap_or_default()
}

/// Least number of azimuths in a turn at which the load zone is known [-]: its edges are within 2.5°.
const AZIMUTHS: usize = 72;

/// The load zone on ideal raceways at a speed [rad/s]; `None` without an equilibrium.
fn load_zone(ideal: &Mechanism, speed: f64) -> Option<LoadZone> {
    let balls = ideal.layout.balls;
    // Each equilibrium has all balls.
    let turns = AZIMUTHS.div_ceil(balls);
    let mut pressed = vec![false; turns * balls];
    for turn in 0..turns {
        let by = TAU * turn as f64 / pressed.len() as f64;
        let turned = Mechanism { start: ideal.start.turned(by), ..ideal.clone() };
        for (ball, load) in equilibrium(&turned, speed).ok()?.loads.iter().enumerate() {
            pressed[turns * ball + turn] = load.inner > 0.0;
        }
    }
    Some(LoadZone::new(pressed))
}

/// The contact that passes the defects of a raceway under a load [N], `turns` times a second round the ring.
fn passing_contact(raceway: &RacewayContact, load: f64, turns: f64) -> PassingContact {
    let (hertz, radius) = (raceway.hertz(), raceway.bottom_radius());
    // The load of the smallest contact: an unloaded one has no size.
    let least = (smallest_half_width(radius) / hertz.semi_minor_coefficient).powi(3);
    let load = load.max(least);
    let (semi_major, half_width) = hertz.semi_axes(load);
    let approach = (load / hertz.stiffness).cbrt().powi(2);
    let curvature = 1.0 / hertz.rolling_radius;
    PassingContact { semi_major, half_width, approach, curvature, radius, speed: TAU * turns * radius }
}

/// An ideal mechanism with the surfaces of its scene.
pub(crate) fn with_surfaces(ideal: Mechanism, scene: &Scene) -> Mechanism {
    let Some(surfaces) = averaged_surfaces(&ideal, scene) else { return ideal };
    let planar = ideal.layout.planar;
    let profile = |of: &AveragedSurface| SurfaceProfile::new(&of.waves.averaged(), &of.defects, planar);
    let limits = |of: &AveragedSurface| of.defects.iter().map(Recess::reach).collect();
    let reaches = PerRaceway { inner: limits(&surfaces.inner), outer: limits(&surfaces.outer) };
    let (inner, outer) = (profile(&surfaces.inner), profile(&surfaces.outer));
    let wave_frequency = surfaces.inner.waves.highest_frequency().max(surfaces.outer.waves.highest_frequency());
    let recesses = surfaces.inner.defects.iter().chain(&surfaces.outer.defects);
    let defect_step = recesses.map(Recess::longest_step).fold(f64::INFINITY, f64::min);
    let edges = |of: &AveragedSurface| of.defects.iter().map(Recess::edges).collect();
    let defects = PerRaceway { inner: edges(&surfaces.inner), outer: edges(&surfaces.outer) };
    let sites = Some(SurfaceSites { load_zone: load_zone(&ideal, scene.operating_speed()), defects });
    let PerRaceway { inner: inner_contact, outer: outer_contact } = ideal.raceway;
    let raceway = PerRaceway { inner: inner_contact.with_surface(inner), outer: outer_contact.with_surface(outer) };
    Mechanism { raceway, wave_frequency, defect_step, defects: reaches, sites, ..ideal }
}
