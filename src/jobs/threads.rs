//! Threads that simulate: away from those that serve HTTP, of lower priority, and kept for the next run, for a thread takes
//! longer to make and to clear away than a short run may take.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::oneshot;

type Work = Box<dyn FnOnce() + Send>;

/// The threads that have nothing to do, by where they take work. They end when this does.
#[derive(Debug, Clone, Default)]
pub struct SolverThreads {
    idle: Arc<Mutex<Vec<Sender<Work>>>>,
}

impl SolverThreads {
    /// Does work on a thread of its own. A panic ends the work, not the service: the channel closes without an answer.
    pub fn run<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> oneshot::Receiver<T> {
        let (sender, receiver) = oneshot::channel();
        let work: Work = Box::new(move || {
            if let Ok(result) = catch_unwind(AssertUnwindSafe(work)) {
                // Nobody waits any more: the service stops.
                drop(sender.send(result));
            }
        });
        let thread = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let work = match thread {
            Some(thread) => thread.send(work).err().map(|refused| refused.0),
            None => Some(work),
        };
        if let Some(work) = work {
            self.begin(work);
        }
        receiver
    }

    /// Makes a thread for this work and what comes after it. One that cannot be made drops the work, like a panic.
    fn begin(&self, work: Work) {
        let idle = Arc::downgrade(&self.idle);
        let works = move || {
            yield_to_readers();
            let mut next = Ok(work);
            while let Ok(work) = next {
                work();
                let Some(idle) = idle.upgrade() else { return };
                // The list alone holds the sender: with it goes the thread.
                let (sender, works) = channel();
                idle.lock().unwrap_or_else(PoisonError::into_inner).push(sender);
                drop(idle);
                next = works.recv();
            }
        };
        if let Err(error) = std::thread::Builder::new().name("solver".into()).spawn(works) {
            tracing::error!(%error, "no thread could be made for a run");
        }
    }
}

/// Solvers burn whole cores; whoever only wants to look at a result goes first.
fn yield_to_readers() {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(None, 5);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_does_one_work_after_another_and_survives_a_panic() {
        let threads = SolverThreads::default();
        let name = || std::thread::current().id();
        let first = threads.run(name).blocking_recv().expect("it answers");
        while threads.idle.lock().expect("whole").is_empty() {
            std::thread::yield_now();
        }
        assert!(threads.run(|| panic!("as the test wants")).blocking_recv().is_err());
        while threads.idle.lock().expect("whole").is_empty() {
            std::thread::yield_now();
        }
        assert_eq!(threads.run(name).blocking_recv(), Ok(first));
    }

    #[test]
    fn works_at_the_same_time_have_threads_of_their_own() {
        let threads = SolverThreads::default();
        let (begin, begun) = channel();
        let (end, ended) = channel::<()>();
        let long = threads.run(move || {
            begin.send(()).expect("somebody waits");
            let _ = ended.recv();
            std::thread::current().id()
        });
        begun.recv().expect("it begins");
        let short = threads.run(|| std::thread::current().id()).blocking_recv();
        drop(end);
        assert_ne!(short, long.blocking_recv());
    }
}
