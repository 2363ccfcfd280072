//! Imported structures: a body on a mount in three forms, reduced matrices against closed forms, and motions that nothing restrains.

use nalgebra::{DMatrix, SymmetricEigen};

use super::housing::{at_rest, in_body, mount, preloaded};
use super::*;
use crate::physics::frame::housing::{Body, Mount};
use crate::physics::frame::structure::{Structure, StructureMatrices, StructureMode};
use crate::physics::frame::support::PORT;
use crate::rotor::restraint::{FreeMotion, Owner, free_motion};

const BODY: Body = Body { at: 0.17, mass: 8.0, inertia: [0.02, 0.05] };
const STIFFNESS: [f64; PORT] = [6e7, 3e7, 4e7, 2e5, 3e5];
const DAMPING: [f64; PORT] = [300.0, 200.0, 250.0, 3.0, 2.0];

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// Displacements of a place at a distance from another on a rigid body.
fn lever(arm: f64) -> DMatrix<f64> {
    let mut lever = DMatrix::identity(PORT, PORT);
    (lever[(1, 4)], lever[(2, 3)]) = (arm, -arm);
    lever
}

/// A matrix at one place, over the displacements of another.
fn moved(diagonal: [f64; PORT], arm: f64) -> DMatrix<f64> {
    lever(arm).transpose() * DMatrix::from_diagonal(&diagonal.to_vec().into()) * lever(arm)
}

/// The body on a mount as matrices over the displacements of a port.
fn as_matrices(port: f64, mount: f64) -> Structure {
    let Body { at, mass, inertia } = BODY;
    let matrices = StructureMatrices {
        mass: rows(&moved([mass, mass, mass, inertia[0], inertia[1]], at - port)),
        damping: rows(&moved(DAMPING, mount - port)),
        stiffness: rows(&moved(STIFFNESS, mount - port)),
        ports: vec![(port, std::array::from_fn(Some))],
    };
    Structure::of_matrices(&matrices, PORT).unwrap()
}

/// The body on a mount at its mass centre as modes.
fn as_modes() -> Structure {
    let masses = [BODY.mass, BODY.mass, BODY.mass, BODY.inertia[0], BODY.inertia[1]];
    let mode = |row: usize| {
        let (mass, frequency) = (masses[row], (STIFFNESS[row] / masses[row]).sqrt());
        // Any scale of the shape, with its modal mass.
        let mut shape = [0.0; PORT];
        shape[row] = 3.0;
        let damping_ratio = DAMPING[row] / (2.0 * mass * frequency);
        StructureMode { frequency: frequency / (2.0 * PI), damping_ratio, mass: 9.0 * mass, shapes: vec![shape] }
    };
    Structure::of_modes(&(0..PORT).map(mode).collect::<Vec<_>>(), &[BODY.at])
}

/// Both bearings in the structure, or in the body on its mount. The structure has no weight.
fn carried_by(structure: Option<Structure>, mounted: f64) -> Rotor {
    let mut rotor = in_body(preloaded(), BODY, STIFFNESS);
    rotor.housing.mounts = vec![Mount { damping: diagonal(DAMPING), ..mount(0, mounted, STIFFNESS) }];
    if structure.is_some() {
        rotor.housing = Housing { structure, ..Housing::default() };
    }
    rotor.gravity = 0.0;
    rotor.speed = 900.0;
    rotor.shaft.damping_ratio = 0.005;
    rotor.unbalances = vec![UnbalancePlane { at: 0.13, product: 2e-5, phase: 0.4 }];
    rotor
}

