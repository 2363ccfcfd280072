//! One ball on one raceway: penetration, contact angle, slip, loads.
//!
//! Everything here happens in the contact's own frame `[a, r, t]` at the ball: `a` along the
//! raceway's axis, `r` radially from that axis to the ball, `t` = a × r along the groove. `frames`
//! and `model` bring motions into it and loads out of it.

use super::bearing::{Bearing, PerRaceway};
use super::contact::damping::{DampingFactor, normal_load};
use super::contact::film::{Film, Inlet};
use super::contact::hertz::{HertzContact, raceway_contacts};
use super::contact::traction::{MAX_STRIPS, Strip, Strips, Traction, TractionContext, rising};
use super::frames::Vector;
use super::kinematics;
use super::lubricant::Lubricant;
use super::surface::SurfaceProfile;

/// Which parts of the contact a model contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RacewayTerms {
    /// Strips the ellipse is cut into across the groove.
    pub strips: usize,
    /// Point on the deformed surface depends on its place across the groove.
    pub conformity: bool,
    /// Slip from rotation about the contact normal, and its moment.
    pub spin: bool,
    pub hydrodynamics: bool,
}

/// Constants of one raceway.
#[derive(Debug, Clone)]
pub struct RacewayContact {
    groove_centre_radius: f64,
    /// (f − ½) d: distance of ball and groove centre at touch [m].
    touch_distance: f64,
    ball_radius: f64,
    hertz: HertzContact,
    /// Semi-major axis over √δ: the contact's size follows from its elastic part.
    semi_major_factor: f64,
    damping: DampingFactor,
    traction: Traction,
    all_strips: StripColumns,
    half_strips: StripColumns,
    terms: RacewayTerms,
    film: Film,
    inlet: Inlet,
    surface: SurfaceProfile,
}

/// Motion of a ball relative to the raceway's centre, in the contact's frame.
#[derive(Debug, Clone, Copy)]
pub struct RelativeMotion {
    /// Ball centre along the raceway's axis [m].
    pub axial: f64,
    /// Distance of the ball centre from the raceway's axis [m].
    pub radius: f64,
    /// Velocity of the ball centre less that of the raceway's centre [m/s].
    pub velocity: Vector,
    /// Angular velocity of the ball [rad/s].
    pub spin: Vector,
    /// Angular speed of the raceway about its axis [rad/s].
    pub raceway_speed: f64,
    /// Angular speed at which the contact moves round the raceway's axis [rad/s].
    pub orbit_speed: f64,
    /// Azimuth of the ball on the raceway itself [rad]; only a surface profile asks for it.
    pub azimuth: f64,
}

/// What a raceway does to a ball; the raceway feels the opposite force.
#[derive(Debug, Clone, Copy, Default)]
pub struct RacewayLoad {
    /// [m]; not positive: no contact.
    pub penetration: f64,
    /// [N]
    pub normal: f64,
    /// Sine and cosine of the contact angle.
    pub angle: (f64, f64),
    /// Force on the ball [N].
    pub force: Vector,
    /// Moment on the ball about its centre [N m].
    pub moment: Vector,
    /// Slip speed of the raceway over the ball at the contact's centre, along the groove and across it [m/s].
    pub slip: (f64, f64),
}

/// Strips of a contact, column by column.
#[derive(Debug, Clone, Copy)]
struct StripColumns {
    count: usize,
    position: [f64; MAX_STRIPS],
    weight: [f64; MAX_STRIPS],
    pressure: [f64; MAX_STRIPS],
}

impl StripColumns {
    fn new(strips: &[Strip]) -> Self {
        let column = |value: fn(&Strip) -> f64| std::array::from_fn(|k| strips.get(k).map_or(0.0, value));
        Self {
            count: strips.len().min(MAX_STRIPS),
            position: column(|strip| strip.position),
            weight: column(|strip| strip.weight),
            pressure: column(|strip| strip.pressure),
        }
    }
}

/// Slip over a contact as a function of height and place, and the shape of its surface.
struct StripMotion {
    semi_major: f64,
    apex: f64,
    shift: f64,
    deformed_2: f64,
    base: f64,
    per_height: f64,
    per_place: f64,
    side: f64,
    roll: f64,
}

