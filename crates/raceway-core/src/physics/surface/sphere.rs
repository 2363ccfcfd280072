//! Height over the unit sphere of a ball: waves round its equator that fade beside it, and round defects.
//!
//! A ball turns under its contacts. Its height h at a contact therefore depends on the attitude of the contact's frame relative to the
//! ball. One vector τ holds all slopes, dh = (dθ_frame − dθ_ball) · τ. A load Q turns the ball with the moment Q τ and pushes it with
//! the force −(Q τ_a/r) t − (Q τ_t/|l|) c. The ring takes the opposite force at the same point. Without that force neither energy nor
//! angular momentum would be kept.

use std::collections::BTreeMap;

use super::ball::BallDefect;
use super::defects::{Across, Defect, PassingContact, Recess, Shape};
use super::height::Rise;
use super::table::{HeightTable, PathTable};
use super::waviness::Wave;
use crate::numerics::angle::sin_cos;
use crate::numerics::lanes::{LANES, Lanes, SideBySide, side_by_side};
use crate::physics::frames::{Vector, add, cross, dot, scale};

/// Height of a ball at a contact, and its slopes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallHeight<T = f64> {
    /// Added to the penetration of the contact [m], positive out of the material.
    pub height: T,
    /// Change with turns of the contact's frame relative to the ball, about the axes of that frame [m/rad].
    pub by_turn: Vector<T>,
}
side_by_side!(BallHeight { height, by_turn });

/// Attitude of a ball in the frame of a contact.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallPose<T = f64> {
    /// Longitude of the contact where the ball stays in its plane [rad].
    pub longitude: T,
    /// Axes of the ball, else.
    pub axes: [Vector<T>; 3],
}
side_by_side!(BallPose { longitude, axes });

/// A round defect of a ball under the contact that passes it. Its outline is taken as the square round it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BallRecess {
    /// Along the ball's surface; the azimuth is the longitude.
    pub recess: Recess,
    /// [rad]
    pub latitude: f64,
}

/// Surface of one ball as the contact of one raceway averages it.
#[derive(Debug)]
pub struct SphereProfile {
    /// Heights over longitude, for balls that stay in their plane.
    track: HeightTable,
    waves: SphereWaves<1>,
    defects: Vec<SphereDefect>,
}

/// Surfaces of all balls as the contact of one raceway averages them.
#[derive(Debug, Default)]
pub struct SphereProfiles {
    /// `None` for a sphere; empty where all balls are spheres.
    each: Vec<Option<SphereProfile>>,
    /// Waves of balls side by side, eight after eight.
    waves: Vec<SphereWaves<LANES>>,
}

/// Waves of balls side by side, by rising order.
#[derive(Debug, Default)]
struct SphereWaves<const N: usize>(Vec<SphereWave<N>>);

/// One order of several balls, A Re[(p₂ + i p₃)^n e^{iψ}].
#[derive(Debug)]
struct SphereWave<const N: usize> {
    /// Order less that of the wave before; the first less 1.
    further: u32,
    order: u32,
    /// A e^{iψ} of each ball [m].
    coefficient: Complex<Lanes<N>>,
}

/// Real and imaginary part.
type Complex<T = f64> = (T, T);

/// A round defect beside or on the equator.
#[derive(Debug)]
struct SphereDefect {
    /// From the ball's centre, in the ball's frame.
    direction: Vector,
    radius: f64,
    path: PathTable,
    across: Across,
}

impl SphereProfile {
    /// Waves and defects; `None` without any. `planar`: contacts lie on the equator.
    pub fn new(waves: &[Wave], recesses: &[BallRecess], planar: bool) -> Option<Self> {
        if waves.is_empty() && recesses.is_empty() {
            return None;
        }
        if planar {
            let recesses: Vec<Recess> = recesses.iter().map(|of| of.recess).collect();
            let track = HeightTable::new(waves, &recesses);
            return Some(Self { track, waves: SphereWaves::default(), defects: Vec::new() });
        }
        let defects = recesses.iter().filter_map(SphereDefect::new).collect();
        Some(Self { track: HeightTable::new(&[], &[]), waves: SphereWaves::new(waves), defects })
    }

