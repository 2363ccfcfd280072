//! Scenes at the edge of what is allowed, by every method at two tolerances: right, refused in plain words, or stopped
//! loudly; never NaN, never quietly wrong.
//!
//! `cargo bench --bench extreme_scenes` prints a table of them all; `-- scene=TEXT method=NAME budget=N` choose.
//! Each cell is a whole run as the service makes it, its own judgement of its accuracy included: it simulates 2 ms and keeps
//! 6 ms. It is compared with the run of another integrator at the tighter tolerance (where no other has finished, with its
//! own at the other tolerance). Levels, and where the motion is not chaotic the largest contact load and the cage speed, are
//! right where they differ by no more than `FACTOR` times what both runs state themselves. A result that says of itself
//! that it is not resolved counts as such.
//! Work is bounded by counts and not by a clock: the table is the same on every machine.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::Method;
use raceway::simulation::error::comparison::FAINT;
use raceway::simulation::error::report::MotionKind;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::failure::SimulationError;
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::run;
use serde_json::Value;

#[path = "../tests/limits/article.rs"]
mod article;
use article::{article, changed};

/// Looks of a run, each after some 1500 evaluations, before it is stopped; its judgement of its accuracy included.
const BUDGET: u64 = 1_000;
const TOLERANCES: [f64; 2] = [1e-4, 1e-6];
/// A stated error may be too small by this factor.
const FACTOR: f64 = 3.0;
/// Levels below this count as silence [m/s²].
const SILENCE: f64 = 1e-6;
/// Differences of levels that nobody hears [dB].
const INAUDIBLE: f64 = 1e-3;
/// Differences of largest load and cage speed that nobody asks for [-].
const UNASKED: f64 = 1e-4;
/// Load [N] and cage speed [Hz] that count as none.
const LEAST_QUANTITIES: [f64; 2] = [0.1, 1.0];

/// What is simulated: a name, the scene, and how long it settles and is kept [s].
struct Case {
    name: String,
    scene: Value,
    settle: f64,
    duration: f64,
    /// Times the budget.
    patience: u64,
}

/// What `scenes/extreme.json` lists, as changes of the article's case.
fn cases() -> Vec<Case> {
    let listed: Vec<Value> = serde_json::from_str(include_str!("scenes/extreme.json")).expect("a list");
    let case = |listed: Value| Case {
        name: listed["name"].as_str().expect("a name").into(),
        scene: changed(article(), listed["changes"].clone()),
        settle: listed["settle_s"].as_f64().expect("a time"),
        duration: listed["duration_s"].as_f64().expect("a time"),
        patience: listed["patience"].as_u64().unwrap_or(1),
    };
    listed.into_iter().map(case).collect()
}

fn outputs() -> Outputs {
    Outputs { vibration: true, contacts: true, cage: true, spectra: Vec::new(), series: Vec::new() }
}

fn settings(case: &Case, method: Method, relative_tolerance: f64) -> RunSettings {
    RunSettings {
        method,
        rung: None,
        relative_tolerance,
        // Integrators are on trial, not reduced models.
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: case.settle,
        duration: case.duration,
        outputs: outputs(),
    }
}

/// What a user reads of a finished run.
struct Answer {
    /// Root mean square of the accelerations in y and z [m/s²].
    levels: [f64; 2],
    /// [dB]
    stated: f64,
    chaotic: bool,
    warned: bool,
    /// It could be judged: what could not confirms nothing.
    judged: bool,
    /// Largest load of the inner contacts [N], cage speed [Hz].
    quantities: [f64; 2],
    /// As shares of them [-].
    stated_quantities: [f64; 2],
    /// What ran.
    ran: &'static str,
    evaluations: u64,
}

/// How a run ended.
enum End {
    Answer(Answer),
    OverBudget(String),
    Failed(String),
    /// Panicked, or gave numbers that are none.
    Broken(String),
}

