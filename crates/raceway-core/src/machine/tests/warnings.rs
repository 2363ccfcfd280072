//! Reasons to doubt the numbers of a run.

use super::*;
use crate::machine::codes::{LaterChange, MachineWarning, StepCause, StepLimit};
use crate::machine::input::{Loss, MachineError, StepsOfLoss};
use crate::machine::result::MachineResult;
use crate::physics::frame::support::{Support, diagonal};
use crate::physics::loads::{Load, LoadCourse, LoadDirection, Shock};
use crate::rotor::input::PlacedLoad;

fn settings(settle: f64, duration: f64, step: Option<f64>) -> MachineSettings {
    MachineSettings { settle: Some(settle), duration, step, range: RANGE, series: Vec::new() }
}

fn run(machine: &Machine, settings: &MachineSettings) -> MachineResult {
    simulate(machine, settings, &Control::until(&|| false)).unwrap()
}

fn in_the_middle(course: LoadCourse) -> PlacedLoad {
    PlacedLoad { at: 0.15, load: Load::Along(LoadDirection::Y, course) }
}

/// A shock after the repeated 0.1 s is named, one within them is not. Free motion of the start remains in both: it decays by 15/s.
#[test]
fn a_shock_after_the_verified_time_is_named() {
    for (at, is_named) in [(0.15, true), (0.05, false)] {
        let mut machine = motor_spindle();
        machine.rotor.loads = vec![in_the_middle(LoadCourse::Shock(Shock { peak: 50.0, at, duration: 1e-3 }))];
        let found = run(&machine, &settings(0.02, 0.14, None)).warnings;
        let later = found.iter().find_map(|warning| match warning {
            MachineWarning::PartlyVerified { window, change, .. } => Some((*window, *change)),
            _ => None,
        });
        let expected = is_named.then_some((0.1, LaterChange::Load { place: 0, at: Some(at) }));
        assert_eq!(later, expected, "{found:?}");
        assert!(
            found.iter().any(|warning| matches!(warning, MachineWarning::StartTransient { required, .. }
                if (0.1..1.0).contains(required))),
            "{found:?}"
        );
        assert!(!found.iter().any(|warning| matches!(warning, MachineWarning::Overloaded { .. })), "{found:?}");
    }
}

/// A dashpot far above the critical damping of the shaft needs short steps: the rejected ones name it.
#[test]
fn steps_that_dashpots_shorten_name_them() {
    let mut machine = motor_spindle();
    let (stiffness, damping) = (diagonal([0.0; 5]), diagonal([0.0, 2e5, 2e5, 0.0, 0.0]));
    machine.rotor.supports = vec![Support { at: 0.15, stiffness, damping }];
    let found = run(&machine, &settings(0.0, 0.01, None)).warnings;
    let rejected = found.iter().find_map(|warning| match warning {
        MachineWarning::StepRejected(rejected) => Some(rejected.clone()),
        _ => None,
    });
    let rejected = rejected.expect("a rejected step");
    assert_eq!(rejected.limit, Some(StepLimit::Dashpots), "{rejected:?}");
    assert!(matches!(rejected.cause, StepCause::Deviation { .. } | StepCause::Lost { .. }));
}

/// Loads beyond what the bearings carry: the run ends, and names the bearing and the load or the displacement.
#[test]
fn a_load_beyond_the_bearings_names_the_cause() {
    let mut machine = motor_spindle();
    machine.rotor.loads = vec![in_the_middle(LoadCourse::Shock(Shock { peak: 1e6, at: 1e-3, duration: 2e-3 }))];
    let error = simulate(&machine, &settings(0.0, 0.01, Some(2e-6)), &Control::until(&|| false)).unwrap_err();
    assert!(
        matches!(
            &error,
            MachineError::Lost { cause: Loss::TooDeep { .. } | Loss::Left { .. }, steps: StepsOfLoss::Selected(_), .. }
        ),
        "{error}"
    );
    let text = error.to_string();
    assert!(text.contains("bearing A") || text.contains("bearing B"), "{text}");
}
