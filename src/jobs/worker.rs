//! One job: claim it, run it on a thread of its own, write its end.
//!
//! Most jobs come from the queue. A job that is accepted while a slot is free and no job waits starts inline: it is claimed as it is
//! accepted and never queued, which saves several round trips to the database.
//!
//! A delivery is a turn. Its place among the runs is taken first and the work chosen last, so that the choice knows all that waits.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use raceway_core::simulation::input::control::{Control, Live};
use raceway_core::simulation::input::series_sink::SeriesSink;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use uuid::Uuid;

use super::error::JobError;
use super::job::{Failure, INTERNAL, NewJob, RESULT_CORRUPT, Status, TIME_LIMIT, WORKER_LOST};
use super::queue::{DeliveryOutcome, WorkItem};
use super::running::{JobEnd, Run, RunGuard, Running, SolverSummary, StopReason};
use super::series_writer::SeriesWriter;
use super::service_metrics::ServiceMetrics;
use super::settings::{Settings, Simulator};
use super::solver_threads::{Done, SolverThreads, UsedTime};
use super::store::claims::{Claim, End, Heartbeat};
use super::store::database::Store;
use super::store::dialect::Dialect;
use super::store::part_names::REQUEST;
use super::store::results::StoredResult;
use super::store::turns::{Turn, TurnLimits};
use super::store::uploaded_series::uploads;
use crate::contract::{self, RunFailure, Uploads};

/// Runs jobs.
pub struct Worker {
    pub store: Store,
    pub running: Arc<Running>,
    pub simulator: Simulator,
    pub settings: Settings,
    slots: Arc<Semaphore>,
    /// Inline runs, which have no delivery.
    inline: TaskTracker,
    /// Cancelled when the inline runs must stop.
    stopping: CancellationToken,
    pub(super) threads: SolverThreads,
}

/// Receiver of the solver thread's result.
type Solution = oneshot::Receiver<Done<Result<StoredResult, RunFailure>>>;

/// A run that started as its job was accepted. If the acceptance is not committed, dropping this stops the run.
pub(super) struct InlineRun {
    _slot: OwnedSemaphorePermit,
    claim: Claim,
    guard: RunGuard,
    solution: Option<Solution>,
}

impl Drop for InlineRun {
    fn drop(&mut self) {
        if self.solution.is_some() {
            self.guard.run.stop(StopReason::ClaimLost);
        }
    }
}

/// The outcome of a run.
pub(super) enum RunOutcome {
    /// With the processor time that no heartbeat has recorded [s].
    Ended(End, f64),
    HandedBack,
    ClaimLost,
}

impl Worker {
    pub fn new(store: Store, running: Arc<Running>, simulator: Simulator, settings: Settings) -> Self {
        let slots = Arc::new(Semaphore::new(settings.workers));
        let (inline, stopping, threads) = (TaskTracker::new(), CancellationToken::new(), SolverThreads::default());
        Self { store, running, simulator, settings, slots, inline, stopping, threads }
    }

    /// Starts a job that is being accepted, if a slot is free.
    pub fn start_inline(&self, job: &NewJob) -> Option<InlineRun> {
        // The values of a series are read before the run starts, which the queue can wait for.
        if self.stopping.is_cancelled() || !contract::named_series(job.request.as_bytes()).is_empty() {
            return None;
        }
        let slot = Arc::clone(&self.slots).try_acquire_owned().ok()?;
        let claim = Claim::at_acceptance(job);
        // Before the job is written: no sweep may find it without its run.
        let guard = self.running.enter(job.id, Arc::default());
        let solution = Some(self.solver_thread(&claim, &guard.run, Uploads::default()));
        Some(InlineRun { _slot: slot, claim, guard, solution })
    }

    /// Completes an inline run after its job is written.
    pub fn finish_inline(self: &Arc<Self>, mut inline: InlineRun) {
        let Some(solution) = inline.solution.take() else { return };
        self.store.metrics.claimed();
        let worker = Arc::clone(self);
        self.inline.spawn(async move {
            let (claim, run, stopping) = (&inline.claim, &inline.guard.run, &worker.stopping);
            let outcome = worker.run(claim, run, solution, stopping);
            // A solver that ignores its stop flag is abandoned: its heartbeat ceases, and a sweep finds the run.
            let Ok(outcome) = tokio::time::timeout(worker.settings.rescue_after(), outcome).await else {
                return tracing::error!(job = %claim.job, "a run did not react to its stop flag and is abandoned");
            };
            if let Err(error) = worker.conclude(claim, outcome, run, stopping).await {
                tracing::warn!(%error, job = %claim.job, "a run could not be returned to the queue");
            }
        });
    }

