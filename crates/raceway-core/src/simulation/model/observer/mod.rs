//! The observer of the dynamics: it samples the motion while an integrator advances it, and leaves a recording.
//!
//! Samples stand at 409 600 Hz, interpolated within the steps; long fixed steps, which damp fast motion, are sampled less often. A sample
//! is an evaluation of the equations, except where the integrator itself states the loads at the end of a step (`Integrator::sight`).
//! There each step is recorded as it ends, and samples are interpolated between steps. A low-pass filter takes the spindle's signals to
//! 102 400 Hz, because contact resonances lie above the band of interest and must not fold into it. Other channels are recorded without a
//! filter, window by window (`windows.rs`). Extremes include every sample. Knows no comparison of runs.

mod moments;

mod powers;

mod snapshot;

mod run_observer;

pub use run_observer::Observer;
