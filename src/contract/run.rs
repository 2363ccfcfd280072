//! Runs a checked job.

use raceway_core::machine::mode_precision;
use raceway_core::simulation::input::control::Control;
use raceway_core::simulation::input::scene::Scene;
use raceway_core::simulation::recording::spectra::ChannelSpectra;
use raceway_core::simulation::result::run_result::RunResult;
use raceway_core::simulation::result::series::Series;
use raceway_core::simulation::solve::run::simulate;
use raceway_core::simulation::work_precision;
use serde::Serialize;
use serde_json::Value;

use super::answer::failure::{INTERNAL, NUMERICAL_BLOWUP, RunFailure};
use super::answer::machine::MachineOutcome;
use super::answer::machine_plan::MachinePlanAnswer;
use super::answer::metrics::Metrics;
use super::answer::optimum::OptimumAnswer;
use super::answer::point::PointEnd;
use super::answer::rotor::RotorAnswer;
use super::answer::signals::{SpectrumAnswer, SpectrumKind, unit_of_envelope};
use super::answer::views::ViewsAnswer;
use super::answer::work_precision::modes::ModePrecisionAnswer;
use super::answer::work_precision::result::WorkPrecisionAnswer;
use super::job::checked::Job;
use super::job::machine::MachineJob;
use super::job::parse::parse_job_or_scene;
use super::job::rotor::RotorJob;
use super::job::simulation::{Simulation, varying_speed_rpm};
use super::json::problem::{FieldError, Refusal};

/// The result of a job, by its kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    Simulation(Box<Simulated>),
    Accuracy(Box<WorkPrecisionAnswer>),
    /// Of an accuracy job of a shaft.
    Modes(Box<ModePrecisionAnswer>),
    Optimum(Box<OptimumAnswer>),
    Rotor(Box<RotorAnswer>),
    Machine(Box<MachineOutcome>),
}

/// The result of a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    pub metrics: Metrics,
    /// Amplitude and envelope spectrum of each requested channel.
    pub spectra: Vec<SpectrumAnswer>,
    pub series: Vec<Series>,
    /// Data of the plots.
    pub views: ViewsAnswer,
    /// Least and greatest shaft speed of the recorded time [r/min]; `None` where it is constant.
    pub varying_speed_rpm: Option<[f64; 2]>,
}

impl Outcome {
    /// The result of a simulation; an internal failure for results of other kinds.
    pub fn into_simulated(self) -> Result<Simulated, RunFailure> {
        match self {
            Self::Simulation(simulated) => Ok(*simulated),
            Self::Accuracy(_) | Self::Modes(_) | Self::Optimum(_) | Self::Rotor(_) | Self::Machine(_) => {
                Err(internal("the result is not that of a simulation"))
            }
        }
    }
}

/// Runs a job. Every number of the result is finite.
pub fn execute(job: &Job, control: &Control<'_>) -> Result<Outcome, RunFailure> {
    match job {
        Job::Simulation(simulation) => Ok(Outcome::Simulation(Box::new(execute_simulation(simulation, control)?))),
        Job::Study(_) | Job::Uncertainty(_) => Err(internal("the job is run point by point")),
        Job::Optimum(search) => {
            // The progress of the search is counted in runs, not in the progress of each run.
            let of_run = Control::until(control.stop);
            let simulate = |simulation: Simulation| execute_simulation(&simulation, &of_run);
            let answer = OptimumAnswer::of(search, &|point| execute_point(point, &simulate), control)?;
            check_finite("optimum", &answer)?;
            Ok(Outcome::Optimum(Box::new(answer)))
        }
        Job::Accuracy(comparison) => {
            let base = &comparison.base;
            let study = work_precision::study(base.scene(), &base.settings, &comparison.plan, control)?;
            let answer = WorkPrecisionAnswer::of(comparison, &study);
            check_finite("accuracy", &answer)?;
            Ok(Outcome::Accuracy(Box::new(answer)))
        }
        Job::Modes(comparison) => {
            let found = mode_precision::compare(&comparison.machine, &comparison.plan, control)?;
            let answer = ModePrecisionAnswer::of(comparison, &found);
            check_finite("accuracy", &answer)?;
            Ok(Outcome::Modes(Box::new(answer)))
        }
        Job::Rotor(rotor) => Ok(Outcome::Rotor(Box::new(execute_rotor(rotor, control.stop)?))),
        Job::Machine(machine) => {
            let outcome = MachineOutcome::of(machine, control)?;
            check_finite("machine", &outcome.answer)?;
            let spectrum = outcome.spectra.iter().find(|spectrum| !spectrum.is_finite());
            let series = outcome.series.iter().find(|series| !series.is_finite);
            match (spectrum, series) {
                (None, None) => Ok(Outcome::Machine(Box::new(outcome))),
                (Some(spectrum), _) => Err(blowup(&format!("the spectrum of {}", spectrum.channel))),
                (None, Some(series)) => Err(blowup(&format!("the series of {}", series.head.channel))),
            }
        }
    }
}

