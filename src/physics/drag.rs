//! Forces of the lubricant–air mixture through which the balls move.

use std::f64::consts::PI;

use super::bearing::Bearing;
use super::lubricant::Lubricant;
use crate::numerics::exponential::power;

/// Drag coefficient of a sphere over Reynolds number, points read off a plot of the standard drag curve; log-log between
/// them, 27.5/Re below (Stokes: 24/Re), constant above, where the drag crisis is left out. Up to 14 % above the curve
/// from 0.1 to 10⁴, 9 % below it at 10⁵ (`docs/VERIFICATION.md`).
const DRAG_COEFFICIENT: [(f64, f64); 7] =
    [(0.1, 275.0), (1.0, 30.0), (10.0, 4.2), (100.0, 1.2), (1e3, 0.48), (1e4, 0.40), (1e5, 0.45)];

/// Drag coefficient `C_d` of a sphere [-], Reynolds number with its diameter.
pub fn drag_coefficient(reynolds: f64) -> f64 {
    let points = &DRAG_COEFFICIENT;
    let last = points.len() - 1;
    if reynolds <= points[0].0 {
        return points[0].0 * points[0].1 / reynolds;
    }
    if reynolds >= points[last].0 {
        return points[last].1;
    }
    let next = points.partition_point(|point| point.0 < reynolds);
    let (low, high) = (points[next - 1], points[next]);
    let share = (reynolds / low.0).ln() / (high.0 / low.0).ln();
    low.1 * (high.1 / low.1).powf(share)
}

/// Moment coefficient `C_n` of a sphere that spins in place [-], Reynolds number ρ ω r²/η.
///
/// C_n = 6.45/√Re + 32.1/Re, laminar flow about a sphere in free fluid, which literature on particles in a flow credits to
/// Dennis, Singh & Ingham (J. Fluid Mech. 101, 1980; as 12.9/√Re + 128.4/Re with the diameter). At Re below about 10 the truth
/// is the Stokes limit 16π/Re, half as much again; in a bearing the mixture turns with the balls.
pub fn churning_coefficient(reynolds: f64) -> f64 {
    6.45 / reynolds.sqrt() + 32.1 / reynolds
}

/// Drag on the orbit and churning of the spin of one ball, made once a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag {
    /// Re at 1 m/s [s/m].
    reynolds_per_speed: f64,
    /// F / V² at C_d = 1 [N s²/m²].
    force_at_unit_coefficient: f64,
    /// F / V below the table [N s/m].
    stokes_factor: f64,
    /// C_d / Re^exponent from each point of the table to the next, and the exponent.
    segments: [(f64, f64); DRAG_COEFFICIENT.len() - 1],
    /// M / ω at rest [N m s].
    churning_linear: f64,
    /// M / ω^1.5 besides [N m s^1.5].
    churning_root: f64,
}

impl Drag {
    /// Prepares drag and churning of a ball in the mixture that the fill of the bearing gives.
    pub fn new(bearing: &Bearing, lubricant: &Lubricant) -> Self {
        let d = bearing.parameters.ball_diameter;
        let radius = 0.5 * d;
        let density = lubricant.mixture_density();
        // A mixture of pure, inviscid oil is no fluid; its Reynolds number only has to stay finite.
        let viscosity = lubricant.mixture_viscosity().max(1e-9);
        let reynolds_per_speed = density * d / viscosity;
        let force_at_unit_coefficient = 0.5 * density * PI * d * d / 4.0;
        let (first, slowest) = (DRAG_COEFFICIENT[0], DRAG_COEFFICIENT[0].0 / reynolds_per_speed);
        let mut segments = [(0.0, 0.0); DRAG_COEFFICIENT.len() - 1];
        for (segment, pair) in segments.iter_mut().zip(DRAG_COEFFICIENT.windows(2)) {
            let exponent = (pair[1].1 / pair[0].1).ln() / (pair[1].0 / pair[0].0).ln();
            *segment = (pair[0].1 / pair[0].0.powf(exponent), exponent);
        }
        let spin_reynolds = density * radius * radius / viscosity;
        let moment_at_unit_coefficient = 0.5 * density * radius.powi(5);
        Self {
            reynolds_per_speed,
            force_at_unit_coefficient,
            stokes_factor: force_at_unit_coefficient * first.1 * slowest,
            segments,
            churning_linear: moment_at_unit_coefficient * 32.1 / spin_reynolds,
            churning_root: moment_at_unit_coefficient * 6.45 / spin_reynolds.sqrt(),
        }
    }

