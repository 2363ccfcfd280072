//! Rating life and lubrication of a ball bearing, from loads and speeds that others find.
//!
//! `ratings` and `factors`: what ISO 281 and ISO 76 state of a bearing; `basic`: equivalent load and basic life; `reference`: life from the loads
//! of the balls (ISO/TS 16281); `lubrication`: viscosity ratio, film over roughness and the life factor. Nothing here knows a scene.

pub mod basic;
pub mod factors;
pub mod lubrication;
pub mod ratings;
pub mod reference;
