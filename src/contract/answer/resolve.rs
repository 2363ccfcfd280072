//! A job before it runs: all defaults, derived quantities, omitted terms and the estimated cost.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::friction::FrictionReferenceAnswer;
use super::life::LifeAnswer;
use super::loads::{LoadAnswer, loads};
use super::messages::{self, MessageAnswer};
use super::ordered::{self, ClearanceAnswer, DesignationAnswer, OilAnswer};
use super::report::{FrequenciesAnswer, LeftOutAnswer};
use super::resonance::ResonanceAnswer;
use super::surfaces::SurfacesAnswer;
use super::unit_warnings;
use crate::contract::job::checked::Job;
use crate::contract::job::cost::{self, CostAnswer};
use crate::contract::job::outputs::OutputsInput;
use crate::contract::job::simulation::Simulation;
use crate::contract::job::solver::SolverInput;
use crate::contract::json::given_fields::given_fields;
use crate::contract::json::problem::FieldError;
use crate::contract::json::units::{DEG, UM};
use crate::contract::scene::scene_input::SceneInput;
use raceway_core::physics::bearing::Bearing;
use raceway_core::physics::contact::hertz::raceway_contacts;
use raceway_core::physics::kinematics::ideal_frequencies;
use raceway_core::physics::rating::{dynamic_load_rating, dynamic_load_rating_full_formula};
use raceway_core::simulation::input::scene::Scene;
use raceway_core::simulation::model::Mechanism;
use raceway_core::simulation::model::contact_resonance::contact_resonances;
use raceway_core::simulation::model::equilibrium::{StaticLoads, static_loads};
use raceway_core::simulation::model::loaded_frequencies::{LoadedFrequencies, loaded_frequencies};
use raceway_core::simulation::solve::eligibility::active_terms;
use raceway_core::simulation::solve::plan::Plan;
use raceway_core::simulation::solve::surface_warnings::surface_warnings;

/// The response of `POST /v1/scenes/resolve`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolveAnswer {
    /// The scene with all defaults filled in; sent again, it gives the same scene.
    #[schema(value_type = SceneInput)]
    pub scene: Value,
    /// The solver with all defaults filled in.
    #[schema(value_type = SolverInput)]
    pub solver: Value,
    /// The outputs with all defaults filled in.
    #[schema(value_type = OutputsInput)]
    pub outputs: Value,
    /// Time simulated before recording begins [s].
    #[schema(minimum = 0)]
    pub settle_s: f64,
    /// Recorded time after settling [s].
    #[schema(minimum = 0)]
    pub duration_s: f64,
    /// Compared methods of an accuracy job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub methods: Option<Vec<String>>,
    /// Relative tolerances of each method of an accuracy job [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub relative_tolerances: Option<Vec<f64>>,
    /// Timed runs of each method at each tolerance of an accuracy job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub repetitions: Option<u32>,
    /// Number of points of a study.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub points: Option<u64>,
    /// Approximate largest number of simulations of an optimum job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub most_runs: Option<u64>,
    /// Pointers, from the root of a job, to the fields that got their default.
    #[schema(example = json!(["/scene/spindle/mass_kg"]))]
    pub defaults: Vec<String>,
    /// Quantities that follow from the scene.
    pub derived: DerivedAnswer,
    /// Unusual values by field: probably a wrong unit, a speed profile that ends after the run, or a spindle that nothing holds. They do not
    /// prevent the job from running.
    #[schema(example = json!([{ "pointer": "/scene/lubricant/viscosity_pa_s", "detail": "32 Pa·s: lubricating oils have 0.001 to 1 Pa·s at running temperature; 1 mPa·s is 0.001 Pa·s" }]))]
    pub warnings: Vec<FieldError>,
    /// Model levels that are tried, the cheapest first. A reduced level gives the result only where its verification holds.
    #[schema(example = json!(["radially_condensed", "full"]))]
    pub rungs: Vec<String>,
    /// Messages about the plan: limits of what the run can say about its surfaces, and model levels that are not tried. See `MessageCode`.
    pub messages: Vec<MessageAnswer>,
    /// Terms omitted on the first of `rungs`, with the reason; the next levels omit fewer.
    pub left_out: Vec<LeftOutAnswer>,
    /// Estimated cost of the job.
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
    /// Basic dynamic load rating by the full formula for f_c, which includes the groove curvatures [N].
    #[schema(minimum = 0)]
    pub dynamic_load_rating_full_formula_n: f64,
    /// Magnitude of the axial load divided by `dynamic_load_rating_n` [-].
    #[schema(minimum = 0)]
    pub axial_load_over_rating: f64,
    /// Free contact angle [°].
    #[schema(minimum = 0)]
    pub free_contact_angle_deg: f64,
    /// Diametral radial clearance [µm]; negative: a radial preload.
    pub radial_clearance_um: f64,
    /// Characteristic frequencies of ideal rolling at the operating speed and the free contact angle, 0 for a deep-groove bearing.
    pub frequencies_hz: FrequenciesAnswer,
    /// Characteristic frequencies of rolling at the operating speed and the contact angles of the equilibrium under loads, weights and
    /// centrifugal forces, in which a run at this speed starts. Outer control: no ball turns about the normal of its outer contact. Absent
    /// where fewer than a tenth of the balls carry load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub frequencies_loaded_hz: Option<FrequenciesAnswer>,
    /// The same for inner control, the other limit of the balls' spin axes. The frequencies of rolling lie between both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub frequencies_loaded_inner_control_hz: Option<FrequenciesAnswer>,
    /// Rating life under the loads at rest; absent without a static equilibrium.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub life: Option<LifeAnswer>,
    /// Friction moments by empirical models; absent at rest, without oil, without load and for types other than deep groove.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub friction_reference: Option<FrictionReferenceAnswer>,
    /// The bearing of the catalogue; absent where no designation is given. The presets of `GET /v1/presets` keep their own numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub designation: Option<DesignationAnswer>,
    /// How the clearance follows from its group; absent where no group is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub clearance: Option<ClearanceAnswer>,
    /// The oil; absent where neither grade nor kinematic viscosities are given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub oil: Option<OilAnswer>,
    /// Each of `operation.loads`; absent without any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<LoadAnswer>,
    /// Waves of the raceways as the contacts average them, what balls feel of defects, and the balls; absent where all raceways are ideal
    /// circles and all balls are alike.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub surfaces: Option<SurfacesAnswer>,
    /// Resonances of the spindle on its loaded contacts, the lowest first; absent without an equilibrium.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub resonances: Vec<ResonanceAnswer>,
    /// Static equilibrium under the applied loads and the weight of the spindle; absent where there is none.
    #[serde(rename = "static", skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub at_rest: Option<StaticAnswer>,
}

