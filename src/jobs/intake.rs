//! One transaction, and one flush to disk, for all waiting submissions. A transaction for each would be several times slower under
//! load, and no faster without load.

use std::collections::HashMap;
use std::sync::Arc;

use tokio::sync::{mpsc, oneshot};
use uuid::Uuid;

use super::error::JobError;
use super::job::{JobRecord, NewJob};
use super::queue::Queue;
use super::store::database::Store;
use super::store::deliveries::Delivery;
use super::store::pool::{Lock, Tx};
use super::store::{idempotency_keys, maintenance, removal, submissions};
use super::worker::{InlineRun, Worker};

/// Largest number of submissions in one transaction.
const BATCH_SIZE: usize = 64;

type Answer = Result<Reply, JobError>;
type Waiting = (NewJob, oneshot::Sender<Answer>);

/// The reply to a submission.
enum Reply {
    Submitted(Submitted),
    /// An existing result would answer the job, once it is known to be what was written. Nothing was stored.
    Compare(Box<NewJob>, Uuid),
}

/// A submitted job.
#[derive(Debug, Clone, PartialEq)]
pub struct Submitted {
    /// The record of the first answer.
    pub record: JobRecord,
    /// Whether an earlier submission with the same idempotency key created the job.
    pub replayed: bool,
}

/// Entry of submissions.
#[derive(Debug, Clone)]
pub struct Intake {
    store: Store,
    sender: mpsc::Sender<Waiting>,
}

/// Limits of submissions.
#[derive(Debug, Clone, Copy)]
pub struct IntakeLimits {
    /// Largest number of queued jobs.
    pub queue: u64,
    /// Largest number of queued jobs of one owner.
    pub queue_of_owner: u64,
    /// Retention of ended jobs that do not state their own [s].
    pub keep_s: f64,
}

impl Intake {
    /// Starts the task that writes submissions.
    pub fn start(store: Store, queue: Arc<Queue>, worker: Arc<Worker>, limits: IntakeLimits) -> Self {
        let (sender, mut receiver) = mpsc::channel::<Waiting>(4 * BATCH_SIZE);
        let intake = Self { store: store.clone(), sender };
        tokio::spawn(async move {
            let mut batch = Vec::with_capacity(BATCH_SIZE);
            while receiver.recv_many(&mut batch, BATCH_SIZE).await > 0 {
                // They were answered while the database did not answer, or their clients have gone.
                batch.retain(|(_, answer)| !answer.is_closed());
                write(&store, &queue, &worker, limits, std::mem::take(&mut batch)).await;
            }
        });
        intake
    }

    /// Submits a job; returns when it is on disk.
    pub async fn submit(&self, mut job: NewJob) -> Result<Submitted, JobError> {
        loop {
            match self.send(job).await? {
                Reply::Submitted(submitted) => return Ok(submitted),
                Reply::Compare(same, result) => {
                    job = *same;
                    // Outside the transaction, because it reads the whole result.
                    if self.store.is_intact(result).await? {
                        job.compared = Some(result);
                    } else {
                        job.reuse = false;
                    }
                }
            }
        }
    }

    async fn send(&self, job: NewJob) -> Answer {
        let (answer, answered) = oneshot::channel();
        self.sender.send((job, answer)).await.map_err(|_| JobError::Stopping)?;
        answered.await.map_err(|_| JobError::Stopping)?
    }
}

async fn write(store: &Store, queue: &Queue, worker: &Arc<Worker>, limits: IntakeLimits, batch: Vec<Waiting>) {
    let (jobs, waiting): (Vec<NewJob>, Vec<_>) = batch.into_iter().unzip();
    match write_all(store, queue, worker, limits, &jobs).await {
        // A client that has gone has still submitted the job.
        Ok(answers) => waiting.into_iter().zip(jobs).zip(answers).for_each(|((sender, job), answer)| {
            let reply = answer.map(|outcome| match outcome {
                Written::Submitted(submitted) => Reply::Submitted(submitted),
                Written::Compare(result) => Reply::Compare(Box::new(job), result),
            });
            drop(sender.send(reply));
        }),
        Err(error) => {
            tracing::error!(%error, jobs = jobs.len(), "submissions could not be written");
            waiting.into_iter().for_each(|sender| drop(sender.send(Err(error_for_each(&error)))));
        }
    }
}

/// The error of a batch, for each submission in it.
fn error_for_each(error: &JobError) -> JobError {
    match error {
        JobError::DiskFull => JobError::DiskFull,
        JobError::Database(sqlx::Error::PoolClosed) => JobError::Stopping,
        away if away.is_away() => JobError::NotWritable,
        other => JobError::Corrupt(other.to_string()),
    }
}

