//! Heights with continuous first and second derivatives, as tables: one periodic over azimuth, one of the path over a defect.

use std::f64::consts::TAU;

use super::defects::{Recess, wrapped};
use super::height::{Height, Rise};
use super::waviness::{HIGHEST_ORDER, Wave};
use crate::numerics::angle::sin_cos;
use crate::numerics::exponential::ROUND;
use crate::numerics::lanes::{Lanes, SideBySide, side_by_side};

/// Knots to one period of the shortest wave. Between knots the height then errs by less than 6e-6 of that wave.
const KNOTS_PER_WAVE: usize = 8;
/// Knots to one half width of the contact that passes a defect.
const KNOTS_PER_HALF_WIDTH: f64 = 8.0;
/// Knots of the smallest table and of the largest.
const FEWEST: usize = 64;
const MOST: usize = KNOTS_PER_WAVE * HIGHEST_ORDER as usize;

/// Height at one knot with its first and second derivative, over the distance between knots [m].
#[derive(Debug, Clone, Copy, Default)]
struct Knot<T = f64> {
    height: T,
    first: T,
    second: T,
}
side_by_side!(Knot { height, first, second });

/// Heights at equidistant azimuths round a ring. Between two knots stands the polynomial of degree five that has their heights and
/// derivatives (Hermite).
#[derive(Debug)]
pub struct HeightTable {
    /// A power of two, and the first knot once more.
    knots: Vec<Knot>,
}

impl HeightTable {
    /// The sum of waves, its derivatives exact at the knots, and of the paths over defects in the middle of the groove. Orders beyond the
    /// range of the largest table are left out.
    pub(super) fn new(waves: &[Wave], recesses: &[Recess]) -> Self {
        let waves = || waves.iter().filter(|wave| wave.order <= HIGHEST_ORDER);
        let of_waves = waves().map(|wave| KNOTS_PER_WAVE * wave.order as usize);
        let of_defects =
            recesses.iter().map(|recess| (TAU * recess.contact.radius / spacing_of(recess)).ceil() as usize);
        let count = of_waves.chain(of_defects).max().unwrap_or(FEWEST).next_power_of_two().clamp(FEWEST, MOST);
        let spacing = TAU / count as f64;
        // Coefficients of e^(i n φ) of the height and of its derivatives by the place between knots.
        let mut sums = [0, 1, 2].map(|_| vec![(0.0, 0.0); count]);
        for wave in waves() {
            let (sine, cosine) = sin_cos(wave.phase);
            let (real, imaginary) = (wave.amplitude * cosine, wave.amplitude * sine);
            let per_knot = f64::from(wave.order) * spacing;
            let square = per_knot * per_knot;
            let terms =
                [(real, imaginary), (-per_knot * imaginary, per_knot * real), (-square * real, -square * imaginary)];
            for (sum, term) in sums.iter_mut().zip(terms) {
                let place = &mut sum[wave.order as usize];
                *place = (place.0 + term.0, place.1 + term.1);
            }
        }
        let circle: Vec<(f64, f64)> = (0..count / 2).map(|knot| sin_cos(spacing * knot as f64)).collect();
        sums.iter_mut().for_each(|sum| sum_waves(sum, &circle));
        let [height, first, second] = sums;
        let mut knots: Vec<Knot> = (0..count)
            .map(|knot| Knot { height: height[knot].0, first: first[knot].0, second: second[knot].0 })
            .collect();
        for recess in recesses {
            add_recess(&mut knots, recess);
        }
        knots.push(knots[0]);
        Self { knots }
    }

    /// Height [m] at an azimuth [rad], and its slope [m/rad].
    #[inline(always)]
    pub(super) fn height_and_slope(&self, azimuth: f64) -> (f64, f64) {
        let (a, b, u) = self.knots_at(azimuth);
        let piece = Piece::between(a, b);
        (piece.height(u), piece.slope(u) * self.knots_per_radian())
    }

    /// Heights and slopes at several azimuths [rad].
    #[inline(always)]
    pub(super) fn under<const N: usize>(&self, azimuth: &Lanes<N>) -> Height<Lanes<N>> {
        let (ends, place) = self.knots_at_each(azimuth);
        let per_radian = self.knots_per_radian();
        let mut heights = Height::<Lanes<N>>::default();
        for lane in 0..N {
            let ((a, b), u) = (ends.at(lane), place[lane]);
            let piece = Piece::between(&a, &b);
            heights.put(lane, Height { height: piece.height(u), along: piece.slope(u) * per_radian, across: 0.0 });
        }
        heights
    }

