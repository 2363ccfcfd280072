//! Exact steps of linear equations under inputs that are polynomials in time (exponential Adams method; M. Hochbruck & A. Ostermann,
//! *Acta Numerica* 19 (2010) 209, §2.5).

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::frame::Frame;
use super::padded::Padded;
use crate::numerics::ode::phi::exponential;
use crate::physics::frame::shaft::USUAL_DAMPING_RATIO;

/// Nodes of the inputs: the new one and two before.
pub(crate) const NODES: usize = 3;

/// A step of q̈ + C q̇ + K q = B u over x = (q, q̇).
#[derive(Debug, Clone)]
pub(crate) struct ExactStep {
    /// e^{hA}
    own: DMatrix<f64>,
    /// ∫ e^{A(h−t)} (0, B) (t/h)ᵐ dt over the step, m from 0.
    moments: [DMatrix<f64>; NODES],
}

/// Its matrices for inputs that are known at a number of nodes.
#[derive(Debug, Clone)]
pub(crate) struct Propagator {
    /// Shares of places and of velocities.
    own: [Padded; 2],
    /// Shares of the inputs at the nodes, newest first, side by side.
    inputs: Padded,
    /// Those of the newest node alone.
    newest: Padded,
}

impl ExactStep {
    /// A step of shaft and housing at a speed [rad/s].
    pub fn of(frame: &Frame, speed: f64, step: f64) -> Self {
        let [stiffness, damping] = frame.matrices(speed);
        let damping = damping + unresolved_damping(&frame.system.linear, step);
        Self::new(&stiffness, &damping, &frame.inputs, step)
    }

    /// `inputs`: B. `step`: h [s].
    fn new(stiffness: &DMatrix<f64>, damping: &DMatrix<f64>, inputs: &DMatrix<f64>, step: f64) -> Self {
        let (n, m) = inputs.shape();
        // C. F. Van Loan, IEEE Trans. Automat. Contr. 23 (1978) 395: the integrals are blocks of the exponential of a larger matrix,
        // over the state and the derivatives of the inputs by t/h.
        let mut generator = DMatrix::zeros(2 * n + NODES * m, 2 * n + NODES * m);
        generator.view_mut((0, n), (n, n)).fill_diagonal(step);
        generator.view_mut((n, 0), (n, n)).copy_from(&(stiffness * -step));
        generator.view_mut((n, n), (n, n)).copy_from(&(damping * -step));
        generator.view_mut((n, 2 * n), (n, m)).copy_from(&(inputs * step));
        for order in 1..NODES {
            generator.view_mut((2 * n + (order - 1) * m, 2 * n + order * m), (m, m)).fill_diagonal(1.0);
        }
        let whole = exponential(generator);
        // The derivative of (t/h)ᵐ is m!.
        let moment = |order: usize| whole.view((0, 2 * n + order * m), (2 * n, m)) * [1.0, 1.0, 2.0][order];
        Self { own: whole.view((0, 0), (2 * n, 2 * n)).into(), moments: std::array::from_fn(moment) }
    }

    /// Shares of the inputs at the nodes 1, 0 and −1 in place and velocity, of which the first `known` are used.
    pub fn of_inputs(&self, known: usize) -> [DMatrix<f64>; NODES] {
        let [constant, linear, square] = &self.moments;
        let none = || constant * 0.0;
        match known {
            1 => [constant.clone(), none(), none()],
            2 => [linear.clone(), constant - linear, none()],
            _ => [(linear + square) * 0.5, constant - square, (square - linear) * 0.5],
        }
    }

    pub fn propagator(&self, known: usize) -> Propagator {
        let n = self.own.nrows() / 2;
        let inputs = self.of_inputs(known);
        let columns: Vec<_> = inputs.iter().flat_map(DMatrix::column_iter).collect();
        Propagator {
            own: [0, n].map(|first| Padded::of(&self.own.columns(first, n).into())),
            inputs: Padded::of(&DMatrix::from_columns(&columns)),
            newest: Padded::of(&inputs[0]),
        }
    }
}

