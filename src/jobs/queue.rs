//! The port to the queue: enqueue, cancel, start, drain, stats, recover. Behind it River; nothing of it
//! shows outside this file, so that another queue is one file's work.

use std::collections::HashSet;
use std::future::Future;
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use riverqueue::migrate::{PostgresMigrator, SqliteMigrator};
use riverqueue::{
    BoxError, Client, InsertManyItem, InsertOpts, MaintenanceConfig, QueueConfig, RunHandle, WorkCancelled,
    WorkContext, WorkOutcome, Workers,
};
use serde::{Deserialize, Serialize};
use tokio::sync::Mutex;
use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::JobError;
use super::store::PRIORITY_OF_STRANDS;
use super::store::database::{Dialect, Pool, Tx};
use super::store::statement::statement;

/// What River stores of a job: our row has the rest.
#[derive(Debug, Clone, Serialize, Deserialize, riverqueue::JobArgs)]
#[river(kind = "run_job")]
struct RunJob {
    job: Uuid,
    /// Whether this is a strand of a study.
    #[serde(default)]
    strand: bool,
}

/// What is put into the queue.
#[derive(Debug, Clone, Copy)]
pub struct Delivery {
    pub job: Uuid,
    pub priority: u8,
    /// Whether this is a strand of a study.
    pub strand: bool,
}

impl Delivery {
    /// A single job.
    pub fn of_job(job: Uuid, priority: u8) -> Self {
        Self { job, priority, strand: false }
    }

    /// Some strands of a study.
    pub fn strands(study: Uuid, count: usize) -> Vec<Self> {
        vec![Self { job: study, priority: PRIORITY_OF_STRANDS, strand: true }; count]
    }
}

/// How a delivery ended.
#[derive(Debug)]
pub enum Delivered {
    /// Nothing is left to do.
    Done,
    /// The process stops; deliver again.
    HandedBack,
    /// More is left to do; deliver again behind those that wait.
    Later,
    /// The database refused; deliver again after a while.
    Again(JobError),
}

/// Works a delivery.
pub type Handler = Arc<dyn Fn(Ticket) -> Pin<Box<dyn Future<Output = Delivered> + Send>> + Send + Sync>;

/// A delivered job.
pub struct Ticket {
    pub job: Uuid,
    pub strand: bool,
    /// Number of this delivery.
    pub delivery: i64,
    context: WorkContext,
}

impl Ticket {
    /// Is cancelled when the process stops.
    pub fn stopping(&self) -> &CancellationToken {
        self.context.cancellation_token()
    }
}

/// Counts of the queue's rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QueueStats {
    pub available: i64,
    pub running: i64,
}

const QUEUE: &str = "runs";

/// How often the queue is looked at without being woken.
const POLL: Duration = Duration::from_secs(1);

/// Time that the queue has to listen; without that it looks.
const READY: Duration = Duration::from_secs(5);

/// The deliveries that are in this process's hands.
#[derive(Debug, Clone, Default)]
struct InHand(Arc<std::sync::Mutex<HashSet<i64>>>);

