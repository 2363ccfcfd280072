//! Seats of bearings by tolerance class (ISO 286-1), and the interference that they give with rings of the normal class (ISO 492).
//!
//! Sizes have the units of catalogues, mm, and deviations µm. Fundamental deviations of letters g to p do not depend on the intermediate steps.

use super::clearance::middle;

/// Classes of shafts.
pub const SHAFT_CLASSES: [&str; 14] =
    ["g6", "h5", "h6", "j5", "j6", "js5", "js6", "k5", "k6", "m5", "m6", "n5", "n6", "p6"];
/// Classes of housings.
pub const HOUSING_CLASSES: [&str; 15] =
    ["G7", "H6", "H7", "H8", "J6", "J7", "JS6", "JS7", "K6", "K7", "M6", "M7", "N6", "N7", "P7"];

/// Largest size of a class [mm].
pub const LARGEST: f64 = 400.0;

const STEPS: usize = 12;
/// Largest size of each step [mm].
const SIZES: [f64; STEPS] = [3.0, 6.0, 10.0, 18.0, 30.0, 50.0, 80.0, 120.0, 180.0, 250.0, 315.0, LARGEST];

/// Standard tolerances of grades 5 to 8.
const GRADES: [[f64; STEPS]; 4] = [
    [4.0, 5.0, 6.0, 8.0, 9.0, 11.0, 13.0, 15.0, 18.0, 20.0, 23.0, 25.0],
    [6.0, 8.0, 9.0, 11.0, 13.0, 16.0, 19.0, 22.0, 25.0, 29.0, 32.0, 36.0],
    [10.0, 12.0, 15.0, 18.0, 21.0, 25.0, 30.0, 35.0, 40.0, 46.0, 52.0, 57.0],
    [14.0, 18.0, 22.0, 27.0, 33.0, 39.0, 46.0, 54.0, 63.0, 72.0, 81.0, 89.0],
];

/// Distance of a shaft's nearer limit from the nominal size: below it for g, above it for the others. For k up to grade 7.
const G: [f64; STEPS] = [2.0, 4.0, 5.0, 6.0, 7.0, 9.0, 10.0, 12.0, 14.0, 15.0, 17.0, 18.0];
const K: [f64; STEPS] = [0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
const M: [f64; STEPS] = [2.0, 4.0, 6.0, 7.0, 8.0, 9.0, 11.0, 13.0, 15.0, 17.0, 20.0, 21.0];
const N: [f64; STEPS] = [4.0, 8.0, 10.0, 12.0, 15.0, 17.0, 20.0, 23.0, 27.0, 31.0, 34.0, 37.0];
const P: [f64; STEPS] = [6.0, 12.0, 15.0, 18.0, 22.0, 26.0, 32.0, 37.0, 43.0, 50.0, 56.0, 62.0];
/// Lower limit of a shaft of j5 and j6 below the nominal size.
const J_SHAFT: [f64; STEPS] = [2.0, 2.0, 2.0, 3.0, 4.0, 5.0, 7.0, 9.0, 11.0, 13.0, 16.0, 18.0];
/// Upper limits of holes of J6 and J7.
const J_HOLE: [[f64; STEPS]; 2] = [
    [2.0, 5.0, 5.0, 6.0, 8.0, 10.0, 13.0, 16.0, 18.0, 22.0, 25.0, 29.0],
    [4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 18.0, 22.0, 26.0, 30.0, 36.0, 39.0],
];

/// Largest size [mm] and tolerance of a ring of the normal class, which lies below the nominal size.
const BORE: [[f64; 2]; 9] = [
    [18.0, 8.0],
    [30.0, 10.0],
    [50.0, 12.0],
    [80.0, 15.0],
    [120.0, 20.0],
    [180.0, 25.0],
    [250.0, 30.0],
    [315.0, 35.0],
    [LARGEST, 40.0],
];
const OUTSIDE: [[f64; 2]; 10] = [
    [18.0, 8.0],
    [30.0, 9.0],
    [50.0, 11.0],
    [80.0, 13.0],
    [120.0, 15.0],
    [150.0, 18.0],
    [180.0, 25.0],
    [250.0, 30.0],
    [315.0, 35.0],
    [LARGEST, 40.0],
];

/// Limits of the seat of a class and of the ring on it, lower and upper [µm] from the nominal size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seat {
    pub class: &'static str,
    pub limits_um: [f64; 2],
    pub ring_limits_um: [f64; 2],
    /// Interference between the middles of both; negative: a loose fit.
    pub interference_um: f64,
}

