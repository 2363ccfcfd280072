//! The outer ring of a bearing on a shaft: its seat, and its place in it.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::housing::{HousingInput, body};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::significant;
use crate::contract::json::problem::listed;
use crate::contract::json::shapes::optional_object;
use crate::contract::json::units::{MRAD, N_M_PER_MRAD, N_PER_UM, UM};
use raceway_core::physics::bearing::Bearing;
use raceway_core::physics::frame::shaft::USUAL_DAMPING_RATIO;
use raceway_core::physics::frame::support::diagonal;
use raceway_core::physics::statics::shaft::Spring;
use raceway_core::rotor::input::Seat;

/// Outer ring of a bearing: held in the ground or in a housing body.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OuterRingInput {
    /// Seat. Default `rigid`.
    #[schema(nullable = false)]
    pub seat: Option<OuterRingSeatName>,
    /// Name of the body or port of the housing that holds it. Default: the ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, max_length = 32, example = "head")]
    pub on: Option<String>,
    /// Stiffness of an elastic seat along the axis and across it [N/µm].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([200.0, 400.0]))]
    pub stiffness_n_per_um: Option<[f64; 2]>,
    /// Stiffness of an elastic seat against tilt [N·m/mrad]. Default: that of its stiffness, spread evenly over the width of the ring and its
    /// circumference: k_r w²/12 + k_x D²/8.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 50.0)]
    pub tilt_n_m_per_mrad: Option<f64>,
    /// Damping of an elastic seat along the axis and across it [N·s/m], by default a ratio of 0.005 for the ring on it; of a sliding one along the axis,
    /// the second 0, by default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([100.0, 100.0]))]
    pub damping_n_s_per_m: Option<[f64; 2]>,
    /// Damping of the tilt of an elastic seat [N·m·s/rad]. Default: a ratio of 0.005 for the ring on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.0)]
    pub tilt_damping_n_m_s_per_rad: Option<f64>,
    /// Force of the spring on a sliding ring at rest, under the weight without other loads [N]. It loads the balls: it pushes the ring of a `+x`
    /// bearing along −X.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 150.0)]
    pub spring_force_n: Option<f64>,
    /// Stiffness of this spring [N/µm]. Default 0: the force is constant.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.05)]
    pub spring_n_per_um: Option<f64>,
    /// Mass of an elastic or sliding ring [kg]; across the axis a sliding one is part of its body. Default: a ring from the bottom of the groove to the
    /// outside.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.05)]
    pub mass_kg: Option<f64>,
    /// Displacement of the outer ring from the centred place.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub offset_um: Option<OffsetInput>,
    /// Tilt of the outer ring.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub tilt_mrad: Option<OuterTiltInput>,
}

/// `rigid`: moves with its body, or is held in the ground. `elastic`: on a spring of its own. `sliding`: moves along the axis on a spring that
/// preloads the bearing, with its body otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OuterRingSeatName {
    Rigid,
    Elastic,
    Sliding,
}

/// Displacement along X, Y and Z [µm]. Default 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OffsetInput {
    /// Along X [µm]. Default 0.
    #[schema(nullable = false)]
    pub x: Option<f64>,
    /// Along Y [µm]. Default 0.
    #[schema(nullable = false)]
    pub y: Option<f64>,
    /// Along Z [µm]. Default 0.
    #[schema(nullable = false)]
    pub z: Option<f64>,
}

/// Rotation about Y and Z [mrad]. Default 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OuterTiltInput {
    /// About Y [mrad]. Default 0.
    #[schema(nullable = false)]
    pub y: Option<f64>,
    /// About Z [mrad]. Default 0.
    #[schema(nullable = false)]
    pub z: Option<f64>,
}

/// An outer ring in SI.
pub struct ResolvedOuterRing {
    pub pose: [f64; 5],
    /// Number of the body that holds it; `None`: the ground.
    pub on: Option<usize>,
    pub seat: Seat,
}

