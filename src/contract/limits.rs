//! The values that each field may take, in the user's units: those of a scene from physics, those of a job its own.

use super::accuracy::MOST_REPETITIONS;
use super::problem::FieldError;
use super::units;
use crate::physics::limits::limits_of;

/// The values that a field may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldLimits {
    /// From the root of a job.
    pointer: &'static str,
    pub lowest: f64,
    pub highest: f64,
    /// The lowest itself is refused.
    pub exclusive: bool,
    pub unit: &'static str,
}

const fn from(pointer: &'static str, lowest: f64, highest: f64, unit: &'static str) -> FieldLimits {
    FieldLimits { pointer, lowest, highest, exclusive: false, unit }
}

/// Tightest and loosest relative tolerance.
const TOLERANCES: (f64, f64) = (1e-12, 1e-2);

/// Time that is kept where no series are.
pub const DURATION: FieldLimits = from("/duration_s", 1e-6, 1000.0, "s");

/// Fields that no scene has.
const OF_A_JOB: [FieldLimits; 9] = [
    DURATION,
    from("/settle_s", 0.0, 1000.0, "s"),
    from("/priority", 1.0, 4.0, ""),
    from("/keep_for_s", 1.0, 315_360_000.0, "s"),
    from("/repetitions", 1.0, MOST_REPETITIONS as f64, ""),
    from("/relative_tolerances", TOLERANCES.0, TOLERANCES.1, ""),
    from("/solver/relative_tolerance", TOLERANCES.0, TOLERANCES.1, ""),
    from("/solver/model_tolerance_db", 0.0, 20.0, "dB"),
    from("/solver/fixed_step_us", 1e-3, 1e3, "µs"),
];

/// The limits of a field of a job, or of the list that an item stands in; `None`: it has none, or is one of the scene.
pub fn of_field(pointer: &str) -> Option<&'static FieldLimits> {
    let is_it = |rest: &str| rest.is_empty() || rest.starts_with('/');
    OF_A_JOB.iter().find(|limits| pointer.strip_prefix(limits.pointer).is_some_and(is_it))
}

/// Every field that has limits, by its pointer from the root of a job, without the places in lists.
pub fn all() -> impl Iterator<Item = (String, FieldLimits)> {
    let of_scene = units::fields().filter_map(|(parameter, pointer, unit)| {
        let limits = limits_of(parameter)?;
        // Freed of the dust of the conversion.
        let told = |value| units::significant(unit.to_user(value), 9);
        let (lowest, highest, exclusive) = (told(limits.lowest), told(limits.highest), limits.exclusive);
        Some((format!("/scene{pointer}"), FieldLimits { pointer, lowest, highest, exclusive, unit: unit.name }))
    });
    OF_A_JOB.iter().map(|limits| (limits.pointer.to_owned(), *limits)).chain(of_scene)
}

/// A fault of a number's type, with the unit and the range of its field.
pub fn with_range(fault: FieldError) -> FieldError {
    if !fault.detail.contains("expected a number") {
        return fault;
    }
    match all().find(|(pointer, _)| *pointer == fault.pointer) {
        Some((_, FieldLimits { lowest, highest, exclusive, unit, .. })) => {
            let range = units::range(lowest, highest, exclusive, unit);
            FieldError { detail: format!("{}, {range}", fault.detail), ..fault }
        }
        None => fault,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_of_physics_has_its_limits_told() {
        let without: Vec<_> =
            units::fields().filter(|field| limits_of(field.0).is_none()).map(|field| field.0).collect();
        // A choice, which has no range.
        assert_eq!(without, ["spindle.axial"]);
        // What is told as a limit is allowed, to the last bit, when it comes back in the user's unit.
        for (parameter, pointer, unit) in units::fields() {
            let Some(limits) = limits_of(parameter) else { continue };
            let told =
                [limits.lowest, limits.highest].map(|limit| unit.to_si(units::significant(unit.to_user(limit), 9)));
            let inside = told.map(|limit| (limits.lowest..=limits.highest).contains(&limit));
            assert_eq!(inside, [true, true], "{pointer}: {told:?}");
        }
        assert!(of_field("/relative_tolerances/3").is_some() && of_field("/duration_series").is_none());
    }
}