impl Seat {
    /// The shaft of a class in a bore [mm]; `None` for unknown classes and sizes.
    pub fn shaft(class: &str, bore: f64) -> Option<Self> {
        let class = SHAFT_CLASSES.into_iter().find(|known| *known == class)?;
        let (limits_um, ring_limits_um) = (shaft_limits(class, step(bore)?)?, ring_limits(&BORE, bore)?);
        Some(Self { class, limits_um, ring_limits_um, interference_um: middle(limits_um) - middle(ring_limits_um) })
    }

    /// The housing of a class around an outer diameter [mm]; `None` for unknown classes and sizes.
    pub fn housing(class: &str, outside: f64) -> Option<Self> {
        let class = HOUSING_CLASSES.into_iter().find(|known| *known == class)?;
        let (limits_um, ring_limits_um) = (hole_limits(class, step(outside)?)?, ring_limits(&OUTSIDE, outside)?);
        Some(Self { class, limits_um, ring_limits_um, interference_um: middle(ring_limits_um) - middle(limits_um) })
    }
}

/// Place of a size among the steps.
fn step(size: f64) -> Option<usize> {
    SIZES.iter().position(|largest| size <= *largest).filter(|_| size > 0.0)
}

fn ring_limits(tolerances: &[[f64; 2]], size: f64) -> Option<[f64; 2]> {
    tolerances.iter().find(|[largest, _]| size <= *largest).map(|[_, tolerance]| [-tolerance, 0.0])
}

/// Letter of a class and number of its grade.
fn parts(class: &str) -> Option<(&str, usize)> {
    let letter = class.trim_end_matches(|digit: char| digit.is_ascii_digit());
    Some((letter, class[letter.len()..].parse().ok()?))
}

fn width(grade: usize, step: usize) -> Option<f64> {
    GRADES.get(grade.checked_sub(5)?)?.get(step).copied()
}

fn shaft_limits(class: &str, step: usize) -> Option<[f64; 2]> {
    let (letter, grade) = parts(class)?;
    let width = width(grade, step)?;
    let lower = match letter {
        "g" => -G[step] - width,
        "h" => -width,
        "j" => -J_SHAFT[step],
        "js" => -0.5 * width,
        "k" => K[step],
        "m" => M[step],
        "n" => N[step],
        "p" => P[step],
        _ => return None,
    };
    Some([lower, lower + width])
}

/// A hole of K to P has the limits of the shaft mirrored, raised by the difference to the next finer grade.
fn hole_limits(class: &str, step: usize) -> Option<[f64; 2]> {
    let (letter, grade) = parts(class)?;
    let width = width(grade, step)?;
    let raised = |by: f64| Some(finer_difference(grade, step)? - by);
    let upper = match letter {
        "G" => G[step] + width,
        "H" => width,
        "J" => J_HOLE.get(grade.checked_sub(6)?)?[step],
        "JS" => 0.5 * width,
        "K" => raised(K[step])?,
        // The standard's table differs from its own rule.
        "M" if grade == 6 && SIZES[step] == 315.0 => -9.0,
        "M" => raised(M[step])?,
        "N" => raised(N[step])?,
        "P" => raised(P[step])?,
        _ => return None,
    };
    Some([upper - width, upper])
}

