//! Error, cost and limit of stability of precise integration, with either exact linear part: the kinematic part, as in the
//! article, or the blocks of the Jacobian.
//!
//! `cargo bench --bench fine_abm` prints all tables. The reference is Dormand–Prince at 1e-9. Errors are those of the state at
//! 200 times, each entry relative to its size (1 µm, 10 mm/s, 100 rad/s …).

use std::time::Instant;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::dormand_prince::DormandPrince;
use raceway::numerics::ode::fine_abm::{FineAbm, LinearPart};
use raceway::numerics::ode::structure::Jacobian;
use raceway::numerics::ode::{Integrator, OdeSystem, Statistics, Tolerances};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::Outputs;
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::terms::ActiveTerms;

const ARTICLE: &str =
    r#"{ "bearing": "article-integrated", "operation": { "speed_rpm": 50000, "radial_load_y_n": 200 } }"#;
const STEEP: &str = r#"{ "bearing": "article-integrated", "operation": { "speed_rpm": 50000, "radial_load_y_n": 200 },
    "lubricant": { "kind": "grease", "traction":
        { "law": "four_parameter", "at_rest": 0, "maximum": 0.05, "at_slip_m_s": 0.001, "limit": 0.036 } } }"#;
const UNDAMPED: &str = r#"{ "bearing": "article-integrated", "operation": { "speed_rpm": 50000, "radial_load_y_n": 200 },
    "damping": { "raceway": { "law": "none" } } }"#;
const SAMPLES: usize = 200;
const RUNS: usize = 3;

fn main() {
    bearing("A: the article's case", ARTICLE, 10e-3);
    bearing("B: traction that saturates at 1 mm/s", STEEP, 5e-3);
    bearing("C: raceways without damping", UNDAMPED, 2e-3);
    prothero_robinson();
    stability();
}

/// States at the sampling times, and the work of the run.
type Run = (Vec<Vec<f64>>, Statistics, f64);

fn run(mut method: Box<dyn Integrator + '_>, end: f64) -> Run {
    let begin = Instant::now();
    let mut samples = Vec::new();
    let mut state = method.state().to_vec();
    while method.time() < end {
        method.step(end).expect("the bearing runs");
        while samples.len() < SAMPLES {
            let at = end * (samples.len() + 1) as f64 / SAMPLES as f64;
            if at > method.time() {
                break;
            }
            method.interpolate(at, &mut state);
            samples.push(state.clone());
        }
    }
    (samples, method.statistics(), begin.elapsed().as_secs_f64())
}

fn bearing(title: &str, json: &str, end: f64) {
    let scene = scene_from_json(json).expect("a scene");
    let outputs = Outputs { contacts: true, cage: true, ..Outputs::vibration() };
    let needs = ActiveTerms::of(&scene, &outputs, Some(ModelLevel::Full)).expect("the full model serves all");
    let model = Model::new(&scene, &needs);
    let start = start_state(&model).expect("an equilibrium");
    let layout = model.mechanism().layout;
    // Where stability limits it, Dormand–Prince takes steps of 3.3 over the fastest decay rate.
    let explicit = run(Box::new(DormandPrince::new(&model, 0.0, &start, layout.tolerances(1e-5), None)), end).1;
    let rate = 3.3 * explicit.steps as f64 / explicit.advanced;
    println!("{title}; {} ms, {} states, fastest rate {rate:.2e} 1/s in the mean", end * 1e3, start.len());
    let (reference, ..) = run(Box::new(DormandPrince::new(&model, 0.0, &start, layout.tolerances(1e-9), None)), end);
    println!(
        "{:>15} {:>9} {:>7} {:>8} {:>8} {:>5} {:>5} {:>9} {:>7} {:>9} {:>9} {:>8}",
        "method", "tolerance", "steps", "rejected", "rhs", "jac", "phi", "mean step", "h|l|", "rms", "max", "ms"
    );
    let sizes = layout.sizes();
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
        for part in [None, Some(LinearPart::Kinematic), Some(LinearPart::Blocks)] {
            let start = || -> Box<dyn Integrator + '_> {
                let tolerances = layout.tolerances(tolerance);
                match part {
                    None => Box::new(DormandPrince::new(&model, 0.0, &start, tolerances, None)),
                    Some(part) => Box::new(FineAbm::new(&model, 0.0, &start, tolerances, None, part)),
                }
            };
            let runs: Vec<Run> = (0..RUNS).map(|_| run(start(), end)).collect();
            let mut times: Vec<f64> = runs.iter().map(|run| run.2).collect();
            times.sort_by(f64::total_cmp);
            let (samples, work, _) = &runs[0];
            let errors = || {
                let pairs = samples.iter().flatten().zip(reference.iter().flatten()).enumerate();
                pairs.map(|(i, (a, b))| ((a - b) / sizes[i % sizes.len()]).abs())
            };
            let rms = (errors().map(|e| e * e).sum::<f64>() / errors().count() as f64).sqrt();
            let step = work.advanced / work.steps as f64;
            println!(
                "{:>15} {tolerance:>9.0e} {:>7} {:>8} {:>8} {:>5} {:>5} {step:>9.2e} {:>7.2} {rms:>9.2e} {:>9.2e} {:>8.1}",
                part.map_or("dormand_prince".into(), |part| format!("{part:?}")),
                work.steps,
                work.rejected_steps,
                work.rhs_evaluations,
                work.jacobian_evaluations,
                work.factorizations,
                rate * step,
                errors().fold(0.0, f64::max),
                times[RUNS / 2] * 1e3,
            );
        }
    }
    println!();
}

