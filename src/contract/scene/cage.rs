//! The cage.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::shapes::{NameOr, optional_object};
use crate::contract::json::units::{DEG, G, MM, MRAD};
use crate::contract::scene::surfaces::are_within_limits;
use raceway_core::physics::cage::{CageParameters, GuidingLand, PocketFilm, PocketSeat};
use raceway_core::physics::contact::damping::DampingLaw;
use raceway_core::physics::defaults::{self, CrownCage};
use raceway_core::physics::lubricant::LubricantKind;
use raceway_core::physics::material::Material;

/// A crown cage. Empty fields are those of the bearing's preset; for a bearing without preset, those of the
/// article's crown cage scaled by pitch and ball diameter.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CageInput {
    /// Diametral clearance of a ball in its pocket [mm].
    #[schema(nullable = false, example = 0.051)]
    pub pocket_clearance_mm: Option<f64>,
    /// Mass [g].
    #[schema(nullable = false, example = 0.13)]
    pub mass_g: Option<f64>,
    /// Moment of inertia about the bearing axis [kg m²].
    #[schema(nullable = false, example = 5.5e-9)]
    pub axial_inertia_kg_m2: Option<f64>,
    /// Moment of inertia about a transverse axis [kg m²].
    #[schema(nullable = false, example = 3e-9)]
    pub transverse_inertia_kg_m2: Option<f64>,
    /// Distance from the centre of mass to the plane of the pockets, along +X [mm].
    #[schema(nullable = false, example = 0.7)]
    pub offset_mm: Option<f64>,
    /// Shape of a pocket. Default `open`.
    #[schema(nullable = false)]
    pub seat: Option<SeatName>,
    /// Angle between the axis of the pocket's mouth and its rim [°]. Default 65.
    #[schema(nullable = false, example = 65.0)]
    pub rim_angle_deg: Option<f64>,
    /// Half width of the pocket's seat for the film [mm].
    #[schema(nullable = false, example = 1.0)]
    pub seat_half_width_mm: Option<f64>,
    /// Lubricant film in the pockets. Default: `none` when dry, else `wedge`.
    #[schema(nullable = false, value_type = Option<FilmChoice>)]
    pub film: Option<NameOr<FilmName, FilmInput>>,
    /// Coefficient of dry friction in the pockets [-]. Default 0.08.
    #[schema(nullable = false, example = 0.08)]
    pub friction: Option<f64>,
    /// Slip speed at which that friction is fully developed [m/s]. Default 0.05.
    #[schema(nullable = false, example = 0.05)]
    pub friction_speed_m_s: Option<f64>,
    /// Stiffness of the cage bars in series with the pocket contacts [N/m]. Default: rigid bars.
    #[schema(nullable = false)]
    pub bar_stiffness_n_per_m: Option<f64>,
    /// Deviations of the pockets from equal spacing [mrad], one for each pocket. The balls start there, too. Default: equal spacing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, min_items = 2, max_items = 64)]
    pub pocket_spacing_mrad: Option<Vec<f64>>,
    /// Guiding land on the outer ring. Default: the cage is guided by the balls.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub land: Option<LandInput>,
}

/// `open`: a spherical cap that ends in a rim, as in a crown cage. `closed`: a whole sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SeatName {
    Open,
    Closed,
}

/// `wedge`: stiffness of a truncated wedge at the operating speed. `empirical-11`: 11 N at the edge of
/// the pocket, an empirical value from the literature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FilmName {
    None,
    Wedge,
    #[serde(rename = "empirical-11")]
    Empirical11,
}

/// A film by name, or by its constants.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
pub enum FilmChoice {
    Name(FilmName),
    Fields(FilmInput),
}

/// A film of given stiffness and damping.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FilmInput {
    /// Stiffness [N/m].
    #[schema(example = 38000.0)]
    pub stiffness_n_per_m: f64,
    /// Damping [N·s/m].
    #[schema(example = 3.0)]
    pub damping_n_s_per_m: f64,
}

/// A guiding land, a short journal bearing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LandInput {
    /// Diametral clearance [mm].
    #[schema(example = 0.1)]
    pub clearance_mm: f64,
    /// Diameter [mm].
    #[schema(example = 15.0)]
    pub diameter_mm: f64,
    /// Axial width [mm].
    #[schema(example = 0.5)]
    pub width_mm: f64,
}

impl CageInput {
    /// Deviations of the pockets from equal spacing [rad]; empty: none.
    pub fn pocket_deviations(&self, defaults: &mut Defaults) -> Vec<f64> {
        let mut one = |(index, &deviation): (usize, &f64)| {
            let item = index.to_string();
            let field = ("pocket_deviations", &item[..], deviation, MRAD);
            let at = "/scene/bearing/cage/pocket_spacing_mrad";
            if are_within_limits(defaults, (at, "bearing.cage"), &[field]) { MRAD.to_si(deviation) } else { 0.0 }
        };
        self.pocket_spacing_mrad.iter().flatten().enumerate().map(&mut one).collect()
    }

