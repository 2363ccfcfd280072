//! The parts of the service put together, in their order of starting and stopping.

use std::net::SocketAddr;

use axum::Router;
use tokio::net::{TcpListener, TcpSocket};
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

pub use super::server::url;
use super::{Access, App, lobby, probes, router, server};
use crate::jobs::{JobError, Jobs, Settings, Simulator};

/// A running service.
pub struct Service {
    jobs: Jobs,
    door: Door,
}

/// A running worker, which tells how it is where it has an address for that.
pub struct Worker {
    jobs: Jobs,
    door: Option<Door>,
}

/// What requests come in by.
struct Door {
    address: SocketAddr,
    stop: CancellationToken,
    serving: JoinHandle<()>,
}

/// Why the service does not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    #[error("cannot listen on {address}: {source}")]
    Listen { address: SocketAddr, source: std::io::Error },
    #[error(transparent)]
    Jobs(#[from] JobError),
}

impl Service {
    /// Starts to run jobs and to answer. The port comes first: a service that cannot be reached must not
    /// touch the database.
    pub async fn start(
        listen: SocketAddr,
        settings: Settings,
        access: Access,
        simulator: Simulator,
    ) -> Result<Self, StartError> {
        let listener = bind(listen)?;
        let jobs = Jobs::start(settings, simulator).await?;
        let app = App::new(jobs.clone(), access);
        Ok(Self { jobs, door: Door::open(listener, router(app.clone()), lobby(app)) })
    }

    /// Where it is reached.
    pub fn url(&self) -> String {
        server::url(self.door.address)
    }

    /// Where it listens; unspecified: on all interfaces.
    pub fn address(&self) -> SocketAddr {
        self.door.address
    }

    /// Stops: no more jobs, no more connections, running jobs back into the queue, database closed.
    pub async fn stop(self) {
        self.jobs.refuse_new();
        self.door.close().await;
        if let Err(error) = self.jobs.stop().await {
            tracing::error!(%error, "the queue did not stop as it should; its jobs run again at the next start");
        }
    }
}

impl Worker {
    /// Starts to run jobs and, at the address of the probes, to tell how that goes.
    pub async fn start(
        settings: Settings,
        simulator: Simulator,
        probed: Option<(SocketAddr, Access)>,
    ) -> Result<Self, StartError> {
        let Some((listen, access)) = probed else {
            return Ok(Self { jobs: Jobs::start(settings, simulator).await?, door: None });
        };
        let listener = bind(listen)?;
        let jobs = Jobs::start(settings, simulator).await?;
        let app = App::new(jobs.clone(), access);
        let door = Door::open(listener, probes(app.clone()), lobby(app));
        Ok(Self { jobs, door: Some(door) })
    }

    /// Where it is probed.
    pub fn url(&self) -> Option<String> {
        self.door.as_ref().map(|door| server::url(door.address))
    }

    /// Stops: running jobs back into the queue, database closed. It is alive until then, but not ready.
    pub async fn stop(self) -> Result<(), JobError> {
        self.jobs.refuse_new();
        let stopped = self.jobs.stop().await;
        if let Some(door) = self.door {
            door.close().await;
        }
        stopped
    }
}

/// Connections that wait in the kernel to be accepted. Of those that find no room there a client tries again after a second, then two.
const BACKLOG: u32 = 1024;

fn bind(address: SocketAddr) -> Result<(TcpListener, SocketAddr), StartError> {
    let listen = || {
        let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
        // A port that was in use a moment ago can be taken again.
        #[cfg(unix)]
        socket.set_reuseaddr(true)?;
        socket.bind(address)?;
        let listener = socket.listen(BACKLOG)?;
        let bound = listener.local_addr()?;
        Ok((listener, bound))
    };
    listen().map_err(|source| StartError::Listen { address, source })
}

impl Door {
    fn open((listener, address): (TcpListener, SocketAddr), router: Router, lobby: Router) -> Self {
        let stop = CancellationToken::new();
        let serving = tokio::spawn(server::serve(listener, router, lobby, stop.clone()));
        Self { address, stop, serving }
    }

    async fn close(self) {
        self.stop.cancel();
        if let Err(error) = self.serving.await {
            tracing::error!(%error, "the server broke off");
        }
    }
}
