//! A structure of the housing that another program has reduced to ports: natural modes, or matrices.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::{escape, listed};
use crate::contract::json::units::MM;
use raceway_core::physics::frame::structure::{MatrixFault, MatrixName, Structure, StructureMatrices, StructureMode};
use raceway_core::physics::frame::support::PORT;

const POINTER: &str = "/scene/housing";
const MAX_PORTS: usize = 16;
/// Most coordinates: with them an analysis of 50 speeds takes seconds.
const MAX_COORDINATES: usize = 60;
/// Largest magnitude of an entry of a matrix, in SI: far above any real one.
const MOST: f64 = 1e13;
/// Largest magnitude of a displacement in a mode [-, rad/m]. The modal mass has the scale of the shape.
const MOST_SHAPE: f64 = 1e6;
/// Displacements of a port, as names of coordinates have them.
const DISPLACEMENTS: [&str; PORT] = ["x", "y", "z", "about_y", "about_z"];

/// A place of the imported structure, which moves along x, y and z and tilts about y and z. Rings and mounts at a distance along the shaft move with the place as on a rigid arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PortInput {
    /// Name: a letter, then letters, digits, `_` or `-`, at most 32; none of `spindle`, `cage`, `ball`, `sensor`, `shaft`.
    #[schema(pattern = "^[A-Za-z][A-Za-z0-9_-]{0,31}$", example = "seat")]
    pub name: String,
    /// Place along the shaft; it may lie beyond its ends [mm].
    #[schema(example = 40.0)]
    pub at_mm: f64,
}

/// A natural mode of the imported structure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ModeInput {
    /// Natural frequency [Hz]. 0: a rigid motion, which mounts or bearings must hold.
    #[schema(example = 420.0)]
    pub frequency_hz: f64,
    /// Damping ratio [-]. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.02)]
    pub damping_ratio: Option<f64>,
    /// Modal mass in the scale of `shape` [kg]: 1 for shapes that are normalised to unit mass.
    #[schema(example = 8.0)]
    pub mass_kg: f64,
    /// Displacements of ports by name: x, y, z [-] and tilts about y and z [rad/m], β_y = −z′, β_z = y′. A port that is left out does not move.
    #[schema(value_type = std::collections::HashMap<String, Vec<f64>>, example = json!({"seat": [0.0, 1.0, 0.0, 0.0, 0.2]}))]
    pub shape: BTreeMap<String, [f64; PORT]>,
}

/// Reduced matrices of the imported structure in SI, of Guyan or Craig–Bampton, or of any other basis of real shapes. The weight of the
/// structure is left out: displacements count from the place that it takes under its weight.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MatricesInput {
    /// Names of the coordinates, in the order of rows and columns. `seat.x`, `seat.y`, `seat.z`, `seat.about_y` and `seat.about_z` are the displacements
    /// of port `seat`; one that is left out is held. Names without `.` are inner coordinates.
    #[schema(min_items = 1, max_items = 60, example = json!(["seat.y", "seat.z", "inner-1"]))]
    pub coordinates: Vec<String>,
    /// Mass, symmetric and positive definite [kg, kg m, kg m²], each entry from −10¹³ to 10¹³.
    #[schema(min_items = 1, max_items = 60)]
    pub mass: Vec<Vec<f64>>,
    /// Damping, symmetric and positive semi-definite [N·s/m, N·s, N·m·s/rad], each entry from −10¹³ to 10¹³. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, min_items = 1, max_items = 60)]
    pub damping: Option<Vec<Vec<f64>>>,
    /// Stiffness, symmetric and positive semi-definite [N/m, N, N·m/rad], each entry from −10¹³ to 10¹³.
    #[schema(min_items = 1, max_items = 60)]
    pub stiffness: Vec<Vec<f64>>,
}

