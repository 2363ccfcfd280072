//! Shafts that clearance leaves loose: closed forms, limits and mirror images.

use std::f64::consts::{PI, TAU};

use super::OperatingPoint;
use crate::physics::bearing::{Bearing, Fit};
use crate::physics::contact::damping::DampingFactor;
use crate::physics::contact::hertz::raceway_contacts;
use crate::physics::frame::beam::Tube;
use crate::physics::frame::disc::Disc;
use crate::physics::frame::housing::Housing;
use crate::physics::frame::mesh::Mesh;
use crate::physics::frame::shaft::{Section, Shaft, ShaftMotion};
use crate::physics::frame::support::{Support, diagonal};
use crate::physics::material::Material;
use crate::physics::presets;
use crate::physics::statics::RingBearing;
use crate::physics::statics::shaft::{Faces, Mounted};
use crate::rotor::input::{NoEquilibrium, Rotor, RotorBearing, RotorError, Seat};
use crate::rotor::system::System;
use crate::simulation::input::scene::Scene;

const STEEL: Material = Material { elastic_modulus: 208e9, poisson_ratio: 0.3, density: 7810.0 };
const RPM: f64 = PI / 30.0;

fn of_preset(name: &str) -> Bearing {
    Scene::of_preset(&presets::bearing(name).unwrap(), 0.0, [0.0; 3]).unwrap().bearing
}

fn with_clearance(preset: &str, clearance: f64) -> Bearing {
    let mut parameters = of_preset(preset).parameters;
    parameters.fit = Fit::RadialClearance(clearance);
    Bearing::new(parameters).unwrap()
}

fn mounted(bearing: &Bearing, at: f64, faces: Faces) -> RotorBearing {
    RotorBearing {
        at,
        mounted: Mounted::new(RingBearing::new(bearing), 0.0, faces),
        damping: DampingFactor { chi: 1.0, viscous: 0.0 },
        on: None,
        seat: Seat::Rigid,
        has_moments: true,
    }
}

/// A bar of a length and diameter with a disc of 10 kg in its middle, held along the axis.
fn bar(length: f64, diameter: f64, bearings: Vec<RotorBearing>) -> Rotor {
    Rotor {
        shaft: Shaft {
            material: STEEL,
            sections: vec![Section { length, tube: Tube { outer_diameter: diameter, inner_diameter: 0.0 } }],
            discs: vec![Disc { at: 0.5 * length, mass: 10.0, transverse_inertia: 5e-3, axial_inertia: 1e-2 }],
            damping_ratio: 0.005,
            rotating_share: 0.0,
            is_axially_free: false,
            motion: ShaftMotion::Bends,
            has_gyroscopic_moments: true,
        },
        unbalances: Vec::new(),
        loads: Vec::new(),
        supports: Vec::new(),
        bearings,
        housing: Housing::default(),
        speed: 0.0,
        gravity: 9.81,
        load: [0.0; 3],
    }
}

fn analysed(rotor: &Rotor) -> Result<System, RotorError> {
    let supports = rotor.supports.iter().map(|support| support.at);
    let discs = rotor.shaft.discs.iter().map(|disc| disc.at);
    let mut places: Vec<f64> = rotor.bearings.iter().map(|bearing| bearing.at).chain(supports).chain(discs).collect();
    places.sort_by(f64::total_cmp);
    let mesh = Mesh::new(&rotor.shaft, &places, rotor.shaft.length() / 16.0);
    System::of(rotor, mesh, 6, &[rotor.speed])
}

fn operating(rotor: &Rotor) -> OperatingPoint {
    analysed(rotor).unwrap().operating.remove(0)
}

/// Displacement of an inner ring under a radial force [m]: both contacts of a ball in series, each ball pressed by δ cos ψ − P_d/2, the mean
/// over eight places in a ball spacing.
fn displaced(bearing: &Bearing, clearance: f64, force: f64) -> f64 {
    let contacts = raceway_contacts(bearing).map(|of| of.stiffness.powf(-2.0 / 3.0));
    let stiffness = (contacts.inner + contacts.outer).powf(-1.5);
    let places = 8 * u32::try_from(bearing.parameters.ball_count).unwrap();
    let carried = |displacement: f64| {
        let of_place = |place: u32| {
            let cosine = (TAU * f64::from(place) / f64::from(places)).cos();
            stiffness * (displacement * cosine - 0.5 * clearance).max(0.0).powf(1.5) * cosine
        };
        (0..places).map(of_place).sum::<f64>() / 8.0
    };
    let (mut low, mut high) = (0.0, 1e-3);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if carried(middle) < force { low = middle } else { high = middle }
    }
    low
}

