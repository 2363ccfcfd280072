//! Oils as they are ordered: by viscosity grade or by two kinematic viscosities, at a temperature.

use raceway_core::physics::oil::{Grade, Oil, Walther, grades};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::short;
use crate::contract::json::problem::listed;

/// Base of an oil.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OilBaseName {
    Mineral,
    Synthetic,
}

/// An oil at running temperature.
#[derive(Debug, Clone, PartialEq)]
pub struct OilAtTemperature {
    /// Name of its grade; `None` for an oil by its viscosities.
    pub grade: Option<&'static str>,
    pub oil: Oil,
    pub law: Walther,
    /// [°C]
    pub temperature: f64,
    /// Kinematic viscosity [mm²/s].
    pub kinematic_viscosity: f64,
    /// Density [kg/m³].
    pub density: f64,
}

/// Density of mineral oils at 15 °C, a usual value [kg/m³].
const USUAL_DENSITY: f64 = 870.0;

const AT: &str = "/scene/lubricant";

/// The grade of that name.
pub fn grade(name: &str) -> Option<&'static Grade> {
    grades().iter().find(|grade| grade.name == name)
}

/// An oil as the request names it.
#[derive(Debug, Clone, Default)]
pub struct OrderedOil {
    pub grade: Option<String>,
    pub temperature: Option<f64>,
    pub viscosity_40: Option<f64>,
    pub viscosity_100: Option<f64>,
    pub density_15: Option<f64>,
    pub base: Option<OilBaseName>,
}

impl OrderedOil {
    /// True if the request names an oil at all.
    pub fn is_given(&self) -> bool {
        self.grade.is_some() || self.viscosity_40.is_some() || self.viscosity_100.is_some()
    }

    /// The oil at its temperature; `None` where the request names none, and after errors.
    pub fn resolve(self, defaults: &mut Defaults) -> Option<OilAtTemperature> {
        let known_errors = defaults.errors.len();
        if !self.is_given() {
            self.refuse_without_oil(defaults);
            return None;
        }
        let oil = self.oil(defaults);
        let temperature = defaults.require(format!("{AT}/temperature_c"), &self.temperature, f64::NAN);
        if !temperature.is_nan() {
            check(defaults, "temperature_c", temperature);
        }
        if let Some(density) = self.density_15 {
            check(defaults, "density_15_kg_m3", density);
        }
        let (grade, oil) = oil.filter(|_| defaults.errors.len() == known_errors)?;
        let oil = Oil { density_15: self.density_15.unwrap_or(oil.density_15), ..oil };
        if !oil.kinematic_viscosity(temperature).is_finite() {
            let detail = format!("{} °C: the oil has no finite viscosity there", short(temperature));
            defaults.refuse(format!("{AT}/temperature_c"), detail);
            return None;
        }
        Some(OilAtTemperature {
            grade,
            oil,
            law: oil.walther(),
            temperature,
            kinematic_viscosity: oil.kinematic_viscosity(temperature),
            density: oil.density(temperature),
        })
    }

    /// Refuses what goes with an oil only.
    fn refuse_without_oil(&self, defaults: &mut Defaults) {
        let given = [
            ("temperature_c", self.temperature.is_some()),
            ("density_15_kg_m3", self.density_15.is_some()),
            ("oil_base", self.base.is_some()),
        ];
        for (name, _) in given.iter().filter(|(_, given)| *given) {
            defaults
                .refuse(format!("{AT}/{name}"), "goes with `viscosity_grade`, or with viscosities at 40 and 100 °C");
        }
    }

    /// The oil and the name of its grade; `None` after errors.
    fn oil(&self, defaults: &mut Defaults) -> Option<(Option<&'static str>, Oil)> {
        let missing = match (&self.grade, self.viscosity_40, self.viscosity_100) {
            (Some(name), None, None) => {
                let known = grade(name);
                if known.is_none() {
                    let names = listed(grades().iter().map(|grade| grade.name));
                    let detail = format!("unknown grade `{name}`; known are {names}");
                    defaults.refuse(format!("{AT}/viscosity_grade"), detail);
                }
                return known.map(|grade| (Some(grade.name), grade.oil));
            }
            (Some(_), _, _) => {
                let detail = "give either a grade, or viscosities at 40 and 100 °C";
                defaults.refuse(format!("{AT}/viscosity_grade"), detail);
                return None;
            }
            (None, Some(viscosity_40), Some(viscosity_100)) => {
                check(defaults, "viscosity_40_mm2_s", viscosity_40);
                check(defaults, "viscosity_100_mm2_s", viscosity_100);
                if viscosity_100 >= viscosity_40 {
                    let (cold, hot) = (short(viscosity_40), short(viscosity_100));
                    let detail = format!("{hot} mm²/s: must be below the viscosity at 40 °C, {cold} mm²/s");
                    defaults.refuse(format!("{AT}/viscosity_100_mm2_s"), detail);
                }
                return Some((None, Oil { viscosity_40, viscosity_100, density_15: USUAL_DENSITY }));
            }
            (None, Some(_), None) => "viscosity_100_mm2_s",
            (None, None, _) => "viscosity_40_mm2_s",
        };
        defaults.refuse(format!("{AT}/{missing}"), "required, but missing");
        None
    }
}

fn check(defaults: &mut Defaults, name: &str, value: f64) {
    defaults.check(&format!("{AT}/{name}"), value);
}