    /// Stops the inline runs and waits until they have returned their jobs.
    pub async fn drain(&self) {
        self.stopping.cancel();
        self.inline.close();
        self.inline.wait().await;
    }

    /// Uses the turn of a delivery.
    pub async fn work(&self, item: &WorkItem) -> DeliveryOutcome {
        self.take_turn(item).await.unwrap_or_else(DeliveryOutcome::Retry)
    }

    async fn take_turn(&self, item: &WorkItem) -> Result<DeliveryOutcome, JobError> {
        let mut alone = false;
        loop {
            let slots = if alone { self.settings.workers } else { 1 };
            let Some(_slots) = self.slots(slots, item.stopping()).await else { return Ok(DeliveryOutcome::HandedBack) };
            let limits = TurnLimits { max_lost_runs: self.settings.max_lost_runs, alone };
            match self.store.take_turn(item.delivery, limits).await? {
                Turn::Void => return Ok(DeliveryOutcome::Done),
                // The slot is returned first: two jobs that each wait for the slot of the other would wait for ever.
                Turn::Alone => alone = true,
                Turn::Job(claim) => return self.run_job(&claim, item).await,
                Turn::Shard(shard) => return self.run_shard(&shard, item).await,
            }
        }
    }

    async fn run_job(&self, claim: &Claim, item: &WorkItem) -> Result<DeliveryOutcome, JobError> {
        self.store.metrics.claimed();
        if claim.request.is_none() {
            self.store.found_corrupt(claim.job, REQUEST).await;
        }
        let guard = self.running.enter(claim.job, Arc::default());
        let outcome = match self.end_without_run(claim) {
            Some(end) => RunOutcome::Ended(end, 0.0),
            None => {
                let uploads = self.uploads(&claim.owner, claim.request.as_deref()).await?;
                let solution = self.solver_thread(claim, &guard.run, uploads);
                self.run(claim, &guard.run, solution, item.stopping()).await
            }
        };
        self.conclude(claim, outcome, &guard.run, item.stopping()).await
    }

    /// Waits for slots; `None` when the service stops.
    async fn slots(&self, slots: usize, stopping: &CancellationToken) -> Option<OwnedSemaphorePermit> {
        let slots = u32::try_from(slots).unwrap_or(1);
        tokio::select! {
            slot = Arc::clone(&self.slots).acquire_many_owned(slots) => slot.ok(),
            () = stopping.cancelled() => None,
        }
    }

    /// The end of a job that must not run: it was cancelled, or lost too often.
    pub(super) fn end_without_run(&self, claim: &Claim) -> Option<End> {
        if claim.cancel_requested {
            return Some(End::Cancelled);
        }
        if claim.request.is_none() {
            return Some(End::Failed(Failure::new(RESULT_CORRUPT, CORRUPT_REQUEST)));
        }
        (claim.lost >= self.settings.max_lost_runs).then(|| {
            let detail = format!("the process that ran the job ended {} times during the run", claim.lost);
            End::Failed(Failure::new(WORKER_LOST, detail))
        })
    }

    async fn run(&self, claim: &Claim, run: &Run, mut solution: Solution, stopping: &CancellationToken) -> RunOutcome {
        // The claim was the first heartbeat.
        let between = self.heartbeat_interval();
        let mut heartbeats = tokio::time::interval_at(tokio::time::Instant::now() + between, between);
        let mut used = UsedTime::start();
        loop {
            tokio::select! {
                solved = &mut solution => {
                    let rest_s = used.rest(solved.as_ref().ok().map(|done| done.used));
                    return outcome_of(solved.map(|done| done.result), rest_s, run, self.settings.time_limit);
                }
                () = stopping.cancelled(), if run.stopped().is_none() => run.stop(StopReason::HandedBack),
                _ = heartbeats.tick() => {
                    apply_heartbeat(self.store.heartbeat(claim, run.progress(), used.record()).await, run);
                }
            }
        }
    }

