//! Clearance as it is ordered and mounted: a group, less what fits and temperatures take away.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::preset_names::{HousingClassName, ShaftClassName};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::{short, significant};
use crate::contract::json::problem::listed;
use raceway_core::physics::bearing::PerRaceway;
use raceway_core::physics::clearance::{
    ClearanceGroup, Expansion, InnerFit, OuterFit, bores_of, groove_bottoms, limits_um, middle,
};
use raceway_core::physics::material::{GCR15, Material};
use raceway_core::physics::presets;
use raceway_core::physics::seat::{self, HOUSING_CLASSES, SHAFT_CLASSES, Seat};

/// Group of radial internal clearance: C2 to C5 of ISO 5753-1 by bore, for bores below 10 mm also MC1 to MC6.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "UPPERCASE")]
pub enum ClearanceGroupName {
    C2,
    Cn,
    C3,
    C4,
    C5,
    Mc1,
    Mc2,
    Mc3,
    Mc4,
    Mc5,
    Mc6,
}

impl ClearanceGroupName {
    pub fn in_physics(self) -> ClearanceGroup {
        match self {
            Self::C2 => ClearanceGroup::C2,
            Self::Cn => ClearanceGroup::Cn,
            Self::C3 => ClearanceGroup::C3,
            Self::C4 => ClearanceGroup::C4,
            Self::C5 => ClearanceGroup::C5,
            Self::Mc1 => ClearanceGroup::Mc1,
            Self::Mc2 => ClearanceGroup::Mc2,
            Self::Mc3 => ClearanceGroup::Mc3,
            Self::Mc4 => ClearanceGroup::Mc4,
            Self::Mc5 => ClearanceGroup::Mc5,
            Self::Mc6 => ClearanceGroup::Mc6,
        }
    }
}

/// Interferences of the rings on steel shaft and in steel housing. Rings are thick-walled cylinders up to the bottom of the groove (Lamé). The
/// smoothing of the surfaces and thermal growth of shaft and housing are omitted.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FitsInput {
    /// Tolerance class of the shaft (ISO 286), instead of `shaft_interference_um`. The interference is that between the middles of both tolerance
    /// fields; the bore has the normal tolerance class of ISO 492.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<ShaftClassName>, example = "k5")]
    pub shaft: Option<String>,
    /// Diametral interference of shaft and bore [µm]; negative: a loose fit, which takes no clearance. Default 0.
    #[schema(nullable = false, example = 8.0)]
    pub shaft_interference_um: Option<f64>,
    /// Tolerance class of the housing (ISO 286), instead of `housing_interference_um`. The outer diameter of the bearing has the normal tolerance
    /// class of ISO 492.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<HousingClassName>, example = "H7")]
    pub housing: Option<String>,
    /// Bore of a hollow shaft [mm]. Default 0: solid.
    #[schema(nullable = false)]
    pub shaft_bore_mm: Option<f64>,
    /// Diametral interference of outer ring and housing [µm]; negative: a loose fit, which takes no clearance. Default 0.
    #[schema(nullable = false)]
    pub housing_interference_um: Option<f64>,
    /// Outer diameter of the housing [mm]. Default: so large that it does not matter.
    #[schema(nullable = false)]
    pub housing_outer_diameter_mm: Option<f64>,
}

/// Temperatures of the parts in operation. The clearance of a group holds at 20 °C.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TemperaturesInput {
    /// Temperature of the inner ring [°C]. Default 20.
    #[schema(nullable = false, example = 60.0)]
    pub inner_ring_c: Option<f64>,
    /// Temperature of the balls [°C]. Default: the mean of both rings.
    #[schema(nullable = false)]
    pub balls_c: Option<f64>,
    /// Temperature of the outer ring [°C]. Default 20.
    #[schema(nullable = false, example = 50.0)]
    pub outer_ring_c: Option<f64>,
    /// Coefficient of thermal expansion of the rings [1/K]. Default 11.5e-6, bearing steel.
    #[schema(nullable = false)]
    pub ring_expansion_per_k: Option<f64>,
    /// Coefficient of thermal expansion of the balls [1/K]. Default 11.5e-6; for balls of `si3n4` 3.2e-6.
    #[schema(nullable = false)]
    pub ball_expansion_per_k: Option<f64>,
}

/// Temperature at which clearances are measured [°C] (ISO 1).
const REFERENCE_TEMPERATURE: f64 = 20.0;
/// Coefficients of thermal expansion [1/K]: bearing steel, and silicon nitride by data sheets.
const STEEL_EXPANSION: f64 = 11.5e-6;
const NITRIDE_EXPANSION: f64 = 3.2e-6;

