//! Local defects of raceways: their outline, and the path of a ball over them.
//!
//! The path is a closed form for what an elastic half-space shows. A ball stays on the edges of a defect as long as it does not reach the
//! floor, and its contact reaches over an edge by half its width. Over the whole groove the form is within 5 % of half-space
//! calculations at the middle of defects longer than 1.5 contact widths, within 22 % for shorter ones and within 30 % on the flanks.

use std::f64::consts::{PI, SQRT_2, TAU};

use crate::numerics::angle::{sin_cos, small_angle};
use crate::numerics::exponential::{ROUND, power};
use crate::numerics::lanes::{larger, smaller};

/// Largest number of defects of one raceway.
pub const MOST_DEFECTS: usize = 16;

/// Form of the floor along the raceway.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// The full depth from edge to edge.
    Rectangular,
    /// depth · cos(π x/length).
    HalfSine,
}

/// A recess of a raceway with a rectangular outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defect {
    /// Azimuth of its middle on the ring [rad].
    pub azimuth: f64,
    /// Length along the raceway [m].
    pub length: f64,
    /// Width across the groove [m]; `None`: the whole groove.
    pub width: Option<f64>,
    /// [m]
    pub depth: f64,
    /// Place of its middle across the groove, from the bottom towards +X [m].
    pub across: f64,
    pub shape: Shape,
}

impl Defect {
    /// Returns true where the outlines of two defects on a raceway of some radius [m] overlap.
    pub(super) fn overlaps(&self, other: &Self, radius: f64) -> bool {
        let apart = radius * wrapped(self.azimuth - other.azimuth).abs();
        let aside = (self.across - other.across).abs();
        let beside = self.width.zip(other.width).is_some_and(|(one, two)| aside >= 0.5 * (one + two));
        apart < 0.5 * (self.length + other.length) && !beside
    }
}

/// An angle less whole turns, −π … π [rad].
pub(super) fn wrapped(angle: f64) -> f64 {
    let turns = angle * (1.0 / TAU);
    TAU * (turns - ((turns + ROUND) - ROUND))
}

/// The contact that passes a defect, fixed for a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassingContact {
    /// Half width across the groove, a [m].
    pub semi_major: f64,
    /// Half width along rolling, b [m].
    pub half_width: f64,
    /// Approach under load, δ₀ [m].
    pub approach: f64,
    /// Relative curvature along rolling, ρ_x [1/m].
    pub curvature: f64,
    /// Radius of the groove's bottom, R [m].
    pub radius: f64,
    /// Speed of the contact along the raceway at the largest speed, v_c [m/s].
    pub speed: f64,
}

/// Distance over which a contact reaches beyond an edge, over b [-].
const EDGE_REACH: f64 = 0.4;
/// Distance over which the path bends at an edge, over b [-].
const EDGE_ROUNDING: f64 = 1.2;
/// Half width of the triangle that averages the floor, over b [-].
const FLOOR_AVERAGE: f64 = SQRT_2;
/// Deepest floor that matters, over the drop between the edges [-].
const DEEPEST_FLOOR: f64 = 3.0;
/// Distance from an edge at which a ball no longer feels the defect, over b [-]; the path itself ends at 1.6.
const FELT: f64 = 2.0;
/// Share of the half width b that a ball may roll in one step within a defect [-]. Methods of order 2 then err by 0.02 to 0.1 dB.
pub const STEP_SHARE: f64 = 0.25;
/// Exponent of the approach over a slot that is narrower than the contact [-].
const SLOT_EXPONENT: f64 = 1.65;
/// Half width of the roundings across the groove, over a [-].
const ROUNDED: f64 = 0.05;

/// A defect under the contact that passes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recess {
    pub defect: Defect,
    pub contact: PassingContact,
}

impl Recess {
    /// Drop of a ball that rests on both edges, ρ_x l²/8 [m].
    pub fn edge_drop(&self) -> f64 {
        0.125 * self.contact.curvature * self.defect.length * self.defect.length
    }

