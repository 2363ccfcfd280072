//! A time series as JSON, CSV or NumPy array file. It is read, formatted and sent chunk by chunk, and never held as a whole.

use std::collections::VecDeque;
use std::ops::Range;

use axum::body::{Body, Bytes};
use axum::http::header::{ACCEPT_RANGES, CONTENT_LENGTH, CONTENT_RANGE};
use axum::http::{HeaderValue, StatusCode};
use axum::response::Response;
use futures_util::stream;

use super::error::ApiError;
use super::range::{Requested, requested};
use super::stored_answer::{CSV, NPY, json_text, respond};
use crate::contract::Thinning;
use crate::contract::answer::csv;
use crate::jobs::{JobError, StoredSeries};

/// A part of a stored series.
#[derive(Debug, Clone)]
pub struct Part {
    pub series: StoredSeries,
    pub places: Range<usize>,
    /// Largest number of points; `None`: all.
    pub max_points: Option<usize>,
}

impl Part {
    fn thinning(&self) -> Option<Thinning> {
        let count = self.places.len();
        self.max_points.filter(|most| *most < count).map(|most| Thinning::new(count, most))
    }

    /// The part in a format; of a NumPy file the requested range of bytes (`Range`). What is sent has been compared with its digests
    /// before.
    pub async fn answer(self, format: &'static str, range: Option<&str>) -> Result<Response, ApiError> {
        match format {
            NPY => self.npy(range).await,
            CSV => {
                self.count().await?;
                let head = csv::series_head(self.series.channel(), self.series.unit());
                let steps = [Step::Text(head.into()), Step::Points(Column::Lines)];
                Ok(respond(CSV, self.body(steps)))
            }
            format => {
                self.count().await?;
                let [channel, unit] = [self.series.channel(), self.series.unit()].map(|text| json_text(&text));
                let mut head = b"{\"channel\":".to_vec();
                head.extend(channel?);
                head.extend(b",\"unit\":");
                head.extend(unit?);
                if let Some(step) = self.series.step() {
                    head.extend(b",\"dt_s\":");
                    head.extend(json_text(&step)?);
                }
                head.extend(b",\"time_s\":[");
                let steps = [
                    Step::Text(head.into()),
                    Step::Points(Column::Times),
                    Step::Text(Bytes::from_static(b"],\"value\":[")),
                    Step::Points(Column::Values),
                    Step::Text(Bytes::from_static(b"]}")),
                ];
                Ok(respond(format, self.body(steps)))
            }
        }
    }

    /// Number of points, after all of their values have been compared with their digests.
    async fn count(&self) -> Result<usize, ApiError> {
        let Some(mut thinning) = self.thinning() else {
            self.series.check(self.places.clone()).await?;
            return Ok(self.places.len());
        };
        let (mut count, mut at) = (0, self.places.start);
        while at < self.places.end {
            let values = self.series.values(at..self.places.end).await?;
            at += values.len();
            values.into_iter().for_each(|value| thinning.pass(value, |_, _| count += 1));
        }
        Ok(count)
    }

    async fn npy(mut self, range: Option<&str>) -> Result<Response, ApiError> {
        // Without thinning the length is known, and only the requested values are read.
        let points = if self.max_points.is_some() { self.count().await? } else { self.places.len() };
        let head = csv::npy_head(points);
        let length = (head.len() + points * csv::NPY_RECORD_BYTES) as u64;
        let requested = range.map_or(Requested::Whole, |range| requested(range, length));
        let bytes = match &requested {
            Requested::Whole => 0..length,
            Requested::Part(part) => part.clone(),
            Requested::Unsatisfiable => return Err(ApiError::Unsatisfiable { length }),
        };
        let mut skipped = 0;
        if self.max_points.is_none() {
            let record = |byte: u64| byte.saturating_sub(head.len() as u64) / csv::NPY_RECORD_BYTES as u64;
            let (first, last) = (record(bytes.start), record(bytes.end - 1));
            let places = self.places.start + first as usize..self.places.start + last as usize + 1;
            skipped = first * csv::NPY_RECORD_BYTES as u64;
            self.places = places.start..places.end.min(self.places.end);
            self.count().await?;
        }
        let steps = [Step::Text(head.into()), Step::Points(Column::Records)];
        let mut response = respond(NPY, self.cut_body(steps, bytes.start - skipped, bytes.end - bytes.start));
        let headers = response.headers_mut();
        headers.insert(ACCEPT_RANGES, HeaderValue::from_static("bytes"));
        headers.insert(CONTENT_LENGTH, (bytes.end - bytes.start).into());
        if let Requested::Part(Range { start, end }) = requested {
            let text = format!("bytes {start}-{}/{length}", end - 1);
            headers.insert(CONTENT_RANGE, HeaderValue::try_from(text).map_err(|_| ApiError::Internal)?);
            *response.status_mut() = StatusCode::PARTIAL_CONTENT;
        }
        Ok(response)
    }

