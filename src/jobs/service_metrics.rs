//! Counts and times of this process, and the depth of the queue, for Prometheus.

use std::time::{Duration, Instant};

use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::{Registry, Unit};

use super::error::JobError;
use super::job::Status;

/// Media type of `ServiceMetrics::text`.
pub const MEDIA_TYPE: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

type ByEnd = [(&'static str, &'static str); 1];

/// Depth of the queue.
#[derive(Debug, Clone, Copy, PartialEq, sqlx::FromRow)]
pub struct QueueDepth {
    pub waiting: i64,
    pub running: i64,
    /// Age of the oldest queued job [s]; 0 if none waits.
    pub oldest_waiting_s: f64,
    /// Number of simultaneous runs of all workers.
    pub slots: i64,
}

/// Counts and times since the process started; gauges are set when they are read.
#[derive(Debug)]
pub struct ServiceMetrics {
    registry: Registry,
    waiting: Gauge,
    running: Gauge,
    oldest: Gauge<f64, std::sync::atomic::AtomicU64>,
    slots: Gauge,
    claims: Counter,
    claims_lost: Counter,
    runs: Family<ByEnd, Counter>,
    corrupt_results: Counter,
    run_time: Histogram,
    real_time_factor: Histogram,
    database_wait: Histogram,
}

impl Default for ServiceMetrics {
    fn default() -> Self {
        let times = |first, count| Histogram::new(exponential_buckets(first, 4.0, count));
        let mut metrics = Self {
            registry: Registry::with_prefix("raceway"),
            waiting: Gauge::default(),
            running: Gauge::default(),
            oldest: Gauge::default(),
            slots: Gauge::default(),
            claims: Counter::default(),
            claims_lost: Counter::default(),
            runs: Family::default(),
            corrupt_results: Counter::default(),
            run_time: times(0.004, 10),
            real_time_factor: times(0.01, 10),
            database_wait: times(0.000_25, 10),
        };
        let registry = &mut metrics.registry;
        registry.register("jobs_waiting", "Queued jobs", metrics.waiting.clone());
        registry.register("jobs_running", "Running jobs on all machines", metrics.running.clone());
        let help = "Age of the oldest queued job";
        registry.register_with_unit("oldest_waiting", help, Unit::Seconds, metrics.oldest.clone());
        registry.register("worker_slots", "Simultaneous simulations that all machines allow", metrics.slots.clone());
        registry.register("claims", "Jobs and points that this process has claimed", metrics.claims.clone());
        let help = "Runs of this process that another one has taken over";
        registry.register("claims_lost", help, metrics.claims_lost.clone());
        registry.register("runs", "Ended runs of this process, by their end", metrics.runs.clone());
        let help = "Reads that found a stored result corrupt";
        registry.register("corrupt_results", help, metrics.corrupt_results.clone());
        let help = "Wall time of succeeded runs";
        registry.register_with_unit("run_time", help, Unit::Seconds, metrics.run_time.clone());
        let help = "Simulated time over wall time of succeeded simulations";
        registry.register("real_time_factor", help, metrics.real_time_factor.clone());
        let help = "Time until a write transaction begins";
        registry.register_with_unit("database_wait", help, Unit::Seconds, metrics.database_wait.clone());
        metrics
    }
}

impl ServiceMetrics {
    /// Counts a claim of a job or a point.
    pub fn claimed(&self) {
        self.claims.inc();
    }

    /// Counts a claim that another process took over.
    pub fn claim_lost(&self) {
        self.claims_lost.inc();
    }

    /// Counts the end of a run.
    pub fn ended(&self, end: Status) {
        self.runs.get_or_create(&[("end", end.name())]).inc();
    }

    /// Counts a read that found a stored result corrupt.
    pub fn found_corrupt(&self) {
        self.corrupt_results.inc();
    }

    /// Records the wall time of a succeeded run and, for a simulation, its real-time factor.
    pub fn succeeded(&self, wall_time: Duration, real_time_factor: Option<f64>) {
        self.run_time.observe(wall_time.as_secs_f64());
        if let Some(factor) = real_time_factor {
            self.real_time_factor.observe(factor);
        }
    }

    /// Waits for a write transaction and records the time.
    pub async fn measure_wait<T>(&self, transaction: impl Future<Output = T>) -> T {
        let begin = Instant::now();
        let tx = transaction.await;
        self.database_wait.observe(begin.elapsed().as_secs_f64());
        tx
    }

    /// All metrics as OpenMetrics text.
    pub fn text(&self, depth: &QueueDepth) -> Result<String, JobError> {
        self.waiting.set(depth.waiting);
        self.running.set(depth.running);
        self.oldest.set(depth.oldest_waiting_s);
        self.slots.set(depth.slots);
        let mut text = String::new();
        encode(&mut text, &self.registry).map_err(|error| JobError::Corrupt(error.to_string()))?;
        Ok(text)
    }
}
