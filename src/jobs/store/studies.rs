//! Studies: their points, claimed one by one and fenced like jobs, and the shards that run them. A shard is one delivery of a study;
//! the tables call it `strand`.

use jiff::{SignedDuration, Timestamp};
use serde::de::DeserializeOwned;
use sqlx::FromRow;
use uuid::Uuid;

use super::claims::Heartbeat;
use super::compression::{compressed, decompressed};
use super::database::{Store, in_time};
use super::dialect::Dialect;
use super::digest::{Place, Sealed, is_intact};
use super::due;
use super::notifications::notify_ended;
use super::part_names::{METRICS, REQUEST, point_name};
use super::pool::Tx;
use super::results;
use super::reuse::{Reusable, reusable};
use super::sealed_request::{SEALED_REQUEST, SealedRequest};
use super::statement::statement;
use super::stored_time::{expiry, micros, stored};
use crate::contract::answer::point::PointError;
use crate::contract::{JobKind, PointEnd, PointStatus};
use crate::jobs::error::JobError;
use crate::jobs::job::{Failure, INTERNAL, Status, TIME_LIMIT, WORKER_LOST};

/// A shard and its study.
#[derive(Debug, Clone)]
pub struct StudyShard {
    pub job: Uuid,
    pub delivery: i64,
    pub owner: String,
    /// `None`: the stored request is not what was written.
    pub request: Option<String>,
    pub keep_for_s: Option<f64>,
}

/// A point that a shard runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PointClaim {
    pub number: usize,
    claim: i64,
}

/// The outcome of a point.
#[derive(Debug, Clone)]
pub struct PointResult {
    pub end: PointEnd,
    pub reused: bool,
    pub content_hash: Option<Vec<u8>>,
    /// Processor time [s] that no heartbeat has recorded.
    pub used_s: f64,
}

/// The next action of a shard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    Point(PointClaim),
    /// No point waits; other shards may still run some.
    Nothing,
    /// The study has ended.
    Ended,
    /// The study was cancelled.
    Cancelled,
    /// Points wait, and other work is due.
    GiveWay,
}

/// A stored point.
#[derive(Debug, Clone)]
pub struct StoredPoint {
    pub number: usize,
    pub status: PointStatus,
    pub reused: bool,
    /// Compressed JSON.
    pub answer: Option<Vec<u8>>,
}

/// Inserts the points of a study and its shards.
pub async fn insert(tx: &mut Tx, job: Uuid, points: usize, deliveries: &[i64]) -> Result<(), JobError> {
    let points = i64::try_from(points).unwrap_or(i64::MAX);
    let sql = "INSERT INTO studies (job, points) VALUES ($1, $2)";
    statement(sql).bind(job).bind(points).run(&mut *tx).await?;
    let sql = "WITH RECURSIVE n (i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE i + 1 < $2) \
               INSERT INTO points (job, number) SELECT $1, i FROM n";
    statement(sql).bind(job).bind(points).run(&mut *tx).await?;
    add_shards(tx, job, deliveries).await
}

/// Inserts shards.
pub async fn add_shards(tx: &mut Tx, job: Uuid, deliveries: &[i64]) -> Result<(), JobError> {
    for delivery in deliveries {
        let sql = "INSERT INTO strands (delivery, job, owner, waiting_since) SELECT $1, id, owner, $3 FROM jobs WHERE id = $2";
        let since = stored(Timestamp::now());
        statement(sql).bind(delivery).bind(job).bind(since).run(&mut *tx).await?;
    }
    Ok(())
}

async fn remove_shards(tx: &mut Tx, job: Uuid) -> Result<(), JobError> {
    statement("DELETE FROM strands WHERE job = $1").bind(job).run(&mut *tx).await?;
    Ok(())
}

