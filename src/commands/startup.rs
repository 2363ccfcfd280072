//! Start of the service and of a worker: the simulator, the rules of access, and the line that announces the address.

use std::io::Write;
use std::net::SocketAddr;
use std::sync::Arc;

use crate::api::Access;
use crate::config::{self, ConfigError};
use crate::contract;
use crate::jobs::tokens::TokenBook;
use crate::jobs::{JobError, Location, Simulator};

/// The simulator of the service.
pub fn simulator() -> Simulator {
    Arc::new(contract::execute)
}

/// Rules of access at an address. An address that other machines reach needs tokens or `insecure_no_auth`.
pub async fn access(
    listen: SocketAddr,
    database: &Location,
    insecure_no_auth: bool,
) -> Result<Access, Box<dyn std::error::Error>> {
    let (tokens, is_local) = (config::tokens()?, config::is_loopback(listen.ip()));
    if !is_local && tokens.is_empty() && !has_tokens(database).await? {
        if !insecure_no_auth {
            return Err(ConfigError::OpenToEveryone(listen).into());
        }
        tracing::warn!(%listen, "there are no tokens: whoever reaches the port may do everything");
    }
    if !is_local && tokens.is_weak() {
        if !insecure_no_auth {
            return Err(ConfigError::WeakToken(listen).into());
        }
        tracing::warn!(%listen, "a token is short enough to be guessed");
    }
    Ok(Access { tokens, is_local, ..Access::default() })
}

/// Returns whether the database has ever had a token. A missing database is not created.
async fn has_tokens(database: &Location) -> Result<bool, JobError> {
    if matches!(database, Location::File(path) if !path.exists()) {
        return Ok(false);
    }
    let book = TokenBook::open(database).await?;
    let tokens = book.list().await;
    book.close().await;
    Ok(!tokens?.is_empty())
}

/// Prints the address, the line that scripts wait for. A closed stdout is no reason to stop.
pub fn announce(url: &str) {
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "listening on {url}").and_then(|()| stdout.flush());
}