/// Traction and its moments over the normal load, along the groove and across it.
#[derive(Default)]
struct StripSums {
    along: f64,
    across: f64,
    along_moment: f64,
    across_moment: f64,
    spin_moment: f64,
}

/// Largest share of the ball's radius that a contact reaches across the groove. Hertz has lost its
/// meaning long before; the share keeps extreme scenes finite.
const LARGEST_CONTACT: f64 = 0.95;

impl RacewayContact {
    /// Both raceways of a bearing.
    pub fn pair(
        bearing: &Bearing,
        lubricant: &Lubricant,
        damping: DampingFactor,
        terms: RacewayTerms,
    ) -> PerRaceway<Self> {
        let p = &bearing.parameters;
        let hertz = raceway_contacts(bearing);
        let one = |hertz: HertzContact, groove_centre_radius: f64, curvature: f64| Self {
            groove_centre_radius,
            touch_distance: (curvature - 0.5) * p.ball_diameter,
            ball_radius: 0.5 * p.ball_diameter,
            semi_major_factor: hertz.semi_axes(hertz.stiffness).0,
            damping,
            traction: Traction::new(&lubricant.traction, lubricant.viscosity, lubricant.pressure_viscosity),
            all_strips: StripColumns::new(Strips::new(terms.strips).as_slice()),
            half_strips: StripColumns::new(Strips::new(terms.strips).half()),
            terms,
            film: Film::new(&hertz, lubricant.viscosity, lubricant.pressure_viscosity),
            inlet: Inlet::new(&hertz, lubricant.viscosity, lubricant.meniscus(p.ball_diameter), 0.5 * p.ball_diameter),
            surface: SurfaceProfile::None,
            hertz,
        };
        PerRaceway {
            inner: one(hertz.inner, bearing.groove_centre_radius.inner, p.groove_curvature.inner),
            outer: one(hertz.outer, bearing.groove_centre_radius.outer, p.groove_curvature.outer),
        }
    }

    /// The same raceway with a surface profile on it.
    pub fn with_surface(mut self, surface: SurfaceProfile) -> Self {
        self.surface = surface;
        self
    }

    /// The elastic contact.
    pub fn hertz(&self) -> &HertzContact {
        &self.hertz
    }

    /// Distance of ball and groove centre at which they touch, (f − ½) d [m].
    pub fn touch_distance(&self) -> f64 {
        self.touch_distance
    }

    /// Penetration [m] and unit vector from the ball towards the contact, in the meridian plane (axial, radial).
    #[inline(always)]
    pub fn penetration<const PLANAR: bool>(&self, axial: f64, radius: f64) -> (f64, (f64, f64)) {
        let radial = radius - self.groove_centre_radius;
        if PLANAR {
            (radial.abs() - self.touch_distance, (0.0, radial.signum()))
        } else {
            let distance = (axial * axial + radial * radial).sqrt();
            let inverse = 1.0 / distance;
            (distance - self.touch_distance, (axial * inverse, radial * inverse))
        }
    }

    /// Elastic normal load at a penetration [N], and its slope [N/m]; both 0 without contact.
    pub fn elastic_load(&self, penetration: f64) -> (f64, f64) {
        let root = penetration.max(0.0).sqrt();
        (self.hertz.stiffness * root * root * root, 1.5 * self.hertz.stiffness * root)
    }

