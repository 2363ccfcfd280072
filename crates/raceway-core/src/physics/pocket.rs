//! A ball in its cage pocket: solid contact with an open crown seat and its rim, the damped film
//! that decides whether the motion is periodic or chaotic, and friction.
//!
//! Vectors are in the cage frame (tilted with the cage, not spinning), X along the mouth.

mod wedge;

use self::wedge::{PocketHydrodynamics, Wedge};
use super::bearing::Bearing;
use super::cage::{CageParameters, PocketFilm, PocketSeat};
use super::contact::damping::{DampingFactor, normal_load, normal_slopes};
use super::contact::hertz::sphere_stiffness;
use super::frames::{Vector, add, cross, dot, length, scale};
use super::lubricant::Lubricant;
use super::material::contact_modulus;
use crate::numerics::exponential::hyperbolic_tangent;
use crate::numerics::lanes::{Lanes, SideBySide, larger, side_by_side, smaller};

/// Damping of the default film [N s/m]: an assumption. Full squeeze of a disc would give about 45;
/// the seat of a crown pocket covers part of a sphere and is rarely full.
pub(crate) const WEDGE_DAMPING: f64 = 3.0;
/// Force of the empirical film at the edge of the clearance [N].
const EMPIRICAL_EDGE_FORCE: f64 = 11.0;
/// Largest effective radius of ball and seat of the lubricant wedge [m].
const MAX_RADIUS: f64 = 0.2;
/// Displacement over which film damping sets in [m].
pub(crate) const DAMPING_ONSET: f64 = 0.1e-6;
/// Penetration over which film damping vanishes once the solids touch [m].
pub(super) const DAMPING_END: f64 = 1e-6;

/// Constants of the pockets of one cage; all pockets are alike.
#[derive(Debug, Clone, Copy)]
pub struct Pocket {
    ball_radius: f64,
    /// `C_p`, half the diametral pocket clearance [m].
    clearance: f64,
    /// Cosine and sine of the rim angle; `None` where the seat is closed.
    rim: Option<(f64, f64)>,
    /// 1/C_p [1/m].
    per_clearance: f64,
    solid_stiffness: f64,
    solid_damping: DampingFactor,
    bar_stiffness: Option<f64>,
    film_stiffness: f64,
    film_damping: f64,
    friction: f64,
    friction_speed: f64,
    hydrodynamics: Option<PocketHydrodynamics>,
    /// Radius of the largest ball less the nominal one [m]; `None`: all balls are alike.
    largest_oversize: Option<f64>,
}

/// Which parts of the pocket force a model contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PocketTerms {
    pub film: bool,
    pub friction: bool,
    pub hydrodynamics: bool,
}

/// Load of a pocket on its ball; the cage takes the opposite load at the contact point.
#[derive(Debug, Clone, Copy, Default)]
pub struct PocketLoad<T = f64> {
    /// Normal load, film and solid [N].
    pub normal: T,
    /// Force on the ball [N].
    pub force: Vector<T>,
    /// Moment on the ball about its centre [N m].
    pub moment: Vector<T>,
    /// From the ball's centre to the contact point [m].
    pub lever: Vector<T>,
}
side_by_side!(PocketLoad { normal, force, moment, lever });

/// Motion of a ball relative to its pocket.
#[derive(Debug, Clone, Copy, Default)]
pub struct PocketMotion<T = f64> {
    /// Ball centre minus pocket centre [m].
    pub displacement: Vector<T>,
    /// Velocity of the ball centre relative to the cage material there [m/s].
    pub velocity: Vector<T>,
    /// Angular velocity of the ball relative to the cage [rad/s].
    pub spin: Vector<T>,
    /// Radius of the ball less the nominal one [m]; only pockets of unequal balls ask for it.
    pub oversize: T,
}
side_by_side!(PocketMotion { displacement, velocity, spin, oversize });

/// Approach of the ball to the nearest point of the seat: distance from the pocket's centre (`C_p` at touch of a nominal ball) [m], its
/// rate [m/s], and the unit vector of the force on the ball.
#[derive(Debug, Clone, Copy, Default)]
struct Approach<T = f64> {
    distance: T,
    rate: T,
    normal: Vector<T>,
}
side_by_side!(Approach { distance, rate, normal });

/// Slopes of the normal load by the ball's motion along the contact normal, for linearly implicit methods.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PocketSlopes<T = f64> {
    /// Unit vector of the force on the ball.
    pub normal: Vector<T>,
    /// Slope by displacement [N/m] and by its rate [N s/m].
    pub stiffness: T,
    pub damping: T,
}
side_by_side!(PocketSlopes { normal, stiffness, damping });

