//! The analysis of a rotor: mesh and coordinates that are fine enough, then each answer from the same matrices.

use nalgebra::{Complex, DVector};

use super::campbell::{Course, courses};
use super::critical::criticals;
use super::deflection::deflection;
use super::input::{Elements, Request, Rotor, RotorError};
use super::result::{Critical, ModeCourse, RotorResult, StationResponse, SupportForces};
use super::shape::{displacements, mode, point};
use super::system::{Port, System};
use super::unbalance::response;
use crate::physics::frame::mesh::Mesh;
use crate::physics::frame::support::Support;

/// Change of a kept frequency, by halving the elements, below which a mesh is fine enough [-].
const CONVERGED: f64 = 1e-4;
/// Elements of the first mesh, and the most of any.
const FIRST_ELEMENTS: f64 = 16.0;
const MOST_ELEMENTS: usize = 800;
/// Free modes are kept up to this multiple of the highest asked-for frequency [-], and at least two more in each plane than half of
/// the asked-for frequencies. With residual vectors the error of a frequency is then below 10⁻⁷ (two rotors of the tests).
const RANGE: f64 = 3.0;
const MORE_MODES: usize = 2;

/// Analyses a rotor.
pub fn analyse(rotor: &Rotor, request: &Request) -> Result<RotorResult, RotorError> {
    let system = system(rotor, request)?;
    let coordinates = &system.coordinates;
    let courses = courses(&system, &request.speeds, request.modes)?;
    let of_course = |course: &Course| ModeCourse {
        points: course
            .iter()
            .zip(&request.speeds)
            .map(|(oscillation, speed)| Some(point(oscillation.as_ref()?, coordinates, *speed)))
            .collect(),
    };
    let operating = system.oscillations(rotor.speed)?;
    let growth_rate = operating.iter().map(|oscillation| oscillation.value.re).fold(f64::NEG_INFINITY, f64::max);
    let highest = request.speeds.last().copied().unwrap_or_default();
    let criticals = criticals(&system, &request.speeds, &courses, highest)
        .into_iter()
        .map(|(speed, oscillation)| Critical { speed, mode: mode(&oscillation, coordinates, speed) });
    let responses: Vec<DVector<Complex<f64>>> =
        request.speeds.iter().map(|speed| response(&system, &rotor.unbalances, *speed)).collect();
    let rest = deflection(&system, rotor)?;
    let whole = displacements(&rest.map(Complex::from), coordinates);
    Ok(RotorResult {
        mass: rotor.shaft.mass(),
        mass_centre: rotor.shaft.mass_centre(),
        nodes: coordinates.mesh.nodes.clone(),
        coordinates: coordinates.len(),
        modes: courses.iter().map(of_course).collect(),
        operating_modes: operating.iter().take(request.modes).map(|o| mode(o, coordinates, rotor.speed)).collect(),
        growth_rate,
        criticals: criticals.collect(),
        stations: stations(rotor).into_iter().map(|at| of_station(&system, at, &responses)).collect(),
        supports: support_forces(&system, rotor, &rest, &request.speeds, &responses),
        deflection: whole.into_iter().map(|node| node.map(|value| value.re)).collect(),
    })
}

/// Places where something acts on the shaft, rising [m].
fn stations(rotor: &Rotor) -> Vec<f64> {
    let discs = rotor.shaft.discs.iter().map(|disc| disc.at);
    let planes = rotor.unbalances.iter().map(|plane| plane.at);
    let mut places: Vec<f64> = discs.chain(planes).chain(rotor.supports.iter().map(|support| support.at)).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    places
}

/// Matrices on a mesh, and with coordinates, that the asked-for frequencies at rest no longer depend on.
fn system(rotor: &Rotor, request: &Request) -> Result<System, RotorError> {
    let mut longest = match request.elements {
        Elements::Sections => f64::INFINITY,
        Elements::Auto => rotor.shaft.length() / FIRST_ELEMENTS,
    };
    let (mut system, mut frequencies) = on_mesh(rotor, longest, request.modes)?;
    while request.elements == Elements::Auto && 2 * system.coordinates.mesh.elements.len() <= MOST_ELEMENTS {
        longest /= 2.0;
        let (finer, of_finer) = on_mesh(rotor, longest, request.modes)?;
        let is_close = |(coarse, fine): (&f64, &f64)| (coarse - fine).abs() < CONVERGED * fine;
        let has_converged = frequencies.len() == of_finer.len() && frequencies.iter().zip(&of_finer).all(is_close);
        (system, frequencies) = (finer, of_finer);
        if has_converged {
            break;
        }
    }
    Ok(system)
}

/// Matrices on a mesh with enough free modes, and the asked-for angular frequencies at rest [rad/s].
fn on_mesh(rotor: &Rotor, longest: f64, modes: usize) -> Result<(System, Vec<f64>), RotorError> {
    let mesh = Mesh::new(&rotor.shaft, &stations(rotor), longest);
    let mut count = modes.div_ceil(2) + MORE_MODES;
    loop {
        let system = System::of(rotor, mesh.clone(), count)?;
        let oscillations = system.oscillations(0.0)?;
        let frequencies: Vec<f64> = oscillations.iter().take(modes).map(|oscillation| oscillation.value.im).collect();
        let highest = frequencies.last().copied().unwrap_or_default();
        if system.coordinates.highest() >= RANGE * highest {
            return Ok((system, frequencies));
        }
        count += 2;
    }
}

fn of_station(system: &System, at: f64, responses: &[DVector<Complex<f64>>]) -> StationResponse {
    let rows = system.coordinates.port(system.coordinates.mesh.node(at)).map(Complex::from);
    let displacement = responses.iter().map(|response| {
        let port = &rows * response;
        [port[1], port[2]]
    });
    StationResponse { at, displacement: displacement.collect() }
}

/// Forces of the shaft on each support.
fn support_forces(
    system: &System,
    rotor: &Rotor,
    rest: &DVector<f64>,
    speeds: &[f64],
    responses: &[DVector<Complex<f64>>],
) -> Vec<SupportForces> {
    let of_port = |(port, support): (&Port, &Support)| {
        let at_rest = &port.stiffness * (&port.rows * rest);
        let dynamic = responses.iter().zip(speeds).map(|(response, speed)| {
            let impedance = port.stiffness.map(Complex::from) + port.damping.map(|c| Complex::new(0.0, speed * c));
            let force = impedance * (port.rows.map(Complex::from) * response);
            [force[1], force[2]]
        });
        SupportForces { at: support.at, at_rest: std::array::from_fn(|i| at_rest[i]), dynamic: dynamic.collect() }
    };
    system.ports.iter().zip(&rotor.supports).map(of_port).collect()
}
