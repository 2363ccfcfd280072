//! Uncertainty jobs: distributions, points, refusals, and what their results say.

use serde_json::{Value, json};

use crate::contract::answer::propagation::{MetricSpreadAnswer, SpreadVerdict};
use crate::contract::job::uncertainty::Uncertainty;
use crate::contract::{Job, PointEnd, Row, TableAnswer, UncertaintyAnswer, parse_job};
use crate::plots::draw_uncertainty;

const LEVEL: &str = "/channels/spindle.y.acceleration/level_db";

fn request(inputs: Value) -> Value {
    json!({ "kind": "uncertainty", "scene": { "bearing": "6205", "operation": { "speed_rpm": 3000, "radial_load_y_n": 500 } },
        "inputs": inputs })
}

fn two_inputs() -> Value {
    json!([
        { "path": "/spindle/mass_kg", "distribution": { "type": "normal", "mean": 0.67, "standard_deviation": 0.05 } },
        { "path": "/operation/speed_rpm", "distribution": { "type": "uniform", "from": 2950, "to": 3050 } },
    ])
}

fn job_of(request: &Value) -> Uncertainty {
    match parse_job(request.to_string().as_bytes()) {
        Ok(Job::Uncertainty(job)) => *job,
        Ok(_) => panic!("another kind"),
        Err(refusal) => panic!("{request}: {refusal}"),
    }
}

fn refused(request: &Value) -> String {
    parse_job(request.to_string().as_bytes()).map(|_| ()).expect_err("refused").to_string()
}

fn with(distribution: Value) -> Value {
    request(json!([{ "path": "/spindle/mass_kg", "distribution": distribution }]))
}

/// Rows with a level by the number of the point; `None`: the run failed.
fn answer(job: &Uncertainty, level: impl Fn(usize) -> Option<f64>, error: f64) -> UncertaintyAnswer {
    UncertaintyAnswer::of(job, &rows(job, level, error))
}

fn rows(job: &Uncertainty, level: impl Fn(usize) -> Option<f64>, error: f64) -> Vec<Row> {
    let row = |point| {
        let end = match level(point) {
            Some(level) => PointEnd::Succeeded(json!({ "channels": { "spindle.y.acceleration":
                { "level_db": level, "level_error_db": error, "level_scatter_db": 0.0 } } })),
            None => serde_json::from_value(json!({ "cause": "did-not-converge", "detail": "none" }))
                .map(PointEnd::Failed)
                .unwrap(),
        };
        Row::queued(&job.study, point).ended(end)
    };
    (0..job.study.points).map(row).collect()
}

fn spread(answer: &UncertaintyAnswer) -> &MetricSpreadAnswer {
    &answer.metrics[LEVEL]
}

#[test]
fn points_are_the_nominal_one_and_those_of_the_design() {
    let job = job_of(&request(two_inputs()));
    assert_eq!((job.study.points, job.cube.len(), &*job.metrics), (65, 64, &[LEVEL.to_owned()][..]));
    assert_eq!(job.study.values(0), [&json!(0.67), &json!(3000.0)]);
    let point = job.study.point(1).unwrap().scene_json();
    let values = job.study.values(1);
    assert_eq!((&point["spindle"]["mass_kg"], &point["operation"]["speed_rpm"]), (values[0], values[1]));
    // One speed in each sixty-fourth of its range.
    let number = |point: usize| job.study.values(point)[1].as_f64().unwrap();
    let mut places: Vec<usize> = (1..65).map(|point| ((number(point) - 2950.0) / 100.0 * 64.0) as usize).collect();
    places.sort_unstable();
    assert_eq!(places, (0..64).collect::<Vec<_>>());
    let mut other = request(two_inputs());
    other["seed"] = json!(2);
    assert_ne!(job_of(&other).cube, job.cube);
    assert_eq!(job_of(&request(two_inputs())).cube, job.cube);
    let mut pairs = request(two_inputs());
    pairs["design"] = json!("pairs");
    assert_eq!(job_of(&pairs).study.points, 1 + 64 * 4);
}

