//! How this crate was built.

/// Optimization level.
pub const OPTIMISATION: &str = env!("RACEWAY_OPT_LEVEL");
