//! Outer rings that move with their bodies and in their seats: balances, limits, the linear analysis, mirror images.

use super::*;
use crate::physics::frame::housing::{Body, Mount};
use crate::physics::frame::structure::{Structure, StructureMatrices};
use crate::physics::frame::support::{PORT, diagonal};
use crate::physics::kinematics::RingSpeeds;
use crate::physics::statics::shaft::Spring;

/// Both bearings in a body off their middle.
pub(super) fn in_body(mut machine: Machine, stiffness: [f64; 5], damping: f64) -> Machine {
    machine.rotor.bearings.iter_mut().for_each(|bearing| bearing.on = Some(0));
    machine.rotor.housing = Housing {
        bodies: vec![Body { at: 0.12, mass: 6.0, inertia: [0.05, 0.03] }],
        mounts: vec![Mount {
            body: 0,
            to: None,
            at: 0.1,
            stiffness: diagonal(stiffness),
            damping: diagonal([damping; 5]),
        }],
        structure: None,
    };
    machine.bodies = vec!["head".to_owned()];
    machine
}

/// The first bearing in an elastic seat, the second in a sliding one in place of the rigid preload.
pub(super) fn in_seats(mut machine: Machine) -> Machine {
    let [one, other] = &mut machine.rotor.bearings[..] else { panic!() };
    (one.mounted.outer, other.mounted.outer) = ([0.0; 5], [0.0; 5]);
    let stiffness = diagonal([1.5e8, 1e8, 1e8, 2e4, 2e4]);
    one.seat = Seat::Elastic { mass: 0.06, inertia: 3e-5, polar: 6e-5, stiffness, damping: diagonal([0.0; 5]) };
    other.seat = Seat::Sliding { mass: 0.06, spring: Spring { force: 200.0, stiffness: 5e4 }, damping: 0.0 };
    machine
}

/// The machine with outer rings that turn [rad/s].
pub(super) fn turning(mut machine: Machine, speed: f64) -> Machine {
    machine.outer_speed = SpeedProfile::constant(speed).unwrap();
    machine.rotor = machine.rotor.at_speeds(RingSpeeds { inner: machine.speed.at(0.0).1, outer: speed });
    machine
}

pub(super) const MOUNTS: [f64; 5] = [6e7, 3e7, 4e7, 2e5, 3e5];

pub(super) fn is_kept(machine: &Machine) {
    let (dynamics, start) = started(machine);
    let state = disturbed(&start, &dynamics);
    let (_, velocity) = dynamics.coordinates(&state);
    let mut rates = vec![0.0; state.len()];
    dynamics.derivative(0.0, &state, &mut rates);
    let (_, acceleration) = dynamics.coordinates(&rates);
    let exchanged: f64 = velocity.iter().zip(acceleration).map(|(v, a)| (v * a).abs()).sum();
    let gained = power(&dynamics, &state, true);
    assert!(exchanged > 1.0 && gained.abs() < 1e-8 * exchanged, "{gained:e} of {exchanged:e} W");
}

/// Without dissipation, bodies and rings gain what shaft and balls lose.
#[test]
fn the_housing_gains_what_the_bearings_lose() {
    let mut machine = conservative();
    machine.rotor.unbalances.clear();
    is_kept(&in_body(machine.clone(), MOUNTS, 0.0));
    is_kept(&in_seats(machine.clone()));
    is_kept(&in_seats(in_body(machine.clone(), MOUNTS, 0.0)));
    is_kept(&turning(in_seats(machine), 300.0));
}

/// Slow vibration of shaft, balls, rings and a body is that of the linear analysis, to 0.1 %.
#[test]
fn slow_vibration_with_a_housing_is_that_of_the_linear_analysis() {
    let turned = turning(in_seats(conservative()), 300.0);
    for machine in [in_body(conservative(), MOUNTS, 0.0), in_seats(in_body(conservative(), MOUNTS, 0.0)), turned] {
        let deviation = deviation_of_frequencies(standing(machine), 14, 4);
        assert!(deviation < 1e-3, "{deviation:e}");
    }
}

