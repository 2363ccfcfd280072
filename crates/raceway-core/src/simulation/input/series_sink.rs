//! Receiver of the requested time series, which takes them while a run records them.

/// Receiver of the series of a run. Each attempt at the run is a recording of its own; one of them is the result.
pub trait SeriesSink: Send + Sync {
    /// Begins a recording and returns its number.
    fn begin(&self) -> u64;

    /// Takes the next values of a series, in the unit of its channel. Series are numbered in the order of the request.
    fn write(&self, recording: u64, series: usize, values: &[f64]);

    /// Drops a recording: its attempt is not the result.
    fn discard(&self, recording: u64);
}
