//! An uncertainty job: a scene, distributions of some of its fields, and metrics whose distribution is asked for. Its points are the nominal
//! scene and the sampled ones, each a simulation of its own; they are run as those of a study.

use raceway_core::simulation::solve::plan::model_levels;
use serde_json::{Value, json};

use super::axis::MAX_POINTS;
use super::design::DesignName;
use super::distribution::Sampled;
use super::input::JobInput;
use super::kind::JobKind;
use super::many_runs::refuse_signals;
use super::metric::{LEVEL, examples, part_of, unavailable};
use super::outputs::MetricsPart;
use super::sampled_inputs::{check_inputs, inputs, varied_request};
use super::simulation::{Draft, Simulation};
use super::study::Study;
use super::variation::Variation;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::{FieldError, Refusal};
use crate::contract::json::uploads::Uploads;

/// Largest number of metrics.
const MAX_METRICS: usize = 8;
/// Samples where the request names none: P90 has both bounds of its interval.
const DEFAULT_SAMPLES: u32 = 64;

/// Design, samples and seed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SamplePlan {
    pub design: DesignName,
    pub samples: u32,
    pub seed: u64,
}

/// A checked uncertainty job.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// The nominal point, then those of the design.
    pub study: Study,
    pub inputs: Vec<Sampled>,
    pub plan: SamplePlan,
    /// Pointers to the metrics.
    pub metrics: Vec<String>,
    /// Points of the design in the unit cube.
    pub cube: Vec<Vec<f64>>,
    /// The inputs as in the request.
    given: Value,
}

impl SamplePlan {
    fn of(input: &mut JobInput, inputs: usize, defaults: &mut Defaults) -> Self {
        let samples = defaults.fill("/samples", &mut input.samples, DEFAULT_SAMPLES);
        let design = defaults.fill("/design", &mut input.design, DesignName::Sobol);
        let seed = defaults.fill("/seed", &mut input.seed, 1);
        let known = defaults.errors.len();
        defaults.check("/samples", f64::from(samples));
        let is_in_range = defaults.errors.len() == known;
        if is_in_range && design.in_core().takes_powers_of_two() && !samples.is_power_of_two() {
            let (below, above) = (samples.next_power_of_two() / 2, samples.next_power_of_two());
            let detail =
                format!("{samples}: must be a power of two, such as {below} or {above}; or use `latin_hypercube`");
            defaults.refuse("/samples", detail);
        }
        let runs = design.in_core().points(inputs, samples as usize);
        if is_in_range && runs > MAX_POINTS {
            let detail = format!("{samples}: `pairs` of {inputs} inputs are {runs} runs: at most {MAX_POINTS}");
            defaults.refuse("/samples", detail);
        }
        Self { design, samples, seed }
    }
}

/// The metrics of a request. Unless it names parts of the metrics, only those that contain them are computed.
fn metrics(input: &mut JobInput, defaults: &mut Defaults) -> Vec<String> {
    let metrics = defaults.fill("/metrics", &mut input.metrics, vec![LEVEL.to_owned()]);
    if metrics.is_empty() || metrics.len() > MAX_METRICS {
        defaults.refuse("/metrics", format!("{} metrics: must be from 1 to {MAX_METRICS}", metrics.len()));
    }
    let mut parts: Vec<MetricsPart> = Vec::new();
    for (place, metric) in metrics.iter().take(MAX_METRICS).enumerate() {
        let pointer = format!("/metrics/{place}");
        if metrics[..place].contains(metric) {
            defaults.refuse(pointer, "given more than once");
            continue;
        }
        match part_of(metric) {
            Some(part) if !parts.contains(&part) => parts.push(part),
            Some(_) => {}
            None => {
                let metric: String = metric.chars().take(100).collect();
                defaults
                    .refuse(pointer, format!("unknown metric `{metric}`; metrics are, for example, {}", examples()));
            }
        }
    }
    let asked = input.outputs.get_or_insert_default().metrics.get_or_insert_with(|| parts.clone());
    if let Some(part) = parts.iter().find(|part| !asked.contains(part)) {
        defaults.refuse("/outputs/metrics", format!("must contain `{}`, a part of `metrics`", part.name()));
    }
    metrics
}

