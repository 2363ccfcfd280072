//! Surfaces of raceways and balls in a model: waves and defects as the contacts of the most loaded ball average them.

use std::f64::consts::{PI, TAU};

use crate::physics::bearing::PerRaceway;
use crate::physics::kinematics::{self, RingSpeeds};
use crate::physics::raceway::RacewayContact;
use crate::physics::surface::SurfaceProfile;
use crate::physics::surface::ball::{BallSurface, surface_number};
use crate::physics::surface::defects::{PassingContact, Recess};
use crate::physics::surface::sphere::{BallPose, BallRecess, SphereProfile};
use crate::physics::surface::waviness::{
    AveragingContact, INNER, OUTER, RacewaySurface, SortedWaves, smallest_half_width,
};
use crate::simulation::input::scene::Scene;
use crate::simulation::model::equilibrium::equilibrium;
use crate::simulation::model::mechanism::{Mechanism, UnevenBall};
use crate::simulation::model::state::Layout;
use crate::simulation::model::surface_sites::{LoadZone, SurfaceSites};

/// Waves and defects of one raceway, and the contact that averages them.
#[derive(Debug, Clone, PartialEq)]
pub struct AveragedSurface {
    /// Load of the most loaded ball [N].
    pub load: f64,
    pub contact: AveragingContact,
    pub waves: SortedWaves,
    /// Waves of the groove's place along the axis.
    pub axial_waves: SortedWaves,
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
    let contacts = Contacts::of(ideal, scene);
    let one = |raceway: &RacewayContact, surface: &RacewaySurface, load: f64, turns: f64, index: u64| {
        let (_, half_width) = raceway.hertz().semi_axes(load);
        let contact = AveragingContact { half_width, radius: raceway.bottom_radius(), turns };
        let passing = passing_contact(raceway, load, turns);
        let felt = surface.defects.iter().filter(|defect| defect.depth > 0.0);
        AveragedSurface {
            load,
            contact,
            waves: contact.sorted(surface, index, surfaces.seed),
            axial_waves: contact
                .sorted_waves(surface.axial_waviness.iter().copied().filter(|wave| wave.amplitude != 0.0)),
            defects: felt.map(|defect| Recess { defect: *defect, contact: passing }).collect(),
        }
    };
    let (raceway, surface, Contacts { load, passages, .. }) = (&ideal.raceway, &surfaces.raceway, &contacts);
    Some(PerRaceway {
        inner: one(&raceway.inner, &surface.inner, load.inner, passages.inner, INNER),
        outer: one(&raceway.outer, &surface.outer, load.outer, passages.outer, OUTER),
    })
}

/// The contacts that surfaces pass at the largest speed.
struct Contacts {
    /// Of the most loaded ball [N].
    load: PerRaceway<f64>,
    /// Frequencies at which a ball goes round each ring [Hz].
    passages: PerRaceway<f64>,
    /// Frequency at which a ball turns under its contacts [Hz].
    spin: f64,
}

impl Contacts {
    fn of(ideal: &Mechanism, scene: &Scene) -> Self {
        let speeds = scene.operating_speeds();
        let speed = speeds.relative();
        let loads = equilibrium(ideal, speeds).map(|rest| rest.loads).unwrap_or_default();
        let most = |of: fn(&PerRaceway<f64>) -> f64| loads.iter().map(of).fold(0.0, f64::max);
        let orbit = kinematics::ideal_orbit_ratio(&scene.bearing);
        let frequency = |ratio: f64| (ratio * speed / TAU).abs();
        Self {
            load: PerRaceway { inner: most(|load| load.inner), outer: most(|load| load.outer) },
            passages: PerRaceway { inner: frequency(1.0 - orbit), outer: frequency(orbit) },
            spin: frequency(kinematics::ideal_spin_ratio(&scene.bearing)),
        }
    }
}

/// Waves and defects of a ball, and the contact with one raceway that averages them.
#[derive(Debug, Clone, PartialEq)]
pub struct AveragedBall {
    pub contact: AveragingContact,
    pub waves: SortedWaves,
    pub defects: Vec<BallRecess>,
}