#[test]
fn every_distribution_has_its_nominal_value_and_assumption() {
    let found = |distribution: Value| {
        let job = job_of(&with(distribution));
        (job.inputs[0].nominal(), job.inputs[0].assumption.clone())
    };
    let (nominal, assumption) = found(json!({ "type": "tolerance", "nominal": 0.6, "plus": 0.03, "minus": 0 }));
    assert_eq!(nominal, json!(0.6));
    assert_eq!(assumption, "normal, limits 0.6 and 0.63 at ±3 standard deviations, not cut");
    let (nominal, assumption) = found(json!({ "type": "discrete", "values": [0.5, 0.6], "weights": [1, 3] }));
    assert_eq!((nominal, &*assumption), (json!(0.6), "one of 0.5 (25 %), 0.6 (75 %)"));
    let (nominal, _) = found(json!({ "type": "triangular", "from": 0.5, "mode": 0.6, "to": 0.9 }));
    assert!((nominal.as_f64().unwrap() - (0.9 - 0.06_f64.sqrt())).abs() < 1e-6, "{nominal}");
    let (nominal, _) = found(json!({ "type": "lognormal", "mean": 0.6, "standard_deviation": 0.06 }));
    assert!((nominal.as_f64().unwrap() - 0.6 / 1.01_f64.sqrt()).abs() < 1e-6, "{nominal}");
    let (nominal, assumption) =
        found(json!({ "type": "normal", "mean": 0.6, "standard_deviation": 0.5, "from": 0.3, "to": 0.9 }));
    assert_eq!(
        (nominal, &*assumption),
        (json!(0.6), "normal, mean 0.6, standard deviation 0.5, cut below 0.3 and above 0.9")
    );
}

/// Bore 25 mm: CN is 5 to 20 µm.
#[test]
fn a_clearance_group_is_normal_between_its_limits_less_fits() {
    let group = json!([{ "path": "/bearing/radial_clearance_um", "distribution": { "type": "clearance_group", "group": "CN" } }]);
    let plain = job_of(&request(group.clone()));
    assert_eq!(plain.inputs[0].nominal(), json!(12.5));
    let assumption = "normal, group CN of bore 25 mm: 5 and 20 µm at ±3 standard deviations, not cut";
    assert_eq!(plain.inputs[0].assumption, assumption);
    let mut fitted = request(group);
    fitted["scene"]["bearing"] =
        json!({ "preset": "6205", "radial_clearance_group": "CN", "fits": { "shaft_interference_um": 5 } });
    let fitted = job_of(&fitted);
    // 0.804 of the interference.
    let loss = 12.5 - fitted.inputs[0].nominal().as_f64().unwrap();
    assert!((loss - 4.02).abs() < 0.01, "{loss}");
    assert!(fitted.inputs[0].assumption.contains(", less 4.0"), "{}", fitted.inputs[0].assumption);
    assert_eq!(
        fitted.study.point(1).unwrap().scene_json()["bearing"]["radial_clearance_um"],
        *fitted.study.values(1)[0]
    );
}

