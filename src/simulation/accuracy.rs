//! How far a run can be trusted: does a disturbance die out, and does the level depend on the tolerance?

use super::channel::{Axis, Channel, Motion};
use super::metrics::{AccuracyReport, BAND, MotionKind};
use super::model::Model;
use super::needs::Needs;
use super::observe::{self, Observer, RATE, Recording};
use super::run::{
    Control, Integrated, Outputs, RunSettings, STEPS_PER_LOOK, SimulationError, Span, Stepping, integrate,
};
use crate::numerics::ode::structure::{Jacobian, Structure};
use crate::numerics::ode::{Integrator, OdeSystem, Tolerances};
use crate::numerics::spectrum::band_limited;
use crate::numerics::statistics::{level_standard_error_db, rms, slope};

/// Stretch over which the disturbed and the undisturbed motion are followed, and the run repeated [s].
const STRETCH: f64 = 0.01;
/// Disturbance, in sizes of the state's entries: 1e-11 m in each position.
const DISTURBANCE: f64 = 1e-5;
/// Distances at which two motions have nothing more in common; growth ends there.
const SATURATED: f64 = 0.1;
/// Distances on the way, evenly spaced in time.
const SAMPLES: usize = 50;
/// Growth by this many e-folds over the stretch counts as diverging; less may be a neutral drift of the azimuths.
const FOLDS: f64 = 2.0;
/// How much tighter the repetition is.
const TIGHTER: f64 = 0.1;
/// Tightest relative tolerance that double precision resolves here.
const LEAST_TOLERANCE: f64 = 1e-13;
const ACCELERATIONS: [Channel; 2] =
    [Channel::Spindle(Axis::Y, Motion::Acceleration), Channel::Spindle(Axis::Z, Motion::Acceleration)];
/// Batches for the sampling error of a level.
const BATCHES: usize = 10;

/// Shortest stretch that tells decay from divergence; shorter runs say nothing about it [s].
const LEAST_STRETCH: f64 = 5e-3;

/// How much of a run is judged [s].
pub fn judged_stretch(settings: &RunSettings) -> f64 {
    settings.duration.min(STRETCH)
}

/// Judges a run from the state at its checkpoint, the end of settling. Instability parts two copies as chaos does; so
/// a fixed step is halved all the same.
pub(super) fn judge(
    model: &Model,
    needs: &Needs,
    settings: &RunSettings,
    recording: &Recording,
    main: &Integrated,
    control: &Control<'_>,
) -> Result<AccuracyReport, SimulationError> {
    let (checkpoint, warning) = (main.checkpoint.as_slice(), main.unstable.clone());
    let stretch = judged_stretch(settings);
    let divergence_rate = divergence_rate(model, settings, checkpoint, stretch, control)?;
    (control.progress)(0.9);
    let diverging = divergence_rate * stretch > FOLDS;
    let decided = stretch >= LEAST_STRETCH;
    let signals = ACCELERATIONS.iter().filter_map(|&channel| recording.signal(channel));
    let sampling = signals
        .filter_map(|signal| level_standard_error_db(&band_limited(signal, RATE, BAND), BATCHES))
        .fold(None, largest);
    let chaotic = decided && diverging;
    const SAMPLING: &str = "the motion is chaotic: standard error of the level by ten batch means, worst of y and z";
    if chaotic && settings.fixed_step.is_none() {
        return Ok(AccuracyReport {
            level_error_db: sampling,
            how: SAMPLING.into(),
            motion: Some(MotionKind::Diverging),
            divergence_rate,
            warning,
        });
    }
    let tolerance_error = tolerance_error(model, needs, settings, recording, checkpoint, stretch, control)?;
    (control.progress)(1.0);
    if chaotic {
        return Ok(AccuracyReport {
            level_error_db: tolerance_error.into_iter().fold(sampling, largest),
            how: format!(
                "{SAMPLING}, or the level over {:.3} ms repeated at half of the step, if that differs more",
                1e3 * stretch
            ),
            motion: Some(MotionKind::Diverging),
            divergence_rate,
            warning,
        });
    }
    Ok(AccuracyReport {
        level_error_db: tolerance_error,
        how: if tolerance_error.is_none() {
            "no level to compare: nothing moves, or the run is too short to repeat a part of it".into()
        } else {
            format!(
                "level over {:.3} ms repeated at {}, worst of y and z",
                1e3 * stretch,
                if settings.fixed_step.is_some() { "half of the step" } else { "a tenth of the relative tolerance" }
            )
        },
        motion: decided.then_some(MotionKind::Decaying),
        divergence_rate,
        warning,
    })
}

fn largest(most: Option<f64>, value: f64) -> Option<f64> {
    Some(most.map_or(value, |most: f64| most.max(value)))
}

/// |20 lg(rms a / rms b)| [dB]; `None` where one stands still.
fn level_difference(a: &[f64], b: &[f64]) -> Option<f64> {
    let (a, b) = (rms(a), rms(b));
    (a > 0.0 && b > 0.0).then(|| 20.0 * (a / b).log10().abs())
}

/// Values between the start of the repeated stretch and the first one compared: past the filter's delay.
const SKIPPED: usize = 100;