/// A body on a mount, given as such, as matrices and as modes, has the same frequencies, damping and responses.
#[test]
fn a_body_as_matrices_and_as_modes_is_the_body() {
    let analysed = |rotor: Rotor| analysed(&rotor, Elements::Auto, vec![0.0, 900.0, 3000.0], 12);
    let pairs = [
        (as_modes(), BODY.at),
        (as_matrices(BODY.at, BODY.at), BODY.at),
        (as_matrices(BODY.at, 0.1), 0.1),
        // A port beside the mass centre.
        (as_matrices(0.05, 0.1), 0.1),
    ];
    for (index, (structure, mounted)) in pairs.into_iter().enumerate() {
        let (one, other) = (analysed(carried_by(None, mounted)), analysed(carried_by(Some(structure), mounted)));
        for speed in 0..3 {
            assert_close(&frequencies(&other, speed), &frequencies(&one, speed), 1e-9);
        }
        for (one, other) in one.operating_modes.iter().zip(&other.operating_modes) {
            assert!((one.point.damping_ratio - other.point.damping_ratio).abs() < 1e-9, "{one:?} {other:?}");
        }
        for (one, other) in one.stations.iter().zip(&other.stations) {
            for (one, other) in one.displacement.iter().flatten().zip(other.displacement.iter().flatten()) {
                assert!((one - other).norm() <= 1e-9 * one.norm(), "{index}: {one} {other}");
            }
        }
        if index < 3 {
            let (one, other) = (&one.bodies[0], &other.bodies[0]);
            for (one, other) in one.at_rest.iter().zip(other.at_rest) {
                assert!((one - other).abs() < 1e-9 * one.abs().max(1e-9), "{one:e} {other:e}");
            }
            for (one, other) in one.response.iter().flatten().zip(other.response.iter().flatten()) {
                assert!((one - other).norm() <= 1e-9 * one.norm(), "{one} {other}");
            }
        }
    }
}

/// Masses of a pedestal at the port and below it [kg], and stiffness between them and to the ground [N/m].
const PEDESTAL: ([f64; 2], [f64; 2]) = ([2.0, 3.0], [9e7, 5e7]);

