//! Resistance of the lubricant–air mixture to balls that orbit and spin in it.

use std::f64::consts::PI;

use super::bearing::Bearing;
use super::frames::{Vector, scale};
use super::lubricant::Lubricant;

/// Drag coefficient of a sphere over the Reynolds number, read off the standard curve
/// (Schlichting, *Boundary-Layer Theory*); between the points straight lines in the logarithms.
const SPHERE: [(f64, f64); 7] =
    [(0.1, 275.0), (1.0, 30.0), (10.0, 4.2), (100.0, 1.2), (1e3, 0.48), (1e4, 0.40), (1e5, 0.45)];

/// C_d of a sphere; 27.5/Re (about Stokes) below the table, constant above it.
pub fn drag_coefficient(reynolds: f64) -> f64 {
    let (first, last) = (SPHERE[0], SPHERE[SPHERE.len() - 1]);
    if reynolds <= first.0 {
        return 27.5 / reynolds.max(1e-30);
    }
    if reynolds >= last.0 {
        return last.1;
    }
    let above = SPHERE.partition_point(|point| point.0 <= reynolds);
    let (low, high) = (SPHERE[above - 1], SPHERE[above]);
    let share = (reynolds / low.0).ln() / (high.0 / low.0).ln();
    low.1 * (share * (high.1 / low.1).ln()).exp()
}

/// Drag and churning of the balls of one bearing.
#[derive(Debug, Clone, Copy)]
pub struct Drag {
    ball_diameter: f64,
    density: f64,
    viscosity: f64,
}

impl Drag {
    pub fn new(bearing: &Bearing, lubricant: &Lubricant) -> Self {
        Self {
            ball_diameter: bearing.parameters.ball_diameter,
            density: lubricant.mixture_density(),
            viscosity: lubricant.mixture_viscosity(),
        }
    }

    /// Force along the orbit on a ball at an orbit velocity V [m/s]: −½ ρ_e C_d (π d²/4) V|V| [N].
    ///
    /// With V = D_m θ̇/2 this is Harris' (π/32) C_d ρ_e (d D_m θ̇)².
    #[inline(always)]
    pub fn force(&self, velocity: f64) -> f64 {
        let speed = velocity.abs();
        if speed == 0.0 || self.density == 0.0 {
            return 0.0;
        }
        let reynolds = self.density * speed * self.ball_diameter / self.viscosity;
        let area = 0.25 * PI * self.ball_diameter * self.ball_diameter;
        -0.5 * self.density * drag_coefficient(reynolds) * area * velocity * speed
    }

    /// Moment on a ball that spins at ω_b [rad/s]: −½ ρ_e C_n |ω_b| ω_b (d/2)⁵ [N m] with the rotating sphere's
    /// C_n = 6.45/√Re + 32.1/Re, Re = ρ_e |ω_b| (d/2)²/η_e; without the quotient it is finite at rest.
    #[inline(always)]
    pub fn churning_moment(&self, spin: Vector) -> Vector {
        if self.density == 0.0 {
            return [0.0; 3];
        }
        let radius = 0.5 * self.ball_diameter;
        let square = radius * radius;
        let speed = (spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2]).sqrt();
        // C_n |ω| = 6.45 √|ω| √(η/ρ)/r + 32.1 η/(ρ r²)
        let kinematic = self.viscosity / self.density;
        let turbulent = 6.45 * (speed * kinematic).sqrt() / radius + 32.1 * kinematic / square;
        scale(-0.5 * self.density * turbulent * square * square * radius, spin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::testing;

    /// Re 1690 and F_D 0.011 N at the ideal orbit of the article's case (own calculation).
    #[test]
    fn drag_of_the_article_s_case() {
        let parts = testing::article();
        let drag = Drag::new(&parts.bearing, &parts.lubricant);
        let velocity = 6.5e-3 * 327.6 * std::f64::consts::TAU;
        let reynolds = drag.density * velocity * 2.778e-3 / drag.viscosity;
        assert!((reynolds / 1690.0 - 1.0).abs() < 0.01, "{reynolds}");
        assert!((-drag.force(velocity) / 0.011 - 1.0).abs() < 0.05, "{}", drag.force(velocity));
        assert_eq!(drag.force(-velocity), -drag.force(velocity));
    }

    #[test]
    fn coefficient_meets_its_table_and_is_continuous() {
        for (reynolds, coefficient) in SPHERE {
            assert!((drag_coefficient(reynolds) / coefficient - 1.0).abs() < 1e-12);
            assert!((drag_coefficient(reynolds * (1.0 + 1e-9)) / coefficient - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn churning_brakes_and_vanishes_at_rest() {
        let parts = testing::article();
        let drag = Drag::new(&parts.bearing, &parts.lubricant);
        assert!(drag.churning_moment([-1e4, 0.0, 0.0])[0] > 0.0);
        assert_eq!(drag.churning_moment([0.0; 3]), [0.0; 3]);
    }
}
