//! The analysis of a rotor: mesh and coordinates that are fine enough, then each answer from the same matrices.

use nalgebra::{Complex, DMatrix, DVector};

use super::campbell::{Course, courses};
use super::critical::criticals;
use super::deflection::deflection;
use super::input::{Elements, Request, Rotor, RotorBearing, RotorError};
use super::operating::wrench;
use super::response::of_unbalance;
use super::result::{
    BearingResult, BodyResult, Critical, ModeCourse, RotorResult, SensorResult, StationResponse, SupportForces,
};
use super::sensor::Sensor;
use super::shape::{displacements, mode, point};
use super::system::{Port, System};
use crate::physics::frame::mesh::Mesh;
use crate::physics::frame::support::PortMatrix;

/// Change of a kept frequency, by halving the elements, below which a mesh is fine enough [-].
const CONVERGED: f64 = 1e-4;
/// Elements of the first mesh, and the most of any.
const FIRST_ELEMENTS: f64 = 16.0;
const MOST_ELEMENTS: usize = 800;
/// Free modes are kept up to this multiple of the highest asked-for frequency [-], and at least two more in each plane than half of
/// the asked-for frequencies. With residual vectors the error of a frequency is then below 10⁻⁷ (two rotors of the tests).
const RANGE: f64 = 3.0;
const MORE_MODES: usize = 2;

/// Analyses a rotor. `stop` is polled between decompositions; true ends the analysis.
pub fn analyse(rotor: &Rotor, request: &Request, stop: &dyn Fn() -> bool) -> Result<RotorResult, RotorError> {
    let (operating_system, count) = system(rotor, request, stop)?;
    let mesh = operating_system.coordinates.mesh.clone();
    let system = match rotor.bearings.is_empty() {
        true => operating_system.clone(),
        false => System::of(rotor, mesh, count, &request.speeds)?,
    };
    let coordinates = &system.coordinates;
    let courses = courses(&system, &request.speeds, request.modes, stop)?;
    let of_course = |course: &Course| ModeCourse {
        points: course
            .iter()
            .zip(&request.speeds)
            .map(|(oscillation, speed)| Some(point(oscillation.as_ref()?, coordinates, *speed)))
            .collect(),
    };
    check(stop)?;
    let (operating, growth_rate) = operating_system
        .free_motion(rotor.speed, |motion| Some((motion.oscillations(request.modes)?, motion.growth_rate())))?;
    check(stop)?;
    let highest = request.speeds.last().copied().unwrap_or_default();
    let criticals = criticals(&system, &request.speeds, &courses, highest).into_iter().map(|(speed, oscillation)| {
        let response = of_unbalance(&system, &rotor.unbalances, speed);
        let at = |at| displacement(&system, at, &response);
        let displacement = rotor.places().into_iter().map(at).collect();
        Critical { speed, mode: mode(&oscillation, coordinates, speed), displacement }
    });
    let responses = request.speeds.iter().map(|speed| {
        check(stop)?;
        Ok(of_unbalance(&system, &rotor.unbalances, *speed))
    });
    let responses: Vec<DVector<Complex<f64>>> = responses.collect::<Result<_, RotorError>>()?;
    let rest = deflection(&operating_system, rotor)?;
    let whole = displacements(&rest.map(Complex::from), coordinates);
    let forces = forces([&operating_system, &system], rotor, &rest, &request.speeds, &responses);
    Ok(RotorResult {
        mass: rotor.shaft.mass(),
        mass_centre: rotor.shaft.mass_centre(),
        nodes: coordinates.mesh.nodes.clone(),
        coordinates: coordinates.len(),
        modes: courses.iter().map(of_course).collect(),
        operating_modes: operating.iter().map(|o| mode(o, coordinates, rotor.speed)).collect(),
        growth_rate,
        criticals: criticals.collect(),
        stations: rotor.places().into_iter().map(|at| of_station(&system, at, &responses)).collect(),
        supports: forces.supports,
        mounts: forces.mounts,
        bodies: bodies(&system, &rest, &responses),
        sensors: request.sensors.iter().map(|sensor| of_sensor(&system, sensor, &rest, &responses)).collect(),
        bearings: bearings([&operating_system, &system], rotor, &request.speeds),
        deflection: whole.into_iter().map(|node| node.map(|value| value.re)).collect(),
    })
}

