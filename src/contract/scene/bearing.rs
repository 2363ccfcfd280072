//! A bearing: a preset by name, a preset with changes, or its dimensions.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::cage::CageInput;
use super::material::MaterialsInput;
use super::mounting::{ClearanceGroupName, FitsInput, TemperaturesInput};
use super::preset_names::BearingName;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::short;
use crate::contract::json::shapes::{optional_object, whole_number};
use crate::contract::json::units::{DEG, MM, UM};
use raceway_core::physics::bearing::{BearingKind, BearingParameters, Fit, PerRaceway};
use raceway_core::physics::material::Material;

/// A ball bearing. With `preset`, the given fields replace those of the preset. Without it, the ball count,
/// all diameters and the width are required; the other fields have defaults.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BearingInput {
    /// Preset of `GET /v1/presets` or designation of `GET /v1/catalogue` to start from, such as `6206-2RS/C3`. A suffix C2 to C5 sets the
    /// clearance group.
    #[schema(nullable = false, value_type = Option<BearingName>, example = "article-integrated")]
    pub preset: Option<String>,
    /// Default `deep_groove`.
    #[serde(rename = "type")]
    #[schema(nullable = false)]
    pub kind: Option<BearingType>,
    /// Outer diameter D [mm].
    #[schema(nullable = false, example = 18.0)]
    pub outer_diameter_mm: Option<f64>,
    /// Bore [mm]; for an integrated bearing the diameter of its spindle.
    #[schema(nullable = false, example = 8.5)]
    pub inner_diameter_mm: Option<f64>,
    /// Width B [mm].
    #[schema(nullable = false, example = 5.9)]
    pub width_mm: Option<f64>,
    /// Number of balls Z [-].
    #[serde(default, deserialize_with = "whole_number::<_, 2, 64>")]
    #[schema(nullable = false, example = 7)]
    pub ball_count: Option<u32>,
    /// Ball diameter d [mm].
    #[schema(nullable = false, example = 2.778)]
    pub ball_diameter_mm: Option<f64>,
    /// Pitch diameter D_m [mm].
    #[schema(nullable = false, example = 13.0)]
    pub pitch_diameter_mm: Option<f64>,
    /// Groove radius of the inner raceway over ball diameter [-]. Default 0.52.
    #[schema(nullable = false, example = 0.529)]
    pub inner_groove_curvature: Option<f64>,
    /// Groove radius of the outer raceway over ball diameter [-]. Default 0.53.
    #[schema(nullable = false, example = 0.529)]
    pub outer_groove_curvature: Option<f64>,
    /// Diametral radial clearance [µm]; negative: a radial preload. At least −2 % of the ball diameter. At most the clearance of a free
    /// contact angle of 60°: ball diameter times the sum of the groove curvatures minus 1. Default: middle of ISO 5753-1 group N for the
    /// bore; for `angular_contact` a contact angle of 15°.
    #[schema(nullable = false, example = 5.0)]
    pub radial_clearance_um: Option<f64>,
    /// Clearance group of an unmounted deep-groove bearing, instead of `radial_clearance_um`: the middle of the group for the bore, less what
    /// `fits` and `temperatures` take away. The resolved scene has the clearance in operation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub radial_clearance_group: Option<ClearanceGroupName>,
    /// Fits on shaft and in housing, which take clearance from a group.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub fits: Option<FitsInput>,
    /// Temperatures of rings and balls, which take clearance from a group.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub temperatures: Option<TemperaturesInput>,
    /// Free contact angle [°]. Either this or `radial_clearance_um`.
    #[schema(nullable = false)]
    pub contact_angle_deg: Option<f64>,
    /// Basic dynamic load rating C of the maker, for the life only [N]. Default: by ISO 281.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 14000)]
    pub dynamic_load_rating_n: Option<f64>,
    /// Basic static load rating C₀ of the maker, for the life only [N]. Default: by ISO 76.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 7850)]
    pub static_load_rating_n: Option<f64>,
    /// Factor f₀ of the maker, for the life only [-]. Default: by ISO 76.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 13.9)]
    pub f0: Option<f64>,
    /// Fatigue load limit C_u of the maker [N], for `life.a_iso`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 335)]
    pub fatigue_load_limit_n: Option<f64>,
    /// Rms roughness R_q of the raceways [µm], for `life.lambda` only. Default 0.05.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.05)]
    pub raceway_roughness_um: Option<f64>,
    /// Rms roughness R_q of the balls [µm], for `life.lambda` only. Default 0.05.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.02)]
    pub ball_roughness_um: Option<f64>,
    /// Materials of balls, raceways and cage.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub materials: Option<MaterialsInput>,
    /// The cage.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub cage: Option<CageInput>,
}

/// Name of a preset of `GET /v1/presets`, a designation of `GET /v1/catalogue`, a bearing by its dimensions, or one of these with changes.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
pub enum BearingChoice {
    /// Name of a preset, or a designation.
    Name(BearingName),
    Fields(Box<BearingInput>),
}

/// `integrated`: the inner raceway is ground on the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum BearingType {
    Integrated,
    DeepGroove,
    AngularContact,
}

/// Outer diameter of the smallest ball bearings in use, and the largest that is accepted [mm].
const MIN_OUTER_DIAMETER_MM: f64 = 1.0;
const MAX_OUTER_DIAMETER_MM: f64 = 12_000.0;
/// Largest ratio of two lengths of a bearing [-]; the balls of large thin rings are a hundredth of the diameter.
const MAX_LENGTH_RATIO: f64 = 500.0;

