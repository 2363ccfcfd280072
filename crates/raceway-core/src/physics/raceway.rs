//! One ball on one raceway: penetration, contact angle, slip, loads.
//!
//! Everything here happens in the contact's own frame `[a, r, t]` at the ball: `a` along the
//! raceway's axis, `r` radially from that axis to the ball, `t` = a × r along the groove. `frames`
//! and `model` bring motions into it and loads out of it.

mod groove;
mod motion;
mod strip_sums;

use std::array::from_fn;
use std::sync::Arc;

pub(crate) use self::groove::LARGEST_CONTACT;
pub use self::groove::OnBall;
use self::groove::{Contact, Groove, GroovePlace};
pub(crate) use self::motion::ContactSlopes;
pub use self::motion::{RacewayLoad, RelativeMotion};
use self::strip_sums::{AT_ONCE, MirroredStrips, StripSums};
use super::bearing::{Bearing, PerRaceway};
use super::contact::damping::DampingFactor;
use super::contact::film::{Film, Inlet, ThinnestFilm};
use super::contact::hertz::{HertzContact, raceway_contacts};
use super::contact::strips::{Strip, Strips};
use super::contact::traction::{
    FourParameters, Traction, TractionContext, coulomb, eyring, rising, rolling, rolling_at_rest, sticking,
};
use super::frames::{add, scale};
use super::kinematics;
use super::lubricant::Lubricant;
use super::surface::sphere::{BallPose, SphereProfile, SphereProfiles};
use super::surface::{Height, SurfaceProfile};
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide, Task};

/// Which parts of the contact a model contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RacewayTerms {
    /// Strips the ellipse is cut into across the groove.
    pub strips: usize,
    /// Points of a Gauss rule replace the strips.
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
    /// Strips that each carry the load of their mirror image as well.
    folded_strips: MirroredStrips,
    surface: SurfaceProfile,
    /// Place of the groove along the axis.
    axial: SurfaceProfile,
    /// Surfaces of the balls as this raceway averages them.
    balls: Arc<SphereProfiles>,
}

/// Loads of balls side by side, to be compiled for each instruction set. Written where they are wanted: no copies.
struct Loads<'a, const PLANAR: bool> {
    raceway: &'a RacewayContact,
    motion: &'a RelativeMotion<Lanes>,
    on_ball: Option<&'a OnBall<Lanes>>,
    load: &'a mut RacewayLoad<Lanes>,
}

impl<const PLANAR: bool> Task for Loads<'_, PLANAR> {
    type Answer = ();

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let contact = self.raceway.contacts::<PLANAR, LANES>(self.motion, self.on_ball);
        self.raceway.loads_of::<PLANAR, LANES>(&contact, self.motion, self.on_ball, self.load);
    }
}

/// Loads of balls side by side on both raceways.
struct PairOfLoads<'a, const PLANAR: bool> {
    raceway: &'a PerRaceway<RacewayContact>,
    motion: &'a PerRaceway<RelativeMotion<Lanes>>,
    on_ball: Option<&'a PerRaceway<OnBall<Lanes>>>,
    load: &'a mut PerRaceway<RacewayLoad<Lanes>>,
}

impl<const PLANAR: bool> Task for PairOfLoads<'_, PLANAR> {
    type Answer = ();

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let Self { raceway, motion, on_ball, load } = self;
        let (on_inner, on_outer) = (on_ball.map(|on| &on.inner), on_ball.map(|on| &on.outer));
        // Both geometries first: each is a chain of roots, and two chains take no longer than one.
        let outer = raceway.outer.contacts::<PLANAR, LANES>(&motion.outer, on_outer);
        let inner = raceway.inner.contacts::<PLANAR, LANES>(&motion.inner, on_inner);
        raceway.inner.loads_of::<PLANAR, LANES>(&inner, &motion.inner, on_inner, &mut load.inner);
        raceway.outer.loads_of::<PLANAR, LANES>(&outer, &motion.outer, on_outer, &mut load.outer);
    }
}

/// Effects of the surfaces of balls side by side.
struct OnBalls<'a, const PLANAR: bool> {
    raceway: &'a RacewayContact,
    first: usize,
    motion: &'a RelativeMotion<Lanes>,
    pose: &'a BallPose<Lanes>,
}

