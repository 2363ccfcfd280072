//! Scenes at the edge of what is allowed, by every method at two tolerances: right, refused in plain words, or stopped
//! loudly; never NaN, never quietly wrong.
//!
//! `cargo bench --bench extreme_scenes` prints a table of them all; `-- scene=TEXT method=NAME budget=N` choose.
//! Each run simulates 2 ms and then keeps 3 ms, and may evaluate the equations `BUDGET` times. An answer is compared with
//! the best one of another integrator (or, where no other has one, with its own at the other tolerance): levels of the
//! accelerations of y and z, and the distance of the paths, root mean square in sizes of the entries (1 µm, 10 mm/s, …).
//! Amplification is how far a small disturbance of the start has grown at most by the end; it decides how well two
//! right answers can agree. Where only the levels are off (nearly nothing moves), the run is made again as the service
//! makes it: it must state an error of that size itself.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::structure::{Jacobian, Structure};
use raceway::numerics::ode::{IntegrationError, Method, OdeSystem};
use raceway::numerics::statistics::rms;
use raceway::simulation::channel::{Axis, Channel, Motion};
use raceway::simulation::equilibrium::static_loads;
use raceway::simulation::model::Model;
use raceway::simulation::needs::Needs;
use raceway::simulation::observe::Observer;
use raceway::simulation::run::{Control, Outputs, RunSettings, run, start_state};
use raceway::simulation::scene::Scene;
use serde_json::{Value, json};

#[path = "../tests/limits/article.rs"]
mod article;
use article::{article, changed};

/// Evaluations of the right-hand side that one run may take.
const BUDGET: u64 = 600_000;
const TOLERANCES: [f64; 2] = [1e-4, 1e-6];
/// Times at which paths are compared.
const SAMPLES: usize = 150;
/// Displacement of the start that shows the amplification, in sizes, and the tolerance of the two runs that do.
const DISPLACEMENT: f64 = 1e-3;
/// Levels below this count as silence [m/s²].
const SILENCE: f64 = 1e-3;
/// Two right paths may differ by so many times tolerance and amplification.
const ERRORS: f64 = 300.0;
/// Part of a size up to which paths that amplify are still compared.
const COMPARABLE: f64 = 1.0;
/// Levels of right answers differ by no more [dB], at the looser and the tighter tolerance; and those of chaotic ones.
const LEVEL: [f64; 2] = [0.3, 0.03];
const CHAOTIC_LEVEL: f64 = 3.0;
/// A stated error may be too small by this factor: it is that of another stretch of the run.
const STATED: f64 = 10.0;
/// Looks of the service's run, each after 256 steps, before it is stopped.
const MOST_LOOKS: u64 = 400;

/// The article's bearing with another number of balls; rings, cage, load and speed go with it.
fn balls(count: u32) -> Value {
    let scale = f64::from(count) / 7.0;
    let pitch = 13.0 * scale;
    json!({
        "bearing": {
            "ball_count": count, "pitch_diameter_mm": pitch, "outer_diameter_mm": pitch + 5.0,
            "inner_diameter_mm": (pitch - 4.5).max(0.5),
            "cage": {
                "mass_g": 0.13 * scale, "axial_inertia_kg_m2": 5.5e-9 * scale.powi(3),
                "transverse_inertia_kg_m2": 3e-9 * scale.powi(3)
            }
        },
        "operation": { "speed_rpm": 50_000.0 / scale, "radial_load_y_n": 200.0 * scale }
    })
}

/// The radial load at which the largest static contact pressure is `pascal` [N].
fn load_at(pascal: f64) -> f64 {
    let pressure = |load: f64| {
        let json = changed(article(), json!({ "operation": { "radial_load_y_n": load } }));
        let scene = scene_from_json(&json.to_string()).expect("a loaded bearing is a scene");
        let needs = Needs::of(&scene, &outputs(), None).expect("no rung is asked for");
        static_loads(&scene, &needs).map_or(f64::INFINITY, |loads| loads.max_pressure)
    };
    let (mut low, mut high) = (1.0, 1e6);
    for _ in 0..40 {
        let middle = f64::sqrt(low * high);
        if pressure(middle) < pascal { low = middle } else { high = middle }
    }
    low
}

/// What is simulated: a name, the scene, and how long it settles and is kept [s].
struct Case {
    name: String,
    scene: Value,
    settle: f64,
    duration: f64,
    /// Times the budget.
    patience: u64,
}

