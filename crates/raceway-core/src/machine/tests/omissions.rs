//! Terms of the system around the bearings that a run leaves out.

use super::housing::{MOUNTS, in_body, is_kept};
use super::levels::on_two_bearings;
use super::*;
use crate::machine::codes::MachineWarning;
use crate::machine::input::Part;
use crate::machine::level::LevelChoice;
use crate::machine::omission::omitted;
use crate::machine::result::MachineResult;
use crate::machine::simulate::simulate_on;
use crate::physics::frame::support::{Support, diagonal};
use crate::physics::loads::{Harmonic, Load, LoadCourse, LoadDirection, LoadRate};
use crate::rotor::input::PlacedLoad;
use crate::rotor::omission::SystemTerm;
use crate::simulation::model::terms::Justification;

const SETTINGS: MachineSettings = MachineSettings {
    settle: Some(0.1),
    duration: 0.1,
    step: Some(5.5e-6),
    range: RANGE,
    series: Vec::new(),
    envelope: ENVELOPE,
    band_edges: Vec::new(),
};

fn run(level: LevelChoice, machine: &Machine) -> MachineResult {
    simulate_on(level, machine, &SETTINGS, &Control::until(&|| false)).unwrap()
}

/// The machine with a term switched off.
fn without(machine: &Machine, term: SystemTerm) -> Machine {
    let mut lean = machine.clone().without([term].into_iter());
    lean.terms.set(term, TermChoice::Off);
    lean.complete = Some(Box::new(machine.rotor.clone()));
    lean
}

/// Largest change of the level of a bearing, both directions together [dB].
fn change(lean: &MachineResult, full: &MachineResult) -> f64 {
    let power = |result: &MachineResult, bearing: usize| -> f64 {
        let is_of_it = |channel: &MachineChannel| matches!(channel, MachineChannel::Ring(of, _, Motion::Acceleration) if *of == bearing);
        let of_bearing = result.channels.iter().filter(|(channel, _)| is_of_it(channel));
        of_bearing.map(|(_, metrics)| metrics.rms.powi(2)).sum()
    };
    let changes = (0..2).map(|bearing| 10.0 * (power(lean, bearing) / power(full, bearing)).log10().abs());
    changes.fold(0.0, f64::max)
}

/// The bound of the linear analysis covers the change of the vibration by each term. Two bars: one of 25 mm that bends in its bearings, and one of
/// 60 mm.
#[test]
fn bounds_cover_the_changes_of_levels() {
    for diameter in [0.025, 0.06] {
        let mut machine = on_two_bearings();
        machine.rotor.shaft.sections[0].tube.outer_diameter = diameter;
        let full = run(LevelChoice::Full, &machine);
        for term in [SystemTerm::ShaftBending, SystemTerm::Tilt, SystemTerm::Gyroscopic] {
            let lean = run(LevelChoice::Full, &without(&machine, term));
            let [omitted] = lean.omitted[..] else { panic!("{:?}", lean.omitted) };
            assert_eq!((omitted.term, omitted.by), (term, Justification::Convention));
            let (change, bound) = (change(&lean, &full), omitted.change_db.unwrap());
            println!("{diameter} m, {}: {change:.4} dB, bound {bound:.4} dB", term.name());
            assert!(change > 0.0 && change < bound, "{}: {change} dB, bound {bound} dB", term.name());
        }
    }
}

/// A machine without its housing is one on the ground, bit for bit.
#[test]
fn without_its_housing_a_machine_stands_on_the_ground() {
    let ground = on_two_bearings();
    let mut housed = in_body(ground.clone(), MOUNTS, 100.0);
    assert!(housed.rotor.has(SystemTerm::Housing) && !ground.rotor.has(SystemTerm::Housing));
    housed = without(&housed, SystemTerm::Housing);
    let (one, other) = (run(LevelChoice::Full, &housed), run(LevelChoice::Full, &ground));
    assert!(one.channels.iter().map(|(_, metrics)| metrics).eq(other.channels.iter().map(|(_, metrics)| metrics)));
    assert!(one.omitted[0].change_db.unwrap() > 3.0, "{:?}", one.omitted);
}

/// Without bending a shaft is a rigid spindle of its mass and inertia.
#[test]
fn without_bending_a_shaft_is_a_rigid_spindle() {
    let machine = motor_spindle();
    let lean = machine.clone().without([SystemTerm::ShaftBending].into_iter());
    for (one, other) in after(&lean, 2e-3, 1e-6).iter().zip(after(&rigid(machine, true), 2e-3, 1e-6)) {
        let size = one[..3].iter().fold(0.0, |most, value| f64::max(most, value.abs()));
        for axis in 0..3 {
            assert!((one[axis] - other[axis]).abs() < 1e-6 * size, "{one:?}, {other:?}");
        }
    }
}

/// Hinges and missing gyroscopic moments do no work: without dissipation the energy is kept.
#[test]
fn lean_machines_keep_their_energy() {
    let mut machine = conservative();
    machine.rotor.unbalances.clear();
    for term in [SystemTerm::ShaftBending, SystemTerm::Tilt, SystemTerm::Gyroscopic] {
        is_kept(&machine.clone().without([term].into_iter()));
        is_kept(&in_body(machine.clone(), MOUNTS, 0.0).without([term].into_iter()));
    }
    let (hinged, state) = started(&motor_spindle().without([SystemTerm::Tilt].into_iter()));
    let (place, velocity) = hinged.coordinates(&state);
    assert_eq!(hinged.rings(0, place, velocity).inner.tilt, [0.0; 2]);
}

