//! `raceway worker`: runs jobs of a service on the same server, without HTTP.

use std::io::Write;

use super::exit::Exit;
use super::logging::log_to_stderr;
use super::signals::Signals;
use super::startup::{access, simulator};
use crate::api::service::Worker;
use crate::config::WorkerOptions;

/// Runs jobs until a signal arrives.
pub async fn run(options: WorkerOptions) -> Exit {
    let (worker, mut signals) = match start(&options).await {
        Ok(started) => started,
        Err(error) => {
            eprintln!("raceway: {error}");
            return Exit::Failure;
        }
    };
    signals.next().await;
    tracing::info!("stopping; running jobs go back into the queue");
    // A second signal stops at once.
    tokio::select! {
        stopped = worker.stop() => match stopped {
            Ok(()) => {
                tracing::info!("stopped");
                Exit::Success
            }
            Err(error) => {
                tracing::error!(%error, "the queue did not stop cleanly; other workers run its jobs after a while");
                Exit::Failure
            }
        },
        () = signals.next() => Exit::Failure,
    }
}

async fn start(options: &WorkerOptions) -> Result<(Worker, Signals), Box<dyn std::error::Error>> {
    log_to_stderr(tracing::Level::INFO)?;
    let signals = Signals::listen()?;
    let settings = options.job_settings()?;
    let (place, database, workers) = (settings.database.to_string(), settings.database.kind(), settings.workers);
    let probes_at = match options.probes {
        Some(listen) => Some((listen, access(listen, &settings.database, options.insecure_no_auth).await?)),
        None => None,
    };
    let worker = Worker::start(settings, simulator(), probes_at).await?;
    let probes = worker.url();
    tracing::info!(version = env!("CARGO_PKG_VERSION"), database, workers, probes, "working");
    // The lines that scripts wait for. A closed stdout is no reason to stop.
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "working for {place}").and_then(|()| stdout.flush());
    if let Some(url) = probes {
        let _ = writeln!(stdout, "probes at {url}").and_then(|()| stdout.flush());
    }
    Ok((worker, signals))
}