/// Static equilibrium under the applied loads and the weight of the spindle, without centrifugal loads, with the first ball under +Y.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StaticAnswer {
    /// Displacement from the centred position along the radial force, clearance included [µm].
    pub radial_displacement_um: f64,
    /// Displacement from the centred position along the axial load [µm], with the play A sin α₀ of the free contact angle.
    pub axial_displacement_um: f64,
    /// Largest load of a ball on the inner raceway [N].
    #[schema(minimum = 0)]
    pub max_ball_load_n: f64,
    /// Load of each ball on the inner raceway [N], ball 1 first.
    pub ball_loads_n: Vec<f64>,
    /// Largest contact pressure of both raceways [MPa].
    #[schema(minimum = 0)]
    pub max_pressure_mpa: f64,
}

/// Resolves a checked job; `None` for jobs of shafts.
pub fn resolve_answer(job: &Job) -> Option<ResolveAnswer> {
    let base = job.base()?;
    let at_rest = static_loads(base.scene(), &base.terms).ok();
    let (plan, points, most_runs) = match job {
        Job::Simulation(_) | Job::Modes(_) | Job::Rotor(_) | Job::Machine(_) => (None, None, None),
        Job::Study(study) => (None, Some(study.points as u64), None),
        Job::Uncertainty(job) => (None, Some(job.study.points as u64), None),
        Job::Optimum(search) => (None, None, Some(search.most_runs() as u64)),
        Job::Accuracy(comparison) => (Some(&comparison.plan), None, None),
    };
    Some(ResolveAnswer {
        scene: base.scene_json(),
        solver: given_fields(&base.solver),
        outputs: outputs(job, base),
        settle_s: base.settings.settle,
        duration_s: base.settings.duration,
        methods: plan.map(|plan| plan.methods.iter().map(|method| method.name().to_owned()).collect()),
        relative_tolerances: plan.map(|plan| plan.relative_tolerances.clone()),
        repetitions: plan.map(|plan| plan.repetitions),
        points,
        most_runs,
        defaults: base.resolved.defaults.clone(),
        rungs: base.model_levels.iter().map(|level| level.name().to_owned()).collect(),
        messages: if plan.is_none() { messages_of(base) } else { Vec::new() },
        left_out: left_out(base),
        cost: cost::estimate(job),
        derived: DerivedAnswer {
            loads: loads(base.scene()),
            surfaces: SurfacesAnswer::of(base.scene(), &base.terms),
            resonances: resonances(base),
            life: at_rest.as_ref().and_then(|at_rest| life(base, at_rest)),
            friction_reference: at_rest
                .as_ref()
                .and_then(|at_rest| FrictionReferenceAnswer::of(&base.resolved, at_rest)),
            designation: DesignationAnswer::of(&base.resolved),
            clearance: base.resolved.ordered.clearance.as_ref().map(ClearanceAnswer::from),
            oil: base.resolved.ordered.oil.as_ref().map(OilAnswer::from),
            ..derived(base.scene(), at_rest.as_ref(), loaded_frequencies(base.scene(), &base.terms).ok().flatten())
        },
        warnings: [ordered::warnings(&base.resolved), unit_warnings::warnings(base, at_rest.as_ref())].concat(),
    })
}

