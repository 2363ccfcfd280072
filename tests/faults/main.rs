//! Faults of the real program: processes that are killed, started twice, or started with wrong settings.

#[path = "../common/mod.rs"]
mod common;

mod commands;
mod crash;
mod machines;
mod startup;
mod tokens;
mod upgrade;
