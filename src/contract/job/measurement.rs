//! A measured record that is compared with a prediction.

use raceway_core::measured::record::{Record, Turning};
use raceway_core::measured::tachometer::{FEWEST_PULSES, Tachometer, middle, pulses_of};
use raceway_core::physics::samples::Samples;
use raceway_core::simulation::input::settings::BAND_EDGES;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use utoipa::ToSchema;

use super::outputs::band_edge_errors;
use crate::contract::json::numbers::out_of_range;
use crate::contract::json::problem::{FieldError, Refusal};
use crate::contract::json::shapes::{optional_object, whole_number};
use crate::contract::json::strict;
use crate::contract::json::typed::typed_with_errors;
use crate::contract::json::uploads::Uploads;

/// A measured record, for a comparison with a prediction. One of `speed_rpm` and `tachometer` is required.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasurementInput {
    /// Content hash of the record, an uploaded series (`POST /v1/series`).
    #[schema(pattern = "^[0-9a-f]{64}$")]
    pub series: String,
    /// Unit of the values of the record.
    pub unit: MeasuredUnit,
    /// The predicted channel, a displacement, velocity or acceleration. Default: the first kept spectrum (`…/channels`).
    #[schema(nullable = false, example = "spindle.y.acceleration")]
    pub channel: Option<String>,
    /// Measured speed of the shaft [r/min]. Orders are frequencies over this speed.
    #[schema(nullable = false, minimum = 0.1, maximum = 500_000, example = 2998.5)]
    pub speed_rpm: Option<f64>,
    /// Pulses of the shaft: the record is then resampled by angle.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub tachometer: Option<TachometerInput>,
    /// Rising edges of the compared bands [Hz], 2 to 17 of them, from 1 to 20 000. Default: 50, 300, 1800, 10 000.
    #[schema(nullable = false, min_items = 2, max_items = 17, example = json!([50, 300, 1800, 10000]))]
    pub bands_hz: Option<Vec<f64>>,
    /// Factor on the measured values, one number for all frequencies. Default: 1. Nothing is scaled without it.
    #[schema(nullable = false, minimum = 1e-6, maximum = 1e6, example = 1.0)]
    pub gain: Option<f64>,
}

/// Pulses of the shaft, as times or as a second uploaded series that begins with the record.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TachometerInput {
    /// Rising times of the pulses since the first value of the record [s].
    #[schema(nullable = false, min_items = 3, max_items = 50_000, example = json!([0.004, 0.024, 0.044]))]
    pub pulse_times_s: Option<Vec<f64>>,
    /// Content hash of the signal of the tachometer, in place of the times. A pulse is where it rises through `threshold`.
    #[schema(nullable = false, pattern = "^[0-9a-f]{64}$")]
    pub series: Option<String>,
    /// Value at which a pulse counts. Default: the middle between the least and the greatest value.
    #[schema(nullable = false, minimum = -1e12, maximum = 1e12, example = 2.5)]
    pub threshold: Option<f64>,
    /// Pulses in a turn of the shaft. Default 1.
    #[serde(default, deserialize_with = "whole_number::<_, 1, 10000>")]
    #[schema(nullable = false, minimum = 1, maximum = 10_000, example = 1)]
    pub pulses_per_turn: Option<u32>,
}

/// Unit of measured values: of an acceleration `m/s2` or `g` (9.80665 m/s²), of a velocity `m/s`, `mm/s` or `um/s`, of a displacement `mm` or `um`.
/// `m/s²`, `m/s^2`, `µm/s` and `µm` are read, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub enum MeasuredUnit {
    #[serde(rename = "m/s2", alias = "m/s²", alias = "m/s^2")]
    MetrePerSecondSquared,
    #[serde(rename = "g")]
    StandardGravity,
    #[serde(rename = "m/s")]
    MetrePerSecond,
    #[serde(rename = "mm/s")]
    MillimetrePerSecond,
    #[serde(rename = "um/s", alias = "µm/s", alias = "μm/s")]
    MicrometrePerSecond,
    #[serde(rename = "mm")]
    Millimetre,
    #[serde(rename = "um", alias = "µm", alias = "μm")]
    Micrometre,
}

impl MeasuredUnit {
    /// Motion that the unit is of, as channels name it, and its size in the unit of these channels: m/s², mm/s or µm.
    pub fn of_channels(self) -> (&'static str, f64) {
        match self {
            Self::MetrePerSecondSquared => ("acceleration", 1.0),
            Self::StandardGravity => ("acceleration", 9.806_65),
            Self::MetrePerSecond => ("velocity", 1e3),
            Self::MillimetrePerSecond => ("velocity", 1.0),
            Self::MicrometrePerSecond => ("velocity", 1e-3),
            Self::Millimetre => ("displacement", 1e3),
            Self::Micrometre => ("displacement", 1.0),
        }
    }
}

