//! Constants of bodies and contacts during a run.

use crate::numerics::lanes::{LANES, Lanes, SideBySide};
use crate::physics::ball::BallBody;
use crate::physics::bearing::{Bearing, PerRaceway, SpindlePlay};
use crate::physics::cage::CageParameters;
use crate::physics::drag::Drag;
use crate::physics::frames::{Azimuth, Vector};
use crate::physics::kinematics::{self, RingSpeeds};
use crate::physics::land::Land;
use crate::physics::life::reference::LoadMeans;
use crate::physics::limits::SHORTEST_RAMP;
use crate::physics::loads::{SpindleLoad, VaryingLoads};
use crate::physics::neighbour::NeighbourContact;
use crate::physics::operation::{InitialPerturbation, RingRotation, Turn};
use crate::physics::pocket::Pocket;
use crate::physics::raceway::RacewayContact;
use crate::physics::spindle::{AxialHold, SpindleInertia, SpindleTilt};
use crate::physics::surface::ball::BallSurface;
use crate::physics::surface::defects::DefectReach;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::model::fading_damping::FadingDamping;
use crate::simulation::model::failure::Departure;
use crate::simulation::model::state::Layout;
use crate::simulation::model::surface_sites::SurfaceSites;
use crate::simulation::model::terms::ActiveTerms;

/// Steps in a period of the fastest wave of a raceway [-].
const STEPS_PER_WAVE: f64 = 10.0;

/// Constants of bodies and contacts during a run, in SI units.
#[derive(Debug, Clone)]
pub struct Mechanism {
    pub layout: Layout,
    pub rotation: RingRotation,
    /// Orbit speed of ideal balls over spindle speed, both relative to the outer ring.
    pub orbit_ratio: f64,
    /// Spin ω_x of ideal balls over spindle speed, both relative to the outer ring: the spin in the orbit frame plus the orbit speed.
    pub spin_ratio: f64,
    pub pitch_radius: f64,
    /// Start azimuths of balls and pockets, padded to whole lanes by that of the last ball.
    pub(crate) start: StartAzimuths,
    /// Mass [kg], moment of inertia [kg m²] and radius [m] of a nominal ball.
    pub ball_mass: f64,
    pub ball_inertia: f64,
    pub ball_radius: f64,
    /// Size and mass of each ball, eight at a time, padded by the last ball.
    pub(crate) bodies: Vec<BallBody<Lanes>>,
    /// A nominal ball.
    pub(crate) nominal_body: BallBody,
    /// Radius of the largest ball less the nominal one [m]; `None`: all balls are nominal.
    pub(crate) largest_oversize: Option<f64>,
    pub raceway: PerRaceway<RacewayContact>,
    /// Highest frequency at which waves of raceways and balls pass a contact [Hz]; 0 without waves.
    pub(crate) wave_frequency: f64,
    /// Longest step that resolves the path over a defect at the largest speed [s]; infinite without defects and at rest.
    pub(crate) defect_step: f64,
    /// Defects of the raceways, as they limit steps.
    pub(crate) defects: PerRaceway<Vec<DefectReach>>,
    /// Places that balls are observed at; `None` on ideal circles.
    pub(crate) sites: Option<SurfaceSites>,
    /// Each ball, where one is no sphere; else empty.
    pub(crate) uneven_balls: Vec<UnevenBall>,
    pub pocket: Pocket,
    /// Contact of neighbouring balls; `None`: a cage keeps them apart.
    pub neighbours: Option<NeighbourContact>,
    pub cage: CageParameters,
    pub land: Option<Land>,
    pub drag: Option<Drag>,
    pub churning: Option<Drag>,
    pub spindle_mass: f64,
    /// Moments of inertia of a spindle that tilts.
    pub spindle_inertia: Option<SpindleInertia>,
    /// Largest displacement at which a ball may hold the spindle [m].
    pub(crate) play: SpindlePlay,
    /// Axial displacement at which the spindle is held [m].
    pub axial_offset: f64,
    /// Imposed tilt of the spindle about Y and Z [rad].
    pub misalignment: [f64; 2],
    /// Load on the spindle at the start [N].
    pub load: Vector,
    /// Moment on the spindle at the start, about Y and the new Z [N m].
    pub moment: [f64; 2],
    /// Changes of load and moment since the start; `None`: they are constant.
    pub(crate) varying_loads: Option<VaryingLoads>,
    /// Mass times eccentricity [kg m].
    pub unbalance: f64,
    /// Acceleration of gravity along +Y [m/s²].
    pub gravity: f64,
    /// Initial velocities of balls and cage; `None`: they start in equilibrium.
    pub(crate) perturbation: Option<InitialPerturbation>,
    /// Damping of the start-up phase, which is no part of the scene.
    pub(crate) damping: Option<FadingDamping>,
}

