//! Messages about the bands of an acceleration.

use std::f64::consts::TAU;

use raceway_core::simulation::error::comparison::SILENCE;
use raceway_core::simulation::recording::bands::{Band, BandMetrics, LOWEST_BIN, SEVERITY_BAND};
use raceway_core::simulation::result::lines::Line;
use serde_json::json;

use super::answer::{MessageAnswer, MessageCode, Severity, message};
use super::words::numbers;
use crate::contract::json::numbers::significant;

/// Distance of the power of the bands from that of the signal above which a message says so [-].
const PARSEVAL_TOLERANCE: f64 = 0.03;
/// Half width of the main lobe of a Hann window [bins].
const LOBE: f64 = 2.0;

/// Messages about the bands of a channel with a root mean square [m/s²] and these lines; silence has none.
pub fn of_bands(channel: &str, rms: f64, metrics: &BandMetrics, lines: &[&Line]) -> Vec<MessageAnswer> {
    if rms <= SILENCE {
        return Vec::new();
    }
    let velocity = metrics.severity.is_none().then(|| velocity_not_resolved(channel));
    let power = metrics.parseval_ratio.filter(|ratio| (ratio - 1.0).abs() > PARSEVAL_TOLERANCE);
    let at_edge = lines.iter().find_map(|line| line_at_edge(channel, metrics, line));
    velocity.into_iter().chain(power.map(|ratio| power_beyond_bands(channel, ratio))).chain(at_edge).collect()
}

fn velocity_not_resolved(channel: &str) -> MessageAnswer {
    let required = LOWEST_BIN / SEVERITY_BAND.0;
    let text = format!(
        "The velocity of {channel} from {} to {} Hz has no value, because the record is shorter than {required} s. Set duration_s to \
         {required} or more.",
        SEVERITY_BAND.0, SEVERITY_BAND.1
    );
    message(MessageCode::VelocityNotResolved, Severity::Info, text, numbers(&[("required_duration_s", required)]))
}

fn power_beyond_bands(channel: &str, ratio: f64) -> MessageAnswer {
    let ratio = significant(ratio, 4);
    let text = format!(
        "The spectra of {channel} hold {ratio} times the power of its signal, so that its bands do not sum to its level: the motion changes \
         during the record, is irregular, or is slower than the spectra resolve. Increase duration_s or settle_s; where the speed changes, \
         keep outputs.orders."
    );
    message(MessageCode::PowerBeyondBands, Severity::Warning, text, [("parseval_ratio", json!(ratio))])
}

/// A line whose main lobe reaches over the edge of a band, and that has more power than the band beyond.
fn line_at_edge(channel: &str, metrics: &BandMetrics, line: &Line) -> Option<MessageAnswer> {
    let square = 0.5 * (line.amplitude / (TAU * line.frequency)).powi(2);
    let reaches = |edge: f64| (line.frequency - edge).abs() <= LOBE * metrics.resolution;
    let is_beyond = |band: &&Band| {
        (line.frequency < band.from && reaches(band.from)) || (line.frequency >= band.to && reaches(band.to))
    };
    let band = metrics.bands.iter().find(|band| is_beyond(band) && square >= band.velocity * band.velocity)?;
    let frequency_hz = significant(line.frequency, 5);
    let text = format!(
        "The line of {channel} at {frequency_hz} Hz lies at an edge of the band from {} to {} Hz, so that the band has a share of it. Increase \
         duration_s, or move the edge by outputs.bands_hz.",
        band.from, band.to
    );
    let values = [("frequency_hz", json!(frequency_hz)), ("from_hz", json!(band.from)), ("to_hz", json!(band.to))];
    Some(message(MessageCode::LineAtEdge, Severity::Warning, text, values))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metrics(severity: Option<f64>, parseval_ratio: f64) -> BandMetrics {
        let band = |from, to, velocity| Band { from, to, velocity, acceleration: 1.0 };
        BandMetrics {
            resolution: 10.0,
            bands: vec![band(300.0, 1800.0, 1e-4), band(1800.0, 10_000.0, 1e-5)],
            severity,
            parseval_ratio: Some(parseval_ratio),
        }
    }

    fn codes(rms: f64, metrics: &BandMetrics, lines: &[(f64, f64)]) -> Vec<MessageCode> {
        let line =
            |&(frequency, amplitude): &(f64, f64)| Line { frequency, amplitude, label: String::new(), deviation: 0.0 };
        let lines: Vec<Line> = lines.iter().map(line).collect();
        let lines: Vec<&Line> = lines.iter().collect();
        of_bands("spindle.y.acceleration", rms, metrics, &lines).iter().map(|message| message.code).collect()
    }

    #[test]
    fn bands_that_hold_all_have_no_message() {
        assert_eq!(codes(1.0, &metrics(Some(1e-3), 0.98), &[(1793.0, 0.1), (1500.0, 10.0)]), []);
    }

    #[test]
    fn silence_has_no_message() {
        assert_eq!(codes(1e-6, &metrics(None, 0.9), &[]), []);
    }

    #[test]
    fn each_limit_has_a_message() {
        assert_eq!(codes(1.0, &metrics(None, 1.0), &[]), [MessageCode::VelocityNotResolved]);
        assert_eq!(codes(1.0, &metrics(Some(1e-3), 0.9), &[]), [MessageCode::PowerBeyondBands]);
        assert_eq!(codes(1.0, &metrics(Some(1e-3), 1.0), &[(1793.0, 1.0)]), [MessageCode::LineAtEdge]);
        assert_eq!(codes(1.0, &metrics(Some(1e-3), 1.0), &[(1805.0, 10.0)]), [MessageCode::LineAtEdge]);
    }
}
