//! One job: claim it, run it on a thread of its own, write how it ended. Most come from the queue; one that is accepted while a slot
//! is free and nobody waits is claimed with its acceptance and never queued: whoever waits for a short job waits for many ways to
//! the database less.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use uuid::Uuid;

use super::figures::Figures;
use super::job::{INTERNAL, TIME_LIMIT, WORKER_LOST};
use super::queue::{Delivered, Ticket};
use super::running::{Ended, Run, RunGuard, Running, Solved, StopReason};
use super::service::{Settings, Simulator};
use super::store::claims::Pulse;
use super::store::database::Dialect;
use super::store::{Claim, End, Store, StoredResult};
use super::threads::SolverThreads;
use super::{Failure, JobError, NewJob, Status};
use crate::contract::{self, JobKind, RunFailure};
use crate::simulation::input::control::{Control, Live};

/// Runs delivered jobs.
pub struct Worker {
    pub store: Store,
    pub running: Arc<Running>,
    pub simulator: Simulator,
    pub settings: Settings,
    slots: Arc<Semaphore>,
    /// The runs that no delivery stands for, and what tells them that the process stops.
    unqueued: TaskTracker,
    stopping: CancellationToken,
    pub(super) threads: SolverThreads,
}

/// Where the solver's thread leaves what it has found.
type Solution = oneshot::Receiver<Result<StoredResult, RunFailure>>;

/// A run that began with the acceptance of its job. Where that is not committed, nobody claims it and it stops.
pub(super) struct Begun {
    _slot: OwnedSemaphorePermit,
    claim: Claim,
    guard: RunGuard,
    solution: Option<Solution>,
}

impl Drop for Begun {
    fn drop(&mut self) {
        if self.solution.is_some() {
            self.guard.run.stop(StopReason::ClaimLost);
        }
    }
}

/// What became of a run.
pub(super) enum Outcome {
    Ended(End),
    HandedBack,
    ClaimLost,
}

/// From this number of losses on a job runs alone, so that it takes no neighbour with it.
const LOSSES_TO_RUN_ALONE: u32 = 2;

impl Worker {
    pub fn new(store: Store, running: Arc<Running>, simulator: Simulator, settings: Settings) -> Self {
        let slots = Arc::new(Semaphore::new(settings.workers));
        let (unqueued, stopping, threads) = (TaskTracker::new(), CancellationToken::new(), SolverThreads::default());
        Self { store, running, simulator, settings, slots, unqueued, stopping, threads }
    }

    /// Begins with a job that is being accepted, where a slot is free.
    pub fn begin(&self, job: &NewJob) -> Option<Begun> {
        // One that measures time waits until it is alone.
        if self.stopping.is_cancelled() || job.kind == JobKind::Accuracy.name() {
            return None;
        }
        let slot = Arc::clone(&self.slots).try_acquire_owned().ok()?;
        let claim = Claim::with_acceptance(job);
        // Before the job is in the record: no sweep may find it there and nobody at it.
        let guard = self.running.enter(job.id, Arc::default());
        let solution = Some(self.solver_thread(job.request.clone(), &guard.run));
        Some(Begun { _slot: slot, claim, guard, solution })
    }

    /// Works what has begun to its end, once its job is in the record.
    pub fn go_on(self: &Arc<Self>, mut begun: Begun) {
        let Some(solution) = begun.solution.take() else { return };
        self.store.figures.claimed();
        let worker = Arc::clone(self);
        self.unqueued.spawn(async move {
            let (claim, run, stopping) = (&begun.claim, &begun.guard.run, &worker.stopping);
            let ended = worker.run(claim, run, solution, stopping);
            // A solver that does not even hear its stop flag is left alone: the run falls silent, and is found by that.
            let Ok(outcome) = tokio::time::timeout(worker.settings.rescue_after(), ended).await else {
                return tracing::error!(job = %claim.job, "a run did not hear that its time is over");
            };
            if let Err(error) = worker.conclude(claim, outcome, run, stopping).await {
                tracing::warn!(%error, job = %claim.job, "a run could not be handed back");
            }
        });
    }

    /// Has the runs that no delivery stands for hand their jobs back, and waits until they have.
    pub async fn drain(&self) {
        self.stopping.cancel();
        self.unqueued.close();
        self.unqueued.wait().await;
    }

    /// Works a delivery to its end.
    pub async fn work(&self, ticket: Ticket) -> Delivered {
        self.attempt(&ticket).await.unwrap_or_else(Delivered::Again)
    }

