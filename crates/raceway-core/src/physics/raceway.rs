//! One ball on one raceway: penetration, contact angle, slip, loads.
//!
//! Everything here happens in the contact's own frame `[a, r, t]` at the ball: `a` along the
//! raceway's axis, `r` radially from that axis to the ball, `t` = a × r along the groove. `frames`
//! and `model` bring motions into it and loads out of it.

use std::array::from_fn;

use super::bearing::{Bearing, PerRaceway};
use super::contact::damping::{DampingFactor, normal_load, normal_slopes};
use super::contact::film::{Film, Inlet, ThinnestFilm};
use super::contact::hertz::{HertzContact, raceway_contacts};
use super::contact::traction::{
    FourParameters, MAX_STRIPS, Strip, Strips, TINY, Traction, TractionContext, coulomb, eyring, rising, rolling,
    rolling_at_rest, sticking,
};
use super::frames::Vector;
use super::kinematics;
use super::lubricant::Lubricant;
use super::surface::SurfaceProfile;
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide, Task, larger, side_by_side, smaller};

/// Which parts of the contact a model contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RacewayTerms {
    /// Strips the ellipse is cut into across the groove.
    pub strips: usize,
    /// As many points of a Gauss rule (2, 4 or 6) in their place.
    pub gauss: bool,
    /// Point on the deformed surface depends on its place across the groove.
    pub conformity: bool,
    /// Slip from rotation about the contact normal, and its moment.
    pub spin: bool,
    pub hydrodynamics: bool,
}

/// One raceway.
#[derive(Debug, Clone)]
pub struct RacewayContact {
    groove: Groove,
    traction: Traction,
    strips: MirroredStrips,
    /// As `strips`, each with the load of its image.
    folded_strips: MirroredStrips,
    surface: SurfaceProfile,
}

/// Constants of one raceway, and what follows from them for one ball.
#[derive(Debug, Clone, Copy)]
struct Groove {
    /// 1 for the outer raceway, −1 for the inner one: outwards or inwards from the circle of the groove's centres.
    side: f64,
    centre_radius: f64,
    /// (f − ½) d: distance of ball and groove centre at touch [m].
    touch_distance: f64,
    ball_radius: f64,
    hertz: HertzContact,
    /// Semi-major axis over √δ: the contact's size follows from its elastic part.
    semi_major_factor: f64,
    damping: DampingFactor,
    conformity: bool,
    /// 1 where spin slips and has a moment, else 0.
    spin: f64,
    film: Film,
    inlet: Inlet,
    hydrodynamics: bool,
}

/// Motion of a ball relative to the raceway's centre, in the contact's frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct RelativeMotion<T = f64> {
    /// Ball centre along the raceway's axis [m].
    pub axial: T,
    /// Distance of the ball centre from the raceway's axis [m].
    pub radius: T,
    /// Velocity of the ball centre less that of the raceway's centre [m/s].
    pub velocity: Vector<T>,
    /// Angular velocity of the ball [rad/s].
    pub spin: Vector<T>,
    /// Angular speed of the raceway about its axis [rad/s].
    pub raceway_speed: T,
    /// Angular speed at which the contact moves round the raceway's axis [rad/s].
    pub orbit_speed: T,
    /// Azimuth of the ball on the raceway itself [rad]; only a surface profile asks for it.
    pub azimuth: T,
}
side_by_side!(RelativeMotion { axial, radius, velocity, spin, raceway_speed, orbit_speed, azimuth });

/// What a raceway does to a ball; the raceway feels the opposite force.
#[derive(Debug, Clone, Copy, Default)]
pub struct RacewayLoad<T = f64> {
    /// [m]; not positive: no contact.
    pub penetration: T,
    /// [N]
    pub normal: T,
    /// Sine and cosine of the contact angle.
    pub angle: (T, T),
    /// Force on the ball [N].
    pub force: Vector<T>,
    /// Moment on the ball about its centre [N m].
    pub moment: Vector<T>,
    /// Slip speed of the raceway over the ball at the contact's centre, along the groove and across it [m/s].
    pub slip: (T, T),
    /// Traction over slip, Σ Q_k μ(u_k)/u_k of the strips [N s/m].
    pub grip: T,
}
side_by_side!(RacewayLoad { penetration, normal, angle, force, moment, slip, grip });

