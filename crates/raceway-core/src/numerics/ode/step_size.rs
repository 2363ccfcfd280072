//! Accept or reject a step, and the size of the first and of the next.

use super::system::OdeSystem;
use super::tolerances::Tolerances;

/// Weighted root mean square of `error`: at most 1 when each component errs within its tolerance.
/// NaN where an entry is NaN.
pub(crate) fn error_norm(error: &[f64], before: &[f64], after: &[f64], tolerances: &Tolerances) -> f64 {
    let sum: f64 = (0..error.len())
        .map(|i| {
            let size = before[i].abs().max(after[i].abs());
            (error[i] / tolerances.allowed(i, size)).powi(2)
        })
        .sum();
    (sum / error.len().max(1) as f64).sqrt()
}

/// Size of the first step of a method of `order`, at most `span` (time to the first stop). It follows from state,
/// `rate` and change of rate relative to their tolerances, with one evaluation.
///
/// The method is that of Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, §II.4, without its
/// constants that have a unit. With slope `d₁` and change of slope `d₂`, `τ = d₁/d₂` is the time in which the motion
/// changes. `d₁/τᵖ` approximates derivative p + 1, and the step satisfies `h^{p+1} d₁/τᵖ = 0.01`.
pub(crate) fn initial_step(
    system: &(impl OdeSystem + ?Sized),
    time: f64,
    state: &[f64],
    rate: &[f64],
    tolerances: &Tolerances,
    order: u32,
    span: f64,
) -> f64 {
    let norm = |entries: &[f64]| error_norm(entries, state, state, tolerances);
    let slope = norm(rate);
    // A hundredth of the time in which the state changes by itself; a state below its tolerance counts as that. Before
    // any motion only the span is known.
    let guess = if slope > 0.0 { (0.01 * norm(state).max(1.0) / slope).min(span) } else { 1e-3 * span };
    let moved: Vec<f64> = state.iter().zip(rate).map(|(y, slope)| y + guess * slope).collect();
    let mut change = vec![0.0; state.len()];
    system.derivative(time + guess, &moved, &mut change);
    for (change, before) in change.iter_mut().zip(rate) {
        *change = (*change - before) / guess;
    }
    let curvature = norm(&change);
    // Rates that overflow leave no time at all: a step must move it all the same.
    let shortest = f64::MIN_POSITIVE.max(16.0 * f64::EPSILON * time.abs());
    if !curvature.is_finite() {
        return (1e-3 * guess).max(shortest).min(span);
    }
    let power = f64::from(order);
    let step = (0.01 / slope * (slope / curvature).powf(power)).powf(1.0 / (power + 1.0));
    let step = if step.is_nan() { guess } else { step.min(100.0 * guess) };
    step.max(shortest).min(span)
}

/// The component that errs most against its tolerance, for error messages.
pub(crate) fn worst_component(error: &[f64], before: &[f64], after: &[f64], tolerances: &Tolerances) -> usize {
    largest(error.len(), |i| (error[i] / tolerances.allowed(i, before[i].abs().max(after[i].abs()))).abs())
}

/// Which of `count` sizes is the largest; NaN is larger than all.
pub(crate) fn largest(count: usize, size: impl Fn(usize) -> f64) -> usize {
    let size = |i: usize| Some(size(i)).filter(|size| !size.is_nan()).unwrap_or(f64::INFINITY);
    (0..count).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(0)
}

/// A step to try.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Try {
    pub step: f64,
    pub end: f64,
    /// The limit chose its size, so that it says little about the next one.
    pub cut: bool,
}

impl Try {
    /// `step` from `time`, to `limit` at the latest. A last step that would leave a sliver is stretched to the limit.
    pub(crate) fn new(time: f64, step: f64, limit: f64) -> Self {
        let remaining = limit - time;
        let cut = step * 1.000_001 >= remaining;
        if cut { Self { step: remaining, end: limit, cut } } else { Self { step, end: time + step, cut } }
    }

    /// The step that follows: `next` as the error of this one has it, where `asked` was to be tried.
    pub(crate) fn followed_by(&self, next: f64, asked: f64) -> f64 {
        if self.cut { next.max(asked) } else { next }
    }
}

/// Rejections in a row after which a step counts as impossible.
const MAX_REJECTIONS: u32 = 60;

/// Returns true where no shorter step can succeed: too many rejections, or a step at the rounding of the time.
pub(crate) fn is_impossible(rejections: u32, time: f64, next: f64) -> bool {
    rejections >= MAX_REJECTIONS || next <= 4.0 * f64::EPSILON * time.abs()
}

/// Returns true where rates that are not finite stay so for any shorter step.
pub(crate) fn stays_broken(rejections: u32) -> bool {
    rejections >= MAX_REJECTIONS / 2
}

