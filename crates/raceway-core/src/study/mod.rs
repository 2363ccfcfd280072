//! Many runs of one scene: the points of a grid, and what their results say together. Plain numbers in, plain numbers out; knows
//! no JSON, and not what a metric is.

mod grid;
mod optimum;
mod trend;

pub use grid::Grid;
pub use optimum::{Evaluation, Optimum, Purpose, most_runs, optimum};
pub use trend::{Best, Goal, Trend, Uncertain, best, trend};