fn check(stop: &dyn Fn() -> bool) -> Result<(), RotorError> {
    if stop() { Err(RotorError::Stopped) } else { Ok(()) }
}

/// Matrices about the operating point on a mesh that the asked-for frequencies no longer depend on, and the number of flexible modes in
/// each plane.
fn system(rotor: &Rotor, request: &Request, stop: &dyn Fn() -> bool) -> Result<(System, usize), RotorError> {
    let mut longest = match request.elements {
        Elements::Sections => f64::INFINITY,
        Elements::Auto => rotor.shaft.length() / FIRST_ELEMENTS,
    };
    let (mut system, mut frequencies, mut count) = on_mesh(rotor, longest, request.modes, stop)?;
    while request.elements == Elements::Auto && 2 * system.coordinates.mesh.elements.len() <= MOST_ELEMENTS {
        longest /= 2.0;
        let (finer, of_finer, of_count) = on_mesh(rotor, longest, request.modes, stop)?;
        let is_close = |(coarse, fine): (&f64, &f64)| (coarse - fine).abs() < CONVERGED * fine;
        let has_converged = frequencies.len() == of_finer.len() && frequencies.iter().zip(&of_finer).all(is_close);
        (system, frequencies, count) = (finer, of_finer, of_count);
        if has_converged {
            break;
        }
    }
    Ok((system, count))
}

/// Matrices on a mesh with enough free modes, the asked-for natural frequencies |λ| without gyroscopic moments [rad/s], and the number of
/// flexible modes in each plane.
fn on_mesh(
    rotor: &Rotor,
    longest: f64,
    modes: usize,
    stop: &dyn Fn() -> bool,
) -> Result<(System, Vec<f64>, usize), RotorError> {
    let mesh = Mesh::new(&rotor.shaft, &rotor.places(), longest);
    let mut count = modes.div_ceil(2) + MORE_MODES;
    let mut coordinates = 0;
    loop {
        check(stop)?;
        let system = System::of(rotor, mesh.clone(), count, &[rotor.speed])?;
        check(stop)?;
        let values = system.free_motion(0.0, |motion| Some(motion.oscillating()))?;
        let frequencies: Vec<f64> = values.iter().take(modes).map(|value| value.norm()).collect();
        let highest = frequencies.last().copied().unwrap_or_default();
        // A coarse mesh has no more modes to give.
        let has_all = system.coordinates.len() == coordinates;
        coordinates = system.coordinates.len();
        if has_all || system.coordinates.highest() >= RANGE * highest {
            return Ok((system, frequencies, count));
        }
        count += 2;
    }
}

fn of_station(system: &System, at: f64, responses: &[DVector<Complex<f64>>]) -> StationResponse {
    StationResponse { at, displacement: responses.iter().map(|response| displacement(system, at, response)).collect() }
}

/// Displacement along Y and Z at a place.
fn displacement(system: &System, at: f64, response: &DVector<Complex<f64>>) -> [Complex<f64>; 2] {
    let port = system.coordinates.port(system.coordinates.mesh.node(at)).map(Complex::from) * response;
    [port[1], port[2]]
}

/// Static displacements of the housing's parts, and their responses.
fn bodies(system: &System, rest: &DVector<f64>, responses: &[DVector<Complex<f64>>]) -> Vec<BodyResult> {
    let of_part = |rows: DMatrix<f64>| {
        let at_rest = &rows * rest;
        let rows = rows.map(Complex::from);
        let response = responses.iter().map(|response| {
            let moved = &rows * response;
            [0, 1, 2].map(|axis| moved[axis])
        });
        BodyResult { at_rest: std::array::from_fn(|axis| at_rest[axis]), response: response.collect() }
    };
    system.coordinates.housing.parts().map(of_part).collect()
}