/// Takes the shard of a delivery from those that wait; `None`: its study has ended.
pub async fn take(tx: &mut Tx, delivery: i64) -> Result<Option<StudyShard>, JobError> {
    let sql =
        format!("UPDATE strands SET waiting_since = NULL, heartbeat_at = {} WHERE delivery = $1", tx.dialect().now());
    statement(sql).bind(delivery).run(&mut *tx).await?;
    let sql = format!(
        "SELECT strands.job, strands.owner, jobs.keep_for_s, {SEALED_REQUEST} \
         FROM strands JOIN jobs ON jobs.id = strands.job \
         WHERE strands.delivery = $1 AND jobs.status IN ('queued', 'running')"
    );
    #[derive(FromRow)]
    struct Row {
        job: Uuid,
        owner: String,
        keep_for_s: Option<f64>,
        #[sqlx(flatten)]
        request: SealedRequest,
    }
    let row: Option<Row> = statement(sql).bind(delivery).optional(&mut *tx).await?;
    Ok(row.map(|Row { job, owner, keep_for_s, request }| {
        let request = request.opened(job, &owner).ok();
        StudyShard { job, delivery, owner, request, keep_for_s }
    }))
}

impl Store {
    /// Starts a shard. Points that it was running were lost with their process: they are queued again, or fail after
    /// `max_lost_runs` losses.
    pub async fn start_shard(&self, shard: &StudyShard, max_lost_runs: u32) -> Result<(), JobError> {
        let mut tx = self.begin().await?;
        let sql = "UPDATE jobs SET status = 'running', started_at = coalesce(started_at, $2) \
                   WHERE id = $1 AND status IN ('queued', 'running')";
        statement(sql).bind(shard.job).bind(stored(Timestamp::now())).run(&mut tx).await?;
        lose_points(&mut tx, shard.job, shard.delivery, max_lost_runs).await?;
        tx.commit().await
    }

    /// Writes the end of a point, if any, and claims the next point unless the shard gives way, in one transaction.
    pub async fn advance(
        &self,
        shard: &StudyShard,
        ended: Option<(PointClaim, &PointResult)>,
        slice_is_over: bool,
        keep_s: f64,
    ) -> Result<Next, JobError> {
        let mut tx = self.begin().await?;
        if let Some((point, result)) = ended {
            write_end(&mut tx, shard.job, point, result).await?;
            due::charge(&shard.owner, result.used_s).run(&mut tx).await?;
        }
        // A turn takes one point at least.
        let may_give_way = ended.is_some().then_some(slice_is_over);
        let next = next(&mut tx, shard, may_give_way, keep_s).await?;
        tx.commit().await?;
        Ok(next)
    }

    /// Cancels the study of a shard. It does nothing if another shard has done so: the study may have been resumed with new shards.
    pub async fn cancel_study(&self, shard: &StudyShard, keep_s: f64) -> Result<(), JobError> {
        let mut tx = self.begin().await?;
        let sql = "SELECT EXISTS (SELECT 1 FROM strands WHERE delivery = $1)";
        if statement(sql).bind(shard.delivery).value(&mut tx).await?.unwrap_or(false) {
            cancel(&mut tx, shard.job, keep_s).await?;
        }
        tx.commit().await
    }

    /// Records that a shard is alive, and the time that it used since the last record [s].
    pub async fn shard_heartbeat(&self, shard: &StudyShard, used_s: f64) -> Result<Heartbeat, JobError> {
        let sql = format!(
            "UPDATE strands SET heartbeat_at = {} WHERE delivery = $1 \
             RETURNING (SELECT cancel_requested_at IS NOT NULL FROM jobs WHERE id = strands.job)",
            self.dialect().now()
        );
        let mut tx = self.begin().await?;
        let cancel_requested: Option<bool> = statement(sql).bind(shard.delivery).value(&mut tx).await?;
        due::charge(&shard.owner, used_s).run(&mut tx).await?;
        tx.commit().await?;
        Ok(Heartbeat::of(cancel_requested))
    }

    /// Marks a shard that stops running points as waiting. Its silence is no loss.
    pub async fn rest_shard(&self, delivery: i64) -> Result<(), JobError> {
        let sql = "UPDATE strands SET heartbeat_at = NULL, waiting_since = $2 WHERE delivery = $1";
        statement(sql).bind(delivery).bind(stored(Timestamp::now())).run(&self.writer).await?;
        Ok(())
    }