/// How a contact's loads answer to a ball that moves on: what a linearly implicit method needs of them. Rates of slip are
/// answered by the traction as a whole, with the same grip along the groove and across it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactSlopes<T = f64> {
    /// Unit vector from the ball towards the contact, axial and radial.
    pub towards: (T, T),
    /// Of the normal load, by penetration [N/m] and by its rate [N s/m].
    pub stiffness: T,
    pub damping: T,
    /// Of the force across the groove, by displacement across it: the normal load turns with its direction [N/m].
    pub turning: T,
    /// Of traction, by slip [N s/m].
    pub grip: T,
}
side_by_side!(ContactSlopes { towards, stiffness, damping, turning, grip });

/// Strips of a contact: those on the side of positive η, which stand for their mirror images, too, and the middle one.
#[derive(Debug, Clone, Copy)]
struct MirroredStrips {
    middle: Option<Strip>,
    pairs: [Strip; MAX_STRIPS],
    /// So many pairs are in use: fewer than `AT_ONCE`, or as many as it divides, the last ones without weight.
    used: usize,
}

/// Pairs of strips that are computed at once: four leave no rest of the usual 9 and 17 strips.
const AT_ONCE: usize = 4;

impl MirroredStrips {
    /// `weight`: 1, or 2 where a strip carries its image's load as well.
    fn new(strips: &Strips, weight: f64) -> Self {
        let all = strips.as_slice();
        let (half, odd) = (all.len() / 2, all.len() % 2 == 1);
        // Where no strip is left, one that carries nothing.
        let blank = Strip { weight: 0.0, ..all[all.len() - 1] };
        let pair = |k: usize| {
            let strip = all[all.len() - half + k];
            Strip { weight: weight * strip.weight, ..strip }
        };
        Self {
            middle: odd.then(|| all[half]),
            pairs: from_fn(|k| if k < half { pair(k) } else { blank }),
            used: if odd || half >= AT_ONCE { half.next_multiple_of(AT_ONCE) } else { half },
        }
    }
}

/// A contact's geometry and slip, from which its strips and its loads follow. Slip of the raceway over the ball at height
/// h along m (towards the contact) and place η along c (across the groove), both from the ball's centre: along the groove
/// u_t = base + h · per_height + η · per_place, across it u_c = side − h · roll.
#[derive(Debug, Clone, Copy, Default)]
struct Contact<T = f64> {
    penetration: T,
    normal: T,
    /// Unit vector from the ball towards the contact, axial and radial.
    towards: (T, T),
    semi_major: T,
    semi_major_2: T,
    /// Height of the deformed surface over the ball's centre, h(η) = √(R_d² − η²) + shift, and h(0).
    shift: T,
    apex: T,
    base: T,
    per_height: T,
    per_place: T,
    side: T,
    roll: T,
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

/// Traction and its moments over the normal load, along the groove and across it.
#[derive(Debug, Clone, Copy, Default)]
struct StripSums<T = f64> {
    along: T,
    across: T,
    along_moment: T,
    across_moment: T,
    spin_moment: T,
    /// Traction over slip [s/m].
    grip: T,
}
side_by_side!(StripSums { along, across, along_moment, across_moment, spin_moment, grip });

/// Slip in `P` strips, along the groove also in their images; across it that is the same.
struct StripSlip<const P: usize, const S: usize> {
    place: [f64; P],
    height: [f64; P],
    along: [f64; S],
    across: [f64; P],
}

impl<const P: usize, const S: usize> StripSlip<P, S> {
    /// Squared slip, above 0 by next to nothing, so that a law may divide by it.
    #[inline(always)]
    fn squares(&self) -> [f64; S] {
        let across: [f64; P] = from_fn(|k| self.across[k] * self.across[k] + TINY);
        from_fn(|k| self.along[k] * self.along[k] + across[k % P])
    }
}

impl StripSums {
    /// Adds strips of which μ/|u| is known.
    #[inline(always)]
    fn add<const P: usize, const S: usize>(&mut self, slip: &StripSlip<P, S>, strips: &[Strip; P], factor: [f64; S]) {
        for k in 0..P {
            let weighted = strips[k].weight * factor[k];
            let traction = weighted * slip.along[k];
            let (mut both, mut difference, mut along) = (weighted, traction, traction);
            if k + P < S {
                let weighted = strips[k].weight * factor[k + P];
                let traction = weighted * slip.along[k + P];
                both += weighted;
                difference -= traction;
                along += traction;
            }
            let across = both * slip.across[k];
            self.grip += both;
            self.along += along;
            self.along_moment += along * slip.height[k];
            self.across += across;
            self.across_moment += across * slip.height[k];
            self.spin_moment += difference * slip.place[k];
        }
    }
}

/// Loads of balls side by side, to be compiled for each instruction set. Written where they are wanted: no copies.
struct Loads<'a, const PLANAR: bool> {
    raceway: &'a RacewayContact,
    motion: &'a RelativeMotion<Lanes>,
    load: &'a mut RacewayLoad<Lanes>,
}

