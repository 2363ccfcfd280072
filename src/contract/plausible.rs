//! What is allowed and can be computed, and is yet so far from what is built that a unit may have been misread.

use super::job::Job;
use super::problem::FieldError;
use super::units::{MM, RPM, UM, short, significant};
use crate::physics::contact::traction::TractionLaw;
use crate::physics::defaults::{CrownCage, shaft_mass};
use crate::physics::spindle::Unbalance;
use crate::simulation::input::scene::Scene;
use crate::simulation::model::equilibrium::StaticLoads;

/// Pressure at which ball and raceway together are dented by 10⁻⁴ of the ball's diameter (ISO 76, ball bearings) [Pa].
const STATIC_LIMIT: f64 = 4.2e9;
/// Speed times pitch diameter of the fastest bearings that are made, with a margin [r/min · mm].
const FASTEST: f64 = 5e6;
/// Viscosities of lubricants at work, with a margin [Pa·s].
const VISCOSITIES: [f64; 2] = [1e-4, 2.0];
/// Clearances below are smaller than any fit is ground to [m].
const LEAST_CLEARANCE: f64 = 1e-7;
/// Times as much as the shaft of that bore, or as the cage of that size, and as little.
const FACTOR: f64 = 500.0;
/// Eccentricity that no rotor is run with [m].
const ECCENTRICITY: f64 = 1e-3;
/// Slope between the rings beyond which ball bearings are not run [rad].
const MOST_TILT: f64 = 0.01;
/// Share of the spindle's weight below which a load hardly counts.
const FAINT_LOAD: f64 = 0.1;
/// Softer than plastics [Pa].
const SOFTEST: f64 = 1e9;
/// Diameters of balls as a share of the radial section of their bearing [-]: less than any have, and usual.
const LEAST_BALL: f64 = 0.25;
const USUAL_BALL: f64 = 0.6;
/// From foams to the heaviest metals [kg/m³].
const DENSITIES: [f64; 2] = [500.0, 20_000.0];

/// Notes a field and what may be meant, where it is so.
type Warn<'a> = &'a mut dyn FnMut(bool, &str, &dyn Fn() -> String);

/// Each with its field and what may be meant; the job runs all the same.
pub fn warnings(job: &Job, at_rest: Option<&StaticLoads>) -> Vec<FieldError> {
    let mut found = Vec::new();
    let mut warn = |is_so: bool, field: &str, detail: &dyn Fn() -> String| {
        if is_so {
            found.push(FieldError::new(format!("/scene/{field}"), detail()));
        }
    };
    of_operation(job.scene(), at_rest, &mut warn);
    let (speed, end) = (&job.scene().operation.speed, job.settings.settle + job.settings.duration);
    // A default has six digits.
    let ends_before = end < (1.0 - 1e-5) * speed.end();
    warn(!speed.is_constant() && ends_before, "operation/speed_rpm", &|| {
        format!(
            "goes on to {} s, and the run ends at {} s, at {} r/min: a longer duration_s sees the rest",
            short(significant(speed.end(), 6)),
            short(significant(end, 6)),
            short(significant(RPM.to_user(speed.at(end).1), 4))
        )
    });
    of_bearing(job.scene(), &mut warn);
    if job.needs.cage {
        of_cage(job.scene(), &mut warn);
    }
    let scene = job.scene();
    let viscosity = scene.lubricant.viscosity;
    warn(viscosity != 0.0 && is_outside(viscosity, VISCOSITIES), "lubricant/viscosity_pa_s", &|| {
        format!(
            "{} Pa·s: oils, also those in greases, have 0.001 to 1 Pa·s at work; 1 mPa·s is 0.001",
            short(viscosity)
        )
    });
    let drives = match scene.lubricant.traction {
        // What should be 0 may be off by rounding.
        TractionLaw::SlideRoll { a, d, .. } => d < 0.0 || a + d < -1e-6 * d,
        _ => false,
    };
    warn(drives, "lubricant/traction", &|| {
        "traction drives what slips, in place of braking it, where a + d (at rest) or d (at large slip) is below 0"
            .into()
    });
    let (mass, usual) = (scene.spindle.mass, shaft_mass(MM.to_user(scene.bearing.parameters.inner_diameter)));
    warn(is_outside(mass / usual, [1.0 / FACTOR, FACTOR]), "spindle/mass_kg", &|| {
        format!(
            "{} kg: a shaft of this bore has about {} kg; masses are in kg",
            short(mass),
            short(significant(usual, 2))
        )
    });
    let speed = scene.operating_speed();
    let eccentricity = scene.spindle.unbalance_product(speed).abs() / mass;
    let field = if matches!(scene.spindle.unbalance, Unbalance::Grade(_)) { "balance_grade" } else { "unbalance_g_mm" };
    warn(eccentricity > ECCENTRICITY, &format!("spindle/{field}"), &|| {
        format!("has the centre of mass {} mm off the axis", short(significant(MM.to_user(eccentricity), 2)))
    });
    found
}

