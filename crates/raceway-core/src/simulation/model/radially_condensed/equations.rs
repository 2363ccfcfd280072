//! Constants of the radially condensed model, computed once for a scene.

use super::applicability::inapplicability;
use super::ball::{Balls, LubricantDrag, OneBall};
use super::border::Border;
use super::pocket::Film;
use super::traction::{RacewayTraction, RisingTraction, WIDEST, WideTraction};
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide, Singles};
use crate::physics::ball::BallBody;
use crate::physics::bearing::PerRaceway;
use crate::physics::cage::PocketFilm;
use crate::physics::contact::traction::{TractionLaw, four_parameters};
use crate::physics::frames::Azimuth;
use crate::physics::pocket::WEDGE_DAMPING;
use crate::physics::raceway::RacewayContact;
use crate::simulation::input::channel::Channel;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::condensed_contact::CondensedContact;
use crate::simulation::model::equilibrium::{Equilibrium, equilibrium};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::heights::Waves;
use crate::simulation::model::mechanism::{Mechanism, StartAzimuths};
use crate::simulation::model::surfaces::with_surfaces;
use crate::simulation::model::terms::ActiveTerms;

/// Largest load over the largest static one up to which a contact has to be narrow [-].
const LOAD_MARGIN: f64 = 1.5;

/// Constants of ball and film for eight balls side by side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Alike {
    pub(super) ball: OneBall<Singles>,
    pub(super) film: Film<Singles>,
}

/// The equations of the model for a scene.
#[derive(Debug, Clone)]
pub struct RadiallyCondensed {
    /// Raceways are ideal circles, whose heights are apart.
    pub(super) mechanism: Mechanism,
    pub(super) needs: ActiveTerms,
    /// Start azimuths of the balls, eight at a time.
    pub(super) start: Vec<Azimuth<Singles>>,
    /// 1 for each ball, 0 for the copies of the last one that fill the last group.
    pub(super) present: Vec<Singles>,
    pub(super) contact: CondensedContact,
    pub(super) one: OneBall,
    pub(super) film: Film,
    /// Constants side by side: of each group of eight balls, or once where all balls are alike.
    all: Vec<Alike>,
    pub(super) traction: PerRaceway<RacewayTraction>,
    /// True if the film alone acts on a ball between the walls of its pocket.
    pub(super) plain_pocket: bool,
    /// True if the model has a cage with plain pockets, and raceways without a viscous damper.
    pub(super) is_plain: bool,
    /// `None`: both raceways are ideal circles.
    pub(super) waves: Option<Waves>,
    /// True if raceways are ideal circles and all balls are alike.
    pub(super) is_even: bool,
    /// Constant speed [rad/s] with the values that depend on it; `None` where the speed changes.
    pub(super) constant: Option<(f64, (LubricantDrag, f32))>,
    /// True if an output shows the motion of the cage.
    pub(super) shows_cage: bool,
    /// Start position of the spindle [m].
    pub(super) rest: [f64; 2],
    /// Damping over mass [1/s] and frequency [rad/s] of the spindle on its contacts at rest, as if all acted in one direction.
    pub(super) spindle_rates: [f64; 2],
    /// Fastest decay rate of a ball's slip by traction [1/s].
    pub(super) traction_rate: f64,
    pub(super) instructions: InstructionSet,
}

