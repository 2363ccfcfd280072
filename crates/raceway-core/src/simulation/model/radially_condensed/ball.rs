//! One ball between its raceways: where it is, what presses on it, what drives it. Formulas for one ball, run over several
//! side by side.

use super::border::Border;
use super::contact::Contact;
use super::traction::Sums;
use crate::numerics::lanes::{LANES, Lanes, Real, SideBySide, Singles, larger, side_by_side};
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::damping::viscous_ramp;
use crate::physics::frames::Azimuth;
use crate::simulation::model::condensed_contact::CondensedContact;

/// Deviations from ideal rolling, as in `state.rs`. The way along the orbit grows with time and keeps its digits; velocities are
/// held near those of rolling, and do with fewer.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallState<P = f64, V = f32> {
    /// [m]
    pub arc: P,
    /// [m/s]
    pub arc_velocity: V,
    /// About X [rad/s].
    pub spin: V,
}

/// Eight of them.
pub type Balls = BallState<Lanes, Singles>;

impl Balls {
    /// How far the balls have gone further along the orbit than their pockets [m].
    #[inline(always)]
    pub fn past_pockets(&self, cage_arc: f64) -> Singles {
        let mut past = Singles::default();
        for lane in 0..LANES {
            past[lane] = (self.arc[lane] - cage_arc) as f32;
        }
        past
    }
}

impl SideBySide for Balls {
    type One = BallState;

    #[inline(always)]
    fn at(&self, lane: usize) -> BallState {
        BallState { arc: self.arc[lane], arc_velocity: self.arc_velocity[lane], spin: self.spin[lane] }
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: BallState) {
        (self.arc[lane], self.arc_velocity[lane], self.spin[lane]) = (one.arc, one.arc_velocity, one.spin);
    }
}

/// Rates of the velocities of a ball, with what the implicit part of a step needs of their derivatives.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallRates<T = f32> {
    pub arc_velocity: T,
    pub spin: T,
    /// −∂(arc rate)/∂(arc velocity), ∂(arc rate)/∂(spin), ∂(spin rate)/∂(arc velocity): each not negative.
    pub arc_by_arc: T,
    pub arc_by_spin: T,
    pub spin_by_arc: T,
    /// −∂(spin rate)/∂(spin).
    pub spin_by_spin: T,
    /// Slope of the inner raceway's traction over slip [N s/m], and where the ball is.
    pub traction: T,
    pub azimuth: Azimuth<T>,
}
side_by_side!(BallRates { arc_velocity, spin, arc_by_arc, arc_by_spin, spin_by_arc, spin_by_spin, traction, azimuth });

/// What drives the motion at a time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drive {
    /// Of the spindle [rad/s], [rad/s²].
    pub speed: f32,
    pub acceleration: f32,
    /// The cage's azimuth.
    pub cage: Azimuth<f32>,
    pub mixture: Mixture,
    /// √δ of the outer contact under the centrifugal force of the ideal orbit.
    pub unloaded_root: f32,
    /// What the spindle's acceleration is taken to be [m/s²].
    pub spindle_acceleration: [f32; 2],
    /// What place and velocity of the spindle have of it [s², s]; the latter is what places of balls and cage have of velocities, too.
    pub place_share: f32,
    pub velocity_share: f32,
}

/// Drag [N] and churning [N m] = value + slope · deviation from the ideal orbit velocity and spin.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mixture {
    pub drag: [f32; 2],
    pub churning: [f32; 2],
}