    /// Time between two heartbeats. Processes that share a server learn the progress of a run from them.
    pub(super) fn heartbeat_interval(&self) -> Duration {
        let between = self.settings.lost_after / 5;
        match self.store.dialect() {
            Dialect::Sqlite => between,
            Dialect::Postgres => between.min(Duration::from_secs(1)),
        }
    }

    /// The series that a request names. Those that are gone are left out, and the run says so.
    pub(super) async fn uploads(&self, owner: &str, request: Option<&str>) -> Result<Uploads, JobError> {
        let hashes = contract::named_series(request.unwrap_or_default().as_bytes());
        let read = async { uploads(self.store.packed_series(owner, &hashes).await?).await };
        match read.await {
            Err(JobError::SeriesExpired { .. } | JobError::ResultCorrupt { .. }) => Ok(Uploads::default()),
            uploads => uploads,
        }
    }

    fn solver_thread(&self, claim: &Claim, run: &Arc<Run>, uploads: Uploads) -> Solution {
        let (simulator, run) = (Arc::clone(&self.simulator), Arc::clone(run));
        let request = claim.request.clone().unwrap_or_default();
        let metrics = Arc::clone(&self.store.metrics);
        let time_limit = self.settings.time_limit;
        let (slots, workers) = (Arc::clone(&self.slots), self.settings.workers);
        let other_runs = move || workers.saturating_sub(slots.available_permits() + 1);
        let series = Arc::new(SeriesWriter::new(self.store.clone(), claim, Arc::clone(&run), time_limit));
        self.threads
            .run(move || solve(&simulator, (&request, &uploads), &run, &other_runs, time_limit, &metrics, &series))
    }

    /// Writes the end, and retries while the database refuses.
    async fn conclude(
        &self,
        claim: &Claim,
        outcome: RunOutcome,
        run: &Run,
        stopping: &CancellationToken,
    ) -> Result<DeliveryOutcome, JobError> {
        let (end, used_s) = match outcome {
            RunOutcome::Ended(end, used_s) => (end, used_s),
            RunOutcome::ClaimLost => {
                self.store.metrics.claim_lost();
                return Ok(DeliveryOutcome::Done);
            }
            RunOutcome::HandedBack => {
                self.store.hand_back(claim).await?;
                return Ok(DeliveryOutcome::HandedBack);
            }
        };
        run.conclude();
        let mut pause = Duration::from_millis(100);
        let written = loop {
            // River itself completes the delivery afterwards. If this process ends before that, the job of the redelivery cannot be claimed.
            let finished = self.store.finish(claim, &end, run.progress(), used_s, self.settings.keep_s).await;
            match self.store.note(finished) {
                Ok(written) => break written,
                Err(error) => {
                    tracing::error!(%error, job = %claim.job, "the end of a run could not be written; retrying");
                }
            }
            tokio::select! {
                () = tokio::time::sleep(pause) => {}
                () = stopping.cancelled() => return Ok(DeliveryOutcome::HandedBack),
            }
            pause = (2 * pause).min(Duration::from_secs(5));
        };
        match written {
            Some(record) => {
                self.store.metrics.ended(record.status);
                log_end(claim.job, &end, run);
                let metrics = if record.status == Status::Succeeded { end.into_metrics() } else { None };
                self.running.ended_as(JobEnd { record, metrics });
            }
            None => {
                self.store.metrics.claim_lost();
                self.running.ended(claim.job);
            }
        }
        Ok(DeliveryOutcome::Done)
    }
}

/// Logs the end of a run.
fn log_end(job: Uuid, end: &End, run: &Run) {
    match (end, run.summary()) {
        (End::Failed(failure), _) => tracing::info!(%job, cause = %failure.cause, "a run has failed"),
        (End::Succeeded(_), Some(SolverSummary { wall_time, rung })) => {
            let seconds = (1e3 * wall_time.as_secs_f64()).round() / 1e3;
            tracing::info!(%job, seconds, rung, "a run has succeeded");
        }
        (end, _) => tracing::info!(%job, status = end.status().name(), "a run has ended"),
    }
}

