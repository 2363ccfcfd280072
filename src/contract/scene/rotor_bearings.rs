//! Ball bearings on a shaft.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::bearing::{BearingChoice, BearingInput};
use super::damping::DampingInput;
use super::lubricant::{LubricantChoice, LubricantInput};
use super::operation::{OperationInput, SpeedInput};
use super::scene_input::{ResolvedScene, SceneInput};
use super::shaft::check_place;
use super::surfaces::SurfacesInput;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::short;
use crate::contract::json::problem::FieldError;
use crate::contract::json::shapes::{NameOr, optional_object};
use crate::contract::json::units::{MM, MRAD, UM};
use crate::contract::json::uploads::Uploads;
use raceway_core::physics::statics::RingBearing;
use raceway_core::physics::statics::shaft::{Faces, Mounted};
use raceway_core::rotor::input::RotorBearing;

const POINTER: &str = "/scene/bearings";
const MAX_BEARINGS: usize = 8;
const MAX_NAME: usize = 32;
/// Names that channels have.
const RESERVED: [&str; 5] = ["spindle", "cage", "ball", "sensor", "shaft"];

/// A ball bearing on the shaft.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RotorBearingInput {
    /// Name: a letter, then letters, digits, `_` or `-`, at most 32; none of `spindle`, `cage`, `ball`, `sensor`, `shaft`.
    #[schema(pattern = "^[A-Za-z][A-Za-z0-9_-]{0,31}$", example = "A")]
    pub name: String,
    /// A preset name, a bearing, or a preset with changes.
    #[schema(value_type = BearingChoice)]
    pub bearing: NameOr<String, BearingInput>,
    /// Place of its pocket plane along the shaft [mm].
    #[schema(example = 40.0)]
    pub at_mm: f64,
    /// Direction of the shaft's thrust that it carries. Default `+x`.
    #[schema(nullable = false)]
    pub faces: Option<FacesName>,
    /// Damping of its contacts. Only `raceway` matters here.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub damping: Option<DampingInput>,
    /// Seat and place of the outer ring.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub outer_ring: Option<OuterRingInput>,
    /// A preset name or a lubricant. Default: that of the bearing's preset, else `grease`. It does not matter to jobs of kind `rotor`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<LubricantChoice>)]
    pub lubricant: Option<NameOr<String, LubricantInput>>,
    /// Surfaces of raceways and balls. Default: ideal circles and equal balls. They do not matter to jobs of kind `rotor`.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub surfaces: Option<SurfacesInput>,
    /// Azimuth at which its first ball starts, from +Y to +Z [°]. Default: 137.5° more than that of the bearing before, so that no ball
    /// passages coincide. It does not matter to jobs of kind `rotor`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.0)]
    pub start_azimuth_deg: Option<f64>,
}

/// `+x`: carries the shaft's thrust along +X. `-x`: its mirror image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub enum FacesName {
    #[serde(rename = "+x")]
    PlusX,
    #[serde(rename = "-x")]
    MinusX,
}

/// Outer ring of a bearing. It is held; elastic and sliding seats are not supported yet.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OuterRingInput {
    /// Seat. Default `rigid`, the only one so far.
    #[schema(nullable = false)]
    pub seat: Option<OuterRingSeatName>,
    /// Displacement of the outer ring from the centred place.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub offset_um: Option<OffsetInput>,
    /// Tilt of the outer ring.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub tilt_mrad: Option<OuterTiltInput>,
}

/// `rigid`: held in the ground. `elastic`, `sliding`: not supported yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OuterRingSeatName {
    Rigid,
    Elastic,
    Sliding,
}

/// Displacement along X, Y and Z [µm]. Default 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OffsetInput {
    /// Along X [µm]. Default 0.
    #[schema(nullable = false)]
    pub x: Option<f64>,
    /// Along Y [µm]. Default 0.
    #[schema(nullable = false)]
    pub y: Option<f64>,
    /// Along Z [µm]. Default 0.
    #[schema(nullable = false)]
    pub z: Option<f64>,
}

/// Rotation about Y and Z [mrad]. Default 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OuterTiltInput {
    /// About Y [mrad]. Default 0.
    #[schema(nullable = false)]
    pub y: Option<f64>,
    /// About Z [mrad]. Default 0.
    #[schema(nullable = false)]
    pub z: Option<f64>,
}

