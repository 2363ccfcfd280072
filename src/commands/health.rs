//! `raceway health`: for container probes, which have no other client at hand.

use std::time::Duration;

use super::Ended;
use super::client::Client;
use crate::api::service::url;
use crate::config::HealthOptions;

/// Asks whether the service takes jobs.
pub async fn run(options: HealthOptions) -> Ended {
    let client = Client::new(url(options.listen));
    let answer = tokio::time::timeout(Duration::from_secs(5), client.get_json("/health/ready")).await;
    match answer {
        Ok(Ok(health)) => {
            println!("{health}");
            Ended::Well
        }
        Ok(Err(error)) => badly(&error.to_string()),
        Err(_) => badly("no answer within 5 s"),
    }
}

fn badly(why: &str) -> Ended {
    eprintln!("raceway: {why}");
    Ended::Badly
}
