//! The machine and the build that a time was measured with.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The machine, and the program with its build flags.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MachineAnswer {
    /// Name of the processor; empty where the system does not report it.
    #[schema(example = "AMD EPYC 7B13")]
    pub processor: String,
    /// Number of cores that the process may use; each run uses one.
    pub cores: u64,
    /// Target platform of the build.
    #[schema(example = "x86_64-unknown-linux-gnu")]
    pub target: String,
    /// Version of raceway.
    pub version: String,
    /// Compiler of the build.
    #[schema(example = "rustc 1.95.0")]
    pub compiler: String,
    /// Build profile.
    #[schema(example = "release")]
    pub profile: String,
    /// Optimization level of the solver.
    #[schema(example = "3")]
    pub optimisation: String,
    /// Further compiler flags.
    pub flags: String,
}

impl MachineAnswer {
    /// This machine and this program.
    pub fn here() -> Self {
        Self {
            processor: processor(),
            cores: std::thread::available_parallelism().map_or(1, |cores| cores.get() as u64),
            target: env!("RACEWAY_TARGET").into(),
            version: env!("CARGO_PKG_VERSION").into(),
            compiler: env!("RACEWAY_RUSTC").into(),
            profile: env!("RACEWAY_PROFILE").into(),
            optimisation: raceway_core::numerics::build::OPTIMISATION.into(),
            flags: env!("RACEWAY_RUSTFLAGS").into(),
        }
    }
}

/// Name of the processor from Linux.
fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(String::new, |(_, name)| name.trim().to_owned())
}