impl<const PLANAR: bool> Task for Loads<'_, PLANAR> {
    type Answer = ();

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let contact = self.raceway.contacts::<PLANAR, LANES>(self.motion);
        self.raceway.loads_of::<PLANAR, LANES>(&contact, self.motion, self.load);
    }
}

/// The same of both raceways.
struct PairOfLoads<'a, const PLANAR: bool> {
    raceway: &'a PerRaceway<RacewayContact>,
    motion: &'a PerRaceway<RelativeMotion<Lanes>>,
    load: &'a mut PerRaceway<RacewayLoad<Lanes>>,
}

impl<const PLANAR: bool> Task for PairOfLoads<'_, PLANAR> {
    type Answer = ();

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let Self { raceway, motion, load } = self;
        // Both geometries first: each is a chain of roots, and two chains take no longer than one.
        let outer = raceway.outer.contacts::<PLANAR, LANES>(&motion.outer);
        let inner = raceway.inner.contacts::<PLANAR, LANES>(&motion.inner);
        raceway.inner.loads_of::<PLANAR, LANES>(&inner, &motion.inner, &mut load.inner);
        raceway.outer.loads_of::<PLANAR, LANES>(&outer, &motion.outer, &mut load.outer);
    }
}

/// Largest share of the ball's radius that a contact reaches across the groove. Hertz has lost its
/// meaning long before; the share keeps extreme scenes finite.
pub(crate) const LARGEST_CONTACT: f64 = 0.95;

