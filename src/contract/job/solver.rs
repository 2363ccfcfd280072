//! Integrator, tolerances and model level of a run.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::listed;
use crate::contract::json::units::US;
use raceway_core::numerics::ode::Method;
use raceway_core::simulation::input::model_level::ModelLevel;

/// Integrator, tolerances and model level.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SolverInput {
    /// Integrator. Default `auto`: chosen for the scene; the result names the one that ran, and the reason.
    #[schema(nullable = false, value_type = Option<MethodName>)]
    pub method: Option<String>,
    /// Relative tolerance of the integrator [-]. Default 1e-5; `auto` tightens it where the integration error exceeds the level. With the
    /// method `auto`, without series and with `model_tolerance_db` above 0, the default is adaptive: fixed steps (`semi_implicit`) are tried
    /// first, then 1e-3, then 1e-5. An attempt is accepted where its stated level error is within 0.7 of `model_tolerance_db`. The result
    /// reports the accepted one in `solver.method` and `solver.relative_tolerance`; fixed steps have no tolerance.
    #[schema(nullable = false, example = 0.00001)]
    pub relative_tolerance: Option<f64>,
    /// Largest accepted error of a level by the model [dB]: by terms that a model level omits. The stated level error, model and integration
    /// together, may take half of it. 0: terms are omitted only by identities and conventions. Default 0.05.
    #[schema(nullable = false, example = 0.05)]
    pub model_tolerance_db: Option<f64>,
    /// Model level. Default: the cheapest level that contains the requested outputs and that is confirmed within `model_tolerance_db` by a
    /// comparison with the next richer level. With a named method: `full` or `planar`.
    #[schema(nullable = false, value_type = Option<RungName>)]
    pub rung: Option<String>,
    /// Fixed step size instead of error control [µs], with `dormand_prince` and `fine_abm`. With the rungs `radially_condensed` and
    /// `spindle_only`: their longest step; steps divide intervals of 9.8 µs between kept values, or join up to 2.5 of them.
    #[schema(nullable = false)]
    pub fixed_step_us: Option<f64>,
}

/// `auto`: fixed steps (`semi_implicit`) where no tolerance is given and their error is accepted; else one of the other methods by the
/// stiffness of the scene. `gear`: backward differentiation formulas of variable step and order 1–5. `fine_abm`: precise integration of
/// the linear part with exponential Adams–Bashforth–Moulton. `dormand_prince`: explicit Runge–Kutta of order 5, for scenes that are not
/// stiff. `radau`: implicit Runge–Kutta of order 5 (Radau IIA), the reference.
#[derive(ToSchema)]
#[schema(rename_all = "snake_case")]
pub enum MethodName {
    Auto,
    Gear,
    FineAbm,
    DormandPrince,
    Radau,
}

/// `full`: six degrees of freedom for each ball and the cage. `planar`: no axial motion, no tilt. `radially_condensed`: balls in radial
/// equilibrium between their raceways. `spindle_only`: balls equally spaced, vibration of the spindle only. `periodic`: the steady motion of
/// `spindle_only` that repeats with each ball passage. The last three have their own integrators, and are verified against the next richer
/// level.
#[derive(ToSchema)]
#[schema(rename_all = "snake_case")]
pub enum RungName {
    Full,
    Planar,
    RadiallyCondensed,
    SpindleOnly,
    Periodic,
}

const METHODS: [(&str, Option<Method>); 10] = [
    ("auto", Some(Method::Auto)),
    ("gear", Some(Method::Gear)),
    ("fine_abm", Some(Method::FineAbm)),
    ("dormand_prince", Some(Method::DormandPrince)),
    ("radau", Some(Method::Radau)),
    ("adams_moulton", None),
    ("runge_kutta_4", None),
    ("semi_implicit", None),
    ("shooting", None),
    ("harmonic_balance", None),
];

/// Default relative tolerances: the loose one is tried first where the method is `auto` and the outputs are metrics and spectra; the
/// tight one is the default otherwise, and where the loose one is rejected.
const LOOSE_TOLERANCE: f64 = 1e-3;
const TOLERANCE: f64 = 1e-5;

/// The solver of a run, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Solver {
    pub method: Method,
    pub rung: Option<ModelLevel>,
    pub relative_tolerance: f64,
    /// As `RunSettings::tightened`.
    pub tightened: Option<f64>,
    pub model_tolerance_db: f64,
    /// Fixed step size [s].
    pub fixed_step: Option<f64>,
}

