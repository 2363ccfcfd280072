//! The ladder of models, one rung a file: `dy/dt` of a scene with what it needs, loads summed over
//! bodies. The only place where a bearing implements `OdeSystem`.

pub mod condensed_contact;
mod dynamics;
pub mod equilibrium;
pub mod integrate;
pub mod observer;
pub mod spindle_runs;
pub mod state;
pub mod stiffness;
pub mod terms;
mod fading_damping;
mod full;
mod jacobian;
mod planar;
pub mod radially_condensed;
mod semi_implicit;
pub mod step_loads;
pub mod spindle_only;

pub use dynamics::{Dynamics, Reaction, Watch, Wrench};
pub use fading_damping::FadingDamping;
pub use full::Full;
pub use planar::Planar;

use crate::simulation::solve::ladder::Rung;
use crate::simulation::model::terms::Needs;
use crate::simulation::input::scene::Scene;
use crate::simulation::model::state::Layout;
use crate::numerics::lanes::{InstructionSet, LANES};
use crate::numerics::ode::structure::{Jacobian, Structure};
use crate::numerics::ode::{Integrator, OdeSystem};
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
                planar: needs.rung == Rung::Planar,
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

/// The equations of motion of a scene: any rung.
#[derive(Debug, Clone)]
pub enum Model {
    Full(Full),
    Planar(Planar),
}

impl Model {
    /// The rung that `needs` chose.
    pub fn new(scene: &Scene, needs: &Needs) -> Self {
        let mechanism = Mechanism::new(scene, needs);
        match needs.rung {
            Rung::Full => Self::Full(Full::new(mechanism)),
            // Reduced rungs have models of their own; what they leave of the dynamics is planar.
            _ => Self::Planar(Planar::new(mechanism)),
        }
    }

    pub fn mechanism(&self) -> &Mechanism {
        match self {
            Self::Full(model) => model.mechanism(),
            Self::Planar(model) => model.mechanism(),
        }
    }

    /// The same under damping that fades.
    pub fn damped(&self, damping: FadingDamping) -> Self {
        let mechanism = Mechanism { damping: Some(damping), ..self.mechanism().clone() };
        match self {
            Self::Full(_) => Self::Full(Full::new(mechanism)),
            Self::Planar(_) => Self::Planar(Planar::new(mechanism)),
        }
    }

    /// As `OdeSystem::derivative`, showing each load to `watch` on the way.
    pub fn derivative_watched(&self, time: f64, state: &[f64], derivative: &mut [f64], watch: &mut impl Watch) {
        match self {
            Self::Full(model) => model.evaluate(time, state, derivative, Some(watch)),
            Self::Planar(model) => model.evaluate(time, state, derivative, Some(watch)),
        }
    }

    /// The same model with other instructions of the same processor; its rates are the same to the bit.
    pub fn with_instructions(self, instructions: InstructionSet) -> Self {
        match self {
            Self::Full(model) => Self::Full(model.with_instructions(instructions)),
            Self::Planar(model) => Self::Planar(model.with_instructions(instructions)),
        }
    }
}

impl OdeSystem for Model {
    fn dimension(&self) -> usize {
        self.mechanism().layout.dimension()
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        match self {
            Self::Full(model) => model.derivative(time, state, derivative),
            Self::Planar(model) => model.derivative(time, state, derivative),
        }
    }

    fn structure(&self) -> Structure {
        match self {
            Self::Full(model) => model.structure(),
            Self::Planar(model) => model.structure(),
        }
    }

    fn own_method<'a>(&'a self, time: f64, state: &[f64], step: f64) -> Option<Box<dyn Integrator + 'a>> {
        match self {
            Self::Full(model) => model.own_method(time, state, step),
            Self::Planar(model) => model.own_method(time, state, step),
        }
    }

    fn jacobian(&self, time: f64, state: &[f64], rate: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        match self {
            Self::Full(model) => model.jacobian(time, state, rate, displacement, jacobian),
            Self::Planar(model) => model.jacobian(time, state, rate, displacement, jacobian),
        }
    }
}