/// The direction across the groove, c = t × m, from m towards the contact; (t, m, c) is right-handed.
#[inline(always)]
fn across((towards_a, towards_r): (f64, f64)) -> (f64, f64) {
    (-towards_r, towards_a)
}

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
        let strips = if terms.gauss { Strips::gauss(terms.strips / 2) } else { Strips::new(terms.strips) };
        let one = |side: f64, hertz: HertzContact, centre_radius: f64, curvature: f64| Self {
            groove: Groove {
                side,
                centre_radius,
                touch_distance: (curvature - 0.5) * p.ball_diameter,
                ball_radius: 0.5 * p.ball_diameter,
                semi_major_factor: hertz.semi_axes(hertz.stiffness).0,
                damping,
                conformity: terms.conformity,
                spin: if terms.spin { 1.0 } else { 0.0 },
                film: Film::new(&hertz, lubricant.viscosity, lubricant.pressure_viscosity),
                inlet: Inlet::new(
                    &hertz,
                    lubricant.viscosity,
                    lubricant.meniscus(p.ball_diameter),
                    0.5 * p.ball_diameter,
                ),
                hydrodynamics: terms.hydrodynamics,
                hertz,
            },
            traction: Traction::new(&lubricant.traction, lubricant.viscosity, lubricant.pressure_viscosity),
            strips: MirroredStrips::new(&strips, 1.0),
            folded_strips: MirroredStrips::new(&strips, 2.0),
            surface: SurfaceProfile::None,
        };
        PerRaceway {
            inner: one(-1.0, hertz.inner, bearing.groove_centre_radius.inner, p.groove_curvature.inner),
            outer: one(1.0, hertz.outer, bearing.groove_centre_radius.outer, p.groove_curvature.outer),
        }
    }

    /// The same raceway with a surface profile on it.
    pub fn with_surface(mut self, surface: SurfaceProfile) -> Self {
        self.surface = surface;
        self
    }

    /// Whether anything damps an impact.
    pub(crate) fn is_damped(&self) -> bool {
        self.groove.damping.chi > 0.0 || self.groove.damping.viscous > 0.0
    }

    /// The elastic contact.
    pub fn hertz(&self) -> &HertzContact {
        &self.groove.hertz
    }

    /// Penetration under an elastic load [N] over the ball's radius [-].
    pub(crate) fn relative_depth(&self, load: f64) -> f64 {
        (load / self.groove.hertz.stiffness).powf(2.0 / 3.0) / self.groove.ball_radius
    }

    /// Distance of ball and groove centre at which they touch, (f − ½) d [m].
    pub fn touch_distance(&self) -> f64 {
        self.groove.touch_distance
    }

    /// Penetration [m] and unit vector from the ball towards the contact, in the meridian plane (axial, radial).
    pub fn penetration<const PLANAR: bool>(&self, axial: f64, radius: f64) -> (f64, (f64, f64)) {
        self.groove.penetration::<PLANAR>(axial, radius)
    }

    /// Elastic normal load at a penetration [N], and its slope [N/m]; both 0 without contact.
    pub(crate) fn elastic_load(&self, penetration: f64) -> (f64, f64) {
        self.groove.elastic_load(penetration)
    }

    /// Force and moment of the raceway on one ball.
    pub fn load<const PLANAR: bool>(&self, motion: &RelativeMotion) -> RacewayLoad {
        let mut one = RelativeMotion::<Lanes<1>>::default();
        one.put(0, *motion);
        let mut load = RacewayLoad::<Lanes<1>>::default();
        self.loads_of::<PLANAR, 1>(&self.contacts::<PLANAR, 1>(&one), &one, &mut load);
        load.at(0)
    }

    /// Forces and moments of both raceways on balls side by side, by a set of instructions. `PLANAR`: nothing acts or moves
    /// along the axis, so contacts are symmetric across the groove and half of their strips will do.
    pub fn pair_of_loads<const PLANAR: bool>(
        raceway: &PerRaceway<Self>,
        motion: &PerRaceway<RelativeMotion<Lanes>>,
        load: &mut PerRaceway<RacewayLoad<Lanes>>,
        instructions: InstructionSet,
    ) {
        instructions.run(PairOfLoads::<PLANAR> { raceway, motion, load });
    }

    /// The same of one raceway.
    pub fn loads<const PLANAR: bool>(
        &self,
        motion: &RelativeMotion<Lanes>,
        load: &mut RacewayLoad<Lanes>,
        instructions: InstructionSet,
    ) {
        instructions.run(Loads::<PLANAR> { raceway: self, motion, load });
    }

    #[inline(always)]
    fn contacts<const PLANAR: bool, const N: usize>(&self, motion: &RelativeMotion<Lanes<N>>) -> Contact<Lanes<N>> {
        // A copy: what is stored in the loop cannot change it.
        let groove = self.groove;
        let surface = self.surface.heights_and_slopes(&motion.azimuth);
        let mut contact = Contact::<Lanes<N>>::default();
        for lane in 0..N {
            contact.put(lane, groove.contact::<PLANAR>(&motion.at(lane), surface.at(lane)));
        }
        contact
    }

    #[inline(always)]
    fn loads_of<const PLANAR: bool, const N: usize>(
        &self,
        contact: &Contact<Lanes<N>>,
        motion: &RelativeMotion<Lanes<N>>,
        load: &mut RacewayLoad<Lanes<N>>,
    ) {
        if !contact.penetration.any(|penetration| penetration > 0.0) {
            *load = RacewayLoad { penetration: contact.penetration, ..RacewayLoad::default() };
            return;
        }
        let groove = self.groove;
        let sums = self.strip_sums::<PLANAR, N>(contact, motion);
        // Apart from the contact, so that the compiler sees that no store changes it.
        let mut found = RacewayLoad::<Lanes<N>>::default();
        for lane in 0..N {
            found.put(lane, groove.sum_of_loads(&contact.at(lane), &sums.at(lane)));
        }
        *load = found;
        if groove.hydrodynamics {
            for lane in 0..N {
                let mut one = load.at(lane);
                groove.add_inlet(&contact.at(lane), &motion.at(lane), &mut one);
                load.put(lane, one);
            }
        }
    }

    /// Traction over load, summed over the strips. Where nothing spins about the normal, a strip and its image slip alike.
    #[inline(always)]
    fn strip_sums<const PLANAR: bool, const N: usize>(
        &self,
        contact: &Contact<Lanes<N>>,
        motion: &RelativeMotion<Lanes<N>>,
    ) -> StripSums<Lanes<N>> {
        if PLANAR || self.groove.spin == 0.0 {
            self.strip_sums_of::<true, N>(contact, motion)
        } else {
            self.strip_sums_of::<false, N>(contact, motion)
        }
    }

    #[inline(always)]
    fn strip_sums_of<const MIRRORED: bool, const N: usize>(
        &self,
        contact: &Contact<Lanes<N>>,
        motion: &RelativeMotion<Lanes<N>>,
    ) -> StripSums<Lanes<N>> {
        match self.traction {
            // The law of most scenes takes several strips at once.
            Traction::RisingFromZero(law) => self.rising_sums::<MIRRORED, N>(&law, contact),
            Traction::StickingAtRest(law) => {
                self.sums_by::<MIRRORED, N>(contact, motion, |square, _| sticking(&law, square.sqrt(), square))
            }
            Traction::SlideRollFromZero(law) => {
                self.sums_by::<MIRRORED, N>(contact, motion, |square, context| rolling(&law, square, context))
            }
            Traction::SlideRollAtRest(law) => {
                self.sums_by::<MIRRORED, N>(contact, motion, |square, context| rolling_at_rest(&law, square, context))
            }
            Traction::Eyring(law) => {
                self.sums_by::<MIRRORED, N>(contact, motion, |square, context| eyring(&law, square, context))
            }
            Traction::Coulomb(law) => self.sums_by::<MIRRORED, N>(contact, motion, |square, _| coulomb(&law, square)),
        }
    }

    #[inline(always)]
    fn rising_sums<const MIRRORED: bool, const N: usize>(
        &self,
        law: &FourParameters,
        contact: &Contact<Lanes<N>>,
    ) -> StripSums<Lanes<N>> {
        let strips = if MIRRORED { &self.folded_strips } else { &self.strips };
        let mut sums = StripSums::<Lanes<N>>::default();
        let mut rest = &strips.pairs[..strips.used];
        while let Some((&[a, b, c, d], after)) = rest.split_first_chunk::<AT_ONCE>() {
            rest = after;
            match strips.middle {
                Some(middle) if rest.is_empty() && MIRRORED => {
                    self.add_rising::<N, 5, 5>(law, contact, &[a, b, c, d, middle], &mut sums);
                }
                Some(middle) if rest.is_empty() => {
                    self.add_rising::<N, 5, 9>(law, contact, &[a, b, c, d, middle], &mut sums);
                }
                _ if MIRRORED => self.add_rising::<N, 4, 4>(law, contact, &[a, b, c, d], &mut sums),
                _ => self.add_rising::<N, 4, 8>(law, contact, &[a, b, c, d], &mut sums),
            }
        }
        match (rest, MIRRORED) {
            (&[a, b, c], true) => self.add_rising::<N, 3, 3>(law, contact, &[a, b, c], &mut sums),
            (&[a, b, c], false) => self.add_rising::<N, 3, 6>(law, contact, &[a, b, c], &mut sums),
            (&[a, b], true) => self.add_rising::<N, 2, 2>(law, contact, &[a, b], &mut sums),
            (&[a, b], false) => self.add_rising::<N, 2, 4>(law, contact, &[a, b], &mut sums),
            (&[a], true) => self.add_rising::<N, 1, 1>(law, contact, &[a], &mut sums),
            (&[a], false) => self.add_rising::<N, 1, 2>(law, contact, &[a], &mut sums),
            _ => {}
        }
        if let (Some(middle), 0) = (strips.middle, strips.used) {
            self.add_rising::<N, 1, 1>(law, contact, &[middle], &mut sums);
        }
        sums
    }

    /// Adds the traction of `P` strips, the first `S − P` of them with their images.
    #[inline(always)]
    fn add_rising<const N: usize, const P: usize, const S: usize>(
        &self,
        law: &FourParameters,
        contact: &Contact<Lanes<N>>,
        strips: &[Strip; P],
        sums: &mut StripSums<Lanes<N>>,
    ) {
        let (groove, law) = (self.groove, *law);
        for lane in 0..N {
            let slip = groove.slip::<P, S>(&contact.at(lane), strips);
            let mut sum = sums.at(lane);
            sum.add(&slip, strips, rising(&law, slip.squares()));
            sums.put(lane, sum);
        }
    }

    /// The sums by a law that gives μ/|u| of a squared slip and what else there is, one strip after the other.
    #[inline(always)]
    fn sums_by<const MIRRORED: bool, const N: usize>(
        &self,
        contact: &Contact<Lanes<N>>,
        motion: &RelativeMotion<Lanes<N>>,
        law: impl Fn(f64, &TractionContext) -> f64,
    ) -> StripSums<Lanes<N>> {
        // In place of each strip's pressure, p₀.
        let mut context = TractionContext::<Lanes<N>>::default();
        if self.traction.needs_context() {
            let groove = self.groove;
            for lane in 0..N {
                context.put(lane, groove.context(&contact.at(lane), &motion.at(lane)));
            }
        }
        let strips = if MIRRORED { &self.folded_strips } else { &self.strips };
        let mut sums = StripSums::<Lanes<N>>::default();
        for strip in &strips.pairs[..strips.used] {
            if MIRRORED {
                self.add_by::<N, 1>(&law, contact, &context, strip, &mut sums);
            } else {
                self.add_by::<N, 2>(&law, contact, &context, strip, &mut sums);
            }
        }
        if let Some(middle) = &strips.middle {
            self.add_by::<N, 1>(&law, contact, &context, middle, &mut sums);
        }
        sums
    }

    #[inline(always)]
    fn add_by<const N: usize, const S: usize>(
        &self,
        law: &impl Fn(f64, &TractionContext) -> f64,
        contact: &Contact<Lanes<N>>,
        context: &TractionContext<Lanes<N>>,
        strip: &Strip,
        sums: &mut StripSums<Lanes<N>>,
    ) {
        let groove = self.groove;
        for lane in 0..N {
            let slip = groove.slip::<1, S>(&contact.at(lane), &[*strip]);
            let whole = context.at(lane);
            let context = TractionContext { pressure: strip.pressure * whole.pressure, ..whole };
            let squares = slip.squares();
            let mut sum = sums.at(lane);
            sum.add(&slip, &[*strip], from_fn(|k| law(squares[k], &context)));
            sums.put(lane, sum);
        }
    }

    /// Writes how loads at a motion answer to the balls' own motion.
    #[inline(always)]
    pub(crate) fn slopes<const PLANAR: bool>(
        &self,
        motion: &RelativeMotion<Lanes>,
        load: &RacewayLoad<Lanes>,
        slopes: &mut ContactSlopes<Lanes>,
    ) {
        let groove = self.groove;
        for lane in 0..LANES {
            slopes.put(lane, groove.slopes::<PLANAR>(&motion.at(lane), &load.at(lane)));
        }
    }

    /// Meets the minimum film of a loaded contact at a mean rolling speed [m/s] and load [N].
    pub(crate) fn meet_film(&self, rolling_speed: f64, load: f64, thinnest: &mut ThinnestFilm) {
        thinnest.meet(&self.groove.film, rolling_speed, load);
    }

    /// Mean rolling speed ū at the contact's centre [m/s].
    pub fn rolling_speed(&self, motion: &RelativeMotion) -> f64 {
        let (_, towards) = self.groove.penetration::<false>(motion.axial, motion.radius);
        self.groove.rolling_speed(motion, towards)
    }

    /// The same of several balls, whose contacts lie where `slopes` says.
    #[inline(always)]
    pub(crate) fn rolling_speeds(
        &self,
        motion: &RelativeMotion<Lanes>,
        slopes: &ContactSlopes<Lanes>,
        rolling_speed: &mut Lanes,
    ) {
        let groove = self.groove;
        for lane in 0..LANES {
            rolling_speed[lane] = groove.rolling_speed(&motion.at(lane), slopes.towards.at(lane));
        }
    }
}

