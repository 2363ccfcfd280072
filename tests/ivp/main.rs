//! The integrators against problems whose answers are known.

mod accuracy;
mod problems;
