//! ModelLevel 2: the radial motion of the balls is in equilibrium between the raceways, and nothing leaves the plane.
//!
//! A ball held between its raceways follows the spindle within microseconds, far above the band of interest. What is left of
//! it are its azimuth, orbit speed and spin; its radius follows from the approach of the raceways (`condensed_contact.rs`),
//! with what its inertia and the damping of both contacts do to first order. `ball.rs`, `pocket.rs` and `traction.rs` have the
//! formulas, `evaluation.rs` runs them over eight balls side by side, `stepping.rs` advances the motion, `looks.rs` looks on,
//! `recording.rs` has the run.

mod ball;
mod evaluation;
mod looks;
mod pocket;
mod recording;
mod stepping;
mod traction;

pub use ball::{BallRates, BallState, Balls};
pub use evaluation::{Rates, Seen};
pub use recording::{MOST_STEPS, Pace, simulate, simulate_beside};
pub use stepping::{Look, Stepper};

use super::Mechanism;
use super::condensed_contact::CondensedContact;
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, Singles, alike};
use crate::physics::bearing::PerRaceway;
use crate::physics::cage::PocketFilm;
use crate::physics::contact::traction::{TractionLaw, four_parameters};
use crate::physics::frames::Azimuth;
use crate::physics::pocket::WEDGE_DAMPING;
use crate::physics::raceway::RacewayContact;
use crate::physics::spindle::AxialHold;
use crate::simulation::input::channel::{Axis, Channel};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::{Scene, Term, TermChoice};
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::equilibrium::{Equilibrium, equilibrium};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::terms::Needs;
use ball::{Mixture, OneBall};
use pocket::Film;
use traction::{RacewayTraction, RisingTraction, WIDEST, WideTraction};

/// Loads beyond the largest static one for which contacts count as narrow.
const LOAD_MARGIN: f64 = 1.5;

/// Spindle and cage, (y, z).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Border<T = f64> {
    pub spindle: [T; 2],
    pub spindle_velocity: [T; 2],
    pub cage: [T; 2],
    pub cage_arc: T,
    /// y, z, along the arc [m/s].
    pub cage_velocity: [T; 3],
}

impl Border {
    /// In single precision, as the balls see it.
    #[inline(always)]
    fn single(&self) -> Border<f32> {
        Border {
            spindle: self.spindle.map(|x| x as f32),
            spindle_velocity: self.spindle_velocity.map(|x| x as f32),
            cage: self.cage.map(|x| x as f32),
            cage_arc: self.cage_arc as f32,
            cage_velocity: self.cage_velocity.map(|x| x as f32),
        }
    }
}

/// What eight balls have in common.
#[derive(Debug, Clone, Copy)]
struct Alike {
    ball: OneBall<Singles>,
    film: Film<Singles>,
}

/// The equations of the rung: made once a scene.
#[derive(Debug, Clone)]
pub struct RadiallyCondensed {
    mechanism: Mechanism,
    needs: Needs,
    /// Azimuths at which the balls start, eight at a time; 1 for each ball, 0 for the copies of the last one that fill up.
    start: Vec<Azimuth<Singles>>,
    present: Vec<Singles>,
    contact: CondensedContact,
    one: OneBall,
    film: Film,
    /// The same of every ball.
    all: Box<Alike>,
    traction: PerRaceway<RacewayTraction>,
    /// Whether a ball between the walls of its pocket feels nothing but the film.
    plain_pocket: bool,
    /// Whether a cage is there, its pockets are plain and raceways are without a viscous damper.
    is_plain: bool,
    /// Where the speed never changes: it [rad/s], and what is made anew elsewhere.
    constant: Option<(f64, (Mixture, f32))>,
    /// Whether an output shows the motion of the cage.
    shows_cage: bool,
    /// Where the spindle starts [m].
    rest: [f64; 2],
    /// Damping over mass and frequency of the spindle on its contacts at rest, as if all lay in one direction [1/s, rad/s].
    spindle_rates: [f64; 2],
    /// Fastest rate at which traction holds a ball [1/s].
    traction_rate: f64,
    instructions: InstructionSet,
}

