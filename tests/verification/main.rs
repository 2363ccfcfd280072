//! Published cases, and cases computed in another way, beside what this program computes: the rows of
//! `docs/VERIFICATION.md`, a module an area. The table is held to the tests: each test computes a row anew and compares
//! all its numbers to the digits printed, and each row has a test.
//!
//! `cargo test --test verification` runs them all.

mod contact;
mod distribution;
mod dynamics;
mod fluid;
mod kinematics;
mod pocket;
mod rating;
mod table;
