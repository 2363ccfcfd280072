//! `raceway worker`.

use std::io::Write;

use super::Ended;
use super::serve::{Signals, access, log_to_stderr, simulator};
use crate::api::service::Worker;
use crate::config::WorkerOptions;

/// Runs jobs until a signal comes.
pub async fn run(options: WorkerOptions) -> Ended {
    let (worker, mut signals) = match start(&options).await {
        Ok(started) => started,
        Err(error) => {
            eprintln!("raceway: {error}");
            return Ended::Badly;
        }
    };
    signals.next().await;
    tracing::info!("stopping; running jobs go back into the queue");
    // Whoever asks twice does not want to wait.
    tokio::select! {
        stopped = worker.stop() => match stopped {
            Ok(()) => {
                tracing::info!("stopped");
                Ended::Well
            }
            Err(error) => {
                tracing::error!(%error, "the queue did not stop as it should; its jobs are run elsewhere after a while");
                Ended::Badly
            }
        },
        () = signals.next() => Ended::Badly,
    }
}

async fn start(options: &WorkerOptions) -> Result<(Worker, Signals), Box<dyn std::error::Error>> {
    log_to_stderr(tracing::Level::INFO)?;
    let signals = Signals::listen()?;
    let settings = options.job_settings()?;
    let (place, database, workers) = (settings.database.to_string(), settings.database.kind(), settings.workers);
    let probed = match options.probes {
        Some(listen) => Some((listen, access(listen, &settings.database, options.insecure_no_auth).await?)),
        None => None,
    };
    let worker = Worker::start(settings, simulator(), probed).await?;
    let probes = worker.url();
    tracing::info!(version = env!("CARGO_PKG_VERSION"), database, workers, probes, "working");
    // The lines that programs wait for. Nobody may be reading, which is no reason to end.
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "working for {place}").and_then(|()| stdout.flush());
    if let Some(url) = probes {
        let _ = writeln!(stdout, "probes at {url}").and_then(|()| stdout.flush());
    }
    Ok((worker, signals))
}
