//! `raceway health`: readiness probe for containers without an HTTP client.

use std::time::Duration;

use super::client::Client;
use super::exit::{Exit, failed};
use crate::api::service::url;
use crate::config::HealthOptions;

/// Asks the service whether it accepts jobs.
pub async fn run(options: HealthOptions) -> Exit {
    let client = Client::new(url(options.listen));
    let answer = tokio::time::timeout(Duration::from_secs(5), client.get_json("/health/ready")).await;
    match answer {
        Ok(Ok(health)) => {
            println!("{health}");
            Exit::Success
        }
        Ok(Err(error)) => failed(&format!("raceway: {error}")),
        Err(_) => failed("raceway: no answer within 5 s"),
    }
}
