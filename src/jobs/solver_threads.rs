//! Threads that simulate. They are separate from the threads that serve HTTP and have a lower priority. They are reused, because
//! creating and ending a thread may take longer than a short run.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::oneshot;

type Work = Box<dyn FnOnce() + Send>;

/// Finished work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Done<T> {
    pub result: T,
    /// Processor time of its thread.
    pub used: Duration,
}

/// The time that a run uses, recorded in parts: wall time while it runs, which its thread cannot exceed, and at its end what the
/// processor time differs from that.
#[derive(Debug)]
pub struct UsedTime {
    begin: Instant,
    recorded_s: f64,
}

impl UsedTime {
    pub fn start() -> Self {
        Self { begin: Instant::now(), recorded_s: 0.0 }
    }

    /// Wall time since the last record [s], which is recorded now.
    pub fn record(&mut self) -> f64 {
        let now = self.begin.elapsed().as_secs_f64();
        now - std::mem::replace(&mut self.recorded_s, now)
    }

    /// The difference between all that was used and what is recorded [s]; without a known processor time by wall time.
    pub fn rest(&self, processor_time: Option<Duration>) -> f64 {
        processor_time.unwrap_or_else(|| self.begin.elapsed()).as_secs_f64() - self.recorded_s
    }
}

/// The idle threads, by the channels that give them work. They end when this is dropped.
#[derive(Debug, Clone, Default)]
pub struct SolverThreads {
    idle: Arc<Mutex<Vec<Sender<Work>>>>,
    yields: bool,
}

impl SolverThreads {
    /// Threads that yield also to those that run jobs.
    pub fn yielding() -> Self {
        Self { yields: true, ..Self::default() }
    }

    /// Runs work on a thread of its own. After a panic the channel closes without an answer, and the service continues.
    pub fn run<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> oneshot::Receiver<Done<T>> {
        let (sender, receiver) = oneshot::channel();
        let work: Work = Box::new(move || {
            let before = processor_time();
            if let Ok(result) = catch_unwind(AssertUnwindSafe(work)) {
                let used = processor_time().saturating_sub(before);
                // The receiver is gone when the service stops.
                drop(sender.send(Done { result, used }));
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
        let niceness = if self.yields { YIELDING } else { SOLVING };
        let works = move || {
            lower_priority(niceness);
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

/// Processor time that this thread has used.
fn processor_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), u32::try_from(time.tv_nsec).unwrap_or(0))
}

/// Solvers occupy whole cores; requests that only read a result have priority.
fn lower_priority(niceness: i32) {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(None, niceness);
    #[cfg(not(target_os = "linux"))]
    let _ = niceness;
}

/// Niceness of threads that run jobs, and of those that also yield to them: ten steps are a tenth of the processor time (Linux).
const SOLVING: i32 = 5;
const YIELDING: i32 = 15;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_is_reused_and_survives_a_panic() {
        let threads = SolverThreads::default();
        let name = || std::thread::current().id();
        let first = threads.run(name).blocking_recv().expect("an answer").result;
        while threads.idle.lock().expect("no poison").is_empty() {
            std::thread::yield_now();
        }
        assert!(threads.run(|| panic!("intended by the test")).blocking_recv().is_err());
        while threads.idle.lock().expect("no poison").is_empty() {
            std::thread::yield_now();
        }
        assert_eq!(threads.run(name).blocking_recv().map(|done| done.result), Ok(first));
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
        let short = threads.run(|| std::thread::current().id()).blocking_recv().expect("an answer");
        drop(end);
        assert_ne!(short.result, long.blocking_recv().expect("an answer").result);
    }

    #[test]
    fn the_processor_time_of_waiting_work_is_less_than_its_wall_time() {
        let spent = Duration::from_millis(50);
        let done = SolverThreads::default().run(move || std::thread::sleep(spent)).blocking_recv().expect("an answer");
        assert!(done.used < spent / 2, "{:?}", done.used);
    }

    #[test]
    fn recorded_parts_and_the_rest_are_the_processor_time() {
        let mut used = UsedTime::start();
        std::thread::sleep(Duration::from_millis(2));
        let parts = used.record() + used.record();
        assert!(parts >= 0.002);
        let all = parts + used.rest(Some(Duration::from_millis(1)));
        assert!((all - 0.001).abs() < 1e-12, "{all}");
    }
}
