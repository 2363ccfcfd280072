//! What the program does when it is called, one command a file. Above all other rooms.

pub mod accuracy;
pub mod article;
/// Asks a service over HTTP.
mod client;
pub mod demo;
pub mod health;
/// A job in this process.
mod local;
/// What the process keeps of memory that is given back.
pub mod memory;
pub mod optimum;
/// Many runs, some at a time.
mod parallel;
/// What stderr tells of a run.
mod progress;
pub mod serve;
pub mod simulate;
pub mod study;
/// Results as text for people.
pub mod table;
pub mod token;
pub mod worker;

use std::io::Write as _;
use std::process::ExitCode;
use std::time::Duration;

use tokio::runtime::{Builder, Runtime};

use crate::config::{Cli, Command};

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    Well,
    /// It did not work out: exit status 1.
    Badly,
    /// It was not understood or not allowed: exit status 2.
    Refused,
}

impl From<Ended> for ExitCode {
    fn from(ended: Ended) -> Self {
        match ended {
            Ended::Well => Self::SUCCESS,
            Ended::Badly => Self::from(1),
            Ended::Refused => Self::from(2),
        }
    }
}

/// Does what the command line says.
pub fn run(cli: Cli) -> Ended {
    memory::keep_for_the_next_run();
    match cli.command {
        Command::Demo(options) => on_runtime(demo::run(options)),
        Command::Serve(options) => on_runtime(serve::run(options)),
        Command::Simulate(options) => simulate::run(&options),
        Command::Accuracy(options) => accuracy::run(&options),
        Command::Optimum(options) => optimum::run(&options),
        Command::Study(options) => study::run(&options),
        Command::Article(options) => article::run(&options),
        Command::Openapi => {
            // Who reads may have read enough.
            let _ = std::io::stdout().write_all(crate::api::document_text().as_bytes());
            Ended::Well
        }
        Command::Token(command) => on_runtime(token::run(command)),
        Command::Migrate(options) => on_runtime(token::migrate(options)),
        Command::Worker(options) => on_runtime(worker::run(options)),
        Command::Health(options) => on_runtime(health::run(options)),
    }
}

/// Two threads answer all requests; solvers have threads of their own.
/// Time that work on threads aside has after a command has ended.
const LAST_WORK: Duration = Duration::from_secs(1);

fn on_runtime(command: impl Future<Output = Ended>) -> Ended {
    match runtime() {
        Ok(runtime) => {
            let ended = runtime.block_on(command);
            // What is still being checked for clients that are gone is not waited for.
            runtime.shutdown_timeout(LAST_WORK);
            ended
        }
        Err(error) => {
            eprintln!("raceway: no threads to work with: {error}");
            Ended::Badly
        }
    }
}

fn runtime() -> std::io::Result<Runtime> {
    Builder::new_multi_thread().worker_threads(2).max_blocking_threads(16).enable_all().build()
}
