//! Results as text tables.

use std::fmt::Write;

use raceway_core::simulation::result::metrics::LEVEL_UNIT;
use serde_json::Value;

use crate::contract::answer::report::MotionName;
use crate::contract::answer::uncertainty::uncertain;
use crate::contract::answer::work_precision::mode_point::ModePointAnswer;
use crate::contract::answer::work_precision::point::{MeasuredAnswer, PointAnswer};
use crate::contract::answer::work_precision::recommended::RECOMMENDED_ERRORS_DB;
use crate::contract::job::input::GoalName;
use crate::contract::{ModePrecisionAnswer, OptimumAnswer, PointStatus, TableAnswer, WorkPrecisionAnswer};

/// Rows of the table of metrics: name, pointer into the metrics, unit, digits.
const ROWS: [(&str, &str, &str, usize); 18] = [
    ("acceleration level, Y", "/channels/spindle.y.acceleration/level_db", LEVEL_UNIT, 2),
    ("acceleration level, Z", "/channels/spindle.z.acceleration/level_db", LEVEL_UNIT, 2),
    ("scatter of the level, Y", "/channels/spindle.y.acceleration/level_scatter_db", "dB", 3),
    ("scatter of the level, Z", "/channels/spindle.z.acceleration/level_scatter_db", "dB", 3),
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
    ("error of the level", "/accuracy/level_error_db", "dB", 5),
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

/// Shortest recorded time for a level [s].
const MIN_LEVEL_TIME_S: f64 = 1e-4;
/// Largest number of printed lines of a channel.
const MAX_LINES: usize = 6;

/// The strongest labelled lines of a job.
pub fn lines(name: &str, job: &Value) -> String {
    let mut text = format!("Lines, {name}:\n");
    let lines = job["metrics"]["lines"].as_array().map(Vec::as_slice).unwrap_or_default();
    let mut shown: Vec<(&str, usize)> = Vec::new();
    for line in lines.iter().filter(|line| line["label"] != "") {
        let channel = line["channel"].as_str().unwrap_or_default();
        match shown.iter_mut().find(|(name, _)| *name == channel) {
            Some((_, count)) if *count == MAX_LINES => continue,
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

/// A number without the `.0` of whole ones.
fn short(value: &Value) -> String {
    value.as_f64().map_or_else(|| value.to_string(), |number| number.to_string())
}

/// Largest number of printed rows of a study; its files have all rows.
const MAX_ROWS: usize = 60;

/// A study: one row for each point, the best points, and whether the trends are resolved.
pub fn study(table: &TableAnswer) -> String {
    const SHOWN: [usize; 9] = [0, 1, 4, 5, 6, 7, 10, 12, 13];
    let mut text = String::new();
    let shown = SHOWN.map(|row| ROWS[row]).into_iter();
    let shown: Vec<_> = shown.filter(|row| table.column(row.1).iter().any(Option::is_some)).collect();
    for (number, axis) in table.axes.iter().enumerate() {
        let _ = writeln!(text, "[{}] {}", number + 1, axis.axis);
    }
    for (letter, (name, _, unit, _)) in ('a'..).zip(&shown) {
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        let _ = writeln!(text, "({letter}) {name}{unit}");
    }
    text.push('\n');
    for number in 1..=table.axes.len() {
        let _ = write!(text, "{:>14}", format!("[{number}]"));
    }
    for (letter, _) in ('a'..).zip(&shown) {
        let _ = write!(text, "{:>12}", format!("({letter})"));
    }
    text.push('\n');
    for row in table.rows.iter().take(MAX_ROWS) {
        for value in table.axes.iter().filter_map(|axis| row.point.get(&axis.axis)) {
            let value = value.as_str().map_or_else(|| short(value), str::to_owned);
            let _ = write!(text, "{value:>14}");
        }
        match (&row.metrics, &row.error) {
            (Some(metrics), _) => {
                for (_, pointer, _, digits) in &shown {
                    // A level that is not resolved is no value.
                    let value = uncertain(metrics, pointer).map(|(value, _)| value);
                    let value = value.map_or("–".to_owned(), |value| format!("{value:.digits$}"));
                    let _ = write!(text, "{value:>12}");
                }
            }
            (None, Some(error)) => {
                let _ = write!(text, "  failed: {}: {}", error.cause, error.detail);
            }
            (None, None) => text.push_str(match row.status {
                PointStatus::Running => "  running",
                PointStatus::Cancelled => "  cancelled",
                _ => "  queued",
            }),
        }
        text.push('\n');
    }
    if table.rows.len() > MAX_ROWS {
        let _ = writeln!(text, "… {} more", table.rows.len() - MAX_ROWS);
    }
    for (name, pointer, unit, digits) in shown {
        let Some(best) = table.best.get(pointer) else { continue };
        let at = table.axes.iter().filter_map(|axis| Some((&axis.axis, best.point.get(&axis.axis)?)));
        let at: Vec<String> = at.map(|(axis, value)| format!("{axis} = {}", short(value))).collect();
        let error = best.error.map_or(String::new(), |error| format!(" ± {error:.1e}"));
        let _ = write!(text, "\nbest {name}: {:.digits$}{error} {unit} at {}", best.value, at.join(", "));
        if let Some(as_good) = best.as_good.filter(|as_good| *as_good > 1) {
            let _ = write!(text, "; {as_good} points may be as good");
        }
        match table.trends.get(pointer).and_then(|trend| trend.resolved) {
            Some(true) => {}
            Some(false) => text.push_str("; the trend is not resolved beyond its error"),
            None => {}
        }
    }
    text.push('\n');
    text
}

/// Largest number of printed runs that may be as good as the optimum; its file has all of them.
const MAX_RIVALS: usize = 5;

/// An optimum: its point, its uncertainty, and runs that may be as good.
pub fn optimum(answer: &OptimumAnswer) -> String {
    let error = answer.error.map_or(String::new(), |error| format!(" ± {error:.1e}"));
    let goal = if answer.goal == GoalName::Minimum { "minimum" } else { "maximum" };
    let mut text = format!("{goal} of {}: {:.5}{error}\n", answer.metric, answer.value);
    for axis in &answer.axes {
        let at = answer.point.get(&axis.axis).map(short).unwrap_or_default();
        let _ = write!(text, "  at {} = {at}", axis.axis);
        match answer.within.as_ref().and_then(|within| within.get(&axis.axis)) {
            Some([low, high]) => {
                let _ = write!(text, ", lies within {low} … {high} of the range {} … {}", axis.from, axis.to);
            }
            None => text.push_str("; uncertainty unknown: the error of this metric is not estimated"),
        }
        if answer.at_end_of_range.contains(&axis.axis) {
            text.push_str("; at the end of the range: a better value may lie beyond it");
        }
        text.push('\n');
    }
    for rival in answer.rivals.iter().take(MAX_RIVALS) {
        let at: Vec<String> = rival.point.iter().map(|(axis, value)| format!("{axis} = {}", short(value))).collect();
        let _ = writeln!(text, "  may be as good at {}: {:.5}", at.join(", "), rival.value.unwrap_or(f64::NAN));
    }
    if answer.rivals.len() > MAX_RIVALS {
        let _ = writeln!(text, "  … and {} more", answer.rivals.len() - MAX_RIVALS);
    }
    let failed = if answer.failed > 0 { format!(", {} of them failed", answer.failed) } else { String::new() };
    let _ = writeln!(text, "{} runs{failed}", answer.runs);
    text
}

/// Error against run time: the compared scene, one row for each point, a legend, and recommendations.
pub fn work_precision(answer: &WorkPrecisionAnswer) -> String {
    let (compared, timing) = (&answer.compared, &answer.timing);
    let motion = compared.motion.map_or("motion unknown: run too short".to_owned(), |motion| {
        let motion = format!("{motion:?}").to_lowercase();
        // Adding 0 turns -0 into 0.
        format!("motion {motion}, divergence rate {:.0} 1/s", compared.divergence_rate_per_s.round() + 0.0)
    });
    let mut text = format!(
        "{}\n{} s after {} s, {} states ({}); {motion}\n{}\n",
        compared.scene,
        compared.duration_s,
        compared.settle_s,
        compared.states,
        compared.rung,
        reference_line(answer),
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
        "\nerror: of the acceleration level, largest of all axes (axes more than 60 dB below another are excluded)\n\
         trajectory: rms distance of all states from the reference's, in standard deviations of each\n\
         *: not significant: below ten times the reference's own error, or below the sampling error\n\
         time: median and range of {}, one thread; cpu: processor time of the run\n\
         rhs: evaluations of the equations; jac: Jacobians; lu: factorizations\n\
         cheapest: least cpu (else wall) time with an error within the bound, at this and all tighter tolerances\n\
         timed: {}; not timed: {}\n",
        timing.repetitions, timing.inside, timing.outside
    );
    text + &recommendation(answer)
}

/// Error against run time for the number of modes: one row for each range, the largest error of each channel, and recommendations.
pub fn mode_precision(answer: &ModePrecisionAnswer) -> String {
    let (reference, compared, timing) = (&answer.reference, &answer.compared, &answer.timing);
    let step_error = reference.step_errors_db.values().copied().reduce(f64::max);
    let mut text = format!(
        "{}\n{} s after {} s, steps of {} µs\nreference: modes to {} × 20 kHz, {} coordinates, steps of {} µs; error of the runs' step alone: {}\n",
        compared.scene,
        compared.duration_s,
        compared.settle_s,
        compared.step_us,
        reference.mode_range,
        reference.coordinates,
        reference.step_us,
        step_error.map_or("–".to_owned(), |error| format!("{error:.2e} dB")),
    );
    let _ = writeln!(
        text,
        "\n{:<12}{:>12}{:>13}{:>13}{:>11}{:>18}{:>10}{:>10}{:>13}  status",
        "mode range", "coordinates", "error [dB]", "modes [dB]", "time [s]", "range", "cpu [s]", "steps", "evaluations"
    );
    let error = |value: Option<f64>| value.map_or("–".to_owned(), |error| format!("{error:.2e}"));
    for point in &answer.points {
        let _ = match point {
            ModePointAnswer::Succeeded(point) => writeln!(
                text,
                "{:<12}{:>12}{:>13}{:>13}{:>11.4}{:>18}{:>10}{:>10}{:>13}  succeeded",
                point.mode_range,
                point.coordinates,
                error(point.level_error_db),
                error(point.mode_error_db),
                point.wall_time_s,
                match point.wall_time_range_s.as_slice() {
                    [least, most] => format!("{least:.4}–{most:.4}"),
                    _ => String::new(),
                },
                point.processor_time_s.map_or("–".to_owned(), |time| format!("{time:.4}")),
                point.steps,
                point.evaluations,
            ),
            ModePointAnswer::Failed(point) => writeln!(
                text,
                "{:<12}{:>12}{:>13}{:>13}{:>11.4}{:>51}  failed: {}",
                point.mode_range, "–", "–", "–", point.wall_time_s, "", point.reason
            ),
        };
    }
    let measured: Vec<_> = answer.points.iter().filter_map(ModePointAnswer::measured).collect();
    if !measured.is_empty() {
        let _ = write!(text, "\n{:<34}{:>11}{:>13}", "level error [dB]", "level [dB]", "step alone");
        for point in &measured {
            let _ = write!(text, "{:>11}", format!("× {}", point.mode_range));
        }
        text.push('\n');
        for (channel, level) in &reference.levels_db {
            let _ =
                write!(text, "{channel:<34}{level:>11.2}{:>13}", error(reference.step_errors_db.get(channel).copied()));
            for point in &measured {
                let _ = write!(text, "{:>11}", error(point.level_errors_db.get(channel).copied()));
            }
            text.push('\n');
        }
    }
    let _ = writeln!(
        text,
        "\nmode range: highest frequency of the kept modes over 20 kHz\n\
         error: of a level against the reference, largest of all channels (those more than 60 dB below the strongest are excluded)\n\
         modes: the same against a run with the modes of the reference at the same step\n\
         time: median and range of {}, one thread; cpu: processor time of the run\n\
         timed: {}; not timed: {}\n",
        timing.repetitions, timing.inside, timing.outside
    );
    for within in RECOMMENDED_ERRORS_DB {
        let _ = match answer.recommended.iter().find(|recommended| recommended.within_db == within) {
            Some(found) => writeln!(
                text,
                "cheapest within {within} dB: modes to {} × 20 kHz, {:.2} s",
                found.mode_range,
                found.processor_time_s.unwrap_or(found.wall_time_s)
            ),
            None => writeln!(text, "cheapest within {within} dB: none of the ranges"),
        };
    }
    text
}

/// One line for each error bound.
fn recommendation(answer: &WorkPrecisionAnswer) -> String {
    let mut text = String::new();
    for within in RECOMMENDED_ERRORS_DB {
        let _ = match answer.recommended.iter().find(|recommended| recommended.within_db == within) {
            Some(found) => writeln!(
                text,
                "cheapest within {within} dB: {} at {:e}, {:.2} s",
                found.method,
                found.relative_tolerance,
                found.processor_time_s.unwrap_or(found.wall_time_s)
            ),
            None => writeln!(text, "cheapest within {within} dB: none of the methods"),
        };
    }
    match (answer.recommended.is_empty(), missing_level(answer), answer.reference.sampling_error_db) {
        (true, Some(why), _) => format!("no recommendation: level {why}\n"),
        (_, _, Some(sampling)) if answer.recommended.len() < RECOMMENDED_ERRORS_DB.len() => {
            format!(
                "{text}chaotic motion: the sampling error of the level over this time is {sampling:.1e} dB for every method\n"
            )
        }
        _ => text,
    }
}

/// The reason why there is no level to compare, if there is none.
fn missing_level(answer: &WorkPrecisionAnswer) -> Option<&'static str> {
    let too_short = answer.compared.duration_s < MIN_LEVEL_TIME_S;
    match (answer.reference.levels_db.is_empty(), too_short) {
        (false, _) => None,
        (true, true) => Some("unknown: run too short"),
        (true, false) => Some("unknown: nothing moves"),
    }
}

fn reference_line(answer: &WorkPrecisionAnswer) -> String {
    let reference = &answer.reference;
    let unchecked = if reference.check_method.is_none() { "unknown: no second reference finished" } else { "unknown" };
    let sampling =
        reference.sampling_error_db.map_or(String::new(), |error| format!("; sampling error {error:.2e} dB"));
    let check = match (&reference.check_method, reference.check_relative_tolerance) {
        (Some(method), Some(tolerance)) => format!(" (against {method} at {tolerance:e})"),
        _ => String::new(),
    };
    let level = reference.own_error_db.map(|error| format!("{error:.2e} dB"));
    let level = level.unwrap_or_else(|| format!("level {}", missing_level(answer).unwrap_or(unchecked)));
    // For a chaotic motion each point states it over its own time.
    let trajectory = match (reference.own_trajectory_error, answer.compared.motion) {
        (Some(error), _) => format!(", trajectory {error:.2e}"),
        (None, Some(MotionName::Diverging)) => String::new(),
        (None, _) => format!(", trajectory {unchecked}"),
    };
    format!(
        "reference {} at {:e}; its own error{check}: {level}{trajectory}{sampling}",
        reference.method, reference.relative_tolerance
    )
}

fn measured_row(point: &MeasuredAnswer) -> String {
    let error = |value: Option<f64>, is_insignificant: bool| {
        let mark = if is_insignificant { "*" } else { " " };
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
