//! Turns of the shaft, and of cage and ball of each bearing, at each recorded value, and the orders that they make.

use super::angle::ShaftAngle;
use super::settings::Reference;
use crate::physics::bearing::Bearing;
use crate::physics::kinematics::ideal_frequencies;

/// Rotation of one body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Rotation {
    /// Turns since the first recorded value.
    pub turns: f64,
    /// Speed [Hz].
    pub speed: f64,
}

/// Rotations at one recorded value: forward where the body turns as expected of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rotations {
    /// Time since the start of the run [s].
    pub time: f64,
    pub shaft: Rotation,
    pub bearings: Vec<BearingRotations>,
}

/// Rotations in a bearing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BearingRotations {
    pub cage: Rotation,
    /// Spin of the ball about its own axis, as seen from the cage.
    pub ball: Rotation,
}

/// Simulated speeds in a bearing [Hz]; `None`: the balls roll ideally.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SimulatedSpeeds {
    pub cage: Option<f64>,
    pub ball: Option<f64>,
}

impl Rotations {
    pub fn of(&self, reference: Reference) -> Rotation {
        match reference {
            Reference::Shaft => self.shaft,
            Reference::Cage => self.bearings.first().map_or_else(Rotation::default, |bearing| bearing.cage),
        }
    }
}

/// Turns in a sum of turns of the shaft, and of cage and ball of a bearing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Combination {
    pub shaft: f64,
    pub cage: f64,
    pub ball: f64,
    /// Number of the bearing.
    pub bearing: usize,
}

impl Combination {
    /// Turns at a recorded value.
    pub fn turns(&self, at: &Rotations) -> f64 {
        let of_shaft = self.shaft * at.shaft.turns;
        match at.bearings.get(self.bearing) {
            Some(BearingRotations { cage, ball }) => of_shaft + self.cage * cage.turns + self.ball * ball.turns,
            None => of_shaft,
        }
    }

    /// Ratio to the shaft's speed for these ratios of the bearings [-].
    pub fn ratio(&self, ratios: &[Ratios]) -> f64 {
        let of_bearing = ratios.get(self.bearing).map_or(0.0, |of| self.cage * of.cage + self.ball * of.ball);
        self.shaft + of_bearing
    }
}

/// Ratios of speeds to that of the shaft where the balls roll ideally [-].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratios {
    pub cage: f64,
    pub ball: f64,
    /// Passages of balls over a point of the inner raceway.
    pub ball_pass_inner: f64,
}

impl Ratios {
    pub fn of(bearing: &Bearing) -> Self {
        let ideal = ideal_frequencies(bearing, std::f64::consts::TAU);
        Self { cage: ideal.cage, ball: ideal.ball_spin, ball_pass_inner: ideal.ball_pass_inner }
    }

    /// Ratio of the reference's speed to that of the shaft [-].
    pub fn of_reference(&self, reference: Reference) -> f64 {
        match reference {
            Reference::Shaft => 1.0,
            Reference::Cage => self.cage,
        }
    }
}

/// Rotations value by value. Simulated speeds of cage and ball are integrated by the trapezoidal rule.
#[derive(Debug, Clone)]
pub struct RotationCourse {
    angle: ShaftAngle,
    /// Of each bearing.
    ratios: Vec<Ratios>,
    /// Time of the first value and time between values [s].
    start: f64,
    step: f64,
    passed: usize,
    last: Rotations,
}

impl RotationCourse {
    pub fn new(angle: ShaftAngle, ratios: Vec<Ratios>, start: f64, step: f64) -> Self {
        let bearings = vec![BearingRotations::default(); ratios.len()];
        Self { angle, ratios, start, step, passed: 0, last: Rotations { bearings, ..Rotations::default() } }
    }

    pub fn angle(&self) -> &ShaftAngle {
        &self.angle
    }

    /// Time between values [s].
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Rotations at the last value.
    pub fn last(&self) -> &Rotations {
        &self.last
    }

    /// Rotations at the next value, from the simulated speeds in each bearing.
    pub fn next(&mut self, simulated: &[SimulatedSpeeds]) -> &Rotations {
        let time = self.start + self.passed as f64 * self.step;
        let (turns, speed) = (self.angle.turns(time), self.angle.speed(time));
        let ideal = |ratio: f64| Rotation { turns: ratio * turns, speed: ratio * speed };
        let elapsed = if self.passed > 0 { self.step } else { 0.0 };
        // A ball turns against the shaft.
        let forward = self.angle.direction();
        (self.last.time, self.last.shaft) = (time, Rotation { turns, speed });
        for ((of, ratios), now) in self.last.bearings.iter_mut().zip(&self.ratios).zip(simulated) {
            of.cage = now.cage.map_or(ideal(ratios.cage), |cage| of.cage.advanced(forward * cage, elapsed));
            of.ball = now.ball.map_or(ideal(ratios.ball), |ball| of.ball.advanced(-forward * ball, elapsed));
        }
        self.passed += 1;
        &self.last
    }
}

impl Rotation {
    /// The rotation after a time [s], at a speed [Hz].
    fn advanced(self, speed: f64, elapsed: f64) -> Self {
        Self { turns: self.turns + 0.5 * (self.speed + speed) * elapsed, speed }
    }
}
