//! `raceway serve`.

use std::io::{IsTerminal, Write};
use std::net::SocketAddr;
use std::sync::Arc;

use tokio::signal::unix::{Signal, SignalKind, signal};

use super::Ended;
use crate::api::Access;
use crate::api::rates::Rates;
use crate::api::service::Service;
use crate::config::{self, ConfigError, ServeOptions};
use crate::contract;
use crate::jobs::tokens::TokenBook;
use crate::jobs::{JobError, Location, Simulator};

/// Serves until a signal comes.
pub async fn run(options: ServeOptions) -> Ended {
    let (service, mut signals) = match start(&options).await {
        Ok(started) => started,
        Err(error) => {
            eprintln!("raceway: {error}");
            return Ended::Badly;
        }
    };
    announce(&service.url());
    signals.next().await;
    tracing::info!("stopping; running jobs go back into the queue");
    // Whoever asks twice does not want to wait.
    tokio::select! {
        () = service.stop() => {
            tracing::info!("stopped");
            Ended::Well
        }
        () = signals.next() => Ended::Badly,
    }
}

/// Signals are heard before anyone learns that there is a service: whoever reads its address may stop it at once.
async fn start(options: &ServeOptions) -> Result<(Service, Signals), Box<dyn std::error::Error>> {
    log_to_stderr(tracing::Level::INFO)?;
    let signals = Signals::listen()?;
    let settings = options.job_settings()?;
    let access = access(options.listen, &settings.database, options.insecure_no_auth).await?;
    let rates = Rates::new(options.rate_limit);
    let access = Access { rates, origins: options.allowed_origins.clone(), ..access };
    let (database, workers) = (settings.database.kind(), settings.workers);
    let service = Service::start(options.listen, settings, access, simulator()).await?;
    let (address, listen) = (service.url(), service.address());
    tracing::info!(version = env!("CARGO_PKG_VERSION"), address, %listen, database, workers, "serving");
    Ok((service, signals))
}

/// Who may ask at an address. Where that would be everyone who reaches it, someone must have said that it is meant.
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
        tracing::warn!(%listen, "a token is so short that it may be guessed");
    }
    Ok(Access { tokens, is_local, ..Access::default() })
}

/// Whether there has ever been a token in the database. One that is not there yet is not made for it.
async fn has_tokens(database: &Location) -> Result<bool, JobError> {
    if matches!(database, Location::File(path) if !path.exists()) {
        return Ok(false);
    }
    let book = TokenBook::open(database).await?;
    let tokens = book.list().await;
    book.close().await;
    Ok(!tokens?.is_empty())
}

/// What production runs.
pub fn simulator() -> Simulator {
    Arc::new(contract::execute)
}

/// The one line that programs wait for. Nobody may be reading, which is no reason to end.
pub fn announce(url: &str) {
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "listening on {url}").and_then(|()| stdout.flush());
}

/// Logs go to stderr; stdout carries only what a command is asked for. `usual`: how much, where the environment does not say.
pub fn log_to_stderr(usual: tracing::Level) -> Result<(), ConfigError> {
    use tracing_subscriber::filter::Targets;
    use tracing_subscriber::prelude::*;
    let level = config::log_level(usual)?;
    // What the libraries tell is only of interest when something is wrong with them.
    let targets = Targets::new().with_default(tracing::Level::WARN.min(level)).with_target("raceway", level);
    let layer = tracing_subscriber::fmt::layer().with_writer(std::io::stderr);
    let layer = if config::logs_json()? {
        // A request has one span; a list of it would say the same twice.
        layer.json().flatten_event(true).with_span_list(false).boxed()
    } else {
        // Colours are for people; a file would keep their codes.
        layer.with_ansi(std::io::stderr().is_terminal()).boxed()
    };
    let _ = tracing_subscriber::registry().with(layer.with_filter(targets)).try_init();
    Ok(())
}

/// A write beyond the largest size of a file (`ulimit -f`): its number on Linux (but for MIPS and PA-RISC), macOS and the BSDs.
const SIGXFSZ: i32 = 25;

/// SIGINT and SIGTERM; from the moment this exists they no longer end the process, nor does a file that may not
/// grow: the write fails, as on a full disk.
pub struct Signals {
    interrupt: Signal,
    terminate: Signal,
    _file_size: Signal,
}

impl Signals {
    pub fn listen() -> std::io::Result<Self> {
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            _file_size: signal(SignalKind::from_raw(SIGXFSZ))?,
        })
    }

    /// Ends with the next one.
    pub async fn next(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}
