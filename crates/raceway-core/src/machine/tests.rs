//! Balances, limits and mirror images of a machine.

use std::f64::consts::PI;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::channel::MachineChannel;
use super::equations::MachineDynamics;
use super::frame::Frame;
use super::growth::check_growth;
use super::input::{Machine, MachineBearing, MachineError, Part, Sensor};
use super::settings::{MachineSettings, RANGE};
use super::simulate::simulate;
use super::start::start_state;
use super::stepping::{MachineStepper, StepLength};
use super::terms::SystemTerms;
use crate::numerics::ode::Method;
use crate::numerics::ode::OdeSystem;
use crate::numerics::ode::Tolerances;
use crate::numerics::random::SplitMix64;
use crate::physics::contact::damping::DampingLaw;
use crate::physics::contact::traction::TractionLaw;
use crate::physics::frame::beam::Tube;
use crate::physics::frame::disc::{Disc, UnbalancePlane};
use crate::physics::frame::housing::Housing;
use crate::physics::frame::shaft::{Section, Shaft, ShaftMotion, SpindleBody};
use crate::physics::frame::support::Support;
use crate::physics::frames::dot;
use crate::physics::operation::SpeedProfile;
use crate::physics::presets;
use crate::physics::raceway::{RacewayLoad, RelativeMotion};
use crate::physics::spindle::{AxialHold, Spindle, SpindleInertia, SpindleTilt, Unbalance};
use crate::physics::statics::RingBearing;
use crate::physics::statics::shaft::{Faces, Mounted, RigidShaft};
use crate::rotor::analysis::analyse;
use crate::rotor::input::{Elements, Request, Rotor, RotorBearing, Seat};
use crate::rotor::result::Mode;
use crate::simulation::input::channel::{Axis, BallContact, Motion};
use crate::simulation::input::control::Control;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::{Scene, Term, TermChoice};
use crate::simulation::input::settings::{ENVELOPE, Outputs};
use crate::simulation::model::dynamics::Watch;
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::model::{Mechanism, Model};

mod housing;
mod levels;
mod loads;
mod mode_precision;
mod omissions;
mod power;
mod unresolved;
mod warnings;

const RPM: f64 = PI / 30.0;

/// A bar of 25 × 300 mm with a disc in its middle on two 6205, 200 N of preload, at 6000 r/min.
fn motor_spindle() -> Machine {
    let preset = presets::bearing("6205").unwrap();
    let scene = Scene::of_preset(&preset, 6000.0 * RPM, [0.0, 100.0, 0.0]).unwrap();
    let ring = RingBearing::new(&scene.bearing);
    let mounted =
        [(0.04, Faces::PlusX), (0.26, Faces::MinusX)].map(|(at, faces)| Mounted::new(ring.clone(), at, faces));
    let pair = RigidShaft { bearings: mounted.to_vec() }.preloaded_by_force([0, 1], 200.0).unwrap();
    let bearings = pair.bearings.into_iter().map(|mounted| RotorBearing {
        at: mounted.at,
        mounted: Mounted { at: 0.0, ..mounted },
        damping: scene.raceway_damping.resolve(),
        on: None,
        seat: Seat::Rigid,
        has_moments: true,
    });
    Machine {
        rotor: Rotor {
            shaft: Shaft {
                material: scene.bearing.parameters.raceway_material.inner,
                sections: vec![Section { length: 0.3, tube: Tube { outer_diameter: 0.025, inner_diameter: 0.0 } }],
                discs: vec![Disc { at: 0.15, mass: 1.2, transverse_inertia: 8e-4, axial_inertia: 1.5e-3 }],
                damping_ratio: 0.005,
                rotating_share: 0.0,
                is_axially_free: true,
                motion: ShaftMotion::Bends,
                has_gyroscopic_moments: true,
            },
            unbalances: vec![UnbalancePlane { at: 0.15, product: 20e-6, phase: 0.3 }],
            supports: Vec::new(),
            bearings: bearings.collect(),
            housing: Housing::default(),
            speed: 6000.0 * RPM,
            gravity: 9.81,
            load: [0.0, 100.0, 0.0],
            loads: Vec::new(),
        },
        bearings: [("A", 0.0), ("B", 2.4)]
            .map(|(name, start_azimuth)| MachineBearing { name: name.to_owned(), scene: scene.clone(), start_azimuth })
            .to_vec(),
        speed: SpeedProfile::constant(6000.0 * RPM).unwrap(),
        outer_speed: SpeedProfile::at_rest(),
        sensors: Vec::new(),
        bodies: Vec::new(),
        terms: SystemTerms::default(),
        complete: None,
    }
}