    /// Returns true where the ball reaches the floor.
    pub fn is_bottomed(&self) -> bool {
        self.edge_drop() > self.defect.depth && self.ground() == self.defect.depth
    }

    /// Returns true where a ball comes to roll between the edges, on the floor or on the ground beside a narrow defect.
    fn is_carried_between_edges(&self) -> bool {
        self.edge_drop() > self.ground()
    }

    /// Fall at which something else than the edges carries the ball: the depth, or less where the defect is so narrow that the ground beside
    /// it does [m].
    fn ground(&self) -> f64 {
        self.across().map_or(f64::INFINITY, |across| across.largest_fall(0.0)).min(self.defect.depth)
    }

    /// Distance from an edge at which the ball reaches this ground, √(2 depth/ρ_x) [m].
    pub fn floor_distance(&self) -> f64 {
        (2.0 * self.ground() / self.contact.curvature).sqrt()
    }

    /// Deepest fall of the ball on its path [m].
    pub fn deepest(&self) -> f64 {
        -self.height(0.0, 0.0)
    }

    /// Time between the middle and the two other impacts [s]: the ball meets and leaves the floor, or the ground next to a narrow defect.
    /// 0 if it stays on the edges, with one impact in the middle. Infinite or not a number at rest.
    pub fn impact_beside_middle(&self) -> f64 {
        let PassingContact { half_width, speed, .. } = self.contact;
        match self.is_carried_between_edges() {
            true => larger(0.5 * self.defect.length + EDGE_REACH * half_width - self.floor_distance(), 0.0) / speed,
            false => 0.0,
        }
    }

    /// Time from the entry, where the middle of the contact passes the first edge, to the last impact [s]; infinite at rest.
    pub fn entry_to_impact(&self) -> f64 {
        0.5 * self.defect.length / self.contact.speed + self.impact_beside_middle()
    }

    /// Longest step that resolves the path at the largest speed [s]; infinite at rest.
    pub fn longest_step(&self) -> f64 {
        self.rolled_in_a_step() / self.contact.speed
    }

    /// Length from which a defect leaves no ideal part of its raceway: the path on it ends two half widths of the contact from the edges [m].
    pub fn longest_length(&self) -> f64 {
        TAU * self.contact.radius - 2.0 * FELT * self.contact.half_width
    }

    /// Returns true where the path has no ideal part.
    pub fn leaves_no_raceway(&self) -> bool {
        self.defect.length >= self.longest_length()
    }

    /// Width over that of the contact [-]; `None`: the defect takes the whole groove.
    pub fn width_over_contact(&self) -> Option<f64> {
        self.defect.width.map(|width| width / (2.0 * self.contact.semi_major))
    }

    /// Centripetal acceleration of the path at an edge, ρ_x v_c² [m/s²]: a ball follows the edge only while it is pressed with more than
    /// its mass times this.
    pub fn edge_acceleration(&self) -> f64 {
        self.contact.curvature * self.contact.speed * self.contact.speed
    }

    /// Distance that a ball may roll in one step within the defect [m].
    fn rolled_in_a_step(&self) -> f64 {
        STEP_SHARE * self.contact.half_width
    }

    /// The places on the ring at which steps are limited.
    pub(crate) fn reach(&self) -> DefectReach {
        let per_radius = 1.0 / self.contact.radius;
        DefectReach {
            azimuth: self.defect.azimuth,
            half_angle: self.half_length() * per_radius,
            step: self.rolled_in_a_step() * per_radius,
        }
    }

    /// The places of the edges on the ring.
    pub(crate) fn edges(&self) -> DefectEdges {
        DefectEdges { azimuth: self.defect.azimuth, half_angle: 0.5 * self.defect.length / self.contact.radius }
    }

    /// Azimuths of the first edge, the middle and the last edge on the ring [rad].
    pub(crate) fn azimuths(&self) -> [f64; 3] {
        let DefectEdges { azimuth, half_angle } = self.edges();
        [azimuth - half_angle, azimuth, azimuth + half_angle]
    }

