//! What a job means before it runs: every default, derived quantities, what is left out, and the cost.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::cost;
use super::given_fields;
use super::job::Job;
use super::metrics::{FrequenciesAnswer, LeftOutAnswer};
use super::outputs::OutputsInput;
use super::plausible;
use super::problem::FieldError;
use super::scene::SceneInput;
use super::solver::SolverInput;
use super::units::{DEG, UM};
use crate::physics::bearing::Bearing;
use crate::physics::contact::hertz::raceway_contacts;
use crate::physics::kinematics::ideal_frequencies;
use crate::physics::rating::{dynamic_load_rating, dynamic_load_rating_full_formula};
use crate::simulation::model::equilibrium::{StaticLoads, static_loads};
use crate::simulation::solve::ladder;

/// The answer to `POST /v1/scenes/resolve`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolveAnswer {
    /// The scene with every default filled in; posted again, it gives the same scene.
    #[schema(value_type = SceneInput)]
    pub scene: Value,
    /// The solver with every default filled in.
    #[schema(value_type = SolverInput)]
    pub solver: Value,
    /// What is kept, with every default filled in.
    #[schema(value_type = OutputsInput)]
    pub outputs: Value,
    /// Time simulated before anything is kept [s].
    #[schema(minimum = 0)]
    pub settle_s: f64,
    /// Time simulated and kept after that [s].
    #[schema(minimum = 0)]
    pub duration_s: f64,
    /// Of an accuracy job: the methods that it compares.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub methods: Option<Vec<String>>,
    /// Of an accuracy job: the relative tolerances that each method runs at [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub relative_tolerances: Option<Vec<f64>>,
    /// Of an accuracy job: timed runs of each method at each tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub repetitions: Option<u32>,
    /// Of a study: points of its grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub points: Option<u64>,
    /// Of an optimum job: simulations that its search makes at most, about.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub most_runs: Option<u64>,
    /// Pointers, from the root of a job, to the fields that were left to their default.
    #[schema(example = json!(["/scene/spindle/mass_kg"]))]
    pub defaults: Vec<String>,
    /// Quantities that follow from the scene.
    pub derived: DerivedAnswer,
    /// What is so far from what is built that a unit may have been misread, a speed that the run does not see the end of, a spindle that nothing
    /// holds, by field; the job runs all the same.
    #[schema(example = json!([{ "pointer": "/scene/lubricant/viscosity_pa_s", "detail": "32 Pa·s: oils, also those in greases, have 0.001 to 1 Pa·s at work; 1 mPa·s is 0.001" }]))]
    pub warnings: Vec<FieldError>,
    /// Rungs of the ladder of models that are tried, the leanest first: a reduced one makes the result where its check holds.
    #[schema(example = json!(["radially_condensed", "full"]))]
    pub rungs: Vec<String>,
    /// What will not be in the equations of the first of them, and why; where its check fails, more is in them.
    pub left_out: Vec<LeftOutAnswer>,
    /// What the run will cost.
    pub cost: CostAnswer,
}

/// Quantities that follow from the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DerivedAnswer {
    /// Load–deflection factor of a ball on the inner raceway [N/m^1.5].
    pub inner_stiffness_n_per_m1_5: f64,
    /// Load–deflection factor of a ball on the outer raceway [N/m^1.5].
    pub outer_stiffness_n_per_m1_5: f64,
    /// Basic dynamic load rating by the table of f_c of ISO 281 [N].
    #[schema(minimum = 0)]
    pub dynamic_load_rating_n: f64,
    /// The same by the full formula for f_c, which knows the groove curvatures [N].
    #[schema(minimum = 0)]
    pub dynamic_load_rating_full_formula_n: f64,
    /// Size of the axial load over `dynamic_load_rating_n` [-].
    #[schema(minimum = 0)]
    pub axial_load_over_rating: f64,
    /// Contact angle without load [°].
    #[schema(minimum = 0)]
    pub free_contact_angle_deg: f64,
    /// Diametral radial clearance [µm]; negative: a radial preload.
    pub radial_clearance_um: f64,
    /// Of ideal rolling at the operating speed.
    pub frequencies_hz: FrequenciesAnswer,
    /// Equilibrium of the raceways under the applied loads alone; absent where there is none.
    #[serde(rename = "static", skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub at_rest: Option<StaticAnswer>,
}

/// Equilibrium under the applied loads alone (no weight, that of the spindle neither, no centrifugal load), first ball under +Y.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StaticAnswer {
    /// From the centred position along the radial load, clearance included [µm].
    pub radial_displacement_um: f64,
    /// Along the axial load [µm].
    pub axial_displacement_um: f64,
    /// Largest load of a ball on the inner raceway [N].
    #[schema(minimum = 0)]
    pub max_ball_load_n: f64,
    /// Load of each ball on the inner raceway [N], ball 1 first.
    pub ball_loads_n: Vec<f64>,
    /// Largest pressure over both raceways [MPa].
    #[schema(minimum = 0)]
    pub max_pressure_mpa: f64,
}