impl Uncertainty {
    /// The uncertainty job of a request of this kind. Refused also where the scene cannot be built at the nominal or at the outermost sampled
    /// values of an input, or where its results never contain a metric.
    pub fn of(request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let mut draft = Draft::of(JobKind::Uncertainty, request, uploads)?;
        refuse_signals(JobKind::Uncertainty, &draft.input, &mut draft.defaults);
        let inputs = inputs(&mut draft);
        let plan = SamplePlan::of(&mut draft.input, inputs.len(), &mut draft.defaults);
        let metrics = metrics(&mut draft.input, &mut draft.defaults);
        let given = json!(draft.input.inputs);
        let settings = draft.settings();
        let base = draft.simulation(settings, model_levels)?;
        let parts = json!(base.outputs.metrics);
        let request = varied_request(&base.submission.request, parts, &inputs);
        let variation = Variation::new(&request, base.scene_json(), uploads);
        check_inputs(&inputs, &variation)?;
        let cube = plan.design.in_core().cube(inputs.len(), plan.samples as usize, plan.seed);
        let columns = inputs.iter().enumerate().map(|(place, input)| {
            let sampled = cube.iter().map(|point| input.value(point[place]));
            (input.varied.clone(), [input.nominal()].into_iter().chain(sampled).collect())
        });
        let study = Study::listed(base, columns.collect(), variation);
        let job = Self { study, inputs, plan, metrics, cube, given };
        let nominal = job.check_values()?;
        let missing = |(place, metric): (usize, &String)| {
            unavailable(metric, nominal.scene()).map(|detail| FieldError::new(format!("/metrics/{place}"), detail))
        };
        match job.metrics.iter().enumerate().find_map(missing) {
            Some(error) => Err(error.into()),
            None => Ok(job),
        }
    }

    /// The nominal simulation. Refuses values of an input with which the scene cannot be built while the others are nominal.
    fn check_values(&self) -> Result<Simulation, Refusal> {
        let at_input = |error: FieldError| {
            let place = self.inputs.iter().position(|input| input.varied.sets(&error.pointer));
            let Some(place) = place else { return error };
            let detail = format!("at the nominal values: {}", self.inputs[place].varied.message(&error));
            FieldError::new(format!("/inputs/{place}/distribution"), detail)
        };
        let nominal = self.study.point(0).map_err(|refusal| refusal.map_errors(at_input))?;
        for (place, input) in self.inputs.iter().enumerate() {
            for value in self.outermost(place) {
                let others = self.inputs.iter().filter(|other| other.varied != input.varied);
                let values =
                    others.map(|other| (&other.varied, other.nominal())).chain([(&input.varied, value.clone())]);
                let Err(Refusal::Invalid { errors }) = self.study.scene(values) else { continue };
                let Some(error) = errors.first() else { continue };
                let detail = format!("at the sampled value {value}: {}", input.varied.message(error));
                return Err(FieldError::new(format!("/inputs/{place}/distribution"), detail).into());
            }
        }
        Ok(nominal)
    }

    /// The least and the greatest sampled number of an input, or all its values.
    fn outermost(&self, place: usize) -> Vec<Value> {
        let values = &self.study.axes[place].values;
        if self.inputs[place].is_ordered() {
            let number = |value: &&Value| value.as_f64().unwrap_or(f64::NAN);
            let by_size = |a: &&Value, b: &&Value| number(a).total_cmp(&number(b));
            return values.iter().min_by(by_size).into_iter().chain(values.iter().max_by(by_size)).cloned().collect();
        }
        let mut known: Vec<Value> = Vec::new();
        for value in values {
            if !known.contains(value) {
                known.push(value.clone());
            }
        }
        known
    }

    /// Everything that determines the result, as JSON.
    pub fn canonical(&self) -> Value {
        json!({
            "kind": JobKind::Uncertainty.name(),
            "base": self.study.base_request(),
            "inputs": self.given,
            "samples": self.plan.samples,
            "design": self.plan.design,
            "seed": self.plan.seed,
            "metrics": self.metrics,
        })
    }
}
