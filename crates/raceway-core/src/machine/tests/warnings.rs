//! Reasons to doubt the numbers of a run.

use super::housing::{in_seats, turning};
use super::*;
use crate::machine::codes::{LaterChange, MachineWarning};
use crate::machine::input::{Loss, MachineError, StepsOfLoss};
use crate::machine::result::MachineResult;
use crate::physics::kinematics::RingSpeeds;
use crate::physics::loads::{Harmonic, Load, LoadCourse, LoadDirection, LoadRate, Shock};
use crate::rotor::input::PlacedLoad;
use crate::simulation::model::state::SpindleState;

pub(super) fn settings(settle: f64, duration: f64, step: Option<f64>) -> MachineSettings {
    MachineSettings {
        settle: Some(settle),
        duration,
        step,
        range: RANGE,
        series: Vec::new(),
        envelope: ENVELOPE,
        band_edges: Vec::new(),
    }
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

/// A load that changes after the record changes neither levels nor messages.
#[test]
fn a_load_that_changes_after_the_record_is_steady() {
    let mut machine = motor_spindle();
    let settings = settings(0.02, 0.1, Some(5.5e-6));
    let alone = run(&machine, &settings);
    let later = LoadCourse::Points(vec![(0.0, 0.0), (500.0, 0.0), (501.0, 1.0)]);
    machine.rotor.loads = vec![in_the_middle(later)];
    let with_load = run(&machine, &settings);
    assert_eq!(with_load.warnings, alone.warnings);
    assert!(!alone.warnings.is_empty());
}

/// The repeated time covers a period of the slowest load.
#[test]
fn a_slow_load_is_verified_over_its_period() {
    let mut machine = motor_spindle();
    let slow = Harmonic { amplitude: 20.0, rate: LoadRate::Frequency(8.0), phase: 0.0 };
    machine.rotor.loads = vec![in_the_middle(LoadCourse::Harmonic(slow))];
    let result = run(&machine, &settings(0.02, 0.15, Some(5.5e-6)));
    assert_eq!(result.accuracy.window, 0.125);
}

/// A ring that no ball can hold, and one that is nowhere: the error names the bearing, the displacement and the steps.
#[test]
fn a_lost_ring_names_its_bearing() {
    let (dynamics, _) = started(&motor_spindle());
    let loss = |position| {
        let ring = SpindleState { position, ..SpindleState::default() };
        dynamics.bearings[0].loss_of_ring("A", (ring.position, ring.tilt))
    };
    assert_eq!(loss([0.0; 3]), None);
    assert_eq!(loss([0.0, f64::NAN, 0.0]), Some(Loss::NotFinite { bearing: "A".to_owned() }));
    let cause = loss([0.0, 0.01, 0.0]).unwrap();
    let text = |steps| MachineError::Lost { time: 0.25, cause: cause.clone(), steps, fastest: None }.to_string();
    for (steps, begin) in [
        (StepsOfLoss::AtStart, "in the equilibrium that the run starts from"),
        (StepsOfLoss::Selected(2e-6), "at t = 0.250000 s in steps of 2.000 µs"),
        (StepsOfLoss::DownTo(5e-7), "at t = 0.250000 s, in steps down to 0.500 µs"),
    ] {
        let text = text(steps);
        assert!(text.starts_with(begin), "{text}");
        assert!(text.contains("left bearing A: it is displaced radially by 10.000 mm"), "{text}");
    }
}

/// Outer rings turn around a shaft at rest. Free axial motion of the start is the strongest motion: while it decays, and after it has become quiet, it
/// is no whirl.
#[test]
fn free_motion_of_the_start_is_no_whirl() {
    for settle in [0.4, 1.0] {
        let mut machine = turning(in_seats(motor_spindle()), 50.0);
        machine.rotor.unbalances.clear();
        machine.speed = SpeedProfile::constant(0.0).unwrap();
        machine.rotor = machine.rotor.at_speeds(RingSpeeds { inner: 0.0, outer: 50.0 });
        let result = run(&machine, &settings(settle, 0.2, None));
        let whirls = result.warnings.iter().any(|warning| matches!(warning, MachineWarning::UnnamedLine { .. }));
        assert!(!whirls, "{settle}: {:?}", result.warnings);
    }
}
