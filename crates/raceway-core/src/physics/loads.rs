//! Loads on the spindle beside the constant forces of the operation: forces along and moments about the axes, over time or over the angle
//! that the spindle has turned.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::limits::{Faults, HIGHEST_FREQUENCY, InvalidParameter, MOST_POINTS, SHORTEST_RAMP};
use super::samples::Samples;
use crate::numerics::angle::sin_cos;

/// Largest number of loads.
pub const MOST_LOADS: usize = 32;
/// Steps in a period of a harmonic load, and in the period of which a shock is half [-]. As for waves of raceways.
const STEPS_PER_PERIOD: f64 = 10.0;

/// Forces along X, Y, Z [N] and moments about Y and the new Z [N m], the axes of the spindle's motions.
pub type SpindleLoad = [f64; 5];

/// Direction of a load. Moments act about the axes that tilt turns about: Y and the new Z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadDirection {
    X,
    Y,
    Z,
    AboutY,
    AboutZ,
}

impl LoadDirection {
    pub fn is_moment(self) -> bool {
        matches!(self, Self::AboutY | Self::AboutZ)
    }
}

/// One load on the spindle.
#[derive(Debug, Clone, PartialEq)]
pub enum Load {
    Along(LoadDirection, LoadCourse),
    /// A force of constant magnitude that turns from +Y to +Z: in Y as the harmonic one, in Z a quarter of a period later.
    Rotating(Harmonic),
}

/// A load over time: force [N] or moment [N m].
#[derive(Debug, Clone, PartialEq)]
pub enum LoadCourse {
    Constant(f64),
    /// Straight lines between points (time [s], load), constant outside them.
    Points(Vec<(f64, f64)>),
    Harmonic(Harmonic),
    Shock(Shock),
    Samples(Arc<Samples>),
}

/// amplitude · cos(argument + phase). The argument is that of the rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// [N] or [N m]
    pub amplitude: f64,
    pub rate: LoadRate,
    /// [rad]
    pub phase: f64,
}

/// Rate of a harmonic load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoadRate {
    /// [Hz]
    Frequency(f64),
    /// Periods in a turn of the spindle [-].
    Order(f64),
}

/// Half of a sine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shock {
    /// [N] or [N m]
    pub peak: f64,
    /// Begin and duration [s].
    pub at: f64,
    pub duration: f64,
}

impl Harmonic {
    /// Argument at a time [s] and an angle of the spindle [rad].
    #[inline]
    fn argument(&self, time: f64, angle: f64) -> f64 {
        match self.rate {
            LoadRate::Frequency(frequency) => TAU * frequency * time + self.phase,
            LoadRate::Order(order) => order * angle + self.phase,
        }
    }

    /// Frequency at a speed of the spindle [Hz]; `speed`: [rad/s].
    pub fn frequency(&self, speed: f64) -> f64 {
        match self.rate {
            LoadRate::Frequency(frequency) => frequency,
            LoadRate::Order(order) => order * speed.abs() / TAU,
        }
    }
}

impl LoadCourse {
    #[inline]
    fn at(&self, time: f64, angle: f64) -> f64 {
        match self {
            Self::Constant(load) => *load,
            Self::Points(points) => between_points(points, time),
            Self::Harmonic(harmonic) => harmonic.amplitude * sin_cos(harmonic.argument(time, angle)).1,
            Self::Shock(Shock { peak, at, duration }) => match time - at {
                elapsed if elapsed > 0.0 && elapsed < *duration => peak * sin_cos(PI * elapsed / duration).0,
                _ => 0.0,
            },
            Self::Samples(samples) => samples.at(time),
        }
    }

    /// The course of a run that ends at a time [s]: later points and shocks do not count.
    fn until(&self, end: f64) -> Self {
        match self {
            Self::Points(points) if points.last().is_some_and(|point| point.0 > end) => {
                let before = points.iter().filter(|point| point.0 < end - SHORTEST_RAMP);
                Self::Points(before.copied().chain([(end, between_points(points, end))]).collect())
            }
            Self::Shock(shock) if shock.at >= end => Self::Constant(0.0),
            other => other.clone(),
        }
    }

