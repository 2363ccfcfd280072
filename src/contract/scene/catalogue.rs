//! The catalogue of `physics` as a response.

use raceway_core::physics::catalogue::{CatalogueBearing, Confidence, bearings};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::bearing::BearingType;

/// Ball bearings of the catalogue that a search finds.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CatalogueAnswer {
    /// Number of bearings that were found.
    pub count: u32,
    /// The bearings, by series and bore.
    pub bearings: Vec<CatalogueEntry>,
}

/// A bearing of the catalogue. Its designation is a value of `scene.bearing`. Groove curvature, clearance, cage and mass are not in here, because no
/// public source gives them: `POST /v1/scenes/resolve` shows their defaults.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CatalogueEntry {
    /// Designation without suffixes of seals, clearance and tolerance.
    #[schema(example = "6205")]
    pub designation: &'static str,
    /// Series.
    #[schema(example = "62")]
    pub series: &'static str,
    /// Deep-groove or angular-contact.
    #[serde(rename = "type")]
    pub kind: BearingType,
    /// Bore [mm].
    #[schema(minimum = 0)]
    pub bore_mm: f64,
    /// Outer diameter D [mm].
    #[schema(minimum = 0)]
    pub outer_diameter_mm: f64,
    /// Width B [mm].
    #[schema(minimum = 0)]
    pub width_mm: f64,
    /// Number of balls Z [-].
    #[schema(value_type = u32)]
    pub ball_count: usize,
    /// Ball diameter d [mm].
    #[schema(minimum = 0)]
    pub ball_diameter_mm: f64,
    /// Pitch diameter D_m [mm].
    #[schema(minimum = 0)]
    pub pitch_diameter_mm: f64,
    /// Free contact angle [°]; 0 for deep-groove bearings.
    #[schema(minimum = 0)]
    pub contact_angle_deg: f64,
    /// Basic dynamic load rating as printed by a maker [kN].
    #[schema(minimum = 0)]
    pub c_listed_kn: f64,
    /// That maker.
    pub c_listed_by: &'static str,
    /// Basic dynamic load rating by ISO 281 from the geometry [kN].
    #[schema(minimum = 0)]
    pub c_iso281_kn: f64,
    /// Frequencies of rolling at the free contact angle, over the speed of the shaft.
    pub frequencies: FrequencyFactorsAnswer,
    /// Sources of number and size of the balls.
    pub source: &'static str,
    /// How well these are supported.
    pub confidence: ConfidenceName,
    /// Makers with other balls, and ball sizes that fit almost as well; may be empty.
    pub note: &'static str,
}

/// Frequencies over the speed of the shaft [-].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct FrequencyFactorsAnswer {
    /// FTF, cage.
    #[schema(minimum = 0)]
    pub ftf: f64,
    /// BPFO, balls passing a point of the outer raceway.
    #[schema(minimum = 0)]
    pub bpfo: f64,
    /// BPFI, balls passing a point of the inner raceway.
    #[schema(minimum = 0)]
    pub bpfi: f64,
    /// BSF, turns of a ball; a ball defect strikes at twice this.
    #[schema(minimum = 0)]
    pub bsf: f64,
}

/// `high`: printed by a maker, or ratings of one maker confirmed by a second source. `medium`: a unique fit to the ratings of one maker. `low`:
/// another number of balls fits almost as well, or the pitch circle was inferred.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ConfidenceName {
    High,
    Medium,
    Low,
}

/// Selection of bearings; empty fields select all.
#[derive(Debug, Clone, Default)]
pub struct CatalogueSearch {
    pub series: Option<String>,
    pub bore_mm: Option<f64>,
    pub min_c_kn: Option<f64>,
    /// Text in the designation, without regard to case.
    pub text: Option<String>,
}

/// The bearings that meet all conditions.
pub fn catalogue_answer(search: &CatalogueSearch) -> CatalogueAnswer {
    let text = search.text.as_ref().map(|text| text.trim().to_ascii_uppercase());
    let matches = |bearing: &&CatalogueBearing| {
        search.series.as_ref().is_none_or(|series| bearing.series() == series)
            && search.bore_mm.is_none_or(|bore| (bearing.dimensions.inner_diameter_mm - bore).abs() < 1e-6)
            && search.min_c_kn.is_none_or(|least| bearing.rating_kn >= least)
            && text.as_ref().is_none_or(|text| bearing.designation.contains(text.as_str()))
    };
    let bearings: Vec<CatalogueEntry> = bearings().iter().filter(matches).map(CatalogueEntry::from).collect();
    CatalogueAnswer { count: bearings.len() as u32, bearings }
}

impl From<&CatalogueBearing> for CatalogueEntry {
    fn from(bearing: &CatalogueBearing) -> Self {
        let (size, factors) = (bearing.dimensions, bearing.factors);
        Self {
            designation: bearing.designation,
            series: bearing.series(),
            kind: bearing.kind.into(),
            bore_mm: size.inner_diameter_mm,
            outer_diameter_mm: size.outer_diameter_mm,
            width_mm: size.width_mm,
            ball_count: size.ball_count,
            ball_diameter_mm: size.ball_diameter_mm,
            pitch_diameter_mm: size.pitch_diameter_mm,
            contact_angle_deg: bearing.contact_angle_deg,
            c_listed_kn: bearing.listed_rating_kn,
            c_listed_by: bearing.rating_source,
            c_iso281_kn: bearing.rating_kn,
            frequencies: FrequencyFactorsAnswer {
                ftf: factors.cage,
                bpfo: factors.ball_pass_outer,
                bpfi: factors.ball_pass_inner,
                bsf: factors.ball_spin,
            },
            source: bearing.source,
            confidence: bearing.confidence.into(),
            note: bearing.note,
        }
    }
}

impl From<Confidence> for ConfidenceName {
    fn from(confidence: Confidence) -> Self {
        match confidence {
            Confidence::High => Self::High,
            Confidence::Medium => Self::Medium,
            Confidence::Low => Self::Low,
        }
    }
}
