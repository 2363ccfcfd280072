//! Is a result of a randomly drawn scene off by more than it states, without a warning?
//!
//! Drawn are bearings of the catalogue and variants of the article's (clearance, balls, groove), speeds, loads, spindles and
//! balance grades. Each scene runs as a plain job with all metrics, with vibration only, with vibration only at 0.2 dB, and
//! on `full`, where the program chooses the method. The reference is `full` at a relative tolerance of 1e-6.
//!
//! | option | adds |
//! |---|---|
//! | `axial` | an axial load |
//! | `rattling` | cages without film or damping, lighter loads, other restitution of the contacts |
//! | `crowns` | crown cages of other mass and other axial offset |
//! | `waves` | waviness of one raceway or both: drawn waves, and in some scenes single ones of low order |
//!
//! A result is wrong without a warning where a level of a_y or a_z deviates by more than `FACTOR` times the sum of both
//! stated errors. Where the motion is not chaotic, the same holds for largest load, pocket load, slip, cage speed and cage
//! orbit. Two scenes run at a time.

use std::collections::BTreeMap;

use raceway::contract::{Metrics, Outcome, execute, parse_job};
use raceway::simulation::input::control::Control;
use serde_json::{Value, json};

use crate::draw::{Draw, has, seed_and_count};
use crate::threads::in_parallel;
use crate::warns;

const SCENES: usize = 100;
const FACTOR: f64 = 3.0;
/// Deviation of a level that always counts as right [dB].
const INAUDIBLE: f64 = 2e-3;
/// Relative deviation of a single number that always counts as right [-].
const NEGLIGIBLE: f64 = 1e-2;
/// Single numbers, each with the field that states its error.
const NUMBERS: [(&str, &str); 7] = [
    ("/contacts/inner/max_load_n", "max_load_error"),
    ("/contacts/outer/max_load_n", "max_load_error"),
    ("/contacts/pocket/max_load_n", "max_pocket_load_error"),
    ("/contacts/inner/max_slip_m_s", "max_slip_error"),
    ("/contacts/outer/max_slip_m_s", "max_slip_error"),
    ("/kinematics/cage_speed_hz", "cage_speed_error"),
    ("/cage/orbit_radius_um", "orbit_radius_error"),
];
const CHANNELS: [&str; 2] = ["spindle.y.acceleration", "spindle.z.acceleration"];

/// Requests: name, metrics, model tolerance [dB], model level.
const CASES: [(&str, &[&str], f64, Option<&str>); 4] = [
    ("all metrics", &["vibration", "contacts", "cage"], 0.05, None),
    ("vibration only", &["vibration"], 0.05, None),
    ("vibration only, 0.2 dB", &["vibration"], 0.2, None),
    ("all metrics, full", &["vibration", "contacts", "cage"], 0.05, Some("full")),
];

fn drawn_scene(draw: &mut Draw) -> Value {
    let preset = draw.one_of(&["article-integrated", "article-integrated", "article-deep-groove", "608", "6205"]);
    let mut bearing = json!({ "preset": preset });
    if draw.chance(0.6) {
        bearing["radial_clearance_um"] = draw.between_decades(1.0, 40.0).into();
    }
    if preset.starts_with("article") && draw.chance(0.5) {
        bearing["ball_count"] = draw.one_of(&[6, 7, 8, 9]).into();
    }
    if draw.chance(0.3) {
        bearing["inner_groove_curvature"] = draw.between(0.51, 0.55).into();
    }
    let mut operation =
        json!({ "speed_rpm": draw.between_decades(3e3, 6e4), "radial_load_y_n": draw.between_decades(20.0, 600.0) });
    if draw.chance(0.3) {
        operation["radial_load_z_n"] = draw.between(-200.0, 200.0).into();
    }
    let mut spindle = json!({});
    if draw.chance(0.5) {
        spindle["mass_kg"] = draw.between_decades(0.02, 2.0).into();
    }
    if draw.chance(0.4) {
        spindle["balance_grade"] = draw.one_of(&[0.4, 1.0, 2.5, 6.3, 16.0, 40.0]).into();
    }
    json!({ "bearing": bearing, "operation": operation, "spindle": spindle })
}

