//! Verification cases: closed forms, and two rotors that an independent finite-element program and ROSS 2.3.0 agree on in every
//! printed digit.

use std::f64::consts::PI;

use super::analysis::analyse;
use super::input::{Elements, Request, Rotor};
use super::omission::SystemTerm;
use super::result::{Direction, RotorResult};
use crate::physics::frame::beam::Tube;
use crate::physics::frame::disc::{Disc, UnbalancePlane};
use crate::physics::frame::housing::Housing;
use crate::physics::frame::shaft::{Section, Shaft, ShaftMotion};
use crate::physics::frame::support::{Support, diagonal};
use crate::physics::material::Material;

mod housing;
mod imported;

/// G = E / (2 (1 + ν)) = 81.2 GPa.
const STEEL: Material = Material { elastic_modulus: 211e9, poisson_ratio: 211.0 / (2.0 * 81.2) - 1.0, density: 7810.0 };
const RPM: f64 = PI / 30.0;

fn sections(parts: &[(usize, f64, f64, f64)]) -> Vec<Section> {
    let of = |&(count, length, outer_diameter, inner_diameter): &(usize, f64, f64, f64)| {
        vec![Section { length, tube: Tube { outer_diameter, inner_diameter } }; count]
    };
    parts.iter().flat_map(of).collect()
}

fn shaft(sections: Vec<Section>, discs: Vec<Disc>) -> Shaft {
    Shaft {
        material: STEEL,
        sections,
        discs,
        damping_ratio: 0.0,
        rotating_share: 0.0,
        is_axially_free: false,
        motion: ShaftMotion::Bends,
        has_gyroscopic_moments: true,
    }
}

fn rotor(shaft: Shaft, supports: Vec<Support>) -> Rotor {
    Rotor {
        shaft,
        unbalances: Vec::new(),
        supports,
        bearings: Vec::new(),
        housing: Housing::default(),
        speed: 0.0,
        gravity: 9.81,
        load: [0.0; 3],
        loads: Vec::new(),
    }
}

/// Stiffness and damping in Y and Z.
fn support(at: f64, stiffness: [f64; 2], damping: f64) -> Support {
    Support {
        at,
        on: None,
        stiffness: diagonal([0.0, stiffness[0], stiffness[1], 0.0, 0.0]),
        damping: diagonal([0.0, damping, damping, 0.0, 0.0]),
    }
}

fn clamp(at: f64) -> Support {
    Support { at, on: None, stiffness: diagonal([0.0, 1e13, 1e13, 1e11, 1e11]), damping: diagonal([0.0; 5]) }
}

fn analysed(rotor: &Rotor, elements: Elements, speeds: Vec<f64>, modes: usize) -> RotorResult {
    analyse(rotor, &Request { elements, speeds, modes, sensors: Vec::new() }, &|| false).unwrap()
}

/// Damped angular frequencies at a speed of the list [rad/s].
fn frequencies(result: &RotorResult, speed: usize) -> Vec<f64> {
    let mut found: Vec<f64> = result.modes.iter().map(|mode| mode.points[speed].unwrap().frequency).collect();
    found.sort_by(f64::total_cmp);
    found
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert!(found.len() >= expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found} instead of {expected}");
    }
}

fn hertz(rad_s: &[f64]) -> Vec<f64> {
    rad_s.iter().map(|value| value / (2.0 * PI)).collect()
}

/// Closed form of the simply supported Timoshenko beam, 25 × 300 mm, at rest and turning.
#[test]
fn simply_supported_bar_has_the_frequencies_of_the_closed_form() {
    let ends = [0.0, 0.3].map(|at| support(at, [1e13, 1e13], 0.0));
    let bar = rotor(shaft(sections(&[(1, 0.3, 0.025, 0.0)]), Vec::new()), ends.to_vec());
    let result = analysed(&bar, Elements::Auto, vec![0.0, 5000.0], 6);
    let at_rest = [562.286, 562.286, 2196.037, 2196.037, 4763.044, 4763.044];
    assert_close(&hertz(&frequencies(&result, 0)), &at_rest, 2e-4);
    assert_close(&hertz(&frequencies(&result, 1)), &[558.984, 565.607, 2183.873, 2208.255], 1e-4);
}

