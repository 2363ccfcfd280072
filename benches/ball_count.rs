//! Time of a step against the number of balls, for each implicit method: with the arrowhead Jacobian of the model, and with
//! the same Jacobian as a dense matrix.
//!
//! `cargo bench --bench ball_count` runs the article's bearing. Rings, cage, load and 1/speed grow with the number of balls.
//! Times are medians of five.

use std::time::Instant;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::structure::{Jacobian, Structure};
use raceway::numerics::ode::{Method, OdeSystem, Statistics, Tolerances};
use raceway::simulation::input::settings::Outputs;
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::terms::ActiveTerms;
use serde_json::json;

const BALLS: [u32; 5] = [7, 14, 21, 30, 50];
const RUNS: usize = 5;
/// Untimed steps, then the timed steps with the arrowhead and with the dense Jacobian.
const WARM_UP: u64 = 100;
const STEPS: u64 = 400;
const STEPS_DENSE: u64 = 100;
const TOLERANCE: f64 = 1e-5;

/// A model whose Jacobian is declared dense.
struct Dense<'a> {
    model: &'a Model,
}

impl OdeSystem for Dense<'_> {
    fn dimension(&self) -> usize {
        self.model.dimension()
    }
    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        self.model.derivative(time, state, derivative);
    }
    fn structure(&self) -> Structure {
        Structure::dense(self.dimension())
    }
    fn jacobian(&self, time: f64, state: &[f64], rate: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        let structure = self.model.structure();
        let mut arrowhead = Jacobian::new(&structure);
        let evaluations = self.model.jacobian(time, state, rate, displacement, &mut arrowhead);
        let Structure { blocks, block, border, .. } = structure;
        let n = self.dimension();
        let whole = jacobian.corner_mut();
        let mut place = |rows: usize, columns: usize, width: usize, part: &mut dyn Iterator<Item = f64>| {
            for (i, value) in part.enumerate() {
                whole[(rows + i / width) * n + columns + i % width] = value;
            }
        };
        let edge = blocks * block;
        for index in 0..blocks {
            place(index * block, index * block, block, &mut arrowhead.blocks.of(index));
            place(index * block, edge, border, &mut arrowhead.right.of(index));
            place(edge, index * block, block, &mut arrowhead.below.of(index));
        }
        place(edge, edge, border, &mut arrowhead.corner().iter().copied());
        evaluations
    }
}

fn model(balls: u32) -> Model {
    let scale = f64::from(balls) / 7.0;
    let pitch = 13.0 * scale;
    let json = json!({
        "bearing": {
            "preset": "article-integrated", "ball_count": balls, "pitch_diameter_mm": pitch,
            "outer_diameter_mm": pitch + 5.0, "inner_diameter_mm": pitch - 4.5,
            "cage": {
                "mass_g": 0.13 * scale, "axial_inertia_kg_m2": 5.5e-9 * scale.powi(3),
                "transverse_inertia_kg_m2": 3e-9 * scale.powi(3)
            }
        },
        "operation": { "speed_rpm": 50_000.0 / scale, "radial_load_y_n": 200.0 * scale }
    });
    let scene = scene_from_json(&json.to_string()).expect("a scene");
    let outputs = Outputs::vibration();
    Model::new(&scene, &ActiveTerms::of(&scene, &outputs, None).expect("no rung is asked for"))
}

/// Median time of a step [s], and the work of the timed steps.
fn cost(
    system: &dyn OdeSystem,
    tolerances: &Tolerances,
    start: &[f64],
    method: Method,
    steps: u64,
) -> (f64, Statistics) {
    let mut times = Vec::new();
    let mut work = Statistics::default();
    for _ in 0..RUNS {
        let mut integrator = method.start(system, 0.0, start, tolerances.clone(), None);
        while integrator.statistics().steps < WARM_UP {
            integrator.step(1.0).expect("the bearing runs");
        }
        let before = integrator.statistics();
        let begin = Instant::now();
        while integrator.statistics().steps < before.steps + steps {
            integrator.step(1.0).expect("the bearing runs");
        }
        times.push(begin.elapsed().as_secs_f64() / steps as f64);
        let after = integrator.statistics();
        work = Statistics {
            steps: after.steps - before.steps,
            rhs_evaluations: after.rhs_evaluations - before.rhs_evaluations,
            jacobian_evaluations: after.jacobian_evaluations - before.jacobian_evaluations,
            factorizations: after.factorizations - before.factorizations,
            ..after
        };
    }
    times.sort_by(f64::total_cmp);
    (times[RUNS / 2], work)
}

/// Exponent of a power law through the points: the slope of a line through the logarithms.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let (x, y) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

fn main() {
    println!(
        "| method | Jacobian | balls | states | µs a step | evaluations a step | Jacobians | factorizations | of steps |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut exponents = Vec::new();
    for (method, dense) in
        [(Method::Gear, false), (Method::Gear, true), (Method::Radau, false), (Method::FineAbm, false)]
    {
        let kind = if dense { "dense" } else { "arrowhead" };
        let mut points = Vec::new();
        let mut per_evaluation = Vec::new();
        for balls in BALLS {
            let model = model(balls);
            let start = start_state(&model).expect("an equilibrium");
            let tolerances = model.mechanism().layout.tolerances(TOLERANCE);
            let hidden = Dense { model: &model };
            let system: &dyn OdeSystem = if dense { &hidden } else { &model };
            let (time, work) = cost(system, &tolerances, &start, method, if dense { STEPS_DENSE } else { STEPS });
            let evaluations = work.rhs_evaluations as f64 / work.steps as f64;
            println!(
                "| {} | {kind} | {balls} | {} | {:.1} | {evaluations:.2} | {} | {} | {} |",
                method.name(),
                start.len(),
                time * 1e6,
                work.jacobian_evaluations,
                work.factorizations,
                work.steps
            );
            points.push((f64::from(balls), time));
            per_evaluation.push((f64::from(balls), time / evaluations));
        }
        exponents.push((method.name(), kind, exponent(&points), exponent(&per_evaluation)));
    }
    println!();
    println!(
        "| method | Jacobian | exponent of the time a step over the number of balls | of the time an evaluation, all else included |"
    );
    println!("|---|---|---|---|");
    for (method, kind, of_step, of_evaluation) in exponents {
        println!("| {method} | {kind} | {of_step:.2} | {of_evaluation:.2} |");
    }
}
