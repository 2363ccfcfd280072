//! The film between ball and seat as a lubricant wedge: stiffness, rolling friction and shear.

/// The lubricant wedge between ball and seat at half the clearance.
pub(super) struct Wedge {
    pub(super) viscosity: f64,
    /// Surface speed of the ball in the pocket [m/s].
    pub(super) speed: f64,
    /// Effective radius of ball and seat [m].
    pub(super) radius: f64,
    pub(super) clearance: f64,
    pub(super) half_width: f64,
}

impl Wedge {
    fn gap(&self) -> f64 {
        0.5 * self.clearance
    }

    /// Half width of the seat over the parabolic length of the gap, t = w_p / √(2 h₀ R_p) [-].
    fn width_ratio(&self) -> f64 {
        self.half_width / (2.0 * self.gap() * self.radius).sqrt()
    }

    /// Film stiffness K_c = W(t) / C_p [N/m], the isoviscous rigid load capacity of a sphere on a
    /// seat of finite width: W = (2/π)(atan t − t/(1+t²)) · 6√2 π η U R_p √(R_p/h₀) / 5.
    pub(super) fn stiffness(&self) -> f64 {
        use std::f64::consts::{FRAC_2_PI, PI, SQRT_2};
        let t = self.width_ratio();
        let truncation = FRAC_2_PI * (t.atan() - t / (1.0 + t * t));
        let full =
            6.0 * SQRT_2 * PI * self.viscosity * self.speed * self.radius * (self.radius / self.gap()).sqrt() / 5.0;
        truncation * full / self.clearance
    }

    /// Rolling friction P_R = ½ C₀ P̄_R with C₀ = η U R_p / 5 (R_x = R_y, U the sum of surface speeds) and P̄_R =
    /// max(0, 34.74 ln t − 27.6). Film shear P̄_S η u R_p with P̄_S = max(0, 0.26 (34.74 ln t − 27.6) + 10.9).
    pub(super) fn hydrodynamics(&self) -> PocketHydrodynamics {
        let base = 34.74 * self.width_ratio().ln() - 27.6;
        PocketHydrodynamics {
            rolling: 0.5 * self.viscosity * self.radius / 5.0 * base.max(0.0),
            shear: self.viscosity * self.radius * (0.26 * base + 10.9).max(0.0),
        }
    }
}

/// Constants of rolling friction and film shear between ball and pocket.
#[derive(Debug, Clone, Copy)]
pub(super) struct PocketHydrodynamics {
    /// Rolling friction on each surface over the rolling speed [N s/m].
    pub(super) rolling: f64,
    /// Film shear over the sliding speed [N s/m].
    pub(super) shear: f64,
}