    /// Removes a shard for which no point is left.
    pub async fn remove_shard(&self, delivery: i64) -> Result<(), JobError> {
        statement("DELETE FROM strands WHERE delivery = $1").bind(delivery).run(&self.writer).await?;
        Ok(())
    }

    /// Charges the owner of a shard for processor time that no heartbeat has recorded [s].
    pub async fn charge(&self, shard: &StudyShard, used_s: f64) -> Result<(), JobError> {
        due::charge(&shard.owner, used_s).run(&self.writer).await?;
        Ok(())
    }

    /// Fails a study whose stored request is not what was written.
    pub async fn fail_corrupt(&self, shard: &StudyShard, failure: &Failure, keep_s: f64) -> Result<(), JobError> {
        let mut tx = self.begin().await?;
        fail(&mut tx, shard.job, failure, keep_s).await?;
        tx.commit().await
    }

    /// Returns an unfinished point to the queue.
    pub async fn give_back(&self, shard: &StudyShard, point: PointClaim) -> Result<(), JobError> {
        let sql =
            "UPDATE points SET status = 'queued' WHERE job = $1 AND number = $2 AND claim = $3 AND status = 'running'";
        let number = i64::try_from(point.number).unwrap_or(i64::MAX);
        statement(sql).bind(shard.job).bind(number).bind(point.claim).run(&self.writer).await?;
        Ok(())
    }

    /// The end of identical finished work of the same owner, a point or a simulation, by `point_hashes`. An answer that is not what
    /// was written does not count.
    pub async fn known_end(&self, owner: &str, hashes: &[Vec<u8>; 2]) -> Result<Option<PointEnd>, JobError> {
        match self.known_point(owner, &hashes[0]).await? {
            Some(end) => Ok(Some(end)),
            None => self.known_simulation(owner, hashes).await,
        }
    }

    async fn known_point(&self, owner: &str, hash: &[u8]) -> Result<Option<PointEnd>, JobError> {
        let sql = "SELECT points.job, points.number, points.answer, points.digest FROM points \
                   JOIN jobs ON jobs.id = points.job \
                   WHERE points.content_hash = $1 AND points.status = 'succeeded' AND jobs.owner = $2 LIMIT 1";
        let row = statement(sql)
            .bind(hash)
            .bind(owner)
            .optional::<(Uuid, i64, Vec<u8>, Option<Vec<u8>>)>(&self.readers)
            .await?;
        let Some((job, number, answer, digest)) = row else { return Ok(None) };
        let place = Place::of_point(job, number, "succeeded", Some(hash));
        let answer = Sealed::stored((answer, digest)).opened(&place).and_then(|answer| decompressed(&answer));
        let end = answer.and_then(|answer| Ok(PointEnd::Succeeded(parsed(&answer)?)));
        unless_corrupt(self.noted(job, &point_name(number), end).await)
    }

    async fn known_simulation(&self, owner: &str, hashes: &[Vec<u8>; 2]) -> Result<Option<PointEnd>, JobError> {
        for work in hashes {
            let Some(Reusable { job, result, is_sound }) = reusable(&self.readers, owner, work, "").await? else {
                continue;
            };
            if !is_sound {
                self.found_corrupt(job, REQUEST).await;
                continue;
            }
            let sql = "SELECT metrics, digest FROM results WHERE id = $1";
            let row: Option<(String, Option<Vec<u8>>)> = statement(sql).bind(result).optional(&self.readers).await?;
            let missing = || JobError::Corrupt("its row is missing".to_owned());
            let end = row.ok_or_else(missing).and_then(|row| {
                let metrics = Sealed::stored(row).opened(&Place::of_result(result, METRICS))?;
                Ok(PointEnd::of_stored(parsed(metrics.as_bytes())?))
            });
            if let Some(end) = unless_corrupt(self.noted(job, METRICS, end).await)? {
                return Ok(Some(end));
            }
        }
        Ok(None)
    }

