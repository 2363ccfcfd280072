//! Friction moments of deep-groove bearings by two empirical models, to compare a simulated torque with.
//!
//! Both hold for usual bearings without seals within a factor of about two. Lengths are in mm, speeds in r/min, viscosities in mm²/s and moments in
//! N mm, as in the catalogues that print them.

/// Running conditions of a deep-groove bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Running {
    /// Bore and outside diameter [mm].
    pub bore: f64,
    pub outside: f64,
    /// C₀ [N].
    pub static_rating: f64,
    /// Magnitudes of the loads [N].
    pub radial: f64,
    pub axial: f64,
    /// Speed of one ring relative to the other, magnitude [r/min].
    pub speed: f64,
    /// Kinematic viscosity at running temperature [mm²/s].
    pub viscosity: f64,
}

/// How much lubricant waits beside the track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Supply {
    /// A low oil bath or an oil jet.
    OilBath,
    Grease,
}

/// Moments of the model of SKF (2006) [N mm].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkfMoments {
    pub rolling: f64,
    pub sliding: f64,
}

/// Moments after Palmgren [N mm].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PalmgrenMoments {
    /// M₀, which does not depend on the load.
    pub viscous: f64,
    /// M₁ with the least and the greatest usual factor.
    pub of_load: [f64; 2],
}

/// Constants of a series of deep-groove bearings, R₁, R₂, S₁, S₂.
///
/// SKF Group, *Rolling bearings* (PUB BU/P1 10000/1 EN, 2013), table of geometry constants of frictional moments, as one public program
/// transcribes it; those of the series 62 agree with a second one. The series 68 and 69 are printed as 618 and 619. Not checked against print.
const SERIES: [(&str, [f64; 4]); 7] = [
    ("60", [4.1e-7, 1.7, 3.73e-3, 14.6]),
    ("62", [3.9e-7, 1.7, 3.23e-3, 36.5]),
    ("63", [3.7e-7, 1.7, 2.84e-3, 92.8]),
    ("64", [3.6e-7, 1.7, 2.43e-3, 198.0]),
    ("160", [4.3e-7, 1.7, 4.63e-3, 4.25]),
    ("68", [4.7e-7, 1.7, 6.50e-3, 0.78]),
    ("69", [4.3e-7, 1.7, 4.75e-3, 3.6]),
];

/// Geometry constant of the type, single-row deep-groove bearings [-].
const TYPE_CONSTANT: f64 = 3.1;
/// Friction coefficient of sliding with full film (mineral oil) and in boundary lubrication [-].
const FILM_FRICTION: f64 = 0.05;
const BOUNDARY_FRICTION: f64 = 0.12;

impl Running {
    /// Mean of bore and outside diameter [mm].
    fn mean_diameter(&self) -> f64 {
        0.5 * (self.bore + self.outside)
    }

    /// Rolling and sliding moment of a series; `None` for series without constants here.
    ///
    /// M_rr = φ_ish φ_rs G_rr (ν n)^0.6, M_sl = G_sl μ_sl (source: `SERIES`), without drag, seals and the weights of balls.
    pub fn skf(&self, series: &str, supply: Supply) -> Option<SkfMoments> {
        let (_, [r1, r2, s1, s2]) = SERIES.iter().find(|(name, _)| *name == series)?;
        let diameter = self.mean_diameter();
        let sine = (24.6 * (self.axial / self.static_rating).powf(0.24)).to_radians().sin();
        // The sine is zero for the smallest loads, too, whose ratio to C₀ is below the least number.
        let (rolling, sliding) = if sine == 0.0 {
            (self.radial, s1 * diameter.powf(-0.26) * self.radial.powf(5.0 / 3.0))
        } else {
            let loads = self.radial.powi(5) + s2 * diameter.powf(1.5) / sine * self.axial.powi(4);
            (self.radial + r2 / sine * self.axial, s1 * diameter.powf(-0.145) * loads.cbrt())
        };
        let of_rolling = r1 * diameter.powf(1.96) * rolling.powf(0.54);
        let starvation = match supply {
            Supply::OilBath => 3e-8,
            Supply::Grease => 6e-8,
        };
        let stirred = self.viscosity * self.speed;
        let heating = 1.0 / (1.0 + 1.84e-9 * (self.speed * diameter).powf(1.28) * self.viscosity.powf(0.64));
        let width = (TYPE_CONSTANT / (2.0 * (self.outside - self.bore))).sqrt();
        let replenishment = (-starvation * stirred * (self.bore + self.outside) * width).exp();
        let boundary = (-2.6e-8 * stirred.powf(1.4) * diameter).exp();
        let friction = boundary * BOUNDARY_FRICTION + (1.0 - boundary) * FILM_FRICTION;
        Some(SkfMoments {
            rolling: heating * replenishment * of_rolling * stirred.powf(0.6),
            sliding: friction * sliding,
        })
    }