impl OuterRingInput {
    /// The ring of a bearing; `at`: pointer to it. Errors are noted in `defaults`.
    pub fn resolve(
        &mut self,
        defaults: &mut Defaults,
        at: &str,
        bearing: &Bearing,
        housing: Option<&HousingInput>,
    ) -> ResolvedOuterRing {
        let name = defaults.fill(format!("{at}/seat"), &mut self.seat, OuterRingSeatName::Rigid);
        let on = body(housing, self.on.as_ref(), defaults, format!("{at}/on"));
        self.refuse_unused(name, defaults, at);
        let seat = match name {
            OuterRingSeatName::Rigid => Seat::Rigid,
            OuterRingSeatName::Elastic => self.elastic(defaults, at, bearing),
            OuterRingSeatName::Sliding => self.sliding(defaults, at, bearing),
        };
        ResolvedOuterRing { pose: self.pose(defaults, at), on, seat }
    }

    /// Refuses fields that belong to other seats.
    fn refuse_unused(&self, seat: OuterRingSeatName, defaults: &mut Defaults, at: &str) {
        use OuterRingSeatName::{Elastic, Sliding};
        let fields: [(&str, bool, &[OuterRingSeatName]); 7] = [
            ("stiffness_n_per_um", self.stiffness_n_per_um.is_some(), &[Elastic]),
            ("tilt_n_m_per_mrad", self.tilt_n_m_per_mrad.is_some(), &[Elastic]),
            ("damping_n_s_per_m", self.damping_n_s_per_m.is_some(), &[Elastic, Sliding]),
            ("tilt_damping_n_m_s_per_rad", self.tilt_damping_n_m_s_per_rad.is_some(), &[Elastic]),
            ("spring_force_n", self.spring_force_n.is_some(), &[Sliding]),
            ("spring_n_per_um", self.spring_n_per_um.is_some(), &[Sliding]),
            ("mass_kg", self.mass_kg.is_some(), &[Elastic, Sliding]),
        ];
        for (field, is_given, seats) in fields {
            if is_given && !seats.contains(&seat) {
                let seats = seats.iter().map(|seat| if *seat == Elastic { "elastic" } else { "sliding" });
                defaults.refuse(format!("{at}/{field}"), format!("only with `seat` {}", listed(seats)));
            }
        }
    }

    fn elastic(&mut self, defaults: &mut Defaults, at: &str, bearing: &Bearing) -> Seat {
        let pointer = format!("{at}/stiffness_n_per_um");
        let stiffness = defaults.require(pointer.clone(), &self.stiffness_n_per_um, [1.0; 2]);
        let [axial, radial] = stiffness.map(|value| N_PER_UM.to_si(value));
        let shape = &bearing.parameters;
        let spread = radial * shape.width.powi(2) / 12.0 + axial * shape.outer_diameter.powi(2) / 8.0;
        let usual = significant(N_M_PER_MRAD.to_user(spread), 6);
        if let Some(tilt) = self.tilt_n_m_per_mrad {
            defaults.check_of_rotor(&format!("{at}/tilt_n_m_per_mrad"), tilt);
        }
        let tilt = defaults.fill(format!("{at}/tilt_n_m_per_mrad"), &mut self.tilt_n_m_per_mrad, usual);
        for (index, stiffness) in stiffness.into_iter().enumerate() {
            defaults.check_of_rotor(&format!("{pointer}/{index}"), stiffness);
        }
        let (mass, tilt) = (self.mass(defaults, at, bearing), N_M_PER_MRAD.to_si(tilt));
        let ring = ring(bearing);
        let inertia = mass * ring.squares;
        for (index, damping) in self.damping_n_s_per_m.iter().flatten().enumerate() {
            defaults.check_of_rotor(&format!("{at}/damping_n_s_per_m/{index}"), *damping);
        }
        let of_tilt = format!("{at}/tilt_damping_n_m_s_per_rad");
        if let Some(damping) = self.tilt_damping_n_m_s_per_rad {
            defaults.check_of_rotor(&of_tilt, damping);
        }
        // A stiffness below 0 is refused already.
        let critical = |stiffness: f64, mass: f64| 2.0 * (stiffness * mass).max(0.0).sqrt();
        // As of the shaft's own modes: without any, a stiff seat would swing on, faster than steps resolve.
        let usual = |stiffness: f64, mass: f64| significant(USUAL_DAMPING_RATIO * critical(stiffness, mass), 6);
        let of_ring = [usual(axial, mass), usual(radial, mass)];
        let damping = defaults.fill(format!("{at}/damping_n_s_per_m"), &mut self.damping_n_s_per_m, of_ring);
        let of_tilt = defaults.fill(of_tilt, &mut self.tilt_damping_n_m_s_per_rad, usual(tilt, inertia));
        Seat::Elastic {
            mass,
            inertia,
            polar: mass * ring.polar_squares,
            stiffness: diagonal([axial, radial, radial, tilt, tilt]),
            damping: diagonal([damping[0], damping[1], damping[1], of_tilt, of_tilt]),
        }
    }

