//! Wall time and processor time of a run.

use std::time::Instant;

/// Duration of a run [s].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taken {
    pub wall: f64,
    /// Processor time of this thread within it; `None` where the system does not measure it.
    pub processor: Option<f64>,
}

/// Clock of wall time and processor time.
pub(crate) struct Clock {
    begin: Instant,
    processor: Option<f64>,
}

impl Clock {
    pub(crate) fn start() -> Self {
        Self { processor: processor_time(), begin: Instant::now() }
    }

    pub(crate) fn taken(&self) -> Taken {
        let wall = self.begin.elapsed().as_secs_f64();
        let processor = self.processor.and_then(|begin| Some(processor_time()? - begin));
        Taken { wall, processor }
    }
}

/// Processor time of this thread so far [s].
#[cfg(target_os = "linux")]
fn processor_time() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

#[cfg(not(target_os = "linux"))]
fn processor_time() -> Option<f64> {
    None
}
