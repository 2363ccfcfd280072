//! Requests about jobs: submit, read, wait, cancel, resume and delete.

use std::sync::Arc;
use std::time::Duration;

use uuid::Uuid;

use super::error::JobError;
use super::intake::Submitted;
use super::job::{IdempotencyKey, JobRecord, NewJob, Status};
use super::parts::Parts;
use super::places::Places;
use super::running::{Completion, StopReason, View};
use super::store::database::in_time;
use super::store::notifications::{notify_cancelled, notify_ended};
use super::store::pool::Tx;
use super::store::records::{self, Filter};
use super::store::results::Fingerprint;
use super::store::series_reader::StoredSeries;
use super::store::signal::Signal;
use super::store::studies::{self, StoredPoint};
use super::store::tokens::Token;
use super::store::uploaded_series::{PackedSeries, UploadedSeries, uploads};
use super::store::{maintenance, removal, submissions};
use crate::contract::{Job, JobKind, SpectrumAnswer, SpectrumKind, Uploads, named_series};

/// Longest time that a readiness probe waits for the database.
const PING_TIMEOUT: Duration = Duration::from_secs(2);

/// Time after which a waiting request reads the job again without a notification.
const POLL_INTERVAL: Duration = Duration::from_secs(1);

/// The jobs of the service.
#[derive(Clone)]
pub struct Jobs {
    pub(super) parts: Arc<Parts>,
}

/// Answer to a cancellation.
#[derive(Debug, Clone, PartialEq)]
pub enum Cancelled {
    /// The job will not run, or had been cancelled before.
    Now(JobRecord),
    /// The job is running and has been asked to stop.
    Soon(JobRecord),
}

impl Jobs {
    /// The tokens of the database, at most a second old while the database answers.
    pub fn tokens(&self) -> Arc<[Token]> {
        self.parts.tokens.get()
    }

    /// The current tokens of the database, for a token that is not known yet.
    pub async fn tokens_now(&self) -> Result<Arc<[Token]>, JobError> {
        in_time(self.parts.tokens.refresh()).await?;
        Ok(self.parts.tokens.get())
    }

    /// Submits a job; it is on disk when this returns. The same idempotency key with the same body returns the first answer again.
    pub async fn submit(&self, job: &Job, owner: &str, key: Option<IdempotencyKey>) -> Result<Submitted, JobError> {
        if self.is_stopping() {
            return Err(JobError::Stopping);
        }
        self.parts.check_file_in_place()?;
        self.parts.store.note(in_time(self.parts.intake.submit(NewJob::new(job, owner, key))).await)
    }

    /// Stores a series of an owner; it is on disk when this returns.
    pub async fn add_series(&self, owner: &str, series: &PackedSeries) -> Result<UploadedSeries, JobError> {
        if self.is_stopping() {
            return Err(JobError::Stopping);
        }
        self.parts.check_file_in_place()?;
        self.parts.store.note(in_time(self.parts.store.add_series(owner, series)).await)
    }

    /// A series of an owner.
    pub async fn uploaded_series(&self, owner: &str, hash: &str) -> Result<UploadedSeries, JobError> {
        in_time(self.parts.store.series_of_load(owner, hash)).await
    }

    /// The series of an owner, newest first.
    pub async fn all_series(&self, owner: &str) -> Result<Vec<UploadedSeries>, JobError> {
        in_time(self.parts.store.all_series(owner)).await
    }

    /// Removes a series that no unfinished job names.
    pub async fn delete_series(&self, owner: &str, hash: &str) -> Result<(), JobError> {
        self.parts.store.note(in_time(self.parts.store.delete_series(owner, hash)).await)
    }

    /// The series of an owner that a request names.
    pub async fn named_series(&self, owner: &str, request: &[u8]) -> Result<Uploads, JobError> {
        let hashes = named_series(request);
        if hashes.is_empty() {
            return Ok(Uploads::default());
        }
        let packed = self.parts.store.note(in_time(self.parts.store.packed_series(owner, &hashes)).await)?;
        uploads(packed).await
    }

    /// A job with its current progress.
    pub async fn get(&self, owner: &str, id: Uuid) -> Result<JobRecord, JobError> {
        Ok(self.with_progress(self.found(owner, id, in_time(self.parts.store.job(owner, id)).await).await?))
    }

    /// A job, with the metrics of a succeeded simulation as JSON text.
    pub async fn get_with_metrics(&self, owner: &str, id: Uuid) -> Result<(JobRecord, Option<String>), JobError> {
        let read = in_time(self.parts.store.job_with_metrics(owner, id)).await;
        let (record, metrics) = self.found(owner, id, read).await?;
        Ok((self.with_progress(record), metrics))
    }

    /// The read part of a job, or its last state if the job has expired.
    async fn found<T>(&self, owner: &str, id: Uuid, read: Result<T, JobError>) -> Result<T, JobError> {
        match read {
            Err(JobError::NotFound) => match in_time(self.parts.store.expired_job(owner, id)).await? {
                Some(expired) => Err(JobError::Expired(Box::new(expired))),
                None => Err(JobError::NotFound),
            },
            read => read,
        }
    }