    /// The request of a study, and its points in order.
    pub async fn points(&self, owner: &str, job: Uuid) -> Result<(String, Vec<StoredPoint>), JobError> {
        let sql = format!("SELECT kind, status, {SEALED_REQUEST} FROM jobs WHERE id = $1 AND owner = $2");
        #[derive(FromRow)]
        struct StudyRow {
            kind: String,
            status: String,
            #[sqlx(flatten)]
            request: SealedRequest,
        }
        let row: Option<StudyRow> = in_time(statement(sql).bind(job).bind(owner).optional(&self.readers)).await?;
        let StudyRow { kind, status: study, request } = row.ok_or(JobError::NotFound)?;
        if !JobKind::has_points(&kind) {
            return Err(JobError::OtherKind { kind });
        }
        let request = self.noted(job, REQUEST, request.opened(job, owner)).await?;
        let sql =
            "SELECT number, status, reused, answer, digest, content_hash FROM points WHERE job = $1 ORDER BY number";
        type Row = (i64, String, bool, Option<Vec<u8>>, Option<Vec<u8>>, Option<Vec<u8>>);
        let rows: Result<Vec<Row>, _> = statement(sql).bind(job).all(&self.readers).await;
        let rows = self.noted(job, "points", rows).await?;
        let damaged = rows.iter().find(|(number, status, _, answer, digest, work)| {
            let place = || Place::of_point(job, *number, status, work.as_deref());
            answer.as_ref().is_some_and(|answer| !is_intact(&place(), answer, digest.as_deref()))
        });
        if let Some((number, ..)) = damaged {
            let part = point_name(*number);
            return self.noted(job, &part, Err(JobError::ResultCorrupt { part: part.clone() })).await;
        }
        let points = rows.into_iter().map(|(number, status, reused, answer, ..)| {
            let status = match status.as_str() {
                "succeeded" => PointStatus::Succeeded,
                "failed" => PointStatus::Failed,
                _ if study == Status::Cancelled.name() => PointStatus::Cancelled,
                "running" => PointStatus::Running,
                _ => PointStatus::Queued,
            };
            Ok(StoredPoint { number: usize::try_from(number).unwrap_or(usize::MAX), status, reused, answer })
        });
        Ok((request, points.collect::<Result<_, JobError>>()?))
    }
}

fn parsed<T: DeserializeOwned>(text: &[u8]) -> Result<T, JobError> {
    serde_json::from_slice(text).map_err(|error| JobError::Corrupt(error.to_string()))
}

/// An answer for reuse; `None` if it is not what was written.
fn unless_corrupt<T>(read: Result<T, JobError>) -> Result<Option<T>, JobError> {
    match read {
        Err(JobError::ResultCorrupt { .. }) => Ok(None),
        read => read.map(Some),
    }
}

/// Queues the points again that a lost shard was running, or fails them after `max_lost_runs` losses.
async fn lose_points(tx: &mut Tx, job: Uuid, delivery: i64, max_lost_runs: u32) -> Result<(), JobError> {
    let sql = "UPDATE points SET status = 'queued', lost = lost + 1 WHERE strand = $1 AND status = 'running' \
               RETURNING number, claim, lost";
    let lost: Vec<(i64, i64, i64)> = statement(sql).bind(delivery).all(&mut *tx).await?;
    for (number, claim, lost) in lost {
        if u32::try_from(lost).unwrap_or(u32::MAX) >= max_lost_runs {
            let detail = format!("the process that ran the point ended {lost} times during the run");
            let error = PointError { cause: WORKER_LOST.to_owned(), detail, errors: Vec::new() };
            let sql = "UPDATE points SET status = 'running' WHERE job = $1 AND number = $2";
            statement(sql).bind(job).bind(number).run(&mut *tx).await?;
            let point = PointClaim { number: usize::try_from(number).unwrap_or(0), claim };
            let result = PointResult { end: PointEnd::Failed(error), reused: false, content_hash: None, used_s: 0.0 };
            write_end(tx, job, point, &result).await?;
        }
    }
    Ok(())
}

