//! Model level `spindle_only`: only place and velocity of the spindle are integrated. Balls orbit equally spaced at the cage's speed,
//! each in radial equilibrium between its raceways. Knows no slip, no motion of the cage and no recorded load of a ball.

mod applicability;

pub(crate) mod equations;

pub(crate) mod on_ring;

mod scene_model;

mod recording;

mod run;

pub use applicability::inapplicability;
pub(crate) use recording::{recording, statistics};
pub use run::simulate;
pub(crate) use scene_model::{scene_model, turned_model};
