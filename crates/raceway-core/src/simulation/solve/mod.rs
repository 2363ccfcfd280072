//! The main story: which models may solve a scene, one run, its verification, the result. Knows no JSON and no sentence.

pub mod run;

pub mod plan;

pub mod eligibility;

pub mod cost;

pub mod attempt;
pub mod fixed_step;
pub mod startup;

pub mod verify;

pub mod verification;
pub mod verify_dynamics;
pub mod verify_planar;

pub(crate) mod verify_reduced;

pub mod judge;

pub mod surface_warnings;

pub mod assemble;