/// Removes shards that have sent no heartbeat for `lost_after`, on a database that several processes share.
pub async fn remove_lost_shards(tx: &mut Tx, lost_after: SignedDuration, max_lost_runs: u32) -> Result<(), JobError> {
    // The shards of a file end with its process, and the next process redelivers them.
    if tx.dialect() == Dialect::Sqlite {
        return Ok(());
    }
    let sql = format!("DELETE FROM strands WHERE heartbeat_at < {} - $1 RETURNING delivery, job", tx.dialect().now());
    let lost: Vec<(i64, Uuid)> = statement(sql).bind(micros(lost_after)).all(&mut *tx).await?;
    for (delivery, job) in lost {
        lose_points(tx, job, delivery, max_lost_runs).await?;
    }
    Ok(())
}

/// Writes the end of a point and counts it; does nothing if the claim is lost.
async fn write_end(tx: &mut Tx, job: Uuid, point: PointClaim, result: &PointResult) -> Result<(), JobError> {
    let (status, cause, answer) = match &result.end {
        PointEnd::Succeeded(metrics) => ("succeeded", None, compressed(metrics)?),
        PointEnd::Failed(error) => ("failed", Some(&error.cause), compressed(error)?),
    };
    let number = i64::try_from(point.number).unwrap_or(i64::MAX);
    let work = result.content_hash.as_deref().filter(|_| status == "succeeded");
    let Sealed { content, digest } = Sealed::new(&Place::of_point(job, number, status, work), answer);
    let sql = "UPDATE points SET status = $4, cause = $5, answer = $6, reused = $7, content_hash = $8, digest = $9 \
               WHERE job = $1 AND number = $2 AND claim = $3 AND status = 'running'";
    let written = statement(sql)
        .bind(job)
        .bind(number)
        .bind(point.claim)
        .bind(status)
        .bind(cause)
        .bind(content)
        .bind(result.reused)
        .bind(work)
        .bind(digest.as_deref())
        .run(&mut *tx)
        .await?;
    if written == 0 {
        return Ok(());
    }
    let sql = "UPDATE studies SET ended = ended + 1, succeeded = succeeded + $2 WHERE job = $1";
    statement(sql).bind(job).bind(i64::from(status == "succeeded")).run(&mut *tx).await?;
    let sql = "UPDATE jobs SET heartbeat_at = $2, \
               progress = (SELECT ended * 1.0 / points FROM studies WHERE job = $1), \
               points_left = (SELECT points - ended FROM studies WHERE job = $1) WHERE id = $1";
    statement(sql).bind(job).bind(stored(Timestamp::now())).run(&mut *tx).await?;
    Ok(())
}

/// The next action of a shard. It may give way to other work if `slice_is_over` is known.
async fn next(tx: &mut Tx, shard: &StudyShard, slice_is_over: Option<bool>, keep_s: f64) -> Result<Next, JobError> {
    // An update, so that no other shard counts or claims points before this transaction ends.
    statement("UPDATE studies SET ended = ended WHERE job = $1").bind(shard.job).run(&mut *tx).await?;
    let sql = "SELECT jobs.cancel_requested_at IS NOT NULL, studies.points, studies.ended, studies.succeeded \
               FROM jobs JOIN studies ON studies.job = jobs.id WHERE jobs.id = $1 AND jobs.status = 'running'";
    let counts: Option<(bool, i64, i64, i64)> = statement(sql).bind(shard.job).optional(&mut *tx).await?;
    let Some((cancel_requested, points, ended, succeeded)) = counts else { return Ok(Next::Ended) };
    if ended == points {
        end(tx, shard.job, succeeded > 0, shard.keep_for_s.unwrap_or(keep_s)).await?;
        return Ok(Next::Ended);
    }
    if cancel_requested {
        cancel(tx, shard.job, keep_s).await?;
        return Ok(Next::Cancelled);
    }
    if let Some(slice_is_over) = slice_is_over
        && due::gives_way(tx, &shard.owner, slice_is_over).await?
    {
        return Ok(Next::GiveWay);
    }
    let sql = "UPDATE points SET status = 'running', claim = claim + 1, strand = $2 WHERE job = $1 \
               AND number = (SELECT min(number) FROM points WHERE job = $1 AND status = 'queued') \
               AND EXISTS (SELECT 1 FROM strands WHERE delivery = $2) RETURNING number, claim";
    let claimed: Option<(i64, i64)> = statement(sql).bind(shard.job).bind(shard.delivery).optional(&mut *tx).await?;
    Ok(match claimed {
        Some((number, claim)) => {
            Next::Point(PointClaim { number: usize::try_from(number).unwrap_or(usize::MAX), claim })
        }
        None => Next::Nothing,
    })
}

