//! Contact of two bodies: normal load, dissipation, lubricant film, traction.

pub mod damping;
pub mod film;
pub mod hertz;
pub mod strips;
pub mod traction;
