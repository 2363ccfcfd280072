//! The service and the worker process: their parts in the order of start and stop.

use std::net::SocketAddr;

use axum::Router;
use tokio::net::{TcpListener, TcpSocket};
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use super::app::{Access, App};
use super::routes::{overflow, probes, router};
use super::server;
pub use super::server::url;
use crate::jobs::{JobError, Jobs, Settings, Simulator};

/// A running service.
pub struct Service {
    jobs: Jobs,
    http: HttpServer,
}

/// A running worker; it answers probes if it has an address for them.
pub struct Worker {
    jobs: Jobs,
    http: Option<HttpServer>,
}

/// A running HTTP server.
struct HttpServer {
    address: SocketAddr,
    stop: CancellationToken,
    serving: JoinHandle<()>,
}

/// Reason why the service does not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    #[error("cannot listen on {address}: {source}")]
    Listen { address: SocketAddr, source: std::io::Error },
    #[error(transparent)]
    Jobs(#[from] JobError),
}

impl Service {
    /// Starts to run jobs and to answer requests. The port is bound first: a service that cannot be reached must not open the database.
    pub async fn start(
        listen: SocketAddr,
        settings: Settings,
        access: Access,
        simulator: Simulator,
    ) -> Result<Self, StartError> {
        let listener = bind(listen)?;
        let jobs = Jobs::start(settings, simulator).await?;
        let app = App::new(jobs.clone(), access);
        Ok(Self { jobs, http: HttpServer::start(listener, router(app.clone()), overflow(app)) })
    }

    /// The URL of the service.
    pub fn url(&self) -> String {
        server::url(self.http.address)
    }

    /// The address it listens on; unspecified: all interfaces.
    pub fn address(&self) -> SocketAddr {
        self.http.address
    }

    /// Stops accepting jobs, closes the connections, returns running jobs to the queue, and closes the database.
    pub async fn stop(self) {
        self.jobs.refuse_new();
        self.http.stop().await;
        if let Err(error) = self.jobs.stop().await {
            tracing::error!(%error, "the queue did not stop cleanly; its jobs run again at the next start");
        }
    }
}

impl Worker {
    /// Starts to run jobs, and to answer probes if an address is given.
    pub async fn start(
        settings: Settings,
        simulator: Simulator,
        probes_at: Option<(SocketAddr, Access)>,
    ) -> Result<Self, StartError> {
        let Some((listen, access)) = probes_at else {
            return Ok(Self { jobs: Jobs::start(settings, simulator).await?, http: None });
        };
        let listener = bind(listen)?;
        let jobs = Jobs::start(settings, simulator).await?;
        let app = App::new(jobs.clone(), access);
        let http = HttpServer::start(listener, probes(app.clone()), overflow(app));
        Ok(Self { jobs, http: Some(http) })
    }

    /// The URL of the probes.
    pub fn url(&self) -> Option<String> {
        self.http.as_ref().map(|http| server::url(http.address))
    }

    /// Returns running jobs to the queue and closes the database. Until then the worker is alive but not ready.
    pub async fn stop(self) -> Result<(), JobError> {
        self.jobs.refuse_new();
        let stopped = self.jobs.stop().await;
        if let Some(http) = self.http {
            http.stop().await;
        }
        stopped
    }
}

/// Largest number of connections that wait in the kernel to be accepted. Clients of further connections retry after 1 s, then 2 s.
const BACKLOG: u32 = 1024;

fn bind(address: SocketAddr) -> Result<(TcpListener, SocketAddr), StartError> {
    let listen = || {
        let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
        // Allows a port that was in use a moment ago.
        #[cfg(unix)]
        socket.set_reuseaddr(true)?;
        socket.bind(address)?;
        let listener = socket.listen(BACKLOG)?;
        let bound = listener.local_addr()?;
        Ok((listener, bound))
    };
    listen().map_err(|source| StartError::Listen { address, source })
}

impl HttpServer {
    fn start((listener, address): (TcpListener, SocketAddr), router: Router, overflow: Router) -> Self {
        let stop = CancellationToken::new();
        let serving = tokio::spawn(server::serve(listener, router, overflow, stop.clone()));
        Self { address, stop, serving }
    }

    async fn stop(self) {
        self.stop.cancel();
        if let Err(error) = self.serving.await {
            tracing::error!(%error, "the HTTP server ended with an error");
        }
    }
}
