//! One ball between its raceways: position, loads, traction and rates. Each formula is for one ball and runs over several side by side.

use super::border::Border;
use super::contact::Contact;
use super::traction::Sums;
use crate::numerics::lanes::{LANES, Lanes, Real, SideBySide, Singles, larger, side_by_side};
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::damping::viscous_ramp;
use crate::physics::frames::Azimuth;
use crate::simulation::model::condensed_contact::CondensedContact;
use crate::simulation::model::heights::{Heights, Lift};

/// Deviations from ideal rolling, as in `state.rs`. The arc along the orbit grows with time and needs double precision; velocities stay
/// near those of rolling, and single precision suffices.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallState<P = f64, V = f32> {
    /// Arc along the orbit [m].
    pub arc: P,
    /// Rate of the arc [m/s].
    pub arc_velocity: V,
    /// Spin about X [rad/s].
    pub spin: V,
}

/// Eight balls side by side.
pub type Balls = BallState<Lanes, Singles>;

impl Balls {
    /// Arc of the balls less that of their pockets [m].
    #[inline(always)]
    pub(crate) fn past_pockets(&self, cage_arc: f64) -> Singles {
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

/// Rates of the velocities of a ball, with their derivatives for the implicit part of a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct BallRates<T = f32> {
    pub arc_velocity: T,
    pub spin: T,
    /// −∂(arc rate)/∂(arc velocity), ∂(arc rate)/∂(spin), ∂(spin rate)/∂(arc velocity): each not negative.
    pub arc_by_arc: T,
    pub arc_by_spin: T,
    pub spin_by_arc: T,
    /// −∂(spin rate)/∂(spin).
    pub spin_by_spin: T,
    /// Slope of the inner raceway's traction over slip [N s/m], and azimuth of the ball.
    pub traction: T,
    pub azimuth: Azimuth<T>,
}
side_by_side!(BallRates { arc_velocity, spin, arc_by_arc, arc_by_spin, spin_by_arc, spin_by_spin, traction, azimuth });

/// Prescribed motion and estimates at one time, common to all balls.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drive {
    /// Speed [rad/s] and acceleration [rad/s²] of the spindle's rotation.
    pub speed: f32,
    pub acceleration: f32,
    /// Azimuth of the cage.
    pub cage: Azimuth<f32>,
    pub mixture: LubricantDrag,
    /// √δ of the outer contact under the centrifugal force of the ideal orbit.
    pub unloaded_root: f32,
    /// Predicted acceleration of the spindle [m/s²].
    pub spindle_acceleration: [f32; 2],
    /// Shares of that acceleration in place and velocity of the spindle [s², s].
    pub place_share: f32,
    pub velocity_share: f32,
    /// Share of velocities in the places of balls and cage [s].
    pub cage_share: f32,
}

/// Drag [N] and churning [N m] = value + slope · deviation from the ideal orbit velocity and spin.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LubricantDrag {
    pub drag: [f32; 2],
    pub churning: [f32; 2],
}

