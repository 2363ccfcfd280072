//! The equations of motion: `dy/dt` of a scene with its active terms, integrated and recorded. `dynamics` holds the full and the planar
//! model; each reduced model has a folder of its own. Knows no comparison of runs, no plan and no result.

pub(crate) mod condensed_contact;
pub mod dynamics;
pub mod equilibrium;
pub(crate) mod fading_damping;
pub mod failure;
pub(crate) mod integrate;
pub mod mechanism;
pub mod observer;
pub mod periodic;
pub mod radially_condensed;
pub mod spindle_only;
pub mod state;
pub(crate) mod step_loads;
pub mod step_ratio;
pub mod stiffness;
pub mod system;
pub mod terms;

pub use dynamics::{Full, Planar, Watch};
pub(crate) use fading_damping::FadingDamping;
pub use mechanism::Mechanism;
pub use system::Model;