/// Within a tolerance, terms with smaller bounds are left out, and the run states its deviation from `full`. A term that is on stays, and so does one
/// whose signals are asked for.
#[test]
fn terms_within_a_tolerance_are_left_out() {
    let mut machine = on_two_bearings();
    machine.rotor.shaft.sections[0].tube.outer_diameter = 0.06;
    let within = |machine: &Machine, settings: &MachineSettings, tolerance| -> Vec<SystemTerm> {
        let omitted = omitted(machine, settings, tolerance, &|| false).unwrap();
        omitted.iter().map(|omitted| omitted.term).collect()
    };
    assert_eq!(within(&machine, &SETTINGS, None), []);
    assert_eq!(within(&machine, &SETTINGS, Some(0.001)), []);
    assert_eq!(within(&machine, &SETTINGS, Some(0.3)), [SystemTerm::Tilt]);
    assert_eq!(within(&machine, &SETTINGS, Some(4.0)), [SystemTerm::Tilt, SystemTerm::Gyroscopic]);
    let series = vec![MachineChannel::Tilt(0, Axis::Y)];
    assert_eq!(within(&machine, &MachineSettings { series, ..SETTINGS }, Some(4.0)), [SystemTerm::Gyroscopic]);
    let result = run(LevelChoice::Within(0.3), &machine);
    let deviation = result.accuracy.model.as_ref().unwrap().largest().unwrap().1;
    assert!(result.level == ModelLevel::SpindleOnly && deviation < 0.3, "{:?} {deviation}", result.level);
    let judged = |left_out: &&_| {
        matches!(left_out, crate::simulation::model::terms::LeftOut { term: "tilt", bound: Some(_), .. })
    };
    assert_eq!(result.left_out().iter().filter(judged).count(), 1);
    machine.terms.set(SystemTerm::Tilt, TermChoice::On);
    assert_eq!(within(&machine, &SETTINGS, Some(4.0)), [SystemTerm::Gyroscopic]);
    // Reduced levels do not apply, and `full` without gyroscopic moments does.
    machine.rotor.shaft.is_axially_free = true;
    let result = run(LevelChoice::Within(4.0), &machine);
    assert_eq!((result.level, result.omitted.len()), (ModelLevel::Full, 1));
    assert!(result.accuracy.model.as_ref().unwrap().largest().unwrap().1 < 0.1);
    let names_term = |warning: &MachineWarning| match warning {
        MachineWarning::LevelNotEligible { model, .. } => model.without == [SystemTerm::Gyroscopic],
        _ => false,
    };
    assert_eq!(result.warnings.iter().filter(|warning| names_term(warning)).count(), 2);
}

/// A housing with a sensor stays, also within a tolerance that its omission would keep.
#[test]
fn a_housing_with_a_sensor_stays() {
    let mut machine = in_body(on_two_bearings(), [1e12, 1e12, 1e12, 1e10, 1e10], 1e5);
    let left_out = |machine: &Machine| -> Vec<SystemTerm> {
        omitted(machine, &SETTINGS, Some(7.0), &|| false).unwrap().iter().map(|omitted| omitted.term).collect()
    };
    assert!(left_out(&machine).contains(&SystemTerm::Housing));
    machine.sensors = vec![Sensor { on: Part::Housing(0), ..on_shaft("acc", 0.1, Axis::Y) }];
    assert!(!left_out(&machine).contains(&SystemTerm::Housing));
    machine.sensors = vec![Sensor { relative_to: Some(Part::Housing(0)), ..on_shaft("probe", 0.1, Axis::Y) }];
    assert!(!left_out(&machine).contains(&SystemTerm::Housing));
}

/// A load along Y moves an overhung disc along Z by gyroscopic moments alone. Without them that direction is silent, which is a deviation from `full`.
#[test]
fn a_direction_that_falls_silent_is_a_deviation() {
    let mut machine = on_two_bearings();
    machine.bearings.clear();
    machine.rotor.bearings.clear();
    let support = |at| Support {
        at,
        on: None,
        stiffness: diagonal([0.0, 5e7, 5e7, 0.0, 0.0]),
        damping: diagonal([0.0, 500.0, 500.0, 0.0, 0.0]),
    };
    machine.rotor.supports = [0.04, 0.2].map(support).to_vec();
    machine.rotor.unbalances.clear();
    (machine.rotor.gravity, machine.rotor.load) = (0.0, [0.0; 3]);
    machine.rotor.shaft.discs[0].at = 0.28;
    machine.sensors = [Axis::Y, Axis::Z].map(|axis| on_shaft("probe", 0.28, axis)).to_vec();
    let harmonic = Harmonic { amplitude: 50.0, rate: LoadRate::Frequency(300.0), phase: 0.0 };
    let load = Load::Along(LoadDirection::Y, LoadCourse::Harmonic(harmonic));
    machine.rotor.loads = vec![PlacedLoad { at: 0.28, load }];
    let result = run(LevelChoice::Within(20.0), &machine);
    assert!(result.omitted.is_empty() && result.level == ModelLevel::Full, "{:?}", result.omitted);
    assert!(
        result.warnings.iter().any(|warning| matches!(warning, MachineWarning::LevelRejected(_))),
        "{:?}",
        result.warnings
    );
}
