//! The parts of a running service, shared by its requests and its background tasks.

use std::sync::Arc;

use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::database_lock::DatabaseLock;
use super::error::JobError;
use super::intake::Intake;
use super::queue::Queue;
use super::running::Running;
use super::settings::Settings;
use super::store::database::Store;
use super::token_cache::TokenCache;
use super::worker::Worker;

/// The parts of a running service.
#[derive(Clone)]
pub struct Parts {
    /// Id of this process among those that share the database.
    pub worker_id: Uuid,
    pub settings: Settings,
    pub store: Store,
    pub queue: Arc<Queue>,
    pub running: Arc<Running>,
    pub worker: Arc<Worker>,
    pub tokens: Arc<TokenCache>,
    pub intake: Intake,
    pub stopping: CancellationToken,
    /// `None` on a server.
    pub lock: Option<Arc<DatabaseLock>>,
}

impl Parts {
    pub fn is_stopping(&self) -> bool {
        self.stopping.is_cancelled()
    }

    /// Fails if the database file was moved, removed or replaced: writes to it would be lost at the next start.
    pub fn check_file_in_place(&self) -> Result<(), JobError> {
        let is_in_place = self.lock.as_ref().is_none_or(|lock| lock.is_in_place());
        if is_in_place { Ok(()) } else { Err(JobError::Displaced) }
    }
}
