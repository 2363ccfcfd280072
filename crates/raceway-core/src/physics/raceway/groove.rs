//! One groove: geometry, slip and load of the contact with one ball.

use std::array::from_fn;

use super::motion::{ContactSlopes, RacewayLoad, RelativeMotion};
use super::strip_sums::{StripSlip, StripSums};
use crate::numerics::angle::small_angle;
use crate::numerics::lanes::{LANES, Lanes, larger, side_by_side, smaller};
use crate::physics::contact::damping::{DampingFactor, normal_load, normal_slopes};
use crate::physics::contact::film::{Film, Inlet};
use crate::physics::contact::hertz::HertzContact;
use crate::physics::contact::strips::Strip;
use crate::physics::contact::traction::TractionContext;
use crate::physics::frames::{Vector, dot, subtract};
use crate::physics::surface::sphere::BallHeight;

/// Constants of one raceway, and what follows from them for one ball.
#[derive(Debug, Clone, Copy)]
pub(super) struct Groove {
    /// 1 for the outer raceway, −1 for the inner one: outwards or inwards from the circle of the groove's centres.
    pub(super) side: f64,
    pub(super) centre_radius: f64,
    /// (f − ½) d: distance of ball and groove centre at touch [m].
    pub(super) touch_distance: f64,
    pub(super) ball_radius: f64,
    pub(super) hertz: HertzContact,
    /// Semi-major axis over √δ: the contact's size follows from its elastic part.
    pub(super) semi_major_factor: f64,
    pub(super) damping: DampingFactor,
    pub(super) conformity: bool,
    /// 1 where spin slips and has a moment, else 0.
    pub(super) spin: f64,
    pub(super) film: Film,
    pub(super) inlet: Inlet,
    pub(super) hydrodynamics: bool,
}

/// Geometry and slip of a contact, from which the slip and load of its strips follow. Height h along m (towards the
/// contact) and place η along c (across the groove) are measured from the ball's centre. Slip of the raceway over the
/// ball: along the groove u_t = base + h · per_height + η · per_place, across it u_c = side − h · roll.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Contact<T = f64> {
    pub(super) penetration: T,
    pub(super) normal: T,
    /// Unit vector from the ball towards the contact, axial and radial.
    pub(super) towards: (T, T),
    pub(super) semi_major: T,
    pub(super) semi_major_2: T,
    /// Height of the deformed surface over the ball's centre, h(η) = √(R_d² − η²) + shift, and h(0).
    pub(super) shift: T,
    pub(super) apex: T,
    pub(super) base: T,
    pub(super) per_height: T,
    pub(super) per_place: T,
    pub(super) side: T,
    pub(super) roll: T,
}
side_by_side!(Contact {
    penetration,
    normal,
    towards,
    semi_major,
    semi_major_2,
    shift,
    apex,
    base,
    per_height,
    per_place,
    side,
    roll
});

/// Place of a contact across its groove.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct GroovePlace<T = f64> {
    /// Arc from the groove's bottom towards +X, η = f d α [m].
    pub(super) place: T,
    /// Its change with the place of the ball, axial and radial [-].
    pub(super) by_ball: (T, T),
}
side_by_side!(GroovePlace { place, by_ball });

impl GroovePlace {
    /// Rate of the place [m/s] where the ball moves with a velocity relative to the raceway.
    #[inline(always)]
    pub(super) fn rate(&self, [axial, radial, _]: &[f64; 3]) -> f64 {
        self.by_ball.0 * axial + self.by_ball.1 * radial
    }
}

/// Effect of a ball's size and surface on a contact.
#[derive(Debug, Clone, Copy, Default)]
pub struct OnBall<T = f64> {
    /// Radius of the ball less the nominal one [m].
    pub(super) oversize: T,
    /// Height of the ball over a nominal one [m], and the rate at which it rises [m/s].
    pub(super) height: T,
    pub(super) rise: T,
    /// Force [-] and moment [m] on the ball over the normal load.
    pub(super) force: Vector<T>,
    pub(super) moment: Vector<T>,
}
side_by_side!(OnBall { oversize, height, rise, force, moment });

