//! Plan of a study and its outcome.

use super::course::Taken;
use super::errors::{Errors, TrajectoryError};
use crate::numerics::ode::{Choice, Method, Statistics};
use crate::simulation::error::report::MotionKind;
use crate::simulation::input::channel::Channel;
use crate::simulation::model::terms::LeftOut;
use crate::simulation::result::lines::Line;

/// What is compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub methods: Vec<Method>,
    pub relative_tolerances: Vec<f64>,
    /// Timed runs of each method at each tolerance; at least 1.
    pub repetitions: u32,
}

/// What a study leaves behind. Times in seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkPrecision {
    /// Time of the state that all runs start from.
    pub begin: f64,
    /// Distance of the points of the output grid, and their number; the first is one distance after `begin`.
    pub grid: (f64, usize),
    pub states: usize,
    pub rung: &'static str,
    /// `None`: the run is too short to tell.
    pub motion: Option<MotionKind>,
    /// [1/s]
    pub divergence_rate: f64,
    pub reference: Reference,
    /// Evaluations that a run might take.
    pub most_evaluations: u64,
    pub points: Vec<Point>,
    pub left_out: Vec<LeftOut>,
}

/// The reference and its own error: its difference from the check.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    pub method: Method,
    pub relative_tolerance: f64,
    /// `None`: no second reference finished, and nothing is known of its error.
    pub check: Option<(Method, f64)>,
    pub own_error_db: Option<f64>,
    /// `None` in chaotic motion, too: each point is compared over a time of its own, and has it for that time.
    pub own_trajectory: Option<TrajectoryError>,
    /// Chaotic motion: what the level of another run of the same length would scatter by, worst of the judged channels [dB].
    pub sampling_error_db: Option<f64>,
    /// Of the spindle's accelerations [dB]; absent where it stands still.
    pub levels: Vec<(Channel, Option<f64>)>,
    /// The lines that are compared.
    pub lines: Vec<(Channel, Line)>,
    pub statistics: Statistics,
    pub taken: Taken,
}

/// One method at one tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    pub method: Method,
    pub relative_tolerance: f64,
    /// By each repetition until its end or its failure; empty where it was not tried.
    pub taken: Vec<Taken>,
    /// Or why there is no result, in words.
    pub measured: Result<Measured, String>,
}

/// What a finished run has shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// What ran, and why where it chose itself.
    pub choice: Choice,
    pub statistics: Statistics,
    pub errors: Errors,
    /// The reference's own trajectory error (root mean square) over the same time.
    pub own_trajectory: Option<f64>,
    /// The trajectory's error is less than ten times that: it says nothing.
    pub below_reference: bool,
    /// The same of the level, or it is less than the level's sampling error.
    pub level_below_reference: bool,
}
