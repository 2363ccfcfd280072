//! By how much a single term can change the levels of a scene, before it is simulated.

use super::channel::BallContact;
use super::equilibrium::equilibrium;
use super::model::{Mechanism, Model, Watch};
use super::needs::Needs;
use super::run::{SimulationError, start_state};
use super::scene::Scene;
use crate::numerics::ode::OdeSystem;
use crate::physics::bearing::PerRaceway;
use crate::physics::raceway::{RacewayContact, RacewayLoad, RacewayTerms, RelativeMotion};

/// Azimuths of the balls, over one pitch, at which the spindle's rest is looked for.
const TURNS: usize = 4;

/// Forces of a scene at rest, to which those of single terms are compared.
#[derive(Debug, Clone)]
pub struct Judge<'a> {
    scene: &'a Scene,
    needs: &'a Needs,
    mechanism: Mechanism,
    motions: Vec<(BallContact, RelativeMotion, f64)>,
    /// Force by which the passing balls shake the spindle, along Y and Z [N].
    pub excitation: [f64; 2],
    pub load: f64,
}

/// Keeps how balls move over their raceways.
#[derive(Default)]
struct Motions(Vec<(BallContact, RelativeMotion, f64)>);

impl Watch for Motions {
    fn raceway(&mut self, _: usize, side: BallContact, motion: &RelativeMotion, load: &RacewayLoad) {
        self.0.push((side, *motion, load.normal));
    }
}

impl<'a> Judge<'a> {
    pub fn new(scene: &'a Scene, needs: &'a Needs) -> Result<Self, SimulationError> {
        let model = Model::new(scene, needs);
        let state = start_state(&model)?;
        let (mut motions, mut rates) = (Motions::default(), vec![0.0; model.dimension()]);
        model.derivative_watched(0.0, &state, &mut rates, &mut motions);
        let mechanism = model.mechanism().clone();
        let excitation = varying_compliance(&mechanism)?;
        let load = motions.0.iter().filter(|m| m.0 == BallContact::Inner).map(|m| m.2).sum();
        Ok(Self { scene, needs, mechanism, motions: motions.0, excitation, load })
    }

    /// Of all balls [N].
    pub fn drag(&self) -> f64 {
        let m = &self.mechanism;
        let speed = m.pitch_radius * m.orbit_ratio * self.scene.operating_speed();
        m.layout.balls as f64 * m.drag.map_or(0.0, |drag| drag.force(speed).abs())
    }

    pub fn churning(&self) -> f64 {
        let m = &self.mechanism;
        let spin = m.spin_ratio * self.scene.operating_speed();
        let radius = 0.5 * self.scene.bearing.parameters.ball_diameter;
        m.layout.balls as f64 * m.churning.map_or(0.0, |drag| drag.churning_moment([spin, 0.0, 0.0])[0].abs()) / radius
    }

    pub fn weight(&self) -> f64 {
        let m = &self.mechanism;
        (m.layout.balls as f64 * m.ball_mass + if m.layout.cage { m.cage.mass } else { 0.0 }) * m.ball_gravity.abs()
    }

    /// By which all tractions differ [N].
    pub fn traction(&self, terms: RacewayTerms) -> f64 {
        let damping = self.scene.raceway_damping.resolve();
        let pair = |terms| RacewayContact::pair(&self.scene.bearing, &self.scene.lubricant, damping, terms);
        let (own, other) = (pair(self.needs.raceway), pair(terms));
        let difference = |(side, motion, _): &(BallContact, RelativeMotion, f64)| match side {
            BallContact::Inner => self.difference(&own.inner, &other.inner, motion),
            _ => self.difference(&own.outer, &other.outer, motion),
        };
        self.motions.iter().map(difference).sum()
    }

    fn difference(&self, own: &RacewayContact, other: &RacewayContact, motion: &RelativeMotion) -> f64 {
        let radius = 0.5 * self.scene.bearing.parameters.ball_diameter;
        let (axis, _) = own.hertz().semi_axes(own.load::<false>(motion).normal);
        let spread = (motion.raceway_speed - motion.spin[0]).abs() * axis * axis / (2.0 * own.hertz().deformed_radius);
        let at = |share: f64| {
            let [a, r, t] = motion.velocity;
            let motion = RelativeMotion { velocity: [a, r, t + share * spread], ..*motion };
            let (own, other) = (own.load::<false>(&motion), other.load::<false>(&motion));
            let moment = |k: usize| (own.moment[k] - other.moment[k]).abs();
            (own.force[2] - other.force[2]).abs() + (moment(0) + moment(1) + moment(2)) / radius
        };
        [-2.0, -1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0, 2.0].into_iter().map(at).fold(0.0, f64::max)
    }
}

/// Force by which the balls that pass shake a spindle, along Y and Z: half of the way that it has to give, times its stiffness [N].
fn varying_compliance(mechanism: &Mechanism) -> Result<[f64; 2], SimulationError> {
    let (mut least, mut most, mut stiffness) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2], [0.0; 2]);
    let pitch = std::f64::consts::TAU / mechanism.layout.balls as f64;
    let mut turned = mechanism.clone();
    let speed = mechanism.speed.largest();
    for turn in 0..TURNS {
        for (angle, start) in turned.start.angle.iter_mut().zip(&mechanism.start.angle) {
            *angle = start + pitch * turn as f64 / TURNS as f64;
        }
        let rest = equilibrium(&turned, speed)?;
        for k in 0..2 {
            least[k] = f64::min(least[k], rest.spindle[k + 1]);
            most[k] = f64::max(most[k], rest.spindle[k + 1]);
        }
        for (load, angle) in rest.loads.iter().zip(&turned.start.angle) {
            let slopes = PerRaceway {
                inner: slope(&mechanism.raceway.inner, load.inner),
                outer: slope(&mechanism.raceway.outer, load.outer),
            };
            let held = slopes.inner * slopes.outer / (slopes.inner + slopes.outer).max(f64::MIN_POSITIVE);
            stiffness[0] += held * angle.cos().powi(2) / TURNS as f64;
            stiffness[1] += held * angle.sin().powi(2) / TURNS as f64;
        }
    }
    Ok(std::array::from_fn(|k| 0.5 * (most[k] - least[k]) * stiffness[k]))
}

/// Stiffness of a contact under a load, 3/2 K^⅔ Q^⅓ [N/m].
fn slope(contact: &RacewayContact, load: f64) -> f64 {
    1.5 * contact.hertz().stiffness.powf(2.0 / 3.0) * load.max(0.0).cbrt()
}