/// Rotations of the rings and of ideally rolling balls at one time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Rotations {
    /// Of the inner ring, with the shaft.
    pub inner: Turn,
    pub outer: Turn,
    /// Of the balls round the bearing axis.
    pub orbit: Turn,
    /// Of a ball about X, in space.
    pub spin: Turn,
    /// Of a ball about X in its orbit frame: angle [rad] and speed [rad/s].
    pub turn: f64,
    pub turn_speed: f64,
}

/// Sign of the speed of ideally rolling balls round the bearing axis; 1 at rest.
pub(crate) fn direction(rings: RingSpeeds, mechanism: &Mechanism) -> f64 {
    if rings.carried(mechanism.orbit_ratio) < 0.0 { -1.0 } else { 1.0 }
}

/// A ball that may have waves and defects, as it lies at the start.
#[derive(Debug, Clone)]
pub(crate) struct UnevenBall {
    /// Its axes in the orbit frame; the second points to the outer contact at rest, the third along the orbit.
    pub axes: [Vector; 3],
    /// Heights at both contacts at rest [m].
    pub heights: PerRaceway<f64>,
    /// Directions of its defects in its own frame, and how they limit steps.
    pub defects: PerRaceway<Vec<(Vector, DefectReach)>>,
}

/// Start azimuths by column.
#[derive(Debug, Clone)]
pub(crate) struct StartAzimuths {
    /// [rad]
    pub angle: Vec<f64>,
    pub cosine: Vec<f64>,
    pub sine: Vec<f64>,
    /// True if all are equally spaced.
    is_even: bool,
}

impl StartAzimuths {
    /// `deviations` from equal spacing [rad]; empty: none.
    fn new(balls: usize, deviations: &[f64]) -> Self {
        let one = |ball: usize| start_azimuth(ball, balls) + deviations.get(ball).copied().unwrap_or_default();
        let angle = (0..balls.next_multiple_of(LANES)).map(|ball| one(ball.min(balls - 1))).collect();
        Self::of(angle, deviations.is_empty())
    }

    /// Returns true where balls and pockets are equally spaced.
    pub(crate) fn are_even(&self) -> bool {
        self.is_even
    }

    /// The azimuths, turned by an angle [rad].
    pub(crate) fn turned(&self, by: f64) -> Self {
        Self::of(self.angle.iter().map(|angle| angle + by).collect(), self.is_even)
    }

    fn of(angle: Vec<f64>, is_even: bool) -> Self {
        let (cosine, sine) = angle.iter().map(|&angle| Azimuth::new(angle)).map(|a| (a.cosine, a.sine)).unzip();
        Self { angle, cosine, sine, is_even }
    }
}

impl Mechanism {
    /// Returns whether contact angles differ from 0: the spindle moves along X, is offset there, or is tilted.
    pub(crate) fn has_axial_motion_or_tilt(&self) -> bool {
        let Layout { axial_spindle, tilting_spindle, .. } = self.layout;
        axial_spindle || tilting_spindle || self.axial_offset != 0.0 || self.misalignment != [0.0; 2]
    }

    /// Returns true where a raceway or a ball has a defect.
    pub(crate) fn has_defects(&self) -> bool {
        self.defect_step.is_finite()
    }

    /// How far the spindle is from the centre of the outer ring where no ball can hold it any more; `None`: a ball may hold it.
    pub(crate) fn departure(&self, [x, y, z]: Vector, [about_y, about_z]: [f64; 2]) -> Option<Departure> {
        let (radial, axial) = ((y * y + z * z).sqrt(), (x + self.axial_offset).abs());
        let tilted = self.pitch_radius * about_y.hypot(about_z);
        if radial > self.play.radial {
            Some(Departure { direction: "radially", displacement: radial, limit: self.play.radial })
        } else if axial > self.play.axial {
            Some(Departure { direction: "axially", displacement: axial, limit: self.play.axial })
        } else if tilted > self.play.axial {
            let direction = "at the pitch circle, because it tilts,";
            Some(Departure { direction, displacement: tilted, limit: self.play.axial })
        } else {
            None
        }
    }

    /// Longest step that resolves the waves of raceways and balls [s]; infinite without waves.
    pub(crate) fn longest_wave_step(&self) -> f64 {
        1.0 / (STEPS_PER_WAVE * self.wave_frequency)
    }

    /// Longest step of fixed length that resolves the waves of raceways and balls, and the loads [s].
    pub(crate) fn longest_excited_step(&self) -> f64 {
        self.longest_wave_step().min(self.longest_load_step())
    }

    /// Longest step of fixed length that resolves the loads [s]; infinite where they are constant.
    pub(crate) fn longest_load_step(&self) -> f64 {
        self.varying_loads.as_ref().map_or(f64::INFINITY, VaryingLoads::longest_fixed_step)
    }

