//! A run depends on nothing but its scene and settings.

use raceway::numerics::ode::Method;
use raceway::simulation::input::channel::Channel;
use raceway::simulation::input::settings::RunSettings;
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::simulate;
use serde_json::json;

use crate::article_run::{patient, settings};
use crate::scenes::{article, changed, scene};

fn short_run() -> RunResult {
    // Dry pockets, because one different bit changes every number of a chaotic motion.
    let scene = scene(&changed(article(), json!({ "lubricant": "dry" })));
    let mut settings = settings();
    settings.settle = 2e-3;
    settings.duration = 4e-3;
    settings.outputs.series = vec![Channel::CageSpeed];
    let mut result = simulate(&scene, &settings, &patient()).unwrap();
    result.summary.solver.wall_time = 0.0;
    result
}

/// The same job gives the same bits when it is repeated and when other jobs run at the same time.
#[test]
fn same_job_gives_the_same_bits() {
    let threads: Vec<_> = (0..2).map(|_| std::thread::spawn(short_run)).collect();
    let alone = short_run();
    assert!(alone.series[0].values.len() > 300);
    for thread in threads {
        let beside = thread.join().unwrap();
        assert_eq!(alone, beside);
        assert_eq!(format!("{alone:?}"), format!("{beside:?}"));
    }
}

/// Every method, with step control and with fixed steps, twice in two threads.
#[test]
fn every_method_repeats_bit_for_bit() {
    let run_by = |method: Method, fixed_step: Option<f64>| {
        // Stiff enough that `auto` changes its method during the run.
        let traction = json!({ "law": "four_parameter", "at_slip_m_s": 0.05 });
        let scene = scene(&changed(article(), json!({ "lubricant": { "kind": "grease", "traction": traction } })));
        let settings = RunSettings { method, fixed_step, settle: 3e-4, duration: 5e-4, ..settings() };
        let mut result = simulate(&scene, &settings, &patient()).unwrap();
        result.summary.solver.wall_time = 0.0;
        result
    };
    for method in Method::NAMED.into_iter().chain([Method::Auto]) {
        let fixed = method.takes_fixed_steps().then_some(Some(0.2e-6));
        for step in [None].into_iter().chain(fixed) {
            let (one, other) = std::thread::scope(|scope| {
                let beside = scope.spawn(|| run_by(method, step));
                (run_by(method, step), beside.join().unwrap())
            });
            // Every number to the bit, NaN and the sign of zero included.
            assert_eq!(format!("{one:?}"), format!("{other:?}"), "{method:?} {step:?}");
            assert_eq!(format!("{one:?}"), format!("{:?}", run_by(method, step)), "{method:?} {step:?}");
            assert!(one.summary.solver.statistics.steps > 20, "{method:?} {step:?}");
        }
    }
}
