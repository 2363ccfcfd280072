//! The housing of a shaft: rigid bodies on mounts, and a structure reduced to ports.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::imported::{MatricesInput, ModeInput, PortInput, structure};
use super::names::check_body_name;
use super::springs::{SpringFields, springs};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::limits;
use crate::contract::json::numbers::significant;
use crate::contract::json::shapes::{optional_list, optional_object};
use crate::contract::json::units::MM;
use raceway_core::physics::frame::housing::{Body, Housing, Mount};

pub const POINTER: &str = "/scene/housing";
const MAX_BODIES: usize = 8;
const MAX_MOUNTS: usize = 16;
/// Density of the cube that gives the default inertia [kg/m³].
const STEEL: f64 = 7850.0;

/// Structure that holds bearings and supports: rigid `bodies` on `mounts`, and a structure that another program has reduced to `ports`, as `modes` or `matrices`.
/// A body moves along x, y and z and tilts about y and z; its roll is held. A port moves in the same way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HousingInput {
    /// Bodies. Required without `ports`.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, min_items = 1, max_items = 8)]
    pub bodies: Option<Vec<BodyInput>>,
    /// Springs between bodies, ports and the ground. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 16)]
    pub mounts: Option<Vec<MountInput>>,
    /// Places of the imported structure, which `on`, `relative_to` and mounts name like bodies. Required with `modes` or `matrices`. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, min_items = 1, max_items = 16)]
    pub ports: Option<Vec<PortInput>>,
    /// Natural modes of the imported structure. Either these or `matrices`.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, min_items = 1, max_items = 60)]
    pub modes: Option<Vec<ModeInput>>,
    /// Reduced matrices of the imported structure.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub matrices: Option<MatricesInput>,
}

/// A rigid body, whose mass centre lies on the axis of the shaft. Its mass contains the outer rings that it holds rigidly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyInput {
    /// Name: a letter, then letters, digits, `_` or `-`, at most 32; none of `spindle`, `cage`, `ball`, `sensor`, `shaft`.
    #[schema(pattern = "^[A-Za-z][A-Za-z0-9_-]{0,31}$", example = "head")]
    pub name: String,
    /// Mass [kg].
    #[schema(example = 8.0)]
    pub mass_kg: f64,
    /// Place of the mass centre along the shaft; it may lie beyond its ends [mm].
    #[schema(example = 150.0)]
    pub at_mm: f64,
    /// Moments of inertia about x, y and z through the mass centre [kg m²]; the first is not used. Default: of a steel cube of this mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([0.02, 0.05, 0.05]))]
    pub inertia_kg_m2: Option<[f64; 3]>,
}

/// A spring and a dashpot between a body and the ground, or another body. Ports count as bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MountInput {
    /// Name of the body or port.
    #[schema(max_length = 32, example = "head")]
    pub body: String,
    /// Name of the other body or port. Default: the ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, max_length = 32)]
    pub to: Option<String>,
    /// Place along the shaft [mm]. Default: that of the mass centre of the body, or of the port.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 150.0)]
    pub at_mm: Option<f64>,
    /// Stiffness along x, y and z [N/µm].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([50.0, 20.0, 50.0]))]
    pub stiffness_n_per_um: Option<[f64; 3]>,
    /// Damping along x, y and z [N·s/m]. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([300.0, 300.0, 300.0]))]
    pub damping_n_s_per_m: Option<[f64; 3]>,
    /// Stiffness against tilt about y and z [N·m/mrad]. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([20.0, 20.0]))]
    pub tilt_n_m_per_mrad: Option<[f64; 2]>,
    /// Damping of tilt about y and z [N·m·s/rad]. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([1.0, 1.0]))]
    pub tilt_damping_n_m_s_per_rad: Option<[f64; 2]>,
}

impl HousingInput {
    /// The housing in SI. Errors are noted in `defaults`.
    pub fn resolve(&mut self, defaults: &mut Defaults) -> Housing {
        let has_structure = self.ports.is_some() || self.modes.is_some() || self.matrices.is_some();
        if self.bodies.is_none() && !has_structure {
            defaults.refuse(format!("{POINTER}/bodies"), "required, or `ports` of an imported structure");
        }
        let count = self.bodies.as_ref().map(Vec::len);
        if let Some(count) = count.filter(|count| !(1..=MAX_BODIES).contains(count)) {
            defaults.refuse(format!("{POINTER}/bodies"), format!("{count} bodies: must be from 1 to {MAX_BODIES}"));
        }
        self.check_names(defaults);
        let bodies = self.bodies.iter_mut().flatten().enumerate().take(MAX_BODIES);
        let bodies = bodies.map(|(index, body)| body.resolve(defaults, &format!("{POINTER}/bodies/{index}"))).collect();
        let ports = self.ports.as_deref();
        let structure = has_structure.then(|| structure(ports, self.modes.as_mut(), self.matrices.as_mut(), defaults));
        let (names, places): (Vec<String>, Vec<f64>) =
            self.parts().map(|part| (part.name.to_owned(), part.at_mm)).unzip();
        let mounts = self.mounts.as_deref_mut().unwrap_or_default();
        if mounts.len() > MAX_MOUNTS {
            defaults.refuse(format!("{POINTER}/mounts"), format!("{} mounts: at most {MAX_MOUNTS}", mounts.len()));
        }
        let resolved = mounts.iter_mut().enumerate().take(MAX_MOUNTS).filter_map(|(index, mount)| {
            mount.resolve(defaults, &format!("{POINTER}/mounts/{index}"), (&names, &places))
        });
        let mounts = resolved.collect();
        Housing { bodies, mounts, structure: structure.flatten() }
    }