    fn body(self, steps: impl Into<VecDeque<Step>>) -> Body {
        self.cut_body(steps, 0, u64::MAX)
    }

    /// The body without its first `skip` bytes, and with at most `left` bytes.
    fn cut_body(self, steps: impl Into<VecDeque<Step>>, skip: u64, left: u64) -> Body {
        let writer = Writer { steps: steps.into(), column: None, skip, left, part: self };
        Body::from_stream(stream::try_unfold(writer, |mut writer| async move {
            Ok::<_, JobError>(writer.next().await?.map(|bytes| (bytes, writer)))
        }))
    }
}

/// A step of writing a body.
enum Step {
    Text(Bytes),
    Points(Column),
}

/// Values that are written of each point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    /// Times with commas between them.
    Times,
    /// Values with commas between them.
    Values,
    /// Lines of a table.
    Lines,
    /// Records of a NumPy file.
    Records,
}

/// Writer of a body.
struct Writer {
    part: Part,
    steps: VecDeque<Step>,
    /// The points that are being written.
    column: Option<Points>,
    /// Bytes to be left out.
    skip: u64,
    /// Bytes to be written after them.
    left: u64,
}

/// Progress within the points.
struct Points {
    column: Column,
    thinning: Option<Thinning>,
    /// Place of the next value.
    at: usize,
    /// True if no point has been written.
    is_first: bool,
}

impl Writer {
    /// The next bytes of the body; `None` after the last.
    async fn next(&mut self) -> Result<Option<Bytes>, JobError> {
        while self.left > 0 {
            let bytes = match &self.column {
                Some(points) if points.at < self.part.places.end => self.points().await?,
                Some(_) => {
                    self.column = None;
                    continue;
                }
                None => match self.steps.pop_front() {
                    Some(Step::Text(text)) => text,
                    Some(Step::Points(column)) => {
                        let (thinning, at) = (self.part.thinning(), self.part.places.start);
                        self.column = Some(Points { column, thinning, at, is_first: true });
                        continue;
                    }
                    None => return Ok(None),
                },
            };
            let skipped = bytes.len().min(usize::try_from(self.skip).unwrap_or(usize::MAX));
            self.skip -= skipped as u64;
            let length = (bytes.len() - skipped).min(usize::try_from(self.left).unwrap_or(usize::MAX));
            self.left -= length as u64;
            if length > 0 {
                return Ok(Some(bytes.slice(skipped..skipped + length)));
            }
        }
        Ok(None)
    }

    /// The points of the next chunk. They are formatted on a thread that serves no HTTP.
    async fn points(&mut self) -> Result<Bytes, JobError> {
        let Some(mut points) = self.column.take() else { return Ok(Bytes::new()) };
        let values = self.part.series.values(points.at..self.part.places.end).await?;
        let (series, start) = (self.part.series.clone(), self.part.places.start);
        let write = move || {
            let first = points.at;
            points.at += values.len();
            let mut text = Vec::with_capacity(40 * values.len());
            match points.thinning.take() {
                None => {
                    values
                        .iter()
                        .enumerate()
                        .for_each(|(k, value)| points.write(series.time(first + k), *value, &mut text));
                }
                Some(mut thinning) => {
                    for value in values {
                        thinning.pass(value, |place, value| points.write(series.time(start + place), value, &mut text));
                    }
                    points.thinning = Some(thinning);
                }
            }
            (points, Bytes::from(text))
        };
        let written = tokio::task::spawn_blocking(write).await;
        let (points, bytes) = written.map_err(|error| JobError::Corrupt(error.to_string()))?;
        self.column = Some(points);
        Ok(bytes)
    }
}

impl Points {
    fn write(&mut self, time: f64, value: f64, to: &mut Vec<u8>) {
        let number = match self.column {
            Column::Lines => return csv::write_line(time, value, to),
            Column::Records => return csv::write_record(time, value, to),
            Column::Times => time,
            Column::Values => value,
        };
        if !std::mem::take(&mut self.is_first) {
            to.push(b',');
        }
        // Writing to memory cannot fail.
        let _ = serde_json::to_writer(to, &number);
    }
}
