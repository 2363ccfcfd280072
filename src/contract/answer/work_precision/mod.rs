//! Results of accuracy jobs: error against run time.

pub mod result;

pub mod recommended;

pub mod point;
pub mod reference;

pub mod modes;

pub mod mode_point;

pub mod machine;
