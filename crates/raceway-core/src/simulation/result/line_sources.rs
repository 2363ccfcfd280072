//! Terms by which the lines of a spectrum are named: frequencies of shaft, cage, balls, raceways and loads.

use std::f64::consts::TAU;

use crate::physics::kinematics::CharacteristicFrequencies;

/// Labels of the rotation of shaft, cage and outer ring.
pub(super) const SHAFT: &str = "f_r";
pub(super) const CAGE: &str = "FTF";
pub(super) const OUTER_RING: &str = "f_o";
/// Labels of the ball passages of the raceways.
pub(super) const INNER: &str = "BPFI";
pub(super) const OUTER: &str = "BPFO";
/// Label of the spin of a ball.
pub(super) const BALL: &str = "BSF";
/// Label of a harmonic load.
pub(super) const LOAD: &str = "load";
/// Labels of whirl.
pub(super) const CAGE_WHIRL: &str = "cage whirl";
pub(super) const SPINDLE_WHIRL: &str = "spindle whirl";
/// Cost over complexity of terms that a surface of the scene drives; of others it is 1.
const DRIVEN_SHARE: f64 = 0.5;

/// Frequencies [Hz] that name the lines of a spectrum; 0 for one that cannot appear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineSources<'a> {
    /// At the simulated speeds of cage and balls.
    pub frequencies: CharacteristicFrequencies,
    /// Mean rate at which the centre of the cage orbits its mean position.
    pub cage_whirl: f64,
    /// Mean rate at which the centre of the spindle orbits its mean position.
    pub spindle_whirl: f64,
    /// The inner raceway has waves or defects. They turn through the load, so that their lines have several sidebands of the shaft.
    pub uneven_inner: bool,
    /// Orders of the given waves of the inner raceway.
    pub inner_orders: &'a [i32],
    /// The outer ring turns. Balls then pass the load and the outer raceway at different rates, and a defect of it turns through the load if it
    /// has one.
    pub outer_ring: OuterRing,
    /// A raceway has waves or defects.
    pub uneven_raceways: bool,
    /// A ball has odd orders of its spin, too: it has a defect, which the raceways feel differently, or waves that others do not have.
    pub odd_ball_orders: bool,
    /// Balls or pockets differ. Their pattern turns with the cage, so that its sidebands stand beside every ball passage.
    pub unequal_balls: bool,
    /// Frequencies of harmonic loads.
    pub loads: &'a [f64],
}

impl<'a> LineSources<'a> {
    /// Of a shaft without bearings at a speed [rad/s], and harmonic loads [Hz].
    pub(crate) fn of_shaft(speed: f64, loads: &'a [f64]) -> Self {
        Self {
            frequencies: CharacteristicFrequencies { shaft: speed.abs() / TAU, ..CharacteristicFrequencies::default() },
            cage_whirl: 0.0,
            spindle_whirl: 0.0,
            uneven_inner: false,
            inner_orders: &[],
            outer_ring: OuterRing::Stands,
            uneven_raceways: false,
            odd_ball_orders: false,
            unequal_balls: false,
            loads,
        }
    }
}

/// Motion of the outer ring, as lines show it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OuterRing {
    Stands,
    Turns { is_uneven: bool },
}

impl LineSources<'_> {
    pub(super) fn outer_turns(&self) -> bool {
        self.outer_ring != OuterRing::Stands
    }

    /// Returns true for the passage of the balls under the load.
    pub(super) fn is_passage(&self, term: &Term) -> bool {
        if self.outer_turns() { term.name == CAGE && term.unit > 1 } else { term.name == OUTER }
    }
}

/// One term `order · name` of a combination.
#[derive(Debug, Clone, Copy)]
pub(super) struct Term {
    pub name: &'static str,
    pub frequency: f64,
    /// Cost of the first order.
    pub weight: f64,
    pub order: i32,
    /// Order of the name in the first order of the term.
    pub unit: i32,
    /// A surface of the scene drives it.
    pub driven: bool,
}

impl Term {
    /// A term of a frequency [Hz] with the cost of its first order.
    pub fn new(name: &'static str, frequency: f64, weight: f64) -> Self {
        Self { name, frequency, weight, order: 0, unit: 1, driven: false }
    }

    pub fn times(self, order: i32) -> Self {
        Self { order, ..self }
    }

    pub fn driven(self, driven: bool) -> Self {
        Self { driven, ..self }
    }

    /// Grows slowly with the order, so that a high harmonic is simpler than a sideband of sidebands.
    pub fn complexity(&self) -> f64 {
        if self.order == 0 { 0.0 } else { self.weight * (1.0 + f64::from(self.order.abs()).ln()) }
    }

    pub fn cost(&self) -> f64 {
        let share = if self.driven { DRIVEN_SHARE } else { 1.0 };
        share * self.complexity()
    }

    /// Its order times its frequency [Hz].
    pub fn at(&self) -> f64 {
        f64::from(self.order) * self.frequency
    }
}
