//! Does a run settle by itself? Levels after the default `settle_s`, and after three turns of the cage alone, beside those long after.
//!
//! `cargo bench --bench settling [-- SEED COUNT [chosen|axial]]` draws bearings, loads, spindles (from those that hardly count to heavy ones) and
//! balance grades, and runs each on `radially_condensed`; `chosen`: on the rung that is chosen; `axial`: that, under a load along the axis, a third
//! to three times as much as across it, levels of x too. Levels below `QUIET` count as so much. Right is the mean of `WINDOWS` later windows, the first after `LATER` times of decay of
//! the spindle's free vibration, the same for both; a level is off by what lies beyond the widest of these windows, for what they scatter
//! by no settling takes away. It counts as told of where it is
//! within `SIGMAS` times what the result states of it: `level_error_db` or `level_scatter_db`, whichever is more, beside the error of the
//! mean itself. Two scenes at a time; the same seed gives the same lines.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use raceway::contract::{ChannelAnswer, Metrics, Outcome, execute, parse_job, scene_from_json};
use raceway::simulation::input::control::Control;
use raceway::simulation::solve::startup::decay_rate;
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};
use serde_json::{Value, json};

const SCENES: u64 = 100;
const WINDOWS: usize = 4;
const LATER: f64 = 6.0;
/// The first of the later windows comes within these [s].
const FIRST: [f64; 2] = [2.0, 20.0];
const CHANNELS: [&str; 3] = ["spindle.x.acceleration", "spindle.y.acceleration", "spindle.z.acceleration"];
/// [dB]: 10⁻⁵ m/s².
const QUIET: f64 = -60.0;
/// The axial load over the radial one.
const AXIAL: [f64; 2] = [0.33, 3.0];
/// Times of what is stated within which a level is told of.
const SIGMAS: f64 = 3.0;
/// Levels off by more are counted [dB].
const COUNTED: [f64; 3] = [0.05, 0.2, 1.0];

struct Draw(SplitMix64);

impl Draw {
    fn share(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Three digits, evenly between the logarithms of two ends.
    fn between_decades(&mut self, from: f64, to: f64) -> f64 {
        format!("{:.2e}", from * (to / from).powf(self.share())).parse().expect("a number")
    }

    fn scene(&mut self, axial: bool) -> Value {
        let presets = ["article-integrated", "608", "article-deep-groove", "6204", "6205"];
        let preset = presets[(self.share() * presets.len() as f64) as usize];
        let (mass, speed) = if preset.starts_with("62") {
            (self.between_decades(0.2, 10.0), self.between_decades(1e3, 1.5e4))
        } else {
            (self.between_decades(0.03, 1.0), self.between_decades(3e3, 6e4))
        };
        let mut spindle = json!({ "mass_kg": mass });
        let grades = [Some(0.4), Some(2.5), Some(6.3), None, None, None];
        if let Some(grade) = grades[(self.share() * grades.len() as f64) as usize] {
            spindle["balance_grade"] = grade.into();
        }
        let radial = self.between_decades(10.0, 500.0);
        let mut operation = json!({ "speed_rpm": speed, "radial_load_y_n": radial });
        if axial {
            operation["axial_load_n"] = self.between_decades(AXIAL[0] * radial, AXIAL[1] * radial).into();
        }
        json!({ "bearing": { "preset": preset }, "operation": operation, "spindle": spindle })
    }
}

/// A run: its levels of x, y and z [dB], their stated errors and scatter, and the times it settled and kept [s].
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
            warns: outcome.metrics.accuracy.warning.is_some(),
            seconds: begin.elapsed().as_secs_f64(),
            settled: job.base().settings.settle,
            kept: job.base().settings.duration,
        }),
        Ok(_) => Err("not a simulation".to_owned()),
        Err(error) => Err(format!("{error:?}")),
    }
}

/// What the levels of a scene are off by [dB], and what the later windows scatter by.
struct Compared {
    turns: f64,
    default: f64,
    scatter: f64,
    /// Whether by itself it is off by more than its error tells, and than error and scatter tell.
    beyond_error: bool,
    beyond_both: bool,
    /// Whether it warns of itself.
    warns: bool,
    /// What it takes after three turns, and by itself.
    seconds: [f64; 2],
    words: String,
}