    /// Force on a ball along its orbit [N], against its velocity V = D_m θ̇/2 [m/s]; linear at rest.
    ///
    /// Harris, Rolling Bearing Analysis: F_D = ½ ρ_e C_d (π d²/4) V |V|, Re = ρ_e |V| d/η_e.
    #[inline(always)]
    pub fn force(&self, orbit_velocity: f64) -> f64 {
        let speed = orbit_velocity.abs();
        let reynolds = self.reynolds_per_speed * speed;
        // The last segment that begins below; beyond the table C_d is its last value.
        let (mut factor, mut exponent) = self.segments[0];
        // By index: an iterator that skips is a branch, and branches keep balls apart.
        #[allow(clippy::needless_range_loop)]
        for i in 1..self.segments.len() {
            let reached = reynolds >= DRAG_COEFFICIENT[i].0;
            factor = if reached { self.segments[i].0 } else { factor };
            exponent = if reached { self.segments[i].1 } else { exponent };
        }
        let (end, last) = DRAG_COEFFICIENT[DRAG_COEFFICIENT.len() - 1];
        let in_table = factor * power(reynolds, exponent);
        let coefficient = if reynolds >= end { last } else { in_table };
        let force = -self.force_at_unit_coefficient * coefficient * speed * orbit_velocity;
        if reynolds <= DRAG_COEFFICIENT[0].0 { -self.stokes_factor * orbit_velocity } else { force }
    }

    /// Moment on a ball [N m] against its spin [rad/s], by components; linear at rest.
    ///
    /// M = −½ ρ_e C_n |ω| ω (d/2)⁵ with `churning_coefficient`.
    #[inline(always)]
    pub fn churning_moment(&self, spin: [f64; 3]) -> [f64; 3] {
        let squared = spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2];
        let factor = -self.churning_factor(squared.sqrt());
        [factor * spin[0], factor * spin[1], factor * spin[2]]
    }

    /// Magnitude of the churning moment over that of the spin [N m s], spin a magnitude [rad/s].
    #[inline(always)]
    pub fn churning_factor(&self, spin: f64) -> f64 {
        self.churning_linear + self.churning_root * spin.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::examples::{article_bearing, article_lubricant};
    use crate::physics::kinematics::{ideal_orbit_ratio, ideal_spin_ratio};

    const SPEED: f64 = 50_000.0 * std::f64::consts::TAU / 60.0;

    /// The table, and half way between two of its points on the log-log line, to rounding.
    #[test]
    fn drag_coefficient_follows_the_table() {
        for (reynolds, coefficient) in DRAG_COEFFICIENT {
            assert!((drag_coefficient(reynolds) / coefficient - 1.0).abs() < 1e-12);
        }
        let between = drag_coefficient(10f64.powf(1.5));
        assert!((between - (4.2f64 * 1.2).sqrt()).abs() < 1e-12);
        assert!((drag_coefficient(0.01) - 2750.0).abs() < 1e-9);
        assert_eq!(drag_coefficient(1e7), 0.45);
    }

    /// Article's case at ideal orbit speed: Re 1690, F_D 0.0115 N, given as 0.011 N.
    #[test]
    fn drag_of_the_article_bearing() {
        let bearing = article_bearing();
        let drag = Drag::new(&bearing, &article_lubricant());
        let velocity = 0.5 * bearing.parameters.pitch_diameter * ideal_orbit_ratio(&bearing) * SPEED;
        assert!((drag.reynolds_per_speed * velocity / 1690.0 - 1.0).abs() < 3e-3);
        assert!((drag.force(velocity) + 0.0115).abs() < 1e-4);
        assert_eq!(drag.force(-velocity), -drag.force(velocity));
    }

    /// The prepared force is the printed one at every Reynolds number, and passes through 0 linearly.
    #[test]
    fn prepared_drag_repeats_the_formula() {
        let (bearing, lubricant) = (article_bearing(), article_lubricant());
        let drag = Drag::new(&bearing, &lubricant);
        let d = bearing.parameters.ball_diameter;
        for velocity in [1e-6, 1e-4, 0.01, 0.3, 13.0, 500.0, 3e4] {
            let reynolds = lubricant.mixture_density() * velocity * d / lubricant.mixture_viscosity();
            let printed = -0.5 * lubricant.mixture_density() * drag_coefficient(reynolds) * PI * d * d / 4.0
                * velocity
                * velocity;
            assert!((drag.force(velocity) / printed - 1.0).abs() < 1e-12);
        }
        assert_eq!(drag.force(0.0), 0.0);
        let dry = Lubricant { viscosity: 0.0, fill: 1.0, ..lubricant };
        assert!(Drag::new(&bearing, &dry).force(10.0).is_finite());
    }

    /// The prepared moment is the printed one, against the spin, along it, and finite at rest.
    #[test]
    fn churning_repeats_the_formula() {
        let (bearing, lubricant) = (article_bearing(), article_lubricant());
        let drag = Drag::new(&bearing, &lubricant);
        let radius = 0.5 * bearing.parameters.ball_diameter;
        let spin = SPEED * ideal_spin_ratio(&bearing);
        let reynolds = lubricant.mixture_density() * spin.abs() * radius * radius / lubricant.mixture_viscosity();
        let printed = 0.5 * lubricant.mixture_density() * churning_coefficient(reynolds) * spin * spin * radius.powi(5);
        let moment = drag.churning_moment([0.6 * spin, 0.0, -0.8 * spin]);
        assert!((moment[0] / (0.6 * printed) - 1.0).abs() < 1e-12);
        assert!((moment[2] / (-0.8 * printed) - 1.0).abs() < 1e-12);
        assert_eq!(drag.churning_moment([0.0; 3]), [0.0; 3]);
    }
}
