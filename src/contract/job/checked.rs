//! A checked job of any kind.

use raceway_core::numerics::spectrum::EnvelopeAnalysis;
use raceway_core::simulation::input::scene::Scene;
use serde_json::Value;

use super::comparison::Comparison;
use super::kind::JobKind;
use super::machine::MachineJob;
use super::mode_comparison::ModeComparison;
use super::orders::{OrderRequest, OrdersInput};
use super::recorded_turns::RecordedTurns;
use super::rotor::RotorJob;
use super::search::Search;
use super::simulation::Simulation;
use super::study::Study;
use super::submission::Submission;
use super::uncertainty::Uncertainty;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::{FieldError, Refusal};
use crate::contract::json::uploads::Uploads;
use crate::contract::scene::single_bearing::with_single_bearing;

/// A checked job.
#[derive(Debug, Clone, PartialEq)]
pub enum Job {
    Simulation(Simulation),
    Study(Study),
    Optimum(Search),
    Uncertainty(Box<Uncertainty>),
    Accuracy(Comparison),
    /// An accuracy job of a shaft.
    Modes(Box<ModeComparison>),
    Rotor(Box<RotorJob>),
    Machine(Box<MachineJob>),
}

impl Job {
    /// Checks a request, whose field `kind` decides the kind of the job.
    pub fn of(request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let kind = JobKind::of(&request)?;
        match kind {
            JobKind::Accuracy if request.pointer("/scene/shaft").is_some() => {
                ModeComparison::of(request, uploads).map(|job| Self::Modes(Box::new(job)))
            }
            JobKind::Simulation | JobKind::Study | JobKind::Optimum | JobKind::Uncertainty | JobKind::Accuracy => {
                with_single_bearing(request, |request| Self::of_one_bearing(kind, request, uploads))
            }
            JobKind::Rotor => RotorJob::of(request, uploads).map(|job| Self::Rotor(Box::new(job))),
            JobKind::Machine => MachineJob::of(request, uploads).map(|job| Self::Machine(Box::new(job))),
        }
    }

    /// Checks a request whose scene has one bearing.
    fn of_one_bearing(kind: JobKind, request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        match kind {
            JobKind::Study => Study::of(request, uploads).map(Self::Study),
            JobKind::Optimum => Search::of(request, uploads).map(Self::Optimum),
            JobKind::Uncertainty => Uncertainty::of(request, uploads).map(|job| Self::Uncertainty(Box::new(job))),
            JobKind::Accuracy => Comparison::of(request, uploads).map(Self::Accuracy),
            JobKind::Simulation | JobKind::Rotor | JobKind::Machine => {
                Simulation::of(request, uploads).map(Self::Simulation)
            }
        }
    }

    /// Number of runs that a submission asks for: the points of a study or an uncertainty job, else 1.
    pub fn cost(&self) -> usize {
        self.points().map_or(1, |study| study.points)
    }

    /// The points of a job that is run point by point.
    pub fn points(&self) -> Option<&Study> {
        match self {
            Self::Study(study) => Some(study),
            Self::Uncertainty(job) => Some(&job.study),
            _ => None,
        }
    }

    pub fn kind(&self) -> JobKind {
        match self {
            Self::Simulation(_) => JobKind::Simulation,
            Self::Study(_) => JobKind::Study,
            Self::Optimum(_) => JobKind::Optimum,
            Self::Uncertainty(_) => JobKind::Uncertainty,
            Self::Accuracy(_) | Self::Modes(_) => JobKind::Accuracy,
            Self::Rotor(_) => JobKind::Rotor,
            Self::Machine(_) => JobKind::Machine,
        }
    }

    /// The simulation itself, or what all runs of the job share; `None` for jobs whose scene is that of a shaft.
    pub fn base(&self) -> Option<&Simulation> {
        match self {
            Self::Simulation(simulation) => Some(simulation),
            Self::Study(study) => Some(&study.base),
            Self::Optimum(search) => Some(&search.base),
            Self::Uncertainty(job) => Some(&job.study.base),
            Self::Accuracy(comparison) => Some(&comparison.base),
            Self::Modes(_) | Self::Rotor(_) | Self::Machine(_) => None,
        }
    }

    pub fn submission(&self) -> &Submission {
        match self {
            Self::Simulation(simulation) => &simulation.submission,
            Self::Study(study) => &study.base.submission,
            Self::Optimum(search) => &search.base.submission,
            Self::Uncertainty(job) => &job.study.base.submission,
            Self::Accuracy(comparison) => &comparison.base.submission,
            Self::Modes(comparison) => &comparison.submission,
            Self::Rotor(rotor) => &rotor.submission,
            Self::Machine(machine) => &machine.submission,
        }
    }

