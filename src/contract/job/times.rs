//! How long to simulate.

use crate::contract::json::defaults::Defaults;
use crate::contract::json::limits::DURATION;
use crate::contract::json::numbers;
use raceway_core::physics::kinematics::{CharacteristicFrequencies, ideal_frequencies};
use raceway_core::simulation::input::scene::Scene;
use raceway_core::simulation::input::settings::Outputs;
use raceway_core::simulation::recording::sampling::RATE;
use raceway_core::simulation::solve::startup::{settling_time, turning_time};

/// Longest default that the speed gives [s].
const LONGEST_DEFAULT: f64 = 1.0;
/// Longest default that a speed's changes give [s].
const LONGEST_PROFILE: f64 = 10.0;
/// The longest time that is kept [s] with up to `FEW_SERIES` series: these take 1 GiB then, at four doubles a sample for the value itself, its time
/// and copies on the way.
const LONGEST_SERIES: f64 = 23.4;
const FEW_SERIES: usize = 14;
const _: () = assert!(LONGEST_SERIES * RATE * (FEW_SERIES * 4 * 8) as f64 <= 1_073_741_824.0);

/// Default time before anything is kept [s]: 3 cage turns, at least 0.02 s, and until the spindle's free vibration has decayed.
pub fn default_settle(scene: Option<&Scene>) -> f64 {
    let turns = scene.map_or(0.02, |scene| numbers::significant(turning_time(scene), 6));
    let decayed = scene.and_then(settling_time).map_or(0.0, |time| numbers::significant(time, 3));
    turns.max(decayed)
}

/// Default time that is kept after so much of settling [s]: 20 ball passes, at least 0.1 s, and to the last point of a speed that changes.
pub fn default_duration(scene: Option<&Scene>, settle: f64) -> f64 {
    let passes = default_time(0.1, 20.0, scene.map(frequencies).map(|f| f.ball_pass_outer));
    let changing = scene.map(|scene| &scene.operation.speed).filter(|speed| !speed.is_constant());
    let profile = changing.map_or(0.0, |speed| speed.end() - settle).min(LONGEST_PROFILE);
    passes.max(numbers::significant(profile, 6))
}

/// Time before anything is kept [s].
pub fn settle(field: &mut Option<f64>, default: f64, defaults: &mut Defaults) -> f64 {
    let settle = defaults.fill("/settle_s", field, default);
    defaults.check("/settle_s", settle);
    settle
}

/// Time that is kept [s].
pub fn duration(field: &mut Option<f64>, default: f64, outputs: &Outputs, defaults: &mut Defaults) -> f64 {
    let duration = defaults.fill("/duration_s", field, default);
    let longest = longest_kept(outputs.series.len());
    if !(DURATION.lowest..=longest).contains(&duration) {
        let mut detail = numbers::out_of_range(duration, DURATION.lowest, longest, false, DURATION.unit);
        if duration > longest && longest < DURATION.highest {
            detail += ": /outputs/series would take more than 1 GiB";
        }
        defaults.refuse("/duration_s", detail);
    }
    duration
}

/// Longest time that is kept with so many series [s], in whole milliseconds, so that it is what messages say.
fn longest_kept(series: usize) -> f64 {
    if series == 0 {
        return DURATION.highest;
    }
    let longest = LONGEST_SERIES * FEW_SERIES as f64 / series.max(FEW_SERIES) as f64;
    // Rounding must not take a millisecond from a whole number of them.
    (longest * 1e3 + 1e-6).floor() / 1e3
}

/// So many periods of a frequency [Hz], but at least `least` and at most a second; `least` at rest.
fn default_time(least: f64, periods: f64, frequency: Option<f64>) -> f64 {
    match frequency {
        Some(frequency) if frequency > 0.0 => {
            numbers::significant((periods / frequency).clamp(least, LONGEST_DEFAULT), 6)
        }
        _ => least,
    }
}

fn frequencies(scene: &Scene) -> CharacteristicFrequencies {
    ideal_frequencies(&scene.bearing, scene.operating_speed())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_series_bound_the_longest_time() {
        assert_eq!((longest_kept(0), longest_kept(1), longest_kept(14)), (1000.0, 23.4, 23.4));
        assert_eq!((longest_kept(15), longest_kept(28)), (21.84, 11.7));
    }
}