fn on_shaft(name: &str, at: f64, axis: Axis) -> Sensor {
    let along = std::array::from_fn(|index| f64::from(index == axis as usize));
    Sensor { name: name.to_owned(), on: Part::Shaft, relative_to: None, at, along }
}

fn started(machine: &Machine) -> (MachineDynamics, Vec<f64>) {
    let dynamics = MachineDynamics::new(machine, RANGE, &|| false).unwrap();
    let state = start_state(machine, &dynamics).unwrap();
    (dynamics, state)
}

/// Energy of bearings and shaft [J] for contacts without dissipation: kinetic, elastic, weight.
fn energy(dynamics: &MachineDynamics, state: &[f64], time: f64) -> f64 {
    let (place, velocity) = dynamics.coordinates(state);
    let parts = dynamics.parts(state).into_iter().enumerate();
    let of_part = |(index, part): (usize, &[f64])| {
        let m = dynamics.bearings[index].dynamics.mechanism();
        let mut loads = Energies { mechanism: m, elastic: 0.0 };
        let (ideal, rings) = (m.rotations(time), dynamics.rings(index, place, velocity));
        dynamics.bearings[index].dynamics.rates_on_ring(
            time,
            part,
            rings,
            &mut vec![0.0; part.len()],
            Some(&mut loads),
        );
        let heights = (0..m.layout.balls).map(|index| {
            let ball = m.layout.ball(part, index);
            (m.pitch_radius + ball.radial) * m.azimuth(index, &ideal, ball.arc).cos()
        });
        let of_cage = if m.layout.cage { m.cage.mass * m.layout.cage(part).centre[1] } else { 0.0 };
        let weight = m.gravity * (m.ball_mass * heights.sum::<f64>() + of_cage);
        loads.elastic + kinetic_energy(m, part) - weight
    };
    energy_of_frame(&dynamics.frame, place, velocity) + parts.map(of_part).sum::<f64>()
}

/// Kinetic energy of balls and cage [J].
fn kinetic_energy(m: &Mechanism, part: &[f64]) -> f64 {
    let ideal = m.rotations(0.0);
    let of_ball = |index: usize| {
        let ball = m.layout.ball(part, index);
        let along = (m.pitch_radius + ball.radial) * m.orbit_speed(&ideal, ball.arc_velocity);
        let velocity = [ball.axial_velocity, ball.radial_velocity, along];
        let spin = [ball.spin[0] + ideal.spin.speed, ball.spin[1], ball.spin[2]];
        0.5 * m.ball_mass * dot(velocity, velocity) + 0.5 * m.ball_inertia * dot(spin, spin)
    };
    let of_balls: f64 = (0..m.layout.balls).map(of_ball).sum();
    if !m.layout.cage {
        return of_balls;
    }
    let cage = m.layout.cage(part);
    let spin = m.orbit_speed(&ideal, cage.arc_velocity);
    let tilting = cage.tilt_rate[0].powi(2) + cage.tilt_rate[1].powi(2);
    let turning = m.cage.axial_inertia * spin * spin + m.cage.transverse_inertia * tilting;
    of_balls + 0.5 * (m.cage.mass * dot(cage.velocity, cage.velocity) + turning)
}

/// Energy of shaft and housing [J], constant loads included; moments of a turning shaft do no work.
fn energy_of_frame(frame: &Frame, place: &[f64], velocity: &[f64]) -> f64 {
    let [place, velocity] = [place, velocity].map(DVector::from_row_slice);
    let ([stiffness, _], load) = (frame.matrices(0.0), frame.inputs.column(frame.inputs.ncols() - 1));
    0.5 * (velocity.dot(&velocity) + place.dot(&(stiffness * &place))) - load.dot(&place)
}

/// Angular frequency of a coordinate by itself [rad/s].
fn frequency_of(frame: &Frame, coordinate: usize) -> f64 {
    frame.system.linear[0][(coordinate, coordinate)].sqrt()
}

