//! Optimum jobs: valid objectives, and their results.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::contract::answer::optimum::PurposeName;
use crate::contract::job::input::GoalName;
use crate::contract::job::search::Objective;
use crate::contract::json::defaults::Defaults;
use crate::contract::{Job, OptimumAnswer, Outcome, PointEnd, execute, parse_job};
use raceway_core::simulation::input::control::Control;

const LEVEL: &str = "/channels/spindle.y.acceleration/level_db";

fn request(axes: Value) -> Value {
    json!({ "kind": "optimum", "scene": { "bearing": "article-integrated", "operation": { "speed_rpm": 50000, "radial_load_y_n": 200 } },
        "axes": axes, "metric": LEVEL })
}

fn parsed(request: &Value) -> Job {
    parse_job(request.to_string().as_bytes()).unwrap_or_else(|refusal| panic!("{request}: {refusal}"))
}

fn refused(request: &Value) -> String {
    parse_job(request.to_string().as_bytes()).map(|_| ()).expect_err("refused").to_string()
}

fn with(field: &str, value: Value) -> Value {
    let mut request = request(json!([{ "path": "/spindle/mass_kg", "from": 0.02, "to": 0.2 }]));
    request[field] = value;
    request
}

const QUIET: Control<'_> = Control::until(&|| false);

fn found(request: &Value) -> OptimumAnswer {
    match execute(&parsed(request), &QUIET) {
        Ok(Outcome::Optimum(answer)) => *answer,
        other => panic!("{other:?}"),
    }
}

#[test]
fn wrong_objectives_are_refused_with_their_pointer() {
    let axis = |axis: Value| request(json!([axis]));
    let path = "/spindle/mass_kg";
    for (request, told) in [
        (request(json!([])), "/axes: 0 axes: must be from 1 to 2"),
        (axis(json!({ "path": path, "values": [0.1, 0.2] })), "/axes/0: takes `from` and `to`"),
        (axis(json!({ "path": path, "from": 0.1, "to": 0.2, "count": 5 })), "/axes/0: takes `from` and `to`"),
        (axis(json!({ "path": path, "from": 0.1, "to": 0.1 })), "/axes/0/to: the same as `from`"),
        (axis(json!({ "path": path, "from": 0.0, "to": 0.1, "scale": "log" })), "/axes/0/scale: `log` needs"),
        (axis(json!({ "path": "/bearing/ball_count", "from": 6, "to": 9 })), "takes whole numbers only: use a study"),
        (axis(json!({ "path": "/spindle/colour", "from": 6, "to": 9 })), "/axes/0/path: unknown field `colour`"),
        (axis(json!({ "path": "/bearing/inner_groove_curvature", "from": 0.4, "to": 0.54 })), "/axes/0/from: 0.4"),
        (axis(json!({ "path": "/bearing/inner_groove_curvature", "from": 0.51, "to": 9 })), "/axes/0/to: 9"),
        (with("metric", json!("/channels/spindle.x.velocity/rms")), "/metric: `spindle.x.velocity` exists only where"),
        (with("metric", json!("/channels/spindle.y.acceleration/colour")), "/metric: unknown metric"),
        (with("metric", json!("/channels/spindle.y.velocity/level_db")), "/metric: unknown metric"),
        (with("metric", json!(5)), "/metric"),
        (with("goal", json!("least")), "/goal"),
        (with("outputs", json!({ "metrics": ["cage"] })), "/outputs/metrics: must contain `vibration`"),
        (with("outputs", json!({ "series": ["cage.speed"] })), "/outputs/series: a job of kind `optimum` keeps no"),
        (with("kind", json!("simulation")), "/metric: goes with the kind `optimum`"),
    ] {
        let found = refused(&request);
        assert!(found.contains(told), "{request}: {found}");
    }
    let mut without = with("goal", json!("maximum"));
    without.as_object_mut().unwrap().remove("metric");
    assert!(refused(&without).contains("/metric: required"));
}

