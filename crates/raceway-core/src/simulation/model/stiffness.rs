//! Stiffness of a model: the fastest rate of its equations, which limits the step of an explicit method.

use crate::numerics::ode::OdeSystem;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::system::Model;

/// The dominant mode of a linearised system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FastestMode {
    /// Magnitude of the eigenvalue [1/s].
    pub rate: f64,
    /// True if the mode decays rather than oscillates.
    pub decays: bool,
}

/// Number of power iterations; the start vector contains all modes, so that few suffice for an estimate.
const ITERATIONS: usize = 40;
/// Number of last iterations whose growth is averaged, because a pair of complex modes makes the growth beat.
const AVERAGED: usize = 20;
/// Displacement of the difference quotient, in sizes of the state's entries [-].
const DISPLACEMENT: f64 = 1e-3;
/// Longest step of Dormand–Prince times the rate of a mode that decays, and of one that oscillates.
const STABLE_DECAY: f64 = 3.3;
const STABLE_OSCILLATION: f64 = 1.0;

impl FastestMode {
    /// Longest stable step of the explicit method [s].
    pub(crate) fn stable_step(&self) -> f64 {
        (if self.decays { STABLE_DECAY } else { STABLE_OSCILLATION }) / self.rate
    }
}

/// The fastest mode at the start of a run: the faster of that with a centred cage and that with a cage displaced far enough for its
/// pockets to act.
pub(crate) fn fastest_mode(model: &Model, start: &[f64]) -> Result<FastestMode, SimulationError> {
    let layout = model.mechanism().layout;
    let mut displaced = start.to_vec();
    let mut cage = layout.cage(start);
    cage.centre[1] += 0.5 * model.mechanism().pocket.clearance();
    layout.set_cage(&mut displaced, &cage);
    let sizes = layout.sizes();
    let (centred, displaced) = (dominant_mode(model, start, &sizes), dominant_mode(model, &displaced, &sizes));
    Ok(if displaced.rate > centred.rate { displaced } else { centred })
}

/// The dominant eigenvalue of the Jacobian at a state, by power iteration on difference quotients.
fn dominant_mode(system: &impl OdeSystem, state: &[f64], sizes: &[f64]) -> FastestMode {
    let n = state.len();
    let (mut base, mut moved, mut rate) = (vec![0.0; n], state.to_vec(), vec![0.0; n]);
    system.derivative(0.0, state, &mut base);
    // Any vector without symmetry suffices.
    let mut direction: Vec<f64> = (0..n).map(|i| 1.0 + (i as f64 * 0.7).sin()).collect();
    let (mut growth, mut projection, mut averaged) = (0.0, 0.0, 0.0);
    for iteration in 0..ITERATIONS {
        let norm = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm == 0.0 || !norm.is_finite() {
            break;
        }
        for i in 0..n {
            direction[i] /= norm;
            moved[i] = state[i] + DISPLACEMENT * sizes[i] * direction[i];
        }
        system.derivative(0.0, &moved, &mut rate);
        let (mut squares, mut along) = (0.0, 0.0);
        for i in 0..n {
            let image = (rate[i] - base[i]) / (DISPLACEMENT * sizes[i]);
            squares += image * image;
            along += image * direction[i];
            direction[i] = image;
        }
        if iteration >= ITERATIONS - AVERAGED && squares > 0.0 && squares.is_finite() {
            growth += 0.5 * squares.ln();
            projection += along / squares.sqrt();
            averaged += 1.0;
        }
    }
    if averaged == 0.0 {
        return FastestMode { rate: 1.0, decays: true };
    }
    FastestMode { rate: (growth / averaged).exp().max(1.0), decays: projection / averaged < -0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x'' = −ω² x − c x' with a slow second oscillator.
    struct Oscillators {
        squared_frequency: f64,
        damping: f64,
    }
    impl OdeSystem for Oscillators {
        fn dimension(&self) -> usize {
            4
        }
        fn derivative(&self, _time: f64, y: &[f64], dy: &mut [f64]) {
            let fast = -self.squared_frequency * y[0] - self.damping * y[1];
            dy.copy_from_slice(&[y[1], fast, y[3], -1e4 * y[2]]);
        }
    }

    /// Closed forms: an undamped oscillator has ±iω, an overdamped one −c/2 − √(c²/4 − ω²).
    #[test]
    fn rates_of_oscillators() {
        let sizes = [1.0, 1e6, 1.0, 1e6];
        let undamped = dominant_mode(&Oscillators { squared_frequency: 1e12, damping: 0.0 }, &[0.0; 4], &sizes);
        assert!((undamped.rate / 1e6 - 1.0).abs() < 0.1 && !undamped.decays, "{undamped:?}");
        let overdamped = dominant_mode(&Oscillators { squared_frequency: 1e12, damping: 5e6 }, &[0.0; 4], &sizes);
        let exact = 2.5e6 + (6.25e12_f64 - 1e12).sqrt();
        assert!((overdamped.rate / exact - 1.0).abs() < 1e-3 && overdamped.decays, "{overdamped:?}");
    }
}
