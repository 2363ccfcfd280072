//! The spindle: a rigid body at prescribed speed that moves in Y and Z, and along X and in tilt where they are free.

use super::frames::Vector;
use super::limits::Faults;
use crate::numerics::angle::sin_cos;

/// Axial support of the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AxialHold {
    Fixed,
    /// The spindle moves along X and carries the axial load.
    Free,
    /// Held at this displacement along X [m].
    Offset(f64),
}

/// Tilt of the spindle about Y and Z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpindleTilt {
    /// Held at the misalignment of the operation.
    Held,
    /// The bearing alone holds it.
    Free(SpindleInertia),
}

/// Moments of inertia of a spindle about its centre of mass [kg m²].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleInertia {
    /// About Y and Z.
    pub transverse: f64,
    /// About its axis.
    pub axial: f64,
}

impl SpindleInertia {
    /// A solid cylinder of a mass [kg], a diameter and a length [m].
    pub fn of_cylinder(mass: f64, diameter: f64, length: f64) -> Self {
        let square = diameter * diameter;
        Self { transverse: mass * (square / 16.0 + length * length / 12.0), axial: mass * square / 8.0 }
    }
}

/// Unbalance of the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unbalance {
    None,
    /// Mass times eccentricity [kg m].
    Product(f64),
    /// ISO 21940 grade: eccentricity times operating speed [m/s].
    Grade(f64),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spindle {
    /// [kg]
    pub mass: f64,
    pub unbalance: Unbalance,
    pub axial: AxialHold,
    pub tilt: SpindleTilt,
}

impl Spindle {
    /// Records values outside the limits.
    pub(crate) fn check(&self, faults: &mut Faults) {
        faults.check("spindle.mass", self.mass);
        match self.unbalance {
            Unbalance::None => true,
            Unbalance::Product(product) => faults.check("spindle.unbalance", product),
            Unbalance::Grade(grade) => faults.check("spindle.balance_grade", grade),
        };
        if let AxialHold::Offset(offset) = self.axial {
            faults.check("spindle.axial.offset", offset);
        }
        if let SpindleTilt::Free(inertia) = self.tilt {
            faults.check("spindle.transverse_inertia", inertia.transverse);
            faults.check("spindle.axial_inertia", inertia.axial);
        }
    }

    /// Mass times eccentricity [kg m] at an operating speed [rad/s]; 0 at rest, where a grade gives no eccentricity.
    pub fn unbalance_product(&self, operating_speed: f64) -> f64 {
        match self.unbalance {
            Unbalance::None => 0.0,
            Unbalance::Product(product) => product,
            Unbalance::Grade(_) if operating_speed == 0.0 => 0.0,
            Unbalance::Grade(grade) => self.mass * grade / operating_speed.abs(),
        }
    }
}

/// Force of an unbalance (mass times eccentricity [kg m]) on the spindle [N], inertial frame:
/// F = m_u e [ω² (cos ψ, sin ψ) + ω̇ (sin ψ, −cos ψ)] in (Y, Z), ψ the angle turned [rad].
pub fn unbalance_force(product: f64, angle: f64, speed: f64, acceleration: f64) -> Vector {
    let (sine, cosine) = sin_cos(angle);
    let (centrifugal, tangential) = (product * speed * speed, product * acceleration);
    [0.0, centrifugal * cosine + tangential * sine, centrifugal * sine - tangential * cosine]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// G 6.3 at 50 000 r/min on 50 g: e = 6.3 mm/s / ω, F = m ω · 6.3 mm/s, pointing at the heavy side.
    #[test]
    fn grade_gives_mass_times_speed_times_grade() {
        let spindle = Spindle {
            mass: 0.05,
            unbalance: Unbalance::Grade(6.3e-3),
            axial: AxialHold::Fixed,
            tilt: SpindleTilt::Held,
        };
        let speed = 5236.0;
        let force = unbalance_force(spindle.unbalance_product(speed), std::f64::consts::FRAC_PI_2, speed, 0.0);
        assert!((force[2] - 0.05 * speed * 6.3e-3).abs() < 1e-12 && force[1].abs() < 1e-12);
        assert_eq!(spindle.unbalance_product(0.0), 0.0);
    }
}
