//! What the rest of the service asks for: submit, look, cancel, delete. Owns the parts and their order of
//! starting and stopping.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::intake::{Intake, IntakeLimits, Submitted};
use super::lock::DatabaseLock;
use super::queue::{Delivery, Handler, Queue, QueueStats};
use super::running::{Bell, Running, StopReason, View};
use super::store::connections;
use super::store::database::{self, Dialect, Pool};
use super::store::studies::StoredPoint;
use super::store::{Filter, Location, Signal, Store, records, studies, upkeep};
use super::tokens::{KnownTokens, Token};
use super::worker::Worker;
use super::{IdempotencyKey, JobError, JobRecord, NewJob, Status, sweep, tokens};
use crate::contract::{Job, JobKind, Outcome, RunFailure, SpectrumAnswer, SpectrumKind};
use crate::simulation::input::control::Control;

/// What computes a job: the contract's `execute`, or a stand-in of a test.
pub type Simulator = Arc<dyn Fn(&Job, &Control<'_>) -> Result<Outcome, RunFailure> + Send + Sync>;

/// Settings of queue and store.
#[derive(Debug, Clone)]
pub struct Settings {
    pub database: Location,
    /// Runs at a time; 0: other processes run them.
    pub workers: usize,
    /// Jobs that may wait.
    pub queue_limit: u64,
    /// Of these, jobs of one owner.
    pub queue_limit_of_owner: u64,
    /// Runs of a job that may end with their process before the job fails.
    pub max_lost_runs: u32,
    /// Wall time a run may take.
    pub time_limit: Duration,
    /// How long jobs are kept that say nothing about it [s].
    pub keep_s: f64,
    /// Silence after which a run counts as lost.
    pub lost_after: Duration,
    pub sweep_every: Duration,
    /// Pages of 4 KiB at which the database counts as full; tests fill a disk with it.
    pub max_pages: Option<u32>,
}

impl Settings {
    /// The usual settings for a database file.
    pub fn new(database: impl Into<PathBuf>) -> Self {
        Self::on(Location::File(database.into()))
    }

    /// The usual settings for a database.
    pub fn on(database: Location) -> Self {
        Self {
            database,
            workers: std::thread::available_parallelism().map_or(1, usize::from),
            queue_limit: 10_000,
            queue_limit_of_owner: u64::MAX,
            max_lost_runs: 5,
            time_limit: Duration::from_secs(3600),
            keep_s: 30.0 * 86_400.0,
            lost_after: Duration::from_secs(15),
            sweep_every: Duration::from_secs(10),
            max_pages: None,
        }
    }

    /// Time after which a run is given up that does not even hear its stop flag; its own limit comes first.
    pub fn rescue_after(&self) -> Duration {
        self.time_limit.saturating_add(Duration::from_secs(30))
    }
}

/// How long a stopping process waits for a server that does not answer.
const LONGEST_STOP: Duration = Duration::from_secs(8);

/// How long a probe does.
const LONGEST_PING: Duration = Duration::from_secs(2);

/// After which a job that is waited for is looked at without a bell.
const LOOK_AGAIN: Duration = Duration::from_secs(1);

/// Answer to a cancellation.
#[derive(Debug, Clone, PartialEq)]
pub enum Cancelled {
    /// The job will not run, or had been cancelled before.
    Now(JobRecord),
    /// The job is running and has been told to stop.
    Soon(JobRecord),
}

/// The jobs of the service.
#[derive(Clone)]
pub struct Jobs {
    inner: Arc<Inner>,
}

/// The parts.
#[derive(Clone)]
pub(super) struct Inner {
    /// This process among those that share the database.
    pub worker: Uuid,
    pub settings: Settings,
    pub store: Store,
    pub queue: Arc<Queue>,
    pub running: Arc<Running>,
    pub runner: Arc<Worker>,
    pub tokens: Arc<KnownTokens>,
    intake: Intake,
    stopping: CancellationToken,
    lock: Option<Arc<DatabaseLock>>,
}

impl Inner {
    pub fn is_stopping(&self) -> bool {
        self.stopping.is_cancelled()
    }

    /// Whether what is written is there after the next start.
    pub fn check_place(&self) -> Result<(), JobError> {
        let is_in_place = self.lock.as_ref().is_none_or(|lock| lock.is_in_place());
        if is_in_place { Ok(()) } else { Err(JobError::Displaced) }
    }
}

impl Jobs {
    /// Opens the database, brings back what a dead process left, and begins to run jobs.
    pub async fn start(settings: Settings, simulator: Simulator) -> Result<Self, JobError> {
        let lock = match &settings.database {
            Location::File(path) => Some(Arc::new(DatabaseLock::take(path)?)),
            Location::Server(_) => None,
        };
        let opening = |error| JobError::opening(&settings.database, error);
        if let (Location::Server(options), 1..) = (&settings.database, settings.workers) {
            connections::check_room(options).await.map_err(opening)?;
        }
        let store = Store::open(&settings.database, settings.workers, settings.max_pages).await.map_err(opening)?;
        store.migrate().await.map_err(opening)?;
        // A file that may only be read would be found out later, and not by its name.
        store.try_write().await.map_err(opening)?;
        let tokens = Arc::new(KnownTokens::read(&store).await?);
        let running = Arc::new(Running::default());
        let runner = Arc::new(Worker::new(store.clone(), Arc::clone(&running), simulator, settings.clone()));
        let handler: Handler = {
            let runner = Arc::clone(&runner);
            Arc::new(move |ticket| {
                let runner = Arc::clone(&runner);
                Box::pin(async move { runner.work(ticket).await })
            })
        };
        let worker_id = Uuid::now_v7();
        let rescue_after = settings.rescue_after();
        let queue = Queue::new(store.writer().clone(), worker_id, settings.workers, rescue_after, handler)?;
        let queue = Arc::new(queue);
        let limits = IntakeLimits {
            queue: settings.queue_limit,
            queue_of_owner: settings.queue_limit_of_owner,
            keep_s: settings.keep_s,
        };
        let intake = Intake::start(store.clone(), Arc::clone(&queue), Arc::clone(&runner), limits);
        let stopping = CancellationToken::new();
        let inner = Arc::new(Inner {
            worker: worker_id,
            settings,
            store,
            queue,
            running,
            runner,
            tokens,
            intake,
            stopping,
            lock,
        });
        if let Pool::Postgres(pool) = inner.store.writer() {
            listen(pool.clone(), &inner);
        }
        recover(&inner).await?;
        sweep::start(&inner);
        tokens::follow(&inner);
        Ok(Self { inner })
    }

    /// The tokens of the database, as they stood a second ago at most while the database answers.
    pub fn tokens(&self) -> Arc<[Token]> {
        self.inner.tokens.get()
    }

    /// The tokens of the database as they stand now, for one that is not known yet.
    pub async fn tokens_now(&self) -> Result<Arc<[Token]>, JobError> {
        self.inner.tokens.refresh(&self.inner.store).await?;
        Ok(self.inner.tokens.get())
    }

    /// The parts, for tests that play the queue.
    #[cfg(test)]
    pub(super) fn inner(&self) -> &Inner {
        &self.inner
    }

    /// What another process on the same database would be, as long as it only sweeps and answers requests.
    #[cfg(test)]
    pub(super) fn twin(&self, worker: Uuid, settings: Settings) -> Self {
        let (running, stopping) = (Arc::default(), CancellationToken::new());
        Self { inner: Arc::new(Inner { worker, settings, running, stopping, ..Inner::clone(&self.inner) }) }
    }

    /// Hands in a job; it is safe on the disk when this returns. With a key, once: the same key answers again as it did first.
    pub async fn submit(&self, job: &Job, owner: &str, key: Option<IdempotencyKey>) -> Result<Submitted, JobError> {
        if self.inner.is_stopping() {
            return Err(JobError::Stopping);
        }
        self.inner.check_place()?;
        self.inner.store.note(self.inner.intake.submit(NewJob::new(job, owner, key)).await)
    }

    /// A job, with the progress of this moment.
    pub async fn get(&self, owner: &str, id: Uuid) -> Result<JobRecord, JobError> {
        Ok(self.live(self.inner.store.job(owner, id).await?))
    }

    /// The same with the metrics of a succeeded simulation, as JSON text.
    pub async fn get_with_metrics(&self, owner: &str, id: Uuid) -> Result<(JobRecord, Option<String>), JobError> {
        let (record, metrics) = self.inner.store.job_with_metrics(owner, id).await?;
        Ok((self.live(record), metrics))
    }

    /// A page of jobs, newest first, and whether there are more.
    pub async fn list(&self, owner: &str, filter: &Filter) -> Result<(Vec<JobRecord>, bool), JobError> {
        let (page, more) = self.inner.store.jobs(owner, filter).await?;
        Ok((page.into_iter().map(|record| self.live(record)).collect(), more))
    }

    /// The record of a job, with the progress of this moment.
    pub fn live(&self, mut record: JobRecord) -> JobRecord {
        // Strands of a study write theirs with every point.
        if record.status == Status::Running
            && record.kind != JobKind::Study.name()
            && let Some(run) = self.inner.running.get(record.id)
        {
            record.progress = run.progress();
        }
        record
    }

    /// How a run of this process goes; `None` where there is none.
    pub fn view(&self, id: Uuid) -> Option<View> {
        self.inner.running.get(id).map(|run| run.view())
    }

    /// What changes once the job has ended; to be taken before the job is looked at.
    pub fn bell(&self, id: Uuid) -> Bell {
        self.inner.running.bell(id)
    }

    /// Whether the service takes no more jobs.
    pub fn is_stopping(&self) -> bool {
        self.inner.is_stopping()
    }

    /// The job with its metrics once it has ended, or as it is when the time is over.
    pub async fn wait(
        &self,
        owner: &str,
        id: Uuid,
        at_most: Duration,
    ) -> Result<(JobRecord, Option<String>), JobError> {
        let mut bell = self.inner.running.bell(id);
        let until = tokio::time::Instant::now() + at_most;
        loop {
            let looked = self.get_with_metrics(owner, id).await;
            let left = until.saturating_duration_since(tokio::time::Instant::now());
            let waits = match &looked {
                Ok((record, _)) => !record.status.is_final(),
                // The job is safe, wherever the database is for now.
                Err(error) => error.is_away(),
            };
            if !waits || left.is_zero() || self.is_stopping() {
                return looked;
            }
            tokio::select! {
                _ = bell.changed() => {
                    let ended = bell.borrow().clone();
                    return match ended {
                        // Whoever has seen the job may see how it ended.
                        Some(ended) if looked.is_ok() => Ok((ended.record.clone(), ended.metrics.clone())),
                        _ => self.get_with_metrics(owner, id).await,
                    };
                }
                // A bell that is rung by another process may be lost on the way.
                () = tokio::time::sleep(left.min(LOOK_AGAIN)) => {}
                // The job goes on after the next start; whoever waits gets its id before this one ends.
                () = self.inner.stopping.cancelled() => {}
            }
        }
    }

    /// Ends a job that waits or runs.
    pub async fn cancel(&self, owner: &str, id: Uuid) -> Result<Cancelled, JobError> {
        self.inner.store.note(self.try_cancel(owner, id).await)
    }

    async fn try_cancel(&self, owner: &str, id: Uuid) -> Result<Cancelled, JobError> {
        let mut tx = self.inner.store.begin().await?;
        let (mut status, delivery, kind) = records::standing(&mut tx, owner, id).await?;
        let is_study = kind == JobKind::Study.name();
        match status {
            Status::Queued | Status::Running if is_study => {
                records::request_cancel(&mut tx, id).await?;
                match self.inner.running.get(id) {
                    // Its strands end it.
                    Some(run) => run.stop(StopReason::Cancelled),
                    // Its strands run elsewhere, and end it.
                    None if studies::is_under_way(&mut tx, id).await? => tx.tell_cancelled(id).await?,
                    None => {
                        studies::cancel(&mut tx, id, self.inner.settings.keep_s).await?;
                        status = Status::Queued;
                    }
                }
            }
            Status::Queued => {
                records::cancel_queued(&mut tx, id, self.inner.settings.keep_s).await?;
                tx.tell_ended(id).await?;
                if let Some(delivery) = delivery {
                    self.inner.queue.cancel(&mut tx, delivery).await?;
                }
            }
            Status::Running => {
                // Before it is written down: a full disk refuses that, and is no reason for the run to go on.
                if let Some(run) = self.inner.running.get(id) {
                    run.stop(StopReason::Cancelled);
                }
                records::request_cancel(&mut tx, id).await?;
                tx.tell_cancelled(id).await?;
            }
            Status::Cancelled => {}
            Status::Succeeded | Status::Failed => return Err(JobError::Conflict(status)),
        }
        tx.commit().await?;
        if status == Status::Queued {
            self.inner.running.ended(id);
        }
        let record = self.get(owner, id).await?;
        Ok(if status == Status::Running { Cancelled::Soon(record) } else { Cancelled::Now(record) })
    }

    /// Lets a study go on that was cancelled or has points that could end otherwise; points that have ended are kept.
    pub async fn resume(&self, owner: &str, id: Uuid) -> Result<JobRecord, JobError> {
        self.inner.store.note(self.try_resume(owner, id).await)
    }

    async fn try_resume(&self, owner: &str, id: Uuid) -> Result<JobRecord, JobError> {
        if self.inner.is_stopping() {
            return Err(JobError::Stopping);
        }
        let mut tx = self.inner.store.begin().await?;
        let (status, _, kind) = records::standing(&mut tx, owner, id).await?;
        if kind != JobKind::Study.name() {
            return Err(JobError::NoStudy { kind });
        }
        if !status.is_final() || !studies::resume(&mut tx, id).await? {
            return Err(JobError::CannotResume(status));
        }
        let strands = Delivery::strands(id, upkeep::slots(&mut tx).await?);
        let deliveries = self.inner.queue.enqueue(&mut tx, &strands).await?;
        studies::add_strands(&mut tx, id, &deliveries).await?;
        tx.commit().await?;
        self.inner.queue.wake();
        self.get(owner, id).await
    }

    /// The request of a study and its points.
    pub async fn points(&self, owner: &str, id: Uuid) -> Result<(String, Vec<StoredPoint>), JobError> {
        self.inner.store.points(owner, id).await
    }

    /// Removes a job that has ended, with its result.
    pub async fn delete(&self, owner: &str, id: Uuid) -> Result<(), JobError> {
        let mut tx = self.inner.store.begin().await?;
        let (status, _, _) = records::standing(&mut tx, owner, id).await?;
        if !status.is_final() {
            return Err(JobError::Conflict(status));
        }
        records::delete(&mut tx, id).await?;
        tx.commit().await
    }

    /// The metrics of a succeeded job, as JSON text.
    pub async fn metrics(&self, owner: &str, id: Uuid) -> Result<String, JobError> {
        self.inner.store.metrics(owner, id).await
    }

    /// A spectrum of a succeeded job.
    pub async fn spectrum(
        &self,
        owner: &str,
        id: Uuid,
        kind: SpectrumKind,
        channel: &str,
    ) -> Result<SpectrumAnswer, JobError> {
        self.inner.store.spectrum(owner, id, kind, channel).await
    }

    /// A series of a succeeded job, as JSON text.
    pub async fn series(&self, owner: &str, id: Uuid, channel: &str) -> Result<Vec<u8>, JobError> {
        self.inner.store.series(owner, id, channel).await
    }

    /// Channels of which a succeeded job keeps a signal.
    pub async fn channels(&self, owner: &str, id: Uuid, signal: Signal) -> Result<Vec<String>, JobError> {
        self.inner.store.channels(owner, id, signal).await
    }

    /// Digest of all that determines the result of a succeeded job; `None` of any other.
    pub async fn fingerprint(&self, owner: &str, id: Uuid) -> Result<Option<Vec<u8>>, JobError> {
        self.inner.store.fingerprint(owner, id).await
    }

    /// What pictures of a succeeded simulation show, as JSON text; `None` where nothing was kept for them.
    pub async fn views(&self, owner: &str, id: Uuid) -> Result<Option<Vec<u8>>, JobError> {
        self.inner.store.views(owner, id).await
    }

    /// The report of a succeeded job of a kind that leaves one, as JSON text.
    pub async fn report(&self, owner: &str, id: Uuid, kind: JobKind) -> Result<Vec<u8>, JobError> {
        self.inner.store.report(owner, id, kind).await
    }

    /// Whether jobs can be taken now.
    pub async fn ready(&self) -> Result<(), JobError> {
        if self.inner.is_stopping() {
            return Err(JobError::Stopping);
        }
        if self.inner.store.disk_is_full() {
            return Err(JobError::DiskFull);
        }
        self.inner.check_place()?;
        let answered = tokio::time::timeout(LONGEST_PING, self.inner.store.ping()).await;
        answered.unwrap_or(Err(JobError::Database(sqlx::Error::PoolTimedOut)))?;
        if self.inner.store.is_unwritable() { Err(JobError::NotWritable) } else { Ok(()) }
    }

    /// Counts and times of this process, and the standing of the queue, as OpenMetrics text.
    pub async fn figures(&self) -> Result<String, JobError> {
        let standing = self.inner.store.standing().await?;
        self.inner.store.figures.text(&standing)
    }

    /// Counts of the queue.
    pub async fn stats(&self) -> Result<QueueStats, JobError> {
        self.inner.queue.stats().await
    }

    /// Takes no more jobs; those that run go on.
    pub fn refuse_new(&self) {
        self.inner.stopping.cancel();
    }

    /// Hands running jobs back, so that they run again at the next start, and closes the database.
    pub async fn stop(&self) -> Result<(), JobError> {
        self.refuse_new();
        self.inner.running.stop_all(StopReason::HandedBack);
        if self.inner.store.dialect() == Dialect::Sqlite {
            return self.settle().await;
        }
        // A server that does not answer keeps nobody from ending: what was not handed back is found by its silence.
        tokio::time::timeout(LONGEST_STOP, self.settle()).await.unwrap_or(Err(JobError::NotWritable))
    }

    /// Hands back what has run, and closes the database.
    async fn settle(&self) -> Result<(), JobError> {
        let (drained, ()) = tokio::join!(self.inner.queue.drain(), self.inner.runner.drain());
        // What was handed back and never queued goes to other processes at once.
        if let Err(error) = sweep::sweep(&self.inner).await {
            tracing::warn!(%error, "what was handed back waits for the next start, or for another process");
        }
        if let Err(error) = self.inner.store.leave(self.inner.worker).await {
            tracing::warn!(%error, "this process is listed for a while although it has ended");
        }
        self.inner.store.close().await;
        drained
    }
}

/// Hears what other processes on the same server tell, until the service is dropped.
fn listen(pool: sqlx::PgPool, inner: &Arc<Inner>) {
    let (running, stopping) = (Arc::clone(&inner.running), inner.stopping.clone());
    let hear = async move {
        loop {
            // Comes back by itself where the link was lost; what was told meanwhile is found by looking.
            if let Ok(mut listener) = sqlx::postgres::PgListener::connect_with(&pool).await
                && listener.listen_all([database::ENDED, database::CANCELLED]).await.is_ok()
            {
                while let Ok(told) = listener.recv().await {
                    match (told.channel(), told.payload().parse()) {
                        // This process tells it by itself, and how.
                        (database::ENDED, Ok(job)) if running.get(job).is_some_and(|run| run.concludes()) => {}
                        (database::ENDED, Ok(job)) => running.ended(job),
                        (_, Ok(job)) => running.cancel(job),
                        (_, Err(_)) => {}
                    }
                }
            }
            tokio::time::sleep(Duration::from_secs(1)).await;
        }
    };
    tokio::spawn(async move {
        tokio::select! {
            () = hear => {}
            () = stopping.cancelled() => {}
        }
    });
}

/// Starts the queue on what a dead process left.
async fn recover(inner: &Inner) -> Result<(), JobError> {
    let recovered = inner.queue.recover().await?;
    if recovered > 0 {
        tracing::warn!(jobs = recovered, "the last process ended during these runs; they start again");
    }
    sweep::sweep(inner).await?;
    inner.queue.start().await
}
