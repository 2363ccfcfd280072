//! How a run talks to whoever waits for it.

/// Questions and news of a run.
pub struct Control<'a> {
    /// Looked at every few hundred steps; true ends the run.
    pub stop: &'a dyn Fn() -> bool,
    /// Told the finished share, 0–1, every few hundred steps.
    pub progress: &'a dyn Fn(f64),
    /// Shown how the run goes, every few hundred steps.
    pub live: &'a dyn Fn(&Live<'_>),
}

impl<'a> Control<'a> {
    /// Nobody looks on.
    pub const fn until(stop: &'a dyn Fn() -> bool) -> Self {
        Self { stop, progress: &|_| (), live: &|_| () }
    }

    /// Work that is a part of the whole: from one share of the progress to another.
    pub fn part<T>(&self, (from, to): (f64, f64), work: impl FnOnce(&Control<'_>) -> T) -> T {
        let progress = |share: f64| (self.progress)(from + (to - from) * share);
        work(&Control { progress: &progress, ..*self })
    }

    /// The same for a run whose levels are not those of the result.
    pub fn aside(&self) -> Self {
        Self { live: &|_| (), ..*self }
    }
}

/// What a run is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// A reduced rung beside a richer one.
    Checking,
    /// Before anything is kept.
    Settling,
    /// What the result is made of.
    Recording,
    /// How far the result can be trusted.
    Judging,
}

/// How a run goes.
pub struct Live<'a> {
    pub phase: Phase,
    /// rms of the spindle's accelerations in y and z [m/s²] over what has been kept in this window, above the band, too; `None` before. Computed when it
    /// is asked for.
    pub accelerations: &'a dyn Fn() -> Option<[f64; 2]>,
}

impl Live<'static> {
    /// Of a phase that keeps nothing.
    pub fn of(phase: Phase) -> Self {
        Self { phase, accelerations: &|| None }
    }
}
