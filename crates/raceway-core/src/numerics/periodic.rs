//! Periodic motions by shooting: the fixed point of the map that one period of a flow is, and its Floquet multipliers.
//!
//! A fixed point does not show its own stability. An orbit with multipliers outside the unit circle is a solution from
//! which neighbouring motions depart. The multipliers are therefore part of the result.

use nalgebra::{DMatrix, DVector, Schur};

/// Settings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Search<const N: usize> {
    /// Size of each entry of the state, the unit of its errors. Difference quotients step by 10⁻⁵ of it.
    pub sizes: [f64; N],
    /// Largest error of an entry over its size.
    pub tolerance: f64,
    /// Newton steps, fresh matrices or not.
    pub iterations: usize,
}

/// A periodic motion.
#[derive(Debug, Clone, PartialEq)]
pub struct PeriodicOrbit<const N: usize> {
    /// State at the start of the period.
    pub state: [f64; N],
    /// Floquet multipliers (real, imaginary), largest modulus first.
    pub multipliers: Vec<(f64, f64)>,
    /// ∂(state after a period)/∂(state).
    pub monodromy: DMatrix<f64>,
    /// Periods integrated to find it.
    pub periods: u64,
}

impl<const N: usize> PeriodicOrbit<N> {
    /// Largest modulus of a multiplier: by how much a disturbance grows in a period.
    pub fn radius(&self) -> f64 {
        self.multipliers.first().map_or(0.0, |(re, im)| re.hypot(*im))
    }
}

/// Reason why no periodic orbit was found.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoOrbit {
    #[error(
        "no periodic motion was found: {error:.1e} of the motion's size is left after {iterations} steps of Newton's method"
    )]
    NotConverged { error: f64, iterations: usize },
    #[error("the periodic motion is not finite")]
    NotFinite,
    #[error("the multipliers of the periodic motion were not found within {MAX_ROTATIONS} iterations")]
    NoMultipliers,
}

/// Share by which a step with an old matrix has to reduce the error; and below which the matrix is taken for right.
const SLOW: f64 = 0.2;
const RIGHT: f64 = 0.02;
/// Step of the difference quotients, and the longest of Newton's method, in sizes.
const DIFFERENCE: f64 = 1e-5;
const FARTHEST: f64 = 1e4;
/// Iterations of the QR method for all multipliers; it takes a few for each, and can go in circles for ever.
const MAX_ROTATIONS: usize = 200;

impl<const N: usize> Search<N> {
    /// The periodic motion near a guess; `period` carries a state over one period.
    pub(crate) fn find(
        &self,
        guess: [f64; N],
        period: impl Fn(&[f64; N]) -> [f64; N],
    ) -> Result<PeriodicOrbit<N>, NoOrbit> {
        self.search(guess, None, period)
    }

    /// The same motion on a slightly other flow, such as one with finer steps; its multipliers are still those of the other.
    pub(crate) fn refine(
        &self,
        orbit: &PeriodicOrbit<N>,
        period: impl Fn(&[f64; N]) -> [f64; N],
    ) -> Result<PeriodicOrbit<N>, NoOrbit> {
        self.search(orbit.state, Some(orbit.monodromy.clone()), period)
    }

    /// With the multipliers of this flow.
    pub(crate) fn measured(
        &self,
        orbit: PeriodicOrbit<N>,
        period: impl Fn(&[f64; N]) -> [f64; N],
    ) -> Result<PeriodicOrbit<N>, NoOrbit> {
        let monodromy = self.monodromy(&orbit.state, &period(&orbit.state), &period);
        let periods = orbit.periods + 1 + N as u64;
        Ok(PeriodicOrbit { multipliers: multipliers(&monodromy)?, monodromy, periods, ..orbit })
    }

    fn search(
        &self,
        guess: [f64; N],
        mut matrix: Option<DMatrix<f64>>,
        period: impl Fn(&[f64; N]) -> [f64; N],
    ) -> Result<PeriodicOrbit<N>, NoOrbit> {
        let mut state = guess;
        let mut image = period(&state);
        let mut periods = 1;
        let mut error = self.error(&state, &image)?;
        // True where the matrix has proved accurate at the present state.
        let mut right = matrix.is_some();
        for _ in 0..self.iterations {
            if error <= self.tolerance && right {
                break;
            }
            let monodromy = matrix.get_or_insert_with(|| {
                periods += N as u64;
                self.monodromy(&state, &image, &period)
            });
            let defect = DVector::from_iterator(N, (0..N).map(|i| image[i] - state[i]));
            let Some(step) = (DMatrix::identity(N, N) - &*monodromy).lu().solve(&defect) else { break };
            if !(0..N).all(|i| step[i].abs() < FARTHEST * self.sizes[i]) {
                break;
            }
            let next: [f64; N] = std::array::from_fn(|i| state[i] + step[i]);
            let next_image = period(&next);
            periods += 1;
            let next_error = self.error(&next, &next_image)?;
            right = next_error < RIGHT * error || next_error < self.tolerance && error < 1e3 * self.tolerance;
            if next_error > SLOW * error && next_error > self.tolerance {
                matrix = None;
            }
            (state, image, error) = (next, next_image, next_error);
        }
        if error > self.tolerance {
            return Err(NoOrbit::NotConverged { error, iterations: self.iterations });
        }
        let monodromy = matrix.unwrap_or_else(|| self.monodromy(&state, &image, &period));
        Ok(PeriodicOrbit { state, multipliers: multipliers(&monodromy)?, monodromy, periods })
    }

