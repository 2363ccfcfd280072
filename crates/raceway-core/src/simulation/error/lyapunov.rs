//! Do two motions that start next to each other meet or part? It tells chaos from decay.

use crate::numerics::ode::Method;
use crate::numerics::ode::{Integrator, OdeSystem, Tolerances};
use crate::numerics::statistics::{rms, slope};
use crate::simulation::error::twin_system::Pair;
use crate::simulation::input::control::Control;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::Model;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::{STEPS_PER_LOOK, stops};

/// Stretch over which the disturbed and the undisturbed motion are followed at first [s].
const STRETCH: f64 = 0.01;
/// Shortest stretch that tells decay from divergence; shorter runs say nothing about it [s].
const LEAST_STRETCH: f64 = 5e-3;
/// Disturbance, in sizes of the state's entries: 1e-11 m in each position.
const DISTURBANCE: f64 = 1e-5;
/// Distances at which two motions have nothing more in common; growth ends there.
const SATURATED: f64 = 0.1;
/// Distances on the way, evenly spaced in time.
const SAMPLES: usize = 50;
/// Relative distances below this are those of rounding.
const ROUNDING: f64 = 1e-9;
/// Growth by this many e-folds over the stretch counts as diverging; less may be a neutral drift of the azimuths.
const FOLDS: f64 = 2.0;
/// Loosest relative tolerance at which two motions are followed: whether they part is a matter of the scene, and must not
/// drown in the errors of the steps.
const PAIR_TOLERANCE: f64 = 1e-4;

/// How much of a run is judged [s].
pub fn judged_stretch(settings: &RunSettings) -> f64 {
    settings.duration.min(STRETCH)
}

/// By what a run of a method is judged. The long steps of `radau` damp what parts two motions and are looked at by
/// interpolation, whose error hardly depends on the tolerance: another method sees both.
pub(crate) fn judging(method: Method) -> Method {
    if method == Method::Radau { Method::Gear } else { method }
}

/// Whether neighbouring trajectories converge or diverge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionKind {
    Decaying,
    Diverging,
}

/// How a disturbance has grown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DivergenceEstimate {
    /// [1/s]; negative: it has shrunk.
    pub rate: f64,
    /// How long it was followed [s].
    pub over: f64,
    /// Its mean size in the later half over that at the beginning [e-folds].
    pub growth: f64,
}

impl DivergenceEstimate {
    /// What that says of the motion; `None`: too short to tell.
    pub fn motion(&self) -> Option<MotionKind> {
        let diverging = self.rate * self.over > FOLDS;
        let kind = if diverging { MotionKind::Diverging } else { MotionKind::Decaying };
        (self.over >= LEAST_STRETCH).then_some(kind)
    }

    /// Whether trajectories may diverge over a longer time [s], although they have not yet.
    pub fn may_grow(&self, time: f64) -> bool {
        self.motion() != Some(MotionKind::Diverging) && self.rate * time > FOLDS
    }
}

/// A signal of two motions: what was kept of each, stretch by stretch.
pub(crate) type Pairs<'a> = (&'a [Vec<f64>], &'a [Vec<f64>]);

/// How two motions part that started `disturbance` apart, in sizes of their signals, from what was recorded of them after a
/// time to settle [s] at a rate [Hz]: of every `spacing` values the first few.
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
            // However it came about: they have nothing more in common.
            let over = values as f64 / rate;
            DivergenceEstimate { rate: late.max((FOLDS + growth).max(FOLDS) / over), over, growth }
        }
        _ => DivergenceEstimate {
            rate: late,
            over: values as f64 / rate,
            growth: late_mean(&logarithms) - disturbance.ln(),
        },
    }
}

/// How a small disturbance of the state at `begin` [s] grows over a stretch [s]: the slope of a straight line through the later
/// half of the logarithms of the distance. Where it might have grown by the end of the kept time and has not yet, it is
/// followed on: slow chaos shows late, and a drift, which is none, never grows by much in the later half.
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
    if model.mechanism().speed.kinks().any(|kink| kink == begin) {
        integrator.restart();
    }
    let (last, spacing) = ((settings.settle + settings.duration).max(begin + stretch), stretch / SAMPLES as f64);
    let (mut times, mut logarithms) = (Vec::new(), Vec::new());
    let mut state = start.clone();
    let [mut straight, mut disturbed] = [(); 2].map(|()| vec![0.0; n]);
    let mut end = begin + stretch;
    loop {
        for stop in stops(model, integrator.time(), end) {
            while integrator.time() < stop {
                step(integrator.as_mut(), stop, model, control)?;
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
                    if distance > SATURATED {
                        // However it came about, on the whole or lately.
                        let mean = (distance / DISTURBANCE).ln() / (time - begin);
                        let growth = (distance / DISTURBANCE).ln();
                        return Ok(DivergenceEstimate {
                            rate: late_slope(&times, &logarithms).max(mean),
                            over: time.max(begin + stretch) - begin,
                            growth,
                        });
                    }
                    if distance == 0.0 {
                        let rate = late_slope(&times, &logarithms);
                        return Ok(DivergenceEstimate { rate, over: stretch, growth: f64::MIN });
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
        let parted = DivergenceEstimate { rate: late_slope(&times, &logarithms), over: end - begin, growth };
        let might_grow = parted.rate * (last - begin) > FOLDS;
        if end >= last || !might_grow || parted.motion() == Some(MotionKind::Diverging) {
            return Ok(parted);
        }
        end = (begin + 2.0 * (end - begin)).min(last);
    }
}

/// Slope of the later half: two motions that fly apart freely part ever more slowly, seen so, and chaos does not.
fn late_slope(times: &[f64], logarithms: &[f64]) -> f64 {
    let half = times.len() / 2;
    slope(&times[half..], &logarithms[half..]).unwrap_or(0.0)
}

/// Mean of the later half; smallest where there is none.
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
