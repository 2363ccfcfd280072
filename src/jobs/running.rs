//! Runs of this process: stop flags, progress, and requests that wait for an end.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use raceway_core::simulation::input::control::{Live, Phase};
use tokio::sync::watch;
use uuid::Uuid;

use super::job::JobRecord;

/// Reason why a run must stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum StopReason {
    /// A client cancelled the job.
    Cancelled = 1,
    /// The process stops; the job runs again later.
    HandedBack = 2,
    /// Another worker has taken the job.
    ClaimLost = 3,
    /// The run exceeded its time limit.
    TimeLimit = 4,
}

/// One run, shared by the solver thread and the requests that read its progress.
#[derive(Debug, Default)]
pub struct Run {
    stop: AtomicU8,
    progress: AtomicU64,
    view: Mutex<View>,
    summary: OnceLock<SolverSummary>,
    concludes: AtomicBool,
}

/// Wall time and model level of a succeeded run.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverSummary {
    pub wall_time: Duration,
    /// Model level of a simulation.
    pub rung: Option<String>,
}

/// Phase and current levels of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct View {
    /// `None`: not reported yet.
    pub phase: Option<Phase>,
    /// rms of the spindle's accelerations in y and z up to now [m/s²].
    pub accelerations: Option<[f64; 2]>,
    taken: Option<Instant>,
}

/// Shortest time between two estimates of the levels: each estimate reads everything recorded up to now.
const ESTIMATE_INTERVAL: Duration = Duration::from_millis(100);

impl Run {
    /// Asks the run to stop; the first reason counts.
    pub fn stop(&self, reason: StopReason) {
        let _ = self.stop.compare_exchange(0, reason as u8, Ordering::AcqRel, Ordering::Acquire);
    }

    /// The reason why the run must stop, if any.
    pub fn stopped(&self) -> Option<StopReason> {
        match self.stop.load(Ordering::Acquire) {
            1 => Some(StopReason::Cancelled),
            2 => Some(StopReason::HandedBack),
            3 => Some(StopReason::ClaimLost),
            4 => Some(StopReason::TimeLimit),
            _ => None,
        }
    }

    /// Records the summary of a succeeded run; the first call counts.
    pub fn set_summary(&self, summary: SolverSummary) {
        let _ = self.summary.set(summary);
    }

    pub fn summary(&self) -> Option<&SolverSummary> {
        self.summary.get()
    }

    /// Records that this process writes the end of the job and notifies the waiting requests itself.
    pub fn conclude(&self) {
        self.concludes.store(true, Ordering::Release);
    }

    pub fn concludes(&self) -> bool {
        self.concludes.load(Ordering::Acquire)
    }

    pub fn set_progress(&self, share: f64) {
        // Bits of numbers from 0 on are in the order of the numbers. A run that begins again with shorter steps keeps what was shown.
        if share > 0.0 {
            self.progress.fetch_max(share.min(1.0).to_bits(), Ordering::Relaxed);
        }
    }

    /// Updates phase and levels; called by the solver thread.
    pub fn update_view(&self, live: &Live<'_>) {
        let mut view = locked(&self.view);
        if view.phase != Some(live.phase) {
            view.phase = Some(live.phase);
            view.taken = None;
        }
        if view.taken.is_none_or(|taken| taken.elapsed() > ESTIMATE_INTERVAL) {
            view.accelerations = (live.accelerations)().or(view.accelerations);
            view.taken = Some(Instant::now());
        }
    }

    pub fn view(&self) -> View {
        *locked(&self.view)
    }

    /// Finished share, 0–1.
    pub fn progress(&self) -> f64 {
        f64::from_bits(self.progress.load(Ordering::Relaxed))
    }
}

/// The end of a job.
#[derive(Debug, Clone)]
pub struct JobEnd {
    pub record: JobRecord,
    /// Metrics of a succeeded simulation, as JSON text.
    pub metrics: Option<String>,
}

/// Receiver that changes when the job ends. Its value is `None` if another process wrote the end.
pub type Completion = watch::Receiver<Option<Arc<JobEnd>>>;

/// The runs of this process.
#[derive(Debug, Default)]
pub struct Running {
    /// Each run with the number of its holders.
    runs: Mutex<HashMap<Uuid, (Arc<Run>, usize)>>,
    waiting: Mutex<HashMap<Uuid, watch::Sender<Option<Arc<JobEnd>>>>>,
}

impl Running {
    /// Adds a run; dropping the guard removes it.
    pub fn enter(self: &Arc<Self>, id: Uuid, run: Arc<Run>) -> RunGuard {
        locked(&self.runs).insert(id, (Arc::clone(&run), 1));
        RunGuard { running: Arc::clone(self), id, run }
    }

    /// Joins the run of a study, or starts one. The shards of a study share one run until it must stop.
    pub fn join(self: &Arc<Self>, id: Uuid) -> RunGuard {
        let mut runs = locked(&self.runs);
        let run = match runs.get_mut(&id).filter(|(run, _)| run.stopped().is_none()) {
            Some((run, holders)) => {
                *holders += 1;
                Arc::clone(run)
            }
            None => {
                let run = Arc::new(Run::default());
                runs.insert(id, (Arc::clone(&run), 1));
                run
            }
        };
        RunGuard { running: Arc::clone(self), id, run }
    }

    pub fn get(&self, id: Uuid) -> Option<Arc<Run>> {
        locked(&self.runs).get(&id).map(|(run, _)| Arc::clone(run))
    }

    /// Asks a run to stop if it is one of this process.
    pub fn cancel(&self, id: Uuid) {
        if let Some(run) = self.get(id) {
            run.stop(StopReason::Cancelled);
        }
    }

    pub fn ids(&self) -> Vec<Uuid> {
        locked(&self.runs).keys().copied().collect()
    }

    /// Asks every run to stop.
    pub fn stop_all(&self, reason: StopReason) {
        locked(&self.runs).values().for_each(|(run, _)| run.stop(reason));
    }

    /// A receiver that changes when the job ends. It must be taken before the job is read.
    pub fn completion(&self, id: Uuid) -> Completion {
        let mut waiting = locked(&self.waiting);
        waiting.retain(|_, sender| sender.receiver_count() > 0);
        waiting.entry(id).or_insert_with(|| watch::channel(None).0).subscribe()
    }

    /// Notifies the waiting requests that the job has ended.
    pub fn ended(&self, id: Uuid) {
        self.notify(id, None);
    }

    /// Notifies the waiting requests with the end, so that they need not query the database.
    pub fn ended_as(&self, end: JobEnd) {
        self.notify(end.record.id, Some(Arc::new(end)));
    }

    fn notify(&self, id: Uuid, end: Option<Arc<JobEnd>>) {
        let sender = locked(&self.waiting).remove(&id);
        if let Some(sender) = sender {
            sender.send_replace(end);
        }
    }
}

/// Removes a run from the registry when it is dropped.
#[derive(Debug)]
pub struct RunGuard {
    running: Arc<Running>,
    id: Uuid,
    pub run: Arc<Run>,
}

impl Drop for RunGuard {
    fn drop(&mut self) {
        let mut runs = locked(&self.running.runs);
        // A later run of the same job may have replaced this one.
        if let Some((_, holders)) = runs.get_mut(&self.id).filter(|(run, _)| Arc::ptr_eq(run, &self.run)) {
            *holders -= 1;
            if *holders == 0 {
                runs.remove(&self.id);
            }
        }
    }
}

/// Ignores poisoning: the maps are consistent after every statement, so a panic elsewhere does no harm.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