    fn error(&self, state: &[f64; N], image: &[f64; N]) -> Result<f64, NoOrbit> {
        let error = (0..N).map(|i| (image[i] - state[i]).abs() / self.sizes[i]).fold(0.0, f64::max);
        if image.iter().all(|value| value.is_finite()) { Ok(error) } else { Err(NoOrbit::NotFinite) }
    }

    /// ∂(state after a period)/∂(state), by difference quotients.
    fn monodromy(&self, state: &[f64; N], image: &[f64; N], period: &impl Fn(&[f64; N]) -> [f64; N]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(N, N);
        for column in 0..N {
            let mut moved = *state;
            moved[column] += DIFFERENCE * self.sizes[column];
            let by = moved[column] - state[column];
            let there = period(&moved);
            for row in 0..N {
                matrix[(row, column)] = (there[row] - image[row]) / by;
            }
        }
        matrix
    }
}

/// Eigenvalues, largest modulus first.
fn multipliers(monodromy: &DMatrix<f64>) -> Result<Vec<(f64, f64)>, NoOrbit> {
    if !monodromy.iter().all(|value| value.is_finite()) {
        return Err(NoOrbit::NotFinite);
    }
    let schur = Schur::try_new(monodromy.clone(), f64::EPSILON, MAX_ROTATIONS).ok_or(NoOrbit::NoMultipliers)?;
    let mut all: Vec<(f64, f64)> = schur.complex_eigenvalues().iter().map(|value| (value.re, value.im)).collect();
    all.sort_by(|a, b| b.0.hypot(b.1).total_cmp(&a.0.hypot(a.1)));
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::ode::adams_moulton::{Motion, runge_kutta};
    use std::f64::consts::TAU;

    /// One period of a forced oscillator by Runge–Kutta.
    fn period(equations: &impl Fn(f64, &Motion<1>) -> [f64; 1], length: f64, state: &[f64; 2]) -> [f64; 2] {
        let steps = 2000;
        let step = length / f64::from(steps);
        let (q, v) = (0..steps).fold(([state[0]], [state[1]]), |motion, k| {
            let time = f64::from(k) * step;
            runge_kutta(time, &motion, &equations(time, &motion), step, equations)
        });
        [q[0], v[0]]
    }

    const SEARCH: Search<2> = Search { sizes: [1.0; 2], tolerance: 1e-10, iterations: 30 };

    /// q̈ + 2ζω q̇ + ω² q = cos t: amplitude and phase of the closed form, multipliers e^(λT).
    #[test]
    fn a_forced_linear_oscillator_has_its_orbit_and_multipliers() {
        let (omega, zeta) = (1.7_f64, 0.05_f64);
        let equations = |t: f64, (q, v): &Motion<1>| [t.cos() - 2.0 * zeta * omega * v[0] - omega * omega * q[0]];
        let orbit = SEARCH.find([0.0; 2], |state| period(&equations, TAU, state)).unwrap();
        let (a, b) = (omega * omega - 1.0, 2.0 * zeta * omega);
        let (cosine, sine) = (a / (a * a + b * b), b / (a * a + b * b));
        assert!((orbit.state[0] - cosine).abs() < 1e-8 && (orbit.state[1] - sine).abs() < 1e-8, "{orbit:?}");
        let decay = (-zeta * omega * TAU).exp();
        let turn = omega * (1.0 - zeta * zeta).sqrt() * TAU;
        assert!((orbit.radius() - decay).abs() < 1e-7);
        for (re, im) in &orbit.multipliers {
            assert!((re - decay * turn.cos()).abs() < 1e-7 && (im.abs() - (decay * turn.sin()).abs()).abs() < 1e-7);
        }
    }

    /// Duffing's q̈ + 0.1 q̇ + q + q³ = 0.2 cos 1.4 t: the small and the large orbit are stable, and the one between is
    /// reported as a saddle. The product of the multipliers is e^(−0.1 T) on each (Liouville).
    #[test]
    fn all_three_orbits_of_duffing_are_found_and_the_saddle_is_unstable() {
        let equations = |t: f64, (q, v): &Motion<1>| [0.2 * (1.4 * t).cos() - 0.1 * v[0] - q[0] - q[0].powi(3)];
        let length = TAU / 1.4;
        // Amplitudes by harmonic balance, as guesses: (1 − ω² + ¾a²)² a² + (0.1 ω a)² = 0.04.
        let mut radii = Vec::new();
        for amplitude in [0.214, 1.053, 1.186] {
            let in_phase: f64 = (1.0 - 1.96 + 0.75 * amplitude * amplitude) * amplitude / 0.2;
            let out_of_phase = (1.0 - in_phase * in_phase).max(0.0).sqrt();
            let guess = [amplitude * in_phase, 1.4 * amplitude * out_of_phase];
            let Ok(orbit) = SEARCH.find(guess, |state| period(&equations, length, state)) else { continue };
            let product = orbit.multipliers.iter().fold((1.0, 0.0), |(a, b), (c, d)| (a * c - b * d, a * d + b * c));
            assert!((product.0 - (-0.1 * length).exp()).abs() < 1e-4 && product.1.abs() < 1e-4, "{product:?}");
            radii.push(orbit.radius());
        }
        assert!(radii.len() == 3 && radii[0] < 1.0 && radii[1] > 1.0 && radii[2] < 1.0, "{radii:?}");
    }

    /// Mathieu's q̈ + 0.02 q̇ + (1 + ε cos 2t) q = 0 within the first tongue: rest is periodic and unstable, with a
    /// multiplier of about −e^((ε/4 − 0.01) π). Without the parametric excitation it decays.
    #[test]
    fn rest_on_a_swinging_spring_is_unstable_within_the_tongue() {
        for (swing, unstable) in [(0.0, false), (0.2, true)] {
            let equations = |t: f64, (q, v): &Motion<1>| [-0.02 * v[0] - (1.0 + swing * (2.0 * t).cos()) * q[0]];
            let orbit = SEARCH.find([0.3, 0.1], |state| period(&equations, TAU / 2.0, state)).unwrap();
            assert!(orbit.state.iter().all(|value| value.abs() < 1e-9));
            let expected = ((swing / 4.0 - 0.01) * TAU / 2.0).exp();
            assert_eq!(orbit.radius() > 1.0, unstable);
            assert!((orbit.radius() / expected - 1.0).abs() < 5e-3, "{}", orbit.radius());
            assert!(!unstable || orbit.multipliers[0].0 < -1.0);
        }
    }

    /// From the orbit of a flow to that of one with other steps, with the matrix of the first.
    #[test]
    fn an_orbit_is_followed_to_a_finer_flow_with_few_periods() {
        let equations = |t: f64, (q, v): &Motion<1>| [0.2 * (1.4 * t).cos() - 0.1 * v[0] - q[0] - q[0].powi(3)];
        let length = TAU / 1.4;
        let rough = |state: &[f64; 2]| period(&equations, length, state).map(|value| 1.0001 * value);
        let found = SEARCH.find([0.0; 2], rough).unwrap();
        let refined = SEARCH.refine(&found, |state| period(&equations, length, state)).unwrap();
        let direct = SEARCH.find([0.0; 2], |state| period(&equations, length, state)).unwrap();
        assert!((0..2).all(|i| (refined.state[i] - direct.state[i]).abs() < 1e-9));
        assert!((found.state[0] - direct.state[0]).abs() > 1e-7 && refined.periods < direct.periods);
        let measured = SEARCH.measured(refined.clone(), |state| period(&equations, length, state)).unwrap();
        assert!((measured.radius() / direct.radius() - 1.0).abs() < 1e-5 && measured.radius() != refined.radius());
    }

    #[test]
    fn a_flow_that_only_drifts_has_no_orbit() {
        assert!(matches!(SEARCH.find([0.0; 2], |s| [s[0] + 1.0, 0.5 * s[1]]), Err(NoOrbit::NotConverged { .. })));
        assert_eq!(SEARCH.find([0.0; 2], |_| [f64::NAN; 2]), Err(NoOrbit::NotFinite));
    }

    /// The QR method would not end on entries that are not finite.
    #[test]
    fn a_flow_whose_slope_is_no_number_has_no_orbit() {
        let nothing = Search { sizes: [0.0; 2], ..SEARCH };
        assert_eq!(nothing.find([0.0; 2], |state| *state), Err(NoOrbit::NotFinite));
    }
}