fn in_stiff_seats(mut machine: Machine) -> Machine {
    for bearing in &mut machine.rotor.bearings {
        let (stiffness, damping) = (diagonal([1e12, 1e12, 1e12, 1e9, 1e9]), diagonal([10.0; 5]));
        bearing.seat = Seat::Elastic { mass: 0.06, inertia: 3e-5, polar: 6e-5, stiffness, damping };
    }
    machine
}

/// Very stiff mounts, and a very stiff seat, are the ground, also where outer rings turn.
#[test]
fn stiff_mounts_and_seats_are_the_ground() {
    let ground = motor_spindle();
    let turned = turning(ground.clone(), -300.0);
    let stiff = in_body(ground.clone(), [1e12, 1e12, 1e12, 1e11, 1e11], 300.0);
    let seats = in_stiff_seats(ground.clone());
    for (machine, ground) in [(stiff, &ground), (seats, &ground), (in_stiff_seats(turned.clone()), &turned)] {
        let (found, expected) = (after(&machine, 1e-3, 5e-6), after(ground, 1e-3, 5e-6));
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < 2e-9, "{found:e} {expected:e}");
        }
    }
}

/// Fixed steps reach the motion of an integrator with error control, rings included.
#[test]
fn fixed_steps_of_a_housing_converge_to_the_motion() {
    let machine = in_seats(in_body(motor_spindle(), MOUNTS, 300.0));
    assert_eq!(started(&machine).0.frame.ports.len(), 4);
    let [long, half] = errors_of_steps(&machine, 0..3);
    assert!(long < 1e-9 && half < 0.5 * long, "{long:e} {half:e}");
}

/// The mirror image of a machine in a housing moves as its mirror image.
#[test]
fn a_mirror_image_in_a_housing_moves_as_such() {
    let mut machine = in_seats(in_body(motor_spindle(), MOUNTS, 300.0));
    machine.rotor.load = [40.0, 100.0, -30.0];
    machine.rotor.unbalances[0].at = 0.2;
    let mut image = machine.clone();
    image.rotor.load[0] = -40.0;
    image.rotor.unbalances[0].at = 0.1;
    image.rotor.housing.bodies[0].at = 0.18;
    image.rotor.housing.mounts[0].at = 0.2;
    for bearing in &mut image.rotor.bearings {
        bearing.at = 0.3 - bearing.at;
        bearing.mounted.faces = match bearing.mounted.faces {
            Faces::PlusX => Faces::MinusX,
            Faces::MinusX => Faces::PlusX,
        };
    }
    let [one, other] = [&machine, &image].map(|machine| after(machine, 1e-3, 5e-6));
    for (one, other) in one.iter().zip(&other) {
        for ((value, mirrored), sign) in one.iter().zip(other).zip([-1.0, 1.0, 1.0, -1.0, -1.0]) {
            assert!((value - sign * mirrored).abs() < 1e-11, "{one:?} {other:?}");
        }
        assert!(one[1].abs() > 1e-7 && one[0].abs() > 1e-7, "{one:?}");
    }
}

