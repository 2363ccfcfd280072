//! Time of one evaluation of the equations of motion of the article's case, and of their Jacobian.
//!
//! `cargo bench --bench simulation` prints medians of five, with their range.

use std::hint::black_box;
use std::time::Instant;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::OdeSystem;
use raceway::numerics::ode::structure::Jacobian;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::Outputs;
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::terms::ActiveTerms;

const ARTICLE: &str =
    r#"{ "bearing": "article-integrated", "operation": { "speed_rpm": 50000, "radial_load_y_n": 200 } }"#;
const RUNS: usize = 5;
const COUNT: u32 = 10_000;

fn main() {
    let scene = scene_from_json(ARTICLE).expect("the article's case is a scene");
    evaluations(&scene);
}

fn outputs() -> Outputs {
    Outputs { contacts: true, cage: true, ..Outputs::vibration() }
}

/// Median, least and largest time.
fn spread(mut values: Vec<f64>) -> (f64, f64, f64) {
    values.sort_by(f64::total_cmp);
    (values[values.len() / 2], values[0], values[values.len() - 1])
}

fn evaluations(scene: &Scene) {
    println!("one evaluation of dy/dt, and one of its Jacobian; start state of the article's case");
    println!("{:>8} {:>7} {:>10} {:>10} {:>22}", "rung", "states", "of", "ns", "range");
    for rung in [ModelLevel::Full, ModelLevel::Planar] {
        let needs = ActiveTerms::of(scene, &outputs(), Some(rung)).expect("both rungs serve the article");
        let model = Model::new(scene, &needs);
        let state = start_state(&model).expect("the article's case has an equilibrium");
        let mut rate = state.clone();
        let mut jacobian = Jacobian::new(&model.structure());
        let row = |of: &str, once: &mut dyn FnMut()| {
            let mean = || {
                let begin = Instant::now();
                (0..COUNT).for_each(|_| once());
                begin.elapsed().as_secs_f64() / f64::from(COUNT) * 1e9
            };
            let (median, least, largest) = spread(std::iter::repeat_with(mean).take(RUNS).collect());
            println!("{:>8} {:>7} {of:>10} {median:>10.0} {least:>10.0} … {largest:<9.0}", rung.name(), state.len());
        };
        row("dy/dt", &mut || model.derivative(black_box(0.0), black_box(&state), &mut rate));
        row("Jacobian", &mut || {
            model.jacobian(black_box(0.0), black_box(&state), &[], &[], &mut jacobian);
        });
    }
}
