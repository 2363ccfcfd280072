//! Does every method give a correct or a rejected result at the limits of the input, at two tolerances?
//!
//! Prints a table of all scenes and methods. `scene=TEXT`, `method=NAME` and `budget=N` select a part of it.
//!
//! Each cell is a whole run as the service makes it, its error estimate included: 2 ms of settling, 6 ms recorded. The
//! reference is another integrator at the tighter tolerance. Where no other has finished, it is the same one at the other
//! tolerance. A level is right where it deviates by at most `FACTOR` times the sum of both stated errors. Where the motion is
//! not chaotic, the same holds for the largest contact load and the cage speed. A result with a warning that it is not
//! resolved counts as such. A NaN or a panic is wrong.
//!
//! The work is limited by counts and not by a clock, so that the table is the same on every machine.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::Method;
use raceway::simulation::error::codes::Warning;
use raceway::simulation::error::comparison::FAINT;
use raceway::simulation::error::lyapunov::MotionKind;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::failure::SimulationError;
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::simulate as simulate_scene;
use serde_json::Value;

#[path = "../../tests/limits/article.rs"]
mod article;
use article::{article, changed};

use crate::threads::in_parallel;

/// Observations of a run, each after some 1500 evaluations, before it is aborted. Its error estimate is included.
const BUDGET: u64 = 1_000;
const TOLERANCES: [f64; 2] = [1e-4, 1e-6];
/// A stated error may be too small by this factor.
const FACTOR: f64 = 3.0;
/// Levels below this count as silence [m/s²].
const SILENCE: f64 = 1e-6;
/// Deviation of a level that always counts as right [dB].
const INAUDIBLE: f64 = 1e-3;
/// Relative deviation of largest load and cage speed that always counts as right [-].
const NEGLIGIBLE: f64 = 1e-4;
/// Load [N] and cage speed [Hz] that count as zero.
const LEAST_QUANTITIES: [f64; 2] = [0.1, 1.0];

/// A scene with its settling and recorded time [s].
struct Case {
    name: String,
    scene: Value,
    settle: f64,
    duration: f64,
    /// Factor on the budget [-].
    budget_factor: u64,
}

/// The scenes of `scenes/extreme.json`, which lists them as changes of the article's case.
fn cases() -> Vec<Case> {
    let listed: Vec<Value> = serde_json::from_str(include_str!("../scenes/extreme.json")).expect("a list");
    let case = |listed: Value| Case {
        name: listed["name"].as_str().expect("a name").into(),
        scene: changed(article(), listed["changes"].clone()),
        settle: listed["settle_s"].as_f64().expect("a time"),
        duration: listed["duration_s"].as_f64().expect("a time"),
        budget_factor: listed["budget_factor"].as_u64().unwrap_or(1),
    };
    listed.into_iter().map(case).collect()
}

fn outputs() -> Outputs {
    Outputs { contacts: true, cage: true, ..Outputs::vibration() }
}

fn settings(case: &Case, method: Method, relative_tolerance: f64) -> RunSettings {
    RunSettings {
        method,
        rung: None,
        relative_tolerance,
        // The full model, because the integrators are compared and not the models.
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: case.settle,
        duration: case.duration,
        outputs: outputs(),
    }
}

/// The numbers of a finished run that are compared.
struct Answer {
    /// Root mean square of the accelerations in y and z [m/s²].
    levels: [f64; 2],
    /// Stated level error [dB].
    stated: f64,
    chaotic: bool,
    warned: bool,
    /// True where an error is stated. A result without one confirms no other.
    judged: bool,
    /// Largest load of the inner contacts [N], cage speed [Hz].
    quantities: [f64; 2],
    /// Their stated errors, relative [-].
    stated_quantities: [f64; 2],
    /// Method that ran.
    ran: &'static str,
    evaluations: u64,
}

/// End of a run.
enum End {
    Answer(Answer),
    OverBudget(String),
    Failed(String),
    /// Panicked, or gave numbers that are not finite.
    Broken(String),
}

fn simulate(case: &Case, scene: &Scene, method: Method, tolerance: f64, budget: u64) -> End {
    let looks = Cell::new(0);
    let stop = || {
        looks.set(looks.get() + 1);
        looks.get() > budget
    };
    let control = Control::until(&stop);
    let result = catch_unwind(AssertUnwindSafe(|| simulate_scene(scene, &settings(case, method, tolerance), &control)));
    match result {
        Err(_) => End::Broken("panicked".into()),
        Ok(Err(SimulationError::Stopped { time })) => {
            End::OverBudget(format!("aborted over budget at {:.3} ms", 1e3 * time))
        }
        Ok(Err(error)) => End::Failed(error.to_string()),
        Ok(Ok(result)) => {
            answer(&result).map_or_else(|| End::Broken("numbers that are not finite".into()), End::Answer)
        }
    }
}