    /// Height and slopes at a contact that lies in a direction from the ball's centre (axial, radial). `PLANAR`: on the equator.
    pub fn at<const PLANAR: bool>(&self, (towards_a, towards_r): (f64, f64), pose: &BallPose) -> BallHeight {
        if PLANAR {
            return self.at_longitude(pose.longitude);
        }
        let mut one = BallPose::<Lanes<1>>::default();
        one.put(0, *pose);
        let waves = self.waves.at(&(Lanes([towards_a]), Lanes([towards_r])), &one.axes).at(0);
        self.with_defects(waves, [towards_a, towards_r, 0.0], &pose.axes)
    }

    /// Height and slope on the equator. The contact's frame turns about X towards larger longitudes.
    fn at_longitude(&self, longitude: f64) -> BallHeight {
        let (height, slope) = self.track.height_and_slope(longitude);
        BallHeight { height, by_turn: [slope, 0.0, 0.0] }
    }

    /// Height of waves and defects where the waves have a height.
    fn with_defects(&self, mut of: BallHeight, towards: Vector, axes: &[Vector; 3]) -> BallHeight {
        for defect in &self.defects {
            let one = defect.at(towards, axes);
            of.height += one.height;
            of.by_turn = add(of.by_turn, one.by_turn);
        }
        of
    }
}

impl SphereProfiles {
    /// `None` for a sphere.
    pub fn new(each: Vec<Option<SphereProfile>>) -> Self {
        let waves_of = |ball: usize| each.get(ball)?.as_ref().map(|profile| &profile.waves);
        let groups = 0..each.len().div_ceil(LANES);
        let waves = groups.map(|group| SphereWaves::side_by_side(|lane| waves_of(group * LANES + lane))).collect();
        Self { each, waves }
    }

    /// Surface of a ball; `None` for a sphere.
    pub(crate) fn of(&self, ball: usize) -> Option<&SphereProfile> {
        self.each.get(ball)?.as_ref()
    }

    /// Heights with both derivatives at longitudes on the equators of the balls from `first` on [rad], which stay in their plane.
    #[inline(always)]
    pub(crate) fn on_tracks(&self, first: usize, longitude: &Lanes) -> Rise<Lanes> {
        HeightTable::rises_of(|lane| self.of(first + lane).map(|ball| &ball.track), longitude)
    }

    /// Heights at contacts of the balls from `first` on, which lie in directions from their centres (axial, radial). `PLANAR`: on the
    /// equators. Lanes beyond the last ball are spheres.
    #[inline(always)]
    pub(crate) fn at<const PLANAR: bool>(
        &self,
        first: usize,
        towards: &(Lanes, Lanes),
        pose: &BallPose<Lanes>,
    ) -> BallHeight<Lanes> {
        let mut heights = BallHeight::default();
        if !PLANAR && let Some(waves) = self.waves.get(first / LANES) {
            heights = waves.at(towards, &pose.axes);
        }
        for lane in 0..LANES {
            let Some(ball) = self.of(first + lane) else { continue };
            if PLANAR {
                heights.put(lane, ball.at_longitude(pose.longitude[lane]));
            } else if !ball.defects.is_empty() {
                let (towards_a, towards_r) = towards.at(lane);
                let waves = heights.at(lane);
                heights.put(lane, ball.with_defects(waves, [towards_a, towards_r, 0.0], &pose.axes.at(lane)));
            }
        }
        heights
    }
}

impl SphereWaves<1> {
    fn new(waves: &[Wave]) -> Self {
        let mut waves = waves.to_vec();
        waves.sort_by_key(|wave| wave.order);
        let coefficient = |wave: &Wave| {
            let (sine, cosine) = sin_cos(wave.phase);
            (Lanes([wave.amplitude * cosine]), Lanes([wave.amplitude * sine]))
        };
        Self::of_orders(waves.iter().map(|wave| (wave.order, coefficient(wave))))
    }
}

impl<const N: usize> SphereWaves<N> {
    /// By rising order.
    fn of_orders(waves: impl Iterator<Item = (u32, Complex<Lanes<N>>)>) -> Self {
        let mut before = 1;
        let one = |(order, coefficient)| {
            let further = order - std::mem::replace(&mut before, order);
            SphereWave { further, order, coefficient }
        };
        Self(waves.map(one).collect())
    }

