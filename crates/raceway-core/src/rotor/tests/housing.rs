//! Housing bodies, mounts and seats: closed form, limits, mirror images, and motions that nothing restrains.

use super::*;
use crate::physics::contact::damping::DampingFactor;
use crate::physics::frame::housing::{Body, Mount};
use crate::physics::kinematics::RingSpeeds;
use crate::physics::presets;
use crate::physics::statics::RingBearing;
use crate::physics::statics::shaft::{Faces, Mounted, Spring};
use crate::rotor::input::{RotorBearing, Seat};
use crate::rotor::restraint::{FreeMotion, Owner, free_motion};
use crate::simulation::input::scene::Scene;

pub(super) fn mount(body: usize, at: f64, stiffness: [f64; 5]) -> Mount {
    Mount { body, to: None, at, stiffness: diagonal(stiffness), damping: diagonal([0.0; 5]) }
}

/// A bar of 25 × 300 mm with a disc off its middle on two 6205 that face outwards, which may be displaced along X by half a length.
fn on_ball_bearings(apart: f64) -> Rotor {
    let scene = Scene::of_preset(&presets::bearing("6205").unwrap(), 0.0, [0.0; 3]).unwrap();
    let bearing = |(at, faces): (f64, Faces)| {
        let mut mounted = Mounted::new(RingBearing::new(&scene.bearing), 0.0, faces);
        mounted.outer[0] = if faces == Faces::PlusX { -apart } else { apart };
        let damping = DampingFactor { chi: 1.0, viscous: 0.0 };
        RotorBearing { at, mounted, damping, on: None, seat: Seat::Rigid, has_moments: true }
    };
    let disc = Disc { at: 0.13, mass: 1.2, transverse_inertia: 8e-4, axial_inertia: 1.5e-3 };
    let mut rotor = rotor(shaft(sections(&[(1, 0.3, 0.025, 0.0)]), vec![disc]), Vec::new());
    rotor.bearings = [(0.04, Faces::PlusX), (0.26, Faces::MinusX)].map(bearing).to_vec();
    rotor.shaft.is_axially_free = true;
    rotor.load = [0.0, 100.0, 0.0];
    rotor
}

/// 6205 under 200 N of preload.
pub(super) fn preloaded() -> Rotor {
    let mut rotor = on_ball_bearings(0.0);
    let pair = rotor.bearings.iter().map(|bearing| bearing.mounted.clone()).collect();
    let pair = crate::physics::statics::shaft::RigidShaft { bearings: pair }.preloaded_by_force([0, 1], 200.0).unwrap();
    rotor.bearings.iter_mut().zip(pair.bearings).for_each(|(bearing, mounted)| bearing.mounted = mounted);
    rotor
}

/// Both bearings in one body.
pub(super) fn in_body(mut rotor: Rotor, body: Body, stiffness: [f64; 5]) -> Rotor {
    rotor.bearings.iter_mut().for_each(|bearing| bearing.on = Some(0));
    rotor.housing = Housing { bodies: vec![body], mounts: vec![mount(0, body.at, stiffness)], structure: None };
    rotor
}

pub(super) fn at_rest(rotor: &Rotor, modes: usize) -> RotorResult {
    analysed(rotor, Elements::Auto, vec![0.0], modes)
}

