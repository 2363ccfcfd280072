//! Callbacks between a run and its caller: cancellation, progress, live levels, time series.

use std::sync::Arc;

use crate::simulation::input::series_sink::SeriesSink;

/// Callbacks of a run.
pub struct Control<'a> {
    /// Polled every few hundred steps; `true` ends the run.
    pub stop: &'a dyn Fn() -> bool,
    /// Receives the finished share, 0–1, every few hundred steps.
    pub progress: &'a dyn Fn(f64),
    /// Receives the phase and the live levels, every few hundred steps.
    pub live: &'a dyn Fn(&Live<'_>),
    /// Receives the requested series; `None`: the result holds them.
    pub series: Option<&'a Arc<dyn SeriesSink>>,
}

impl<'a> Control<'a> {
    /// Cancellation only: progress and live levels are dropped, and the result holds the series.
    pub const fn until(stop: &'a dyn Fn() -> bool) -> Self {
        Self { stop, progress: &|_| (), live: &|_| (), series: None }
    }

    /// Runs `work` as a part of the whole, from one share of the progress to another.
    pub fn part<T>(&self, (from, to): (f64, f64), work: impl FnOnce(&Control<'_>) -> T) -> T {
        let progress = |share: f64| (self.progress)(from + (to - from) * share);
        work(&Control { progress: &progress, ..*self })
    }

    /// Callbacks without live levels, for a run whose levels are not those of the result.
    pub(crate) fn without_live(&self) -> Self {
        Self { live: &|_| (), ..*self }
    }
}

/// Phase of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Comparison of a reduced model with a richer one.
    Checking,
    /// Decay of the transient; nothing is recorded.
    Settling,
    /// Simulation of the recorded time.
    Recording,
    /// Estimation of the error.
    Judging,
}

/// State of a run while it runs.
pub struct Live<'a> {
    pub phase: Phase,
    /// rms of the spindle's accelerations in y and z [m/s²] over the recorded part of this window, at all frequencies; `None`
    /// before the first value. Computed on request.
    pub accelerations: &'a dyn Fn() -> Option<[f64; 2]>,
}

impl Live<'static> {
    /// State in a phase that records nothing.
    pub fn of(phase: Phase) -> Self {
        Self { phase, accelerations: &|| None }
    }
}