    /// The waves of one ball in each lane.
    fn side_by_side<'a>(of: impl Fn(usize) -> Option<&'a SphereWaves<1>>) -> Self {
        let mut orders = BTreeMap::<u32, Complex<Lanes<N>>>::new();
        for lane in 0..N {
            for wave in of(lane).into_iter().flat_map(|waves| &waves.0) {
                let (real, imaginary) = orders.entry(wave.order).or_default();
                real[lane] += wave.coefficient.0[0];
                imaginary[lane] += wave.coefficient.1[0];
            }
        }
        Self::of_orders(orders.into_iter())
    }

    /// h = Re F(z) with z = p₂ + i p₃ of each contact; its gradient in the ball's frame is (0, Re F', −Im F').
    #[inline(always)]
    fn at(&self, towards: &(Lanes<N>, Lanes<N>), axes: &[Vector<Lanes<N>>; 3]) -> BallHeight<Lanes<N>> {
        let direction = |lane: usize| [towards.0[lane], towards.1[lane], 0.0];
        let mut z = Complex::<Lanes<N>>::default();
        for lane in 0..N {
            z.put(lane, (dot(direction(lane), axes[1].at(lane)), dot(direction(lane), axes[2].at(lane))));
        }
        let (mut height, mut slope) = (Lanes::<N>::default(), Complex::<Lanes<N>>::default());
        let mut power = (Lanes::<N>::all(1.0), Lanes::<N>::default());
        for wave in &self.0 {
            power = products(&power, &to_the_power(&z, wave.further));
            let order = f64::from(wave.order);
            for lane in 0..N {
                let (term, place) = (product(wave.coefficient.at(lane), power.at(lane)), z.at(lane));
                height[lane] += term.0 * place.0 - term.1 * place.1;
                slope.put(lane, (slope.0[lane] + order * term.0, slope.1[lane] + order * term.1));
            }
        }
        let mut heights = BallHeight::<Lanes<N>>::default();
        for lane in 0..N {
            let (real, imaginary) = slope.at(lane);
            let gradient = add(scale(real, axes[1].at(lane)), scale(-imaginary, axes[2].at(lane)));
            heights.put(lane, BallHeight { height: height[lane], by_turn: cross(direction(lane), gradient) });
        }
        heights
    }
}

impl SphereDefect {
    fn new(of: &BallRecess) -> Option<Self> {
        let across = of.recess.across()?;
        let path = PathTable::new(&of.recess);
        Some(Self { direction: of.direction(), radius: of.recess.contact.radius, path, across })
    }

    /// The contact lies at x along the groove and η across it from the defect's middle, both by the defect's direction n in the contact's
    /// frame: x = −(d/2) n·t, η = −(d/2) n·c. Beyond a quarter turn the defect is on the far side.
    fn at(&self, towards: Vector, axes: &[Vector; 3]) -> BallHeight {
        let [one, two, three] = self.direction;
        let n = add(scale(one, axes[0]), add(scale(two, axes[1]), scale(three, axes[2])));
        if dot(towards, n) <= 0.0 {
            return BallHeight::default();
        }
        let (fall, slope) = self.path.fall_and_slope(-self.radius * n[2]);
        if fall == 0.0 && slope == 0.0 {
            return BallHeight::default();
        }
        let across = [-towards[1], towards[0], 0.0];
        let (limited, by_fall, by_place) = self.across.limited(fall, -self.radius * dot(n, across));
        let gradient = add(scale(-by_place, across), [0.0, 0.0, -by_fall * slope]);
        BallHeight { height: -limited, by_turn: scale(self.radius, cross(n, gradient)) }
    }
}

impl BallRecess {
    pub(crate) fn new(defect: &BallDefect, contact: PassingContact) -> Self {
        let BallDefect { diameter, depth, latitude, longitude } = *defect;
        let shape = Shape::Rectangular;
        let defect = Defect { azimuth: longitude, length: diameter, width: Some(diameter), depth, across: 0.0, shape };
        Self { recess: Recess { defect, contact }, latitude }
    }

    /// Direction of its middle from the ball's centre, in the ball's frame: longitude from axis 2 towards 3, latitude towards 1.
    pub(crate) fn direction(&self) -> Vector {
        let ((sine, cosine), (lon_sine, lon_cosine)) = (sin_cos(self.latitude), sin_cos(self.recess.defect.azimuth));
        [sine, cosine * lon_cosine, cosine * lon_sine]
    }
}