/// Proportional–integral step-size control after Gustafsson, constants of Hairer, Nørsett & Wanner,
/// *Solving Ordinary Differential Equations I*, §IV.2 (DOPRI5). The integral part keeps the step
/// from oscillating where stability, not accuracy, limits it.
#[derive(Debug, Clone)]
pub(crate) struct StepSizeControl {
    /// 1 / (order of the error estimate + 1)
    exponent: f64,
    previous_error: f64,
    just_rejected: bool,
}

const SAFETY: f64 = 0.9;
const INTEGRAL: f64 = 0.04;
const MIN_FACTOR: f64 = 0.2;
const MAX_FACTOR: f64 = 10.0;

impl StepSizeControl {
    /// `order`: order of the error estimate.
    pub(crate) fn new(order: u32) -> Self {
        Self { exponent: 1.0 / f64::from(order + 1), previous_error: 1e-4, just_rejected: false }
    }

    /// Factor on the step after an error norm ≤ 1. A step that follows a rejection does not grow.
    pub(crate) fn accepted(&mut self, error: f64) -> f64 {
        let error = error.max(1e-10);
        let factor = SAFETY * error.powf(0.75 * INTEGRAL - self.exponent) * self.previous_error.powf(INTEGRAL);
        self.previous_error = error.max(1e-4);
        let most = if std::mem::take(&mut self.just_rejected) { 1.0 } else { MAX_FACTOR };
        factor.clamp(MIN_FACTOR, most)
    }

    /// Factor on the step after an error norm above 1 (NaN included).
    pub(crate) fn rejected(&mut self, error: f64) -> f64 {
        self.just_rejected = true;
        let factor = SAFETY * error.powf(-self.exponent);
        if factor.is_finite() { factor.clamp(0.1, 0.9) } else { 0.1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_at_tolerance_has_norm_one() {
        let tolerances = Tolerances::uniform(2, 0.0, 1e-3);
        assert_eq!(error_norm(&[1e-3, -1e-3], &[0.0; 2], &[0.0; 2], &tolerances), 1.0);
        assert!(error_norm(&[f64::NAN, 0.0], &[0.0; 2], &[0.0; 2], &tolerances).is_nan());
        assert_eq!(worst_component(&[1e-4, f64::NAN], &[0.0; 2], &[0.0; 2], &tolerances), 1);
    }

    /// `y' = rate · y`, or nothing.
    struct Growth(f64);
    impl OdeSystem for Growth {
        fn dimension(&self) -> usize {
            1
        }
        fn derivative(&self, _time: f64, state: &[f64], derivative: &mut [f64]) {
            derivative[0] = self.0 * state[0];
        }
    }

    /// Whatever the unit of time, the first step is the same part of the motion's own time.
    #[test]
    fn the_first_step_has_no_unit_of_its_own() {
        let first = |rate: f64, start: f64, span: f64| {
            let tolerances = Tolerances::uniform(1, 1e-6, 1e-9);
            initial_step(&Growth(rate), 0.0, &[start], &[rate * start], &tolerances, 5, span)
        };
        let slow = first(-1e-9, 1.0, 1e12) * 1e-9;
        let fast = first(-1e9, 1.0, 1e-6) * 1e9;
        assert!((slow / fast - 1.0).abs() < 1e-9 && (0.01..0.2).contains(&slow), "{slow} {fast}");
        assert_eq!(first(-1.0, 1.0, 1e-4), 1e-4);
        assert_eq!(first(0.0, 1.0, 1e3), 1.0);
        assert_eq!(first(0.0, 1.0, 1e-9), 1e-3 * 1e-9);
        assert!(first(f64::NAN, 1.0, 1.0) > 0.0);
    }

    #[test]
    fn a_step_ends_at_the_limit_without_a_sliver() {
        let tried = Try::new(1.0, 0.25, 2.0);
        assert_eq!((tried.step, tried.end, tried.cut), (0.25, 1.25, false));
        assert_eq!(tried.followed_by(0.1, 0.25), 0.1);
        for step in [0.999_999_5, 1.0, 3.0] {
            let tried = Try::new(1.0, step, 2.0);
            assert_eq!((tried.step, tried.end, tried.cut), (1.0, 2.0, true));
            assert_eq!(tried.followed_by(0.1, step), step);
        }
    }

    #[test]
    fn a_rejected_step_shrinks_and_the_next_does_not_grow() {
        let mut control = StepSizeControl::new(4);
        assert!(control.rejected(f64::NAN) == 0.1);
        assert!(control.rejected(2.0) < 0.9);
        assert!(control.accepted(1e-9) <= 1.0);
        assert!(control.accepted(1e-9) > 1.0);
    }
}
