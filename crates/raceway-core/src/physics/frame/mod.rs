//! The elastic frame around the bearings: the shaft as beams and discs, its free modes, and what loads it. Linear algebra once a
//! scene, in SI. Knows no bearing and no speed: gyroscopic matrices are those of 1 rad/s.
//!
//! A shaft is axisymmetric, so that one plane stands for both: displacement and slope (w, w′) are (y, β_z) in the plane of Y and
//! (z, −β_y) in that of Z, the slopes taken without shear. Rotations about Y and Z follow as β_y = −z′, β_z = y′.

pub mod beam;
pub mod disc;
pub mod shaft;

pub mod mesh;
pub mod modes;

pub mod structure;
pub mod support;

pub mod housing;
