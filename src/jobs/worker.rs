//! One delivered job: claim it, run it on a thread of its own, write how it ended.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use uuid::Uuid;

use super::ahead::{Ahead, Begun, DELIVERED_WITHIN, Solution};
use super::figures::Figures;
use super::job::{INTERNAL, TIME_LIMIT, WORKER_LOST};
use super::queue::{Delivered, Ticket};
use super::running::{Run, Running, Solved, StopReason};
use super::service::{Settings, Simulator};
use super::store::claims::{self, Pulse};
use super::store::database::Dialect;
use super::store::{Claim, End, Store, StoredResult};
use super::threads::SolverThreads;
use super::{Failure, JobError, Status};
use crate::contract::{self, JobKind, RunFailure};
use crate::simulation::run::{Control, Live};

/// Runs delivered jobs.
pub struct Worker {
    pub store: Store,
    pub running: Arc<Running>,
    pub simulator: Simulator,
    pub settings: Settings,
    slots: Arc<Semaphore>,
    ahead: Ahead,
    pub(super) threads: SolverThreads,
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
        Self { store, running, simulator, settings, slots, ahead: Ahead::default(), threads: SolverThreads::default() }
    }

    /// Begins with a job that is about to be delivered, where a slot is free.
    pub fn begin(self: &Arc<Self>, job: Uuid, request: String) {
        let Ok(slot) = Arc::clone(&self.slots).try_acquire_owned() else { return };
        let run = Arc::new(Run::default());
        let solution = self.solver_thread(request, &run);
        self.ahead.enter(job, Begun { _slot: slot, run, solution: Some(solution) });
        let worker = Arc::clone(self);
        tokio::spawn(async move {
            tokio::time::sleep(DELIVERED_WITHIN).await;
            drop(worker.ahead.take(job));
        });
    }

    /// Ends what was begun without a claim.
    pub fn stop_ahead(&self) {
        self.ahead.stop();
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
        let mut begun = match self.ahead.take(ticket.job) {
            Some(begun) => begun,
            None => {
                let outlook = self.store.outlook(ticket.job, ticket.delivery).await?;
                let Some(outlook) = outlook else { return Ok(Delivered::Done) };
                let measures = outlook.kind == JobKind::Accuracy.name();
                let slot = self.slots(outlook.losses, measures, ticket).await;
                let Some(slot) = slot else { return Ok(Delivered::HandedBack) };
                Begun { _slot: slot, run: Arc::default(), solution: None }
            }
        };
        let claim = self.store.claim(ticket.job, ticket.delivery, self.settings.max_lost_runs).await?;
        let Some(claim) = claim else { return Ok(Delivered::Done) };
        self.store.figures.claimed();
        let guard = self.running.enter(claim.job, Arc::clone(&begun.run));
        let outcome = match self.without_running(&claim) {
            Some(end) => Outcome::Ended(end),
            None => {
                let solution = begun.solution.take();
                let solution = solution.unwrap_or_else(|| self.solver_thread(claim.request.clone(), &guard.run));
                self.run(&claim, &guard.run, solution, ticket).await
            }
        };
        self.conclude(&claim, outcome, &guard.run, ticket).await
    }

    /// One slot, or all of them for a job that may have taken its process down and for one that measures time; none
    /// once the service stops.
    pub(super) async fn slots(&self, losses: u32, measures: bool, ticket: &Ticket) -> Option<OwnedSemaphorePermit> {
        let alone = losses >= LOSSES_TO_RUN_ALONE || measures;
        let slots = if alone { self.settings.workers } else { 1 };
        let slots = u32::try_from(slots).unwrap_or(1);
        tokio::select! {
            slot = Arc::clone(&self.slots).acquire_many_owned(slots) => slot.ok(),
            () = ticket.stopping() => None,
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

    async fn run(&self, claim: &Claim, run: &Run, mut solution: Solution, ticket: &Ticket) -> Outcome {
        // The claim was the first beat.
        let between = self.between_beats();
        let mut pulse = tokio::time::interval_at(tokio::time::Instant::now() + between, between);
        loop {
            tokio::select! {
                end = &mut solution => return ended(end, run, self.settings.time_limit),
                () = ticket.stopping(), if run.stopped().is_none() => run.stop(StopReason::HandedBack),
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
        ticket: &Ticket,
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
        let mut pause = Duration::from_millis(100);
        let written = loop {
            match self.store.note(self.write_end(claim, &end, run.progress()).await) {
                Ok(written) => break written,
                Err(error) => {
                    tracing::error!(%error, job = %claim.job, "the end of a run could not be written; trying again");
                }
            }
            tokio::select! {
                () = tokio::time::sleep(pause) => {}
                () = ticket.stopping() => return Ok(Delivered::HandedBack),
            }
            pause = (2 * pause).min(Duration::from_secs(5));
        };
        match written {
            Some(status) => {
                self.store.figures.ended(status);
                tell(claim.job, &end, run);
            }
            None => self.store.figures.claim_lost(),
        }
        self.running.ended(claim.job);
        Ok(Delivered::Done)
    }

    /// The end as it stands in the record; `None`: the claim is lost.
    async fn write_end(&self, claim: &Claim, end: &End, progress: f64) -> Result<Option<Status>, JobError> {
        let mut tx = self.store.begin().await?;
        let written = claims::finish(&mut tx, claim, end, progress, self.settings.keep_s).await?;
        if written.is_some() {
            // River notes by itself that the delivery is done. Should this process end before, it delivers a job that nobody can claim.
            tx.commit().await?;
        }
        Ok(written)
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
