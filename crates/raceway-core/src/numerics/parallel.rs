//! Two things at a time.

use std::sync::{Mutex, PoisonError};
use std::thread::Builder;

/// Does both, the first on a thread of its own where one can be had; panics as they do.
pub fn both<A: Send, B>(first: impl FnOnce() -> A + Send, second: impl FnOnce() -> B) -> (A, B) {
    let waiting = Mutex::new(Some(first));
    let take = || waiting.lock().unwrap_or_else(PoisonError::into_inner).take();
    let work = || take().map(|first| first());
    std::thread::scope(|scope| {
        let thread = Builder::new().spawn_scoped(scope, work);
        let b = second();
        let a = match thread {
            Ok(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
            Err(_) => work(),
        };
        match a {
            Some(a) => (a, b),
            None => unreachable!("the work is taken once"),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_are_done_and_a_panic_is_passed_on() {
        let borrowed = [1, 2, 3];
        assert_eq!(both(|| borrowed.iter().sum::<i32>(), || borrowed.len()), (6, 3));
        let first = || -> i32 { panic!("as the test wants") };
        assert!(std::panic::catch_unwind(|| both(first, || ())).is_err());
    }
}
