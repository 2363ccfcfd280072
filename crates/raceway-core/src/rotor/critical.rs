//! Critical speeds: those that equal a damped natural frequency.

use nalgebra::{Complex, DMatrix, DVector, SymmetricEigen};

use super::campbell::Course;
use super::system::System;
use crate::numerics::quadratic_eigen::Oscillation;

/// Distance of two critical speeds, relative to them, at which their shapes are compared [-].
const SAME_SPEED: f64 = 1e-7;
/// Difference of frequency and speed at which a critical speed is found, relative to it [-]: rounding of frequencies of a soft shaft on stiff
/// supports is 1e-10.
const CONVERGED: f64 = 1e-9;
/// Largest number of steps of the secant method.
const MOST_STEPS: usize = 30;

/// Critical speeds up to `highest`, rising, each with its oscillation.
///
/// Candidates are those of the undamped rotor, none of which a list of speeds can step over, and the crossings of the followed
/// courses with the speed. Each is refined with damping.
pub fn criticals(system: &System, speeds: &[f64], courses: &[Course], highest: f64) -> Vec<(f64, Oscillation)> {
    let mut found: Vec<(f64, Oscillation)> = Vec::new();
    let candidates = undamped(system).into_iter().chain(crossings(speeds, courses));
    for (speed, oscillation) in candidates {
        let Some((speed, oscillation)) = refined(system, speed, oscillation) else { continue };
        let is_known = |known: &(f64, Oscillation)| {
            (known.0 - speed).abs() < SAME_SPEED * speed && known.1.likeness(&oscillation) > 0.5
        };
        if speed > 0.0 && speed <= highest && !found.iter().any(is_known) {
            found.push((speed, oscillation));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

/// Critical speeds without damping: a motion u e^(iΩt) solves K u = Ω² (1 − i G) u, a Hermitian problem whose positive
/// eigenvalues 1/Ω² are all of them. The gyroscopic matrix at speed Ω is Ω G. Bearings change K with speed: each interval between
/// two known speeds has its mean, and the criticals in it or near its ends.
fn undamped(system: &System) -> Vec<(f64, Oscillation)> {
    let courses = system.stiffness_courses();
    courses.into_iter().flat_map(|(stiffness, ends)| of_stiffness(system, stiffness, ends)).collect()
}

fn of_stiffness(system: &System, stiffness: DMatrix<f64>, [from, to]: [f64; 2]) -> Vec<(f64, Oscillation)> {
    let stiffness = 0.5 * (&stiffness + stiffness.transpose());
    let Some(factor) = stiffness.cholesky().map(|cholesky| cholesky.l()) else { return Vec::new() };
    let size = factor.nrows();
    let lower = factor.map(Complex::from);
    let gyroscopic = system.gyroscopic();
    let inertia =
        DMatrix::from_fn(size, size, |row, column| Complex::new(f64::from(row == column), -gyroscopic[(row, column)]));
    let Some(half) = lower.solve_lower_triangular(&inertia) else { return Vec::new() };
    let Some(whole) = lower.solve_lower_triangular(&half.adjoint()) else { return Vec::new() };
    let eigen = SymmetricEigen::new(whole);
    let largest = eigen.eigenvalues.amax();
    // The mean stiffness of the interval moves a critical near its end across that end.
    let (from, to) = (from - (to - from), to + (to - from));
    let mut found = Vec::new();
    for (index, value) in eigen.eigenvalues.iter().enumerate().filter(|(_, value)| **value > f64::EPSILON * largest) {
        let speed = 1.0 / value.sqrt();
        let column: DVector<Complex<f64>> = eigen.eigenvectors.column(index).into_owned();
        if let Some(vector) = lower.ad_solve_lower_triangular(&column).filter(|_| (from..=to).contains(&speed)) {
            let vector = vector.unscale(vector.norm());
            found.push((speed, Oscillation { value: Complex::new(0.0, speed), vector }));
        }
    }
    found
}

/// Speeds at which the frequency of a course equals the speed, between two neighbouring speeds.
fn crossings(speeds: &[f64], courses: &[Course]) -> Vec<(f64, Oscillation)> {
    let mut found = Vec::new();
    for course in courses {
        for (pair, ends) in course.windows(2).zip(speeds.windows(2)) {
            let [Some(a), Some(b)] = pair else { continue };
            let excess = [a.value.im - ends[0], b.value.im - ends[1]];
            if excess[0] > 0.0 && excess[1] <= 0.0 || excess[0] < 0.0 && excess[1] >= 0.0 {
                let share = excess[0] / (excess[0] - excess[1]);
                let nearer = if share < 0.5 { a } else { b };
                found.push((ends[0] + share * (ends[1] - ends[0]), nearer.clone()));
            }
        }
    }
    found
}

/// The speed at which this oscillation has it as its frequency, by the secant method.
fn refined(system: &System, speed: f64, start: Oscillation) -> Option<(f64, Oscillation)> {
    let at = |speed: f64, from: &Oscillation| {
        let (stiffness, damping) = system.matrices(speed);
        from.followed(&stiffness, &damping)
    };
    let (mut before, mut oscillation) = (speed, at(speed, &start)?);
    let mut excess = oscillation.value.im - speed;
    // Between speeds closer than this a slope is rounding.
    if excess.abs() <= CONVERGED * speed {
        return Some((speed, oscillation));
    }
    let mut speed = oscillation.value.im;
    for _ in 0..MOST_STEPS {
        let next = at(speed, &oscillation)?;
        let now = next.value.im - speed;
        oscillation = next;
        if now.abs() <= CONVERGED * speed {
            return Some((speed, oscillation));
        }
        let slope = (now - excess) / (speed - before);
        (before, excess) = (speed, now);
        speed -= now / slope;
        if !(speed.is_finite() && speed > 0.0) {
            return None;
        }
    }
    None
}
