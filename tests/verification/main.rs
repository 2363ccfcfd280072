//! Published cases, and cases computed independently, beside the results of this program, a module an area.
//!
//! The rows stand in `docs/verification/published-cases.md`. Each row has a test, which computes it anew and compares all its numbers to the
//! digits printed.
//!
//! `cargo test --test verification` runs them all.

mod contact;
mod distribution;
mod dynamics;
mod fluid;
mod kinematics;
mod life;
mod pocket;
mod rating;
mod table;