impl<const PLANAR: bool> Task for OnBalls<'_, PLANAR> {
    type Answer = OnBall<Lanes>;

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let Self { raceway: RacewayContact { groove, balls, .. }, first, motion, pose } = self;
        let mut contact = <(Lanes, (Lanes, Lanes))>::default();
        for lane in 0..LANES {
            contact.put(lane, groove.penetration::<PLANAR>(motion.axial[lane], motion.radius[lane]));
        }
        let height = balls.at::<PLANAR>(first, &contact.1, pose);
        let mut on_ball = OnBall::default();
        for lane in 0..LANES {
            on_ball.put(lane, groove.on_ball::<PLANAR>(&height.at(lane), &motion.at(lane), contact.at(lane)));
        }
        on_ball
    }
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
            axial: SurfaceProfile::None,
            balls: Arc::default(),
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

    /// The same raceway with a groove whose place along the axis has waves.
    pub fn with_axial_waves(mut self, axial: SurfaceProfile) -> Self {
        self.axial = axial;
        self
    }

    /// Returns true where forces of the film's inlet act.
    pub(crate) fn has_inlet(&self) -> bool {
        self.groove.hydrodynamics
    }

    /// The same raceway without forces of the film's inlet.
    pub(crate) fn without_inlet(&self) -> Self {
        Self { groove: Groove { hydrodynamics: false, ..self.groove }, ..self.clone() }
    }

    /// Returns true for an ideal circle in a plane.
    pub(crate) fn is_circle(&self) -> bool {
        self.surface.is_ideal() && self.axial.is_ideal()
    }

    /// Place of the groove along the axis at an azimuth [m].
    pub fn groove_place(&self, azimuth: f64) -> f64 {
        self.axial.at(azimuth, 0.0).height
    }

    /// Refers the axial places of balls to the groove at their azimuths.
    #[inline(always)]
    pub(crate) fn place_in_groove(&self, motion: &mut RelativeMotion<Lanes>) {
        if self.axial.is_ideal() {
            return;
        }
        for lane in 0..LANES {
            motion.axial[lane] -= self.groove_place(motion.azimuth[lane]);
        }
    }

    /// The same raceway on balls of some surfaces, `None` for a sphere.
    pub fn with_balls(mut self, balls: Vec<Option<SphereProfile>>) -> Self {
        self.balls = Arc::new(SphereProfiles::new(balls));
        self
    }

    /// Surfaces of the balls.
    pub(crate) fn balls(&self) -> &Arc<SphereProfiles> {
        &self.balls
    }

    /// Effects of the surfaces of the balls from `first` on, without their sizes.
    #[inline(never)]
    pub(crate) fn on_balls<const PLANAR: bool>(
        &self,
        first: usize,
        motion: &RelativeMotion<Lanes>,
        pose: &BallPose<Lanes>,
        instructions: InstructionSet,
    ) -> OnBall<Lanes> {
        instructions.run(OnBalls::<PLANAR> { raceway: self, first, motion, pose })
    }

    /// The surface profile.
    pub fn surface(&self) -> &SurfaceProfile {
        &self.surface
    }

    /// Radius of the groove's bottom [m].
    pub(crate) fn bottom_radius(&self) -> f64 {
        self.groove.centre_radius + self.groove.side * (self.groove.touch_distance + self.groove.ball_radius)
    }

    /// Returns true where the contact damps an impact.
    pub(crate) fn is_damped(&self) -> bool {
        self.groove.damping.chi > 0.0 || self.groove.damping.viscous > 0.0
    }

    /// The elastic contact.
    pub fn hertz(&self) -> &HertzContact {
        &self.groove.hertz
    }

    /// Penetration under an elastic load [N] over the ball's radius [-].
    pub fn relative_depth(&self, load: f64) -> f64 {
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
    pub fn elastic_load(&self, penetration: f64) -> (f64, f64) {
        self.groove.elastic_load(penetration)
    }

    /// Force and moment of the raceway on a ball that is a sphere.
    pub fn load<const PLANAR: bool>(&self, motion: &RelativeMotion) -> RacewayLoad {
        self.load_of_one::<PLANAR>(motion, None)
    }

    /// Force and moment of the raceway on a ball of some surface in some attitude.
    pub fn load_on_ball<const PLANAR: bool>(
        &self,
        motion: &RelativeMotion,
        ball: &SphereProfile,
        pose: &BallPose,
    ) -> RacewayLoad {
        let mut on_ball = OnBall::<Lanes<1>>::default();
        let (penetration, towards) = self.penetration::<PLANAR>(motion.axial, motion.radius);
        let height = ball.at::<PLANAR>(towards, pose);
        on_ball.put(0, self.groove.on_ball::<PLANAR>(&height, motion, (penetration, towards)));
        self.load_of_one::<PLANAR>(motion, Some(&on_ball))
    }

    fn load_of_one<const PLANAR: bool>(
        &self,
        motion: &RelativeMotion,
        on_ball: Option<&OnBall<Lanes<1>>>,
    ) -> RacewayLoad {
        let mut one = RelativeMotion::<Lanes<1>>::default();
        one.put(0, *motion);
        let mut load = RacewayLoad::<Lanes<1>>::default();
        self.loads_of::<PLANAR, 1>(&self.contacts::<PLANAR, 1>(&one, on_ball), &one, on_ball, &mut load);
        load.at(0)
    }

    /// Forces and moments of both raceways on balls side by side, by a set of instructions. `PLANAR`: nothing acts or moves
    /// along the axis, so contacts are symmetric across the groove and half of their strips will do. `on_ball`: effects of the balls'
    /// surfaces.
    pub fn pair_of_loads<const PLANAR: bool>(
        raceway: &PerRaceway<Self>,
        motion: &PerRaceway<RelativeMotion<Lanes>>,
        on_ball: Option<&PerRaceway<OnBall<Lanes>>>,
        load: &mut PerRaceway<RacewayLoad<Lanes>>,
        instructions: InstructionSet,
    ) {
        instructions.run(PairOfLoads::<PLANAR> { raceway, motion, on_ball, load });
    }

    /// Forces and moments of one raceway on balls side by side.
    pub fn loads<const PLANAR: bool>(
        &self,
        motion: &RelativeMotion<Lanes>,
        on_ball: Option<&OnBall<Lanes>>,
        load: &mut RacewayLoad<Lanes>,
        instructions: InstructionSet,
    ) {
        instructions.run(Loads::<PLANAR> { raceway: self, motion, on_ball, load });
    }

    #[inline(always)]
    fn contacts<const PLANAR: bool, const N: usize>(
        &self,
        motion: &RelativeMotion<Lanes<N>>,
        on_ball: Option<&OnBall<Lanes<N>>>,
    ) -> Contact<Lanes<N>> {
        // A copy, so that the compiler knows that stores in the loop do not change it.
        let groove = self.groove;
        let mut contact = Contact::<Lanes<N>>::default();
        if self.is_circle() && on_ball.is_none() {
            for lane in 0..N {
                contact.put(lane, groove.contact::<PLANAR>(&motion.at(lane), None));
            }
            return contact;
        }
        let lift = self.lifts(motion, on_ball);
        let oversize = on_ball.map_or(Lanes::default(), |on_ball| on_ball.oversize);
        for lane in 0..N {
            let mut one = groove.contact::<PLANAR>(&motion.at(lane), Some(lift.at(lane)));
            // A larger ball touches farther from its centre.
            one.shift += oversize[lane];
            one.apex += oversize[lane];
            contact.put(lane, one);
        }
        contact
    }

    /// Heights of the raceway and of the balls over it [m], and the rates at which they rise [m/s].
    #[inline(always)]
    fn lifts<const N: usize>(
        &self,
        motion: &RelativeMotion<Lanes<N>>,
        on_ball: Option<&OnBall<Lanes<N>>>,
    ) -> (Lanes<N>, Lanes<N>) {
        let (mut height, mut rise) = self.lifts_of_raceway(motion);
        if let Some(on_ball) = on_ball {
            for lane in 0..N {
                height[lane] += on_ball.height[lane];
                rise[lane] += on_ball.rise[lane];
            }
        }
        (height, rise)
    }

    /// Heights of the raceway alone.
    #[inline(always)]
    fn lifts_of_raceway<const N: usize>(&self, motion: &RelativeMotion<Lanes<N>>) -> (Lanes<N>, Lanes<N>) {
        if self.is_circle() {
            return Default::default();
        }
        let (of, places) = self.heights(motion);
        let mut rise = <Lanes<N>>::default();
        for lane in 0..N {
            rise[lane] = of.along[lane] * motion.at(lane).azimuth_rate();
        }
        if self.surface.is_narrow() {
            for lane in 0..N {
                rise[lane] += of.across[lane] * places.at(lane).rate(&motion.velocity.at(lane));
            }
        }
        (of.height, rise)
    }

    /// Heights under balls with the places of their contacts, which stay 0 where the height does not change across the groove.
    #[inline(always)]
    fn heights<const N: usize>(&self, motion: &RelativeMotion<Lanes<N>>) -> (Height<Lanes<N>>, GroovePlace<Lanes<N>>) {
        let mut places = GroovePlace::<Lanes<N>>::default();
        if self.surface.is_narrow() {
            for lane in 0..N {
                places.put(lane, self.groove.place(motion.axial[lane], motion.radius[lane]));
            }
        }
        let mut of = self.surface.under(&motion.azimuth, &places.place);
        if !self.axial.is_ideal() {
            for lane in 0..N {
                let (height, by_axial) = (of.at(lane), places.by_ball.0[lane]);
                let place = (motion.axial[lane], motion.radius[lane]);
                of.along[lane] += self.along_axial_waves(motion.azimuth[lane], place, height.across * by_axial);
            }
        }
        (of, places)
    }

    /// Change of the penetration with the azimuth [m/rad], because the place of the groove changes: −x_g' (m_a + h_η η_a). `place`: axial, in
    /// the groove, and radius [m]; `across`: change of the height with the axial place [-].
    fn along_axial_waves(&self, azimuth: f64, (axial, radius): (f64, f64), across: f64) -> f64 {
        let (_, (towards_a, _)) = self.groove.penetration::<false>(axial, radius);
        -self.axial.at(azimuth, 0.0).along * (towards_a + across)
    }

    /// Adds the lean force of a raceway that is not a circle: −Q h_φ/r along the groove, and across it −Q h_η by the change of η with
    /// the place of the ball. It acts through the ball's centre.
    #[inline(always)]
    fn add_lean<const N: usize>(&self, motion: &RelativeMotion<Lanes<N>>, load: &mut RacewayLoad<Lanes<N>>) {
        let (of, places) = self.heights(motion);
        for lane in 0..N {
            load.force[2][lane] -= load.normal[lane] * of.along[lane] / motion.radius[lane];
        }
        if self.surface.is_narrow() {
            for lane in 0..N {
                let (axial, radial) = places.by_ball.at(lane);
                load.force[0][lane] -= load.normal[lane] * of.across[lane] * axial;
                load.force[1][lane] -= load.normal[lane] * of.across[lane] * radial;
            }
        }
    }

    /// Height and slopes of the raceway under a ball at an azimuth on the ring [rad], and the change of the contact's place across the
    /// groove with the ball's own place, axial and radial [-]. `axial`: place of the ball in the groove [m].
    pub(crate) fn height(&self, azimuth: f64, axial: f64, radius: f64) -> (Height, (f64, f64)) {
        let place = if self.surface.is_narrow() { self.groove.place(axial, radius) } else { GroovePlace::default() };
        let mut of = self.surface.at(azimuth, place.place);
        if !self.axial.is_ideal() {
            of.along += self.along_axial_waves(azimuth, (axial, radius), of.across * place.by_ball.0);
        }
        (of, place.by_ball)
    }

    #[inline(always)]
    fn loads_of<const PLANAR: bool, const N: usize>(
        &self,
        contact: &Contact<Lanes<N>>,
        motion: &RelativeMotion<Lanes<N>>,
        on_ball: Option<&OnBall<Lanes<N>>>,
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
        if !self.is_circle() {
            self.add_lean(motion, load);
        }
        if let Some(on_ball) = on_ball {
            for lane in 0..N {
                let (one, normal) = (on_ball.at(lane), load.normal[lane]);
                load.force.put(lane, add(load.force.at(lane), scale(normal, one.force)));
                load.moment.put(lane, add(load.moment.at(lane), scale(normal, one.moment)));
            }
        }
        if groove.hydrodynamics {
            for lane in 0..N {
                let mut one = load.at(lane);
                groove.add_inlet(&contact.at(lane), &motion.at(lane), &mut one);
                load.put(lane, one);
            }
        }
    }

    /// Traction over load, summed over the strips. Without spin about the normal, a strip and its mirror image have the
    /// same slip.
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
        on_ball: Option<&OnBall<Lanes>>,
        load: &RacewayLoad<Lanes>,
        slopes: &mut ContactSlopes<Lanes>,
    ) {
        let groove = self.groove;
        let (_, rise) = self.lifts(motion, on_ball);
        for lane in 0..LANES {
            slopes.put(lane, groove.slopes::<PLANAR>(&motion.at(lane), &load.at(lane), rise[lane]));
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

    /// Mean rolling speeds of several balls whose contacts lie in the directions of `slopes` [m/s].
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
