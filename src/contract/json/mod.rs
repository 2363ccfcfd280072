//! The language of requests: strict JSON, JSON pointers, units, limits and defaults. Knows the names and limits of the parameters of
//! `physics`, but no scene and no job.

pub mod problem;
pub mod shapes;
pub mod strict;
pub mod typed;

pub mod numbers;
pub mod units;
pub mod uploads;

pub mod limits;
pub mod parameters;

pub mod defaults;
pub mod given_fields;
pub mod schema;