impl SolverInput {
    pub fn resolve(&mut self, defaults: &mut Defaults) -> Solver {
        let name = defaults.fill("/solver/method", &mut self.method, "auto".to_owned());
        let method = method_of(defaults, "/solver/method", &name).unwrap_or(Method::Auto);
        let (rung, model_tolerance_db) = self.resolve_model(defaults);
        let chooses = self.relative_tolerance.is_none()
            && method == Method::Auto
            && self.fixed_step_us.is_none()
            && model_tolerance_db > 0.0;
        if !chooses {
            defaults.fill("/solver/relative_tolerance", &mut self.relative_tolerance, TOLERANCE);
        }
        let relative_tolerance = self.relative_tolerance.unwrap_or(LOOSE_TOLERANCE);
        defaults.check("/solver/relative_tolerance", relative_tolerance);
        if let Some(step) = self.fixed_step_us {
            defaults.check("/solver/fixed_step_us", step);
            let has_own_steps = matches!(rung, Some(ModelLevel::RadiallyCondensed | ModelLevel::SpindleOnly));
            if !(method.takes_fixed_steps() || has_own_steps) {
                let takers = listed(Method::NAMED.iter().filter(|m| m.takes_fixed_steps()).map(|m| m.name()));
                let detail = format!(
                    "goes with the methods {takers}, and with the rungs `radially_condensed` and `spindle_only`, not with `{name}`"
                );
                defaults.refuse("/solver/fixed_step_us", detail);
            }
        }
        if let Some(rung) = rung.filter(|rung| rung.is_reduced() && method != Method::Auto) {
            let detail = format!("`{}` has its own integrator: the method must be `auto`", rung.name());
            defaults.refuse("/solver/rung", detail);
        }
        let fixed_step = self.fixed_step_us.map(|step| US.to_si(step));
        let tightened = chooses.then_some(TOLERANCE);
        Solver { method, rung, relative_tolerance, tightened, model_tolerance_db, fixed_step }
    }

    /// Model level and `model_tolerance_db`.
    pub fn resolve_model(&mut self, defaults: &mut Defaults) -> (Option<ModelLevel>, f64) {
        let rungs = ModelLevel::ALL.map(|rung| (rung.name(), Some(rung)));
        let rung = self.rung.as_ref().and_then(|name| chosen(defaults, "/solver/rung", name, &rungs));
        let model_tolerance_db = defaults.fill("/solver/model_tolerance_db", &mut self.model_tolerance_db, 0.05);
        defaults.check("/solver/model_tolerance_db", model_tolerance_db);
        (rung, model_tolerance_db)
    }
}

/// Integrators of the reduced model levels.
const OF_MODEL_LEVELS: [(&str, ModelLevel); 3] = [
    ("adams_moulton", ModelLevel::SpindleOnly),
    ("semi_implicit", ModelLevel::RadiallyCondensed),
    ("shooting", ModelLevel::Periodic),
];

/// The method of that name; `None` after an error at `pointer`.
pub fn method_of(defaults: &mut Defaults, pointer: &str, name: &str) -> Option<Method> {
    if let Some((_, rung)) = OF_MODEL_LEVELS.iter().find(|own| own.0 == name) {
        let rung = rung.name();
        let remark = match name == Method::SemiImplicit.name() {
            true => ", and `auto` tries it first on `full` and `planar` where no tolerance is given; it",
            false => " and",
        };
        defaults.refuse(
            pointer,
            format!("`{name}` goes with the rung `{rung}`{remark} cannot be requested: omit `method`"),
        );
        return None;
    }
    chosen(defaults, pointer, name, &METHODS)
}

/// The choice of that name; `None` after an error. Names without a choice are reserved.
fn chosen<T: Copy>(defaults: &mut Defaults, pointer: &str, name: &str, choices: &[(&str, Option<T>)]) -> Option<T> {
    let available = listed(choices.iter().filter(|choice| choice.1.is_some()).map(|choice| choice.0));
    match choices.iter().find(|choice| choice.0 == name) {
        Some((_, Some(choice))) => return Some(*choice),
        Some(_) => {
            defaults.refuse(pointer, format!("`{name}` is not available in this version; available: {available}"))
        }
        None => defaults.refuse(pointer, format!("`{name}` is unknown; available: {available}")),
    }
    None
}
