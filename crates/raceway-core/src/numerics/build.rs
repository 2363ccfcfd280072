//! Settings of this build of the crate.

/// Optimization level.
pub const OPTIMISATION: &str = env!("RACEWAY_OPT_LEVEL");
