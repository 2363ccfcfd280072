//! Fuzz target for jobs: parses the bytes as a job, resolves an accepted job, builds its model and takes ten steps.
#![no_main]

mod mutation;

use std::time::Instant;

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use raceway::contract::{self, Job, JobKind, Refusal, RunFailure, parse_job};
use raceway::jobs::NewJob;
use raceway::simulation::input::control::Control;
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use serde_json::{Value, json};

fuzz_target!(|body: &[u8]| {
    match parse_job(body) {
        Ok(job) => {
            accepted(&job);
            ten_steps(&job);
            if one_in(64, body) {
                run(&job);
            }
        }
        Err(refusal) => refused(&refusal),
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    mutation::mutate(data, size, max_size, seed)
});

/// Whether these bytes are selected for a slow check. The selection depends on the bytes alone.
fn one_in(turns: u64, body: &[u8]) -> bool {
    let hash = body
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3));
    (hash >> 20).is_multiple_of(turns)
}

/// An error response names each invalid field and the reason.
fn refused(refusal: &Refusal) {
    assert!(!refusal.to_string().is_empty());
    match refusal {
        Refusal::NotJson { detail } => assert!(!detail.is_empty()),
        Refusal::Invalid { errors } => {
            assert!(!errors.is_empty(), "refused for nothing");
            for error in errors {
                assert!(!error.detail.is_empty(), "{error:?}");
                assert!(error.pointer.is_empty() || error.pointer.starts_with('/'), "{error:?}");
                // Between backquotes stands what the request has.
                assert!(error.detail.split('`').step_by(2).all(|own| !own.contains("NaN")), "{error:?}");
            }
        }
    }
}

/// The answers of the service before a job runs: priority, hash, resolved scene, cost.
fn accepted(job: &Job) {
    let row = NewJob::new(job, "", None);
    assert!((1..=4).contains(&row.priority) && row.content_hash.len() == 32);
    let Some(answer) = contract::resolve_answer(job) else { return };
    let json = serde_json::to_value(&answer).expect("an answer is JSON");
    // JSON has no infinity. serde_json writes null in its place, and no answer contains null otherwise.
    assert_eq!(null_in(&json, String::new()), None, "{json}");
    assert_eq!(contract::estimate(job).estimated_wall_time_s, answer.cost.estimated_wall_time_s);
    again(job);
    match job {
        Job::Study(study) => {
            for point in [0, study.points / 2, study.points - 1] {
                if let Err(refusal) = study.point(point) {
                    refused(&refusal);
                }
            }
        }
        Job::Uncertainty(uncertainty) => {
            let study = &uncertainty.study;
            for point in [0, study.points / 2, study.points - 1] {
                if let Err(refusal) = study.point(point) {
                    refused(&refusal);
                }
            }
        }
        Job::Optimum(search) => assert!(search.most_runs() > 0),
        // Rotors and machines have no scene to resolve, and were left above.
        Job::Simulation(_) | Job::Accuracy(_) | Job::Modes(_) | Job::Rotor(_) | Job::Machine(_) => {}
    }
}

/// A resolved job, posted again, is the same job.
fn again(job: &Job) {
    let mut complete = job.complete();
    if !matches!(job, Job::Simulation(_) | Job::Accuracy(_)) {
        complete["kind"] = json!(JobKind::Simulation.name());
    }
    let second = parse_job(complete.to_string().as_bytes());
    let second = second.unwrap_or_else(|refusal| panic!("{refusal}: {complete}"));
    assert_eq!(second.scene(), job.scene());
    assert_eq!(second.scene_json(), job.scene_json());
    if matches!(job, Job::Simulation(_) | Job::Accuracy(_)) {
        assert_eq!(second.canonical(), job.canonical());
        let of = |job: &Job| job.base().map(|base| (base.settings.clone(), base.model_levels.clone(), base.terms.clone()));
        assert_eq!(of(&second), of(job));
    }
}

fn null_in(value: &Value, way: String) -> Option<String> {
    match value {
        Value::Null => Some(way),
        Value::Array(items) => {
            items.iter().enumerate().find_map(|(place, item)| null_in(item, format!("{way}/{place}")))
        }
        Value::Object(fields) => fields.iter().find_map(|(name, field)| null_in(field, format!("{way}/{name}"))),
        _ => None,
    }
}

fn ten_steps(job: &Job) {
    let Some(base) = job.base() else { return };
    let model = Model::new(base.scene(), &base.terms);
    let start = match start_state(&model) {
        Ok(start) => start,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    assert!(start.iter().all(|entry| entry.is_finite()), "the start");
    let settings = &base.settings;
    let method = match job {
        Job::Accuracy(comparison) => comparison.plan.methods.first().copied().unwrap_or(settings.method),
        _ => settings.method,
    };
    let tolerances = model.mechanism().layout.tolerances(settings.relative_tolerance);
    let mut integrator = method.start(&model, 0.0, &start, tolerances, settings.fixed_step);
    let end = settings.settle + settings.duration;
    let mut between = start.clone();
    for _ in 0..10 {
        if integrator.time() >= end {
            break;
        }
        // A run may fail, but with a reason.
        if let Err(error) = integrator.step(end) {
            return assert!(!error.to_string().is_empty());
        }
        let (from, to) = (integrator.previous_time(), integrator.time());
        assert!(from < to && to <= end, "a step from {from} to {to} of {end}");
        assert!(integrator.state().iter().all(|entry| entry.is_finite()), "the state at {to}");
        integrator.interpolate(from + 0.5 * (to - from), &mut between);
    }
}

/// The first 5 ms of wall time of a whole run, as a worker executes it, reduced models included.
fn run(job: &Job) {
    if matches!(job, Job::Study(_) | Job::Uncertainty(_)) {
        return;
    }
    let begin = Instant::now();
    let stop = || begin.elapsed().as_millis() > 5;
    match contract::execute(job, &Control::until(&stop)) {
        Ok(outcome) => drop(outcome),
        Err(RunFailure::Cancelled) => {}
        Err(RunFailure::Failed { cause, detail }) => {
            assert!(!detail.is_empty() && cause != contract::answer::failure::INTERNAL, "{cause}: {detail}");
        }
    }
}