/// Changes film, damping and stiffness of the pockets, and in some scenes the load and the restitution.
fn rattle(draw: &mut Draw, scene: &mut Value) {
    let stiffness = draw.between_decades(1e3, 1e6);
    let film = match draw.one_of(&[0, 1, 2, 3]) {
        0 => json!("wedge"),
        1 => json!("none"),
        2 => json!({ "stiffness_n_per_m": stiffness, "damping_n_s_per_m": 0.0 }),
        _ => json!({ "stiffness_n_per_m": stiffness, "damping_n_s_per_m": draw.between_decades(0.05, 5.0) }),
    };
    scene["bearing"]["cage"] = json!({ "film": film });
    if draw.chance(0.5) {
        scene["operation"]["radial_load_y_n"] = draw.between_decades(2.0, 50.0).into();
    }
    if draw.chance(0.3) {
        let restitution = draw.between(0.5, 0.99);
        scene["damping"] = json!({ "raceway": { "law": "restitution", "restitution": restitution } });
    }
}

/// Changes mass and axial offset of the crown cage.
fn crown(draw: &mut Draw, scene: &mut Value) {
    scene["bearing"]["cage"] =
        json!({ "mass_g": draw.between_decades(0.1, 10.0), "offset_mm": draw.between_decades(0.1, 4.0) });
}

/// Adds waves to one raceway or both.
fn wave(draw: &mut Draw, scene: &mut Value) {
    let rings: &[&str] = draw.one_of(&[&["inner"], &["outer"], &["inner", "outer"], &["inner", "outer"]]);
    for ring in rings {
        let mut surface = json!({ "random_waviness": {
            "amplitude_nm": draw.between_decades(1.0, 50.0),
            "at_order": 10,
            "exponent": draw.between(0.8, 1.6),
        } });
        if draw.chance(0.5) {
            surface["random_waviness"]["to_order"] = draw.one_of(&[16, 64, 256]).into();
        }
        if draw.chance(0.3) {
            let order = draw.one_of(&[1, 2, 3, 5]);
            surface["waviness"] = json!([{ "order": order, "amplitude_nm": draw.between_decades(50.0, 1000.0) }]);
        }
        scene["surfaces"][ring] = surface;
    }
}

fn metrics(scene: &Value, solver: &Value, asked: &[&str]) -> Result<Metrics, String> {
    let job = json!({
        "kind": "simulation", "scene": scene, "solver": solver, "settle_s": 0.03, "duration_s": 0.1,
        "outputs": { "metrics": asked },
    });
    let job = parse_job(job.to_string().as_bytes()).map_err(|refusal| refusal.to_string())?;
    match execute(&job, &Control::until(&|| false)) {
        Ok(Outcome::Simulation(simulated)) => Ok(simulated.metrics),
        Ok(_) => Err("no simulation".into()),
        Err(failure) => Err(format!("{failure:?}")),
    }
}

/// One request of a scene beside the reference.
struct Judged {
    /// Model level and method.
    by: String,
    /// Deviation of the level [dB].
    off: f64,
    /// Stated error of the level [dB].
    stated: f64,
    /// What deviates by more than stated, without a warning.
    wrong: Option<&'static str>,
}