/// Two bearings with clearance carry half of the weight and of the load each, and a stiff shaft sinks by the closed form, which leaves out how
/// the displaced ring turns the contacts: up to a thousandth.
#[test]
fn a_loose_pair_sinks_by_the_closed_form() {
    for clearance in [0.0, 5e-6, 20e-6, 40e-6] {
        let bearing = with_clearance("6205", clearance);
        let pair = [(0.05, Faces::PlusX), (0.25, Faces::MinusX)].map(|(at, faces)| mounted(&bearing, at, faces));
        let mut rotor = bar(0.3, 0.025, pair.to_vec());
        rotor.shaft.material.elastic_modulus *= 1e6;
        let mut before = 0.0;
        for load in [0.0, 1.0, 30.0, 1e3, 3e3] {
            rotor.load[1] = load;
            let point = operating(&rotor);
            let expected = displaced(&bearing, clearance, 0.5 * (load + 9.81 * rotor.shaft.mass()));
            for ring in &point.rings {
                let [_, y, z, about_y, about_z] = ring.pose;
                assert!((y / expected - 1.0).abs() < 1e-3, "{clearance:e} m, {load} N: {y:e} for {expected:e}");
                assert!(z.abs() < 1e-12 && about_y.abs() < 1e-9 && about_z.abs() < 1e-8, "{:?}", ring.pose);
            }
            assert!(point.rings[0].pose[1] > before);
            before = point.rings[0].pose[1];
        }
    }
}

/// The spindle of the article with its load 60 mm beyond the second bearing: the bearings carry it as levers do, at every speed.
#[test]
fn an_overhung_load_tips_a_loose_spindle() {
    let bearing = of_preset("article-integrated");
    let pair = [(5e-3, Faces::PlusX), (45e-3, Faces::MinusX)].map(|(at, faces)| mounted(&bearing, at, faces));
    let mut rotor = bar(110e-3, 8.5e-3, pair.to_vec());
    // Its mass centre is that of the bar, and the load acts there.
    rotor.shaft.discs = vec![Disc { at: 105e-3, mass: 10.0, transverse_inertia: 1e-4, axial_inertia: 1e-4 }];
    for (speed, load) in [(0.0, 20.0), (1000.0, 50.0), (10_000.0, 200.0), (30_000.0, 50.0), (50_000.0, 200.0)] {
        (rotor.speed, rotor.load[1]) = (speed * RPM, load);
        let point = operating(&rotor);
        let whole = load + 9.81 * rotor.shaft.mass();
        let forces = point.rings.iter().map(|ring| -ring.wrench[1]).sum::<f64>();
        assert!((forces / whole - 1.0).abs() < 1e-8, "{forces} for {whole}");
        // Moments about the first bearing; those of the rings count, too.
        let second = -point.rings[1].wrench[1] * 40e-3;
        let rings: f64 = point.rings.iter().zip([1.0, -1.0]).map(|(ring, sign)| -sign * ring.wrench[4]).sum();
        let expected = whole * (rotor.shaft.mass_centre() - 5e-3);
        assert!(((second + rings) / expected - 1.0).abs() < 1e-8, "{second} and {rings} for {expected}");
    }
}

/// The mirror image of a skew load on bearings with different clearance.
#[test]
fn a_loose_shaft_has_its_mirror_image() {
    let (tight, wide) = (with_clearance("6205", 3e-6), with_clearance("6205", 30e-6));
    let mirrored = |sign: f64| {
        let (plus, minus) = if sign > 0.0 { (Faces::PlusX, Faces::MinusX) } else { (Faces::MinusX, Faces::PlusX) };
        let at = |at: f64| if sign > 0.0 { at } else { 0.3 - at };
        let mut rotor = bar(0.3, 0.025, vec![mounted(&tight, at(0.03), plus), mounted(&wide, at(0.2), minus)]);
        rotor.shaft.is_axially_free = true;
        (rotor.speed, rotor.load) = (9000.0 * RPM, [sign * 40.0, 70.0, -30.0]);
        operating(&rotor)
    };
    let [one, other] = [1.0, -1.0].map(mirrored);
    for (one, other) in one.rings.iter().zip(&other.rings) {
        assert!(one.pose.iter().zip(other.pose).all(|(one, other)| (one - other).abs() < 1e-12), "{one:?} {other:?}");
    }
}

