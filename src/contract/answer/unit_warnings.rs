//! Warnings of values that are valid, but so unusual that a unit may be wrong.

use std::f64::consts::PI;

use crate::contract::job::simulation::Simulation;
use crate::contract::json::numbers::{short, significant};
use crate::contract::json::problem::FieldError;
use crate::contract::json::units::{MM, RPM, UM};
use raceway_core::physics::bearing::BearingKind;
use raceway_core::physics::contact::hertz::{STATIC_PRESSURE_LIMIT, raceway_contacts};
use raceway_core::physics::contact::traction::TractionLaw;
use raceway_core::physics::defaults::{CrownCage, shaft_mass};
use raceway_core::physics::spindle::{AxialHold, Unbalance};
use raceway_core::simulation::input::scene::Scene;
use raceway_core::simulation::model::equilibrium::StaticLoads;

/// Speed times pitch diameter of the fastest bearings in use, with a margin [r/min · mm].
const MAX_SPEED_FACTOR: f64 = 5e6;
/// Viscosities of lubricants at running temperature, with a margin [Pa·s].
const VISCOSITIES: [f64; 2] = [1e-4, 2.0];
/// Smallest clearance that can be ground [m].
const MIN_CLEARANCE: f64 = 1e-7;
/// Largest ratio of a mass to that of a usual shaft or cage of the same size [-].
const MAX_MASS_RATIO: f64 = 500.0;
/// Largest eccentricity of a rotor [m].
const MAX_ECCENTRICITY: f64 = 1e-3;
/// Largest misalignment between the rings of a ball bearing [rad].
const MAX_TILT: f64 = 0.01;
/// Load of the most loaded ball over the mean load of all balls, for a radial force (Stribeck) [-].
const STRIBECK: f64 = 5.0;
/// Load divided by the spindle's weight below which the load hardly matters [-].
const MIN_LOAD_RATIO: f64 = 0.1;
/// Elastic modulus of soft plastics [Pa].
const MIN_ELASTIC_MODULUS: f64 = 1e9;
/// Ball diameter divided by the radial section of the bearing [-]: smallest and usual.
const MIN_BALL_RATIO: f64 = 0.25;
const USUAL_BALL_RATIO: f64 = 0.6;
/// Densities from foams to the heaviest metals [kg/m³].
const DENSITIES: [f64; 2] = [500.0, 20_000.0];

/// Notes a warning of a field where the condition holds.
type Warn<'a> = &'a mut dyn FnMut(bool, &str, &dyn Fn() -> String);

/// Warnings of a simulation, each with its field. They do not prevent it from running.
pub fn warnings(simulation: &Simulation, at_rest: Option<&StaticLoads>) -> Vec<FieldError> {
    let mut found = Vec::new();
    let mut warn = |condition: bool, field: &str, detail: &dyn Fn() -> String| {
        if condition {
            found.push(FieldError::new(format!("/scene/{field}"), detail()));
        }
    };
    of_operation(simulation.scene(), at_rest, &mut warn);
    let (speed, end) = (&simulation.scene().operation.speed, simulation.settings.settle + simulation.settings.duration);
    // The default duration is rounded to six digits.
    let ends_before = end < (1.0 - 1e-5) * speed.end();
    warn(!speed.is_constant() && ends_before, "operation/speed_rpm", &|| {
        format!(
            "the profile ends at {} s, but the run at {} s, at {} r/min; increase duration_s to simulate the rest",
            short(significant(speed.end(), 6)),
            short(significant(end, 6)),
            short(significant(RPM.to_user(speed.at(end).1), 4))
        )
    });
    of_load_times(simulation, &mut warn);
    of_bearing(simulation.scene(), &mut warn);
    if simulation.terms.cage {
        of_cage(simulation.scene(), &mut warn);
    } else {
        of_loose_balls(simulation.scene(), &mut warn);
    }
    let scene = simulation.scene();
    let viscosity = scene.lubricant.viscosity;
    warn(viscosity != 0.0 && is_outside(viscosity, VISCOSITIES), "lubricant/viscosity_pa_s", &|| {
        format!(
            "{} Pa·s: lubricating oils have 0.001 to 1 Pa·s at running temperature; 1 mPa·s is 0.001 Pa·s",
            short(viscosity)
        )
    });
    let drives = match scene.lubricant.traction {
        // A sum of zero may differ from it by rounding.
        TractionLaw::SlideRoll { a, d, .. } => d < 0.0 || a + d < -1e-6 * d,
        _ => false,
    };
    warn(drives, "lubricant/traction", &|| {
        "a + d (at rest) or d (at large slip) is below 0: traction then accelerates slip instead of opposing it".into()
    });
    let (mass, usual) = (scene.spindle.mass, shaft_mass(MM.to_user(scene.bearing.parameters.inner_diameter)));
    warn(is_outside(mass / usual, [1.0 / MAX_MASS_RATIO, MAX_MASS_RATIO]), "spindle/mass_kg", &|| {
        format!(
            "{} kg: a shaft of this bore has about {} kg; is the mass in kg?",
            short(mass),
            short(significant(usual, 2))
        )
    });
    let speed = scene.operating_speed();
    let eccentricity = scene.spindle.unbalance_product(speed).abs() / mass;
    let field = if matches!(scene.spindle.unbalance, Unbalance::Grade(_)) { "balance_grade" } else { "unbalance_g_mm" };
    warn(eccentricity > MAX_ECCENTRICITY, &format!("spindle/{field}"), &|| {
        format!(
            "places the centre of mass {} mm off the axis; is the unit right?",
            short(significant(MM.to_user(eccentricity), 2))
        )
    });
    found
}

