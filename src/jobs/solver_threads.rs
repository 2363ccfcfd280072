//! Threads that simulate. They are separate from the threads that serve HTTP and have a lower priority. They are reused, because
//! creating and ending a thread may take longer than a short run.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::oneshot;

type Work = Box<dyn FnOnce() + Send>;

/// The idle threads, by the channels that give them work. They end when this is dropped.
#[derive(Debug, Clone, Default)]
pub struct SolverThreads {
    idle: Arc<Mutex<Vec<Sender<Work>>>>,
}

impl SolverThreads {
    /// Runs work on a thread of its own. After a panic the channel closes without an answer, and the service continues.
    pub fn run<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> oneshot::Receiver<T> {
        let (sender, receiver) = oneshot::channel();
        let work: Work = Box::new(move || {
            if let Ok(result) = catch_unwind(AssertUnwindSafe(work)) {
                // The receiver is gone when the service stops.
                drop(sender.send(result));
            }
        });
        let thread = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let work = match thread {
            Some(thread) => thread.send(work).err().map(|refused| refused.0),
            None => Some(work),
        };
        if let Some(work) = work {
            self.spawn(work);
        }
        receiver
    }

    /// Creates a thread for this work and later work. If the thread cannot be created, the work is dropped as after a panic.
    fn spawn(&self, work: Work) {
        let idle = Arc::downgrade(&self.idle);
        let works = move || {
            lower_priority();
            let mut next = Ok(work);
            while let Ok(work) = next {
                work();
                let Some(idle) = idle.upgrade() else { return };
                // Only the list holds the sender: dropping the list ends the thread.
                let (sender, works) = channel();
                idle.lock().unwrap_or_else(PoisonError::into_inner).push(sender);
                drop(idle);
                next = works.recv();
            }
        };
        if let Err(error) = std::thread::Builder::new().name("solver".into()).spawn(works) {
            tracing::error!(%error, "no thread could be created for a run");
        }
    }
}

/// Solvers occupy whole cores; requests that only read a result have priority.
fn lower_priority() {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(None, 5);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_is_reused_and_survives_a_panic() {
        let threads = SolverThreads::default();
        let name = || std::thread::current().id();
        let first = threads.run(name).blocking_recv().expect("an answer");
        while threads.idle.lock().expect("no poison").is_empty() {
            std::thread::yield_now();
        }
        assert!(threads.run(|| panic!("intended by the test")).blocking_recv().is_err());
        while threads.idle.lock().expect("no poison").is_empty() {
            std::thread::yield_now();
        }
        assert_eq!(threads.run(name).blocking_recv(), Ok(first));
    }

    #[test]
    fn simultaneous_work_runs_on_separate_threads() {
        let threads = SolverThreads::default();
        let (begin, begun) = channel();
        let (end, ended) = channel::<()>();
        let long = threads.run(move || {
            begin.send(()).expect("a receiver");
            let _ = ended.recv();
            std::thread::current().id()
        });
        begun.recv().expect("a start");
        let short = threads.run(|| std::thread::current().id()).blocking_recv();
        drop(end);
        assert_ne!(short, long.blocking_recv());
    }
}
