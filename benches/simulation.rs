//! Error against run time of the article's case, and what one evaluation of its equations costs.
//!
//! `cargo bench --bench simulation` prints both tables; times are medians of five, with their range.

use std::hint::black_box;
use std::time::Instant;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::OdeSystem;
use raceway::simulation::channel::{Axis, Channel, Motion};
use raceway::simulation::model::Model;
use raceway::simulation::needs::Needs;
use raceway::simulation::run::{Control, Method, Outputs, RunSettings, Rung, run, start_state};
use raceway::simulation::scene::Scene;

const ARTICLE: &str =
    r#"{ "bearing": "article-integrated", "operation": { "speed_rpm": 50000, "radial_load_y_n": 200 } }"#;
const RUNS: usize = 5;

fn main() {
    let scene = scene_from_json(ARTICLE).expect("the article's case is a scene");
    evaluations(&scene);
    work_precision(&scene);
}

fn settings(rung: Rung, relative_tolerance: f64) -> RunSettings {
    RunSettings {
        method: Method::DormandPrince,
        rung: Some(rung),
        relative_tolerance,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: 0.02,
        duration: 0.02,
        outputs: Outputs { vibration: true, contacts: true, cage: true, spectra: Vec::new(), series: Vec::new() },
    }
}

/// (median, least, largest)
fn spread(mut values: Vec<f64>) -> (f64, f64, f64) {
    values.sort_by(f64::total_cmp);
    (values[values.len() / 2], values[0], values[values.len() - 1])
}

fn evaluations(scene: &Scene) {
    println!("one evaluation of dy/dt, start state of the article's case");
    println!("{:>8} {:>7} {:>10} {:>22}", "rung", "states", "ns", "range");
    for rung in [Rung::Full, Rung::Planar] {
        let needs = Needs::of(scene, &settings(rung, 1e-5).outputs, Some(rung)).expect("both rungs serve the article");
        let model = Model::new(scene, &needs);
        let state = start_state(&model).expect("the article's case has an equilibrium");
        let mut rate = state.clone();
        let once = || {
            let begin = Instant::now();
            for _ in 0..20_000 {
                model.derivative(black_box(0.0), black_box(&state), &mut rate);
            }
            begin.elapsed().as_secs_f64() / 20_000.0 * 1e9
        };
        let (median, least, largest) = spread(std::iter::repeat_with(once).take(RUNS).collect());
        println!("{:>8} {:>7} {median:>10.0} {least:>10.0} … {largest:<9.0}", rung.name(), state.len());
    }
}

fn work_precision(scene: &Scene) {
    let level = |rung: Rung, tolerance: f64| {
        let control = Control { stop: &|| false, progress: &|_| {} };
        let result = run(scene, &settings(rung, tolerance), &control).expect("the article's case runs");
        let channel = Channel::Spindle(Axis::Y, Motion::Acceleration);
        let level = result.summary.channels.iter().find(|(c, _)| *c == channel).and_then(|(_, m)| m.level_db);
        (level.expect("the article's bearing vibrates"), result.summary.solver)
    };
    let (reference, _) = level(Rung::Full, 1e-9);
    let (second, _) = level(Rung::Full, 1e-8);
    println!();
    println!(
        "0.04 s of the article's case: error of the y acceleration level against the full model at 1e-9 (own error {:.1e} dB)",
        (reference - second).abs()
    );
    println!(
        "{:>8} {:>10} {:>12} {:>10} {:>22} {:>9} {:>9}",
        "rung", "tolerance", "error dB", "s", "range", "steps", "rejected"
    );
    for rung in [Rung::Full, Rung::Planar] {
        for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
            let runs: Vec<_> = (0..RUNS).map(|_| level(rung, tolerance)).collect();
            let (median, least, largest) = spread(runs.iter().map(|(_, solver)| solver.wall_time).collect());
            let (found, solver) = &runs[0];
            println!(
                "{:>8} {tolerance:>10.0e} {:>12.1e} {median:>10.3} {least:>10.3} … {largest:<9.3} {:>9} {:>9}",
                rung.name(),
                (found - reference).abs(),
                solver.statistics.steps,
                solver.statistics.rejected_steps
            );
        }
    }
}
