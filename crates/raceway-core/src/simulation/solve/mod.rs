//! The main story: which models may solve a scene, one run, its verification, the result.

pub mod fixed_step;
pub mod judgement;
pub mod ladder;
pub mod run;
pub mod startup;