/// Sum of the elastic energies of the contacts.
struct Energies<'a> {
    mechanism: &'a Mechanism,
    elastic: f64,
}

impl Watch for Energies<'_> {
    fn raceway(&mut self, _: usize, side: BallContact, _: &RelativeMotion, load: &RacewayLoad) {
        let raceway = &self.mechanism.raceway;
        let contact = if side == BallContact::Inner { &raceway.inner } else { &raceway.outer };
        self.elastic += 0.4 * contact.hertz().stiffness * load.penetration.max(0.0).powf(2.5);
    }
}

/// The machine without a cage and without dissipation: smooth balls, undamped contacts and shaft.
fn conservative() -> Machine {
    let mut machine = motor_spindle();
    machine.rotor.shaft.damping_ratio = 0.0;
    for bearing in &mut machine.bearings {
        let scene = &mut bearing.scene;
        scene.lubricant.traction = TractionLaw::FourParameter { at_rest: 0.0, maximum: 0.0, at_slip: 1.0, limit: 0.0 };
        scene.raceway_damping = DampingLaw::None;
        for term in [Term::Cage, Term::Hydrodynamics, Term::Drag, Term::Churning] {
            scene.terms.set(term, TermChoice::Off);
        }
    }
    machine
}

/// A state near the start in which everything moves: balls by about a micrometre and 10 mm/s, the shaft bends and tilts.
fn disturbed(state: &[f64], dynamics: &MachineDynamics) -> Vec<f64> {
    let mut random = SplitMix64::new(7);
    let size = dynamics.frame.len();
    let of_frame = state.len() - 2 * size;
    let frequency = |k: usize| frequency_of(&dynamics.frame, k).max(1e3);
    let scale = |k: usize| match k {
        k if k < of_frame => 1e-6,
        k if k < of_frame + size => 1e-2 / frequency(k - of_frame),
        _ => 1e-2,
    };
    state.iter().enumerate().map(|(k, value)| value + scale(k) * (2.0 * random.uniform() - 1.0)).collect()
}

/// Rate of the energy along the motion [W], by central differences of order 4.
fn power(dynamics: &MachineDynamics, state: &[f64], turned: bool) -> f64 {
    let mut rates = vec![0.0; state.len()];
    dynamics.derivative(0.0, state, &mut rates);
    let at = |time: f64| {
        let moved: Vec<f64> = state.iter().zip(&rates).map(|(value, rate)| value + time * rate).collect();
        energy(dynamics, &moved, if turned { time } else { 0.0 })
    };
    let step = 2e-8;
    (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step)
}

/// Without dissipation the energy of balls, rings and a shaft that bends, tilts and turns does not change: to 1e-8 of the power that the
/// shaft alone exchanges. The unbalance is left out, because the drive works on it.
#[test]
fn the_shaft_gains_what_the_bearings_lose() {
    let mut machine = conservative();
    machine.rotor.unbalances.clear();
    let (dynamics, start) = started(&machine);
    let state = disturbed(&start, &dynamics);
    let (place, velocity) = dynamics.coordinates(&state);
    let mut rates = vec![0.0; state.len()];
    dynamics.derivative(0.0, &state, &mut rates);
    let (_, acceleration) = dynamics.coordinates(&rates);
    let exchanged: f64 = velocity.iter().zip(acceleration).map(|(v, a)| (v * a).abs()).sum();
    assert!(place.iter().any(|place| place.abs() > 1e-8) && exchanged > 1.0, "{exchanged}");
    let gained = power(&dynamics, &state, true);
    assert!(gained.abs() < 1e-8 * exchanged, "{gained:e} of {exchanged:e} W");
}

/// A machine at rest, whose balls have a hundredth of their mass: the linear analysis takes them without mass.
fn standing(mut machine: Machine) -> Machine {
    machine.rotor.unbalances.clear();
    machine.rotor.speed = 0.0;
    machine.speed = SpeedProfile::constant(0.0).unwrap();
    for bearing in &mut machine.bearings {
        bearing.scene.bearing.ball_mass *= 0.01;
        bearing.scene.bearing.ball_inertia *= 0.01;
    }
    machine
}

