//! Order codes of a request, and the numbers that follow: designation, clearance group, oil.

use raceway_core::physics::designation::{Designation, Suffix};
use raceway_core::physics::oil::WALTHER_LOWEST;
use raceway_core::physics::seat::Seat;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::numbers::{short, significant};
use crate::contract::json::problem::FieldError;
use crate::contract::scene::catalogue::ConfidenceName;
use crate::contract::scene::mounting::{GROUP, OperatingClearance};
use crate::contract::scene::oil::OilAtTemperature;
use crate::contract::scene::scene_input::ResolvedScene;

/// The bearing of the catalogue that the designation names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DesignationAnswer {
    /// Designation without suffixes and prefix.
    pub designation: String,
    /// Suffixes and prefix, and what they mean to the simulation.
    pub suffixes: Vec<SuffixAnswer>,
    /// Sources of number and size of the balls.
    pub source: String,
    /// How well these are supported.
    pub confidence: ConfidenceName,
    /// Makers with other balls, and ball sizes that fit almost as well; may be empty.
    pub note: String,
    /// Pointers to the fields that no catalogue gives: their defaults are assumptions.
    pub assumptions: Vec<String>,
}

/// A suffix of a designation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SuffixAnswer {
    /// The suffix, or the prefix.
    pub suffix: String,
    /// Its effect on the simulation.
    pub effect: String,
}

/// Radial clearance of a group: the clearance in operation is the unmounted one less fits and temperature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ClearanceAnswer {
    /// Name of the group.
    pub group: String,
    /// Least and greatest clearance of the group for this bore [µm].
    pub limits_um: [f64; 2],
    /// Middle of the group, unmounted [µm].
    pub unmounted_um: f64,
    /// Clearance that the fit on the shaft takes away [µm].
    pub shaft_fit_um: f64,
    /// Clearance that the fit in the housing takes away [µm].
    pub housing_fit_um: f64,
    /// Clearance that the temperatures take away [µm]; negative: they add some.
    pub temperature_um: f64,
    /// Clearance in operation, which is simulated [µm].
    pub operating_um: f64,
    /// Fit of the shaft's tolerance class; absent without a class.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub shaft: Option<SeatAnswer>,
    /// Fit of the housing's tolerance class; absent without a class.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub housing: Option<SeatAnswer>,
}

/// Interference that a tolerance class gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SeatAnswer {
    /// Tolerance class of the seat (ISO 286).
    pub class: String,
    /// Lower and upper limit of the seat from the nominal size [µm].
    pub limits_um: [f64; 2],
    /// Lower and upper limit of the bearing's bore or outer diameter from the nominal size [µm].
    pub ring_limits_um: [f64; 2],
    /// Interference between the middles of both [µm]; negative: a loose fit, which takes no clearance.
    pub interference_um: f64,
    /// Assumption of the interference.
    pub assumption: String,
}

const MIDDLES: &str =
    "interference between the middles of both tolerance fields; bearing of the normal tolerance class (ISO 492)";

/// The oil at running temperature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OilAnswer {
    /// Viscosity grade; absent for an oil by its viscosities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub grade: Option<String>,
    /// Temperature [°C].
    pub temperature_c: f64,
    /// Kinematic viscosity at that temperature [mm²/s].
    #[schema(minimum = 0)]
    pub kinematic_viscosity_mm2_s: f64,
    /// Density at that temperature [kg/m³].
    #[schema(minimum = 0)]
    pub density_kg_m3: f64,
    /// A of Walther's law, lg lg(ν + 0.7) = A − B lg T, with ν in mm²/s and T in K.
    pub walther_a: f64,
    /// B of Walther's law.
    pub walther_b: f64,
}

/// Fields of a bearing that the catalogue gives.
const OF_CATALOGUE: [&str; 8] = [
    "type",
    "outer_diameter_mm",
    "inner_diameter_mm",
    "width_mm",
    "ball_count",
    "ball_diameter_mm",
    "pitch_diameter_mm",
    "contact_angle_deg",
];

impl DesignationAnswer {
    /// The same of an item of `scene.bearings`.
    pub fn of_item(mut self, index: usize) -> Self {
        for pointer in &mut self.assumptions {
            *pointer = pointer.replacen("/scene/bearing/", &format!("/scene/bearings/{index}/bearing/"), 1);
        }
        self
    }

