//! The main story: which models may solve a scene, one run, its verification, the result. Knows no JSON and no sentence.

pub mod assemble;
pub mod attempt;
pub mod cost;
pub mod eligibility;
pub mod fixed_step;
pub mod judge;
pub mod plan;
pub mod run;
pub mod startup;
pub mod verification;
pub mod verify;
pub mod verify_dynamics;
pub mod verify_reduced;
