//! Natural frequencies over speed. Each oscillation is followed from speed to speed; where one gets lost, all are computed anew.

use nalgebra::{Complex, DMatrix};

use super::input::RotorError;
use super::system::System;
use crate::numerics::quadratic_eigen::Oscillation;

/// Smallest likeness of the shapes of an oscillation at neighbouring speeds, so that following it is safe [-].
const SAME_SHAPE: f64 = 0.7;
/// Distance of two followed eigenvalues, relative to them, at which their shapes are compared [-].
const SAME_VALUE: f64 = 1e-6;

/// An oscillation at each speed; `None` where it has stopped to oscillate.
pub type Course = Vec<Option<Oscillation>>;

/// The `count` lowest oscillations of the first speed, over all speeds.
pub fn courses(
    system: &System,
    speeds: &[f64],
    count: usize,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Course>, RotorError> {
    let first = system.oscillations(speeds[0], count)?;
    let mut courses: Vec<Course> = first.into_iter().map(|oscillation| vec![Some(oscillation)]).collect();
    for (index, speed) in speeds.iter().enumerate().skip(1) {
        if stop() {
            return Err(RotorError::Stopped);
        }
        let (stiffness, damping) = system.matrices(*speed);
        let expected: Vec<_> = courses.iter().map(|course| expected(course, speeds, index)).collect();
        let next = match followed(&expected, &stiffness, &damping) {
            Some(next) => next.into_iter().map(Some).collect(),
            None => matched(&expected, system.oscillations(*speed, usize::MAX)?),
        };
        courses.iter_mut().zip(next).for_each(|(course, next)| course.push(next));
    }
    Ok(courses)
}

/// The oscillation at the speed of this index, by the line through its last two values.
fn expected(course: &Course, speeds: &[f64], index: usize) -> Option<Oscillation> {
    let last = course[index - 1].clone()?;
    let Some(before) = index.checked_sub(2).and_then(|before| course[before].as_ref()) else { return Some(last) };
    let share = (speeds[index] - speeds[index - 1]) / (speeds[index - 1] - speeds[index - 2]);
    let value = last.value + (last.value - before.value) * Complex::from(share);
    Some(Oscillation { value, ..last })
}

/// Every expected oscillation, followed; `None` where one gets lost or two become one.
fn followed(
    expected: &[Option<Oscillation>],
    stiffness: &DMatrix<f64>,
    damping: &DMatrix<f64>,
) -> Option<Vec<Oscillation>> {
    let mut next: Vec<Oscillation> = Vec::with_capacity(expected.len());
    for before in expected {
        let before = before.as_ref()?;
        let found = before.followed(stiffness, damping)?;
        let is_known = |known: &Oscillation| {
            (known.value - found.value).norm() < SAME_VALUE * found.value.norm() && known.likeness(&found) > 0.5
        };
        if found.likeness(before) < SAME_SHAPE || next.iter().any(is_known) {
            return None;
        }
        next.push(found);
    }
    Some(next)
}

/// The oscillation that each expected one resembles most, in value and shape.
fn matched(expected: &[Option<Oscillation>], mut found: Vec<Oscillation>) -> Course {
    let difference = |a: &Oscillation, b: &Oscillation| {
        (a.value - b.value).norm() / b.value.norm().max(a.value.norm()) + 1.0 - a.likeness(b)
    };
    let nearest = |before: &Oscillation, found: &[Oscillation]| {
        let best =
            (0..found.len()).min_by(|a, b| difference(&found[*a], before).total_cmp(&difference(&found[*b], before)));
        best.filter(|best| difference(&found[*best], before) < 1.0)
    };
    let mut next = Vec::with_capacity(expected.len());
    for before in expected {
        let best = before.as_ref().and_then(|before| nearest(before, &found));
        next.push(best.map(|best| found.remove(best)));
    }
    next
}