impl Pocket {
    /// Constants at an operating spin of the balls [rad/s].
    pub(crate) fn new(
        bearing: &Bearing,
        cage: &CageParameters,
        lubricant: &Lubricant,
        ball_spin: f64,
        terms: PocketTerms,
    ) -> Self {
        let ball_radius = 0.5 * bearing.parameters.ball_diameter;
        let clearance = 0.5 * cage.pocket_clearance;
        let relative_radius = ball_radius * (ball_radius + clearance) / clearance;
        let wedge = Wedge {
            viscosity: lubricant.viscosity,
            speed: ball_radius * ball_spin.abs(),
            radius: relative_radius.min(MAX_RADIUS),
            clearance,
            half_width: cage.seat_half_width,
        };
        let (film_stiffness, film_damping) = match cage.film {
            _ if !terms.film => (0.0, 0.0),
            PocketFilm::None => (0.0, 0.0),
            PocketFilm::Wedge => (wedge.stiffness(), WEDGE_DAMPING),
            PocketFilm::Empirical11 => (EMPIRICAL_EDGE_FORCE / clearance, 0.0),
            PocketFilm::Given { stiffness, damping } => (stiffness, damping),
        };
        Self {
            ball_radius,
            clearance,
            rim: match cage.seat {
                PocketSeat::Open => Some((cage.rim_angle.cos(), cage.rim_angle.sin())),
                PocketSeat::Closed => None,
            },
            per_clearance: 1.0 / clearance,
            solid_stiffness: sphere_stiffness(
                contact_modulus(&bearing.parameters.ball_material, &cage.material),
                relative_radius,
            ),
            solid_damping: cage.damping.resolve(),
            bar_stiffness: cage.bar_stiffness,
            film_stiffness,
            film_damping,
            friction: if terms.friction { cage.friction } else { 0.0 },
            friction_speed: cage.friction_speed,
            hydrodynamics: terms.hydrodynamics.then(|| wedge.hydrodynamics()),
            largest_oversize: None,
        }
    }

    /// The same pockets for balls that differ in size; `largest`: radius of the largest less the nominal one [m].
    pub(crate) fn with_unequal_balls(self, largest: f64) -> Self {
        Self { largest_oversize: Some(largest), ..self }
    }

    /// The pocket as a ball of its own size meets it, by its radius less the nominal one [m]: the seat is the same.
    #[inline(always)]
    fn of_ball(self, oversize: f64) -> Self {
        Self { ball_radius: self.ball_radius + oversize, clearance: self.clearance - oversize, ..self }
    }

    /// `C_p`, half the diametral pocket clearance [m].
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// Film stiffness `K_c` [N/m]; 0 without a film.
    pub fn film_stiffness(&self) -> f64 {
        self.film_stiffness
    }

    /// Returns true where a film damps the ball in its pocket.
    pub fn film_is_damped(&self) -> bool {
        self.film_damping > 0.0
    }

    /// Stiffness of the solid contact at first touch [N/m^1.5].
    pub fn solid_stiffness(&self) -> f64 {
        self.solid_stiffness
    }

    /// Elastic load of the solid contact at a penetration [m], without bar and damping [N]; 0 where they do not touch.
    pub fn solid_load(&self, penetration: f64) -> f64 {
        let depth = penetration.max(0.0);
        self.solid_stiffness * conformity((depth / self.clearance).sqrt()) * depth * depth.sqrt()
    }

    /// Force and moment of the pocket on one ball.
    pub fn load(&self, motion: &PocketMotion) -> PocketLoad {
        let mut one = PocketMotion::<Lanes<1>>::default();
        one.put(0, *motion);
        let mut load = PocketLoad::<Lanes<1>>::default();
        self.loads(&one, &mut load);
        load.at(0)
    }

    /// Forces and moments of the pockets on their balls.
    ///
    /// Normal force: Q = Q_film + Q_solid, neither part below 0. Film: Q_film = K_c min(s, C_p) + c_f ṡ min(1, s/0.1
    /// µm); its damping falls to 0 over the first 1 µm of solid contact. Solid: Q_solid = K_n (s − C_p)^1.5 κ (1 + χ ṡ)
    /// with `conformity` κ. Friction acts on the solid part only: on an undamped film force it would drive the cage
    /// unstable.
    #[inline(always)]
    pub fn loads<const N: usize>(&self, motion: &PocketMotion<Lanes<N>>, load: &mut PocketLoad<Lanes<N>>) {
        self.loads_at(motion, &self.approaches(motion), load);
    }

