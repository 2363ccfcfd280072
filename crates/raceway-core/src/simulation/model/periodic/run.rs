//! The periodic motion, extended over the recorded time.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::applicability::inapplicability;
use super::passage::{Passage, Signals, steady};
use crate::numerics::ode::Statistics;
use crate::numerics::statistics::rms;
use crate::simulation::input::control::Control;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::spindle_only::{recording, scene_model};
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::{RATE, SPINDLE_IN_PLANE, kept_values};
use crate::simulation::recording::series::SeriesRecording;
use crate::simulation::recording::windows::{Recorder, Windows};

/// Values of an extended motion between two polls of `Control`.
const VALUES_PER_POLL: usize = 1 << 14;
/// Points of the Fourier series for each integrated point.
const REFINEMENT: usize = 8;

/// Simulates a scene on the model level `periodic`.
pub fn simulate(
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    let (model, mechanism) = scene_model(scene, settings, "periodic", inapplicability)?;
    if (control.stop)() {
        return Err(SimulationError::Stopped { time: 0.0 });
    }
    let passage = steady(&model)?;
    // The motion repeats: one window shows all of it, unless a series shows every value.
    let all = kept_values(settings.duration);
    let values =
        if settings.outputs.series.is_empty() { Windows::of(all, settings.outputs.longest_window).length } else { all };
    let mut recorder = Recorder::new(SPINDLE_IN_PLANE, &settings.outputs, values)
        .with_series(SeriesRecording::begin(&settings.outputs, control));
    passage.repeated(settings.settle, values, control, |frame| recorder.push(frame))?;
    let total = std::array::from_fn(|i| rms(&passage.signals[i]).powi(2));
    let recording = recording(&model, &mechanism, settings.settle, settings.duration, recorder, Some(total));
    Ok((recording, passage.statistics))
}

impl Passage {
    /// Passes a number of values of the motion at `RATE` to `keep`; `start`: time of the first one [s].
    fn repeated(
        &self,
        start: f64,
        values: usize,
        control: &Control<'_>,
        mut keep: impl FnMut(&[f64; 6]),
    ) -> Result<(), SimulationError> {
        let fine = self.finer();
        let n = fine[0].len();
        let per_value = n as f64 / (RATE * self.length);
        let first = start / self.length * n as f64;
        // All signals share places and weights: cubic polynomials through four of the fine points.
        let mut place = first.rem_euclid(n as f64);
        for value in 0..values {
            if value.is_multiple_of(VALUES_PER_POLL) {
                if (control.stop)() {
                    return Err(SimulationError::Stopped { time: start + value as f64 / RATE });
                }
                (control.progress)(value as f64 / values as f64);
            }
            let whole = place as usize;
            let x = place - whole as f64;
            let (below, above, over) = (x + 1.0, 1.0 - x, 2.0 - x);
            let weights =
                [-x * above * over / 6.0, 0.5 * below * above * over, 0.5 * x * below * over, -x * below * above / 6.0];
            let at = [whole + n - 1, whole, whole + 1, whole + 2].map(|i| i % n);
            keep(&fine.each_ref().map(|fine| (0..4).map(|k| weights[k] * fine[at[k]]).sum()));
            place += per_value;
            if place >= n as f64 {
                place -= n as f64;
            }
        }
        Ok(())
    }

    /// Every signal at `REFINEMENT` times as many points, by its Fourier series.
    fn finer(&self) -> Signals {
        let n = self.signals[0].len();
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, backward) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(REFINEMENT * n));
        std::array::from_fn(|i| {
            let (mut coarse, mut fine) = (forward.make_output_vec(), backward.make_output_vec());
            let mut signal = self.signals[i].clone();
            let mut padded = backward.make_input_vec();
            let _ = forward.process(&mut signal, &mut coarse);
            for (to, from) in padded.iter_mut().zip(&coarse) {
                *to = from / n as f64;
            }
            if n.is_multiple_of(2) {
                padded[n / 2] = Complex::new(0.5 * padded[n / 2].re, 0.0);
            }
            let _ = backward.process(&mut padded, &mut fine);
            fine
        })
    }
}