/// The names that are accepted are those of the numbers that a run has.
#[test]
fn every_number_of_the_metrics_can_be_sought() {
    let mut job = request(json!(null));
    for (field, value) in [("kind", json!("simulation")), ("settle_s", json!(0.002)), ("duration_s", json!(0.004))] {
        job[field] = value;
    }
    job["scene"]["operation"]["axial_load_n"] = json!(12);
    job["scene"]["lubricant"] = json!({ "kind": "oil" });
    for field in ["axes", "metric"] {
        job.as_object_mut().unwrap().remove(field);
    }
    let mut names = BTreeSet::new();
    collect(&metrics_of(&job), String::new(), &mut names);
    // With surfaces there are envelopes at the rates of defects, and balls off their raceways.
    job["scene"]["surfaces"] = json!({ "outer": { "defects": [{ "length_mm": 0.2, "depth_um": 1 }] } });
    collect(&metrics_of(&job), String::new(), &mut names);
    assert!(names.contains("/channels/spindle.y.acceleration/envelope/ball_pass_outer/first_over_rms"), "{names:?}");
    let is_result = |name: &String| {
        ["/channels/", "/contacts/", "/kinematics/", "/cage/"].iter().any(|group| name.starts_with(group))
    };
    names.retain(is_result);
    // How sure a level is belongs to the run, not to the bearing.
    names.retain(|name| !name.ends_with("level_error_db") && !name.ends_with("level_scatter_db"));
    assert!(names.len() > 60, "{names:?}");
    for name in names {
        let mut input = serde_json::from_value(with("metric", json!(name))).unwrap();
        let mut defaults = Defaults::default();
        Objective::of(&mut input, &mut defaults);
        assert!(defaults.errors.is_empty(), "{name}: {:?}", defaults.errors);
    }
}

fn metrics_of(job: &Value) -> Value {
    let Ok(Outcome::Simulation(simulated)) = execute(&parsed(job), &QUIET) else { panic!("{job}") };
    let PointEnd::Succeeded(metrics) = PointEnd::of(&simulated.metrics) else { panic!() };
    metrics
}

fn collect(value: &Value, at: String, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => fields.iter().for_each(|(key, field)| collect(field, format!("{at}/{key}"), names)),
        Value::Number(_) => drop(names.insert(at)),
        _ => {}
    }
}

/// The level of a spindle by the periodic rung over its mass: heavier is calmer, so that the best lies at the end.
#[test]
fn the_optimum_is_the_best_run_and_tells_how_well_it_is_known() {
    let mut request = with("solver", json!({ "rung": "periodic" }));
    request["scene"]["operation"] = json!({ "speed_rpm": 30000, "radial_load_y_n": 100 });
    let mut shares = std::sync::Mutex::new(Vec::new());
    let progress = |share: f64| shares.lock().unwrap().push(share);
    let outcome = execute(&parsed(&request), &Control { progress: &progress, ..Control::until(&|| false) });
    let Ok(Outcome::Optimum(answer)) = outcome else { panic!("{outcome:?}") };
    let values: Vec<f64> = answer.evaluations.iter().filter_map(|run| run.value).collect();
    assert_eq!(answer.value, values.iter().copied().fold(f64::INFINITY, f64::min));
    // Where the periodic motion is unstable there is no answer.
    let refused = answer.evaluations.iter().filter(|run| run.failure.is_some()).count() as u64;
    assert_eq!((answer.runs, answer.failed), (answer.evaluations.len() as u64, refused));
    assert_eq!(answer.metrics.pointer(LEVEL).and_then(Value::as_f64), Some(answer.value));
    assert_eq!(answer.evaluations.iter().filter(|run| run.purpose == PurposeName::Scan).count(), 17);
    let mass = answer.point["/spindle/mass_kg"].as_f64().unwrap();
    let [low, high] = answer.within.as_ref().unwrap()["/spindle/mass_kg"];
    assert!(low <= mass && mass <= high && high - low < 0.18, "{low} {mass} {high}");
    let shares = shares.get_mut().unwrap();
    assert!(shares.windows(2).all(|pair| pair[0] < pair[1]) && shares.iter().all(|share| *share <= 1.0));
    let again = found(&request);
    let timeless = |answer: &OptimumAnswer| (answer.point.clone(), answer.value, answer.within.clone(), answer.runs);
    assert_eq!(timeless(&answer), timeless(&again));
    let picture = crate::plots::draw::optimum(&answer);
    assert!(picture.contains("Minimum of") && picture.contains("mass in kg"));
}

/// A maximum over two axes, of a metric whose error nobody estimates.
#[test]
fn without_an_error_no_band_is_told() {
    let mut request = request(json!([
        { "path": "/operation/radial_load_y_n", "from": 50, "to": 100 },
        { "path": "/spindle/mass_kg", "from": 0.05, "to": 0.2, "scale": "log" },
    ]));
    request["metric"] = json!("/channels/spindle.y.displacement/peak");
    request["goal"] = json!("maximum");
    request["solver"] = json!({ "rung": "periodic" });
    let answer = found(&request);
    assert_eq!((answer.goal, &answer.within, answer.error), (GoalName::Maximum, &None, None));
    assert!(answer.rivals.is_empty() && answer.axes.len() == 2);
    assert!(crate::plots::draw::optimum(&answer).contains("radial load y in N"));
}

