//! Channels that a run can record, by name.

/// A direction of the inertial frame: X along the bearing axis, Y down the load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Axis {
    X,
    Y,
    Z,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Motion {
    Displacement,
    Velocity,
    Acceleration,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BallContact {
    Inner,
    Outer,
    Pocket,
}

/// A signal. Balls count from 0 here and from 1 in names; ball 0 starts at azimuth 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Channel {
    Spindle(Axis, Motion),
    /// Tilt about Y or the new Z.
    SpindleTilt(Axis),
    CageDisplacement(Axis),
    CageSpeed,
    BallSpin(usize),
    BallLoad(usize, BallContact),
}

impl Channel {
    /// The acceleration of the spindle along the same axis; `None` for channels of other bodies.
    pub fn acceleration(&self) -> Option<Self> {
        match self {
            Self::Spindle(axis, _) => Some(Self::Spindle(*axis, Motion::Acceleration)),
            _ => None,
        }
    }

    /// The channel of that name in a bearing of `ball_count` balls, or `None`.
    pub fn parse(name: &str, ball_count: usize) -> Option<Self> {
        let mut parts = name.split('.');
        let channel = match (parts.next()?, parts.next()?, parts.next()) {
            ("spindle", "tilt", Some(axis)) => match parse_axis(axis)? {
                Axis::X => return None,
                axis => Self::SpindleTilt(axis),
            },
            ("spindle", axis, Some(motion)) => {
                let motion = match motion {
                    "displacement" => Motion::Displacement,
                    "velocity" => Motion::Velocity,
                    "acceleration" => Motion::Acceleration,
                    _ => return None,
                };
                Self::Spindle(parse_axis(axis)?, motion)
            }
            ("cage", "speed", None) => Self::CageSpeed,
            ("cage", axis, Some("displacement")) => Self::CageDisplacement(parse_axis(axis)?),
            ("ball", number, Some(rest)) => {
                // Digits only and no leading zero, so that a channel has one name.
                if number.starts_with('0') || !number.bytes().all(|byte| byte.is_ascii_digit()) {
                    return None;
                }
                let ball = number.parse::<usize>().ok().filter(|ball| (1..=ball_count).contains(ball))? - 1;
                match (rest, parts.next()) {
                    ("spin", None) => Self::BallSpin(ball),
                    ("inner", Some("load")) => Self::BallLoad(ball, BallContact::Inner),
                    ("outer", Some("load")) => Self::BallLoad(ball, BallContact::Outer),
                    ("pocket", Some("load")) => Self::BallLoad(ball, BallContact::Pocket),
                    _ => return None,
                }
            }
            _ => return None,
        };
        parts.next().is_none().then_some(channel)
    }

    /// The unit in which results show this channel.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Spindle(_, Motion::Displacement) | Self::CageDisplacement(_) => "µm",
            Self::SpindleTilt(_) => "mrad",
            Self::Spindle(_, Motion::Velocity) => "mm/s",
            Self::Spindle(_, Motion::Acceleration) => "m/s²",
            Self::CageSpeed | Self::BallSpin(_) => "Hz",
            Self::BallLoad(..) => "N",
        }
    }

    /// Factor from SI (spin and speed: rad/s) to `unit()`.
    pub fn scale(self) -> f64 {
        match self {
            Self::Spindle(_, Motion::Displacement) | Self::CageDisplacement(_) => 1e6,
            Self::Spindle(_, Motion::Velocity) | Self::SpindleTilt(_) => 1e3,
            Self::Spindle(_, Motion::Acceleration) | Self::BallLoad(..) => 1.0,
            Self::CageSpeed | Self::BallSpin(_) => 0.5 / std::f64::consts::PI,
        }
    }
}

fn parse_axis(text: &str) -> Option<Axis> {
    match text {
        "x" => Some(Axis::X),
        "y" => Some(Axis::Y),
        "z" => Some(Axis::Z),
        _ => None,
    }
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        })
    }
}

impl std::fmt::Display for Channel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Spindle(axis, Motion::Displacement) => write!(f, "spindle.{axis}.displacement"),
            Self::Spindle(axis, Motion::Velocity) => write!(f, "spindle.{axis}.velocity"),
            Self::Spindle(axis, Motion::Acceleration) => write!(f, "spindle.{axis}.acceleration"),
            Self::SpindleTilt(axis) => write!(f, "spindle.tilt.{axis}"),
            Self::CageDisplacement(axis) => write!(f, "cage.{axis}.displacement"),
            Self::CageSpeed => write!(f, "cage.speed"),
            Self::BallSpin(ball) => write!(f, "ball.{}.spin", ball + 1),
            Self::BallLoad(ball, contact) => {
                let contact = match contact {
                    BallContact::Inner => "inner",
                    BallContact::Outer => "outer",
                    BallContact::Pocket => "pocket",
                };
                write!(f, "ball.{}.{contact}.load", ball + 1)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_parses_to_the_channel_that_prints_it() {
        for name in [
            "spindle.x.displacement",
            "spindle.y.velocity",
            "spindle.z.acceleration",
            "spindle.tilt.y",
            "cage.y.displacement",
            "cage.speed",
            "ball.1.spin",
            "ball.7.inner.load",
            "ball.3.outer.load",
            "ball.2.pocket.load",
        ] {
            assert_eq!(Channel::parse(name, 7).map(|channel| channel.to_string()).as_deref(), Some(name));
        }
        for name in [
            "",
            "spindle",
            "spindle.y",
            "spindle.w.velocity",
            "spindle.tilt.x",
            "ball.0.spin",
            "ball.8.spin",
            "ball.01.spin",
            "ball.+1.spin",
            "cage.speed.x",
            "ball.1.spin.load",
            "spindle.y.velocity.",
        ] {
            assert_eq!(Channel::parse(name, 7), None, "{name}");
        }
    }
}