/// Largest deviation of the natural frequencies of all balls, rings and the shaft, mean over `places` starts of the balls in a ball spacing, from
/// those of the linear analysis [-].
fn deviation_of_frequencies(mut machine: Machine, modes: usize, places: usize) -> f64 {
    let request = Request { elements: Elements::Auto, speeds: vec![0.0], modes, sensors: Vec::new() };
    let linear = analyse(&machine.rotor, &request, &|| false).unwrap();
    let found: Vec<Vec<f64>> = (0..places)
        .map(|place| {
            for bearing in &mut machine.bearings {
                bearing.start_azimuth = 2.0 * PI / 9.0 * place as f64 / places as f64;
            }
            let (dynamics, state) = started(&machine);
            natural_frequencies(&dynamics, &state)
        })
        .collect();
    let deviation = |mode: &Mode| {
        let frequency = mode.point.frequency / (2.0 * PI);
        let nearest =
            |found: &Vec<f64>| found.iter().copied().min_by_key(|f| ((f / frequency - 1.0).abs() * 1e9) as u64);
        let mean = found.iter().filter_map(nearest).sum::<f64>() / places as f64;
        println!("{frequency} Hz: {mean}");
        (mean / frequency - 1.0).abs()
    };
    linear.operating_modes.iter().map(deviation).fold(0.0, f64::max)
}

/// Natural frequencies of all balls, rings and the shaft about a standing machine without traction are those of the linear analysis, which
/// takes the bearings by 5 × 5 matrices and their balls without mass, to 0.1 %. Both are means over a ball spacing. Balls have a hundredth of their
/// mass here; with all of it the axial mode is 0.28 % slower.
#[test]
fn slow_vibration_is_that_of_the_linear_analysis() {
    let deviation = deviation_of_frequencies(standing(conservative()), 10, 8);
    assert!(deviation < 1e-3, "{deviation:e}");
}

/// The mass of the motor spindle as a rigid body.
fn rigid(mut machine: Machine, tilts: bool) -> Machine {
    let shaft = &machine.rotor.shaft;
    let centre = shaft.mass_centre();
    let bar = shaft.mass() - 1.2;
    // A bar of 300 mm, and the disc in its middle.
    let transverse = bar * (0.3_f64.powi(2) / 12.0 + 0.025_f64.powi(2) / 16.0) + 8e-4;
    let inertia = SpindleInertia { transverse, axial: bar * 0.025_f64.powi(2) / 8.0 + 1.5e-3 };
    let motion = if tilts { ShaftMotion::Rigid } else { ShaftMotion::Upright };
    let body = SpindleBody { mass: shaft.mass(), centre, inertia };
    machine.rotor.shaft = Shaft::rigid(body, (0.3, 0.025), motion, true);
    machine
}

/// A shaft a million times as stiff moves as a rigid spindle, to 1e-4: linear frequencies, and the motion after 2 ms. Upright, it has three
/// coordinates, and its bearings feel no tilt.
#[test]
fn a_stiff_shaft_moves_as_a_rigid_spindle() {
    let machine = motor_spindle();
    let mut stiff = machine.clone();
    stiff.rotor.shaft.damping_ratio = 0.0;
    stiff.rotor.shaft.material.elastic_modulus *= 1e6;
    // The bearings keep their contacts: they have a material of their own.
    let rigid_spindle = rigid(machine.clone(), true);
    let request = Request { elements: Elements::Sections, speeds: vec![6000.0 * RPM], modes: 5, sensors: Vec::new() };
    let [one, other] = [&stiff, &rigid_spindle].map(|machine| analyse(&machine.rotor, &request, &|| false).unwrap());
    assert_eq!((one.operating_modes.len(), other.operating_modes.len()), (5, 5));
    for (a, b) in one.operating_modes.iter().zip(&other.operating_modes) {
        assert!((a.point.frequency / b.point.frequency - 1.0).abs() < 1e-4, "{:?} {:?}", a.point, b.point);
    }
    let [a, b] = [&stiff, &rigid_spindle].map(|machine| after(machine, 2e-3, 1e-6));
    for (one, other) in a.iter().zip(&b) {
        let size = one[..3].iter().fold(0.0, |most, value| f64::max(most, value.abs()));
        for axis in 0..3 {
            assert!((one[axis] - other[axis]).abs() < 1e-4 * size, "{a:?}, {b:?}");
        }
    }
    let (upright, state) = started(&rigid(machine, false));
    assert_eq!(upright.frame.len(), 3);
    assert!(upright.rings(0, upright.coordinates(&state).0, upright.coordinates(&state).1).inner.tilt == [0.0; 2]);
}

