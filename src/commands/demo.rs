//! `raceway demo`: the article's case, submitted to a service over HTTP.

use std::fs;
use std::io::{IsTerminal, Write};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

use serde_json::{Value, json};

use super::client::{Client, ClientError};
use super::exit::Exit;
use super::logging::log_to_stderr;
use super::output_directory::OutputDirectory;
use super::signals::Signals;
use super::startup::{announce, simulator};
use super::text_tables;
use crate::api::Access;
use crate::api::service::Service;
use crate::config::DemoOptions;
use crate::jobs::Settings;

/// Starts the service, runs both cases, and continues to serve unless `once` is set.
pub async fn run(options: DemoOptions) -> Exit {
    let directory = TemporaryDirectory::new();
    let (service, mut signals) = match start(&directory).await {
        Ok(started) => started,
        Err(error) => {
            eprintln!("raceway: {error}");
            return Exit::Failure;
        }
    };
    let url = service.url();
    announce(&url);
    let exit = tokio::select! {
        shown = show(&url, &options) => shown,
        () = signals.next() => Exit::Failure,
    };
    if exit == Exit::Success && !options.once {
        println!("\nThe service continues to run; its documentation is at {url}/docs/. Stop it with Ctrl-C.");
        signals.next().await;
    }
    service.stop().await;
    exit
}

async fn start(directory: &TemporaryDirectory) -> Result<(Service, Signals), Box<dyn std::error::Error>> {
    // The output of the command already reports the jobs.
    log_to_stderr(tracing::Level::WARN)?;
    let signals = Signals::listen()?;
    let settings = Settings::new(directory.0.join("raceway.db"));
    let listen = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let access = Access { is_local: true, ..Access::default() };
    Ok((Service::start(listen, settings, access, simulator()).await?, signals))
}

/// The article's integrated bearing, on a balanced and on an unbalanced spindle.
fn cases() -> [(&'static str, Value); 2] {
    let operation = json!({ "speed_rpm": 50000, "radial_load_y_n": 200 });
    let scene = |spindle: Value| json!({ "bearing": "article-integrated", "operation": operation, "spindle": spindle });
    let balanced = json!({ "bearing": "article-integrated", "operation": operation });
    [
        ("balanced", json!({ "kind": "simulation", "scene": balanced })),
        ("balance grade G 6.3", json!({ "kind": "simulation", "scene": scene(json!({ "balance_grade": 6.3 })) })),
    ]
}

async fn show(url: &str, options: &DemoOptions) -> Exit {
    match try_show(url, options).await {
        Ok(exit) => exit,
        Err(error) => {
            eprintln!("raceway: {error}");
            Exit::Failure
        }
    }
}

async fn try_show(url: &str, options: &DemoOptions) -> Result<Exit, Box<dyn std::error::Error>> {
    let output = OutputDirectory::open(&options.output)?;
    let client = Client::new(url.to_owned());
    let mut submitted = Vec::new();
    for (name, job) in cases() {
        let answer = client.post_json("/v1/jobs", &job).await?;
        let path = answer["links"]["self"].as_str().unwrap_or_default().to_owned();
        println!("submitted {path}: article-integrated, 50 000 r/min, 200 N radial, {name}");
        submitted.push((name, path));
    }
    let mut finished = Vec::new();
    for (name, path) in submitted {
        let job = finished_job(&client, name, &path).await?;
        if job["status"] != "succeeded" {
            eprintln!("raceway: {path} has {}: {}", job["status"], job["error"]);
            return Ok(Exit::Failure);
        }
        finished.push((name, job));
    }
    let path = finished[0].1["links"]["spectrum_svg"].as_str().unwrap_or_default().to_owned();
    output.write("spectrum.svg", &client.get_text(&path).await?)?;
    println!("\n{}", text_tables::metrics(&finished));
    finished.iter().for_each(|(name, job)| println!("{}", text_tables::lines(name, job)));
    println!("Spectrum of the first case: {}", options.output.join("spectrum.svg").display());
    Ok(Exit::Success)
}

/// The finished job with its metrics.
async fn finished_job(client: &Client, name: &str, path: &str) -> Result<Value, ClientError> {
    let terminal = std::io::stderr().is_terminal();
    loop {
        let job = client.get_json(&format!("{path}?include=metrics")).await?;
        let is_unfinished = matches!(job["status"].as_str(), Some("queued" | "running"));
        if terminal {
            let percent = 100.0 * job["progress"].as_f64().unwrap_or(0.0);
            eprint!("\r{name}: {percent:3.0} % {}", if is_unfinished { "" } else { "\n" });
            let _ = std::io::stderr().flush();
        }
        if !is_unfinished {
            return Ok(job);
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

/// A directory for the database; dropping it removes it.
struct TemporaryDirectory(PathBuf);

impl TemporaryDirectory {
    fn new() -> Self {
        let place = std::env::temp_dir().join(format!("raceway-demo-{}", uuid::Uuid::now_v7()));
        if let Err(error) = fs::create_dir_all(&place) {
            tracing::warn!(%error, place = %place.display(), "no place for the database");
        }
        Self(place)
    }
}

impl Drop for TemporaryDirectory {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