impl Mixture {
    fn at(m: &Mechanism, speed: f64) -> Self {
        let line = |f: &dyn Fn(f64) -> f64, at: f64| {
            let step = 1e-3 * at.abs() + 1e-9;
            [f(at) as f32, ((f(at + step) - f(at - step)) / (2.0 * step)) as f32]
        };
        Self {
            drag: m.drag.map_or([0.0; 2], |drag| line(&|v| drag.force(v), m.pitch_radius * m.orbit_ratio * speed)),
            churning: m
                .churning
                .map_or([0.0; 2], |drag| line(&|w| drag.churning_moment([w, 0.0, 0.0])[0], m.spin_ratio * speed)),
        }
    }
}

/// Why this rung cannot stand for a scene and its outputs; `None`: it can.
pub fn unable(scene: &Scene, outputs: &Outputs) -> Option<&'static str> {
    let term_on = |term| scene.terms.get(term) == TermChoice::On;
    let along_x =
        |channel: &Channel| matches!(channel, Channel::Spindle(Axis::X, _) | Channel::CageDisplacement(Axis::X));
    if scene.operation.load[0] != 0.0 {
        Some("an axial load acts")
    } else if scene.spindle.axial == AxialHold::Free {
        Some("the spindle moves along X")
    } else if matches!(scene.spindle.axial, AxialHold::Offset(offset) if offset != 0.0) {
        Some("the spindle is held off its centre along X")
    } else if scene.operation.misalignment != [0.0; 2] {
        Some("the spindle is misaligned")
    } else if scene.cage.film == PocketFilm::Empirical11 && scene.terms.get(Term::Cage) != TermChoice::Off {
        Some("the pocket film empirical-11 is stiff and has no damping, which its fixed steps do not bear")
    } else if term_on(Term::CageTilt) {
        Some("terms.cage_tilt is on")
    } else if term_on(Term::Axial) {
        Some("terms.axial is on")
    } else if term_on(Term::BallRadialDynamics) {
        Some("terms.ball_radial_dynamics is on")
    } else if outputs.spectra.iter().chain(&outputs.series).any(along_x) {
        Some("an output asks for motion along X")
    } else {
        None
    }
}

/// Whether a channel shows the motion of the cage.
fn shows_cage(channel: &Channel) -> bool {
    matches!(channel, Channel::CageDisplacement(_) | Channel::CageSpeed)
}

/// Traction in short form where the law has one and the contact stays narrow up to a load [N].
fn traction(scene: &Scene, needs: &Needs, contact: &RacewayContact, load: f64) -> RacewayTraction {
    let TractionLaw::FourParameter { at_rest: 0.0, maximum, at_slip, limit } = scene.lubricant.traction else {
        return RacewayTraction::General;
    };
    if needs.raceway.hydrodynamics {
        return RacewayTraction::General;
    }
    let law = four_parameters(0.0, maximum, at_slip, limit);
    let (ball_radius, deformed) = (0.5 * scene.bearing.parameters.ball_diameter, contact.hertz().deformed_radius);
    let (axis, _) = contact.hertz().semi_axes(load);
    if axis * axis < WIDEST * ball_radius * ball_radius {
        let conformity = needs.raceway.conformity;
        RacewayTraction::Rising(Box::new(RisingTraction::new(law, conformity, ball_radius, deformed)))
    } else {
        let wide = WideTraction::new(law, &needs.raceway, ball_radius, deformed);
        wide.map_or(RacewayTraction::General, |wide| RacewayTraction::Wide(Box::new(wide)))
    }
}

