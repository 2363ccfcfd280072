//! A rotor as a Python script for ROSS (ross-rotordynamics).

use std::fmt::Write;

use super::rotor_model::{ModelSupportAnswer, RotorModelAnswer};

/// Versions of ROSS, which name the speeds differently.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RossVersion {
    /// 2.x: `frequency`.
    Two,
    /// 3.x: `speed` of coefficients, `speed_range` of a response.
    Three,
}

impl RossVersion {
    /// Argument for the speeds of tabulated coefficients.
    fn of_table(self) -> &'static str {
        match self {
            Self::Two => "frequency",
            Self::Three => "speed",
        }
    }

    /// Argument for the speeds of a response to unbalance.
    fn of_response(self) -> &'static str {
        match self {
            Self::Two => "frequency",
            Self::Three => "speed_range",
        }
    }
}

/// Coefficients of a bearing of ROSS over displacements here: its x, y and z are y, z and x. It couples no radial motion with the axial one.
const ENTRIES: [(&str, [usize; 2]); 5] =
    [("xx", [1, 1]), ("xy", [1, 2]), ("yx", [2, 1]), ("yy", [2, 2]), ("zz", [0, 0])];

/// The script. It builds `rotor`, and prints its results as JSON when it is run.
///
/// ROSS turns about its z axis, so that (x, y, z) there are (y, z, x) here; both are right-handed. Its bearing element has no tilt, and no coupling of
/// radial and axial motion: those entries are left out, and the script says so.
pub fn script(model: &RotorModelAnswer, version: RossVersion) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = write_script(&mut text, model, version);
    text
}

fn write_script(text: &mut String, model: &RotorModelAnswer, version: RossVersion) -> std::fmt::Result {
    let release = if version == RossVersion::Two { "2" } else { "3" };
    writeln!(
        text,
        "\"\"\"A rotor of raceway for ROSS {release}.x (ross-rotordynamics). SI; (x, y, z) here are (y, z, x) of raceway."
    )?;
    if let Some(dropped) = dropped(model) {
        writeln!(text, "\n{dropped}")?;
    }
    writeln!(text, "\"\"\"\n\nimport json\n\nimport numpy as np\nimport ross as rs\n")?;
    let shear_modulus = model.elastic_modulus_pa / (2.0 * (1.0 + model.poisson_ratio));
    writeln!(
        text,
        "steel = rs.Material(name=\"Shaft\", rho={:?}, E={:?}, G_s={shear_modulus:?})",
        model.density_kg_m3, model.elastic_modulus_pa
    )?;
    writeln!(text, "speeds = np.array({:?})  # rad/s", model.speeds_rad_s)?;
    writeln!(text, "table = np.linspace(0.0, max(1.0, speeds[-1]), {FEWEST_SPEEDS})  # speeds of the coefficients\n")?;
    writeln!(text, "shaft = [")?;
    for (node, element) in model.elements.iter().enumerate() {
        writeln!(
            text,
            "    rs.ShaftElement(L={:?}, idl={1:?}, odl={2:?}, idr={1:?}, odr={2:?}, material=steel, n={node}),",
            element.length_m, element.inner_diameter_m, element.outer_diameter_m
        )?;
    }
    writeln!(text, "]\ndiscs = [")?;
    for disc in &model.discs {
        writeln!(
            text,
            "    rs.DiskElement(n={}, m={:?}, Id={:?}, Ip={:?}),",
            disc.node, disc.mass_kg, disc.transverse_inertia_kg_m2, disc.axial_inertia_kg_m2
        )?;
    }
    writeln!(text, "]\nbearings = [")?;
    for support in &model.supports {
        writeln!(text, "    rs.BearingElement(n={}{}),", support.node, coefficients(support, version))?;
    }
    writeln!(text, "]\nrotor = rs.Rotor(shaft, discs, bearings)\n\n")?;
    writeln!(text, "def unbalance_response():")?;
    writeln!(text, "    \"\"\"Amplitudes at all nodes and speeds for the unbalance planes.\"\"\"")?;
    let of = |value: &dyn Fn(&super::rotor_model::ModelUnbalanceAnswer) -> String| {
        model.unbalances.iter().map(value).collect::<Vec<_>>().join(", ")
    };
    writeln!(
        text,
        "    return rotor.run_unbalance_response(\n        node=[{}],\n        unbalance_magnitude=[{}],\n        unbalance_phase=[{}],\n        \
         {}=speeds,\n    )\n\n",
        of(&|plane| plane.node.to_string()),
        of(&|plane| format!("{:?}", plane.unbalance_kg_m)),
        of(&|plane| format!("{:?}", plane.phase_rad)),
        version.of_response(),
    )?;
    writeln!(text, "if __name__ == \"__main__\":")?;
    writeln!(text, "    modal = [rotor.run_modal(speed=speed, num_modes={}) for speed in speeds]", 2 * MODES)?;
    writeln!(
        text,
        "    print(json.dumps({{\"speeds_rad_s\": speeds.tolist(), \"wd\": [one.wd.tolist() for one in modal]}}))"
    )
}