#[test]
fn wrong_inputs_are_refused_at_their_place() {
    let cases = [
        (json!({ "type": "uniform", "from": 1 }), "/inputs/0/distribution/to: required by `uniform`, but missing"),
        (json!({ "type": "uniform", "from": 1, "to": 1 }), "/inputs/0/distribution/to: 1: must be above `from`, 1"),
        (
            json!({ "type": "uniform", "from": 0.1, "to": 1, "mean": 1 }),
            "/inputs/0/distribution/mean: `uniform` takes `from`, `to`",
        ),
        (json!({ "type": "normal", "mean": 1, "standard_deviation": 0 }), "standard_deviation: 0: must be above 0"),
        (json!({ "type": "normal", "mean": 1, "standard_deviation": 1, "from": 2 }), "mean: 1: must lie between"),
        (
            json!({ "type": "normal", "mean": 0.1, "standard_deviation": 0.1 }),
            "/inputs/0/distribution: at the sampled value -",
        ),
        (json!({ "type": "lognormal", "mean": -1, "standard_deviation": 1 }), "mean: -1: must be above 0"),
        (json!({ "type": "tolerance", "nominal": 1, "plus": 0.1, "minus": -0.2 }), "plus: 0.1: the upper limit"),
        (json!({ "type": "discrete", "values": [1] }), "values: 1 values: must be from 2 to 16"),
        (json!({ "type": "discrete", "values": [1, 1] }), "values/1: given more than once"),
        (json!({ "type": "discrete", "values": [1, 2], "weights": [1] }), "weights: 1 weights: must be 2"),
        (json!({ "type": "discrete", "values": [1, 2], "weights": [1, 0] }), "weights/1: 0: must be from 1e-6 to 1e6"),
        (
            json!({ "type": "clearance_group", "group": "CN" }),
            "`clearance_group` describes `/bearing/radial_clearance_um`",
        ),
        (json!({ "type": "gaussian", "mean": 1 }), "/inputs/0/distribution/type"),
        (json!([1]), "/inputs/0/distribution"),
    ];
    for (distribution, expected) in cases {
        let refused = refused(&with(distribution.clone()));
        assert!(refused.contains(expected), "{distribution}: {refused}");
    }
    let changed = |field: &str, value: Value| {
        let mut request = request(two_inputs());
        request[field] = value;
        refused(&request)
    };
    assert!(changed("samples", json!(100)).contains("/samples: 100: must be a power of two, such as 64 or 128"));
    assert!(changed("samples", json!(8)).contains("/samples: 8"), "{}", changed("samples", json!(8)));
    assert!(changed("design", json!("grid")).contains("/design"));
    assert!(changed("metrics", json!([])).contains("/metrics: 0 metrics: must be from 1 to 8"));
    assert!(changed("metrics", json!(["/level"])).contains("/metrics/0: unknown metric"));
    assert!(changed("metrics", json!(["/channels/spindle.x.acceleration/rms"])).contains("/metrics/0"));
    assert!(changed("outputs", json!({ "metrics": ["cage"] })).contains("/outputs/metrics: must contain `vibration`"));
    assert!(changed("outputs", json!({ "series": ["spindle.y.velocity"] })).contains("/outputs/series"));
    assert!(changed("inputs", json!([])).contains("/inputs: 0 inputs: must be from 1 to 12"));
    assert!(changed("axes", json!([])).contains("/axes: goes with"));
    let twice = json!([two_inputs()[0], two_inputs()[0]]);
    assert!(changed("inputs", twice).contains("/inputs/1: `/spindle/mass_kg` is already varied"));
    let unknown = json!([{ "path": "/spindle/weight", "distribution": { "type": "uniform", "from": 1, "to": 2 } }]);
    assert!(changed("inputs", unknown).contains("/inputs/0/path"));
    let mut many = request(two_inputs());
    (many["design"], many["samples"]) = (json!("pairs"), json!(4096));
    assert!(refused(&many).contains("/samples: 4096: `pairs` of 2 inputs are 16384 runs: at most 10000"));
    many["design"] = json!("latin_hypercube");
    many["samples"] = json!(100);
    assert_eq!(job_of(&many).study.points, 101);
}

/// A level of 60 + 40 (mass − 0.67) dB: the mass alone decides.
#[test]
fn the_answer_has_spread_ranking_and_errors() {
    let job = job_of(&request(two_inputs()));
    let mass = |point: usize| job.study.values(point)[0].as_f64().unwrap();
    let level = |point| Some(60.0 + 40.0 * (mass(point) - 0.67));
    let found = answer(&job, level, 0.1);
    let of = spread(&found);
    assert_eq!((found.points, found.ended, found.failed, of.values, of.without_value), (65, 65, 0, 64, 0));
    assert_eq!((of.nominal, of.verdict, found.messages.len()), (Some(60.0), SpreadVerdict::Resolved, 0));
    assert!((of.mean - 60.0).abs() < 0.05 && (of.standard_deviation - 2.0).abs() < 0.15, "{of:?}");
    // 10 lg of the mean of a lognormal power: mean + ln 10/20 σ².
    let energy = of.energy_mean_db.unwrap();
    assert!((energy - of.mean - 0.1151 * of.standard_deviation.powi(2)).abs() < 0.05, "{energy}");
    let p90 = of.percentiles[3];
    assert!(p90.percentile == 90 && (p90.value - 62.563).abs() < 0.1, "{p90:?}");
    assert!(p90.from.unwrap() < p90.value && p90.to.unwrap() > p90.value);
    assert!(of.percentiles[4].to.is_none() && of.percentiles[0].from.is_none(), "64 values have no such bounds");
    assert_eq!(of.histogram.counts.iter().sum::<u64>(), 64);
    let ranking = of.sensitivity.as_ref().unwrap();
    assert!(ranking.q2 > 0.95 && ranking.inputs[0].share > 0.95 && ranking.inputs[1].share < 0.01, "{ranking:?}");
    assert_eq!((ranking.inputs[0].sign, ranking.inputs[0].total_share), (Some(1), None));
    assert!((of.errors.integration.unwrap() - 0.1).abs() < 1e-9);
    let subtracted = (of.standard_deviation.powi(2) - 0.01).sqrt();
    assert!((of.errors.tolerance_spread - subtracted).abs() < 1e-9);
    assert_eq!((of.errors.model.model_tolerance_db, of.errors.model.without_bound.len()), (0.05, 3));
    assert!(draw_uncertainty::histograms(&found).contains(">P90<"));
    let table = TableAnswer::of(&job.study, rows(&job, level, 0.1));
    assert!(table.best.is_empty() && table.trends.is_empty() && table.rows.len() == 65);
}

