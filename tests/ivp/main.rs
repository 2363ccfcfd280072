//! The integrators against problems whose answers are known.
//!
//! `cargo test --test ivp -- --nocapture` prints what each method made of each problem.

mod accuracy;
mod order;
mod problems;
mod work;
