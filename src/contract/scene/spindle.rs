//! The spindle.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::units::{G_MM, MM_S, UM};
use raceway_core::physics::defaults::spindle_inertia;
use raceway_core::physics::spindle::{AxialHold, Spindle, SpindleInertia, SpindleTilt, Unbalance};

/// A rigid spindle.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SpindleInput {
    /// Mass [kg]. Default: that of the bearing's preset, else of a solid steel shaft with the diameter of the bore and 7 times its length.
    #[schema(nullable = false, example = 0.05)]
    pub mass_kg: Option<f64>,
    /// Place of the mass centre along X [mm], of a spindle on several bearings. Default: the middle between the first and the last of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, maximum = 20_000, example = 150.0)]
    pub centre_mm: Option<f64>,
    /// Mass times eccentricity [g·mm]. Either this or `balance_grade`. Default 0.
    #[schema(nullable = false)]
    pub unbalance_g_mm: Option<f64>,
    /// Balance quality grade G of ISO 21940: eccentricity times operating speed [mm/s].
    #[schema(nullable = false, example = 6.3)]
    pub balance_grade: Option<f64>,
    /// Axial support. Default: `free` with a load along X, else `fixed`.
    #[schema(nullable = false)]
    pub axial: Option<AxialInput>,
    /// Tilt about Y and Z: `held`, or `free`: the bearing alone holds it. Default: `held`, at `operation.misalignment_mrad`.
    #[schema(nullable = false)]
    pub tilt: Option<TiltInput>,
    /// Moment of inertia about Y and Z, of a spindle that tilts freely [kg·m²]. Default: that of a solid steel shaft of this mass, 7 diameters long.
    #[schema(nullable = false)]
    pub transverse_inertia_kg_m2: Option<f64>,
    /// Moment of inertia about the axis, of a spindle that tilts freely [kg·m²]. Default: that of the same shaft.
    #[schema(nullable = false)]
    pub axial_inertia_kg_m2: Option<f64>,
}

/// Tilt of the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum TiltInput {
    Held,
    Free,
}

/// `fixed`, `free` (the spindle moves along X and takes the axial load), or fixed at an offset.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AxialInput {
    Fixed,
    Free,
    /// Fixed at this displacement along X [µm].
    OffsetUm(f64),
}

impl SpindleInput {
    pub fn resolve(&mut self, defaults: &mut Defaults, default_mass: f64, acts_along_x: bool) -> Spindle {
        let mass = defaults.fill("/scene/spindle/mass_kg", &mut self.mass_kg, default_mass);
        let usual = if acts_along_x { AxialInput::Free } else { AxialInput::Fixed };
        let axial = defaults.fill("/scene/spindle/axial", &mut self.axial, usual);
        Spindle {
            mass,
            unbalance: self.unbalance(defaults),
            axial: axial.in_physics(),
            tilt: self.tilt(defaults, mass),
        }
    }

    fn tilt(&mut self, defaults: &mut Defaults, mass: f64) -> SpindleTilt {
        if self.tilt != Some(TiltInput::Free) {
            let given = [
                ("transverse_inertia_kg_m2", self.transverse_inertia_kg_m2),
                ("axial_inertia_kg_m2", self.axial_inertia_kg_m2),
            ];
            for (name, _) in given.iter().filter(|(_, value)| value.is_some()) {
                defaults.refuse(
                    format!("/scene/spindle/{name}"),
                    "goes with `tilt` free, because only then does the spindle tilt",
                );
            }
            return SpindleTilt::Held;
        }
        let usual = spindle_inertia(mass);
        let mut take = |name: &str, field: &mut Option<f64>, usual: f64| {
            defaults.fill(format!("/scene/spindle/{name}"), field, usual)
        };
        SpindleTilt::Free(SpindleInertia {
            transverse: take("transverse_inertia_kg_m2", &mut self.transverse_inertia_kg_m2, usual.transverse),
            axial: take("axial_inertia_kg_m2", &mut self.axial_inertia_kg_m2, usual.axial),
        })
    }

    fn unbalance(&mut self, defaults: &mut Defaults) -> Unbalance {
        match self.balance_grade {
            Some(_) if self.unbalance_g_mm.is_some() => {
                defaults
                    .refuse("/scene/spindle/balance_grade", "give either unbalance_g_mm or balance_grade, not both");
                Unbalance::None
            }
            Some(0.0) => Unbalance::None,
            Some(grade) => Unbalance::Grade(MM_S.to_si(grade)),
            None => match defaults.fill("/scene/spindle/unbalance_g_mm", &mut self.unbalance_g_mm, 0.0) {
                0.0 => Unbalance::None,
                product => Unbalance::Product(G_MM.to_si(product)),
            },
        }
    }
}

impl AxialInput {
    fn in_physics(self) -> AxialHold {
        match self {
            Self::Fixed => AxialHold::Fixed,
            Self::Free => AxialHold::Free,
            Self::OffsetUm(offset) => AxialHold::Offset(UM.to_si(offset)),
        }
    }
}
