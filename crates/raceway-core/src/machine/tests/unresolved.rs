//! Motions that steps do not resolve.

use super::housing::{MOUNTS, in_body, in_seats};
use super::warnings::settings;
use super::*;
use crate::machine::input::{Loss, MachineError};
use crate::machine::result::MachineResult;
use crate::physics::frame::support::diagonal;
use crate::physics::statics::shaft::Spring;

fn run(machine: &Machine, step: Option<f64>) -> Result<MachineResult, MachineError> {
    simulate(machine, &settings(0.02, 0.02, step), &Control::until(&|| false))
}

/// On its seat the ring vibrates at 360 kHz, twice the rate of steps of 5.5 µs. Without damping the seat gives
/// the levels of one with damping, which are those of a ring in the body itself to 0.2 dB.
#[test]
fn a_very_stiff_seat_without_damping_adds_no_lines() {
    let in_seat = |damping: f64| {
        let mut machine = in_seats(in_body(motor_spindle(), MOUNTS, 300.0));
        let stiffness = diagonal([3e11, 3e11, 3e11, 1e8, 1e8]);
        machine.rotor.bearings[0].seat =
            Seat::Elastic { mass: 0.06, inertia: 3e-5, polar: 6e-5, stiffness, damping: diagonal([damping; 5]) };
        machine
    };
    let mut rigid = in_seat(0.0);
    rigid.rotor.bearings[0].seat = Seat::Rigid;
    let [undamped, damped, rigid] = [in_seat(0.0), in_seat(1e3), rigid].map(|machine| run(&machine, None).unwrap());
    for (((channel, found), (_, damped)), (_, rigid)) in
        undamped.channels.iter().zip(&damped.channels).zip(&rigid.channels)
    {
        if channel.is_acceleration() {
            let level = |of: f64| 20.0 * (found.rms / of).log10();
            assert!(level(damped.rms).abs() < 0.01, "{channel:?}: {} dB", level(damped.rms));
            assert!(level(rigid.rms).abs() < 0.2, "{channel:?}: {} dB", level(rigid.rms));
        }
    }
}

/// Bearings in a body of 10 mg move it faster than the shortest steps resolve: no levels are given, and the body is named. A step of the request
/// gives levels with their error.
#[test]
fn a_body_too_light_for_its_bearings_is_named() {
    let mut machine = in_body(motor_spindle(), MOUNTS, 300.0);
    machine.rotor.bearings[1].mounted.outer = [0.0; 5];
    machine.rotor.bearings[0].mounted.outer = [0.0; 5];
    let spring = Spring { force: 150.0, stiffness: 5e4 };
    machine.rotor.bearings[1].seat = Seat::Sliding { mass: 0.06, spring, damping: 0.0 };
    let mut light = machine.clone();
    light.rotor.housing.bodies[0].mass = 1e-5;
    let error = run(&light, None).unwrap_err();
    assert!(
        matches!(&error, MachineError::Lost { cause: Loss::Unresolved, fastest: Some(part), .. }
            if part.name == "head" && part.field == "housing.bodies[0].mass_kg" && part.frequency > 5e5),
        "{error}"
    );
    let selected = run(&light, Some(5.5e-6)).unwrap();
    let largest = selected.accuracy.errors.iter().filter_map(|(_, error)| *error).fold(0.0, f64::max);
    assert!(largest > 1.0, "{largest} dB");
    run(&machine, None).unwrap();
}