/// Position of a ball in space and in its pocket, and the elastic and damping forces of the raceways there.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BallInRaceways<T = f32> {
    /// Azimuth of the ball, of its pocket, and the difference of both.
    pub azimuth: Azimuth<T>,
    pub pocket: Azimuth<T>,
    pub ahead: Azimuth<T>,
    /// Orbit speed, and its excess over the cage's [rad/s].
    pub orbit: T,
    pub past_cage: T,
    /// Outward body force: centrifugal force and weight, on wavy raceways with the inertia of the radial motion [N].
    pub outward: T,
    /// Place and velocity of the spindle along the ball's direction [m, m/s], its velocity across.
    pub along: T,
    pub along_velocity: T,
    pub across_velocity: T,
    /// Inclination of the inner raceway's force to the radius [rad].
    pub lean: T,
    /// Rate of approach of the raceways [m/s].
    pub rate: T,
    /// Orbit radius [m], its excess over the pitch radius [m], and its rate [m/s].
    pub radius: T,
    pub lift: T,
    pub radial_velocity: T,
    /// Penetrations [m].
    pub inner: T,
    pub outer: T,
    /// Load of the inner raceway without the effect of the pocket [N].
    pub normal: T,
    /// Derivatives of that load by approach and rate of approach [N/m, N s/m].
    pub stiffness: T,
    pub damping: T,
    pub outer_share: T,
}
side_by_side!(BallInRaceways {
    azimuth,
    pocket,
    ahead,
    orbit,
    past_cage,
    outward,
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

/// Load of a pocket on its ball and on the cage.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PocketReaction<T = f32> {
    /// Normal load [N].
    pub load: T,
    /// Force on the ball along the radius and along the orbit [N], and its moment about X [N m].
    pub radial: T,
    pub along: T,
    pub moment: T,
    /// −∂(force along the orbit)/∂(velocity) [N s/m].
    pub damping: T,
    /// Load on the cage: force along Y and Z [N], moment about X [N m]; damping of these.
    pub cage: [T; 3],
    pub cage_damping: [T; 3],
}
side_by_side!(PocketReaction { load, radial, along, moment, damping, cage, cage_damping });

/// Loads and slip of both contacts.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RacewayLoads<T = f32> {
    pub inner: Contact<T>,
    pub outer: Contact<T>,
    /// Decrease of the inner load with the spindle's acceleration towards the ball, including the shares of place and velocity [kg]; 0
    /// without contact.
    pub slope: T,
}
side_by_side!(RacewayLoads { inner, outer, slope });

/// Force of a ball on the spindle along Y and Z [N], and its negative slope over the acceleration (yy, yz, zz) [kg].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SpindleReaction<T = f32> {
    pub force: (T, T),
    pub slope: [T; 3],
}
side_by_side!(SpindleReaction { force, slope });

