//! Beam element of a round shaft: two nodes, shear deformation, rotary inertia, gyroscopic moment.

use std::f64::consts::PI;

use crate::physics::material::Material;

/// Symmetric matrix of an element over (w₁, w₁′, w₂, w₂′).
pub type ElementMatrix = [[f64; 4]; 4];

/// Cross-section of a round shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tube {
    /// [m]
    pub outer_diameter: f64,
    /// Bore [m]; 0 for a solid shaft.
    pub inner_diameter: f64,
}

impl Tube {
    /// [m²]
    pub fn area(&self) -> f64 {
        PI / 4.0 * (self.outer_diameter.powi(2) - self.inner_diameter.powi(2))
    }

    /// Second moment of area about a diameter [m⁴].
    pub fn second_moment(&self) -> f64 {
        PI / 64.0 * (self.outer_diameter.powi(4) - self.inner_diameter.powi(4))
    }

    /// Shear coefficient κ of Cowper [-], *J. Appl. Mech.* 33 (1966) 335, with m the bore ratio:
    /// κ = 6(1 + ν)(1 + m²)² / ((7 + 6ν)(1 + m²)² + (20 + 12ν)m²). Quasi-static, so below the shear modes.
    pub fn shear_coefficient(&self, poisson_ratio: f64) -> f64 {
        let bore = (self.inner_diameter / self.outer_diameter).powi(2);
        let wall = (1.0 + bore).powi(2);
        6.0 * (1.0 + poisson_ratio) * wall / ((7.0 + 6.0 * poisson_ratio) * wall + (20.0 + 12.0 * poisson_ratio) * bore)
    }
}

/// Two-node Timoshenko element of constant section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamElement {
    /// [m]
    pub length: f64,
    pub section: Tube,
    pub material: Material,
}

/// Points and weights of Gauss and Legendre on 0 … 1: exact to the seventh degree; products of two shapes have the sixth.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_9),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273_1),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_1),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_9),
];

impl BeamElement {
    /// Shear parameter Φ = 12 E I / (κ G A L²) [-]; 0 for a slender beam.
    pub fn shear_parameter(&self) -> f64 {
        let Material { elastic_modulus, poisson_ratio, .. } = self.material;
        let shear_modulus = elastic_modulus / (2.0 * (1.0 + poisson_ratio));
        let shear_stiffness = self.section.shear_coefficient(poisson_ratio) * shear_modulus * self.section.area();
        12.0 * elastic_modulus * self.section.second_moment() / (shear_stiffness * self.length.powi(2))
    }

    /// Shapes of the displacement w at a share ξ of the length (Przemieniecki 1968, Φ-dependent): those that a load at the ends
    /// alone causes.
    pub fn displacement_shapes(&self, share: f64) -> [f64; 4] {
        let (phi, length, x) = (self.shear_parameter(), self.length, share);
        let (x2, x3) = (x * x, x * x * x);
        [
            1.0 - 3.0 * x2 + 2.0 * x3 + phi * (1.0 - x),
            length * (x - 2.0 * x2 + x3 + 0.5 * phi * (x - x2)),
            3.0 * x2 - 2.0 * x3 + phi * x,
            length * (x3 - x2 + 0.5 * phi * (x2 - x)),
        ]
        .map(|shape| shape / (1.0 + phi))
    }

    /// Shapes of the slope of the sections (without shear) [1/m, -, 1/m, -].
    fn slope_shapes(&self, share: f64) -> [f64; 4] {
        let (phi, length, x) = (self.shear_parameter(), self.length, share);
        let tip = 6.0 * (x * x - x) / length;
        [tip, 1.0 - 4.0 * x + 3.0 * x * x + phi * (1.0 - x), -tip, 3.0 * x * x - 2.0 * x + phi * x]
            .map(|shape| shape / (1.0 + phi))
    }

    /// Bending and shear stiffness. The shapes solve the static equations, so that any number of elements has the exact static
    /// answer at the nodes: K = E I ∫ B Bᵀ with the curvatures B, and the constant shear angle's share.
    pub fn stiffness(&self) -> ElementMatrix {
        let (phi, length) = (self.shear_parameter(), self.length);
        let bending = self.material.elastic_modulus * self.section.second_moment();
        let curvature = |x: f64| {
            let tip = 6.0 * (2.0 * x - 1.0) / length;
            [tip, 6.0 * x - 4.0 - phi, -tip, 6.0 * x - 2.0 + phi].map(|shape| shape / (length * (1.0 + phi)))
        };
        // w′ less the slope of the section is the same everywhere.
        let shear = [-1.0, -0.5 * length, 1.0, -0.5 * length].map(|shape| shape * phi / (length * (1.0 + phi)));
        let shear_stiffness = if phi > 0.0 { 12.0 * bending / (phi * length * length) } else { 0.0 };
        let of_bending = self.integral(bending, curvature);
        let of_shear = self.integral(shear_stiffness, |_| shear);
        sum(of_bending, of_shear)
    }

