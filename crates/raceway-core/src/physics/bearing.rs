//! Geometry of a ball bearing: checked once, then derived quantities that never change.

use std::f64::consts::PI;

use super::limits::{Faults, InvalidParameter};
use super::material::Material;
use crate::numerics::lanes::SideBySide;

/// Inner and outer as a pair, so that one formula holds for both.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PerRaceway<T> {
    pub inner: T,
    pub outer: T,
}

impl<C: SideBySide> SideBySide for PerRaceway<C> {
    type One = PerRaceway<C::One>;

    #[inline(always)]
    fn at(&self, lane: usize) -> Self::One {
        PerRaceway { inner: self.inner.at(lane), outer: self.outer.at(lane) }
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: Self::One) {
        self.inner.put(lane, one.inner);
        self.outer.put(lane, one.outer);
    }
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

/// Clearance or contact angle; one determines the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fit {
    /// Diametral radial clearance `P_d` [m]; negative is a radial preload.
    RadialClearance(f64),
    /// Free contact angle [rad].
    ContactAngle(f64),
}

/// Parameters of a bearing without its cage, unchecked.
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

/// Largest displacements of the spindle in the plane and along the axis [m].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindlePlay {
    pub radial: f64,
    pub axial: f64,
}

/// Largest radial preload over ball diameter [-].
const MAX_PRELOAD: f64 = 0.02;

impl BearingParameters {
    /// Distance `A = (f_i + f_e − 1) d` of the groove centres [m].
    fn groove_centre_distance(&self) -> f64 {
        (self.groove_curvature.inner + self.groove_curvature.outer - 1.0) * self.ball_diameter
    }

    /// Cosine of the free contact angle that a clearance [m] leaves; above 1 with a preload.
    fn cosine_of_contact(&self, clearance: f64) -> f64 {
        1.0 - clearance / (2.0 * self.groove_centre_distance())
    }

    fn check_materials(&self, faults: &mut Faults) {
        self.ball_material.check(
            [
                "bearing.materials.ball.elastic_modulus",
                "bearing.materials.ball.poisson_ratio",
                "bearing.materials.ball.density",
            ],
            faults,
        );
        self.raceway_material.inner.check(
            [
                "bearing.materials.inner_raceway.elastic_modulus",
                "bearing.materials.inner_raceway.poisson_ratio",
                "bearing.materials.inner_raceway.density",
            ],
            faults,
        );
        self.raceway_material.outer.check(
            [
                "bearing.materials.outer_raceway.elastic_modulus",
                "bearing.materials.outer_raceway.poisson_ratio",
                "bearing.materials.outer_raceway.density",
            ],
            faults,
        );
    }

    /// Checks clearance or contact angle; a clearance against ball and grooves only where these are valid.
    fn check_fit(&self, has_grooves: bool, faults: &mut Faults) {
        let clearance = match self.fit {
            Fit::ContactAngle(angle) => {
                faults.check("bearing.contact_angle", angle);
                return;
            }
            Fit::RadialClearance(clearance) => clearance,
        };
        const CLEARANCE: &str = "bearing.radial_clearance";
        if !faults.check(CLEARANCE, clearance) || !has_grooves {
            return;
        }
        let least = -MAX_PRELOAD * self.ball_diameter;
        if clearance < least {
            let reason = format!(
                "{:.3} µm: must be at least {:.3} µm, a preload of {MAX_PRELOAD} ball diameters",
                clearance * 1e6,
                least * 1e6
            );
            faults.inconsistent(CLEARANCE, reason);
        } else if self.cosine_of_contact(clearance) < 0.5 {
            let reason = format!(
                "{:.3} µm leaves no contact angle up to 60°; at most {:.3} µm with these groove curvatures",
                clearance * 1e6,
                self.groove_centre_distance() * 1e6
            );
            faults.inconsistent(CLEARANCE, reason);
        }
    }
}