/// Stops the run if the answer to its heartbeat requires it.
pub(super) fn apply_heartbeat(answer: Result<Heartbeat, JobError>, run: &Run) {
    match answer {
        Ok(Heartbeat::Alive) => {}
        Ok(Heartbeat::CancelRequested) => run.stop(StopReason::Cancelled),
        Ok(Heartbeat::ClaimLost) => run.stop(StopReason::ClaimLost),
        // The run continues: its end is fenced, and most connections recover before the run counts as lost.
        Err(error) => tracing::warn!(%error, "a heartbeat could not be written"),
    }
}

/// Parses the request and simulates it until it ends, must stop, or exceeds its time limit.
fn solve(
    simulator: &Simulator,
    (request, uploads): (&str, &Uploads),
    run: &Run,
    other_runs: &dyn Fn() -> usize,
    time_limit: Duration,
    metrics: &ServiceMetrics,
    series: &Arc<SeriesWriter>,
) -> Result<StoredResult, RunFailure> {
    let internal = |detail: String| RunFailure::Failed { cause: INTERNAL, detail };
    let job = contract::parse_job_with(request.as_bytes(), uploads).map_err(|refusal| internal(refusal.to_string()))?;
    let begin = Instant::now();
    let stop = || {
        if begin.elapsed() > time_limit {
            run.stop(StopReason::TimeLimit);
        }
        run.stopped().is_some()
    };
    let most_other_runs = AtomicUsize::new(other_runs());
    let progress = |share| {
        run.set_progress(share);
        most_other_runs.fetch_max(other_runs(), Ordering::Relaxed);
    };
    let live = |live: &Live<'_>| run.update_view(live);
    let sink: Arc<dyn SeriesSink> = Arc::clone(series) as _;
    let mut outcome = simulator(&job, &Control { stop: &stop, progress: &progress, live: &live, series: Some(&sink) })?;
    let solved = begin.elapsed();
    let most_other_runs = Some(most_other_runs.into_inner() as u64);
    match &mut outcome {
        contract::Outcome::Accuracy(answer) => answer.timing.most_other_runs = most_other_runs,
        contract::Outcome::Modes(answer) => answer.timing.most_other_runs = most_other_runs,
        _ => {}
    }
    let solver = match &outcome {
        contract::Outcome::Simulation(simulated) => Some(&simulated.metrics.solver),
        _ => None,
    };
    metrics.succeeded(solved, solver.map(|solver| solver.real_time_factor));
    run.set_summary(SolverSummary { wall_time: solved, rung: solver.map(|solver| solver.rung.clone()) });
    let chunks = series.take().map_err(|error| internal(error.to_string()))?;
    let stored = StoredResult::of(&outcome, chunks).map_err(|error| internal(error.to_string()));
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    tracing::debug!(solved_ms = ms(solved), encoded_ms = ms(begin.elapsed() - solved), "a result is there");
    stored
}

/// The solver thread's answer; an error if the thread panicked.
pub(super) type Solved = Result<Result<StoredResult, RunFailure>, oneshot::error::RecvError>;

/// The outcome of a run by the solver's answer and the reason why it was stopped.
pub(super) fn outcome_of(solved: Solved, used_s: f64, run: &Run, time_limit: Duration) -> RunOutcome {
    let end = match solved {
        Ok(Ok(result)) => End::Succeeded(result),
        Ok(Err(RunFailure::Failed { cause, detail })) => End::Failed(Failure::new(cause, detail)),
        Ok(Err(RunFailure::Cancelled)) => match run.stopped() {
            Some(StopReason::HandedBack) => return RunOutcome::HandedBack,
            Some(StopReason::ClaimLost) => return RunOutcome::ClaimLost,
            Some(StopReason::TimeLimit) => End::Failed(Failure::new(TIME_LIMIT, time_limit_detail(time_limit))),
            Some(StopReason::Cancelled) | None => End::Cancelled,
        },
        // The log has the message of the panic.
        Err(_) => End::Failed(Failure::new(INTERNAL, BROKE_OFF)),
    };
    RunOutcome::Ended(end, used_s)
}

/// Detail of a job whose stored request is not what was written.
pub(super) const CORRUPT_REQUEST: &str = "the stored request of the job is not what was written; submit it again";

/// Detail of a run that a panic ended.
pub(super) const BROKE_OFF: &str = "the simulation ended with an internal error of the service";

/// Detail of a run that exceeded its time limit.
pub(super) fn time_limit_detail(limit: Duration) -> String {
    format!("the run took longer than {} s of wall time", limit.as_secs_f64())
}
