//! Scenes drawn at random, on the rung that is chosen by itself, beside the full dynamics: is any quietly wrong?
//!
//! `cargo bench --bench drawn_scenes [-- SEED COUNT [axial] [rattling] [crowns]]` draws catalogue bearings and variants of the article's (clearance, balls,
//! groove), speeds, loads, spindles and balance grades, and runs each as a plain job with all metrics, with vibration only, with
//! vibration only at 0.2 dB, and on the rung `full`, whose method is chosen then; `axial`: each with an axial load as well; `rattling`: with cages without film or damping as well, lighter loads and more of the contacts' restitution; `crowns`: with heavier or lighter crown cages, nearer to their balls or further off. A result is quietly wrong where a level of a_y or a_z, or, where the motion is not chaotic, largest load, pocket load, slip, cage speed or the
//! cage's orbit is off by more than `FACTOR` times what it and the full dynamics state themselves, and nothing warns of it. Two scenes at a time; the same seed gives the same lines.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use raceway::contract::{Metrics, Outcome, execute, parse_job};
use raceway::simulation::input::control::Control;
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};
use serde_json::{Value, json};

const SCENES: usize = 100;
const FACTOR: f64 = 3.0;
/// Differences of levels that nobody hears [dB], and shares of single numbers that nobody minds.
const INAUDIBLE: f64 = 2e-3;
const MINUTE: f64 = 1e-2;
/// Single numbers and the field that states the error of each.
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

/// What is asked for: name, metrics, tolerance of the model [dB], rung.
const CASES: [(&str, &[&str], f64, Option<&str>); 4] = [
    ("all metrics", &["vibration", "contacts", "cage"], 0.05, None),
    ("vibration only", &["vibration"], 0.05, None),
    ("vibration only, 0.2 dB", &["vibration"], 0.2, None),
    ("all metrics, full", &["vibration", "contacts", "cage"], 0.05, Some("full")),
];

struct Draw(SplitMix64);

impl Draw {
    /// In 0 … 1.
    fn share(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn chance(&mut self, share: f64) -> bool {
        self.share() < share
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[(self.share() * all.len() as f64) as usize]
    }

    /// Three digits, evenly between two ends, or between their logarithms.
    fn between(&mut self, from: f64, to: f64) -> f64 {
        three_digits(from + (to - from) * self.share())
    }

    fn between_decades(&mut self, from: f64, to: f64) -> f64 {
        three_digits(from * (to / from).powf(self.share()))
    }

    fn scene(&mut self) -> Value {
        let preset = self.one_of(&["article-integrated", "article-integrated", "article-deep-groove", "608", "6205"]);
        let mut bearing = json!({ "preset": preset });
        if self.chance(0.6) {
            bearing["radial_clearance_um"] = self.between_decades(1.0, 40.0).into();
        }
        if preset.starts_with("article") && self.chance(0.5) {
            bearing["ball_count"] = self.one_of(&[6, 7, 8, 9]).into();
        }
        if self.chance(0.3) {
            bearing["inner_groove_curvature"] = self.between(0.51, 0.55).into();
        }
        let mut operation = json!({ "speed_rpm": self.between_decades(3e3, 6e4), "radial_load_y_n": self.between_decades(20.0, 600.0) });
        if self.chance(0.3) {
            operation["radial_load_z_n"] = self.between(-200.0, 200.0).into();
        }
        let mut spindle = json!({});
        if self.chance(0.5) {
            spindle["mass_kg"] = self.between_decades(0.02, 2.0).into();
        }
        if self.chance(0.4) {
            spindle["balance_grade"] = self.one_of(&[0.4, 1.0, 2.5, 6.3, 16.0, 40.0]).into();
        }
        json!({ "bearing": bearing, "operation": operation, "spindle": spindle })
    }

    /// Another film in the pockets, a lighter load, contacts that bounce otherwise: each now and then.
    fn rattle(&mut self, scene: &mut Value) {
        let stiffness = self.between_decades(1e3, 1e6);
        let film = match self.one_of(&[0, 1, 2, 3]) {
            0 => json!("wedge"),
            1 => json!("none"),
            2 => json!({ "stiffness_n_per_m": stiffness, "damping_n_s_per_m": 0.0 }),
            _ => json!({ "stiffness_n_per_m": stiffness, "damping_n_s_per_m": self.between_decades(0.05, 5.0) }),
        };
        scene["bearing"]["cage"] = json!({ "film": film });
        if self.chance(0.5) {
            scene["operation"]["radial_load_y_n"] = self.between_decades(2.0, 50.0).into();
        }
        if self.chance(0.3) {
            let restitution = self.between(0.5, 0.99);
            scene["damping"] = json!({ "raceway": { "law": "restitution", "restitution": restitution } });
        }
    }

    /// Another crown cage.
    fn crown(&mut self, scene: &mut Value) {
        scene["bearing"]["cage"] =
            json!({ "mass_g": self.between_decades(0.1, 10.0), "offset_mm": self.between_decades(0.1, 4.0) });
    }
}

fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().expect("a number")
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

/// What a case of a scene shows.
struct Judged {
    /// ModelLevel and method.
    by: String,
    /// By how much its level is off, and what is stated [dB].
    off: f64,
    stated: f64,
    /// What is quietly wrong.
    wrong: Option<&'static str>,
}

/// What a scene shows, case by case.
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
            let warned = found.accuracy.warning.is_some() || full.accuracy.warning.is_some();
            let wrong = off > FACTOR * (stated(&found) + stated(&full)) + INAUDIBLE;
            let misled = misled(&found, &full);
            Ok(Judged {
                by: format!("{} by {}", found.solver.rung, found.solver.method),
                off,
                stated: stated(&found),
                wrong: if wrong { Some("level") } else { misled }.filter(|_| !warned),
            })
        })
        .collect()
}

