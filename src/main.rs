//! The commands are in `config`, what they do in `commands`.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    raceway::commands::run(raceway::config::Cli::parse()).into()
}