impl Bearing {
    /// Checks the parameters and derives the geometry (`docs/explanation/model.md`, contact geometry).
    pub fn new(parameters: BearingParameters) -> Result<Self, Vec<InvalidParameter>> {
        let p = &parameters;
        let mut faults = Faults::default();
        let has_ball = faults.check("bearing.ball_diameter", p.ball_diameter);
        let has_pitch = faults.check("bearing.pitch_diameter", p.pitch_diameter) && has_ball;
        let has_outer = faults.check("bearing.outer_diameter", p.outer_diameter) && has_pitch;
        let has_inner = faults.check("bearing.inner_diameter", p.inner_diameter) && has_pitch;
        faults.check("bearing.width", p.width);
        let has_balls = faults.check("bearing.ball_count", p.ball_count as f64) && has_pitch;
        let has_grooves = [
            has_ball,
            faults.check("bearing.inner_groove_curvature", p.groove_curvature.inner),
            faults.check("bearing.outer_groove_curvature", p.groove_curvature.outer),
        ] == [true; 3];
        p.check_materials(&mut faults);
        let (d, pitch) = (p.ball_diameter, p.pitch_diameter);
        if has_balls && pitch * (PI / p.ball_count as f64).sin() <= d {
            let most = (PI / (d / pitch).min(1.0).asin()).ceil() as usize - 1;
            let reason = format!(
                "{} balls of {:.4} mm overlap on a pitch circle of {:.4} mm; at most {most} fit",
                p.ball_count,
                d * 1e3,
                pitch * 1e3
            );
            faults.inconsistent("bearing.ball_count", reason);
        }
        if has_outer && p.outer_diameter <= pitch + d {
            let reason = format!(
                "{:.4} mm leaves no outer ring outside pitch and ball diameter ({:.4} mm)",
                p.outer_diameter * 1e3,
                (pitch + d) * 1e3
            );
            faults.inconsistent("bearing.outer_diameter", reason);
        }
        if has_inner && p.inner_diameter >= pitch - d {
            let reason = format!(
                "{:.4} mm leaves no inner raceway inside pitch less ball diameter ({:.4} mm)",
                p.inner_diameter * 1e3,
                (pitch - d) * 1e3
            );
            faults.inconsistent("bearing.inner_diameter", reason);
        }
        p.check_fit(has_grooves, &mut faults);
        faults.or(|| Self::of_checked(parameters))
    }

    /// The geometry that follows from parameters that fit together.
    fn of_checked(parameters: BearingParameters) -> Self {
        let p = &parameters;
        let (d, pitch, f) = (p.ball_diameter, p.pitch_diameter, p.groove_curvature);
        let distance = p.groove_centre_distance();
        let (radial_clearance, free_contact_angle) = match p.fit {
            Fit::RadialClearance(clearance) => (clearance, p.cosine_of_contact(clearance).min(1.0).acos()),
            Fit::ContactAngle(angle) => (2.0 * distance * (1.0 - angle.cos()), angle),
        };
        let ball_mass = p.ball_material.density * PI * d.powi(3) / 6.0;
        Self {
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
        }
    }

    /// Largest displacement of the spindle from the centre of the outer ring at which a ball may still hold it [m]. In the plane: d + P_d/2, at
    /// which the bottoms of both raceways touch. Along the axis: A + d/2, at which even balls that are pressed into
    /// both raceways by half their radius are passed.
    pub fn largest_displacement(&self) -> SpindlePlay {
        let d = self.parameters.ball_diameter;
        SpindlePlay { radial: d + 0.5 * self.radial_clearance, axial: self.groove_centre_distance + 0.5 * d }
    }

    /// `γ = d cos α / D_m` with the angle that the kinematics use: the free contact angle of an
    /// angular-contact bearing, 0 for radial types.
    pub fn gamma(&self) -> f64 {
        let p = &self.parameters;
        p.ball_diameter * self.kinematic_contact_angle().cos() / p.pitch_diameter
    }

    /// Contact angle for curvatures, kinematics and rating [rad].
    pub(crate) fn kinematic_contact_angle(&self) -> f64 {
        match self.parameters.kind {
            BearingKind::AngularContact => self.free_contact_angle,
            BearingKind::Integrated | BearingKind::DeepGroove => 0.0,
        }
    }
}
