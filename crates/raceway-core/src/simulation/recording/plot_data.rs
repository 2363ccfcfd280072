//! What pictures of a run show: its motions thinned, and the loads of one ball along its way. Kept of every run; a second of it where
//! there is more.

use crate::numerics::statistics::thin;
use crate::simulation::input::channel::{Axis, Channel, Motion};
use crate::simulation::recording::load_course::LoadsAlong;
use crate::simulation::recording::load_course::stretch;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::RATE;
use crate::simulation::recording::windows::Signal;

/// Values of a signal that a picture of some hundred dots across shows, and ball passages that they can show.
const MOST_VALUES: usize = 500;
const PASSAGES: f64 = 12.0;
/// Points of an orbit, and turns that it shows: those of the shaft for the spindle, those of the cage for the cage.
const TURNS: f64 = 4.0;
const MOST_POINTS: usize = 500;

/// A signal, thinned so that peaks survive.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    pub channel: Channel,
    /// Time of the first kept value since the start of the run, and between two values before they were thinned [s].
    pub start: f64,
    pub step: f64,
    /// Which of those values are there.
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

/// All of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Views {
    pub traces: Vec<Trace>,
    pub orbits: Vec<Orbit>,
    pub loads: Option<LoadsAlong>,
}

impl Views {
    /// Of what a run has shown: of a steady one as much as can be told apart, its end.
    pub fn of(recording: &Recording, balls: usize, is_steady: bool) -> Self {
        let passage = is_steady.then_some(recording.cage_speed * balls as f64);
        let moves = [Motion::Velocity, Motion::Acceleration];
        let channels =
            [Axis::Y, Axis::Z].into_iter().flat_map(|axis| moves.map(|motion| Channel::Spindle(axis, motion)));
        let traces = channels.filter_map(|channel| Some(trace(recording.start, recording.of(channel)?, passage)));
        let spindle = |axis| Channel::Spindle(axis, Motion::Displacement);
        let orbits = [
            orbit("spindle", recording.shaft_speed, recording.of(spindle(Axis::Y)), recording.of(spindle(Axis::Z))),
            orbit(
                "cage",
                recording.cage_speed,
                recording.of(Channel::CageDisplacement(Axis::Y)),
                recording.of(Channel::CageDisplacement(Axis::Z)),
            ),
        ];
        let loads = recording.loads.clone().filter(|loads| !loads.azimuth.is_empty());
        Self { traces: traces.collect(), orbits: orbits.into_iter().flatten().collect(), loads }
    }
}

/// `passage`: of balls [rad/s].
fn trace(start: f64, signal: &Signal, passage: Option<f64>) -> Trace {
    let (scale, values) = (signal.channel.scale(), signal.first_window());
    let first = values.len() - stretch(values.len(), PASSAGES, passage);
    let kept = thin(&values[first..], MOST_VALUES);
    Trace {
        channel: signal.channel,
        start: start + first as f64 / RATE,
        step: 1.0 / RATE,
        value: kept.iter().map(|place| scale * values[first + place]).collect(),
        place: kept,
    }
}

/// `speed`: of what turns [rad/s].
fn orbit(body: &'static str, speed: f64, y: Option<&Signal>, z: Option<&Signal>) -> Option<Orbit> {
    let (y, z) = (y?, z?);
    let all = y.first_window().len();
    let turns = stretch(all, TURNS, Some(speed));
    let every = turns.div_ceil(MOST_POINTS).max(1);
    let points = |signal: &Signal| {
        let scale = signal.channel.scale();
        signal.first_window().iter().skip(all - turns).step_by(every).map(|value| scale * value).collect()
    };
    Some(Orbit { body, y: points(y), z: points(z) })
}