impl OnBall<Lanes> {
    /// The effect of balls that are larger by some excess of their radii [m].
    #[inline(always)]
    pub(crate) fn grown(mut self, by: &Lanes) -> Self {
        for lane in 0..LANES {
            self.oversize[lane] += by[lane];
            self.height[lane] += by[lane];
        }
        self
    }
}

/// Largest share of the ball's radius that a contact reaches across the groove. Hertz's theory fails long before; the
/// limit keeps extreme scenes finite.
pub(crate) const LARGEST_CONTACT: f64 = 0.95;

/// The direction across the groove, c = t × m, from m towards the contact; (t, m, c) is right-handed.
#[inline(always)]
fn across((towards_a, towards_r): (f64, f64)) -> (f64, f64) {
    (-towards_r, towards_a)
}

impl Groove {
    /// Penetration [m] and unit vector from the ball towards the contact, in the meridian plane (axial, radial).
    #[inline(always)]
    pub(super) fn penetration<const PLANAR: bool>(&self, axial: f64, radius: f64) -> (f64, (f64, f64)) {
        let radial = radius - self.centre_radius;
        // A groove is an arc: beyond its centre there is no surface to touch.
        let ahead = self.side * radial;
        if PLANAR {
            (ahead - self.touch_distance, (0.0, self.side))
        } else {
            let distance = (axial * axial + radial * radial).sqrt();
            // At the groove's centre there is no direction, and no contact.
            let inverse = 1.0 / larger(distance, f64::MIN_POSITIVE);
            let reach = if ahead > 0.0 { distance } else { ahead };
            (reach - self.touch_distance, (axial * inverse, radial * inverse))
        }
    }

    /// Place of the contact of a ball across the groove.
    pub(super) fn place(&self, axial: f64, radius: f64) -> GroovePlace {
        let (penetration, (sine, towards_r)) = self.penetration::<false>(axial, radius);
        let (cosine, groove_radius) = (self.side * towards_r, self.touch_distance + self.ball_radius);
        // A ball that touches within a defect is farther from the groove's centre than at touch.
        let per_distance = groove_radius / (self.touch_distance + larger(penetration, 0.0));
        GroovePlace {
            place: groove_radius * small_angle(cosine, sine),
            by_ball: (per_distance * cosine, -self.side * per_distance * sine),
        }
    }

    /// The contact on a ball of some height, with its penetration and direction. The frame of the contact turns about the raceway's axis
    /// with v_t/r and about t with v·c/|l|.
    #[inline(always)]
    pub(super) fn on_ball<const PLANAR: bool>(
        &self,
        of: &BallHeight,
        motion: &RelativeMotion,
        (penetration, towards): (f64, (f64, f64)),
    ) -> OnBall {
        let across = if PLANAR { (0.0, 0.0) } else { across(towards) };
        let BallHeight { height, by_turn } = *of;
        let [va, vr, vt] = motion.velocity;
        let per_radius = 1.0 / motion.radius;
        let per_distance = 1.0 / larger(penetration + self.touch_distance, f64::MIN_POSITIVE);
        let frame = [vt * per_radius, 0.0, per_distance * (va * across.0 + vr * across.1)];
        let aside = -per_distance * by_turn[2];
        OnBall {
            oversize: 0.0,
            height,
            rise: dot(by_turn, subtract(frame, motion.spin)),
            force: [aside * across.0, aside * across.1, -per_radius * by_turn[0]],
            moment: by_turn,
        }
    }

    /// Elastic normal load at a penetration [N], and its slope [N/m]; both 0 without contact.
    #[inline(always)]
    pub(super) fn elastic_load(&self, penetration: f64) -> (f64, f64) {
        let root = larger(penetration, 0.0).sqrt();
        (self.hertz.stiffness * root * root * root, 1.5 * self.hertz.stiffness * root)
    }

