//! One transaction, and one flush to the disk, for all submissions that wait: a transaction each would be
//! several times slower under load, and no faster without.

use std::collections::HashMap;
use std::sync::Arc;

use tokio::sync::{mpsc, oneshot};

use super::queue::{Delivery, Queue};
use super::store::database::{Lock, Tx};
use super::store::{Store, keys, submissions, upkeep};
use super::worker::{Begun, Worker};
use super::{JobError, JobRecord, NewJob};

/// Submissions that one transaction takes at most.
const BATCH: usize = 64;

type Answer = Result<Submitted, JobError>;
type Waiting = (NewJob, oneshot::Sender<Answer>);

/// A job that was handed in.
#[derive(Debug, Clone, PartialEq)]
pub struct Submitted {
    /// As it was answered first.
    pub record: JobRecord,
    /// Whether its idempotency key had made it before.
    pub replayed: bool,
}

/// Where submissions are handed in.
#[derive(Debug, Clone)]
pub struct Intake {
    sender: mpsc::Sender<Waiting>,
}

/// What a submission is measured against.
#[derive(Debug, Clone, Copy)]
pub struct IntakeLimits {
    /// Jobs that may wait.
    pub queue: u64,
    /// Of these, jobs of one owner.
    pub queue_of_owner: u64,
    /// How long jobs are kept that say nothing about it [s].
    pub keep_s: f64,
}

impl Intake {
    /// Starts the task that writes submissions.
    pub fn start(store: Store, queue: Arc<Queue>, worker: Arc<Worker>, limits: IntakeLimits) -> Self {
        let (sender, mut receiver) = mpsc::channel::<Waiting>(4 * BATCH);
        tokio::spawn(async move {
            let mut batch = Vec::with_capacity(BATCH);
            while receiver.recv_many(&mut batch, BATCH).await > 0 {
                write(&store, &queue, &worker, limits, std::mem::take(&mut batch)).await;
            }
        });
        Self { sender }
    }

    /// Hands in a job; the answer comes once it is on the disk.
    pub async fn submit(&self, job: NewJob) -> Answer {
        let (answer, answered) = oneshot::channel();
        self.sender.send((job, answer)).await.map_err(|_| JobError::Stopping)?;
        answered.await.map_err(|_| JobError::Stopping)?
    }
}

async fn write(store: &Store, queue: &Queue, worker: &Arc<Worker>, limits: IntakeLimits, batch: Vec<Waiting>) {
    let (jobs, waiting): (Vec<NewJob>, Vec<_>) = batch.into_iter().unzip();
    match write_all(store, queue, worker, limits, &jobs).await {
        // Whoever no longer waits for an answer has still submitted the job.
        Ok(answers) => waiting.into_iter().zip(answers).for_each(|(sender, answer)| drop(sender.send(answer))),
        Err(error) => {
            tracing::error!(%error, jobs = jobs.len(), "submissions could not be written");
            waiting.into_iter().for_each(|sender| drop(sender.send(Err(same_for_each(&error)))));
        }
    }
}

/// The error of a batch, told to each of those in it.
fn same_for_each(error: &JobError) -> JobError {
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
) -> Result<Vec<Answer>, JobError> {
    let mut tx = store.begin_alone(Lock::Intake).await?;
    let mut places = Places { limits, waiting: submissions::waiting(&mut tx).await? };
    let none_waited = places.waiting.is_empty();
    let mut plans = Vec::with_capacity(jobs.len());
    for job in jobs {
        plans.push(plan(&mut tx, job, &mut places, limits.keep_s).await?);
    }
    let slots = if jobs.iter().any(|job| job.points.is_some()) { upkeep::slots(&mut tx).await? } else { 1 };
    let to_run = |plan: &Plan| matches!(plan, Plan::Queue);
    let begin = |(job, plan): (&NewJob, &Plan)| {
        let may_begin = to_run(plan) && none_waited && job.points.is_none();
        may_begin.then(|| worker.begin(job)).flatten()
    };
    // Before they are in the record: while that is written they run.
    let mut begun: Vec<Option<Begun>> = jobs.iter().zip(&plans).map(begin).collect();
    let queued = jobs.iter().zip(&plans).zip(&begun).filter(|((_, plan), begun)| to_run(plan) && begun.is_none());
    let queued: Vec<_> = queued.flat_map(|((job, _), _)| deliveries_of(job, slots)).collect();
    let mut deliveries = queue.enqueue(&mut tx, &queued).await?.into_iter();
    let mut answers = Vec::with_capacity(jobs.len());
    for ((job, plan), begun) in jobs.iter().zip(plans).zip(&begun) {
        let record = match plan {
            Plan::Made(first) => {
                answers.push(first.map(|record| Submitted { record, replayed: true }));
                continue;
            }
            Plan::Answer(found) => Ok(submissions::insert_answered(&mut tx, job, found, limits.keep_s).await?),
            Plan::Refuse(reason) => Err(reason),
            Plan::Queue if job.points.is_some() => {
                let points = job.points.unwrap_or(0);
                let strands: Vec<i64> = deliveries.by_ref().take(strands_of(points, slots)).collect();
                Ok(submissions::insert_study(&mut tx, job, points, &strands).await?)
            }
            Plan::Queue if begun.is_some() => Ok(submissions::insert_begun(&mut tx, job).await?),
            Plan::Queue => {
                let delivery = deliveries.next().ok_or_else(|| JobError::Corrupt("a delivery is missing".into()))?;
                Ok(submissions::insert(&mut tx, job, delivery).await?)
            }
        };
        answers.push(record.map(|record| Submitted { record, replayed: false }));
    }
    tx.commit().await?;
    begun.drain(..).flatten().for_each(|begun| worker.go_on(begun));
    if !queued.is_empty() {
        queue.wake();
    }
    Ok(answers)
}

/// Strands of a study of so many points, where there are so many workers.
pub fn strands_of(points: usize, workers: usize) -> usize {
    points.min(workers).max(1)
}

fn deliveries_of(job: &NewJob, workers: usize) -> Vec<Delivery> {
    match job.points {
        Some(points) => Delivery::strands(job.id, strands_of(points, workers)),
        None => vec![Delivery::of_job(job.id, job.priority)],
    }
}

/// What happens to a submission.
enum Plan {
    /// Its key has made a job before, or is refused.
    Made(Box<Result<JobRecord, JobError>>),
    Queue,
    Answer(submissions::Reusable),
    Refuse(JobError),
}

/// Places in the queue.
struct Places {
    limits: IntakeLimits,
    /// Jobs that wait, by owner.
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

/// Notes the key of a submission that will be made at once: the same key may stand once more in the same batch.
async fn plan(tx: &mut Tx, job: &NewJob, places: &mut Places, keep_s: f64) -> Result<Plan, JobError> {
    if let Some(key) = &job.key
        && let Some(made) = keys::made(tx, &job.owner, key).await?
    {
        return Ok(Plan::Made(Box::new(made.first_answer(job, key))));
    }
    let found = if job.reuse { submissions::reusable(tx, job).await? } else { None };
    let (plan, expires) = match found {
        Some(found) => (Plan::Answer(found), Some(submissions::expiry(job, keep_s))),
        None => match places.take(&job.owner) {
            Ok(()) => (Plan::Queue, None),
            Err(full) => return Ok(Plan::Refuse(full)),
        },
    };
    if let Some(key) = &job.key {
        keys::note(tx, job, key, expires).await?;
    }
    Ok(plan)
}
