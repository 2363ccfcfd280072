//! Results as JSON: of a request before it runs, of a simulation, a study, an optimum job and an accuracy job. Knows jobs; runs none but
//! the search for an optimum, by a function that it is given.

pub mod headline;
pub mod loads;
pub mod messages;
pub mod metrics;
pub mod report;
pub mod signals;
pub mod spectrum_view;
pub mod views;

mod arrangement;
pub mod machine;
pub mod machine_plan;
pub mod measured;
pub mod measured_comparison;
pub mod optimum;
pub mod orders;
pub mod propagation;
pub mod ross;
pub mod rotor;
pub mod rotor_model;
mod sampled_row;
pub mod table;
pub mod work_precision;

pub mod point;
pub mod uncertainty;

pub mod failure;

pub mod envelope;
pub mod friction;
pub mod life;
pub mod ordered;
pub mod resolve;
pub mod resonance;
pub mod surfaces;
pub mod unit_warnings;

pub mod csv;
pub mod headings;
pub mod scene_heading;
