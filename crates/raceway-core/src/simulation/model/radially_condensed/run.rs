//! Run of the radially condensed model, with the same recording as that of the full dynamics.
//!
//! Where steps are shorter than the interval of recorded values, the spindle's signals pass the low-pass filter of
//! `numerics/spectrum.rs`. Where steps are longer, `numerics/interpolation.rs` gives the values between them.

use super::equations::RadiallyCondensed;
use super::observer::{Observer, Schedule};
use super::stepping::Stepper;
use crate::numerics::ode::{IntegrationError, Statistics};
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::step_ratio::{MAX_STEPS_PER_VALUE, StepRatio};
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::kept_values;
use crate::simulation::recording::series::SeriesRecording;

/// Steps between two polls of `Control`.
const STEPS_PER_POLL: u64 = 256;
/// Refinement of the steps after a run that diverged [-].
const REFINEMENT: usize = 4;
/// Largest displacement [m] or velocity [m/s] of spindle and cage: beyond it the run has diverged.
const MAX_MOTION: f64 = 1.0;

/// Simulates a scene on this model level. Deterministic: the same arguments give the same bits.
pub fn simulate(
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    run(&RadiallyCondensed::new(scene, &settings.outputs)?, settings, control)
}

/// Simulates a scene with the spindle displaced from its equilibrium by (y, z) [m] at the start, without spectra and series.
pub(crate) fn simulate_perturbed(
    scene: &Scene,
    displacement: [f64; 2],
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    let model = RadiallyCondensed::new(scene, &settings.outputs)?.displaced(displacement);
    let outputs = settings.outputs.without_signals();
    run(&model, &RunSettings { outputs, ..settings.clone() }, control)
}

fn run(
    model: &RadiallyCondensed,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    let mut ratio = model.step_ratio_for(settings);
    loop {
        if ratio.steps > MAX_STEPS_PER_VALUE {
            let reason = Inapplicable::FastMotion { step: ratio.step() };
            return Err(SimulationError::NotApplicable { rung: "radially_condensed", reason });
        }
        match model.run(settings, ratio, control) {
            // Later events, such as balls that hit their pocket walls as the speed changes, cannot be predicted. Finer steps are tried only
            // where no other model level can replace this one, which would be faster.
            Err(SimulationError::Integration { .. }) if settings.rung.is_some() && settings.fixed_step.is_none() => {
                ratio = StepRatio::of_steps(REFINEMENT * ratio.steps);
            }
            ended => return ended,
        }
    }
}

impl RadiallyCondensed {
    /// Runs from equilibrium through settling and recorded time.
    pub fn run(
        &self,
        settings: &RunSettings,
        ratio: StepRatio,
        control: &Control<'_>,
    ) -> Result<(Recording, Statistics), SimulationError> {
        let step = ratio.step();
        let values = kept_values(settings.duration);
        // The first recorded value is at the end of a step: the run starts later by a part of a step.
        let before = (settings.settle / step).floor();
        let offset = settings.settle - before * step;
        let (balls, border) = self.start();
        let mut stepper = Stepper::new(self, offset, balls, border, step);
        let first = (before as u64).max(stepper.steps());
        let last = first + ((values - 1) * ratio.steps).div_ceil(ratio.values) as u64;
        let delay = ratio.delay();
        let schedule = Schedule { ratio, first, last, values, delay };
        // A run without settling time has no past for the filter, which then starts from a standstill.
        let primed = first < stepper.steps() + delay as u64;
        let series = SeriesRecording::begin(&settings.outputs, control);
        let mut observer = Observer::new(self, &settings.outputs, schedule, primed, series);
        let all = last + delay as u64 + 1;
        while stepper.steps() < all {
            if (control.stop)() {
                return Err(SimulationError::Stopped { time: stepper.time() });
            }
            stepper.advance(STEPS_PER_POLL.min(all - stepper.steps()), &mut observer);
            finite(&stepper)?;
            let [y, z] = stepper.border().spindle;
            if let Some(departure) = self.mechanism().departure([0.0, y, z], [0.0; 2]) {
                return Err(SimulationError::SpindleLeft { time: stepper.time(), departure });
            }
            (control.progress)(stepper.steps() as f64 / all as f64);
            let phase = if stepper.steps() < first { Phase::Settling } else { Phase::Recording };
            (control.live)(&Live { phase, accelerations: &|| observer.accelerations() });
        }
        let statistics = Statistics {
            steps: stepper.steps(),
            rhs_evaluations: stepper.evaluations(),
            least_step: step,
            advanced: stepper.time() - offset,
            ..Statistics::default()
        };
        Ok((observer.finish(settings.settle), statistics))
    }
}

fn finite(stepper: &Stepper<'_>) -> Result<(), SimulationError> {
    let border = stepper.border();
    let moved = border.spindle.iter().chain(&border.spindle_velocity).chain(&border.cage);
    if moved.into_iter().any(|x| x.is_nan() || x.abs() > MAX_MOTION) {
        let source = IntegrationError::NotFinite { time: stepper.time(), step: stepper.step_length(), component: 0 };
        return Err(SimulationError::Integration { source, entry: "spindle or cage, radially condensed".into() });
    }
    Ok(())
}
