//! The parts of the service put together, in their order of starting and stopping.

use std::net::SocketAddr;

use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

pub use super::server::url;
use super::{Access, App, lobby, router, server};
use crate::jobs::{JobError, Jobs, Settings, Simulator};

/// A running service.
pub struct Service {
    address: SocketAddr,
    jobs: Jobs,
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
        let refused = |source| StartError::Listen { address: listen, source };
        let listener = TcpListener::bind(listen).await.map_err(refused)?;
        let address = listener.local_addr().map_err(refused)?;
        let jobs = Jobs::start(settings, simulator).await?;
        let stop = CancellationToken::new();
        let app = App::new(jobs.clone(), access);
        let serving = tokio::spawn(server::serve(listener, router(app.clone()), lobby(app), stop.clone()));
        Ok(Self { address, jobs, stop, serving })
    }

    /// Where it is reached.
    pub fn url(&self) -> String {
        server::url(self.address)
    }

    /// Stops: no more jobs, no more connections, running jobs back into the queue, database closed.
    pub async fn stop(self) {
        self.jobs.refuse_new();
        self.stop.cancel();
        if let Err(error) = self.serving.await {
            tracing::error!(%error, "the server broke off");
        }
        if let Err(error) = self.jobs.stop().await {
            tracing::error!(%error, "the queue did not stop as it should; its jobs run again at the next start");
        }
    }
}
