//! Metrics with their estimated errors.

use raceway_core::sampling::statistic::Statistic;
use raceway_core::study::Uncertain;
use serde_json::Value;

/// Share of samples without a value beyond which a statistic says nothing, and percentiles carry a warning.
pub const MANY_FAILED: f64 = 0.05;

/// True for a metric of either sign whose best value is 0. The smallest magnitude is its minimum.
pub fn is_best_at_zero(pointer: &str) -> bool {
    pointer.rsplit('/').next() == Some("cage_slip")
}

/// A metric and its estimated error; `None` where the metrics do not contain it. The error is derived from that of the level along the
/// same axis (vibration), of the largest load, of the largest slip, of the cage's speed, or of its slip. A level that is not
/// resolved counts as absent.
pub fn uncertain(metrics: &Value, pointer: &str) -> Option<Uncertain> {
    let value = metrics.pointer(pointer)?.as_f64()?;
    let accuracy = |field: &str| metrics.pointer(&format!("/accuracy/{field}")).and_then(Value::as_f64);
    // A level that is not resolved is no value.
    let is_resolved = |axis: &str| {
        metrics.pointer(&format!("/channels/spindle.{axis}.acceleration/resolved")).and_then(Value::as_bool)
            != Some(false)
    };
    let name = pointer.rsplit('/').next().unwrap_or_default();
    // Of the acceleration along the same axis, or the largest of all where that axis has none.
    let axis = pointer.strip_prefix("/channels/spindle.").and_then(|rest| rest.split('.').next());
    if axis.is_some_and(|axis| !is_resolved(axis)) {
        return None;
    }
    let of_level = || {
        let axis = axis?;
        metrics.pointer(&format!("/channels/spindle.{axis}.acceleration/level_error_db"))?.as_f64()
    };
    let level_error = || of_level().or_else(|| accuracy("level_error_db"));
    let error = match name {
        "level_db" => level_error(),
        "rms" | "rms_g" => level_error().map(|db| value * (10_f64.powf(db / 20.0) - 1.0)),
        "max_load_n" if pointer.contains("pocket") => accuracy("max_pocket_load_error").map(|share| share * value),
        "max_load_n" => accuracy("max_load_error").map(|share| share * value),
        // Pressure grows with the cube root of the load.
        "max_pressure_mpa" => accuracy("max_load_error").map(|share| share * value / 3.0),
        "orbit_radius_um" => accuracy("orbit_radius_error").map(|share| share * value),
        "max_slip_m_s" => accuracy("max_slip_error").map(|share| share * value),
        "cage_speed_hz" => accuracy("cage_speed_error").map(|share| share * value),
        "cage_slip" => accuracy("cage_slip_error"),
        // 1 − cage speed / a speed without error.
        "cage_slip_free_angle" => accuracy("cage_speed_error").map(|share| share * (1.0 - value).abs()),
        _ => None,
    };
    Some((value, error))
}

/// The statistic of a metric over samples, of its magnitude where 0 is its best value; `None` where more than `MANY_FAILED` of them have no value.
pub fn over_samples(statistic: Statistic, pointer: &str, samples: &[Option<f64>]) -> Option<Uncertain> {
    let of_magnitude = is_best_at_zero(pointer);
    let known = samples.iter().flatten().map(|value| if of_magnitude { value.abs() } else { *value });
    let values: Vec<f64> = known.collect();
    if (samples.len() - values.len()) as f64 > MANY_FAILED * samples.len() as f64 {
        return None;
    }
    statistic.of(&values)
}
