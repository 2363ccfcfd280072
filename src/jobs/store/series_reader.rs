//! Time series of succeeded jobs, read chunk by chunk.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::chunk_codec::{CHUNK_VALUES, decoded};
use super::compression::decompressed;
use super::database::Store;
use super::digest::{Place, Sealed};
use super::part_names::signal_name;
use super::signal::{Signal, WITH_SIGNALS};
use super::statement::statement;
use crate::contract::{SeriesAnswer, SeriesHead};
use crate::jobs::error::JobError;

/// Fields of a stored series beside its chunks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredHead {
    #[serde(flatten)]
    pub head: SeriesHead,
    /// Number of the series in the order of the request.
    pub number: i64,
    /// Values of a chunk.
    pub chunk_values: usize,
}

impl StoredHead {
    pub fn new(head: SeriesHead, number: usize) -> Self {
        Self { head, number: i64::try_from(number).unwrap_or(i64::MAX), chunk_values: CHUNK_VALUES }
    }

    /// Number of chunks.
    pub fn chunks(&self) -> usize {
        self.head.length.div_ceil(self.chunk_values.max(1))
    }
}

/// A stored series. Its values are read when they are asked for.
#[derive(Debug, Clone)]
pub struct StoredSeries {
    head: SeriesHead,
    values: Values,
}

#[derive(Debug, Clone)]
enum Values {
    Chunks {
        store: Store,
        job: Uuid,
        result: Uuid,
        head: StoredHead,
    },
    /// In one piece, as earlier versions stored them.
    Whole(Arc<SeriesAnswer>),
}

impl From<SeriesAnswer> for StoredSeries {
    fn from(answer: SeriesAnswer) -> Self {
        let length = answer.time_s.len().min(answer.value.len());
        let head = SeriesHead {
            channel: answer.channel.clone(),
            unit: answer.unit.clone(),
            start_s: 0.0,
            step_s: answer.dt_s.unwrap_or_default(),
            length,
        };
        Self { head, values: Values::Whole(Arc::new(answer)) }
    }
}

impl StoredSeries {
    pub fn channel(&self) -> &str {
        &self.head.channel
    }

    pub fn unit(&self) -> &str {
        &self.head.unit
    }

    /// Time between values [s]; `None` where it is not stored.
    pub fn step(&self) -> Option<f64> {
        (self.head.step_s > 0.0).then_some(self.head.step_s)
    }

    /// Number of values.
    pub fn length(&self) -> usize {
        self.head.length
    }

    /// Time of a value since the start of the run [s].
    pub fn time(&self, place: usize) -> f64 {
        match &self.values {
            Values::Chunks { .. } => self.head.time(place),
            Values::Whole(answer) => answer.time_s[place],
        }
    }

    /// Places of the values from one time to another [s], both included.
    pub fn between(&self, from_s: f64, to_s: f64) -> Range<usize> {
        let end = self.first_place(|time| time > to_s);
        self.first_place(|time| time >= from_s).min(end)..end
    }

    /// The first place whose time fulfils a condition that holds from some time on.
    fn first_place(&self, holds: impl Fn(f64) -> bool) -> usize {
        let mut places = 0..self.head.length;
        while !places.is_empty() {
            let middle = places.start + places.len() / 2;
            if holds(self.time(middle)) { places.end = middle } else { places.start = middle + 1 }
        }
        places.start
    }

    /// Values of these places, from the first on: those of one chunk at most.
    pub async fn values(&self, places: Range<usize>) -> Result<Vec<f64>, JobError> {
        match &self.values {
            Values::Chunks { head, .. } => {
                let number = places.start / head.chunk_values;
                let first = number * head.chunk_values;
                let chunk = self.chunk(number, |content| decoded(&content)).await?;
                let expected = head.chunk_values.min(self.head.length.saturating_sub(first));
                if chunk.len() != expected {
                    return self.noted(Err(JobError::Corrupt("a chunk has another length".to_owned()))).await;
                }
                Ok(chunk[places.start - first..chunk.len().min(places.end - first)].to_vec())
            }
            Values::Whole(answer) => {
                let end = places.end.min(places.start + CHUNK_VALUES);
                Ok(answer.value[places.start..end].to_vec())
            }
        }
    }

    /// The part up to a time after its first value [s], in memory.
    pub async fn beginning(&self, longest_s: f64) -> Result<SeriesAnswer, JobError> {
        let end = if self.head.length == 0 { 0 } else { self.between(f64::NEG_INFINITY, self.time(0) + longest_s).end };
        let mut value = Vec::with_capacity(end);
        while value.len() < end {
            value.extend(self.values(value.len()..end).await?);
        }
        let time_s = (0..end).map(|place| self.time(place)).collect();
        let (channel, unit) = (self.head.channel.clone(), self.head.unit.clone());
        Ok(SeriesAnswer { channel, unit, dt_s: self.step(), time_s, value })
    }

