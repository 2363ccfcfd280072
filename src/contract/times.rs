//! How long to simulate.

use super::filling::Filling;
use super::units;
use crate::physics::kinematics::{CharacteristicFrequencies, ideal_frequencies};
use crate::simulation::observe::RATE;
use crate::simulation::run::Outputs;
use crate::simulation::scene::Scene;

/// Longest default [s].
const LONGEST_DEFAULT: f64 = 1.0;
/// Longest settling time [s].
const LONGEST_SETTLE: f64 = 1000.0;
/// Channels that metrics and plots keep, whatever was asked for.
const USUAL_CHANNELS: usize = 12;
/// The usual channels and the two accelerations whose spectra are kept unless told otherwise.
const LEAST_CHANNELS: usize = USUAL_CHANNELS + 2;
/// Shortest and longest time that is kept [s], the latter with up to `LEAST_CHANNELS` channels: their signals take 1 GiB
/// then, at four doubles a sample for the value itself, its transform and copies on the way. Stands in the schema, too.
const SHORTEST: f64 = 1e-6;
const LONGEST: f64 = 23.4;
const _: () = assert!(LONGEST * RATE * (LEAST_CHANNELS * 4 * 8) as f64 <= 1_073_741_824.0);

/// Default time before anything is kept [s]: 3 cage turns, at least 0.02 s.
pub fn default_settle(scene: Option<&Scene>) -> f64 {
    default_time(0.02, 3.0, scene.map(frequencies).map(|f| f.cage))
}

/// Default time that is kept [s]: 20 ball passes, at least 0.1 s.
pub fn default_duration(scene: Option<&Scene>) -> f64 {
    default_time(0.1, 20.0, scene.map(frequencies).map(|f| f.ball_pass_outer))
}

/// Time before anything is kept [s].
pub fn settle(field: &mut Option<f64>, default: f64, filling: &mut Filling) -> f64 {
    let settle = filling.take("/settle_s", field, default);
    filling.within("/settle_s", settle, 0.0, LONGEST_SETTLE, "s");
    settle
}

/// Time that is kept [s].
pub fn duration(field: &mut Option<f64>, default: f64, outputs: &Outputs, filling: &mut Filling) -> f64 {
    let duration = filling.take("/duration_s", field, default);
    let asked = outputs.spectra.iter().chain(&outputs.series).collect::<std::collections::BTreeSet<_>>().len();
    let channels = (USUAL_CHANNELS + asked).max(LEAST_CHANNELS);
    let longest = longest_kept(channels);
    if !(SHORTEST..=longest).contains(&duration) {
        let mut detail = units::out_of_range(duration, SHORTEST, longest, false, "s");
        if duration > longest {
            detail += &format!(": the signals of {channels} channels would take more than 1 GiB");
        }
        filling.refuse("/duration_s", detail);
    }
    duration
}

/// Longest time that is kept of so many channels [s], in whole milliseconds, so that it is what messages say.
fn longest_kept(channels: usize) -> f64 {
    let longest = LONGEST * LEAST_CHANNELS as f64 / channels as f64;
    // Rounding must not take a millisecond from a whole number of them.
    (longest * 1e3 + 1e-6).floor() / 1e3
}

/// So many periods of a frequency [Hz], but at least `least` and at most a second; `least` at rest.
fn default_time(least: f64, periods: f64, frequency: Option<f64>) -> f64 {
    match frequency {
        Some(frequency) if frequency > 0.0 => {
            units::significant((periods / frequency).clamp(least, LONGEST_DEFAULT), 6)
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
    fn the_longest_time_is_one_number_for_all_usual_jobs() {
        assert_eq!(longest_kept(LEAST_CHANNELS), LONGEST);
        assert_eq!((longest_kept(15), longest_kept(28)), (21.84, 11.7));
    }
}