/// Waves and defects of each ball in a scene, as the contacts of both raceways average them; empty where all balls are spheres.
pub fn averaged_balls(ideal: &Mechanism, scene: &Scene) -> Vec<PerRaceway<AveragedBall>> {
    if !scene.surfaces.have_uneven_balls() {
        return Vec::new();
    }
    let Contacts { load, passages, spin } = Contacts::of(ideal, scene);
    let radius = ideal.ball_radius;
    let one = |(ball, surface): (usize, &BallSurface), raceway: &RacewayContact, load: f64, turns: f64| {
        let (_, half_width) = raceway.hertz().semi_axes(load);
        let contact = AveragingContact { half_width, radius, turns: spin };
        let waves = surface.waves(contact.first_zero(), surface_number(ball), scene.surfaces.seed);
        let passing = PassingContact { radius, ..passing_contact(raceway, load, turns) };
        let felt = surface.defects.iter().filter(|defect| defect.depth > 0.0);
        AveragedBall {
            contact,
            waves: contact.sorted_waves(waves),
            defects: felt.map(|defect| BallRecess::new(defect, passing)).collect(),
        }
    };
    let balls = scene.surfaces.balls.iter().enumerate();
    let averaged = balls.map(|ball| PerRaceway {
        inner: one(ball, &ideal.raceway.inner, load.inner, passages.inner),
        outer: one(ball, &ideal.raceway.outer, load.outer, passages.outer),
    });
    averaged.collect()
}

/// Loads of a ball that passes an azimuth [rad], on ideal raceways at the largest speed [N]; 0 without an equilibrium.
pub fn ball_loads_at(ideal: &Mechanism, scene: &Scene, azimuth: f64) -> PerRaceway<f64> {
    let turned = Mechanism { start: ideal.start.turned(azimuth), ..ideal.clone() };
    let loads = equilibrium(&turned, scene.operating_speeds()).map(|rest| rest.loads).unwrap_or_default();
    loads.first().copied().unwrap_or_default()
}

/// Least number of azimuths in a turn at which the load zone is known [-]: its edges are within 2.5°.
const AZIMUTHS: usize = 72;

