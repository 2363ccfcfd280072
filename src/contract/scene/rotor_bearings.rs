//! Ball bearings on a shaft.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::bearing::{BearingChoice, BearingInput};
use super::damping::DampingInput;
use super::housing::HousingInput;
use super::lubricant::{LubricantChoice, LubricantInput};
use super::names::check_body_name;
use super::operation::{OperationInput, SpeedInput};
use super::outer_ring::{OuterRingInput, OuterRingSeatName};
use super::scene_input::{ResolvedScene, SceneInput};
use super::shaft::check_place;
use super::surfaces::{SEED, SurfacesInput};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::short;
use crate::contract::json::problem::FieldError;
use crate::contract::json::shapes::{NameOr, optional_object};
use crate::contract::json::units::{MM, UM};
use crate::contract::json::uploads::Uploads;
use raceway_core::physics::statics::RingBearing;
use raceway_core::physics::statics::shaft::{Faces, Mounted};
use raceway_core::rotor::input::{RotorBearing, Seat};

const POINTER: &str = "/scene/bearings";
const MAX_BEARINGS: usize = 8;

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
    /// Surfaces of raceways and balls. Default: ideal circles and equal balls. The seed of the first bearing is 1 by default, that of the next one 2,
    /// so that drawn surfaces differ. They do not matter to jobs of kind `rotor`.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub surfaces: Option<SurfacesInput>,
    /// Azimuth at which its first ball starts, from +Y to +Z [°]. Default: 137.5° more than that of the bearing before, so that no ball
    /// passages coincide. It does not matter to jobs of kind `rotor`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.0)]
    pub start_azimuth_deg: Option<f64>,
}

/// `+x`: carries the shaft's thrust along +X. `-x`: its mirror image, crown cage and surfaces included. What its fields place along +X, such as
/// `across_mm` of a defect, lies along −X of the shaft; `outer_ring` refers to the shaft's axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub enum FacesName {
    #[serde(rename = "+x")]
    PlusX,
    #[serde(rename = "-x")]
    MinusX,
}

/// A bearing in SI.
pub struct ResolvedBearing {
    pub rotor: RotorBearing,
    /// The bearing alone, with all defaults.
    pub scene: ResolvedScene,
}

/// The bearings in SI. Errors are noted in `defaults`.
pub fn resolve(
    bearings: &mut [RotorBearingInput],
    defaults: &mut Defaults,
    length_mm: f64,
    housing: Option<&HousingInput>,
) -> Vec<ResolvedBearing> {
    if bearings.len() > MAX_BEARINGS {
        defaults.refuse(POINTER, format!("{} bearings: at most {MAX_BEARINGS}", bearings.len()));
    }
    let mut resolved = Vec::with_capacity(bearings.len());
    let mut widths: Vec<(f64, f64)> = Vec::new();
    for index in 0..bearings.len() {
        let at = format!("{POINTER}/{index}");
        let (known, rest) = bearings.split_at_mut(index);
        let Some(bearing) = rest.first_mut() else { continue };
        check_body_name(&bearing.name, defaults, &at);
        if known.iter().any(|other| other.name == bearing.name) {
            defaults.refuse(format!("{at}/name"), format!("`{}` is the name of another bearing", bearing.name));
        }
        check_place(defaults, (&at, "at_mm"), bearing.at_mm, length_mm);
        let Some(one) = bearing.resolve(defaults, (index, &at), housing) else { continue };
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
    /// True if a spring presses on its outer ring.
    pub(super) fn has_spring(&self) -> bool {
        self.outer_ring.as_ref().is_some_and(|ring| ring.seat == Some(OuterRingSeatName::Sliding))
    }

    /// The bearing at this place of the list; `None` after errors.
    fn resolve(
        &mut self,
        defaults: &mut Defaults,
        (index, at): (usize, &str),
        housing: Option<&HousingInput>,
    ) -> Option<ResolvedBearing> {
        let faces = match defaults.fill(format!("{at}/faces"), &mut self.faces, FacesName::PlusX) {
            FacesName::PlusX => Faces::PlusX,
            FacesName::MinusX => Faces::MinusX,
        };
        let mut surfaces = self.surfaces.clone();
        if let Some(surfaces) = &mut surfaces {
            // Equal surfaces of two bearings would excite the shaft in step.
            surfaces.seed.get_or_insert(SEED + index as u64);
        }
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
            surfaces,
            terms: None,
            gravity_m_s2: None,
            contamination_factor: None,
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
        let ring = self.outer_ring.get_or_insert_default();
        let ring = ring.resolve(defaults, &format!("{at}/outer_ring"), &scene.scene.bearing, housing);
        let mut mounted = Mounted::new(RingBearing::new(&scene.scene.bearing), 0.0, faces);
        mounted.outer = ring.pose;
        let damping = scene.scene.raceway_damping.resolve();
        let (at, on, seat) = (MM.to_si(self.at_mm), ring.on, ring.seat);
        Some(ResolvedBearing { rotor: RotorBearing { at, mounted, damping, on, seat, has_moments: true }, scene })
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

    // The preload that has set the place of each ring.
    let mut set_by: Vec<Option<usize>> = vec![None; inputs.len()];
    for (index, preload) in preloads.iter().enumerate() {
        let at = format!("/scene/preloads/{index}");
        let place = |name: &String| inputs.iter().position(|bearing| bearing.name == *name);
        let [Some(one), Some(other)] = [place(&preload.between[0]), place(&preload.between[1])] else {
            defaults.refuse(format!("{at}/between"), "must be the names of two bearings");
            continue;
        };
        for index in [one, other] {
            let ring = inputs[index].outer_ring.as_ref();
            let offset = ring.and_then(|ring| ring.offset_um).and_then(|offset| offset.x);
            if offset.is_some_and(|offset| offset != 0.0) {
                let pointer = format!("/scene/bearings/{index}/outer_ring/offset_um/x");
                defaults.refuse(pointer, "the preload sets the place of this ring along X");
            }
        }
        let set = [one, other].into_iter().find_map(|bearing| Some((bearing, set_by[bearing]?)));
        if let Some((bearing, before)) = set {
            let detail = format!("the ring of `{}` is set by preloads[{before}] already", inputs[bearing].name);
            defaults.refuse(format!("{at}/between"), detail);
            continue;
        }
        [one, other].into_iter().for_each(|bearing| set_by[bearing] = Some(index));
        let sliding =
            [one, other].into_iter().find(|index| matches!(bearings[*index].rotor.seat, Seat::Sliding { .. }));
        if let Some(index) = sliding {
            let detail = format!("the ring of `{}` slides: its spring sets the preload", inputs[index].name);
            defaults.refuse(format!("{at}/between"), detail);
            continue;
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
