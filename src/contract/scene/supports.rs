//! Linear supports of a shaft: springs and dashpots to the ground or to a body of the housing.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::housing::{HousingInput, body};
use super::shaft::check_place;
use super::springs::{SpringFields, springs};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::shapes::optional_object;
use crate::contract::json::units::MM;
use raceway_core::physics::frame::support::{PORT, PortMatrix, Support};

const POINTER: &str = "/scene/supports";
const MAX_SUPPORTS: usize = 16;
/// Largest magnitude of an entry of a matrix, in SI: far above any real one.
const MOST: f64 = 1e13;

/// A spring and a dashpot between shaft and ground or a housing body, for a roller bearing, a plain bearing or a coupling. Either `stiffness_n_per_um`
/// or `matrix`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SupportInput {
    /// Place along the shaft [mm].
    #[schema(example = 40.0)]
    pub at_mm: f64,
    /// Stiffness along x, y and z [N/µm].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([0.0, 50.0, 50.0]))]
    pub stiffness_n_per_um: Option<[f64; 3]>,
    /// Damping along x, y and z [N·s/m]. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([0.0, 200.0, 200.0]))]
    pub damping_n_s_per_m: Option<[f64; 3]>,
    /// Stiffness against tilt about y and z [N·m/mrad]. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([0.0, 0.0]))]
    pub tilt_n_m_per_mrad: Option<[f64; 2]>,
    /// Damping of tilt about y and z [N·m·s/rad]. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = json!([0.0, 0.0]))]
    pub tilt_damping_n_m_s_per_rad: Option<[f64; 2]>,
    /// Complete matrices in place of the other fields.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub matrix: Option<SupportMatrixInput>,
    /// Name of the body or port of the housing that holds it. Default: the ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, max_length = 32)]
    pub on: Option<String>,
}

/// Matrices over x, y, z, β_y, β_z in SI: rows are the force on the support, columns the displacements. β_y = −z′, β_z = y′. They need
/// not be symmetric.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SupportMatrixInput {
    /// Stiffness [N/m, N/rad, N·m/m, N·m/rad], each from −10¹³ to 10¹³.
    #[schema(value_type = Vec<Vec<f64>>, min_items = 5, max_items = 5)]
    pub k: [[f64; PORT]; PORT],
    /// Damping [N·s/m, N·s/rad, N·m·s/m, N·m·s/rad], each from −10¹³ to 10¹³. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<Vec<Vec<f64>>>, min_items = 5, max_items = 5)]
    pub c: Option<[[f64; PORT]; PORT]>,
}

/// The supports in SI. Errors are noted in `defaults`.
pub fn resolve(
    supports: &mut [SupportInput],
    defaults: &mut Defaults,
    length_mm: f64,
    housing: Option<&HousingInput>,
) -> Vec<Support> {
    if supports.len() > MAX_SUPPORTS {
        defaults.refuse(POINTER, format!("{} supports: at most {MAX_SUPPORTS}", supports.len()));
    }
    let resolved = supports.iter_mut().enumerate();
    resolved
        .map(|(index, support)| support.resolve(defaults, &format!("{POINTER}/{index}"), length_mm, housing))
        .collect()
}

impl SupportInput {
    fn resolve(
        &mut self,
        defaults: &mut Defaults,
        at: &str,
        length_mm: f64,
        housing: Option<&HousingInput>,
    ) -> Support {
        check_place(defaults, (at, "at_mm"), self.at_mm, length_mm);
        let on = body(housing, self.on.as_ref(), defaults, format!("{at}/on"));
        let (stiffness, damping) = match self.matrix.clone() {
            Some(matrix) => self.of_matrix(defaults, at, &matrix),
            None => {
                let fields = SpringFields {
                    stiffness: &self.stiffness_n_per_um,
                    damping: &mut self.damping_n_s_per_m,
                    tilt: &mut self.tilt_n_m_per_mrad,
                    tilt_damping: &mut self.tilt_damping_n_m_s_per_rad,
                };
                springs(defaults, at, fields)
            }
        };
        Support { at: MM.to_si(self.at_mm), on, stiffness, damping }
    }

    fn of_matrix(&self, defaults: &mut Defaults, at: &str, matrix: &SupportMatrixInput) -> (PortMatrix, PortMatrix) {
        let others = [
            ("stiffness_n_per_um", self.stiffness_n_per_um.is_some()),
            ("damping_n_s_per_m", self.damping_n_s_per_m.is_some()),
            ("tilt_n_m_per_mrad", self.tilt_n_m_per_mrad.is_some()),
            ("tilt_damping_n_m_s_per_rad", self.tilt_damping_n_m_s_per_rad.is_some()),
        ];
        for (name, _) in others.into_iter().filter(|field| field.1) {
            defaults.refuse(format!("{at}/{name}"), "give either this or `matrix`");
        }
        let damping = matrix.c.unwrap_or_default();
        for (name, values) in [("k", &matrix.k), ("c", &damping)] {
            for (row, column) in (0..PORT).flat_map(|row| (0..PORT).map(move |column| (row, column))) {
                let value = values[row][column];
                if value.abs() > MOST || !value.is_finite() {
                    let detail = format!("{value:e}: must be from {:e} to {MOST:e}", -MOST);
                    defaults.refuse(format!("{at}/matrix/{name}/{row}/{column}"), detail);
                }
            }
        }
        (matrix.k, damping)
    }
}
