//! Bearings on reduced levels.

use super::*;
use crate::machine::codes::MachineWarning;
use crate::machine::inapplicable::{BearingInapplicable, MachineInapplicable};
use crate::machine::level::{LevelChoice, ReducedLevel, inapplicability, missing_signal};
use crate::machine::recording::MachineRecording;
use crate::machine::run::{Run, Work};
use crate::machine::simulate::simulate_on;
use crate::numerics::ode::Statistics;
use crate::simulation::input::channel::Channel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::{radially_condensed, spindle_only};
use crate::simulation::recording::record::Recording;
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
pub(super) fn on_two_bearings() -> Machine {
    let mut machine = motor_spindle();
    machine.rotor.shaft.is_axially_free = false;
    machine.rotor.load = [0.0, 500.0, 0.0];
    for bearing in &mut machine.rotor.bearings {
        bearing.mounted.outer = [0.0; 5];
    }
    machine
}

fn recorded(
    machine: &Machine,
    dynamics: &MachineDynamics,
    [settle, duration]: [f64; 2],
    step: f64,
) -> MachineRecording {
    let start = start_state(machine, dynamics).unwrap();
    let run = Run { machine, dynamics, start: &start, settle, series: &[] };
    let step = StepLength { longest: step, share: 1.0 };
    run.record(duration, step, &Control::until(&|| false), &mut Work::default()).ok().unwrap()
}

fn level(values: &[f64]) -> f64 {
    20.0 * InBand::of(values, &[]).moments.rms().log10()
}

/// Levels of the accelerations of a bearing in Y and Z [dB].
fn levels(recording: &MachineRecording, bearing: usize) -> [f64; 2] {
    [Axis::Y, Axis::Z].map(|axis| level(recording.of(MachineChannel::Ring(bearing, axis, Motion::Acceleration))))
}

/// A shaft a million times as stiff on one bearing at its mass centre vibrates as the rigid spindle of a simulation on the same level. Both settle for
/// 0.9 s: they start differently.
#[test]
fn a_very_stiff_shaft_is_the_spindle_of_the_level() {
    compared_with_rigid_spindle(ReducedLevel::RadiallyCondensed, radially_condensed::simulate);
    compared_with_rigid_spindle(ReducedLevel::SpindleOnly, spindle_only::simulate);
}