/// Damping that turns along pushes a loose shaft aside: forces without a potential balance, too.
#[test]
fn a_shaft_that_its_own_damping_pushes_aside_balances() {
    let bearing = with_clearance("6205", 20e-6);
    let pair = [(0.05, Faces::PlusX), (0.25, Faces::MinusX)].map(|(at, faces)| mounted(&bearing, at, faces));
    let mut rotor = bar(0.3, 0.025, pair.to_vec());
    (rotor.shaft.damping_ratio, rotor.shaft.rotating_share, rotor.speed) = (0.1, 1.0, 3000.0 * RPM);
    rotor.load[1] = 500.0;
    let system = analysed(&rotor).unwrap();
    let point = &system.operating[0];
    let (turning, own) = (system.rotating() * rotor.speed, system.coordinates.squares());
    let mut rest = system.load(&rotor) - turning * &point.coordinates;
    for (place, square) in own.enumerate() {
        rest[place] -= square * point.coordinates[place];
    }
    for ((port, bearing), ring) in system.bearings.iter().zip(&rotor.bearings).zip(&point.rings) {
        rest += port.rows.tr_mul(&nalgebra::DVector::from_row_slice(&super::wrench(bearing, ring)));
    }
    assert!(rest.amax() < 1e-8 * system.load(&rotor).amax(), "{rest}");
    assert!(point.rings[0].pose[2].abs() > 1e-9, "{:?}", point.rings[0].pose);
}

/// A disc of 100 kg bends a shaft of 5 mm beyond linear theory, and a load of 10⁷ N presses balls through: each refusal names its cause.
#[test]
fn loads_beyond_every_bearing_are_refused() {
    let bearing = with_clearance("6205", 10e-6);
    let cause = |rotor: &Rotor| match analysed(rotor) {
        Err(RotorError::NoEquilibrium { cause, .. }) => cause,
        Err(other) => panic!("{other}"),
        Ok(system) => panic!("{:?}", system.operating[0].rings.iter().map(|ring| ring.pose).collect::<Vec<_>>()),
    };
    let pair =
        || [(0.02, Faces::PlusX), (0.28, Faces::MinusX)].map(|(at, faces)| mounted(&bearing, at, faces)).to_vec();
    let mut slender = bar(0.3, 0.005, pair());
    slender.shaft.discs[0].mass = 100.0;
    let found = cause(&slender);
    assert!(matches!(found, NoEquilibrium::Leans { slope, .. } if (0.1..1.0).contains(&slope)), "{found:?}");
    let mut pressed = bar(0.3, 0.025, pair());
    pressed.shaft.material.elastic_modulus *= 1e6;
    pressed.load[1] = 1e7;
    let found = cause(&pressed);
    assert!(matches!(found, NoEquilibrium::Bearing { .. } | NoEquilibrium::Departs { .. }), "{found:?}");
}

/// Without weight and load, no ball holds the shaft. Its weight does, and so do a spring and one loaded bearing.
#[test]
fn a_free_shaft_is_not_restrained() {
    let bearing = with_clearance("6205", 10e-6);
    let mut rotor = bar(0.3, 0.025, [0.05, 0.25].map(|at| mounted(&bearing, at, Faces::PlusX)).to_vec());
    rotor.gravity = 0.0;
    for speed in [0.0, 12_000.0] {
        rotor.speed = speed * RPM;
        let system = analysed(&rotor).unwrap();
        assert_eq!(system.growth_rate(rotor.speed).unwrap_err(), RotorError::Unrestrained);
    }
    // Weight holds it.
    rotor.gravity = 9.81;
    assert!(analysed(&rotor).unwrap().growth_rate(rotor.speed).is_ok());
    // A spring in place of the second bearing.
    rotor.bearings.truncate(1);
    let stiffness = diagonal([0.0, 5e7, 5e7, 0.0, 0.0]);
    rotor.supports = vec![Support { at: 0.25, on: None, stiffness, damping: diagonal([0.0; 5]) }];
    let point = operating(&rotor);
    assert!(
        (point.rings[0].wrench[1] / (-0.5 * 9.81 * rotor.shaft.mass()) - 1.0).abs() < 1e-3,
        "{:?}",
        point.rings[0].wrench
    );
}
