//! Exit status of a command.

use std::process::ExitCode;

/// Exit status of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    Success,
    /// The command failed: exit status 1.
    Failure,
    /// The input is invalid or not allowed: exit status 2.
    Refused,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        match exit {
            Exit::Success => Self::SUCCESS,
            Exit::Failure => Self::from(1),
            Exit::Refused => Self::from(2),
        }
    }
}

/// Prints the reason of a refusal to stderr.
pub fn refused(reason: &str) -> Exit {
    eprintln!("{reason}");
    Exit::Refused
}

/// Prints the reason of a failure to stderr.
pub fn failed(reason: &str) -> Exit {
    eprintln!("{reason}");
    Exit::Failure
}
