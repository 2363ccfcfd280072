//! One run of one candidate.

use std::cell::OnceCell;

use crate::numerics::ode::stability::UnstableStep;
use crate::numerics::ode::{Choice, Integrator, Method, Statistics};
use crate::simulation::error::comparison::Deviation;
use crate::simulation::error::thresholds::MIN_WINDOW_S;
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::{STEPS_PER_LOOK, Span, Stepping, integrate};
use crate::simulation::model::observer::Observer;
use crate::simulation::model::radially_condensed::{self, RadiallyCondensed};
use crate::simulation::model::system::Model;
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::model::{periodic, spindle_only};
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::series::SeriesRecording;
use crate::simulation::solve::eligibility::{active_terms, window_times};
use crate::simulation::solve::plan::{Candidate, CandidateSteps};
use crate::simulation::solve::startup::{InitialState, StartupPhase};

/// First-order states of the models of the spindle alone.
const SPINDLE_STATES: usize = 4;
/// Least number of evaluations of a run when the limit of another run is a multiple of them.
pub(crate) const MIN_EVALUATIONS: u64 = 10_000;
/// Share of the tolerance by which a longer step of the condensed model may move its levels over a window [-]; *drawn*.
const STEP_SHARE: f64 = 0.5;

/// A scene to solve, and the state shared by its candidates.
pub(crate) struct Problem<'a> {
    pub scene: &'a Scene,
    pub settings: &'a RunSettings,
    /// Steps of the start-up phase; `None`: the longest fixed steps that do not diverge.
    startup: Option<Stepping>,
    dynamics: OnceCell<Dynamics>,
}

/// The dynamics of a scene after the shared start-up phase.
pub(crate) struct Dynamics {
    pub model: Model,
    pub terms: ActiveTerms,
    pub start: InitialState,
}

/// The whole run of one candidate.
pub(crate) struct Attempt {
    pub recording: Recording,
    pub work: Statistics,
    pub states: usize,
    pub strips: usize,
    /// Name of the integrator.
    pub method: &'static str,
    /// Relative tolerance [-] under error control.
    pub tolerance: Option<f64>,
    /// Fixed step [s].
    pub step: Option<f64>,
    /// Deviation over a window of the condensed model in longer steps from the same model in its own step.
    pub step_deviation: Option<Deviation>,
    /// States of a run of the dynamics, for later runs.
    pub trajectory: Option<Trajectory>,
}

/// States of a run of the dynamics.
pub(crate) struct Trajectory {
    /// State at the beginning of the recorded time.
    pub checkpoint: Vec<f64>,
    pub end: Vec<f64>,
    pub choice: Choice,
    pub unstable: Option<UnstableStep>,
}

impl<'a> Problem<'a> {
    pub fn new(scene: &'a Scene, settings: &'a RunSettings) -> Self {
        Self { scene, settings, startup: None, dynamics: OnceCell::new() }
    }

    /// True if the spindle moves along the axis or is tilted, so that light oscillations have little damping.
    pub fn has_axial_motion_or_tilt(&self) -> bool {
        self.dynamics.get().is_some_and(|dynamics| dynamics.model.mechanism().has_axial_motion_or_tilt())
    }

    /// Makes the later attempts share a start-up phase in other steps. Slow vibration that rejected steps have excited outlasts the rest
    /// of the settling time, and no repetition from their start would show it.
    pub fn start_in(&mut self, stepping: Stepping) {
        self.startup = Some(stepping);
        self.dynamics.take();
    }

    /// The dynamics after the start-up phase, computed once.
    pub fn dynamics(&self, control: &Control<'_>) -> Result<&Dynamics, SimulationError> {
        if let Some(dynamics) = self.dynamics.get() {
            return Ok(dynamics);
        }
        let terms = active_terms(self.scene, &self.settings.outputs, self.settings.rung)?;
        let model = Model::new(self.scene, &terms);
        let phase = StartupPhase::of(self.scene, &model, self.settings);
        let start = InitialState::after_in(&phase, self.startup, &model, control)?;
        Ok(self.dynamics.get_or_init(|| Dynamics { model, terms, start }))
    }
}

/// Runs a candidate over the whole time.
pub(crate) fn execute(
    candidate: &Candidate,
    problem: &Problem<'_>,
    most_evaluations: Option<u64>,
    control: &Control<'_>,
) -> Result<Attempt, SimulationError> {
    let settings = problem.settings;
    match candidate.stepping {
        CandidateSteps::Own(step) => reduced(candidate.level, step, problem, control),
        CandidateSteps::Fixed(method, step) => {
            let stepping = Stepping { method, fixed_step: Some(step), most_evaluations, ..Stepping::of(settings) };
            let in_steps = RunSettings { method, fixed_step: Some(step), ..settings.clone() };
            run(problem.dynamics(control)?, &in_steps, &stepping, control)
        }
        CandidateSteps::Controlled(method, relative_tolerance) => {
            let stepping = Stepping { method, relative_tolerance, fixed_step: None, most_evaluations };
            run(problem.dynamics(control)?, settings, &stepping, control)
        }
    }
}