/// A bearing in SI.
pub struct ResolvedBearing {
    pub rotor: RotorBearing,
    /// The bearing alone, with all defaults.
    pub scene: ResolvedScene,
}

/// The bearings in SI. Errors are noted in `defaults`.
pub fn resolve(bearings: &mut [RotorBearingInput], defaults: &mut Defaults, length_mm: f64) -> Vec<ResolvedBearing> {
    if bearings.len() > MAX_BEARINGS {
        defaults.refuse(POINTER, format!("{} bearings: at most {MAX_BEARINGS}", bearings.len()));
    }
    let mut resolved = Vec::with_capacity(bearings.len());
    let mut widths: Vec<(f64, f64)> = Vec::new();
    for index in 0..bearings.len() {
        let at = format!("{POINTER}/{index}");
        let (known, rest) = bearings.split_at_mut(index);
        let Some(bearing) = rest.first_mut() else { continue };
        bearing.check_name(defaults, &at);
        if known.iter().any(|other| other.name == bearing.name) {
            defaults.refuse(format!("{at}/name"), format!("`{}` is the name of another bearing", bearing.name));
        }
        check_place(defaults, (&at, "at_mm"), bearing.at_mm, length_mm);
        let Some(one) = bearing.resolve(defaults, &at) else { continue };
        let (place, width) = (one.rotor.at, one.scene.scene.bearing.parameters.width);
        let overlaps = |(other, of): &(f64, f64)| (other - place).abs() < 0.5 * (of + width) * (1.0 - 1e-9);
        if widths.iter().any(overlaps) {
            let detail = format!("{} mm: the rings overlap those of another bearing", short(bearing.at_mm));
            defaults.refuse(format!("{at}/at_mm"), detail);
        }
        widths.push((place, width));
        resolved.push(one);
    }
    resolved
}

impl RotorBearingInput {
    fn check_name(&self, defaults: &mut Defaults, at: &str) {
        check_name(&self.name, defaults, at);
        if RESERVED.contains(&self.name.as_str()) {
            defaults.refuse(format!("{at}/name"), format!("`{}` is the name of a body; give another", self.name));
        }
    }

    /// The bearing; `None` after errors.
    fn resolve(&mut self, defaults: &mut Defaults, at: &str) -> Option<ResolvedBearing> {
        let faces = match defaults.fill(format!("{at}/faces"), &mut self.faces, FacesName::PlusX) {
            FacesName::PlusX => Faces::PlusX,
            FacesName::MinusX => Faces::MinusX,
        };
        let outer = self.outer_ring.get_or_insert_default().resolve(defaults, &format!("{at}/outer_ring"));
        // The scene of this bearing alone checks and fills its fields.
        let alone = SceneInput {
            bearing: self.bearing.clone(),
            operation: OperationInput {
                speed_rpm: SpeedInput::Constant(0.0),
                outer_speed_rpm: None,
                radial_load_y_n: None,
                radial_load_z_n: None,
                axial_load_n: None,
                loads: None,
                misalignment_mrad: None,
                initial_perturbation: None,
            },
            spindle: None,
            lubricant: self.lubricant.clone(),
            damping: self.damping.clone(),
            surfaces: self.surfaces.clone(),
            terms: None,
            gravity_m_s2: None,
        };
        let scene = match alone.resolve(&Uploads::default()) {
            Ok(scene) => scene,
            Err(errors) => {
                defaults.errors.extend(errors.into_iter().map(|error| in_list(error, at)));
                return None;
            }
        };
        self.bearing = scene.input.bearing.clone();
        self.damping = scene.input.damping.clone();
        if let Some(azimuth) = self.start_azimuth_deg {
            defaults.check_of_rotor(&format!("{at}/start_azimuth_deg"), azimuth);
        }
        let mut mounted = Mounted::new(RingBearing::new(&scene.scene.bearing), 0.0, faces);
        mounted.outer = outer;
        let damping = scene.scene.raceway_damping.resolve();
        Some(ResolvedBearing { rotor: RotorBearing { at: MM.to_si(self.at_mm), mounted, damping }, scene })
    }
}

/// Refuses a name that no channel can have; `at`: pointer to the object that has it.
pub(super) fn check_name(name: &str, defaults: &mut Defaults, at: &str) {
    let mut letters = name.chars();
    let is_pattern = letters.next().is_some_and(|first| first.is_ascii_alphabetic())
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-')
        && name.len() <= MAX_NAME;
    if !is_pattern {
        let detail = format!("must be a letter, then letters, digits, `_` or `-`, at most {MAX_NAME}");
        defaults.refuse(format!("{at}/name"), detail);
    }
}

