//! What a run on this rung leaves behind: the same recording as that of the full dynamics.
//!
//! Where steps are shorter than the interval of the kept values, the spindle's signals pass the low-pass filter of
//! `numerics/spectrum.rs` on their way to it; where they are longer, values between steps come from `numerics/interpolation.rs`.

use super::equations::RadiallyCondensed;
use super::observer::{Observer, Schedule};
use super::stepping::Stepper;
use crate::numerics::ode::{IntegrationError, Statistics};
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::step_ratio::{MAX_STEPS_PER_VALUE, StepRatio};
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::kept_values;

/// Steps between two looks at `Control`.
const STEPS_PER_LOOK: u64 = 256;
/// So many times as many steps are tried where the motion is lost.
const FINER: usize = 4;
/// A spindle or cage beyond this is lost [m, m/s].
const FARTHEST: f64 = 1.0;

/// Simulates a scene on this rung. Deterministic: the same arguments give the same bits.
pub fn simulate(
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    run(&RadiallyCondensed::new(scene, &settings.outputs)?, settings, control)
}

/// The same with the spindle starting a little beside its equilibrium (y, z) [m], and nothing kept that is asked for as a
/// spectrum or a series.
pub fn simulate_perturbed(
    scene: &Scene,
    displacement: [f64; 2],
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    let model = RadiallyCondensed::new(scene, &settings.outputs)?.displaced(displacement);
    let outputs = Outputs { spectra: Vec::new(), series: Vec::new(), ..settings.outputs.clone() };
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
            let reason =
                format!("spindle, cage or traction are too quick for it: they need steps of {:.1e} s", ratio.step());
            return Err(SimulationError::NotApplicable { rung: "radially_condensed", reason });
        }
        match model.run(settings, ratio, control) {
            // What comes later in a run, such as balls thrown against their walls by a changing speed, is not foreseen. Where another
            // rung can follow, it is the quicker way out.
            Err(SimulationError::Integration { .. }) if settings.rung.is_some() && settings.fixed_step.is_none() => {
                ratio = StepRatio::of_steps(FINER * ratio.steps);
            }
            ended => return ended,
        }
    }
}

impl RadiallyCondensed {
    /// Runs from equilibrium through settling and kept time.
    pub fn run(
        &self,
        settings: &RunSettings,
        ratio: StepRatio,
        control: &Control<'_>,
    ) -> Result<(Recording, Statistics), SimulationError> {
        let step = ratio.step();
        let values = kept_values(settings.duration);
        // The first kept value falls on a step: the part of a step before that is a short start.
        let before = (settings.settle / step).floor();
        let offset = settings.settle - before * step;
        let (balls, border) = self.start();
        let mut stepper = Stepper::new(self, offset, balls, border, step);
        let first = (before as u64).max(stepper.steps());
        let last = first + ((values - 1) * ratio.steps).div_ceil(ratio.values) as u64;
        let delay = ratio.delay();
        let schedule = Schedule { ratio, first, last, values, delay };
        // A run without time to settle has no past for the filter: it starts from a standstill then.
        let primed = first < stepper.steps() + delay as u64;
        let mut observer = Observer::new(self, &settings.outputs, schedule, primed);
        let all = last + delay as u64 + 1;
        while stepper.steps() < all {
            if (control.stop)() {
                return Err(SimulationError::Stopped { time: stepper.time() });
            }
            stepper.advance(STEPS_PER_LOOK.min(all - stepper.steps()), &mut observer);
            finite(&stepper)?;
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
    if moved.into_iter().any(|x| x.is_nan() || x.abs() > FARTHEST) {
        let source = IntegrationError::NotFinite { time: stepper.time(), step: stepper.step_length(), component: 0 };
        return Err(SimulationError::Integration { source, entry: "spindle or cage, radially condensed".into() });
    }
    Ok(())
}