/// Asserts that levels and cage speed of a shaft that hardly bends are those of a rigid spindle.
fn compared_with_rigid_spindle(
    level: ReducedLevel,
    simulate: impl Fn(&Scene, &RunSettings, &Control<'_>) -> Result<(Recording, Statistics), SimulationError>,
) {
    let mut machine = on_one_bearing();
    machine.rotor.shaft.material.elastic_modulus *= 1e6;
    let (times, step) = ([0.9, 0.1], 4.8828125e-6);
    let mut scene = machine.bearings[0].scene.clone();
    scene.spindle = Spindle {
        mass: machine.rotor.shaft.mass(),
        unbalance: Unbalance::Product(5e-6),
        axial: AxialHold::Fixed,
        tilt: SpindleTilt::Held,
    };
    scene.operation.load = machine.rotor.load;
    scene.gravity = machine.rotor.gravity;
    let settings = RunSettings { fixed_step: Some(step), ..RunSettings::new(times[0], times[1], Outputs::vibration()) };
    let (rigid, _) = simulate(&scene, &settings, &Control::until(&|| false)).unwrap();
    let dynamics = MachineDynamics::new(&machine, RANGE, &|| false).unwrap().reduced_to(level, &machine).unwrap();
    let recording = recorded(&machine, &dynamics, times, step);
    for (axis, found) in [Axis::Y, Axis::Z].into_iter().zip(levels(&recording, 0)) {
        let signal = rigid.of(Channel::Spindle(axis, Motion::Acceleration)).unwrap();
        let expected = 20.0 * signal.in_band().moments.rms().log10();
        assert!((found - expected).abs() < 1e-3, "{axis}: {found} dB, rigid {expected} dB");
    }
    let cage = recording.bearings[0].cage_speed / rigid.speeds.cage - 1.0;
    assert!(cage.abs() < 1e-6, "{cage:e}");
}

/// Largest deviation of a level of a bearing from that on `full` [dB], for a bar of a diameter [m], on a level in steps of a length [s].
fn deviation_from_full(diameter: f64, level: ReducedLevel, step: f64) -> f64 {
    let mut machine = on_two_bearings();
    machine.rotor.shaft.sections[0].tube.outer_diameter = diameter;
    let full = MachineDynamics::new(&machine, RANGE, &|| false).unwrap();
    let reduced = full.clone().reduced_to(level, &machine).unwrap();
    let times = [0.3, 0.1];
    let (reference, found) = (recorded(&machine, &full, times, 5.5e-6), recorded(&machine, &reduced, times, step));
    let pairs = (0..2).flat_map(|bearing| levels(&found, bearing).into_iter().zip(levels(&reference, bearing)));
    let deviation = pairs.map(|(found, reference)| (found - reference).abs()).fold(0.0, f64::max);
    println!("{} mm, {}: {deviation} dB", 1e3 * diameter, level.level().name());
    deviation
}

/// Levels at two bearings of a flexible shaft, beside those on `full`. The bar of 25 mm leans by 0.4 mrad in its bearings, which moves their balls along
/// the axis; that of 40 mm leans by 0.06 mrad.
#[test]
fn a_flexible_shaft_agrees_with_full() {
    let condensed = |diameter| deviation_from_full(diameter, ReducedLevel::RadiallyCondensed, 11e-6);
    let (slender, stout) = (condensed(0.025), condensed(0.04));
    assert!(slender < 0.7 && stout < 0.1, "{slender} {stout}");
    let planar = deviation_from_full(0.06, ReducedLevel::Planar, 5.5e-6);
    let only = deviation_from_full(0.06, ReducedLevel::SpindleOnly, 11e-6);
    assert!(planar < 0.02 && only < 0.5, "{planar} {only}");
}

/// A run states its deviation from `full`, and one within a tolerance is on `full` where the deviation is larger.
#[test]
fn a_level_is_verified_against_full() {
    let machine = on_two_bearings();
    let settings = MachineSettings {
        settle: Some(0.01),
        duration: 0.01,
        step: Some(5.5e-6),
        range: RANGE,
        series: Vec::new(),
        envelope: ENVELOPE,
        band_edges: Vec::new(),
    };
    let on = |level| simulate_on(level, &machine, &settings, &Control::until(&|| false)).unwrap();
    let condensed = on(LevelChoice::Reduced(ReducedLevel::RadiallyCondensed));
    let deviation = condensed.accuracy.model.as_ref().unwrap().largest().unwrap().1;
    assert!(condensed.level == ModelLevel::RadiallyCondensed && deviation > 1e-3, "{deviation}");
    assert!(condensed.left_out().iter().any(|left_out| left_out.term == "tilt"));
    let only = on(LevelChoice::Reduced(ReducedLevel::SpindleOnly)).accuracy.model.unwrap().largest().unwrap().1;
    assert!(only > 2.0 * deviation, "{only} {deviation}");
    let within = on(LevelChoice::Within(1.5 * deviation));
    assert_eq!((within.level, &within.accuracy.model), (condensed.level, &condensed.accuracy.model));
    assert!(within.warnings.iter().any(|warning| matches!(warning, MachineWarning::LevelRejected(_))));
    assert_eq!(on(LevelChoice::Within(2.0 * only)).level, ModelLevel::SpindleOnly);
    let rejected = on(LevelChoice::Within(0.5 * deviation));
    assert!(rejected.level == ModelLevel::Full && rejected.left_out().is_empty() && rejected.accuracy.model.is_none());
    let names_it = |warning: &MachineWarning| matches!(warning, MachineWarning::LevelRejected(_));
    assert!(rejected.warnings.iter().any(names_it), "{:?}", rejected.warnings);
}

/// Machines that the level cannot represent are named with their cause.
#[test]
fn what_the_level_cannot_represent_is_named() {
    let condensed = |machine: &Machine| inapplicability(machine, ReducedLevel::RadiallyCondensed);
    for level in ReducedLevel::ALL {
        assert_eq!(inapplicability(&motor_spindle(), level), Some(MachineInapplicable::AxiallyFree));
    }
    assert_eq!(condensed(&on_two_bearings()), None);
    assert_eq!(condensed(&motor_spindle()), Some(MachineInapplicable::AxiallyFree));
    let mut preloaded = motor_spindle();
    preloaded.rotor.shaft.is_axially_free = false;
    assert_eq!(condensed(&preloaded), Some(MachineInapplicable::OuterRingOff { bearing: "A".to_owned() }));
    let mut run_up = on_two_bearings();
    run_up.speed = SpeedProfile::new(vec![(0.0, 100.0), (1.0, 200.0)]).unwrap();
    assert_eq!(condensed(&run_up), Some(MachineInapplicable::SpeedChanges));
    let mut without_cage = on_two_bearings();
    without_cage.bearings[1].scene.terms.set(Term::Cage, TermChoice::Off);
    let reason = MachineInapplicable::Bearing {
        bearing: "B".to_owned(),
        reason: BearingInapplicable::Scene(Inapplicable::NoCage),
    };
    assert_eq!(condensed(&without_cage), Some(reason));
    let of_ball = [MachineChannel::BallLoad(0, 2, BallContact::Inner)];
    let missing = ReducedLevel::ALL.map(|level| missing_signal(&of_ball, level));
    assert_eq!(missing, [Some(MachineInapplicable::SingleBalls), None, None]);
}