    async fn attempt(&self, ticket: &Ticket) -> Result<Delivered, JobError> {
        if ticket.strand {
            return match self.store.strand(ticket.delivery).await? {
                Some(strand) => self.strand(ticket, strand).await,
                None => Ok(Delivered::Done),
            };
        }
        let outlook = self.store.outlook(ticket.job, ticket.delivery).await?;
        let Some(outlook) = outlook else { return Ok(Delivered::Done) };
        let measures = outlook.kind == JobKind::Accuracy.name();
        let slot = self.slots(outlook.losses, measures, ticket.stopping()).await;
        let Some(_slot) = slot else { return Ok(Delivered::HandedBack) };
        let claim = self.store.claim(ticket.job, ticket.delivery, self.settings.max_lost_runs).await?;
        let Some(claim) = claim else { return Ok(Delivered::Done) };
        self.store.figures.claimed();
        let guard = self.running.enter(claim.job, Arc::default());
        let outcome = match self.without_running(&claim) {
            Some(end) => Outcome::Ended(end),
            None => {
                let solution = self.solver_thread(claim.request.clone(), &guard.run);
                self.run(&claim, &guard.run, solution, ticket.stopping()).await
            }
        };
        self.conclude(&claim, outcome, &guard.run, ticket.stopping()).await
    }

    /// One slot, or all of them for a job that may have taken its process down and for one that measures time; none
    /// once the service stops.
    pub(super) async fn slots(
        &self,
        losses: u32,
        measures: bool,
        stopping: &CancellationToken,
    ) -> Option<OwnedSemaphorePermit> {
        let alone = losses >= LOSSES_TO_RUN_ALONE || measures;
        let slots = if alone { self.settings.workers } else { 1 };
        let slots = u32::try_from(slots).unwrap_or(1);
        tokio::select! {
            slot = Arc::clone(&self.slots).acquire_many_owned(slots) => slot.ok(),
            () = stopping.cancelled() => None,
        }
    }

    /// The end of a job that must not run.
    pub(super) fn without_running(&self, claim: &Claim) -> Option<End> {
        if claim.cancel_requested {
            return Some(End::Cancelled);
        }
        (claim.lost >= self.settings.max_lost_runs).then(|| {
            let detail = format!("the process that ran the job ended {} times during the run", claim.lost);
            End::Failed(Failure::new(WORKER_LOST, detail))
        })
    }

    async fn run(&self, claim: &Claim, run: &Run, mut solution: Solution, stopping: &CancellationToken) -> Outcome {
        // The claim was the first beat.
        let between = self.between_beats();
        let mut pulse = tokio::time::interval_at(tokio::time::Instant::now() + between, between);
        loop {
            tokio::select! {
                end = &mut solution => return ended(end, run, self.settings.time_limit),
                () = stopping.cancelled(), if run.stopped().is_none() => run.stop(StopReason::HandedBack),
                _ = pulse.tick() => self.beat(claim, run).await,
            }
        }
    }

    async fn beat(&self, claim: &Claim, run: &Run) {
        follow(self.store.heartbeat(claim, run.progress()).await, run);
    }

    /// Time between two signs of life. Those who share a server see a run's progress by them.
    pub(super) fn between_beats(&self) -> Duration {
        let between = self.settings.lost_after / 5;
        match self.store.dialect() {
            Dialect::Sqlite => between,
            Dialect::Postgres => between.min(Duration::from_secs(1)),
        }
    }

    fn solver_thread(&self, request: String, run: &Arc<Run>) -> Solution {
        let (simulator, run) = (Arc::clone(&self.simulator), Arc::clone(run));
        let figures = Arc::clone(&self.store.figures);
        let time_limit = self.settings.time_limit;
        self.threads.run(move || solve(&simulator, &request, &run, time_limit, &figures))
    }

    /// Writes the end, again and again while the database refuses.
    async fn conclude(
        &self,
        claim: &Claim,
        outcome: Outcome,
        run: &Run,
        stopping: &CancellationToken,
    ) -> Result<Delivered, JobError> {
        let end = match outcome {
            Outcome::Ended(end) => end,
            Outcome::ClaimLost => {
                self.store.figures.claim_lost();
                return Ok(Delivered::Done);
            }
            Outcome::HandedBack => {
                self.store.hand_back(claim).await?;
                return Ok(Delivered::HandedBack);
            }
        };
        run.conclude();
        let mut pause = Duration::from_millis(100);
        let written = loop {
            // River notes by itself that the delivery is done. Should this process end before, it delivers a job that nobody can claim.
            match self.store.note(self.store.finish(claim, &end, run.progress(), self.settings.keep_s).await) {
                Ok(written) => break written,
                Err(error) => {
                    tracing::error!(%error, job = %claim.job, "the end of a run could not be written; trying again");
                }
            }
            tokio::select! {
                () = tokio::time::sleep(pause) => {}
                () = stopping.cancelled() => return Ok(Delivered::HandedBack),
            }
            pause = (2 * pause).min(Duration::from_secs(5));
        };
        match written {
            Some(record) => {
                self.store.figures.ended(record.status);
                tell(claim.job, &end, run);
                let metrics = if record.status == Status::Succeeded { end.into_metrics() } else { None };
                self.running.ended_as(Ended { record, metrics });
            }
            None => {
                self.store.figures.claim_lost();
                self.running.ended(claim.job);
            }
        }
        Ok(Delivered::Done)
    }
}