/// Analyses a rotor until `stop` returns true. Every number of the result is finite.
pub fn execute_rotor(job: &RotorJob, stop: &dyn Fn() -> bool) -> Result<RotorAnswer, RunFailure> {
    let answer = RotorAnswer::of(job, stop)?;
    check_finite("rotor", &answer)?;
    Ok(answer)
}

/// Plans a machine job until `stop` returns true. Every number of the result is finite.
pub fn plan_machine(job: &MachineJob, stop: &dyn Fn() -> bool) -> Result<MachinePlanAnswer, RunFailure> {
    let answer = MachinePlanAnswer::of(job, stop)?;
    check_finite("machine", &answer)?;
    Ok(answer)
}

/// Runs a simulation. Every number of the result is finite.
pub fn execute_simulation(simulation: &Simulation, control: &Control<'_>) -> Result<Simulated, RunFailure> {
    let result = simulate(simulation.scene(), &simulation.settings, control)?;
    let simulated = simulated(simulation, result);
    match not_finite(&simulated) {
        None => Ok(simulated),
        Some(part) => Err(blowup(&part)),
    }
}

/// Runs one point of a study or a search by `simulate`; `None`: the run was cancelled.
pub fn execute_point(
    point: Result<Simulation, Refusal>,
    simulate: &dyn Fn(Simulation) -> Result<Simulated, RunFailure>,
) -> Option<PointEnd> {
    match point.map(simulate) {
        Err(refusal) => Some(PointEnd::Failed(refusal.into())),
        Ok(Ok(simulated)) => Some(PointEnd::of(&simulated.metrics)),
        Ok(Err(RunFailure::Cancelled)) => None,
        Ok(Err(failure)) => Some(PointEnd::Failed(failure.into())),
    }
}

fn internal(detail: &str) -> RunFailure {
    RunFailure::Failed { cause: INTERNAL, detail: detail.to_owned() }
}

fn blowup(part: &str) -> RunFailure {
    RunFailure::Failed { cause: NUMERICAL_BLOWUP, detail: format!("{part} is not finite") }
}

fn simulated(simulation: &Simulation, mut result: RunResult) -> Simulated {
    let series = std::mem::take(&mut result.series);
    let (solver, outputs) = (&result.summary.solver, &simulation.settings.outputs);
    let of_channel = |of: &ChannelSpectra| {
        let unit = of.channel.unit();
        let unit_of_envelope = unit_of_envelope(unit, outputs.envelope.kind);
        [
            (SpectrumKind::Amplitude, unit.to_owned(), &of.amplitude),
            (SpectrumKind::Envelope, unit_of_envelope, &of.envelope),
        ]
        .map(|(kind, unit, spectrum)| SpectrumAnswer::of((of.channel, unit), kind, spectrum, solver))
    };
    Simulated {
        metrics: Metrics::of(&result, simulation),
        spectra: result.spectra.iter().flat_map(of_channel).collect(),
        series,
        views: ViewsAnswer::of(&result.plot_data),
        varying_speed_rpm: varying_speed_rpm(&simulation.submission.request),
    }
}

fn check_finite(kind: &str, answer: &impl Serialize) -> Result<(), RunFailure> {
    null_of(answer).map_or(Ok(()), |pointer| Err(blowup(&format!("{kind} {pointer}"))))
}

/// The first part of the result that is not finite.
fn not_finite(outcome: &Simulated) -> Option<String> {
    let spectrum = || outcome.spectra.iter().find(|spectrum| !spectrum.is_finite()).map(|s| &s.channel);
    let series = || outcome.series.iter().find(|series| !series.is_finite).map(|s| s.channel);
    null_of(&outcome.metrics)
        .map(|pointer| format!("metric {pointer}"))
        .or_else(|| spectrum().map(|channel| format!("the spectrum of {channel}")))
        .or_else(|| series().map(|channel| format!("the series of {channel}")))
}

/// Pointer to the first number that is not finite. JSON has no infinities: serde_json writes them as null, and no other field of a
/// result is null.
fn null_of(answer: &impl Serialize) -> Option<String> {
    null_in(&serde_json::to_value(answer).unwrap_or_default(), "")
}

/// Pointer to the first null.
fn null_in(value: &Value, pointer: &str) -> Option<String> {
    match value {
        Value::Null => Some(pointer.to_owned()),
        Value::Array(items) => {
            items.iter().enumerate().find_map(|(index, item)| null_in(item, &format!("{pointer}/{index}")))
        }
        Value::Object(fields) => fields.iter().find_map(|(key, field)| null_in(field, &format!("{pointer}/{key}"))),
        _ => None,
    }
}

/// Builds a scene from JSON: a scene, `{ "scene": … }`, or a whole job.
pub fn scene_from_json(text: &str) -> Result<Scene, Refusal> {
    let job = parse_job_or_scene(text.as_bytes())?;
    job.scene().cloned().ok_or_else(|| {
        FieldError::new("/kind", "jobs of the kinds `rotor` and `machine` have no scene of one bearing").into()
    })
}