    /// The knots before and after several azimuths [rad], and their places between them. Knots are fetched one by one, so that the
    /// arithmetic runs side by side.
    #[inline(always)]
    fn knots_at_each<const N: usize>(&self, azimuth: &Lanes<N>) -> (Ends<N>, Lanes<N>) {
        let (mut ends, mut place) = (Ends::<N>::default(), Lanes::<N>::default());
        for lane in 0..N {
            let (a, b, u) = self.knots_at(azimuth[lane]);
            ends.put(lane, (*a, *b));
            place[lane] = u;
        }
        (ends, place)
    }

    /// Heights with both derivatives at several azimuths [rad].
    #[inline(always)]
    pub(super) fn rises<const N: usize>(&self, azimuth: &Lanes<N>) -> Rise<Lanes<N>> {
        let (ends, place) = self.knots_at_each(azimuth);
        rises_between(&ends, &place, &Lanes::all(self.knots_per_radian()))
    }

    /// The same at one azimuth of each of several tables; 0 without a table.
    #[inline(always)]
    pub(super) fn rises_of<'a, const N: usize>(
        table: impl Fn(usize) -> Option<&'a Self>,
        azimuth: &Lanes<N>,
    ) -> Rise<Lanes<N>> {
        let (mut ends, mut place) = (Ends::<N>::default(), Lanes::<N>::default());
        let mut per_radian = Lanes::<N>::default();
        for lane in 0..N {
            if let Some(table) = table(lane) {
                let (a, b, u) = table.knots_at(azimuth[lane]);
                ends.put(lane, (*a, *b));
                place[lane] = u;
                per_radian[lane] = table.knots_per_radian();
            }
        }
        rises_between(&ends, &place, &per_radian)
    }

    #[inline(always)]
    fn knots_per_radian(&self) -> f64 {
        (self.knots.len() - 1) as f64 * (1.0 / TAU)
    }

    /// The knots before and after an azimuth [rad], and its place 0 … 1 between them.
    #[inline(always)]
    fn knots_at(&self, azimuth: f64) -> (&Knot, &Knot, f64) {
        let count = self.knots.len() - 1;
        let turns = azimuth * (1.0 / TAU);
        // The nearest whole number, subtracted in double precision: −½ … ½ turns remain.
        let part = turns - ((turns + ROUND) - ROUND);
        let part = if part < 0.0 { part + 1.0 } else { part };
        let place = part * count as f64;
        let knot = (place as usize).min(count - 1);
        (&self.knots[knot], &self.knots[knot + 1], place - knot as f64)
    }
}

/// Heights with both derivatives at places between knots.
#[inline(always)]
fn rises_between<const N: usize>(ends: &Ends<N>, place: &Lanes<N>, per_radian: &Lanes<N>) -> Rise<Lanes<N>> {
    let mut rises = Rise::<Lanes<N>>::default();
    for lane in 0..N {
        let ((a, b), u, per_radian) = (ends.at(lane), place[lane], per_radian[lane]);
        let piece = Piece::between(&a, &b);
        let one = Rise {
            height: piece.height(u),
            slope: piece.slope(u) * per_radian,
            curvature: piece.curvature(u) * (per_radian * per_radian),
        };
        rises.put(lane, one);
    }
    rises
}

/// Knots before and after several azimuths.
type Ends<const N: usize> = (Knot<Lanes<N>>, Knot<Lanes<N>>);

/// The polynomial between two knots, h + u h' + u² half + u³ (c₃ + u (c₄ + u c₅)).
struct Piece {
    height: f64,
    first: f64,
    half: f64,
    c3: f64,
    c4: f64,
    c5: f64,
    second: f64,
}

impl Piece {
    /// p(u) = h₀ + u h₀' + u² h₀''/2 + u³ (10 D − 4 E + F/2 − u (15 D − 7 E + F) + u² (6 D − 3 E + F/2))
    #[inline(always)]
    fn between(a: &Knot, b: &Knot) -> Self {
        let half = 0.5 * a.second;
        let value = b.height - (a.height + a.first + half);
        let first = b.first - (a.first + a.second);
        let second = b.second - a.second;
        Self {
            height: a.height,
            first: a.first,
            half,
            c3: 10.0 * value - 4.0 * first + 0.5 * second,
            c4: -15.0 * value + 7.0 * first - second,
            c5: 6.0 * value - 3.0 * first + 0.5 * second,
            second: a.second,
        }
    }