fn cases() -> Vec<Case> {
    let case = |name: &str, changes: Value| Case {
        name: name.into(),
        scene: changed(article(), changes),
        settle: 2e-3,
        duration: 3e-3,
        patience: 1,
    };
    let bearing = |changes: Value| json!({ "bearing": changes });
    let cage = |changes: Value| json!({ "bearing": { "cage": changes } });
    let operation = |changes: Value| json!({ "operation": changes });
    let traction = |law: Value| json!({ "lubricant": { "kind": "grease", "traction": law } });
    let weight = |kg: f64| json!({ "spindle": { "mass_kg": kg }, "gravity_m_s2": 0 });
    let curvature = |f: f64, um: f64| {
        bearing(json!({ "inner_groove_curvature": f, "outer_groove_curvature": f, "radial_clearance_um": um }))
    };
    let (four, eight) = (load_at(4e9), load_at(8e9));
    let step =
        json!([{ "at_s": 0, "rpm": 50_000 }, { "at_s": 0.003, "rpm": 50_000 }, { "at_s": 0.003_001, "rpm": 20_000 }]);
    let mut all = vec![
        case("article's case", json!({})),
        case("no load", operation(json!({ "radial_load_y_n": 0 }))),
        case("no load, no gravity", changed(operation(json!({ "radial_load_y_n": 0 })), json!({ "gravity_m_s2": 0 }))),
        case("no speed", operation(json!({ "speed_rpm": 0 }))),
        case("200 000 r/min", operation(json!({ "speed_rpm": 200_000 }))),
        case("500 000 r/min", operation(json!({ "speed_rpm": 500_000 }))),
        case(&format!("4 GPa ({four:.0} N)"), operation(json!({ "radial_load_y_n": four }))),
        case(&format!("8 GPa ({eight:.0} N)"), operation(json!({ "radial_load_y_n": eight }))),
        case("1e7 N", operation(json!({ "radial_load_y_n": 1e7 }))),
        case("clearance 0", bearing(json!({ "radial_clearance_um": 0 }))),
        case("clearance -4 µm", bearing(json!({ "radial_clearance_um": -4 }))),
        case("clearance -0.02 d", bearing(json!({ "radial_clearance_um": -55.5 }))),
        case("3 balls", balls(3)),
        case("50 balls", balls(50)),
        case("restitution 1", json!({ "damping": { "raceway": { "law": "restitution", "restitution": 1 } } })),
        case(
            "no damping at all",
            changed(
                json!({ "damping": { "raceway": { "law": "none" }, "pocket": { "law": "none" } } }),
                cage(json!({ "film": "none" })),
            ),
        ),
        case("traction at 1 mm/s", traction(json!({ "law": "four_parameter", "at_slip_m_s": 1e-3 }))),
        case("speed step in 1 µs", operation(json!({ "speed_rpm": step }))),
        case("pocket clearance 1e-3 mm", cage(json!({ "pocket_clearance_mm": 1e-3 }))),
        case("pocket clearance 1e-9 mm", cage(json!({ "pocket_clearance_mm": 1e-9 }))),
        case("spindle 1e6 balls", weight(88.0)),
        case("spindle 1e-6 balls", weight(8.8e-11)),
        case("spindle 1e6 kg", weight(1e6)),
        case("spindle 1e-300 kg", weight(1e-300)),
        case("f = 0.5", curvature(0.5, 5.0)),
        case("f = 0.5000001", curvature(0.500_000_1, 1e-6)),
        case("f = 0.501", curvature(0.501, 2.0)),
        case("f = 0.6", curvature(0.6, 5.0)),
        case(
            "viscous damping 1e9",
            json!({ "damping": { "raceway": { "law": "viscous", "viscous_n_s_per_m": 1e9 } } }),
        ),
        case("film stiffness 1e10", cage(json!({ "film": { "stiffness_n_per_m": 1e10, "damping_n_s_per_m": 3 } }))),
        case("film damping 1e5", cage(json!({ "film": { "stiffness_n_per_m": 0, "damping_n_s_per_m": 1e5 } }))),
        case("cage of 1e-6 g", cage(json!({ "mass_g": 1e-6 }))),
        case(
            "cage of 1e-6 g, inertia alike",
            cage(json!({ "mass_g": 1e-6, "axial_inertia_kg_m2": 4e-14, "transverse_inertia_kg_m2": 2e-14 })),
        ),
        case("coulomb over 1 mm/s", traction(json!({ "law": "coulomb", "regularisation_m_s": 1e-3 }))),
        case("coulomb over 10 µm/s", traction(json!({ "law": "coulomb", "regularisation_m_s": 1e-5 }))),
        case("eyring in grease", traction(json!({ "law": "eyring" }))),
        case("viscosity 100", json!({ "lubricant": { "kind": "oil", "viscosity_pa_s": 100 } })),
        case("dry, chaotic", json!({ "lubricant": "dry" })),
    ];
    for case in all.iter_mut().filter(|case| ["film stiffness 1e10", "viscosity 100"].contains(&case.name.as_str())) {
        case.patience = 4;
    }
    all.push(Case { name: "1 µs".into(), scene: article(), settle: 0.0, duration: 1e-6, patience: 1 });
    all.push(Case { name: "60 s".into(), scene: article(), settle: 0.02, duration: 60.0, patience: 1 });
    all
}