    /// Forces and moments of the pockets on their balls, and the slopes of the normal loads.
    #[inline(always)]
    pub(crate) fn loads_and_slopes<const N: usize>(
        &self,
        motion: &PocketMotion<Lanes<N>>,
        load: &mut PocketLoad<Lanes<N>>,
        slopes: &mut PocketSlopes<Lanes<N>>,
    ) {
        let approach = self.approaches(motion);
        let pocket = *self;
        match pocket.largest_oversize {
            None => {
                for lane in 0..N {
                    slopes.put(lane, pocket.slopes(&approach.at(lane)));
                }
            }
            Some(_) => {
                for lane in 0..N {
                    slopes.put(lane, pocket.of_ball(motion.oversize[lane]).slopes(&approach.at(lane)));
                }
            }
        }
        self.loads_at(motion, &approach, load);
    }

    #[inline(always)]
    fn approaches<const N: usize>(&self, motion: &PocketMotion<Lanes<N>>) -> Approach<Lanes<N>> {
        // A copy, so that the compiler knows that stores in the loops do not change it.
        let pocket = *self;
        let mut approach = Approach::<Lanes<N>>::default();
        match pocket.rim {
            Some(rim) => {
                for lane in 0..N {
                    let motion = motion.at(lane);
                    approach.put(lane, approach_at(&motion, pocket.seat_or_rim(rim, motion.displacement)));
                }
            }
            None => {
                for lane in 0..N {
                    let motion = motion.at(lane);
                    approach.put(lane, approach_at(&motion, seat(motion.displacement)));
                }
            }
        }
        approach
    }

    #[inline(always)]
    fn loads_at<const N: usize>(
        &self,
        motion: &PocketMotion<Lanes<N>>,
        approach: &Approach<Lanes<N>>,
        load: &mut PocketLoad<Lanes<N>>,
    ) {
        let pocket = *self;
        let solid = pocket.solid_loads(approach, &motion.oversize);
        match pocket.largest_oversize {
            None => {
                for lane in 0..N {
                    load.put(lane, pocket.normal_part(&approach.at(lane), solid[lane]));
                }
            }
            Some(_) => {
                for lane in 0..N {
                    let pocket = pocket.of_ball(motion.oversize[lane]);
                    load.put(lane, pocket.normal_part(&approach.at(lane), solid[lane]));
                }
            }
        }
        match pocket.hydrodynamics {
            Some(hydrodynamics) => {
                for lane in 0..N {
                    let mut one = load.at(lane);
                    let touching = if approach.distance[lane] > 0.0 { 1.0 } else { 0.0 };
                    let film = (touching * hydrodynamics.rolling, touching * hydrodynamics.shear);
                    pocket.add_friction(&motion.at(lane), approach.normal.at(lane), solid[lane], film, &mut one);
                    load.put(lane, one);
                }
            }
            None if pocket.friction > 0.0 && solid.any(|load| load > 0.0) => {
                for lane in 0..N {
                    let mut one = load.at(lane);
                    pocket.add_friction(&motion.at(lane), approach.normal.at(lane), solid[lane], (0.0, 0.0), &mut one);
                    load.put(lane, one);
                }
            }
            None => {}
        }
    }

    /// To the cap as `seat`; where the displacement points out of the mouth, to the rim. Both agree at the rim's angle,
    /// here as (cosine, sine).
    #[inline(always)]
    fn seat_or_rim(&self, (cosine, sine): (f64, f64), s: Vector) -> (f64, Vector) {
        let across = (s[1] * s[1] + s[2] * s[2]).sqrt();
        let per_across = if across > 0.0 { 1.0 / across } else { 0.0 };
        let seat_radius = self.ball_radius + self.clearance;
        let (along, radial) = (s[0] - seat_radius * cosine, across - seat_radius * sine);
        let distance = (along * along + radial * radial).sqrt();
        let per_distance = 1.0 / distance;
        let outward = radial * per_across * per_distance;
        let rim = (seat_radius - distance, [along * per_distance, outward * s[1], outward * s[2]]);
        let cap = seat(s);
        let out = s[0] * sine > across * cosine;
        let pick = |rim: f64, cap: f64| if out { rim } else { cap };
        (pick(rim.0, cap.0), [pick(rim.1[0], cap.1[0]), pick(rim.1[1], cap.1[1]), pick(rim.1[2], cap.1[2])])
    }

