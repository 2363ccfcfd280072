//! The equations of motion: `dy/dt` of a scene with its active terms, integrated and recorded. `dynamics` holds the full and the planar
//! model; each reduced model has a folder of its own. Knows no comparison of runs, no plan and no result.

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
