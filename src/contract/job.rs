//! A job: a scene, how to simulate it, what to keep, and how the service treats it.

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use serde_json::{Value, json};
use utoipa::ToSchema;

use super::filling::Filling;
use super::optimum::{self, GoalName, Sought};
use super::outputs::{OutputsInput, USUAL_SPECTRA};
use super::problem::{FieldError, Refusal, listed};
use super::scene::{ResolvedScene, SceneInput};
use super::solver::{MethodName, Solver, SolverInput};
use super::strict::{self, ObjectOnly, object, optional_object};
use super::study::{self, StrictAxis, Study};
use super::variation::Variation;
use super::{accuracy, given_fields, limits, times};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::terms::{Needs, Unmet};
use crate::simulation::solve::ladder::{self};
use crate::simulation::work_precision::{Plan, SETTLING};

/// A request: one simulation, a study of many, the optimum of a metric over one or two ranges, or the error of several methods against
/// their run time. `kind` decides which fields it takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JobInput {
    /// What to do.
    #[schema(value_type = JobKindName)]
    pub kind: String,
    /// What to simulate.
    #[serde(deserialize_with = "object")]
    pub scene: SceneInput,
    /// How to simulate it. Default: the run chooses.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub solver: Option<SolverInput>,
    /// What is varied. Several axes of a study span a grid of at most 10 000 points; an optimum job takes one range or two, each by
    /// `from` and `to`.
    #[schema(nullable = false, value_type = Option<Vec<study::AxisInput>>, min_items = 1, max_items = 4)]
    pub axes: Option<Vec<StrictAxis>>,
    /// JSON pointer to the number in the metrics whose best value is sought.
    #[schema(nullable = false, max_length = 200, example = "/channels/spindle.y.acceleration/level_db")]
    pub metric: Option<String>,
    /// Which end of the metric is the best. Default `minimum`.
    #[schema(nullable = false)]
    pub goal: Option<GoalName>,
    /// Time simulated and kept, after settling [s]. Default: 20 ball passes, at least 0.1 and at most 1; 0.02 for
    /// `accuracy`. With `outputs.series` the longest is 23.4 s, and 327.6 s over their number where they are more than 14.
    #[schema(nullable = false, example = 0.1)]
    pub duration_s: Option<f64>,
    /// Time simulated before anything is kept [s]. Default: 3 cage turns, at least 0.02 and at most 1; at constant speed also until free
    /// vibration of the spindle has decayed to a fiftieth on its contacts, at most 5. 0.02 for `accuracy`.
    #[schema(nullable = false, example = 0.02)]
    pub settle_s: Option<f64>,
    /// Methods to compare. Default: all.
    #[schema(nullable = false, value_type = Option<Vec<MethodName>>, min_items = 1, max_items = 5)]
    pub methods: Option<Vec<String>>,
    /// Relative tolerances to run each method at, each from 1e-12 to 1e-2. Default: 1e-3 to 1e-7.
    #[schema(nullable = false, min_items = 1, max_items = 12, example = json!([1e-3, 1e-4, 1e-5, 1e-6, 1e-7]))]
    pub relative_tolerances: Option<Vec<f64>>,
    /// Timed runs of each method at each tolerance. Default 1.
    #[serde(default, deserialize_with = "strict::whole_number::<_, 1, { accuracy::MOST_REPETITIONS }>")]
    #[schema(nullable = false, example = 5)]
    pub repetitions: Option<u32>,
    /// What to keep of it.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub outputs: Option<OutputsInput>,
    /// Words to find the job by: at most 16 of at most 200 characters.
    #[schema(nullable = false, max_items = 16, example = json!(["line 3"]))]
    pub labels: Option<Vec<String>>,
    /// 1 (first) to 4 (last). Default 2.
    #[serde(default, deserialize_with = "strict::whole_number::<_, 1, 4>")]
    #[schema(nullable = false, example = 2)]
    pub priority: Option<u32>,
    /// Whether the result of identical finished work may answer this job. Default true; never for `accuracy`.
    #[schema(nullable = false)]
    pub reuse: Option<bool>,
    /// How long job and result are kept after it has ended [s]. Default: the service's.
    #[schema(nullable = false)]
    pub keep_for_s: Option<f64>,
}

/// `simulation`: one run. `study`: a run for each point of a grid. `optimum`: the point of one range or two that is best by a metric. `accuracy`: error against run time, by several methods and tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobKindName {
    Simulation,
    Study,
    Optimum,
    Accuracy,
}