/// Where a ball is in its pocket and in space, and how the raceways hold it there.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Held<T = f32> {
    /// Of the ball, of its pocket, and of the one ahead of the other.
    pub azimuth: Azimuth<T>,
    pub pocket: Azimuth<T>,
    pub ahead: Azimuth<T>,
    /// Orbit speed, and by how much it is more than the cage's [rad/s].
    pub orbit: T,
    pub past_cage: T,
    /// Radial force that no contact gives, outwards [N].
    pub centrifugal: T,
    /// Place and velocity of the spindle along the ball's direction [m, m/s], its velocity across.
    pub along: T,
    pub along_velocity: T,
    pub across_velocity: T,
    /// By which the inner raceway's force leans against the radius [rad].
    pub lean: T,
    /// Rate of approach of the raceways [m/s].
    pub rate: T,
    /// Orbit radius, that less the pitch radius [m], its rate [m/s].
    pub radius: T,
    pub lift: T,
    pub radial_velocity: T,
    /// Penetrations [m].
    pub inner: T,
    pub outer: T,
    /// Load of the inner raceway without the pocket's part [N].
    pub normal: T,
    /// Its derivatives by approach and rate of approach [N/m, N s/m].
    pub stiffness: T,
    pub damping: T,
    pub outer_share: T,
}
side_by_side!(Held {
    azimuth,
    pocket,
    ahead,
    orbit,
    past_cage,
    centrifugal,
    along,
    along_velocity,
    across_velocity,
    lean,
    rate,
    radius,
    lift,
    radial_velocity,
    inner,
    outer,
    normal,
    stiffness,
    damping,
    outer_share,
});

/// What a pocket does to its ball and passes on to the cage.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pushed<T = f32> {
    /// Normal load [N].
    pub load: T,
    /// On the ball, along the radius and along the orbit [N]; its moment about X [N m].
    pub radial: T,
    pub along: T,
    pub moment: T,
    /// −∂(force along the orbit)/∂(velocity) [N s/m].
    pub damping: T,
    /// On the cage: Y, Z [N], moment about X [N m]; damping of these.
    pub cage: [T; 3],
    pub cage_damping: [T; 3],
}
side_by_side!(Pushed { load, radial, along, moment, damping, cage, cage_damping });

/// Loads of both contacts and the slip over them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Loaded<T = f32> {
    pub inner: Contact<T>,
    pub outer: Contact<T>,
    /// By how much the inner load, where it presses, falls with the spindle's acceleration towards the ball, place and velocity
    /// going along by their shares [kg].
    pub slope: T,
}
side_by_side!(Loaded { inner, outer, slope });

/// What a ball passes on to the spindle: force along Y and Z [N], and its slope over the acceleration with the sign turned (yy, yz,
/// zz) [kg].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Passed<T = f32> {
    pub force: (T, T),
    pub slope: [T; 3],
}
side_by_side!(Passed { force, slope });

/// Constants of a ball.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct OneBall<T = f32> {
    pub contact: CondensedContact<T>,
    pub pitch_radius: T,
    pub per_pitch_radius: T,
    /// Orbit radius of a ball that touches the outer raceway without load [m].
    pub nominal: T,
    pub per_nominal: T,
    /// That less the pitch radius [m].
    pub lift: T,
    /// Half the diametral clearance: approach at which a weightless ball touches both raceways [m], less what the place says.
    pub clearance: T,
    pub orbit_ratio: T,
    pub spin_ratio: T,
    pub mass: T,
    pub per_mass: T,
    pub per_inertia: T,
    pub radius: T,
    /// Square of the radius over the inertia [1/kg].
    pub turning: T,
    /// Mass times gravity [N].
    pub weight: T,
    /// χ [s/m], viscous damper [N s/m].
    pub chi: T,
    pub viscous: T,
    /// a²/δ [m].
    pub axis_square: PerRaceway<T>,
}
side_by_side!(OneBall {
    contact,
    pitch_radius,
    per_pitch_radius,
    nominal,
    per_nominal,
    lift,
    clearance,
    orbit_ratio,
    spin_ratio,
    mass,
    per_mass,
    per_inertia,
    radius,
    turning,
    weight,
    chi,
    viscous,
    axis_square,
});

/// 1/(1 + x) for small x, to x³.
#[inline(always)]
fn reciprocal_near_one(x: f32) -> f32 {
    1.0 - x * (1.0 - x)
}

