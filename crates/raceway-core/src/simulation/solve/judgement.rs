//! Single terms that a scene can do without within `model_tolerance_db`: by how much each can change the levels is bounded
//! before the run, from the scene at rest.
//!
//! The factors of the bounds are measured (`benches/omissions.rs`, docs/data/term-omission.csv). Where no bound was found that holds, nothing
//! is left out.

use crate::numerics::ode::OdeSystem;
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::traction::TractionLaw;
use crate::physics::raceway::{RacewayContact, RacewayLoad, RelativeMotion};
use crate::simulation::input::channel::{BallContact, Channel};
use crate::simulation::input::scene::{Scene, Term, TermChoice};
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::equilibrium::equilibrium;
use crate::simulation::model::equilibrium::start_state;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::terms::{Grounds, LeftOut, Needs};
use crate::simulation::model::{Mechanism, Model, Watch};

/// Decibels of a small relative change of an amplitude.
const DB_PER_UNIT: f64 = 20.0 / std::f64::consts::LN_10;
/// How many decibels a relative change of the balls' speed costs at most: twice the worst that was measured.
const DB_PER_SPEED: f64 = 40.0;
/// Centrifugal acceleration, in standard gravities, below which balls out of the load zone fall and knock: nothing bounds that.
const LEAST_CENTRIFUGE: f64 = 50.0;
const STANDARD_GRAVITY: f64 = 9.81;
/// Least load of the most loaded ball over the centrifugal force on one: below, the spindle leaves the balls.
const LEAST_LOAD: f64 = 4.0;
/// Slip speed, at least, at which a traction law that is judged has its maximum [m/s]; a tenth of it broke the bound of strips.
const GENTLE_SLIP: f64 = 1.0;
/// Most drag on a ball whose strips are judged, over its centrifugal force; five times as much broke the bound.
const MOST_DRAG: f64 = 0.01;
/// Azimuths of the balls, over one pitch, at which the spindle's rest is looked for.
const TURNS: usize = 4;
/// Slip beside that of ideal rolling at which traction is compared, over what conformity spreads over the contact.
const SLIPS: [f64; 9] = [-2.0, -1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0, 2.0];
/// Gauss points that may stand for the strips, the fewest first.
const POINTS: [usize; 3] = [2, 4, CLOSEST];
const CLOSEST: usize = 6;

/// Something that may be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Omission {
    /// Strips of the contact ellipse, down to so many Gauss points.
    Strips(usize),
    Drag,
    Churning,
}

impl Omission {
    /// The name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Strips(_) => "strips",
            Self::Drag => Term::Drag.name(),
            Self::Churning => Term::Churning.name(),
        }
    }

    /// Takes it out of the equations.
    pub fn leave_out(self, needs: &mut Needs) {
        match self {
            Self::Strips(points) => (needs.raceway.gauss, needs.raceway.strips) = (true, points),
            Self::Drag => needs.drag = false,
            Self::Churning => needs.churning = false,
        }
    }

    fn reason(self, whole: &Needs) -> String {
        match self {
            Self::Strips(points) => {
                format!("{points} points of a Gauss rule in place of {} strips across a contact", whole.raceway.strips)
            }
            Self::Drag => "small beside the force of varying compliance".into(),
            Self::Churning => "as a force at the balls' surface, small beside that of varying compliance".into(),
        }
    }

    /// Whether what is asked for is no more than levels, or does not feel it: mixture and strips move slip, cage speed and pocket
    /// loads by more than levels; but six points are closer to the integral than nine strips are.
    fn serves(self, outputs: &Outputs) -> bool {
        let vibration = |channel: &Channel| matches!(channel, Channel::Spindle(..));
        self == Self::Strips(CLOSEST)
            || !outputs.contacts && !outputs.cage && outputs.spectra.iter().chain(&outputs.series).all(vibration)
    }

    /// Whether the request lets the scene decide.
    fn is_free(self, scene: &Scene) -> bool {
        let auto = |term: Term| scene.terms.get(term) == TermChoice::Auto;
        match self {
            Self::Strips(_) => auto(Term::Spin) && auto(Term::Conformity),
            // Without a cage they decide where the balls go.
            Self::Drag => auto(Term::Drag) && scene.terms.get(Term::Cage) != TermChoice::Off,
            Self::Churning => auto(Term::Churning) && scene.terms.get(Term::Cage) != TermChoice::Off,
        }
    }
}