/// The motion of the shaft at each bearing after a time, in steps of a length.
fn after(machine: &Machine, time: f64, step: f64) -> Vec<[f64; 5]> {
    let (dynamics, state) = started(machine);
    let mut stepper = MachineStepper::new(&dynamics, 0.0, &state, StepLength { longest: step, share: 1.0 });
    while stepper.time() < time - 0.5 * step {
        stepper.advance();
    }
    dynamics.frame.ports.iter().map(|port| port.of_place(stepper.coordinates().0)).collect()
}

/// The mirror image of a machine moves as its mirror image: bearings change their facing, motion along X and tilts their sign.
#[test]
fn a_mirror_image_moves_as_such() {
    let mut machine = motor_spindle();
    machine.rotor.load = [40.0, 100.0, -30.0];
    machine.rotor.shaft.discs[0].at = 0.12;
    machine.rotor.unbalances[0].at = 0.2;
    let signs = [-1.0, 1.0, 1.0, -1.0, -1.0];
    let mut image = machine.clone();
    image.rotor.load[0] = -40.0;
    image.rotor.shaft.discs[0].at = 0.18;
    image.rotor.unbalances[0].at = 0.1;
    for bearing in &mut image.rotor.bearings {
        bearing.at = 0.3 - bearing.at;
        bearing.mounted.faces = match bearing.mounted.faces {
            Faces::PlusX => Faces::MinusX,
            Faces::MinusX => Faces::PlusX,
        };
        for (value, sign) in bearing.mounted.outer.iter_mut().zip(signs) {
            *value *= sign;
        }
    }
    let [one, other] = [&machine, &image].map(|machine| after(machine, 1e-3, 5e-6));
    for (one, other) in one.iter().zip(&other) {
        for ((value, mirrored), sign) in one.iter().zip(other).zip(signs) {
            assert!((value - sign * mirrored).abs() < 1e-12, "{one:?} {other:?}");
        }
        assert!(one[1].abs() > 1e-7 && one[0].abs() > 1e-7, "{one:?}");
    }
}

/// Largest errors of the places of all rings along some axes after 1 ms in steps of 5 and 2.5 µs, beside an integrator with error control [m].
fn errors_of_steps(machine: &Machine, axes: Range<usize>) -> [f64; 2] {
    let (dynamics, state) = started(machine);
    let time = 1e-3;
    let mut reference =
        Method::DormandPrince.start(&dynamics, 0.0, &state, Tolerances::uniform(state.len(), 1e-8, 1e-12), None);
    while reference.time() < time {
        reference.step(time).unwrap();
    }
    let place = dynamics.coordinates(reference.state()).0;
    let exact: Vec<[f64; 5]> = dynamics.frame.ports.iter().map(|port| port.of_place(place)).collect();
    let error = |step: f64| {
        let found = after(machine, time, step);
        assert_eq!(found.len(), exact.len());
        let pairs = found.iter().zip(&exact).flat_map(|(found, exact)| axes.clone().map(|k| (found[k], exact[k])));
        pairs.map(|(found, exact)| (found - exact).abs()).fold(0.0, f64::max)
    };
    [5e-6, 2.5e-6].map(error)
}

/// Fixed steps reach the motion of an integrator with error control; half the step leaves at most half of the error.
#[test]
fn fixed_steps_converge_to_the_motion() {
    let [long, half] = errors_of_steps(&motor_spindle(), 1..3);
    assert!(long < 1e-10 && half < 0.5 * long, "{long:e} {half:e}");
}

