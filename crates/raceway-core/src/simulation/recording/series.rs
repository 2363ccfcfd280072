//! Requested time series on their way from a recorder to their receiver.

use std::collections::BTreeMap;
use std::fmt::{self, Debug};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::simulation::input::channel::Channel;
use crate::simulation::input::control::Control;
use crate::simulation::input::series_sink::SeriesSink;
use crate::simulation::input::settings::Outputs;

/// Values that are converted to their unit together.
const CONVERTED: usize = 1024;

/// The series of one attempt. Its receiver drops them with the last copy of this, unless they are kept.
#[derive(Clone)]
pub(crate) struct SeriesRecording(Arc<Recorded>);

struct Recorded {
    sink: Arc<dyn SeriesSink>,
    number: u64,
    series: Vec<Progress>,
    is_kept: AtomicBool,
}

#[derive(Default)]
struct Progress {
    length: AtomicUsize,
    not_finite: AtomicBool,
}

impl SeriesRecording {
    /// Begins a recording; `None` if no series is requested, or if nobody receives it.
    pub fn begin(outputs: &Outputs, control: &Control<'_>) -> Option<Self> {
        let sink = Arc::clone(control.series.filter(|_| !outputs.series.is_empty())?);
        let series = outputs.series.iter().map(|_| Progress::default()).collect();
        Some(Self(Arc::new(Recorded { number: sink.begin(), sink, series, is_kept: AtomicBool::new(false) })))
    }

    /// Passes on the next values [SI] of a series.
    pub fn write(&self, series: usize, channel: Channel, values: &[f64]) {
        let Some(progress) = self.0.series.get(series) else { return };
        let scale = channel.scale();
        for values in values.chunks(CONVERTED) {
            let mut converted = [0.0; CONVERTED];
            for (to, from) in converted.iter_mut().zip(values) {
                *to = scale * from;
            }
            let converted = &converted[..values.len()];
            if !converted.iter().all(|value| value.is_finite()) {
                progress.not_finite.store(true, Ordering::Relaxed);
            }
            self.0.sink.write(self.0.number, series, converted);
        }
        progress.length.fetch_add(values.len(), Ordering::Relaxed);
    }

    /// Number of values of a series so far.
    pub fn length(&self, series: usize) -> usize {
        self.0.series.get(series).map_or(0, |progress| progress.length.load(Ordering::Relaxed))
    }

    /// Returns whether all values of a series are finite.
    pub fn is_finite(&self, series: usize) -> bool {
        self.0.series.get(series).is_none_or(|progress| !progress.not_finite.load(Ordering::Relaxed))
    }

    /// Leaves the series to the receiver: the attempt is the result.
    pub fn keep(&self) {
        self.0.is_kept.store(true, Ordering::Relaxed);
    }
}

impl Drop for Recorded {
    fn drop(&mut self) {
        if !self.is_kept.load(Ordering::Relaxed) {
            self.sink.discard(self.number);
        }
    }
}

impl Debug for SeriesRecording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SeriesRecording").field("number", &self.0.number).finish_non_exhaustive()
    }
}

/// Receiver that holds the series in memory.
#[derive(Debug, Default)]
pub(crate) struct SeriesInMemory {
    /// Values of each series, by recording.
    recordings: Mutex<BTreeMap<u64, BTreeMap<usize, Vec<f64>>>>,
}

impl SeriesInMemory {
    fn recordings(&self) -> MutexGuard<'_, BTreeMap<u64, BTreeMap<usize, Vec<f64>>>> {
        self.recordings.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The values of the series of the recording that was kept, by number.
    pub fn take(&self) -> BTreeMap<usize, Vec<f64>> {
        self.recordings().pop_last().map(|(_, series)| series).unwrap_or_default()
    }
}

impl SeriesSink for SeriesInMemory {
    fn begin(&self) -> u64 {
        let mut recordings = self.recordings();
        let number = recordings.last_key_value().map_or(0, |(last, _)| last + 1);
        recordings.insert(number, BTreeMap::new());
        number
    }

    fn write(&self, recording: u64, series: usize, values: &[f64]) {
        if let Some(recording) = self.recordings().get_mut(&recording) {
            recording.entry(series).or_default().extend(values);
        }
    }

    fn discard(&self, recording: u64) {
        self.recordings().remove(&recording);
    }
}