fn of_operation(scene: &Scene, at_rest: Option<&StaticLoads>, warn: Warn<'_>) {
    let operation = &scene.operation;
    let loads = || ["axial_load_n", "radial_load_y_n", "radial_load_z_n"].into_iter().zip(operation.load);
    let (largest, load) = loads().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or(("", 0.0));
    let tilt = operation.misalignment.iter().fold(0.0, |most: f64, tilt| most.max(tilt.abs()));
    warn(tilt > MOST_TILT, "operation/misalignment_mrad", &|| {
        format!("{} mrad: ball bearings are run with 3 mrad at most", short(1e3 * tilt))
    });
    let pressure = at_rest.map_or(0.0, |loads| loads.max_pressure);
    warn(pressure > STATIC_LIMIT && tilt <= MOST_TILT, &format!("operation/{largest}"), &|| {
        format!(
            "presses the most loaded ball at rest with {:.0} MPa: beyond {:.0} MPa the raceway is dented for good, and the model is elastic; are load (N) and dimensions (mm) as meant?",
            pressure / 1e6,
            STATIC_LIMIT / 1e6
        )
    });
    let weight = scene.spindle.mass * scene.gravity.abs();
    let is_held = load != 0.0 || weight > 0.0 || scene.bearing.radial_clearance < 0.0;
    warn(!is_held, "operation", &|| {
        "no load, no weight and no preload: nothing holds the spindle, and levels mean little".to_owned()
    });
    warn(load != 0.0 && load.abs() < FAINT_LOAD * weight, &format!("operation/{largest}"), &|| {
        format!("{} N: the spindle alone weighs {} N; loads are in N", short(load), short(significant(weight, 2)))
    });
    let speed = RPM.to_user(operation.speed.largest()) * MM.to_user(scene.bearing.parameters.pitch_diameter);
    warn(speed > FASTEST, "operation/speed_rpm", &|| {
        format!("times the pitch diameter is {speed:.2e} r/min·mm: bearings are made for {FASTEST:.0e} at most")
    });
}

fn of_bearing(scene: &Scene, warn: Warn<'_>) {
    let (bearing, parameters) = (&scene.bearing, &scene.bearing.parameters);
    let clearance = bearing.radial_clearance;
    let (ball, section) = (parameters.ball_diameter, 0.5 * (parameters.outer_diameter - parameters.inner_diameter));
    warn(ball < LEAST_BALL * section, "bearing/ball_diameter_mm", &|| {
        format!(
            "{} mm: between the bore and the outer diameter there are {} mm, of which balls have about {} mm",
            short(MM.to_user(ball)),
            short(MM.to_user(section)),
            short(significant(MM.to_user(USUAL_BALL * section), 2))
        )
    });
    warn(clearance != 0.0 && clearance.abs() < LEAST_CLEARANCE, "bearing/radial_clearance_um", &|| {
        format!("{} µm: nothing is ground to that; clearances are in µm", short(UM.to_user(clearance)))
    });
    for (part, material) in [
        ("ball", &parameters.ball_material),
        ("inner_raceway", &parameters.raceway_material.inner),
        ("outer_raceway", &parameters.raceway_material.outer),
    ] {
        let of = |field: &str| format!("bearing/materials/{part}/{field}");
        warn(material.elastic_modulus < SOFTEST, &of("elastic_modulus_gpa"), &|| {
            format!("{} GPa: steel has 208 GPa, plastics 1 to 4 GPa", short(material.elastic_modulus / 1e9))
        });
        warn(is_outside(material.density, DENSITIES), &of("density_kg_m3"), &|| {
            format!("{} kg/m³: steel has 7830 kg/m³", short(material.density))
        });
    }
}

fn of_cage(scene: &Scene, warn: Warn<'_>) {
    let (cage, parameters) = (&scene.cage, &scene.bearing.parameters);
    let land = cage.land.as_ref().map_or(parameters.pitch_diameter, |land| land.diameter);
    warn(
        is_outside(land, [parameters.inner_diameter, parameters.outer_diameter]),
        "bearing/cage/land/diameter_mm",
        &|| {
            format!(
                "{} mm: lies outside the bearing, which has {} to {} mm",
                short(MM.to_user(land)),
                short(MM.to_user(parameters.inner_diameter)),
                short(MM.to_user(parameters.outer_diameter))
            )
        },
    );
    let ball = parameters.ball_diameter;
    warn(cage.pocket_clearance > 0.5 * ball, "bearing/cage/pocket_clearance_mm", &|| {
        format!(
            "{} mm: the ball has {} mm; pockets leave it some tenths",
            short(MM.to_user(cage.pocket_clearance)),
            short(MM.to_user(ball))
        )
    });
    let usual_grams = CrownCage::scaled(MM.to_user(ball), MM.to_user(parameters.pitch_diameter)).mass_g;
    let grams = 1e3 * cage.mass;
    warn(is_outside(grams / usual_grams, [1.0 / FACTOR, FACTOR]), "bearing/cage/mass_g", &|| {
        format!("{} g: a crown cage of this size has about {} g", short(grams), short(significant(usual_grams, 2)))
    });
    for (field, inertia) in
        [("axial_inertia_kg_m2", cage.axial_inertia), ("transverse_inertia_kg_m2", cage.transverse_inertia)]
    {
        let radius = (inertia / cage.mass).sqrt();
        let within = [parameters.pitch_diameter / FACTOR.sqrt(), parameters.outer_diameter];
        warn(is_outside(radius, within), &format!("bearing/cage/{field}"), &|| {
            format!(
                "{} kg m²: with its mass that is a radius of gyration of {} mm",
                short(inertia),
                short(significant(MM.to_user(radius), 2))
            )
        });
    }
}

