//! A run depends on nothing but its scene and settings.

use raceway::simulation::channel::Channel;
use raceway::simulation::run::{RunResult, run};
use serde_json::json;

use crate::article_run::{patient, settings};
use crate::scenes::{article, changed, scene};

fn short_run() -> RunResult {
    // Dry pockets: chaotic, so that one different bit would show everywhere.
    let scene = scene(&changed(article(), json!({ "lubricant": "dry" })));
    let mut settings = settings();
    settings.settle = 2e-3;
    settings.duration = 4e-3;
    settings.outputs.series = vec![Channel::CageSpeed];
    let mut result = run(&scene, &settings, &patient()).unwrap();
    result.summary.solver.wall_time = 0.0;
    result
}

/// The same job gives the same bits when it is run again and when others run beside it.
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
