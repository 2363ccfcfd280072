//! Run of the spindle alone in time, in fixed steps.

use super::applicability::inapplicability;
use super::equations::{Driven, SpindleMotion, SpindleOnly};
use super::recording::{recording, statistics};
use super::scene_model::scene_model;
use crate::numerics::interpolation::Interpolator;
use crate::numerics::lanes::{InstructionSet, Task};
use crate::numerics::ode::adams_moulton::AdamsMoulton;
use crate::numerics::ode::{IntegrationError, Statistics};
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::step_ratio::{MAX_STEPS_PER_VALUE, StepRatio};
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::{SPINDLE_IN_PLANE, kept_values};
use crate::simulation::recording::series::SeriesRecording;
use crate::simulation::recording::windows::Recorder;

/// Nodes of the Adams–Moulton method.
const NODES: usize = 7;
/// Largest product of the step with the frequency of the stiffest direction [rad], where levels err by up to 0.01 dB.
const MAX_PHASE: f64 = 0.6;
/// The longest step [s]: levels err by 0.01 dB at 19.5 µs, and by more at the next longer step.
const MAX_STEP: f64 = 20e-6;
/// Steps of one block: speed and finiteness are checked between blocks.
const STEPS_PER_BLOCK: usize = 64;
/// Relative change of speed after which the centrifugal force is updated [-].
const SPEED_CHANGE: f64 = 1e-3;
/// Values of one step, in the order of `SPINDLE_IN_PLANE`.
type Frame = [f64; SPINDLE_IN_PLANE.len()];

/// Simulates a scene on the model level `spindle_only`. `settings.fixed_step` bounds the step.
pub fn simulate(
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    let (mut model, mechanism) = scene_model(scene, settings, "spindle_only", inapplicability)?;
    let (rest, frequency) = model.rest();
    let longest = MAX_STEP.min(MAX_PHASE / frequency).min(model.longest_step());
    let ratio = StepRatio::of(settings.fixed_step.unwrap_or(longest));
    let step = ratio.step();
    if ratio.steps > MAX_STEPS_PER_VALUE {
        let reason = Inapplicable::FastSpindle { step };
        return Err(SimulationError::NotApplicable { rung: "spindle_only", reason });
    }
    let values = kept_values(settings.duration);
    let before = (settings.settle / step).floor() as usize;
    // A step ends at the first recorded value; the run begins up to a step after time 0.
    let begin = settings.settle - before as f64 * step;
    let mut recorder = Recorder::new(SPINDLE_IN_PLANE, &settings.outputs, values)
        .with_series(SeriesRecording::begin(&settings.outputs, control));
    // Values between steps need steps on either side; before the first step the spindle stands still.
    let mut interpolator = Interpolator::new(ratio.steps, ratio.values);
    let delay = if ratio.is_long() { Interpolator::<{ SPINDLE_IN_PLANE.len() }>::DELAY } else { 0 };
    let mut primed = before >= delay;
    let first = if primed { before - delay } else { before };
    let all = before + ((values - 1) * ratio.steps).div_ceil(ratio.values) + delay + 1;
    let set = InstructionSet::best();
    let mut fitted = model.speed(begin).0;
    model.refit(fitted);
    let mut method = AdamsMoulton::<NODES>::new(&model, begin, (rest, [0.0; 2]), step);
    for from in (0..all).step_by(STEPS_PER_BLOCK) {
        let to = (from + STEPS_PER_BLOCK).min(all);
        let (speed, constant) = model.speed(method.time());
        if !constant && (speed - fitted).abs() > SPEED_CHANGE * fitted.abs() {
            fitted = speed;
            model.refit(speed);
        }
        let mut frames = [Frame::default(); STEPS_PER_BLOCK];
        set.run(Advance { model: &model, method: &mut method, begins: from == 0, frames: &mut frames[..to - from] });
        let kept = &frames[first.clamp(from, to) - from..to - from];
        if !ratio.is_long() {
            let done = from.max(first) - first;
            let next = done.next_multiple_of(ratio.steps) - done;
            kept.iter().skip(next).step_by(ratio.steps).for_each(|frame| recorder.push(frame));
        } else if let Some(frame) = kept.first() {
            if !primed {
                interpolator.prime(frame);
                primed = true;
            }
            recorder.extend(interpolator.push(kept, set));
        }
        let time = method.time();
        if let Some(component) = not_finite(method.motion()) {
            let source = IntegrationError::NotFinite { time, step, component };
            return Err(SimulationError::Integration { source, entry: "the spindle".into() });
        }
        let [y, z] = method.motion().0;
        if let Some(departure) = mechanism.departure([0.0, y, z], [0.0; 2]) {
            return Err(SimulationError::SpindleLeft { time, departure });
        }
        if from % (16 * STEPS_PER_BLOCK) == 0 {
            if (control.stop)() {
                return Err(SimulationError::Stopped { time });
            }
            (control.progress)(to as f64 / all as f64);
            let phase = if to < before { Phase::Settling } else { Phase::Recording };
            (control.live)(&Live { phase, accelerations: &|| recorder.accelerations() });
        }
    }
    let statistics = statistics(all as u64 - 1, method.evaluations(), step);
    let start = begin + before as f64 * step;
    Ok((recording(&model, &mechanism, start, settings.duration, recorder, None), statistics))
}

fn not_finite((place, velocity): &SpindleMotion) -> Option<usize> {
    place.iter().chain(velocity).position(|value| !value.is_finite())
}

/// Consecutive points of a run; the very first is its initial state.
struct Advance<'a> {
    model: &'a SpindleOnly,
    method: &'a mut AdamsMoulton<NODES>,
    begins: bool,
    frames: &'a mut [Frame],
}

impl Task for Advance<'_> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        let Self { model, method: at, begins, frames } = self;
        let mut begun = 0;
        while begun < frames.len() && !at.has_begun() {
            if begun > 0 || !begins {
                at.begin(model);
            }
            frames[begun] = frame(at);
            begun += 1;
        }
        let frames = &mut frames[begun..];
        // The method is copied into registers, because a vector load waits for scalar stores. No function call between two steps empties
        // the registers.
        let mut method = *at;
        let mut drives = [Driven::default(); STEPS_PER_BLOCK];
        model.drives(|step| method.after(step + 1), &mut drives);
        for (kept, drive) in frames.iter_mut().zip(&drives) {
            method.step(model, drive);
            *kept = frame(&method);
        }
        *at = method;
    }
}

#[inline(always)]
fn frame(method: &AdamsMoulton<NODES>) -> Frame {
    let (([y, z], [vy, vz]), [ay, az]) = (*method.motion(), *method.acceleration());
    [y, z, vy, vz, ay, az]
}
