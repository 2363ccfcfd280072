//! Starting and stopping of the job service, and the listener for notifications of other processes.

use std::sync::Arc;
use std::time::Duration;

use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::database_lock::DatabaseLock;
use super::error::JobError;
use super::intake::{Intake, IntakeLimits};
use super::parts::Parts;
use super::queue::{Handler, Queue};
use super::running::{Running, StopReason};
use super::service::Jobs;
use super::settings::{Settings, Simulator};
use super::store::connections;
use super::store::database::Store;
use super::store::dialect::Dialect;
use super::store::location::Location;
use super::store::notifications::{CANCELLED, ENDED, ENQUEUED};
use super::store::pool::Pool;
use super::sweep;
use super::token_cache::TokenCache;
use super::worker::Worker;

/// Longest time that a stopping process waits for a server.
const STOP_TIMEOUT: Duration = Duration::from_secs(8);

/// Pause before a lost connection for notifications is opened again.
const RECONNECT_PAUSE: Duration = Duration::from_secs(1);

/// Shortest time between two notifications of new deliveries.
const ANNOUNCE_INTERVAL: Duration = Duration::from_millis(10);

impl Jobs {
    /// Opens the database, recovers the jobs of a dead process, and starts to run jobs.
    pub async fn start(settings: Settings, simulator: Simulator) -> Result<Self, JobError> {
        let lock = match &settings.database {
            Location::File(path) => Some(Arc::new(DatabaseLock::take(path)?)),
            Location::Server(_) => None,
        };
        let store = open(&settings).await?;
        let tokens = Arc::new(TokenCache::read(store.clone()).await?);
        let running = Arc::new(Running::default());
        let worker = Arc::new(Worker::new(store.clone(), Arc::clone(&running), simulator, settings.clone()));
        let worker_id = Uuid::now_v7();
        let handler = handler_of(&worker);
        let queue = Queue::new(store.writer(), worker_id, settings.workers, settings.rescue_after(), handler)?;
        let queue = Arc::new(queue);
        let limits = IntakeLimits { work: settings.work_limits, keep_s: settings.keep_s };
        let intake = Intake::start(store.clone(), Arc::clone(&queue), Arc::clone(&worker), Arc::clone(&tokens), limits);
        let stopping = CancellationToken::new();
        let parts =
            Arc::new(Parts { worker_id, settings, store, queue, running, worker, tokens, intake, stopping, lock });
        if let Pool::Postgres(pool) = parts.store.writer() {
            listen(pool.clone(), &parts);
            announce(&parts);
        }
        recover(&parts).await?;
        sweep::start(&parts);
        parts.tokens.keep_current(parts.stopping.clone());
        Ok(Self { parts })
    }

    /// Stops accepting jobs; running jobs continue.
    pub fn refuse_new(&self) {
        self.parts.stopping.cancel();
    }

    /// Returns running jobs to the queue, so that they run again at the next start, and closes the database.
    pub async fn stop(&self) -> Result<(), JobError> {
        self.refuse_new();
        self.parts.running.stop_all(StopReason::HandedBack);
        if self.parts.store.dialect() == Dialect::Sqlite {
            return close(&self.parts).await;
        }
        // A server that does not answer must not keep the process alive: other processes find its runs by their missing heartbeat.
        tokio::time::timeout(STOP_TIMEOUT, close(&self.parts)).await.unwrap_or(Err(JobError::NotWritable))
    }
}

async fn open(settings: &Settings) -> Result<Store, JobError> {
    let opening = |error| JobError::opening(&settings.database, error);
    if let (Location::Server(options), 1..) = (&settings.database, settings.workers) {
        connections::check_connection_limit(options).await.map_err(opening)?;
    }
    let store = Store::open(&settings.database, settings.workers, settings.max_pages).await.map_err(opening)?;
    store.migrate().await.map_err(opening)?;
    // A read-only file would otherwise be noticed later, by an error that does not name it.
    store.try_write().await.map_err(opening)?;
    Ok(store)
}

fn handler_of(worker: &Arc<Worker>) -> Handler {
    let worker = Arc::clone(worker);
    Arc::new(move |item| {
        let worker = Arc::clone(&worker);
        Box::pin(async move { worker.work(&item).await })
    })
}

/// Starts the queue after it has recovered the deliveries of a dead process.
async fn recover(parts: &Parts) -> Result<(), JobError> {
    let recovered = parts.store.recover_deliveries().await?;
    if recovered > 0 {
        tracing::warn!(jobs = recovered, "the previous process ended during these runs; they start again");
    }
    sweep::sweep(parts).await?;
    parts.queue.start().await
}

/// Returns runs to the queue and closes the database.
async fn close(parts: &Parts) -> Result<(), JobError> {
    let (drained, ()) = tokio::join!(parts.queue.drain(), parts.worker.drain());
    // Redelivers at once the jobs that were returned and never had a delivery.
    if let Err(error) = sweep::sweep(parts).await {
        tracing::warn!(%error, "returned jobs wait for the next start, or for another process");
    }
    if let Err(error) = parts.store.unlist_worker(parts.worker_id).await {
        tracing::warn!(%error, "this process remains in the list of workers for a while");
    }
    parts.store.close().await;
    drained
}

/// Notifies other processes on the same server of new deliveries, until the service stops.
fn announce(parts: &Arc<Parts>) {
    let (store, queue, stopping) = (parts.store.clone(), Arc::clone(&parts.queue), parts.stopping.clone());
    let announce = async move {
        loop {
            queue.enqueued().await;
            // Without it they find the deliveries by polling.
            if let Err(error) = store.notify_enqueued().await {
                tracing::debug!(%error, "other processes could not be notified of new jobs");
            }
            tokio::time::sleep(ANNOUNCE_INTERVAL).await;
        }
    };
    tokio::spawn(async move {
        tokio::select! {
            () = announce => {}
            () = stopping.cancelled() => {}
        }
    });
}

/// Listens to notifications of other processes on the same server, until the service stops.
fn listen(pool: sqlx::PgPool, parts: &Arc<Parts>) {
    let (running, queue, stopping) = (Arc::clone(&parts.running), Arc::clone(&parts.queue), parts.stopping.clone());
    let receive = async move {
        loop {
            // Reconnects after a lost connection. Notifications that were missed meanwhile are found by polling.
            if let Ok(mut listener) = sqlx::postgres::PgListener::connect_with(&pool).await
                && listener.listen_all([ENDED, CANCELLED, ENQUEUED]).await.is_ok()
            {
                while let Ok(notification) = listener.recv().await {
                    if notification.channel() == ENQUEUED {
                        queue.wake_own();
                        continue;
                    }
                    match (notification.channel(), notification.payload().parse()) {
                        // This process completes the job itself, with its end.
                        (ENDED, Ok(job)) if running.get(job).is_some_and(|run| run.concludes()) => {}
                        (ENDED, Ok(job)) => running.ended(job),
                        (_, Ok(job)) => running.cancel(job),
                        (_, Err(_)) => {}
                    }
                }
            }
            tokio::time::sleep(RECONNECT_PAUSE).await;
        }
    };
    tokio::spawn(async move {
        tokio::select! {
            () = receive => {}
            () = stopping.cancelled() => {}
        }
    });
}