    /// The load in equilibrium with which a run starts: that at time 0, of a harmonic load the mean.
    fn at_start(&self) -> f64 {
        match self {
            Self::Harmonic(_) => 0.0,
            other => other.at(0.0, 0.0),
        }
    }

    /// Largest difference from the load at the start.
    fn largest_change(&self) -> f64 {
        match self {
            Self::Constant(_) => 0.0,
            Self::Points(points) => {
                let start = self.at_start();
                points.iter().map(|point| (point.1 - start).abs()).fold(0.0, f64::max)
            }
            Self::Harmonic(harmonic) => harmonic.amplitude,
            Self::Shock(shock) => shock.peak.abs(),
            Self::Samples(samples) => samples.largest_change(),
        }
    }
}

fn between_points(points: &[(f64, f64)], time: f64) -> f64 {
    let next = points.partition_point(|point| point.0 < time);
    match (next.checked_sub(1).map(|before| points[before]), points.get(next)) {
        (Some((at, load)), Some(&(end, next))) => load + (next - load) * ((time - at) / (end - at)),
        (Some((_, load)), None) | (None, Some(&(_, load))) => load,
        (None, None) => 0.0,
    }
}

impl Load {
    /// The load of a run that ends at a time [s]: later points and shocks do not count.
    pub fn until(&self, end: f64) -> Self {
        match self {
            Self::Along(direction, course) => Self::Along(*direction, course.until(end)),
            Self::Rotating(harmonic) => Self::Rotating(*harmonic),
        }
    }

    /// Records values outside the limits. `place`: that of the load in its list; `largest_speed`: of the spindle [rad/s].
    pub(crate) fn check(&self, place: usize, largest_speed: f64, faults: &mut Faults) {
        match self {
            Self::Along(direction, course) => {
                let name = |force, moment| if direction.is_moment() { moment } else { force };
                match course {
                    LoadCourse::Constant(load) => {
                        faults.check(name("operation.loads.constant", "operation.loads.constant_moment"), *load);
                    }
                    LoadCourse::Points(points) => {
                        check_points(points, place, faults);
                        for &(time, load) in points.iter().take(MOST_POINTS) {
                            faults.check("operation.loads.points.at", time);
                            faults.check(name("operation.loads.points.force", "operation.loads.points.moment"), load);
                        }
                    }
                    LoadCourse::Harmonic(harmonic) => {
                        let amplitude =
                            name("operation.loads.harmonic.amplitude", "operation.loads.harmonic.moment_amplitude");
                        faults.check(amplitude, harmonic.amplitude);
                        harmonic.check(OF_HARMONIC, place, largest_speed, faults);
                    }
                    LoadCourse::Shock(Shock { peak, at, duration }) => {
                        faults.check(name("operation.loads.shock.peak", "operation.loads.shock.moment_peak"), *peak);
                        faults.check("operation.loads.shock.at", *at);
                        faults.check("operation.loads.shock.duration", *duration);
                    }
                    LoadCourse::Samples(samples) => {
                        faults
                            .check(name("operation.loads.series", "operation.loads.series_moment"), samples.largest());
                    }
                }
            }
            Self::Rotating(harmonic) => {
                faults.check("operation.loads.rotating.amplitude", harmonic.amplitude);
                harmonic.check(OF_ROTATING, place, largest_speed, faults);
            }
        }
    }

    /// The first fault of the load that `check` finds.
    pub fn faults(&self, place: usize, largest_speed: f64) -> Vec<InvalidParameter> {
        let mut faults = Faults::default();
        self.check(place, largest_speed, &mut faults);
        faults.or(|| ()).err().unwrap_or_default()
    }

    /// The harmonic part, if it is one.
    pub fn harmonic(&self) -> Option<&Harmonic> {
        match self {
            Self::Along(_, LoadCourse::Harmonic(harmonic)) | Self::Rotating(harmonic) => Some(harmonic),
            Self::Along(..) => None,
        }
    }

