//! The main story: which models may solve a scene, one run, its verification, the result. Knows no JSON and no sentence.

pub mod run;
pub mod plan;
pub mod cost;
pub mod eligibility;
pub mod attempt;
pub mod startup;
pub mod fixed_step;
pub mod verify;
pub mod judge;
pub mod assemble;
