//! The order analysis of a signal: mean order spectrum, and tracks of orders over speed.

use super::rotations::{Combination, RotationCourse, SimulatedSpeeds};
use super::settings::OrderSettings;
use super::track::{OrderTracker, TrackPoint, beating};
use super::waterfall::{OrderRows, Row};
use crate::numerics::spectrum::Spectrum;

/// A value of the analysed signal, with the simulated speeds in each bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value<'a> {
    pub signal: f64,
    pub bearings: &'a [SimulatedSpeeds],
}

/// Result of an order analysis.
#[derive(Debug, Clone, PartialEq)]
pub struct Orders {
    /// Turns of the reference.
    pub turns: f64,
    /// Root of the mean power of all blocks; its resolution is in orders. `None` where no block is complete.
    pub spectrum: Option<Spectrum>,
    /// Mean order of each track: turns in a turn of the reference.
    pub orders: Vec<f64>,
    /// Pairs of tracks that beat.
    pub beating: Vec<(usize, usize)>,
    pub points: Vec<TrackPoint>,
}

/// Analysis that takes a signal value by value.
#[derive(Debug, Clone)]
pub struct OrderAnalysis {
    settings: OrderSettings,
    course: RotationCourse,
    orders: Vec<Combination>,
    rows: OrderRows,
    tracker: OrderTracker,
    spectrum: Option<Spectrum>,
    points: Vec<TrackPoint>,
}

impl OrderAnalysis {
    pub fn new(settings: OrderSettings, course: RotationCourse, orders: Vec<Combination>) -> Self {
        Self {
            rows: OrderRows::new(settings),
            tracker: OrderTracker::new(settings, orders.clone()),
            settings,
            course,
            orders,
            spectrum: None,
            points: Vec::new(),
        }
    }

    pub fn push(&mut self, value: Value<'_>) {
        let step = self.course.step();
        let at = self.course.next(value.bearings);
        let (spectrum, points) = (&mut self.spectrum, &mut self.points);
        self.rows.push(at, step, value.signal, |row| join(spectrum, row));
        self.tracker.push(at, step, value.signal, |point| points.push(point));
    }

    pub fn finish(self) -> Orders {
        let mut spectrum = self.spectrum;
        self.rows.finish(|row| join(&mut spectrum, row));
        let last = self.course.last();
        let turns = last.of(self.settings.reference).turns;
        let orders: Vec<f64> = self.orders.iter().map(|order| order.turns(last) / turns).collect();
        let beating = beating(&orders, self.settings.turns_per_block);
        Orders { turns, spectrum, orders, beating, points: self.points }
    }
}

fn join(mean: &mut Option<Spectrum>, row: Row) {
    match mean {
        Some(mean) => mean.join(&row.spectrum),
        None => *mean = Some(row.spectrum),
    }
}
