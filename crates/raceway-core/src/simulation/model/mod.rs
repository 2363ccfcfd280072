//! The equations of motion, one model level a folder or file: `dy/dt` of a scene with what it needs, loads summed over
//! bodies. Knows no comparison of runs and no result.

pub mod condensed_contact;
pub mod dynamics;
pub mod equilibrium;
pub mod fading_damping;
pub mod failure;
pub mod full;
pub mod integrate;
pub mod jacobian;
pub mod mechanism;
pub mod observer;
pub mod planar;
pub mod radially_condensed;
pub mod semi_implicit;
pub mod spindle_only;
pub mod spindle_runs;
pub mod state;
pub mod step_loads;
pub mod stiffness;
pub mod system;
pub mod terms;

pub use dynamics::{Dynamics, Reaction, Watch, Wrench};
pub use fading_damping::FadingDamping;
pub use full::Full;
pub use mechanism::{Mechanism, StartAzimuths};
pub use planar::Planar;
pub use system::Model;