    /// Adds the load at the start.
    fn add_start(&self, sum: &mut SpindleLoad) {
        if let Self::Along(direction, course) = self {
            sum[*direction as usize] += course.at_start();
        }
    }

    /// Adds the largest differences from the load at the start.
    fn add_largest_change(&self, sum: &mut SpindleLoad) {
        match self {
            Self::Along(direction, course) => sum[*direction as usize] += course.largest_change(),
            Self::Rotating(harmonic) => [1, 2].into_iter().for_each(|axis| sum[axis] += harmonic.amplitude),
        }
    }

    /// Time of the last change [s]; `None`: the load is constant or periodic.
    pub fn end(&self) -> Option<f64> {
        match self {
            Self::Along(_, LoadCourse::Points(points)) if self.is_varying() => points.last().map(|point| point.0),
            Self::Along(_, LoadCourse::Shock(shock)) => Some(shock.at + shock.duration),
            Self::Along(_, LoadCourse::Samples(samples)) if self.is_varying() => Some(samples.end()),
            _ => None,
        }
    }

    /// Longest step that resolves a harmonic load or a series [s]; `None` for others.
    fn longest_step(&self, largest_speed: f64) -> Option<f64> {
        match self {
            Self::Along(_, LoadCourse::Samples(samples)) => Some(1.0 / samples.rate()),
            other => other.harmonic().map(|harmonic| 1.0 / (STEPS_PER_PERIOD * harmonic.frequency(largest_speed))),
        }
    }

    /// The direction; `None`: it turns.
    pub fn direction(&self) -> Option<LoadDirection> {
        match self {
            Self::Along(direction, _) => Some(*direction),
            Self::Rotating(_) => None,
        }
    }

    /// The shock, if it is one.
    pub fn shock(&self) -> Option<&Shock> {
        match self {
            Self::Along(_, LoadCourse::Shock(shock)) => Some(shock),
            _ => None,
        }
    }

    fn is_varying(&self) -> bool {
        let mut change = SpindleLoad::default();
        self.add_largest_change(&mut change);
        change != SpindleLoad::default()
    }
}

fn check_points(points: &[(f64, f64)], place: usize, faults: &mut Faults) {
    let mut refuse = |reason| faults.inconsistent_item("operation.loads.points", &[place], reason);
    if points.is_empty() || points.len() > MOST_POINTS {
        refuse(format!("{} points; 1 to {MOST_POINTS}", points.len()));
    }
    if let Some(pair) = points.windows(2).find(|pair| pair[1].0 < pair[0].0 + SHORTEST_RAMP) {
        refuse(format!("times must rise by at least 1 ns: {} s is followed by {} s", pair[0].0, pair[1].0));
    }
}

/// Parameters of the rate and phase of a harmonic and of a rotating load.
const OF_HARMONIC: [&str; 3] =
    ["operation.loads.harmonic.frequency", "operation.loads.harmonic.order", "operation.loads.harmonic.phase"];
const OF_ROTATING: [&str; 3] =
    ["operation.loads.rotating.frequency", "operation.loads.rotating.order", "operation.loads.rotating.phase"];

impl Harmonic {
    fn check(&self, of: [&'static str; 3], place: usize, largest_speed: f64, faults: &mut Faults) {
        let [frequency, order, phase] = of;
        faults.check(phase, self.phase);
        let (parameter, value) = match self.rate {
            LoadRate::Frequency(value) => (frequency, value),
            LoadRate::Order(value) => (order, value),
        };
        if !faults.check(parameter, value) {
            return;
        }
        let at_largest = self.frequency(largest_speed);
        if at_largest == 0.0 {
            let reason = "an order needs a spindle that turns; at rest give frequency_hz or a constant load".to_owned();
            faults.inconsistent_item(parameter, &[place], reason);
        } else if at_largest > HIGHEST_FREQUENCY {
            let reason =
                format!("order {value} is {at_largest:.0} Hz at the largest speed: at most {HIGHEST_FREQUENCY:.0} Hz");
            faults.inconsistent_item(parameter, &[place], reason);
        }
    }
}

/// The loads at the start of a run, and the largest differences from them.
pub fn start_and_largest_change(loads: &[Load]) -> (SpindleLoad, SpindleLoad) {
    let (mut start, mut change) = (SpindleLoad::default(), SpindleLoad::default());
    for load in loads {
        load.add_start(&mut start);
        load.add_largest_change(&mut change);
    }
    (start, change)
}

/// Time of the last change of loads that are neither constant nor periodic [s]; `None`: there are none.
pub fn end_of_transients(loads: &[Load]) -> Option<f64> {
    loads.iter().filter_map(Load::end).reduce(f64::max)
}

/// Changes of the loads since the start of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct VaryingLoads {
    /// Loads along one direction, less their start.
    along: Vec<(LoadDirection, LoadCourse, f64)>,
    rotating: Vec<Harmonic>,
    /// Longest step that resolves every harmonic load and every series [s].
    steady_step: f64,
    /// Largest changes.
    pub largest: SpindleLoad,
}

