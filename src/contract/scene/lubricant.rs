//! Lubricant and traction.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;

use super::oil::{OilAtTemperature, OilBaseName, OrderedOil, grade};
use super::preset_names::{LubricantName, ViscosityGradeName};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::significant;
use crate::contract::json::problem::listed;
use crate::contract::json::shapes::NameOr;
use crate::contract::json::units::MM;
use raceway_core::physics::contact::traction::TractionLaw;
use raceway_core::physics::defaults::{COULOMB, EYRING, FOUR_PARAMETER};
use raceway_core::physics::lubricant::{Lubricant, LubricantKind, default_inlet_distance};
use raceway_core::physics::oil::mineral_pressure_viscosity;
use raceway_core::physics::presets;

/// A lubricant at running temperature. Empty fields are those of the preset with the name of the kind.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LubricantInput {
    /// Kind of lubricant. Default `oil` with a viscosity grade or kinematic viscosities, else `grease`, whose hydrodynamic forces are omitted
    /// by convention.
    #[schema(nullable = false)]
    pub kind: Option<LubricantKindName>,
    /// ISO viscosity grade of a mineral oil, or of the base oil of a grease; goes with `temperature_c`, instead of `viscosity_pa_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<ViscosityGradeName>)]
    pub viscosity_grade: Option<String>,
    /// Temperature of the oil in operation [°C].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 70.0)]
    pub temperature_c: Option<f64>,
    /// Kinematic viscosity at 40 °C [mm²/s]; with the one at 100 °C and `temperature_c` instead of `viscosity_grade`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 120.0)]
    pub viscosity_40_mm2_s: Option<f64>,
    /// Kinematic viscosity at 100 °C [mm²/s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 12.0)]
    pub viscosity_100_mm2_s: Option<f64>,
    /// Density of that oil at 15 °C [kg/m³]. Default 870.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub density_15_kg_m3: Option<f64>,
    /// Base of the oil. Default `mineral`, whose pressure–viscosity coefficient follows from the viscosity. `synthetic` requires
    /// `pressure_viscosity_per_pa`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub oil_base: Option<OilBaseName>,
    /// Dynamic viscosity of the oil, or of the base oil of a grease, at running temperature [Pa·s]; 0: no film.
    #[schema(nullable = false, example = 0.02)]
    pub viscosity_pa_s: Option<f64>,
    /// Pressure–viscosity coefficient [1/Pa].
    #[schema(nullable = false, example = 2e-8)]
    pub pressure_viscosity_per_pa: Option<f64>,
    /// Fraction of the free volume that is filled with lubricant [-]; it determines drag and churning.
    #[schema(nullable = false, example = 0.05)]
    pub fill: Option<f64>,
    /// Distance of the inlet meniscus from the contact [mm]. Default: a quarter of the ball diameter.
    #[schema(nullable = false)]
    pub inlet_distance_mm: Option<f64>,
    /// Traction law. Default: that of the lubricant's preset.
    #[serde(default, deserialize_with = "law_with_fields")]
    #[schema(nullable = false)]
    pub traction: Option<TractionInput>,
}

/// Refuses the name of a law without an object, and names the right place for it.
fn law_with_fields<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<TractionInput>, D::Error> {
    match NameOr::<String, TractionInput>::deserialize(deserializer)? {
        NameOr::Object(own) => Ok(Some(own)),
        NameOr::Name(name) => Err(D::Error::custom(format!(
            "\"{name}\": must be an object with the field `law`, such as {{\"law\": \"coulomb\"}}"
        ))),
    }
}

/// Name of a preset of `GET /v1/presets`, or a lubricant with its constants.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
pub enum LubricantChoice {
    /// Name of a preset.
    Name(LubricantName),
    Fields(Box<LubricantInput>),
}

/// `grease`: hydrodynamic forces are omitted by convention. `oil`: they are included. `dry`: no film.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LubricantKindName {
    Grease,
    Oil,
    Dry,
}