fn simulate(case: &Case, scene: &Scene, method: Method, tolerance: f64, budget: u64) -> End {
    let looks = Cell::new(0);
    let stop = || {
        looks.set(looks.get() + 1);
        looks.get() > budget
    };
    let control = Control::until(&stop);
    let result = catch_unwind(AssertUnwindSafe(|| run(scene, &settings(case, method, tolerance), &control)));
    match result {
        Err(_) => End::Broken("panicked".into()),
        Ok(Err(SimulationError::Stopped { time })) => {
            End::OverBudget(format!("stopped by its cost at {:.3} ms", 1e3 * time))
        }
        Ok(Err(error)) => End::Failed(error.to_string()),
        Ok(Ok(result)) => answer(&result).map_or_else(|| End::Broken("numbers that are none".into()), End::Answer),
    }
}

/// `None`: not all numbers are finite.
fn answer(result: &RunResult) -> Option<Answer> {
    let summary = &result.summary;
    let level = |axis: Axis| {
        let channel = Channel::Spindle(axis, Motion::Acceleration);
        summary.channels.iter().find(|(of, _)| *of == channel).map_or(0.0, |(_, metrics)| metrics.rms)
    };
    let answer = Answer {
        levels: [level(Axis::Y), level(Axis::Z)],
        stated: summary.accuracy.level_error_db().unwrap_or(0.0),
        chaotic: summary.accuracy.motion == Some(MotionKind::Diverging),
        warned: summary.accuracy.warning.is_some(),
        judged: summary.accuracy.level_error_db().is_some() || summary.accuracy.warning.is_none(),
        quantities: [
            summary.contacts.as_ref().map_or(0.0, |contacts| contacts.raceway.inner.max_load),
            summary.cage.as_ref().map_or(0.0, |cage| cage.speed),
        ],
        stated_quantities: summary.accuracy.quantity_errors.map_or([0.0; 2], |e| [e.max_load, e.cage_speed]),
        ran: summary.solver.method,
        evaluations: summary.solver.statistics.rhs_evaluations,
    };
    let finite = answer.levels.iter().chain(&answer.quantities).chain([&answer.stated]).all(|x| x.is_finite());
    finite.then_some(answer)
}

/// Worst of y and z, without one that is negligible [dB].
fn level_difference(a: &Answer, b: &Answer) -> f64 {
    let strongest = a.levels.iter().chain(&b.levels).copied().fold(SILENCE, f64::max);
    let floor = strongest * 10_f64.powf(-FAINT / 20.0);
    let one = |a: f64, b: f64| 20.0 * (a.max(floor) / b.max(floor)).log10().abs();
    one(a.levels[0], b.levels[0]).max(one(a.levels[1], b.levels[1]))
}

/// Of load and cage speed, relative to the other answer, or to `LEAST_QUANTITIES` if that is more.
fn quantity_differences(a: &Answer, b: &Answer) -> [f64; 2] {
    std::array::from_fn(|i| {
        let (a, b) = (a.quantities[i], b.quantities[i]);
        (a - b).abs() / a.abs().max(b.abs()).max(LEAST_QUANTITIES[i])
    })
}

#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Verdict {
    Right,
    Warned,
    OverBudget,
    Unconfirmed,
    Failed,
    Wrong,
}

impl Verdict {
    fn words(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Warned => "warns of itself",
            Self::OverBudget => "stopped by its cost",
            Self::Unconfirmed => "not confirmed",
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

/// All methods at both tolerances, on as many threads as there are processors.
fn ends(case: &Case, scene: &Scene, methods: &[Method], budget: u64) -> Vec<[End; 2]> {
    let next = AtomicUsize::new(0);
    let count = TOLERANCES.len() * methods.len();
    let work = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return done;
            }
            done.push((index, simulate(case, scene, methods[index / 2], TOLERANCES[index % 2], budget)));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let mut all: Vec<(usize, End)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("runs catch their panics")).collect()
    });
    all.sort_by_key(|(index, _)| *index);
    let mut all = all.into_iter().map(|(_, end)| end);
    std::iter::from_fn(|| Some([all.next()?, all.next()?])).collect()
}

