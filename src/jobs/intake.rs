//! One transaction, and one flush to disk, for all waiting submissions. A transaction for each would be several times slower under
//! load, and no faster without load.

use std::collections::BTreeSet;
use std::sync::Arc;

use tokio::sync::{mpsc, oneshot};
use uuid::Uuid;

use super::error::JobError;
use super::job::{JobRecord, NewJob};
use super::places::{Left, Places, WorkLimits};
use super::queue::Queue;
use super::store::database::Store;
use super::store::part_names::REQUEST;
use super::store::pool::Tx;
use super::store::{due, idempotency_keys, maintenance, removal, reuse, submissions};
use super::token_cache::TokenCache;
use super::worker::{InlineRun, Worker};

/// Largest number of submissions in one transaction.
const BATCH_SIZE: usize = 64;

type Answer = Result<Reply, JobError>;
type Waiting = (NewJob, oneshot::Sender<Answer>);

/// The reply to a submission.
enum Reply {
    Submitted(Box<Submitted>),
    /// An existing result would answer the job, once it is known to be what was written. Nothing was stored.
    Compare(Box<NewJob>, Uuid),
    /// A job that seemed to have the same work is not what was written. Nothing was stored.
    Corrupt(Box<NewJob>, Uuid),
}

/// A submitted job.
#[derive(Debug, Clone, PartialEq)]
pub struct Submitted {
    /// The record of the first answer.
    pub record: JobRecord,
    /// True if an earlier submission with the same idempotency key created the job.
    pub replayed: bool,
    /// Rest of the limit of single jobs, or of points for a study.
    pub left: Left,
}

/// Entry of submissions.
#[derive(Debug, Clone)]
pub struct Intake {
    store: Store,
    sender: mpsc::Sender<Waiting>,
}

/// Limits of submissions.
#[derive(Debug, Clone, Copy, Default)]
pub struct IntakeLimits {
    pub work: WorkLimits,
    /// Retention of ended jobs that do not state their own [s].
    pub keep_s: f64,
}

impl Intake {
    /// Starts the task that writes submissions.
    pub fn start(
        store: Store,
        queue: Arc<Queue>,
        worker: Arc<Worker>,
        tokens: Arc<TokenCache>,
        limits: IntakeLimits,
    ) -> Self {
        let (sender, mut receiver) = mpsc::channel::<Waiting>(4 * BATCH_SIZE);
        let intake = Self { store: store.clone(), sender };
        tokio::spawn(async move {
            let mut batch = Vec::with_capacity(BATCH_SIZE);
            while receiver.recv_many(&mut batch, BATCH_SIZE).await > 0 {
                // They were answered while the database did not answer, or their clients have gone.
                batch.retain(|(_, answer)| !answer.is_closed());
                write(&store, &queue, &worker, &tokens, limits, std::mem::take(&mut batch)).await;
            }
        });
        intake
    }

