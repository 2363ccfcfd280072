//! What operators watch: counts and times of this process, and the standing of the queue, for Prometheus.

use std::time::{Duration, Instant};

use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::{Registry, Unit};

use super::store::upkeep::Standing;
use super::{JobError, Status};

/// Media type of `Figures::text`.
pub const MEDIA_TYPE: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

type ByEnd = [(&'static str, &'static str); 1];

/// Counts and times since the process began; gauges are set when they are asked for.
#[derive(Debug)]
pub struct Figures {
    registry: Registry,
    waiting: Gauge,
    running: Gauge,
    oldest: Gauge<f64, std::sync::atomic::AtomicU64>,
    slots: Gauge,
    claims: Counter,
    claims_lost: Counter,
    runs: Family<ByEnd, Counter>,
    run_time: Histogram,
    real_time_factor: Histogram,
    database_wait: Histogram,
}

impl Default for Figures {
    fn default() -> Self {
        let times = |first, count| Histogram::new(exponential_buckets(first, 4.0, count));
        let mut figures = Self {
            registry: Registry::with_prefix("raceway"),
            waiting: Gauge::default(),
            running: Gauge::default(),
            oldest: Gauge::default(),
            slots: Gauge::default(),
            claims: Counter::default(),
            claims_lost: Counter::default(),
            runs: Family::default(),
            run_time: times(0.004, 10),
            real_time_factor: times(0.01, 10),
            database_wait: times(0.000_25, 10),
        };
        let registry = &mut figures.registry;
        registry.register("jobs_waiting", "Jobs that wait", figures.waiting.clone());
        registry.register("jobs_running", "Jobs that run, on all machines", figures.running.clone());
        let help = "How long the oldest waiting job has waited";
        registry.register_with_unit("oldest_waiting", help, Unit::Seconds, figures.oldest.clone());
        registry.register("worker_slots", "Simulations that may run at a time, on all machines", figures.slots.clone());
        registry.register("claims", "Jobs and points that this process has taken up", figures.claims.clone());
        let help = "Runs of this process that another one has taken over";
        registry.register("claims_lost", help, figures.claims_lost.clone());
        registry.register("runs", "Runs of this process that have ended", figures.runs.clone());
        let help = "Wall time of runs that succeeded";
        registry.register_with_unit("run_time", help, Unit::Seconds, figures.run_time.clone());
        let help = "Simulated time over wall time of simulations that succeeded";
        registry.register("real_time_factor", help, figures.real_time_factor.clone());
        let help = "Waits for a write transaction";
        registry.register_with_unit("database_wait", help, Unit::Seconds, figures.database_wait.clone());
        figures
    }
}

impl Figures {
    /// Someone has taken up a job or a point.
    pub fn claimed(&self) {
        self.claims.inc();
    }

    /// Another process has taken over.
    pub fn claim_lost(&self) {
        self.claims_lost.inc();
    }

    /// A run has ended.
    pub fn ended(&self, end: Status) {
        self.runs.get_or_create(&[("end", end.name())]).inc();
    }

    /// A run has succeeded, in so much time, and so much faster than what it simulated.
    pub fn succeeded(&self, wall_time: Duration, real_time_factor: Option<f64>) {
        self.run_time.observe(wall_time.as_secs_f64());
        if let Some(factor) = real_time_factor {
            self.real_time_factor.observe(factor);
        }
    }

    /// Waits for a write transaction.
    pub async fn waiting_for<T>(&self, transaction: impl Future<Output = T>) -> T {
        let begin = Instant::now();
        let begun = transaction.await;
        self.database_wait.observe(begin.elapsed().as_secs_f64());
        begun
    }

    /// All of it, with the queue as it stands.
    pub fn text(&self, standing: &Standing) -> Result<String, JobError> {
        self.waiting.set(standing.waiting);
        self.running.set(standing.running);
        self.oldest.set(standing.oldest_waiting_s);
        self.slots.set(standing.slots);
        let mut text = String::new();
        encode(&mut text, &self.registry).map_err(|error| JobError::Corrupt(error.to_string()))?;
        Ok(text)
    }
}