/// A single number that is further off than both say; `None`: there is none, or the motion is chaotic, of which both are samples.
fn misled(found: &Metrics, full: &Metrics) -> Option<&'static str> {
    let [found, full] = [found, full].map(|metrics| serde_json::to_value(metrics).expect("metrics are JSON"));
    if [&found, &full].into_iter().any(|metrics| metrics["accuracy"]["motion"] == "diverging") {
        return None;
    }
    let is_off = |(pointer, error): &(&str, &str)| {
        let [a, b] = [&found, &full].map(|metrics| metrics.pointer(pointer).and_then(Value::as_f64));
        let Some((a, b)) = a.zip(b) else { return false };
        let stated =
            [&found, &full].map(|metrics| metrics["accuracy"][error].as_f64().unwrap_or(0.0)).iter().sum::<f64>();
        (a - b).abs() > (FACTOR * stated + MINUTE) * a.abs().max(b.abs())
    };
    NUMBERS.iter().find(|number| is_off(number)).map(|(pointer, _)| *pointer)
}

fn main() {
    raceway::commands::allocator::keep_memory_for_next_run();
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|argument| argument.parse().ok()).collect();
    let (seed, count) = (numbers.first().copied().unwrap_or(1), numbers.get(1).copied().unwrap_or(SCENES));
    let mut draw = Draw(SplitMix64::seed_from_u64(seed as u64));
    let mut scenes: Vec<Value> = (0..count).map(|_| draw.scene()).collect();
    if std::env::args().any(|argument| argument == "axial") {
        for scene in &mut scenes {
            scene["operation"]["axial_load_n"] = draw.between_decades(5.0, 200.0).into();
        }
    }
    if std::env::args().any(|argument| argument == "rattling") {
        scenes.iter_mut().for_each(|scene| draw.rattle(scene));
    }
    if std::env::args().any(|argument| argument == "crowns") {
        scenes.iter_mut().for_each(|scene| draw.crown(scene));
    }
    let next = AtomicUsize::new(0);
    let found = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(scene) = scenes.get(number) else { break };
                    let judged = judged(scene);
                    found.lock().expect("whole").push((number, judged));
                }
            });
        }
    });
    let mut found = found.into_inner().expect("whole");
    found.sort_by_key(|(number, _)| *number);
    let mut rungs = CASES.map(|_| std::collections::BTreeMap::<String, (usize, usize, usize, f64)>::new());
    for (number, judged) in found {
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
        "\n| asked for | rung and method | scenes | off by more than the tolerance | quietly wrong | largest error dB |\n|---|---|---|---|---|---|"
    );
    for ((name, ..), rungs) in CASES.iter().zip(rungs) {
        for (rung, (count, beyond, wrong, off)) in rungs {
            println!("| {name} | {rung} | {count} | {beyond} | {wrong} | {off:.3} |");
        }
    }
}