/// A mass of 10 kg in the middle of a shaft of 4 MN/m on two bearings of 10⁸ N/m, each on a pedestal of 5 kg and 5·10⁷ N/m.
#[test]
fn pedestals_have_the_frequencies_of_the_closed_form() {
    // The deflection of the middle with shear: L³/48EI + L/4κGA.
    let (tube, length) = (Tube { outer_diameter: 0.03, inner_diameter: 0.0 }, 0.5_f64);
    let compliance = length.powi(3) / (48.0 * tube.second_moment())
        + length / (4.0 * tube.shear_coefficient(0.3) * tube.area() / 2.6);
    let material = Material { elastic_modulus: 4e6 * compliance, poisson_ratio: 0.3, density: 1.0 };
    let disc = Disc { at: 0.25, mass: 10.0, transverse_inertia: 0.0, axial_inertia: 0.0 };
    let shaft = Shaft { material, ..shaft(sections(&[(2, 0.25, 0.03, 0.0)]), vec![disc]) };
    let supports = [0.0, 0.5].map(|at| support(at, [1e8, 1e8], 0.0));
    let mut rotor = rotor(shaft, supports.to_vec());
    let body = |at: f64| Body { at, mass: 5.0, inertia: [0.01; 2] };
    for (index, at) in [0.0, 0.5].into_iter().enumerate() {
        rotor.supports[index].on = Some(index);
        rotor.housing.bodies.push(body(at));
        rotor.housing.mounts.push(mount(index, at, [5e7, 5e7, 5e7, 1e6, 1e6]));
    }
    // Between them stand the motions of the pedestals along X and against each other, at 503 Hz.
    let result = at_rest(&rotor, 10);
    let found = hertz(&frequencies(&result, 0));
    for expected in [97.696, 513.445] {
        let near = found.iter().filter(|found| (**found / expected - 1.0).abs() < 1e-4).count();
        assert_eq!(near, 2, "{expected}: {found:?}");
    }
    // The mounts carry everything.
    let carried: f64 = result.mounts.iter().map(|mount| mount.at_rest[1]).sum();
    assert!((carried / (9.81 * 20.0) - 1.0).abs() < 1e-4, "{carried}");
    assert!((result.bodies[0].at_rest[1] / (9.81 * 10.0 / 5e7) - 1.0).abs() < 1e-4);
}

/// Mounts far stiffer than all else, and a body far heavier than all else, are the ground; so is a very stiff seat.
#[test]
fn stiff_mounts_heavy_bodies_and_stiff_seats_are_the_ground() {
    let ground = Rotor { gravity: 0.0, ..preloaded() };
    let expected = hertz(&frequencies(&at_rest(&ground, 8), 0));
    let is_ground = |rotor: &Rotor, count: usize, below: usize| {
        let found = hertz(&frequencies(&at_rest(rotor, count), 0));
        assert_close(&found[below..], &expected[..count.min(8) - below], 1e-4);
    };
    let body = Body { at: 0.17, mass: 8.0, inertia: [0.05; 2] };
    is_ground(&in_body(ground.clone(), body, [1e13, 1e13, 1e13, 1e12, 1e12]), 8, 0);
    // Five slow motions of the body itself come before.
    let heavy = Body { mass: 1e7, inertia: [1e6; 2], ..body };
    let floating = in_body(ground.clone(), heavy, [1e6; 5]);
    is_ground(&floating, 10, 5);
    let mut stiff = ground.clone();
    for bearing in &mut stiff.bearings {
        let (stiffness, damping) = (diagonal([1e13, 1e13, 1e13, 1e10, 1e10]), diagonal([0.0; 5]));
        bearing.seat = Seat::Elastic { mass: 0.05, inertia: 2e-5, polar: 4e-5, stiffness, damping };
    }
    is_ground(&stiff, 8, 0);
}

/// A soft seat and a soft mount in a row are one spring, where the ring has no mass.
#[test]
fn a_seat_and_a_mount_in_a_row_are_one_spring() {
    let seat = |stiffness: f64, tilt: f64| Seat::Elastic {
        mass: 1e-6,
        inertia: 1e-6,
        polar: 1e-6,
        stiffness: diagonal([stiffness, stiffness, stiffness, tilt, tilt]),
        damping: diagonal([0.0; 5]),
    };
    let mut one = preloaded();
    one.bearings[0].seat = seat(2e7, 1e8);
    let mut other = preloaded();
    (other.bearings[0].seat, other.bearings[0].on) = (seat(4e7, 2e8), Some(0));
    let body = Body { at: 0.04, mass: 1e-6, inertia: [1e-6; 2] };
    other.housing =
        Housing { bodies: vec![body], mounts: vec![mount(0, 0.04, [4e7, 4e7, 4e7, 2e8, 2e8])], structure: None };
    let [one, other] = [one, other].map(|rotor| at_rest(&rotor, 8));
    assert_close(&frequencies(&one, 0), &frequencies(&other, 0), 1e-5);
}