/// Traction coefficient as a function of slip speed: a law and its parameters.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TractionInput {
    /// Traction law. Default `four_parameter`; for a dry bearing `coulomb`.
    #[schema(nullable = false)]
    pub law: Option<TractionLawName>,
    /// `four_parameter`: coefficient at rest [-]. Default 0.
    #[schema(nullable = false)]
    pub at_rest: Option<f64>,
    /// `four_parameter`: largest coefficient [-]. Default 0.05.
    #[schema(nullable = false)]
    pub maximum: Option<f64>,
    /// `four_parameter`: slip speed at which the largest coefficient is reached [m/s]. Default 1.
    #[schema(nullable = false)]
    pub at_slip_m_s: Option<f64>,
    /// `four_parameter`: coefficient at high slip [-], default 0.036. `eyring`: largest shear stress divided by pressure [-], default 0.08.
    #[schema(nullable = false)]
    pub limit: Option<f64>,
    /// `eyring`: Eyring stress [Pa]. Default 5e6.
    #[schema(nullable = false)]
    pub stress_pa: Option<f64>,
    /// `coulomb`: coefficient [-]. Default 0.1.
    #[schema(nullable = false)]
    pub coefficient: Option<f64>,
    /// `coulomb`: slip speed over which friction builds up [m/s]. Default 0.05.
    #[schema(nullable = false)]
    pub regularisation_m_s: Option<f64>,
    /// `slide_roll`: A in (A + B s) e^(−C s) + D, a function of the slide/roll ratio s [-]. Required, as are B, C and D.
    #[schema(nullable = false)]
    pub a: Option<f64>,
    /// `slide_roll`: B [-].
    #[schema(nullable = false)]
    pub b: Option<f64>,
    /// `slide_roll`: C [-].
    #[schema(nullable = false)]
    pub c: Option<f64>,
    // Last: clients of openapi-python-client lose the fields that follow one called `d`.
    /// `slide_roll`: D [-].
    #[schema(nullable = false)]
    pub d: Option<f64>,
}

/// `four_parameter`: rises to a maximum and falls to a limit. `slide_roll`: an exponential function of the slide/roll ratio. `eyring`:
/// an Eyring shear stress with a limit. `coulomb`: a constant coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum TractionLawName {
    FourParameter,
    SlideRoll,
    Eyring,
    Coulomb,
}

/// The lubricant of `physics`; fills in defaults, and replaces a name by its constants.
pub fn resolve(
    field: &mut Option<NameOr<String, LubricantInput>>,
    defaults: &mut Defaults,
    default: &str,
    ball_diameter_mm: f64,
) -> (Lubricant, Option<OilAtTemperature>) {
    let given = field.is_some();
    let mut own = match field.take().unwrap_or_else(|| NameOr::Name(default.to_owned())) {
        NameOr::Object(own) => own,
        NameOr::Name(name) => {
            let kind = presets::lubricant(&name).map(|lubricant| lubricant.kind.into());
            if kind.is_none() {
                let known = listed(presets::LUBRICANTS.iter().map(|preset| preset.name));
                let detail = match grade(&name) {
                    Some(_) => {
                        let example = format!("{{\"viscosity_grade\": \"{name}\", \"temperature_c\": 60}}");
                        format!("a viscosity grade needs a temperature, such as {example}")
                    }
                    None => format!("unknown lubricant `{name}`; known are {known}"),
                };
                defaults.refuse("/scene/lubricant", detail);
            }
            if !given {
                defaults.filled.push("/scene/lubricant/kind".to_owned());
            }
            LubricantInput { kind, ..LubricantInput::default() }
        }
    };
    let oil = own.take_oil(defaults);
    let lubricant = own.resolve(defaults, ball_diameter_mm);
    *field = Some(NameOr::Object(own));
    (lubricant, oil)
}

