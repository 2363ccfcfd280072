//! The elements and matrices of a rotor analysis as JSON, for other programs, and as a script for ROSS.

use raceway_core::physics::frame::mesh::Mesh;
use raceway_core::physics::frame::support::PORT;
use raceway_core::rotor::result::RotorResult;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::report::LeftOutAnswer;
use crate::contract::job::rotor::RotorJob;
use crate::contract::json::units::RPM;

/// The calculated rotor in SI. Nodes are numbered from 0 at the end at x = 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RotorModelAnswer {
    /// Young's modulus [Pa].
    pub elastic_modulus_pa: f64,
    /// Poisson's ratio [-].
    pub poisson_ratio: f64,
    /// Density [kg/m³]; 0 of a rigid spindle, whose mass is a disc and whose element is its outline.
    pub density_kg_m3: f64,
    /// Damping ratio of the free modes of the shaft [-].
    pub damping_ratio: f64,
    /// Elements in their order; element k lies between the nodes k and k + 1.
    pub elements: Vec<ElementAnswer>,
    /// Discs.
    pub discs: Vec<ModelDiscAnswer>,
    /// Unbalance planes.
    pub unbalances: Vec<ModelUnbalanceAnswer>,
    /// Supports, then bearings, with their complete matrices over x, y, z, β_y, β_z.
    pub supports: Vec<ModelSupportAnswer>,
    /// True if housing bodies or outer rings move; the model leaves them out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub leaves_out_housing: bool,
    /// Terms that the analysis is without because the scene switches them off. Their data stand here all the same.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOutAnswer>,
    /// Operating speed [rad/s].
    pub speed_rad_s: f64,
    /// Requested speeds [rad/s].
    pub speeds_rad_s: Vec<f64>,
}

/// A beam element.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ElementAnswer {
    /// [m]
    pub length_m: f64,
    /// [m]
    pub outer_diameter_m: f64,
    /// [m]
    pub inner_diameter_m: f64,
}

/// A disc at a node.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ModelDiscAnswer {
    /// Number of the node.
    pub node: u64,
    /// [kg]
    pub mass_kg: f64,
    /// About a diameter [kg m²].
    pub transverse_inertia_kg_m2: f64,
    /// About the axis [kg m²].
    pub axial_inertia_kg_m2: f64,
}

/// An unbalance at a node.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ModelUnbalanceAnswer {
    /// Number of the node.
    pub node: u64,
    /// Mass times eccentricity [kg m].
    pub unbalance_kg_m: f64,
    /// Angle from +Y towards +Z [rad].
    pub phase_rad: f64,
}

/// A support or bearing at a node, its matrices at each of `speeds_rad_s`, or one where they do not depend on speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ModelSupportAnswer {
    /// Number of the node.
    pub node: u64,
    /// Stiffness [N/m, N/rad, N·m/m, N·m/rad].
    #[schema(value_type = Vec<Vec<Vec<f64>>>)]
    pub k: Vec<[[f64; PORT]; PORT]>,
    /// Damping [N·s/m, N·s/rad, N·m·s/m, N·m·s/rad].
    #[schema(value_type = Vec<Vec<Vec<f64>>>)]
    pub c: Vec<[[f64; PORT]; PORT]>,
}

impl RotorModelAnswer {
    /// True if the shaft is a rigid spindle: every shaft of a request has mass.
    pub fn is_rigid_spindle(&self) -> bool {
        self.density_kg_m3 == 0.0
    }

    /// The model of a job on the nodes of its result.
    pub fn of(job: &RotorJob, result: &RotorResult) -> Self {
        let rotor = &job.rotor;
        let mesh = Mesh::new(&rotor.shaft, &result.nodes, f64::INFINITY);
        let node = |at: f64| mesh.node(at) as u64;
        let material = rotor.shaft.material;
        Self {
            elastic_modulus_pa: material.elastic_modulus,
            poisson_ratio: material.poisson_ratio,
            density_kg_m3: material.density,
            damping_ratio: rotor.shaft.damping_ratio,
            elements: mesh
                .elements
                .iter()
                .map(|element| ElementAnswer {
                    length_m: element.length,
                    outer_diameter_m: element.section.outer_diameter,
                    inner_diameter_m: element.section.inner_diameter,
                })
                .collect(),
            discs: rotor
                .shaft
                .discs
                .iter()
                .map(|disc| ModelDiscAnswer {
                    node: node(disc.at),
                    mass_kg: disc.mass,
                    transverse_inertia_kg_m2: disc.transverse_inertia,
                    axial_inertia_kg_m2: disc.axial_inertia,
                })
                .collect(),
            unbalances: rotor
                .unbalances
                .iter()
                .map(|plane| ModelUnbalanceAnswer {
                    node: node(plane.at),
                    unbalance_kg_m: plane.product,
                    phase_rad: plane.phase,
                })
                .collect(),
            supports: rotor
                .supports
                .iter()
                .map(|support| (support.at, vec![(support.stiffness, support.damping)]))
                .chain(result.bearings.iter().map(|bearing| (bearing.at, bearing.over_speed.clone())))
                .map(|(at, over_speed)| {
                    let (k, c) = over_speed.into_iter().unzip();
                    ModelSupportAnswer { node: node(at), k, c }
                })
                .collect(),
            left_out: job.omitted.iter().map(LeftOutAnswer::from).collect(),
            leaves_out_housing: rotor.has_moving_housing(),
            speed_rad_s: rotor.speed,
            speeds_rad_s: job.speeds_rpm.iter().map(|rpm| RPM.to_si(*rpm)).collect(),
        }
    }
}