/// Constants of a ball.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct OneBall<T = f32> {
    pub contact: CondensedContact<T>,
    pub pitch_radius: T,
    pub per_pitch_radius: T,
    /// Orbit radius of a ball that touches the outer raceway without load [m].
    pub nominal: T,
    pub per_nominal: T,
    /// That radius less the pitch radius [m].
    pub lift: T,
    /// Half the diametral clearance: displacement of the raceways at which a weightless ball touches both [m].
    pub clearance: T,
    pub orbit_ratio: T,
    pub spin_ratio: T,
    pub mass: T,
    pub per_mass: T,
    pub per_inertia: T,
    pub radius: T,
    /// Radius less that of a nominal ball [m].
    pub oversize: T,
    /// Square of the radius over the inertia [1/kg].
    pub turning: T,
    /// Mass times gravity [N].
    pub weight: T,
    /// χ [s/m], viscous damper [N s/m].
    pub chi: T,
    pub viscous: T,
    /// Square of the semi-major axis over the penetration, a²/δ [m].
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
    oversize,
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
    /// Azimuth difference between a ball and its pocket, which stays within the pocket's clearance.
    #[inline(always)]
    pub(super) fn ahead(&self, past_pocket: f32) -> Azimuth<f32> {
        small_azimuth(past_pocket * self.per_pitch_radius)
    }

    /// Azimuth difference of a ball from ideal rolling, without a cage.
    #[inline(always)]
    pub(crate) fn ahead_alone(&self, ball: &BallState) -> Azimuth<f32> {
        Azimuth::new(ball.arc * (1.0 / f64::from(self.pitch_radius))).single()
    }

    /// Position and elastic state of the ball; `start`: start azimuth of its pocket. `WAVY`: raceways have `heights`.
    #[inline(always)]
    pub(crate) fn in_raceways<const WAVY: bool>(
        &self,
        drive: &Drive,
        start: Azimuth<f32>,
        ahead: Azimuth<f32>,
        border: &Border<f32>,
        ball: &BallState,
        heights: &Heights<f32>,
    ) -> BallInRaceways {
        let pocket = start.turned(drive.cage);
        let azimuth = pocket.turned(ahead);
        let (c, s) = (azimuth.cosine, azimuth.sine);
        let orbit = self.orbit_ratio * drive.speed + ball.arc_velocity * self.per_pitch_radius;
        let centrifugal = larger(
            self.mass * (self.nominal + drive.unloaded_root * drive.unloaded_root) * orbit * orbit + self.weight * c,
            0.0,
        );
        let unloaded = self.contact.unloaded_near(drive.unloaded_root, centrifugal);

        // Approach of the raceways and its rate; the spindle's displacement across the ball's direction enters to second order.
        let ([y, z], [vy, vz]) = (border.spindle, border.spindle_velocity);
        let (along, across) = (y * c + z * s, z * c - y * s);
        let (along_velocity, across_velocity) = (vy * c + vz * s, vz * c - vy * s);
        let lean = across * self.per_nominal * reciprocal_near_one((unloaded.penetration - along) * self.per_nominal);
        let mut approach = along - 0.5 * across * lean - self.clearance;
        let mut rate = along_velocity + lean * ((self.nominal + unloaded.penetration) * orbit - across_velocity);
        let mut raised = PerRaceway::<Lift<f32>>::default();
        if WAVY {
            let turning = (orbit * along - across_velocity) * self.per_nominal;
            let rings = PerRaceway { inner: orbit + turning - drive.speed, outer: orbit };
            let spin = self.spin_ratio * drive.speed + ball.spin;
            raised = heights.lifts(rings, PerRaceway { inner: orbit + turning, outer: orbit }, spin);
            approach += raised.inner.height + raised.outer.height;
            rate += raised.inner.rate + raised.outer.rate;
        }

        // Elastic load of both contacts, damping with the dissipation of both, and inertia of the ball's radial motion.
        let contact = self.contact.load(approach, &unloaded);
        let damping = self.chi * contact.damped_load;
        let [ay, az] = drive.spindle_acceleration;
        let mut swing = (ay * c + az * s) + orbit * (2.0 * across_velocity - orbit * along);
        if WAVY {
            swing += raised.inner.acceleration + raised.outer.acceleration;
        }
        let mut inertia =
            self.mass * (contact.outer_share * contact.outer_share * swing + contact.outer_share_slope * rate * rate);
        let (mut outward, mut moved, mut radial_velocity) = (centrifugal, contact.outer, contact.outer_share * rate);
        if WAVY {
            // The ball stands on the height of the outer raceway: r = r₀ + δ_e − h_e, r̈ = a_e D̈ − ḧ_e.
            let lifting = self.mass * raised.outer.acceleration;
            inertia -= contact.outer_share * lifting;
            outward += lifting - self.mass * contact.outer_share * swing;
            moved -= raised.outer.height;
            radial_velocity -= raised.outer.rate;
        }
        BallInRaceways {
            azimuth,
            pocket,
            ahead,
            orbit,
            past_cage: (ball.arc_velocity - border.cage_velocity[2]) * self.per_pitch_radius,
            outward,
            along,
            along_velocity,
            across_velocity,
            lean,
            rate,
            radius: self.nominal + moved,
            lift: self.lift + moved,
            radial_velocity,
            inner: contact.inner,
            outer: contact.outer,
            normal: contact.load + damping * rate + inertia,
            stiffness: contact.stiffness,
            damping,
            outer_share: contact.outer_share,
        }
    }

    /// Adds the viscous dampers of both raceways.
    #[inline(always)]
    pub(crate) fn with_viscous(&self, held: &BallInRaceways) -> BallInRaceways {
        let inner_share = 1.0 - held.outer_share;
        let damping = self.viscous
            * (inner_share * inner_share * viscous_ramp(held.inner)
                + held.outer_share * held.outer_share * viscous_ramp(held.outer));
        BallInRaceways { normal: held.normal + damping * held.rate, damping: held.damping + damping, ..*held }
    }

    /// Loads and slip of both contacts under the radial force of the pocket. `WAVY`: raceways have heights, or balls differ.
    #[inline(always)]
    pub(crate) fn raceway_loads<const WAVY: bool>(
        &self,
        drive: &Drive,
        ball: &BallState,
        held: &BallInRaceways,
        pocket_radial: f32,
    ) -> RacewayLoads {
        let normal = held.normal - held.outer_share * pocket_radial;
        let presses = (normal > 0.0) & (held.outer_share > 0.0);
        let pressed = |value: f32| if presses { value } else { 0.0 };
        let inner = pressed(normal);
        let outer = larger(inner + held.outward + pocket_radial, 0.0);
        let share = pressed(held.outer_share);
        let tangential = held.radius * held.orbit;
        let spin = self.spin_ratio * drive.speed + ball.spin;
        let lean = held.lean;
        // Distance of the contact from the spindle's centre.
        let radius = held.radius - held.along;
        let over_centre = radius * (1.0 + 0.5 * lean * lean);
        let relative = tangential * (1.0 - 0.5 * lean * lean) - held.across_velocity
            + lean * (held.radial_velocity - held.along_velocity);
        let (inner_height, outer_height) = (spin - drive.speed, -spin);
        let (mut inner_base, mut outer_base) = (drive.speed * over_centre - relative, -tangential);
        if WAVY {
            // Traction has the heights of nominal balls. A larger ball touches farther from its centre.
            inner_base += self.oversize * inner_height;
            outer_base += self.oversize * outer_height;
        }
        RacewayLoads {
            inner: Contact {
                load: inner,
                axis_square: self.axis_square.inner * held.inner,
                base: inner_base,
                per_height: inner_height,
            },
            outer: Contact {
                load: outer,
                axis_square: self.axis_square.outer * held.outer,
                base: outer_base,
                per_height: outer_height,
            },
            slope: self.mass * share * share
                + pressed(drive.place_share * held.stiffness + drive.velocity_share * held.damping),
        }
    }

    /// The forces along both raceways with those of heights, −h'/r of the load, and the moments: those of traction on a ball of this size, and
    /// h' of the ball's own heights. Moments of the inner raceway count against those of the outer one.
    #[inline(always)]
    pub(super) fn with_lean(
        &self,
        held: &BallInRaceways,
        heights: &Heights<f32>,
        traction: &PerRaceway<Sums>,
    ) -> PerRaceway<Sums> {
        let PerRaceway { inner, outer } = traction;
        let (slopes, own) = (heights.slopes(), &heights.ball);
        PerRaceway {
            inner: Sums {
                force: inner.force - slopes.inner / (held.radius - held.along),
                moment: inner.moment + self.oversize * inner.force - own.inner.slope,
                ..*inner
            },
            outer: Sums {
                force: outer.force - slopes.outer / held.radius,
                moment: outer.moment + self.oversize * outer.force + own.outer.slope,
                ..*outer
            },
        }
    }

    /// Rates of the ball under the traction of both raceways.
    #[inline(always)]
    pub(super) fn rates(
        &self,
        drive: &Drive,
        ball: &BallState,
        held: &BallInRaceways,
        loaded: &RacewayLoads,
        pushed: &PocketReaction,
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

/// Load of the ball on the spindle; `present`: 1, or 0 for a copy that only fills a lane.
#[inline(always)]
pub(super) fn spindle_reaction(
    held: &BallInRaceways,
    loaded: &RacewayLoads,
    inner: &Sums,
    present: f32,
) -> SpindleReaction {
    let (q, t) = (loaded.inner.load, loaded.inner.load * inner.force);
    let (along, across) = (-(q + held.lean * t), held.lean * q - t);
    let (c, s) = (held.azimuth.cosine, held.azimuth.sine);
    let (c_present, s_present) = (c * present, s * present);
    let radial = loaded.slope;
    SpindleReaction {
        force: (along * c_present - across * s_present, along * s_present + across * c_present),
        slope: [radial * (c * c_present), radial * (c * s_present), radial * (s * s_present)],
    }
}