impl LubricantInput {
    /// Replaces grade, viscosities and temperature by the dynamic viscosity and the pressure–viscosity coefficient.
    fn take_oil(&mut self, defaults: &mut Defaults) -> Option<OilAtTemperature> {
        let ordered = OrderedOil {
            grade: self.viscosity_grade.take(),
            temperature: self.temperature_c.take(),
            viscosity_40: self.viscosity_40_mm2_s.take(),
            viscosity_100: self.viscosity_100_mm2_s.take(),
            density_15: self.density_15_kg_m3.take(),
            base: self.oil_base.take(),
        };
        if ordered.is_given() {
            if self.kind == Some(LubricantKindName::Dry) {
                defaults.refuse("/scene/lubricant/kind", "`dry` has no oil");
            }
            if self.viscosity_pa_s.is_some() {
                let detail = "give either this, or the oil by its grade or its viscosities at 40 and 100 °C";
                defaults.refuse("/scene/lubricant/viscosity_pa_s", detail);
            }
            if ordered.base == Some(OilBaseName::Synthetic) && self.pressure_viscosity_per_pa.is_none() {
                let detail = "required, but missing: no one formula holds for synthetic oils";
                defaults.refuse("/scene/lubricant/pressure_viscosity_per_pa", detail);
            }
        }
        let oil = ordered.resolve(defaults)?;
        defaults.fill("/scene/lubricant/kind", &mut self.kind, LubricantKindName::Oil);
        let viscosity = significant(oil.oil.viscosity(oil.temperature), 6);
        let viscosity = defaults.fill("/scene/lubricant/viscosity_pa_s", &mut self.viscosity_pa_s, viscosity);
        let pressure_viscosity = significant(mineral_pressure_viscosity(viscosity), 6);
        let pointer = "/scene/lubricant/pressure_viscosity_per_pa";
        defaults.fill(pointer, &mut self.pressure_viscosity_per_pa, pressure_viscosity);
        Some(oil)
    }

    fn resolve(&mut self, defaults: &mut Defaults, ball_diameter_mm: f64) -> Lubricant {
        let kind = defaults.fill("/scene/lubricant/kind", &mut self.kind, LubricantKindName::Grease);
        let base = &presets::lubricant_of(kind.in_physics()).lubricant;
        let viscosity = defaults.fill("/scene/lubricant/viscosity_pa_s", &mut self.viscosity_pa_s, base.viscosity);
        let pressure_viscosity = defaults.fill(
            "/scene/lubricant/pressure_viscosity_per_pa",
            &mut self.pressure_viscosity_per_pa,
            base.pressure_viscosity,
        );
        let fill = defaults.fill("/scene/lubricant/fill", &mut self.fill, base.fill);
        let inlet = default_inlet_distance(ball_diameter_mm);
        let inlet = defaults.fill("/scene/lubricant/inlet_distance_mm", &mut self.inlet_distance_mm, inlet);
        Lubricant {
            kind: kind.in_physics(),
            viscosity,
            pressure_viscosity,
            fill,
            inlet_distance: Some(MM.to_si(inlet)),
            traction: self.traction.get_or_insert_default().resolve(defaults, base.traction.into()),
        }
    }
}

impl From<LubricantKind> for LubricantKindName {
    fn from(kind: LubricantKind) -> Self {
        match kind {
            LubricantKind::Grease => Self::Grease,
            LubricantKind::Oil => Self::Oil,
            LubricantKind::Dry => Self::Dry,
        }
    }
}

impl LubricantKindName {
    fn in_physics(self) -> LubricantKind {
        match self {
            Self::Grease => LubricantKind::Grease,
            Self::Oil => LubricantKind::Oil,
            Self::Dry => LubricantKind::Dry,
        }
    }
}

