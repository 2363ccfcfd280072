//! Error against run time of the scenes of docs/how-to/measure-error-against-time.md, by every method.
//!
//! `cargo bench --bench work_precision` runs all of `benches/scenes`, `-- a b` only the named ones. `--repetitions N` times each
//! run N times (default 5). `--plots DIR` writes `DIR/work-precision-NAME.svg`. The output is a table for each scene. The last
//! table compares the stated level error of plain runs with the true one.
//!
//! `-- models` compares models instead, from the full model to the periodic orbit, on the 18 scenes of `benches/scenes`. It
//! prints the error of model and integrator together against the time until the answer, verification included (about two
//! minutes). With `--plots DIR` it writes a diagram for each scene, `DIR/models-NUMBER.svg`.

use std::path::{Path, PathBuf};

use raceway::commands::text_tables;
use raceway::contract::{self, Metrics, Outcome, WorkPrecisionAnswer, execute};
use raceway::plots::draw;
use raceway::plots::{ErrorPanel, WorkPoint, WorkPrecisionCurve, work_precision_svg};
use raceway::simulation::input::control::Control;
use serde_json::{Value, json};

#[path = "scenes/mod.rs"]
mod scenes;

const SCENES: [&str; 5] = ["a", "b", "c-no-film", "c-no-damping", "d"];
const CONTROL: Control<'static> = Control::until(&|| false);

struct Options {
    scenes: Vec<String>,
    repetitions: u32,
    plots: Option<PathBuf>,
}

fn main() {
    if std::env::args().any(|argument| argument == "models") {
        let directory = std::env::args().skip_while(|argument| argument != "--plots").nth(1);
        models(directory.map(PathBuf::from).as_deref());
        return;
    }
    let options = options();
    for name in &options.scenes {
        println!("## Scene {name}\n");
        let answer = study(name, options.repetitions);
        println!("{}", text_tables::work_precision(&answer));
        if let Some(directory) = &options.plots {
            let file = directory.join(format!("work-precision-{name}.svg"));
            std::fs::write(&file, draw::work_precision(&answer)).expect("the plot's directory can be written to");
        }
    }
    println!("## Stated and true level error of plain runs\n");
    println!("| scene | method | rtol | stated [dB] | true [dB] | stated/true | motion | rate [1/s] |");
    println!("|---|---|---|---|---|---|---|---|");
    for name in &options.scenes {
        estimates(name);
    }
}

fn options() -> Options {
    let mut options = Options { scenes: Vec::new(), repetitions: 5, plots: None };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            // cargo passes it.
            "--bench" => {}
            "--repetitions" => {
                let count = arguments.next().and_then(|count| count.parse().ok());
                options.repetitions = count.expect("--repetitions takes a number");
            }
            "--plots" => options.plots = Some(arguments.next().expect("--plots takes a directory").into()),
            name if SCENES.contains(&name) => options.scenes.push(name.to_owned()),
            other => panic!("no scene is called {other}; there are {SCENES:?}"),
        }
    }
    if options.scenes.is_empty() {
        options.scenes = SCENES.map(str::to_owned).to_vec();
    }
    options
}

/// The accuracy job of a scene.
fn job(name: &str) -> Value {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("benches/scenes/{name}.json"));
    let text = std::fs::read_to_string(file).expect("each scene has its file");
    serde_json::from_str(&text).expect("scenes are JSON")
}

fn study(name: &str, repetitions: u32) -> Box<WorkPrecisionAnswer> {
    let request = job(name).to_string();
    let job = contract::parse_accuracy_request(request.as_bytes(), Some(repetitions)).expect("scenes are jobs");
    match execute(&job, &CONTROL) {
        Ok(Outcome::Accuracy(answer)) => answer,
        Ok(_) => unreachable!("an accuracy job has an accuracy result"),
        Err(failure) => panic!("scene {name}: {failure}"),
    }
}

/// A plain run of the scene.
fn plain(name: &str, method: &str, tolerance: f64) -> Metrics {
    let study = job(name);
    let request = json!({
        "kind": "simulation", "scene": study["scene"], "settle_s": study["settle_s"], "duration_s": 0.05,
        // The full model, because integrators are compared.
        "solver": { "method": method, "relative_tolerance": tolerance, "model_tolerance_db": 0 },
        "outputs": { "metrics": ["vibration"], "spectra": [] }
    });
    let job = contract::parse_job(request.to_string().as_bytes()).expect("scenes are jobs");
    match execute(&job, &CONTROL) {
        Ok(Outcome::Simulation(simulated)) => simulated.metrics,
        Ok(_) => unreachable!("a simulation has a simulation's result"),
        Err(failure) => panic!("scene {name}: {failure}"),
    }
}

