//! A job: a scene, how to simulate it, what to keep, and how the service treats it.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;

use super::filling::Filling;
use super::outputs::OutputsInput;
use super::problem::{FieldError, Refusal, listed};
use super::scene::{ResolvedScene, SceneInput};
use super::solver::{Solver, SolverInput};
use super::strict::{self, object, optional_object};
use super::{given_fields, times};
use crate::simulation::needs::{Needs, Unmet};
use crate::simulation::run::RunSettings;

/// A request for one simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JobInput {
    /// What to do.
    #[schema(value_type = JobKindName)]
    pub kind: String,
    #[serde(deserialize_with = "object")]
    pub scene: SceneInput,
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub solver: Option<SolverInput>,
    /// Time simulated and kept, after settling [s]. Default: 20 ball passes, at least 0.1 and at most 1.
    #[schema(nullable = false, exclusive_minimum = 0, example = 0.1)]
    pub duration_s: Option<f64>,
    /// Time simulated before anything is kept [s]. Default: 3 cage turns, at least 0.02 and at most 1.
    #[schema(nullable = false, minimum = 0, maximum = 1000, example = 0.02)]
    pub settle_s: Option<f64>,
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub outputs: Option<OutputsInput>,
    /// Words to find the job by: at most 16 of at most 200 characters.
    #[schema(nullable = false, max_items = 16, example = json!(["line 3"]))]
    pub labels: Option<Vec<String>>,
    /// 1 (first) to 4 (last). Default 2.
    #[serde(default, deserialize_with = "strict::whole_number")]
    #[schema(nullable = false, minimum = 1, maximum = 4, example = 2)]
    pub priority: Option<u32>,
    /// Whether the result of identical finished work may answer this job. Default true.
    #[schema(nullable = false)]
    pub reuse: Option<bool>,
    /// How long job and result are kept after it has ended [s]. Default: the service's.
    #[schema(nullable = false, minimum = 1, maximum = 315360000)]
    pub keep_for_s: Option<f64>,
}

/// Kinds of jobs.
#[derive(ToSchema)]
#[schema(rename_all = "snake_case")]
pub enum JobKindName {
    Simulation,
}

/// Kinds of jobs that can be run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobKind {
    Simulation,
}

/// Kinds by name; those without a kind are not available yet.
const KINDS: [(&str, Option<JobKind>); 4] =
    [("simulation", Some(JobKind::Simulation)), ("study", None), ("optimum", None), ("accuracy", None)];

/// A checked job.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    pub kind: JobKind,
    /// The request as it was sent.
    pub request: Value,
    pub resolved: ResolvedScene,
    pub settings: RunSettings,
    /// What the model contains.
    pub needs: Needs,
    /// Solver and outputs with every default, as in a request.
    pub solver: SolverInput,
    pub outputs: OutputsInput,
    pub labels: Vec<String>,
    /// 1 (first) to 4 (last).
    pub priority: u8,
    pub reuse: bool,
    /// [s]
    pub keep_for_s: Option<f64>,
}

impl JobKind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Simulation => "simulation",
        }
    }
}

impl Job {
    pub fn scene(&self) -> &crate::simulation::scene::Scene {
        &self.resolved.scene
    }

    /// All that determines the result, as text: equal for equal work, whatever was left to a default.
    pub fn canonical(&self) -> String {
        json!({
            "kind": self.kind.name(),
            "scene": self.scene_json(),
            "solver": given_fields(&self.solver),
            "outputs": given_fields(&self.outputs),
            "settle_s": self.settings.settle,
            "duration_s": self.settings.duration,
        })
        .to_string()
    }

    /// The scene with every default filled in.
    pub fn scene_json(&self) -> Value {
        given_fields(&self.resolved.input)
    }
}

/// Reads a job.
pub fn parse_job(body: &[u8]) -> Result<Job, Refusal> {
    job_of(strict::read(body)?)
}

/// Reads a job, or `{ "scene": … }` for a simulation of it.
pub fn parse_scene_request(body: &[u8]) -> Result<Job, Refusal> {
    simulation_of(strict::read(body)?)
}

