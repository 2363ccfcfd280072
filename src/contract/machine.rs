//! Where and by what a time was measured.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The machine that ran, and the program with the flags it was built with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MachineAnswer {
    /// Name of the processor; empty where the system does not tell.
    #[schema(example = "AMD EPYC 7B13")]
    pub processor: String,
    /// Cores that the process may use; each run uses one.
    pub cores: u64,
    /// What the program was compiled for.
    #[schema(example = "x86_64-unknown-linux-gnu")]
    pub target: String,
    /// Of raceway.
    pub version: String,
    /// What compiled it.
    #[schema(example = "rustc 1.95.0")]
    pub compiler: String,
    /// Profile it was built with.
    #[schema(example = "release")]
    pub profile: String,
    /// Level of optimisation.
    #[schema(example = "3")]
    pub optimisation: String,
    /// Further flags of the compiler.
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
            optimisation: env!("RACEWAY_OPT_LEVEL").into(),
            flags: env!("RACEWAY_RUSTFLAGS").into(),
        }
    }
}

/// Name of the processor as Linux tells it.
fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = told.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(String::new, |(_, name)| name.trim().to_owned())
}
