//! Logs on stderr.

use std::io::IsTerminal;

use crate::config::{self, ConfigError};

/// Writes logs to stderr, at the level of the environment or `default_level`. stdout carries only the output of a command.
pub fn log_to_stderr(default_level: tracing::Level) -> Result<(), ConfigError> {
    use tracing_subscriber::filter::Targets;
    use tracing_subscriber::prelude::*;
    let level = config::log_level(default_level)?;
    // Libraries log only warnings and errors.
    let targets = Targets::new().with_default(tracing::Level::WARN.min(level)).with_target("raceway", level);
    let layer = tracing_subscriber::fmt::layer().with_writer(std::io::stderr);
    let layer = if config::logs_json()? {
        // A request has one span, so a list of spans would repeat it.
        layer.json().flatten_event(true).with_span_list(false).boxed()
    } else {
        // A file would contain the codes of colours.
        layer.with_ansi(std::io::stderr().is_terminal()).boxed()
    };
    let _ = tracing_subscriber::registry().with(layer.with_filter(targets)).try_init();
    Ok(())
}
