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

/// Stretch over which the disturbed and the undisturbed motion are followed [s].
const STRETCH: f64 = 0.01;
/// Stretch that is repeated at a tighter tolerance [s].
const REPEATED: f64 = 0.01;
/// Disturbance, in sizes of the state's entries: 1e-11 m in each position.
const DISTURBANCE: f64 = 1e-5;
/// Distances at which two motions have nothing more in common; growth ends there.
const SATURATED: f64 = 0.1;
/// Distances on the way, evenly spaced in time.
const SAMPLES: usize = 50;
/// Growth by this many e-folds over the stretch counts as diverging; less may be a neutral drift of the azimuths.
const FOLDS: f64 = 2.0;
/// Loosest relative tolerance at which two motions are followed: whether they part is a matter of the scene, and must not
/// drown in the errors of the steps.
const PAIR_TOLERANCE: f64 = 1e-6;
/// How much tighter the repetition is.
const TIGHTER: f64 = 0.1;
/// Tightest relative tolerance that double precision resolves here.
const LEAST_TOLERANCE: f64 = 1e-13;
/// What a level is made of.
pub(super) const ACCELERATIONS: [Channel; 2] =
    [Channel::Spindle(Axis::Y, Motion::Acceleration), Channel::Spindle(Axis::Z, Motion::Acceleration)];
/// Batches for the sampling error of a level.
pub(super) const BATCHES: usize = 10;

/// Shortest stretch that tells decay from divergence; shorter runs say nothing about it [s].
const LEAST_STRETCH: f64 = 5e-3;

/// How much of a run is judged [s].
pub fn judged_stretch(settings: &RunSettings) -> f64 {
    settings.duration.min(STRETCH)
}