/// The load zone on ideal raceways at speeds of the rings [rad/s]; `None` without an equilibrium.
fn load_zone(ideal: &Mechanism, speeds: RingSpeeds) -> Option<LoadZone> {
    let balls = ideal.layout.balls;
    // Each equilibrium has all balls.
    let turns = AZIMUTHS.div_ceil(balls);
    let mut pressed = vec![false; turns * balls];
    for turn in 0..turns {
        let by = TAU * turn as f64 / pressed.len() as f64;
        let turned = Mechanism { start: ideal.start.turned(by), ..ideal.clone() };
        for (ball, load) in equilibrium(&turned, speeds).ok()?.loads.iter().enumerate() {
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
    let balls = averaged_balls(&ideal, scene);
    let planar = ideal.layout.planar;
    let profile = |of: &AveragedSurface| SurfaceProfile::new(&of.waves.averaged(), &of.defects, planar);
    let limits = |of: &AveragedSurface| of.defects.iter().map(Recess::reach).collect();
    let reaches = PerRaceway { inner: limits(&surfaces.inner), outer: limits(&surfaces.outer) };
    let (inner, outer) = (profile(&surfaces.inner), profile(&surfaces.outer));
    let waves_of_balls = balls.iter().flat_map(|ball| [&ball.inner.waves, &ball.outer.waves]);
    let of_ring = |of: &'_ AveragedSurface| [&of.waves, &of.axial_waves].map(SortedWaves::highest_frequency);
    let of_rings = of_ring(&surfaces.inner).into_iter().chain(of_ring(&surfaces.outer));
    let wave_frequency = waves_of_balls.map(SortedWaves::highest_frequency).chain(of_rings).fold(0.0, f64::max);
    let of_balls = balls.iter().flat_map(|ball| ball.inner.defects.iter().chain(&ball.outer.defects));
    let recesses = surfaces.inner.defects.iter().chain(&surfaces.outer.defects).chain(of_balls.map(|of| &of.recess));
    let defect_step = recesses.map(Recess::longest_step).fold(f64::INFINITY, f64::min);
    let edges = |of: &AveragedSurface| of.defects.iter().map(Recess::edges).collect();
    let defects = PerRaceway { inner: edges(&surfaces.inner), outer: edges(&surfaces.outer) };
    let sites = Some(SurfaceSites { load_zone: load_zone(&ideal, scene.operating_speeds()), defects });
    let PerRaceway { inner: inner_contact, outer: outer_contact } = ideal.raceway.clone();
    let axial = |of: &AveragedSurface| SurfaceProfile::of_waves(&of.axial_waves.averaged());
    let raceway = PerRaceway {
        inner: inner_contact.with_surface(inner).with_axial_waves(axial(&surfaces.inner)),
        outer: outer_contact.with_surface(outer).with_axial_waves(axial(&surfaces.outer)),
    };
    let surfaced = Mechanism { raceway, wave_frequency, defect_step, defects: reaches, sites, ..ideal };
    if balls.is_empty() { surfaced } else { with_balls(surfaced, &balls) }
}

/// A mechanism with uneven balls, which lie at the start as on ideal raceways.
fn with_balls(smooth: Mechanism, balls: &[PerRaceway<AveragedBall>]) -> Mechanism {
    let planar = smooth.layout.planar;
    let sphere = |of: &AveragedBall| SphereProfile::new(&of.waves.averaged(), &of.defects, planar);
    let contacts = |of: fn(&PerRaceway<AveragedBall>) -> &AveragedBall| -> Vec<Option<SphereProfile>> {
        balls.iter().map(|ball| sphere(of(ball))).collect()
    };
    let PerRaceway { inner, outer } = smooth.raceway.clone();
    let raceway = PerRaceway {
        inner: inner.with_balls(contacts(|ball| &ball.inner)),
        outer: outer.with_balls(contacts(|ball| &ball.outer)),
    };
    let angles = equilibrium(&smooth, smooth.rotation.speeds(0.0)).map(|rest| rest.angles).unwrap_or_default();
    let start = |ball: usize| {
        let at_rest = angles.get(ball).copied().unwrap_or_default();
        UnevenBall::at_start(ball, &raceway, &balls[ball], at_rest, planar)
    };
    let uneven_balls = (0..balls.len()).map(start).collect();
    let layout = Layout { attitude: true, ..smooth.layout };
    Mechanism { layout, raceway, uneven_balls, ..smooth }
}

impl UnevenBall {
    /// `at_rest`: sines and cosines of the contact angles, positive where the outer contact lies towards +X.
    fn at_start(
        ball: usize,
        raceway: &PerRaceway<RacewayContact>,
        averaged: &PerRaceway<AveragedBall>,
        at_rest: PerRaceway<(f64, f64)>,
        planar: bool,
    ) -> Self {
        // Without an equilibrium all angles are 0.
        let is_known = |&(_, cosine): &(f64, f64)| !planar && cosine > 0.0;
        let direction = |angle: &(f64, f64)| if is_known(angle) { *angle } else { (0.0, 1.0) };
        let PerRaceway { inner, outer } = at_rest.map(direction);
        let (sine, cosine) = outer;
        let axes = [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]];
        let height = |contact: &RacewayContact, towards: (f64, f64), longitude: f64| {
            let pose = BallPose { longitude, axes };
            let of = |sphere: &SphereProfile| match planar {
                true => sphere.at::<true>(towards, &pose).height,
                false => sphere.at::<false>(towards, &pose).height,
            };
            contact.balls().of(ball).map_or(0.0, of)
        };
        let reaches = |of: &AveragedBall| of.defects.iter().map(|of| (of.direction(), of.recess.reach())).collect();
        Self {
            axes,
            heights: PerRaceway {
                inner: height(&raceway.inner, (-inner.0, -inner.1), PI),
                outer: height(&raceway.outer, outer, 0.0),
            },
            defects: PerRaceway { inner: reaches(&averaged.inner), outer: reaches(&averaged.outer) },
        }
    }
}