#[test]
fn failed_points_large_errors_and_noise_are_told() {
    let mut with_metrics = request(two_inputs());
    with_metrics["samples"] = json!(64);
    let job = job_of(&with_metrics);
    let codes = |found: &UncertaintyAnswer| {
        found.messages.iter().map(|message| json!(message.code).as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let mass = |point: usize| job.study.values(point)[0].as_f64().unwrap();
    let found = answer(&job, |point| (point > 4).then(|| mass(point)), 1e-4);
    assert_eq!((found.failed, spread(&found).without_value, spread(&found).nominal), (5, 4, None));
    assert_eq!(codes(&found), ["failed-samples"]);
    let found = answer(&job, |point| Some(mass(point)), 0.04);
    assert_eq!(
        (spread(&found).verdict, codes(&found)),
        (SpreadVerdict::SpreadNotResolved, vec!["spread-not-resolved".to_owned()])
    );
    assert!(found.messages[0].text.contains("0.04"), "{}", found.messages[0].text);
    // Values that have nothing to do with the inputs.
    let noise = |point: usize| Some(60.0 + ((point * 7919) % 101) as f64 / 100.0);
    let found = answer(&job, noise, 1e-4);
    assert_eq!(codes(&found), ["ranking-not-resolved"]);
    assert!(!spread(&found).sensitivity.as_ref().unwrap().resolved);
    assert!(answer(&job, |_| None, 0.0).metrics.is_empty());
    let one = answer(&job, |_| Some(60.0), 0.0);
    assert!(spread(&one).sensitivity.is_none() && spread(&one).standard_deviation == 0.0);
}

#[test]
fn pairs_have_total_shares_and_words_have_no_sign() {
    let mut request = request(json!([
        { "path": "/spindle/mass_kg", "distribution": { "type": "uniform", "from": 0.5, "to": 0.7 } },
        { "path": "/bearing/materials/ball", "distribution": { "type": "discrete", "values": ["gcr15", "si3n4"] } },
    ]));
    request["design"] = json!("pairs");
    let job = job_of(&request);
    // Nothing but an interaction and the mass: x + x·b with b = ±1 has shares ½, 0; totals 1, ½.
    let level = |point: usize| {
        let values = job.study.values(point);
        let x = (values[0].as_f64().unwrap() - 0.6) * 10.0;
        let b = if values[1] == "gcr15" { 1.0 } else { -1.0 };
        Some(60.0 + x + x * b)
    };
    let found = answer(&job, level, 1e-3);
    assert_eq!(spread(&found).values, 128);
    let ranking = spread(&found).sensitivity.as_ref().unwrap();
    let [mass, ball] = [&ranking.inputs[0], &ranking.inputs[1]];
    assert!((mass.share - 0.5).abs() < 0.1 && ball.share.abs() < 0.1, "{ranking:?}");
    assert!(
        (mass.total_share.unwrap() - 1.0).abs() < 0.1 && (ball.total_share.unwrap() - 0.5).abs() < 0.1,
        "{ranking:?}"
    );
    let [low, high] = mass.pair_share_interval.unwrap();
    assert!(low < 0.5 && 0.5 < high, "{ranking:?}");
    assert_eq!((mass.sign, ball.sign), (Some(1), None));
}