    /// Bodies and then ports, which have one range of names and numbers.
    pub fn parts(&self) -> impl Iterator<Item = PartInput<'_>> {
        let bodies = self.bodies.iter().flatten().enumerate().map(|(index, body)| PartInput {
            pointer: format!("{POINTER}/bodies/{index}"),
            name: &body.name,
            at_mm: body.at_mm,
        });
        let ports = self.ports.iter().flatten().enumerate().map(|(index, port)| PartInput {
            pointer: format!("{POINTER}/ports/{index}"),
            name: &port.name,
            at_mm: port.at_mm,
        });
        bodies.chain(ports)
    }

    fn check_names(&self, defaults: &mut Defaults) {
        let mut known: Vec<&str> = Vec::new();
        for PartInput { pointer, name, .. } in self.parts() {
            check_body_name(name, defaults, &pointer);
            if known.contains(&name) {
                defaults.refuse(format!("{pointer}/name"), format!("`{name}` is the name of another body or port"));
            }
            known.push(name);
        }
    }
}

/// A body or a port.
pub struct PartInput<'a> {
    /// Pointer to it.
    pub pointer: String,
    pub name: &'a str,
    pub at_mm: f64,
}

/// The number of a body or port; `None` for the ground, and after an error.
pub fn body(
    housing: Option<&HousingInput>,
    name: Option<&String>,
    defaults: &mut Defaults,
    pointer: String,
) -> Option<usize> {
    let name = name?;
    let names: Vec<&str> = housing.iter().flat_map(|housing| housing.parts()).map(|part| part.name).collect();
    number(&names, name, defaults, pointer)
}

/// Place of a name in a list; `None` after an error.
fn number(names: &[&str], name: &str, defaults: &mut Defaults, pointer: String) -> Option<usize> {
    let found = names.iter().position(|known| *known == name);
    if found.is_none() {
        let shown: String = name.chars().take(32).collect();
        let known = if names.is_empty() {
            "the scene has no `housing`".to_owned()
        } else {
            format!("bodies and ports are {}", names.join(", "))
        };
        defaults.refuse(pointer, format!("unknown body `{shown}`; {known}"));
    }
    found
}

impl BodyInput {
    fn resolve(&mut self, defaults: &mut Defaults, at: &str) -> Body {
        let is_inside = defaults.check_of_rotor(&format!("{at}/mass_kg"), self.mass_kg);
        defaults.check_of_rotor(&format!("{at}/at_mm"), self.at_mm);
        let mass = if is_inside { self.mass_kg } else { 1.0 };
        let pointer = format!("{at}/inertia_kg_m2");
        let least = limits::of_rotor_field(&pointer).map_or(0.0, |limits| limits.lowest);
        let usual = significant(mass * (mass / STEEL).powf(2.0 / 3.0) / 6.0, 6).max(least);
        let inertia = defaults.fill(pointer.clone(), &mut self.inertia_kg_m2, [usual; 3]);
        for (index, value) in inertia.iter().enumerate() {
            defaults.check_of_rotor(&format!("{pointer}/{index}"), *value);
        }
        Body { at: MM.to_si(self.at_mm), mass, inertia: [inertia[1], inertia[2]] }
    }
}

impl MountInput {
    /// The mount; `None` after an error in its bodies.
    fn resolve(&mut self, defaults: &mut Defaults, at: &str, (names, places): (&[String], &[f64])) -> Option<Mount> {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let body = number(&names, &self.body, defaults, format!("{at}/body"));
        let to = self.to.as_ref().map(|to| number(&names, to, defaults, format!("{at}/to")));
        if to.flatten().is_some() && to.flatten() == body {
            defaults.refuse(format!("{at}/to"), "must be another body");
        }
        let usual = body.and_then(|body| places.get(body)).map_or(0.0, |place| *place);
        let place = defaults.fill(format!("{at}/at_mm"), &mut self.at_mm, usual);
        defaults.check_of_rotor(&format!("{at}/at_mm"), place);
        let fields = SpringFields {
            stiffness: &self.stiffness_n_per_um,
            damping: &mut self.damping_n_s_per_m,
            tilt: &mut self.tilt_n_m_per_mrad,
            tilt_damping: &mut self.tilt_damping_n_m_s_per_rad,
        };
        let (stiffness, damping) = springs(defaults, at, fields);
        let body = body?;
        let to = match to {
            Some(to) => Some(to?),
            None => None,
        };
        Some(Mount { body, to, at: MM.to_si(place), stiffness, damping })
    }
}