    /// A page of jobs, newest first, and the job after which the next page starts.
    pub async fn list(&self, owner: &str, filter: &Filter) -> Result<(Vec<JobRecord>, Option<Uuid>), JobError> {
        let (page, next) = in_time(self.parts.store.jobs(owner, filter)).await?;
        Ok((page.into_iter().map(|record| self.with_progress(record)).collect(), next))
    }

    /// The record of a job with its current progress.
    pub fn with_progress(&self, mut record: JobRecord) -> JobRecord {
        // The shards of a study write its progress with every point.
        if record.status == Status::Running
            && !JobKind::has_points(&record.kind)
            && let Some(run) = self.parts.running.get(record.id)
        {
            record.progress = run.progress();
        }
        record
    }

    /// Phase and levels of a run of this process; `None` if the job does not run here.
    pub fn view(&self, id: Uuid) -> Option<View> {
        self.parts.running.get(id).map(|run| run.view())
    }

    /// A receiver that changes when the job ends. It must be taken before the job is read.
    pub fn completion(&self, id: Uuid) -> Completion {
        self.parts.running.completion(id)
    }

    /// Returns whether the service accepts no more jobs.
    pub fn is_stopping(&self) -> bool {
        self.parts.is_stopping()
    }

    /// The job with its metrics, once it has ended or after `timeout`.
    pub async fn wait(
        &self,
        owner: &str,
        id: Uuid,
        timeout: Duration,
    ) -> Result<(JobRecord, Option<String>), JobError> {
        let mut completion = self.completion(id);
        let until = tokio::time::Instant::now() + timeout;
        loop {
            let current = self.get_with_metrics(owner, id).await;
            let left = until.saturating_duration_since(tokio::time::Instant::now());
            let is_unfinished = match &current {
                Ok((record, _)) => !record.status.is_final(),
                // The job is stored, even if the database is unreachable for now.
                Err(error) => error.is_away(),
            };
            if !is_unfinished || left.is_zero() || self.is_stopping() {
                return current;
            }
            tokio::select! {
                _ = completion.changed() => {
                    let end = completion.borrow().clone();
                    return match end {
                        // The owner was checked when the job was read.
                        Some(end) if current.is_ok() => Ok((end.record.clone(), end.metrics.clone())),
                        _ => self.get_with_metrics(owner, id).await,
                    };
                }
                // A notification of another process may be lost.
                () = tokio::time::sleep(left.min(POLL_INTERVAL)) => {}
                // The job runs again after the next start; the client gets its id before this process ends.
                () = self.parts.stopping.cancelled() => {}
            }
        }
    }

    /// Cancels a queued or running job.
    pub async fn cancel(&self, owner: &str, id: Uuid) -> Result<Cancelled, JobError> {
        let cancelled = in_time(self.try_cancel(owner, id)).await;
        self.found(owner, id, self.parts.store.note(cancelled)).await
    }

    async fn try_cancel(&self, owner: &str, id: Uuid) -> Result<Cancelled, JobError> {
        let mut tx = self.parts.store.begin().await?;
        let (mut status, delivery, kind) = records::locked_status(&mut tx, owner, id).await?;
        let is_study = JobKind::has_points(&kind);
        match status {
            Status::Queued | Status::Running if is_study => {
                records::request_cancel(&mut tx, id).await?;
                match self.parts.running.get(id) {
                    // Its shards end it.
                    Some(run) => run.stop(StopReason::Cancelled),
                    // Its shards run elsewhere, and end it.
                    None if studies::is_under_way(&mut tx, id).await? => notify_cancelled(&mut tx, id).await?,
                    None => {
                        studies::cancel(&mut tx, id, self.parts.settings.keep_s).await?;
                        status = Status::Queued;
                    }
                }
            }
            Status::Queued => {
                records::cancel_queued(&mut tx, id, self.parts.settings.keep_s).await?;
                notify_ended(&mut tx, id).await?;
                if let Some(delivery) = delivery {
                    self.parts.queue.cancel(&mut tx, delivery).await?;
                }
            }
            Status::Running => {
                // Before the request is written: the run must stop even if a full disk refuses the write.
                if let Some(run) = self.parts.running.get(id) {
                    run.stop(StopReason::Cancelled);
                }
                records::request_cancel(&mut tx, id).await?;
                notify_cancelled(&mut tx, id).await?;
            }
            Status::Cancelled => {}
            Status::Succeeded | Status::Failed => return Err(JobError::Conflict(status)),
        }
        tx.commit().await?;
        if status == Status::Queued {
            self.parts.running.ended(id);
        }
        let record = self.get(owner, id).await?;
        Ok(if status == Status::Running { Cancelled::Soon(record) } else { Cancelled::Now(record) })
    }

    /// Resumes a study that was cancelled or has points that failed for a temporary cause. Finished points are kept.
    pub async fn resume(&self, owner: &str, id: Uuid) -> Result<JobRecord, JobError> {
        let resumed = in_time(self.try_resume(owner, id)).await;
        self.found(owner, id, self.parts.store.note(resumed)).await
    }