    /// Loads of the solid contacts [N].
    #[inline(always)]
    fn solid_loads<const N: usize>(self, approach: &Approach<Lanes<N>>, oversize: &Lanes<N>) -> Lanes<N> {
        let mut solid = Lanes::default();
        let least = self.clearance - self.largest_oversize.unwrap_or(0.0);
        if !approach.distance.any(|distance| distance > least) {
            return solid;
        }
        let mut penetrations = <Lanes<N>>::default();
        for lane in 0..N {
            penetrations[lane] = approach.distance[lane] - (self.clearance - oversize[lane]);
        }
        match self.bar_stiffness {
            None => {
                for lane in 0..N {
                    let penetration = penetrations[lane];
                    let depth = larger(penetration, 0.0) * self.per_clearance;
                    let stiffness = self.solid_stiffness * conformity(depth.sqrt());
                    solid[lane] = normal_load(stiffness, penetration, approach.rate[lane], &self.solid_damping);
                }
            }
            Some(bar) => {
                for lane in 0..N {
                    let penetration = larger(penetrations[lane], 0.0);
                    let share = self.contact_share(bar, penetration);
                    let local = if penetration > 0.0 { share } else { 0.0 };
                    let root = (local * self.per_clearance).sqrt();
                    let stiffness = self.solid_stiffness * conformity(root);
                    // The contact takes part of the rate: d(local)/d(penetration) = k_bar / (k_bar + dQ/dδ).
                    let share = bar / (bar + exponent(root) * stiffness * local.sqrt());
                    let rate = share * approach.rate[lane];
                    solid[lane] = normal_load(stiffness, local, rate, &self.solid_damping);
                }
            }
        }
        solid
    }

    /// Part of a penetration [m] that the contact takes in series with a bar of stiffness `bar` [N/m]. Solves Q(δ) =
    /// bar (penetration − δ) by Newton's method in √δ from above, where it converges monotonically.
    #[inline(always)]
    fn contact_share(&self, bar: f64, penetration: f64) -> f64 {
        // A root of nothing would be divided by itself.
        let mut root = larger(penetration, 1e-200).sqrt();
        for _ in 0..12 {
            let relative = root * self.per_clearance.sqrt();
            let stiffness = self.solid_stiffness * conformity(relative);
            let residual = (stiffness * root + bar) * root * root - bar * penetration;
            let slope = 2.0 * (exponent(relative) * stiffness * root + bar) * root;
            root -= residual / slope;
        }
        root * root
    }

    /// Share of the film's damping that acts.
    #[inline(always)]
    fn damping_share(&self, distance: f64) -> f64 {
        larger(1.0 - larger(distance - self.clearance, 0.0) * (1.0 / DAMPING_END), 0.0)
            * smaller(distance * (1.0 / DAMPING_ONSET), 1.0)
    }

    /// How the normal load answers to displacements along the normal; a bar in series is taken as rigid, which is stiffer.
    #[inline(always)]
    fn slopes(&self, &Approach { distance, rate, normal }: &Approach) -> PocketSlopes {
        let penetration = distance - self.clearance;
        let depth = larger(penetration, 0.0) * self.per_clearance;
        let solid = self.solid_stiffness * conformity(depth.sqrt());
        let (stiffness, damping) = normal_slopes(solid, penetration, rate, &self.solid_damping);
        let film = if penetration < 0.0 { self.film_stiffness } else { 0.0 };
        PocketSlopes {
            normal,
            stiffness: film + stiffness,
            damping: self.film_damping * self.damping_share(distance) + damping,
        }
    }

    /// The load along the contact's normal, film and solid.
    #[inline(always)]
    fn normal_part(&self, approach: &Approach, solid: f64) -> PocketLoad {
        let Approach { distance, rate, normal } = *approach;
        let damping = self.film_damping * self.damping_share(distance);
        let film = larger(self.film_stiffness * smaller(distance, self.clearance) + damping * rate, 0.0);
        let load = if distance > 0.0 { film + solid } else { 0.0 };
        PocketLoad {
            normal: load,
            force: scale(load, normal),
            moment: [0.0; 3],
            lever: scale(-self.ball_radius, normal),
        }
    }