impl From<JobKindName> for JobKind {
    fn from(kind: JobKindName) -> Self {
        match kind {
            JobKindName::Simulation => Self::Simulation,
            JobKindName::Study => Self::Study,
            JobKindName::Optimum => Self::Optimum,
            JobKindName::Accuracy => Self::Accuracy,
        }
    }
}

/// Kinds of jobs that can be run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobKind {
    Simulation,
    Study,
    Optimum,
    Accuracy,
}

const KINDS: [JobKind; 4] = [JobKind::Simulation, JobKind::Study, JobKind::Optimum, JobKind::Accuracy];

/// A checked job.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    pub kind: JobKind,
    /// The request as it was sent.
    pub request: Value,
    pub resolved: ResolvedScene,
    /// Of an accuracy job: times, outputs and rung; method and tolerance are the plan's.
    pub settings: RunSettings,
    /// What an accuracy job compares; `None` for all others.
    pub plan: Option<Plan>,
    /// What a study varies; `None` for all others.
    pub study: Option<Study>,
    /// What an optimum job seeks; `None` for all others.
    pub sought: Option<Sought>,
    /// Rungs that are tried, the leanest first.
    pub rungs: Vec<ModelLevel>,
    /// What the equations hold on the last of them.
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
            Self::Study => "study",
            Self::Optimum => "optimum",
            Self::Accuracy => "accuracy",
        }
    }
}

impl Job {
    pub fn scene(&self) -> &crate::simulation::input::scene::Scene {
        &self.resolved.scene
    }

    /// Simulations of a study, or of an optimum job at most, about; `None`: the job is of another kind.
    pub fn simulations(&self) -> Option<usize> {
        let points = self.study.as_ref().map(|study| study.points);
        points.or_else(|| Some(self.sought.as_ref()?.most_runs()))
    }

    /// All that determines the result, as text: equal for equal work, whatever was left to a default.
    pub fn canonical(&self) -> String {
        match (&self.study, &self.sought) {
            (Some(study), _) => study.canonical().to_string(),
            (_, Some(sought)) => sought.canonical().to_string(),
            _ => self.complete().to_string(),
        }
    }

    /// The same of the simulation that differs in nothing but that it keeps the usual spectra; its metrics are the same.
    pub fn canonical_with_usual_spectra(&self) -> String {
        let mut job = self.complete();
        job["outputs"]["spectra"] = json!(USUAL_SPECTRA);
        job.to_string()
    }

    /// The job with every default filled in, without what only the service needs to know.
    pub fn complete(&self) -> Value {
        let mut job = json!({
            "kind": self.kind.name(),
            "scene": self.scene_json(),
            "solver": given_fields(&self.solver),
            "outputs": given_fields(&self.outputs),
            "settle_s": self.settings.settle,
            "duration_s": self.settings.duration,
        });
        if let Some(plan) = &self.plan {
            job["methods"] = plan.methods.iter().map(|method| method.name()).collect();
            job["relative_tolerances"] = plan.relative_tolerances.clone().into();
            job["repetitions"] = plan.repetitions.into();
        }
        job
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

/// Jobs of a batch at most.
const MOST_JOBS: usize = 1000;

/// Reads `{ "jobs": … }`: each is accepted or refused for itself, by pointers from its own root.
pub fn parse_batch(body: &[u8]) -> Result<Vec<Result<Job, Refusal>>, Refusal> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Batch<'a> {
        #[serde(borrow)]
        jobs: Vec<&'a RawValue>,
    }
    let jobs = match serde_json::from_slice::<ObjectOnly<Batch<'_>>>(body) {
        Ok(batch) => batch.0.jobs,
        // What is wrong with it, and where.
        Err(error) => {
            const WANTED: &str = "must be an object `{\"jobs\": […]}`";
            let detail = match strict::read(body)? {
                Value::Object(_) => {
                    let detail = error.to_string();
                    format!("{WANTED}: {}", detail.split(" at line").next().unwrap_or_default())
                }
                Value::Array(_) => format!("an array: {WANTED}, with this array as its field `jobs`"),
                _ => WANTED.to_owned(),
            };
            return Err(FieldError::new("", detail).into());
        }
    };
    if jobs.is_empty() || jobs.len() > MOST_JOBS {
        let detail = format!("{} jobs: must be from 1 to {MOST_JOBS}", jobs.len());
        return Err(FieldError::new("/jobs", detail).into());
    }
    Ok(jobs.into_iter().map(|job| parse_job(job.get().as_bytes())).collect())
}