    /// Geometry, normal load and slip of a contact; without penetration its load is 0. `lift`: height of the surfaces [m], and the rate
    /// at which they rise [m/s].
    #[inline(always)]
    pub(super) fn contact<const PLANAR: bool>(&self, motion: &RelativeMotion, lift: Option<(f64, f64)>) -> Contact {
        let (mut penetration, towards) = self.penetration::<PLANAR>(motion.axial, motion.radius);
        let (towards_a, towards_r) = towards;
        let [va, vr, vt] = motion.velocity;
        let mut rate = if PLANAR { towards_r * vr } else { towards_a * va + towards_r * vr };
        if let Some((height, rise)) = lift {
            penetration += height;
            rate += rise;
        }
        let normal = normal_load(self.hertz.stiffness, penetration, rate, &self.damping);
        // a² goes with δ: the roots of heights need not wait for that of a.
        let (depth, largest) = (larger(penetration, 0.0), LARGEST_CONTACT * self.ball_radius);
        let semi_major = smaller(self.semi_major_factor * depth.sqrt(), largest);
        let semi_major_2 = smaller(self.semi_major_factor * self.semi_major_factor * depth, largest * largest);

        let (across_a, across_r) = across(towards);
        let [spin_a, spin_r, spin_t] = motion.spin;
        let relative = motion.raceway_speed - spin_a;

        let deformed = self.hertz.deformed_radius;
        let edge = (self.ball_radius * self.ball_radius - semi_major_2).sqrt();
        let shift = edge - (deformed * deformed - semi_major_2).sqrt();
        Contact {
            penetration,
            normal,
            towards,
            semi_major,
            semi_major_2,
            shift,
            apex: deformed + shift,
            base: motion.raceway_speed * motion.radius - vt,
            per_height: relative * towards_r + spin_r * towards_a,
            per_place: if PLANAR { 0.0 } else { self.spin * (relative * across_r + spin_r * across_a) },
            side: if PLANAR { 0.0 } else { -(va * across_a + vr * across_r) },
            roll: if PLANAR { 0.0 } else { spin_t },
        }
    }

    /// Slopes of the loads by the ball's own motion, on a raceway that rises under the ball at a rate. The lean force has no slope here:
    /// over Q h_φφ/r² a contact is thousands of times as stiff.
    #[inline(always)]
    pub(super) fn slopes<const PLANAR: bool>(
        &self,
        motion: &RelativeMotion,
        load: &RacewayLoad,
        rise: f64,
    ) -> ContactSlopes {
        let (penetration, towards) = self.penetration::<PLANAR>(motion.axial, motion.radius);
        let [va, vr, _] = motion.velocity;
        let rate = rise + if PLANAR { towards.1 * vr } else { towards.0 * va + towards.1 * vr };
        let (stiffness, damping) = normal_slopes(self.hertz.stiffness, load.penetration, rate, &self.damping);
        let turning = if PLANAR { 0.0 } else { load.normal / (penetration + self.touch_distance) };
        // A ball in the middle of its groove touches nothing.
        let turning = if load.normal > 0.0 { turning } else { 0.0 };
        ContactSlopes { towards, stiffness, damping, turning, grip: load.grip }
    }

    /// Slip in `P` strips, and in the images of the first `S − P`.
    #[inline(always)]
    pub(super) fn slip<const P: usize, const S: usize>(&self, c: &Contact, strips: &[Strip; P]) -> StripSlip<P, S> {
        let deformed_2 = self.hertz.deformed_radius * self.hertz.deformed_radius;
        let place: [f64; P] = from_fn(|k| strips[k].position * c.semi_major);
        let bent = if self.conformity { 1.0 } else { 0.0 };
        let height: [f64; P] = from_fn(|k| {
            let position_2 = bent * strips[k].position * strips[k].position;
            // The middle, which has no image, needs no root.
            let is_middle = P > 1 && S == 2 * P - 1 && k == P - 1;
            if is_middle { c.apex } else { (deformed_2 - position_2 * c.semi_major_2).sqrt() + c.shift }
        });
        let mean: [f64; P] = from_fn(|k| c.base + height[k] * c.per_height);
        let half: [f64; P] = from_fn(|k| place[k] * c.per_place);
        StripSlip {
            place,
            height,
            along: from_fn(|k| if k < P { mean[k] + half[k] } else { mean[k - P] - half[k - P] }),
            across: from_fn(|k| c.side - height[k] * c.roll),
        }
    }