    /// The parameters of `physics`; empty fields are filled from `base`, whose fields are all given.
    pub fn resolve(
        &mut self,
        defaults: &mut Defaults,
        base: &CageInput,
        material: Material,
        lubricant: LubricantKind,
        damping: DampingLaw,
    ) -> CageParameters {
        let mut take = |name: &str, field: &mut Option<f64>, default: Option<f64>| {
            defaults.fill(format!("/scene/bearing/cage/{name}"), field, default.unwrap_or(f64::NAN))
        };
        let mass = G.to_si(take("mass_g", &mut self.mass_g, base.mass_g));
        let axial_inertia = take("axial_inertia_kg_m2", &mut self.axial_inertia_kg_m2, base.axial_inertia_kg_m2);
        let transverse_inertia =
            take("transverse_inertia_kg_m2", &mut self.transverse_inertia_kg_m2, base.transverse_inertia_kg_m2);
        let offset = MM.to_si(take("offset_mm", &mut self.offset_mm, base.offset_mm));
        let clearance = take("pocket_clearance_mm", &mut self.pocket_clearance_mm, base.pocket_clearance_mm);
        let rim_angle = DEG.to_si(take("rim_angle_deg", &mut self.rim_angle_deg, base.rim_angle_deg));
        let half_width = take("seat_half_width_mm", &mut self.seat_half_width_mm, base.seat_half_width_mm);
        let friction = take("friction", &mut self.friction, base.friction);
        let friction_speed = take("friction_speed_m_s", &mut self.friction_speed_m_s, base.friction_speed_m_s);
        let default_film = match defaults::pocket_film(lubricant) {
            PocketFilm::None => FilmName::None,
            _ => FilmName::Wedge,
        };
        let film = defaults.fill("/scene/bearing/cage/film", &mut self.film, NameOr::Name(default_film));
        let seat = defaults.fill("/scene/bearing/cage/seat", &mut self.seat, base.seat.unwrap_or(SeatName::Open));
        self.bar_stiffness_n_per_m = self.bar_stiffness_n_per_m.or(base.bar_stiffness_n_per_m);
        self.land = self.land.or(base.land);
        CageParameters {
            material,
            mass,
            axial_inertia,
            transverse_inertia,
            offset,
            pocket_clearance: MM.to_si(clearance),
            seat: match seat {
                SeatName::Open => PocketSeat::Open,
                SeatName::Closed => PocketSeat::Closed,
            },
            rim_angle,
            seat_half_width: MM.to_si(half_width),
            film: pocket_film(&film),
            friction,
            friction_speed,
            bar_stiffness: self.bar_stiffness_n_per_m,
            land: self.land.map(|land| GuidingLand {
                clearance: MM.to_si(land.clearance_mm),
                diameter: MM.to_si(land.diameter_mm),
                width: MM.to_si(land.width_mm),
            }),
            damping,
        }
    }
}

impl From<CrownCage> for CageInput {
    fn from(cage: CrownCage) -> Self {
        Self {
            pocket_clearance_mm: Some(cage.pocket_clearance_mm),
            mass_g: Some(cage.mass_g),
            axial_inertia_kg_m2: Some(cage.axial_inertia_kg_m2),
            transverse_inertia_kg_m2: Some(cage.transverse_inertia_kg_m2),
            offset_mm: Some(cage.offset_mm),
            seat: Some(SeatName::from(cage.seat)),
            rim_angle_deg: Some(cage.rim_angle_deg),
            seat_half_width_mm: Some(cage.seat_half_width_mm),
            friction: Some(cage.friction),
            friction_speed_m_s: Some(cage.friction_speed_m_s),
            ..Self::default()
        }
    }
}

impl From<PocketSeat> for SeatName {
    fn from(seat: PocketSeat) -> Self {
        match seat {
            PocketSeat::Open => Self::Open,
            PocketSeat::Closed => Self::Closed,
        }
    }
}

fn pocket_film(film: &NameOr<FilmName, FilmInput>) -> PocketFilm {
    match film {
        NameOr::Name(FilmName::None) => PocketFilm::None,
        NameOr::Name(FilmName::Wedge) => PocketFilm::Wedge,
        NameOr::Name(FilmName::Empirical11) => PocketFilm::Empirical11,
        NameOr::Object(given) => {
            PocketFilm::Given { stiffness: given.stiffness_n_per_m, damping: given.damping_n_s_per_m }
        }
    }
}
