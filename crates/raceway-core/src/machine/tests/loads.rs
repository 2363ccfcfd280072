//! Loads at places of the shaft, and run-ups.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use nalgebra::Complex;

use super::*;
use crate::physics::frame::support::{Support, diagonal};
use crate::physics::loads::{Harmonic, Load, LoadCourse, LoadDirection, LoadRate, Shock};
use crate::physics::samples::Samples;
use crate::rotor::input::PlacedLoad;
use crate::rotor::response::of_unbalance;

/// Stiffness of the supports together [N/m], mass [kg] and angular frequency [rad/s].
const STIFFNESS: f64 = 4e6;
const MASS: f64 = 10.0;
const FREQUENCY: f64 = 632.455_532_033_675_9;

/// A disc in the middle of a rigid shaft without mass on two linear supports, with a damping ratio, at rest and weightless.
fn oscillator(ratio: f64) -> Machine {
    let mut machine = motor_spindle();
    machine.bearings.clear();
    let rotor = &mut machine.rotor;
    rotor.bearings.clear();
    rotor.unbalances.clear();
    (rotor.shaft.damping_ratio, rotor.shaft.is_axially_free) = (0.0, false);
    rotor.shaft.material.elastic_modulus *= 1e4;
    rotor.shaft.material.density = 1e-3;
    rotor.shaft.discs[0].mass = MASS;
    (rotor.gravity, rotor.load) = (0.0, [0.0; 3]);
    let (stiffness, damping) = (0.5 * STIFFNESS, ratio * MASS * FREQUENCY);
    rotor.supports = [0.0, 0.3]
        .map(|at| Support {
            at,
            on: None,
            stiffness: diagonal([0.0, stiffness, stiffness, 0.0, 0.0]),
            damping: diagonal([0.0, damping, damping, 0.0, 0.0]),
        })
        .to_vec();
    machine.sensors = vec![on_shaft("disc", 0.15, Axis::Y)];
    turning(machine, vec![(0.0, 0.0)])
}

/// The machine with a speed profile (time [s], speed [rad/s]).
fn turning(mut machine: Machine, points: Vec<(f64, f64)>) -> Machine {
    machine.speed = SpeedProfile::new(points).unwrap();
    machine.rotor.speed = machine.speed.at(0.0).1;
    machine
}

/// The machine under a load in Y in the middle.
fn loaded(mut machine: Machine, course: LoadCourse) -> Machine {
    machine.rotor.loads = vec![PlacedLoad { at: 0.15, load: Load::Along(LoadDirection::Y, course) }];
    machine
}

fn harmonic(amplitude: f64, frequency: f64) -> LoadCourse {
    LoadCourse::Harmonic(Harmonic { amplitude, rate: LoadRate::Frequency(frequency), phase: -FRAC_PI_2 })
}

/// Time, and place of the disc in Y and Z, after each step up to a time.
fn course(machine: &Machine, end: f64) -> Vec<(f64, [f64; 2])> {
    let (dynamics, state) = started(machine);
    let mut stepper = MachineStepper::new(&dynamics, 0.0, &state, StepLength { longest: 5e-6, share: 1.0 });
    let mut course = Vec::new();
    while stepper.time() < end {
        stepper.advance();
        let [_, y, z, _, _] = dynamics.frame.sensors[0].of_place(stepper.coordinates().0);
        course.push((stepper.time(), [y, z]));
    }
    course
}

/// Largest displacement in Y.
fn largest(course: &[(f64, [f64; 2])]) -> f64 {
    course.iter().map(|(_, [y, _])| y.abs()).fold(0.0, f64::max)
}

/// A constant load at a place bends the shaft as the static deflection of the linear analysis, on ball bearings.
#[test]
fn a_constant_load_gives_the_static_deflection() {
    let mut machine = motor_spindle();
    machine.rotor.unbalances.clear();
    machine.rotor.load = [0.0; 3];
    machine.rotor.loads =
        [(0.1, LoadDirection::Y, 150.0), (0.29, LoadDirection::Z, -80.0), (0.2, LoadDirection::AboutZ, 4.0)]
            .map(|(at, direction, load)| PlacedLoad { at, load: Load::Along(direction, LoadCourse::Constant(load)) })
            .to_vec();
    machine.sensors =
        [(0.1, Axis::Y), (0.29, Axis::Z)].map(|(at, axis)| on_shaft(&format!("{axis}"), at, axis)).to_vec();
    let settings = MachineSettings {
        settle: Some(0.05),
        duration: 0.02,
        step: None,
        range: RANGE,
        series: Vec::new(),
        envelope: ENVELOPE,
        band_edges: Vec::new(),
    };
    let result = simulate(&machine, &settings, &Control::until(&|| false)).unwrap();
    let request =
        Request { elements: Elements::Auto, speeds: vec![machine.rotor.speed], modes: 4, sensors: Vec::new() };
    let linear = analyse(&machine.rotor, &request, &|| false).unwrap();
    for (sensor, axis) in [(0, 1), (1, 2)] {
        let node = linear.nodes.iter().position(|node| (node - machine.sensors[sensor].at).abs() < 1e-9).unwrap();
        let expected = 1e6 * linear.deflection[node][axis];
        let channel = MachineChannel::Sensor(sensor, Motion::Displacement);
        let found = result.channels.iter().find(|(of, _)| *of == channel).unwrap().1.mean;
        assert!(expected.abs() > 1.0 && (found / expected - 1.0).abs() < 1e-3, "{found} instead of {expected} µm");
    }
}