/// Natural frequencies that the script asks for at each speed.
const MODES: usize = 12;

/// Fewest speeds between which ROSS interpolates without a warning.
const FEWEST_SPEEDS: usize = 5;

/// Arguments of a bearing: its coefficients as a table over speed, a constant where there are too few speeds for one.
fn coefficients(support: &ModelSupportAnswer, version: RossVersion) -> String {
    let is_table = support.k.len() >= FEWEST_SPEEDS;
    let mut text = String::new();
    for (name, matrices) in [("k", &support.k), ("c", &support.c)] {
        for (entry, [row, column]) in ENTRIES {
            let values: Vec<f64> = matrices.iter().map(|matrix| matrix[row][column]).collect();
            // Without kyy ROSS takes kxx in its place.
            if row != column && values.iter().all(|value| *value == 0.0) {
                continue;
            }
            text += &match is_table {
                true => format!(", {name}{entry}={values:?}"),
                false => format!(", {name}{entry}=np.full({FEWEST_SPEEDS}, {:?})", values.last().unwrap_or(&0.0)),
            };
        }
    }
    text + &format!(", {}={}", version.of_table(), if is_table { "speeds" } else { "table" })
}

/// Parts that the script leaves out, in sentences.
fn dropped(model: &RotorModelAnswer) -> Option<String> {
    let nodes_with = |is_dropped: fn(usize, usize) -> bool| -> Option<String> {
        let has_any = |support: &&ModelSupportAnswer| {
            let places = (0..5).flat_map(|row| (0..5).map(move |column| (row, column)));
            let mut dropped = places.filter(|(row, column)| is_dropped(*row, *column));
            let of = |matrices: &[[[f64; 5]; 5]], row: usize, column: usize| {
                matrices.iter().any(|matrix: &[[f64; 5]; 5]| matrix[row][column] != 0.0)
            };
            dropped.any(|(row, column)| of(&support.k, row, column) || of(&support.c, row, column))
        };
        let nodes: Vec<String> =
            model.supports.iter().filter(has_any).map(|support| support.node.to_string()).collect();
        (!nodes.is_empty()).then(|| nodes.join(", "))
    };
    let of_tilt = nodes_with(|row, column| row > 2 || column > 2).map(|nodes| {
        format!(
            "Dropped: entries of tilt of the supports at node {nodes}, which BearingElement does not take. The result of the job\nhas \
             them in `model.supports`."
        )
    });
    let of_coupling = nodes_with(|row, column| row != column && row.min(column) == 0 && row.max(column) < 3).map(|nodes| {
        format!(
            "Dropped: coupling of radial and axial motion of the supports at node {nodes}, which BearingElement does not take."
        )
    });
    let of_shaft = (model.damping_ratio > 0.0).then(|| {
        format!(
            "Dropped: the damping of the shaft, a ratio of {} of its free modes. Modes are less damped here than in the result\nof \
             the job, and responses near critical speeds are larger.",
            model.damping_ratio
        )
    });
    let of_housing = model.leaves_out_housing.then(|| {
        "Dropped: the housing and the seats of outer rings. Supports and bearings stand on the ground here.".to_owned()
    });
    let kept: Vec<&str> = model.left_out.iter().map(|left_out| left_out.term.as_str()).collect();
    let of_terms = (!kept.is_empty())
        .then(|| format!("Kept, as far as ROSS has it, though the scene switches it off: {}.", kept.join(", ")));
    let sentences = of_housing.into_iter().chain(of_tilt).chain(of_coupling).chain(of_shaft).chain(of_terms);
    let sentences: Vec<String> = sentences.collect();
    (!sentences.is_empty()).then(|| sentences.join("\n"))
}