/// ẏ = λ (y − cos t) − sin t, with `claimed` as its Jacobian.
struct ProtheroRobinson {
    rate: f64,
    claimed: f64,
}
impl OdeSystem for ProtheroRobinson {
    fn dimension(&self) -> usize {
        1
    }
    fn derivative(&self, time: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = self.rate * (y[0] - time.cos()) - time.sin();
    }
    fn jacobian(&self, _: f64, _: &[f64], _: &[f64], _: &[f64], jacobian: &mut Jacobian) -> u64 {
        jacobian.corner_mut()[0] = self.claimed;
        1
    }
}

fn prothero_robinson() {
    println!("y' = l (y - cos t) - sin t to t = 10, tolerance 1e-6: steps and largest error");
    println!("{:>9} {:>12} {:>9} {:>12} {:>9}", "l", "Kinematic", "", "Blocks", "");
    for rate in [-1e1, -1e2, -1e3, -1e4, -1e5] {
        print!("{rate:>9.0e}");
        for part in [LinearPart::Kinematic, LinearPart::Blocks] {
            let system = ProtheroRobinson { rate, claimed: rate };
            let mut method = FineAbm::new(&system, 0.0, &[1.0], Tolerances::uniform(1, 1e-6, 1e-6), None, part);
            let mut error: f64 = 0.0;
            while method.time() < 10.0 {
                method.step(10.0).expect("a smooth solution");
                error = error.max((method.state()[0] - method.time().cos()).abs());
            }
            print!(" {:>12} {error:>9.1e}", method.statistics().steps);
        }
        println!();
    }
    println!();
}

/// y' = J y, a decay or an oscillator. The method is given `share · J` as the linear part.
struct Misjudged {
    real: bool,
    rate: f64,
    share: f64,
}
impl OdeSystem for Misjudged {
    fn dimension(&self) -> usize {
        2
    }
    fn derivative(&self, _: f64, y: &[f64], dy: &mut [f64]) {
        let rate = self.rate;
        dy.copy_from_slice(&if self.real { [-rate * y[0], -rate * y[1]] } else { [rate * y[1], -rate * y[0]] });
    }
    fn jacobian(&self, _: f64, _: &[f64], _: &[f64], _: &[f64], jacobian: &mut Jacobian) -> u64 {
        let r = self.share * self.rate;
        jacobian.corner_mut().copy_from_slice(&if self.real { [-r, 0.0, 0.0, -r] } else { [0.0, r, -r, 0.0] });
        1
    }
}

/// Longest fixed step whose state stays bounded, by bisection.
fn stability() {
    println!("largest stable h|l - H| of y' = l y, by the share of l that H holds");
    println!("{:>7} {:>10} {:>10}", "share", "decay", "oscillation");
    for share in [0.0, 0.5, 0.8, 0.9, 0.95, 1.05, 1.1, 1.2, 1.5] {
        let limit = |real: bool| {
            let bounded = |rate: f64| {
                let system = Misjudged { real, rate, share };
                let tolerances = Tolerances::uniform(2, 1e-9, 1e-9);
                let mut method = FineAbm::new(&system, 0.0, &[1.0, 0.5], tolerances, Some(1.0), LinearPart::Blocks);
                let size = |method: &FineAbm<'_, Misjudged>| method.state().iter().map(|x| x.abs()).fold(0.0, f64::max);
                // The first five points may be far away. The criterion is the growth after them.
                while method.time() < 3000.0 && size(&method) < 1e3 {
                    if method.step(3000.0).is_err() {
                        return false;
                    }
                }
                size(&method) < 10.0
            };
            let (mut low, mut high) = (0.01, 0.01);
            while high < 2e3 && bounded(high) {
                (low, high) = (high, high * 1.3);
            }
            for _ in 0..12 {
                let middle = 0.5 * (low + high);
                if bounded(middle) { low = middle } else { high = middle }
            }
            (low, high > 2e3)
        };
        let text =
            |(rate, open): (f64, bool)| format!("{}{:.2}", if open { "> " } else { "" }, rate * f64::abs(1.0 - share));
        println!("{share:>7} {:>10} {:>10}", text(limit(true)), text(limit(false)));
    }
}
