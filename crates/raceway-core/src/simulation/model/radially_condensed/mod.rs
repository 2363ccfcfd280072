//! Model level `radially_condensed`: the radial motion of the balls is in equilibrium between the raceways, and nothing leaves the
//! plane.
//!
//! A ball held between its raceways follows the spindle within microseconds, far above the band of interest. Its azimuth, orbit
//! speed and spin remain as states. Its radius follows from the approach of the raceways (`condensed_contact.rs`), with inertia and
//! the damping of both contacts to first order. Knows no axial motion, no tilt and no error of its own.

mod applicability;

mod carried_balls;

mod border;

mod contact;

mod traction;

mod ball;

mod pocket;

mod equations;

mod evaluation;

mod stepping;

mod step_length;

mod films;

mod loaded_lift;

mod observer;

pub(crate) mod on_ring;

mod run;

pub use crate::simulation::model::step_ratio::StepRatio;
pub use applicability::inapplicability;
pub use equations::RadiallyCondensed;
pub use run::simulate;
pub(crate) use run::simulate_perturbed;
pub use stepping::{Observe, Stepper};