/// Clearance of a group in operation [µm].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatingClearance {
    pub group: ClearanceGroup,
    /// Least and greatest clearance of the group.
    pub limits_um: [f64; 2],
    /// Middle of the group.
    pub unmounted_um: f64,
    /// Clearance that the fits and the temperatures take away.
    pub shaft_fit_um: f64,
    pub housing_fit_um: f64,
    pub temperature_um: f64,
    /// Clearance of the simulated bearing.
    pub operating_um: f64,
    /// True if fits are given.
    pub has_fits: bool,
    /// Seats whose tolerance class is named.
    pub shaft: Option<Seat>,
    pub housing: Option<Seat>,
}

/// Materials that matter to the clearance.
pub struct RingsAndBalls {
    pub rings: PerRaceway<Material>,
    pub ball: Material,
}

/// Diameters of a bearing [mm].
pub struct Sizes {
    pub bore: f64,
    pub outside: f64,
    pub ball: f64,
    pub pitch: f64,
}

pub const GROUP: &str = "/scene/bearing/radial_clearance_group";
pub const FITS: &str = "/scene/bearing/fits";
pub const TEMPERATURES: &str = "/scene/bearing/temperatures";

/// Clearance in operation of a group, less what fits and temperatures take away; `None` for bores without the group.
pub fn operating_clearance(
    group: ClearanceGroup,
    fits: Option<&FitsInput>,
    temperatures: Option<&TemperaturesInput>,
    (sizes, materials): (&Sizes, &RingsAndBalls),
    defaults: &mut Defaults,
) -> Option<OperatingClearance> {
    let Some(limits_um) = limits_um(group, sizes.bore) else {
        defaults.refuse(GROUP, no_group(group, sizes.bore));
        return None;
    };
    let unmounted_um = middle(limits_um);
    let grooves = groove_bottoms(sizes.pitch, sizes.ball, unmounted_um / 1e3);
    let shaft = fits.and_then(|fits| fits.shaft_seat(sizes.bore, defaults));
    let housing = fits.and_then(|fits| fits.housing_seat(sizes.outside, defaults));
    let [shaft_fit_um, housing_fit_um] =
        fits.map_or([0.0; 2], |fits| fits.clearance_loss((shaft, housing), sizes, grooves, &materials.rings, defaults));
    let of_temperature =
        temperatures.map(|temperatures| temperatures.clearance_loss(sizes.ball, grooves, materials.ball, defaults));
    let temperature_um = 1e3 * of_temperature.unwrap_or_default();
    let operating_um = significant(unmounted_um - shaft_fit_um - housing_fit_um - temperature_um, 6);
    operating_um.is_finite().then_some(OperatingClearance {
        group,
        limits_um,
        unmounted_um,
        shaft_fit_um,
        housing_fit_um,
        temperature_um,
        operating_um,
        has_fits: fits.is_some_and(FitsInput::is_given),
        shaft,
        housing,
    })
}

/// Why a bore has no such group.
fn no_group(group: ClearanceGroup, bore: f64) -> String {
    let bores = bores_of(group);
    let range = match bores.over {
        0.0 => format!("below {} mm", short(bores.up_to)),
        over => format!("above {} mm up to {} mm", short(over), short(bores.up_to)),
    };
    let remedy = if bore <= bores.over { "; MC1 to MC6 are for bores below 10 mm" } else { "" };
    format!("{} is for bores {range}, this one has {} mm{remedy}", group.name(), short(bore))
}

impl FitsInput {
    /// True if a fit is given, and not only a size of shaft or housing.
    fn is_given(&self) -> bool {
        let classes = [&self.shaft, &self.housing].into_iter().any(Option::is_some);
        classes || [self.shaft_interference_um, self.housing_interference_um].into_iter().any(|one| one.is_some())
    }

    /// The seat of the named class of the shaft; `None` without a class and after errors.
    fn shaft_seat(&self, bore: f64, defaults: &mut Defaults) -> Option<Seat> {
        let class = self.shaft.as_deref()?;
        let seat = Seat::shaft(class, bore);
        if self.shaft_interference_um.is_some() {
            refuse_both("shaft", defaults);
        } else if seat.is_none() {
            refuse_class(("shaft", class), &SHAFT_CLASSES, ("bore", bore), defaults);
        }
        seat
    }

    /// The seat of the named class of the housing; `None` without a class and after errors.
    fn housing_seat(&self, outside: f64, defaults: &mut Defaults) -> Option<Seat> {
        let class = self.housing.as_deref()?;
        let seat = Seat::housing(class, outside);
        if self.housing_interference_um.is_some() {
            refuse_both("housing", defaults);
        } else if seat.is_none() {
            refuse_class(("housing", class), &HOUSING_CLASSES, ("outer diameter", outside), defaults);
        }
        seat
    }