    /// The scene of the simulations; `None` for jobs of shafts.
    pub fn scene(&self) -> Option<&Scene> {
        self.base().map(Simulation::scene)
    }

    /// The scene with all defaults, as in a request.
    pub fn scene_json(&self) -> Value {
        match self.base() {
            Some(base) => base.scene_json(),
            None => self.complete()["scene"].take(),
        }
    }

    /// The points of a job that is run point by point.
    pub fn into_study(self) -> Option<Study> {
        match self {
            Self::Study(study) => Some(study),
            Self::Uncertainty(job) => Some(job.study),
            _ => None,
        }
    }

    /// Number of simulations of a study or an uncertainty job, and the approximate largest number of an optimum job; `None` for other kinds.
    pub fn simulations(&self) -> Option<usize> {
        match self {
            Self::Study(study) => Some(study.points),
            Self::Optimum(search) => Some(search.most_runs()),
            Self::Uncertainty(job) => Some(job.study.points),
            Self::Simulation(_) | Self::Accuracy(_) | Self::Modes(_) | Self::Rotor(_) | Self::Machine(_) => None,
        }
    }

    /// Recorded turns, where the first value lies at a time [s]; `None` for kinds without series.
    pub fn recorded_turns(&self, start: f64) -> Option<RecordedTurns> {
        match self {
            Self::Simulation(run) => Some(RecordedTurns::of(run.scene(), run.settings.settle, run.settings.duration)),
            Self::Machine(run) => Some(RecordedTurns::of_machine(&run.machine, start, run.settings.duration)),
            Self::Study(_)
            | Self::Optimum(_)
            | Self::Uncertainty(_)
            | Self::Accuracy(_)
            | Self::Modes(_)
            | Self::Rotor(_) => None,
        }
    }

    /// The analysed envelope of a run with spectra.
    pub fn envelope(&self) -> Option<EnvelopeAnalysis> {
        match self {
            Self::Simulation(run) => Some(run.settings.outputs.envelope),
            Self::Machine(run) => Some(run.settings.envelope),
            Self::Study(_)
            | Self::Optimum(_)
            | Self::Uncertainty(_)
            | Self::Accuracy(_)
            | Self::Modes(_)
            | Self::Rotor(_) => None,
        }
    }

    /// An order analysis by the given settings, and by those of the request for the others. The pointers of errors are those of a request.
    pub fn orders(&self, given: OrdersInput, run: &RecordedTurns) -> Result<OrderRequest, Vec<FieldError>> {
        let requested = self.submission().request.pointer("/outputs/orders").cloned();
        let requested = requested.and_then(|orders| serde_json::from_value(orders).ok()).unwrap_or_default();
        let mut defaults = Defaults::default();
        let orders = given.or(requested).resolve(run, &mut defaults);
        orders.ok_or(defaults.errors)
    }

    /// The channel whose orders are analysed where none is named; `None` where no orders were requested.
    pub fn first_channel(&self) -> Option<&str> {
        let orders = match self {
            Self::Simulation(simulation) => simulation.outputs.orders.as_ref(),
            Self::Machine(machine) => machine.input.outputs.as_ref().and_then(|outputs| outputs.orders.as_ref()),
            Self::Study(_)
            | Self::Optimum(_)
            | Self::Uncertainty(_)
            | Self::Accuracy(_)
            | Self::Modes(_)
            | Self::Rotor(_) => None,
        };
        orders?.channels.as_ref()?.first().map(String::as_str)
    }

    /// Everything that determines the result, as text: equal for equal work, whichever fields were left to their default.
    pub fn canonical(&self) -> String {
        match self {
            Self::Simulation(simulation) => simulation.canonical(),
            Self::Study(study) => study.canonical().to_string(),
            Self::Optimum(search) => search.canonical().to_string(),
            Self::Uncertainty(job) => job.canonical().to_string(),
            Self::Accuracy(comparison) => comparison.complete().to_string(),
            Self::Modes(comparison) => comparison.complete().to_string(),
            Self::Rotor(rotor) => rotor.complete().to_string(),
            Self::Machine(machine) => machine.complete().to_string(),
        }
    }

    /// The job with all defaults, without axes, metrics, goal and inputs, and without the fields that concern only the service.
    pub fn complete(&self) -> Value {
        let mut job = match self {
            Self::Accuracy(comparison) => return comparison.complete(),
            Self::Modes(comparison) => return comparison.complete(),
            Self::Rotor(rotor) => return rotor.complete(),
            Self::Machine(machine) => return machine.complete(),
            Self::Simulation(simulation) => simulation.complete(),
            Self::Study(study) => study.base.complete(),
            Self::Optimum(search) => search.base.complete(),
            Self::Uncertainty(job) => job.study.base.complete(),
        };
        job["kind"] = self.kind().name().into();
        job
    }
}