/// A shaft a million times as stiff on one bearing in its mass centre moves as the rigid spindle that tilts freely.
#[test]
fn a_very_stiff_shaft_is_a_rigid_spindle() {
    let mut machine = motor_spindle();
    machine.rotor.shaft.discs.clear();
    machine.rotor.shaft.material.elastic_modulus *= 1e6;
    machine.rotor.load = [300.0, 100.0, 0.0];
    machine.bearings.truncate(1);
    machine.rotor.bearings.truncate(1);
    machine.rotor.bearings[0].at = 0.15;
    machine.rotor.bearings[0].mounted.outer = [0.0; 5];
    machine.rotor.unbalances[0] = UnbalancePlane { at: 0.15, product: 5e-6, phase: 0.0 };
    let (dynamics, state) = started(&machine);
    let mut scene = machine.bearings[0].scene.clone();
    let mass = machine.rotor.shaft.mass();
    scene.spindle = Spindle {
        mass,
        unbalance: Unbalance::Product(5e-6),
        axial: AxialHold::Free,
        tilt: SpindleTilt::Free(SpindleInertia::of_cylinder(mass, 0.025, 0.3)),
    };
    scene.operation.load = machine.rotor.load;
    scene.gravity = machine.rotor.gravity;
    let terms = ActiveTerms::of(&scene, &Outputs::vibration(), Some(ModelLevel::Full)).unwrap();
    let model = Model::new(&scene, &terms);
    let layout = model.mechanism().layout;
    let (place, velocity) = dynamics.coordinates(&state);
    let mut of_spindle = dynamics.parts(&state)[0].to_vec();
    of_spindle.resize(layout.dimension(), 0.0);
    layout.set_spindle(&mut of_spindle, &dynamics.rings(0, place, velocity).inner);
    let time = 2e-3;
    let mut rigid = Method::DormandPrince.start(&model, 0.0, &of_spindle, layout.tolerances(1e-8), None);
    while rigid.time() < time {
        rigid.step(time).unwrap();
    }
    let expected = layout.spindle(rigid.state());
    let [x, y, z, about_y, about_z] = after(&machine, time, 2e-6)[0];
    let ([ex, ey, ez], [e_about_y, e_about_z]) = (expected.position, expected.tilt);
    for (found, expected) in [(x, ex), (y, ey), (z, ez), (about_y, e_about_y), (about_z, e_about_z)] {
        assert!((found - expected).abs() < 1e-9, "{found:e} {expected:e}");
    }
}

/// Frequencies of the oscillations about a state [Hz], rising, from differences of the equations.
fn natural_frequencies(dynamics: &MachineDynamics, state: &[f64]) -> Vec<f64> {
    let size = state.len();
    let mut rates = vec![0.0; size];
    let steps: Vec<f64> = vec![1e-9; size];
    let mut jacobian = DMatrix::zeros(size, size);
    for column in 0..size {
        let mut at = |sign: f64| {
            let mut moved = state.to_vec();
            moved[column] += sign * steps[column];
            dynamics.derivative(0.0, &moved, &mut rates);
            rates.clone()
        };
        let (after, before) = (at(1.0), at(-1.0));
        for row in 0..size {
            jacobian[(row, column)] = (after[row] - before[row]) / (2.0 * steps[column]);
        }
    }
    let values = jacobian.complex_eigenvalues();
    values.iter().filter(|value| value.im > 1.0).map(|value| value.im / (2.0 * PI)).collect()
}

