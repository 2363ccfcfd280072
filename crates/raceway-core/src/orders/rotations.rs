//! Turns of shaft, cage and ball at each recorded value, and the orders that they make.

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
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Rotations {
    /// Time since the start of the run [s].
    pub time: f64,
    pub shaft: Rotation,
    pub cage: Rotation,
    /// Spin of the ball about its own axis, as seen from the cage.
    pub ball: Rotation,
}

impl Rotations {
    pub fn of(&self, reference: Reference) -> Rotation {
        match reference {
            Reference::Shaft => self.shaft,
            Reference::Cage => self.cage,
        }
    }
}

/// Turns in a sum of turns of shaft, cage and ball.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Combination {
    pub shaft: f64,
    pub cage: f64,
    pub ball: f64,
}

impl Combination {
    /// Turns at a recorded value.
    pub fn turns(&self, at: &Rotations) -> f64 {
        self.shaft * at.shaft.turns + self.cage * at.cage.turns + self.ball * at.ball.turns
    }

    /// Ratio to the shaft's speed for these ratios of cage and ball [-].
    pub fn ratio(&self, ratios: &Ratios) -> f64 {
        self.shaft + self.cage * ratios.cage + self.ball * ratios.ball
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
    ratios: Ratios,
    /// Time of the first value and time between values [s].
    start: f64,
    step: f64,
    passed: usize,
    last: Rotations,
}

impl RotationCourse {
    pub fn new(angle: ShaftAngle, ratios: Ratios, start: f64, step: f64) -> Self {
        Self { angle, ratios, start, step, passed: 0, last: Rotations::default() }
    }

    pub fn angle(&self) -> &ShaftAngle {
        &self.angle
    }

    /// Time between values [s].
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Rotations at the next value, from the simulated speeds of cage and ball [Hz]; `None`: the balls roll ideally.
    pub fn next(&mut self, cage: Option<f64>, ball: Option<f64>) -> Rotations {
        let time = self.start + self.passed as f64 * self.step;
        let (turns, speed) = (self.angle.turns(time), self.angle.speed(time));
        let ideal = |ratio: f64| Rotation { turns: ratio * turns, speed: ratio * speed };
        // A ball turns against the shaft.
        let forward = self.angle.direction();
        let now = Rotations {
            time,
            shaft: Rotation { turns, speed },
            cage: cage.map_or(ideal(self.ratios.cage), |cage| self.advanced(self.last.cage, forward * cage)),
            ball: ball.map_or(ideal(self.ratios.ball), |ball| self.advanced(self.last.ball, -forward * ball)),
        };
        self.passed += 1;
        self.last = now;
        now
    }

    /// The rotation one step later, at a speed [Hz].
    fn advanced(&self, before: Rotation, speed: f64) -> Rotation {
        let turned = if self.passed > 0 { 0.5 * (before.speed + speed) * self.step } else { 0.0 };
        Rotation { turns: before.turns + turned, speed }
    }
}
