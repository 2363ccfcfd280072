//! A job as it is sent, before it is checked.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::axis::{AxisInput, StrictAxis};
use super::design::DesignName;
use super::distribution::{StrictInput, UncertainInput};
use super::kind::JobKindName;
use super::outputs::OutputsInput;
use super::solver::{MethodName, SolverInput};
use super::statistic::{StatisticChoice, StatisticInput};
use super::submission::ServiceFields;
use crate::contract::json::limits::{MAX_REPETITIONS, MAX_SAMPLES, MIN_SAMPLES};
use crate::contract::json::shapes::{object, optional_object, whole_number, wide_whole_number};
use crate::contract::scene::scene_input::SceneInput;

/// A job: one simulation, a study of many, the optimum of a metric over one or two ranges, the distribution of metrics from
/// those of inputs, or the error of several methods against their run time. `kind` decides which fields it takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JobInput {
    /// Kind of the computation.
    #[schema(value_type = JobKindName)]
    pub kind: String,
    /// Bearing, operation and everything else that is simulated.
    #[serde(deserialize_with = "object")]
    pub scene: SceneInput,
    /// Integrator, tolerances and model. Default: chosen for the scene.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub solver: Option<SolverInput>,
    /// The varied fields. Several axes of a study span a grid of at most 10 000 points. An optimum job takes one or two ranges, each with
    /// `from` and `to`.
    #[schema(nullable = false, value_type = Option<Vec<AxisInput>>, min_items = 1, max_items = 4)]
    pub axes: Option<Vec<StrictAxis>>,
    /// JSON pointer to the metric that is minimized or maximized.
    #[schema(nullable = false, max_length = 200, example = "/channels/spindle.y.acceleration/level_db")]
    pub metric: Option<String>,
    /// Which extreme of the metric is searched for; of `cage_slip`, which of its magnitude. Default `minimum`.
    #[schema(nullable = false)]
    pub goal: Option<GoalName>,
    /// Uncertain fields and their distributions, independent of each other. With them every point of a study or an optimum is run for the same samples, and
    /// its metrics are a `statistic` over these.
    #[schema(nullable = false, value_type = Option<Vec<UncertainInput>>, min_items = 1, max_items = 12)]
    pub inputs: Option<Vec<StrictInput>>,
    /// Number of samples. A power of two, except for `latin_hypercube`. Default 64; 32 for a point of a study or an optimum. A study has at most 10 000 points times samples. `pairs` runs as many times as there are inputs, and twice more, at
    /// most 10 000 times; one more run of an uncertainty job is that of the nominal values.
    #[serde(default, deserialize_with = "whole_number::<_, MIN_SAMPLES, MAX_SAMPLES>")]
    #[schema(nullable = false, example = 64)]
    pub samples: Option<u32>,
    /// How samples are drawn. Default `sobol`.
    #[schema(nullable = false)]
    pub design: Option<DesignName>,
    /// Seed of the design: the same seed gives the same points on every machine. Default 1.
    #[serde(default, deserialize_with = "wide_whole_number")]
    #[schema(nullable = false, value_type = u64, minimum = 0, maximum = 9_007_199_254_740_991_u64, example = 1)]
    pub seed: Option<u64>,
    /// JSON pointers to the metrics whose distribution is asked for. Default: the level of the spindle's acceleration along y.
    #[schema(nullable = false, min_items = 1, max_items = 8, example = json!(["/channels/spindle.y.acceleration/level_db"]))]
    pub metrics: Option<Vec<String>>,
    /// With `inputs` of a study or an optimum: the statistic of the metrics over the inputs, `mean` or a percentile. Default: the 90th percentile.
    #[schema(nullable = false, value_type = Option<StatisticChoice>, example = json!({"percentile": 90}))]
    pub statistic: Option<StatisticInput>,
    /// Recorded time, after settling [s]. Default: 20 ball passes, at least 0.1 and at most 1; 0.02 for
    /// `accuracy`. With `outputs.series` or `outputs.orders` at most 23.4 s; with more than 14 series at most 327.6 s divided by their number.
    #[schema(nullable = false, example = 0.1)]
    pub duration_s: Option<f64>,
    /// Time simulated before recording begins [s]. Default: 3 cage turns, at least 0.02 and at most 1. At constant speed also until the free
    /// vibration of the spindle on its contacts has decayed to a fiftieth, at most 5. 0.02 for `accuracy`.
    #[schema(nullable = false, example = 0.02)]
    pub settle_s: Option<f64>,
    /// Methods to compare. Default: all.
    #[schema(nullable = false, value_type = Option<Vec<MethodName>>, min_items = 1, max_items = 5)]
    pub methods: Option<Vec<String>>,
    /// Relative tolerances of each method, each from 1e-12 to 1e-2. Default: 1e-3 to 1e-7.
    #[schema(nullable = false, min_items = 1, max_items = 12, example = json!([1e-3, 1e-4, 1e-5, 1e-6, 1e-7]))]
    pub relative_tolerances: Option<Vec<f64>>,
    /// Timed runs of each method at each tolerance. Default 1.
    #[serde(default, deserialize_with = "whole_number::<_, 1, { MAX_REPETITIONS }>")]
    #[schema(nullable = false, example = 5)]
    pub repetitions: Option<u32>,
    /// Metrics, spectra and time series of the result.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub outputs: Option<OutputsInput>,
    /// Labels to find the job by: at most 16, each at most 200 characters.
    #[schema(nullable = false, max_items = 16, example = json!(["line 3"]))]
    pub labels: Option<Vec<String>>,
    /// Priority from 1 (first) to 4 (last). Default 2.
    #[serde(default, deserialize_with = "whole_number::<_, 1, 4>")]
    #[schema(nullable = false, example = 2)]
    pub priority: Option<u32>,
    /// True if the result of an identical finished job may be returned. Default true; never for `accuracy`.
    #[schema(nullable = false)]
    pub reuse: Option<bool>,
    /// Time that the job and its result are kept after its end [s]. Default: set by the service.
    #[schema(nullable = false)]
    pub keep_for_s: Option<f64>,
}

/// Which extreme of the metric is searched for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum GoalName {
    Minimum,
    Maximum,
}

impl JobInput {
    /// Fields that concern only the service.
    pub fn service(&mut self) -> ServiceFields<'_> {
        let Self { labels, priority, reuse, keep_for_s, .. } = self;
        ServiceFields { labels, priority, reuse: *reuse, keep_for_s: *keep_for_s }
    }
}
