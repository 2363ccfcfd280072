//! The commands of the program, one file each. Above all other folders.

/// Memory that consecutive runs reuse.
pub mod allocator;
/// A client of the HTTP API.
mod client;
/// Exit status of a command.
mod exit;
/// A job in this process.
mod local;
/// Logs on stderr.
mod logging;
/// The directory for results.
mod output_directory;
/// Many runs on several threads.
mod parallel_map;
/// Progress of a run on stderr.
mod progress;
/// Signals of the operating system.
mod signals;
/// Access, simulator and announcement of a service.
mod startup;
/// Results as text tables.
pub mod text_tables;

mod accuracy;
mod article;
mod check;
mod demo;
mod health;
mod optimum;
mod serve;
mod simulate;
mod study;
mod token;
mod uncertainty;
mod worker;

use std::io::Write as _;
use std::time::Duration;

use tokio::runtime::{Builder, Runtime};

use crate::config::{Cli, Command};

pub use exit::Exit;

/// Runs the command of the command line.
pub fn run(cli: Cli) -> Exit {
    allocator::keep_memory_for_next_run();
    match cli.command {
        Command::Demo(options) => on_runtime(demo::run(options)),
        Command::Serve(options) => on_runtime(serve::run(options)),
        Command::Simulate(options) => simulate::run(&options),
        Command::Accuracy(options) => accuracy::run(&options),
        Command::Optimum(options) => optimum::run(&options),
        Command::Study(options) => study::run(&options),
        Command::Article(options) => article::run(&options),
        Command::Openapi => {
            // A reader may close the pipe early.
            let _ = std::io::stdout().write_all(crate::api::document_text().as_bytes());
            Exit::Success
        }
        Command::Token(command) => on_runtime(token::run(command)),
        Command::Migrate(options) => on_runtime(token::migrate(options)),
        Command::Check(options) => on_runtime(check::run(options)),
        Command::Worker(options) => on_runtime(worker::run(options)),
        Command::Health(options) => on_runtime(health::run(options)),
    }
}

/// Longest time for blocking work to end after a command has ended.
const BLOCKING_WORK_TIMEOUT: Duration = Duration::from_secs(1);

fn on_runtime(command: impl Future<Output = Exit>) -> Exit {
    match runtime() {
        Ok(runtime) => {
            let exit = runtime.block_on(command);
            // Requests of clients that have gone may still be parsed; they are not waited for.
            runtime.shutdown_timeout(BLOCKING_WORK_TIMEOUT);
            exit
        }
        Err(error) => {
            eprintln!("raceway: the threads could not be created: {error}");
            Exit::Failure
        }
    }
}

/// A runtime whose two threads answer all requests; solvers have their own threads.
fn runtime() -> std::io::Result<Runtime> {
    Builder::new_multi_thread().worker_threads(2).max_blocking_threads(16).enable_all().build()
}