    /// Clearance that the fits on the shaft and in the housing take away [µm].
    fn clearance_loss(
        &self,
        (shaft, housing): (Option<Seat>, Option<Seat>),
        sizes: &Sizes,
        grooves: PerRaceway<f64>,
        rings: &PerRaceway<Material>,
        defaults: &mut Defaults,
    ) -> [f64; 2] {
        let mut number = |name: &str, value: Option<f64>, default: f64| {
            let Some(value) = value else { return default };
            defaults.check(&format!("{FITS}/{name}"), value);
            value
        };
        let of_seat = |seat: Option<Seat>| seat.map_or(0.0, |seat| seat.interference_um);
        let shaft_interference = number("shaft_interference_um", self.shaft_interference_um, of_seat(shaft));
        let shaft_bore = number("shaft_bore_mm", self.shaft_bore_mm, 0.0);
        let housing_interference = number("housing_interference_um", self.housing_interference_um, of_seat(housing));
        let housing_outside = number("housing_outer_diameter_mm", self.housing_outer_diameter_mm, f64::INFINITY);
        if shaft_bore >= sizes.bore {
            let detail = format!("{} mm: must be below the bore, {} mm", short(shaft_bore), short(sizes.bore));
            defaults.refuse(format!("{FITS}/shaft_bore_mm"), detail);
        }
        if housing_outside <= sizes.outside {
            let (given, outside) = (short(housing_outside), short(sizes.outside));
            let detail = format!("{given} mm: must be above the outer diameter of the bearing, {outside} mm");
            defaults.refuse(format!("{FITS}/housing_outer_diameter_mm"), detail);
        }
        if grooves.inner <= sizes.bore || grooves.outer >= sizes.outside {
            defaults.refuse(FITS, "the rings have no thickness at the bottom of the groove");
        }
        let on_shaft = InnerFit {
            interference: shaft_interference,
            shaft_bore,
            seat: sizes.bore,
            groove: grooves.inner,
            shaft: GCR15,
            ring: rings.inner,
        };
        let in_housing = OuterFit {
            interference: housing_interference,
            housing_outside,
            seat: sizes.outside,
            groove: grooves.outer,
            housing: GCR15,
            ring: rings.outer,
        };
        [on_shaft.groove_growth(), in_housing.groove_shrinkage()]
    }
}

/// Refuses a class beside an interference.
fn refuse_both(part: &str, defaults: &mut Defaults) {
    defaults
        .refuse(format!("{FITS}/{part}"), format!("give either {part} or {part}_interference_um: both set the fit"));
}

/// Refuses an unknown class, or a size that no class has.
fn refuse_class(
    (part, class): (&str, &str),
    known: &[&'static str],
    (size, value): (&str, f64),
    defaults: &mut Defaults,
) {
    let detail = if known.contains(&class) {
        format!("{class} is for sizes above 0 up to {} mm, the {size} has {} mm", short(seat::LARGEST), short(value))
    } else {
        format!("unknown class `{class}`; known are {}", listed(known.iter().copied()))
    };
    defaults.refuse(format!("{FITS}/{part}"), detail);
}

impl TemperaturesInput {
    /// Clearance that the expansion takes away, in the unit of the sizes.
    fn clearance_loss(
        &self,
        ball_diameter: f64,
        grooves: PerRaceway<f64>,
        ball: Material,
        defaults: &mut Defaults,
    ) -> f64 {
        let mut number = |name: &str, value: Option<f64>, default: f64| {
            let Some(value) = value else { return default };
            defaults.check(&format!("{TEMPERATURES}/{name}"), value);
            value
        };
        let inner = number("inner_ring_c", self.inner_ring_c, REFERENCE_TEMPERATURE);
        let outer = number("outer_ring_c", self.outer_ring_c, REFERENCE_TEMPERATURE);
        let balls = number("balls_c", self.balls_c, 0.5 * (inner + outer));
        let of_ball = if presets::material("si3n4") == Some(ball) { NITRIDE_EXPANSION } else { STEEL_EXPANSION };
        let expansion = Expansion {
            rings: PerRaceway { inner: inner - REFERENCE_TEMPERATURE, outer: outer - REFERENCE_TEMPERATURE },
            balls: balls - REFERENCE_TEMPERATURE,
            ring_expansion: number("ring_expansion_per_k", self.ring_expansion_per_k, STEEL_EXPANSION),
            ball_expansion: number("ball_expansion_per_k", self.ball_expansion_per_k, of_ball),
        };
        expansion.clearance_loss(grooves, ball_diameter)
    }
}
