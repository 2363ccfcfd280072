//! An accuracy job: several methods and tolerances for one scene, instead of one of each.

use raceway_core::numerics::ode::Method;
use raceway_core::simulation::input::settings::RunSettings;
use raceway_core::simulation::solve::eligibility::active_terms;
use raceway_core::simulation::work_precision::{Plan, SETTLING};
use serde_json::Value;

use super::input::JobInput;
use super::kind::JobKind;
use super::outputs::OutputsInput;
use super::simulation::{Draft, Simulation};
use super::solver::{SolverInput, method_of};
use super::times;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::limits::MAX_REPETITIONS;
use crate::contract::json::problem::Refusal;
use crate::contract::json::uploads::Uploads;

/// Default settling time and default compared time [s]: each is run many times.
const SETTLE: f64 = 0.02;
const DURATION: f64 = 0.02;
/// Default tolerances: five over four decades.
const RELATIVE_TOLERANCES: [f64; 5] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7];
const MAX_TOLERANCES: usize = 12;
/// Each method once.
const MAX_METHODS: usize = Method::NAMED.len() + 1;

/// A checked accuracy job.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Scene, times and model of all runs.
    pub base: Simulation,
    pub plan: Plan,
}

impl Comparison {
    /// The comparison of a request of this kind.
    pub fn of(request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let mut draft = Draft::of(JobKind::Accuracy, request, uploads)?;
        let plan = plan(&mut draft.input, &mut draft.defaults);
        let settings = settings(&mut draft.input, &mut draft.defaults);
        let only_level = |scene: &_, settings: &RunSettings| {
            let needs = active_terms(scene, &settings.outputs, settings.rung)?;
            Ok(vec![needs.rung])
        };
        Ok(Self { base: draft.simulation(settings, only_level)?, plan })
    }

    /// The job with all defaults, without the fields that concern only the service.
    pub fn complete(&self) -> Value {
        let mut job = self.base.complete();
        job["kind"] = JobKind::Accuracy.name().into();
        job["methods"] = self.plan.methods.iter().map(|method| method.name()).collect();
        job["relative_tolerances"] = self.plan.relative_tolerances.clone().into();
        job["repetitions"] = self.plan.repetitions.into();
        job
    }
}

fn plan(input: &mut JobInput, defaults: &mut Defaults) -> Plan {
    refuse_fields_of_simulations(input, defaults);
    let every = || Method::NAMED.iter().chain([&Method::Auto]).map(|method| method.name().to_owned()).collect();
    let names: Vec<String> = defaults.fill("/methods", &mut input.methods, every());
    let methods = methods(&names, defaults);
    let relative_tolerances =
        defaults.fill("/relative_tolerances", &mut input.relative_tolerances, RELATIVE_TOLERANCES.to_vec());
    check_tolerances(&relative_tolerances, defaults);
    let repetitions = defaults.fill("/repetitions", &mut input.repetitions, 1);
    defaults.check("/repetitions", f64::from(repetitions));
    Plan { methods, relative_tolerances, repetitions: repetitions.clamp(1, MAX_REPETITIONS) }
}

/// Settings that all runs share.
fn settings(input: &mut JobInput, defaults: &mut Defaults) -> RunSettings {
    let (rung, model_tolerance_db) = input.solver.get_or_insert_default().resolve_model(defaults);
    if let Some(rung) = rung.filter(|rung| rung.is_reduced()) {
        defaults
            .refuse("/solver/rung", format!("methods are compared on `full` or `planar`, not on `{}`", rung.name()));
    }
    let outputs = input.outputs.get_or_insert_default().resolve_metrics(defaults);
    let settle = times::settle(&mut input.settle_s, SETTLE, defaults);
    let duration = times::duration(&mut input.duration_s, DURATION, &outputs, defaults);
    let (method, relative_tolerance) = SETTLING;
    RunSettings {
        method,
        rung,
        relative_tolerance,
        tightened: None,
        model_tolerance_db,
        fixed_step: None,
        settle,
        duration,
        outputs,
    }
}

fn methods(names: &[String], defaults: &mut Defaults) -> Vec<Method> {
    if names.is_empty() || names.len() > MAX_METHODS {
        defaults.refuse("/methods", format!("{} methods: must be from 1 to {MAX_METHODS}", names.len()));
        return Vec::new();
    }
    let mut methods = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let pointer = format!("/methods/{index}");
        if names[..index].contains(name) {
            defaults.refuse(pointer, "given more than once");
        } else if let Some(method) = method_of(defaults, &pointer, name) {
            methods.push(method);
        }
    }
    methods
}

fn check_tolerances(tolerances: &[f64], defaults: &mut Defaults) {
    if tolerances.is_empty() || tolerances.len() > MAX_TOLERANCES {
        let detail = format!("{} tolerances: must be from 1 to {MAX_TOLERANCES}", tolerances.len());
        defaults.refuse("/relative_tolerances", detail);
        return;
    }
    for (index, tolerance) in tolerances.iter().enumerate() {
        let pointer = format!("/relative_tolerances/{index}");
        if tolerances[..index].contains(tolerance) {
            defaults.refuse(pointer, "given more than once");
        } else {
            defaults.check(&pointer, *tolerance);
        }
    }
}

/// Refuses fields that belong to a simulation.
fn refuse_fields_of_simulations(input: &JobInput, defaults: &mut Defaults) {
    let SolverInput { method, relative_tolerance, fixed_step_us, .. } = input.solver.clone().unwrap_or_default();
    let OutputsInput { spectra, series, envelope_band_hz, envelope, bands_hz, orders, .. } =
        input.outputs.clone().unwrap_or_default();
    let signals = "a job of kind `accuracy` keeps no signals";
    let fields = [
        ("/solver/method", method.is_some(), "a job of kind `accuracy` takes /methods"),
        (
            "/solver/relative_tolerance",
            relative_tolerance.is_some(),
            "a job of kind `accuracy` takes /relative_tolerances",
        ),
        ("/solver/fixed_step_us", fixed_step_us.is_some(), "a job of kind `accuracy` compares runs with error control"),
        ("/outputs/spectra", spectra.is_some(), signals),
        ("/outputs/series", series.is_some(), signals),
        ("/outputs/orders", orders.is_some(), signals),
        ("/outputs/envelope_band_hz", envelope_band_hz.is_some(), signals),
        ("/outputs/envelope", envelope.is_some(), signals),
        ("/outputs/bands_hz", bands_hz.is_some(), signals),
        ("/reuse", input.reuse == Some(true), "a job of kind `accuracy` measures run time: its result is never reused"),
    ];
    for (pointer, _, detail) in fields.into_iter().filter(|field| field.1) {
        defaults.refuse(pointer, detail);
    }
}