/// A rotating load of order 1 on a disc is an unbalance there.
#[test]
fn a_rotating_load_is_an_unbalance() {
    let unbalanced = motor_spindle();
    let mut pulled = unbalanced.clone();
    let UnbalancePlane { at, product, phase } = pulled.rotor.unbalances.remove(0);
    let amplitude = product * pulled.rotor.speed.powi(2);
    let load = Load::Rotating(Harmonic { amplitude, rate: LoadRate::Order(1.0), phase });
    pulled.rotor.loads = vec![PlacedLoad { at, load }];
    let [one, other] = [&unbalanced, &pulled].map(|machine| after(machine, 1e-3, 5e-6));
    for (one, other) in one.iter().flatten().zip(other.iter().flatten()) {
        assert!((one - other).abs() < 1e-13, "{one:e} {other:e}");
    }
}

/// Far below the resonance a harmonic load moves the disc by F/K.
#[test]
fn a_slow_harmonic_load_meets_the_static_stiffness() {
    let machine = loaded(oscillator(0.0), harmonic(100.0, 2.0));
    let seen = largest(&course(&machine, 0.2)) * STIFFNESS / 100.0;
    assert!((seen - 1.0).abs() < 1e-3, "{seen}");
}

/// Half a sine that lasts half of the period: response factor π/2.
#[test]
fn a_shock_of_half_a_period_has_the_factor_of_the_closed_form() {
    let shock = Shock { peak: 100.0, at: 1.2345e-3, duration: 0.5 * TAU / FREQUENCY };
    let machine = loaded(oscillator(0.0), LoadCourse::Shock(shock));
    let factor = largest(&course(&machine, 0.03)) * STIFFNESS / 100.0;
    assert!((factor / FRAC_PI_2 - 1.0).abs() < 1e-4, "{factor}");
}

/// A load that jumps between two steps: F/K (1 − cos ω(t − t₀)), because a step ends there.
#[test]
fn a_jump_between_steps_is_taken_at_its_time() {
    let at = 1.2345e-3;
    let jump = LoadCourse::Points(vec![(at, 0.0), (at + 1e-9, 100.0)]);
    for (time, [y, _]) in course(&loaded(oscillator(0.0), jump), 0.005) {
        let expected = if time > at { 1.0 - (FREQUENCY * (time - at)).cos() } else { 0.0 };
        assert!((y * STIFFNESS / 100.0 - expected).abs() < 3e-4, "{time} s: {y}");
    }
}

/// A harmonic load and its values at 20 kHz give one motion, once the start has decayed.
#[test]
fn a_series_is_the_load_that_it_samples() {
    let (rate, frequency) = (20_000.0, 90.0);
    let values = (0..8000).map(|k| 100.0 * (TAU * frequency * f64::from(k) / rate).sin()).collect();
    let series = LoadCourse::Samples(Arc::new(Samples::new(rate, values).unwrap()));
    let [one, other] = [harmonic(100.0, frequency), series].map(|load| course(&loaded(oscillator(0.05), load), 0.35));
    let (scale, from) = (largest(&one), one.len() - 4000);
    for ((_, one), (_, other)) in one[from..].iter().zip(&other[from..]) {
        assert!((one[0] - other[0]).abs() < 2e-4 * scale, "{one:?} {other:?}");
    }
}

/// Run-up of an unbalance through the resonance: largest amplitude, and the speed at which it occurs. Without acceleration the amplitude is
/// 500.03 µm.
#[test]
fn run_ups_pass_the_resonance_with_known_peaks() {
    for (acceleration, amplitude, place) in [(100.0, 400.85, 1.0242), (400.0, 291.58, 1.0569), (1600.0, 185.58, 1.1245)]
    {
        let mut machine = oscillator(0.01);
        machine.rotor.unbalances = vec![UnbalancePlane { at: 0.15, product: 1e-4, phase: 0.0 }];
        let time = 1.2 * FREQUENCY / acceleration;
        let machine = turning(machine, vec![(0.0, 0.0), (time, acceleration * time)]);
        let peak = course(&machine, time).into_iter().map(|(time, [y, z])| (y.hypot(z), time));
        let (seen, at) = peak.fold((0.0, 0.0), |most, now| if now.0 > most.0 { now } else { most });
        let found = acceleration * at / FREQUENCY;
        assert!((1e6 * seen / amplitude - 1.0).abs() < 1e-3, "{seen:e} m at {acceleration} rad/s²");
        assert!((found / place - 1.0).abs() < 1e-3, "{found} at {acceleration} rad/s²");
    }
}

