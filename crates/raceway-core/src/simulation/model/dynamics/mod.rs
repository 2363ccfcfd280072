//! Equations (1)–(14) in vector form: each contact gives one force and one moment, applied with opposite sign to the two bodies it
//! joins. With them stand their Jacobian and an integrator of their own. Knows no recording, no start and no choice of method.

mod attitude;
mod ball_group;
mod border;
mod contact_frame;
mod equations;
mod forces;
mod jacobian;
mod neighbours;
mod ode_system;
pub(crate) mod on_ring;
mod one_ball;
mod semi_implicit;
mod watch;

pub use equations::{Dynamics, Full, Planar};
pub use watch::Watch;
