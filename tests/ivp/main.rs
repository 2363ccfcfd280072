//! The integrators on problems with known solutions.
//!
//! `cargo test --test ivp -- --nocapture` prints the error of each method on each problem.

mod accuracy;
mod order;
mod problems;
mod work;
