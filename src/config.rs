//! Settings from command line and environment. Only this file reads them.

use std::ffi::OsStr;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

use axum::http::HeaderValue;
use clap::builder::BoolishValueParser;
use clap::{Args, Parser, Subcommand};

use crate::api::cors::origin;
use crate::api::credentials::{MIN_TOKEN_LENGTH, Tokens};
use crate::jobs::{Location, Settings, WorkLimits};

/// Predicts the vibration of rolling bearings.
#[derive(Debug, Parser)]
#[command(name = "raceway", version, about, arg_required_else_help = true)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Start the service on loopback, run the article's case over HTTP, and print and plot the results
    Demo(DemoOptions),
    /// Serve the HTTP API and run jobs
    Serve(ServeOptions),
    /// Run jobs of a service on the same PostgreSQL database, without HTTP
    Worker(WorkerOptions),
    /// Create, list and revoke bearer tokens, also while the service runs
    #[command(subcommand)]
    Token(TokenCommand),
    /// Create or update the tables of a database, as every start does if its database user may
    Migrate(DatabaseOptions),
    /// Compare every stored result with its digest, and check the structure of a database file; exit status 1 with a list of jobs if
    /// something is corrupt
    Check(DatabaseOptions),
    /// Run one job without a server, and print its metrics as JSON
    Simulate(SimulateOptions),
    /// Run a scene with several methods and tolerances: error against run time as table, JSON and SVG
    Accuracy(AccuracyOptions),
    /// Find the minimum or maximum of a metric over one or two ranges
    Optimum(OptimumOptions),
    /// Run a study, a scene over a grid of values: table, CSV and plots
    Study(StudyOptions),
    /// Reproduce the article's figures and compare them with the article
    Article(ArticleOptions),
    /// Print the OpenAPI document
    Openapi,
    /// Ask a running service whether it accepts jobs; exit status 0 if it does
    Health(HealthOptions),
}

#[derive(Debug, Args)]
pub struct DemoOptions {
    /// Stop after the demonstration instead of continuing to serve
    #[arg(long, env = "RACEWAY_ONCE", value_parser = BoolishValueParser::new())]
    pub once: bool,
    /// Directory for spectrum.svg
    #[arg(long, env = "RACEWAY_OUTPUT", default_value = ".", value_name = "DIR")]
    pub output: PathBuf,
}

#[derive(Debug, Args)]
pub struct SimulateOptions {
    /// JSON with a job or only a scene; - reads stdin
    #[arg(value_name = "JOB.json|-")]
    pub job: PathBuf,
    /// Directory for metrics, spectra, series and plots
    #[arg(long, env = "RACEWAY_OUTPUT", value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// No estimate and no progress on stderr
    #[arg(long, env = "RACEWAY_QUIET", value_parser = BoolishValueParser::new())]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub struct AccuracyOptions {
    /// JSON with only a scene, or with a job of kind accuracy; - reads stdin
    #[arg(value_name = "SCENE.json|-")]
    pub scene: PathBuf,
    /// Directory for accuracy.json and work-precision.svg
    #[arg(long, env = "RACEWAY_OUTPUT", default_value = ".", value_name = "DIR")]
    pub output: PathBuf,
    /// Timed runs of each method at each tolerance, unless the job states them [default: 1]
    #[arg(long, env = "RACEWAY_REPETITIONS", value_parser = clap::value_parser!(u32).range(1..=9))]
    pub repetitions: Option<u32>,
    /// No estimate and no progress on stderr
    #[arg(long, env = "RACEWAY_QUIET", value_parser = BoolishValueParser::new())]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub struct StudyOptions {
    /// JSON with a job of kind study; - reads stdin
    #[arg(value_name = "FILE.json|-")]
    pub study: PathBuf,
    /// Directory for table.json, table.csv, trend.svg (one axis) or map.svg (two)
    #[arg(long, env = "RACEWAY_OUTPUT", default_value = ".", value_name = "DIR")]
    pub output: PathBuf,
    /// Number of simultaneous points [default: number of cores]
    #[arg(long, env = "RACEWAY_WORKERS", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub workers: Option<u16>,
    /// No estimate and no progress on stderr
    #[arg(long, env = "RACEWAY_QUIET", value_parser = BoolishValueParser::new())]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub struct OptimumOptions {
    /// JSON with a job of kind optimum; - reads stdin
    #[arg(value_name = "FILE.json|-")]
    pub job: PathBuf,
    /// Directory for optimum.json and optimum.svg
    #[arg(long, env = "RACEWAY_OUTPUT", default_value = ".", value_name = "DIR")]
    pub output: PathBuf,
    /// No estimate and no progress on stderr
    #[arg(long, env = "RACEWAY_QUIET", value_parser = BoolishValueParser::new())]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub struct ArticleOptions {
    /// Only this figure, 5 to 18
    #[arg(long, value_name = "N")]
    pub figure: Option<u32>,
    /// Test the article's statements over sampled sets of the values that the article does not give; writes ROBUSTNESS.md and
    /// robustness.csv
    #[arg(long, conflicts_with = "figure")]
    pub robustness: bool,
    /// With --robustness: number of sampled sets [default: 200]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=10_000))]
    pub sets: Option<u32>,
    /// With --robustness: seed of the samples [default: 2025]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Directory for ARTICLE.md (or FIGURE-N.md of one figure) and plots/article
    #[arg(long, env = "RACEWAY_OUTPUT", default_value = ".", value_name = "DIR")]
    pub output: PathBuf,
    /// No progress on stderr
    #[arg(long, env = "RACEWAY_QUIET", value_parser = BoolishValueParser::new())]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub struct HealthOptions {
    /// Address of the service
    #[arg(long, env = "RACEWAY_LISTEN", default_value = "127.0.0.1:8080", value_name = "ADDRESS:PORT")]
    pub listen: SocketAddr,
}

