//! JSON in and out: requests become checked scenes and settings, results become answers. Every field
//! carries its unit in its name and is converted once, here. Knows physics and simulation; knows no
//! HTTP, no SQL and no thread.

pub mod problem;

pub mod bearing;
pub mod cage;
pub mod damping;
pub mod job;
pub mod lubricant;
pub mod material;
pub mod operation;
pub mod optimum;
pub mod outputs;
pub mod presets;
pub mod scene;
pub mod solver;
pub mod spindle;
pub mod study;
pub mod terms;

pub mod execute;
pub mod in_words;
pub mod machine;
pub mod messages;
pub mod metrics;
pub mod recommended;
pub mod report;
pub mod resolve;
pub mod signals;
pub mod table;
pub mod views;
pub mod work_precision;

mod accuracy;
mod cost;
mod filling;
mod limits;
mod plausible;
pub mod schema;
mod strict;
mod times;
pub(crate) mod units;
mod variation;
mod words;

pub use cost::estimate;
pub use execute::{Outcome, RunFailure, Simulated, execute, execute_point};
pub use job::{
    Job, JobKind, parse_accuracy_request, parse_batch, parse_job, parse_job_or_scene, parse_optimum_request,
    parse_scene_request, parse_study_request,
};
pub use metrics::{ChannelAnswer, LineAnswer, Metrics};
pub use optimum::OptimumAnswer;
pub use presets::presets_answer;
pub use problem::{FieldError, Refusal};
pub use resolve::{ResolveAnswer, resolve_answer};
pub use signals::{SeriesAnswer, SpectrumAnswer, SpectrumKind};
pub use strict::{MOST_FAULTS, NameOr};
pub use study::Study;
pub use table::{PointEnd, PointStatus, Row, TableAnswer};
pub use views::ViewsAnswer;
pub use work_precision::WorkPrecisionAnswer;

use serde::Serialize;
use serde_json::Value;

use crate::simulation::input::scene::Scene;

/// Builds a scene from JSON: a scene, `{ "scene": … }`, or a whole job.
pub fn scene_from_json(text: &str) -> Result<Scene, Refusal> {
    parse_job_or_scene(text.as_bytes()).map(|job| job.resolved.scene)
}

/// The JSON of an input type, fields that are left out absent.
pub(crate) fn given_fields(input: &impl Serialize) -> Value {
    fn prune(value: &mut Value) {
        match value {
            Value::Object(fields) => {
                fields.retain(|_, field| !field.is_null());
                fields.values_mut().for_each(prune);
            }
            Value::Array(items) => items.iter_mut().for_each(prune),
            _ => {}
        }
    }
    // Input types have string keys only, so that this never fails.
    let mut value = serde_json::to_value(input).unwrap_or_default();
    prune(&mut value);
    value
}

#[cfg(test)]
mod tests;
