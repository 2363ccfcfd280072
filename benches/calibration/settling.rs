//! Has the initial transient decayed after the default `settle_s`, and after three cage turns alone?
//!
//! Bearings, loads, spindles (light to heavy) and balance grades are drawn at random. Each scene runs on `radially_condensed`.
//! `chosen` lets the program choose the model. `axial` does that under an axial load of a third to three times the radial
//! one, and compares the levels of x, too.
//!
//! The reference is the mean level of `WINDOWS` later windows. The first of them begins after `LATER` decay times of the
//! spindle's free vibration. The level error is the deviation beyond the widest of these windows, because settling does not
//! remove the scatter among them. Levels below `QUIET` count as `QUIET`.
//!
//! A deviation counts as stated where it lies within `SIGMAS` times the larger of `level_error_db` and `level_scatter_db`,
//! combined with the standard error of the reference. Two scenes run at a time.

use std::time::Instant;

use raceway::contract::{ChannelAnswer, Metrics, Outcome, execute, parse_job, scene_from_json};
use raceway::simulation::input::control::Control;
use raceway::simulation::solve::startup::decay_rate;
use serde_json::{Value, json};

use crate::draw::{Draw, has, seed_and_count};
use crate::threads::in_parallel;
use crate::warns;

const SCENES: usize = 100;
const WINDOWS: usize = 4;
const LATER: f64 = 6.0;
/// Earliest and latest start of the first later window [s].
const FIRST: [f64; 2] = [2.0, 20.0];
const CHANNELS: [&str; 3] = ["spindle.x.acceleration", "spindle.y.acceleration", "spindle.z.acceleration"];
/// Level that counts as silence [dB]: 10⁻⁵ m/s².
const QUIET: f64 = -60.0;
/// Range of the axial load over the radial load [-].
const AXIAL: [f64; 2] = [0.33, 3.0];
/// A level is covered where it deviates by at most this many times what the result states [-].
const SIGMAS: f64 = 3.0;
/// Deviations that are counted [dB].
const COUNTED: [f64; 3] = [0.05, 0.2, 1.0];

fn drawn_scene(draw: &mut Draw, axial: bool) -> Value {
    let preset = draw.one_of(&["article-integrated", "608", "article-deep-groove", "6204", "6205"]);
    let (mass, speed) = if preset.starts_with("62") {
        (draw.between_decades(0.2, 10.0), draw.between_decades(1e3, 1.5e4))
    } else {
        (draw.between_decades(0.03, 1.0), draw.between_decades(3e3, 6e4))
    };
    let mut spindle = json!({ "mass_kg": mass });
    if let Some(grade) = draw.one_of(&[Some(0.4), Some(2.5), Some(6.3), None, None, None]) {
        spindle["balance_grade"] = grade.into();
    }
    let radial = draw.between_decades(10.0, 500.0);
    let mut operation = json!({ "speed_rpm": speed, "radial_load_y_n": radial });
    if axial {
        operation["axial_load_n"] = draw.between_decades(AXIAL[0] * radial, AXIAL[1] * radial).into();
    }
    json!({ "bearing": { "preset": preset }, "operation": operation, "spindle": spindle })
}

/// Levels of x, y and z [dB] of a run, their stated errors and scatter [dB], and its settling and recorded time [s].
struct Run {
    levels: [f64; 3],
    errors: [f64; 3],
    scatter: [f64; 3],
    warns: bool,
    seconds: f64,
    settled: f64,
    kept: f64,
}

fn simulate(scene: &Value, rung: Option<&str>, settle: Option<f64>) -> Result<Run, String> {
    let mut job = json!({ "kind": "simulation", "scene": scene, "outputs": { "metrics": ["vibration"] } });
    if let Some(rung) = rung {
        job["solver"] = json!({ "rung": rung });
    }
    if let Some(settle) = settle {
        job["settle_s"] = settle.into();
    }
    let job = parse_job(job.to_string().as_bytes()).map_err(|refusal| refusal.to_string())?;
    let settings = job.base().ok_or("not a simulation")?.settings.clone();
    let of = |metrics: &Metrics, value: fn(&ChannelAnswer) -> Option<f64>| {
        let channels = metrics.channels.as_ref();
        CHANNELS.map(|name| channels.and_then(|all| value(all.get(name)?)).unwrap_or(f64::NAN))
    };
    let begin = Instant::now();
    match execute(&job, &Control::until(&|| false)) {
        Ok(Outcome::Simulation(outcome)) => Ok(Run {
            levels: of(&outcome.metrics, |channel| channel.level_db).map(|level| level.max(QUIET)),
            errors: of(&outcome.metrics, |channel| channel.level_error_db),
            scatter: of(&outcome.metrics, |channel| channel.level_scatter_db),
            warns: warns(&outcome.metrics),
            seconds: begin.elapsed().as_secs_f64(),
            settled: settings.settle,
            kept: settings.duration,
        }),
        Ok(_) => Err("not a simulation".to_owned()),
        Err(error) => Err(format!("{error:?}")),
    }
}

