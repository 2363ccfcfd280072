//! The queue: enqueue, cancel, start, wake and drain. River's client is used only in this file; its table has a file in `store`.

use std::collections::HashSet;
use std::future::Future;
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use riverqueue::{
    BoxError, Client, InsertManyItem, InsertOpts, MaintenanceConfig, QueueConfig, RunHandle, WorkCancelled,
    WorkContext, WorkOutcome, Workers,
};
use serde::{Deserialize, Serialize};
use tokio::sync::{Mutex, Notify};
use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::error::JobError;
use super::store::deliveries;
use super::store::pool::{Pool, Tx};

/// River's arguments of a delivery: none. A delivery is a turn, and our tables tell what takes it.
#[derive(Debug, Clone, Serialize, Deserialize, riverqueue::JobArgs)]
#[river(kind = "run_job")]
struct RunJob {}

/// How the work on a delivery ended.
#[derive(Debug)]
pub enum DeliveryOutcome {
    /// Nothing is left to do.
    Done,
    /// The process stops; the queue delivers again.
    HandedBack,
    /// Work is left; the queue delivers again behind those that wait.
    Later,
    /// The database refused; the queue delivers again after a pause.
    Retry(JobError),
}

/// Function that works on a delivery.
pub type Handler = Arc<dyn Fn(WorkItem) -> Pin<Box<dyn Future<Output = DeliveryOutcome> + Send>> + Send + Sync>;

/// A delivery that was handed to this process.
pub struct WorkItem {
    /// Number of the delivery.
    pub delivery: i64,
    context: WorkContext,
}

impl WorkItem {
    /// A token that is cancelled when the process stops.
    pub fn stopping(&self) -> &CancellationToken {
        self.context.cancellation_token()
    }
}

const QUEUE: &str = "runs";

/// Time between two looks at the queue without a notification.
const POLL_INTERVAL: Duration = Duration::from_secs(1);

/// Longest time that the start waits until the queue listens to notifications; after that it polls.
const LISTEN_TIMEOUT: Duration = Duration::from_secs(5);

/// Numbers of the deliveries that this process works on.
#[derive(Debug, Clone, Default)]
struct InHand(Arc<std::sync::Mutex<HashSet<i64>>>);

