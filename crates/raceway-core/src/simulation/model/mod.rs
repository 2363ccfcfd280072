//! The equations of motion, one model level a folder or file: `dy/dt` of a scene with what it needs, loads summed over
//! bodies. Knows no comparison of runs and no result.

pub mod condensed_contact;
pub mod dynamics;
pub mod equilibrium;
pub mod fading_damping;
pub mod failure;
pub mod integrate;
pub mod mechanism;
pub mod observer;
pub mod periodic;
pub mod radially_condensed;
pub mod spindle_only;
pub mod state;
pub mod step_loads;
pub mod step_ratio;
pub mod stiffness;
pub mod system;
pub mod terms;

pub use dynamics::{Dynamics, Full, Planar, Reaction, Watch, Wrench};
pub use fading_damping::FadingDamping;
pub use mechanism::{Mechanism, StartAzimuths};
pub use system::Model;