/// A run records every signal. At a constant speed the motion at the disc is the linear response to unbalance.
#[test]
fn a_run_shows_the_response_to_unbalance() {
    let mut machine = motor_spindle();
    machine.sensors = vec![on_shaft("probe", 0.15, Axis::Y)];
    let contacts = [BallContact::Inner, BallContact::Outer];
    let of_balls: Vec<_> = (0..9).flat_map(|ball| contacts.map(|of| MachineChannel::BallLoad(0, ball, of))).collect();
    let settings = MachineSettings {
        settle: Some(0.05),
        duration: 0.05,
        step: None,
        range: RANGE,
        series: of_balls.clone(),
        envelope: ENVELOPE,
        band_edges: Vec::new(),
    };
    let result = simulate(&machine, &settings, &Control::until(&|| false)).unwrap();
    let request = Request { elements: Elements::Auto, speeds: vec![6000.0 * RPM], modes: 4, sensors: Vec::new() };
    let linear = analyse(&machine.rotor, &request, &|| false).unwrap();
    let place = linear.stations.iter().find(|station| (station.at - 0.15).abs() < 1e-9).unwrap();
    let amplitude = 1e6 * place.displacement[0][0].norm();
    let of = |name: &str| {
        let channel = MachineChannel::parse(name, &machine).unwrap();
        result.channels.iter().find(|(of, _)| *of == channel).map(|(_, metrics)| metrics.clone()).unwrap()
    };
    let seen = 2.0_f64.sqrt() * of("sensor.probe.displacement").rms;
    assert!((seen / amplitude - 1.0).abs() < 0.01, "{seen} µm, linear {amplitude} µm");
    let line = result.spectra.last().unwrap().lines.first().unwrap();
    assert!(line.label == "f_r" && (line.frequency - 100.0).abs() < 0.1, "{line:?}");
    // Each bearing carries half of weight and load.
    let carried = 0.5 * (100.0 + 9.81 * machine.rotor.shaft.mass());
    assert!((of("A.force.y").mean / carried - 1.0).abs() < 1e-3, "{} N", of("A.force.y").mean);
    // Ball 3 of A presses the outer raceway by its centrifugal force more; the largest load of all balls is that of the bearing.
    let load = |contact: &str| of(&format!("A.ball.3.{contact}.load"));
    assert!(load("outer").mean > load("inner").mean + 1.0, "{} N, {} N", load("outer").mean, load("inner").mean);
    let largest = result
        .series
        .iter()
        .zip(&of_balls)
        .filter(|(_, of)| matches!(of, MachineChannel::BallLoad(_, _, BallContact::Inner)));
    let largest = largest.flat_map(|((_, values), _)| values).fold(0.0_f64, |most, value| most.max(*value));
    assert!((largest / result.bearings[0].record.inner_load - 1.0).abs() < 1e-3, "{largest} N");
    assert_eq!(result.series.len(), of_balls.len());
    assert_eq!(result.accuracy.step, 5.5e-6);
    let worst = result.accuracy.errors.iter().filter_map(|(_, error)| *error).fold(0.0, f64::max);
    assert!(worst <= 0.1, "{:?}", result.accuracy);
}

/// Damping that turns along drives the whirl above its threshold speed: the run ends and names both. At a speed below the threshold it does not.
#[test]
fn whirl_that_its_damping_drives_ends_with_the_cause() {
    let mut machine = motor_spindle();
    (machine.rotor.shaft.damping_ratio, machine.rotor.shaft.rotating_share) = (0.05, 1.0);
    let settings = MachineSettings {
        settle: Some(0.0),
        duration: 0.5,
        step: None,
        range: RANGE,
        series: Vec::new(),
        envelope: ENVELOPE,
        band_edges: Vec::new(),
    };
    let mut growth = |speed: f64| {
        machine.rotor.speed = speed;
        machine.speed = SpeedProfile::constant(speed).unwrap();
        let dynamics = MachineDynamics::new(&machine, settings.range, &|| false).unwrap();
        check_growth(&machine, &dynamics, 0.0, 0.5).err()
    };
    let threshold_in = |error: &MachineError| match error {
        MachineError::Grows { decays_below: Some(speed), .. } => *speed,
        error => panic!("{error}"),
    };
    let error = growth(60_000.0 * RPM).unwrap();
    assert!(error.to_string().contains("rotating_share"), "{error}");
    let threshold = threshold_in(&error);
    assert_eq!(growth(0.98 * threshold), None);
    let above = threshold_in(&growth(1.02 * threshold).unwrap());
    assert!((above / threshold - 1.0).abs() < 1e-3, "{above} rad/s and {threshold} rad/s");
}

/// A support that couples both directions drives a whirl. Damping that turns beside it, but drives nothing, is not blamed.
#[test]
fn growth_is_blamed_on_its_cause() {
    let mut machine = motor_spindle();
    let mut stiffness = [[0.0; 5]; 5];
    (stiffness[1][2], stiffness[2][1]) = (2e7, -2e7);
    machine.rotor.supports = vec![Support { at: 0.15, on: None, stiffness, damping: [[0.0; 5]; 5] }];
    for share in [0.0, 1e-6] {
        machine.rotor.shaft.rotating_share = share;
        let dynamics = MachineDynamics::new(&machine, RANGE, &|| false).unwrap();
        let error = check_growth(&machine, &dynamics, 0.0, 0.5).unwrap_err().to_string();
        assert!(error.ends_with("a support pushes it (`supports`)"), "{share}: {error}");
    }
}