impl VaryingLoads {
    /// `None` where no load varies. `largest_speed`: of the spindle [rad/s].
    pub fn of(loads: &[Load], largest_speed: f64) -> Option<Self> {
        let (_, largest) = start_and_largest_change(loads);
        let mut varying = Self { along: Vec::new(), rotating: Vec::new(), steady_step: f64::INFINITY, largest };
        for load in loads.iter().filter(|load| load.is_varying()) {
            match load {
                Load::Along(direction, course) => varying.along.push((*direction, course.clone(), course.at_start())),
                Load::Rotating(harmonic) => varying.rotating.push(*harmonic),
            }
            if let Some(step) = load.longest_step(largest_speed) {
                varying.steady_step = varying.steady_step.min(step);
            }
        }
        (!varying.along.is_empty() || !varying.rotating.is_empty()).then_some(varying)
    }

    /// The changes at a time [s] and an angle of the spindle [rad].
    #[inline(never)]
    pub fn at(&self, time: f64, angle: f64) -> SpindleLoad {
        let mut sum = SpindleLoad::default();
        for (direction, course, start) in &self.along {
            sum[*direction as usize] += course.at(time, angle) - start;
        }
        for harmonic in &self.rotating {
            let (sine, cosine) = sin_cos(harmonic.argument(time, angle));
            sum[1] += harmonic.amplitude * cosine;
            sum[2] += harmonic.amplitude * sine;
        }
        sum
    }

    /// Times at which the slope of a load jumps [s], in no order.
    pub fn kinks(&self) -> impl Iterator<Item = f64> + '_ {
        self.along.iter().flat_map(|(_, course, _)| match course {
            LoadCourse::Points(points) => points.iter().map(|point| point.0).collect(),
            LoadCourse::Shock(Shock { at, duration, .. }) => vec![*at, at + duration],
            LoadCourse::Samples(samples) => vec![samples.end()],
            LoadCourse::Constant(_) | LoadCourse::Harmonic(_) => Vec::new(),
        })
    }

    /// Longest step of fixed length that resolves every load [s].
    pub fn longest_fixed_step(&self) -> f64 {
        self.shocks().map(Shock::longest_step).fold(self.steady_step, f64::min)
    }

    /// Longest step that resolves the loads from a time on [s]. Steps end where a shock begins.
    pub fn longest_step_from(&self, time: f64) -> f64 {
        let is_on = |shock: &&Shock| time >= shock.at && time < shock.at + shock.duration;
        self.shocks().filter(is_on).map(Shock::longest_step).fold(self.steady_step, f64::min)
    }

    /// True where a load neither is constant nor repeats.
    pub fn has_transients(&self) -> bool {
        self.along.iter().any(|(_, course, _)| !matches!(course, LoadCourse::Harmonic(_)))
    }

    fn shocks(&self) -> impl Iterator<Item = &Shock> {
        self.along.iter().filter_map(|(_, course, _)| match course {
            LoadCourse::Shock(shock) => Some(shock),
            _ => None,
        })
    }
}

impl Shock {
    fn longest_step(&self) -> f64 {
        2.0 * self.duration / STEPS_PER_PERIOD
    }
}

#[cfg(test)]
mod tests;
