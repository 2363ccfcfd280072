//! The HTTP contract, over real sockets and a real database. Files are named after routes. Where the physics does not matter, a stub
//! replaces the simulator.

#[path = "../common/mod.rs"]
mod common;
mod server;

mod access;
mod accuracy;
mod comparison;
mod job_events;
mod jobs;
mod jobs_cancel;
mod jobs_list;
mod jobs_once;
mod openapi;
mod optimum;
mod portal;
mod refusals;
mod results;
mod scenes;
mod service_metrics;
mod stored_results;
mod studies;
mod uncertainty;
mod uploaded_series;