/// Ends a study after its last point.
async fn end(tx: &mut Tx, job: Uuid, succeeded: bool, keep_s: f64) -> Result<(), JobError> {
    let (status, result, failure) = if succeeded {
        (Status::Succeeded, Some(results::insert_empty(tx).await?), None)
    } else {
        let sql =
            "SELECT cause FROM points WHERE job = $1 AND cause IS NOT NULL ORDER BY cause = 'invalid', number LIMIT 1";
        let cause: Option<String> = statement(sql).bind(job).value(&mut *tx).await?;
        let failure = Failure::new(
            cause.as_deref().unwrap_or(INTERNAL),
            "no point of the study succeeded; its table lists the causes",
        );
        (Status::Failed, None, Some(failure))
    };
    let now = Timestamp::now();
    let sql = "UPDATE jobs SET status = $2, result_id = $3, error_cause = $4, error_detail = $5, finished_at = $6, \
               expires_at = $7, progress = 1 WHERE id = $1";
    statement(sql)
        .bind(job)
        .bind(status.name())
        .bind(result)
        .bind(failure.as_ref().map(|failure| &failure.cause))
        .bind(failure.as_ref().map(|failure| &failure.detail))
        .bind(stored(now))
        .bind(stored(expiry(now, keep_s)))
        .run(&mut *tx)
        .await?;
    notify_ended(tx, job).await?;
    remove_shards(tx, job).await?;
    tracing::info!(%job, status = status.name(), "a study has ended");
    Ok(())
}

/// Fails a study.
async fn fail(tx: &mut Tx, job: Uuid, failure: &Failure, keep_s: f64) -> Result<(), JobError> {
    let now = stored(Timestamp::now());
    let sql = "UPDATE jobs SET status = 'failed', error_cause = $2, error_detail = $3, finished_at = $4, \
               expires_at = $4 + CAST(coalesce(keep_for_s, $5) * 1e6 AS BIGINT) \
               WHERE id = $1 AND status IN ('queued', 'running')";
    let failed = statement(sql).bind(job).bind(&failure.cause).bind(&failure.detail).bind(now).bind(keep_s);
    failed.run(&mut *tx).await?;
    let sql = "UPDATE points SET status = 'queued' WHERE job = $1 AND status = 'running'";
    statement(sql).bind(job).run(&mut *tx).await?;
    notify_ended(tx, job).await?;
    remove_shards(tx, job).await
}

/// Cancels a study, which is kept for `keep_s` unless it states its own retention: finished points are kept, running points are queued again.
pub async fn cancel(tx: &mut Tx, job: Uuid, keep_s: f64) -> Result<(), JobError> {
    let now = Timestamp::now();
    let sql = "UPDATE jobs SET status = 'cancelled', cancel_requested_at = coalesce(cancel_requested_at, $2), \
               finished_at = $2, expires_at = $2 + CAST(coalesce(keep_for_s, $3) * 1e6 AS BIGINT) \
               WHERE id = $1 AND status IN ('queued', 'running')";
    statement(sql).bind(job).bind(stored(now)).bind(keep_s).run(&mut *tx).await?;
    let sql = "UPDATE points SET status = 'queued' WHERE job = $1 AND status = 'running'";
    statement(sql).bind(job).run(&mut *tx).await?;
    notify_ended(tx, job).await?;
    remove_shards(tx, job).await
}