/// The structure in SI; `None` after errors, which are noted in `defaults`.
pub fn structure(
    ports: Option<&[PortInput]>,
    modes: Option<&mut Vec<ModeInput>>,
    matrices: Option<&mut MatricesInput>,
    defaults: &mut Defaults,
) -> Option<Structure> {
    let known_errors = defaults.errors.len();
    let ports = check_ports(ports, defaults)?;
    let structure = match (modes, matrices) {
        (Some(modes), None) => of_modes(ports, modes, defaults),
        (None, Some(matrices)) => of_matrices(ports, matrices, defaults),
        (Some(_), Some(_)) => {
            defaults.refuse(format!("{POINTER}/matrices"), "give either this or `modes`");
            None
        }
        (None, None) => {
            defaults.refuse(format!("{POINTER}/ports"), "only with `modes` or `matrices`, which say how they move");
            None
        }
    };
    structure.filter(|_| defaults.errors.len() == known_errors)
}

/// The ports, at most as many as are taken; `None` without any.
fn check_ports<'a>(ports: Option<&'a [PortInput]>, defaults: &mut Defaults) -> Option<&'a [PortInput]> {
    let pointer = format!("{POINTER}/ports");
    let Some(ports) = ports else {
        defaults.refuse(pointer, "required with `modes` or `matrices`: places at which something may act");
        return None;
    };
    if !(1..=MAX_PORTS).contains(&ports.len()) {
        defaults.refuse(pointer, format!("{} ports: must be from 1 to {MAX_PORTS}", ports.len()));
    }
    let ports = &ports[..ports.len().min(MAX_PORTS)];
    for (index, port) in ports.iter().enumerate() {
        defaults.check_of_rotor(&format!("{POINTER}/ports/{index}/at_mm"), port.at_mm);
    }
    (!ports.is_empty()).then_some(ports)
}

fn of_modes(ports: &[PortInput], inputs: &mut [ModeInput], defaults: &mut Defaults) -> Option<Structure> {
    if !check_count(inputs.len(), "modes", format!("{POINTER}/modes"), defaults) {
        return None;
    }
    let mut modes = Vec::new();
    for (index, input) in inputs.iter_mut().enumerate() {
        modes.push(input.resolve(ports, &format!("{POINTER}/modes/{index}"), defaults));
    }
    for (index, port) in ports.iter().enumerate() {
        if modes.iter().all(|mode| mode.shapes[index] == [0.0; PORT]) {
            refuse_unmoved(index, &port.name, "give its displacements in the `shape` of a mode", defaults);
        }
    }
    let places: Vec<f64> = ports.iter().map(|port| MM.to_si(port.at_mm)).collect();
    Some(Structure::of_modes(&modes, &places))
}

/// A port that never moves would be the ground.
fn refuse_unmoved(index: usize, name: &str, remedy: &str, defaults: &mut Defaults) {
    defaults.refuse(format!("{POINTER}/ports/{index}"), format!("nothing moves `{name}`: {remedy}"));
}

fn check_count(count: usize, what: &str, pointer: String, defaults: &mut Defaults) -> bool {
    let is_inside = (1..=MAX_COORDINATES).contains(&count);
    if !is_inside {
        defaults.refuse(pointer, format!("{count} {what}: must be from 1 to {MAX_COORDINATES}"));
    }
    is_inside
}

impl ModeInput {
    fn resolve(&mut self, ports: &[PortInput], at: &str, defaults: &mut Defaults) -> StructureMode {
        let damping_ratio = defaults.fill(format!("{at}/damping_ratio"), &mut self.damping_ratio, 0.0);
        let numbers =
            [("frequency_hz", self.frequency_hz), ("damping_ratio", damping_ratio), ("mass_kg", self.mass_kg)];
        for (name, value) in numbers {
            defaults.check_of_rotor(&format!("{at}/{name}"), value);
        }
        for (name, displacements) in &self.shape {
            let pointer = format!("{at}/shape/{}", escape(name));
            if !ports.iter().any(|port| port.name == *name) {
                defaults.refuse(&pointer, unknown_port(name, ports));
            }
            for (index, value) in displacements.iter().enumerate().filter(|(_, value)| value.abs() > MOST_SHAPE) {
                let detail = format!("{value:e}: must be from {:e} to {MOST_SHAPE:e}", -MOST_SHAPE);
                defaults.refuse(format!("{pointer}/{index}"), detail);
            }
        }
        let shapes = ports.iter().map(|port| self.shape.get(&port.name).copied().unwrap_or_default());
        StructureMode { frequency: self.frequency_hz, damping_ratio, mass: self.mass_kg, shapes: shapes.collect() }
    }
}