    #[inline(always)]
    fn height(&self, u: f64) -> f64 {
        self.height + u * (self.first + u * (self.half + u * (self.c3 + u * (self.c4 + u * self.c5))))
    }

    #[inline(always)]
    fn slope(&self, u: f64) -> f64 {
        self.first + u * (self.second + u * (3.0 * self.c3 + u * (4.0 * self.c4 + u * (5.0 * self.c5))))
    }

    #[inline(always)]
    fn curvature(&self, u: f64) -> f64 {
        self.second + u * (6.0 * self.c3 + u * (12.0 * self.c4 + u * (20.0 * self.c5)))
    }
}

/// Longest distance between knots on the path over a defect [m].
fn spacing_of(recess: &Recess) -> f64 {
    recess.contact.half_width / KNOTS_PER_HALF_WIDTH
}

/// A knot of a path with equidistant heights before, at and behind it. Central differences smooth the feet of the path, where its second
/// derivative has short peaks.
fn by_differences([before, at, behind]: [f64; 3]) -> Knot {
    Knot { height: at, first: 0.5 * (behind - before), second: behind - 2.0 * at + before }
}

/// Adds the path over a defect in the middle of the groove to the knots of one turn.
fn add_recess(knots: &mut [Knot], recess: &Recess) {
    let angle = TAU / knots.len() as f64;
    let spacing = recess.contact.radius * angle;
    for (index, knot) in knots.iter_mut().enumerate() {
        let x = recess.contact.radius * wrapped(angle * index as f64 - recess.defect.azimuth);
        if x.abs() <= recess.half_length() + spacing {
            let added = by_differences([-1.0, 0.0, 1.0].map(|by| recess.height(x + by * spacing, 0.0)));
            knot.height += added.height;
            knot.first += added.first;
            knot.second += added.second;
        }
    }
}

/// Falls of a ball in the middle of the groove [m] and their curvatures along the raceway [1/m], from the middle of a defect to its foot: the
/// path is even.
pub(crate) fn path_over(recess: &Recess) -> impl Iterator<Item = (f64, f64)> {
    let spacing = spacing_of(recess);
    let knots = (recess.half_length() / spacing).ceil() as usize;
    (0..=knots).map(move |knot| {
        let at = |by: f64| -recess.height((knot as f64 + by) * spacing, 0.0);
        let Knot { height, second, .. } = by_differences([-1.0, 0.0, 1.0].map(at));
        (height, second / (spacing * spacing))
    })
}

/// Path over a defect by the distance from its middle, as if the defect took the whole groove.
#[derive(Debug)]
pub(super) struct PathTable {
    /// Distance from the middle to the first knot [m].
    half_length: f64,
    per_spacing: f64,
    knots: Vec<Knot>,
}

impl PathTable {
    pub(super) fn new(recess: &Recess) -> Self {
        let half_length = recess.half_length();
        let parts = (2.0 * half_length / spacing_of(recess)).ceil();
        let spacing = 2.0 * half_length / parts;
        let at = |knot: f64| recess.fall(knot * spacing - half_length);
        let knots = (0..=parts as usize).map(|knot| knot as f64);
        let knots = knots.map(|knot| by_differences([knot - 1.0, knot, knot + 1.0].map(at))).collect();
        Self { half_length, per_spacing: 1.0 / spacing, knots }
    }

    /// Fall [m] at a distance from the middle [m], and its slope [-]; 0 beside the defect.
    pub(super) fn fall_and_slope(&self, x: f64) -> (f64, f64) {
        let place = (x + self.half_length) * self.per_spacing;
        let last = self.knots.len() - 2;
        if !(0.0..=(last + 1) as f64).contains(&place) {
            return (0.0, 0.0);
        }
        let knot = (place as usize).min(last);
        let (piece, u) = (Piece::between(&self.knots[knot], &self.knots[knot + 1]), place - knot as f64);
        (piece.height(u), piece.slope(u) * self.per_spacing)
    }
}