    /// Moments after Palmgren of an oil bath (Harris, *Rolling Bearing Analysis*).
    ///
    /// M₀ = f₀ 10⁻⁷ (ν n)^(2/3) d_m³, at least that of ν n = 2000, f₀ = 2; M₁ = f₁ P₁ d_m, f₁ = (0.0006 … 0.0009) (P₀/C₀)^0.55,
    /// P₁ = 3 F_a − 0.1 F_r, at least F_r, P₀ = 0.6 F_r + 0.5 F_a, at least F_r.
    pub fn palmgren(&self) -> PalmgrenMoments {
        let diameter = self.mean_diameter();
        let stirred = (self.viscosity * self.speed).max(2000.0);
        let of_rating = (0.6 * self.radial + 0.5 * self.axial).max(self.radial) / self.static_rating;
        let load = (3.0 * self.axial - 0.1 * self.radial).max(self.radial);
        PalmgrenMoments {
            viscous: 2e-7 * stirred.powf(2.0 / 3.0) * diameter.powi(3),
            of_load: [0.0006, 0.0009].map(|factor| factor * of_rating.powf(0.55) * load * diameter),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 6205 at 3000 r/min in a bath of 20 mm²/s.
    fn running(radial: f64, axial: f64) -> Running {
        Running { bore: 25.0, outside: 52.0, static_rating: 7850.0, radial, axial, speed: 3000.0, viscosity: 20.0 }
    }

    /// The last case is that of C₀ 7.8 kN, as the catalogue prints it.
    #[test]
    fn moments_of_the_6205() {
        for (radial, axial, rolling, sliding) in
            [(500.0, 0.0, 9.83, 1.99), (1000.0, 0.0, 14.29, 6.32), (500.0, 200.0, 23.01, 4.60)]
        {
            let running = Running { static_rating: 7800.0, ..running(radial, axial) };
            let ours = running.skf("62", Supply::OilBath).unwrap();
            assert!((ours.rolling - rolling).abs() < 5e-3 && (ours.sliding - sliding).abs() < 5e-3, "{ours:?}");
        }
        let sum = running(500.0, 0.0).skf("62", Supply::OilBath).map(|of| of.rolling + of.sliding).unwrap();
        let power = 1e-3 * sum * 3000.0 * std::f64::consts::TAU / 60.0;
        assert!((sum - 11.82).abs() < 6e-3 && (power - 3.71).abs() < 5e-3, "{sum} N mm, {power} W");
        assert_eq!(running(500.0, 0.0).skf("72", Supply::OilBath), None);
    }

    #[test]
    fn palmgren_of_the_6205() {
        let PalmgrenMoments { viscous, of_load: [least, most] } = running(500.0, 0.0).palmgren();
        assert!((viscous - 17.5).abs() < 0.05, "{viscous}");
        assert!((least - 2.5).abs() < 0.05 && (most - 3.8).abs() < 0.05, "{least} {most}");
    }

    #[test]
    fn the_least_axial_load_is_none() {
        assert_eq!(running(500.0, 5e-324).skf("62", Supply::Grease), running(500.0, 0.0).skf("62", Supply::Grease));
        let small = running(500.0, 1e-300).skf("62", Supply::Grease).unwrap();
        assert!(small.rolling.is_finite() && small.sliding.is_finite(), "{small:?}");
    }

    /// Grease starves the track sooner, and loads and viscosity raise the moments.
    #[test]
    fn trends_have_their_signs() {
        let bath = running(500.0, 0.0).skf("62", Supply::OilBath).unwrap();
        let grease = running(500.0, 0.0).skf("62", Supply::Grease).unwrap();
        assert!(grease.rolling < bath.rolling && grease.sliding == bath.sliding);
        let thick = Running { viscosity: 40.0, ..running(500.0, 0.0) }.skf("62", Supply::OilBath).unwrap();
        assert!(thick.rolling > bath.rolling && thick.sliding < bath.sliding);
    }
}
