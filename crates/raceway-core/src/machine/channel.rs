//! Signals of a machine, by name.

use std::f64::consts::TAU;
use std::fmt;

use super::input::Machine;
use crate::simulation::input::channel::{Axis, BallContact, Channel, Motion};

/// A signal. Bearings, sensors and bodies count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MachineChannel {
    /// Motion of the inner ring of a bearing, along the shaft's axes.
    Ring(usize, Axis, Motion),
    /// Tilt of the inner ring about Y or the new Z.
    Tilt(usize, Axis),
    /// Force of the shaft on a bearing.
    Force(usize, Axis),
    /// Moment of the shaft on a bearing.
    Moment(usize, Axis),
    CageSpeed(usize),
    /// Spin of ball 1 about the axis of its bearing, as seen from the cage.
    BallSpin(usize),
    /// Load of a ball on a raceway, recorded where it is asked for. Balls count from 0 here and from 1 in names.
    BallLoad(usize, usize, BallContact),
    Sensor(usize, Motion),
    /// Of the mass centre of a housing body, or of a port of the housing.
    Body(usize, Axis, Motion),
}

impl MachineChannel {
    /// All signals of a machine but the loads of its balls.
    pub fn all(machine: &Machine) -> Vec<Self> {
        const RADIAL: [Axis; 2] = [Axis::Y, Axis::Z];
        let along: &[Axis] = if machine.rotor.shaft.is_axially_free { &[Axis::X, Axis::Y, Axis::Z] } else { &RADIAL };
        let motions = [Motion::Displacement, Motion::Acceleration];
        let mut channels = Vec::new();
        for bearing in 0..machine.bearings.len() {
            let moved = along.iter().flat_map(|axis| motions.map(|motion| Self::Ring(bearing, *axis, motion)));
            channels.extend(moved.chain(RADIAL.map(|axis| Self::Tilt(bearing, axis))));
            channels.extend(along.iter().map(|axis| Self::Force(bearing, *axis)));
            channels.extend(RADIAL.map(|axis| Self::Moment(bearing, axis)));
            channels.extend([Self::CageSpeed(bearing), Self::BallSpin(bearing)]);
        }
        for body in 0..machine.bodies.len() {
            let moved = [Axis::X, Axis::Y, Axis::Z].into_iter();
            channels.extend(moved.flat_map(|axis| motions.map(|motion| Self::Body(body, axis, motion))));
        }
        let motions = [Motion::Displacement, Motion::Velocity, Motion::Acceleration];
        channels
            .extend((0..machine.sensors.len()).flat_map(|sensor| motions.map(|motion| Self::Sensor(sensor, motion))));
        channels
    }

    /// The acceleration that is shown first: of the first sensor, else of the first bearing or body along y. A machine has one of them.
    pub fn first_acceleration(machine: &Machine) -> Self {
        if !machine.sensors.is_empty() {
            Self::Sensor(0, Motion::Acceleration)
        } else if !machine.bearings.is_empty() {
            Self::Ring(0, Axis::Y, Motion::Acceleration)
        } else {
            Self::Body(0, Axis::Y, Motion::Acceleration)
        }
    }

    /// The signal of that name, or `None`.
    pub fn parse(name: &str, machine: &Machine) -> Option<Self> {
        let is_named = |channel: &Self| channel.named(machine).to_string() == name;
        Self::all(machine).into_iter().find(is_named).or_else(|| Self::ball_load(name, machine))
    }

    /// The load of a ball with a name such as `A.ball.3.inner.load`.
    fn ball_load(name: &str, machine: &Machine) -> Option<Self> {
        let (bearing, channel) = name.split_once('.')?;
        let index = machine.bearings.iter().position(|known| known.name == bearing)?;
        match Channel::parse(channel, machine.bearings[index].scene.bearing.parameters.ball_count)? {
            // One level has no pockets.
            Channel::BallLoad(_, BallContact::Pocket) => None,
            Channel::BallLoad(ball, contact) => Some(Self::BallLoad(index, ball, contact)),
            _ => None,
        }
    }