/// Limits of what the run can say about its surfaces, and model levels that are not tried.
fn messages_of(base: &Simulation) -> Vec<MessageAnswer> {
    let not_eligible = Plan::of(base.scene(), &base.settings).map(|plan| plan.not_eligible).unwrap_or_default();
    let ideal = Mechanism::new(base.scene(), &base.terms);
    let of_surfaces = surface_warnings(base.scene(), &ideal, &base.settings);
    of_surfaces.iter().map(messages::of_warning).chain(not_eligible.iter().map(messages::of_not_eligible)).collect()
}

fn resonances(base: &Simulation) -> Vec<ResonanceAnswer> {
    let ideal = Mechanism::new(base.scene(), &base.terms);
    contact_resonances(&ideal, base.scene().operating_speeds()).iter().map(ResonanceAnswer::from).collect()
}

/// Terms omitted on the first model level.
fn left_out(base: &Simulation) -> Vec<LeftOutAnswer> {
    let first = base.model_levels.first().filter(|level| level.is_reduced());
    let terms = first
        .and_then(|level| active_terms(base.scene(), &base.settings.outputs, Some(*level)).ok())
        .map_or_else(|| base.terms.left_out.clone(), |terms| terms.left_out);
    terms.iter().map(LeftOutAnswer::from).collect()
}

fn outputs(job: &Job, base: &Simulation) -> Value {
    let mut outputs = given_fields(&base.outputs);
    if job.simulations().is_some() {
        // Studies and optimum jobs keep metrics only.
        outputs["spectra"] = Value::Array(Vec::new());
    }
    outputs
}

fn derived(scene: &Scene, at_rest: Option<&StaticLoads>, loaded: Option<LoadedFrequencies>) -> DerivedAnswer {
    let bearing: &Bearing = &scene.bearing;
    let stiffness = raceway_contacts(bearing).map(|contact| contact.stiffness);
    let rating = dynamic_load_rating(bearing);
    DerivedAnswer {
        inner_stiffness_n_per_m1_5: stiffness.inner,
        outer_stiffness_n_per_m1_5: stiffness.outer,
        dynamic_load_rating_n: rating,
        dynamic_load_rating_full_formula_n: dynamic_load_rating_full_formula(bearing),
        axial_load_over_rating: scene.operation.start_load()[0].abs() / rating,
        free_contact_angle_deg: DEG.to_user(bearing.free_contact_angle),
        radial_clearance_um: UM.to_user(bearing.radial_clearance),
        frequencies_hz: ideal_frequencies(bearing, scene.operating_speeds()).into(),
        frequencies_loaded_hz: loaded.map(|loaded| loaded.outer_control.into()),
        frequencies_loaded_inner_control_hz: loaded.map(|loaded| loaded.inner_control.into()),
        life: None,
        friction_reference: None,
        designation: None,
        clearance: None,
        oil: None,
        loads: Vec::new(),
        surfaces: None,
        resonances: Vec::new(),
        at_rest: at_rest.and_then(static_answer),
    }
}

/// `None` where a load of the equilibrium is not finite.
fn life(base: &Simulation, at_rest: &StaticLoads) -> Option<LifeAnswer> {
    static_answer(at_rest).map(|_| LifeAnswer::of(base.scene(), at_rest, &base.resolved.life))
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
