//! Progress of a run on stderr: an estimate of its time, then the finished share.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use raceway_core::machine::mode_precision::ModePlan;

use crate::contract::{self, Job};

/// Time between two updates of the line on a terminal.
const TERMINAL_INTERVAL: Duration = Duration::from_millis(200);
/// Time between two lines in a file or pipe.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// Smallest finished share from which the remaining time is estimated.
const MIN_SHARE: f64 = 0.02;
/// Largest ratio of two remaining times that are told as one, because estimates are good to a factor of about this [-].
const NOTABLE_RATIO: f64 = 2.0;

/// Runs `work`, which passes its progress (0–1) to the given function. Unless `quiet`, an estimate and the progress are written to stderr,
/// by a thread of its own so that writing does not slow the run.
pub fn shown<T>(job: &Job, quiet: bool, work: impl FnOnce(&dyn Fn(f64)) -> T) -> T {
    // Progress of many runs counts points, which take their time with all rejections.
    let most = match job {
        Job::Simulation(_) if !quiet => contract::estimate(job).most_wall_time_s,
        _ => None,
    };
    reported(|| announcement(job), most, quiet, work)
}

/// Runs `work` as `shown`, with another first line.
pub fn announced<T>(announcement: impl FnOnce() -> String, quiet: bool, work: impl FnOnce(&dyn Fn(f64)) -> T) -> T {
    reported(announcement, None, quiet, work)
}

/// `most`: run time [s] of a single run if all its models and tolerances but the last are rejected.
fn reported<T>(
    announcement: impl FnOnce() -> String,
    most: Option<f64>,
    quiet: bool,
    work: impl FnOnce(&dyn Fn(f64)) -> T,
) -> T {
    if quiet {
        return work(&|_| ());
    }
    let terminal = std::io::stderr().is_terminal();
    write_stderr(&format!("{}\n", announcement()));
    let share = AtomicU64::new(0);
    let begin = Instant::now();
    let (ended, end) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            // The channel closes at the end, also after a panic of the work.
            let end = end;
            while end.recv_timeout(if terminal { TERMINAL_INTERVAL } else { LINE_INTERVAL })
                == Err(RecvTimeoutError::Timeout)
            {
                let line = line(f64::from_bits(share.load(Ordering::Relaxed)), begin.elapsed(), most);
                write_stderr(&if terminal { format!("\r{line:<50}") } else { format!("{line}\n") });
            }
            if terminal {
                write_stderr(&format!("\r{:<50}\r", ""));
            }
        });
        let done = work(&|done| share.store(done.clamp(0.0, 1.0).to_bits(), Ordering::Relaxed));
        drop(ended);
        done
    })
}

/// Kind, simulated time and estimated run time of a job.
fn announcement(job: &Job) -> String {
    if let Job::Modes(comparison) = job {
        let ModePlan { duration, ranges, repetitions, .. } = &comparison.plan;
        let (runs, times) = (ranges.len(), times(*repetitions));
        return format!("{}: {duration} s, {runs} runs{times} and their reference", job.kind().name());
    }
    let Some(base) = job.base() else { return job.kind().name().to_owned() };
    let simulated = format!("{} s after {} s", base.settings.duration, base.settings.settle);
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
        Job::Uncertainty(uncertainty) => {
            format!("{kind}: {} points of {simulated}; {estimate} for each", uncertainty.study.points)
        }
        Job::Simulation(_) | Job::Study(_) | Job::Modes(_) | Job::Rotor(_) | Job::Machine(_) => {
            format!("{kind}: {simulated}; {estimate}")
        }
    }
}

/// The estimated run time and its upper value [s] as text.
fn estimated(estimate: Option<f64>, most: Option<f64>) -> String {
    match (estimate, most) {
        (Some(estimate), Some(most)) if most > estimate => format!(
            "estimated to an order of magnitude: {}, up to {} if models or tolerances are rejected",
            duration(estimate),
            duration(most)
        ),
        (Some(estimate), _) => format!("estimated to an order of magnitude: {}", duration(estimate)),
        _ => "no estimate: the static equilibrium was not found".to_owned(),
    }
}

fn times(repetitions: u32) -> String {
    if repetitions == 1 { String::new() } else { format!(" of {repetitions} repetitions") }
}

/// Share, elapsed and remaining time. The remaining time of a single run is that of the candidate at work, up to the rest of `most` [s]: others
/// follow if it is rejected.
fn line(share: f64, elapsed: Duration, most: Option<f64>) -> String {
    let elapsed = elapsed.as_secs_f64();
    let percent = (100.0 * share).floor();
    let least = elapsed * (1.0 - share) / share;
    let to_go = match most.filter(|_| share < 1.0).map(|most| most - elapsed) {
        _ if share < MIN_SHARE => String::new(),
        Some(most) if most > NOTABLE_RATIO * least => format!(", {} to {} to go", duration(least), duration(most)),
        Some(most) if most < least => format!(", at least {} to go", duration(least)),
        _ => format!(", about {} to go", duration(least)),
    };
    format!("{percent:3.0} %, {} gone{to_go}", duration(elapsed))
}

/// A duration [s] as text with a suitable unit.
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

/// Writes to stderr. A closed stderr is no reason to end a run.
fn write_stderr(text: &str) {
    let mut stderr = std::io::stderr().lock();
    let _ = stderr.write_all(text.as_bytes()).and_then(|()| stderr.flush());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_includes_the_remaining_time_once_it_is_known() {
        assert_eq!(line(0.0, Duration::from_secs(1), Some(100.0)), "  0 %, 1.0 s gone");
        assert_eq!(line(0.25, Duration::from_secs(30), None), " 25 %, 30 s gone, about 90 s to go");
        assert_eq!(line(1.0, Duration::from_secs(600), None), "100 %, 10 min gone, about 0 s to go");
        // Other candidates may follow: 6 s of this one, at most 100 s of all. Beyond the estimate no end is known.
        assert_eq!(line(0.4, Duration::from_secs(4), Some(104.0)), " 40 %, 4.0 s gone, 6.0 s to 100 s to go");
        assert_eq!(line(0.4, Duration::from_secs(4), Some(12.0)), " 40 %, 4.0 s gone, about 6.0 s to go");
        assert_eq!(line(0.8, Duration::from_secs(80), Some(60.0)), " 80 %, 80 s gone, at least 20 s to go");
        assert_eq!(line(1.0, Duration::from_secs(4), Some(60.0)), "100 %, 4.0 s gone, about 0 s to go");
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
        // The upper value is included, and no time reads 0 s.
        assert!(told.contains(", up to ") && !told.contains(" 0 s"), "{told}");
    }
}
