//! Bearings on the level `radially_condensed`.

use super::*;
use crate::machine::recording::MachineRecording;
use crate::machine::run::{Run, Work};
use crate::numerics::statistics::rms;
use crate::simulation::input::channel::Channel;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::radially_condensed;
use crate::simulation::recording::windows::InBand;

/// One bearing at the mass centre of the bar, without its disc and axially held.
fn on_one_bearing() -> Machine {
    let mut machine = motor_spindle();
    machine.rotor.shaft.discs.clear();
    machine.rotor.shaft.is_axially_free = false;
    machine.bearings.truncate(1);
    machine.rotor.bearings.truncate(1);
    machine.rotor.bearings[0].at = 0.15;
    machine.rotor.bearings[0].mounted.outer = [0.0; 5];
    machine.rotor.unbalances[0] = UnbalancePlane { at: 0.15, product: 5e-6, phase: 0.0 };
    machine
}

/// Two bearings without preload under a radial load, axially held.
fn on_two_bearings() -> Machine {
    let mut machine = motor_spindle();
    machine.rotor.shaft.is_axially_free = false;
    machine.rotor.load = [0.0, 500.0, 0.0];
    for bearing in &mut machine.rotor.bearings {
        bearing.mounted.outer = [0.0; 5];
    }
    machine
}

fn recorded(machine: &Machine, dynamics: &MachineDynamics, [settle, duration]: [f64; 2], step: f64) -> MachineRecording {
    let start = start_state(machine, dynamics).unwrap();
    let run = Run { machine, dynamics, start: &start, settle };
    let step = StepLength { longest: step, share: 1.0 };
    run.record(duration, step, &Control::until(&|| false), &mut Work::default()).ok().unwrap()
}

fn level(values: &[f64]) -> f64 {
    20.0 * InBand::of(values).moments.rms().log10()
}

/// Levels of the accelerations of a bearing in Y and Z [dB].
fn levels(recording: &MachineRecording, bearing: usize) -> [f64; 2] {
    [Axis::Y, Axis::Z].map(|axis| level(recording.of(MachineChannel::Ring(bearing, axis, Motion::Acceleration))))
}

/// A shaft a million times as stiff on one bearing at its mass centre vibrates as the rigid spindle of a simulation on the same level.
#[test]
fn a_very_stiff_shaft_is_the_condensed_spindle() {
    let mut machine = on_one_bearing();
    machine.rotor.shaft.material.elastic_modulus *= 1e6;
    let mut scene = machine.bearings[0].scene.clone();
    scene.spindle = Spindle {
        mass: machine.rotor.shaft.mass(),
        unbalance: Unbalance::Product(5e-6),
        axial: AxialHold::Fixed,
        tilt: SpindleTilt::Held,
    };
    scene.operation.load = machine.rotor.load;
    scene.gravity = machine.rotor.gravity;
    let mut worst = 0.0_f64;
    let upright = |mut machine: Machine| {
        let (mass, centre) = (machine.rotor.shaft.mass(), machine.rotor.shaft.mass_centre());
        let body = SpindleBody { mass, centre, inertia: SpindleInertia { transverse: 1.0, axial: 1.0 } };
        machine.rotor.shaft = Shaft::rigid(body, (0.3, 0.025), ShaftMotion::Upright, false);
        machine
    };
    for (name, machine, unbalance, times) in [
        ("stiff", machine.clone(), 5e-6, [0.3, 0.1]),
        ("upright", upright(machine.clone()), 5e-6, [0.3, 0.1]),
        ("balanced", machine.clone(), 0.0, [0.3, 0.1]),
        ("later", machine.clone(), 5e-6, [0.9, 0.1]),
        ("longer", machine.clone(), 5e-6, [0.3, 0.5]),
    ] {
        let mut machine = machine;
        machine.rotor.unbalances[0].product = unbalance;
        scene.spindle.unbalance = Unbalance::Product(unbalance);
        let step = 4.8828125e-6;
        let settings = RunSettings { fixed_step: Some(step), ..RunSettings::new(times[0], times[1], Outputs::vibration()) };
        let (rigid, _) = radially_condensed::simulate(&scene, &settings, &Control::until(&|| false)).unwrap();
        let signal = |axis| rigid.of(Channel::Spindle(axis, Motion::Acceleration)).unwrap();
        let expected = [Axis::Y, Axis::Z].map(|axis| 20.0 * signal(axis).in_band().moments.rms().log10());
        let dynamics = MachineDynamics::new(&machine, RANGE, &|| false).unwrap();
        let dynamics = dynamics.radially_condensed(&machine).unwrap();
        let recording = recorded(&machine, &dynamics, times, step);
        let found = levels(&recording, 0);
        let cage = rigid.speeds.cage - recording.bearings[0].cage_speed;
        println!("{name}: {found:?} {expected:?} cage {cage:e}");
        worst = (0..2).map(|axis| (found[axis] - expected[axis]).abs()).fold(worst, f64::max);
    }
    println!("{worst:?}");
    assert!(worst < 1e-3, "{worst:?}");
}

/// On a flexible shaft the level agrees with `full`.
#[test]
fn two_bearings_agree_with_full() {
    let machine = on_two_bearings();
    let full = MachineDynamics::new(&machine, RANGE, &|| false).unwrap();
    let condensed = full.clone().radially_condensed(&machine).unwrap();
    let times = [0.2, 0.1];
    let clock = std::time::Instant::now();
    let reference = recorded(&machine, &full, times, 5.5e-6);
    println!("full {:?}", clock.elapsed());
    for step in [2.75e-6, 5.5e-6, 11e-6, 16e-6] {
        let clock = std::time::Instant::now();
        let found = recorded(&machine, &condensed, times, step);
        println!("{step:e} {:?}", clock.elapsed());
        for bearing in 0..2 {
            println!("  {:?} {:?}", levels(&found, bearing), levels(&reference, bearing));
        }
    }
    let _ = rms(&[1.0]);
}