/// A mass of 10 kg in the middle of a shaft of 4 MN/m, whose ends stand on supports of 10⁸ N/m on two equal pedestals. `mass` and `stiffness`:
/// of a pedestal in a plane, its port first.
fn on_pedestals(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Rotor {
    let size = mass.nrows();
    // Both pedestals, in y and z: four blocks.
    let four = |block: &DMatrix<f64>| {
        let mut whole = DMatrix::zeros(4 * size, 4 * size);
        for k in 0..4 {
            whole.view_mut((k * size, k * size), (size, size)).copy_from(block);
        }
        rows(&whole)
    };
    let port = |at: f64, first: usize| (at, [None, Some(first), Some(first + size), None, None]);
    let matrices = StructureMatrices {
        mass: four(mass),
        damping: four(&DMatrix::zeros(size, size)),
        stiffness: four(stiffness),
        ports: vec![port(0.0, 0), port(0.5, 2 * size)],
    };
    // The deflection of the middle with shear: L³/48EI + L/4κGA.
    let (tube, length) = (Tube { outer_diameter: 0.03, inner_diameter: 0.0 }, 0.5_f64);
    let compliance = length.powi(3) / (48.0 * tube.second_moment())
        + length / (4.0 * tube.shear_coefficient(0.3) * tube.area() / 2.6);
    let material = Material { elastic_modulus: 4e6 * compliance, poisson_ratio: 0.3, density: 1.0 };
    let disc = Disc { at: 0.25, mass: 10.0, transverse_inertia: 0.0, axial_inertia: 0.0 };
    let shaft = Shaft { material, ..shaft(sections(&[(2, 0.25, 0.03, 0.0)]), vec![disc]) };
    let mut supports = [0.0, 0.5].map(|at| support(at, [1e8, 1e8], 0.0));
    (supports[0].on, supports[1].on) = (Some(0), Some(1));
    let mut rotor = rotor(shaft, supports.to_vec());
    rotor.housing.structure = Some(Structure::of_matrices(&matrices, 4 * size).unwrap());
    rotor
}

/// Frequencies of a chain of the half mass on its half shaft and support, and the pedestal [Hz].
fn of_chain(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Vec<f64> {
    let size = mass.nrows() + 1;
    let spring = 1.0 / (1.0 / 2e6 + 1.0 / 1e8);
    let (mut m, mut k) = (DMatrix::zeros(size, size), DMatrix::zeros(size, size));
    m.view_mut((1, 1), (size - 1, size - 1)).copy_from(mass);
    k.view_mut((1, 1), (size - 1, size - 1)).copy_from(stiffness);
    m[(0, 0)] = 5.0;
    for (row, column, sign) in [(0, 0, 1.0), (1, 1, 1.0), (0, 1, -1.0), (1, 0, -1.0)] {
        k[(row, column)] += sign * spring;
    }
    let inverse = m.cholesky().unwrap().l().try_inverse().unwrap();
    let mut squares: Vec<f64> =
        SymmetricEigen::new(&inverse * k * inverse.transpose()).eigenvalues.iter().copied().collect();
    squares.sort_by(f64::total_cmp);
    squares.iter().map(|square| square.sqrt() / (2.0 * PI)).collect()
}

/// Matrices of a pedestal of two masses, complete, by Craig and Bampton and by Guyan. The first two have the frequencies of the chain; all
/// three have its static deflection. Guyan's frequency is that of its own closed form.
#[test]
fn reduced_pedestals_have_the_closed_forms() {
    let ([upper, lower], [between, ground]) = PEDESTAL;
    let square = |values: [f64; 4]| DMatrix::from_row_slice(2, 2, &values);
    let share = between / (between + ground);
    let complete = (square([upper, 0.0, 0.0, lower]), square([between, -between, -between, between + ground]));
    let in_series = between * ground / (between + ground);
    let craig_bampton = (
        square([upper + share * share * lower, share * lower, share * lower, lower]),
        square([in_series, 0.0, 0.0, between + ground]),
    );
    let one = |value: f64| DMatrix::from_element(1, 1, value);
    let guyan = (one(upper + share * share * lower), one(in_series));
    let expected = of_chain(&complete.0, &complete.1);
    let sag = 9.81 * 5.0 / in_series;
    for ((mass, stiffness), expected) in
        [(complete.clone(), expected.clone()), (craig_bampton, expected), (guyan.clone(), of_chain(&guyan.0, &guyan.1))]
    {
        let result = at_rest(&on_pedestals(&mass, &stiffness), 20);
        let found = hertz(&frequencies(&result, 0));
        for expected in expected {
            let near = found.iter().filter(|found| (**found / expected - 1.0).abs() < 1e-4).count();
            assert_eq!(near, 2, "{expected}: {found:?}");
        }
        for port in &result.bodies {
            assert!((port.at_rest[1] / sag - 1.0).abs() < 1e-4, "{:e} {sag:e}", port.at_rest[1]);
        }
    }
}

/// Free motions of a structure are named by the port that moves most, or as inner ones.
#[test]
fn free_motions_of_a_structure_are_named() {
    let mode = |frequency: f64, shape: [f64; PORT]| StructureMode {
        frequency,
        damping_ratio: 0.0,
        mass: 8.0,
        shapes: vec![shape, [0.0; PORT]],
    };
    let unit = |row: usize| std::array::from_fn(|k| f64::from(k == row));
    let with = |frequencies: [f64; PORT], more: Vec<StructureMode>| {
        let modes = (0..PORT).map(|row| mode(frequencies[row], unit(row))).chain(more).collect::<Vec<_>>();
        let mut rotor = in_body(preloaded(), BODY, STIFFNESS);
        rotor.housing = Housing { structure: Some(Structure::of_modes(&modes, &[0.1, 0.2])), ..Housing::default() };
        rotor
    };
    assert_eq!(free_motion(&with([400.0; 5], Vec::new())), None);
    let moves = |displacement| Some(FreeMotion::Beside(Owner::Part(0), displacement));
    for row in 0..PORT {
        let mut frequencies = [400.0; PORT];
        frequencies[row] = 0.0;
        assert_eq!(free_motion(&with(frequencies, Vec::new())), moves(row), "{row}");
        // A mount on the port holds it.
        let mut held = with(frequencies, Vec::new());
        held.housing.mounts = vec![mount(0, 0.1, STIFFNESS)];
        assert_eq!(free_motion(&held), None);
    }
    let inner = with([400.0; 5], vec![mode(0.0, [0.0; PORT])]);
    assert_eq!(free_motion(&inner), Some(FreeMotion::InsideStructure));
}
