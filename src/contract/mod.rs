//! JSON in and out: requests become checked jobs, jobs become results as JSON. Each field carries its unit in its name and is
//! converted once, here. Knows the simulation and studies; knows no HTTP, no SQL and no thread.

pub mod run;

pub mod answer;

pub mod job;

pub mod scene;

pub(crate) mod json;

pub use answer::failure::RunFailure;
pub use answer::machine::{MachineAnswer, MachineOutcome};
pub use answer::machine_plan::MachinePlanAnswer;
pub use answer::measured::MeasuredAnswer;
pub use answer::measured_comparison::{Prediction, unit_factor};
pub use answer::metrics::{ChannelAnswer, LineAnswer, Metrics};
pub use answer::optimum::OptimumAnswer;
pub use answer::point::{PointEnd, PointStatus};
pub use answer::propagation::UncertaintyAnswer;
pub use answer::resolve::{ResolveAnswer, resolve_answer};
pub use answer::rotor::RotorAnswer;
pub use answer::signals::{SeriesAnswer, SeriesHead, SpectrumAnswer, SpectrumKind, Thinning};
pub use answer::table::{Row, TableAnswer};
pub use answer::views::ViewsAnswer;
pub use answer::work_precision::modes::{AccuracyJobAnswer, ModePrecisionAnswer};
pub use answer::work_precision::result::WorkPrecisionAnswer;
pub use job::checked::Job;
pub use job::cost::estimate;
pub use job::kind::JobKind;
pub use job::measurement::{Measurement, MeasurementRequest};
pub use job::parse::{
    parse_accuracy_request, parse_batch, parse_job, parse_job_or_scene, parse_job_with, parse_machine_request,
    parse_optimum_request, parse_rotor_request, parse_scene_request, parse_scene_request_with, parse_study_request,
};
pub use job::simulation::Simulation;
pub use job::study::Study;
pub use json::problem::{FieldError, Refusal};
pub use json::uploads::{Uploads, is_content_hash, named_series};
pub use run::{
    Outcome, Simulated, execute, execute_point, execute_rotor, execute_simulation, plan_machine, scene_from_json,
};
pub use scene::catalogue::{CatalogueAnswer, CatalogueSearch, catalogue_answer};
pub use scene::presets::presets_answer;

#[cfg(test)]
mod tests;