impl OuterRingInput {
    /// Pose of the outer ring.
    fn resolve(&mut self, defaults: &mut Defaults, at: &str) -> [f64; 5] {
        if defaults.fill(format!("{at}/seat"), &mut self.seat, OuterRingSeatName::Rigid) != OuterRingSeatName::Rigid {
            defaults.refuse(format!("{at}/seat"), "not supported yet: `rigid` is the only seat so far");
        }
        let mut take = |name: &str, field: &mut Option<f64>| {
            let pointer = format!("{at}/{name}");
            let value = defaults.fill(pointer.clone(), field, 0.0);
            defaults.check_of_rotor(&pointer, value);
            value
        };
        let offset = self.offset_um.get_or_insert_default();
        let x = take("offset_um/x", &mut offset.x);
        let y = take("offset_um/y", &mut offset.y);
        let z = take("offset_um/z", &mut offset.z);
        let tilt = self.tilt_mrad.get_or_insert_default();
        let (about_y, about_z) = (take("tilt_mrad/y", &mut tilt.y), take("tilt_mrad/z", &mut tilt.z));
        [UM.to_si(x), UM.to_si(y), UM.to_si(z), MRAD.to_si(about_y), MRAD.to_si(about_z)]
    }
}

/// The error of a bearing alone, at its place in the list.
fn in_list(error: FieldError, at: &str) -> FieldError {
    match error.pointer.strip_prefix("/scene") {
        Some(rest) => FieldError::new(format!("{at}{rest}"), error.detail),
        None => error,
    }
}

/// A rigid preload of two bearings: their outer rings are set apart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PreloadInput {
    /// Names of two bearings that face opposite directions.
    #[schema(value_type = Vec<String>, min_items = 2, max_items = 2, example = json!(["A", "B"]))]
    pub between: [String; 2],
    /// Force that loads both at rest, the shaft centred [N]. Either this or `offset_um`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 200.0)]
    pub force_n: Option<f64>,
    /// Distance beyond the place where all balls just touch [µm].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub offset_um: Option<f64>,
}

/// Sets the outer rings of preloaded pairs. Errors are noted in `defaults`.
pub fn preload(
    preloads: &[PreloadInput],
    inputs: &[RotorBearingInput],
    bearings: &mut [ResolvedBearing],
    defaults: &mut Defaults,
) {
    use raceway_core::physics::statics::shaft::RigidShaft;

    for (index, preload) in preloads.iter().enumerate() {
        let at = format!("/scene/preloads/{index}");
        let place = |name: &String| inputs.iter().position(|bearing| bearing.name == *name);
        let [Some(one), Some(other)] = [place(&preload.between[0]), place(&preload.between[1])] else {
            defaults.refuse(format!("{at}/between"), "must be the names of two bearings");
            continue;
        };
        for index in [one, other] {
            let offset = inputs[index].outer_ring.and_then(|ring| ring.offset_um).and_then(|offset| offset.x);
            if offset.is_some_and(|offset| offset != 0.0) {
                let pointer = format!("/scene/bearings/{index}/outer_ring/offset_um/x");
                defaults.refuse(pointer, "the preload sets the place of this ring along X");
            }
        }
        if inputs[one].faces == inputs[other].faces {
            defaults.refuse(format!("{at}/between"), "the bearings must face opposite directions");
            continue;
        }
        let shaft = RigidShaft { bearings: bearings.iter().map(|bearing| bearing.rotor.mounted.clone()).collect() };
        let set = match (preload.force_n, preload.offset_um) {
            (Some(force), None) if defaults.check_of_rotor(&format!("{at}/force_n"), force) => {
                shaft.preloaded_by_force([one, other], force).map_err(|error| error.to_string())
            }
            (None, Some(offset)) if defaults.check_of_rotor(&format!("{at}/offset_um"), offset) => {
                Ok(shaft.preloaded_by_offset([one, other], UM.to_si(offset)))
            }
            (Some(_), None) | (None, Some(_)) => continue,
            _ => Err("give either force_n or offset_um".to_owned()),
        };
        match set {
            Ok(shaft) => {
                bearings.iter_mut().zip(shaft.bearings).for_each(|(bearing, mounted)| bearing.rotor.mounted = mounted);
            }
            Err(detail) => defaults.refuse(at, detail),
        }
    }
}