    /// Force and moment of the raceway on the ball. `PLANAR`: nothing acts or moves along the axis, so the
    /// contact is symmetric across the groove and half of its strips will do.
    #[inline(always)]
    pub fn load<const PLANAR: bool>(&self, motion: &RelativeMotion) -> RacewayLoad {
        let (mut penetration, (towards_a, towards_r)) = self.penetration::<PLANAR>(motion.axial, motion.radius);
        let [va, vr, vt] = motion.velocity;
        let mut rate = if PLANAR { towards_r * vr } else { towards_a * va + towards_r * vr };
        if !matches!(self.surface, SurfaceProfile::None) {
            let turning = motion.orbit_speed - motion.raceway_speed;
            penetration += self.surface.height(motion.azimuth);
            rate += self.surface.slope(motion.azimuth) * turning;
        }
        if penetration <= 0.0 {
            return RacewayLoad { penetration, ..RacewayLoad::default() };
        }
        let normal = normal_load(self.hertz.stiffness, penetration, rate, &self.damping);
        let semi_major = (self.semi_major_factor * penetration.sqrt()).min(LARGEST_CONTACT * self.ball_radius);

        // Across the groove, c = t × m with m towards the contact; (t, m, c) is right-handed.
        let (across_a, across_r) = (-towards_r, towards_a);
        // Slip of the raceway over the ball at height h along m and place η along c (both from the ball's centre):
        // along the groove  u_t = base + h · per_height + η · per_place,   across it  u_c = side − h · roll.
        let speed = motion.raceway_speed;
        let [spin_a, spin_r, spin_t] = motion.spin;
        let base = speed * motion.radius - vt;
        let relative = speed - spin_a;
        let per_height = relative * towards_r + spin_r * towards_a;
        let per_place = if PLANAR || !self.terms.spin { 0.0 } else { relative * across_r + spin_r * across_a };
        let side = if PLANAR { 0.0 } else { -(va * across_a + vr * across_r) };
        let roll = if PLANAR { 0.0 } else { spin_t };

        // Height of the deformed surface over the ball's centre, h(η) = √(R_d² − η²) + shift.
        let deformed = self.hertz.deformed_radius;
        let (deformed_2, semi_major_2) = (deformed * deformed, semi_major * semi_major);
        let edge = (self.ball_radius * self.ball_radius - semi_major_2).sqrt();
        let shift = edge - (deformed_2 - semi_major_2).sqrt();
        let apex = deformed + shift;

        let contact = StripMotion { semi_major, apex, shift, deformed_2, base, per_height, per_place, side, roll };
        let sums = match &self.traction {
            // The law of most scenes, chosen once per contact and not once per strip.
            Traction::RisingFromZero(law) => {
                self.sum_strips::<PLANAR>(&contact, |slip_2, _| rising(law, slip_2.sqrt()))
            }
            other => {
                let (context, max_pressure) = self.context(normal, penetration, motion, per_height, apex);
                self.sum_strips::<PLANAR>(&contact, |slip_2, pressure| {
                    other.traction_over_speed(slip_2, &TractionContext { pressure: pressure * max_pressure, ..context })
                })
            }
        };
        let StripSums { mut along, mut across, mut along_moment, mut across_moment, mut spin_moment } = sums;
        along *= normal;
        across *= normal;
        along_moment *= normal;
        across_moment *= normal;
        spin_moment *= if self.terms.spin { normal } else { 0.0 };

        // Normal force points from the contact to the ball's centre; c and m are turned back to (a, r).
        let mut force = [across * across_a - normal * towards_a, across * across_r - normal * towards_r, along];
        let mut moment = [
            spin_moment * towards_a - along_moment * across_a,
            spin_moment * towards_r - along_moment * across_r,
            across_moment,
        ];
        if self.terms.hydrodynamics {
            let rolling = self.rolling_velocity(motion, per_height, apex);
            let semi_minor = semi_major / self.hertz.ellipse.ellipticity;
            let hydro = self.inlet.forces(rolling, self.film.central(rolling, normal), semi_minor);
            // F_R at the contact point against rolling on each surface, F_H through the ball's centre.
            force[2] += hydro.pressure - hydro.rolling;
            moment[0] += hydro.rolling * apex * across_a;
            moment[1] += hydro.rolling * apex * across_r;
        }
        RacewayLoad {
            penetration,
            normal,
            angle: (towards_a * towards_r.signum(), towards_r.abs()),
            force,
            moment,
            slip: (base + apex * per_height, side - apex * roll),
        }
    }