async fn write_all(
    store: &Store,
    queue: &Queue,
    worker: &Arc<Worker>,
    limits: IntakeLimits,
    jobs: &[NewJob],
) -> Result<Vec<Result<Written, JobError>>, JobError> {
    let mut tx = store.begin_locked(Lock::Intake).await?;
    let mut places = Places { limits, waiting: submissions::waiting(&mut tx).await? };
    let queue_was_empty = places.waiting.is_empty();
    let mut plans = Vec::with_capacity(jobs.len());
    for job in jobs {
        plans.push(plan(&mut tx, job, &mut places, limits.keep_s).await?);
    }
    let slots = if jobs.iter().any(|job| job.points.is_some()) { maintenance::slots(&mut tx).await? } else { 1 };
    let is_queued = |plan: &Plan| matches!(plan, Plan::Queue);
    let start = |(job, plan): (&NewJob, &Plan)| {
        let may_start = is_queued(plan) && queue_was_empty && job.points.is_none();
        may_start.then(|| worker.start_inline(job)).flatten()
    };
    // The runs start before the jobs are written, so that they overlap with the write.
    let mut started: Vec<Option<InlineRun>> = jobs.iter().zip(&plans).map(start).collect();
    let queued = jobs.iter().zip(&plans).zip(&started).filter(|((_, plan), run)| is_queued(plan) && run.is_none());
    let queued: Vec<_> = queued.flat_map(|((job, _), _)| deliveries_of(job, slots)).collect();
    let mut deliveries = queue.enqueue(&mut tx, &queued).await?.into_iter();
    let mut answers = Vec::with_capacity(jobs.len());
    for ((job, plan), run) in jobs.iter().zip(plans).zip(&started) {
        let record = match plan {
            Plan::Replay(first) => {
                answers.push(first.map(|record| Written::Submitted(Submitted { record, replayed: true })));
                continue;
            }
            Plan::Compare(result) => {
                answers.push(Ok(Written::Compare(result)));
                continue;
            }
            Plan::Answer(found) => Ok(submissions::insert_answered(&mut tx, job, found, limits.keep_s).await?),
            Plan::Refuse(reason) => Err(reason),
            Plan::Queue if job.points.is_some() => {
                let points = job.points.unwrap_or(0);
                let shards: Vec<i64> = deliveries.by_ref().take(shard_count(points, slots)).collect();
                Ok(submissions::insert_study(&mut tx, job, points, &shards).await?)
            }
            Plan::Queue if run.is_some() => Ok(submissions::insert_started(&mut tx, job).await?),
            Plan::Queue => {
                let delivery = deliveries.next().ok_or_else(|| JobError::Corrupt("a delivery is missing".into()))?;
                Ok(submissions::insert(&mut tx, job, delivery).await?)
            }
        };
        answers.push(record.map(|record| Written::Submitted(Submitted { record, replayed: false })));
    }
    tx.commit().await?;
    started.drain(..).flatten().for_each(|run| worker.finish_inline(run));
    if !queued.is_empty() {
        queue.wake();
    }
    Ok(answers)
}

/// The outcome of a submission in a transaction.
enum Written {
    Submitted(Submitted),
    Compare(Uuid),
}

/// Number of shards of a study: one for each worker, at most one for each point.
fn shard_count(points: usize, workers: usize) -> usize {
    points.min(workers).max(1)
}

fn deliveries_of(job: &NewJob, workers: usize) -> Vec<Delivery> {
    match job.points {
        Some(points) => Delivery::shards(job.id, shard_count(points, workers)),
        None => vec![Delivery::of_job(job.id, job.priority)],
    }
}

/// Treatment of a submission.
enum Plan {
    /// Its key was used before: the first answer, or the refusal of another body.
    Replay(Box<Result<JobRecord, JobError>>),
    Queue,
    /// An existing result answers it.
    Answer(submissions::Reusable),
    /// An existing result may answer it, and has not been compared with its digests.
    Compare(Uuid),
    Refuse(JobError),
}

/// Free places in the queue.
struct Places {
    limits: IntakeLimits,
    /// Number of queued jobs by owner.
    waiting: HashMap<String, u64>,
}

impl Places {
    fn take(&mut self, owner: &str) -> Result<(), JobError> {
        if self.waiting.values().sum::<u64>() >= self.limits.queue {
            return Err(JobError::QueueFull { limit: self.limits.queue });
        }
        let waiting = self.waiting.entry(owner.to_owned()).or_default();
        if *waiting >= self.limits.queue_of_owner {
            return Err(JobError::OwnersQueueFull { limit: self.limits.queue_of_owner });
        }
        *waiting += 1;
        Ok(())
    }
}

/// Decides the treatment of a submission and records its key at once: the same batch may contain the key again.
async fn plan(tx: &mut Tx, job: &NewJob, places: &mut Places, keep_s: f64) -> Result<Plan, JobError> {
    if let Some(key) = &job.key
        && let Some(first_use) = idempotency_keys::first_use(tx, &job.owner, key).await?
    {
        let mut answer = first_use.first_answer(job, key);
        if answer.is_ok()
            && let Some(expired) = removal::expired(&mut *tx, &job.owner, first_use.job).await?
        {
            answer = Err(JobError::Expired(Box::new(expired)));
        }
        return Ok(Plan::Replay(Box::new(answer)));
    }
    let found = if job.reuse { submissions::reusable(tx, job).await? } else { None };
    let (plan, expires) = match found {
        Some(found) if job.compared != Some(found.result) => return Ok(Plan::Compare(found.result)),
        Some(found) => (Plan::Answer(found), Some(submissions::expiry(job, keep_s))),
        None => match places.take(&job.owner) {
            Ok(()) => (Plan::Queue, None),
            Err(full) => return Ok(Plan::Refuse(full)),
        },
    };
    if let Some(key) = &job.key {
        idempotency_keys::record(tx, job, key, expires).await?;
    }
    Ok(plan)
}
