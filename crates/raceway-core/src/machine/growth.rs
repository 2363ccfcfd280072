//! Motions that grow by themselves, by the linear analysis.

use super::equations::MachineDynamics;
use super::input::{Machine, MachineError};
use crate::numerics::roots::bracketed_root;
use crate::physics::operation::SpeedProfile;
use crate::rotor::input::{Rotor, RotorBearing};
use crate::rotor::system::System;

/// Largest rise of a level by growth [dB].
const ALLOWED_DB: f64 = 0.1;
/// Speeds of a run-up at which growth is looked for, and times between which its speed is taken as constant.
const SPEEDS: usize = 17;
const TIMES: usize = 1000;

/// Refuses motions that grow so much that levels depend on the recorded time, or on the time that a run-up takes.
pub(super) fn check_growth(
    machine: &Machine,
    dynamics: &MachineDynamics,
    settle: f64,
    duration: f64,
) -> Result<(), MachineError> {
    let found = match dynamics.speed.is_constant() {
        true => at_constant_speed(dynamics, duration),
        false => over_run_up(machine, dynamics, settle + duration),
    };
    let Some(Growth { efolds, rate, speeds }) = found else { return Ok(()) };
    if 20.0 * std::f64::consts::LOG10_E * efolds <= ALLOWED_DB {
        return Ok(());
    }
    if grows_by_rotating_damping(machine, dynamics, speeds[1]) {
        let cause = "damping that turns with the shaft drives its whirl (`shaft.rotating_share`)";
        let over = |speeds| GrowthRates::over(machine, dynamics, speeds);
        let decays_below = over((0.0, speeds[0])).and_then(|rates| rates.threshold());
        return Err(MachineError::Grows { rate, speeds, cause, decays_below });
    }
    let of_seats = [dynamics.outer_speed.at(0.0).1; 2];
    let (speeds, cause) = if machine.rotor.bearings.iter().any(RotorBearing::turns_in_own_seat) {
        (of_seats, "damping of a seat that turns with its ring drives a whirl (`operation.outer_speed_rpm`)")
    } else if machine.rotor.supports.is_empty() {
        (speeds, "the bearings do not hold it at this speed")
    } else {
        (speeds, "a support pushes it (`supports`)")
    };
    Err(MachineError::Grows { rate, speeds, cause, decays_below: None })
}

/// True where nothing grows at a speed [rad/s] if the damping of the shaft does not turn.
fn grows_by_rotating_damping(machine: &Machine, dynamics: &MachineDynamics, speed: f64) -> bool {
    if machine.rotor.shaft.rotating_share == 0.0 {
        return false;
    }
    let mut rotor = machine.rotor.clone();
    rotor.shaft.rotating_share = 0.0;
    let rate = system_over(&rotor, dynamics, &[speed]).and_then(|system| system.growth_rate(speed).ok());
    rate.is_some_and(|rate| rate <= 0.0)
}

/// Shaft and housing with the coordinates of a run, its bearings in equilibrium at speeds [rad/s].
fn system_over(rotor: &Rotor, dynamics: &MachineDynamics, speeds: &[f64]) -> Option<System> {
    let coordinates = &dynamics.frame.system.coordinates;
    let count = coordinates.frequencies().iter().filter(|frequency| **frequency > 0.0).count();
    System::of(rotor, coordinates.mesh.clone(), count, speeds).ok()
}

/// Growth over a time.
struct Growth {
    efolds: f64,
    /// Largest rate [1/s].
    rate: f64,
    /// The lowest and the highest speed at which a motion grows [rad/s].
    speeds: [f64; 2],
}

/// `None` where the motion is not linear, because a bearing is loose.
fn at_constant_speed(dynamics: &MachineDynamics, duration: f64) -> Option<Growth> {
    let speed = dynamics.speed.at(0.0).1;
    let rate = dynamics.free_motion.as_ref()?.growth_rate;
    Some(Growth { efolds: rate * duration, rate, speeds: [speed; 2] })
}

/// Growth up to a time [s], each speed taken as constant; `None` where nothing grows, or where the motion is not linear.
fn over_run_up(machine: &Machine, dynamics: &MachineDynamics, end: f64) -> Option<Growth> {
    let course = GrowthRates::over(machine, dynamics, range(&dynamics.speed))?;
    let step = end / TIMES as f64;
    let at = |time: usize| dynamics.speed.at((time as f64 + 0.5) * step).1.abs();
    let growing = (0..TIMES).map(at).map(|speed| (course.at(speed), speed)).filter(|(rate, _)| *rate > 0.0);
    growing.fold(None, |sum: Option<Growth>, (rate, speed)| {
        let sum = sum.unwrap_or(Growth { efolds: 0.0, rate, speeds: [speed; 2] });
        Some(Growth {
            efolds: sum.efolds + rate * step,
            rate: sum.rate.max(rate),
            speeds: [sum.speeds[0].min(speed), sum.speeds[1].max(speed)],
        })
    })
}

/// Growth rates over speed, between which they are interpolated.
struct GrowthRates {
    first: f64,
    step: f64,
    rates: Vec<f64>,
    system: System,
}

impl GrowthRates {
    fn over(machine: &Machine, dynamics: &MachineDynamics, (first, last): (f64, f64)) -> Option<Self> {
        let step = (last - first) / (SPEEDS - 1) as f64;
        let speeds: Vec<f64> = (0..SPEEDS).map(|k| first + k as f64 * step).collect();
        let system = system_over(&machine.rotor, dynamics, &speeds)?;
        let rates = speeds.iter().map(|speed| system.growth_rate(*speed).ok()).collect::<Option<_>>()?;
        Some(Self { first, step, rates, system })
    }

    /// The speed from which on a motion grows up to the last speed [rad/s]; `None` where none decays.
    fn threshold(&self) -> Option<f64> {
        let decaying = self.rates.iter().rposition(|rate| *rate <= 0.0)?;
        let low = self.first + decaying as f64 * self.step;
        let rate = |speed: f64| self.system.growth_rate(speed).unwrap_or(f64::NAN);
        Some(bracketed_root(rate, low, low + self.step)).filter(|speed| speed.is_finite())
    }

    fn at(&self, speed: f64) -> f64 {
        let place = ((speed - self.first) / self.step).clamp(0.0, (SPEEDS - 1) as f64);
        let before = (place as usize).min(SPEEDS - 2);
        let share = place - before as f64;
        (1.0 - share) * self.rates[before] + share * self.rates[before + 1]
    }
}

/// Least and largest magnitude of the speed [rad/s].
fn range(profile: &SpeedProfile) -> (f64, f64) {
    let least = profile.points().iter().fold(profile.largest(), |least, point| least.min(point.1.abs()));
    (if profile.reverses() { 0.0 } else { least }, profile.largest())
}