#[derive(Debug, Args)]
pub struct ServeOptions {
    /// Address to listen on; port 0 picks a free one
    #[arg(long, env = "RACEWAY_LISTEN", default_value = "127.0.0.1:8080", value_name = "ADDRESS:PORT")]
    pub listen: SocketAddr,
    #[command(flatten)]
    pub database: DatabaseOptions,
    /// Number of simultaneous simulations [default: number of cores]; on PostgreSQL 0 leaves them to workers
    #[arg(long, env = "RACEWAY_WORKERS", value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub workers: Option<u16>,
    /// Largest number of queued and running single jobs; further ones are answered with 429
    #[arg(long, env = "RACEWAY_QUEUE_LIMIT", default_value_t = 10_000)]
    pub queue_limit: u32,
    /// Of these, jobs of one owner [default: half of them where there are tokens]
    #[arg(long, env = "RACEWAY_QUEUE_LIMIT_PER_OWNER", value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub queue_limit_per_owner: Option<u32>,
    /// Largest number of unfinished points of studies; further studies are answered with 429
    #[arg(long, env = "RACEWAY_POINT_LIMIT", default_value_t = 100_000)]
    pub point_limit: u32,
    /// Of these, points of one owner [default: half of them where there are tokens]
    #[arg(long, env = "RACEWAY_POINT_LIMIT_PER_OWNER", value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub point_limit_per_owner: Option<u32>,
    /// Largest number of event streams and waiting requests of one owner of tokens, of 256
    #[arg(long, env = "RACEWAY_FOLLOWERS_PER_OWNER", default_value_t = 128, value_name = "N")]
    pub followers_per_owner: u32,
    /// Largest number of requests per second of one owner, of submitted jobs and points per second, and of either at once after a
    /// pause; 0: no limit
    #[arg(long, env = "RACEWAY_RATE_LIMIT", default_value_t = 1000, value_name = "N")]
    pub rate_limit: u32,
    #[command(flatten)]
    pub runs: RunOptions,
    /// Origins of other web pages that may use the API, such as `https://portal.example`, separated by commas
    #[arg(long, env = "RACEWAY_ALLOWED_ORIGINS", value_name = "ORIGIN,…", value_delimiter = ',', value_parser = origin)]
    pub allowed_origins: Vec<HeaderValue>,
    /// Serve other machines without tokens: whoever reaches the port may do everything
    #[arg(long, env = "RACEWAY_INSECURE_NO_AUTH", value_parser = BoolishValueParser::new())]
    pub insecure_no_auth: bool,
}

/// Commands on tokens.
#[derive(Debug, Subcommand)]
pub enum TokenCommand {
    /// Create a token and print it once: only its digest is stored
    Create(NewTokenOptions),
    /// List all tokens, revoked and expired ones included, without their secrets
    List(DatabaseOptions),
    /// Revoke a token; a running service refuses it within a second
    Revoke(RevokeOptions),
}