impl InHand {
    fn with<T>(&self, use_them: impl FnOnce(&mut HashSet<i64>) -> T) -> T {
        use_them(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The queue.
pub struct Queue {
    client: Client,
    pool: Pool,
    process: Uuid,
    in_hand: InHand,
    workers: usize,
    wakes: AtomicU64,
    run: Mutex<Option<RunHandle>>,
}

impl Queue {
    /// Makes the queue's tables.
    pub async fn migrate(pool: &Pool) -> Result<(), JobError> {
        match pool {
            Pool::Sqlite(pool) => SqliteMigrator::new(pool.clone()).migrate_up().await,
            Pool::Postgres(pool) => PostgresMigrator::new(pool.clone()).migrate_up().await,
        }
        .map_err(|error| JobError::Migration(error.to_string()))?;
        Ok(())
    }

    /// Whether River's tables are those that this version makes.
    pub async fn is_up_to_date(pool: &Pool) -> Result<bool, JobError> {
        let (made, all) = match pool {
            Pool::Sqlite(pool) => {
                (SqliteMigrator::new(pool.clone()).existing_versions().await, SqliteMigrator::all_versions().len())
            }
            Pool::Postgres(pool) => {
                (PostgresMigrator::new(pool.clone()).existing_versions().await, PostgresMigrator::all_versions().len())
            }
        };
        Ok(made.map_err(|error| JobError::Migration(error.to_string()))?.len() == all)
    }

    /// A queue of a process that is not started yet; runs are rescued from their worker after `rescue_after`.
    pub fn new(
        pool: Pool,
        process: Uuid,
        workers: usize,
        rescue_after: Duration,
        handler: Handler,
    ) -> Result<Self, JobError> {
        let builder = match &pool {
            // All that writes is in this process, and says so by `wake`.
            Pool::Sqlite(pool) => Client::builder(pool).without_notifications(),
            Pool::Postgres(pool) => Client::builder(pool),
        };
        let in_hand = InHand::default();
        // A process that takes no jobs only puts them into the queue.
        let builder = match workers {
            0 => builder,
            _ => builder
                .workers(workers_for(handler, &in_hand)?)
                .queue(QUEUE, QueueConfig::new(workers).with_fetch_poll_interval(POLL)),
        };
        let client = builder
            // By which a delivery tells in whose hands it is.
            .id(process.to_string())
            .fetch_cooldown(Duration::from_millis(2))
            // Runs have a limit of their own, which ends them by a flag.
            .without_job_timeout()
            .maintenance(MaintenanceConfig::default().with_rescue_after(rescue_after))
            .build()?;
        // From 1 on: the pace of 0 is the one that the queue begins with, and would wake nobody.
        Ok(Self { client, pool, process, in_hand, workers, wakes: AtomicU64::new(1), run: Mutex::new(None) })
    }

    /// Adds deliveries; answers with their numbers, in order.
    pub async fn enqueue(&self, tx: &mut Tx, deliveries: &[Delivery]) -> Result<Vec<i64>, JobError> {
        // River takes an empty list for a mistake.
        if deliveries.is_empty() {
            return Ok(Vec::new());
        }
        let items = deliveries.iter().map(|Delivery { job, priority, strand }| {
            let opts = InsertOpts::default().with_queue(QUEUE).with_priority(i16::from(*priority));
            InsertManyItem::new(RunJob { job: *job, strand: *strand }, opts)
        });
        let request = self.client.insert_many(items.collect::<Vec<_>>());
        let inserted = match tx {
            Tx::Sqlite(tx) => request.tx(&mut *tx).await?,
            Tx::Postgres(tx) => request.tx(&mut *tx).await?,
        };
        Ok(inserted.iter().map(|result| result.id()).collect())
    }

    /// Has the queue look for what was enqueued; to be called once the transaction is committed.
    ///
    /// River looks at its queue when it is polled or when the queue's settings change, but an insert in our
    /// own transaction tells it nothing. (On PostgreSQL it tells all processes by a notification, which comes later, and may be lost
    /// in the first second of a process.) Polling every few milliseconds instead costs a tenth of a core.
    pub fn wake(&self) {
        if self.workers == 0 {
            return;
        }
        // Settings that have not changed wake nobody, so that the pace differs by some milliseconds each time.
        let wakes = self.wakes.fetch_add(1, Ordering::Relaxed);
        let pace = POLL + Duration::from_millis(wakes % 256);
        let settings = QueueConfig::new(self.workers).with_fetch_poll_interval(pace);
        if let Err(error) = self.client.local_queues().update(QUEUE, settings) {
            tracing::warn!(%error, "the queue could not be woken and looks again within a second");
        }
    }

    /// Withdraws a delivery that has not begun.
    pub async fn cancel(&self, tx: &mut Tx, delivery: i64) -> Result<(), JobError> {
        let request = self.client.jobs().cancel(delivery);
        let cancelled = match tx {
            Tx::Sqlite(tx) => request.tx(&mut *tx).await,
            Tx::Postgres(tx) => request.tx(&mut *tx).await,
        };
        match cancelled {
            Ok(_) | Err(riverqueue::Error::NotFound(_)) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Begins to deliver.
    pub async fn start(&self) -> Result<(), JobError> {
        if self.workers > 0 {
            let mut run = self.client.start()?;
            // Before it listens, what is put into the queue is only found by looking.
            if let Ok(ready) = tokio::time::timeout(READY, run.wait_ready()).await {
                ready?;
            }
            *self.run.lock().await = Some(run);
        }
        Ok(())
    }

    /// Stops delivering and waits until the running deliveries have handed their jobs back.
    pub async fn drain(&self) -> Result<(), JobError> {
        match self.run.lock().await.take() {
            Some(mut run) => Ok(run.stop_and_cancel().await?),
            None => Ok(()),
        }
    }

    /// Makes due what is to wait longer than anything here ever does: a clock that was set back, of this machine or of the one that made it,
    /// would keep jobs waiting for as long as that.
    pub async fn hasten(&self, tx: &mut Tx) -> Result<u64, JobError> {
        let (now, later) = match tx.dialect() {
            Dialect::Sqlite => {
                ("strftime('%Y-%m-%d %H:%M:%f', 'now')", "strftime('%Y-%m-%d %H:%M:%f', 'now', '+5 seconds')")
            }
            Dialect::Postgres => ("now()", "now() + INTERVAL '5 seconds'"),
        };
        let sql = format!(
            "UPDATE river_job SET state = 'available', scheduled_at = {now} \
             WHERE state IN ('available', 'scheduled') AND scheduled_at > {later}"
        );
        statement(sql).run(tx).await
    }

    /// Delivers again what was handed to this process `lost_after` ago and never came: where a link breaks while the server answers, what it
    /// has handed out stays handed out, and nobody works it.
    pub async fn recall(&self, tx: &mut Tx, lost_after: Duration) -> Result<u64, JobError> {
        if tx.dialect() == Dialect::Sqlite {
            return Ok(0);
        }
        let in_hand = self.in_hand.with(|ids| ids.iter().map(i64::to_string).collect::<Vec<_>>().join(", "));
        let not_in_hand = if in_hand.is_empty() { String::new() } else { format!(" AND id NOT IN ({in_hand})") };
        let sql = format!(
            "UPDATE river_job SET state = 'available' WHERE state = 'running' \
             AND attempted_by[array_upper(attempted_by, 1)] = $1 AND attempted_at < now() - $2 * INTERVAL '1 second'{not_in_hand}"
        );
        statement(sql).bind(self.process.to_string()).bind(lost_after.as_secs_f64()).run(tx).await
    }

    /// Counts of what waits and runs.
    pub async fn stats(&self) -> Result<QueueStats, JobError> {
        let sql = "SELECT CAST(state AS TEXT), count(*) FROM river_job WHERE state IN ('available', 'running') GROUP BY state";
        let rows: Vec<(String, i64)> = statement(sql).all(&self.pool).await?;
        let count = |state: &str| rows.iter().find(|row| row.0 == state).map_or(0, |row| row.1);
        Ok(QueueStats { available: count("available"), running: count("running") })
    }

    /// Delivers again what a dead process was working on, where no other process can be at it.
    pub async fn recover(&self) -> Result<u64, JobError> {
        if matches!(self.pool, Pool::Postgres(_)) {
            return Ok(0);
        }
        let sql = "UPDATE river_job SET state = 'available' WHERE state = 'running'";
        statement(sql).run(&self.pool).await
    }
}

fn workers_for(handler: Handler, in_hand: &InHand) -> Result<Workers, JobError> {
    let in_hand = in_hand.clone();
    let mut workers = Workers::new();
    workers.add_fn(move |context: WorkContext, job: riverqueue::Job<RunJob>| {
        let RunJob { job: id, strand } = job.args;
        let (delivery, in_hand) = (job.row.id, in_hand.clone());
        in_hand.with(|ids| ids.insert(delivery));
        let delivered = handler(Ticket { job: id, strand, delivery, context });
        async move {
            let delivered = delivered.await;
            in_hand.with(|ids| ids.remove(&delivery));
            match delivered {
                Delivered::Done => Ok(WorkOutcome::Complete),
                // Gives the row back without using up an attempt.
                Delivered::HandedBack => Err(BoxError::from(WorkCancelled)),
                Delivered::Later => Ok(WorkOutcome::Snooze(Duration::ZERO)),
                Delivered::Again(error) => {
                    tracing::warn!(%error, "a job could not be taken from the queue");
                    Ok(WorkOutcome::Snooze(Duration::from_secs(1)))
                }
            }
        }
    })?;
    Ok(workers)
}
