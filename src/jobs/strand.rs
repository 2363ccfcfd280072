//! One strand of a study: point after point, until none waits, the study ends, or others have waited long enough.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::oneshot;

use super::job::{INTERNAL, TIME_LIMIT, point_hashes};
use super::queue::{Delivered, Ticket};
use super::running::{Run, StopReason};
use super::store::studies::{Next, PointClaim, PointResult, Strand};
use super::worker::{Worker, follow, stop_after};
use super::{JobError, Status};
use crate::contract::answer::point::PointError;
use crate::contract::{self, Job, PointEnd, Refusal, Simulation, Study, execute_point};
use crate::simulation::input::control::Control;

/// How long a strand keeps its place while others of its kind wait.
const SLICE: Duration = Duration::from_secs(1);

/// What became of a point.
enum Computed {
    Ended(PointResult),
    /// The run was told to stop.
    Stopped,
}

impl Worker {
    /// Works a strand for a while.
    pub(super) async fn strand(&self, ticket: &Ticket, strand: Strand) -> Result<Delivered, JobError> {
        let delivery = strand.delivery;
        let delivered = self.points(ticket, strand).await;
        // Where it cannot be written the strand is replaced after a while.
        if let Err(error) = self.store.rest_strand(delivery).await {
            tracing::warn!(%error, "a strand could not be laid to rest");
        }
        delivered
    }

    async fn points(&self, ticket: &Ticket, strand: Strand) -> Result<Delivered, JobError> {
        let Some(_slot) = self.slots(strand.losses, false, ticket.stopping()).await else {
            return Ok(Delivered::HandedBack);
        };
        let request = strand.request.clone();
        // Reading a large one takes its time.
        let job = tokio::task::spawn_blocking(move || contract::parse_job(request.as_bytes()).ok());
        let Some(study) = job.await.ok().flatten().and_then(Job::into_study) else {
            return Err(JobError::Corrupt(format!("the request of study {}", strand.job)));
        };
        self.store.begin_strand(&strand, self.settings.max_lost_runs).await?;
        let guard = self.running.join(strand.job);
        let begin = Instant::now();
        let mut ended: Option<(PointClaim, PointResult)> = None;
        loop {
            let next = self.advance(&strand, ended.as_ref(), ticket).await?;
            let point = match next {
                Some(Next::Point(point)) => {
                    self.store.figures.claimed();
                    point
                }
                Some(Next::Nothing) => return Ok(Delivered::Done),
                Some(Next::Ended | Next::Cancelled) => {
                    self.running.ended(strand.job);
                    return Ok(Delivered::Done);
                }
                // The process stops while the database refuses: the point is computed again.
                None => return Ok(Delivered::HandedBack),
            };
            match self.point(&strand, &study, point, &guard.run, ticket).await? {
                Computed::Ended(result) => ended = Some((point, result)),
                Computed::Stopped if guard.run.stopped() == Some(StopReason::Cancelled) => {
                    // Here and not by what stands in the record: a full disk may have refused the note of it.
                    self.store.cancel_study(&strand, self.settings.keep_s).await?;
                    self.running.ended(strand.job);
                    return Ok(Delivered::Done);
                }
                // Other strands have taken over from this one, or from one that shares its run and stopped both.
                Computed::Stopped if guard.run.stopped() == Some(StopReason::ClaimLost) => {
                    self.store.give_back(&strand, point).await?;
                    return Ok(Delivered::Later);
                }
                Computed::Stopped => {
                    self.store.give_back(&strand, point).await?;
                    return Ok(Delivered::HandedBack);
                }
            }
            if let Some(end) = &ended
                && self.gives_way(begin).await
            {
                let mut next = self.advance(&strand, Some(end), ticket).await?;
                if let Some(Next::Point(point)) = next {
                    self.store.give_back(&strand, point).await?;
                    next = None;
                }
                if matches!(next, Some(Next::Ended | Next::Cancelled)) {
                    self.running.ended(strand.job);
                }
                return Ok(if next.is_some() { Delivered::Done } else { Delivered::Later });
            }
        }
    }