#[derive(Debug, Args)]
pub struct DatabaseOptions {
    /// Database: sqlite://FILE, created if it is missing, or postgres://USER@HOST/NAME
    #[arg(
        long,
        env = "RACEWAY_DATABASE",
        default_value = "sqlite://raceway.db",
        value_name = "URL",
        hide_env_values = true
    )]
    pub database: String,
}

impl DatabaseOptions {
    /// The database.
    pub fn location(&self) -> Result<Location, ConfigError> {
        location(&self.database)
    }
}

#[derive(Debug, Args)]
pub struct NewTokenOptions {
    /// Name of the token, by which it is listed and revoked [default: generated]
    #[arg(value_parser = token_name)]
    pub name: Option<String>,
    /// Owner of the jobs that it gives access to; several tokens can have one owner [default: an owner of its own]
    #[arg(long, value_name = "OWNER", value_parser = token_name)]
    pub owner: Option<String>,
    /// Gives access to the jobs that were created while no token was needed, instead of those of an owner
    #[arg(long, conflicts_with = "owner")]
    pub open_jobs: bool,
    /// Days until it expires [default: never]
    #[arg(long, value_name = "DAYS", value_parser = clap::value_parser!(u32).range(1..=36_500))]
    pub expires_in_days: Option<u32>,
    #[command(flatten)]
    pub database: DatabaseOptions,
}

#[derive(Debug, Args)]
pub struct RevokeOptions {
    /// Name or id of the token
    #[arg(value_name = "NAME|ID")]
    pub token: String,
    #[command(flatten)]
    pub database: DatabaseOptions,
}

/// A name of a token or an owner: one word, so that lists can be split into columns.
fn token_name(name: &str) -> Result<String, String> {
    let is_word = name.chars().all(|letter| letter.is_ascii_graphic());
    if is_word && (1..=100).contains(&name.len()) {
        Ok(name.to_owned())
    } else {
        Err("must be 1 to 100 visible ASCII characters without spaces".to_owned())
    }
}

#[derive(Debug, Args)]
pub struct WorkerOptions {
    /// Database of the service: postgres://USER@HOST/NAME
    #[arg(long, env = "RACEWAY_DATABASE", value_name = "URL", hide_env_values = true)]
    pub database: String,
    /// Number of simultaneous simulations [default: number of cores]
    #[arg(long, env = "RACEWAY_WORKERS", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub workers: Option<u16>,
    #[command(flatten)]
    pub runs: RunOptions,
    /// Address for /health/live, /health/ready and /metrics of this worker; port 0 picks a free one [default: none]
    #[arg(long, env = "RACEWAY_PROBES", value_name = "ADDRESS:PORT")]
    pub probes: Option<SocketAddr>,
    /// Answer probes of other machines without tokens: whoever reaches the port can read the metrics
    #[arg(long, env = "RACEWAY_INSECURE_NO_AUTH", value_parser = BoolishValueParser::new())]
    pub insecure_no_auth: bool,
}

/// Options of runs.
#[derive(Debug, Args)]
pub struct RunOptions {
    /// Number of runs lost with their process after which a job fails
    #[arg(long, env = "RACEWAY_MAX_LOST_RUNS", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub max_lost_runs: u32,
    /// Longest wall time of a run, in seconds
    #[arg(long, env = "RACEWAY_TIME_LIMIT_S", default_value_t = 3600, value_parser = clap::value_parser!(u32).range(1..))]
    pub time_limit_s: u32,
    /// Retention of ended jobs that do not state their own, in seconds
    #[arg(long, env = "RACEWAY_KEEP_FOR_S", default_value_t = 30 * 86_400, value_parser = clap::value_parser!(u32).range(1..))]
    pub keep_for_s: u32,
    /// Time for which the address and the idempotency key of an expired job are answered with its last state (410), in seconds; for a
    /// key a day at least
    #[arg(long, env = "RACEWAY_REMEMBER_EXPIRED_FOR_S", default_value_t = 7 * 86_400)]
    pub remember_expired_for_s: u32,
    /// Time without a heartbeat after which a run counts as lost, in seconds; the same for all processes on a database
    #[arg(long, env = "RACEWAY_LOST_AFTER_S", default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..=3600))]
    pub lost_after_s: u32,
}