    /// The designation of a scene; `None` for other bearings.
    pub fn of(scene: &ResolvedScene) -> Option<Self> {
        let Designation { bearing, suffixes } = scene.ordered.designation.as_ref()?;
        let is_assumed = |pointer: &&String| {
            let field = pointer.strip_prefix("/scene/bearing/");
            field.is_some_and(|field| !OF_CATALOGUE.contains(&field))
        };
        Some(Self {
            designation: bearing.designation.to_owned(),
            suffixes: suffixes.iter().map(|suffix| SuffixAnswer::of(*suffix)).collect(),
            source: bearing.source.to_owned(),
            confidence: bearing.confidence.into(),
            note: bearing.note.to_owned(),
            assumptions: scene.defaults.iter().filter(is_assumed).cloned().collect(),
        })
    }
}

impl SuffixAnswer {
    fn of(suffix: Suffix) -> Self {
        let effect = match suffix {
            Suffix::Seals(_) => "rubbing seals: their friction is omitted",
            Suffix::Shields(_) => "shields or seals without contact: no effect",
            Suffix::Clearance(_) => "clearance group",
            Suffix::Tolerance(_) => "tolerance class: no effect, give `surfaces` for waviness",
            Suffix::Hybrid(_) => "balls of silicon nitride, `si3n4`",
            Suffix::Design(_) => "balls of the usual size, as in the catalogue",
            Suffix::Cage(_) => "cage of this material: no effect, give `bearing.cage` for its sizes",
        };
        Self { suffix: suffix.text().to_owned(), effect: effect.to_owned() }
    }
}

impl From<&OperatingClearance> for ClearanceAnswer {
    fn from(clearance: &OperatingClearance) -> Self {
        Self {
            group: clearance.group.name().to_owned(),
            limits_um: clearance.limits_um,
            unmounted_um: clearance.unmounted_um,
            shaft_fit_um: significant(clearance.shaft_fit_um, 6),
            housing_fit_um: significant(clearance.housing_fit_um, 6),
            temperature_um: significant(clearance.temperature_um, 6),
            operating_um: clearance.operating_um,
            shaft: clearance.shaft.map(SeatAnswer::from),
            housing: clearance.housing.map(SeatAnswer::from),
        }
    }
}

impl From<Seat> for SeatAnswer {
    fn from(seat: Seat) -> Self {
        Self {
            class: seat.class.to_owned(),
            limits_um: seat.limits_um,
            ring_limits_um: seat.ring_limits_um,
            interference_um: seat.interference_um,
            assumption: MIDDLES.to_owned(),
        }
    }
}

impl From<&OilAtTemperature> for OilAnswer {
    fn from(oil: &OilAtTemperature) -> Self {
        Self {
            grade: oil.grade.map(str::to_owned),
            temperature_c: oil.temperature,
            kinematic_viscosity_mm2_s: significant(oil.kinematic_viscosity, 6),
            density_kg_m3: significant(oil.density, 6),
            walther_a: significant(oil.law.a, 6),
            walther_b: significant(oil.law.b, 6),
        }
    }
}

/// Warnings of a clearance group without fits, of a clearance that fits and temperatures take away, and of an oil outside its law.
pub fn warnings(scene: &ResolvedScene) -> Vec<FieldError> {
    let mut found = Vec::new();
    if let Some(clearance) = &scene.ordered.clearance {
        let [unmounted, operating] =
            [clearance.unmounted_um, clearance.operating_um].map(|um| short(significant(um, 3)));
        let group = clearance.group.name();
        let mut warn = |detail: String| found.push(FieldError::new(GROUP, detail));
        if !clearance.has_fits {
            warn(format!(
                "{group}, {unmounted} µm, is the clearance of the unmounted bearing; give `fits`, because the mounted clearance is smaller"
            ));
        }
        if clearance.operating_um < 0.0 {
            warn(format!(
                "{group}, {unmounted} µm, is {operating} µm in operation, a radial preload; choose a group with more clearance, looser fits or smaller differences of temperature"
            ));
        }
    }
    if let Some(oil) = scene.ordered.oil.as_ref().filter(|oil| oil.kinematic_viscosity < WALTHER_LOWEST) {
        let (viscosity, temperature) = (short(significant(oil.kinematic_viscosity, 3)), short(oil.temperature));
        let detail = format!(
            "{temperature} °C: {viscosity} mm²/s by Walther's law, which holds above {WALTHER_LOWEST} mm²/s; give viscosity_pa_s instead"
        );
        found.push(FieldError::new("/scene/lubricant/temperature_c", detail));
    }
    found
}
