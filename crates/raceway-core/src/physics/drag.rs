//! Forces of the lubricant–air mixture through which the balls move.

use std::f64::consts::PI;

use super::bearing::Bearing;
use super::lubricant::Lubricant;
use crate::numerics::exponential::{exponential, logarithm};
use crate::numerics::lanes::larger;

/// Drag coefficient `C_d` of a sphere [-], Reynolds number ρ V d/η.
///
/// C_d = 24/Re (1 + 0.15 Re^0.687) + 0.42/(1 + 42500 Re^−1.16): Clift & Gauvin 1971 after Schiller & Naumann, within 6 % of
/// measurements up to Re 3·10⁵, where the drag crisis begins, which is left out.
pub fn drag_coefficient(reynolds: f64) -> f64 {
    let wake = 0.42 / (1.0 + 4.25e4 * reynolds.powf(-1.16));
    24.0 / reynolds * (1.0 + 0.15 * reynolds.powf(0.687)) + wake
}

/// Moment coefficient `C_n` of a sphere that spins in place [-], Reynolds number ρ ω r²/η.
///
/// C_n = 6.45/√Re + 32.1/Re, laminar flow about a sphere in free fluid, which literature on particles in a flow credits to
/// Dennis, Singh & Ingham (J. Fluid Mech. 101, 1980; as 12.9/√Re + 128.4/Re with the diameter). At Re below about 10 the truth
/// is the Stokes limit 16π/Re, half as much again; in a bearing the mixture turns with the balls.
pub fn churning_coefficient(reynolds: f64) -> f64 {
    6.45 / reynolds.sqrt() + 32.1 / reynolds
}

/// Below it inertia adds less than a rounding to the drag.
const MIN_REYNOLDS: f64 = 1e-24;

/// Drag on the orbit and churning of the spin of one ball, made once a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag {
    /// Re at 1 m/s [s/m].
    reynolds_per_speed: f64,
    /// F / V² at C_d = 1 [N s²/m²].
    force_at_unit_coefficient: f64,
    /// F / V at rest, where Stokes' law holds [N s/m].
    stokes_factor: f64,
    /// M / ω at rest [N m s].
    churning_linear: f64,
    /// M / ω^1.5 besides [N m s^1.5].
    churning_root: f64,
}

impl Drag {
    /// Prepares drag and churning of a ball in the mixture that the fill of the bearing gives.
    pub(crate) fn new(bearing: &Bearing, lubricant: &Lubricant) -> Self {
        let d = bearing.parameters.ball_diameter;
        let radius = 0.5 * d;
        let density = lubricant.mixture_density();
        // A mixture of pure, inviscid oil is no fluid; its Reynolds number only has to stay finite.
        let viscosity = lubricant.mixture_viscosity().max(1e-9);
        let reynolds_per_speed = density * d / viscosity;
        let force_at_unit_coefficient = 0.5 * density * PI * d * d / 4.0;
        let spin_reynolds = density * radius * radius / viscosity;
        let moment_at_unit_coefficient = 0.5 * density * radius.powi(5);
        Self {
            reynolds_per_speed,
            force_at_unit_coefficient,
            stokes_factor: force_at_unit_coefficient * 24.0 / reynolds_per_speed,
            churning_linear: moment_at_unit_coefficient * 32.1 / spin_reynolds,
            churning_root: moment_at_unit_coefficient * 6.45 / spin_reynolds.sqrt(),
        }
    }

    /// Force on a ball along its orbit [N], against its velocity V = D_m θ̇/2 [m/s]; linear at rest.
    ///
    /// Harris, Rolling Bearing Analysis: F_D = ½ ρ_e C_d (π d²/4) V |V|, Re = ρ_e |V| d/η_e, with `drag_coefficient`.
    #[inline(always)]
    pub fn force(&self, orbit_velocity: f64) -> f64 {
        let speed = orbit_velocity.abs();
        // One logarithm for both powers; far below any speed of a ball, where Stokes' law is exact to rounding.
        let logarithm = logarithm(larger(self.reynolds_per_speed * speed, MIN_REYNOLDS));
        let stokes = self.stokes_factor * (1.0 + 0.15 * exponential(0.687 * logarithm));
        let wake = self.force_at_unit_coefficient * 0.42 / (1.0 + 4.25e4 * exponential(-1.16 * logarithm));
        -(stokes + wake * speed) * orbit_velocity
    }

    /// Moment on a ball [N m] against its spin [rad/s], by components; linear at rest.
    ///
    /// M = −½ ρ_e C_n |ω| ω (d/2)⁵ with `churning_coefficient`.
    #[inline(always)]
    pub(crate) fn churning_moment(&self, spin: [f64; 3]) -> [f64; 3] {
        let squared = spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2];
        let factor = -self.churning_factor(squared.sqrt());
        [factor * spin[0], factor * spin[1], factor * spin[2]]
    }

    /// Magnitude of the churning moment over that of the spin [N m s], spin a magnitude [rad/s].
    #[inline(always)]
    pub(crate) fn churning_factor(&self, spin: f64) -> f64 {
        self.churning_linear + self.churning_root * spin.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::examples::{article_bearing, article_lubricant};
    use crate::physics::kinematics::{ideal_orbit_ratio, ideal_spin_ratio};

    const SPEED: f64 = 50_000.0 * std::f64::consts::TAU / 60.0;

    /// Article's case at ideal orbit speed: Re 1690, F_D 0.0104 N, given as 0.011 N with a coefficient read off a plot.
    #[test]
    fn drag_of_the_article_bearing() {
        let bearing = article_bearing();
        let drag = Drag::new(&bearing, &article_lubricant());
        let velocity = 0.5 * bearing.parameters.pitch_diameter * ideal_orbit_ratio(&bearing) * SPEED;
        assert!((drag.reynolds_per_speed * velocity / 1690.0 - 1.0).abs() < 3e-3);
        assert!((drag.force(velocity) + 0.0104).abs() < 1e-4);
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
