//! The program. `config` parses the command line, `commands` runs it.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    raceway::commands::run(raceway::config::Cli::parse()).into()
}