    /// Submits a job; returns when it is on disk.
    pub async fn submit(&self, mut job: NewJob) -> Result<Submitted, JobError> {
        loop {
            match self.send(job).await? {
                Reply::Submitted(submitted) => return Ok(*submitted),
                Reply::Corrupt(same, other) => {
                    job = *same;
                    job.reuse = false;
                    self.store.found_corrupt(other, REQUEST).await;
                }
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

async fn write(
    store: &Store,
    queue: &Queue,
    worker: &Arc<Worker>,
    tokens: &TokenCache,
    limits: IntakeLimits,
    batch: Vec<Waiting>,
) {
    let (jobs, waiting): (Vec<NewJob>, Vec<_>) = batch.into_iter().unzip();
    match write_all(store, queue, worker, tokens, limits, &jobs).await {
        // A client that has gone has still submitted the job.
        Ok(answers) => waiting.into_iter().zip(jobs).zip(answers).for_each(|((sender, job), answer)| {
            let reply = answer.map(|outcome| match outcome {
                Written::Submitted(submitted) => Reply::Submitted(submitted),
                Written::Compare(result) => Reply::Compare(Box::new(job), result),
                Written::Corrupt(other) => Reply::Corrupt(Box::new(job), other),
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
    tokens: &TokenCache,
    limits: IntakeLimits,
    jobs: &[NewJob],
) -> Result<Vec<Result<Written, JobError>>, JobError> {
    let mut tx = store.begin().await?;
    let Accepted { answers, started, queued } = write_in(&mut tx, queue, worker, tokens, limits, jobs).await?;
    tx.commit().await?;
    started.into_iter().for_each(|run| worker.finish_inline(run));
    if queued > 0 {
        queue.wake();
    }
    Ok(answers)
}

/// Submissions in a transaction that is not committed yet.
pub(super) struct Accepted {
    answers: Vec<Result<Written, JobError>>,
    started: Vec<InlineRun>,
    /// Number of new deliveries.
    queued: usize,
}

/// Writes submissions in a transaction. It locks rows of their owners only, so that processes on one server do not wait for each other.
pub(super) async fn write_in(
    tx: &mut Tx,
    queue: &Queue,
    worker: &Arc<Worker>,
    tokens: &TokenCache,
    limits: IntakeLimits,
    jobs: &[NewJob],
) -> Result<Accepted, JobError> {
    // A job of a token without owner is found by the list of tokens.
    let has_tokens = !tokens.get().is_empty() || jobs.iter().any(|job| !job.owner.is_empty());
    let mut places = Places::new(limits.work, has_tokens, submissions::unfinished(tx).await?);
    let none_waits = !submissions::any_waits(tx).await?;
    let plans = plans(tx, jobs, &mut places, limits.keep_s).await?;
    let slots = if jobs.iter().any(|job| job.points.is_some()) { maintenance::slots(tx).await? } else { 1 };
    let is_queued = |plan: &Plan| matches!(plan, Plan::Queue);
    let start = |(job, plan): (&NewJob, &Plan)| {
        let may_start = is_queued(plan) && none_waits && job.points.is_none();
        may_start.then(|| worker.start_inline(job)).flatten()
    };
    // The runs start before the jobs are written, so that they overlap with the write.
    let started: Vec<Option<InlineRun>> = jobs.iter().zip(&plans).map(start).collect();
    let queued = jobs.iter().zip(&plans).zip(&started).filter(|((_, plan), run)| is_queued(plan) && run.is_none());
    let queued = queued.map(|((job, _), _)| job.points.map_or(1, |points| shard_count(points, slots))).sum();
    let mut deliveries = queue.enqueue(tx, queued).await?.into_iter();
    let mut answers = Vec::with_capacity(jobs.len());
    for ((job, plan), run) in jobs.iter().zip(plans).zip(&started) {
        let left = places.left(&job.owner, job.points.is_some());
        let record = match plan {
            Plan::Replay(first) => {
                answers
                    .push(first.map(|record| Written::Submitted(Box::new(Submitted { record, replayed: true, left }))));
                continue;
            }
            Plan::Compare(result) => {
                answers.push(Ok(Written::Compare(result)));
                continue;
            }
            Plan::Corrupt(other) => {
                answers.push(Ok(Written::Corrupt(other)));
                continue;
            }
            Plan::Answer(found) => Ok(submissions::insert_answered(tx, job, found, limits.keep_s).await?),
            Plan::Refuse(reason) => Err(reason),
            Plan::Queue if job.points.is_some() => {
                let points = job.points.unwrap_or(0);
                let shards: Vec<i64> = deliveries.by_ref().take(shard_count(points, slots)).collect();
                Ok(submissions::insert_study(tx, job, points, &shards).await?)
            }
            Plan::Queue if run.is_some() => Ok(submissions::insert_started(tx, job).await?),
            Plan::Queue => {
                let delivery = deliveries.next().ok_or_else(|| JobError::Corrupt("a delivery is missing".into()))?;
                Ok(submissions::insert(tx, job, delivery).await?)
            }
        };
        answers.push(record.map(|record| Written::Submitted(Box::new(Submitted { record, replayed: false, left }))));
    }
    let started_owners: BTreeSet<&str> =
        jobs.iter().zip(&started).filter(|(_, run)| run.is_some()).map(|(job, _)| job.owner.as_str()).collect();
    for owner in started_owners {
        due::begin_turn(tx, owner).await?;
    }
    Ok(Accepted { answers, started: started.into_iter().flatten().collect(), queued })
}

/// The outcome of a submission in a transaction.
enum Written {
    Submitted(Box<Submitted>),
    Compare(Uuid),
    Corrupt(Uuid),
}

/// Number of shards of a study: one for each worker, at most one for each point.
fn shard_count(points: usize, workers: usize) -> usize {
    points.min(workers).max(1)
}

/// Treatment of a submission.
enum Plan {
    /// Its key was used before: the first answer, or the refusal of another body.
    Replay(Box<Result<JobRecord, JobError>>),
    Queue,
    /// An existing result answers it.
    Answer(reuse::Reusable),
    /// The row that an index finds for its work is not what was written for that work.
    Corrupt(Uuid),
    /// An existing result may answer it, and has not been compared with its digests.
    Compare(Uuid),
    Refuse(JobError),
}

/// The treatments of submissions.
async fn plans(tx: &mut Tx, jobs: &[NewJob], places: &mut Places, keep_s: f64) -> Result<Vec<Plan>, JobError> {
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    // In the order of their keys: of two processes that record the same keys, one waits for the other, and never both.
    order.sort_by_key(|place| jobs[*place].key.as_ref().map(|key| (&jobs[*place].owner, &key.key)));
    let mut plans: Vec<Option<Plan>> = jobs.iter().map(|_| None).collect();
    for place in order {
        plans[place] = Some(plan(tx, &jobs[place], places, keep_s).await?);
    }
    Ok(plans.into_iter().flatten().collect())
}

/// Decides the treatment of a submission and records its key at once: the same batch may contain the key again.
async fn plan(tx: &mut Tx, job: &NewJob, places: &mut Places, keep_s: f64) -> Result<Plan, JobError> {
    if let Some(replay) = replay(tx, job).await? {
        return Ok(replay);
    }
    let lock = tx.dialect().for_share();
    let found = if job.reuse { reuse::reusable(&mut *tx, &job.owner, &job.content_hash, lock).await? } else { None };
    let (plan, expires) = match found {
        Some(found) if !found.is_sound => return Ok(Plan::Corrupt(found.job)),
        Some(found) if job.compared != Some(found.result) => return Ok(Plan::Compare(found.result)),
        Some(found) => (Plan::Answer(found), Some(submissions::expiry(job, keep_s))),
        None => match places.take(&job.owner, job.points) {
            Ok(()) => (Plan::Queue, None),
            Err(full) => return Ok(Plan::Refuse(full)),
        },
    };
    if let Some(key) = &job.key
        && !idempotency_keys::record(tx, job, key, expires).await?
    {
        if matches!(plan, Plan::Queue) {
            places.give_back(&job.owner, job.points);
        }
        let replay = replay(tx, job).await?;
        return replay.ok_or_else(|| JobError::Corrupt("an idempotency key is used and missing".to_owned()));
    }
    Ok(plan)
}

/// The answer to a submission whose key was used before.
async fn replay(tx: &mut Tx, job: &NewJob) -> Result<Option<Plan>, JobError> {
    let Some(key) = &job.key else { return Ok(None) };
    let Some(first_use) = idempotency_keys::first_use(tx, &job.owner, key).await? else { return Ok(None) };
    let mut answer = first_use.first_answer(job, key);
    if answer.is_ok()
        && let Some(expired) = removal::expired(&mut *tx, &job.owner, first_use.job).await?
    {
        answer = Err(JobError::Expired(Box::new(expired)));
    }
    Ok(Some(Plan::Replay(Box::new(answer))))
}
