//! What is allowed and can be computed, and is yet so far from what is built that a unit may have been misread.

use super::job::Job;
use super::problem::FieldError;
use super::scaling::shaft_mass_kg;
use super::units::{MM, RPM, UM, short};
use crate::simulation::equilibrium::StaticLoads;

/// Pressure at which ball and raceway together are dented by 10⁻⁴ of the ball's diameter (ISO 76, ball bearings) [Pa].
const STATIC_LIMIT: f64 = 4.2e9;
/// Speed times pitch diameter of the fastest bearings that are made, with a margin [r/min · mm].
const FASTEST: f64 = 5e6;
/// Most viscous lubricants at work, with a margin [Pa·s].
const MOST_VISCOUS: f64 = 2.0;
/// Clearances below are smaller than any fit is ground to [m].
const LEAST_CLEARANCE: f64 = 1e-7;
/// Times as much as the shaft of that bore.
const HEAVIEST: f64 = 500.0;

/// Each with its field and what may be meant; the job runs all the same.
pub fn warnings(job: &Job, at_rest: Option<&StaticLoads>) -> Vec<FieldError> {
    let scene = job.scene();
    let mut found = Vec::new();
    let mut warn = |is_so: bool, field: &str, detail: String| {
        if is_so {
            found.push(FieldError::new(format!("/scene/{field}"), detail));
        }
    };
    let pressure = at_rest.map_or(0.0, |loads| loads.max_pressure);
    let loads = ["axial_load_n", "radial_load_y_n", "radial_load_z_n"].into_iter().zip(scene.operation.load);
    let largest = loads.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map_or("", |load| load.0);
    warn(
        pressure > STATIC_LIMIT,
        &format!("operation/{largest}"),
        format!(
            "presses the most loaded ball at rest with {:.0} MPa: beyond {:.0} MPa the raceway is dented for good, and the model is elastic; are load (N) and dimensions (mm) as meant?",
            pressure / 1e6,
            STATIC_LIMIT / 1e6
        ),
    );
    let speed = RPM.to_user(scene.operation.speed.largest()) * MM.to_user(scene.bearing.parameters.pitch_diameter);
    warn(
        speed > FASTEST,
        "operation/speed_rpm",
        format!("times the pitch diameter is {speed:.2e} r/min·mm: bearings are made for {FASTEST:.0e} at most"),
    );
    let viscosity = scene.lubricant.viscosity;
    warn(
        viscosity > MOST_VISCOUS,
        "lubricant/viscosity_pa_s",
        format!(
            "{} Pa·s: oils, also those in greases, have 0.001 to 1 Pa·s at work; 1 mPa·s is 0.001",
            short(viscosity)
        ),
    );
    let clearance = scene.bearing.radial_clearance;
    warn(
        clearance != 0.0 && clearance.abs() < LEAST_CLEARANCE,
        "bearing/radial_clearance_um",
        format!("{} µm: nothing is ground to that; clearances are in µm", short(UM.to_user(clearance))),
    );
    let usual = shaft_mass_kg(MM.to_user(scene.bearing.parameters.inner_diameter));
    warn(
        scene.spindle.mass > HEAVIEST * usual,
        "spindle/mass_kg",
        format!(
            "{} kg: a shaft of this bore has about {} kg; masses are in kg",
            short(scene.spindle.mass),
            short(super::units::significant(usual, 2))
        ),
    );
    found
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use crate::contract::presets::presets_answer;
    use crate::contract::{parse_scene_request, resolve_answer};

    fn warned(scene: Value) -> Vec<String> {
        let job = parse_scene_request(json!({ "scene": scene }).to_string().as_bytes()).expect("it can be computed");
        resolve_answer(&job).warnings.into_iter().map(|warning| warning.pointer).collect()
    }

    /// Each quantity a thousand times as large as meant, or as small.
    #[test]
    fn misread_units_are_found() {
        for (field, scene) in [
            ("operation/radial_load_y_n", json!({ "operation": { "speed_rpm": 1500, "radial_load_y_n": 4e6 } })),
            (
                "operation/axial_load_n",
                json!({ "operation": { "speed_rpm": 1500, "axial_load_n": 4e5 }, "spindle": { "axial": "free" } }),
            ),
            ("operation/speed_rpm", json!({ "operation": { "speed_rpm": 4e5 } })),
            (
                "lubricant/viscosity_pa_s",
                json!({ "operation": { "speed_rpm": 1500 }, "lubricant": { "kind": "oil", "viscosity_pa_s": 32 } }),
            ),
            (
                "bearing/radial_clearance_um",
                json!({ "operation": { "speed_rpm": 1500 }, "bearing": { "preset": "6205", "radial_clearance_um": 0.0125 } }),
            ),
            ("spindle/mass_kg", json!({ "operation": { "speed_rpm": 1500 }, "spindle": { "mass_kg": 672.6 } })),
        ] {
            let mut scene = scene;
            if scene.get("bearing").is_none() {
                scene["bearing"] = json!("6205");
            }
            assert_eq!(warned(scene.clone()), [format!("/scene/{field}")], "{scene}");
        }
    }

    #[test]
    fn presets_are_as_they_are_built() {
        for preset in presets_answer().bearings.keys() {
            let scene = json!({ "bearing": preset, "operation": { "speed_rpm": 15000, "radial_load_y_n": 200 } });
            assert!(warned(scene).is_empty(), "{preset}");
        }
    }
}