/// The tip of a cantilever under 1 N moves by 2.232 980 µm on any mesh.
#[test]
fn cantilever_has_the_exact_deflection_on_any_mesh() {
    for count in [1, 2, 7] {
        let shaft = shaft(sections(&[(count, 0.3 / count as f64, 0.025, 0.0)]), Vec::new());
        let mut bar = rotor(shaft, vec![clamp(0.0), support(0.3, [1.0, 1.0], 0.0)]);
        // An unbalance of 1 kg m at 1 rad/s is 1 N; inertia adds next to nothing at this speed.
        bar.unbalances = vec![UnbalancePlane { at: 0.3, product: 1.0, phase: 0.0 }];
        let result = analysed(&bar, Elements::Sections, vec![1.0], 2);
        let tip = result.stations.last().unwrap().displacement[0][0].re;
        // The spring of 1 N/m takes two millionths.
        assert!((tip / 2.232_980e-6 - 1.0).abs() < 5e-6, "{tip:e}");
    }
}

fn disc_in_the_middle() -> Rotor {
    let disc = Disc { at: 0.15, mass: 1.2, transverse_inertia: 8e-4, axial_inertia: 1.5e-3 };
    let supports = [0.04, 0.26].map(|at| support(at, [5e7, 5e7], 200.0));
    let mut rotor = rotor(shaft(sections(&[(30, 0.01, 0.025, 0.0)]), vec![disc]), supports.to_vec());
    rotor.unbalances = vec![UnbalancePlane { at: 0.15, product: 20e-6, phase: 0.0 }];
    rotor
}

/// Without gyroscopic moments no motion turns with the rotation or against it. On unequal supports the bounce of a centred disc is in a plane with
/// them, too, while it tilts forward and backward.
#[test]
fn motions_in_a_plane_have_no_direction() {
    let mut rotor = disc_in_the_middle();
    rotor.shaft.material.density = 1e-3;
    rotor.supports = [0.04, 0.26].map(|at| support(at, [5e7, 4e7], 0.0)).to_vec();
    let directions = |rotor: Rotor| -> Vec<Direction> {
        let result = analysed(&rotor, Elements::Sections, vec![2000.0], 4);
        result.modes.iter().map(|mode| mode.points[0].unwrap()).map(|point| point.direction).collect()
    };
    let found = directions(rotor.clone());
    assert_eq!(found[..2], [Direction::Planar; 2], "{found:?}");
    assert!(found.contains(&Direction::Forward) && found.contains(&Direction::Backward), "{found:?}");
    assert_eq!(directions(rotor.without(SystemTerm::Gyroscopic)), [Direction::Planar; 4]);
}

/// Bar with a disc in the middle on two equal supports: frequencies, damping, critical speeds, unbalance response.
#[test]
fn disc_in_the_middle_agrees_with_two_other_programs() {
    let speeds: Vec<f64> = [0.0, 6000.0, 12_000.0, 18_000.0, 24_000.0, 30_000.0].map(|rpm| rpm * RPM).to_vec();
    let result = analysed(&disc_in_the_middle(), Elements::Sections, speeds, 8);
    assert!((result.mass - 2.350_12).abs() < 5e-6);
    let at_rest = [479.448, 479.448, 1681.937, 1681.937, 2006.030, 2006.030, 2422.913, 2422.913];
    assert_close(&hertz(&frequencies(&result, 0)), &at_rest, 1e-6);
    let damping: Vec<f64> = result.modes.iter().map(|mode| mode.points[0].unwrap().damping_ratio).collect();
    let expected = [0.00102, 0.00102, 0.01692, 0.01692, 0.01966, 0.01966, 0.00452, 0.00452];
    assert!(damping.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 5e-6), "{damping:?}");
    let turning = [478.545, 480.350, 1567.076, 1767.981, 2001.751, 2010.308, 2289.108, 2607.341];
    assert_close(&hertz(&frequencies(&result, 4)), &turning, 1e-6);
    let directions: Vec<_> = result.modes.iter().map(|mode| mode.points[4].unwrap().direction).collect();
    assert_eq!(directions.iter().filter(|direction| **direction == Direction::Forward).count(), 4);
    let criticals: Vec<f64> = result.criticals.iter().map(|critical| critical.speed / RPM).collect();
    assert!(criticals.len() == 2);
    assert_close(&criticals, &[28_702.0, 28_832.0], 2e-5);
    let directions = result.criticals.iter().map(|critical| critical.mode.point.direction);
    assert_eq!(directions.collect::<Vec<_>>(), [Direction::Backward, Direction::Forward]);
    let response = |station: usize, speed: usize| result.stations[station].displacement[speed][0].norm() * 1e6;
    let at_disc: Vec<f64> = (1..5).map(|speed| response(1, speed)).collect();
    assert_close(&at_disc, &[0.547_845, 2.535_067, 7.724_406, 27.270_72], 2e-6);
    assert_close(&[response(0, 1), response(0, 4)], &[0.082_741, 4.286_790], 7e-6);
}