/// Replaces coefficients c_n by the sums Σ c_n e^(2πi n k/N), k = 0 … N − 1 (Cooley & Tukey, N a power of two). `circle`: sine and cosine
/// of the first N/2 angles. Own code, because libraries choose their order of operations by the processor.
fn sum_waves(values: &mut [(f64, f64)], circle: &[(f64, f64)]) {
    let count = values.len();
    let bits = count.trailing_zeros();
    for at in 0..count {
        let mirrored = at.reverse_bits() >> (usize::BITS - bits);
        if at < mirrored {
            values.swap(at, mirrored);
        }
    }
    let mut half = 1;
    while half < count {
        let stride = count / (2 * half);
        for block in values.chunks_exact_mut(2 * half) {
            let (even, odd) = block.split_at_mut(half);
            for (at, (a, b)) in even.iter_mut().zip(odd).enumerate() {
                let (sine, cosine) = circle[at * stride];
                let turned = (b.0 * cosine - b.1 * sine, b.0 * sine + b.1 * cosine);
                (*a, *b) = ((a.0 + turned.0, a.1 + turned.1), (a.0 - turned.0, a.1 - turned.1));
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::super::defects::{Defect, PassingContact, Shape};
    use super::*;

    fn waves() -> Vec<Wave> {
        let of = |(order, amplitude, phase)| Wave { order, amplitude, phase };
        [(1, 1e-6, 0.3), (7, 2e-8, -2.0), (256, 1e-8, 1.0)].map(of).to_vec()
    }

    /// Height and slope of the sum, also at knots and many turns away.
    #[test]
    fn the_table_is_the_sum_of_its_waves() {
        let table = HeightTable::new(&waves(), &[]);
        for step in 0..20_000 {
            let azimuth = -40.0 + 0.004_1 * f64::from(step);
            let (mut height, mut slope) = (0.0, 0.0);
            for Wave { order, amplitude, phase } in waves() {
                let (sine, cosine) = (f64::from(order) * azimuth + phase).sin_cos();
                height += amplitude * cosine;
                slope -= f64::from(order) * amplitude * sine;
            }
            let (found, rise) = table.height_and_slope(azimuth);
            assert!((found - height).abs() < 6e-6 * 1e-8, "{azimuth}: {found:e} {height:e}");
            assert!((rise - slope).abs() < 1e-4 * 256.0 * 1e-8, "{azimuth}: {rise:e} {slope:e}");
        }
    }

    /// Height, slope and curvature pass each knot without a step, the seam of the table included.
    #[test]
    fn two_derivatives_are_continuous() {
        let table = HeightTable::new(&waves(), &[]);
        let count = table.knots.len() - 1;
        for knot in [0, 1, 2, 17, count - 1, count] {
            let at = TAU * knot as f64 / count as f64;
            let by = 1e-6 * TAU / count as f64;
            let curvature = |from: f64| {
                let (a, b) = (table.height_and_slope(from).1, table.height_and_slope(from + by).1);
                (b - a) / by
            };
            let (before, after) = (curvature(at - 1.5 * by), curvature(at + 0.5 * by));
            // The slope of 1e-6 m/rad has sixteen digits; the step is 1e-9 rad.
            assert!((before - after).abs() < 1e-3 * 256.0 * 256.0 * 1e-8, "{knot}: {before:e} {after:e}");
        }
    }

    /// Heights between knots are those of the closed form. At the feet, where its second derivative has short peaks, they are smoothed.
    #[test]
    fn both_tables_hold_the_path_over_a_defect() {
        let contact = PassingContact {
            semi_major: 0.7e-3,
            half_width: 0.117e-3,
            approach: 8e-6,
            curvature: 209.6,
            radius: 23.5e-3,
            speed: 1.76,
        };
        for (length, depth) in [(0.05e-3, 1e-5), (0.5e-3, 2e-6), (2e-3, 1e-5), (10e-3, 1e-3)] {
            let shape = Shape::Rectangular;
            // Across the seam of the table.
            let defect = Defect { azimuth: 1e-3, length, width: None, depth, across: 0.0, shape };
            let recess = Recess { defect, contact };
            let (ring, path) = (HeightTable::new(&[], &[recess]), PathTable::new(&recess));
            let bound = 2e-3 * recess.deepest();
            for step in -3000..3000 {
                let x = 1.1 * recess.half_length() * f64::from(step) / 3000.0;
                let expected = recess.height(x, 0.0);
                let (height, slope) = ring.height_and_slope(1e-3 + x / contact.radius);
                let (fall, fall_slope) = path.fall_and_slope(x);
                assert!((height - expected).abs() < bound, "{length} {depth}, {x}: {height:e} {expected:e}");
                assert!((-fall - expected).abs() < bound, "{length} {depth}, {x}: {fall:e} {expected:e}");
                let largest = contact.curvature * (length + 2.0 * contact.half_width);
                assert!((slope / contact.radius + fall_slope).abs() < 0.01 * largest, "{slope} {fall_slope}");
            }
        }
    }
}