/// |20 lg| of the ratio of the levels of a stretch as it was recorded and repeated at a tighter tolerance, worst of y
/// and z [dB]; `None` where the run is too short or nothing moves.
fn tolerance_error(
    model: &Model,
    needs: &Needs,
    settings: &RunSettings,
    recording: &Recording,
    checkpoint: &[f64],
    stretch: f64,
    control: &Control<'_>,
) -> Result<Option<f64>, SimulationError> {
    let values = observe::kept_values(stretch);
    if values < 2 * SKIPPED {
        return Ok(None);
    }
    let again = RunSettings {
        settle: settings.settle + SKIPPED as f64 / RATE,
        duration: (values - SKIPPED) as f64 / RATE,
        outputs: Outputs { spectra: Vec::new(), series: Vec::new(), ..settings.outputs.clone() },
        ..settings.clone()
    };
    let stepping = Stepping {
        relative_tolerance: (TIGHTER * settings.relative_tolerance).max(LEAST_TOLERANCE),
        fixed_step: settings.fixed_step.map(|step| 0.5 * step),
        ..Stepping::of(settings)
    };
    let mut observer = Observer::new(model, needs, &again);
    let span = Span { start: settings.settle, end: observer.end(), checkpoint: settings.settle, share: (0.9, 1.0) };
    integrate(model, checkpoint, &stepping, &span, control, |step| observer.after(step))?;
    let repeated = observer.finish();
    let difference = |channel: Channel| {
        let first = recording.signal(channel)?.get(SKIPPED..values)?;
        level_difference(first, repeated.signal(channel)?)
    };
    Ok(ACCELERATIONS.into_iter().filter_map(difference).fold(None, largest))
}

fn step(
    integrator: &mut dyn Integrator,
    limit: f64,
    model: &Model,
    control: &Control<'_>,
) -> Result<(), SimulationError> {
    integrator.step(limit).map_err(|source| SimulationError::integration(source, &model.mechanism().layout))?;
    if integrator.statistics().steps.is_multiple_of(STEPS_PER_LOOK) && (control.stop)() {
        return Err(SimulationError::Stopped { time: integrator.time() });
    }
    Ok(())
}

/// Two copies of a system side by side, so that both take the same steps.
struct Pair<'a> {
    model: &'a Model,
}

impl OdeSystem for Pair<'_> {
    fn dimension(&self) -> usize {
        2 * self.model.dimension()
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        let n = self.model.dimension();
        self.model.derivative(time, &state[..n], &mut derivative[..n]);
        self.model.derivative(time, &state[n..], &mut derivative[n..]);
    }

    fn structure(&self) -> Structure {
        Structure { copies: 2, ..self.model.structure() }
    }

    /// That of the first copy: the second is never far.
    fn jacobian(&self, time: f64, state: &[f64], rate: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        let n = self.model.dimension();
        self.model.jacobian(time, &state[..n], &rate[..n], &displacement[..n], jacobian)
    }
}

/// Rate at which a small disturbance grows (negative: shrinks) [1/s], by a straight line through the
/// logarithm of the distance, first tenth left out.
fn divergence_rate(
    model: &Model,
    settings: &RunSettings,
    checkpoint: &[f64],
    stretch: f64,
    control: &Control<'_>,
) -> Result<f64, SimulationError> {
    let n = model.dimension();
    let sizes = model.mechanism().layout.sizes();
    let mut start = checkpoint.to_vec();
    // Alternating signs: a disturbance that no symmetry of the bearing cancels.
    start.extend((0..n).map(|i| checkpoint[i] + if i % 3 == 0 { -1.0 } else { 1.0 } * DISTURBANCE * sizes[i]));
    let one = model.mechanism().layout.tolerances(settings.relative_tolerance);
    let tolerances = Tolerances { relative: one.relative.repeat(2), absolute: one.absolute.repeat(2) };
    let pair = Pair { model };
    let mut integrator = settings.method.start(&pair, settings.settle, &start, tolerances, settings.fixed_step);
    let kinks: Vec<f64> = model.mechanism().speed.kinks().collect();
    let (mut times, mut logarithms) = (Vec::new(), Vec::new());
    let mut state = start.clone();
    for k in 1..=SAMPLES {
        let time = settings.settle + stretch * k as f64 / SAMPLES as f64;
        while integrator.time() < time {
            let kink = kinks.iter().copied().find(|kink| *kink > integrator.time() && *kink < time);
            step(integrator.as_mut(), kink.unwrap_or(time), model, control)?;
            if Some(integrator.time()) == kink {
                integrator.restart();
            }
        }
        integrator.interpolate(time, &mut state);
        let squares: f64 = (0..n).map(|i| ((state[n + i] - state[i]) / sizes[i]).powi(2)).sum();
        let distance = (squares / n as f64).sqrt();
        if distance > SATURATED || distance == 0.0 {
            break;
        }
        if k > SAMPLES / 10 {
            times.push(time);
            logarithms.push(distance.ln());
        }
    }
    Ok(slope(&times, &logarithms).unwrap_or(0.0))
}