impl RunOptions {
    fn settings(&self, database: Location, workers: Option<u16>) -> Settings {
        let settings = Settings::on(database);
        let lost_after = Duration::from_secs(u64::from(self.lost_after_s));
        Settings {
            workers: workers.map_or(settings.workers, usize::from),
            max_lost_runs: self.max_lost_runs,
            time_limit: Duration::from_secs(u64::from(self.time_limit_s)),
            keep_s: f64::from(self.keep_for_s),
            remember_expired: Duration::from_secs(u64::from(self.remember_expired_for_s)),
            lost_after,
            sweep_every: settings.sweep_every.min(lost_after),
            ..settings
        }
    }
}

/// An invalid setting.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    #[error("the database {0} is not valid; use sqlite://FILE or postgres://USER@HOST/NAME")]
    UnknownDatabase(String),
    #[error("the database sqlite://:memory: and its jobs would be lost with the process: use sqlite://FILE")]
    NotKept,
    #[error("the database {0}: only one process can use a file; a separate worker needs postgres://USER@HOST/NAME")]
    NotShared(Location),
    #[error(
        "--workers 0 leaves the jobs to other processes, and only one process can use a file: use postgres://USER@HOST/NAME"
    )]
    NoWorkers,
    #[error(
        "{0} can be reached from other machines, and there are no tokens: create one with `raceway token create`, set \
         RACEWAY_API_TOKENS, listen on 127.0.0.1, or accept the risk with --insecure-no-auth"
    )]
    OpenToEveryone(SocketAddr),
    #[error("RACEWAY_API_TOKENS is not UTF-8")]
    UnreadableTokens,
    #[error(
        "RACEWAY_API_TOKENS contains characters that a header cannot carry: tokens are visible ASCII, separated by commas"
    )]
    UnsendableTokens,
    #[error(
        "{0} can be reached from other machines, and a token of RACEWAY_API_TOKENS has fewer than {MIN_TOKEN_LENGTH} characters: use a longer \
         one, or create one with `raceway token create`, or accept the risk with --insecure-no-auth"
    )]
    WeakToken(SocketAddr),
    #[error("RACEWAY_API_TOKENS is set but holds no token: set tokens, separated by commas, or unset it")]
    NoTokens,
    #[error("RACEWAY_LOG is {0:?}: must be error, warn, info, debug or trace")]
    UnknownLogLevel(String),
    #[error("RACEWAY_LOG_FORMAT is {0:?}: must be text or json")]
    UnknownLogFormat(String),
}

impl ServeOptions {
    /// Settings of queue and store.
    pub fn job_settings(&self) -> Result<Settings, ConfigError> {
        let database = self.database.location()?;
        if self.workers == Some(0) && matches!(database, Location::File(_)) {
            return Err(ConfigError::NoWorkers);
        }
        let settings = self.runs.settings(database, self.workers);
        let work_limits = WorkLimits {
            jobs: u64::from(self.queue_limit),
            jobs_of_owner: self.queue_limit_per_owner.map(u64::from),
            points: u64::from(self.point_limit),
            points_of_owner: self.point_limit_per_owner.map(u64::from),
        };
        Ok(Settings { work_limits, ..settings })
    }
}

impl WorkerOptions {
    /// Settings of queue and store.
    pub fn job_settings(&self) -> Result<Settings, ConfigError> {
        match location(&self.database)? {
            file @ Location::File(_) => Err(ConfigError::NotShared(file)),
            server @ Location::Server(_) => Ok(self.runs.settings(server, self.workers)),
        }
    }
}

/// Returns whether only this machine can reach the address.
pub fn is_loopback(address: IpAddr) -> bool {
    address.to_canonical().is_loopback()
}

/// The location of a database URL. An error shows only the scheme of a server's URL, which may contain a password.
fn location(url: &str) -> Result<Location, ConfigError> {
    let scheme = url.split_once(':').map_or("", |parts| parts.0);
    match (scheme, url.strip_prefix("sqlite://")) {
        ("postgres" | "postgresql", _) => {
            Location::server(url).ok_or_else(|| ConfigError::UnknownDatabase(format!("{scheme}://…")))
        }
        (_, Some(":memory:")) => Err(ConfigError::NotKept),
        (_, Some(file)) if !file.is_empty() && !file.contains(['?', '#']) => Ok(Location::File(file.into())),
        ("sqlite", _) => Err(ConfigError::UnknownDatabase(url.to_owned())),
        // A path contains no password.
        ("", _) if !url.contains('@') => Err(ConfigError::UnknownDatabase(url.to_owned())),
        _ => Err(ConfigError::UnknownDatabase(format!("{scheme}:…"))),
    }
}