/// A spring on a sliding ring has its force at rest, however stiff it is. Both bearings carry it, and their stiffness is that of a rigid preload
/// of the same force.
#[test]
fn a_spring_preloads_both_bearings() {
    [1.0, 1e5, 1e7].into_iter().for_each(preloads_as_a_rigid_one);
}

fn preloads_as_a_rigid_one(stiffness: f64) {
    let mut sprung = on_ball_bearings(0.0);
    sprung.load = [0.0; 3];
    sprung.gravity = 0.0;
    sprung.bearings[1].seat = Seat::Sliding { mass: 0.05, spring: Spring { force: 200.0, stiffness }, damping: 0.0 };
    let mut rigid = preloaded();
    (rigid.load, rigid.gravity) = ([0.0; 3], 0.0);
    // A shaft that does not give along X.
    for rotor in [&mut sprung, &mut rigid] {
        rotor.shaft.material.elastic_modulus *= 1e4;
    }
    let [sprung, rigid] = [sprung, rigid].map(|rotor| at_rest(&rotor, 8));
    for (sprung, rigid) in sprung.supports.iter().zip(&rigid.supports) {
        assert!((sprung.at_rest[0] / rigid.at_rest[0] - 1.0).abs() < 1e-5, "{:?} {:?}", sprung.at_rest, rigid.at_rest);
        assert!((rigid.at_rest[0].abs() / 200.0 - 1.0).abs() < 1e-5);
    }
    for (sprung, rigid) in sprung.bearings.iter().zip(&rigid.bearings) {
        for k in 0..3 {
            assert!((sprung.stiffness[k][k] / rigid.stiffness[k][k] - 1.0).abs() < 1e-4, "{k}");
        }
    }
}

/// The mirror image of a skew scene has the same frequencies; motions along X and tilts change their sign.
#[test]
fn a_mirror_image_has_mirrored_bodies() {
    let mirrored = |sign: f64| {
        let at = |at: f64| if sign > 0.0 { at } else { 0.3 - at };
        let mut rotor = on_ball_bearings(0.0);
        rotor.shaft.discs[0].at = at(0.13);
        rotor.load = [sign * 40.0, 100.0, -30.0];
        rotor.speed = 600.0;
        rotor.unbalances = vec![UnbalancePlane { at: at(0.13), product: 2e-5, phase: 0.4 }];
        for bearing in &mut rotor.bearings {
            bearing.at = at(bearing.at);
            if sign < 0.0 {
                let turned = if bearing.mounted.faces == Faces::PlusX { Faces::MinusX } else { Faces::PlusX };
                bearing.mounted.faces = turned;
            }
        }
        let spring = Spring { force: 150.0, stiffness: 5e4 };
        rotor.bearings[1].seat = Seat::Sliding { mass: 0.06, spring, damping: 5.0 };
        let (stiffness, damping) = (diagonal([2e8, 1e8, 1e8, 1e5, 1e5]), diagonal([50.0; 5]));
        rotor.bearings[0].seat = Seat::Elastic { mass: 0.06, inertia: 3e-5, polar: 6e-5, stiffness, damping };
        rotor.bearings.iter_mut().for_each(|bearing| bearing.on = Some(0));
        let body = Body { at: at(0.1), mass: 6.0, inertia: [0.02, 0.05] };
        let held = Mount { damping: diagonal([300.0; 5]), ..mount(0, at(0.2), [3e7, 2e7, 5e7, 1e5, 2e5]) };
        rotor.housing = Housing { bodies: vec![body], mounts: vec![held], structure: None };
        analysed(&rotor, Elements::Auto, vec![0.0, 600.0], 10)
    };
    let [one, other] = [1.0, -1.0].map(mirrored);
    for speed in [0, 1] {
        assert_close(&frequencies(&one, speed), &frequencies(&other, speed), 1e-8);
    }
    let signs = [-1.0, 1.0, 1.0, -1.0, -1.0];
    let (one, other) = (&one.bodies[0], &other.bodies[0]);
    for ((one, other), sign) in one.at_rest.iter().zip(other.at_rest).zip(signs) {
        assert!((one - sign * other).abs() < 1e-6 * one.abs() && *one != 0.0, "{one:e} {other:e}");
    }
    for ((one, other), sign) in one.response[1].iter().zip(other.response[1]).zip(signs) {
        assert!((one - sign * other).norm() < 1e-6 * one.norm(), "{one} {other}");
    }
}