    /// Distance from the middle within which the path differs from the ideal one [m].
    pub(super) fn half_length(&self) -> f64 {
        0.5 * self.defect.length + FELT * self.contact.half_width
    }

    /// Height of the path at distance x from the middle along the raceway and at a place across the groove [m].
    pub fn height(&self, x: f64, place: f64) -> f64 {
        let fall = self.fall(x);
        match self.across() {
            None => -fall,
            Some(across) => -across.limited(fall, place).0,
        }
    }

    /// The defect across the groove; `None`: it takes the whole groove.
    pub(super) fn across(&self) -> Option<Across> {
        let PassingContact { semi_major, approach, .. } = self.contact;
        let middle = self.defect.across;
        self.defect.width.map(|width| Across { half_width: 0.5 * width, middle, semi_major, approach })
    }

    /// Fall of a ball over the defect as if it took the whole groove, at distance x from the middle [m].
    pub(super) fn fall(&self, x: f64) -> f64 {
        if x.abs() >= self.half_length() {
            return 0.0;
        }
        let PassingContact { half_width: b, curvature, .. } = self.contact;
        let half = 0.5 * self.defect.length;
        let drop = |u: f64| {
            let bent = bent(u + EDGE_REACH * b, EDGE_ROUNDING * b);
            0.5 * curvature * bent * bent
        };
        let edges = smooth_minimum(drop(half + x), drop(half - x), 0.1 + 0.55 * self.defect.length / b);
        smooth_minimum(edges, self.floor(x), 3.0)
    }

    /// Depth of the floor, averaged with a triangle of half width √2 b [m].
    fn floor(&self, x: f64) -> f64 {
        let width = FLOOR_AVERAGE * self.contact.half_width;
        let integral = |x: f64| self.twice_integrated_floor(x.abs());
        let half = 0.5 * self.defect.length;
        let deepest = DEEPEST_FLOOR * self.edge_drop();
        if x.abs() - width >= half {
            return 0.0;
        }
        if self.defect.shape == Shape::Rectangular && x.abs() + width <= half {
            // The difference of the integrals would leave their rounding.
            return smaller(self.defect.depth, deepest);
        }
        larger(integral(x + width) - 2.0 * integral(x) + integral(x - width), 0.0) / (width * width)
    }

    /// ∫∫ of the floor's depth, which is no deeper than 3 H, from the middle to a distance u ≥ 0 [m³].
    fn twice_integrated_floor(&self, u: f64) -> f64 {
        let Defect { length, depth, shape, .. } = self.defect;
        let (half, deepest) = (0.5 * length, DEEPEST_FLOOR * self.edge_drop());
        let plain = smaller(depth, deepest);
        let wave = PI / length;
        // Distance up to which the floor is flat.
        let flat = match shape {
            Shape::Rectangular => half,
            // arccos of c by its half angle.
            Shape::HalfSine if depth > deepest => {
                let cosine = deepest / depth;
                2.0 * small_angle((1.0 + cosine).sqrt(), (1.0 - cosine).sqrt()) / wave
            }
            Shape::HalfSine => 0.0,
        };
        let (slope, value) = (plain * flat, 0.5 * plain * flat * flat);
        if u <= flat {
            return 0.5 * plain * u * u;
        }
        let (sine, cosine) = sin_cos(wave * flat);
        // Slope and value at a distance between the flat and the edge.
        let at = |u: f64| {
            if flat == half {
                return (slope, value);
            }
            let (s, c) = sin_cos(wave * u);
            let beyond = slope - depth / wave * sine;
            (beyond + depth / wave * s, value + beyond * (u - flat) + depth / (wave * wave) * (cosine - c))
        };
        if u <= half {
            return at(u).1;
        }
        let (slope, value) = at(half);
        value + slope * (u - half)
    }
}

/// 0 below −w, u above w, a parabola between.
fn bent(u: f64, w: f64) -> f64 {
    if u <= -w {
        0.0
    } else if u < w {
        (u + w) * (u + w) / (4.0 * w)
    } else {
        u
    }
}

