//! The motion: a checked scene becomes a model that holds only what it needs, an integrator advances
//! it from equilibrium, and what was asked for is observed. Plain synchronous Rust; knows no JSON, HTTP or SQL.

pub mod accuracy;
pub mod channel;
pub mod control;
pub mod distance;
pub mod divergence;
pub mod equilibrium;
pub mod integration;
pub mod judgement;
pub mod ladder;
pub mod later;
pub mod lines;
pub mod metrics;
pub mod model;
pub mod needs;
pub mod observe;
pub mod pair;
pub mod reduced;
pub mod result;
pub mod run;
pub mod scene;
pub mod settings;
pub mod settling;
pub mod state;
pub mod stepped;
pub mod stiffness;
pub mod views;
pub mod windows;
pub mod work_precision;