impl Groove {
    /// Penetration [m] and unit vector from the ball towards the contact, in the meridian plane (axial, radial).
    #[inline(always)]
    fn penetration<const PLANAR: bool>(&self, axial: f64, radius: f64) -> (f64, (f64, f64)) {
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

    /// Elastic normal load at a penetration [N], and its slope [N/m]; both 0 without contact.
    #[inline(always)]
    fn elastic_load(&self, penetration: f64) -> (f64, f64) {
        let root = larger(penetration, 0.0).sqrt();
        (self.hertz.stiffness * root * root * root, 1.5 * self.hertz.stiffness * root)
    }

    /// Geometry, normal load and slip of a contact; without penetration its load is 0.
    #[inline(always)]
    fn contact<const PLANAR: bool>(&self, motion: &RelativeMotion, (height, slope): (f64, f64)) -> Contact {
        let (mut penetration, towards) = self.penetration::<PLANAR>(motion.axial, motion.radius);
        let (towards_a, towards_r) = towards;
        let [va, vr, vt] = motion.velocity;
        let mut rate = if PLANAR { towards_r * vr } else { towards_a * va + towards_r * vr };
        let turning = motion.orbit_speed - motion.raceway_speed;
        penetration += height;
        rate += slope * turning;
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

    /// How the loads at a motion answer to the ball's own motion. What a surface profile adds to the rate is left out.
    #[inline(always)]
    fn slopes<const PLANAR: bool>(&self, motion: &RelativeMotion, load: &RacewayLoad) -> ContactSlopes {
        let (penetration, towards) = self.penetration::<PLANAR>(motion.axial, motion.radius);
        let [va, vr, _] = motion.velocity;
        let rate = if PLANAR { towards.1 * vr } else { towards.0 * va + towards.1 * vr };
        let (stiffness, damping) = normal_slopes(self.hertz.stiffness, load.penetration, rate, &self.damping);
        let turning = if PLANAR { 0.0 } else { load.normal / (penetration + self.touch_distance) };
        // A ball in the middle of its groove touches nothing.
        let turning = if load.normal > 0.0 { turning } else { 0.0 };
        ContactSlopes { towards, stiffness, damping, turning, grip: load.grip }
    }

    /// Slip in `P` strips, and in the images of the first `S − P`.
    #[inline(always)]
    fn slip<const P: usize, const S: usize>(&self, c: &Contact, strips: &[Strip; P]) -> StripSlip<P, S> {
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
    fn sum_of_loads(&self, c: &Contact, sums: &StripSums) -> RacewayLoad {
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
    fn add_inlet(&self, c: &Contact, motion: &RelativeMotion, load: &mut RacewayLoad) {
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
    fn rolling_speed(&self, motion: &RelativeMotion, (towards_a, towards_r): (f64, f64)) -> f64 {
        let per_height = (motion.raceway_speed - motion.spin[0]) * towards_r + motion.spin[1] * towards_a;
        self.rolling_velocity(motion, per_height, self.ball_radius)
    }

    /// Mean velocity of both surfaces along the groove, in the frame that moves with the contact [m/s].
    #[inline(always)]
    fn rolling_velocity(&self, motion: &RelativeMotion, per_height: f64, apex: f64) -> f64 {
        // Raceway: (ω − θ̇)(r' + h m_r); the ball moves slower by the slip.
        let raceway = (motion.raceway_speed - motion.orbit_speed) * (motion.radius + apex * self.side);
        let slip = motion.raceway_speed * motion.radius - motion.velocity[2] + apex * per_height;
        raceway - 0.5 * slip
    }

    /// What the traction law looks at besides slip, with the largest pressure p₀.
    #[inline(always)]
    fn context(&self, c: &Contact, motion: &RelativeMotion) -> TractionContext {
        let rolling = self.rolling_velocity(motion, c.per_height, c.apex);
        TractionContext {
            rolling_speed: rolling.abs(),
            pressure: self.hertz.max_pressure(self.elastic_load(c.penetration).0),
            film_thickness: self.film.central(rolling, c.normal),
        }
    }
}

/// Rolling friction F_R [N] of a ball on the inner raceway under a load [N], rolling ideally at a spindle speed
/// [rad/s], its inlet flooded.
pub(crate) fn nominal_rolling_friction(bearing: &Bearing, lubricant: &Lubricant, load: f64, speed: f64) -> f64 {
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
