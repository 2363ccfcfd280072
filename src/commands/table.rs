//! Results as text for people.

use std::fmt::Write;

use serde_json::Value;

use crate::contract::WorkPrecisionAnswer;
use crate::contract::work_precision::{MeasuredAnswer, PointAnswer, ReferenceAnswer};

/// What the table shows: name, pointer into the metrics, unit, digits.
const ROWS: [(&str, &str, &str, usize); 16] = [
    ("acceleration level, Y", "/channels/spindle.y.acceleration/level_db", "dB", 2),
    ("acceleration level, Z", "/channels/spindle.z.acceleration/level_db", "dB", 2),
    ("acceleration, rms, Y", "/channels/spindle.y.acceleration/rms", "m/s²", 3),
    ("acceleration, peak, Y", "/channels/spindle.y.acceleration/peak", "m/s²", 3),
    ("velocity, rms, Y", "/channels/spindle.y.velocity/rms", "mm/s", 4),
    ("velocity, rms, Z", "/channels/spindle.z.velocity/rms", "mm/s", 4),
    ("largest load, inner raceway", "/contacts/inner/max_load_n", "N", 1),
    ("largest load, outer raceway", "/contacts/outer/max_load_n", "N", 1),
    ("largest pressure, inner raceway", "/contacts/inner/max_pressure_mpa", "MPa", 0),
    ("largest pocket load", "/contacts/pocket/max_load_n", "N", 2),
    ("cage speed", "/kinematics/cage_speed_hz", "Hz", 2),
    ("cage slip", "/kinematics/cage_slip", "", 5),
    ("orbit of the cage, rms", "/cage/orbit_radius_um", "µm", 2),
    ("error of the level", "/accuracy/level_error_db", "dB", 2),
    ("steps", "/solver/steps", "", 0),
    ("wall time", "/solver/wall_time_s", "s", 2),
];

/// Metrics of several jobs side by side.
pub fn metrics(jobs: &[(&str, Value)]) -> String {
    let mut text = format!("{:<34}", "");
    for (name, _) in jobs {
        let _ = write!(text, "{name:>22}");
    }
    for (name, pointer, unit, digits) in ROWS {
        let _ = write!(text, "\n{name:<34}");
        for (_, job) in jobs {
            let value = job["metrics"].pointer(pointer).and_then(Value::as_f64);
            let value = value.map_or("–".to_owned(), |value| format!("{value:.digits$}"));
            let _ = write!(text, "{value:>22}");
        }
        let _ = write!(text, " {unit}");
    }
    text.push('\n');
    text
}

/// Lines that are shown of a channel.
const LINES: usize = 6;

/// The strongest labelled lines of a job.
pub fn lines(name: &str, job: &Value) -> String {
    let mut text = format!("Lines, {name}:\n");
    let lines = job["metrics"]["lines"].as_array().map(Vec::as_slice).unwrap_or_default();
    let mut shown: Vec<(&str, usize)> = Vec::new();
    for line in lines.iter().filter(|line| line["label"] != "") {
        let channel = line["channel"].as_str().unwrap_or_default();
        match shown.iter_mut().find(|(name, _)| *name == channel) {
            Some((_, count)) if *count == LINES => continue,
            Some((_, count)) => *count += 1,
            None => shown.push((channel, 1)),
        }
        let number = |field: &str| line[field].as_f64().unwrap_or(f64::NAN);
        let (frequency, amplitude, deviation) = (number("frequency_hz"), number("amplitude"), number("deviation_hz"));
        let label = line["label"].as_str().unwrap_or_default();
        let off = if deviation.abs() < 0.05 { String::new() } else { format!(" ({deviation:+.1} Hz)") };
        let _ = writeln!(text, "  {channel:<24}{frequency:>10.1} Hz {amplitude:>12.4e} m/s²   {label}{off}");
    }
    text
}

/// Error against run time: what is compared, a row a point, and what the marks mean.
pub fn work_precision(answer: &WorkPrecisionAnswer) -> String {
    let (compared, timing) = (&answer.compared, &answer.timing);
    let mut text = format!(
        "{} s after {} s, {} states ({}); motion {}, divergence rate {:.0} 1/s\n{}\n",
        compared.duration_s,
        compared.settle_s,
        compared.states,
        compared.rung,
        compared.motion.map_or("unknown".to_owned(), |motion| format!("{motion:?}").to_lowercase()),
        compared.divergence_rate_per_s,
        reference_line(&answer.reference),
    );
    let _ = writeln!(
        text,
        "\n{:<16}{:>8}{:>13}{:>13}{:>10}{:>18}{:>10}{:>10}{:>9}{:>11}{:>8}{:>8}  status",
        "method",
        "rtol",
        "error [dB]",
        "trajectory",
        "time [s]",
        "range",
        "cpu [s]",
        "steps",
        "rejected",
        "rhs",
        "jac",
        "lu"
    );
    for point in &answer.points {
        let row = match point {
            PointAnswer::Succeeded(point) => measured_row(point),
            PointAnswer::Failed(point) => {
                let time = point.wall_time_s.map_or("–".to_owned(), |time| format!("{time:.4}"));
                format!("{:>13}{:>13}{time:>10}{:>74}  failed: {}", "–", "–", "", point.reason)
            }
        };
        let _ = writeln!(text, "{:<16}{:>8e}{row}", point.method(), point.relative_tolerance());
    }
    let _ = writeln!(
        text,
        "\n* below ten times the reference's own error, or below the sampling error: says nothing\n\
         time: median and range of {}, one thread; inside: {}; outside: {}",
        timing.repetitions, timing.inside, timing.outside
    );
    text
}

fn reference_line(reference: &ReferenceAnswer) -> String {
    let number = |value: Option<f64>| value.map_or("unknown".to_owned(), |value| format!("{value:.2e}"));
    let sampling =
        reference.sampling_error_db.map_or(String::new(), |error| format!("; sampling error {error:.2e} dB"));
    let check = match (&reference.check_method, reference.check_relative_tolerance) {
        (Some(method), Some(tolerance)) => format!(" (against {method} at {tolerance:e})"),
        _ => String::new(),
    };
    format!(
        "reference {} at {:e}; its own error{check}: {} dB, trajectory {}{sampling}",
        reference.method,
        reference.relative_tolerance,
        number(reference.own_error_db),
        number(reference.own_trajectory_error)
    )
}

fn measured_row(point: &MeasuredAnswer) -> String {
    let error = |value: Option<f64>, says_nothing: bool| {
        let mark = if says_nothing { "*" } else { " " };
        value.map_or("– ".to_owned(), |value| format!("{value:.2e}{mark}"))
    };
    let range: Vec<String> = point.wall_time_range_s.iter().map(|time| format!("{time:.4}")).collect();
    let ran = if point.ran == point.method { String::new() } else { format!(" (ran {})", point.ran) };
    format!(
        "{:>13}{:>13}{:>10.4}{:>18}{:>10}{:>10}{:>9}{:>11}{:>8}{:>8}  succeeded{ran}",
        error(point.level_error_db, point.level_below_reference),
        error(point.trajectory_error, point.below_reference),
        point.wall_time_s,
        range.join("–"),
        point.processor_time_s.map_or("–".to_owned(), |time| format!("{time:.4}")),
        point.steps,
        point.rejected_steps,
        point.rhs_evaluations,
        point.jacobian_evaluations,
        point.factorizations
    )
}