    /// Consistent mass, rotary inertia included.
    pub fn mass(&self) -> ElementMatrix {
        let density = self.material.density;
        let translation = self.integral(density * self.section.area(), |x| self.displacement_shapes(x));
        let rotation = self.integral(density * self.section.second_moment(), |x| self.slope_shapes(x));
        sum(translation, rotation)
    }

    /// Polar inertia over the slopes: the gyroscopic matrix at 1 rad/s couples the two planes by it.
    pub fn polar_inertia(&self) -> ElementMatrix {
        self.integral(2.0 * self.material.density * self.section.second_moment(), |x| self.slope_shapes(x))
    }

    /// Stiffness along the axis [N/m].
    pub fn axial_stiffness(&self) -> f64 {
        self.material.elastic_modulus * self.section.area() / self.length
    }

    /// [kg]
    pub fn weight(&self) -> f64 {
        self.material.density * self.section.area() * self.length
    }

    /// factor · ∫ s sᵀ along the element.
    fn integral(&self, factor: f64, shapes: impl Fn(f64) -> [f64; 4]) -> ElementMatrix {
        let mut matrix = [[0.0; 4]; 4];
        for (point, weight) in GAUSS {
            let s = shapes(point);
            for (row, sums) in matrix.iter_mut().enumerate() {
                for (column, sum) in sums.iter_mut().enumerate() {
                    *sum += factor * weight * self.length * s[row] * s[column];
                }
            }
        }
        matrix
    }
}

fn sum(a: ElementMatrix, b: ElementMatrix) -> ElementMatrix {
    std::array::from_fn(|row| std::array::from_fn(|column| a[row][column] + b[row][column]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEEL: Material = Material { elastic_modulus: 211e9, poisson_ratio: 0.299_261, density: 7810.0 };

    fn element(length: f64) -> BeamElement {
        BeamElement { length, section: Tube { outer_diameter: 0.025, inner_diameter: 0.0 }, material: STEEL }
    }

    /// κ = 6(1 + ν)/(7 + 6ν) of a solid section, and 1/2 of a thin wall for ν = 0.
    #[test]
    fn shear_coefficient_is_that_of_cowper() {
        let solid = Tube { outer_diameter: 1.0, inner_diameter: 0.0 };
        assert!((solid.shear_coefficient(0.299_26) - 0.886_31).abs() < 5e-6);
        let thin = Tube { outer_diameter: 1.0, inner_diameter: 0.999_999 };
        assert!((thin.shear_coefficient(0.0) - 0.5).abs() < 1e-5);
    }

    /// Tip of a cantilever of 300 mm under 1 N, on one element: L³/(3 E I) + L/(κ G A) = 2.232 980 µm.
    #[test]
    fn one_element_has_the_exact_static_deflection() {
        let k = element(0.3).stiffness();
        let determinant = k[2][2] * k[3][3] - k[2][3] * k[3][2];
        let tip = k[3][3] / determinant;
        assert!((tip / 2.232_980e-6 - 1.0).abs() < 1e-6, "{tip:e}");
    }

    /// A rigid translation has the whole mass; a rigid rotation about the middle, the inertia of a cylinder; its polar inertia is
    /// half of m r².
    #[test]
    fn rigid_motions_have_the_inertia_of_a_cylinder() {
        let element = element(0.05);
        let energy = |matrix: ElementMatrix, motion: [f64; 4]| -> f64 {
            (0..4).flat_map(|i| (0..4).map(move |j| (i, j))).map(|(i, j)| motion[i] * matrix[i][j] * motion[j]).sum()
        };
        let (mass, radius) = (element.weight(), 0.0125_f64);
        let turned = [-0.025, 1.0, 0.025, 1.0];
        let transverse = mass * (radius.powi(2) / 4.0 + 0.05_f64.powi(2) / 12.0);
        assert!((energy(element.mass(), [1.0, 0.0, 1.0, 0.0]) / mass - 1.0).abs() < 1e-12);
        assert!((energy(element.mass(), turned) / transverse - 1.0).abs() < 1e-12);
        assert!((energy(element.polar_inertia(), turned) / (0.5 * mass * radius.powi(2)) - 1.0).abs() < 1e-12);
        assert!(energy(element.stiffness(), turned).abs() < 1e-6);
    }
}
