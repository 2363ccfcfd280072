//! Uncertain inputs: distributions, designs of sampled points, and what the values at these points say about the result. Plain numbers in,
//! plain numbers out; knows no bearing and no metric.

pub mod distribution;

pub mod design;
mod sobol;

pub mod order_statistics;
pub mod statistic;

pub mod basis;
pub mod expansion;
pub mod pairs;

#[cfg(test)]
mod tests;