/// A run-up through the threshold of rotating damping ends, and names the speeds; one that stays below does not.
#[test]
fn a_run_up_beyond_the_threshold_of_rotating_damping_is_named() {
    let mut machine = motor_spindle();
    (machine.rotor.shaft.damping_ratio, machine.rotor.shaft.rotating_share) = (0.05, 1.0);
    let settings = MachineSettings {
        settle: Some(0.0),
        duration: 0.02,
        step: None,
        range: RANGE,
        series: Vec::new(),
        envelope: ENVELOPE,
        band_edges: Vec::new(),
    };
    let to = |rpm: f64| {
        let machine = turning(machine.clone(), vec![(0.0, 12_000.0 * RPM), (0.02, rpm * RPM)]);
        simulate(&machine, &settings, &Control::until(&|| false)).map(|_| ())
    };
    assert_eq!(to(15_000.0), Ok(()));
    let error = to(60_000.0).unwrap_err().to_string();
    assert!(error.contains("rotating_share") && error.contains("and 59") && error.contains("between"), "{error}");
}

/// A disc of 2 kg that overhangs two supports with dashpots at 30 000 r/min: gyroscopic moments and dashpots couple its coordinates strongly.
fn overhung() -> Machine {
    let mut machine = motor_spindle();
    let speed = 30_000.0 * RPM;
    machine.bearings.clear();
    machine.rotor.bearings.clear();
    machine.rotor.shaft.sections =
        vec![Section { length: 0.2, tube: Tube { outer_diameter: 0.03, inner_diameter: 0.0 } }];
    machine.rotor.shaft.discs = vec![Disc { at: 0.2, mass: 2.0, transverse_inertia: 4e-3, axial_inertia: 8e-3 }];
    machine.rotor.shaft.damping_ratio = 0.001;
    machine.rotor.shaft.is_axially_free = false;
    machine.rotor.unbalances = vec![UnbalancePlane { at: 0.2, product: 5e-6, phase: 0.0 }];
    machine.rotor.load = [0.0; 3];
    let support = |at, along_z| Support {
        at,
        on: None,
        stiffness: diagonal([0.0, 1e8, along_z, 0.0, 0.0]),
        damping: diagonal([0.0, 300.0, 300.0, 0.0, 0.0]),
    };
    machine.rotor.supports = vec![support(0.02, 8e7), support(0.12, 9e7)];
    (machine.rotor.speed, machine.speed) = (speed, SpeedProfile::constant(speed).unwrap());
    machine.sensors = vec![on_shaft("disc", 0.2, Axis::Y)];
    machine
}

/// A machine on supports keeps the linear response from which it starts, within 2e-6 of it, also with dashpots far above the critical damping.
#[test]
fn a_machine_on_supports_keeps_its_linear_response() {
    for dashpots in [300.0, 2e5] {
        let mut machine = overhung();
        machine.rotor.gravity = 0.0;
        machine.rotor.supports[0].damping = diagonal([0.0, dashpots, dashpots, 0.0, 0.0]);
        let course = course(&machine, 0.2);
        let (dynamics, _) = started(&machine);
        let response = of_unbalance(&dynamics.frame.system, &machine.rotor.unbalances, machine.rotor.speed);
        let [along_y, along_z] = [1, 2].map(|axis| {
            let coordinates = &dynamics.frame.system.coordinates;
            let rows = coordinates.port(coordinates.mesh.node(0.2));
            (0..response.len()).map(|k| response[k] * rows[(axis, k)]).sum::<Complex<f64>>()
        });
        let size = along_y.norm().max(along_z.norm());
        for (time, place) in course.into_iter().step_by(97) {
            let turned = Complex::from_polar(1.0, machine.rotor.speed * time);
            for (found, amplitude) in place.into_iter().zip([along_y, along_z]) {
                let off = (found - (amplitude * turned).re).abs() / size;
                assert!(off < 2e-6, "{dashpots} N s/m: {off:e} at {time} s");
            }
        }
    }
}

/// A run-up with strong gyroscopic moments in the motion of an integrator with error control.
#[test]
fn a_run_up_with_gyroscopic_moments_converges_to_the_motion() {
    let machine = turning(overhung(), vec![(0.0, 0.0), (0.02, 30_000.0 * RPM)]);
    let (dynamics, state) = started(&machine);
    let time = 0.02;
    let mut reference =
        Method::DormandPrince.start(&dynamics, 0.0, &state, Tolerances::uniform(state.len(), 1e-8, 1e-13), None);
    while reference.time() < time {
        reference.step(time).unwrap();
    }
    let [_, y, z, _, _] = dynamics.frame.sensors[0].of_place(dynamics.coordinates(reference.state()).0);
    let course = course(&machine, time - 1e-7);
    let size = course.iter().fold(0.0, |size, (_, [y, z])| f64::max(size, y.hypot(*z)));
    let (end, found) = course[course.len() - 1];
    assert!((end - time).abs() < 1e-9, "{end}");
    let off = (found[0] - y).hypot(found[1] - z) / size;
    println!("{off:e} of {size:e} m");
    assert!(off < 1e-3, "{off:e}");
}