/// A run of the dynamics from their initial state.
pub(crate) fn run(
    dynamics: &Dynamics,
    settings: &RunSettings,
    stepping: &Stepping,
    control: &Control<'_>,
) -> Result<Attempt, SimulationError> {
    run_from(dynamics, &dynamics.start, settings, stepping, control)
}

/// A run of the dynamics from a state.
pub(crate) fn run_from(
    dynamics: &Dynamics,
    start: &InitialState,
    settings: &RunSettings,
    stepping: &Stepping,
    control: &Control<'_>,
) -> Result<Attempt, SimulationError> {
    let Dynamics { model, terms, .. } = dynamics;
    let series = SeriesRecording::begin(&settings.outputs, control);
    let mut observer = Observer::new(model, terms, settings).with_series(series);
    let settle = settings.settle;
    let span = Span { start: start.time, end: observer.end(), checkpoint: settle, share: (0.0, 1.0) };
    let mut steps = 0_u64;
    let after_step = |step: &dyn Integrator| {
        observer.after(step);
        steps += 1;
        if steps.is_multiple_of(STEPS_PER_LOOK) {
            let phase = if step.time() < settle { Phase::Settling } else { Phase::Recording };
            (control.live)(&Live { phase, accelerations: &|| observer.accelerations() });
        }
    };
    let integrated = integrate(model, &start.state, stepping, &span, control, after_step)?;
    Ok(Attempt {
        recording: observer.finish(),
        work: start.work.and(&integrated.statistics),
        states: model.mechanism().layout.dimension(),
        strips: terms.raceway.strips,
        method: integrated.choice.method.name(),
        tolerance: stepping.fixed_step.is_none().then_some(stepping.relative_tolerance),
        step: stepping.fixed_step,
        step_deviation: None,
        trajectory: Some(Trajectory {
            checkpoint: integrated.checkpoint,
            end: integrated.end,
            choice: integrated.choice,
            unstable: integrated.unstable,
        }),
    })
}

/// The run of a reduced model.
fn reduced(
    level: ModelLevel,
    step: Option<f64>,
    problem: &Problem<'_>,
    control: &Control<'_>,
) -> Result<Attempt, SimulationError> {
    let Problem { scene, settings, .. } = *problem;
    let strips = active_terms(scene, &settings.outputs, Some(level))?.raceway.strips;
    let trial = match (level, step) {
        (ModelLevel::RadiallyCondensed, None) if scene.operation.is_steady() => {
            longer_step(scene, settings, &Control::until(control.stop))
        }
        _ => None,
    };
    let step = step.or(trial.as_ref().map(|(step, _)| *step));
    let stepped = RunSettings { fixed_step: step, ..settings.clone() };
    let (recording, work) = record(level, scene, &stepped, control)?;
    let (states, method) = match level {
        ModelLevel::Periodic => (SPINDLE_STATES, "shooting"),
        ModelLevel::SpindleOnly => (SPINDLE_STATES, "adams_moulton"),
        _ => (RadiallyCondensed::new(scene, &settings.outputs)?.states(), Method::SemiImplicit.name()),
    };
    let step_deviation = trial.map(|(_, deviation)| deviation);
    Ok(Attempt { recording, work, states, strips, method, tolerance: None, step, step_deviation, trajectory: None })
}

/// Records a run of a reduced model.
pub(crate) fn record(
    level: ModelLevel,
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    match level {
        ModelLevel::Periodic => periodic::simulate(scene, settings, control),
        ModelLevel::SpindleOnly => spindle_only::simulate(scene, settings, control),
        _ => radially_condensed::simulate(scene, settings, control),
    }
}

/// The longest step of the condensed model [s] that reproduces the levels of its own step over a window, and its deviation from that step.
fn longer_step(scene: &Scene, settings: &RunSettings, control: &Control<'_>) -> Option<(f64, Deviation)> {
    let model = RadiallyCondensed::new(scene, &settings.outputs).ok()?;
    let short = window_settings(scene, settings);
    let own = OnceCell::new();
    model.longer_step_ratios().find_map(|step_ratio| {
        let own = own.get_or_init(|| model.run(&short, model.step_ratio(), control).ok()).as_ref()?;
        let (stepped, _) = model.run(&short, step_ratio, control).ok()?;
        let deviation = Deviation::of_recordings(&stepped, &own.0, 0.0);
        deviation
            .within(&short.outputs, STEP_SHARE * short.model_tolerance_db)
            .then(|| (step_ratio.step(), deviation.of_asked(&short.outputs)))
    })
}

/// A short run for a verification of the condensed model, no longer than the run itself.
pub(crate) fn window_settings(scene: &Scene, settings: &RunSettings) -> RunSettings {
    let (settle, window) = window_times(scene, settings);
    RunSettings {
        method: Method::Auto,
        fixed_step: None,
        settle: settle.min(settings.settle),
        duration: window.min(settings.duration.max(MIN_WINDOW_S)),
        outputs: settings.outputs.without_signals(),
        ..settings.clone()
    }
}