    /// Times after 0 at which the angular acceleration or the slope of a load jumps [s], in their order.
    pub(crate) fn kinks(&self) -> Vec<f64> {
        let of_loads = self.varying_loads.iter().flat_map(VaryingLoads::kinks).filter(|at| *at >= SHORTEST_RAMP);
        let mut kinks: Vec<f64> = self.rotation.kinks().chain(of_loads).collect();
        kinks.sort_by(f64::total_cmp);
        kinks.dedup_by(|later, earlier| *later < *earlier + SHORTEST_RAMP);
        kinks
    }

    /// True where neither speeds nor loads change but periodically.
    pub(crate) fn is_steady(&self) -> bool {
        self.rotation.is_constant() && !self.varying_loads.as_ref().is_some_and(VaryingLoads::has_transients)
    }

    /// Returns true where state or time limit the steps of error control.
    pub(crate) fn limits_steps(&self) -> bool {
        self.has_defects() || self.varying_loads.is_some()
    }

    /// Changes of the loads since the start of the run at a time [s] and an angle of the spindle [rad].
    #[inline(always)]
    pub(crate) fn load_change(&self, time: f64, angle: f64) -> Option<SpindleLoad> {
        self.varying_loads.as_ref().map(|loads| loads.at(time, angle))
    }

    /// The mechanism under the largest radial loads of the run; `None` where they are those at the start.
    pub(crate) fn under_largest_loads(&self) -> Option<Self> {
        let [_, y, z, ..] = self.varying_loads.as_ref()?.largest;
        let mut heaviest = self.clone();
        heaviest.load[1] += y.copysign(self.load[1] + self.spindle_mass * self.gravity);
        heaviest.load[2] += z.copysign(self.load[2]);
        Some(heaviest)
    }

    /// Orbit speed of ideally rolling balls at constant speeds of the rings [rad/s]; `None` where a speed changes.
    pub(crate) fn steady_orbit_speed(&self) -> Option<f64> {
        self.rotation.is_constant().then(|| self.rotations(0.0).orbit.speed)
    }

    /// Empty means of the loads of the balls, with the exponents of the rings that turn.
    pub(crate) fn load_means(&self) -> LoadMeans {
        LoadMeans::of_rings(self.rotation.inner.largest(), self.rotation.outer.largest())
    }

    /// Rotations of the rings and of ideally rolling balls at a time [s].
    #[inline(always)]
    pub fn rotations(&self, time: f64) -> Rotations {
        let (inner, outer) = self.rotation.at(time);
        Rotations {
            inner,
            outer,
            orbit: outer.carried(self.orbit_ratio, inner),
            spin: outer.carried(self.spin_ratio, inner),
            turn: (self.spin_ratio - self.orbit_ratio) * (inner.angle - outer.angle),
            turn_speed: (self.spin_ratio - self.orbit_ratio) * (inner.speed - outer.speed),
        }
    }

    /// Azimuth of a ball along its orbit [rad]; `arc`: its arc beyond the ideal orbit [m].
    #[inline(always)]
    pub(crate) fn azimuth(&self, ball: usize, rotations: &Rotations, arc: f64) -> f64 {
        self.start.angle[ball] + rotations.orbit.angle + arc / self.pitch_radius
    }

    /// Speed of ball or cage along the orbit [rad/s]; `arc_velocity`: beyond the ideal orbit [m/s].
    #[inline(always)]
    pub(crate) fn orbit_speed(&self, rotations: &Rotations, arc_velocity: f64) -> f64 {
        rotations.orbit.speed + arc_velocity / self.pitch_radius
    }