/// Judges a run from its first state and that at its checkpoint, the end of settling. Instability parts two copies as
/// chaos does; so a fixed step is halved all the same.
pub(super) fn judge(
    model: &Model,
    needs: &Needs,
    settings: &RunSettings,
    recording: &Recording,
    (main, start): (&Integrated, &[f64]),
    control: &Control<'_>,
) -> Result<AccuracyReport, SimulationError> {
    let (checkpoint, warning) = (main.checkpoint.as_slice(), main.unstable.clone());
    let stretch = judged_stretch(settings);
    let divergence_rate = divergence_rate(model, settings, settings.settle, checkpoint, stretch, control)?;
    (control.progress)(0.9);
    let motion = motion(divergence_rate, stretch);
    let signals = ACCELERATIONS.iter().filter_map(|&channel| recording.signal(channel));
    let sampling = signals
        .filter_map(|signal| level_standard_error_db(&band_limited(signal, RATE, BAND), BATCHES))
        .fold(None, largest);
    const SAMPLING: &str = "the motion is chaotic: standard error of the level by ten batch means, worst of y and z";
    let chaotic = motion == Some(MotionKind::Diverging);
    if chaotic && settings.fixed_step.is_none() {
        return Ok(AccuracyReport { level_error_db: sampling, how: SAMPLING.into(), motion, divergence_rate, warning });
    }
    let stretch = settings.duration.min(REPEATED);
    // With what settling has left behind, too, where that does not double the work.
    let begin = if settings.settle <= settings.duration { (0.0, start) } else { (settings.settle, checkpoint) };
    let tolerance_error = tolerance_error(model, needs, settings, recording, begin, stretch, control)?;
    (control.progress)(1.0);
    if chaotic {
        return Ok(AccuracyReport {
            level_error_db: tolerance_error.into_iter().fold(sampling, largest),
            how: format!(
                "{SAMPLING}, or the level over {:.3} ms repeated at half of the step, if that differs more",
                1e3 * stretch
            ),
            motion,
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
        motion,
        divergence_rate,
        warning,
    })
}

/// What growth at a rate [1/s] over a stretch [s] says of the motion; `None`: the stretch is too short to tell.
pub(super) fn motion(divergence_rate: f64, stretch: f64) -> Option<MotionKind> {
    let diverging = divergence_rate * stretch > FOLDS;
    let kind = if diverging { MotionKind::Diverging } else { MotionKind::Decaying };
    (stretch >= LEAST_STRETCH).then_some(kind)
}

/// Level error from which a result warns of itself [dB].
const DOUBTFUL: f64 = 1.0;

impl AccuracyReport {
    /// With a warning where the level is not resolved, unless there is one already.
    pub(super) fn doubted(mut self) -> Self {
        if let (None, Some(error)) = (&self.warning, self.level_error_db.filter(|error| *error > DOUBTFUL)) {
            self.warning = Some(format!(
                "the level is not resolved: it may err by {error:.0} dB or more; hardly anything moves, or the run is too short. \
                 Try a tighter relative tolerance, or keep more"
            ));
        }
        self
    }
}

fn largest(most: Option<f64>, value: f64) -> Option<f64> {
    Some(most.map_or(value, |most: f64| most.max(value)))
}

/// 20 lg(rms a / rms b) [dB]; `None` where one stands still.
fn level_difference(a: &[f64], b: &[f64]) -> Option<f64> {
    let (a, b) = (rms(a), rms(b));
    (a > 0.0 && b > 0.0).then(|| 20.0 * (a / b).log10())
}

/// Parts of the repeated stretch whose levels are compared one by one.
const PARTS: usize = 5;
/// Values between the start of the repeated stretch and the first one compared: past the filter's delay.
pub(super) const SKIPPED: usize = 100;

/// |20 lg| of the ratio of the levels of a stretch as it was recorded and repeated at a tighter tolerance, worst of y
/// and z [dB]; `None` where the run is too short or nothing moves.
fn tolerance_error(
    model: &Model,
    needs: &Needs,
    settings: &RunSettings,
    recording: &Recording,
    (begin, state): (f64, &[f64]),
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
    let span = Span { start: begin, end: observer.end(), checkpoint: begin, share: (0.9, 1.0) };
    integrate(model, state, &stepping, &span, control, |step| observer.after(step))?;
    let repeated = observer.finish();
    let difference = |channel: Channel| {
        let first = band_limited(recording.signal(channel)?.get(SKIPPED..values)?, RATE, BAND);
        let again = band_limited(repeated.signal(channel)?, RATE, BAND);
        let whole = level_difference(&first, &again)?;
        // Differences of either sign can cancel: their scatter over parts tells by how much the rest of the run may differ.
        let unseen = (1.0 - stretch / settings.duration).max(0.0).sqrt();
        let part = first.len().div_ceil(PARTS);
        let parts: Vec<f64> =
            first.chunks(part).zip(again.chunks(part)).filter_map(|(a, b)| level_difference(a, b)).collect();
        Some(whole.hypot(unseen * standard_error(&parts)))
    };
    Ok(ACCELERATIONS.into_iter().filter_map(difference).fold(None, largest))
}

/// Standard error of the mean of a few values.
fn standard_error(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    if n < 2.0 {
        return 0.0;
    }
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt()
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

/// Rate at which a small disturbance of the state at `begin` [s] grows over a stretch [s] (negative: shrinks) [1/s], by
/// a straight line through the logarithm of the distance, first tenth left out.
pub(super) fn divergence_rate(
    model: &Model,
    settings: &RunSettings,
    begin: f64,
    checkpoint: &[f64],
    stretch: f64,
    control: &Control<'_>,
) -> Result<f64, SimulationError> {
    let n = model.dimension();
    let sizes = model.mechanism().layout.sizes();
    let mut start = checkpoint.to_vec();
    // Alternating signs: a disturbance that no symmetry of the bearing cancels.
    start.extend((0..n).map(|i| checkpoint[i] + if i % 3 == 0 { -1.0 } else { 1.0 } * DISTURBANCE * sizes[i]));
    let one = model.mechanism().layout.tolerances(settings.relative_tolerance.min(PAIR_TOLERANCE));
    let tolerances = Tolerances { relative: one.relative.repeat(2), absolute: one.absolute.repeat(2) };
    let pair = Pair { model };
    let mut integrator = settings.method.start(&pair, begin, &start, tolerances, settings.fixed_step);
    let end = begin + stretch;
    let mut stops: Vec<f64> = model.mechanism().speed.kinks().filter(|kink| *kink > begin && *kink < end).collect();
    stops.push(end);
    let (mut times, mut logarithms) = (Vec::new(), Vec::new());
    let mut state = start.clone();
    let mut sample = 1;
    for stop in stops {
        while integrator.time() < stop {
            step(integrator.as_mut(), stop, model, control)?;
            while sample <= SAMPLES {
                let time = (begin + stretch * sample as f64 / SAMPLES as f64).min(end);
                if time > integrator.time() {
                    break;
                }
                integrator.interpolate(time, &mut state);
                let squares: f64 = (0..n).map(|i| ((state[n + i] - state[i]) / sizes[i]).powi(2)).sum();
                let distance = (squares / n as f64).sqrt();
                if distance > SATURATED || distance == 0.0 {
                    return Ok(slope(&times, &logarithms).unwrap_or(0.0));
                }
                if sample > SAMPLES / 10 {
                    times.push(time);
                    logarithms.push(distance.ln());
                }
                sample += 1;
            }
        }
        integrator.restart();
    }
    Ok(slope(&times, &logarithms).unwrap_or(0.0))
}