    /// Load on the ball from the sums over its strips.
    #[inline(always)]
    pub(super) fn sum_of_loads(&self, c: &Contact, sums: &StripSums) -> RacewayLoad {
        let normal = c.normal;
        let (towards_a, towards_r) = c.towards;
        let (across_a, across_r) = across(c.towards);
        let along = sums.along * normal;
        let across = sums.across * normal;
        let along_moment = sums.along_moment * normal;
        let across_moment = sums.across_moment * normal;
        let spin_moment = sums.spin_moment * normal * self.spin;
        RacewayLoad {
            penetration: c.penetration,
            normal,
            angle: (towards_a * 1.0_f64.copysign(towards_r), towards_r.abs()),
            // The normal force points from the contact to the ball's centre; c and m are turned back to (a, r).
            force: [across * across_a - normal * towards_a, across * across_r - normal * towards_r, along],
            moment: [
                spin_moment * towards_a - along_moment * across_a,
                spin_moment * towards_r - along_moment * across_r,
                across_moment,
            ],
            slip: (c.base + c.apex * c.per_height, c.side - c.apex * c.roll),
            grip: sums.grip * normal,
        }
    }

    /// Adds the forces of the inlet: F_R at the contact point against rolling on each surface, F_H through the ball's centre.
    #[inline(always)]
    pub(super) fn add_inlet(&self, c: &Contact, motion: &RelativeMotion, load: &mut RacewayLoad) {
        let rolling = self.rolling_velocity(motion, c.per_height, c.apex);
        let semi_minor = c.semi_major / self.hertz.ellipse.ellipticity;
        let hydro = self.inlet.forces(rolling, self.film.central(rolling, c.normal), semi_minor);
        let (across_a, across_r) = across(c.towards);
        let touching = if c.penetration > 0.0 { 1.0 } else { 0.0 };
        load.force[2] += touching * (hydro.pressure - hydro.rolling);
        load.moment[0] += touching * hydro.rolling * c.apex * across_a;
        load.moment[1] += touching * hydro.rolling * c.apex * across_r;
    }

    /// Mean rolling speed at the centre of a contact that lies in a direction [m/s].
    #[inline(always)]
    pub(super) fn rolling_speed(&self, motion: &RelativeMotion, (towards_a, towards_r): (f64, f64)) -> f64 {
        let per_height = (motion.raceway_speed - motion.spin[0]) * towards_r + motion.spin[1] * towards_a;
        self.rolling_velocity(motion, per_height, self.ball_radius)
    }

    /// Mean velocity of both surfaces along the groove, in the frame that moves with the contact [m/s].
    #[inline(always)]
    pub(super) fn rolling_velocity(&self, motion: &RelativeMotion, per_height: f64, apex: f64) -> f64 {
        // Raceway: (ω − θ̇)(r' + h m_r); the ball moves slower by the slip.
        let raceway = (motion.raceway_speed - motion.orbit_speed) * (motion.radius + apex * self.side);
        let slip = motion.raceway_speed * motion.radius - motion.velocity[2] + apex * per_height;
        raceway - 0.5 * slip
    }

    /// Inputs of the traction law besides slip, with the largest pressure p₀.
    #[inline(always)]
    pub(super) fn context(&self, c: &Contact, motion: &RelativeMotion) -> TractionContext {
        let rolling = self.rolling_velocity(motion, c.per_height, c.apex);
        TractionContext {
            rolling_speed: rolling.abs(),
            pressure: self.hertz.max_pressure(self.elastic_load(c.penetration).0),
            film_thickness: self.film.central(rolling, c.normal),
        }
    }
}