    fn sliding(&mut self, defaults: &mut Defaults, at: &str, bearing: &Bearing) -> Seat {
        let force = defaults.require(format!("{at}/spring_force_n"), &self.spring_force_n, 0.0);
        let stiffness = defaults.fill(format!("{at}/spring_n_per_um"), &mut self.spring_n_per_um, 0.0);
        let damping = defaults.fill(format!("{at}/damping_n_s_per_m"), &mut self.damping_n_s_per_m, [0.0; 2]);
        defaults.check_of_rotor(&format!("{at}/spring_force_n"), force);
        defaults.check_of_rotor(&format!("{at}/spring_n_per_um"), stiffness);
        defaults.check_of_rotor(&format!("{at}/damping_n_s_per_m/0"), damping[0]);
        if damping[1] != 0.0 {
            defaults.refuse(
                format!("{at}/damping_n_s_per_m/1"),
                "must be 0: across the axis a sliding ring moves with its body",
            );
        }
        let mass = self.mass(defaults, at, bearing);
        Seat::Sliding { mass, spring: Spring { force, stiffness: N_PER_UM.to_si(stiffness) }, damping: damping[0] }
    }

    fn mass(&mut self, defaults: &mut Defaults, at: &str, bearing: &Bearing) -> f64 {
        let pointer = format!("{at}/mass_kg");
        let mass = defaults.fill(pointer.clone(), &mut self.mass_kg, significant(ring(bearing).mass, 6));
        if defaults.check_of_rotor(&pointer, mass) { mass } else { 1.0 }
    }

    /// Pose of the outer ring.
    fn pose(&mut self, defaults: &mut Defaults, at: &str) -> [f64; 5] {
        let mut take = |name: &str, field: &mut Option<f64>| {
            let pointer = format!("{at}/{name}");
            let value = defaults.fill(pointer.clone(), field, 0.0);
            defaults.check_of_rotor(&pointer, value);
            value
        };
        let offset = self.offset_um.get_or_insert_default();
        let x = take("offset_um/x", &mut offset.x);
        let y = take("offset_um/y", &mut offset.y);
        let z = take("offset_um/z", &mut offset.z);
        let tilt = self.tilt_mrad.get_or_insert_default();
        let (about_y, about_z) = (take("tilt_mrad/y", &mut tilt.y), take("tilt_mrad/z", &mut tilt.z));
        [UM.to_si(x), UM.to_si(y), UM.to_si(z), MRAD.to_si(about_y), MRAD.to_si(about_z)]
    }
}

/// A cylindrical ring from the bottom of the outer groove to the outside.
struct Ring {
    mass: f64,
    /// Moment of inertia about a diameter over the mass [m²].
    squares: f64,
    /// About the axis.
    polar_squares: f64,
}

fn ring(bearing: &Bearing) -> Ring {
    let shape = &bearing.parameters;
    let bottom = shape.pitch_diameter + shape.ball_diameter + 0.5 * bearing.radial_clearance;
    let [outer, inner] = [shape.outer_diameter, bottom].map(|diameter| diameter.powi(2));
    Ring {
        mass: shape.raceway_material.outer.density * shape.width * PI / 4.0 * (outer - inner).max(0.0),
        squares: (outer + inner) / 16.0 + shape.width.powi(2) / 12.0,
        polar_squares: (outer + inner) / 8.0,
    }
}