/// Loads that change before or after the recorded time.
fn of_load_times(simulation: &Simulation, warn: Warn<'_>) {
    let (begin, loads) = (simulation.settings.settle, &simulation.scene().operation.loads);
    let end = (begin + simulation.settings.duration) * (1.0 + 1e-5);
    for (place, load) in loads.iter().enumerate() {
        let Some(last) = load.end() else { continue };
        warn(last > end, &format!("operation/loads/{place}"), &|| {
            let (last, end) = (short(significant(last, 6)), short(significant(end, 4)));
            format!("the load changes until {last} s, but the run ends at {end} s; increase duration_s")
        });
        warn(last < begin && load.shock().is_some(), &format!("operation/loads/{place}/shock"), &|| {
            let (last, begin) = (short(significant(last, 6)), short(significant(begin, 4)));
            format!(
                "the shock ends at {last} s, before recording begins at {begin} s; reduce settle_s or increase at_s"
            )
        });
    }
}

fn of_operation(scene: &Scene, at_rest: Option<&StaticLoads>, warn: Warn<'_>) {
    let operation = &scene.operation;
    let loads = || ["axial_load_n", "radial_load_y_n", "radial_load_z_n"].into_iter().zip(operation.load);
    let (largest, load) = loads().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or(("", 0.0));
    let tilt = operation.misalignment.iter().fold(0.0, |most: f64, tilt| most.max(tilt.abs()));
    warn(tilt > MAX_TILT, "operation/misalignment_mrad", &|| {
        format!("{} mrad: ball bearings tolerate about 3 mrad; is the angle in mrad?", short(1e3 * tilt))
    });
    let pressure = at_rest.map_or(0.0, |loads| loads.max_pressure);
    let weight = scene.spindle.mass * scene.gravity.abs();
    let balls = scene.bearing.parameters.ball_count as f64;
    // The field that causes the pressure: the largest force, or a preload that loads a ball more than this force does.
    let (cause, question) = if STRIBECK * load.abs().max(weight) / balls <= preload(scene) {
        ("bearing/radial_clearance_um".to_owned(), "Is the clearance in µm?")
    } else if weight > load.abs() {
        ("spindle/mass_kg".to_owned(), "Is the mass in kg?")
    } else {
        (format!("operation/{largest}"), "Is the load in N, and are the dimensions in mm?")
    };
    warn(pressure > STATIC_PRESSURE_LIMIT && tilt <= MAX_TILT, &cause, &|| {
        format!(
            "the static contact pressure of the most loaded ball is {:.0} MPa. Above {:.0} MPa the raceway deforms permanently, and the model is elastic. {question}",
            pressure / 1e6,
            STATIC_PRESSURE_LIMIT / 1e6
        )
    });
    let is_held = operation.start_load() != [0.0; 5] || weight > 0.0 || scene.bearing.radial_clearance < 0.0;
    warn(!is_held, "operation", &|| {
        "no load, no weight and no preload: nothing holds the spindle, and levels have little meaning".to_owned()
    });
    warn(load != 0.0 && load.abs() < MIN_LOAD_RATIO * weight, &format!("operation/{largest}"), &|| {
        format!(
            "{} N: the weight of the spindle alone is {} N; is the load in N?",
            short(load),
            short(significant(weight, 2))
        )
    });
    let speed = RPM.to_user(operation.speed.largest()) * MM.to_user(scene.bearing.parameters.pitch_diameter);
    let is_offset = matches!(scene.spindle.axial, AxialHold::Offset(offset) if offset != 0.0);
    let is_angular = scene.bearing.parameters.kind == BearingKind::AngularContact;
    warn(
        is_angular && operation.load[0] == 0.0 && !is_offset && scene.bearing.radial_clearance > 0.0,
        "operation/axial_load_n",
        &|| {
            "an angular-contact bearing without axial load or preload: its balls run at small contact angles, far from the design".into()
        },
    );
    warn(speed > MAX_SPEED_FACTOR, "operation/speed_rpm", &|| {
        format!("speed times pitch diameter is {speed:.2e} r/min·mm: bearings reach at most {MAX_SPEED_FACTOR:.0e}")
    });
}

