//! Renewal of the linear part and its weights.

use super::FineAbm;
use super::diagonal::Diagonal;
use super::linear_part::{LinearPart, MAX_PATIENCE, MIN_PATIENCE, Renewal};
use super::weights::Weights;
use crate::numerics::ode::structure::displacements;
use crate::numerics::ode::system::OdeSystem;

/// `h |∂f/∂y|` at which the linear part counts as outdated.
const OUTDATED: f64 = 0.5;
impl<S: OdeSystem + ?Sized> FineAbm<'_, S> {
    /// Weights of the present step, computed where they are not at hand.
    pub(super) fn prepare_weights(&mut self) -> usize {
        if self.part == LinearPart::Blocks && !self.renewal.taken {
            self.renew_linear_part();
        }
        let at_hand = |weights: &[Weights], step: f64| weights.iter().position(|weights| weights.step == step);
        if let Some(index) = at_hand(&self.weights, self.step) {
            return index;
        }
        let half = at_hand(&self.weights, 0.5 * self.step).unwrap_or_else(|| {
            self.weights.push(Weights::new(&self.linear, 0.5 * self.step));
            self.statistics.factorizations += 1;
            self.weights.len() - 1
        });
        self.weights.push(self.weights[half].doubled(&self.linear));
        self.weights.len() - 1
    }

    /// Takes the blocks of the Jacobian at the newest point for `H`, and moves what that adds out of `f`.
    fn renew_linear_part(&mut self) {
        displacements(self.past.state(), &self.rate, &self.tolerances, self.step, &mut self.displacement);
        let (state, rate) = (self.past.state(), &self.rate);
        let evaluations = self.system.jacobian(self.grid_time, state, rate, &self.displacement, &mut self.jacobian);
        self.statistics.rhs_evaluations += evaluations;
        self.statistics.jacobian_evaluations += 1;
        (self.renewal.taken, self.renewal.age) = (true, 0);
        if !self.jacobian.is_finite() {
            return;
        }
        let renewed = Diagonal::of(&self.jacobian);
        for (state, rest) in self.past.states.iter().zip(&mut self.past.rests).take(self.past.kept) {
            self.linear.add_product(1.0, state, rest, &self.structure);
            renewed.add_product(-1.0, state, rest, &self.structure);
        }
        self.linear = renewed;
        self.weights.clear();
    }

    /// Renews the linear part where it is outdated.
    pub(super) fn renew_where_outdated(&mut self) {
        let outdated = self.part == LinearPart::Blocks && self.rate_of_rest > OUTDATED;
        let Renewal { age, patience, .. } = &mut self.renewal;
        if *age == 1 {
            // The renewal did not help: the fast modes lie outside the blocks.
            *patience = if outdated { (2 * *patience).min(MAX_PATIENCE) } else { MIN_PATIENCE };
        }
        if outdated && *age >= *patience {
            self.renew_linear_part();
            self.rate_of_rest = 0.0;
        }
    }
}