/// The numbers of a result; `None` where one of them is not finite.
fn answer(result: &RunResult) -> Option<Answer> {
    let summary = &result.summary;
    let level = |axis: Axis| {
        let channel = Channel::Spindle(axis, Motion::Acceleration);
        summary.channels.iter().find(|(of, _)| *of == channel).map_or(0.0, |(_, metrics)| metrics.rms)
    };
    let is_transient = |warning: &Warning| {
        matches!(
            warning,
            Warning::StartTransient { .. } | Warning::CageTransient { .. } | Warning::TiltTransient { .. }
        )
    };
    let warned = summary.accuracy.warnings.iter().any(|warning| !is_transient(warning));
    let answer = Answer {
        levels: [level(Axis::Y), level(Axis::Z)],
        stated: summary.accuracy.level_error_db().unwrap_or(0.0),
        chaotic: summary.accuracy.motion == Some(MotionKind::Diverging),
        warned,
        judged: summary.accuracy.level_error_db().is_some() || !warned,
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

/// Larger deviation of y and z [dB]. A direction that is much weaker than the other counts as equal.
fn level_difference(a: &Answer, b: &Answer) -> f64 {
    let strongest = a.levels.iter().chain(&b.levels).copied().fold(SILENCE, f64::max);
    let floor = strongest * 10_f64.powf(-FAINT / 20.0);
    let one = |a: f64, b: f64| 20.0 * (a.max(floor) / b.max(floor)).log10().abs();
    one(a.levels[0], b.levels[0]).max(one(a.levels[1], b.levels[1]))
}

/// Deviations of load and cage speed [-], relative to the larger value or to `LEAST_QUANTITIES`.
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
    fn text(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Warned => "with a warning",
            Self::OverBudget => "aborted over budget",
            Self::Unconfirmed => "not confirmed",
            Self::Failed => "failed with a reason",
            Self::Wrong => "**WRONG**",
        }
    }
}

struct Selection {
    scene: String,
    method: String,
    budget: u64,
}

pub fn run(words: &[String]) {
    let mut selection = Selection { scene: String::new(), method: String::new(), budget: BUDGET };
    for argument in words {
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
            Err(reason) => {
                refused += 1;
                println!("| {} | all | {reason} | | refused |", case.name);
            }
        }
    }
    println!();
    let counts: Vec<String> = counts.iter().map(|(verdict, count)| format!("{}: {count}", verdict.text())).collect();
    println!("{}; scenes refused: {refused}; {:.0} s", counts.join("; "), begin.elapsed().as_secs_f64());
}

/// Ends of each method at both tolerances, on as many threads as there are processors.
fn ends(case: &Case, scene: &Scene, methods: &[Method], budget: u64) -> Vec<[End; 2]> {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let mut all = in_parallel(threads, TOLERANCES.len() * methods.len(), |index| {
        simulate(case, scene, methods[index / 2], TOLERANCES[index % 2], budget)
    })
    .into_iter();
    std::iter::from_fn(|| Some([all.next()?, all.next()?])).collect()
}

/// Prints the rows of a scene and returns their verdicts; `Err`: why the scene is refused.
fn rows(case: &Case, selection: &Selection) -> Result<Vec<Verdict>, String> {
    let scene = scene_from_json(&case.scene.to_string()).map_err(|refusal| format!("{refusal:?}"))?;
    let methods: Vec<Method> = Method::NAMED.into_iter().chain([Method::Auto]).collect();
    let ends = ends(case, &scene, &methods, case.budget_factor * selection.budget);
    let mut verdicts = Vec::new();
    for (index, both) in ends.iter().enumerate() {
        if !methods[index].name().contains(&selection.method) {
            continue;
        }
        let cells: Vec<(Verdict, String)> = (0..2)
            .map(|which| match &both[which] {
                End::Answer(answer) => judge(&ends, &methods, index, which, answer),
                End::OverBudget(reason) => (Verdict::OverBudget, reason.clone()),
                End::Failed(reason) => (Verdict::Failed, reason.clone()),
                End::Broken(reason) => (Verdict::Wrong, reason.clone()),
            })
            .collect();
        let worst = if cells[0].0 > cells[1].0 { cells[0].0 } else { cells[1].0 };
        println!("| {} | {} | {} | {} | {} |", case.name, methods[index].name(), cells[0].1, cells[1].1, worst.text());
        verdicts.push(worst);
    }
    Ok(verdicts)
}

/// Verdict and cell of an answer, from its comparison with the best other one.
fn judge(ends: &[[End; 2]], methods: &[Method], index: usize, which: usize, answer: &Answer) -> (Verdict, String) {
    const RADAU: usize = 3;
    let found = |method: usize, at: usize| match &ends[method][at] {
        End::Answer(other) if other.judged => Some((method, at, other)),
        _ => None,
    };
    // `auto` may have run the method of another row. The same run is no comparison.
    let of_another = |at: usize| {
        [RADAU, 0, 2, 1, 4].into_iter().filter(|method| *method != index).find_map(|method| {
            found(method, at).filter(|(_, _, other)| other.ran != answer.ran || other.levels != answer.levels)
        })
    };
    let cell = format!(
        "{:.2}/{:.2} dB ± {:.1e}{}, {} evaluations",
        level(answer.levels[0]),
        level(answer.levels[1]),
        answer.stated,
        if answer.chaotic { ", chaotic" } else { "" },
        answer.evaluations
    );
    let Some((method, at, other)) = of_another(1).or_else(|| found(index, 1 - which)).or_else(|| of_another(0)) else {
        let verdict = if answer.warned { Verdict::Warned } else { Verdict::Unconfirmed };
        return (verdict, format!("{cell}; nothing to compare with"));
    };
    let (levels, quantities) = (level_difference(answer, other), quantity_differences(answer, other));
    let right_level = levels <= FACTOR * (answer.stated + other.stated) + INAUDIBLE;
    let stated = |i: usize| answer.stated_quantities[i] + other.stated_quantities[i];
    let right_quantities = (0..2).all(|i| quantities[i] <= FACTOR * stated(i) + NEGLIGIBLE);
    let right = right_level && (answer.chaotic || right_quantities);
    let cell = format!(
        "{cell}; from {} at {:e}: {levels:.1e} dB, {:.1e} ± {:.1e} of the load, {:.1e} ± {:.1e} of the cage speed",
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
    (verdict, cell)
}

/// Level of an acceleration [dB re 9.81 mm/s²].
fn level(rms: f64) -> f64 {
    20.0 * (rms.max(SILENCE) / 9.81e-3).log10()
}