/// Tokens from `RACEWAY_API_TOKENS`, separated by commas.
///
/// They are not an option, because every user of a machine can read the command lines of its processes. A set variable without a
/// token is an error and does not open the service.
pub fn tokens() -> Result<Tokens, ConfigError> {
    std::env::var_os("RACEWAY_API_TOKENS").map_or_else(|| Ok(Tokens::default()), |list| tokens_of(&list))
}

fn tokens_of(list: &OsStr) -> Result<Tokens, ConfigError> {
    let list = list.to_str().ok_or(ConfigError::UnreadableTokens)?;
    if !list.split(',').all(|token| token.trim().bytes().all(|byte| byte.is_ascii_graphic())) {
        return Err(ConfigError::UnsendableTokens);
    }
    let tokens = Tokens::parse(list);
    if tokens.is_empty() { Err(ConfigError::NoTokens) } else { Ok(tokens) }
}

/// The log level: `RACEWAY_LOG` is one of error, warn, info, debug, trace; `default` if it is not set.
pub fn log_level(default: tracing::Level) -> Result<tracing::Level, ConfigError> {
    let Some(level) = std::env::var_os("RACEWAY_LOG") else { return Ok(default) };
    let level = level.to_string_lossy();
    level.parse().map_err(|_| ConfigError::UnknownLogLevel(level.into_owned()))
}

/// Returns whether logs are JSON: `RACEWAY_LOG_FORMAT` is `text`, or `json` with one object per line.
pub fn logs_json() -> Result<bool, ConfigError> {
    let Some(format) = std::env::var_os("RACEWAY_LOG_FORMAT") else { return Ok(false) };
    match format.to_string_lossy().as_ref() {
        "text" => Ok(false),
        "json" => Ok(true),
        other => Err(ConfigError::UnknownLogFormat(other.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_and_servers_are_databases() {
        let shown = |url: &str| location(url).map(|place| place.to_string()).ok();
        assert_eq!(shown("sqlite:///data/raceway.db").as_deref(), Some("/data/raceway.db"));
        assert_eq!(shown("sqlite://raceway.db").as_deref(), Some("raceway.db"));
        assert_eq!(shown("postgres://me:secret@host/db").as_deref(), Some("postgres://host:5432/db"));
        assert!(!format!("{:?}", location("postgres://me:secret@host/db")).contains("secret"));
        assert!(matches!(location("sqlite://:memory:"), Err(ConfigError::NotKept)));
        for url in ["", "raceway.db", "sqlite:raceway.db", "sqlite://", "mysql://x:secret@y/z"] {
            let refused = location(url).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(refused.contains("sqlite://FILE") && !refused.contains("secret"), "{url}: {refused}");
        }
    }

    #[test]
    fn set_tokens_are_parsed_or_refused() {
        use std::os::unix::ffi::OsStrExt;
        assert!(tokens_of(OsStr::new("one,")).is_ok_and(|tokens| !tokens.is_empty() && tokens.is_weak()));
        assert!(tokens_of(OsStr::new("sixteen-letters-")).is_ok_and(|tokens| !tokens.is_weak()));
        for unsendable in ["a\nb", "two words", "schlüssel"] {
            assert!(matches!(tokens_of(OsStr::new(unsendable)), Err(ConfigError::UnsendableTokens)), "{unsendable:?}");
        }
        for nothing in ["", " ", ",", " , ,"] {
            assert!(matches!(tokens_of(OsStr::new(nothing)), Err(ConfigError::NoTokens)), "{nothing:?}");
        }
        let refused = tokens_of(OsStr::from_bytes(b"secret,\xff")).err().map(|error| error.to_string());
        assert_eq!(refused.as_deref(), Some("RACEWAY_API_TOKENS is not UTF-8"));
    }

    #[test]
    fn every_loopback_address_counts() {
        for address in ["127.0.0.1", "127.1.2.3", "::1", "::ffff:127.0.0.1"] {
            assert!(address.parse().is_ok_and(is_loopback), "{address}");
        }
        for address in ["0.0.0.0", "::", "192.168.1.1"] {
            assert!(!address.parse().is_ok_and(is_loopback), "{address}");
        }
    }
}