fn unknown_port(name: &str, ports: &[PortInput]) -> String {
    let shown: String = name.chars().take(32).collect();
    format!("unknown port `{shown}`; ports are {}", listed(ports.iter().map(|port| port.name.as_str())))
}

fn of_matrices(ports: &[PortInput], input: &mut MatricesInput, defaults: &mut Defaults) -> Option<Structure> {
    const MATRICES: &str = "/scene/housing/matrices";
    let count = input.coordinates.len();
    if !check_count(count, "coordinates", format!("{MATRICES}/coordinates"), defaults) {
        return None;
    }
    let places = ports_of_coordinates(ports, &input.coordinates, defaults);
    let zeros = vec![vec![0.0; count]; count];
    let damping = defaults.fill(format!("{MATRICES}/damping"), &mut input.damping, zeros);
    let (mass, stiffness) = (input.mass.clone(), input.stiffness.clone());
    let named = [("mass", &mass), ("damping", &damping), ("stiffness", &stiffness)];
    if !named
        .map(|(name, rows)| check_entries(&format!("{MATRICES}/{name}"), rows, defaults))
        .iter()
        .all(|inside| *inside)
    {
        return None;
    }
    let ports = ports.iter().zip(places).map(|(port, coordinates)| (MM.to_si(port.at_mm), coordinates)).collect();
    match Structure::of_matrices(&StructureMatrices { mass, damping, stiffness, ports }, count) {
        Ok(structure) => Some(structure),
        Err(faults) => {
            for (name, fault) in faults {
                let name = match name {
                    MatrixName::Mass => "mass",
                    MatrixName::Damping => "damping",
                    MatrixName::Stiffness => "stiffness",
                };
                let place = match fault {
                    MatrixFault::Asymmetric { row, column, .. } => format!("/{row}/{column}"),
                    MatrixFault::Diagonal { row, .. } => format!("/{row}/{row}"),
                    MatrixFault::Numbers { row, .. } => format!("/{row}"),
                    _ => String::new(),
                };
                defaults.refuse(format!("{MATRICES}/{name}{place}"), fault.to_string());
            }
            None
        }
    }
}

/// For each port the coordinates that are its displacements. Errors are noted in `defaults`.
fn ports_of_coordinates(
    ports: &[PortInput],
    coordinates: &[String],
    defaults: &mut Defaults,
) -> Vec<[Option<usize>; PORT]> {
    let mut places = vec![[None; PORT]; ports.len()];
    for (index, name) in coordinates.iter().enumerate() {
        let pointer = format!("{POINTER}/matrices/coordinates/{index}");
        if coordinates[..index].contains(name) {
            let shown: String = name.chars().take(64).collect();
            defaults.refuse(pointer, format!("`{shown}` is the name of another coordinate"));
            continue;
        }
        let Some((port, displacement)) = name.split_once('.') else { continue };
        let Some(port) = ports.iter().position(|known| known.name == port) else {
            defaults.refuse(pointer, unknown_port(port, ports));
            continue;
        };
        match DISPLACEMENTS.iter().position(|known| *known == displacement) {
            Some(row) => places[port][row] = Some(index),
            None => {
                let name = &ports[port].name;
                let known = DISPLACEMENTS.map(|displacement| format!("`{name}.{displacement}`"));
                let detail = format!("displacements of `{name}` are {}", known.join(", "));
                defaults.refuse(pointer, detail);
            }
        }
    }
    for (index, port) in ports.iter().enumerate() {
        if places[index] == [None; PORT] {
            let remedy = format!("give a coordinate such as `{}.y`", port.name);
            refuse_unmoved(index, &port.name, &remedy, defaults);
        }
    }
    places
}

/// Refuses numbers outside their limits; returns whether all are inside.
fn check_entries(at: &str, rows: &[Vec<f64>], defaults: &mut Defaults) -> bool {
    let known_errors = defaults.errors.len();
    for (row, values) in rows.iter().enumerate() {
        for (column, value) in values.iter().enumerate().filter(|(_, value)| value.abs() > MOST) {
            let detail = format!("{value:e}: must be from {:e} to {MOST:e}", -MOST);
            defaults.refuse(format!("{at}/{row}/{column}"), detail);
        }
    }
    defaults.errors.len() == known_errors
}
