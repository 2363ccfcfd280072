//! Requests as bytes to checked jobs.

use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Value, json};

use super::checked::Job;
use super::kind::JobKind;
use crate::contract::json::problem::{FieldError, Refusal};
use crate::contract::json::shapes::ObjectOnly;
use crate::contract::json::strict;
use crate::contract::json::uploads::Uploads;

/// Largest number of jobs in a batch.
const MAX_JOBS: usize = 1000;

/// Reads a job that names no uploaded series.
pub fn parse_job(body: &[u8]) -> Result<Job, Refusal> {
    parse_job_with(body, &Uploads::default())
}

/// Reads a job that may name these series.
pub fn parse_job_with(body: &[u8], uploads: &Uploads) -> Result<Job, Refusal> {
    Job::of(strict::read(body)?, uploads)
}

/// Reads `{ "jobs": … }`. Each job is accepted or refused on its own, with pointers from its own root. Jobs after `stop` has returned true are
/// left out.
pub fn parse_batch(
    body: &[u8],
    uploads: &Uploads,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Result<Job, Refusal>>, Refusal> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Batch<'a> {
        #[serde(borrow)]
        jobs: Vec<&'a RawValue>,
    }
    let jobs = match serde_json::from_slice::<ObjectOnly<Batch<'_>>>(strict::text(body)) {
        Ok(batch) => batch.0.jobs,
        // Read again strictly, for an error with a pointer.
        Err(error) => {
            const EXPECTED: &str = "must be an object `{\"jobs\": […]}`";
            let detail = match strict::read(body)? {
                Value::Object(_) => {
                    let detail = error.to_string();
                    format!("{EXPECTED}: {}", detail.split(" at line").next().unwrap_or_default())
                }
                Value::Array(_) => format!("an array: {EXPECTED}, with this array as its field `jobs`"),
                _ => EXPECTED.to_owned(),
            };
            return Err(FieldError::new("", detail).into());
        }
    };
    if jobs.is_empty() || jobs.len() > MAX_JOBS {
        let detail = format!("{} jobs: must be from 1 to {MAX_JOBS}", jobs.len());
        return Err(FieldError::new("/jobs", detail).into());
    }
    Ok(jobs.into_iter().take_while(|_| !stop()).map(|job| parse_job_with(job.get().as_bytes(), uploads)).collect())
}

/// Reads a job, or `{ "scene": … }` for a simulation of it, that names no uploaded series.
pub fn parse_scene_request(body: &[u8]) -> Result<Job, Refusal> {
    parse_scene_request_with(body, &Uploads::default())
}

/// The same of a request that may name these series.
pub fn parse_scene_request_with(body: &[u8], uploads: &Uploads) -> Result<Job, Refusal> {
    let request = strict::read(body)?;
    if is_scene(&request) {
        let detail = "a scene alone: must be an object `{\"scene\": …}`, with this as its field `scene`";
        return Err(FieldError::new("", detail).into());
    }
    match Job::of(with_kind(JobKind::Simulation, request), uploads)? {
        Job::Rotor(_) => Err(FieldError::new("/kind", "`rotor` has nothing to resolve: post it to /v1/rotor").into()),
        Job::Modes(_) => {
            let detail = "a scene with a `shaft` is resolved by /v1/machine/resolve, as `kind` `machine`";
            Err(FieldError::new("/kind", detail).into())
        }
        Job::Machine(_) => {
            let detail = "`machine` is resolved by /v1/machine/resolve";
            Err(FieldError::new("/kind", detail).into())
        }
        job => Ok(job),
    }
}

/// Reads a job, `{ "scene": … }` for a simulation of it, or the scene alone.
pub fn parse_job_or_scene(body: &[u8]) -> Result<Job, Refusal> {
    job_or_scene(strict::read(body)?, simulation_by_default)
}

/// Reads an accuracy job, `{ "scene": … }` for one, or the scene alone. `repetitions` applies where the request does not give them.
pub fn parse_accuracy_request(body: &[u8], repetitions: Option<u32>) -> Result<Job, Refusal> {
    job_or_scene(strict::read(body)?, |mut request| {
        if let (Value::Object(fields), Some(repetitions)) = (&mut request, repetitions) {
            fields.entry("repetitions").or_insert_with(|| repetitions.into());
        }
        of_kind(JobKind::Accuracy, request, &Uploads::default())
    })
}

/// Reads a study, with or without its kind.
pub fn parse_study_request(body: &[u8]) -> Result<Job, Refusal> {
    of_kind(JobKind::Study, strict::read(body)?, &Uploads::default())
}

/// Reads an optimum job, with or without its kind.
pub fn parse_optimum_request(body: &[u8]) -> Result<Job, Refusal> {
    of_kind(JobKind::Optimum, strict::read(body)?, &Uploads::default())
}

/// Reads a rotor job that may name these series. Its kind is required, as in other requests for a job.
pub fn parse_rotor_request(body: &[u8], uploads: &Uploads) -> Result<Job, Refusal> {
    let request = strict::read(body)?;
    if request.is_object() && request.get("kind").is_none() {
        return Err(FieldError::new("/kind", "required, but missing: `rotor`").into());
    }
    of_kind(JobKind::Rotor, request, uploads)
}

/// Reads a machine job that may name these series; the request may omit its kind.
pub fn parse_machine_request(body: &[u8], uploads: &Uploads) -> Result<Job, Refusal> {
    of_kind(JobKind::Machine, strict::read(body)?, uploads)
}

/// Checks a job of one kind, which the request may omit.
fn of_kind(expected: JobKind, request: Value, uploads: &Uploads) -> Result<Job, Refusal> {
    let request = with_kind(expected, request);
    match JobKind::of(&request)? {
        kind if kind == expected => Job::of(request, uploads),
        kind => Err(FieldError::new("/kind", format!("must be `{}`, not `{}`", expected.name(), kind.name())).into()),
    }
}

/// Checks a job, a simulation where it gives no kind.
fn simulation_by_default(request: Value) -> Result<Job, Refusal> {
    Job::of(with_kind(JobKind::Simulation, request), &Uploads::default())
}

fn with_kind(default: JobKind, mut request: Value) -> Value {
    if let Value::Object(fields) = &mut request {
        fields.entry("kind").or_insert_with(|| default.name().into());
    }
    request
}

/// Checks a request by `job`, a scene alone as `{ "scene": … }`. Pointers of errors start at the root of the request in both cases.
fn job_or_scene(request: Value, job: impl FnOnce(Value) -> Result<Job, Refusal>) -> Result<Job, Refusal> {
    if is_scene(&request) {
        return job(json!({ "scene": request })).map_err(|refusal| refusal.map_errors(without_scene));
    }
    job(request)
}

/// True if the request is a scene alone.
fn is_scene(request: &Value) -> bool {
    let has = |field: &str| request.get(field).is_some();
    !has("kind") && !has("scene") && (has("bearing") || has("operation"))
}

fn without_scene(error: FieldError) -> FieldError {
    match error.pointer.strip_prefix("/scene") {
        Some(rest) => FieldError::new(rest, error.detail),
        None => error,
    }
}
