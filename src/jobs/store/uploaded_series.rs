//! Uploaded series. They stay for a time after the last job that names them; their hash is remembered for a while longer.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use jiff::{SignedDuration, Timestamp};
use raceway_core::physics::samples::Samples;
use sha2::{Digest, Sha256};
use sqlx::FromRow;

use super::compression::{decompressed, deflated};
use super::database::Store;
use super::statement::statement;
use super::stored_time::{micros, stored, time};
use crate::contract::Uploads;
use crate::jobs::error::JobError;

/// Time that a series is kept after the last job that names it.
const KEPT: SignedDuration = SignedDuration::from_hours(30 * 24);
/// Largest stored content of all series of an owner [bytes].
pub const BYTES_OF_OWNER: i64 = 1 << 30;
/// Largest number of listed series of an owner.
const MOST_LISTED: i64 = 1000;

/// A series without its values.
#[derive(Debug, Clone, PartialEq)]
pub struct UploadedSeries {
    pub hash: String,
    pub rate_hz: f64,
    pub count: u64,
    /// Length of the stored content.
    pub bytes: u64,
    pub created_at: Timestamp,
    pub expires_at: Timestamp,
}

/// A series in its stored form.
#[derive(Debug, Clone, FromRow)]
pub struct PackedSeries {
    hash: String,
    rate_hz: f64,
    count: i64,
    content: Vec<u8>,
}

impl PackedSeries {
    pub fn new(samples: &Samples) -> Result<Self, JobError> {
        let values: Vec<u8> = samples.values().iter().flat_map(|value| value.to_le_bytes()).collect();
        Ok(Self {
            hash: content_hash(samples.rate(), &values),
            rate_hz: samples.rate(),
            count: i64::try_from(samples.values().len()).unwrap_or(i64::MAX),
            content: deflated(&values)?,
        })
    }
}