/// A ring that turns on its own seat, beside a shaft that it does not touch. Its tilt has the frequencies of a gyroscope on a spring,
/// I_p Ω/2 I_t ± √((I_p Ω/2 I_t)² + k/I_t), and the damping of its seat drives a whirl above √(k/m).
#[test]
fn a_ring_that_turns_on_its_seat_is_a_rotor() {
    let mut rotor = on_ball_bearings(0.0);
    (rotor.load, rotor.gravity, rotor.shaft.is_axially_free) = ([0.0; 3], 0.0, false);
    rotor.bearings.truncate(1);
    rotor.supports = vec![support(0.05, [1e9; 2], 1e4), support(0.25, [1e9; 2], 1e4)];
    rotor.shaft.damping_ratio = 0.01;
    let (mass, inertia, polar, radial, tilt) = (0.06, 3e-5, 5e-5, 3e5, 120.0);
    let on_seat = |speed: f64, damping: f64| {
        let mut rotor = rotor.clone();
        let stiffness = diagonal([radial, radial, radial, tilt, tilt]);
        let damping = diagonal([damping, damping, damping, 1e-3 * damping, 1e-3 * damping]);
        rotor.bearings[0].seat = Seat::Elastic { mass, inertia, polar, stiffness, damping };
        let rotor = rotor.at_speeds(RingSpeeds { inner: 0.0, outer: speed });
        analysed(&rotor, Elements::Auto, vec![0.0], 5)
    };
    let speed = 1000.0;
    let half = 0.5 * polar * speed / inertia;
    let whole = (half * half + tilt / inertia).sqrt();
    let translation = (radial / mass).sqrt();
    let mut expected = [whole - half, whole + half, translation, translation, translation];
    expected.sort_by(f64::total_cmp);
    let found = on_seat(speed, 0.0).operating_modes;
    for (mode, expected) in found.iter().zip(expected) {
        let found = mode.point.frequency;
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    }
    for (share, grows) in [(0.0, false), (0.98, false), (1.02, true)] {
        let rate = on_seat(share * translation, 20.0).growth_rate;
        assert_eq!(rate > 0.0, grows, "at {share} of the frequency: {rate} 1/s");
    }
}

/// Motions that nothing restrains are named by the body that makes them.
#[test]
fn free_motions_are_named() {
    let body = Body { at: 0.15, mass: 8.0, inertia: [0.05; 2] };
    let with = |stiffness: [f64; 5]| free_motion(&in_body(preloaded(), body, stiffness));
    assert_eq!(with([1e3, 1e3, 1e3, 1.0, 1.0]), None);
    let moves = |displacement| Some(FreeMotion::Beside(Owner::Part(0), displacement));
    assert_eq!(with([0.0, 1e7, 1e7, 1e5, 1e5]), moves(0));
    assert_eq!(with([1e7, 0.0, 1e7, 1e5, 1e5]), moves(1));
    assert_eq!(with([1e7, 1e7, 0.0, 1e5, 1e5]), moves(2));
    // The tilt of a body with its bearings about the mount.
    assert!(matches!(with([1e7, 1e7, 1e7, 1e5, 0.0]), Some(FreeMotion::Beside(Owner::Part(0), _))));
    // Bearings hold a body on a shaft that stands on the ground.
    let mut on_ground = in_body(preloaded(), body, [1e7, 0.0, 0.0, 0.0, 0.0]);
    on_ground.supports = vec![clamp(0.15)];
    assert_eq!(free_motion(&on_ground), None);
    assert_eq!(free_motion(&rotor(preloaded().shaft, vec![support(0.0, [1e7, 1e7], 0.0)])), Some(FreeMotion::Shaft));
}