/// Difference between a grade and the next finer one; not for sizes up to 3 mm.
fn finer_difference(grade: usize, step: usize) -> Option<f64> {
    if step == 0 {
        return Some(0.0);
    }
    Some(width(grade, step)? - width(grade.checked_sub(1)?, step)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shaft(class: &str, bore: f64) -> [f64; 2] {
        Seat::shaft(class, bore).unwrap().limits_um
    }

    fn housing(class: &str, outside: f64) -> [f64; 2] {
        Seat::housing(class, outside).unwrap().limits_um
    }

    /// Values that makers of bearings print.
    #[test]
    fn limits_of_shafts_are_those_of_the_standard() {
        let of = |size: f64, classes: [&str; 5]| classes.map(|class| shaft(class, size));
        let expected = [[-20.0, -7.0], [-13.0, 0.0], [-4.0, 5.0], [-4.0, 9.0], [2.0, 11.0]];
        assert_eq!(of(25.0, ["g6", "h6", "j5", "j6", "k5"]), expected);
        let expected = [[2.0, 13.0], [2.0, 18.0], [9.0, 20.0], [9.0, 25.0], [17.0, 28.0]];
        assert_eq!(of(50.0, ["k5", "k6", "m5", "m6", "n5"]), expected);
        let expected = [[-13.0, 0.0], [-6.5, 6.5], [-9.5, 9.5], [20.0, 39.0], [32.0, 51.0]];
        assert_eq!(of(50.1, ["h5", "js5", "js6", "n6", "p6"]), expected);
    }

    #[test]
    fn limits_of_housings_are_those_of_the_standard() {
        let of = |size: f64, classes: [&str; 5]| classes.map(|class| housing(class, size));
        let expected = [[10.0, 40.0], [0.0, 19.0], [0.0, 30.0], [0.0, 46.0], [-6.0, 13.0]];
        assert_eq!(of(52.0, ["G7", "H6", "H7", "H8", "J6"]), expected);
        let expected = [[-12.0, 18.0], [-15.0, 15.0], [-15.0, 4.0], [-21.0, 9.0], [-24.0, -5.0]];
        assert_eq!(of(52.0, ["J7", "JS7", "K6", "K7", "M6"]), expected);
        let expected = [[-30.0, 0.0], [-33.0, -14.0], [-39.0, -9.0], [-51.0, -21.0], [-9.5, 9.5]];
        assert_eq!(of(52.0, ["M7", "N6", "N7", "P7", "JS6"]), expected);
        let expected = [[-6.0, 0.0], [-8.0, -2.0], [-14.0, -4.0], [-16.0, -6.0], [-6.0, 4.0]];
        assert_eq!(of(3.0, ["K6", "M6", "N7", "P7", "J7"]), expected);
        let expected = [[-27.0, 5.0], [-41.0, -9.0], [-57.0, -25.0], [-66.0, -14.0], [-88.0, -36.0]];
        assert_eq!(of(300.0, ["K6", "M6", "N6", "N7", "P7"]), expected);
    }

    /// Every class exists for every step. Its width is that of its grade, h and H touch the nominal size, and JS is symmetric.
    #[test]
    fn classes_are_consistent() {
        for (step, largest) in SIZES.into_iter().enumerate() {
            let of_shafts = SHAFT_CLASSES.map(|class| (class, shaft(class, largest)));
            let of_housings = HOUSING_CLASSES.map(|class| (class, housing(class, largest)));
            for (class, [lower, upper]) in of_shafts.into_iter().chain(of_housings) {
                let (letter, grade) = parts(class).unwrap();
                assert_eq!(upper - lower, width(grade, step).unwrap(), "{class} {largest}");
                match letter {
                    "h" => assert_eq!(upper, 0.0),
                    "H" => assert_eq!(lower, 0.0),
                    "js" | "JS" => assert_eq!(upper, -lower),
                    _ => {}
                }
            }
        }
    }

    /// Grades follow 7, 10, 16 and 25 tolerance factors, m is the difference of grades 7 and 6 (ISO 286-1). The first step is a convention.
    #[test]
    fn tables_follow_the_formulas_of_the_standard() {
        for step in 1..STEPS {
            let mean = (SIZES[step - 1] * SIZES[step]).sqrt();
            let factor = 0.45 * mean.cbrt() + 0.001 * mean;
            for (grade, factors) in GRADES.iter().zip([7.0, 10.0, 16.0, 25.0]) {
                assert!((grade[step] / (factors * factor) - 1.0).abs() < 0.1, "{mean} {factors}");
            }
            assert_eq!(M[step], GRADES[2][step] - GRADES[1][step]);
            for (table, formula) in [(G, 2.5 * mean.powf(0.34)), (N, 5.0 * mean.powf(0.34)), (K, 0.6 * mean.cbrt())] {
                assert!((table[step] - formula).abs() < 1.0, "{mean}: {} {formula}", table[step]);
            }
            assert!((0.0..=6.0).contains(&(P[step] - GRADES[2][step])));
        }
    }

    /// k5 on 25 mm: 6.5 µm above the nominal size, the bore 5 µm below. H7 around 52 mm: 15 µm above, the ring 6.5 µm below.
    #[test]
    fn interference_lies_between_the_middles() {
        let interference = |seat: Option<Seat>| seat.map(|seat| seat.interference_um);
        assert_eq!(interference(Seat::shaft("k5", 25.0)), Some(11.5));
        assert_eq!(interference(Seat::housing("H7", 52.0)), Some(-21.5));
        assert_eq!(interference(Seat::housing("P7", 52.0)), Some(29.5));
        assert_eq!(interference(Seat::shaft("g6", 400.0)), Some(-16.0));
    }

    #[test]
    fn other_classes_and_sizes_have_no_seat() {
        assert!(["K5", "k4", "", "k", "5", "é5"].into_iter().all(|class| Seat::shaft(class, 25.0).is_none()));
        assert!(["h7", "H5", "P6"].into_iter().all(|class| Seat::housing(class, 52.0).is_none()));
        assert!([0.0, -1.0, 400.1, f64::NAN].into_iter().all(|size| Seat::shaft("k5", size).is_none()));
    }
}
