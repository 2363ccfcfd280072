//! What stderr tells of a run: an estimate, then how far it is.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use crate::contract::{self, Job};

/// How often one line is drawn anew on a terminal, and how often a line is written elsewhere.
const REDRAWN: Duration = Duration::from_millis(200);
const WRITTEN: Duration = Duration::from_secs(5);
/// Shares below this tell nothing of the time to go.
const LEAST_SHARE: f64 = 0.02;

/// Runs `work`, which tells its progress, 0–1, to what it is given; quietly, or with an estimate and the progress on stderr. A
/// thread of its own looks at the progress, so that writing takes no time from the run.
pub fn shown<T>(job: &Job, quiet: bool, work: impl FnOnce(&dyn Fn(f64)) -> T) -> T {
    announced(|| announcement(job), quiet, work)
}

/// The same with an announcement of its own.
pub fn announced<T>(announcement: impl FnOnce() -> String, quiet: bool, work: impl FnOnce(&dyn Fn(f64)) -> T) -> T {
    if quiet {
        return work(&|_| ());
    }
    let terminal = std::io::stderr().is_terminal();
    say(&format!("{}\n", announcement()));
    let share = AtomicU64::new(0);
    let begin = Instant::now();
    let (ended, end) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            // The channel closes at the end, also where the work panics.
            let end = end;
            while end.recv_timeout(if terminal { REDRAWN } else { WRITTEN }) == Err(RecvTimeoutError::Timeout) {
                let line = line(f64::from_bits(share.load(Ordering::Relaxed)), begin.elapsed());
                say(&if terminal { format!("\r{line:<50}") } else { format!("{line}\n") });
            }
            if terminal {
                say(&format!("\r{:<50}\r", ""));
            }
        });
        let done = work(&|done| share.store(done.clamp(0.0, 1.0).to_bits(), Ordering::Relaxed));
        drop(ended);
        done
    })
}

/// What will be done, and about how long that takes.
fn announcement(job: &Job) -> String {
    let simulated = format!("{} s after {} s", job.base().settings.duration, job.base().settings.settle);
    let cost = contract::estimate(job);
    let (kind, estimate) = (job.kind().name(), estimated(cost.estimated_wall_time_s, cost.most_wall_time_s));
    match job {
        Job::Study(study) if study.points > 1 => {
            format!("{kind}: {} points of {simulated}; {estimate} for each", study.points)
        }
        Job::Optimum(search) => {
            format!("{kind}: up to about {} runs of {simulated}; {estimate} for each", search.most_runs())
        }
        Job::Accuracy(comparison) => {
            let plan = &comparison.plan;
            let (runs, times) = (plan.methods.len() * plan.relative_tolerances.len(), times(plan.repetitions));
            format!("{kind}: {simulated}, {runs} runs{times} and their references; {estimate}")
        }
        Job::Simulation(_) | Job::Study(_) => format!("{kind}: {simulated}; {estimate}"),
    }
}

/// An estimate [s] in words, with what it may become.
fn estimated(estimate: Option<f64>, most: Option<f64>) -> String {
    match (estimate, most) {
        (Some(estimate), Some(most)) if most > estimate => format!(
            "estimated to an order of magnitude: {}, up to {} where models or tolerances do not serve at once",
            duration(estimate),
            duration(most)
        ),
        (Some(estimate), _) => format!("estimated to an order of magnitude: {}", duration(estimate)),
        _ => "no estimate: no equilibrium to start from".to_owned(),
    }
}

fn times(repetitions: u32) -> String {
    if repetitions == 1 { String::new() } else { format!(" of {repetitions} repetitions") }
}

fn line(share: f64, gone: Duration) -> String {
    let gone = gone.as_secs_f64();
    let percent = (100.0 * share).floor();
    let to_go = if share >= LEAST_SHARE {
        format!(", about {} to go", duration(gone * (1.0 - share) / share))
    } else {
        String::new()
    };
    format!("{percent:3.0} %, {} gone{to_go}", duration(gone))
}

/// A time [s] as people say it.
fn duration(time: f64) -> String {
    match time {
        0.0 => "0 s".into(),
        0.0..0.01 => "less than 0.01 s".into(),
        0.01..0.1 => format!("{time:.2} s"),
        0.1..10.0 => format!("{time:.1} s"),
        10.0..120.0 => format!("{time:.0} s"),
        120.0..7200.0 => format!("{:.0} min", time / 60.0),
        7200.0..172_800.0 => format!("{:.0} h", time / 3600.0),
        _ => format!("{:.0} days", time / 86_400.0),
    }
}

/// Nobody may be there to read it: a closed stderr is no reason to end a run.
fn say(text: &str) {
    let mut stderr = std::io::stderr().lock();
    let _ = stderr.write_all(text.as_bytes()).and_then(|()| stderr.flush());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_tells_the_time_to_go_once_it_is_known() {
        assert_eq!(line(0.0, Duration::from_secs(1)), "  0 %, 1.0 s gone");
        assert_eq!(line(0.25, Duration::from_secs(30)), " 25 %, 30 s gone, about 90 s to go");
        assert_eq!(line(1.0, Duration::from_secs(600)), "100 %, 10 min gone, about 0 s to go");
    }

    #[test]
    fn the_announcement_has_times_runs_and_an_estimate() {
        let scene = br#"{"bearing":"608","operation":{"speed_rpm":3000}}"#;
        let told = announcement(&contract::parse_accuracy_request(scene, Some(5)).unwrap());
        assert!(
            told.starts_with("accuracy: 0.02 s after 0.02 s, 25 runs of 5 repetitions and their references; "),
            "{told}"
        );
        assert!(told.contains("estimated "), "{told}");
        let told = announcement(&contract::parse_job_or_scene(scene).unwrap());
        assert!(told.starts_with("simulation: ") && !told.contains("runs"), "{told}");
        // What it may become is told, too, and nothing takes no time at all.
        assert!(told.contains(", up to ") && !told.contains(" 0 s"), "{told}");
    }
}