/// Cosine and sine of a small angle, to 1e-12 at 0.1.
#[inline(always)]
pub(super) fn small_azimuth<T: Real>(x: T) -> Azimuth<T> {
    let (one, square) = (T::of(1.0), x * x);
    Azimuth {
        cosine: one - square * (T::of(0.5) - square * (T::of(1.0 / 24.0) - square * T::of(1.0 / 720.0))),
        sine: x * (one - square * (T::of(1.0 / 6.0) - square * (T::of(1.0 / 120.0) - square * T::of(1.0 / 5_040.0)))),
    }
}

impl OneBall {
    /// How far a ball has gone further than the cage, which keeps it within a pocket's clearance.
    #[inline(always)]
    pub fn ahead(&self, past_pocket: f32) -> Azimuth<f32> {
        small_azimuth(past_pocket * self.per_pitch_radius)
    }

    /// The same where no cage turns.
    #[inline(always)]
    pub fn ahead_alone(&self, ball: &BallState) -> Azimuth<f32> {
        Azimuth::new(ball.arc * (1.0 / f64::from(self.pitch_radius))).single()
    }

    /// Between its raceways; `start`: where its pocket was.
    #[inline(always)]
    pub fn held(
        &self,
        drive: &Drive,
        start: Azimuth<f32>,
        ahead: Azimuth<f32>,
        border: &Border<f32>,
        ball: &BallState,
    ) -> Held {
        let pocket = start.turned(drive.cage);
        let azimuth = pocket.turned(ahead);
        let (c, s) = (azimuth.cosine, azimuth.sine);
        let orbit = self.orbit_ratio * drive.speed + ball.arc_velocity * self.per_pitch_radius;
        let centrifugal = larger(
            self.mass * (self.nominal + drive.unloaded_root * drive.unloaded_root) * orbit * orbit + self.weight * c,
            0.0,
        );
        let unloaded = self.contact.unloaded_near(drive.unloaded_root, centrifugal);

        // Approach of the raceways and its rate; the spindle's displacement across counts to second order.
        let ([y, z], [vy, vz]) = (border.spindle, border.spindle_velocity);
        let (along, across) = (y * c + z * s, z * c - y * s);
        let (along_velocity, across_velocity) = (vy * c + vz * s, vz * c - vy * s);
        let lean = across * self.per_nominal * reciprocal_near_one((unloaded.penetration - along) * self.per_nominal);
        let approach = along - 0.5 * across * lean - self.clearance;
        let rate = along_velocity + lean * ((self.nominal + unloaded.penetration) * orbit - across_velocity);

        // Both contacts; damping that takes what both dissipate; inertia of the ball's own motion.
        let contact = self.contact.load(approach, &unloaded);
        let damping = self.chi * contact.damped_load;
        let [ay, az] = drive.spindle_acceleration;
        let swing = (ay * c + az * s) + orbit * (2.0 * across_velocity - orbit * along);
        let inertia =
            self.mass * (contact.outer_share * contact.outer_share * swing + contact.outer_share_slope * rate * rate);
        Held {
            azimuth,
            pocket,
            ahead,
            orbit,
            past_cage: (ball.arc_velocity - border.cage_velocity[2]) * self.per_pitch_radius,
            centrifugal,
            along,
            along_velocity,
            across_velocity,
            lean,
            rate,
            radius: self.nominal + contact.outer,
            lift: self.lift + contact.outer,
            radial_velocity: contact.outer_share * rate,
            inner: contact.inner,
            outer: contact.outer,
            normal: contact.load + damping * rate + inertia,
            stiffness: contact.stiffness,
            damping,
            outer_share: contact.outer_share,
        }
    }

    /// With the viscous dampers of both raceways.
    #[inline(always)]
    pub fn with_viscous(&self, held: &Held) -> Held {
        let inner_share = 1.0 - held.outer_share;
        let damping = self.viscous
            * (inner_share * inner_share * viscous_ramp(held.inner)
                + held.outer_share * held.outer_share * viscous_ramp(held.outer));
        Held { normal: held.normal + damping * held.rate, damping: held.damping + damping, ..*held }
    }