impl From<TractionLaw> for TractionLawName {
    fn from(law: TractionLaw) -> Self {
        match law {
            TractionLaw::FourParameter { .. } => Self::FourParameter,
            TractionLaw::SlideRoll { .. } => Self::SlideRoll,
            TractionLaw::Eyring { .. } => Self::Eyring,
            TractionLaw::Coulomb { .. } => Self::Coulomb,
        }
    }
}

impl TractionLawName {
    /// The law with its default coefficients; `slide_roll` has none.
    fn with_defaults(self) -> TractionLaw {
        match self {
            Self::FourParameter => FOUR_PARAMETER,
            Self::SlideRoll => TractionLaw::SlideRoll { a: 0.0, b: 0.0, c: 0.0, d: 0.0 },
            Self::Eyring => EYRING,
            Self::Coulomb => COULOMB,
        }
    }
}

impl TractionInput {
    /// The traction law; fills in its defaults. `slide_roll` has none, because no fit for a real oil is published.
    pub fn resolve(&mut self, defaults: &mut Defaults, default: TractionLawName) -> TractionLaw {
        const AT: &str = "/scene/lubricant/traction";
        let law_is_given = self.law.is_some();
        let law = defaults.fill(format!("{AT}/law"), &mut self.law, default);
        let four = law == TractionLawName::FourParameter;
        let slide_roll = law == TractionLawName::SlideRoll;
        let eyring = law == TractionLawName::Eyring;
        let coulomb = law == TractionLawName::Coulomb;
        let name = match law {
            TractionLawName::FourParameter => "four_parameter",
            TractionLawName::SlideRoll => "slide_roll",
            TractionLawName::Eyring => "eyring",
            TractionLawName::Coulomb => "coulomb",
        };
        // Without its own law it follows the kind, which may be unknown.
        if law_is_given || !defaults.is_unread("/scene/lubricant/kind") {
            let used = [
                ("at_rest", self.at_rest.is_some(), four),
                ("maximum", self.maximum.is_some(), four),
                ("at_slip_m_s", self.at_slip_m_s.is_some(), four),
                ("limit", self.limit.is_some(), four || eyring),
                ("a", self.a.is_some(), slide_roll),
                ("b", self.b.is_some(), slide_roll),
                ("c", self.c.is_some(), slide_roll),
                ("d", self.d.is_some(), slide_roll),
                ("stress_pa", self.stress_pa.is_some(), eyring),
                ("coefficient", self.coefficient.is_some(), coulomb),
                ("regularisation_m_s", self.regularisation_m_s.is_some(), coulomb),
            ];
            defaults.only_used(AT, name, &used);
        }
        let mut take =
            |field: &str, value: &mut Option<f64>, default| defaults.fill(format!("{AT}/{field}"), value, default);
        match law.with_defaults() {
            TractionLaw::FourParameter { at_rest, maximum, at_slip, limit } => TractionLaw::FourParameter {
                at_rest: take("at_rest", &mut self.at_rest, at_rest),
                maximum: take("maximum", &mut self.maximum, maximum),
                at_slip: take("at_slip_m_s", &mut self.at_slip_m_s, at_slip),
                limit: take("limit", &mut self.limit, limit),
            },
            TractionLaw::Eyring { stress, limit } => TractionLaw::Eyring {
                stress: take("stress_pa", &mut self.stress_pa, stress),
                limit: take("limit", &mut self.limit, limit),
            },
            TractionLaw::Coulomb { coefficient, regularisation } => TractionLaw::Coulomb {
                coefficient: take("coefficient", &mut self.coefficient, coefficient),
                regularisation: take("regularisation_m_s", &mut self.regularisation_m_s, regularisation),
            },
            TractionLaw::SlideRoll { a, b, c, d } => TractionLaw::SlideRoll {
                a: defaults.require(format!("{AT}/a"), &self.a, a),
                b: defaults.require(format!("{AT}/b"), &self.b, b),
                c: defaults.require(format!("{AT}/c"), &self.c, c),
                d: defaults.require(format!("{AT}/d"), &self.d, d),
            },
        }
    }
}
