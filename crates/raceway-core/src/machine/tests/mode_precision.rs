//! Comparison of numbers of modes.

use super::*;
use crate::machine::mode_precision::{ModePlan, ModePrecision, compare};
use crate::simulation::work_precision::Taken;

fn plan() -> ModePlan {
    ModePlan {
        ranges: vec![0.1, 1.0],
        reference_range: 2.0,
        settle: Some(0.004),
        duration: 0.006,
        step: Some(5.5e-6),
        repetitions: 2,
    }
}

fn without_times(mut found: ModePrecision) -> ModePrecision {
    found.reference.taken = Taken { wall: 0.0, processor: None };
    found.points.iter_mut().for_each(|point| point.taken.clear());
    found
}

#[test]
fn more_modes_have_smaller_errors_and_a_repetition_has_the_same_bits() {
    let machine = motor_spindle();
    let shares = std::cell::RefCell::new(vec![0.0]);
    let progress = |share: f64| shares.borrow_mut().push(share);
    let found = compare(&machine, &plan(), &Control { progress: &progress, ..Control::until(&|| false) }).unwrap();
    assert!(shares.borrow().is_sorted() && shares.borrow().last() > Some(&0.9));
    assert_eq!(found.step, 5.5e-6);
    let [few, many] = [0, 1].map(|index| found.points[index].measured.clone().unwrap());
    assert!(few.size.coordinates < many.size.coordinates && many.size.coordinates < found.reference.size.coordinates);
    assert_eq!(few.work.steps, many.work.steps);
    assert!(found.points.iter().all(|point| point.taken.len() == 2));
    let largest = |errors: &[(MachineChannel, f64)]| errors.iter().map(|error| error.1).fold(0.0, f64::max);
    assert_eq!(few.mode_errors.len(), found.reference.levels.len());
    assert!(largest(&few.mode_errors) > 2.0 * largest(&many.mode_errors), "{few:?} {many:?}");
    // The step is an error of every run; modes and step together err by no more than the sum of both.
    for (error, (mode, step)) in many.errors.iter().zip(many.mode_errors.iter().zip(&found.reference.step_errors)) {
        assert!(error.1 <= mode.1 + step.1 + 1e-9, "{error:?} {mode:?} {step:?}");
    }
    let again = compare(&machine, &plan(), &Control::until(&|| false)).unwrap();
    assert_eq!(without_times(again), without_times(found));
}

#[test]
fn a_comparison_ends_when_the_caller_stops_it() {
    let stopped = compare(&motor_spindle(), &plan(), &Control::until(&|| true));
    assert!(matches!(stopped, Err(crate::machine::input::MachineError::Stopped(_))), "{stopped:?}");
}