fn outputs() -> Outputs {
    Outputs { vibration: true, contacts: true, cage: true, spectra: Vec::new(), series: Vec::new() }
}

/// The model, until the budget is spent; from then on nothing is finite, and every method gives up by itself.
struct Budgeted<'a> {
    model: &'a Model,
    left: Cell<u64>,
}

impl OdeSystem for Budgeted<'_> {
    fn dimension(&self) -> usize {
        self.model.dimension()
    }
    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        match self.left.get() {
            0 => derivative.fill(f64::NAN),
            left => {
                self.left.set(left - 1);
                self.model.derivative(time, state, derivative);
            }
        }
    }
    fn structure(&self) -> Structure {
        self.model.structure()
    }
    fn jacobian(&self, time: f64, state: &[f64], rate: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        let evaluations = self.model.jacobian(time, state, rate, displacement, jacobian);
        self.left.set(self.left.get().saturating_sub(evaluations));
        evaluations
    }
}

fn settings(case: &Case, method: Method, tolerance: f64) -> RunSettings {
    RunSettings {
        method,
        rung: None,
        relative_tolerance: tolerance,
        model_tolerance_db: 0.05,
        fixed_step: None,
        settle: case.settle,
        duration: case.duration,
        outputs: outputs(),
    }
}

/// The error of the level that the service would state for this run [dB], or why there is none.
fn stated_error(case: &Case, scene: &Scene, method: Method, tolerance: f64) -> Result<f64, String> {
    let looks = Cell::new(0);
    let stop = || {
        looks.set(looks.get() + 1);
        looks.get() > MOST_LOOKS
    };
    let control = Control { stop: &stop, progress: &|_| {} };
    let result = run(scene, &settings(case, method, tolerance), &control).map_err(|error| error.to_string())?;
    let accuracy = result.summary.accuracy;
    accuracy.level_error_db.ok_or(accuracy.how)
}

struct Answer {
    /// Of the accelerations in y and z [m/s²].
    levels: [f64; 2],
    path: Vec<Vec<f64>>,
    evaluations: u64,
    wall: f64,
}

/// How a run ended.
enum End {
    Answer(Answer),
    OverBudget(String),
    Failed(String),
    /// Panicked, or gave numbers that are none.
    Broken(String),
}

fn simulate(
    case: &Case,
    scene: &Scene,
    model: &Model,
    start: &[f64],
    method: Method,
    tolerance: f64,
    budget: u64,
) -> End {
    let needs = Needs::of(scene, &outputs(), None).expect("no rung is asked for");
    let settings = settings(case, method, tolerance);
    let begin = Instant::now();
    let layout = model.mechanism().layout;
    let system = Budgeted { model, left: Cell::new(budget) };
    let mut observer = Observer::new(model, &needs, &settings);
    let end = observer.end();
    let mut integrator = method.start(&system, 0.0, start, layout.tolerances(tolerance), None);
    let kept_until = case.settle + case.duration;
    let sample = |k: usize| kept_until * (k + 1) as f64 / SAMPLES as f64;
    let mut path: Vec<Vec<f64>> = Vec::new();
    let mut state = start.to_vec();
    let mut stops: Vec<f64> = model.mechanism().speed.kinks().filter(|kink| *kink > 0.0 && *kink < end).collect();
    stops.push(end.max(kept_until));
    for stop in stops {
        while integrator.time() < stop {
            if let Err(error) = integrator.step(stop) {
                let time = integrator.time();
                if system.left.get() == 0 {
                    let total = kept_until * 1e3;
                    return End::OverBudget(format!("{budget} evaluations for {:.3} of {total} ms", time * 1e3));
                }
                let component = match error {
                    IntegrationError::StepTooSmall { component, .. }
                    | IntegrationError::NotFinite { component, .. } => layout.name(component),
                    IntegrationError::Stopped { .. } => String::new(),
                };
                return End::Failed(format!("{error} ({component})"));
            }
            observer.after(integrator.as_ref());
            while path.len() < SAMPLES && sample(path.len()) <= integrator.time() {
                integrator.interpolate(sample(path.len()), &mut state);
                path.push(state.clone());
            }
        }
        if integrator.time() < end {
            integrator.restart();
        }
    }
    let recording = observer.finish();
    let level = |axis: Axis| recording.signal(Channel::Spindle(axis, Motion::Acceleration)).map_or(f64::NAN, rms);
    let levels = [level(Axis::Y), level(Axis::Z)];
    if !levels.iter().chain(path.iter().flatten()).all(|x| x.is_finite()) {
        return End::Broken("numbers that are none".into());
    }
    End::Answer(Answer {
        levels,
        path,
        evaluations: integrator.statistics().rhs_evaluations,
        wall: begin.elapsed().as_secs_f64(),
    })
}