    /// Loads, with what the pocket pushes, and slip.
    #[inline(always)]
    pub fn loaded(&self, drive: &Drive, ball: &BallState, held: &Held, pocket_radial: f32) -> Loaded {
        let normal = held.normal - held.outer_share * pocket_radial;
        let presses = (normal > 0.0) & (held.outer_share > 0.0);
        let pressed = |value: f32| if presses { value } else { 0.0 };
        let inner = pressed(normal);
        let outer = larger(inner + held.centrifugal + pocket_radial, 0.0);
        let share = pressed(held.outer_share);
        let tangential = held.radius * held.orbit;
        let spin = self.spin_ratio * drive.speed + ball.spin;
        let lean = held.lean;
        // Over the spindle's centre, along the direction in which the contact lies from there.
        let radius = held.radius - held.along;
        let over_centre = radius * (1.0 + 0.5 * lean * lean);
        let relative = tangential * (1.0 - 0.5 * lean * lean) - held.across_velocity
            + lean * (held.radial_velocity - held.along_velocity);
        Loaded {
            inner: Contact {
                load: inner,
                axis_square: self.axis_square.inner * held.inner,
                base: drive.speed * over_centre - relative,
                per_height: spin - drive.speed,
            },
            outer: Contact {
                load: outer,
                axis_square: self.axis_square.outer * held.outer,
                base: -tangential,
                per_height: -spin,
            },
            slope: self.mass * share * share
                + pressed(drive.place_share * held.stiffness + drive.velocity_share * held.damping),
        }
    }

    /// Rates of the ball under the traction of both raceways.
    #[inline(always)]
    pub fn rates(
        &self,
        drive: &Drive,
        ball: &BallState,
        held: &Held,
        loaded: &Loaded,
        pushed: &Pushed,
        traction: &PerRaceway<Sums>,
    ) -> BallRates {
        let PerRaceway { inner, outer } = traction;
        let (q_i, q_e) = (loaded.inner.load, loaded.outer.load);
        let drag = drive.mixture.drag[0] + drive.mixture.drag[1] * ball.arc_velocity;
        let churning = drive.mixture.churning[0] + drive.mixture.churning[1] * ball.spin;
        let force =
            q_i * (inner.force - held.lean) + q_e * outer.force + pushed.along + drag - self.weight * held.azimuth.sine;
        let per_radius = self.per_nominal * reciprocal_near_one(held.outer * self.per_nominal);
        let turning = (force * self.per_mass - 2.0 * held.radial_velocity * held.orbit) * per_radius;
        let moment = q_e * outer.moment - q_i * inner.moment + pushed.moment + churning;
        let (s_i, s_e) = (q_i * inner.slope, q_e * outer.slope);
        let cross = (s_i - s_e) * self.radius;
        BallRates {
            arc_velocity: self.pitch_radius * (turning - self.orbit_ratio * drive.acceleration),
            spin: moment * self.per_inertia - self.spin_ratio * drive.acceleration,
            arc_by_arc: (s_i + s_e + pushed.damping) * self.per_mass,
            arc_by_spin: cross * self.per_mass,
            spin_by_arc: cross * self.per_inertia,
            spin_by_spin: (s_i + s_e) * self.turning,
            traction: s_i,
            azimuth: held.azimuth,
        }
    }
}

/// On the spindle; `present`: 1, or 0 for a copy that only fills a lane.
#[inline(always)]
pub(super) fn passed(held: &Held, loaded: &Loaded, inner: &Sums, present: f32) -> Passed {
    let (q, t) = (loaded.inner.load, loaded.inner.load * inner.force);
    let (along, across) = (-(q + held.lean * t), held.lean * q - t);
    let (c, s) = (held.azimuth.cosine, held.azimuth.sine);
    let (c_present, s_present) = (c * present, s * present);
    let radial = loaded.slope;
    Passed {
        force: (along * c_present - across * s_present, along * s_present + across * c_present),
        slope: [radial * (c * c_present), radial * (c * s_present), radial * (s * s_present)],
    }
}
