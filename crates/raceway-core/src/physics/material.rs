//! Elastic isotropic materials.

use super::limits::Faults;

/// An elastic isotropic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus [Pa].
    pub elastic_modulus: f64,
    /// Poisson's ratio [-].
    pub poisson_ratio: f64,
    /// Density [kg/m³].
    pub density: f64,
}

/// Bearing steel GCr15, the article's table 2; its modulus is high for this steel.
pub const GCR15: Material = Material { elastic_modulus: 219e9, poisson_ratio: 0.3, density: 7830.0 };

/// Polyamide 46, the article's table 3.
pub(crate) const PA46: Material = Material { elastic_modulus: 1e9, poisson_ratio: 0.39, density: 1100.0 };

impl Material {
    /// Records values outside the limits; `path` names the material's fields in the faults (elastic modulus, Poisson's
    /// ratio, density).
    pub(crate) fn check(&self, path: [&'static str; 3], faults: &mut Faults) {
        faults.check(path[0], self.elastic_modulus);
        faults.check(path[1], self.poisson_ratio);
        faults.check(path[2], self.density);
    }
}

/// Contact modulus `E*`, 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂ [Pa]. The effective modulus of
/// Hamrock & Dowson is `E' = 2 E*`.
pub(crate) fn contact_modulus(a: &Material, b: &Material) -> f64 {
    let compliance = |m: &Material| (1.0 - m.poisson_ratio * m.poisson_ratio) / m.elastic_modulus;
    1.0 / (compliance(a) + compliance(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two equal steels: E* = E / (2 (1 − ν²)), hand calculation.
    #[test]
    fn equal_materials_share_the_compliance() {
        let steel = Material { elastic_modulus: 210e9, poisson_ratio: 0.3, density: 7830.0 };
        assert!((contact_modulus(&steel, &steel) - 115.384_615_4e9).abs() < 1e3);
    }
}