/// Overhung disc on a hollow shaft with unequal supports.
#[test]
fn overhung_disc_on_unequal_supports_agrees_with_two_other_programs() {
    let parts = sections(&[(2, 0.02, 0.03, 0.0), (8, 0.02, 0.04, 0.012), (3, 0.02, 0.035, 0.012)]);
    let disc = Disc { at: 0.26, mass: 2.5, transverse_inertia: 4e-3, axial_inertia: 7e-3 };
    let supports = vec![support(0.06, [1.0e8, 1.5e8], 500.0), support(0.18, [2.0e8, 2.6e8], 800.0)];
    let rotor = rotor(shaft(parts, vec![disc]), supports);
    let result = analysed(&rotor, Elements::Sections, vec![0.0, 1500.0, 3000.0, 4000.0], 6);
    assert_close(&hertz(&frequencies(&result, 0)), &[446.804, 474.458, 1533.621], 2e-6);
    let turning = [382.978, 532.761, 1338.523, 1668.489, 1937.944, 2016.615];
    assert_close(&hertz(&frequencies(&result, 2)), &turning, 2e-6);
    let criticals: Vec<f64> = result.criticals.iter().map(|critical| critical.speed / RPM).collect();
    assert_close(&criticals, &[23_739.0, 32_465.0], 3e-5);
}

/// The example rotor of ROSS, printed in its issue 599 [rad/s].
#[test]
fn example_of_ross_has_its_printed_frequencies() {
    let (width, inner, outer) = (0.07_f64, 0.05_f64, 0.28_f64);
    let squares = outer * outer + inner * inner;
    let mass = STEEL.density * PI * width * (outer * outer - inner * inner) / 4.0;
    let disc = |at| Disc {
        at,
        mass,
        transverse_inertia: mass * (squares / 16.0 + width * width / 12.0),
        axial_inertia: mass * squares / 8.0,
    };
    let supports = [0.0, 1.5].map(|at| support(at, [1e6, 0.8e6], 0.0)).to_vec();
    let rotor = rotor(shaft(sections(&[(6, 0.25, 0.05, 0.0)]), vec![disc(0.5), disc(1.0)]), supports);
    let result = analysed(&rotor, Elements::Sections, vec![0.0], 6);
    let mut printed = [91.797, 96.289, 274.566, 296.5, 722.898, 765.0];
    printed.sort_by(f64::total_cmp);
    assert_close(&frequencies(&result, 0), &printed, 1e-3);
}

/// Overhung disc on a massless cantilever of 20 × 200 mm: 3 kg, I_t 6·10⁻³, I_p 1.1·10⁻² kg m².
struct Overhung {
    /// Stiffness over displacement and slope of the tip: of displacement, mixed, of slope.
    stiffness: [f64; 3],
}

impl Overhung {
    /// From the compliances L³/3EI + L/κGA, L²/2EI, L/EI; without shear the closed form of text books.
    fn new(has_shear: bool) -> Self {
        let (length, tube) = (0.2_f64, Tube { outer_diameter: 0.02, inner_diameter: 0.0 });
        let bending = STEEL.elastic_modulus * tube.second_moment();
        let shear = 81.2e9 * tube.shear_coefficient(STEEL.poisson_ratio) * tube.area();
        let tip = length.powi(3) / (3.0 * bending) + if has_shear { length / shear } else { 0.0 };
        let (mixed, slope) = (length.powi(2) / (2.0 * bending), length / bending);
        let determinant = tip * slope - mixed * mixed;
        Self { stiffness: [slope / determinant, -mixed / determinant, tip / determinant] }
    }