/// Load that the radial preload puts on one ball [N]: half of the interference on each raceway in series.
fn preload(scene: &Scene) -> f64 {
    let stiffness = raceway_contacts(&scene.bearing).map(|contact| contact.stiffness);
    let compliance = stiffness.inner.powf(-2.0 / 3.0) + stiffness.outer.powf(-2.0 / 3.0);
    (0.5 * (-scene.bearing.radial_clearance).max(0.0) / compliance).powf(1.5)
}

fn of_bearing(scene: &Scene, warn: Warn<'_>) {
    let (bearing, parameters) = (&scene.bearing, &scene.bearing.parameters);
    let clearance = bearing.radial_clearance;
    let (ball, section) = (parameters.ball_diameter, 0.5 * (parameters.outer_diameter - parameters.inner_diameter));
    warn(ball < MIN_BALL_RATIO * section, "bearing/ball_diameter_mm", &|| {
        format!(
            "{} mm: the radial section is {} mm, for which balls of about {} mm are usual",
            short(MM.to_user(ball)),
            short(MM.to_user(section)),
            short(significant(MM.to_user(USUAL_BALL_RATIO * section), 2))
        )
    });
    warn(clearance != 0.0 && clearance.abs() < MIN_CLEARANCE, "bearing/radial_clearance_um", &|| {
        format!("{} µm: smaller than any grinding tolerance; is the clearance in µm?", short(UM.to_user(clearance)))
    });
    for (part, material) in [
        ("ball", &parameters.ball_material),
        ("inner_raceway", &parameters.raceway_material.inner),
        ("outer_raceway", &parameters.raceway_material.outer),
    ] {
        let of = |field: &str| format!("bearing/materials/{part}/{field}");
        warn(material.elastic_modulus < MIN_ELASTIC_MODULUS, &of("elastic_modulus_gpa"), &|| {
            format!("{} GPa: steel has 208 GPa, plastics 1 to 4 GPa", short(material.elastic_modulus / 1e9))
        });
        warn(is_outside(material.density, DENSITIES), &of("density_kg_m3"), &|| {
            format!("{} kg/m³: steel has 7830 kg/m³", short(material.density))
        });
    }
}

/// Balls that gather side by side on less than half of the pitch circle leave the spindle free to the other side.
fn of_loose_balls(scene: &Scene, warn: Warn<'_>) {
    let parameters = &scene.bearing.parameters;
    let spacing = 2.0 * (parameters.ball_diameter / parameters.pitch_diameter).asin();
    let (balls, least) = (parameters.ball_count as f64, (PI / spacing).floor() + 2.0);
    warn(balls < least, "bearing/ball_count", &|| {
        format!(
            "without a cage {balls} balls may gather within {:.0}°, and nothing holds the spindle on the other side; {least} balls \
             reach around half of it",
            ((balls - 1.0) * spacing).to_degrees()
        )
    });
}

