//! One shard of a study: it runs point after point until none waits, the study ends, or other work is due.

use std::sync::Arc;
use std::time::{Duration, Instant};

use raceway_core::simulation::input::control::Control;
use tokio::sync::oneshot;

use super::error::JobError;
use super::job::{Failure, INTERNAL, RESULT_CORRUPT, Status, TIME_LIMIT, point_hashes};
use super::queue::{DeliveryOutcome, WorkItem};
use super::running::{Run, StopReason};
use super::solver_threads::{Done, UsedTime};
use super::store::part_names::REQUEST;
use super::store::studies::{Next, PointClaim, PointResult, StudyShard};
use super::worker::{BROKE_OFF, CORRUPT_REQUEST, Worker, apply_heartbeat, time_limit_detail};
use crate::contract::answer::point::PointError;
use crate::contract::{self, Job, PointEnd, Refusal, Simulation, Study, execute_point};

/// Time for which a shard keeps its slot while other work of its owner waits.
const TIME_SLICE: Duration = Duration::from_secs(1);

/// The outcome of a point's run.
enum PointOutcome {
    Ended(PointResult),
    /// The run had to stop.
    /// With the processor time that no heartbeat has recorded [s].
    Stopped(f64),
}

impl Worker {
    /// Runs points of a shard.
    pub(super) async fn run_shard(&self, shard: &StudyShard, item: &WorkItem) -> Result<DeliveryOutcome, JobError> {
        let outcome = self.points(item, shard).await;
        let rested = match &outcome {
            Ok(DeliveryOutcome::Done) => self.store.remove_shard(shard.delivery).await,
            _ => self.store.rest_shard(shard.delivery).await,
        };
        // A sweep replaces the shard after a while.
        if let Err(error) = rested {
            tracing::warn!(%error, "the end of the turn of a shard could not be recorded");
        }
        outcome
    }

    async fn points(&self, item: &WorkItem, shard: &StudyShard) -> Result<DeliveryOutcome, JobError> {
        let Some(request) = shard.request.clone() else {
            self.store.found_corrupt(shard.job, REQUEST).await;
            let failure = Failure::new(RESULT_CORRUPT, CORRUPT_REQUEST);
            self.store.fail_corrupt(shard, &failure, self.settings.keep_s).await?;
            self.running.ended(shard.job);
            return Ok(DeliveryOutcome::Done);
        };
        // Parsing a large request takes some time.
        let uploads = self.uploads(&shard.owner, Some(&request)).await?;
        let job = tokio::task::spawn_blocking(move || contract::parse_job_with(request.as_bytes(), &uploads).ok());
        let Some(study) = job.await.ok().flatten().and_then(Job::into_study) else {
            return Err(JobError::Corrupt(format!("the request of study {}", shard.job)));
        };
        self.store.start_shard(shard, self.settings.max_lost_runs).await?;
        let guard = self.running.join(shard.job);
        let begin = Instant::now();
        let mut ended: Option<(PointClaim, PointResult)> = None;
        loop {
            let since = Instant::now();
            let next = self.advance(shard, ended.as_ref(), begin.elapsed() > TIME_SLICE, item).await?;
            let point = match next {
                Some(Next::Point(point)) => {
                    self.store.metrics.claimed();
                    point
                }
                Some(Next::GiveWay) => return Ok(DeliveryOutcome::Later),
                Some(Next::Nothing) => return Ok(DeliveryOutcome::Done),
                Some(Next::Ended | Next::Cancelled) => {
                    self.running.ended(shard.job);
                    return Ok(DeliveryOutcome::Done);
                }
                // The process stops while the database refuses writes: the point is computed again.
                None => return Ok(DeliveryOutcome::HandedBack),
            };
            let outcome = self.point(shard, &study, point, since, &guard.run, item).await?;
            if let PointOutcome::Stopped(used_s) = outcome
                && let Err(error) = self.store.charge(shard, used_s).await
            {
                tracing::warn!(%error, job = %shard.job, "the time of a stopped point could not be charged");
            }
            match outcome {
                PointOutcome::Ended(result) => ended = Some((point, result)),
                PointOutcome::Stopped(_) if guard.run.stopped() == Some(StopReason::Cancelled) => {
                    // By the stop flag and not by the record: a full disk may have refused to record the request.
                    self.store.cancel_study(shard, self.settings.keep_s).await?;
                    self.running.ended(shard.job);
                    return Ok(DeliveryOutcome::Done);
                }
                // Other shards have replaced this one, or one that shares its run and stopped both.
                PointOutcome::Stopped(_) if guard.run.stopped() == Some(StopReason::ClaimLost) => {
                    self.store.give_back(shard, point).await?;
                    return Ok(DeliveryOutcome::Later);
                }
                PointOutcome::Stopped(_) => {
                    self.store.give_back(shard, point).await?;
                    return Ok(DeliveryOutcome::HandedBack);
                }
            }
        }
    }

