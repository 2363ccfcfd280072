//! One ball between its raceways: where it is, what presses on it, what drives it. Formulas for one ball, run over several
//! side by side.

use super::Border;
use super::traction::Sums;
use crate::numerics::lanes::{larger, side_by_side};
use crate::numerics::ode::adams_moulton::Shares;
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::damping::{DampingFactor, viscous_ramp};
use crate::physics::frames::Azimuth;
use crate::simulation::model::condensed_contact::CondensedContact;

/// Deviations from ideal rolling, as in `state.rs`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallState<T = f64> {
    /// [m]
    pub arc: T,
    /// [m/s]
    pub arc_velocity: T,
    /// About X [rad/s].
    pub spin: T,
}
side_by_side!(BallState { arc, arc_velocity, spin });

/// Rates of the velocities of a ball, with what the implicit part of a step needs of their derivatives.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallRates<T = f64> {
    pub arc_velocity: T,
    pub spin: T,
    /// −∂(arc rate)/∂(arc velocity), ∂(arc rate)/∂(spin), ∂(spin rate)/∂(arc velocity): each not negative.
    pub arc_by_arc: T,
    pub arc_by_spin: T,
    pub spin_by_arc: T,
    /// −∂(spin rate)/∂(spin).
    pub spin_by_spin: T,
}
side_by_side!(BallRates { arc_velocity, spin, arc_by_arc, arc_by_spin, spin_by_arc, spin_by_spin });

/// What drives the motion at a time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drive {
    /// Of the spindle [rad], [rad/s], [rad/s²].
    pub angle: f64,
    pub speed: f64,
    pub acceleration: f64,
    /// The cage's azimuth.
    pub cage: Azimuth,
    pub mixture: Mixture,
    /// √δ of the outer contact under the centrifugal force of the ideal orbit.
    pub unloaded_root: f64,
    /// What the spindle's acceleration is taken to be [m/s²], and what place and velocity have of it.
    pub spindle_acceleration: [f64; 2],
    pub shares: Shares,
    /// What the places of balls and cage have of their velocities [s].
    pub place_share: f64,
}

/// Drag [N] and churning [N m] = value + slope · deviation from the ideal orbit velocity and spin.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mixture {
    pub drag: [f64; 2],
    pub churning: [f64; 2],
}

/// Where a ball is in its pocket and in space, and how the raceways hold it there.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Held<T = f64> {
    /// Of the ball, of its pocket, and of the one ahead of the other.
    pub azimuth: Azimuth<T>,
    pub pocket: Azimuth<T>,
    pub ahead: Azimuth<T>,
    /// Orbit speed [rad/s].
    pub orbit: T,
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
    /// Orbit radius [m] and its rate [m/s].
    pub radius: T,
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
    centrifugal,
    along,
    along_velocity,
    across_velocity,
    lean,
    rate,
    radius,
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
pub(super) struct Pushed<T = f64> {
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
pub(super) struct Loaded<T = f64> {
    pub inner: Contact<T>,
    pub outer: Contact<T>,
    /// By how much the inner load, where it presses, falls with the spindle's acceleration towards the ball, place and velocity
    /// going along by their shares [kg].
    pub slope: T,
}
side_by_side!(Loaded { inner, outer, slope });

/// Load of a contact [N], square of its semi-major axis [m²], and slip: base + height over the ball's centre · per_height.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Contact<T = f64> {
    pub load: T,
    pub axis_square: T,
    pub base: T,
    pub per_height: T,
}
side_by_side!(Contact { load, axis_square, base, per_height });

/// What a ball passes on to the spindle: force along Y and Z [N], and its slope over the acceleration with the sign turned (yy, yz,
/// zz) [kg].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Passed<T = f64> {
    pub force: (T, T),
    pub slope: [T; 3],
}
side_by_side!(Passed { force, slope });

/// Constants of a ball. A copy of it stands before each loop over balls, so that the compiler sees that nothing stored in
/// the loop changes it.
#[derive(Debug, Clone, Copy)]
pub(super) struct OneBall {
    pub contact: CondensedContact,
    pub pitch_radius: f64,
    /// Orbit radius of a ball that touches the outer raceway without load [m].
    pub nominal: f64,
    /// Half the diametral clearance: approach at which a weightless ball touches both raceways [m], less what the place says.
    pub clearance: f64,
    pub orbit_ratio: f64,
    pub spin_ratio: f64,
    pub mass: f64,
    pub inertia: f64,
    pub radius: f64,
    /// Mass times gravity [N].
    pub weight: f64,
    pub damping: DampingFactor,
    /// a²/δ [m].
    pub axis_square: PerRaceway<f64>,
}

/// 1/(1 + x) for small x, to x³.
#[inline(always)]
fn reciprocal_near_one(x: f64) -> f64 {
    1.0 - x * (1.0 - x)
}

/// Cosine and sine of a small angle, to 1e-12 at 0.1.
#[inline(always)]
pub(super) fn small_azimuth(x: f64) -> Azimuth {
    let square = x * x;
    Azimuth {
        cosine: 1.0 - square * (0.5 - square * (1.0 / 24.0 - square * (1.0 / 720.0))),
        sine: x * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5_040.0)))),
    }
}

impl OneBall {
    /// How far a ball has gone further than the cage, which keeps it within a pocket's clearance.
    #[inline(always)]
    pub fn ahead(&self, cage_arc: f64, ball: &BallState) -> Azimuth {
        small_azimuth((ball.arc - cage_arc) * (1.0 / self.pitch_radius))
    }

