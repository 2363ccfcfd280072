//! Error against run time: one scene run by several methods at several tolerances, each compared with a reference whose
//! own error is known.
//!
//! All runs start from the same settled state and are observed alike. The timed part is the integration, the observation of the
//! motion and the interpolation to the output grid. Equilibrium, settling, reference, spectra and comparison are not timed. Each run
//! uses one thread and a bounded number of evaluations. Knows no JSON, no plot and no choice of method by itself.

mod clock;

mod course;

mod errors;

mod report;

mod study;

pub(crate) use clock::Clock;
pub use clock::Taken;
pub use errors::{Errors, LEAST_SCALE, MOST_GROWN, TrajectoryError};
pub use report::{Measured, Plan, Point, Reference, WorkPrecision};
pub use study::{ABOVE_OWN_ERROR, SETTLING, level_floor, study};
