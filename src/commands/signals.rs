//! Signals of the operating system.

use tokio::signal::unix::{Signal, SignalKind, signal};

/// Signal for a write beyond the largest file size (`ulimit -f`): its number on Linux (except MIPS and PA-RISC), macOS and the BSDs.
const SIGXFSZ: i32 = 25;

/// SIGINT and SIGTERM. From its creation on they no longer end the process.
///
/// Neither does a write beyond the largest file size: it fails as on a full disk.
pub struct Signals {
    interrupt: Signal,
    terminate: Signal,
    _file_size: Signal,
}

impl Signals {
    pub fn listen() -> std::io::Result<Self> {
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            _file_size: signal(SignalKind::from_raw(SIGXFSZ))?,
        })
    }

    /// Waits for the next SIGINT or SIGTERM.
    pub async fn next(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}