/// The same without what changes the levels by no more than a tolerance, all together [dB]; on the rungs of the dynamics. The
/// saving decides the order: strips first, as few as fit.
pub fn within(whole: Needs, scene: &Scene, outputs: &Outputs, tolerance_db: f64) -> Needs {
    let mut needs = whole.clone();
    if tolerance_db == 0.0 || whole.rung.is_reduced() {
        return needs;
    }
    let Ok(Some(judge)) = Judge::new(scene, &whole) else { return needs };
    let mut rest = tolerance_db;
    let mut leave_out = |omission: Omission| {
        if !omission.serves(outputs) || !omission.is_free(scene) {
            return false;
        }
        let Some(bound) = judge.bound(omission).filter(|bound| *bound <= rest) else { return false };
        rest -= bound;
        omission.leave_out(&mut needs);
        needs.left_out.push(LeftOut {
            term: omission.name(),
            reason: omission.reason(&whole),
            by: Grounds::Judgement,
            bound: Some((bound, "dB")),
        });
        true
    };
    let _fewest = POINTS.into_iter().find(|points| leave_out(Omission::Strips(*points)));
    for omission in [Omission::Drag, Omission::Churning] {
        leave_out(omission);
    }
    needs
}

/// A scene at rest, where its terms are weighed against each other.
#[derive(Debug)]
pub struct Judge<'a> {
    scene: &'a Scene,
    needs: &'a Needs,
    mechanism: Mechanism,
    motions: Vec<(BallContact, RelativeMotion)>,
}

/// Keeps how balls move over their raceways, and the largest load of the inner one.
#[derive(Default)]
struct Motions {
    motions: Vec<(BallContact, RelativeMotion)>,
    largest: f64,
}

impl Watch for Motions {
    fn raceway(&mut self, _: usize, side: BallContact, motion: &RelativeMotion, load: &RacewayLoad) {
        self.motions.push((side, *motion));
        if side == BallContact::Inner {
            self.largest = self.largest.max(load.normal);
        }
    }
}

impl<'a> Judge<'a> {
    /// `None` where nothing bounds what small forces do: the cage rattles, traction grows steeply, the speed varies or is low, or the
    /// spindle may leave the balls; and with a load or motion along the axis, or a misaligned spindle, for which no bound was measured.
    pub fn new(scene: &'a Scene, needs: &'a Needs) -> Result<Option<Self>, SimulationError> {
        let model = Model::new(scene, needs);
        let m = model.mechanism();
        let damped = !m.layout.cage || m.pocket.film_is_damped();
        let in_plane = !m.leans();
        let orbit_speed = m.orbit_ratio * m.speed.largest();
        let centrifuge = m.pitch_radius * orbit_speed * orbit_speed;
        let law = &scene.lubricant.traction;
        let gentle = matches!(law, TractionLaw::FourParameter { at_rest: 0.0, at_slip, .. } if *at_slip >= GENTLE_SLIP);
        if !damped || !in_plane || !gentle || !m.speed.is_constant() || centrifuge < LEAST_CENTRIFUGE * STANDARD_GRAVITY
        {
            return Ok(None);
        }
        let state = start_state(&model)?;
        let (mut seen, mut rates) = (Motions::default(), vec![0.0; model.dimension()]);
        model.derivative_watched(0.0, &state, &mut rates, &mut seen);
        if seen.largest < LEAST_LOAD * m.ball_mass * centrifuge {
            return Ok(None);
        }
        Ok(Some(Self { scene, needs, mechanism: m.clone(), motions: seen.motions }))
    }

    /// By how much the levels can change without a term [dB]; `None`: it is not in the model, or nothing can be said.
    pub fn bound(&self, omission: Omission) -> Option<f64> {
        let m = &self.mechanism;
        let speed = m.speed.largest();
        let balls = m.layout.balls as f64;
        match omission {
            Omission::Strips(points) => (points < self.needs.raceway.strips && self.rolls_freely())
                .then(|| DB_PER_SPEED * self.slip_without_strips(points)),
            Omission::Drag => {
                m.drag.and_then(|drag| self.shaking(balls * drag.force(m.pitch_radius * m.orbit_ratio * speed).abs()))
            }
            Omission::Churning => m.churning.and_then(|churning| {
                let [moment, ..] = churning.churning_moment([m.spin_ratio * speed, 0.0, 0.0]);
                self.shaking(balls * moment.abs() / self.ball_radius())
            }),
        }
    }

    /// Whether the balls are hardly braked: only there the bound of strips holds.
    fn rolls_freely(&self) -> bool {
        let m = &self.mechanism;
        let orbit_velocity = m.pitch_radius * m.orbit_ratio * m.speed.largest();
        let drag = m.drag.map_or(0.0, |drag| drag.force(orbit_velocity).abs());
        let centrifugal = m.ball_mass * orbit_velocity * orbit_velocity / m.pitch_radius;
        drag <= MOST_DRAG * centrifugal
    }

    fn ball_radius(&self) -> f64 {
        0.5 * self.scene.bearing.parameters.ball_diameter
    }