fn compare(scene: &Value, rung: Option<&str>) -> Result<Compared, String> {
    let rate = decay_rate(&scene_from_json(&scene.to_string()).map_err(|refusal| refusal.to_string())?)
        .ok_or("nothing decays")?;
    let by_itself = simulate(scene, rung, None)?;
    // Three turns of the cage, which turns with 0.38 to 0.4 of the speed of the shaft in these bearings.
    let hertz = scene["operation"]["speed_rpm"].as_f64().ok_or("no speed")? / 60.0;
    let turns = simulate(scene, rung, Some((3.0 / (0.39 * hertz)).max(0.02)))?;
    let first = (LATER / rate).clamp(FIRST[0], FIRST[1]);
    let later: Vec<Run> = (0..WINDOWS)
        .map(|window| simulate(scene, rung, Some(first + 1.37 * window as f64 * by_itself.kept)))
        .collect::<Result<_, _>>()?;
    let mean = |axis: usize| later.iter().map(|run| run.levels[axis]).sum::<f64>() / WINDOWS as f64;
    let right = [0, 1, 2].map(mean);
    let off = |run: &Run| (0..3).map(|axis| (run.levels[axis] - right[axis]).abs()).fold(0.0, f64::max);
    let scatter = later.iter().map(off).fold(0.0, f64::max);
    let beyond = |run: &Run| (off(run) - scatter).max(0.0);
    // Of a mean of four.
    let of_mean = |axis: usize| {
        let squares = later.iter().map(|run| (run.levels[axis] - right[axis]).powi(2)).sum::<f64>();
        (squares / (WINDOWS * (WINDOWS - 1)) as f64).sqrt()
    };
    let beyond_stated = |stated: [f64; 3]| {
        (0..3).any(|axis| {
            let apart = (by_itself.levels[axis] - right[axis]).abs();
            apart > COUNTED[0] && apart > SIGMAS * stated[axis].max(0.0).hypot(of_mean(axis))
        })
    };
    let both = [0, 1, 2].map(|axis| by_itself.errors[axis].max(by_itself.scatter[axis]));
    let (beyond_error, beyond_both) = (beyond_stated(by_itself.errors), beyond_stated(both));
    let words = format!(
        "{}{:.3} s: {:.2} dB; by itself {:.3} s ({:.1} times of decay): {:.2} dB; error and scatter {both:.2?} dB; later windows scatter by {scatter:.2} dB; {scene}",
        if beyond_both { "beyond what it states: " } else { "" },
        turns.settled,
        off(&turns),
        by_itself.settled,
        rate * by_itself.settled,
        off(&by_itself),
    );
    Ok(Compared {
        turns: beyond(&turns),
        default: beyond(&by_itself),
        scatter,
        beyond_error,
        beyond_both,
        warns: by_itself.warns,
        seconds: [turns.seconds, by_itself.seconds],
        words,
    })
}

fn main() {
    let numbers: Vec<u64> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let asked = |option: &str| std::env::args().any(|word| word == option);
    let axial = asked("axial");
    let rung = if axial || asked("chosen") { None } else { Some("radially_condensed") };
    let (seed, count) = (numbers.first().copied().unwrap_or(1), numbers.get(1).copied().unwrap_or(SCENES));
    let mut draw = Draw(SplitMix64::seed_from_u64(seed));
    let scenes: Vec<Value> = (0..count).map(|_| draw.scene(axial)).collect();
    let (next, all) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(scene) = scenes.get(number) else { break };
                    let compared = compare(scene, rung);
                    all.lock().expect("no thread fails").push((number, compared));
                }
            });
        }
    });
    let mut all = all.into_inner().expect("no thread fails");
    all.sort_by_key(|(number, _)| *number);
    let (mut compared, mut failed) = (Vec::new(), 0);
    for (number, one) in all {
        match one {
            Ok(one) => {
                println!("{number:3} {}", one.words);
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
        let restless = compared.iter().filter(|one| one.default > limit && one.scatter > limit).count();
        println!(
            "more than {limit} dB off: {} after three turns, {} by itself, {restless} of these where the later windows scatter by more than that",
            over(|one| one.turns),
            over(|one| one.default),
        );
    }
    let count = |of: fn(&Compared) -> bool| compared.iter().filter(|one| of(one)).count();
    println!(
        "off by more than {SIGMAS} times its error tells: {} by itself; than error and scatter tell: {}, {} of these without a warning",
        count(|one| one.beyond_error),
        count(|one| one.beyond_both),
        count(|one| one.beyond_both && !one.warns),
    );
    for (when, of) in ["after three turns", "by itself"].into_iter().enumerate() {
        let seconds: Vec<f64> = compared.iter().map(|one| one.seconds[when]).collect();
        let (all, most) = (seconds.iter().sum::<f64>(), seconds.iter().copied().fold(0.0, f64::max));
        println!("{of}: {all:.1} s in all, {most:.2} s at most");
    }
}