    /// Compares the chunks of these places with their digests.
    pub async fn check(&self, places: Range<usize>) -> Result<(), JobError> {
        let Values::Chunks { head, .. } = &self.values else { return Ok(()) };
        for number in places.start / head.chunk_values..places.end.div_ceil(head.chunk_values) {
            self.chunk(number, |_| Ok(())).await?;
        }
        Ok(())
    }

    async fn chunk<T: Send + 'static>(
        &self,
        number: usize,
        read: fn(Vec<u8>) -> Result<T, JobError>,
    ) -> Result<T, JobError> {
        let Values::Chunks { store, result, head, .. } = &self.values else {
            return Err(JobError::Corrupt("a series in one piece has no chunks".to_owned()));
        };
        let sql = "SELECT content, digest FROM series_chunks WHERE result_id = $1 AND series = $2 AND number = $3";
        let number = i64::try_from(number).unwrap_or(i64::MAX);
        let place = Place::of_chunk(*result, head.number, number);
        let query = statement(sql).bind(*result).bind(head.number).bind(number);
        let read = async {
            let chunk: Option<(Vec<u8>, Option<Vec<u8>>)> = query.optional(&store.readers).await?;
            let missing = || JobError::Corrupt("a chunk is missing".to_owned());
            read(Sealed::stored(chunk.ok_or_else(missing)?).opened(&place)?)
        };
        self.noted(read.await).await
    }

    async fn noted<T>(&self, read: Result<T, JobError>) -> Result<T, JobError> {
        let Values::Chunks { store, job, .. } = &self.values else { return read };
        store.noted(*job, &signal_name(Signal::Series.name(), &self.head.channel), read).await
    }
}

/// Content of a series in the table of signals: its head, or all of it by earlier versions.
enum Stored {
    Head(StoredHead),
    Whole(SeriesAnswer),
}

/// Reads the stored text of a series.
fn stored(text: &[u8]) -> Result<Stored, JobError> {
    if let Ok(head) = serde_json::from_slice(text) {
        return Ok(Stored::Head(head));
    }
    serde_json::from_slice(text).map(Stored::Whole).map_err(|error| JobError::Corrupt(error.to_string()))
}

/// The head of a series that is stored in chunks; `None` if it is stored in one piece.
pub(super) fn head_of(content: &[u8]) -> Result<Option<StoredHead>, JobError> {
    Ok(serde_json::from_slice(&decompressed(content)?).ok())
}

impl Store {
    /// A series of a succeeded job.
    pub async fn series(&self, owner: &str, job: Uuid, channel: &str) -> Result<StoredSeries, JobError> {
        let result = self.result_among(owner, job, &WITH_SIGNALS).await?;
        let open = |content: &[u8]| stored(&decompressed(content)?);
        Ok(match self.signal(job, result, Signal::Series, channel, open).await? {
            Stored::Head(head) => StoredSeries {
                head: head.head.clone(),
                values: Values::Chunks { store: self.clone(), job, result, head },
            },
            Stored::Whole(answer) => answer.into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_between_two_times_include_both() {
        let answer = SeriesAnswer {
            channel: String::new(),
            unit: String::new(),
            dt_s: None,
            time_s: (0..100).map(f64::from).collect(),
            value: vec![0.0; 100],
        };
        let series = StoredSeries::from(answer);
        for ((from, to), places) in [
            ((10.0, 12.0), 10..13),
            ((9.5, 9.6), 10..10),
            ((f64::NEG_INFINITY, f64::INFINITY), 0..100),
            ((98.5, 1e9), 99..100),
            ((-3.0, -1.0), 0..0),
            ((100.0, 200.0), 100..100),
        ] {
            assert_eq!(series.between(from, to), places);
        }
    }

    #[test]
    fn a_head_is_told_from_a_series_in_one_piece() {
        let head =
            SeriesHead { channel: "cage.speed".into(), unit: "Hz".into(), start_s: 0.1, step_s: 1e-5, length: 3 };
        let text = serde_json::to_vec(&StoredHead::new(head.clone(), 2)).expect("JSON");
        let Ok(Stored::Head(found)) = stored(&text) else { panic!("a head") };
        assert_eq!((found.head, found.number, found.chunk_values), (head, 2, CHUNK_VALUES));
        let whole = br#"{"channel":"cage.speed","unit":"Hz","time_s":[0.1,0.2],"value":[1,2]}"#;
        assert!(matches!(stored(whole), Ok(Stored::Whole(answer)) if answer.value == [1.0, 2.0]));
        assert!(stored(b"{}").is_err());
    }
}