/// What the run will cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CostAnswer {
    /// Number of first-order states on the last of `rungs`.
    pub states: u64,
    /// Order of magnitude, on one core [s]: in ordinary scenes within a factor of ten, mostly of three; of the first of `rungs`; of
    /// one point of a study, of one run of an optimum job. What happens later in
    /// the run is not foreseen: chaos and impacts may double it, and slip that saturates early (`coulomb` over 1e-5 m/s)
    /// takes ten to a hundred times as long, `radau` and `fine_abm` at loose tolerances most. Absent where the run has
    /// no equilibrium to start from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub estimated_wall_time_s: Option<f64>,
    /// The same where no reduced rung is confirmed, and the last of `rungs` makes the result, with all that judgement has left out and at
    /// a tighter tolerance in the end [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub most_wall_time_s: Option<f64>,
    /// `estimated_wall_time_s` of all points of a study, or of `most_runs` of an optimum job [s]; as many cores share it as there are workers
    /// for a study, one has it for an optimum job. Absent of other kinds.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub all_wall_time_s: Option<f64>,
    /// The same of `most_wall_time_s` [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub most_all_wall_time_s: Option<f64>,
}

/// Resolves a checked job.
pub fn resolve_answer(job: &Job) -> ResolveAnswer {
    let at_rest = static_loads(job.scene(), &job.needs).ok();
    let plan = job.plan.as_ref();
    let leanest = job.rungs.first().filter(|rung| rung.is_reduced());
    let tolerance = job.settings.model_tolerance_db;
    let leanest =
        leanest.and_then(|rung| ladder::needs(job.scene(), &job.settings.outputs, Some(*rung), tolerance).ok());
    let left_out = leanest.map_or_else(|| job.needs.left_out.clone(), |needs| needs.left_out);
    ResolveAnswer {
        scene: job.scene_json(),
        solver: given_fields(&job.solver),
        outputs: outputs(job),
        settle_s: job.settings.settle,
        duration_s: job.settings.duration,
        methods: plan.map(|plan| plan.methods.iter().map(|method| method.name().to_owned()).collect()),
        relative_tolerances: plan.map(|plan| plan.relative_tolerances.clone()),
        repetitions: plan.map(|plan| plan.repetitions),
        points: job.study.as_ref().map(|study| study.points as u64),
        most_runs: job.sought.as_ref().map(|sought| sought.most_runs() as u64),
        defaults: job.resolved.defaults.clone(),
        rungs: job.rungs.iter().map(|rung| rung.name().to_owned()).collect(),
        left_out: left_out.iter().map(LeftOutAnswer::from).collect(),
        cost: cost::estimate(job),
        derived: derived(job, at_rest.as_ref()),
        warnings: plausible::warnings(job, at_rest.as_ref()),
    }
}

fn outputs(job: &Job) -> Value {
    let mut outputs = given_fields(&job.outputs);
    if job.simulations().is_some() {
        // Their runs keep metrics alone.
        outputs["spectra"] = Value::Array(Vec::new());
    }
    outputs
}

fn derived(job: &Job, at_rest: Option<&StaticLoads>) -> DerivedAnswer {
    let scene = job.scene();
    let bearing: &Bearing = &scene.bearing;
    let stiffness = raceway_contacts(bearing).map(|contact| contact.stiffness);
    let rating = dynamic_load_rating(bearing);
    DerivedAnswer {
        inner_stiffness_n_per_m1_5: stiffness.inner,
        outer_stiffness_n_per_m1_5: stiffness.outer,
        dynamic_load_rating_n: rating,
        dynamic_load_rating_full_formula_n: dynamic_load_rating_full_formula(bearing),
        axial_load_over_rating: scene.operation.load[0].abs() / rating,
        free_contact_angle_deg: DEG.to_user(bearing.free_contact_angle),
        radial_clearance_um: UM.to_user(bearing.radial_clearance),
        frequencies_hz: ideal_frequencies(bearing, scene.operating_speed()).into(),
        at_rest: at_rest.and_then(static_answer),
    }
}

/// `None` unless every number is finite.
fn static_answer(loads: &StaticLoads) -> Option<StaticAnswer> {
    let answer = StaticAnswer {
        radial_displacement_um: UM.to_user(loads.radial_displacement),
        axial_displacement_um: UM.to_user(loads.axial_displacement),
        max_ball_load_n: loads.max_ball_load,
        ball_loads_n: loads.ball_loads.clone(),
        max_pressure_mpa: loads.max_pressure / 1e6,
    };
    let numbers = [answer.radial_displacement_um, answer.axial_displacement_um, answer.max_pressure_mpa];
    let finite = answer.ball_loads_n.iter().chain(&numbers).all(|number| number.is_finite());
    finite.then_some(answer)
}