/// Sensors on the body and between shaft and body show the linear response to unbalance, in one direction and with the mean of the statics.
#[test]
fn sensors_on_a_body_show_the_linear_response() {
    let mut machine = in_body(motor_spindle(), MOUNTS, 300.0);
    let sensor = |name: &str, on: Part, relative_to: Option<Part>, along: [f64; 3]| Sensor {
        name: name.to_owned(),
        on,
        relative_to,
        at: 0.2,
        along,
    };
    let (y, oblique) = ([0.0, 1.0, 0.0], [0.0, 0.6, 0.8]);
    let body = Part::Housing(0);
    machine.sensors = vec![
        sensor("on", body, None, y),
        sensor("gap", Part::Shaft, Some(body), y),
        sensor("back", body, Some(Part::Shaft), y),
        sensor("oblique", Part::Shaft, Some(body), oblique),
    ];
    let settings = MachineSettings {
        settle: Some(0.1),
        duration: 0.1,
        step: None,
        range: RANGE,
        series: Vec::new(),
        envelope: ENVELOPE,
        band_edges: Vec::new(),
    };
    let result = simulate(&machine, &settings, &Control::until(&|| false)).unwrap();
    let sensors = machine.sensors.clone();
    let request = Request { elements: Elements::Auto, speeds: vec![machine.rotor.speed], modes: 4, sensors };
    let linear = analyse(&machine.rotor, &request, &|| false).unwrap();
    let of = |name: &str| {
        let channel = MachineChannel::parse(name, &machine).unwrap();
        result.channels.iter().find(|(of, _)| *of == channel).map(|(_, metrics)| metrics.clone()).unwrap()
    };
    for (sensor, found) in linear.sensors.iter().zip(["on", "gap", "back", "oblique"]) {
        let seen = of(&format!("sensor.{found}.displacement"));
        let (rms, mean) = (1e6 * sensor.response[0].norm() / 2.0_f64.sqrt(), 1e6 * sensor.at_rest);
        assert!((seen.rms / rms - 1.0).abs() < 0.02, "{found}: {} µm, linear {rms} µm", seen.rms);
        assert!((seen.mean / mean - 1.0).abs() < 0.01, "{found}: {} µm, static {mean} µm", seen.mean);
    }
    assert!((of("head.y.displacement").mean / (1e6 * linear.bodies[0].at_rest[1]) - 1.0).abs() < 0.01);
}

/// The body on its mount as matrices over the displacements of its mass centre.
fn as_matrices(housing: &Housing) -> Structure {
    let (Body { at, mass, inertia }, mount) = (housing.bodies[0], housing.mounts[0]);
    let mut lever = DMatrix::<f64>::identity(PORT, PORT);
    (lever[(1, 4)], lever[(2, 3)]) = (mount.at - at, at - mount.at);
    let rows = |matrix: DMatrix<f64>| matrix.row_iter().map(|row| row.iter().copied().collect()).collect();
    let over = |of: [[f64; PORT]; PORT]| {
        rows(lever.transpose() * DMatrix::from_fn(PORT, PORT, |row, column| of[row][column]) * &lever)
    };
    let mass = diagonal([mass, mass, mass, inertia[0], inertia[1]]);
    let matrices = StructureMatrices {
        mass: mass.map(|row| row.to_vec()).to_vec(),
        damping: over(mount.damping),
        stiffness: over(mount.stiffness),
        ports: vec![(at, std::array::from_fn(Some))],
    };
    Structure::of_matrices(&matrices, PORT).unwrap()
}

/// A body on a mount, given as matrices, has the same levels in the same steps. It has no weight in both.
#[test]
fn a_body_as_matrices_has_the_same_levels() {
    let mut machine = in_seats(in_body(motor_spindle(), MOUNTS, 300.0));
    machine.rotor.gravity = 0.0;
    let mut imported = machine.clone();
    imported.rotor.housing = Housing { structure: Some(as_matrices(&machine.rotor.housing)), ..Housing::default() };
    let settings = MachineSettings {
        settle: Some(0.02),
        duration: 0.05,
        step: Some(5e-6),
        range: RANGE,
        series: Vec::new(),
        envelope: ENVELOPE,
        band_edges: Vec::new(),
    };
    let [one, other] =
        [&machine, &imported].map(|machine| simulate(machine, &settings, &Control::until(&|| false)).unwrap());
    assert_eq!(one.channels.len(), other.channels.len());
    for ((channel, one), (_, other)) in one.channels.iter().zip(&other.channels) {
        let deviation = 20.0 * (one.rms / other.rms).log10();
        assert!(deviation.abs() < 1e-6, "{}: {deviation:e} dB", channel.named(&machine));
    }
}