/// lo (1 + (lo/hi)^p)^(−1/p), a smooth minimum of two numbers that are not negative.
fn smooth_minimum(one: f64, other: f64, p: f64) -> f64 {
    let (low, high) = if one < other { (one, other) } else { (other, one) };
    if low <= 0.0 {
        return 0.0;
    }
    low * power(1.0 + power(low / high, p), -1.0 / p)
}

/// Extent of a defect across the groove, and the contact that it carries beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Across {
    half_width: f64,
    middle: f64,
    semi_major: f64,
    approach: f64,
}

impl Across {
    /// Fall at which the ground beside the defect carries a ball at a place across the groove, whatever the depth: W/S [m].
    fn largest_fall(&self, place: f64) -> f64 {
        // min₄(S y, W) is W for a huge y and rises by S from y = 0 on.
        let (carried, ..) = self.limited(1.0, place);
        let (_, share, _) = self.limited(f64::MIN_POSITIVE, place);
        if share > 0.0 { carried / share } else { 0.0 }
    }

    /// The fall of a ball that is limited by the ground beside the defect, min₄(S y, W) [m], and its slopes by y [-] and by the place
    /// across the groove [m/m].
    pub(super) fn limited(&self, fall: f64, place: f64) -> (f64, f64, f64) {
        let a = self.semi_major;
        let aside = place - self.middle;
        let (one, by_one) = clipped((self.half_width - aside) / a);
        let (two, by_two) = clipped((self.half_width + aside) / a);
        let (share, by_place) = (0.5 * (one + two), 0.5 * (by_two - by_one) / a);
        // Twice the smaller distance to an edge, where that exceeds the contact.
        let (distance, by_aside) = rounded_size(aside / a);
        let over = self.half_width / a - distance - 1.0;
        let (wider, by_over) = ramp(over);
        let relative = larger(share + wider, 0.0);
        let relative_by_place = by_place - by_over * by_aside / a;
        let least = self.approach * power(relative, SLOT_EXPONENT);
        let least_by_place = SLOT_EXPONENT * least / larger(relative, f64::MIN_POSITIVE) * relative_by_place;
        let (limited, by_share, by_least) = minimum_of_fourth_power(larger(share * fall, 0.0), least);
        (limited, by_share * share, by_share * fall * by_place + by_least * least_by_place)
    }
}

/// t clipped to ±1 with rounded corners, and its slope.
fn clipped(t: f64) -> (f64, f64) {
    let (beyond, slope) = ramp(t - 1.0);
    let (below, slope_below) = ramp(-t - 1.0);
    (t - beyond + below, 1.0 - slope - slope_below)
}

/// 0 below 0 and t above, with a rounded corner, and its slope.
fn ramp(t: f64) -> (f64, f64) {
    if t <= -ROUNDED {
        (0.0, 0.0)
    } else if t < ROUNDED {
        ((t + ROUNDED) * (t + ROUNDED) / (4.0 * ROUNDED), 0.5 * (t + ROUNDED) / ROUNDED)
    } else {
        (t, 1.0)
    }
}

/// |t| with a rounded corner, and its slope.
fn rounded_size(t: f64) -> (f64, f64) {
    if t.abs() < ROUNDED { (0.5 * (t * t / ROUNDED + ROUNDED), t / ROUNDED) } else { (t.abs(), 1.0_f64.copysign(t)) }
}

/// The smooth minimum of two numbers with p = 4, and its slopes by both. Neither is negative.
fn minimum_of_fourth_power(one: f64, other: f64) -> (f64, f64, f64) {
    if one <= 0.0 || other <= 0.0 {
        return (0.0, if other > 0.0 { 1.0 } else { 0.0 }, if one > 0.0 { 1.0 } else { 0.0 });
    }
    // (1 + r⁴)^(−5/4)
    let slope = |ratio: f64| {
        let sum = 1.0 + ratio * ratio * ratio * ratio;
        1.0 / (sum * sum.sqrt().sqrt())
    };
    let ratio = if one < other { one / other } else { other / one };
    let sum = 1.0 + ratio * ratio * ratio * ratio;
    (smaller(one, other) / sum.sqrt().sqrt(), slope(one / other), slope(other / one))
}