/// The product of two complex numbers.
#[inline(always)]
fn product(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

#[inline(always)]
fn products<const N: usize>(a: &Complex<Lanes<N>>, b: &Complex<Lanes<N>>) -> Complex<Lanes<N>> {
    let mut products = Complex::<Lanes<N>>::default();
    for lane in 0..N {
        products.put(lane, product(a.at(lane), b.at(lane)));
    }
    products
}

/// Complex numbers to a whole power, by squares.
#[inline(always)]
fn to_the_power<const N: usize>(z: &Complex<Lanes<N>>, exponent: u32) -> Complex<Lanes<N>> {
    // Orders mostly follow one another.
    if exponent == 1 {
        return *z;
    }
    let (mut square, mut power) = (*z, (Lanes::<N>::all(1.0), Lanes::<N>::default()));
    let mut rest = exponent;
    while rest > 0 {
        if rest & 1 == 1 {
            power = products(&power, &square);
        }
        square = products(&square, &square);
        rest >>= 1;
    }
    power
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONTACT: PassingContact = PassingContact {
        semi_major: 0.2e-3,
        half_width: 0.03e-3,
        approach: 2e-6,
        curvature: 900.0,
        radius: 1.389e-3,
        speed: 10.0,
    };

    fn profile(planar: bool) -> SphereProfile {
        let wave = |(order, amplitude, phase)| Wave { order, amplitude, phase };
        let waves = [(40, 20e-9, 1.0), (1, 300e-9, -0.4), (3, 100e-9, 0.7)].map(wave);
        let defect = BallDefect { diameter: 0.3e-3, depth: 3e-6, latitude: 0.0, longitude: 0.1 };
        SphereProfile::new(&waves, &[BallRecess::new(&defect, CONTACT)], planar).unwrap()
    }

    /// Axes of a ball turned by a rotation about one axis after the other.
    fn turned(axes: &[Vector; 3], axis: usize, by: f64) -> [Vector; 3] {
        let (sine, cosine) = sin_cos(by);
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        axes.map(|v| {
            let mut turned = v;
            turned[a] = cosine * v[a] - sine * v[b];
            turned[b] = sine * v[a] + cosine * v[b];
            turned
        })
    }

    const SELF: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    /// Where the ball turns, the height falls by its slopes.
    #[test]
    fn slopes_are_those_of_the_height() {
        let ball = profile(false);
        let towards = (0.2, (1.0 - 0.04_f64).sqrt());
        for place in -40..40 {
            let axes = turned(&turned(&turned(&SELF, 0, 0.004 * f64::from(place)), 1, 0.03), 2, -0.15);
            let pose = |axes| BallPose { longitude: 0.0, axes };
            let at = ball.at::<false>(towards, &pose(axes));
            for axis in 0..3 {
                let by = 1e-6;
                let [less, more] = [-by, by].map(|by| ball.at::<false>(towards, &pose(turned(&axes, axis, by))).height);
                let slope = (less - more) / (2.0 * by);
                assert!((slope - at.by_turn[axis]).abs() < 1e-9, "{place} {axis}: {slope:e} {:e}", at.by_turn[axis]);
            }
        }
    }

    /// On the equator the height is the sum of cosines of longitude, by powers as by table.
    #[test]
    fn the_track_is_the_equator() {
        let (sphere, track) = (profile(false), profile(true));
        for place in 0..2000 {
            let longitude = 0.003_3 * f64::from(place) - 1.0;
            let axes = turned(&SELF, 0, -longitude);
            let one = sphere.at::<false>((0.0, 1.0), &BallPose { longitude, axes });
            let other = track.at::<true>((0.0, 1.0), &BallPose { longitude, axes });
            // Distances along the equator by their sine or by the arc.
            assert!((one.height - other.height).abs() < 2e-8, "{longitude}: {one:?} {other:?}");
            if !(-0.1..0.3).contains(&longitude) {
                assert!((one.height - other.height).abs() < 1e-12, "{longitude}: {one:?} {other:?}");
                assert!((one.by_turn[0] - other.by_turn[0]).abs() < 1e-9, "{longitude}: {one:?} {other:?}");
            }
        }
    }

    /// 6° beside the equator a wave of order 100 keeps 0.58 of its amplitude.
    #[test]
    fn waves_fade_beside_the_equator() {
        let ball = SphereProfile::new(&[Wave { order: 100, amplitude: 1.0, phase: 0.0 }], &[], false).unwrap();
        let (sine, cosine) = sin_cos(6.0_f64.to_radians());
        let height = ball.at::<false>((sine, cosine), &BallPose { longitude: 0.0, axes: SELF }).height;
        assert!((height - 0.577).abs() < 1e-3, "{height}");
    }
}