/// Measured speeds [r/min].
const SPEEDS_RPM: [f64; 2] = [0.1, 500_000.0];
/// Factors on measured values.
const GAINS: [f64; 2] = [1e-6, 1e6];
const MOST_PULSES: usize = 50_000;

/// A request whose fields are checked as far as they can be without the record, which takes seconds to read.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasurementRequest(MeasurementInput);

impl MeasurementRequest {
    pub fn read(body: &[u8]) -> Result<Self, Refusal> {
        let value = strict::read(body)?;
        let (input, mut errors) = typed_with_errors::<MeasurementInput>(&value);
        if let Some(input) = &input {
            input.check(&mut errors);
        }
        input.filter(|_| errors.is_empty()).map(Self).ok_or(Refusal::Invalid { errors })
    }

    /// The named channel.
    pub fn channel(&self) -> Option<&String> {
        self.0.channel.as_ref()
    }

    pub fn unit(&self) -> MeasuredUnit {
        self.0.unit
    }

    /// The measurement, with the series that the request may name.
    pub fn with(self, uploads: &Uploads) -> Result<Measurement, Refusal> {
        let mut errors = Vec::new();
        let measurement = Measurement::of(self.0, uploads, &mut errors);
        measurement.filter(|_| errors.is_empty()).ok_or(Refusal::Invalid { errors })
    }
}

impl MeasurementInput {
    /// Checks what does not depend on the record.
    fn check(&self, errors: &mut Vec<FieldError>) {
        match (self.speed_rpm, &self.tachometer) {
            (Some(speed), None) => check(speed, SPEEDS_RPM, "r/min", "/speed_rpm", errors),
            (None, Some(tachometer)) => {
                let error = tachometer.error();
                errors.extend(error.map(|(field, detail)| FieldError::new(format!("/tachometer{field}"), detail)));
            }
            (Some(_), Some(_)) => {
                errors.push(FieldError::new("/speed_rpm", "leave it out: the tachometer gives the speed"));
            }
            (None, None) => {
                let detail = "required, but missing: give `speed_rpm`, or a `tachometer`, because orders need the measured speed";
                errors.push(FieldError::new("/speed_rpm", detail));
            }
        }
        if let Some(gain) = self.gain {
            check(gain, GAINS, "", "/gain", errors);
        }
        if let Some(edges) = &self.bands_hz {
            errors.extend(band_edge_errors("/bands_hz", edges));
        }
    }
}

/// A checked measured record.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    samples: Arc<Samples>,
    turning: Turning,
    pub unit: MeasuredUnit,
    pub band_edges: Vec<f64>,
    pub gain: Option<f64>,
}

impl Measurement {
    /// Of checked fields.
    fn of(input: MeasurementInput, uploads: &Uploads, errors: &mut Vec<FieldError>) -> Option<Self> {
        let samples = uploads.get(&input.series);
        match samples.as_ref().map(|samples| no_vibration(samples.values())) {
            None => errors.push(FieldError::new("/series", UNKNOWN_SERIES)),
            Some(Some(detail)) => errors.push(FieldError::new("/series", detail)),
            Some(None) => {}
        }
        let end = samples.as_ref().map(|samples| samples.end());
        let turning = match (input.speed_rpm, &input.tachometer) {
            (Some(speed), _) => Some(Turning::Even(speed / 60.0)),
            (None, tachometer) => tachometer.as_ref()?.turning(end, uploads, errors),
        };
        Some(Self {
            samples: samples?,
            turning: turning?,
            unit: input.unit,
            band_edges: input.bands_hz.unwrap_or_else(|| BAND_EDGES.to_vec()),
            gain: input.gain,
        })
    }

    /// The record, with its values as they were uploaded.
    pub fn record(&self) -> Record<'_> {
        Record { values: self.samples.values(), rate: self.samples.rate(), turning: self.turning.clone() }
    }
}

/// Largest value of a record: squares of larger ones over a spectrum might overflow.
const LARGEST: f64 = 1e100;
/// Variation of a record over its largest value that is rounding [-].
const ROUNDING: f64 = 1e-12;
const UNKNOWN_SERIES: &str = "no uploaded series has this hash: post its values to /v1/series";

