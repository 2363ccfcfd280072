//! Plan of a study and its outcome.

use super::clock::Taken;
use super::errors::{Errors, TrajectoryError};
use crate::numerics::ode::{Choice, Method, Statistics};
use crate::simulation::error::lyapunov::MotionKind;
use crate::simulation::input::channel::Channel;
use crate::simulation::model::terms::LeftOut;
use crate::simulation::result::lines::Line;

/// Methods and tolerances of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub methods: Vec<Method>,
    pub relative_tolerances: Vec<f64>,
    /// Timed runs of each method at each tolerance; at least 1.
    pub repetitions: u32,
}

/// Outcome of a study. Times in seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkPrecision {
    /// Time of the state that all runs start from.
    pub begin: f64,
    /// Interval of the output grid, and its number of points; the first point is one interval after `begin`.
    pub grid: (f64, usize),
    pub states: usize,
    pub rung: &'static str,
    /// `None`: the run is too short to tell.
    pub motion: Option<MotionKind>,
    /// [1/s]
    pub divergence_rate: f64,
    pub reference: Reference,
    /// Largest number of evaluations of a run.
    pub most_evaluations: u64,
    pub points: Vec<Point>,
    pub left_out: Vec<LeftOut>,
}

/// The reference and its own error: its difference from the check.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    pub method: Method,
    pub relative_tolerance: f64,
    /// `None`: no second reference finished, and the error of the first is unknown.
    pub check: Option<(Method, f64)>,
    pub own_error_db: Option<f64>,
    /// `None` in chaotic motion, too: each point is compared over a time of its own, and states this error for that time.
    pub own_trajectory: Option<TrajectoryError>,
    /// Chaotic motion: standard deviation of the level between runs of this length, largest of the compared channels [dB].
    pub sampling_error_db: Option<f64>,
    /// Levels of the spindle's accelerations [dB]; absent where it stands still.
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
    /// Duration of each repetition until its end or its failure; empty where the point was not tried.
    pub taken: Vec<Taken>,
    /// The measurement, or the reason for its absence.
    pub measured: Result<Measured, String>,
}

/// Measurement of a finished run.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Integrator that ran, with its reason where the method is automatic.
    pub choice: Choice,
    pub statistics: Statistics,
    pub errors: Errors,
    /// The reference's own trajectory error (root mean square) over the same time.
    pub own_trajectory: Option<f64>,
    /// The trajectory error is less than ten times the reference's own, and therefore not significant.
    pub below_reference: bool,
    /// The level error is less than ten times the reference's own, or less than the level's sampling error.
    pub level_below_reference: bool,
}
