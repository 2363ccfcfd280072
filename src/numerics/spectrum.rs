//! Amplitude and envelope spectra.

/// One-sided amplitude spectrum: entry `k` belongs to frequency `k · resolution`, and a sine of
/// amplitude 1 on a bin reads 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// [Hz]
    pub resolution: f64,
    pub amplitude: Vec<f64>,
    /// Name of the window.
    pub window: &'static str,
}
