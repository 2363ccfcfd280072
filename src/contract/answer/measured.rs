//! A measured record beside a prediction, as JSON.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::spectrum_view::SpectrumQuantity;

/// A measured record beside a prediction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MeasurementComparison)]
pub struct MeasuredAnswer {
    /// The predicted channel.
    #[schema(example = "spindle.y.acceleration")]
    pub channel: String,
    /// Unit of measured and predicted amplitudes.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// Factor on the measured values; absent where nothing was scaled.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub gain: Option<GainAnswer>,
    /// The measured record.
    pub measured: ComparedRecordAnswer,
    /// The prediction.
    pub predicted: ComparedRecordAnswer,
    /// Resolution of both spectra [Hz]; both have a Hann window.
    #[schema(minimum = 0)]
    pub resolution_hz: f64,
    /// Lowest compared frequency [Hz].
    #[schema(minimum = 0)]
    pub from_hz: f64,
    /// Highest compared frequency [Hz]: 0.4 times the lower sampling rate, at most 20 kHz.
    #[schema(minimum = 0)]
    pub to_hz: f64,
    /// Levels over the compared band and in each band.
    pub levels: Vec<LevelComparisonAnswer>,
    /// Predicted lines with the measured lines that belong to them: those of `lines` of the metrics in their sequence, then at most 20 weaker
    /// peaks of the predicted spectrum, strongest first and without labels.
    pub lines: Vec<LineComparisonAnswer>,
    /// Lines without a partner.
    pub unmatched: UnmatchedLinesAnswer,
    /// Lines of the envelope; absent where the prediction kept none, or analysed a band that the record does not cover.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub envelope: Option<EnvelopeComparisonAnswer>,
    /// Limits of this comparison, each as one sentence.
    pub notes: Vec<String>,
}

/// A factor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GainAnswer {
    /// The factor [-].
    #[schema(minimum = 0)]
    pub factor: f64,
    /// The same, 20 lg [dB].
    pub db: f64,
}

/// Record behind a spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ComparedRecordAnswer {
    /// Mean speed of the shaft [r/min], by which frequencies are divided.
    #[schema(minimum = 0)]
    pub speed_rpm: f64,
    /// Number of time windows whose power is averaged.
    #[schema(minimum = 1)]
    pub averages: usize,
}

/// A measured and a predicted level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LevelComparisonAnswer {
    /// Motion of the level.
    pub quantity: SpectrumQuantity,
    /// Lower end of the band [Hz].
    #[schema(minimum = 0)]
    pub from_hz: f64,
    /// Upper end of the band [Hz].
    #[schema(minimum = 0)]
    pub to_hz: f64,
    /// Unit of both values.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// Measured root mean square, in `unit`.
    #[schema(minimum = 0)]
    pub measured: f64,
    /// Predicted root mean square, in `unit`.
    #[schema(minimum = 0)]
    pub predicted: f64,
    /// Apparent transfer, 20 lg(measured / predicted) [dB]. The path from the bearing to the sensor is unknown, so that this is no error of the
    /// prediction. Absent where a value is 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub level_ratio_db: Option<f64>,
    /// Estimated numerical error of the predicted level from 0 to 20 kHz [dB], as in the metrics; on the whole band only.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub predicted_error_db: Option<f64>,
    /// Standard deviation of the predicted level between time windows [dB], as in the metrics; on the whole band only.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub predicted_scatter_db: Option<f64>,
}

/// A predicted line and the measured line that belongs to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LineComparisonAnswer {
    /// Label of the predicted line; empty where it has none.
    #[schema(example = "BPFO")]
    pub label: String,
    /// Predicted frequency over the predicted speed of the shaft [-].
    #[schema(minimum = 0)]
    pub predicted_order: f64,
    /// Measured frequency over the measured speed of the shaft [-].
    #[schema(minimum = 0)]
    pub measured_order: f64,
    /// Measured less predicted order, over the predicted one [%].
    pub order_difference_percent: f64,
    /// Predicted amplitude.
    #[schema(minimum = 0)]
    pub predicted_amplitude: f64,
    /// Measured amplitude.
    #[schema(minimum = 0)]
    pub measured_amplitude: f64,
    /// Apparent transfer at the line, 20 lg(measured / predicted) [dB]; of squared envelopes 10 lg. Only differences between lines of one narrow
    /// band test the prediction.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub level_ratio_db: Option<f64>,
    /// Height of the measured line over the floor around it [dB]; absent where the floor is 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub over_floor_db: Option<f64>,
}

/// Lines without a partner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct UnmatchedLinesAnswer {
    /// Predicted lines that were not measured.
    pub predicted: Vec<UnmatchedLineAnswer>,
    /// Measured lines that were not predicted, strongest first, at most 20.
    pub measured: Vec<UnmatchedLineAnswer>,
}

/// A line without a partner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct UnmatchedLineAnswer {
    /// Label of a predicted line; empty where it has none, and of measured lines.
    #[schema(example = "2·BPFI")]
    pub label: String,
    /// Frequency over the speed of the shaft [-].
    #[schema(minimum = 0)]
    pub order: f64,
    /// Frequency of the line [Hz].
    #[schema(minimum = 0)]
    pub frequency_hz: f64,
    /// Amplitude of the line.
    #[schema(minimum = 0)]
    pub amplitude: f64,
}

/// Measured and predicted lines of the envelope.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EnvelopeComparisonAnswer {
    /// Unit of the amplitudes.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// Lower and upper end of the band whose envelope is analysed [Hz].
    #[schema(min_items = 2, max_items = 2)]
    pub band_hz: Vec<f64>,
    /// Predicted lines with the measured lines that belong to them.
    pub lines: Vec<LineComparisonAnswer>,
    /// Lines without a partner.
    pub unmatched: UnmatchedLinesAnswer,
}
