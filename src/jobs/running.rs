//! Runs of this process: stop flags, progress, and who waits for an end.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::watch;
use uuid::Uuid;

use super::JobRecord;
use crate::simulation::input::control::{Live, Phase};

/// Why a run is asked to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum StopReason {
    /// Someone asked for it.
    Cancelled = 1,
    /// The process stops; the job runs again later.
    HandedBack = 2,
    /// Another worker has taken the job.
    ClaimLost = 3,
    /// It took longer than a run may.
    TimeLimit = 4,
}

/// One run, shared by the solver's thread and those who look at it.
#[derive(Debug, Default)]
pub struct Run {
    stop: AtomicU8,
    progress: AtomicU64,
    view: Mutex<View>,
    solved: OnceLock<Solved>,
    concludes: AtomicBool,
}

/// How a run that has succeeded was made.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// Wall time.
    pub time: Duration,
    /// Of a simulation.
    pub rung: Option<String>,
}

/// How a run goes, for those who watch it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct View {
    /// `None`: it has not said.
    pub phase: Option<Phase>,
    /// rms of the spindle's accelerations in y and z so far [m/s²].
    pub accelerations: Option<[f64; 2]>,
    taken: Option<Instant>,
}

/// Least time between two estimates of what is being recorded: each goes through all that is there.
const BETWEEN_ESTIMATES: Duration = Duration::from_millis(100);

impl Run {
    /// Asks the run to stop; the first reason counts.
    pub fn stop(&self, reason: StopReason) {
        let _ = self.stop.compare_exchange(0, reason as u8, Ordering::AcqRel, Ordering::Acquire);
    }

    /// Why the run was asked to stop, if it was.
    pub fn stopped(&self) -> Option<StopReason> {
        match self.stop.load(Ordering::Acquire) {
            1 => Some(StopReason::Cancelled),
            2 => Some(StopReason::HandedBack),
            3 => Some(StopReason::ClaimLost),
            4 => Some(StopReason::TimeLimit),
            _ => None,
        }
    }

    /// Notes how the run was made; once.
    pub fn note(&self, solved: Solved) {
        let _ = self.solved.set(solved);
    }

    pub fn solved(&self) -> Option<&Solved> {
        self.solved.get()
    }

    /// Notes that this process writes the end of the job, and tells it to those who wait.
    pub fn conclude(&self) {
        self.concludes.store(true, Ordering::Release);
    }

    pub fn concludes(&self) -> bool {
        self.concludes.load(Ordering::Acquire)
    }

    pub fn set_progress(&self, share: f64) {
        self.progress.store(share.clamp(0.0, 1.0).to_bits(), Ordering::Relaxed);
    }

    /// Takes a look at the run, from the solver's thread.
    pub fn show(&self, live: &Live<'_>) {
        let mut view = locked(&self.view);
        if view.phase != Some(live.phase) {
            view.phase = Some(live.phase);
            view.taken = None;
        }
        if view.taken.is_none_or(|taken| taken.elapsed() > BETWEEN_ESTIMATES) {
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

/// How a job has ended.
#[derive(Debug, Clone)]
pub struct Ended {
    pub record: JobRecord,
    /// Of a simulation that has succeeded, as JSON text.
    pub metrics: Option<String>,
}

/// Changes once the job has ended; `None` then, too, where the end was written elsewhere.
pub type Bell = watch::Receiver<Option<Arc<Ended>>>;

/// The runs of this process.
#[derive(Debug, Default)]
pub struct Running {
    /// With the number of those who hold the run.
    runs: Mutex<HashMap<Uuid, (Arc<Run>, usize)>>,
    waiting: Mutex<HashMap<Uuid, watch::Sender<Option<Arc<Ended>>>>>,
}

impl Running {
    /// Adds a run; it leaves when the guard is dropped.
    pub fn enter(self: &Arc<Self>, id: Uuid, run: Arc<Run>) -> RunGuard {
        locked(&self.runs).insert(id, (Arc::clone(&run), 1));
        RunGuard { running: Arc::clone(self), id, run }
    }

    /// Joins a run, or begins one: strands of a study share theirs, until it is told to stop.
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

    /// Asks a run to stop, if it is one of this process.
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

    /// What changes once the job has ended; to be taken before the job is looked at.
    pub fn bell(&self, id: Uuid) -> Bell {
        let mut waiting = locked(&self.waiting);
        waiting.retain(|_, bell| bell.receiver_count() > 0);
        waiting.entry(id).or_insert_with(|| watch::channel(None).0).subscribe()
    }

    /// Tells those who wait that the job has ended.
    pub fn ended(&self, id: Uuid) {
        self.ring(id, None);
    }

    /// Tells them how, so that they need not ask the database.
    pub fn ended_as(&self, ended: Ended) {
        self.ring(ended.record.id, Some(Arc::new(ended)));
    }

    fn ring(&self, id: Uuid, ended: Option<Arc<Ended>>) {
        let bell = locked(&self.waiting).remove(&id);
        if let Some(bell) = bell {
            bell.send_replace(ended);
        }
    }
}

/// A run's place among the running ones.
#[derive(Debug)]
pub struct RunGuard {
    running: Arc<Running>,
    id: Uuid,
    pub run: Arc<Run>,
}

impl Drop for RunGuard {
    fn drop(&mut self) {
        let mut runs = locked(&self.running.runs);
        // A later run of the same job may have taken the place.
        if let Some((_, holders)) = runs.get_mut(&self.id).filter(|(run, _)| Arc::ptr_eq(run, &self.run)) {
            *holders -= 1;
            if *holders == 0 {
                runs.remove(&self.id);
            }
        }
    }
}

/// These maps are whole after every statement, so that a panic elsewhere spoils nothing.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
