//! Exact steps of single coordinates under a force that is a polynomial in time (exponential Adams method; M. Hochbruck & A. Ostermann,
//! *Acta Numerica* 19 (2010) 209, §2.5).

use crate::numerics::ode::phi::phi;

/// Nodes of the force: the new one and two before.
pub(crate) const NODES: usize = 3;

/// A step of q̈ + c q̇ + ω² q = g for each coordinate.
#[derive(Debug, Clone)]
pub(crate) struct Propagator {
    /// e^{hA} of each coordinate over its place and velocity, row by row.
    pub own: [Vec<f64>; 4],
    /// Shares of the force at the nodes, newest first, in place and velocity.
    pub place: [Vec<f64>; NODES],
    pub velocity: [Vec<f64>; NODES],
}

impl Propagator {
    /// `known`: number of nodes, the new one included, of which 1 to `NODES` are used.
    pub fn new(squares: &[f64], damping: &[f64], step: f64, known: usize) -> Self {
        let mut shares = Self { own: Default::default(), place: Default::default(), velocity: Default::default() };
        for (square, damping) in squares.iter().zip(damping) {
            let matrix = [0.0, step, -square * step, -damping * step];
            let functions = phi(&matrix, 2);
            let one = &functions[0];
            // e^Z = 1 + Z φ₁.
            let product =
                |row: usize, column: usize| matrix[2 * row] * one[column] + matrix[2 * row + 1] * one[2 + column];
            let own = [1.0 + product(0, 0), product(0, 1), product(1, 0), 1.0 + product(1, 1)];
            shares.own.iter_mut().zip(own).for_each(|(entries, entry)| entries.push(entry));
            // ∫ e^{A(h−t)} (0, 1) (t/h)^m dt = h m! φ_{m+1} (0, 1).
            let moments = |row: usize| {
                [1.0, 1.0, 2.0]
                    .map(|factorial| step * factorial)
                    .into_iter()
                    .enumerate()
                    .map(move |(m, factor)| (m, row, factor))
            };
            let of = |row: usize| -> [f64; NODES] {
                let mut values = [0.0; NODES];
                moments(row).for_each(|(m, row, factor)| values[m] = factor * functions[m][2 * row + 1]);
                through_nodes(values, known)
            };
            let (place, velocity) = (of(0), of(1));
            for node in 0..NODES {
                shares.place[node].push(place[node]);
                shares.velocity[node].push(velocity[node]);
            }
        }
        shares
    }

    /// Advances places and velocities by a step, under forces at the nodes, newest first.
    #[inline(always)]
    pub fn advance(&self, place: &mut [f64], velocity: &mut [f64], forces: [&[f64]; NODES]) {
        // Slices of one known length need no check in the loop.
        let size = self.own[0].len();
        let (place, velocity) = (&mut place[..size], &mut velocity[..size]);
        let forces = forces.map(|forces| &forces[..size]);
        let [to_place, to_velocity] =
            [&self.place, &self.velocity].map(|shares| shares.each_ref().map(|of| &of[..size]));
        let [by_place, by_velocity, back, own] = self.own.each_ref().map(|of| &of[..size]);
        for k in 0..size {
            let (q, v) = (place[k], velocity[k]);
            // No closure: one that is called apart has no lanes.
            let [new, now, before] = [forces[0][k], forces[1][k], forces[2][k]];
            let [to_q, to_v] = [&to_place, &to_velocity];
            place[k] =
                by_place[k] * q + by_velocity[k] * v + (to_q[0][k] * new + to_q[1][k] * now + to_q[2][k] * before);
            velocity[k] = back[k] * q + own[k] * v + (to_v[0][k] * new + to_v[1][k] * now + to_v[2][k] * before);
        }
    }

    /// Adds the effect of additional forces at the new node.
    #[inline(always)]
    pub fn add(&self, place: &mut [f64], velocity: &mut [f64], forces: &[f64]) {
        for ((place, force), share) in place.iter_mut().zip(forces).zip(&self.place[0]) {
            *place += share * force;
        }
        for ((velocity, force), share) in velocity.iter_mut().zip(forces).zip(&self.velocity[0]) {
            *velocity += share * force;
        }
    }
}

/// Shares of the forces at the nodes 1, 0 and −1, by the moments of the powers 1, t, t².
fn through_nodes([constant, linear, square]: [f64; NODES], known: usize) -> [f64; NODES] {
    match known {
        1 => [constant, 0.0, 0.0],
        2 => [linear, constant - linear, 0.0],
        _ => [0.5 * (linear + square), constant - square, 0.5 * (square - linear)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola of the force is integrated without error, whatever the frequency and the damping.
    #[test]
    fn a_parabola_is_exact() {
        let step = 3e-6_f64;
        for (frequency, ratio) in [(0.0_f64, 0.0_f64), (3e3, 0.005), (4e5, 0.02), (1e6, 3.0)] {
            let (square, damping) = (frequency * frequency, 2.0 * ratio * frequency);
            let propagator = Propagator::new(&[square], &[damping], step, 3);
            // q = t³ + t² by construction; in units of the step.
            let place = |t: f64| t * t;
            let velocity = |t: f64| 2.0 * t;
            let force = |t: f64| 2.0 + damping * step * velocity(t) + square * step * step * place(t);
            let [to_place, by_velocity, back, own] = propagator.own.each_ref().map(|of| of[0]);
            let (q, v) = (place(0.5), velocity(0.5));
            let nodes = [1.5, 0.5, -0.5].map(force);
            let sum =
                |shares: &[Vec<f64>; NODES]| -> f64 { (0..NODES).map(|node| shares[node][0] * nodes[node]).sum() };
            let end = to_place * q + by_velocity * v / step + sum(&propagator.place) / (step * step);
            let rate = back * q * step + own * v + sum(&propagator.velocity) / step;
            assert!(
                (end - place(1.5)).abs() < 1e-11 && (rate - velocity(1.5)).abs() < 1e-10,
                "{frequency}: {end} {rate}"
            );
        }
    }
}
