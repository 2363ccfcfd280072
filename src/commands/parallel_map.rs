//! Many independent runs on several threads.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};

/// Default number of threads.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The results of `run` for the numbers 0 to `count` − 1, in order, on `threads` threads. `progress` gets the finished share.
pub fn map<T: Send>(count: usize, threads: usize, progress: &dyn Fn(f64), run: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let done: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    let next = AtomicUsize::new(0);
    let (ended, end) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, count.max(1)) {
            let ended = ended.clone();
            let (next, done, run) = (&next, &done, &run);
            scope.spawn(move || {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(place) = done.get(number) else { return };
                    let result = run(number);
                    *place.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
                    let _ = ended.send(());
                }
            });
        }
        drop(ended);
        for count_done in 1..=count {
            if end.recv().is_err() {
                break;
            }
            progress(count_done as f64 / count as f64);
        }
    });
    // A panic in a thread propagates from the scope, so every place is filled here.
    done.into_iter().filter_map(|place| place.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_whatever_the_number_of_threads() {
        for threads in [0, 1, 3, 100] {
            let shares = Mutex::new(Vec::new());
            let squares = map(20, threads, &|share| shares.lock().unwrap().push(share), |number| number * number);
            assert_eq!(squares, (0..20).map(|number| number * number).collect::<Vec<_>>());
            assert_eq!(shares.into_inner().unwrap().last(), Some(&1.0));
        }
        assert!(map(0, 2, &|_| (), |number| number).is_empty());
    }
}