/// Rows of the last table. The reference is a run at 1e-10. For a chaotic scene it is another sample of the same motion.
fn estimates(name: &str) {
    let levels = |metrics: &Metrics| {
        let channels = metrics.channels.as_ref().expect("vibration was asked for");
        ["spindle.y.acceleration", "spindle.z.acceleration"]
            .map(|channel| channels[channel].level_db.expect("the scenes vibrate"))
    };
    let truth = levels(&plain(name, "gear", 1e-10));
    for (method, tolerance) in
        [("auto", 1e-3), ("auto", 1e-4), ("auto", 1e-5), ("auto", 1e-6), ("radau", 1e-4), ("fine_abm", 1e-4)]
    {
        let metrics = plain(name, method, tolerance);
        let found = levels(&metrics);
        let error = (found[0] - truth[0]).abs().max((found[1] - truth[1]).abs());
        let accuracy = &metrics.accuracy;
        let stated = accuracy.level_error_db.unwrap_or(f64::NAN);
        println!(
            "| {name} | {method} | {tolerance:e} | {stated:.1e} | {error:.1e} | {:.2} | {} | {:.0} |",
            stated / error,
            accuracy.motion.map_or("unknown".into(), |motion| format!("{motion:?}").to_lowercase()),
            accuracy.divergence_rate_per_s.unwrap_or(f64::NAN)
        );
    }
}

