//! What stays the same during a run: constants of bodies and contacts.

use crate::numerics::lanes::LANES;
use crate::physics::bearing::PerRaceway;
use crate::physics::cage::CageParameters;
use crate::physics::drag::Drag;
use crate::physics::frames::{Azimuth, Vector};
use crate::physics::kinematics;
use crate::physics::land::Land;
use crate::physics::operation::SpeedProfile;
use crate::physics::pocket::Pocket;
use crate::physics::raceway::RacewayContact;
use crate::physics::spindle::AxialHold;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::model::fading_damping::FadingDamping;
use crate::simulation::model::state::Layout;
use crate::simulation::model::terms::Needs;

/// What stays the same during a run: constants of bodies and contacts.
#[derive(Debug, Clone)]
pub struct Mechanism {
    pub layout: Layout,
    pub speed: SpeedProfile,
    /// Orbit speed of ideal balls over spindle speed.
    pub orbit_ratio: f64,
    /// Spin ω_x of ideal balls in space (that in the orbit frame, and the orbit's own) over spindle speed.
    pub spin_ratio: f64,
    pub pitch_radius: f64,
    /// Azimuths at which balls and pockets start; beyond the last ball, its own again, up to whole lanes.
    pub start: StartAzimuths,
    pub ball_mass: f64,
    pub ball_inertia: f64,
    /// [m]
    pub ball_radius: f64,
    pub raceway: PerRaceway<RacewayContact>,
    pub pocket: Pocket,
    pub cage: CageParameters,
    pub land: Option<Land>,
    pub drag: Option<Drag>,
    pub churning: Option<Drag>,
    pub spindle_mass: f64,
    /// Axial displacement at which the spindle is held [m].
    pub axial_offset: f64,
    /// Imposed tilt of the spindle about Y and Z [rad].
    pub misalignment: [f64; 2],
    /// Load on the spindle [N].
    pub load: Vector,
    /// Mass times eccentricity [kg m].
    pub unbalance: f64,
    /// [m/s²]
    pub gravity: f64,
    /// While a start settles; no part of the scene.
    pub damping: Option<FadingDamping>,
}

/// Azimuths by column.
#[derive(Debug, Clone)]
pub struct StartAzimuths {
    /// [rad]
    pub angle: Vec<f64>,
    pub cosine: Vec<f64>,
    pub sine: Vec<f64>,
}

impl StartAzimuths {
    fn new(balls: usize) -> Self {
        Self::of((0..balls.next_multiple_of(LANES)).map(|ball| start_azimuth(ball.min(balls - 1), balls)).collect())
    }

    /// All of them further round by an angle [rad].
    pub fn turned(&self, by: f64) -> Self {
        Self::of(self.angle.iter().map(|angle| angle + by).collect())
    }

    fn of(angle: Vec<f64>) -> Self {
        let (cosine, sine) = angle.iter().map(|&angle| Azimuth::new(angle)).map(|a| (a.cosine, a.sine)).unzip();
        Self { angle, cosine, sine }
    }
}

impl Mechanism {
    /// Whether contacts lean: the spindle moves along X, is held off its centre there, or is tilted.
    pub fn leans(&self) -> bool {
        self.layout.axial_spindle || self.axial_offset != 0.0 || self.misalignment != [0.0; 2]
    }

    /// Speed at which balls go round where the shaft turns steadily and they roll [rad/s].
    pub fn steady_orbit_speed(&self) -> Option<f64> {
        self.speed.is_constant().then(|| self.orbit_ratio * self.speed.at(0.0).1)
    }

    /// The constants of a scene with what it needs.
    pub fn new(scene: &Scene, needs: &Needs) -> Self {
        let bearing = &scene.bearing;
        let operating_speed = scene.operating_speed();
        let orbit_ratio = kinematics::ideal_orbit_ratio(bearing);
        let relative_spin_ratio = kinematics::ideal_spin_ratio(bearing);
        let drag = Drag::new(bearing, &scene.lubricant);
        Self {
            layout: Layout {
                balls: bearing.parameters.ball_count,
                planar: needs.rung == ModelLevel::Planar,
                cage: needs.cage,
                axial_spindle: needs.axial_spindle,
            },
            speed: scene.operation.speed.clone(),
            orbit_ratio,
            spin_ratio: relative_spin_ratio + orbit_ratio,
            pitch_radius: 0.5 * bearing.parameters.pitch_diameter,
            start: StartAzimuths::new(bearing.parameters.ball_count),
            ball_mass: bearing.ball_mass,
            ball_inertia: bearing.ball_inertia,
            ball_radius: 0.5 * bearing.parameters.ball_diameter,
            raceway: RacewayContact::pair(bearing, &scene.lubricant, scene.raceway_damping.resolve(), needs.raceway),
            pocket: Pocket::new(
                bearing,
                &scene.cage,
                &scene.lubricant,
                relative_spin_ratio * operating_speed,
                needs.pocket,
            ),
            cage: scene.cage,
            land: scene.cage.land.filter(|_| needs.land).map(|land| Land::new(&land, &scene.lubricant)),
            drag: needs.drag.then_some(drag),
            churning: needs.churning.then_some(drag),
            spindle_mass: scene.spindle.mass,
            axial_offset: match scene.spindle.axial {
                AxialHold::Offset(offset) => offset,
                AxialHold::Fixed | AxialHold::Free => 0.0,
            },
            misalignment: scene.operation.misalignment,
            load: scene.operation.load,
            unbalance: if needs.unbalance { scene.spindle.unbalance_product(operating_speed) } else { 0.0 },
            gravity: if needs.gravity { scene.gravity } else { 0.0 },
            damping: None,
        }
    }

    /// Azimuth at which ball or pocket `index` starts [rad]; ball 0 starts at 0, under the load.
    pub fn start_azimuth(&self, index: usize) -> f64 {
        start_azimuth(index, self.layout.balls)
    }
}

fn start_azimuth(index: usize, balls: usize) -> f64 {
    std::f64::consts::TAU * index as f64 / balls as f64
}