    /// Zero where the disc whirls with ω at speed Ω, negative ω backward: (k₁₁ − m ω²)(k₂₂ − I_t ω² + I_p Ω ω) − k₁₂².
    fn characteristic(&self, whirl: f64, speed: f64) -> f64 {
        let [k11, k12, k22] = self.stiffness;
        let square = whirl * whirl;
        (k11 - 3.0 * square) * (k22 - 6e-3 * square + 1.1e-2 * speed * whirl) - k12 * k12
    }

    fn is_whirl(&self, whirl: f64, speed: f64, tolerance: f64) -> bool {
        let beside = |sign: f64| self.characteristic(whirl * (1.0 + sign * tolerance), speed);
        beside(-1.0) * beside(1.0) < 0.0
    }

    fn is_critical(&self, speed: f64, direction: Direction, tolerance: f64) -> bool {
        let sign = if direction == Direction::Forward { 1.0 } else { -1.0 };
        let beside = |side: f64| {
            let speed = speed * (1.0 + side * tolerance);
            self.characteristic(sign * speed, speed)
        };
        beside(-1.0) * beside(1.0) < 0.0
    }
}

/// The closed form has its four known whirls at 1000 rad/s; the elements have those of the closed form with shear, and its critical
/// speeds: only one is forward.
#[test]
fn overhung_disc_on_a_massless_shaft_has_the_whirls_of_the_closed_form() {
    let slender = Overhung::new(false);
    assert!([-1854.481, -335.796, 525.256, 3498.354].iter().all(|whirl| slender.is_whirl(*whirl, 1000.0, 2e-6)));
    assert!(slender.is_critical(477.279, Direction::Forward, 2e-6));
    assert!([392.291, 1619.981].iter().all(|speed| slender.is_critical(*speed, Direction::Backward, 2e-6)));

    let disc = Disc { at: 0.2, mass: 3.0, transverse_inertia: 6e-3, axial_inertia: 1.1e-2 };
    // A sixteenth of a gram in all, and a clamp that gives by as little: neither exceeds 10⁻⁴ of the frequencies.
    let massless = Material { density: 1.0, ..STEEL };
    let shaft = Shaft { material: massless, ..shaft(sections(&[(8, 0.025, 0.02, 0.0)]), vec![disc]) };
    let clamp = Support { stiffness: diagonal([0.0, 1e12, 1e12, 1e10, 1e10]), ..clamp(0.0) };
    let rotor = rotor(shaft, vec![clamp]);
    let result = analysed(&rotor, Elements::Sections, vec![0.0, 500.0, 1000.0, 1500.0, 2000.0], 4);
    let closed = Overhung::new(true);
    for point in result.modes.iter().map(|mode| mode.points[2].unwrap()) {
        let whirl = if point.direction == Direction::Forward { point.frequency } else { -point.frequency };
        assert!(closed.is_whirl(whirl, 1000.0, 1e-4), "{whirl}");
    }
    let criticals: Vec<(f64, Direction)> =
        result.criticals.iter().map(|critical| (critical.speed, critical.mode.point.direction)).collect();
    assert!(criticals.iter().all(|(speed, direction)| closed.is_critical(*speed, *direction, 1e-4)), "{criticals:?}");
    let directions: Vec<_> = criticals.iter().map(|critical| critical.1).collect();
    assert_eq!(directions, [Direction::Backward, Direction::Forward, Direction::Backward]);
}