fn check(value: f64, [lowest, highest]: [f64; 2], unit: &str, pointer: &str, errors: &mut Vec<FieldError>) {
    if !(lowest..=highest).contains(&value) {
        errors.push(FieldError::new(pointer, out_of_range(value, lowest, highest, false, unit)));
    }
}

impl TachometerInput {
    /// Field and detail of what is wrong whatever the record.
    fn error(&self) -> Option<(&'static str, String)> {
        match (&self.pulse_times_s, &self.series) {
            (Some(times), None) if times.len() > MOST_PULSES => {
                return Some(("/pulse_times_s", format!("{} times: at most {MOST_PULSES}", times.len())));
            }
            (Some(times), None) if !times.is_sorted_by(|one, next| one < next) => {
                return Some(("/pulse_times_s", "the times must rise".to_owned()));
            }
            (Some(_), None) | (None, Some(_)) => {}
            _ => return Some(("", "must have either `pulse_times_s` or `series`".to_owned())),
        }
        if self.threshold.is_some() && self.series.is_none() {
            return Some(("/threshold", "times have no threshold: leave it out".to_owned()));
        }
        let per_turn = self.per_turn();
        (!(1..=10_000).contains(&per_turn))
            .then(|| ("/pulses_per_turn", out_of_range(f64::from(per_turn), 1.0, 1e4, false, "")))
    }

    fn per_turn(&self) -> u32 {
        self.pulses_per_turn.unwrap_or(1)
    }

    /// Turns of the shaft within a record whose last value is at `end` [s].
    fn turning(&self, end: Option<f64>, uploads: &Uploads, errors: &mut Vec<FieldError>) -> Option<Turning> {
        let mut refuse = |field: &str, detail: String| {
            errors.push(FieldError::new(format!("/tachometer{field}"), detail));
            None
        };
        let (pointer, mut pulses) = match (&self.pulse_times_s, &self.series) {
            (Some(times), _) => ("/pulse_times_s", times.clone()),
            (None, hash) => {
                let Some(signal) = uploads.get(hash.as_ref()?) else {
                    return refuse("/series", UNKNOWN_SERIES.to_owned());
                };
                let threshold = self.threshold.unwrap_or_else(|| middle(signal.values()));
                ("/series", pulses_of(signal.values(), signal.rate(), threshold))
            }
        };
        pulses.retain(|time| (0.0..=end.unwrap_or(f64::INFINITY)).contains(time));
        if let Some(detail) = irregularity(&pulses) {
            return refuse(pointer, detail);
        }
        let (count, per_turn) = (pulses.len(), self.per_turn());
        match Tachometer::new(pulses, per_turn) {
            Some(tachometer) => Some(Turning::Pulses(tachometer)),
            None => refuse(pointer, format!("{count} pulses within the record: at least {FEWEST_PULSES} are needed")),
        }
    }
}

/// The first interval between pulses that is nearer to twice or half of the one before than to its equal: a pulse is missing or one too many.
fn irregularity(pulses: &[f64]) -> Option<String> {
    let place = pulses.windows(3).position(|three| {
        let ratio = (three[2] - three[1]) / (three[1] - three[0]);
        !(0.5_f64.sqrt()..=2.0_f64.sqrt()).contains(&ratio)
    })?;
    let [a, b, c] = [0, 1, 2].map(|k| pulses[place + k]);
    Some(format!(
        "{:.6} s follow an interval of {:.6} s at the pulse at {b:.6} s: a pulse is missing, or one is too many",
        c - b,
        b - a
    ))
}

