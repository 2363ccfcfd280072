//! Scenes: what is simulated, in the user's units, with defaults and presets. Each input type converts itself to the parameters of
//! `physics`. Knows no job and no result.

pub mod scene_input;

pub mod bearing;
pub mod cage;
pub mod damping;
pub mod life;
pub mod loads;
pub mod lubricant;
pub mod material;
pub mod mounting;
pub mod oil;
pub mod operation;
pub mod spindle;
pub mod surfaces;
pub mod system_terms;
pub mod terms;

pub mod housing;
pub mod imported;
pub mod outer_ring;
mod rigid_spindle;
pub mod rotor_bearings;
pub mod rotor_scene;
pub mod sensor;
pub mod shaft;
mod shaft_loads;
mod springs;
pub mod supports;

pub mod single_bearing;

pub mod catalogue;
pub mod presets;

mod bearing_base;
mod mounted_bearing;
mod names;
mod preset_names;
