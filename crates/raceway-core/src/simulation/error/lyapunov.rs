//! Divergence of neighbouring trajectories. It distinguishes chaos from decay.

use crate::numerics::ode::Method;
use crate::numerics::ode::{Integrator, OdeSystem, Tolerances};
use crate::numerics::statistics::{rms, slope};
use crate::simulation::error::twin_system::Pair;
use crate::simulation::input::control::Control;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::Model;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::{STEPS_PER_LOOK, stops};
use crate::simulation::model::rolling_limit::end_of_step;

/// Initial time over which the disturbed and the undisturbed trajectory are compared [s].
const STRETCH: f64 = 0.01;
/// Shortest time that distinguishes decay from divergence [s]; shorter runs give no estimate.
const LEAST_STRETCH: f64 = 5e-3;
/// Disturbance relative to the sizes of the state's entries [-]: 1e-11 m in each position.
const DISTURBANCE: f64 = 1e-5;
/// Relative distance at which two trajectories are independent [-]; growth ends there.
const SATURATED: f64 = 0.1;
/// Number of recorded distances, evenly spaced in time.
const SAMPLES: usize = 50;
/// Relative distance below which rounding dominates [-].
const ROUNDING: f64 = 1e-9;
/// Growth over the window from which trajectories count as diverging [e-folds]. Smaller growth may be a neutral drift of the azimuths.
const FOLDS: f64 = 2.0;
/// Loosest relative tolerance for following two trajectories [-]. Divergence is a property of the scene and must not be hidden by errors of the
/// steps.
const PAIR_TOLERANCE: f64 = 1e-4;

/// Time over which divergence is estimated [s].
pub fn judged_stretch(settings: &RunSettings) -> f64 {
    settings.duration.min(STRETCH)
}

/// Method that follows the trajectories of a run. Long steps of `radau` damp the divergence. Its interpolation error hardly depends on the
/// tolerance. Another method shows both effects.
pub(crate) fn judging(method: Method) -> Method {
    if method == Method::Radau { Method::Gear } else { method }
}

/// Kind of motion: neighbouring trajectories converge or diverge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionKind {
    Decaying,
    Diverging,
}

/// Growth of a disturbance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DivergenceEstimate {
    /// Growth rate [1/s]; negative: the disturbance decays.
    pub rate: f64,
    /// Time over which the disturbance was followed [s].
    pub over: f64,
    /// Mean size of the disturbance in the later half over its initial size [e-folds].
    pub growth: f64,
    /// The speed is constant. Only then are parts of the run samples of one motion.
    pub is_steady: bool,
}

impl DivergenceEstimate {
    /// Kind of motion; `None`: the time is too short.
    pub fn motion(&self) -> Option<MotionKind> {
        let diverging = self.rate * self.over > FOLDS;
        let kind = if diverging { MotionKind::Diverging } else { MotionKind::Decaying };
        (self.over >= LEAST_STRETCH).then_some(kind)
    }

    /// True if the motion is chaotic at constant speed, so that its statistics are the answer and not its course.
    pub fn is_chaotic(&self) -> bool {
        self.is_steady && self.motion() == Some(MotionKind::Diverging)
    }

    /// True if trajectories may diverge over a longer time [s], although they have not yet diverged.
    pub fn may_grow(&self, time: f64) -> bool {
        self.motion() != Some(MotionKind::Diverging) && self.rate * time > FOLDS
    }
}

/// Excerpts of one signal on two trajectories.
pub(crate) type Pairs<'a> = (&'a [Vec<f64>], &'a [Vec<f64>]);

