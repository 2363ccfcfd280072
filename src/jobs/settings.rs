//! Settings of queue and store.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use raceway_core::simulation::input::control::Control;

use super::places::WorkLimits;
use super::store::location::Location;
use crate::contract::{Job, Outcome, RunFailure};

/// Function that computes a job: the contract's `execute`, or a replacement in tests.
pub type Simulator = Arc<dyn Fn(&Job, &Control<'_>) -> Result<Outcome, RunFailure> + Send + Sync>;

/// Settings of queue and store.
#[derive(Debug, Clone)]
pub struct Settings {
    pub database: Location,
    /// Number of simultaneous runs; 0 leaves the jobs to other processes.
    pub workers: usize,
    pub work_limits: WorkLimits,
    /// Number of lost runs after which a job fails.
    pub max_lost_runs: u32,
    /// Longest wall time of a run.
    pub time_limit: Duration,
    /// Retention of ended jobs that do not state their own [s].
    pub keep_s: f64,
    /// Time for which an expired job is remembered.
    pub remember_expired: Duration,
    /// Time without a heartbeat after which a run counts as lost.
    pub lost_after: Duration,
    pub sweep_every: Duration,
    /// Number of 4 KiB pages at which the database counts as full; tests simulate a full disk with it.
    pub max_pages: Option<u32>,
}

impl Settings {
    /// Default settings for a database file.
    pub fn new(database: impl Into<PathBuf>) -> Self {
        Self::on(Location::File(database.into()))
    }

    /// Default settings for a database.
    pub fn on(database: Location) -> Self {
        Self {
            database,
            workers: std::thread::available_parallelism().map_or(1, usize::from),
            work_limits: WorkLimits::default(),
            max_lost_runs: 5,
            time_limit: Duration::from_secs(3600),
            keep_s: 30.0 * 86_400.0,
            remember_expired: Duration::from_secs(7 * 86_400),
            lost_after: Duration::from_secs(15),
            sweep_every: Duration::from_secs(10),
            max_pages: None,
        }
    }

    /// Time after which a run that does not react to its stop flag is abandoned. The run's own time limit expires first.
    pub fn rescue_after(&self) -> Duration {
        self.time_limit.saturating_add(Duration::from_secs(30))
    }
}