/// Root mean square over entries and times, and the largest of its values over times; in sizes.
fn distance(a: &Answer, b: &Answer, sizes: &[f64]) -> (f64, f64) {
    let at_each_time: Vec<f64> = a
        .path
        .iter()
        .zip(&b.path)
        .map(|(a, b)| rms(&a.iter().zip(b).zip(sizes).map(|((a, b), size)| (a - b) / size).collect::<Vec<f64>>()))
        .collect();
    (rms(&at_each_time), at_each_time.iter().copied().fold(0.0, f64::max))
}

/// Worst of y and z [dB].
fn level_difference(a: &Answer, b: &Answer) -> f64 {
    let one = |a: f64, b: f64| 20.0 * ((a + SILENCE) / (b + SILENCE)).log10().abs();
    one(a.levels[0], b.levels[0]).max(one(a.levels[1], b.levels[1]))
}

#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Verdict {
    Right,
    OverBudget,
    Failed,
    Wrong,
}

impl Verdict {
    fn words(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::OverBudget => "stopped by its cost",
            Self::Failed => "failed loudly",
            Self::Wrong => "**WRONG**",
        }
    }
}

struct Selection {
    scene: String,
    method: String,
    budget: u64,
}

fn main() {
    let mut selection = Selection { scene: String::new(), method: String::new(), budget: BUDGET };
    for argument in std::env::args().skip(1) {
        match argument.split_once('=') {
            Some(("scene", text)) => selection.scene = text.into(),
            Some(("method", name)) => selection.method = name.into(),
            Some(("budget", count)) => selection.budget = count.parse().unwrap_or(BUDGET),
            _ => {}
        }
    }
    let begin = Instant::now();
    println!("| scene | method | at {:e} | at {:e} | verdict |", TOLERANCES[0], TOLERANCES[1]);
    println!("|---|---|---|---|---|");
    let mut counts: Vec<(Verdict, u32)> = Vec::new();
    let mut refused = 0;
    for case in cases().iter().filter(|case| case.name.contains(&selection.scene)) {
        match rows(case, &selection) {
            Ok(verdicts) => {
                for verdict in verdicts {
                    match counts.iter_mut().find(|(of, _)| *of == verdict) {
                        Some((_, count)) => *count += 1,
                        None => counts.push((verdict, 1)),
                    }
                }
            }
            Err(words) => {
                refused += 1;
                println!("| {} | all | {words} | | refused |", case.name);
            }
        }
    }
    println!();
    let counts: Vec<String> = counts.iter().map(|(verdict, count)| format!("{}: {count}", verdict.words())).collect();
    println!("{}; scenes refused: {refused}; {:.0} s", counts.join("; "), begin.elapsed().as_secs_f64());
}