/// Checks a job that has been read, a simulation where it says no kind.
pub fn simulation_of(mut request: Value) -> Result<Job, Refusal> {
    if let Value::Object(fields) = &mut request {
        fields.entry("kind").or_insert_with(|| "simulation".into());
    }
    job_of(request)
}

/// Checks a job that has been read.
pub fn job_of(request: Value) -> Result<Job, Refusal> {
    let kind = kind_of(&request)?;
    let mut input: JobInput = strict::typed(&request, "")?;
    let mut filling = Filling::default();
    let (resolved, mut errors) = match input.scene.resolve() {
        Ok(resolved) => (Some(resolved), Vec::new()),
        Err(errors) => (None, errors),
    };
    let scene = resolved.as_ref().map(|resolved| &resolved.scene);
    let mut solver = input.solver.unwrap_or_default();
    let mut outputs = input.outputs.unwrap_or_default();
    let Solver { method, rung, relative_tolerance, model_tolerance_db, fixed_step } = solver.resolve(&mut filling);
    let kept = outputs.resolve(&mut filling, scene);
    let settle = times::settle(&mut input.settle_s, scene, &mut filling);
    let duration = times::duration(&mut input.duration_s, scene, &kept, &mut filling);
    let labels = input.labels.unwrap_or_default();
    check_labels(&labels, &mut filling);
    let priority = filling.take("/priority", &mut input.priority, 2);
    filling.within("/priority", f64::from(priority), 1.0, 4.0, "");
    if let Some(keep) = input.keep_for_s {
        filling.within("/keep_for_s", keep, 1.0, 315_360_000.0, "s");
    }
    errors.append(&mut filling.errors);
    match resolved {
        Some(mut resolved) if errors.is_empty() => {
            let needs = Needs::of(&resolved.scene, &kept, rung).map_err(unmet)?;
            resolved.defaults.append(&mut filling.defaults);
            Ok(Job {
                kind,
                request,
                resolved,
                settings: RunSettings {
                    method,
                    rung,
                    relative_tolerance,
                    model_tolerance_db,
                    fixed_step,
                    settle,
                    duration,
                    outputs: kept,
                },
                needs,
                solver,
                outputs,
                labels,
                priority: u8::try_from(priority).unwrap_or(2),
                reuse: input.reuse.unwrap_or(true),
                keep_for_s: input.keep_for_s,
            })
        }
        _ => Err(Refusal::Invalid { errors }),
    }
}

fn kind_of(request: &Value) -> Result<JobKind, FieldError> {
    let refuse = |detail: String| Err(FieldError::new("/kind", detail));
    let Some(fields) = request.as_object() else {
        return Err(FieldError::new("", "must be an object"));
    };
    let known = listed(KINDS.iter().map(|kind| kind.0));
    match fields.get("kind") {
        None => refuse(format!("required, but missing; kinds are {known}")),
        Some(Value::String(name)) => match KINDS.iter().find(|kind| kind.0 == name) {
            Some((_, Some(kind))) => Ok(*kind),
            Some(_) => refuse(format!("`{name}` is not available in this version")),
            None => {
                refuse(format!("no kind is called `{}`; kinds are {known}", name.chars().take(100).collect::<String>()))
            }
        },
        Some(_) => refuse(format!("must be a string; kinds are {known}")),
    }
}

/// The choice that the scene cannot be given.
fn unmet(unmet: Unmet) -> FieldError {
    let pointer = match &unmet {
        Unmet::Rung { .. } => "/solver/rung".to_owned(),
        Unmet::Term { term, .. } => format!("/scene/terms/{}", term.name()),
    };
    FieldError::new(pointer, unmet.to_string())
}

fn check_labels(labels: &[String], filling: &mut Filling) {
    if labels.len() > 16 {
        filling.refuse("/labels", format!("{} labels: at most 16", labels.len()));
    }
    for (index, label) in labels.iter().enumerate() {
        let length = label.chars().count();
        if length > 200 {
            filling.refuse(format!("/labels/{index}"), format!("{length} characters: at most 200"));
        } else if label.chars().any(char::is_control) {
            filling.refuse(format!("/labels/{index}"), "control characters have no place in a label");
        }
    }
}
