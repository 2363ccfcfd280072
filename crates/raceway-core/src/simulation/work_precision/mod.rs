//! Error against run time: one scene run by several methods at several tolerances, each compared with a reference whose
//! own error is known.
//!
//! All runs start from the same state, in which the scene has settled, and are looked at alike. What is timed is the
//! integration, the looks at the motion that any run takes, and the interpolation to the output grid; not the
//! equilibrium, the settling, the reference, the spectra and the comparison. One thread; evaluations are bounded.

mod course;

mod errors;

mod report;

mod study;

pub use course::Taken;
pub use errors::{Errors, LEAST_SCALE, MOST_GROWN, TrajectoryError};
pub use report::{Measured, Plan, Point, Reference, WorkPrecision};
pub use study::{ABOVE_OWN_ERROR, EVALUATIONS_OVER_REFERENCE, REFERENCES, SETTLING, level_floor, study};