/// Static displacement of a sensor, and its response.
fn of_sensor(
    system: &System,
    sensor: &Sensor,
    rest: &DVector<f64>,
    responses: &[DVector<Complex<f64>>],
) -> SensorResult {
    let row = system.coordinates.reading(sensor);
    let moved = |response: &DVector<Complex<f64>>| response.iter().zip(&row).map(|(value, by)| value * *by).sum();
    SensorResult { at_rest: row.dot(rest), response: responses.iter().map(moved).collect() }
}

/// Forces of springs and bearings.
struct Forces {
    supports: Vec<SupportForces>,
    mounts: Vec<SupportForces>,
}

/// Forces of the shaft on each support and bearing, and of bodies on their mounts. Systems: about the operating point, and over the speeds.
fn forces(
    [operating, system]: [&System; 2],
    rotor: &Rotor,
    rest: &DVector<f64>,
    speeds: &[f64],
    responses: &[DVector<Complex<f64>>],
) -> Forces {
    let dynamic = |port: &Port| {
        let at = |(response, speed): (&DVector<Complex<f64>>, &f64)| {
            let (stiffness, damping) = system.of_port(port, *speed);
            let impedance = stiffness.map(Complex::from) + damping.map(|c| Complex::new(0.0, speed * c));
            let force = impedance * (port.rows.map(Complex::from) * response);
            [force[1], force[2]]
        };
        responses.iter().zip(speeds).map(at).collect()
    };
    let of_spring = |(index, at): (usize, f64)| {
        let port = &operating.springs[index];
        let at_rest = operating.of_port(port, rotor.speed).0 * (&port.rows * rest);
        let at_rest = std::array::from_fn(|axis| at_rest[axis]);
        SupportForces { at, at_rest, dynamic: dynamic(&system.springs[index]) }
    };
    let of_bearing = |(index, bearing): (usize, &RotorBearing)| {
        let ring = &operating.operating[0].rings[index];
        let at_rest = wrench(bearing, ring).map(|force| -force);
        SupportForces { at: bearing.at, at_rest, dynamic: dynamic(&system.bearings[index]) }
    };
    let supports = rotor.supports.iter().map(|support| support.at).enumerate().map(of_spring);
    let mounts = rotor.housing.mounts.iter().map(|mount| mount.at);
    let mounts = mounts.enumerate().map(|(index, at)| of_spring((rotor.supports.len() + index, at)));
    Forces {
        supports: supports.chain(rotor.bearings.iter().enumerate().map(of_bearing)).collect(),
        mounts: mounts.collect(),
    }
}

/// The bearings about the operating point, and their matrices over the speeds.
fn bearings([operating, system]: [&System; 2], rotor: &Rotor, speeds: &[f64]) -> Vec<BearingResult> {
    let of_bearing = |(index, bearing): (usize, &RotorBearing)| {
        let ring = &operating.operating[0].rings[index];
        let on_shaft = |matrix: &PortMatrix| bearing.mounted.along_shaft(matrix);
        let [one, other] = [&ring.stiffness.least, &ring.stiffness.most].map(on_shaft);
        // The mirror image turns signs, and with them the order.
        let by = |choose: fn(f64, f64) -> f64| {
            std::array::from_fn(|row| std::array::from_fn(|column| choose(one[row][column], other[row][column])))
        };
        let port = &system.bearings[index];
        BearingResult {
            at: bearing.at,
            pose: ring.pose,
            stiffness: on_shaft(&ring.stiffness.mean),
            least_stiffness: by(f64::min),
            most_stiffness: by(f64::max),
            damping: on_shaft(&ring.damping(&bearing.damping)),
            largest_loads: ring.largest_loads,
            loaded: ring.loaded,
            largest_pressure: ring.largest_pressure(),
            thrust_over_open_side: ring.thrust_over_open_side(),
            over_speed: speeds
                .iter()
                .map(|speed| {
                    let (stiffness, damping) = system.of_port(port, *speed);
                    (in_arrays(&stiffness), in_arrays(&damping))
                })
                .collect(),
        }
    };
    rotor.bearings.iter().enumerate().map(of_bearing).collect()
}

fn in_arrays(matrix: &DMatrix<f64>) -> PortMatrix {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
}
