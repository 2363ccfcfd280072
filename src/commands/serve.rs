//! `raceway serve`: the HTTP service.

use super::exit::Exit;
use super::logging::log_to_stderr;
use super::signals::Signals;
use super::startup::{access, announce, simulator};
use crate::api::Access;
use crate::api::rate_limit::RateLimits;
use crate::api::service::Service;
use crate::config::ServeOptions;

/// Serves until a signal arrives.
pub async fn run(options: ServeOptions) -> Exit {
    let (service, mut signals) = match start(&options).await {
        Ok(started) => started,
        Err(error) => {
            eprintln!("raceway: {error}");
            return Exit::Failure;
        }
    };
    announce(&service.url());
    signals.next().await;
    tracing::info!("stopping; running jobs go back into the queue");
    // A second signal stops at once.
    tokio::select! {
        () = service.stop() => {
            tracing::info!("stopped");
            Exit::Success
        }
        () = signals.next() => Exit::Failure,
    }
}

/// Starts the service. Signals are handled before the address is printed, because a script may stop the service at once.
async fn start(options: &ServeOptions) -> Result<(Service, Signals), Box<dyn std::error::Error>> {
    log_to_stderr(tracing::Level::INFO)?;
    let signals = Signals::listen()?;
    let settings = options.job_settings()?;
    let access = access(options.listen, &settings.database, options.insecure_no_auth).await?;
    let rates = RateLimits::new(options.rate_limit);
    let followers_per_owner = usize::try_from(options.followers_per_owner).ok();
    let access = Access { rates, followers_per_owner, origins: options.allowed_origins.clone(), ..access };
    let (database, workers) = (settings.database.kind(), settings.workers);
    let service = Service::start(options.listen, settings, access, simulator()).await?;
    let (address, listen) = (service.url(), service.address());
    tracing::info!(version = env!("CARGO_PKG_VERSION"), address, %listen, database, workers, "serving");
    Ok((service, signals))
}