    async fn try_resume(&self, owner: &str, id: Uuid) -> Result<JobRecord, JobError> {
        if self.is_stopping() {
            return Err(JobError::Stopping);
        }
        let mut tx = self.parts.store.begin().await?;
        let (status, _, kind) = records::locked_status(&mut tx, owner, id).await?;
        if !JobKind::has_points(&kind) {
            return Err(JobError::NoStudy { kind });
        }
        if !status.is_final() || !studies::resume(&mut tx, id).await? {
            return Err(JobError::CannotResume(status));
        }
        self.check_points(&mut tx, owner).await?;
        let shards = maintenance::slots(&mut tx).await?;
        let deliveries = self.parts.queue.enqueue(&mut tx, shards).await?;
        studies::add_shards(&mut tx, id, &deliveries).await?;
        tx.commit().await?;
        self.parts.queue.wake();
        self.get(owner, id).await
    }

    /// Checks the limits of unfinished points after a study was resumed.
    async fn check_points(&self, tx: &mut Tx, owner: &str) -> Result<(), JobError> {
        let has_tokens = !owner.is_empty() || !self.parts.tokens.get().is_empty();
        let unfinished = submissions::unfinished(tx).await?;
        Places::new(self.parts.settings.work_limits, has_tokens, unfinished).take(owner, Some(0))
    }

    /// The request of a study and its points.
    pub async fn points(&self, owner: &str, id: Uuid) -> Result<(String, Vec<StoredPoint>), JobError> {
        self.found(owner, id, self.parts.store.points(owner, id).await).await
    }

    /// Removes an ended job with its result.
    pub async fn delete(&self, owner: &str, id: Uuid) -> Result<(), JobError> {
        self.found(owner, id, in_time(self.try_delete(owner, id)).await).await
    }

    async fn try_delete(&self, owner: &str, id: Uuid) -> Result<(), JobError> {
        let mut tx = self.parts.store.begin().await?;
        let (status, _, _) = records::locked_status(&mut tx, owner, id).await?;
        if !status.is_final() {
            return Err(JobError::Conflict(status));
        }
        removal::delete(&mut tx, id).await?;
        tx.commit().await
    }

    /// The metrics of a succeeded simulation or machine job, as JSON text.
    pub async fn metrics(&self, owner: &str, id: Uuid, kind: JobKind) -> Result<String, JobError> {
        self.found(owner, id, self.parts.store.metrics(owner, id, kind).await).await
    }

    /// A spectrum of a succeeded simulation or machine job.
    pub async fn spectrum(
        &self,
        owner: &str,
        id: Uuid,
        kind: SpectrumKind,
        channel: &str,
    ) -> Result<SpectrumAnswer, JobError> {
        self.found(owner, id, self.parts.store.spectrum(owner, id, kind, channel).await).await
    }

    /// A series of a succeeded simulation.
    pub async fn series(&self, owner: &str, id: Uuid, channel: &str) -> Result<StoredSeries, JobError> {
        self.found(owner, id, self.parts.store.series(owner, id, channel).await).await
    }

    /// Channels for which a succeeded simulation or machine job keeps a signal of this kind.
    pub async fn channels(&self, owner: &str, id: Uuid, signal: Signal) -> Result<Vec<String>, JobError> {
        self.found(owner, id, self.parts.store.channels(owner, id, signal).await).await
    }

    /// Digest of everything that determines the result of a succeeded job; `None` for any other job.
    pub async fn fingerprint(&self, owner: &str, id: Uuid) -> Result<Option<Fingerprint>, JobError> {
        in_time(self.parts.store.fingerprint(owner, id)).await
    }

    /// Data of the plots of a succeeded simulation, as JSON text; `None` if none are kept.
    pub async fn views(&self, owner: &str, id: Uuid) -> Result<Option<Vec<u8>>, JobError> {
        self.found(owner, id, self.parts.store.views(owner, id).await).await
    }

    /// The report of a succeeded optimum or accuracy job, as JSON text.
    pub async fn report(&self, owner: &str, id: Uuid, kind: JobKind) -> Result<Vec<u8>, JobError> {
        self.found(owner, id, self.parts.store.report(owner, id, kind).await).await
    }

    /// Number of jobs whose stored result is known to be corrupt, if jobs can be accepted now.
    pub async fn ready(&self) -> Result<i64, JobError> {
        if self.is_stopping() {
            return Err(JobError::Stopping);
        }
        if self.parts.store.disk_is_full() {
            return Err(JobError::DiskFull);
        }
        self.parts.check_file_in_place()?;
        let answered = tokio::time::timeout(PING_TIMEOUT, self.parts.store.corrupt_results()).await;
        let corrupt = answered.unwrap_or(Err(JobError::Database(sqlx::Error::PoolTimedOut)))?;
        if self.parts.store.is_unwritable() { Err(JobError::NotWritable) } else { Ok(corrupt) }
    }

    /// Counts and times of this process, and the depth of the queue, as OpenMetrics text.
    pub async fn service_metrics(&self) -> Result<String, JobError> {
        let depth = in_time(self.parts.store.queue_depth()).await?;
        self.parts.store.metrics.text(&depth)
    }
}
