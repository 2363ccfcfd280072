//! Data of the plots of a run: thinned motions, orbits, and the loads of one ball. Plots show at most the first second of the recorded
//! time.

use std::ops::Range;

use crate::numerics::statistics::thin;
use crate::simulation::input::channel::{Axis, Channel, Motion};
use crate::simulation::recording::defect_passages::Passage;
use crate::simulation::recording::load_course::BallLoadCourse;
use crate::simulation::recording::load_course::values_in_turns;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::RATE;
use crate::simulation::recording::windows::Signal;

/// Largest number of values of a trace: a plot is some hundred pixels wide.
const MAX_TRACE_VALUES: usize = 500;
/// Ball passages that a trace of a steady run shows.
const TRACE_PASSAGES: f64 = 12.0;
/// Ball passages around an impact.
const IMPACT_PASSAGES: f64 = 3.0;
/// Turns that an orbit shows: of the shaft for the spindle, of the cage for the cage.
const ORBIT_TURNS: f64 = 4.0;
/// Largest number of points of an orbit.
const MAX_ORBIT_POINTS: usize = 500;

/// A signal, thinned so that peaks survive.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    pub channel: Channel,
    /// Time of the first recorded value since the start of the run [s].
    pub start: f64,
    /// Interval between two values before thinning [s].
    pub step: f64,
    /// Indices of the values that remain after thinning.
    pub place: Vec<usize>,
    /// In the channel's unit.
    pub value: Vec<f64>,
}

/// The path of a body's centre in the plane of the bearing.
#[derive(Debug, Clone, PartialEq)]
pub struct Orbit {
    pub body: &'static str,
    /// [µm]
    pub y: Vec<f64>,
    /// [µm]
    pub z: Vec<f64>,
}

/// The spindle's acceleration around its largest peak.
#[derive(Debug, Clone, PartialEq)]
pub struct Impact {
    pub traces: Vec<Trace>,
    /// Time of the peak [s].
    pub peak: f64,
    /// Passages of balls over defects within these traces.
    pub passages: Vec<Passage>,
}

/// Data of all plots of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlotData {
    pub traces: Vec<Trace>,
    pub orbits: Vec<Orbit>,
    pub loads: Option<BallLoadCourse>,
    /// Of scenes with defects.
    pub impact: Option<Impact>,
}

impl PlotData {
    /// Data of a recording. Of a steady run only the last passages and turns are kept, as many as a plot can resolve.
    pub fn of(recording: &Recording, balls: usize, is_steady: bool) -> Self {
        let passage = is_steady.then_some(recording.speeds.cage * balls as f64);
        let moves = [Motion::Velocity, Motion::Acceleration];
        let channels =
            [Axis::Y, Axis::Z].into_iter().flat_map(|axis| moves.map(|motion| Channel::Spindle(axis, motion)));
        let traces = channels.filter_map(|channel| Some(trace(recording.start, recording.of(channel)?, passage)));
        let spindle = |axis| Channel::Spindle(axis, Motion::Displacement);
        let orbits = [
            orbit("spindle", recording.speeds.shaft, recording.of(spindle(Axis::Y)), recording.of(spindle(Axis::Z))),
            orbit(
                "cage",
                recording.speeds.cage,
                recording.of(Channel::CageDisplacement(Axis::Y)),
                recording.of(Channel::CageDisplacement(Axis::Z)),
            ),
        ];
        let loads = recording.loads.clone().filter(|loads| !loads.azimuth.is_empty());
        Self { traces: traces.collect(), orbits: orbits.into_iter().flatten().collect(), loads, impact: None }
    }
}

impl Impact {
    /// The largest peak of the accelerations in y and z over the first window; `None` without a signal.
    pub fn of(recording: &Recording, balls: usize) -> Option<Self> {
        let of = |axis| recording.of(Channel::Spindle(axis, Motion::Acceleration));
        let signals: Vec<&Signal> = [Axis::Y, Axis::Z].into_iter().filter_map(of).collect();
        let largest = |signal: &&Signal| {
            let values = signal.first_window().iter().map(|value| value.abs()).enumerate();
            values.max_by(|(_, one), (_, other)| one.total_cmp(other))
        };
        let (place, _) = signals.iter().filter_map(largest).max_by(|(_, one), (_, other)| one.total_cmp(other))?;
        let all = signals.first()?.first_window().len();
        let shown = values_in_turns(all, IMPACT_PASSAGES, Some(recording.speeds.cage * balls as f64));
        let first = place.saturating_sub(shown / 2).min(all - shown);
        let trace = |signal: &&Signal| part(recording.start, signal, first..first + shown);
        let time = |place: usize| recording.start + place as f64 / RATE;
        let is_shown = |passage: &&Passage| passage.exit > time(first) && passage.entry < time(first + shown);
        let passages = recording.passages.iter().filter(is_shown).copied().collect();
        Some(Self { traces: signals.iter().map(trace).collect(), peak: time(place), passages })
    }
}

/// Trace of a signal; `passage`: angular rate of ball passages [rad/s].
fn trace(start: f64, signal: &Signal, passage: Option<f64>) -> Trace {
    let values = signal.first_window();
    let first = values.len() - values_in_turns(values.len(), TRACE_PASSAGES, passage);
    part(start, signal, first..values.len())
}

/// Part of the first window of a signal, thinned; `start`: time of its first value [s].
fn part(start: f64, signal: &Signal, part: Range<usize>) -> Trace {
    let (scale, values) = (signal.channel.scale(), &signal.first_window()[part.clone()]);
    let kept = thin(values, MAX_TRACE_VALUES);
    Trace {
        channel: signal.channel,
        start: start + part.start as f64 / RATE,
        step: 1.0 / RATE,
        value: kept.iter().map(|place| scale * values[*place]).collect(),
        place: kept,
    }
}

/// Orbit of a body; `speed`: angular speed of its reference rotation [rad/s].
fn orbit(body: &'static str, speed: f64, y: Option<&Signal>, z: Option<&Signal>) -> Option<Orbit> {
    let (y, z) = (y?, z?);
    let all = y.first_window().len();
    let turns = values_in_turns(all, ORBIT_TURNS, Some(speed));
    let every = turns.div_ceil(MAX_ORBIT_POINTS).max(1);
    let points = |signal: &Signal| {
        let scale = signal.channel.scale();
        signal.first_window().iter().skip(all - turns).step_by(every).map(|value| scale * value).collect()
    };
    Some(Orbit { body, y: points(y), z: points(z) })
}