impl RadiallyCondensed {
    /// The model of a scene, or why it has none on this rung.
    pub fn new(scene: &Scene, outputs: &Outputs) -> Result<Self, SimulationError> {
        if let Some(reason) = unable(scene, outputs) {
            return Err(SimulationError::Unable { rung: "radially_condensed", reason: reason.into() });
        }
        let needs = Needs::of(scene, outputs, Some(ModelLevel::Planar))?;
        let m = Mechanism::new(scene, &needs);
        let balls = m.layout.balls;
        let rest = equilibrium(&m, m.speed.at(0.0).1)?;
        let largest = rest.loads.iter().fold(0.0, |most, load| f64::max(most, f64::max(load.inner, load.outer)));
        let damping = scene.raceway_damping.resolve();
        let film_damping = match scene.cage.film {
            PocketFilm::Wedge => WEDGE_DAMPING,
            PocketFilm::Given { damping, .. } => damping,
            PocketFilm::None | PocketFilm::Empirical11 => 0.0,
        };
        let contact = CondensedContact::new(m.raceway.map(|contact| contact.hertz().stiffness));
        // Of a ball that touches the outer raceway without load over the pitch circle.
        let lift = 0.25 * scene.bearing.radial_clearance;
        let nominal = (m.pitch_radius + lift) as f32;
        let (mass, inertia) = (m.ball_mass as f32, m.ball_inertia as f32);
        let (pitch_radius, radius) = (m.pitch_radius as f32, (0.5 * scene.bearing.parameters.ball_diameter) as f32);
        let one = OneBall {
            contact: contact.single(),
            pitch_radius,
            per_pitch_radius: 1.0 / pitch_radius,
            nominal,
            per_nominal: 1.0 / nominal,
            lift: lift as f32,
            clearance: (0.5 * scene.bearing.radial_clearance) as f32,
            orbit_ratio: m.orbit_ratio as f32,
            spin_ratio: m.spin_ratio as f32,
            mass,
            per_mass: 1.0 / mass,
            per_inertia: 1.0 / inertia,
            radius,
            turning: radius * radius * (1.0 / inertia),
            weight: (m.ball_mass * m.gravity) as f32,
            chi: damping.chi as f32,
            viscous: damping.viscous as f32,
            axis_square: m.raceway.map(|contact| contact.hertz().semi_axes(contact.hertz().stiffness).0.powi(2) as f32),
        };
        let film = Film {
            stiffness: m.pocket.film_stiffness() as f32,
            damping: if needs.pocket.film { film_damping as f32 } else { 0.0 },
            clearance: m.pocket.clearance() as f32,
            pitch_radius,
        };
        let mut model = Self {
            start: (0..balls)
                .step_by(LANES)
                .map(|first| Azimuth {
                    cosine: Lanes::of(&m.start.cosine, first).single(),
                    sine: Lanes::of(&m.start.sine, first).single(),
                })
                .collect(),
            present: (0..balls)
                .step_by(LANES)
                .map(|first| Lanes(std::array::from_fn(|lane| if first + lane < balls { 1.0 } else { 0.0 })))
                .collect(),
            one,
            film,
            all: Box::new(Alike { ball: alike(one), film: alike(film) }),
            contact,
            traction: m.raceway.map(|contact| traction(scene, &needs, contact, LOAD_MARGIN * largest)),
            plain_pocket: !needs.pocket.hydrodynamics,
            is_plain: needs.cage && !needs.pocket.hydrodynamics && damping.viscous == 0.0,
            constant: None,
            shows_cage: outputs.spectra.iter().chain(&outputs.series).any(shows_cage),
            rest: [rest.spindle[1], rest.spindle[2]],
            spindle_rates: [0.0; 2],
            traction_rate: 0.0,
            instructions: InstructionSet::best(),
            mechanism: m,
            needs,
        };
        model.spindle_rates = model.rates_at_rest(&rest);
        let steepest = model.traction.map(RacewayTraction::steepest);
        let (m, radius) = (&model.mechanism, 0.5 * scene.bearing.parameters.ball_diameter);
        model.traction_rate =
            largest * (steepest.inner + steepest.outer) * (1.0 / m.ball_mass + radius * radius / m.ball_inertia);
        if model.mechanism.speed.is_constant() {
            let speed = model.mechanism.speed.at(0.0).1;
            model.constant = Some((speed, model.ideal(speed)));
        }
        Ok(model)
    }

