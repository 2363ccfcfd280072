//! Metrics as text for people.

use std::fmt::Write;

use serde_json::Value;

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
