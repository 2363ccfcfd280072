//! Jobs: requests as they are sent, and as they are checked. Knows scenes and their JSON; knows no result.

pub mod parse;

pub mod checked;

pub mod comparison;
pub mod machine;
pub mod mode_comparison;
pub mod rotor;
pub mod search;
pub mod study;
pub mod uncertainty;

pub mod design;
pub mod distribution;
mod metric;
pub mod robust;
mod sampled_inputs;
pub mod statistic;

mod many_runs;
mod range;
mod shaft_draft;
pub mod submission;
mod varied;

pub mod simulation;
mod variation;

pub mod input;
pub mod kind;

pub mod axis;
pub mod measurement;
pub mod orders;
pub mod outputs;
pub mod recorded_turns;
pub mod solver;
mod times;

pub mod cost;
pub mod schema;
