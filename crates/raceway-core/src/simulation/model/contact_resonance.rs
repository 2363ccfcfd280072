//! Resonances of the spindle on its loaded contacts, which the impacts of defects excite.

use std::f64::consts::{PI, TAU};

use nalgebra::Matrix3;

use crate::physics::frames::{Vector, dot};
use crate::physics::kinematics::RingSpeeds;
use crate::simulation::model::equilibrium::spindle_stiffness;
use crate::simulation::model::mechanism::Mechanism;

/// Free vibration of the spindle on the contacts of its equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactResonance {
    /// [Hz]
    pub frequency: f64,
    /// Unit vector of the motion along X, Y, Z; its largest part is positive.
    pub direction: Vector,
}

impl ContactResonance {
    /// The band within an octave of the resonance [Hz].
    pub fn band(&self) -> (f64, f64) {
        (0.5 * self.frequency, 2.0 * self.frequency)
    }
}

/// Resonances under the loads at speeds of the rings [rad/s], the lowest first; empty without an equilibrium. Balls follow without inertia. The
/// stiffness is the mean of two positions: a ball under +Y, and half a ball spacing further.
pub fn contact_resonances(ideal: &Mechanism, speeds: impl Into<RingSpeeds>) -> Vec<ContactResonance> {
    let speeds = speeds.into();
    let stiffness = |turn: f64| {
        let turned = Mechanism { start: ideal.start.turned(turn), ..ideal.clone() };
        spindle_stiffness(&turned, speeds).ok()
    };
    let halfway = PI / ideal.layout.balls as f64;
    let Some((one, other)) = stiffness(0.0).zip(stiffness(halfway)) else { return Vec::new() };
    let modes = (0.5 * (one + other)).symmetric_eigen();
    let mut found: Vec<ContactResonance> = (0..3)
        // Held directions have no stiffness, free ones without contact a negative one by centrifugal force.
        .filter(|&mode| modes.eigenvalues[mode] > 0.0)
        .map(|mode| ContactResonance {
            frequency: (modes.eigenvalues[mode] / ideal.spindle_mass).sqrt() / TAU,
            direction: upright(&modes.eigenvectors, mode),
        })
        .collect();
    found.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    found
}

/// A column with a positive largest part.
fn upright(columns: &Matrix3<f64>, column: usize) -> Vector {
    let vector = columns.column(column);
    let sign = vector[vector.iamax()].signum();
    // Adding 0 turns −0 into 0.
    [0, 1, 2].map(|axis| sign * vector[axis] + 0.0)
}

/// The resonance that a push along a direction excites most.
pub fn excited_along(resonances: &[ContactResonance], direction: Vector) -> Option<ContactResonance> {
    let share = |of: &ContactResonance| dot(of.direction, direction).abs();
    resonances.iter().copied().max_by(|a, b| share(a).total_cmp(&share(b)))
}