/// Reads a job, or `{ "scene": … }` for a simulation of it.
pub fn parse_scene_request(body: &[u8]) -> Result<Job, Refusal> {
    let request = strict::read(body)?;
    if is_scene(&request) {
        let detail = "a scene alone: must be an object `{\"scene\": …}`, with this as its field `scene`";
        return Err(FieldError::new("", detail).into());
    }
    simulation_of(request)
}

/// Reads a job, `{ "scene": … }` for a simulation of it, or the scene alone.
pub fn parse_job_or_scene(body: &[u8]) -> Result<Job, Refusal> {
    job_or_scene(strict::read(body)?, simulation_of)
}

/// Reads an accuracy job, `{ "scene": … }` for one, or the scene alone; `repetitions` is for those that say nothing about it.
pub fn parse_accuracy_request(body: &[u8], repetitions: Option<u32>) -> Result<Job, Refusal> {
    job_or_scene(strict::read(body)?, |mut request| {
        if let (Value::Object(fields), Some(repetitions)) = (&mut request, repetitions) {
            fields.entry("repetitions").or_insert_with(|| repetitions.into());
        }
        of_kind(JobKind::Accuracy, request)
    })
}

/// Reads a study, with or without its kind.
pub fn parse_study_request(body: &[u8]) -> Result<Job, Refusal> {
    of_kind(JobKind::Study, strict::read(body)?)
}

/// Reads an optimum job, with or without its kind.
pub fn parse_optimum_request(body: &[u8]) -> Result<Job, Refusal> {
    of_kind(JobKind::Optimum, strict::read(body)?)
}

/// Checks a job of a kind, which it need not say.
fn of_kind(wanted: JobKind, mut request: Value) -> Result<Job, Refusal> {
    if let Value::Object(fields) = &mut request {
        fields.entry("kind").or_insert_with(|| wanted.name().into());
    }
    match kind_of(&request)? {
        kind if kind == wanted => job_of(request),
        kind => Err(FieldError::new("/kind", format!("must be `{}`, not `{}`", wanted.name(), kind.name())).into()),
    }
}

/// Checks what has been read by `job`, a scene alone as one of `{ "scene": … }`. Told apart by their fields; pointers
/// of errors are those of what was read.
pub fn job_or_scene(request: Value, job: impl FnOnce(Value) -> Result<Job, Refusal>) -> Result<Job, Refusal> {
    if is_scene(&request) {
        return job(json!({ "scene": request })).map_err(|refusal| refusal.each(without_scene));
    }
    job(request)
}

/// Whether it is a scene where a job, or an object with a scene, may stand.
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
    let (input, faults) = strict::typed_with_faults::<JobInput>(&request);
    let faults: Vec<FieldError> = faults.into_iter().map(limits::with_range).collect();
    let Some(mut input) = input else { return Err(Refusal::Invalid { errors: faults }) };
    let mut filling = Filling::default();
    let (resolved, mut errors) = if faults.iter().any(|fault| fault.concerns("/scene")) {
        (None, input.scene.clone().faults_beside(&faults))
    } else {
        match input.scene.clone().resolve() {
            Ok(resolved) => (Some(resolved), Vec::new()),
            Err(errors) => (None, errors),
        }
    };
    let scene = resolved.as_ref().map(|resolved| &resolved.scene);
    if !matches!(kind, JobKind::Study | JobKind::Optimum) {
        study::refuse_in(kind, &input, &mut filling);
    }
    if kind != JobKind::Optimum {
        optimum::refuse_in(kind, &input, &mut filling);
    }
    let (mut varied, mut wish) = (None, None);
    let (settings, plan) = match kind {
        JobKind::Simulation => (simulation(kind, &mut input, scene, &mut filling), None),
        JobKind::Study => {
            study::refuse_signals(kind, &input, &mut filling);
            varied = Some(study::axes(&mut input, &mut filling));
            (simulation(kind, &mut input, scene, &mut filling), None)
        }
        JobKind::Optimum => {
            wish = Some(optimum::wish(&mut input, &mut filling));
            (simulation(kind, &mut input, scene, &mut filling), None)
        }
        JobKind::Accuracy => {
            let plan = accuracy::plan(&mut input, &mut filling);
            (compared(&mut input, &mut filling), Some(plan))
        }
    };
    let labels = input.labels.unwrap_or_default();
    check_labels(&labels, &mut filling);
    let priority = filling.take("/priority", &mut input.priority, 2);
    filling.check("/priority", f64::from(priority));
    if let Some(keep) = input.keep_for_s {
        filling.check("/keep_for_s", keep);
    }
    let variation = resolved.as_ref().map(|resolved| Variation::new(&request, given_fields(&resolved.input)));
    if let (Some((axes, _)), Some(variation)) = (&varied, &variation) {
        study::refuse_values(axes, variation, &mut filling);
    }
    // What could not be read may be what is missing.
    let model = scene.filter(|_| faults.is_empty()).map(|scene| model(scene, &settings, plan.is_some()));
    let model = match model {
        Some(Err(error)) if !filling.errors.iter().any(|told| told.pointer == error.pointer) => {
            filling.errors.push(error);
            None
        }
        model => model.and_then(Result::ok),
    };
    errors.append(&mut filling.errors);
    errors.retain(|error| !faults.iter().any(|fault| fault.concerns(&error.pointer)));
    errors.splice(0..0, faults);
    let (Some(mut resolved), Some(variation), Some((needs, rungs)), true) =
        (resolved, variation, model, errors.is_empty())
    else {
        return Err(Refusal::Invalid { errors });
    };
    resolved.defaults.append(&mut filling.defaults);
    let reuse = kind != JobKind::Accuracy && input.reuse.unwrap_or(true);
    let study = varied.map(|(axes, points)| Study::new(axes, points, reuse, variation)).transpose()?;
    let complete = || given_fields(&resolved.input);
    let sought = wish.map(|wish| Sought::new(wish, &request, complete())).transpose()?;
    Ok(Job {
        kind,
        request,
        resolved,
        settings,
        plan,
        study,
        sought,
        rungs,
        needs,
        solver: input.solver.unwrap_or_default(),
        outputs: input.outputs.unwrap_or_default(),
        labels,
        priority: u8::try_from(priority).unwrap_or(2),
        reuse,
        keep_for_s: input.keep_for_s,
    })
}

