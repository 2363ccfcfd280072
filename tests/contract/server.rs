//! A server inside the test's process, with a stand-in simulator.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use raceway::api::Access;
use raceway::api::cors::origin;
use raceway::api::credentials::Tokens;
use raceway::api::service::Service;
use raceway::contract::{self, Job, Outcome, RunFailure};
use raceway::jobs::{Location, Settings, Simulator};
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
    /// Changes the database behind the service's back.
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

/// How a test wants its server.
pub struct Wishes {
    pub tokens: &'static str,
    pub origins: &'static [&'static str],
    pub workers: usize,
    pub queue_limit: u64,
    pub time_limit: Duration,
    pub max_pages: Option<u32>,
}

impl Default for Wishes {
    fn default() -> Self {
        Self {
            tokens: "",
            origins: &[],
            workers: 2,
            queue_limit: 1000,
            time_limit: Duration::from_secs(60),
            max_pages: None,
        }
    }
}

/// A server whose jobs do what their first label says.
pub fn start() -> InProcess {
    start_with(Wishes::default())
}

pub fn start_with(wishes: Wishes) -> InProcess {
    let place = tempfile::tempdir().expect("a directory");
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().expect("threads");
    let database = database(place.path());
    let settings = Settings {
        workers: wishes.workers,
        queue_limit: wishes.queue_limit,
        time_limit: wishes.time_limit,
        max_pages: wishes.max_pages,
        sweep_every: Duration::from_millis(200),
        ..Settings::on(database.clone())
    };
    let origins = wishes.origins.iter().map(|text| origin(text).expect("an origin")).collect();
    let access = Access { tokens: Tokens::parse(wishes.tokens), is_local: true, origins, ..Access::default() };
    let listen = SocketAddr::from(([127, 0, 0, 1], 0));
    let service = runtime.block_on(Service::start(listen, settings, access, stand_in())).expect("the service starts");
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

/// `slow` runs until it is stopped, `panic` panics, `fail` fails; everything else gives a short real run.
pub fn stand_in() -> Simulator {
    Arc::new(|job: &Job, control: &Control<'_>| match job.labels.first().map(String::as_str) {
        Some("slow") => slow(control),
        Some("panic") => panic!("as the test wants"),
        Some("fail") => Err(RunFailure::Failed { cause: "did-not-converge", detail: "as the test wants".into() }),
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

/// The real simulation, cut to a millisecond, and a study to four runs: results have their real form.
fn short(job: &Job, control: &Control<'_>) -> Result<Outcome, RunFailure> {
    let mut job = job.clone();
    job.settings.settle = 0.0;
    job.settings.duration = 0.001;
    if let Some(plan) = &mut job.plan {
        plan.methods.truncate(2);
        plan.relative_tolerances.truncate(2);
    }
    contract::execute(&job, control)
}
