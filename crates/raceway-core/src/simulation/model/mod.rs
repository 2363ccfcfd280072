//! The equations of motion: `dy/dt` of a scene with its active terms, integrated and recorded. `dynamics` holds the full and the planar
//! model; each reduced model has a folder of its own. Knows no comparison of runs, no plan and no result.

pub mod terms;

pub mod state;

pub(crate) mod surface_sites;

pub mod mechanism;

pub(crate) mod fading_damping;

pub mod failure;

pub mod inapplicable;

pub mod omission;

pub mod dynamics;

pub(crate) mod step_loads;

pub mod system;

pub mod equilibrium;

pub mod surfaces;

pub mod loaded_frequencies;

pub mod rating_life;

pub mod contact_resonance;

pub mod stiffness;

pub(crate) mod rolling_limit;

pub(crate) mod integrate;

pub mod observer;

pub(crate) mod condensed_contact;

pub(crate) mod heights;

pub mod step_ratio;

pub(crate) mod ring_motion;

pub mod radially_condensed;

pub mod spindle_only;

pub mod periodic;

pub use dynamics::{Full, Planar, Watch};
pub(crate) use fading_damping::FadingDamping;
pub use mechanism::Mechanism;
pub use system::Model;