    /// The same where no cage turns.
    #[inline(always)]
    pub fn ahead_alone(&self, ball: &BallState) -> Azimuth {
        Azimuth::new(ball.arc * (1.0 / self.pitch_radius))
    }

    /// Between its raceways; `start`: where its pocket was.
    #[inline(always)]
    pub fn held(&self, drive: &Drive, start: Azimuth, ahead: Azimuth, border: &Border, ball: &BallState) -> Held {
        let (per_pitch_radius, per_nominal) = (1.0 / self.pitch_radius, 1.0 / self.nominal);
        let pocket = start.turned(drive.cage);
        let azimuth = pocket.turned(ahead);
        let (c, s) = (azimuth.cosine, azimuth.sine);
        let orbit = self.orbit_ratio * drive.speed + ball.arc_velocity * per_pitch_radius;
        let centrifugal = larger(
            self.mass * (self.nominal + drive.unloaded_root * drive.unloaded_root) * orbit * orbit + self.weight * c,
            0.0,
        );
        let unloaded = self.contact.unloaded_near(drive.unloaded_root, centrifugal);

        // Approach of the raceways and its rate; the spindle's displacement across counts to second order.
        let ([y, z], [vy, vz]) = (border.spindle, border.spindle_velocity);
        let (along, across) = (y * c + z * s, z * c - y * s);
        let (along_velocity, across_velocity) = (vy * c + vz * s, vz * c - vy * s);
        let lean = across * per_nominal * reciprocal_near_one((unloaded.penetration - along) * per_nominal);
        let approach = along - 0.5 * across * lean - self.clearance;
        let rate = along_velocity + lean * ((self.nominal + unloaded.penetration) * orbit - across_velocity);

        // Both contacts; damping that takes what both dissipate; inertia of the ball's own motion.
        let contact = self.contact.load(approach, &unloaded);
        let damping = self.damping.chi * contact.damped_load;
        let [ay, az] = drive.spindle_acceleration;
        let swing = (ay * c + az * s) + orbit * (2.0 * across_velocity - orbit * along);
        let inertia =
            self.mass * (contact.outer_share * contact.outer_share * swing + contact.outer_share_slope * rate * rate);
        Held {
            azimuth,
            pocket,
            ahead,
            orbit,
            centrifugal,
            along,
            along_velocity,
            across_velocity,
            lean,
            rate,
            radius: self.nominal + contact.outer,
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
        let damping = self.damping.viscous
            * (inner_share * inner_share * viscous_ramp(held.inner)
                + held.outer_share * held.outer_share * viscous_ramp(held.outer));
        Held { normal: held.normal + damping * held.rate, damping: held.damping + damping, ..*held }
    }

    /// Loads, with what the pocket pushes, and slip.
    #[inline(always)]
    pub fn loaded(&self, drive: &Drive, ball: &BallState, held: &Held, pocket_radial: f64) -> Loaded {
        let normal = held.normal - held.outer_share * pocket_radial;
        let presses = (normal > 0.0) & (held.outer_share > 0.0);
        let pressed = |value: f64| if presses { value } else { 0.0 };
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
                + pressed(drive.shares.place * held.stiffness + drive.shares.velocity * held.damping),
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
        let (per_mass, per_inertia, per_nominal) = (1.0 / self.mass, 1.0 / self.inertia, 1.0 / self.nominal);
        let PerRaceway { inner, outer } = traction;
        let (q_i, q_e) = (loaded.inner.load, loaded.outer.load);
        let drag = drive.mixture.drag[0] + drive.mixture.drag[1] * ball.arc_velocity;
        let churning = drive.mixture.churning[0] + drive.mixture.churning[1] * ball.spin;
        let force =
            q_i * (inner.force - held.lean) + q_e * outer.force + pushed.along + drag - self.weight * held.azimuth.sine;
        let per_radius = per_nominal * reciprocal_near_one(held.outer * per_nominal);
        let turning = (force * per_mass - 2.0 * held.radial_velocity * held.orbit) * per_radius;
        let moment = q_e * outer.moment - q_i * inner.moment + pushed.moment + churning;
        let (s_i, s_e) = (q_i * inner.slope, q_e * outer.slope);
        let cross = (s_i - s_e) * self.radius;
        BallRates {
            arc_velocity: self.pitch_radius * (turning - self.orbit_ratio * drive.acceleration),
            spin: moment * per_inertia - self.spin_ratio * drive.acceleration,
            arc_by_arc: (s_i + s_e + pushed.damping) * per_mass,
            arc_by_spin: cross * per_mass,
            spin_by_arc: cross * per_inertia,
            spin_by_spin: (s_i + s_e) * (self.radius * self.radius * per_inertia),
        }
    }
}

/// On the spindle; `present`: 1, or 0 for a copy that only fills a lane.
#[inline(always)]
pub(super) fn passed(drive: &Drive, held: &Held, loaded: &Loaded, inner: &Sums, present: f64) -> Passed {
    let (q, t) = (loaded.inner.load, loaded.inner.load * inner.force);
    let (along, across) = (-(q + held.lean * t), held.lean * q - t);
    let (c, s) = (held.azimuth.cosine, held.azimuth.sine);
    let (c_present, s_present) = (c * present, s * present);
    // Along the radius, and by traction across it.
    let (radial, tangential) = (loaded.slope, drive.shares.velocity * (q * inner.slope));
    Passed {
        force: (along * c_present - across * s_present, along * s_present + across * c_present),
        slope: [
            radial * (c * c_present) + tangential * (s * s_present),
            (radial - tangential) * (c * s_present),
            radial * (s * s_present) + tangential * (c * c_present),
        ],
    }
}