    /// Adds dry friction P_S = μ Q_solid tanh(|u|/u₀) and the film's rolling friction and shear. These are proportional
    /// to rolling and sliding speed [N s/m].
    #[inline(always)]
    fn add_friction(
        &self,
        motion: &PocketMotion,
        normal: Vector,
        solid: f64,
        (film_rolling, film_shear): (f64, f64),
        load: &mut PocketLoad,
    ) {
        let along = dot(motion.velocity, normal);
        let centre = add(motion.velocity, scale(-along, normal));
        let rolling = cross(motion.spin, load.lever);
        let slip = add(centre, rolling);
        let speed = larger(length(slip), MIN_SLIP);
        let dry = self.friction * solid * hyperbolic_tangent(speed * (1.0 / self.friction_speed)) / speed;
        // The ball's surface carries the lubricant through; rolling friction acts against it.
        let force = add(scale(-film_rolling, rolling), scale(-(dry + film_shear), slip));
        load.force = add(load.force, force);
        load.moment = add(load.moment, cross(load.lever, force));
    }
}

/// Stands in for a slip of 0 where its direction is asked for [m/s].
pub(super) const MIN_SLIP: f64 = 1e-12;

/// The displacement itself is the way to the nearest point of a cap.
#[inline(always)]
fn seat(s: Vector) -> (f64, Vector) {
    let distance = length(s);
    // At the very centre there is no direction and, with every law here, no force.
    let inverse = if distance > 0.0 { -1.0 / distance } else { 0.0 };
    (distance, scale(inverse, s))
}

#[inline(always)]
fn approach_at(motion: &PocketMotion, (distance, normal): (f64, Vector)) -> Approach {
    Approach { distance, rate: -dot(motion.velocity, normal), normal }
}

/// How much a ball's contact with its seat differs from Hertz's, over s = √(δ/C_p), about the radius of the contact over that of the
/// ball: (1 + s) / (1 + s/2 + ¾ s²).
///
/// 1 at first touch; for s → ∞ the load is that of a ball that fills its seat, 16/9 E* R δ. Between these it is fitted to finite elements
/// (`verification/pocket`), which it meets within 1 % for pocket clearances of 10 to 100 µm up to 20 N.
#[inline(always)]
fn conformity(s: f64) -> f64 {
    (1.0 + s) / (1.0 + s * (0.5 + 0.75 * s))
}