/// Why values are no record of a vibration; `None`: they are one.
fn no_vibration(values: &[f64]) -> Option<String> {
    let (least, most) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(*value), most.max(*value)));
    let largest = least.abs().max(most.abs());
    if largest > LARGEST {
        Some(format!("a value of {largest:e}: must be from -{LARGEST:e} to {LARGEST:e}"))
    } else if most - least <= ROUNDING * largest {
        Some(format!("all values are {most}: there is no vibration to compare"))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde_json::{Value, json};

    use super::*;

    const RECORD: &str = "0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a";

    fn read(more: &Value) -> Result<Measurement, Refusal> {
        let samples = Samples::new(1000.0, (0..1000).map(|k| f64::from(k % 20)).collect()).unwrap();
        let uploads = Uploads::new(BTreeMap::from([(RECORD.to_owned(), Arc::new(samples))]));
        let mut request = json!({ "series": RECORD, "unit": "g" });
        request.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        MeasurementRequest::read(request.to_string().as_bytes())?.with(&uploads)
    }

    fn pointers(more: &Value) -> Vec<String> {
        match read(more) {
            Err(Refusal::Invalid { errors }) => errors.into_iter().map(|error| error.pointer).collect(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_record_has_a_speed_or_a_tachometer() {
        assert_eq!(read(&json!({ "speed_rpm": 3000 })).unwrap().turning, Turning::Even(50.0));
        let Turning::Pulses(found) = read(&json!({ "tachometer": { "series": RECORD } })).unwrap().turning else {
            panic!("pulses")
        };
        assert!((found.mean_speed() - 50.0).abs() < 1e-9);
        let times = json!({ "tachometer": { "pulse_times_s": [-0.1, 0.1, 0.2, 0.3, 5], "pulses_per_turn": 2 } });
        let Turning::Pulses(found) = read(&times).unwrap().turning else { panic!("pulses") };
        assert!((found.turns() - 1.0).abs() < 1e-12, "times beyond the record are left out");
        assert_eq!(pointers(&json!({})), ["/speed_rpm"]);
        assert_eq!(pointers(&json!({ "speed_rpm": 50, "tachometer": {} })), ["/speed_rpm"]);
    }

    #[test]
    fn equal_values_are_no_vibration() {
        let samples = Samples::new(1000.0, vec![0.3; 1000]).unwrap();
        let uploads = Uploads::new(BTreeMap::from([(RECORD.to_owned(), Arc::new(samples))]));
        let request = json!({ "series": RECORD, "unit": "g", "speed_rpm": 3000 }).to_string();
        let given = MeasurementRequest::read(request.as_bytes()).unwrap();
        let Err(Refusal::Invalid { errors }) = given.with(&uploads) else { panic!("refused") };
        assert_eq!(errors, [FieldError::new("/series", "all values are 0.3: there is no vibration to compare")]);
    }

    #[test]
    fn units_are_read_as_they_are_printed() {
        let unit = |name: &str| read(&json!({ "speed_rpm": 50, "unit": name })).unwrap().unit;
        assert!(["m/s2", "m/s²", "m/s^2"].iter().all(|name| unit(name) == MeasuredUnit::MetrePerSecondSquared));
        // The sign of micro, and the Greek letter.
        assert!(["um/s", "\u{b5}m/s", "\u{3bc}m/s"].iter().all(|name| unit(name) == MeasuredUnit::MicrometrePerSecond));
        assert!(["um", "\u{b5}m", "\u{3bc}m"].iter().all(|name| unit(name) == MeasuredUnit::Micrometre));
    }

    #[test]
    fn wrong_fields_are_named() {
        assert_eq!(
            pointers(&json!({ "speed_rpm": 0, "gain": -1, "bands_hz": [300, 50] })),
            ["/speed_rpm", "/gain", "/bands_hz/1"]
        );
        assert_eq!(pointers(&json!({ "speed_rpm": 50, "unit": "mV" })), ["/unit"]);
        assert_eq!(pointers(&json!({ "speed_rpm": 50, "series": "0b" })), ["/series"]);
        let tachometer = |of: Value| pointers(&json!({ "tachometer": of }));
        assert_eq!(tachometer(json!({})), ["/tachometer"]);
        assert_eq!(tachometer(json!({ "series": "0b" })), ["/tachometer/series"]);
        assert_eq!(tachometer(json!({ "series": RECORD, "threshold": 99 })), ["/tachometer/series"]);
        assert_eq!(tachometer(json!({ "pulse_times_s": [0.1, 0.2, 0.1] })), ["/tachometer/pulse_times_s"]);
        // A pulse is missing, or one too many.
        assert_eq!(tachometer(json!({ "pulse_times_s": [0.1, 0.2, 0.3, 0.5] })), ["/tachometer/pulse_times_s"]);
        assert_eq!(tachometer(json!({ "pulse_times_s": [0.1, 0.2, 0.20001, 0.3] })), ["/tachometer/pulse_times_s"]);
        assert_eq!(tachometer(json!({ "pulse_times_s": [1, 2, 3] })), ["/tachometer/pulse_times_s"]);
        assert_eq!(
            tachometer(json!({ "pulse_times_s": [0, 0.1, 0.2], "pulses_per_turn": 0 })),
            ["/tachometer/pulses_per_turn"]
        );
        assert_eq!(tachometer(json!({ "pulse_times_s": [0, 0.1, 0.2], "threshold": 1 })), ["/tachometer/threshold"]);
    }
}