/// Prints the rows of a scene; `Err`: its refusal.
fn rows(case: &Case, selection: &Selection) -> Result<Vec<Verdict>, String> {
    let scene = scene_from_json(&case.scene.to_string()).map_err(|refusal| format!("{refusal:?}"))?;
    let needs = Needs::of(&scene, &outputs(), None).map_err(|unmet| unmet.to_string())?;
    let model = Model::new(&scene, &needs);
    let start = start_state(&model).map_err(|error| error.to_string())?;
    let sizes = model.mechanism().layout.sizes();
    let guarded = |start: &[f64], method: Method, tolerance: f64| {
        let run = || simulate(case, &scene, &model, start, method, tolerance, case.patience * selection.budget);
        catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| End::Broken("panicked".into()))
    };
    let methods: Vec<Method> = Method::NAMED.into_iter().chain([Method::Auto]).collect();
    let mut ends: Vec<(Method, [End; 2])> = Vec::new();
    for method in methods {
        ends.push((method, TOLERANCES.map(|tolerance| guarded(&start, method, tolerance))));
    }
    // Displaced in a way that no symmetry cancels.
    let displaced: Vec<f64> =
        (0..start.len()).map(|i| start[i] + if i % 3 == 0 { -1.0 } else { 1.0 } * DISPLACEMENT * sizes[i]).collect();
    let mut amplification = None;
    for (method, which, both) in
        [1, 0].into_iter().flat_map(|which| ends.iter().map(move |(m, both)| (*m, which, both)))
    {
        let End::Answer(straight) = &both[which] else { continue };
        if let End::Answer(displaced) = guarded(&displaced, method, TOLERANCES[which]) {
            amplification = Some((distance(straight, &displaced, &sizes).1 / DISPLACEMENT).max(1.0));
            break;
        }
    }
    let mut verdicts = Vec::new();
    println!(
        "| **{}** | | {} states, amplification {} | | |",
        case.name,
        start.len(),
        amplification.map_or("unknown".into(), |a| format!("{a:.1}"))
    );
    for (index, (method, both)) in ends.iter().enumerate() {
        if !method.name().contains(&selection.method) {
            continue;
        }
        let mut worst = Verdict::Right;
        let cells: Vec<String> = both
            .iter()
            .enumerate()
            .map(|(which, end)| {
                let (verdict, words) = match end {
                    End::Answer(answer) => {
                        let stated = || stated_error(case, &scene, *method, TOLERANCES[which]);
                        judge(&ends, index, which, answer, amplification.unwrap_or(1.0), &sizes, stated)
                    }
                    End::OverBudget(words) => (Verdict::OverBudget, words.clone()),
                    End::Failed(words) => (Verdict::Failed, words.clone()),
                    End::Broken(words) => (Verdict::Wrong, words.clone()),
                };
                if verdict > worst {
                    worst = verdict;
                }
                words
            })
            .collect();
        println!("| {} | {} | {} | {} | {} |", case.name, method.name(), cells[0], cells[1], worst.words());
        verdicts.push(worst);
    }
    Ok(verdicts)
}

/// The answer against the best other one.
fn judge(
    ends: &[(Method, [End; 2])],
    index: usize,
    which: usize,
    answer: &Answer,
    amplification: f64,
    sizes: &[f64],
    stated: impl Fn() -> Result<f64, String>,
) -> (Verdict, String) {
    // `auto` may have run what stands beside it: the same bits show nothing.
    let other = |method: usize, which: usize| match &ends[method].1[which] {
        End::Answer(other) if method != index && other.path != answer.path => Some((ends[method].0, which, other)),
        _ => None,
    };
    const RADAU: usize = 3;
    let of_another = [RADAU, 0, 2, 1, 4].into_iter().find_map(|method| other(method, 1));
    let at_the_other = match &ends[index].1[1 - which] {
        End::Answer(other) => Some((ends[index].0, 1 - which, other)),
        _ => None,
    };
    let looser = || [RADAU, 0, 2, 1, 4].into_iter().find_map(|method| other(method, 0));
    let work = format!("{} evaluations, {:.2} s", answer.evaluations, answer.wall);
    let Some((method, at, reference)) = of_another.or(at_the_other).or_else(looser) else {
        return (Verdict::Failed, format!("nothing to compare with; {work}"));
    };
    let (level, (path, most)) = (level_difference(answer, reference), distance(answer, reference, sizes));
    let tolerance = TOLERANCES[which].max(TOLERANCES[at]);
    let allowed = ERRORS * tolerance * amplification;
    let chaotic = allowed > COMPARABLE;
    let right_path = chaotic || path <= allowed;
    let right_level = level <= LEVEL[usize::from(tolerance <= TOLERANCES[1])] + CHAOTIC_LEVEL * allowed.min(COMPARABLE);
    let (said, right) = if right_path && !right_level {
        match stated() {
            Ok(error) => (format!(", states {error:.1e} dB"), error * STATED >= level),
            Err(words) => return (Verdict::OverBudget, format!("{level:.1e} dB, and as a whole run: {words}; {work}")),
        }
    } else {
        (String::new(), right_path && right_level)
    };
    let words = format!(
        "{level:.1e} dB{said}, {path:.1e} (≤ {most:.1e}) from {} at {:e}{}; {work}",
        method.name(),
        TOLERANCES[at],
        if chaotic { ", chaotic: level only" } else { "" },
    );
    (if right { Verdict::Right } else { Verdict::Wrong }, words)
}