/// Divergence of two trajectories that started `disturbance` apart, relative to the sizes of their signals. The signals were recorded after
/// `settle` [s] at `rate` [Hz]. Each excerpt contains the first few of every `spacing` values.
pub(crate) fn of_signals(
    pairs: &[Pairs<'_>],
    spacing: usize,
    disturbance: f64,
    settle: f64,
    rate: f64,
) -> DivergenceEstimate {
    let stretches = pairs.iter().map(|(one, other)| one.len().min(other.len())).min().unwrap_or(0);
    let length = |stretch: usize| {
        pairs.iter().map(|(one, other)| one[stretch].len().min(other[stretch].len())).min().unwrap_or(0)
    };
    let kept: usize = (0..stretches).map(length).sum();
    let sizes: Vec<f64> = pairs.iter().map(|(one, _)| rms(&one.concat()).max(f64::MIN_POSITIVE)).collect();
    let (mut times, mut logarithms) = (Vec::new(), Vec::new());
    for stretch in 0..stretches {
        let window = (kept / SAMPLES).clamp(1, length(stretch).max(1));
        for from in (0..length(stretch).saturating_sub(window - 1)).step_by(window) {
            let relative = |((one, other), size): (&Pairs<'_>, &f64)| {
                let (one, other) = (&one[stretch][from..from + window], &other[stretch][from..]);
                let squares: f64 = one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
                squares.sqrt() / (window as f64).sqrt() / size
            };
            times.push(settle + (stretch * spacing + from) as f64 / rate);
            logarithms.push(pairs.iter().zip(&sizes).map(relative).fold(ROUNDING, f64::max).ln());
        }
    }
    let values = stretches * spacing;
    let late = late_slope(&times, &logarithms);
    match logarithms.iter().copied().reduce(f64::max) {
        Some(largest) if largest > SATURATED.ln() => {
            let growth = largest - disturbance.ln();
            // The trajectories are independent, whatever the course of growth was.
            let over = values as f64 / rate;
            let rate = late.max((FOLDS + growth).max(FOLDS) / over);
            DivergenceEstimate { rate, over, growth, is_steady: true }
        }
        _ => DivergenceEstimate {
            rate: late,
            over: values as f64 / rate,
            growth: late_mean(&logarithms) - disturbance.ln(),
            is_steady: true,
        },
    }
}

/// Growth rate of a small disturbance of the state at `begin` [s] over `stretch` [s]. It is the slope of a straight line through the later half of
/// the logarithms of the distance. The time is extended up to the end of the recorded time while the rate would allow growth that has not yet
/// appeared. Slow chaos appears late. A drift is not chaos, and never grows much in the later half.
///
/// Where the speed changes, trajectories may part at one speed and join again at another. The whole run is followed then, and the mean growth in
/// its later half decides.
pub(crate) fn divergence_rate(
    model: &Model,
    settings: &RunSettings,
    begin: f64,
    checkpoint: &[f64],
    stretch: f64,
    most_evaluations: u64,
    control: &Control<'_>,
) -> Result<DivergenceEstimate, SimulationError> {
    let n = model.dimension();
    let sizes = model.mechanism().layout.sizes();
    let pair = Pair::new(model);
    // Alternating signs: a disturbance that no symmetry of the bearing cancels.
    let disturbed: Vec<f64> =
        (0..n).map(|i| checkpoint[i] + if i % 3 == 0 { -1.0 } else { 1.0 } * DISTURBANCE * sizes[i]).collect();
    let start = pair.joined(checkpoint, &disturbed);
    let one = model.mechanism().layout.tolerances(settings.relative_tolerance.min(PAIR_TOLERANCE));
    let twice = |of: &[f64]| pair.joined(of, of);
    let tolerances = Tolerances { relative: twice(&one.relative), absolute: twice(&one.absolute) };
    let mut integrator = judging(settings.method).start(&pair, begin, &start, tolerances, settings.fixed_step);
    if model.mechanism().kinks().contains(&begin) {
        integrator.restart();
    }
    // The pair has no fixed steps of its own.
    let is_controlled = settings.fixed_step.is_none() || settings.method == Method::SemiImplicit;
    let is_steady = model.mechanism().is_steady();
    let last = (settings.settle + settings.duration).max(begin + stretch);
    let stretch = if is_steady { stretch } else { last - begin };
    let spacing = stretch / SAMPLES as f64;
    let (mut times, mut logarithms) = (Vec::new(), Vec::new());
    let mut state = start.clone();
    let [mut straight, mut disturbed] = [(); 2].map(|()| vec![0.0; n]);
    let mut end = begin + stretch;
    loop {
        for stop in stops(model, integrator.time(), end) {
            while integrator.time() < stop {
                let mut end = stop;
                if model.mechanism().limits_steps() && is_controlled {
                    pair.take(0, integrator.state(), &mut straight);
                    end = end_of_step(model.mechanism(), integrator.time(), &straight, stop);
                }
                step(integrator.as_mut(), end, model, control)?;
                let (time, evaluations) = (integrator.time(), integrator.statistics().rhs_evaluations);
                if evaluations > most_evaluations {
                    return Err(SimulationError::EvaluationLimit { time, evaluations });
                }
                loop {
                    let time = (begin + spacing * (times.len() + 1) as f64).min(last);
                    if time > integrator.time() || times.last() == Some(&time) {
                        break;
                    }
                    integrator.interpolate(time, &mut state);
                    pair.take(0, &state, &mut straight);
                    pair.take(1, &state, &mut disturbed);
                    let squares: f64 = (0..n).map(|i| ((disturbed[i] - straight[i]) / sizes[i]).powi(2)).sum();
                    let distance = (squares / n as f64).sqrt();
                    if distance > SATURATED && is_steady {
                        // The larger of the mean rate and the latest rate counts.
                        let mean = (distance / DISTURBANCE).ln() / (time - begin);
                        let growth = (distance / DISTURBANCE).ln();
                        return Ok(DivergenceEstimate {
                            rate: late_slope(&times, &logarithms).max(mean),
                            over: time.max(begin + stretch) - begin,
                            growth,
                            is_steady,
                        });
                    }
                    if distance == 0.0 {
                        let rate = late_slope(&times, &logarithms);
                        let growth = f64::MIN;
                        return Ok(DivergenceEstimate { rate, over: stretch, growth, is_steady });
                    }
                    times.push(time);
                    logarithms.push(distance.ln());
                }
            }
            if stop < end {
                integrator.restart();
            }
        }
        let growth = late_mean(&logarithms) - DISTURBANCE.ln();
        let over = end - begin;
        let rate = if is_steady { late_slope(&times, &logarithms) } else { growth / over };
        let parted = DivergenceEstimate { rate, over, growth, is_steady };
        let might_grow = parted.rate * (last - begin) > FOLDS;
        if end >= last || !might_grow || parted.motion() == Some(MotionKind::Diverging) {
            return Ok(parted);
        }
        end = (begin + 2.0 * (end - begin)).min(last);
    }
}

/// Slope of the later half. On this scale, trajectories that separate by free drift diverge ever more slowly, and chaotic ones do not.
fn late_slope(times: &[f64], logarithms: &[f64]) -> f64 {
    let half = times.len() / 2;
    slope(&times[half..], &logarithms[half..]).unwrap_or(0.0)
}

/// Mean of the later half; `f64::MIN` if the half is empty.
fn late_mean(logarithms: &[f64]) -> f64 {
    let late = &logarithms[logarithms.len() / 2..];
    if late.is_empty() { f64::MIN } else { late.iter().sum::<f64>() / late.len() as f64 }
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