    /// Whether jobs wait that go before studies, or others of the same rank for long enough.
    async fn gives_way(&self, begin: Instant) -> bool {
        // Who waits is no reason to lose what has been computed.
        let (before, any) = self.store.others_wait().await.unwrap_or_default();
        before || any && begin.elapsed() > SLICE
    }

    /// Writes an end and takes the next point, again and again while the database refuses; `None` once the process stops.
    async fn advance(
        &self,
        strand: &Strand,
        ended: Option<&(PointClaim, PointResult)>,
        ticket: &Ticket,
    ) -> Result<Option<Next>, JobError> {
        let mut pause = Duration::from_millis(100);
        loop {
            let ended = ended.map(|(point, result)| (*point, result));
            match self.store.note(self.store.advance(strand, ended, self.settings.keep_s).await) {
                Ok(next) => return Ok(Some(next)),
                Err(error) => tracing::error!(%error, job = %strand.job, "a point could not be written; trying again"),
            }
            tokio::select! {
                () = tokio::time::sleep(pause) => {}
                () = ticket.stopping().cancelled() => return Ok(None),
            }
            pause = (2 * pause).min(Duration::from_secs(5));
        }
    }

    async fn point(
        &self,
        strand: &Strand,
        study: &Study,
        point: PointClaim,
        run: &Arc<Run>,
        ticket: &Ticket,
    ) -> Result<Computed, JobError> {
        let simulation = study.point(point.number);
        let hashes = simulation.as_ref().ok().map(point_hashes);
        if study.reuses()
            && let Some(hashes) = &hashes
            && let Some(end) = self.store.known(&strand.owner, hashes).await?
        {
            return Ok(Computed::Ended(PointResult { end, reused: true, content_hash: Some(hashes[0].clone()) }));
        }
        let hash = hashes.map(|[hash, _]| hash);
        let mut solved = self.point_thread(simulation, Arc::clone(run));
        let between = self.between_beats();
        let mut pulse = tokio::time::interval_at(tokio::time::Instant::now() + between, between);
        let end = loop {
            tokio::select! {
                end = &mut solved => break end,
                _ = pulse.tick() => follow(self.store.strand_beat(strand).await, run),
                () = ticket.stopping().cancelled(), if run.stopped().is_none() => run.stop(StopReason::HandedBack),
            }
        };
        Ok(match end {
            Ok(Some(end)) => {
                self.store.figures.ended(match &end {
                    PointEnd::Succeeded(_) => Status::Succeeded,
                    PointEnd::Failed(_) => Status::Failed,
                });
                Computed::Ended(PointResult { end, reused: false, content_hash: hash })
            }
            Ok(None) => Computed::Stopped,
            // The thread panicked; what it said is in the log.
            Err(_) => {
                let detail = "the simulation broke off by an error in the service".to_owned();
                let error = PointError { cause: INTERNAL.to_owned(), detail, errors: Vec::new() };
                Computed::Ended(PointResult { end: PointEnd::Failed(error), reused: false, content_hash: None })
            }
        })
    }

    /// Simulates a point on a thread of its own; `None`: told to stop.
    fn point_thread(&self, point: Result<Simulation, Refusal>, run: Arc<Run>) -> oneshot::Receiver<Option<PointEnd>> {
        let (simulator, limit) = (Arc::clone(&self.simulator), self.settings.time_limit);
        let figures = Arc::clone(&self.store.figures);
        self.threads.run(move || {
            let begin = Instant::now();
            let over = || begin.elapsed() > limit;
            let stop = || over() || run.stopped().is_some();
            let simulate = |simulation: Simulation| {
                simulator(&Job::Simulation(simulation), &Control::until(&stop))?.into_simulated()
            };
            let end = execute_point(point, &simulate);
            if let Some(PointEnd::Succeeded(metrics)) = &end {
                figures.succeeded(begin.elapsed(), metrics["solver"]["real_time_factor"].as_f64());
            }
            if end.is_none() && run.stopped().is_none() && over() {
                return Some(PointEnd::Failed(PointError {
                    cause: TIME_LIMIT.to_owned(),
                    detail: stop_after(limit),
                    errors: Vec::new(),
                }));
            }
            end
        })
    }
}
