//! `raceway worker`.

use std::io::Write;

use super::Ended;
use super::serve::{Signals, log_to_stderr, simulator};
use crate::config::WorkerOptions;
use crate::jobs::Jobs;

/// Runs jobs until a signal comes.
pub async fn run(options: WorkerOptions) -> Ended {
    let (jobs, mut signals) = match start(&options).await {
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
        stopped = jobs.stop() => match stopped {
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

async fn start(options: &WorkerOptions) -> Result<(Jobs, Signals), Box<dyn std::error::Error>> {
    log_to_stderr(tracing::Level::INFO)?;
    let signals = Signals::listen()?;
    let settings = options.job_settings()?;
    let (place, database, workers) = (settings.database.to_string(), settings.database.kind(), settings.workers);
    let jobs = Jobs::start(settings, simulator()).await?;
    tracing::info!(version = env!("CARGO_PKG_VERSION"), database, workers, "working");
    // The one line that programs wait for. Nobody may be reading, which is no reason to end.
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "working for {place}").and_then(|()| stdout.flush());
    Ok((jobs, signals))
}
