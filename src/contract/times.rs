//! How long to simulate.

use super::filling::Filling;
use super::units::{self, short};
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
/// Bytes a sample: the value itself, its transform and copies on the way.
const BYTES_PER_SAMPLE: f64 = 8.0 * 4.0;
/// Most memory that the signals of one run may take: 1 GiB.
const MOST_BYTES: f64 = 1_073_741_824.0;

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
    let channels = USUAL_CHANNELS + asked;
    let longest = MOST_BYTES / (RATE * BYTES_PER_SAMPLE * channels as f64);
    if duration <= 0.0 {
        filling.refuse("/duration_s", units::out_of_range(duration, 0.0, longest, true, "s"));
    } else if duration > longest {
        let detail = format!(
            "{} s: the signals of {channels} channels would take more than 1 GiB; at most {} s",
            short(duration),
            short((longest * 1e3).floor() / 1e3)
        );
        filling.refuse("/duration_s", detail);
    }
    duration
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