/// All requests of a scene, each beside the reference.
fn judged(scene: &Value) -> Result<Vec<Judged>, String> {
    let full = metrics(scene, &json!({ "rung": "full", "relative_tolerance": 1e-6 }), CASES[0].1)?;
    let level = |metrics: &Metrics, channel: &str| -> Option<f64> { metrics.channels.as_ref()?.get(channel)?.level_db };
    CASES
        .iter()
        .map(|(_, asked, tolerance, rung)| {
            let mut solver = json!({ "model_tolerance_db": tolerance });
            if let Some(rung) = rung {
                solver["rung"] = (*rung).into();
            }
            let found = metrics(scene, &solver, asked)?;
            let off = CHANNELS
                .iter()
                .filter_map(|channel| Some((level(&found, channel)? - level(&full, channel)?).abs()))
                .fold(0.0, f64::max);
            let stated = |metrics: &Metrics| metrics.accuracy.level_error_db.unwrap_or(0.0);
            let warned = warns(&found) || warns(&full);
            let wrong = off > FACTOR * (stated(&found) + stated(&full)) + INAUDIBLE;
            let misstated = misstated(&found, &full);
            Ok(Judged {
                by: format!("{} by {}", found.solver.rung, found.solver.method),
                off,
                stated: stated(&found),
                wrong: if wrong { Some("level") } else { misstated }.filter(|_| !warned),
            })
        })
        .collect()
}

/// The first single number that deviates by more than both results state. `None` also for chaotic motion, where both are samples.
fn misstated(found: &Metrics, full: &Metrics) -> Option<&'static str> {
    let [found, full] = [found, full].map(|metrics| serde_json::to_value(metrics).expect("metrics are JSON"));
    if [&found, &full].into_iter().any(|metrics| metrics["accuracy"]["motion"] == "diverging") {
        return None;
    }
    let is_off = |(pointer, error): &(&str, &str)| {
        let [a, b] = [&found, &full].map(|metrics| metrics.pointer(pointer).and_then(Value::as_f64));
        let Some((a, b)) = a.zip(b) else { return false };
        let stated =
            [&found, &full].map(|metrics| metrics["accuracy"][error].as_f64().unwrap_or(0.0)).iter().sum::<f64>();
        (a - b).abs() > (FACTOR * stated + NEGLIGIBLE) * a.abs().max(b.abs())
    };
    NUMBERS.iter().find(|number| is_off(number)).map(|(pointer, _)| *pointer)
}

pub fn run(words: &[String]) {
    raceway::commands::allocator::keep_memory_for_next_run();
    let (seed, count) = seed_and_count(words, SCENES);
    let mut draw = Draw::new(seed);
    let mut scenes: Vec<Value> = (0..count).map(|_| drawn_scene(&mut draw)).collect();
    if has(words, "axial") {
        for scene in &mut scenes {
            scene["operation"]["axial_load_n"] = draw.between_decades(5.0, 200.0).into();
        }
    }
    if has(words, "rattling") {
        scenes.iter_mut().for_each(|scene| rattle(&mut draw, scene));
    }
    if has(words, "crowns") {
        scenes.iter_mut().for_each(|scene| crown(&mut draw, scene));
    }
    if has(words, "waves") {
        scenes.iter_mut().for_each(|scene| wave(&mut draw, scene));
    }
    let found = in_parallel(2, scenes.len(), |number| judged(&scenes[number]));
    let mut rungs = CASES.map(|_| BTreeMap::<String, (usize, usize, usize, f64)>::new());
    for (number, judged) in found.into_iter().enumerate() {
        match judged {
            Err(fault) => println!("{fault}: {}", scenes[number]),
            Ok(cases) => {
                for (case, Judged { by, off, stated, wrong }) in cases.into_iter().enumerate() {
                    if let Some(what) = wrong {
                        println!(
                            "{}, {by}: {what}; level {off:.4} dB off, {stated:.4} stated: {}",
                            CASES[case].0, scenes[number]
                        );
                    }
                    let of = rungs[case].entry(by).or_default();
                    let beyond = off > CASES[case].2;
                    *of = (of.0 + 1, of.1 + usize::from(beyond), of.2 + usize::from(wrong.is_some()), off.max(of.3));
                }
            }
        }
    }
    println!(
        "\n| request | model level and method | scenes | off by more than the tolerance | off by more than stated, without a warning | largest error dB |\n|---|---|---|---|---|---|"
    );
    for ((name, ..), rungs) in CASES.iter().zip(rungs) {
        for (rung, (count, beyond, wrong, off)) in rungs {
            println!("| {name} | {rung} | {count} | {beyond} | {wrong} | {off:.3} |");
        }
    }
}
