//! Settling time and recorded time of a run.

use crate::contract::json::defaults::Defaults;
use crate::contract::json::limits::DURATION;
use crate::contract::json::numbers;
use raceway_core::physics::kinematics::{CharacteristicFrequencies, ideal_frequencies};
use raceway_core::simulation::input::scene::Scene;
use raceway_core::simulation::input::settings::Outputs;
use raceway_core::simulation::recording::sampling::RATE;
use raceway_core::simulation::solve::eligibility::representative_time;
use raceway_core::simulation::solve::startup::{settling_time, turning_time};

/// Longest default recorded time of profiles of speed and load [s].
const MAX_PROFILE: f64 = 10.0;
/// Turns of the cage in the default recorded time of surfaces that are not ideal, or balls or pockets that differ [-], and their longest time [s]: lines beside each other
/// differ by the speed of the cage.
const SURFACE_TURNS: f64 = 10.0;
const MAX_SURFACE: f64 = 20.0;
/// Longest recorded time with `SERIES_AT_MAX` series [s]: they take 512 MiB as NumPy files, two doubles for each value.
const MAX_SERIES: f64 = 23.4;
const SERIES_AT_MAX: usize = 14;
const _: () = assert!(MAX_SERIES * RATE * (SERIES_AT_MAX * 2 * 8) as f64 <= 536_870_912.0);

/// Default settling time [s]: 3 cage turns, at least 0.02 s, and until the free vibration of the spindle has decayed.
pub fn default_settle(scene: Option<&Scene>) -> f64 {
    let turns = scene.map_or(0.02, |scene| numbers::significant(turning_time(scene), 6));
    let decayed = scene.and_then(settling_time).map_or(0.0, |time| numbers::significant(time, 3));
    turns.max(decayed)
}

/// Default recorded time after the settling time [s]: 20 ball passes, and at least 0.1 s. A speed profile is recorded up to its last point, and a
/// load as long again after its last change. Where a raceway is no circle, or balls or pockets differ, the cage turns ten times.
pub fn default_duration(scene: Option<&Scene>, settle: f64) -> f64 {
    let passes = scene.map_or(0.1, |scene| numbers::significant(representative_time(scene), 6));
    let speeds = scene.into_iter().flat_map(|scene| [&scene.operation.speed, &scene.operation.outer_speed]);
    let changing = speeds.filter(|speed| !speed.is_constant());
    let of_speed = changing.map(|speed| speed.end() - settle).fold(0.0, f64::max);
    // The motion that a load excites comes after it.
    let of_loads =
        scene.and_then(|scene| scene.operation.end_of_load_changes()).map_or(0.0, |end| end - settle + passes);
    let profile = of_speed.max(of_loads).min(MAX_PROFILE);
    let is_uneven = |scene: &&Scene| !scene.surfaces.are_ideal() || scene.has_unequal_balls();
    let turns = match scene.filter(is_uneven).map(|scene| frequencies(scene).cage) {
        Some(cage) if cage > 0.0 => (SURFACE_TURNS / cage).min(MAX_SURFACE),
        _ => 0.0,
    };
    passes.max(numbers::significant(profile.max(turns), 6))
}

/// Settling time [s].
pub fn settle(field: &mut Option<f64>, default: f64, defaults: &mut Defaults) -> f64 {
    let settle = defaults.fill("/settle_s", field, default);
    defaults.check("/settle_s", settle);
    settle
}

/// Recorded time [s].
pub fn duration(field: &mut Option<f64>, default: f64, outputs: &Outputs, defaults: &mut Defaults) -> f64 {
    let duration = defaults.fill("/duration_s", field, default);
    let longest = max_duration(outputs.series.len());
    if !(DURATION.lowest..=longest).contains(&duration) {
        let mut detail = numbers::out_of_range(duration, DURATION.lowest, longest, false, DURATION.unit);
        if duration > longest && longest < DURATION.highest {
            detail += ": the kept series would take more than 512 MiB";
        }
        defaults.refuse("/duration_s", detail);
    }
    duration
}

/// Longest recorded time with this number of series [s], in whole milliseconds as messages show it.
fn max_duration(series: usize) -> f64 {
    if series == 0 {
        return DURATION.highest;
    }
    let longest = MAX_SERIES * SERIES_AT_MAX as f64 / series.max(SERIES_AT_MAX) as f64;
    // A rounding error must not remove a millisecond.
    (longest * 1e3 + 1e-6).floor() / 1e3
}

fn frequencies(scene: &Scene) -> CharacteristicFrequencies {
    ideal_frequencies(&scene.bearing, scene.operating_speeds())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_series_limit_the_recorded_time() {
        assert_eq!((max_duration(0), max_duration(1), max_duration(14)), (1000.0, 23.4, 23.4));
        assert_eq!((max_duration(15), max_duration(28)), (21.84, 11.7));
    }
}
