//! Data of the plots of a run, as they are stored: rounded to visible digits.

use serde::{Deserialize, Serialize};

use super::signals::SeriesAnswer;
use crate::contract::json::numbers::rounded;
use raceway_core::simulation::recording::plot_data::{Orbit, PlotData, Trace};

/// Significant digits of a plotted value.
const DIGITS: i32 = 4;

/// Data of all plots of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ViewsAnswer {
    /// Signals, thinned so that peaks are kept.
    pub traces: Vec<TraceView>,
    pub orbits: Vec<OrbitView>,
    pub loads: Option<LoadsView>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub impact: Option<ImpactView>,
}

/// A signal of the spindle, thinned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TraceView {
    pub channel: String,
    pub unit: String,
    pub start_s: f64,
    pub step_s: f64,
    /// Steps between successive values: small numbers take little space.
    pub steps: Vec<usize>,
    pub value: Vec<f64>,
}

impl TraceView {
    /// The signal with its times.
    pub fn series(self) -> SeriesAnswer {
        let places = self.steps.iter().scan(0, |place, step| {
            *place += step;
            Some(*place)
        });
        SeriesAnswer {
            time_s: places.map(|place| self.start_s + place as f64 * self.step_s).collect(),
            channel: self.channel,
            unit: self.unit,
            dt_s: Some(self.step_s),
            value: self.value,
        }
    }
}

/// The path of a body's centre [µm].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OrbitView {
    pub body: String,
    pub y: Vec<f64>,
    pub z: Vec<f64>,
}

/// The spindle's acceleration around its largest peak, with the passages over defects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImpactView {
    pub traces: Vec<TraceView>,
    pub peak_s: f64,
    /// Times of entry and exit.
    pub passages_s: Vec<(f64, f64)>,
}

/// Raceway loads of ball 1 against its azimuth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LoadsView {
    pub azimuth_deg: Vec<f64>,
    pub inner_n: Vec<f64>,
    pub outer_n: Vec<f64>,
}

impl ViewsAnswer {
    pub fn of(views: &PlotData) -> Self {
        Self {
            traces: views.traces.iter().map(trace).collect(),
            orbits: views.orbits.iter().map(orbit).collect(),
            loads: views.loads.as_ref().map(|loads| LoadsView {
                azimuth_deg: loads.azimuth.iter().map(|azimuth| rounded(azimuth.to_degrees(), DIGITS)).collect(),
                inner_n: all(&loads.inner),
                outer_n: all(&loads.outer),
            }),
            impact: views.impact.as_ref().map(|impact| ImpactView {
                traces: impact.traces.iter().map(trace).collect(),
                peak_s: impact.peak,
                passages_s: impact.passages.iter().map(|passage| (passage.entry, passage.exit)).collect(),
            }),
        }
    }

    /// True if there are no data.
    pub fn is_empty(&self) -> bool {
        self.traces.is_empty() && self.orbits.is_empty() && self.loads.is_none()
    }
}

/// The values rounded relative to their range, so that a small orbit far from the origin keeps its digits.
fn all(values: &[f64]) -> Vec<f64> {
    let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(least, most), &v| (least.min(v), most.max(v)));
    let span = most - least;
    if !(span > 0.0 && span.is_finite()) {
        return values.iter().map(|value| rounded(*value, DIGITS)).collect();
    }
    let places = DIGITS - 1 - span.log10().floor() as i32;
    let scale = 10_f64.powi(places.clamp(-300, 300));
    values.iter().map(|value| (value * scale).round() / scale).collect()
}

fn trace(trace: &Trace) -> TraceView {
    let before = std::iter::once(0).chain(trace.place.iter().copied());
    TraceView {
        channel: trace.channel.to_string(),
        unit: trace.channel.unit().to_owned(),
        start_s: trace.start,
        step_s: trace.step,
        steps: trace.place.iter().zip(before).map(|(place, before)| place - before).collect(),
        value: all(&trace.value),
    }
}

fn orbit(orbit: &Orbit) -> OrbitView {
    OrbitView { body: orbit.body.to_owned(), y: all(&orbit.y), z: all(&orbit.z) }
}