    /// A force on all balls together [N] over the lesser of those by which they shake the spindle along Y and Z [dB].
    fn shaking(&self, force: f64) -> Option<f64> {
        let [along, across] = varying_compliance(&self.mechanism).ok()?;
        let bound = DB_PER_UNIT * force / along.min(across);
        bound.is_finite().then_some(bound)
    }

    /// Slip by which balls make up for what traction changes with Gauss points, over the speed of their orbit: Σ |ΔT| / Σ dT/du.
    fn slip_without_strips(&self, points: usize) -> f64 {
        let damping = self.scene.raceway_damping.resolve();
        let pair =
            |needs: &Needs| RacewayContact::pair(&self.scene.bearing, &self.scene.lubricant, damping, needs.raceway);
        let mut fewer = self.needs.clone();
        Omission::Strips(points).leave_out(&mut fewer);
        let (strips, gauss) = (pair(self.needs), pair(&fewer));
        let of = |both: &'_ PerRaceway<RacewayContact>, side: BallContact| match side {
            BallContact::Inner => both.inner.clone(),
            _ => both.outer.clone(),
        };
        let (mut difference, mut slope) = (0.0, 0.0);
        for (side, motion) in &self.motions {
            let compared =
                Compared { strips: of(&strips, *side), gauss: of(&gauss, *side), radius: self.ball_radius() };
            let (own_difference, own_slope) = compared.traction(motion);
            difference += own_difference;
            slope += own_slope;
        }
        let orbit = self.mechanism.pitch_radius * self.mechanism.orbit_ratio * self.mechanism.speed.largest();
        difference / (slope * orbit.abs())
    }
}

/// A contact with strips and with Gauss points.
struct Compared {
    strips: RacewayContact,
    gauss: RacewayContact,
    /// Of the ball [m].
    radius: f64,
}

impl Compared {
    /// Largest difference of traction, moments as forces at the ball's surface [N], and the slope of traction over slip [N s/m].
    fn traction(&self, motion: &RelativeMotion) -> (f64, f64) {
        let hertz = self.strips.hertz();
        let (axis, _) = hertz.semi_axes(self.strips.load::<false>(motion).normal);
        let spread = (motion.raceway_speed - motion.spin[0]).abs() * axis * axis / (2.0 * hertz.deformed_radius);
        if spread == 0.0 {
            return (0.0, 0.0);
        }
        let at = |contact: &RacewayContact, share: f64| {
            let [a, r, t] = motion.velocity;
            contact.load::<false>(&RelativeMotion { velocity: [a, r, t + share * spread], ..*motion })
        };
        let difference = |share: f64| {
            let (strips, gauss) = (at(&self.strips, share), at(&self.gauss, share));
            let moments: f64 = strips.moment.iter().zip(gauss.moment).map(|(a, b)| (a - b).abs()).sum();
            (strips.force[2] - gauss.force[2]).abs() + moments / self.radius
        };
        let slope = (at(&self.strips, 1.0).force[2] - at(&self.strips, -1.0).force[2]).abs() / (2.0 * spread);
        (SLIPS.into_iter().map(difference).fold(0.0, f64::max), slope)
    }
}

/// Force by which the balls that pass shake the spindle, along Y and Z: half of the way that its rest goes, times its stiffness [N].
fn varying_compliance(mechanism: &Mechanism) -> Result<[f64; 2], SimulationError> {
    let (mut least, mut most, mut stiffness) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2], [0.0; 2]);
    let pitch = std::f64::consts::TAU / mechanism.layout.balls as f64;
    let mut turned = mechanism.clone();
    for turn in 0..TURNS {
        let ahead = pitch * turn as f64 / TURNS as f64;
        for (angle, start) in turned.start.angle.iter_mut().zip(&mechanism.start.angle) {
            *angle = start + ahead;
        }
        let rest = equilibrium(&turned, mechanism.speed.largest())?;
        for k in 0..2 {
            least[k] = f64::min(least[k], rest.spindle[k + 1]);
            most[k] = f64::max(most[k], rest.spindle[k + 1]);
        }
        for (load, angle) in rest.loads.iter().zip(&turned.start.angle) {
            let inner = slope(&mechanism.raceway.inner, load.inner);
            let outer = slope(&mechanism.raceway.outer, load.outer);
            let held = inner * outer / (inner + outer).max(f64::MIN_POSITIVE) / TURNS as f64;
            stiffness[0] += held * angle.cos().powi(2);
            stiffness[1] += held * angle.sin().powi(2);
        }
    }
    Ok(std::array::from_fn(|k| 0.5 * (most[k] - least[k]) * stiffness[k]))
}

/// Stiffness of a contact under a load, 3/2 K^⅔ Q^⅓ [N/m].
fn slope(contact: &RacewayContact, load: f64) -> f64 {
    1.5 * contact.hertz().stiffness.powf(2.0 / 3.0) * load.max(0.0).cbrt()
}
