//! A land-guided cage: short journal bearing between the cage and the shoulder of the outer ring.

use std::f64::consts::{PI, TAU};

use super::cage::GuidingLand;
use super::frames::Vector;
use super::lubricant::Lubricant;

/// Share of the clearance up to which the film law is used; beyond it the solids carry.
const MAX_ECCENTRICITY: f64 = 0.95;
/// Stiffness of the solid guiding land [N/m]; the film law holds the cage off it in regular running.
const SOLID_STIFFNESS: f64 = 1e6;

/// Constants of one guiding land.
#[derive(Debug, Clone, Copy)]
pub struct Land {
    clearance: f64,
    radius: f64,
    width: f64,
    viscosity: f64,
}

impl Land {
    pub fn new(land: &GuidingLand, lubricant: &Lubricant) -> Self {
        Self {
            clearance: 0.5 * land.clearance,
            radius: 0.5 * land.diameter,
            width: land.width,
            viscosity: lubricant.viscosity,
        }
    }

    /// Force on the cage [N] in the inertial frame and braking moment about X [N m], at a
    /// displacement [m] of the cage centre and speeds of cage and outer ring [rad/s].
    ///
    /// Both surfaces draw lubricant in, with the sum of their speeds, and shear it with the difference.
    /// Ocvirk's short bearing: F_ε = η U L³/C² · ε²/(1−ε²)², F_φ = η U L³/(4C²) · π ε/(1−ε²)^1.5,
    /// M = 2π η U R² L / (C √(1−ε²)); static film forces, no squeeze. Half-filled: cavitated.
    pub fn load(&self, centre: Vector, cage_speed: f64, ring_speed: f64) -> (Vector, f64) {
        let eccentricity = (centre[1] * centre[1] + centre[2] * centre[2]).sqrt();
        let ratio = (eccentricity / self.clearance).min(MAX_ECCENTRICITY);
        let free = 1.0 - ratio * ratio;
        let drawing_speed = self.radius * (cage_speed + ring_speed);
        let sliding_speed = self.radius * (cage_speed - ring_speed);
        let scale = self.viscosity * drawing_speed * self.width.powi(3) / (self.clearance * self.clearance);
        let radial = scale.abs() * ratio * ratio / (free * free);
        let tangential = 0.25 * scale * PI * ratio / free.powf(1.5);
        let solid = SOLID_STIFFNESS * (eccentricity - MAX_ECCENTRICITY * self.clearance).max(0.0);
        let moment = -TAU * self.viscosity * sliding_speed * self.radius * self.radius * self.width
            / (self.clearance * free.sqrt());
        if eccentricity == 0.0 {
            return ([0.0; 3], moment);
        }
        let (ey, ez) = (centre[1] / eccentricity, centre[2] / eccentricity);
        let inward = -(radial + solid);
        ([0.0, inward * ey - tangential * ez, inward * ez + tangential * ey], moment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Total film force of the short bearing: W = η U L³/(4C²) · ε/(1−ε²)² · √(16ε² + π²(1−ε²)) (Ocvirk 1953).
    #[test]
    fn load_capacity_is_that_of_the_short_bearing() {
        let lubricant = crate::physics::examples::article_lubricant();
        let land = Land::new(&GuidingLand { clearance: 100e-6, diameter: 15e-3, width: 1e-3 }, &lubricant);
        let ratio: f64 = 0.6;
        let (force, moment) = land.load([0.0, 0.0, ratio * 50e-6], 2000.0, 0.0);
        let scale = lubricant.viscosity * 2000.0 * 7.5e-3 * 1e-9 / (4.0 * 50e-6 * 50e-6);
        let free = 1.0 - ratio * ratio;
        let expected = scale * ratio / (free * free) * (16.0 * ratio * ratio + PI * PI * free).sqrt();
        assert!((force[1].hypot(force[2]) / expected - 1.0).abs() < 1e-12);
        // The film pushes back and ahead: displaced to +Z and turning from +Y to +Z, "ahead" is −Y.
        assert!(force[2] < 0.0 && force[1] < 0.0 && moment < 0.0);
        // A ring that turns with the cage doubles the film's force and does not brake; one that turns against it leaves no film.
        let (together, none) = land.load([0.0, 0.0, ratio * 50e-6], 2000.0, 2000.0);
        assert!((together[2] / force[2] - 2.0).abs() < 1e-12 && none == 0.0);
        let (against, twice) = land.load([0.0, 0.0, ratio * 50e-6], 2000.0, -2000.0);
        assert!(against[1] == 0.0 && (twice / moment - 2.0).abs() < 1e-12);
    }
}
