//! The lubricant at running temperature.

use super::contact::traction::TractionLaw;
use super::limits::Faults;

/// Kind of lubrication. For grease the hydrodynamic forces are left out by convention.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LubricantKind {
    Grease,
    Oil,
    Dry,
}

/// A lubricant at running temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lubricant {
    pub kind: LubricantKind,
    /// Dynamic viscosity η of the (base) oil [Pa s]; 0 means no film at all.
    pub viscosity: f64,
    /// Pressure–viscosity coefficient α_p [1/Pa].
    pub pressure_viscosity: f64,
    /// Share `X` of the bearing's free volume that is filled with lubricant [-].
    pub fill: f64,
    /// Distance of the inlet meniscus from the contact [m]; `None`: a quarter of the ball diameter.
    pub inlet_distance: Option<f64>,
    pub traction: TractionLaw,
}

/// Density of lubricants [kg/m³] and of air [kg/m³], viscosity of air [Pa s].
const OIL_DENSITY: f64 = 900.0;
const AIR_DENSITY: f64 = 1.2;
const AIR_VISCOSITY: f64 = 1.8e-5;

/// Distance of the inlet meniscus from the contact, in the unit of the ball's diameter.
pub fn default_inlet_distance(ball_diameter: f64) -> f64 {
    0.25 * ball_diameter
}

impl Lubricant {
    /// Records values outside the limits.
    pub(crate) fn check(&self, faults: &mut Faults) {
        faults.check("lubricant.viscosity", self.viscosity);
        faults.check("lubricant.pressure_viscosity", self.pressure_viscosity);
        faults.check("lubricant.fill", self.fill);
        if let Some(distance) = self.inlet_distance {
            faults.check("lubricant.inlet_distance", distance);
        }
        self.traction.check(faults);
    }

    /// Distance of the inlet meniscus from a contact of balls of that diameter [m].
    pub fn meniscus(&self, ball_diameter: f64) -> f64 {
        self.inlet_distance.unwrap_or_else(|| default_inlet_distance(ball_diameter))
    }

    /// Kinematic viscosity of the (base) oil at a usual density of 900 kg/m³ [mm²/s]; `None` without oil.
    pub fn kinematic_viscosity(&self) -> Option<f64> {
        (self.kind != LubricantKind::Dry && self.viscosity > 0.0).then(|| 1e6 * self.viscosity / OIL_DENSITY)
    }

    /// Density of the lubricant–air mixture, ρ_e = X ρ_l + (1 − X) ρ_a [kg/m³].
    pub(crate) fn mixture_density(&self) -> f64 {
        self.fill * OIL_DENSITY + (1.0 - self.fill) * AIR_DENSITY
    }

    /// Viscosity of the lubricant–air mixture, η_e = X η + (1 − X) η_a [Pa s].
    pub(crate) fn mixture_viscosity(&self) -> f64 {
        self.fill * self.viscosity + (1.0 - self.fill) * AIR_VISCOSITY
    }
}