/// Deviation of the levels of a scene from the reference, and scatter of the later windows [dB].
struct Compared {
    after_turns: f64,
    after_default: f64,
    scatter: f64,
    /// Whether the run with the default `settle_s` deviates by more than its error covers, and by more than error and scatter cover.
    beyond_error: bool,
    beyond_both: bool,
    /// True where the result carries a warning.
    warns: bool,
    /// Wall time with three cage turns, and with the default `settle_s` [s].
    seconds: [f64; 2],
    line: String,
}

fn compare(scene: &Value, rung: Option<&str>) -> Result<Compared, String> {
    let rate = decay_rate(&scene_from_json(&scene.to_string()).map_err(|refusal| refusal.to_string())?)
        .ok_or("nothing decays")?;
    let default = simulate(scene, rung, None)?;
    // Three cage turns. The cage turns at 0.38 to 0.4 of the shaft speed in these bearings.
    let hertz = scene["operation"]["speed_rpm"].as_f64().ok_or("no speed")? / 60.0;
    let turns = simulate(scene, rung, Some((3.0 / (0.39 * hertz)).max(0.02)))?;
    let first = (LATER / rate).clamp(FIRST[0], FIRST[1]);
    let later: Vec<Run> = (0..WINDOWS)
        .map(|window| simulate(scene, rung, Some(first + 1.37 * window as f64 * default.kept)))
        .collect::<Result<_, _>>()?;
    let mean = |axis: usize| later.iter().map(|run| run.levels[axis]).sum::<f64>() / WINDOWS as f64;
    let reference = [0, 1, 2].map(mean);
    let off = |run: &Run| (0..3).map(|axis| (run.levels[axis] - reference[axis]).abs()).fold(0.0, f64::max);
    let scatter = later.iter().map(off).fold(0.0, f64::max);
    let beyond = |run: &Run| (off(run) - scatter).max(0.0);
    let standard_error = |axis: usize| {
        let squares = later.iter().map(|run| (run.levels[axis] - reference[axis]).powi(2)).sum::<f64>();
        (squares / (WINDOWS * (WINDOWS - 1)) as f64).sqrt()
    };
    let beyond_stated = |stated: [f64; 3]| {
        (0..3).any(|axis| {
            let apart = (default.levels[axis] - reference[axis]).abs();
            apart > COUNTED[0] && apart > SIGMAS * stated[axis].max(0.0).hypot(standard_error(axis))
        })
    };
    let both = [0, 1, 2].map(|axis| default.errors[axis].max(default.scatter[axis]));
    let (beyond_error, beyond_both) = (beyond_stated(default.errors), beyond_stated(both));
    let line = format!(
        "{}{:.3} s: {:.2} dB; default {:.3} s ({:.1} decay times): {:.2} dB; error and scatter {both:.2?} dB; scatter of the later windows {scatter:.2} dB; {scene}",
        if beyond_both { "deviation larger than stated: " } else { "" },
        turns.settled,
        off(&turns),
        default.settled,
        rate * default.settled,
        off(&default),
    );
    Ok(Compared {
        after_turns: beyond(&turns),
        after_default: beyond(&default),
        scatter,
        beyond_error,
        beyond_both,
        warns: default.warns,
        seconds: [turns.seconds, default.seconds],
        line,
    })
}

pub fn run(words: &[String]) {
    let axial = has(words, "axial");
    let rung = if axial || has(words, "chosen") { None } else { Some("radially_condensed") };
    let (seed, count) = seed_and_count(words, SCENES);
    let mut draw = Draw::new(seed);
    let scenes: Vec<Value> = (0..count).map(|_| drawn_scene(&mut draw, axial)).collect();
    let all = in_parallel(2, scenes.len(), |number| compare(&scenes[number], rung));
    let (mut compared, mut failed) = (Vec::new(), 0);
    for (number, one) in all.into_iter().enumerate() {
        match one {
            Ok(one) => {
                println!("{number:3} {}", one.line);
                compared.push(one);
            }
            Err(reason) => {
                println!("{number:3} {reason}");
                failed += 1;
            }
        }
    }
    println!("{} scenes, {failed} more without a comparison", compared.len());
    for limit in COUNTED {
        let over = |of: fn(&Compared) -> f64| compared.iter().filter(|one| of(one) > limit).count();
        let scattering = compared.iter().filter(|one| one.after_default > limit && one.scatter > limit).count();
        println!(
            "more than {limit} dB off: {} after three cage turns, {} after the default time, {scattering} of these with later windows that scatter by more",
            over(|one| one.after_turns),
            over(|one| one.after_default),
        );
    }
    let count = |of: fn(&Compared) -> bool| compared.iter().filter(|one| of(one)).count();
    println!(
        "off by more than {SIGMAS} times the stated error: {}; more than {SIGMAS} times error and scatter: {}, {} of these without a warning",
        count(|one| one.beyond_error),
        count(|one| one.beyond_both),
        count(|one| one.beyond_both && !one.warns),
    );
    for (when, of) in ["three cage turns", "default time"].into_iter().enumerate() {
        let seconds: Vec<f64> = compared.iter().map(|one| one.seconds[when]).collect();
        let (all, most) = (seconds.iter().sum::<f64>(), seconds.iter().copied().fold(0.0, f64::max));
        println!("{of}: {all:.1} s in total, {most:.2} s at most");
    }
}