/// Damping that K and C without the factors of the speed lack for motions above half the rate of steps [s].
///
/// No force of a bearing or a load contains such a frequency. Undamped, the motion that a start or rounding leaves in them never ends, and its samples
/// are those of a slow one within the band. They get the least damping that a shaft and seats have by default.
fn unresolved_damping([stiffness, damping]: &[DMatrix<f64>; 2], step: f64) -> DMatrix<f64> {
    let n = stiffness.nrows();
    let eigen = (stiffness + stiffness.transpose()).scale(0.5).symmetric_eigen();
    let mut sum = DMatrix::zeros(n, n);
    for (square, motion) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        let frequency = square.max(0.0).sqrt();
        let lacking = 2.0 * USUAL_DAMPING_RATIO * frequency - motion.dot(&(damping * motion));
        if frequency * step > PI && lacking > 0.0 {
            sum += motion * motion.transpose() * lacking;
        }
    }
    sum
}

impl Propagator {
    /// Adds a share of the motion at the end of a step, under inputs at the nodes, newest first, one behind the other.
    #[inline(always)]
    pub fn add_step(&self, share: f64, motion: &[f64], inputs: &[f64], sums: &mut [f64]) {
        let (place, velocity) = motion.split_at(motion.len() / 2);
        self.own[0].add_product(share, place, sums);
        self.own[1].add_product(share, velocity, sums);
        self.inputs.add_product(share, inputs, sums);
    }

    /// Adds a share of the motion by a change of the first inputs at the new node.
    #[inline(always)]
    pub fn add_change(&self, share: f64, change: &[f64], sums: &mut [f64]) {
        self.newest.add_product(share, change, sums);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    /// Only the motion of 3·10⁶ rad/s is faster than half the rate of steps of 5 µs. Where it has enough damping, nothing is added.
    #[test]
    fn only_unresolved_motions_without_damping_get_some() {
        let stiffness = DMatrix::from_diagonal(&DVector::from_row_slice(&[1e8, 9e12]));
        for (ratio, expected) in [(0.0, 3e4), (0.002, 1.8e4), (0.01, 0.0)] {
            let damping = DMatrix::from_diagonal(&DVector::from_row_slice(&[0.0, 2.0 * ratio * 3e6]));
            let added = unresolved_damping(&[stiffness.clone(), damping], 5e-6);
            let off = added - DMatrix::from_diagonal(&DVector::from_row_slice(&[0.0, expected]));
            assert!(off.amax() < 1e-6, "{ratio}: {off}");
        }
    }

    /// The motion q = w t² under the parabola of its force is reached without error, whatever the frequencies, the damping and what couples them.
    #[test]
    fn a_parabola_is_exact() {
        let step = 3e-6_f64;
        let turning = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -1.0, 0.0]);
        for (frequencies, ratio, coupling) in
            [([0.0_f64, 0.0], 0.0_f64, 0.0), ([3e3, 5e3], 0.005, 0.0), ([4e5, 3e3], 0.02, 2e4), ([1e6, 1e6], 3.0, 5e6)]
        {
            let frequencies = DVector::from_row_slice(&frequencies);
            let stiffness = DMatrix::from_diagonal(&frequencies.map(|frequency| frequency * frequency));
            let damping = DMatrix::from_diagonal(&frequencies) * (2.0 * ratio) + &turning * coupling;
            let propagator = ExactStep::new(&stiffness, &damping, &DMatrix::identity(2, 2), step).propagator(NODES);
            // In units of the step.
            let weights = DVector::from_row_slice(&[1.0, -0.5]);
            let force = |t: f64| -> Vec<f64> {
                let of_damping = &damping * &weights * (2.0 * t * step);
                let of_stiffness = &stiffness * &weights * (t * t * step * step);
                (&weights * 2.0 + of_damping + of_stiffness).iter().map(|force| force / (step * step)).collect()
            };
            let motion = |t: f64| -> Vec<f64> {
                let place = weights.iter().map(|weight| weight * t * t);
                place.chain(weights.iter().map(|weight| weight * 2.0 * t / step)).collect()
            };
            let nodes = [1.5, 0.5, -0.5].map(force).concat();
            let mut end = vec![0.0; 4];
            propagator.add_step(1.0, &motion(0.5), &nodes, &mut end);
            for (k, (found, exact)) in end.iter().zip(motion(1.5)).enumerate() {
                let off = (found / exact - 1.0).abs();
                assert!(off < 1e-10, "{frequencies:?} {ratio} {coupling}, {k}: {found} {exact}");
            }
        }
    }
}
