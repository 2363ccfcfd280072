//! `raceway serve`.

use std::io::Write;
use std::sync::Arc;

use tokio::signal::unix::{SignalKind, signal};

use super::Ended;
use crate::api::Access;
use crate::api::service::Service;
use crate::config::{self, ServeOptions};
use crate::contract;
use crate::jobs::Simulator;

/// Serves until a signal comes.
pub async fn run(options: ServeOptions) -> Ended {
    log_to_stderr();
    let service = match start(&options).await {
        Ok(service) => service,
        Err(error) => {
            eprintln!("raceway: {error}");
            return Ended::Badly;
        }
    };
    announce(&service.url());
    wait_for_signal().await;
    tracing::info!("stopping; running jobs go back into the queue");
    // Whoever asks twice does not want to wait.
    tokio::select! {
        () = service.stop() => Ended::Well,
        () = wait_for_signal() => Ended::Badly,
    }
}

async fn start(options: &ServeOptions) -> Result<Service, Box<dyn std::error::Error>> {
    let tokens = config::tokens();
    options.check_access(&tokens)?;
    let settings = options.job_settings()?;
    let only_local_hosts = tokens.is_empty() && config::is_loopback(options.listen.ip());
    if tokens.is_empty() && !only_local_hosts {
        tracing::warn!(listen = %options.listen, "there are no tokens: whoever reaches the port may do everything");
    }
    Ok(Service::start(options.listen, settings, Access { tokens, only_local_hosts }, simulator()).await?)
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

/// Logs go to stderr; stdout carries only what a command is asked for.
pub fn log_to_stderr() {
    use tracing_subscriber::filter::Targets;
    use tracing_subscriber::prelude::*;
    let level = config::log_level();
    // What the libraries tell is only of interest when something is wrong with them.
    let targets = Targets::new().with_default(tracing::Level::WARN.min(level)).with_target("raceway", level);
    let layer = tracing_subscriber::fmt::layer().with_writer(std::io::stderr);
    let _ = tracing_subscriber::registry().with(layer.with_filter(targets)).try_init();
}

/// Ends with SIGINT or SIGTERM.
pub async fn wait_for_signal() {
    match (signal(SignalKind::interrupt()), signal(SignalKind::terminate())) {
        (Ok(mut interrupt), Ok(mut terminate)) => {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
        }
        // Without signals the process can still be killed, which loses nothing.
        _ => std::future::pending().await,
    }
}
