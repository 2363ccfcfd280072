//! Time series of a run on their way to the store. Each attempt at the run is a recording of its own. Chunks are compressed as soon as
//! they are full and stored before they take much memory, so that a run holds a few of them at most.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use raceway_core::simulation::input::series_sink::SeriesSink;
use tokio::runtime::Handle;
use uuid::Uuid;

use super::error::JobError;
use super::running::{Run, StopReason};
use super::store::chunk_codec::{CHUNK_VALUES, encoded};
use super::store::claims::Claim;
use super::store::database::Store;
use super::store::digest::{Place, Sealed};
use super::store::series_chunks::{Chunk, RecordedChunks};

/// Size of compressed chunks from which they are stored [B]. Those of a short run are stored with its result, in one transaction.
const STORED_TOGETHER: usize = 1 << 20;

/// Time between two attempts to store chunks.
const RETRY_INTERVAL: Duration = Duration::from_millis(100);

/// Receiver of the series of a run.
pub struct SeriesWriter {
    store: Store,
    runtime: Handle,
    job: Uuid,
    claim: i64,
    run: Arc<Run>,
    /// When the run exceeds its time limit; `None`: never.
    until: Option<Instant>,
    recordings: Mutex<BTreeMap<u64, Recording>>,
}

/// The series of one attempt.
struct Recording {
    result: Uuid,
    /// True if chunks are stored.
    is_stored: bool,
    series: BTreeMap<usize, Series>,
    chunks: Vec<Chunk>,
    /// Size of the chunks that are not stored yet [B].
    bytes: usize,
}

/// The values of a series after its last chunk.
#[derive(Default)]
struct Series {
    values: Vec<f64>,
    chunks: i64,
}

impl SeriesWriter {
    /// A receiver for the run of a claim. Within the runtime of the service.
    pub fn new(store: Store, claim: &Claim, run: Arc<Run>, time_limit: Duration) -> Self {
        Self {
            store,
            runtime: Handle::current(),
            job: claim.job,
            claim: claim.number,
            run,
            until: Instant::now().checked_add(time_limit),
            recordings: Mutex::default(),
        }
    }

    /// The chunks of the recording that is the result.
    pub fn take(&self) -> Result<RecordedChunks, JobError> {
        let Some((_, mut recording)) = self.recordings().pop_last() else { return Ok(RecordedChunks::none()) };
        recording.end()?;
        Ok(RecordedChunks { result: recording.result, is_stored: recording.is_stored, rest: recording.chunks })
    }

    fn recordings(&self) -> MutexGuard<'_, BTreeMap<u64, Recording>> {
        self.recordings.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stores the chunks of a recording, and retries while the database refuses. Without success the run stops.
    fn store(&self, recording: &mut Recording) {
        let chunks = std::mem::take(&mut recording.chunks);
        recording.bytes = 0;
        while self.run.stopped().is_none() {
            let appended = self.store.append_chunks(self.job, self.claim, recording.result, &chunks);
            match self.store.note(self.runtime.block_on(appended)) {
                Ok(true) => {
                    recording.is_stored = true;
                    return;
                }
                // A job that starts as it is accepted may not be written yet.
                Ok(false) if self.claim > 1 => return self.run.stop(StopReason::ClaimLost),
                Ok(false) => {}
                Err(error) => tracing::error!(%error, job = %self.job, "a time series could not be written; retrying"),
            }
            if self.until.is_some_and(|until| Instant::now() > until) {
                self.run.stop(StopReason::TimeLimit);
            }
            std::thread::sleep(RETRY_INTERVAL);
        }
    }
}

impl Recording {
    fn new() -> Self {
        Self { result: Uuid::now_v7(), is_stored: false, series: BTreeMap::new(), chunks: Vec::new(), bytes: 0 }
    }

    fn write(&mut self, number: usize, mut values: &[f64]) -> Result<(), JobError> {
        while !values.is_empty() {
            let series = self.series.entry(number).or_default();
            let (now, later) = values.split_at(values.len().min(CHUNK_VALUES - series.values.len()));
            series.values.extend(now);
            if series.values.len() == CHUNK_VALUES {
                self.close_chunk(number)?;
            }
            values = later;
        }
        Ok(())
    }

    fn close_chunk(&mut self, number: usize) -> Result<(), JobError> {
        let Some(series) = self.series.get_mut(&number).filter(|series| !series.values.is_empty()) else {
            return Ok(());
        };
        let in_order = i64::try_from(number).unwrap_or(i64::MAX);
        let place = Place::of_chunk(self.result, in_order, series.chunks);
        let content = Sealed::new(&place, encoded(&series.values)?);
        series.values.clear();
        self.bytes += content.content.len();
        self.chunks.push(Chunk { series: in_order, number: series.chunks, content });
        series.chunks += 1;
        Ok(())
    }

    /// Closes the last chunk of every series.
    fn end(&mut self) -> Result<(), JobError> {
        let numbers: Vec<usize> = self.series.keys().copied().collect();
        numbers.into_iter().try_for_each(|number| self.close_chunk(number))
    }
}

impl SeriesSink for SeriesWriter {
    fn begin(&self) -> u64 {
        let mut recordings = self.recordings();
        let number = recordings.last_key_value().map_or(0, |(last, _)| last + 1);
        recordings.insert(number, Recording::new());
        number
    }

    fn write(&self, recording: u64, series: usize, values: &[f64]) {
        let mut recordings = self.recordings();
        let Some(recording) = recordings.get_mut(&recording) else { return };
        if let Err(error) = recording.write(series, values) {
            tracing::error!(%error, job = %self.job, "a time series could not be compressed");
        }
        if recording.bytes >= STORED_TOGETHER {
            self.store(recording);
        }
    }

    fn discard(&self, recording: u64) {
        let Some(recording) = self.recordings().remove(&recording).filter(|recording| recording.is_stored) else {
            return;
        };
        let store = self.store.clone();
        // A sweep removes what is left.
        self.runtime.spawn(async move {
            if let Err(error) = store.remove_recording(recording.result).await {
                tracing::warn!(%error, "the time series of an attempt could not be removed");
            }
        });
    }
}