    /// Traction over load, summed over the strips; `law` gives μ/|u| of a squared slip and the strip's mean
    /// pressure over p₀. In two passes, so that the first has no order of summation to keep.
    #[inline(always)]
    fn sum_strips<const PLANAR: bool>(&self, c: &StripMotion, law: impl Fn(f64, f64) -> f64) -> StripSums {
        let strips = if PLANAR { &self.half_strips } else { &self.all_strips };
        let n = strips.count.min(MAX_STRIPS);
        let (mut along, mut across, mut heights) = ([0.0; MAX_STRIPS], [0.0; MAX_STRIPS], [0.0; MAX_STRIPS]);
        for k in 0..n {
            let place = strips.position[k] * c.semi_major;
            let height = if self.terms.conformity { (c.deformed_2 - place * place).sqrt() + c.shift } else { c.apex };
            let slip_t = c.base + height * c.per_height + place * c.per_place;
            let slip_c = c.side - height * c.roll;
            let factor = strips.weight[k] * law(slip_t * slip_t + slip_c * slip_c, strips.pressure[k]);
            along[k] = factor * slip_t;
            across[k] = factor * slip_c;
            heights[k] = height;
        }
        let mut sums = StripSums::default();
        for k in 0..n {
            sums.along += along[k];
            sums.along_moment += along[k] * heights[k];
            if !PLANAR {
                sums.across += across[k];
                sums.across_moment += across[k] * heights[k];
                sums.spin_moment += along[k] * (strips.position[k] * c.semi_major);
            }
        }
        sums
    }

    /// Mean velocity of both surfaces along the groove, in the frame that moves with the contact [m/s].
    #[inline(always)]
    fn rolling_velocity(&self, motion: &RelativeMotion, per_height: f64, apex: f64) -> f64 {
        // Raceway: (ω − θ̇)(r' + h m_r); the ball moves slower by the slip.
        let towards_r = (motion.radius - self.groove_centre_radius).signum();
        let raceway = (motion.raceway_speed - motion.orbit_speed) * (motion.radius + apex * towards_r);
        let slip = motion.raceway_speed * motion.radius - motion.velocity[2] + apex * per_height;
        raceway - 0.5 * slip
    }

    /// What the traction law looks at besides slip, and the largest pressure p₀ [Pa].
    #[inline(always)]
    fn context(
        &self,
        normal: f64,
        penetration: f64,
        motion: &RelativeMotion,
        per_height: f64,
        apex: f64,
    ) -> (TractionContext, f64) {
        if !self.traction.needs_context() {
            return (TractionContext::default(), 0.0);
        }
        let rolling = self.rolling_velocity(motion, per_height, apex);
        let context = TractionContext {
            rolling_speed: rolling.abs(),
            pressure: 0.0,
            film_thickness: self.film.central(rolling, normal),
        };
        (context, self.hertz.max_pressure(self.elastic_load(penetration).0))
    }

    /// Minimum film thickness of a loaded contact [m]; 0 without a film.
    pub fn minimum_film(&self, motion: &RelativeMotion, load: &RacewayLoad) -> f64 {
        let (_, (towards_a, towards_r)) = self.penetration::<false>(motion.axial, motion.radius);
        let per_height = (motion.raceway_speed - motion.spin[0]) * towards_r + motion.spin[1] * towards_a;
        let rolling = self.rolling_velocity(motion, per_height, self.ball_radius);
        self.film.minimum(rolling, load.normal)
    }
}

/// Rolling friction F_R [N] of a ball on the inner raceway under a load [N], rolling ideally at a spindle speed
/// [rad/s], its inlet flooded.
pub fn nominal_rolling_friction(bearing: &Bearing, lubricant: &Lubricant, load: f64, speed: f64) -> f64 {
    if load <= 0.0 {
        return 0.0;
    }
    let hertz = raceway_contacts(bearing).inner;
    let p = &bearing.parameters;
    let groove_radius = 0.5 * (p.pitch_diameter * (1.0 - bearing.gamma()));
    let rolling = groove_radius * (1.0 - kinematics::ideal_orbit_ratio(bearing)) * speed.abs();
    let film = Film::new(&hertz, lubricant.viscosity, lubricant.pressure_viscosity).central(rolling, load);
    let inlet = Inlet::new(&hertz, lubricant.viscosity, lubricant.meniscus(p.ball_diameter), 0.5 * p.ball_diameter);
    inlet.forces(rolling, film, hertz.semi_axes(load).1).rolling
}
