//! What an accuracy job asks for: methods and tolerances to compare, in the place of one of each.

use super::filling::Filling;
use super::job::{JobInput, JobKind};
use super::outputs::OutputsInput;
use super::solver::{SolverInput, method_of};
use crate::numerics::ode::Method;
use crate::simulation::work_precision::Plan;

/// Default time before anything is compared, and default time that is compared [s]: each is run many times.
pub const SETTLE: f64 = 0.02;
pub const DURATION: f64 = 0.02;
/// Default tolerances: five over four decades.
const RELATIVE_TOLERANCES: [f64; 5] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7];
const MOST_TOLERANCES: usize = 12;
/// Each method once.
const MOST_METHODS: usize = Method::NAMED.len() + 1;
pub const MOST_REPETITIONS: u32 = 9;

/// The plan of an accuracy job; fields that such a job does not take are refused.
pub fn plan(input: &mut JobInput, filling: &mut Filling) -> Plan {
    refuse_foreign(input, filling);
    let every = || Method::NAMED.iter().chain([&Method::Auto]).map(|method| method.name().to_owned()).collect();
    let names: Vec<String> = filling.take("/methods", &mut input.methods, every());
    let methods = methods(&names, filling);
    let relative_tolerances =
        filling.take("/relative_tolerances", &mut input.relative_tolerances, RELATIVE_TOLERANCES.to_vec());
    check_tolerances(&relative_tolerances, filling);
    let repetitions = filling.take("/repetitions", &mut input.repetitions, 1);
    filling.check("/repetitions", f64::from(repetitions));
    Plan { methods, relative_tolerances, repetitions: repetitions.clamp(1, MOST_REPETITIONS) }
}

fn methods(names: &[String], filling: &mut Filling) -> Vec<Method> {
    if names.is_empty() || names.len() > MOST_METHODS {
        filling.refuse("/methods", format!("{} methods: must be from 1 to {MOST_METHODS}", names.len()));
        return Vec::new();
    }
    let mut methods = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let pointer = format!("/methods/{index}");
        if names[..index].contains(name) {
            filling.refuse(pointer, "given more than once");
        } else if let Some(method) = method_of(filling, &pointer, name) {
            methods.push(method);
        }
    }
    methods
}

fn check_tolerances(tolerances: &[f64], filling: &mut Filling) {
    if tolerances.is_empty() || tolerances.len() > MOST_TOLERANCES {
        let detail = format!("{} tolerances: must be from 1 to {MOST_TOLERANCES}", tolerances.len());
        filling.refuse("/relative_tolerances", detail);
        return;
    }
    for (index, tolerance) in tolerances.iter().enumerate() {
        let pointer = format!("/relative_tolerances/{index}");
        if tolerances[..index].contains(tolerance) {
            filling.refuse(pointer, "given more than once");
        } else {
            filling.check(&pointer, *tolerance);
        }
    }
}

/// Refuses fields that belong to a simulation.
fn refuse_foreign(input: &JobInput, filling: &mut Filling) {
    let SolverInput { method, relative_tolerance, fixed_step_us, .. } = input.solver.clone().unwrap_or_default();
    let OutputsInput { spectra, series, .. } = input.outputs.clone().unwrap_or_default();
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
        ("/reuse", input.reuse == Some(true), "a job of kind `accuracy` measures time: no other answers it"),
    ];
    for (pointer, _, detail) in fields.into_iter().filter(|field| field.1) {
        filling.refuse(pointer, detail);
    }
}

/// Refuses, in a job of another kind, fields that belong to an accuracy job.
pub fn refuse_in(kind: JobKind, input: &JobInput, filling: &mut Filling) {
    let fields = [
        ("/methods", input.methods.is_some()),
        ("/relative_tolerances", input.relative_tolerances.is_some()),
        ("/repetitions", input.repetitions.is_some()),
    ];
    for (pointer, _) in fields.into_iter().filter(|field| field.1) {
        filling.refuse(pointer, format!("goes with the kind `accuracy`, not with `{}`", kind.name()));
    }
}