impl LubricantDrag {
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

/// Returns whether a channel depends on the motion of the cage.
fn shows_cage(channel: &Channel) -> bool {
    matches!(channel, Channel::CageDisplacement(_) | Channel::CageSpeed)
}

/// Traction of a raceway, in short form where the law has one and the contact stays narrow up to a load [N].
fn traction(scene: &Scene, needs: &ActiveTerms, contact: &RacewayContact, load: f64) -> RacewayTraction {
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

fn side_by_side_azimuths(start: &StartAzimuths) -> Vec<Azimuth<Singles>> {
    let group = |first: usize| Azimuth {
        cosine: Lanes::of(&start.cosine, first).single(),
        sine: Lanes::of(&start.sine, first).single(),
    };
    (0..start.angle.len()).step_by(LANES).map(group).collect()
}

impl RadiallyCondensed {
    /// The model of a scene, or the reason why it is not applicable.
    pub fn new(scene: &Scene, outputs: &Outputs) -> Result<Self, SimulationError> {
        if let Some(reason) = inapplicability(scene, outputs) {
            return Err(SimulationError::NotApplicable { rung: "radially_condensed", reason });
        }
        let needs = ActiveTerms::of(scene, outputs, Some(ModelLevel::Planar))?;
        let mut m = Mechanism::new(scene, &needs);
        let surfaced = with_surfaces(m.clone(), scene);
        (m.wave_frequency, m.defect_step) = (surfaced.wave_frequency, surfaced.defect_step);
        m.sites = surfaced.sites.clone();
        let balls = m.layout.balls;
        let rest = equilibrium(&surfaced, m.rotation.inner.at(0.0).1)?;
        let heaviest = match surfaced.under_largest_loads() {
            Some(heaviest) => equilibrium(&heaviest, m.rotation.inner.at(0.0).1)?,
            None => rest.clone(),
        };
        let largest = heaviest.loads.iter().fold(0.0, |most, load| f64::max(most, f64::max(load.inner, load.outer)));
        let damping = scene.raceway_damping.resolve();
        let film_damping = match scene.cage.film {
            PocketFilm::Wedge => WEDGE_DAMPING,
            PocketFilm::Given { damping, .. } => damping,
            PocketFilm::None | PocketFilm::Empirical11 => 0.0,
        };
        let contact = CondensedContact::new(m.raceway.map(|contact| contact.hertz().stiffness));
        // Radial position of a ball that touches the outer raceway without load, less the pitch radius.
        let lift = 0.25 * scene.bearing.radial_clearance;
        let pitch_radius = m.pitch_radius as f32;
        let single = contact.single();
        let of_body = |body: &BallBody| {
            let (mass, inertia, radius) =
                (body.mass as f32, body.inertia as f32, (m.ball_radius + body.oversize) as f32);
            let lift = lift - body.oversize;
            let nominal = (m.pitch_radius + lift) as f32;
            OneBall {
                contact: single,
                pitch_radius,
                per_pitch_radius: 1.0 / pitch_radius,
                nominal,
                per_nominal: 1.0 / nominal,
                lift: lift as f32,
                clearance: (0.5 * scene.bearing.radial_clearance - 2.0 * body.oversize) as f32,
                orbit_ratio: m.orbit_ratio as f32,
                spin_ratio: m.spin_ratio as f32,
                mass,
                per_mass: 1.0 / mass,
                per_inertia: 1.0 / inertia,
                radius,
                oversize: body.oversize as f32,
                turning: radius * radius * (1.0 / inertia),
                weight: (body.mass * m.gravity) as f32,
                chi: damping.chi as f32,
                viscous: damping.viscous as f32,
                axis_square: m
                    .raceway
                    .map(|contact| contact.hertz().semi_axes(contact.hertz().stiffness).0.powi(2) as f32),
            }
        };
        let in_pocket = |body: &BallBody| Film {
            stiffness: m.pocket.film_stiffness() as f32,
            damping: if needs.pocket.film { film_damping as f32 } else { 0.0 },
            clearance: (m.pocket.clearance() - body.oversize) as f32,
            pitch_radius,
        };
        let side_by_side = |bodies: &BallBody<Lanes>| {
            let mut all = Alike { ball: OneBall::default(), film: Film::default() };
            for lane in 0..LANES {
                all.ball.put(lane, of_body(&bodies.at(lane)));
                all.film.put(lane, in_pocket(&bodies.at(lane)));
            }
            all
        };
        let groups = if m.has_equal_balls() { 1 } else { m.bodies.len() };
        let all: Vec<Alike> = m.bodies.iter().take(groups).map(side_by_side).collect();
        let nominal = BallBody::new(&scene.bearing, 0.0);
        let (one, film) = (of_body(&nominal), in_pocket(&nominal));
        let waves = Waves::of(&surfaced);
        let mut model = Self {
            start: side_by_side_azimuths(&m.start),
            present: (0..balls)
                .step_by(LANES)
                .map(|first| Lanes(std::array::from_fn(|lane| if first + lane < balls { 1.0 } else { 0.0 })))
                .collect(),
            one,
            film,
            all,
            contact,
            traction: m.raceway.map(|contact| traction(scene, &needs, contact, LOAD_MARGIN * largest)),
            plain_pocket: !needs.pocket.hydrodynamics,
            is_plain: needs.cage && !needs.pocket.hydrodynamics && damping.viscous == 0.0,
            is_even: waves.is_none() && m.has_equal_balls(),
            waves,
            constant: None,
            shows_cage: outputs.spectra.iter().chain(&outputs.series).any(shows_cage),
            rest: [rest.spindle[1], rest.spindle[2]],
            spindle_rates: [0.0; 2],
            traction_rate: 0.0,
            instructions: InstructionSet::best(),
            mechanism: m,
            needs,
        };
        model.spindle_rates = model.rates_at_rest(&heaviest);
        let steepest = model.traction.map(RacewayTraction::steepest);
        let (m, radius) = (&model.mechanism, 0.5 * scene.bearing.parameters.ball_diameter);
        model.traction_rate =
            largest * (steepest.inner + steepest.outer) * (1.0 / m.ball_mass + radius * radius / m.ball_inertia);
        if model.mechanism.rotation.inner.is_constant() {
            let speed = model.mechanism.rotation.inner.at(0.0).1;
            model.constant = Some((speed, model.ideal(speed)));
        }
        Ok(model)
    }

    /// Speed of the spindle at a time [rad/s].
    #[inline(always)]
    pub(super) fn speed_at(&self, time: f64) -> f64 {
        self.constant.map_or_else(|| self.mechanism.rotation.inner.at(time).1, |(speed, _)| speed)
    }

    /// Drag near ideal rolling, and √δ of a ball on the outer raceway alone, at a spindle speed [rad/s].
    pub(super) fn ideal(&self, speed: f64) -> (LubricantDrag, f32) {
        let (m, radius) = (&self.mechanism, f64::from(self.one.nominal));
        let free = self.contact.unloaded(m.ball_mass, radius, m.orbit_ratio * speed, m.ball_mass * m.gravity);
        (LubricantDrag::at(m, speed), free.root as f32)
    }

    fn rates_at_rest(&self, rest: &Equilibrium) -> [f64; 2] {
        let (mut held, mut damped) = (0.0, 0.0);
        let hertz = self.mechanism.raceway.inner.hertz();
        for load in rest.loads.iter().filter(|load| load.inner > 0.0) {
            // Two contacts in series have half of the slope and of the damping of one.
            let depth = (load.inner / hertz.stiffness).powf(2.0 / 3.0);
            held += 0.75 * load.inner / depth;
            damped += 0.5 * (f64::from(self.one.chi) * load.inner + f64::from(self.one.viscous));
        }
        let mass = self.mechanism.spindle_mass;
        [damped / mass, (held / mass).sqrt()]
    }

    /// The model with other vector instructions of the same processor; its motion has the same bits.
    pub fn with_instructions(self, instructions: InstructionSet) -> Self {
        Self { instructions, ..self }
    }

    /// The model with traction by the contacts of the full model, as for laws without a short form.
    pub fn with_general_traction(self) -> Self {
        Self { traction: PerRaceway { inner: RacewayTraction::General, outer: RacewayTraction::General }, ..self }
    }

    /// Returns whether traction uses the contacts of the full model, which take several times as long.
    pub(crate) fn has_general_traction(&self) -> bool {
        let is_general = |of: &RacewayTraction| matches!(of, RacewayTraction::General);
        is_general(&self.traction.inner) || is_general(&self.traction.outer)
    }

    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    pub fn needs(&self) -> &ActiveTerms {
        &self.needs
    }

    /// Constants of the balls of a group.
    #[inline(always)]
    pub(super) fn all(&self, group: usize) -> &Alike {
        &self.all[group.min(self.all.len() - 1)]
    }

    /// Number of groups of eight balls.
    pub fn groups(&self) -> usize {
        self.start.len()
    }

    pub(super) fn pockets_are_damped(&self) -> bool {
        self.film.damping > 0.0
    }

    /// Fastest frequency of balls and cage against each other on the film [rad/s], of the cage's rotation or its motion in the plane.
    pub(super) fn film_frequency(&self) -> f64 {
        let (m, balls) = (&self.mechanism, self.mechanism.layout.balls as f64);
        let turning = balls * m.pitch_radius * m.pitch_radius / m.cage.axial_inertia;
        let moving = 0.5 * balls / m.cage.mass;
        (f64::from(self.film.stiffness) * (turning.max(moving) + 1.0 / m.ball_mass)).sqrt()
    }

    /// Damping of the spindle over its mass on its contacts at rest [1/s].
    pub(crate) fn spindle_damping(&self) -> f64 {
        self.spindle_rates[0]
    }

    /// Number of first-order states.
    pub fn states(&self) -> usize {
        self.states_on_ring() + 4
    }

    /// That number without the spindle.
    pub(crate) fn states_on_ring(&self) -> usize {
        3 * self.mechanism.layout.balls + if self.mechanism.layout.cage { 6 } else { 0 }
    }

    /// The model with all balls starting farther by an angle [rad].
    pub(crate) fn turned(mut self, by: f64) -> Self {
        self.mechanism.start = self.mechanism.start.turned(by);
        self.start = side_by_side_azimuths(&self.mechanism.start);
        self
    }

    /// The model with the spindle's start displaced by (y, z) [m].
    pub fn displaced(self, [y, z]: [f64; 2]) -> Self {
        Self { rest: [self.rest[0] + y, self.rest[1] + z], ..self }
    }

    /// Initial state: spindle in equilibrium under load, gravity and centrifugal force, balls in ideal rolling, cage centred.
    pub fn start(&self) -> (Vec<Balls>, Border) {
        (vec![Balls::default(); self.groups()], Border { spindle: self.rest, ..Border::default() })
    }
}