    /// Writes an end and claims the next point, and retries while the database refuses; `None` when the process stops.
    async fn advance(
        &self,
        shard: &StudyShard,
        ended: Option<&(PointClaim, PointResult)>,
        slice_is_over: bool,
        item: &WorkItem,
    ) -> Result<Option<Next>, JobError> {
        let mut pause = Duration::from_millis(100);
        loop {
            let ended = ended.map(|(point, result)| (*point, result));
            match self.store.note(self.store.advance(shard, ended, slice_is_over, self.settings.keep_s).await) {
                Ok(next) => return Ok(Some(next)),
                Err(error) => tracing::error!(%error, job = %shard.job, "a point could not be written; retrying"),
            }
            tokio::select! {
                () = tokio::time::sleep(pause) => {}
                () = item.stopping().cancelled() => return Ok(None),
            }
            pause = (2 * pause).min(Duration::from_secs(5));
        }
    }

    /// Runs a point that was claimed in a transaction begun at `since`.
    async fn point(
        &self,
        shard: &StudyShard,
        study: &Study,
        point: PointClaim,
        since: Instant,
        run: &Arc<Run>,
        item: &WorkItem,
    ) -> Result<PointOutcome, JobError> {
        let simulation = study.point(point.number);
        let hashes = simulation.as_ref().ok().map(point_hashes);
        if study.reuses()
            && let Some(hashes) = &hashes
            && let Some(end) = self.store.known_end(&shard.owner, hashes).await?
        {
            let content_hash = Some(hashes[0].clone());
            // The worker is occupied by the claim as well, which takes longer than the search.
            let used_s = since.elapsed().as_secs_f64();
            return Ok(PointOutcome::Ended(PointResult { end, reused: true, content_hash, used_s }));
        }
        let hash = hashes.map(|[hash, _]| hash);
        let mut solved = self.point_thread(simulation, Arc::clone(run));
        let between = self.heartbeat_interval();
        let mut heartbeats = tokio::time::interval_at(tokio::time::Instant::now() + between, between);
        let mut used = UsedTime::start();
        let end = loop {
            tokio::select! {
                end = &mut solved => break end,
                _ = heartbeats.tick() => apply_heartbeat(self.store.shard_heartbeat(shard, used.record()).await, run),
                () = item.stopping().cancelled(), if run.stopped().is_none() => run.stop(StopReason::HandedBack),
            }
        };
        let used_s = used.rest(end.as_ref().ok().map(|done| done.used));
        Ok(match end.map(|done| done.result) {
            Ok(Some(end)) => {
                self.store.metrics.ended(match &end {
                    PointEnd::Succeeded(_) => Status::Succeeded,
                    PointEnd::Failed(_) => Status::Failed,
                });
                PointOutcome::Ended(PointResult { end, reused: false, content_hash: hash, used_s })
            }
            Ok(None) => PointOutcome::Stopped(used_s),
            // The log has the message of the panic.
            Err(_) => {
                let error = PointError { cause: INTERNAL.to_owned(), detail: BROKE_OFF.to_owned(), errors: Vec::new() };
                PointOutcome::Ended(PointResult {
                    end: PointEnd::Failed(error),
                    reused: false,
                    content_hash: None,
                    used_s,
                })
            }
        })
    }

    /// Simulates a point on a thread of its own; `None`: the run had to stop.
    fn point_thread(
        &self,
        point: Result<Simulation, Refusal>,
        run: Arc<Run>,
    ) -> oneshot::Receiver<Done<Option<PointEnd>>> {
        let (simulator, limit) = (Arc::clone(&self.simulator), self.settings.time_limit);
        let service_metrics = Arc::clone(&self.store.metrics);
        self.threads.run(move || {
            let begin = Instant::now();
            let over = || begin.elapsed() > limit;
            let stop = || over() || run.stopped().is_some();
            let simulate = |simulation: Simulation| {
                simulator(&Job::Simulation(simulation), &Control::until(&stop))?.into_simulated()
            };
            let end = execute_point(point, &simulate);
            if let Some(PointEnd::Succeeded(metrics)) = &end {
                service_metrics.succeeded(begin.elapsed(), metrics["solver"]["real_time_factor"].as_f64());
            }
            if end.is_none() && run.stopped().is_none() && over() {
                return Some(PointEnd::Failed(PointError {
                    cause: TIME_LIMIT.to_owned(),
                    detail: time_limit_detail(limit),
                    errors: Vec::new(),
                }));
            }
            end
        })
    }
}