/// Prints the rows of a scene; `Err`: its refusal.
fn rows(case: &Case, selection: &Selection) -> Result<Vec<Verdict>, String> {
    let scene = scene_from_json(&case.scene.to_string()).map_err(|refusal| format!("{refusal:?}"))?;
    let methods: Vec<Method> = Method::NAMED.into_iter().chain([Method::Auto]).collect();
    let ends = ends(case, &scene, &methods, case.patience * selection.budget);
    let mut verdicts = Vec::new();
    for (index, both) in ends.iter().enumerate() {
        if !methods[index].name().contains(&selection.method) {
            continue;
        }
        let cells: Vec<(Verdict, String)> = (0..2)
            .map(|which| match &both[which] {
                End::Answer(answer) => judge(&ends, &methods, index, which, answer),
                End::OverBudget(words) => (Verdict::OverBudget, words.clone()),
                End::Failed(words) => (Verdict::Failed, words.clone()),
                End::Broken(words) => (Verdict::Wrong, words.clone()),
            })
            .collect();
        let worst = if cells[0].0 > cells[1].0 { cells[0].0 } else { cells[1].0 };
        println!("| {} | {} | {} | {} | {} |", case.name, methods[index].name(), cells[0].1, cells[1].1, worst.words());
        verdicts.push(worst);
    }
    Ok(verdicts)
}

/// The answer against the best other one.
fn judge(ends: &[[End; 2]], methods: &[Method], index: usize, which: usize, answer: &Answer) -> (Verdict, String) {
    const RADAU: usize = 3;
    let found = |method: usize, at: usize| match &ends[method][at] {
        End::Answer(other) if other.judged => Some((method, at, other)),
        _ => None,
    };
    // `auto` may have run what stands beside it: the same run shows nothing.
    let of_another = |at: usize| {
        [RADAU, 0, 2, 1, 4].into_iter().filter(|method| *method != index).find_map(|method| {
            found(method, at).filter(|(_, _, other)| other.ran != answer.ran || other.levels != answer.levels)
        })
    };
    let words = format!(
        "{:.2}/{:.2} dB ± {:.1e}{}, {} evaluations",
        level(answer.levels[0]),
        level(answer.levels[1]),
        answer.stated,
        if answer.chaotic { ", chaotic" } else { "" },
        answer.evaluations
    );
    let Some((method, at, other)) = of_another(1).or_else(|| found(index, 1 - which)).or_else(|| of_another(0)) else {
        let verdict = if answer.warned { Verdict::Warned } else { Verdict::Unconfirmed };
        return (verdict, format!("{words}; nothing to compare with"));
    };
    let (levels, quantities) = (level_difference(answer, other), quantity_differences(answer, other));
    let right_level = levels <= FACTOR * (answer.stated + other.stated) + INAUDIBLE;
    let stated = |i: usize| answer.stated_quantities[i] + other.stated_quantities[i];
    let right_quantities = (0..2).all(|i| quantities[i] <= FACTOR * stated(i) + UNASKED);
    let right = right_level && (answer.chaotic || right_quantities);
    let words = format!(
        "{words}; from {} at {:e}: {levels:.1e} dB, {:.1e} ± {:.1e} of the load, {:.1e} ± {:.1e} of the cage speed",
        methods[method].name(),
        TOLERANCES[at],
        quantities[0],
        stated(0),
        quantities[1],
        stated(1),
    );
    let verdict = match (right, answer.warned) {
        (_, true) => Verdict::Warned,
        (true, false) => Verdict::Right,
        (false, false) => Verdict::Wrong,
    };
    (verdict, words)
}

/// [dB]
fn level(rms: f64) -> f64 {
    20.0 * (rms.max(SILENCE) / 9.81e-3).log10()
}
