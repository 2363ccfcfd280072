//! Geometry of a ball bearing: checked once, then derived quantities that never change.

use std::f64::consts::PI;

use super::material::Material;
use super::{InvalidParameter, above, within};

/// Inner and outer, always as a pair, so that one formula serves both.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PerRaceway<T> {
    pub inner: T,
    pub outer: T,
}

impl<T> PerRaceway<T> {
    /// The pair of results of `f` on inner and outer.
    pub fn map<U>(&self, f: impl Fn(&T) -> U) -> PerRaceway<U> {
        PerRaceway { inner: f(&self.inner), outer: f(&self.outer) }
    }
}

/// Which kind of bearing; an integrated one has its inner raceway ground on the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BearingKind {
    Integrated,
    DeepGroove,
    AngularContact,
}

/// How tight the balls sit: one determines the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fit {
    /// Diametral radial clearance `P_d` [m]; negative is a radial preload.
    RadialClearance(f64),
    /// Free contact angle [rad].
    ContactAngle(f64),
}

/// What a catalogue says of a bearing without its cage, unchecked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingParameters {
    pub kind: BearingKind,
    /// [m]
    pub outer_diameter: f64,
    /// [m]
    pub inner_diameter: f64,
    /// [m]
    pub width: f64,
    pub ball_count: usize,
    /// [m]
    pub ball_diameter: f64,
    /// [m]
    pub pitch_diameter: f64,
    /// Groove radius over ball diameter [-].
    pub groove_curvature: PerRaceway<f64>,
    pub fit: Fit,
    pub ball_material: Material,
    pub raceway_material: PerRaceway<Material>,
}

/// A bearing whose parameters fit together, with its derived geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearing {
    pub parameters: BearingParameters,
    /// Diametral radial clearance `P_d` [m].
    pub radial_clearance: f64,
    /// Free contact angle α₀ [rad]; 0 where `P_d` ≤ 0.
    pub free_contact_angle: f64,
    /// Radii of the circles on which the groove centres lie [m].
    pub groove_centre_radius: PerRaceway<f64>,
    /// Distance `A = (f_i + f_e − 1) d` of the groove centres [m].
    pub groove_centre_distance: f64,
    /// [kg]
    pub ball_mass: f64,
    /// Moment of inertia of a ball about any axis [kg m²].
    pub ball_inertia: f64,
}

/// Largest number of balls accepted.
pub const MAX_BALLS: usize = 64;

impl Bearing {
    /// Checks the parameters and derives the geometry (`docs/MODEL.md`, contact geometry).
    pub fn new(parameters: BearingParameters) -> Result<Self, InvalidParameter> {
        let p = &parameters;
        above("bearing.ball_diameter", p.ball_diameter, 0.0, 0.5)?;
        above("bearing.pitch_diameter", p.pitch_diameter, 0.0, 10.0)?;
        above("bearing.outer_diameter", p.outer_diameter, 0.0, 12.0)?;
        above("bearing.inner_diameter", p.inner_diameter, 0.0, 10.0)?;
        above("bearing.width", p.width, 0.0, 2.0)?;
        within("bearing.ball_count", p.ball_count as f64, 2.0, MAX_BALLS as f64)?;
        above("bearing.inner_groove_curvature", p.groove_curvature.inner, 0.5, 1.0)?;
        above("bearing.outer_groove_curvature", p.groove_curvature.outer, 0.5, 1.0)?;
        p.ball_material.check([
            "bearing.materials.ball.elastic_modulus",
            "bearing.materials.ball.poisson_ratio",
            "bearing.materials.ball.density",
        ])?;
        p.raceway_material.inner.check([
            "bearing.materials.inner_raceway.elastic_modulus",
            "bearing.materials.inner_raceway.poisson_ratio",
            "bearing.materials.inner_raceway.density",
        ])?;
        p.raceway_material.outer.check([
            "bearing.materials.outer_raceway.elastic_modulus",
            "bearing.materials.outer_raceway.poisson_ratio",
            "bearing.materials.outer_raceway.density",
        ])?;
        let inconsistent = |parameter, reason: String| Err(InvalidParameter::Inconsistent { parameter, reason });
        let (d, pitch) = (p.ball_diameter, p.pitch_diameter);
        let chord = pitch * (PI / p.ball_count as f64).sin();
        if chord <= d {
            let most = (PI / (d / pitch).min(1.0).asin()).ceil() as usize - 1;
            return inconsistent(
                "bearing.ball_count",
                format!(
                    "{} balls of {:.4} mm overlap on a pitch circle of {:.4} mm; at most {most} fit",
                    p.ball_count,
                    d * 1e3,
                    pitch * 1e3
                ),
            );
        }
        if p.outer_diameter <= pitch + d {
            return inconsistent(
                "bearing.outer_diameter",
                format!(
                    "{:.4} mm leaves no outer ring outside pitch and ball diameter ({:.4} mm)",
                    p.outer_diameter * 1e3,
                    (pitch + d) * 1e3
                ),
            );
        }
        if p.inner_diameter >= pitch - d {
            return inconsistent(
                "bearing.inner_diameter",
                format!(
                    "{:.4} mm leaves no inner raceway inside pitch less ball diameter ({:.4} mm)",
                    p.inner_diameter * 1e3,
                    (pitch - d) * 1e3
                ),
            );
        }
        let f = p.groove_curvature;
        let distance = (f.inner + f.outer - 1.0) * d;
        let (radial_clearance, free_contact_angle) = match p.fit {
            Fit::RadialClearance(clearance) => {
                within("bearing.radial_clearance", clearance, -0.02 * d, f64::MAX)?;
                let cosine = 1.0 - clearance / (2.0 * distance);
                if cosine < 0.5 {
                    return inconsistent(
                        "bearing.radial_clearance",
                        format!(
                            "{:.3} µm leaves no contact angle up to 60°; at most {:.3} µm with these groove curvatures",
                            clearance * 1e6,
                            distance * 1e6
                        ),
                    );
                }
                (clearance, cosine.min(1.0).acos())
            }
            Fit::ContactAngle(angle) => {
                within("bearing.contact_angle", angle, 0.0, PI / 3.0)?;
                (2.0 * distance * (1.0 - angle.cos()), angle)
            }
        };
        let ball_mass = p.ball_material.density * PI * d.powi(3) / 6.0;
        Ok(Self {
            radial_clearance,
            free_contact_angle,
            groove_centre_radius: PerRaceway {
                inner: 0.5 * pitch + (f.inner - 0.5) * d - 0.25 * radial_clearance,
                outer: 0.5 * pitch - (f.outer - 0.5) * d + 0.25 * radial_clearance,
            },
            groove_centre_distance: distance,
            ball_mass,
            ball_inertia: 0.1 * ball_mass * d * d,
            parameters,
        })
    }

    /// `γ = d cos α / D_m` with the angle that the kinematics use: the free contact angle of an
    /// angular-contact bearing, 0 for radial types.
    pub fn gamma(&self) -> f64 {
        let p = &self.parameters;
        p.ball_diameter * self.kinematic_contact_angle().cos() / p.pitch_diameter
    }

    /// Contact angle for curvatures, kinematics and rating [rad].
    pub fn kinematic_contact_angle(&self) -> f64 {
        match self.parameters.kind {
            BearingKind::AngularContact => self.free_contact_angle,
            BearingKind::Integrated | BearingKind::DeepGroove => 0.0,
        }
    }
}