/// Returns whether a shard is running points of a study.
pub async fn is_under_way(tx: &mut Tx, job: Uuid) -> Result<bool, JobError> {
    // A file has no other process.
    if tx.dialect() == Dialect::Sqlite {
        return Ok(false);
    }
    let sql = "SELECT EXISTS (SELECT 1 FROM strands WHERE job = $1 AND heartbeat_at IS NOT NULL)";
    Ok(statement(sql).bind(job).value(&mut *tx).await?.unwrap_or(false))
}

/// Resumes a study. Points that failed by a time limit, a lost worker or an internal error are queued again. Returns false if no
/// point is left.
pub async fn resume(tx: &mut Tx, job: Uuid) -> Result<bool, JobError> {
    let sql = "UPDATE points SET status = 'queued', cause = NULL, answer = NULL, digest = NULL, lost = 0 \
               WHERE job = $1 AND status = 'failed' AND cause IN ($2, $3, $4)";
    let again = statement(sql).bind(job).bind(TIME_LIMIT).bind(WORKER_LOST).bind(INTERNAL).run(&mut *tx).await?;
    let sql = "UPDATE studies SET ended = ended - $2 WHERE job = $1 RETURNING points > ended";
    let again = i64::try_from(again).unwrap_or(0);
    let left: Option<bool> = statement(sql).bind(job).bind(again).value(&mut *tx).await?;
    if left != Some(true) {
        return Ok(false);
    }
    let result: Option<Option<Uuid>> =
        statement("SELECT result_id FROM jobs WHERE id = $1").bind(job).value(&mut *tx).await?;
    let sql = "UPDATE jobs SET status = 'queued', started_at = NULL, finished_at = NULL, expires_at = NULL, \
               cancel_requested_at = NULL, error_cause = NULL, error_detail = NULL, result_id = NULL, \
               progress = (SELECT ended * 1.0 / points FROM studies WHERE job = $1), \
               points_left = (SELECT points - ended FROM studies WHERE job = $1) WHERE id = $1";
    statement(sql).bind(job).run(&mut *tx).await?;
    if let Some(result) = result.flatten() {
        results::remove_orphan(tx, result).await?;
    }
    Ok(true)
}

/// Unfinished studies with too few shards, each with the number of missing ones.
///
/// A study has one shard for each slot as long as points wait. If it has none, its running points are queued again.
pub async fn missing_shards(tx: &mut Tx, slots: usize, keep_s: f64) -> Result<Vec<(Uuid, usize)>, JobError> {
    let orphaned = tx.dialect().is_orphaned();
    let sql = format!(
        "SELECT jobs.id, \
         (SELECT count(*) FROM strands JOIN river_job ON river_job.id = strands.delivery WHERE strands.job = jobs.id \
          AND river_job.state NOT IN ('completed', 'cancelled', 'discarded') \
          AND NOT (strands.heartbeat_at IS NULL AND {orphaned})), \
         (SELECT count(*) FROM points WHERE points.job = jobs.id AND points.status = 'queued'), \
         cancel_requested_at IS NOT NULL FROM jobs WHERE kind IN ('study', 'uncertainty') AND status IN ('queued', 'running')"
    );
    let studies: Vec<(Uuid, i64, i64, bool)> = statement(sql).all(&mut *tx).await?;
    let mut missing = Vec::new();
    for (study, shards, waiting, cancel_requested) in studies {
        // No shard runs that could end it.
        if cancel_requested && !is_under_way(tx, study).await? {
            cancel(tx, study, keep_s).await?;
            continue;
        }
        if shards == 0 {
            let sql = "UPDATE points SET status = 'queued' WHERE job = $1 AND status = 'running'";
            statement(sql).bind(study).run(&mut *tx).await?;
            remove_shards(tx, study).await?;
        }
        let [shards, waiting] = [shards, waiting].map(|count| usize::try_from(count).unwrap_or(0));
        let wanted = waiting.min(slots).max(1);
        if shards < wanted {
            missing.push((study, wanted - shards));
        }
    }
    Ok(missing)
}