impl BearingInput {
    /// The parameters of `physics`; empty fields are filled from `base`.
    pub fn resolve(
        &mut self,
        defaults: &mut Defaults,
        base: &BearingInput,
        ball_material: Material,
        raceway_material: PerRaceway<Material>,
    ) -> BearingParameters {
        let kind = base.kind.unwrap_or(BearingType::DeepGroove);
        let kind = defaults.fill("/scene/bearing/type", &mut self.kind, kind);
        let ball_count = defaults.fill("/scene/bearing/ball_count", &mut self.ball_count, base.ball_count.unwrap_or(0));
        let fit = self.fit(defaults, base);
        let mut take = |name: &str, field: &mut Option<f64>, default: Option<f64>| {
            defaults.fill(format!("/scene/bearing/{name}"), field, default.unwrap_or(f64::NAN))
        };
        let outer = take("outer_diameter_mm", &mut self.outer_diameter_mm, base.outer_diameter_mm);
        let inner = take("inner_diameter_mm", &mut self.inner_diameter_mm, base.inner_diameter_mm);
        let width = take("width_mm", &mut self.width_mm, base.width_mm);
        let ball = take("ball_diameter_mm", &mut self.ball_diameter_mm, base.ball_diameter_mm);
        let pitch = take("pitch_diameter_mm", &mut self.pitch_diameter_mm, base.pitch_diameter_mm);
        let inner_curvature =
            take("inner_groove_curvature", &mut self.inner_groove_curvature, base.inner_groove_curvature);
        let outer_curvature =
            take("outer_groove_curvature", &mut self.outer_groove_curvature, base.outer_groove_curvature);
        self.refuse_metres(defaults);
        BearingParameters {
            kind: kind.in_physics(),
            outer_diameter: MM.to_si(outer),
            inner_diameter: MM.to_si(inner),
            width: MM.to_si(width),
            ball_count: ball_count as usize,
            ball_diameter: MM.to_si(ball),
            pitch_diameter: MM.to_si(pitch),
            groove_curvature: PerRaceway { inner: inner_curvature, outer: outer_curvature },
            fit,
            ball_material,
            raceway_material,
        }
    }

    /// Refuses lengths that were probably given in m instead of mm, at their own fields: the inconsistencies they cause would be reported at
    /// other fields.
    fn refuse_metres(&self, defaults: &mut Defaults) {
        let lengths = [
            ("outer_diameter_mm", self.outer_diameter_mm),
            ("inner_diameter_mm", self.inner_diameter_mm),
            ("width_mm", self.width_mm),
            ("ball_diameter_mm", self.ball_diameter_mm),
            ("pitch_diameter_mm", self.pitch_diameter_mm),
        ]
        .map(|(name, length)| (name, length.unwrap_or(f64::NAN)));
        let sound = lengths.into_iter().filter(|length| length.1 > 0.0 && length.1 < MAX_OUTER_DIAMETER_MM);
        let Some(largest) = sound.clone().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        let all_small = largest.1 < MIN_OUTER_DIAMETER_MM;
        for (name, length) in sound.filter(|length| all_small || length.1 * MAX_LENGTH_RATIO < largest.1) {
            let pointer = format!("/scene/bearing/{name}");
            if defaults.filled.contains(&pointer) {
                continue;
            }
            let small = if all_small {
                "smaller than any ball bearing".to_owned()
            } else {
                format!("less than a {MAX_LENGTH_RATIO}th of `{}`, {} mm", largest.0, short(largest.1))
            };
            let perhaps = short(length * 1e3);
            defaults.refuse(pointer, format!("{} mm: {small}; lengths are in mm, not in m: {perhaps}?", short(length)));
            defaults.substitute();
        }
    }

    /// The given clearance or contact angle, else that of `base`.
    fn fit(&mut self, defaults: &mut Defaults, base: &BearingInput) -> Fit {
        const ANGLE: &str = "/scene/bearing/contact_angle_deg";
        match (self.radial_clearance_um, self.contact_angle_deg) {
            (Some(clearance), angle) => {
                if angle.is_some() {
                    defaults.refuse(
                        ANGLE,
                        "give either radial_clearance_um or contact_angle_deg: one determines the other",
                    );
                }
                Fit::RadialClearance(UM.to_si(clearance))
            }
            (None, Some(angle)) => Fit::ContactAngle(DEG.to_si(angle)),
            (None, None) => match base.contact_angle_deg {
                Some(angle) => Fit::ContactAngle(DEG.to_si(defaults.fill(ANGLE, &mut self.contact_angle_deg, angle))),
                None => {
                    let clearance = base.radial_clearance_um.unwrap_or(0.0);
                    let pointer = "/scene/bearing/radial_clearance_um";
                    Fit::RadialClearance(UM.to_si(defaults.fill(pointer, &mut self.radial_clearance_um, clearance)))
                }
            },
        }
    }
}

impl From<BearingKind> for BearingType {
    fn from(kind: BearingKind) -> Self {
        match kind {
            BearingKind::Integrated => Self::Integrated,
            BearingKind::DeepGroove => Self::DeepGroove,
            BearingKind::AngularContact => Self::AngularContact,
        }
    }
}

impl BearingType {
    pub fn in_physics(self) -> BearingKind {
        match self {
            Self::Integrated => BearingKind::Integrated,
            Self::DeepGroove => BearingKind::DeepGroove,
            Self::AngularContact => BearingKind::AngularContact,
        }
    }
}