/// Places of the edges of a defect on its ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DefectEdges {
    /// Azimuth of its middle on the ring [rad].
    azimuth: f64,
    /// Angle from the middle to an edge [rad].
    pub half_angle: f64,
}

impl DefectEdges {
    /// Angle of an azimuth on the ring from the middle, −π … π [rad].
    pub(crate) fn angle_from_middle(&self, azimuth: f64) -> f64 {
        wrapped(azimuth - self.azimuth)
    }
}

/// A part of a ring, or of a ball, within which steps are limited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DefectReach {
    /// Azimuth of its middle on the ring [rad].
    azimuth: f64,
    half_angle: f64,
    /// Angle that a ball may roll in one step [rad].
    step: f64,
}

impl DefectReach {
    /// Angle that a ball at an azimuth on the ring may roll in one step [rad]: up to the entry, or a share of its contact.
    pub(crate) fn largest_angle(&self, azimuth: f64) -> f64 {
        self.largest_angle_from(wrapped(azimuth - self.azimuth).abs())
    }

    /// Angle that a ball may roll in one step at an angle from the defect's middle [rad].
    pub(crate) fn largest_angle_from(&self, angle: f64) -> f64 {
        larger(angle - self.half_angle, self.step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outer raceway of a 6205 under 243 N at 1797 r/min.
    const OUTER: PassingContact = PassingContact {
        semi_major: 0.7e-3,
        half_width: 0.116_8e-3,
        approach: 8e-6,
        curvature: 209.6,
        radius: 23.55e-3,
        speed: 1.760_7,
    };

    fn recess(length: f64, depth: f64) -> Recess {
        let defect = Defect { azimuth: 0.0, length, width: None, depth, across: 0.0, shape: Shape::Rectangular };
        Recess { defect, contact: OUTER }
    }

    #[test]
    fn a_shallow_defect_is_felt_to_its_floor_and_a_deep_one_to_the_drop_between_its_edges() {
        let shallow = recess(2e-3, 1e-6);
        assert!((shallow.deepest() / 1e-6 - 1.0).abs() < 1e-3 && shallow.is_bottomed(), "{}", shallow.deepest());
        for length in [0.5e-3, 1e-3, 2e-3] {
            let deep = recess(length, 1e-3);
            // The reach of the contact over the edges: (l + 0.8 b)² in place of l².
            let ratio = deep.deepest() / deep.edge_drop();
            assert!((1.0..1.25).contains(&ratio), "{length}: {ratio}");
        }
        assert_eq!(recess(1e-3, 0.0).deepest(), 0.0);
    }

    #[test]
    fn the_path_falls_on_one_side_and_is_even() {
        for shape in [Shape::Rectangular, Shape::HalfSine] {
            for (length, depth) in [(0.05e-3, 1e-3), (0.3e-3, 2e-6), (1e-3, 10e-6), (3e-3, 50e-6), (20e-3, 1e-3)] {
                let mut recess = recess(length, depth);
                recess.defect.shape = shape;
                let end = recess.half_length();
                let mut before = 0.0;
                for step in 0..=2000 {
                    let x = -end + end * f64::from(step) / 2000.0;
                    let fall = recess.fall(x);
                    assert!(
                        fall >= before * (1.0 - 1e-9) && fall.is_finite(),
                        "{shape:?} {length} {depth}: {fall} at {x}"
                    );
                    assert!((recess.fall(-x) - fall).abs() <= 1e-9 * depth);
                    before = fall;
                }
                assert!(before <= depth * (1.0 + 1e-9) && recess.fall(end) == 0.0);
            }
        }
    }

    /// The floor's average is depth · (sin(q)/q)² of the triangle for a half sine far from its ends.
    #[test]
    fn a_wide_half_sine_keeps_its_depth_in_the_middle() {
        let mut recess = recess(10e-3, 1e-6);
        recess.defect.shape = Shape::HalfSine;
        let q = 0.5 * PI / 10e-3 * FLOOR_AVERAGE * OUTER.half_width;
        let expected = 1e-6 * (q.sin() / q).powi(2);
        assert!((recess.floor(0.0) / expected - 1.0).abs() < 1e-6, "{} {expected}", recess.floor(0.0));
    }

    /// A narrow defect has the slopes of its fall. There is no fall beside it, and the whole fall in a wide defect.
    #[test]
    fn a_narrow_defect_has_the_slopes_of_its_fall() {
        for width in [0.2e-3, 0.5e-3, 1.4e-3, 3e-3] {
            let across = Across { half_width: 0.5 * width, middle: 0.1e-3, semi_major: 0.7e-3, approach: 8e-6 };
            for step in -300..300 {
                let place = 1e-5 * f64::from(step) + 0.37e-6;
                let (fall, by_fall, by_place) = across.limited(6e-6, place);
                let by = |a: (f64, f64, f64), b: (f64, f64, f64), h: f64| (b.0 - a.0) / (2.0 * h);
                let fall_slope = by(across.limited(6e-6 - 1e-9, place), across.limited(6e-6 + 1e-9, place), 1e-9);
                let slope = by(across.limited(6e-6, place - 1e-8), across.limited(6e-6, place + 1e-8), 1e-8);
                assert!((fall_slope - by_fall).abs() < 1e-6, "{width} {place}: {fall_slope} {by_fall}");
                assert!((slope - by_place).abs() < 1e-6, "{width} {place}: {slope} {by_place}");
                assert!((0.0..=6e-6).contains(&fall));
            }
            assert_eq!(across.limited(6e-6, 4e-3), (0.0, 0.0, 0.0));
        }
        let wide = Across { half_width: 50e-3, middle: 0.0, semi_major: 0.7e-3, approach: 8e-6 };
        let (fall, by_fall, by_place) = wide.limited(6e-6, 0.2e-3);
        assert!((fall / 6e-6 - 1.0).abs() < 1e-6 && (by_fall - 1.0).abs() < 1e-6 && by_place.abs() < 1e-9);
    }

    /// Contact of k = 6.3: deep slots in its middle of 0.15, 0.3 and 0.6 of its width give 0.044, 0.137 and 0.430 of the approach. A slot under
    /// one half of the contact gives 0.32 of it.
    #[test]
    fn slots_narrower_than_the_contact_carry_the_ball() {
        let a = OUTER.semi_major;
        let deep = |half_width: f64, middle: f64| {
            Across { half_width, middle, semi_major: a, approach: 1.0 }.limited(1e3, 0.0).0
        };
        for (share, expected) in [(0.15, 0.044), (0.3, 0.137), (0.6, 0.430)] {
            assert!((deep(share * a, 0.0) / expected - 1.0).abs() < 0.02, "{share}: {}", deep(share * a, 0.0));
        }
        assert!((deep(5.0 * a, 5.0 * a) / 0.32 - 1.0).abs() < 0.02, "{}", deep(5.0 * a, 5.0 * a));
    }

    #[test]
    fn outlines_overlap_along_and_across() {
        let one = recess(1e-3, 1e-6).defect;
        let at = |azimuth: f64, across: f64, width: Option<f64>| Defect { azimuth, across, width, ..one };
        let radius = OUTER.radius;
        let pair = |a: Defect, b: Defect| a.overlaps(&b, radius);
        assert!(pair(one, at(0.9e-3 / radius, 0.0, None)) && !pair(one, at(1.1e-3 / radius, 0.0, None)));
        assert!(pair(one, at(TAU - 0.9e-3 / radius, 0.0, None)), "across the seam");
        let narrow = |across| at(0.0, across, Some(0.4e-3));
        assert!(pair(narrow(0.0), narrow(0.3e-3)) && !pair(narrow(0.0), narrow(0.5e-3)));
        assert!(pair(one, narrow(3e-3)), "the whole groove");
    }
}