/// Exponent of the load in the penetration, d(ln Q)/d(ln δ): 3/2 at first touch, 1 of a ball that fills its seat.
#[inline(always)]
fn exponent(s: f64) -> f64 {
    1.5 + 0.5 * s * (1.0 / (1.0 + s) - (0.5 + 1.5 * s) / (1.0 + s * (0.5 + 0.75 * s)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::contact::damping::DampingLaw;
    use crate::physics::examples;

    fn article_pocket(change: impl Fn(&mut CageParameters), terms: PocketTerms) -> Pocket {
        let mut cage = examples::article_cage();
        change(&mut cage);
        Pocket::new(&examples::article_bearing(), &cage, &examples::article_lubricant(), 11_692.0, terms)
    }
    const ALL: PocketTerms = PocketTerms { film: true, friction: true, hydrodynamics: false };

    fn at_rest(displacement: Vector) -> PocketMotion {
        PocketMotion { displacement, ..PocketMotion::default() }
    }

    /// Pins the wedge: 3.8e4 N/m in the article's case, about a tenth of the untruncated 4e5 N/m.
    #[test]
    fn wedge_stiffness_of_the_article_s_pocket() {
        let narrow = article_pocket(|_| {}, ALL).film_stiffness();
        assert!((narrow / 3.8e4 - 1.0).abs() < 0.03, "{narrow}");
        let wide = article_pocket(|cage| cage.seat_half_width = 0.5, ALL).film_stiffness();
        assert!((wide / 4e5 - 1.0).abs() < 0.1, "{wide}");
    }

    /// K_n = 4/3 E* √R_p with E* = 1.17 GPa and R_p = 77 mm.
    #[test]
    fn solid_stiffness_is_hertz_of_ball_and_seat() {
        let stiffness = article_pocket(|_| {}, ALL).solid_stiffness();
        assert!((stiffness / (4.0 / 3.0 * 1.17e9 * 0.077_f64.sqrt()) - 1.0).abs() < 0.01, "{stiffness:e}");
    }

    /// The exponent is the derivative of the load, and both limits are met.
    #[test]
    fn the_contact_goes_from_hertz_to_a_filled_seat() {
        let pocket = article_pocket(|_| {}, ALL);
        for depth in [1e-8, 1e-6, 25.5e-6, 1e-4] {
            let (low, high) = (pocket.solid_load(depth * 0.999_99), pocket.solid_load(depth * 1.000_01));
            let slope = (high / low).ln() / (1.000_01_f64 / 0.999_99).ln();
            assert!((slope - exponent((depth / pocket.clearance).sqrt())).abs() < 1e-6, "{depth}: {slope}");
        }
        let tiny = 1e-13;
        assert!((pocket.solid_load(tiny) / (pocket.solid_stiffness * tiny.powf(1.5)) - 1.0).abs() < 1e-4);
        let tight = article_pocket(|cage| cage.pocket_clearance = 1e-12, ALL);
        let filled = 16.0 / 9.0 * 1.17e9 * 1.389e-3 * 1e-5;
        assert!((tight.solid_load(1e-5) / filled - 1.0).abs() < 0.01, "{}", tight.solid_load(1e-5));
    }

    /// A bar takes what its stiffness and the contact's leave it.
    #[test]
    fn contact_and_bar_bear_the_same_load() {
        let pocket = article_pocket(|_| {}, ALL);
        for penetration in [1e-7, 1e-5, 1e-4] {
            for bar in [1e3, 1e5, 1e8] {
                let local = pocket.contact_share(bar, penetration);
                let (contact, of_bar) = (pocket.solid_load(local), bar * (penetration - local));
                assert!((contact - of_bar).abs() < 1e-9 * bar * penetration, "{penetration} {bar}: {contact} {of_bar}");
            }
        }
    }

    /// Cap and rim meet at the rim angle without a jump in force.
    #[test]
    fn force_is_continuous_where_the_cap_ends() {
        let pocket = article_pocket(|cage| cage.damping = DampingLaw::None, ALL);
        let at = |degrees: f64| {
            let angle = degrees.to_radians();
            pocket.load(&at_rest([30e-6 * angle.cos(), 30e-6 * angle.sin(), 0.0])).force
        };
        let (rim, cap) = (at(65.0 - 1e-9), at(65.0 + 1e-9));
        for k in 0..3 {
            assert!((rim[k] - cap[k]).abs() < 1e-6 * length(cap), "{rim:?} {cap:?}");
        }
    }

    /// The rim pushes a ball that leaves through the mouth back in, and grows beyond any axial load of a light cage.
    #[test]
    fn the_rim_keeps_the_ball_in() {
        let pocket = article_pocket(|_| {}, ALL);
        let slightly = pocket.load(&at_rest([0.3e-3, 1e-9, 0.0]));
        assert!(slightly.force[0] < -20.0, "{:?}", slightly.force);
        let closed = article_pocket(|cage| cage.seat = PocketSeat::Closed, ALL);
        assert!(closed.load(&at_rest([40e-6, 0.0, 0.0])).force[0] < 0.0);
    }

    /// Film never pulls, friction opposes sliding and never acts on the film.
    #[test]
    fn film_does_not_pull_and_friction_needs_solid_contact() {
        let pocket = article_pocket(|_| {}, ALL);
        let leaving = PocketMotion {
            displacement: [0.0, 10e-6, 0.0],
            velocity: [0.0, -10.0, 0.0],
            spin: [1e4, 0.0, 0.0],
            oversize: 0.0,
        };
        assert_eq!(length(pocket.load(&leaving).force), 0.0);
        let film_only =
            PocketMotion { displacement: [0.0, 0.0, 20e-6], velocity: [0.0; 3], spin: [1e4, 0.0, 0.0], oversize: 0.0 };
        assert_eq!(pocket.load(&film_only).moment, [0.0; 3]);
        let solid =
            PocketMotion { displacement: [0.0, 0.0, 30e-6], velocity: [0.0; 3], spin: [1e4, 0.0, 0.0], oversize: 0.0 };
        let load = pocket.load(&solid);
        // Contact point at +z, spin about +x moves the ball's surface there towards −y: friction points to +y
        // and brakes the spin.
        assert!(load.force[1] > 0.0 && load.moment[0] < 0.0, "{load:?}");
    }

    /// A soft bar takes almost all of the penetration: Q → bar · penetration.
    #[test]
    fn a_soft_bar_in_series_limits_the_load() {
        let pocket = article_pocket(
            |cage| {
                cage.bar_stiffness = Some(1e3);
                cage.damping = DampingLaw::None;
            },
            PocketTerms { film: false, friction: false, hydrodynamics: false },
        );
        let load = pocket.load(&at_rest([0.0, 0.0, 25.5e-6 + 100e-6])).normal;
        assert!((load / 0.1 - 1.0).abs() < 0.01 && load < 0.1, "{load}");
    }
}