    /// The name, such as `A.y.acceleration`.
    pub fn named<'a>(&self, machine: &'a Machine) -> Named<'a> {
        Named { channel: *self, machine }
    }

    /// Number of its bearing, sensor or body.
    pub fn source(&self) -> usize {
        match *self {
            Self::Ring(index, ..)
            | Self::Tilt(index, _)
            | Self::Force(index, _)
            | Self::Moment(index, _)
            | Self::CageSpeed(index)
            | Self::BallSpin(index)
            | Self::BallLoad(index, ..)
            | Self::Sensor(index, _)
            | Self::Body(index, ..) => index,
        }
    }

    /// True if it is recorded only where it is asked for.
    pub fn is_of_ball(&self) -> bool {
        matches!(self, Self::BallLoad(..))
    }

    pub fn is_acceleration(&self) -> bool {
        matches!(
            self,
            Self::Ring(_, _, Motion::Acceleration)
                | Self::Sensor(_, Motion::Acceleration)
                | Self::Body(_, _, Motion::Acceleration)
        )
    }

    /// The unit in which results show this signal.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Ring(_, _, motion) | Self::Sensor(_, motion) | Self::Body(_, _, motion) => match motion {
                Motion::Displacement => "µm",
                Motion::Velocity => "mm/s",
                Motion::Acceleration => "m/s²",
            },
            Self::Tilt(..) => "mrad",
            Self::Force(..) | Self::BallLoad(..) => "N",
            Self::Moment(..) => "N m",
            Self::CageSpeed(_) | Self::BallSpin(_) => "Hz",
        }
    }

    /// Factor from SI (speed: rad/s) to `unit()`.
    pub fn scale(&self) -> f64 {
        match self {
            Self::Ring(_, _, motion) | Self::Sensor(_, motion) | Self::Body(_, _, motion) => match motion {
                Motion::Displacement => 1e6,
                Motion::Velocity => 1e3,
                Motion::Acceleration => 1.0,
            },
            Self::Tilt(..) => 1e3,
            Self::Force(..) | Self::Moment(..) | Self::BallLoad(..) => 1.0,
            Self::CageSpeed(_) | Self::BallSpin(_) => 1.0 / TAU,
        }
    }
}

/// A signal with the names of its bearing or sensor.
pub struct Named<'a> {
    channel: MachineChannel,
    machine: &'a Machine,
}

impl fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bearing = |index: usize| &self.machine.bearings[index].name;
        let motion = |motion: Motion| match motion {
            Motion::Displacement => "displacement",
            Motion::Velocity => "velocity",
            Motion::Acceleration => "acceleration",
        };
        match self.channel {
            MachineChannel::Ring(index, axis, of) => write!(f, "{}.{axis}.{}", bearing(index), motion(of)),
            MachineChannel::Tilt(index, axis) => write!(f, "{}.tilt.{axis}", bearing(index)),
            MachineChannel::Force(index, axis) => write!(f, "{}.force.{axis}", bearing(index)),
            MachineChannel::Moment(index, axis) => write!(f, "{}.moment.{axis}", bearing(index)),
            MachineChannel::CageSpeed(index) => write!(f, "{}.cage.speed", bearing(index)),
            MachineChannel::BallSpin(index) => write!(f, "{}.ball.1.spin", bearing(index)),
            MachineChannel::BallLoad(index, ball, contact) => {
                write!(f, "{}.{}", bearing(index), Channel::BallLoad(ball, contact))
            }
            MachineChannel::Body(index, axis, of) => {
                write!(f, "{}.{axis}.{}", self.machine.bodies[index], motion(of))
            }
            MachineChannel::Sensor(index, of) => {
                write!(f, "sensor.{}.{}", self.machine.sensors[index].name, motion(of))
            }
        }
    }
}
