//! A server inside the process of the test, with a stub for the simulator.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use raceway::api::Access;
use raceway::api::cors::origin;
use raceway::api::credentials::Tokens;
use raceway::api::service::Service;
use raceway::contract::{self, Job, Outcome, RunFailure};
use raceway::jobs::{Location, Settings, Simulator, WorkLimits};
use raceway::simulation::input::control::Control;
use tempfile::TempDir;
use tokio::runtime::Runtime;

use crate::common::{POSTGRES, Server, postgres_database};

/// A running service with its runtime and its directory.
pub struct InProcess {
    runtime: Runtime,
    service: Option<Service>,
    address: String,
    database: Location,
    _place: TempDir,
}

impl Server for InProcess {
    fn address(&self) -> &str {
        &self.address
    }
}

impl Drop for InProcess {
    fn drop(&mut self) {
        if let Some(service) = self.service.take() {
            self.runtime.block_on(service.stop());
        }
    }
}

impl InProcess {
    /// Changes the database directly.
    pub fn sql(&self, on_sqlite: &'static str, on_postgres: &'static str) {
        use sqlx::Connection;
        let done = self.runtime.block_on(async {
            match &self.database {
                Location::File(path) => {
                    let url = format!("sqlite://{}", path.display());
                    let mut connection = sqlx::SqliteConnection::connect(&url).await?;
                    sqlx::raw_sql(on_sqlite).execute(&mut connection).await?;
                    connection.close().await
                }
                Location::Server(options) => {
                    let mut connection = sqlx::PgConnection::connect_with(options).await?;
                    sqlx::raw_sql(on_postgres).execute(&mut connection).await?;
                    connection.close().await
                }
            }
        });
        done.expect("the database takes it");
    }
}

/// Settings of a test server.
pub struct ServerSettings {
    pub tokens: &'static str,
    pub origins: &'static [&'static str],
    pub workers: usize,
    pub queue_limit: u64,
    pub point_limit: u64,
    pub time_limit: Duration,
    pub max_pages: Option<u32>,
}

impl Default for ServerSettings {
    fn default() -> Self {
        Self {
            tokens: "",
            origins: &[],
            workers: 2,
            queue_limit: 1000,
            point_limit: 100_000,
            time_limit: Duration::from_secs(60),
            max_pages: None,
        }
    }
}

/// A server whose jobs behave as their first label states.
pub fn start() -> InProcess {
    start_with(ServerSettings::default())
}

pub fn start_with(settings: ServerSettings) -> InProcess {
    let place = tempfile::tempdir().expect("a directory");
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().expect("threads");
    let database = database(place.path());
    let job_settings = Settings {
        workers: settings.workers,
        work_limits: WorkLimits { jobs: settings.queue_limit, points: settings.point_limit, ..WorkLimits::default() },
        time_limit: settings.time_limit,
        max_pages: settings.max_pages,
        sweep_every: Duration::from_millis(200),
        ..Settings::on(database.clone())
    };
    let origins = settings.origins.iter().map(|text| origin(text).expect("an origin")).collect();
    let access = Access { tokens: Tokens::parse(settings.tokens), is_local: true, origins, ..Access::default() };
    let listen = SocketAddr::from(([127, 0, 0, 1], 0));
    let service =
        runtime.block_on(Service::start(listen, job_settings, access, stub_simulator())).expect("the service starts");
    let address = service.url().strip_prefix("http://").expect("a URL").to_owned();
    InProcess { runtime, service: Some(service), address, database, _place: place }
}

/// An empty database.
fn database(place: &Path) -> Location {
    match postgres_database() {
        Some(url) => Location::server(&url).expect("a URL"),
        None => Location::File(place.join("test.db")),
    }
}

/// Whether the test servers use PostgreSQL.
pub fn on_postgres() -> bool {
    std::env::var(POSTGRES).is_ok()
}

/// A stub for the simulator: `slow` runs until it is stopped, `panic` panics, `fail` fails, and any other label is a short real run.
pub fn stub_simulator() -> Simulator {
    Arc::new(|job: &Job, control: &Control<'_>| match job.submission().labels.first().map(String::as_str) {
        Some("slow") => slow(control),
        Some("panic") => panic!("intended by the test"),
        Some("fail") => Err(RunFailure::Failed { cause: "did-not-converge", detail: "intended by the test".into() }),
        _ => short(job, control),
    })
}

fn slow(control: &Control<'_>) -> Result<Outcome, RunFailure> {
    (control.progress)(0.25);
    while !(control.stop)() {
        std::thread::sleep(Duration::from_millis(5));
    }
    Err(RunFailure::Cancelled)
}

/// The real simulation over 1 ms, and accuracy jobs with four runs, so that results have their real form.
fn short(job: &Job, control: &Control<'_>) -> Result<Outcome, RunFailure> {
    let mut job = job.clone();
    let base = match &mut job {
        Job::Simulation(simulation) => simulation,
        Job::Study(study) => &mut study.base,
        Job::Uncertainty(job) => &mut job.study.base,
        Job::Optimum(search) => &mut search.base,
        Job::Accuracy(comparison) => {
            comparison.plan.methods.truncate(2);
            comparison.plan.relative_tolerances.truncate(2);
            &mut comparison.base
        }
        Job::Modes(_) | Job::Rotor(_) | Job::Machine(_) => return contract::execute(&job, control),
    };
    base.settings.settle = 0.0;
    base.settings.duration = 0.001;
    contract::execute(&job, control)
}
