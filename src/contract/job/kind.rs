//! Kinds of jobs, and the fields that only some kinds take.

use serde::Deserialize;
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::{FieldError, listed};
use serde_json::Value;

/// `simulation`: one run. `study`: a run for each point of a grid. `optimum`: the point of one or two ranges with the best value of a metric. `uncertainty`: distribution of metrics from those of inputs, and which input matters most. `accuracy`: error against run time, for several methods and tolerances, or numbers of modes of a shaft. `rotor`: natural frequencies, critical speeds and unbalance response of a shaft on its supports. `machine`: a shaft on ball bearings in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobKindName {
    Simulation,
    Study,
    Optimum,
    Uncertainty,
    Accuracy,
    Rotor,
    Machine,
}

/// Kinds of jobs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobKind {
    Simulation,
    Study,
    Optimum,
    Uncertainty,
    Accuracy,
    Rotor,
    Machine,
}

impl From<JobKindName> for JobKind {
    fn from(kind: JobKindName) -> Self {
        match kind {
            JobKindName::Simulation => Self::Simulation,
            JobKindName::Study => Self::Study,
            JobKindName::Optimum => Self::Optimum,
            JobKindName::Uncertainty => Self::Uncertainty,
            JobKindName::Accuracy => Self::Accuracy,
            JobKindName::Rotor => Self::Rotor,
            JobKindName::Machine => Self::Machine,
        }
    }
}

/// Fields of a job that only some kinds take.
pub const FIELDS_OF_SOME_KINDS: [&str; 12] = [
    "axes",
    "metric",
    "goal",
    "inputs",
    "samples",
    "design",
    "seed",
    "metrics",
    "statistic",
    "methods",
    "relative_tolerances",
    "repetitions",
];

impl JobKind {
    pub const ALL: [Self; 7] =
        [Self::Simulation, Self::Study, Self::Optimum, Self::Uncertainty, Self::Accuracy, Self::Rotor, Self::Machine];

    pub fn name(self) -> &'static str {
        match self {
            Self::Simulation => "simulation",
            Self::Study => "study",
            Self::Optimum => "optimum",
            Self::Uncertainty => "uncertainty",
            Self::Accuracy => "accuracy",
            Self::Rotor => "rotor",
            Self::Machine => "machine",
        }
    }

    /// True if a job of this kind, by name, is run point by point.
    pub fn has_points(name: &str) -> bool {
        [Self::Study, Self::Uncertainty].map(Self::name).contains(&name)
    }

    /// Those of `FIELDS_OF_SOME_KINDS` that this kind takes.
    pub fn takes(self) -> &'static [&'static str] {
        match self {
            Self::Simulation | Self::Rotor | Self::Machine => &[],
            Self::Study => &["axes", "inputs", "samples", "seed", "statistic"],
            Self::Optimum => &["axes", "metric", "goal", "inputs", "samples", "seed", "statistic"],
            Self::Uncertainty => &["inputs", "samples", "design", "seed", "metrics"],
            Self::Accuracy => &["methods", "relative_tolerances", "repetitions"],
        }
    }

    /// The kind of a request.
    pub fn of(request: &Value) -> Result<Self, FieldError> {
        let refuse = |detail: String| Err(FieldError::new("/kind", detail));
        let Some(fields) = request.as_object() else {
            let batch = "; several jobs are a batch, `{\"jobs\": […]}`";
            let detail = format!("must be an object{}", if request.is_array() { batch } else { "" });
            return Err(FieldError::new("", detail));
        };
        let known = listed(Self::ALL.map(Self::name));
        match fields.get("kind") {
            None => refuse(format!("required, but missing; kinds are {known}")),
            Some(Value::String(name)) => match Self::ALL.iter().find(|kind| kind.name() == name) {
                Some(kind) => Ok(*kind),
                None => {
                    let name: String = name.chars().take(100).collect();
                    refuse(format!("unknown kind `{name}`; kinds are {known}"))
                }
            },
            Some(_) => refuse(format!("must be a string; kinds are {known}")),
        }
    }

    /// Refuses fields that only jobs of other kinds take.
    pub fn refuse_fields_of_other_kinds(self, request: &Value, defaults: &mut Defaults) {
        for field in FIELDS_OF_SOME_KINDS {
            if self.takes().contains(&field) || request.get(field).is_none() {
                continue;
            }
            let takers = Self::ALL.iter().filter(|kind| kind.takes().contains(&field));
            let takers: Vec<String> = takers.map(|kind| format!("`{}`", kind.name())).collect();
            let kinds = if takers.len() == 1 { "kind" } else { "kinds" };
            let detail = format!("goes with the {kinds} {}, not with `{}`", takers.join(" and "), self.name());
            defaults.refuse(format!("/{field}"), detail);
        }
    }
}
