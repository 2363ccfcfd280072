//! How to simulate.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::listed;
use crate::contract::json::units::US;
use raceway_core::numerics::ode::Method;
use raceway_core::simulation::input::model_level::ModelLevel;

/// Integrator, tolerances and model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SolverInput {
    /// Default `auto`: the run chooses, and the result names what ran and why.
    #[schema(nullable = false, value_type = Option<MethodName>)]
    pub method: Option<String>,
    /// Relative tolerance of the integrator [-]; `auto` tightens it where it leaves more noise than level. Left out, it is
    /// 1e-5; with the method `auto` and no series asked for, steps of a fixed length (`semi_implicit`) are tried first, then 1e-3,
    /// each taken where the error that the result then states is within half of `model_tolerance_db`, else 1e-5.
    /// `solver.method` of the result tells which, and `solver.relative_tolerance`, which steps do not have. With `model_tolerance_db` 0
    /// no steps are tried.
    #[schema(nullable = false, example = 0.00001)]
    pub relative_tolerance: Option<f64>,
    /// How much a level may change by what is left out by judgement [dB]; 0: identities and
    /// conventions only. Default 0.05.
    #[schema(nullable = false, example = 0.05)]
    pub model_tolerance_db: Option<f64>,
    /// A rung of the ladder of models. Left out, it is the leanest one that can give the outputs and that a check against the
    /// next richer one confirms within `model_tolerance_db`; a method asked for by name, or a fixed step, runs on `full` or `planar`.
    #[schema(nullable = false, value_type = Option<RungName>)]
    pub rung: Option<String>,
    /// Steps of this size instead of error control [µs]; only with `dormand_prince` and `fine_abm`.
    #[schema(nullable = false)]
    pub fixed_step_us: Option<f64>,
}

/// `auto`: steps of a fixed length (`semi_implicit`) where no tolerance is asked for and they serve; else chooses between the others by
/// the stiffness of the scene, and says why. `gear`: backward differentiation
/// of variable step and order 1–5. `fine_abm`: precise integration of the linear part with exponential
/// Adams–Bashforth–Moulton. `dormand_prince`: explicit Runge–Kutta of order 5, for scenes that are not stiff. `radau`:
/// implicit Runge–Kutta of order 5 (Radau IIA), the reference.
#[derive(ToSchema)]
#[schema(rename_all = "snake_case")]
pub enum MethodName {
    Auto,
    Gear,
    FineAbm,
    DormandPrince,
    Radau,
}

/// `full`: six degrees of freedom a ball and cage. `planar`: no axial motion, no tilt. `radially_condensed`: balls in radial
/// equilibrium between their raceways. `spindle_only`: balls equally spaced, vibration of the spindle only. `periodic`:
/// the same, its steady motion that repeats with every ball. The last three have integrators of their own, and are checked
/// against the next richer one.
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

/// Relative tolerance where none is given: the first where a run may choose and nothing but levels, loads and speeds is asked
/// for, the second where that does not do.
const LOOSE_TOLERANCE: f64 = 1e-3;
const TOLERANCE: f64 = 1e-5;

/// The solver of a run, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Solver {
    pub method: Method,
    pub rung: Option<ModelLevel>,
    pub relative_tolerance: f64,
    /// See `RunSettings::tightened`.
    pub tightened: Option<f64>,
    pub model_tolerance_db: f64,
    /// [s]
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
            if !method.takes_fixed_steps() {
                let takers = listed(Method::NAMED.iter().filter(|m| m.takes_fixed_steps()).map(|m| m.name()));
                defaults.refuse("/solver/fixed_step_us", format!("goes with the methods {takers}, not with `{name}`"));
            }
        }
        if let Some(rung) = rung.filter(|rung| rung.is_reduced())
            && (method != Method::Auto || self.fixed_step_us.is_some())
        {
            let detail = format!(
                "`{}` has an integrator of its own: the method must be `auto`, without a fixed step",
                rung.name()
            );
            defaults.refuse("/solver/rung", detail);
        }
        let fixed_step = self.fixed_step_us.map(|step| US.to_si(step));
        let tightened = chooses.then_some(TOLERANCE);
        Solver { method, rung, relative_tolerance, tightened, model_tolerance_db, fixed_step }
    }

    /// What decides over the model alone: rung and `model_tolerance_db`.
    pub fn resolve_model(&mut self, defaults: &mut Defaults) -> (Option<ModelLevel>, f64) {
        let rungs = ModelLevel::ALL.map(|rung| (rung.name(), Some(rung)));
        let rung = self.rung.as_ref().and_then(|name| chosen(defaults, "/solver/rung", name, &rungs));
        let model_tolerance_db = defaults.fill("/solver/model_tolerance_db", &mut self.model_tolerance_db, 0.05);
        defaults.check("/solver/model_tolerance_db", model_tolerance_db);
        (rung, model_tolerance_db)
    }
}

/// Integrators that go with their rung.
const OF_RUNGS: [(&str, ModelLevel); 3] = [
    ("adams_moulton", ModelLevel::SpindleOnly),
    ("semi_implicit", ModelLevel::RadiallyCondensed),
    ("shooting", ModelLevel::Periodic),
];

/// The method of that name; `None` with an error at `pointer` where there is none.
pub fn method_of(defaults: &mut Defaults, pointer: &str, name: &str) -> Option<Method> {
    if let Some((_, rung)) = OF_RUNGS.iter().find(|own| own.0 == name) {
        let rung = rung.name();
        let alike = match name == Method::SemiImplicit.name() {
            true => ", and is what `auto` tries first on `full` and `planar` where no tolerance is asked for; it",
            false => " and",
        };
        defaults.refuse(pointer, format!("`{name}` goes with the rung `{rung}`{alike} cannot be chosen: leave it out"));
        return None;
    }
    chosen(defaults, pointer, name, &METHODS)
}

/// The choice of that name; known names without one are not available yet.
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