    /// The constants of a scene with its active terms, on raceways that are ideal circles.
    pub fn new(scene: &Scene, needs: &ActiveTerms) -> Self {
        let bearing = &scene.bearing;
        let spindle_inertia = match scene.spindle.tilt {
            SpindleTilt::Free(inertia) => Some(inertia),
            SpindleTilt::Held => None,
        };
        let rotation = scene.operation.rotation();
        let [x, y, z, about_y, about_z] = scene.operation.start_load();
        let orbit_ratio = kinematics::ideal_orbit_ratio(bearing);
        let relative_spin_ratio = kinematics::ideal_spin_ratio(bearing);
        let drag = Drag::new(bearing, &scene.lubricant);
        let deviations = scene.surfaces.balls.iter().map(|surface| surface.diameter_deviation);
        let largest_oversize = deviations
            .clone()
            .any(|deviation| deviation != 0.0)
            .then(|| 0.5 * deviations.fold(f64::NEG_INFINITY, f64::max));
        let raceway = RacewayContact::pair(bearing, &scene.lubricant, scene.raceway_damping.resolve(), needs.raceway);
        let mut pocket = Pocket::new(
            bearing,
            &scene.cage,
            &scene.lubricant,
            relative_spin_ratio * rotation.operating().relative(),
            needs.pocket,
        );
        if let Some(largest) = largest_oversize {
            pocket = pocket.with_unequal_balls(largest);
        }
        Self {
            layout: Layout {
                balls: bearing.parameters.ball_count,
                planar: needs.rung == ModelLevel::Planar,
                cage: needs.cage,
                axial_spindle: needs.axial_spindle,
                tilting_spindle: spindle_inertia.is_some(),
                attitude: false,
            },
            rotation,
            orbit_ratio,
            spin_ratio: relative_spin_ratio + orbit_ratio,
            pitch_radius: 0.5 * bearing.parameters.pitch_diameter,
            start: StartAzimuths::new(bearing.parameters.ball_count, &scene.pocket_deviations),
            ball_mass: bearing.ball_mass,
            ball_inertia: bearing.ball_inertia,
            ball_radius: 0.5 * bearing.parameters.ball_diameter,
            bodies: bodies(bearing, &scene.surfaces.balls),
            nominal_body: BallBody::new(bearing, 0.0),
            largest_oversize,
            raceway,
            wave_frequency: 0.0,
            defect_step: f64::INFINITY,
            defects: PerRaceway { inner: Vec::new(), outer: Vec::new() },
            sites: None,
            uneven_balls: Vec::new(),
            pocket,
            neighbours: (!needs.cage)
                .then(|| NeighbourContact::new(bearing, &scene.cage, &scene.lubricant, needs.pocket)),
            cage: scene.cage,
            land: scene.cage.land.filter(|_| needs.land).map(|land| Land::new(&land, &scene.lubricant)),
            drag: needs.drag.then_some(drag),
            churning: needs.churning.then_some(drag),
            spindle_mass: scene.spindle.mass,
            spindle_inertia,
            play: bearing.largest_displacement(),
            axial_offset: match scene.spindle.axial {
                AxialHold::Offset(offset) => offset,
                AxialHold::Fixed | AxialHold::Free => 0.0,
            },
            misalignment: scene.operation.misalignment,
            load: [x, y, z],
            moment: [about_y, about_z],
            varying_loads: scene.operation.varying_loads(),
            unbalance: if needs.unbalance { scene.spindle.unbalance_product(scene.operating_speed()) } else { 0.0 },
            gravity: if needs.gravity { scene.gravity } else { 0.0 },
            perturbation: scene.operation.start_perturbation(),
            damping: None,
        }
    }

    /// Azimuth at which ball or pocket `index` starts [rad]. Ball 0 starts at 0, under the load, or at the deviation of its pocket.
    pub fn start_azimuth(&self, index: usize) -> f64 {
        self.start.angle[index]
    }

    /// Size and mass of the balls from `first` on; `None`: all balls are nominal.
    #[inline(always)]
    pub(crate) fn unequal_bodies(&self, first: usize) -> Option<&BallBody<Lanes>> {
        self.largest_oversize.map(|_| &self.bodies[first / LANES])
    }

    /// Size and mass of a ball.
    pub(crate) fn body(&self, ball: usize) -> BallBody {
        self.bodies[ball / LANES].at(ball % LANES)
    }

    /// Start azimuth of a ball [rad], and its radius less the nominal one [m].
    #[inline(always)]
    pub(crate) fn start_and_oversize(&self, ball: usize) -> (f64, f64) {
        (self.start.angle[ball], self.oversize(ball))
    }

    /// Radius of a ball less the nominal one [m].
    #[inline(always)]
    pub(crate) fn oversize(&self, ball: usize) -> f64 {
        if self.has_equal_balls() { 0.0 } else { self.bodies[ball / LANES].oversize[ball % LANES] }
    }

    /// Sum of the radii of two balls less twice the nominal one [m].
    pub(crate) fn sum_of_oversizes(&self, one: usize, other: usize) -> f64 {
        self.body(one).oversize + self.body(other).oversize
    }

    /// Returns true where all balls are nominal, so that one can stand for another.
    pub(crate) fn has_equal_balls(&self) -> bool {
        self.largest_oversize.is_none()
    }
}

/// Bodies of the balls, padded to whole lanes by the last one.
fn bodies(bearing: &Bearing, surfaces: &[BallSurface]) -> Vec<BallBody<Lanes>> {
    let balls = bearing.parameters.ball_count;
    let deviation = |ball: usize| surfaces.get(ball).map_or(0.0, |surface| surface.diameter_deviation);
    let group = |first: usize| {
        let mut bodies = BallBody::default();
        for lane in 0..LANES {
            bodies.put(lane, BallBody::new(bearing, deviation((first + lane).min(balls - 1))));
        }
        bodies
    };
    (0..balls).step_by(LANES).map(group).collect()
}

fn start_azimuth(index: usize, balls: usize) -> f64 {
    std::f64::consts::TAU * index as f64 / balls as f64
}