/// SHA-256 of rate and values, in hexadecimal digits.
fn content_hash(rate_hz: f64, values: &[u8]) -> String {
    let digest = Sha256::new().chain_update(rate_hz.to_le_bytes()).chain_update(values).finalize();
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[derive(FromRow)]
struct Row {
    hash: String,
    rate_hz: f64,
    count: i64,
    bytes: i64,
    created_at: i64,
    expires_at: i64,
    is_there: bool,
}

impl Row {
    /// The series; an error if it has expired.
    fn series(self) -> Result<UploadedSeries, JobError> {
        let expires_at = time(self.expires_at)?;
        if !self.is_there {
            return Err(JobError::SeriesExpired { hash: self.hash, expired_at: expires_at });
        }
        Ok(UploadedSeries {
            hash: self.hash,
            rate_hz: self.rate_hz,
            count: u64::try_from(self.count).unwrap_or_default(),
            bytes: u64::try_from(self.bytes).unwrap_or_default(),
            created_at: time(self.created_at)?,
            expires_at,
        })
    }
}

/// Columns of `Row`.
const COLUMNS: &str = "hash, rate_hz, count, bytes, created_at, expires_at, content IS NOT NULL AS is_there";

/// Condition that an unfinished job of the owner names the series.
const IS_NAMED: &str = "EXISTS (SELECT 1 FROM jobs WHERE jobs.owner = uploaded_series.owner \
     AND jobs.status IN ('queued', 'running') AND jobs.request LIKE '%' || uploaded_series.hash || '%')";

impl Store {
    /// Stores a series of an owner, or puts off its expiry where it is there.
    pub async fn add_series(&self, owner: &str, series: &PackedSeries) -> Result<UploadedSeries, JobError> {
        let now = Timestamp::now();
        let expires_at = stored(now).saturating_add(micros(KEPT));
        let bytes = i64::try_from(series.content.len()).unwrap_or(i64::MAX);
        let mut tx = self.begin().await?;
        let sql = "SELECT CAST(coalesce(sum(bytes), 0) AS BIGINT) FROM uploaded_series WHERE owner = $1 AND hash <> $2";
        let used: i64 = statement(sql).bind(owner).bind(&series.hash).value(&mut tx).await?.unwrap_or(0);
        if used.saturating_add(bytes) > BYTES_OF_OWNER {
            return Err(JobError::SeriesFull { used, limit: BYTES_OF_OWNER });
        }
        let sql = format!(
            "INSERT INTO uploaded_series (owner, hash, rate_hz, count, content, bytes, created_at, expires_at) \
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8) ON CONFLICT (owner, hash) DO UPDATE SET \
             content = excluded.content, bytes = excluded.bytes, expires_at = excluded.expires_at RETURNING {COLUMNS}"
        );
        let row: Row = statement(sql)
            .bind(owner)
            .bind(&series.hash)
            .bind(series.rate_hz)
            .bind(series.count)
            .bind(&series.content)
            .bind(bytes)
            .bind(stored(now))
            .bind(expires_at)
            .one(&mut tx)
            .await?;
        tx.commit().await?;
        row.series()
    }

    /// A series of an owner.
    pub async fn series_of_load(&self, owner: &str, hash: &str) -> Result<UploadedSeries, JobError> {
        let sql = format!("SELECT {COLUMNS} FROM uploaded_series WHERE owner = $1 AND hash = $2");
        let row: Option<Row> = statement(sql).bind(owner).bind(hash).optional(&self.readers).await?;
        row.ok_or(JobError::NoSeries)?.series()
    }

    /// The series of an owner, newest first, and the sum of their stored bytes.
    pub async fn all_series(&self, owner: &str) -> Result<Vec<UploadedSeries>, JobError> {
        let sql = format!(
            "SELECT {COLUMNS} FROM uploaded_series WHERE owner = $1 AND content IS NOT NULL \
             ORDER BY created_at DESC, hash LIMIT $2"
        );
        let rows: Vec<Row> = statement(sql).bind(owner).bind(MOST_LISTED).all(&self.readers).await?;
        rows.into_iter().map(Row::series).collect()
    }

    /// The series of an owner that a request names, for a job, in their stored form: puts off their expiry. Series that are not there are left out.
    pub async fn packed_series(&self, owner: &str, hashes: &BTreeSet<String>) -> Result<Vec<PackedSeries>, JobError> {
        let mut known = Vec::with_capacity(hashes.len());
        for hash in hashes {
            let sql =
                "UPDATE uploaded_series SET expires_at = $3 WHERE owner = $1 AND hash = $2 AND content IS NOT NULL";
            let expires_at = stored(Timestamp::now()).saturating_add(micros(KEPT));
            statement(sql).bind(owner).bind(hash).bind(expires_at).run(&self.writer).await?;
            // Megabytes are not read on the only connection that writes to a file.
            let sql = "SELECT hash, rate_hz, count, content FROM uploaded_series \
                       WHERE owner = $1 AND hash = $2 AND content IS NOT NULL";
            match statement(sql).bind(owner).bind(hash).optional(&self.readers).await? {
                Some(series) => known.push(series),
                // Expired, or never there.
                None => match self.series_of_load(owner, hash).await {
                    Err(expired @ JobError::SeriesExpired { .. }) => return Err(expired),
                    Ok(_) | Err(JobError::NoSeries) => {}
                    Err(error) => return Err(error),
                },
            }
        }
        Ok(known)
    }

    /// Removes a series that no unfinished job names.
    pub async fn delete_series(&self, owner: &str, hash: &str) -> Result<(), JobError> {
        self.series_of_load(owner, hash).await?;
        let sql = format!("DELETE FROM uploaded_series WHERE owner = $1 AND hash = $2 AND NOT {IS_NAMED}");
        let deleted = statement(sql).bind(owner).bind(hash).run(&self.writer).await?;
        if deleted == 0 { Err(JobError::SeriesInUse) } else { Ok(()) }
    }

    /// Removes the values of expired series that no unfinished job names, and remembers their hashes for `remembered`.
    pub async fn expire_series(&self, remembered: SignedDuration) -> Result<(), JobError> {
        let now = stored(Timestamp::now());
        let sql = "SELECT EXISTS (SELECT 1 FROM uploaded_series WHERE expires_at < $1)";
        if !statement(sql).bind(now).value(&self.readers).await?.unwrap_or(false) {
            return Ok(());
        }
        let sql = format!(
            "UPDATE uploaded_series SET content = NULL, bytes = 0 WHERE expires_at < $1 AND content IS NOT NULL AND NOT {IS_NAMED}"
        );
        statement(sql).bind(now).run(&self.writer).await?;
        let sql = "DELETE FROM uploaded_series WHERE content IS NULL AND expires_at < $1";
        statement(sql).bind(now.saturating_sub(micros(remembered))).run(&self.writer).await?;
        Ok(())
    }
}

/// The values of series, on a thread that serves no connection: a long record takes a second.
pub async fn uploads(packed: Vec<PackedSeries>) -> Result<Uploads, JobError> {
    let unpack = move || {
        let series = packed.into_iter().map(|PackedSeries { hash, rate_hz, content, .. }| {
            let samples = unpacked(&hash, rate_hz, &content)?;
            Ok((hash, Arc::new(samples)))
        });
        Ok(Uploads::new(series.collect::<Result<BTreeMap<_, _>, JobError>>()?))
    };
    let unpacked = tokio::task::spawn_blocking(unpack).await;
    unpacked.map_err(|error| JobError::Corrupt(error.to_string()))?
}

/// The series of a stored content, compared with its hash.
fn unpacked(hash: &str, rate_hz: f64, content: &[u8]) -> Result<Samples, JobError> {
    let values = decompressed(content)?;
    let corrupt = || JobError::ResultCorrupt { part: "uploaded series".to_owned() };
    if content_hash(rate_hz, &values) != hash {
        return Err(corrupt());
    }
    let (values, _) = values.as_chunks::<8>();
    Samples::new(rate_hz, values.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()).ok_or_else(corrupt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_is_unpacked_as_it_was_packed() {
        let samples = Samples::new(1000.0, (0..100).map(|k| f64::from(k).sin()).collect()).unwrap();
        let packed = PackedSeries::new(&samples).unwrap();
        assert_eq!(unpacked(&packed.hash, 1000.0, &packed.content).unwrap(), samples);
        assert!(unpacked(&packed.hash, 1001.0, &packed.content).is_err());
        assert!(crate::contract::is_content_hash(packed.hash.as_bytes()));
    }
}