/// Damping that turns along makes a disc on a simply supported shaft unstable from Ω = ω (1 + c_e/c_i); both dampings are taken from
/// the decay at rest.
#[test]
fn rotating_damping_has_its_threshold_speed() {
    let disc = Disc { at: 0.2, mass: 10.0, transverse_inertia: 1e-2, axial_inertia: 2e-2 };
    let held = [0.0, 0.4].map(|at| support(at, [1e12, 1e12], 0.0));
    let outside = support(0.2, [0.0, 0.0], 60.0);
    let at = |speed: f64, supports: &[Support], damping_ratio: f64| {
        let shaft =
            Shaft { damping_ratio, rotating_share: 1.0, ..shaft(sections(&[(8, 0.05, 0.03, 0.0)]), vec![disc]) };
        let rotor = Rotor { speed, ..rotor(shaft, supports.to_vec()) };
        analysed(&rotor, Elements::Sections, vec![speed], 4)
    };
    let decay = |result: &RotorResult| {
        let point = result.modes[0].points[0].unwrap();
        (point.damping_ratio * point.frequency, point.frequency)
    };
    let with_outside = [held[0], held[1], outside];
    let (external, _) = decay(&at(0.0, &with_outside, 0.0));
    let (internal, frequency) = decay(&at(0.0, &held, 0.01));
    let threshold = frequency * (1.0 + external / internal);
    assert!(external > 0.05 * internal);
    assert!(at(0.999 * threshold, &with_outside, 0.01).growth_rate < 0.0);
    assert!(at(1.001 * threshold, &with_outside, 0.01).growth_rate > 0.0);
}

/// The supports carry the weight and the load; the shaft hangs through in the direction of both.
#[test]
fn supports_carry_weight_and_load() {
    let mut rotor = disc_in_the_middle();
    rotor.load = [0.0, 100.0, -40.0];
    let result = analysed(&rotor, Elements::Sections, vec![0.0], 8);
    let sum = |axis: usize| result.supports.iter().map(|support| support.at_rest[axis]).sum::<f64>();
    assert!((sum(1) - 100.0 - 9.81 * result.mass).abs() < 1e-6 && (sum(2) + 40.0).abs() < 1e-6);
    let middle = result.deflection[15];
    assert!(middle[1] > result.deflection[4][1] && middle[2] < 0.0);
}

/// Halving the range of the basis or the elements moves no kept frequency by more than the stated share.
#[test]
fn automatic_elements_have_converged() {
    let mut rotor = disc_in_the_middle();
    rotor.shaft.sections = sections(&[(1, 0.3, 0.025, 0.0)]);
    let automatic = analysed(&rotor, Elements::Auto, vec![0.0], 8);
    rotor.shaft.sections = sections(&[(240, 0.00125, 0.025, 0.0)]);
    let fine = analysed(&rotor, Elements::Sections, vec![0.0], 8);
    assert_close(&frequencies(&automatic, 0), &frequencies(&fine, 0), 1e-4);
}

/// A damper that pushes makes the rotor unstable, also where its motion grows without oscillating.
#[test]
fn growth_without_oscillation_is_unstable() {
    let of = |damping: f64| {
        let held = [0.0, 0.3].map(|at| support(at, [5e7, 5e7], damping));
        analysed(&rotor(shaft(sections(&[(1, 0.3, 0.025, 0.0)]), vec![]), held.to_vec()), Elements::Auto, vec![0.0], 2)
    };
    assert!(of(200.0).growth_rate < 0.0);
    assert!(of(-200.0).growth_rate > 0.0 && of(-1e5).growth_rate > 1e5);
}

/// A bar of 300 × 25 mm at 14 000 r/min on supports that damp its tilt above the critical damping: the lowest natural frequencies are those of
/// twice as many. Matrices of few modes have pairs of the damping ratio 1, whose damped frequencies of 42 and 373 Hz no richer model has.
#[test]
fn overdamped_tilt_adds_no_oscillation() {
    let held = |at: f64| Support {
        at,
        on: None,
        stiffness: diagonal([0.0, 50e6, 50e6, 2e3, 2e3]),
        damping: diagonal([0.0, 0.0, 0.0, 5.0, 5.0]),
    };
    let bar = shaft(sections(&[(1, 0.3, 0.025, 0.0)]), Vec::new());
    let rotor = Rotor { speed: 14_000.0 * RPM, ..rotor(bar, vec![held(0.04), held(0.26)]) };
    let of_modes = |count: usize| -> Vec<f64> {
        let result = analysed(&rotor, Elements::Auto, vec![rotor.speed], count);
        result.operating_modes.iter().map(|mode| mode.point.frequency).collect()
    };
    let (few, many) = (of_modes(8), of_modes(16));
    assert_eq!(few.len(), 8);
    assert_close(&few, &many[..8], 1e-3);
    assert!(few[0] > 2.0 * PI * 900.0, "{few:?}");
}