impl InHand {
    fn with<T>(&self, use_ids: impl FnOnce(&mut HashSet<i64>) -> T) -> T {
        use_ids(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The queue.
pub struct Queue {
    client: Client,
    /// Inserts deliveries without a notification in the transaction.
    inserter: Client,
    /// Set when deliveries are enqueued, for the notification of other processes.
    enqueued: Notify,
    process: Uuid,
    in_hand: InHand,
    workers: usize,
    wakes: AtomicU64,
    run: Mutex<Option<RunHandle>>,
}

impl Queue {
    /// A queue that is not started yet. River takes a run from its worker after `rescue_after`.
    pub fn new(
        pool: &Pool,
        process: Uuid,
        workers: usize,
        rescue_after: Duration,
        handler: Handler,
    ) -> Result<Self, JobError> {
        let builder = match pool {
            // Only this process writes, and it calls `wake`.
            Pool::Sqlite(pool) => Client::builder(pool).without_notifications(),
            Pool::Postgres(pool) => Client::builder(pool),
        };
        let inserter = match pool {
            Pool::Sqlite(pool) => Client::builder(pool),
            Pool::Postgres(pool) => Client::builder(pool),
        };
        // River notifies within the transaction of an insert, at most once in its cooldown: here only with the first delivery.
        let inserter = inserter.without_notifications().fetch_cooldown(Duration::MAX).build()?;
        let in_hand = InHand::default();
        // A process without workers only inserts deliveries.
        let builder = match workers {
            0 => builder,
            _ => builder
                .workers(workers_for(handler, &in_hand)?)
                .queue(QUEUE, QueueConfig::new(workers).with_fetch_poll_interval(POLL_INTERVAL)),
        };
        let client = builder
            // River writes this id into the deliveries that the process holds.
            .id(process.to_string())
            .fetch_cooldown(Duration::from_millis(2))
            // Runs have their own time limit, which sets a stop flag.
            .without_job_timeout()
            .maintenance(MaintenanceConfig::default().with_rescue_after(rescue_after))
            .build()?;
        // The count begins with 1: the poll interval of count 0 is the initial one, and setting it again would wake nothing.
        let (enqueued, wakes, run) = (Notify::new(), AtomicU64::new(1), Mutex::new(None));
        Ok(Self { client, inserter, enqueued, process, in_hand, workers, wakes, run })
    }

    /// Inserts deliveries and returns their numbers in order.
    pub async fn enqueue(&self, tx: &mut Tx, count: usize) -> Result<Vec<i64>, JobError> {
        // River refuses an empty list.
        if count == 0 {
            return Ok(Vec::new());
        }
        // All of one priority: the order of turns is that of the owners.
        let delivery = || InsertManyItem::new(RunJob {}, InsertOpts::default().with_queue(QUEUE));
        let request = self.inserter.insert_many(std::iter::repeat_with(delivery).take(count).collect::<Vec<_>>());
        let inserted = match tx {
            Tx::Sqlite(tx) => request.tx(&mut *tx).await?,
            Tx::Postgres(tx) => request.tx(&mut *tx).await?,
        };
        Ok(inserted.iter().map(|result| result.id()).collect())
    }

    /// Makes the queues of all processes fetch new deliveries. It must be called after the transaction is committed.
    pub fn wake(&self) {
        self.wake_own();
        self.enqueued.notify_one();
    }

    /// Waits until deliveries have been enqueued since the last call.
    pub async fn enqueued(&self) {
        self.enqueued.notified().await;
    }

    /// Makes the queue of this process fetch new deliveries.
    ///
    /// River fetches when it polls or when its settings change; an insert in our own transaction does not notify it. Polling every
    /// few milliseconds instead costs a tenth of a core.
    pub fn wake_own(&self) {
        if self.workers == 0 {
            return;
        }
        // Unchanged settings wake nothing, so the poll interval differs by some milliseconds each time.
        let wakes = self.wakes.fetch_add(1, Ordering::Relaxed);
        let interval = POLL_INTERVAL + Duration::from_millis(wakes % 256);
        let settings = QueueConfig::new(self.workers).with_fetch_poll_interval(interval);
        if let Err(error) = self.client.local_queues().update(QUEUE, settings) {
            tracing::warn!(%error, "the queue could not be woken and polls again within a second");
        }
    }

    /// Cancels a delivery that has not started.
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

    /// Starts to deliver.
    pub async fn start(&self) -> Result<(), JobError> {
        if self.workers > 0 {
            let mut run = self.client.start()?;
            // Until River listens, new deliveries are found only by polling.
            if let Ok(ready) = tokio::time::timeout(LISTEN_TIMEOUT, run.wait_ready()).await {
                ready?;
            }
            *self.run.lock().await = Some(run);
        }
        Ok(())
    }

    /// Stops delivering and waits until the running deliveries have returned their jobs.
    pub async fn drain(&self) -> Result<(), JobError> {
        match self.run.lock().await.take() {
            Some(mut run) => Ok(run.stop_and_cancel().await?),
            None => Ok(()),
        }
    }

    /// Redelivers what was handed to this process more than `lost_after` ago and never arrived; returns the number.
    pub async fn recall(&self, tx: &mut Tx, lost_after: Duration) -> Result<u64, JobError> {
        let in_hand: Vec<i64> = self.in_hand.with(|ids| ids.iter().copied().collect());
        deliveries::recall(tx, self.process, &in_hand, lost_after).await
    }
}

fn workers_for(handler: Handler, in_hand: &InHand) -> Result<Workers, JobError> {
    let in_hand = in_hand.clone();
    let mut workers = Workers::new();
    workers.add_fn(move |context: WorkContext, job: riverqueue::Job<RunJob>| {
        let (delivery, in_hand) = (job.row.id, in_hand.clone());
        in_hand.with(|ids| ids.insert(delivery));
        let work = handler(WorkItem { delivery, context });
        async move {
            let outcome = work.await;
            in_hand.with(|ids| ids.remove(&delivery));
            match outcome {
                DeliveryOutcome::Done => Ok(WorkOutcome::Complete),
                // Returns the row without using up an attempt.
                DeliveryOutcome::HandedBack => Err(BoxError::from(WorkCancelled)),
                DeliveryOutcome::Later => Ok(WorkOutcome::Snooze(Duration::ZERO)),
                DeliveryOutcome::Retry(error) => {
                    tracing::warn!(%error, "a job could not be taken from the queue");
                    Ok(WorkOutcome::Snooze(Duration::from_secs(1)))
                }
            }
        }
    })?;
    Ok(workers)
}
