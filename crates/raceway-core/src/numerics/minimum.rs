//! The minimum of a function by a damped Newton search (Levenberg–Marquardt).

use super::bordered::Bordered;

/// A function such as a potential [J] of places [m].
pub(crate) trait Potential {
    /// Second derivatives.
    type Curvature;

    fn slopes(&self, place: &[f64]) -> Slopes<Self::Curvature>;

    /// The step −(H + μ)⁻¹ g from slopes with a damping μ; `None` unless the damped matrix is positive definite.
    fn step(&self, slopes: &Slopes<Self::Curvature>, damping: f64) -> Option<Vec<f64>>;
}

/// A function at a place, with its derivatives.
pub(crate) struct Slopes<H> {
    pub(crate) value: f64,
    pub(crate) gradient: Vec<f64>,
    /// The part of the gradient that belongs to no function, as of forces without a potential; empty where there is none.
    pub(crate) without_potential: Vec<f64>,
    pub(crate) hessian: H,
}

impl<const B: usize> Slopes<Bordered<B>> {
    /// The step −(H + μ)⁻¹ g with a damping μ.
    pub(crate) fn bordered_step(&self, damping: f64) -> Option<Vec<f64>> {
        let factor = self.hessian.clone().shifted(damping).factor()?;
        let mut step: Vec<f64> = self.gradient.iter().map(|slope| -slope).collect();
        factor.solve(&mut step);
        Some(step)
    }
}

impl<H> Slopes<H> {
    /// Largest entry of the gradient.
    pub(crate) fn residual(&self) -> f64 {
        largest(&self.gradient)
    }
}

/// Rules of a search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Search {
    /// Residual at which the search ends.
    pub(crate) converged: f64,
    pub(crate) longest_step: f64,
    /// Damping of the first step: a gradient over a length.
    pub(crate) first_damping: f64,
}

/// Largest number of steps, rejected ones included; a loaded bearing needs ten to thirty.
const MAX_STEPS: usize = 2000;
/// Smallest damping, and the one from which a step no longer moves anything.
const DAMPING_RANGE: [f64; 2] = [1e-9, 1e25];

impl Search {
    /// Moves a place to the minimum, and returns the derivatives there. They have the smallest residual that was found where it does not converge.
    pub(crate) fn minimise<P: Potential>(&self, potential: &P, place: &mut Vec<f64>) -> Slopes<P::Curvature> {
        let mut damping = self.first_damping;
        let more = |damping: f64| (10.0 * damping).max(DAMPING_RANGE[0]);
        let mut here = potential.slopes(place);
        for _ in 0..MAX_STEPS {
            if here.residual() <= self.converged {
                break;
            }
            let Some(mut step) = potential.step(&here, damping) else {
                damping = more(damping);
                continue;
            };
            let longest = largest(&step);
            if !longest.is_finite() {
                break;
            }
            if longest > self.longest_step {
                step.iter_mut().for_each(|part| *part *= self.longest_step / longest);
            }
            let next: Vec<f64> = place.iter().zip(&step).map(|(at, part)| at + part).collect();
            let there = potential.slopes(&next);
            // Close to the minimum the value no longer resolves the step, and the gradient decides.
            // Forces without a potential count as if they were constant on the way.
            let forces: f64 = here.without_potential.iter().zip(&step).map(|(force, part)| force * part).sum();
            if there.value + forces < here.value || there.residual() < here.residual() {
                (*place, here) = (next, there);
                damping = (0.1 * damping).max(DAMPING_RANGE[0]);
            } else {
                damping = more(damping);
                if damping > DAMPING_RANGE[1] {
                    break;
                }
            }
        }
        here
    }
}

/// Largest magnitude; NaN where a value is NaN.
fn largest(values: &[f64]) -> f64 {
    let larger = |most: f64, value: f64| if value > most || value.is_nan() { value } else { most };
    values.iter().map(|value| value.abs()).fold(0.0, larger)
}