fn of_cage(scene: &Scene, warn: Warn<'_>) {
    let (cage, parameters) = (&scene.cage, &scene.bearing.parameters);
    let land = cage.land.as_ref().map_or(parameters.pitch_diameter, |land| land.diameter);
    warn(
        is_outside(land, [parameters.inner_diameter, parameters.outer_diameter]),
        "bearing/cage/land/diameter_mm",
        &|| {
            format!(
                "{} mm: outside the bearing, whose rings span {} to {} mm",
                short(MM.to_user(land)),
                short(MM.to_user(parameters.inner_diameter)),
                short(MM.to_user(parameters.outer_diameter))
            )
        },
    );
    let ball = parameters.ball_diameter;
    warn(cage.pocket_clearance > 0.5 * ball, "bearing/cage/pocket_clearance_mm", &|| {
        format!(
            "{} mm: large for a ball of {} mm; a few tenths of a millimetre are usual",
            short(MM.to_user(cage.pocket_clearance)),
            short(MM.to_user(ball))
        )
    });
    let usual_grams = CrownCage::scaled(MM.to_user(ball), MM.to_user(parameters.pitch_diameter)).mass_g;
    let grams = 1e3 * cage.mass;
    warn(is_outside(grams / usual_grams, [1.0 / MAX_MASS_RATIO, MAX_MASS_RATIO]), "bearing/cage/mass_g", &|| {
        format!("{} g: a crown cage of this size has about {} g", short(grams), short(significant(usual_grams, 2)))
    });
    for (field, inertia) in
        [("axial_inertia_kg_m2", cage.axial_inertia), ("transverse_inertia_kg_m2", cage.transverse_inertia)]
    {
        let radius = (inertia / cage.mass).sqrt();
        let within = [parameters.pitch_diameter / MAX_MASS_RATIO.sqrt(), parameters.outer_diameter];
        warn(is_outside(radius, within), &format!("bearing/cage/{field}"), &|| {
            format!(
                "{} kg m²: with the mass of the cage this is a radius of gyration of {} mm",
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

    use crate::contract::presets_answer;
    use crate::contract::{parse_scene_request, resolve_answer};

    fn warned(scene: Value) -> Vec<String> {
        let job = parse_scene_request(json!({ "scene": scene }).to_string().as_bytes()).expect("it can be computed");
        resolve_answer(&job).unwrap().warnings.into_iter().map(|warning| warning.pointer).collect()
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

    /// Balls of a 6206 side by side stand 23.90° apart: 8 of them reach 167°, 9 reach 191°.
    #[test]
    fn balls_that_may_gather_on_one_side_are_found() {
        let of = |balls: u32| {
            let operation = json!({ "speed_rpm": 600, "radial_load_y_n": 500 });
            let bearing = json!({ "preset": "6206", "ball_count": balls });
            warned(json!({ "bearing": bearing, "operation": operation, "terms": { "cage": "off" } }))
        };
        assert!(of(9).is_empty() && of(8) == ["/scene/bearing/ball_count"], "{:?} {:?}", of(9), of(8));
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

    /// A pressure by preload points at the clearance, one by weight at the mass, one by a load at the load.
    #[test]
    fn a_pressure_warning_points_at_its_cause() {
        let tight = json!({
            "outer_diameter_mm": 80, "inner_diameter_mm": 50, "width_mm": 16, "ball_count": 14, "ball_diameter_mm": 8.73,
            "pitch_diameter_mm": 65, "inner_groove_curvature": 0.625, "outer_groove_curvature": 0.625, "radial_clearance_um": -174.6
        });
        for (field, scene) in [
            (
                "bearing/radial_clearance_um",
                json!({ "bearing": tight, "operation": { "speed_rpm": 120 }, "spindle": { "mass_kg": 0.92 } }),
            ),
            (
                "spindle/mass_kg",
                json!({ "bearing": "6210", "operation": { "speed_rpm": 3000 }, "spindle": { "mass_kg": 2600 } }),
            ),
            (
                "operation/radial_load_y_n",
                json!({ "bearing": "6210", "operation": { "speed_rpm": 3000, "radial_load_y_n": 2600.0 * 9.81 } }),
            ),
        ] {
            assert_eq!(warned(scene.clone()), [format!("/scene/{field}")], "{scene}");
        }
    }

    #[test]
    fn an_angular_contact_bearing_without_axial_load_is_found() {
        let of = |axial_load_n: f64| {
            let bearing = json!({
                "type": "angular_contact", "outer_diameter_mm": 68, "inner_diameter_mm": 40, "width_mm": 15, "ball_count": 17,
                "ball_diameter_mm": 7.938, "pitch_diameter_mm": 54, "contact_angle_deg": 15
            });
            let operation = json!({ "speed_rpm": 18_000, "radial_load_y_n": 200, "axial_load_n": axial_load_n });
            warned(json!({ "bearing": bearing, "operation": operation }))
        };
        assert_eq!((of(0.0), of(100.0)), (vec!["/scene/operation/axial_load_n".to_owned()], Vec::new()));
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