/// What the equations hold, and the rungs that are tried.
fn model(scene: &Scene, settings: &RunSettings, is_compared: bool) -> Result<(Needs, Vec<ModelLevel>), FieldError> {
    let needs = ladder::needs(scene, &settings.outputs, settings.rung, settings.model_tolerance_db).map_err(unmet)?;
    let rungs = if is_compared { vec![needs.rung] } else { ladder::tried(scene, settings).map_err(unmet)? };
    Ok((needs, rungs))
}

/// How to run a simulation.
fn simulation(kind: JobKind, input: &mut JobInput, scene: Option<&Scene>, filling: &mut Filling) -> RunSettings {
    accuracy::refuse_in(kind, input, filling);
    let solver = input.solver.get_or_insert_default().resolve(filling);
    let outputs = input.outputs.get_or_insert_default().resolve(filling, scene);
    let settle = times::settle(&mut input.settle_s, times::default_settle(scene), filling);
    let duration = times::duration(&mut input.duration_s, times::default_duration(scene, settle), &outputs, filling);
    let Solver { method, rung, mut relative_tolerance, mut tightened, model_tolerance_db, fixed_step } = solver;
    if !outputs.series.is_empty() {
        // Every value of a series is asked for, and nothing judges them.
        relative_tolerance = tightened.take().unwrap_or(relative_tolerance);
    }
    RunSettings {
        method,
        rung,
        relative_tolerance,
        tightened,
        model_tolerance_db,
        fixed_step,
        settle,
        duration,
        outputs,
    }
}

/// What the runs of an accuracy job have in common.
fn compared(input: &mut JobInput, filling: &mut Filling) -> RunSettings {
    let (rung, model_tolerance_db) = input.solver.get_or_insert_default().resolve_model(filling);
    if let Some(rung) = rung.filter(|rung| rung.is_reduced()) {
        filling.refuse("/solver/rung", format!("methods are compared on `full` or `planar`, not on `{}`", rung.name()));
    }
    let outputs = input.outputs.get_or_insert_default().resolve_metrics(filling);
    let settle = times::settle(&mut input.settle_s, accuracy::SETTLE, filling);
    let duration = times::duration(&mut input.duration_s, accuracy::DURATION, &outputs, filling);
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

fn kind_of(request: &Value) -> Result<JobKind, FieldError> {
    let refuse = |detail: String| Err(FieldError::new("/kind", detail));
    let Some(fields) = request.as_object() else {
        let several = "; several jobs are a batch, `{\"jobs\": […]}`";
        return Err(FieldError::new("", format!("must be an object{}", if request.is_array() { several } else { "" })));
    };
    let known = listed(KINDS.map(JobKind::name));
    match fields.get("kind") {
        None => refuse(format!("required, but missing; kinds are {known}")),
        Some(Value::String(name)) => match KINDS.iter().find(|kind| kind.name() == name) {
            Some(kind) => Ok(*kind),
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
        Unmet::ModelLevel { .. } => "/solver/rung".to_owned(),
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