#[test]
fn where_no_run_succeeds_the_job_fails_and_a_stop_ends_it() {
    let mut hopeless = with("metric", json!("/contacts/inner/min_film_thickness_um"));
    hopeless["scene"]["lubricant"] = json!("dry");
    hopeless["settle_s"] = json!(0.001);
    hopeless["duration_s"] = json!(0.001);
    let failure = execute(&parsed(&hopeless), &QUIET).map(|_| ()).unwrap_err().to_string();
    assert!(
        failure.contains("no-metric: none of 17 runs has the metric /contacts/inner/min_film_thickness_um"),
        "{failure}"
    );
    let stopped = execute(&parsed(&with("goal", json!("minimum"))), &Control::until(&|| true));
    assert_eq!(stopped.map(|_| ()).unwrap_err().to_string(), "cancelled");
}

/// Radial loads y + z = x + u, u uniform ± ½: the narrow valley at 0 is best without scatter, the wide one at 3 with it.
fn robust(statistic: Value) -> Value {
    let mut request = request(json!([{ "path": "/operation/radial_load_y_n", "from": -2, "to": 4 }]));
    request["inputs"] = json!([{ "path": "/operation/radial_load_z_n",
        "distribution": { "type": "uniform", "from": -0.5, "to": 0.5 } }]);
    request["statistic"] = statistic;
    request
}

fn with_valleys(request: &Value) -> OptimumAnswer {
    let Job::Optimum(search) = parsed(request) else { panic!("another kind") };
    let level = |point: Result<crate::contract::Simulation, crate::contract::Refusal>| {
        let operation = point.unwrap().scene_json()["operation"].take();
        let z = operation["radial_load_y_n"].as_f64().unwrap() + operation["radial_load_z_n"].as_f64().unwrap();
        let level = (20.0 * z.abs()).min(4.0 + (z - 3.0).abs());
        Some(PointEnd::Succeeded(
            json!({ "channels": { "spindle.y.acceleration": { "level_db": level, "level_error_db": 1e-3 } } }),
        ))
    };
    OptimumAnswer::of(&search, &level, &QUIET).unwrap()
}

#[test]
fn a_robust_optimum_avoids_a_narrow_valley() {
    let at = |answer: &OptimumAnswer| answer.point["/operation/radial_load_y_n"].as_f64().unwrap();
    let mut plain = robust(json!("mean"));
    for field in ["inputs", "statistic"] {
        plain.as_object_mut().unwrap().remove(field);
    }
    let nominal = with_valleys(&plain);
    assert!(
        at(&nominal).abs() < 0.05 && nominal.repeated.is_empty() && nominal.statistic.is_none(),
        "{}",
        at(&nominal)
    );
    let found = with_valleys(&robust(json!({ "percentile": 90 })));
    assert!((at(&found) - 3.0).abs() < 0.05, "{}", at(&found));
    assert!(
        (found.value - 4.45).abs() < 0.03 && found.error.is_some_and(|error| error < 0.1),
        "{} {:?}",
        found.value,
        found.error
    );
    assert!((found.nominal.unwrap() - 4.0).abs() < 0.08, "{:?}", found.nominal);
    assert!(!found.repeated.is_empty() && found.repeated.len() <= 3);
    let runs = 32 * found.evaluations.len() + 256 * found.repeated.len() + 1;
    assert_eq!(found.runs, runs as u64);
    let within = found.within.unwrap()["/operation/radial_load_y_n"];
    assert!(within[0] < 2.95 && within[1] > 3.05 && within[0] > 2.0, "{within:?}");
    // The mean of the narrow valley is 4.54, that of the wide one 4 + 1/4.
    let mean = with_valleys(&robust(json!("mean")));
    assert!((at(&mean) - 3.0).abs() < 0.1 && (mean.value - 4.25).abs() < 0.02, "{} {}", at(&mean), mean.value);
}

#[test]
fn wrong_statistics_and_inputs_of_an_optimum_are_refused() {
    let mut without = robust(json!("mean"));
    without.as_object_mut().unwrap().remove("inputs");
    assert!(refused(&without).contains("/statistic: `optimum` takes it with `inputs` only"));
    assert!(refused(&robust(json!({ "percentile": 99.5 }))).contains("/statistic/percentile: 99.5"));
    assert!(refused(&robust(json!("median"))).contains("/statistic"));
    let mut twice = robust(json!("mean"));
    twice["inputs"][0]["path"] = json!("/operation/radial_load_y_n");
    assert!(refused(&twice).contains("/inputs/0: `/operation/radial_load_y_n` is already varied"));
    let mut many = robust(json!("mean"));
    many["samples"] = json!(100);
    assert!(refused(&many).contains("/samples: 100: must be a power of two"));
    many["samples"] = json!(32);
    many["design"] = json!("sobol");
    assert!(refused(&many).contains("/design: goes with the kind `uncertainty`"));
    assert_ne!(parsed(&robust(json!("mean"))).canonical(), parsed(&robust(json!({ "percentile": 90 }))).canonical());
}
