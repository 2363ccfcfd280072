//! `raceway demo`: the service shown from outside, over HTTP, on the article's case.

use std::fs;
use std::io::{IsTerminal, Write};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

use serde_json::{Value, json};

use super::client::{Client, ClientError};
use super::local::Directory;
use super::serve::{Signals, announce, log_to_stderr, simulator};
use super::{Ended, table};
use crate::api::Access;
use crate::api::service::Service;
use crate::config::DemoOptions;
use crate::jobs::Settings;

/// Starts the service, shows both cases, and serves on unless told to stop.
pub async fn run(options: DemoOptions) -> Ended {
    let place = Place::new();
    let (service, mut signals) = match start(&place).await {
        Ok(started) => started,
        Err(error) => {
            eprintln!("raceway: {error}");
            return Ended::Badly;
        }
    };
    let url = service.url();
    announce(&url);
    let ended = tokio::select! {
        shown = show(&url, &options) => shown,
        () = signals.next() => Ended::Badly,
    };
    if ended == Ended::Well && !options.once {
        println!("\nThe service runs on; its documentation is at {url}/docs/. Stop it with Ctrl-C.");
        signals.next().await;
    }
    service.stop().await;
    ended
}

async fn start(place: &Place) -> Result<(Service, Signals), Box<dyn std::error::Error>> {
    // What it prints tells how its jobs go.
    log_to_stderr(tracing::Level::WARN)?;
    let signals = Signals::listen()?;
    let settings = Settings::new(place.0.join("raceway.db"));
    let listen = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let access = Access { is_local: true, ..Access::default() };
    Ok((Service::start(listen, settings, access, simulator()).await?, signals))
}

/// The article's integrated bearing, on a perfect spindle and on an unbalanced one.
fn cases() -> [(&'static str, Value); 2] {
    let operation = json!({ "speed_rpm": 50000, "radial_load_y_n": 200 });
    let scene = |spindle: Value| json!({ "bearing": "article-integrated", "operation": operation, "spindle": spindle });
    let balanced = json!({ "bearing": "article-integrated", "operation": operation });
    [
        ("balanced", json!({ "kind": "simulation", "scene": balanced })),
        ("balance grade G 6.3", json!({ "kind": "simulation", "scene": scene(json!({ "balance_grade": 6.3 })) })),
    ]
}

async fn show(url: &str, options: &DemoOptions) -> Ended {
    match try_show(url, options).await {
        Ok(ended) => ended,
        Err(error) => {
            eprintln!("raceway: {error}");
            Ended::Badly
        }
    }
}

async fn try_show(url: &str, options: &DemoOptions) -> Result<Ended, Box<dyn std::error::Error>> {
    let output = Directory::at(&options.output)?;
    let client = Client::new(url.to_owned());
    let mut submitted = Vec::new();
    for (name, job) in cases() {
        let answer = client.post_json("/v1/jobs", &job).await?;
        let path = answer["links"]["self"].as_str().unwrap_or_default().to_owned();
        println!("submitted {path}: article-integrated, 50 000 r/min, 200 N radial, {name}");
        submitted.push((name, path));
    }
    let mut ended = Vec::new();
    for (name, path) in submitted {
        let job = followed(&client, name, &path).await?;
        if job["status"] != "succeeded" {
            eprintln!("raceway: {path} has {}: {}", job["status"], job["error"]);
            return Ok(Ended::Badly);
        }
        ended.push((name, job));
    }
    let path = ended[0].1["links"]["spectrum_svg"].as_str().unwrap_or_default().to_owned();
    output.write("spectrum.svg", &client.get_text(&path).await?)?;
    println!("\n{}", table::metrics(&ended));
    ended.iter().for_each(|(name, job)| println!("{}", table::lines(name, job)));
    println!("The spectrum of the first is drawn in {}.", options.output.join("spectrum.svg").display());
    Ok(Ended::Well)
}

/// The job once it has ended, with its metrics.
async fn followed(client: &Client, name: &str, path: &str) -> Result<Value, ClientError> {
    let terminal = std::io::stderr().is_terminal();
    loop {
        let job = client.get_json(&format!("{path}?include=metrics")).await?;
        let waits = matches!(job["status"].as_str(), Some("queued" | "running"));
        if terminal {
            let percent = 100.0 * job["progress"].as_f64().unwrap_or(0.0);
            eprint!("\r{name}: {percent:3.0} % {}", if waits { "" } else { "\n" });
            let _ = std::io::stderr().flush();
        }
        if !waits {
            return Ok(job);
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

/// A directory for the database that goes with the demonstration.
struct Place(PathBuf);

impl Place {
    fn new() -> Self {
        let place = std::env::temp_dir().join(format!("raceway-demo-{}", uuid::Uuid::now_v7()));
        if let Err(error) = fs::create_dir_all(&place) {
            tracing::warn!(%error, place = %place.display(), "no place for the database");
        }
        Self(place)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