    /// Speed of the spindle at a time [rad/s].
    #[inline(always)]
    fn speed_at(&self, time: f64) -> f64 {
        self.constant.map_or_else(|| self.mechanism.speed.at(time).1, |(speed, _)| speed)
    }

    /// Drag about ideal rolling and √δ of a ball that only the outer raceway holds, at a spindle speed [rad/s].
    fn ideal(&self, speed: f64) -> (Mixture, f32) {
        let (m, radius) = (&self.mechanism, f64::from(self.one.nominal));
        let free = self.contact.unloaded(m.ball_mass, radius, m.orbit_ratio * speed, m.ball_mass * m.gravity);
        (Mixture::at(m, speed), free.root as f32)
    }

    fn rates_at_rest(&self, rest: &Equilibrium) -> [f64; 2] {
        let (mut held, mut damped) = (0.0, 0.0);
        let hertz = self.mechanism.raceway.inner.hertz();
        for load in rest.loads.iter().filter(|load| load.inner > 0.0) {
            // Two contacts in series: half of the slope and of the damping of one.
            let depth = (load.inner / hertz.stiffness).powf(2.0 / 3.0);
            held += 0.75 * load.inner / depth;
            damped += 0.5 * (f64::from(self.one.chi) * load.inner + f64::from(self.one.viscous));
        }
        let mass = self.mechanism.spindle_mass;
        [damped / mass, (held / mass).sqrt()]
    }

    /// The same model with other instructions of the same processor; its motion is the same to the bit.
    pub fn with_instructions(self, instructions: InstructionSet) -> Self {
        Self { instructions, ..self }
    }

    /// The same model with every traction law through the contact of the full model, as laws without a short form take it.
    pub fn with_general_traction(self) -> Self {
        Self { traction: PerRaceway { inner: RacewayTraction::General, outer: RacewayTraction::General }, ..self }
    }

    /// Whether traction goes through the contacts of the full model, which take several times as long.
    pub fn has_general_traction(&self) -> bool {
        let is_general = |of: &RacewayTraction| matches!(of, RacewayTraction::General);
        is_general(&self.traction.inner) || is_general(&self.traction.outer)
    }

    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    pub fn needs(&self) -> &Needs {
        &self.needs
    }

    /// Balls by eights.
    pub fn groups(&self) -> usize {
        self.start.len()
    }

    fn pockets_are_damped(&self) -> bool {
        self.film.damping > 0.0
    }

    /// Fastest frequency of balls and cage against each other on the film [rad/s]: the cage turns, or it moves in its plane.
    fn film_frequency(&self) -> f64 {
        let (m, balls) = (&self.mechanism, self.mechanism.layout.balls as f64);
        let turning = balls * m.pitch_radius * m.pitch_radius / m.cage.axial_inertia;
        let moving = 0.5 * balls / m.cage.mass;
        (f64::from(self.film.stiffness) * (turning.max(moving) + 1.0 / m.ball_mass)).sqrt()
    }

    /// Damping of the spindle over its mass on its contacts at rest [1/s].
    pub fn spindle_damping(&self) -> f64 {
        self.spindle_rates[0]
    }

    /// First-order states of the scene on this rung.
    pub fn states(&self) -> usize {
        3 * self.mechanism.layout.balls + if self.mechanism.layout.cage { 6 } else { 0 } + 4
    }

    /// The same, its spindle starting a little beside its equilibrium (y, z) [m].
    pub fn displaced(self, [y, z]: [f64; 2]) -> Self {
        Self { rest: [self.rest[0] + y, self.rest[1] + z], ..self }
    }

    /// Spindle in equilibrium under load, gravity and centrifugal force; balls rolling ideally, cage centred.
    pub fn start(&self) -> (Vec<Balls>, Border) {
        (vec![Balls::default(); self.groups()], Border { spindle: self.rest, ..Border::default() })
    }
}
