//! What breaks: processes that are killed, started twice, or started carelessly. With the real program.

#[path = "../common/mod.rs"]
mod common;

mod commands;
mod crash;
mod machines;
mod startup;
mod tokens;