fn is_outside(value: f64, [least, most]: [f64; 2]) -> bool {
    value < least || value > most
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

    #[test]
    fn parts_that_do_not_fit_each_other_are_found() {
        let operation = json!({ "speed_rpm": 1500, "radial_load_y_n": 500 });
        let land =
            json!({ "preset": "6205", "cage": { "land": { "clearance_mm": 0.2, "diameter_mm": 90, "width_mm": 2 } } });
        for (field, bearing) in
            [("cage/land/diameter_mm", land), ("ball_diameter_mm", json!({ "preset": "6205", "ball_diameter_mm": 2 }))]
        {
            let found = warned(json!({ "bearing": bearing, "operation": operation }));
            assert!(found.contains(&format!("/scene/bearing/{field}")), "{field}: {found:?}");
        }
    }

    #[test]
    fn runs_that_end_before_their_speed_does_and_spindles_that_nothing_holds_are_found() {
        let profile = |at_s: f64| json!([{ "at_s": 0, "rpm": 0 }, { "at_s": at_s, "rpm": 30_000 }]);
        let of = |at_s: f64| {
            warned(json!({ "bearing": "608", "operation": { "speed_rpm": profile(at_s), "radial_load_y_n": 50 } }))
        };
        assert!(of(5.0).is_empty() && of(50.0) == ["/scene/operation/speed_rpm"], "{:?}", of(50.0));
        let idle = |gravity: f64| {
            warned(json!({ "bearing": "608", "operation": { "speed_rpm": 3000 }, "gravity_m_s2": gravity }))
        };
        assert!(idle(9.81).is_empty() && idle(0.0) == ["/scene/operation"], "{:?}", idle(0.0));
    }

    #[test]
    fn traction_that_drives_is_found() {
        let scene = |d: f64| {
            let law = json!({ "law": "slide_roll", "a": -0.01, "b": 2, "c": 60, "d": d });
            let operation = json!({ "speed_rpm": 17_000, "radial_load_y_n": 97 });
            json!({ "bearing": "608", "operation": operation, "lubricant": { "kind": "grease", "traction": law } })
        };
        assert!(warned(scene(0.01)).is_empty());
        for d in [0.009, -0.01] {
            assert_eq!(warned(scene(d)), ["/scene/lubricant/traction"], "{d}");
        }
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
            ("spindle/mass_kg", json!({ "operation": { "speed_rpm": 1500 }, "spindle": { "mass_kg": 6e-4 } })),
            (
                "spindle/unbalance_g_mm",
                json!({ "operation": { "speed_rpm": 1500 }, "spindle": { "mass_kg": 0.6, "unbalance_g_mm": 5000 } }),
            ),
            (
                "spindle/balance_grade",
                json!({ "operation": { "speed_rpm": 1500 }, "spindle": { "balance_grade": 2500 } }),
            ),
            ("operation/radial_load_y_n", json!({ "operation": { "speed_rpm": 1500, "radial_load_y_n": 0.5 } })),
            (
                "operation/misalignment_mrad",
                json!({ "operation": { "speed_rpm": 1500, "radial_load_y_n": 500, "misalignment_mrad": { "y": 15 } } }),
            ),
            (
                "lubricant/viscosity_pa_s",
                json!({ "operation": { "speed_rpm": 1500 }, "lubricant": { "kind": "oil", "viscosity_pa_s": 1.3e-5 } }),
            ),
            (
                "bearing/cage/pocket_clearance_mm",
                json!({ "operation": { "speed_rpm": 1500 }, "bearing": { "preset": "6205", "cage": { "pocket_clearance_mm": 60 } } }),
            ),
            (
                "bearing/cage/axial_inertia_kg_m2",
                json!({ "operation": { "speed_rpm": 1500 }, "bearing": { "preset": "6205", "cage": { "axial_inertia_kg_m2": 1.217 } } }),
            ),
            (
                "bearing/materials/ball/density_kg_m3",
                json!({ "operation": { "speed_rpm": 1500 }, "bearing": { "preset": "6205", "materials": { "ball": { "elastic_modulus_gpa": 208, "poisson_ratio": 0.3, "density_kg_m3": 78.1 } } } }),
            ),
            (
                "bearing/materials/ball/elastic_modulus_gpa",
                json!({ "operation": { "speed_rpm": 1500 }, "bearing": { "preset": "6205", "materials": { "ball": { "elastic_modulus_gpa": 0.21, "poisson_ratio": 0.3, "density_kg_m3": 7830 } } } }),
            ),
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