/// Models: name, solver, and whether all metrics are requested. Levels of the spindle alone allow a smaller model.
const MODELS: [(&str, &str, bool); 9] = [
    ("full, every term, 1e-3", r#"{"rung":"full","model_tolerance_db":0,"relative_tolerance":1e-3}"#, true),
    ("full, every term, 1e-4", r#"{"rung":"full","model_tolerance_db":0,"relative_tolerance":1e-4}"#, true),
    ("full, every term, 1e-5", r#"{"rung":"full","model_tolerance_db":0,"relative_tolerance":1e-5}"#, true),
    ("full as it chooses", r#"{"rung":"full"}"#, true),
    ("full as it chooses, levels only", r#"{"rung":"full"}"#, false),
    ("planar", r#"{"rung":"planar"}"#, true),
    ("radially_condensed", r#"{"rung":"radially_condensed"}"#, true),
    ("spindle_only", r#"{"rung":"spindle_only"}"#, false),
    ("periodic", r#"{"rung":"periodic"}"#, false),
];
/// Solver of the reference.
const WHOLE: &str = r#"{"rung":"full","model_tolerance_db":0,"relative_tolerance":1e-9,"method":"gear"}"#;
const LEVELS: [&str; 4] =
    ["spindle.y.acceleration", "spindle.z.acceleration", "spindle.y.velocity", "spindle.z.velocity"];

/// Curves of the diagrams. Each of the first models is a curve over its tolerances, each other model a point.
const CURVES: [(&str, std::ops::Range<usize>); 7] = [
    ("full, every term", 0..3),
    ("full as it chooses", 3..4),
    ("the same, levels only", 4..5),
    ("planar", 5..6),
    ("radially_condensed", 6..7),
    ("spindle_only", 7..8),
    ("periodic", 8..9),
];
/// Relative tolerances of the first models. The others have none.
const TOLERANCES: [f64; 3] = [1e-3, 1e-4, 1e-5];

/// Levels of a scene by a model [dB], their stated error [dB], and the run time with verification [s]; `Err`: why the model is
/// not applicable.
fn by_model(scene: &str, solver: &str, all: bool) -> Result<([f64; 4], f64, f64), String> {
    let metrics = if all { r#"["vibration","contacts","cage"]"# } else { r#"["vibration"]"# };
    let request = format!(
        r#"{{"kind":"simulation","scene":{scene},"settle_s":0.02,"duration_s":0.1,"solver":{solver},"outputs":{{"metrics":{metrics}}}}}"#
    );
    let job = contract::parse_job(request.as_bytes()).map_err(|refusal| format!("{refusal:?}"))?;
    let begin = std::time::Instant::now();
    let metrics = match execute(&job, &CONTROL) {
        Ok(Outcome::Simulation(simulated)) => simulated.metrics,
        Ok(_) => unreachable!("a simulation has a simulation's result"),
        Err(failure) => return Err(failure.to_string()),
    };
    let took = begin.elapsed().as_secs_f64();
    let channels = metrics.channels.as_ref().expect("vibration was asked for");
    // A velocity has no level, only its root mean square.
    let level = |channel: &str| channels[channel].level_db.unwrap_or_else(|| 20.0 * channels[channel].rms.log10());
    let levels = LEVELS.map(level);
    Ok((levels, metrics.accuracy.level_error_db.unwrap_or(f64::NAN), took))
}

/// The diagram of a scene: time [s] and errors [dB] of each applicable model.
fn diagram(scene: &str, found: &[Option<(f64, [f64; 4])>]) -> String {
    let point = |index: usize| {
        let (time_s, [ay, az, vy, vz]) = found[index]?;
        let worst = |a: f64, b: f64| Some((a.abs().max(b.abs()).max(1e-12), true));
        let label = TOLERANCES.get(index).map(|tolerance| format!("{tolerance:e}"));
        Some(WorkPoint { label, time_s, errors: [worst(ay, az), worst(vy, vz)] })
    };
    let curves: Vec<_> = CURVES
        .iter()
        .map(|(name, of)| WorkPrecisionCurve {
            name,
            points: of.clone().filter_map(point).collect(),
            failures: Vec::new(),
        })
        .filter(|curve| !curve.points.is_empty())
        .collect();
    let panel = |name| ErrorPanel { name, unit: "dB", floor: None };
    let panels =
        [panel("Level of the acceleration, worst of y and z"), panel("Level of the velocity, worst of y and z")];
    work_precision_svg(
        [
            scene,
            "Error against the full dynamics at 1e-9; time with all checks, 0.1 s after 0.02 s",
            "relative tolerances",
        ],
        &curves,
        panels,
    )
}

fn models(plots: Option<&Path>) {
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let mut errors: [Vec<[f64; 4]>; MODELS.len()] = Default::default();
    let mut times: [Vec<f64>; MODELS.len()] = Default::default();
    println!("| scene | model | ms | a_y, a_z, v_y, v_z off by [dB] | stated [dB] |");
    println!("|---|---|---|---|---|");
    for (number, (speed, load, clearance, balls, mass, grade)) in scenes::SCENES.into_iter().enumerate() {
        let scene = scenes::scene(number).1;
        let (truth, _, _) = by_model(&scene, WHOLE, true).expect("the full model applies to every scene");
        let name = format!("{speed} r/min, {load} N, {clearance} µm, {balls} balls, {mass} g, G {grade}");
        let mut found = [None; MODELS.len()];
        for (index, (model, solver, all)) in MODELS.into_iter().enumerate() {
            match by_model(&scene, solver, all) {
                Ok((levels, stated, took)) => {
                    let off: [f64; 4] = std::array::from_fn(|k| levels[k] - truth[k]);
                    let [ay, az, vy, vz] = off;
                    println!(
                        "| {name} | {model} | {:.1} | {ay:.4} {az:.4} {vy:.4} {vz:.4} | {stated:.4} |",
                        1e3 * took
                    );
                    errors[index].push(off);
                    times[index].push(1e3 * took);
                    found[index] = Some((took, off));
                }
                Err(words) => println!("| {name} | {model} | – | {words} | – |"),
            }
        }
        if let Some(directory) = plots {
            let file = directory.join(format!("models-{:02}.svg", number + 1));
            std::fs::write(&file, diagram(&name, &found)).expect("the plot's directory can be written to");
        }
    }
    println!(
        "\n| model | scenes | median ms | × real time | worst a_y, a_z, v_y, v_z [dB] | median of the worst [dB] |"
    );
    println!("|---|---|---|---|---|---|");
    for (index, (model, _, _)) in MODELS.into_iter().enumerate() {
        let worst: [f64; 4] = std::array::from_fn(|k| errors[index].iter().map(|off| off[k].abs()).fold(0.0, f64::max));
        let [ay, az, vy, vz] = worst;
        let each = errors[index].iter().map(|off| off.iter().fold(0.0, |most: f64, x| most.max(x.abs()))).collect();
        let time = median(times[index].clone());
        println!(
            "| {model} | {} | {time:.1} | {:.2} | {ay:.3} {az:.3} {vy:.3} {vz:.3} | {:.4} |",
            errors[index].len(),
            120.0 / time,
            median(each)
        );
    }
}