/// Notes the end of a run in the log.
fn tell(job: Uuid, end: &End, run: &Run) {
    match (end, run.solved()) {
        (End::Failed(failure), _) => tracing::info!(%job, cause = %failure.cause, "a run has failed"),
        (End::Succeeded(_), Some(Solved { time, rung })) => {
            let seconds = (1e3 * time.as_secs_f64()).round() / 1e3;
            tracing::info!(%job, seconds, rung, "a run has succeeded");
        }
        (end, _) => tracing::info!(%job, status = end.status().name(), "a run has ended"),
    }
}

/// What a heartbeat has learnt is what the run does.
pub(super) fn follow(learnt: Result<Pulse, JobError>, run: &Run) {
    match learnt {
        Ok(Pulse::Alive) => {}
        Ok(Pulse::CancelRequested) => run.stop(StopReason::Cancelled),
        Ok(Pulse::ClaimLost) => run.stop(StopReason::ClaimLost),
        // The run goes on: its end is fenced, and most links come back before anyone takes it for lost.
        Err(error) => tracing::warn!(%error, "a heartbeat could not be written"),
    }
}

/// Reads the request and simulates it, until it is told to stop or its time is over.
fn solve(
    simulator: &Simulator,
    request: &str,
    run: &Run,
    time_limit: Duration,
    figures: &Figures,
) -> Result<StoredResult, RunFailure> {
    let internal = |detail: String| RunFailure::Failed { cause: INTERNAL, detail };
    let job = contract::parse_job(request.as_bytes()).map_err(|refusal| internal(refusal.to_string()))?;
    let begin = Instant::now();
    let stop = || {
        if begin.elapsed() > time_limit {
            run.stop(StopReason::TimeLimit);
        }
        run.stopped().is_some()
    };
    let (progress, live) = (|share| run.set_progress(share), |live: &Live<'_>| run.show(live));
    let outcome = simulator(&job, &Control { stop: &stop, progress: &progress, live: &live })?;
    let solved = begin.elapsed();
    let solver = match &outcome {
        contract::Outcome::Simulation(simulated) => Some(&simulated.metrics.solver),
        _ => None,
    };
    figures.succeeded(solved, solver.map(|solver| solver.real_time_factor));
    run.note(Solved { time: solved, rung: solver.map(|solver| solver.rung.clone()) });
    let stored = StoredResult::of(&outcome).map_err(|error| internal(error.to_string()));
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    tracing::debug!(solved_ms = ms(solved), encoded_ms = ms(begin.elapsed() - solved), "a result is there");
    stored
}

pub(super) type Found = Result<Result<StoredResult, RunFailure>, oneshot::error::RecvError>;

pub(super) fn ended(found: Found, run: &Run, time_limit: Duration) -> Outcome {
    Outcome::Ended(match found {
        Ok(Ok(result)) => End::Succeeded(result),
        Ok(Err(RunFailure::Failed { cause, detail })) => End::Failed(Failure::new(cause, detail)),
        Ok(Err(RunFailure::Cancelled)) => match run.stopped() {
            Some(StopReason::HandedBack) => return Outcome::HandedBack,
            Some(StopReason::ClaimLost) => return Outcome::ClaimLost,
            Some(StopReason::TimeLimit) => End::Failed(Failure::new(TIME_LIMIT, stop_after(time_limit))),
            Some(StopReason::Cancelled) | None => End::Cancelled,
        },
        // The thread panicked; what it said is in the log, not for the user.
        Err(_) => End::Failed(Failure::new(INTERNAL, "the simulation broke off by an error in the service")),
    })
}

/// Why a run was ended.
pub(super) fn stop_after(limit: Duration) -> String {
    format!("the run took longer than {} s of wall time", limit.as_secs_f64())
}
