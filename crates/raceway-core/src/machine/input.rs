//! Input of a machine: a shaft, its bearings with all that moves in them, and sensors.

use std::f64::consts::TAU;

use super::inapplicable::MachineInapplicable;
use super::terms::SystemTerms;
use crate::physics::operation::SpeedProfile;
use crate::physics::statics::MAX_RELATIVE_DEPTH;
use crate::rotor::input::{Rotor, RotorError};
use crate::rotor::omission::SystemTerm;
pub use crate::rotor::sensor::{Part, Sensor};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::model::failure::{Departure, SimulationError};

/// Shortest step that is tried, where the request selects none [s].
pub(super) const SHORTEST_STEP: f64 = 2.5e-7;

/// A shaft on ball bearings, and the points at which its motion is recorded.
#[derive(Debug, Clone)]
pub struct Machine {
    /// Shaft, supports, loads, and the place of each bearing. Its speed is the first of `speed`.
    pub rotor: Rotor,
    /// Balls, cage, lubricant and surfaces of each bearing of the rotor, in their order.
    pub bearings: Vec<MachineBearing>,
    pub speed: SpeedProfile,
    /// Speed of every outer ring.
    pub outer_speed: SpeedProfile,
    pub sensors: Vec<Sensor>,
    /// Names of the parts of the rotor's housing, in their order.
    pub bodies: Vec<String>,
    pub terms: SystemTerms,
    /// The rotor with all its terms, where `rotor` is without those that are off.
    pub complete: Option<Box<Rotor>>,
}

impl Machine {
    /// The machine of a run that ends at a time [s]: later points of speeds and loads do not count.
    pub fn until(mut self, end: f64) -> Self {
        (self.speed, self.outer_speed) = (self.speed.until(end), self.outer_speed.until(end));
        for placed in &mut self.rotor.loads {
            placed.load = placed.load.until(end);
        }
        for bearing in &mut self.bearings {
            bearing.scene.operation = bearing.scene.operation.until(end);
        }
        self
    }

    /// The machine without some terms of the system around its bearings.
    pub(super) fn without(mut self, terms: impl Iterator<Item = SystemTerm>) -> Self {
        for term in terms {
            self.rotor = self.rotor.without(term);
            if term == SystemTerm::Housing {
                self.bodies.clear();
            }
        }
        self
    }
}

/// A bearing on the shaft: its name, its balls and cage, and where they start.
#[derive(Debug, Clone)]
pub struct MachineBearing {
    /// Name in channels and labels.
    pub name: String,
    /// The bearing alone. Its spindle and its loads do not count: the shaft replaces them.
    pub scene: Scene,
    /// Azimuth at which its first ball starts [rad].
    pub start_azimuth: f64,
}

/// Reason why a run has no result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MachineError {
    #[error(transparent)]
    Rotor(#[from] RotorError),
    #[error("bearing {bearing}: {source}")]
    Bearing { bearing: String, source: SimulationError },
    /// The selected model level cannot represent the machine.
    #[error("{}: {reason}", .level.name())]
    NotApplicable { level: ModelLevel, reason: MachineInapplicable },
    /// No bearing can hold the motion any more, or steps do not resolve it. `fastest`: the part for which steps may be too long.
    #[error("{}, {cause}. {}", .steps.at(*.time), .steps.remedy(.fastest.as_deref()))]
    Lost { time: f64, cause: Loss, steps: StepsOfLoss, fastest: Option<Box<FastestPart>> },
    /// A motion grows by itself, so that levels would depend on the recorded time. Speeds [rad/s]: the lowest and the highest at which it does,
    /// of the outer rings where their seats drive it; and the speed up to which it decays, where it is known.
    #[error("a motion grows by {rate:.3} 1/s {}: {cause}{}", at_speeds(.speeds), below(*.decays_below))]
    Grows { rate: f64, speeds: [f64; 2], cause: &'static str, decays_below: Option<f64> },
    /// More modes of the shaft lie in the range than a run can carry.
    #[error("the shaft has more than {0} modes in the range; give a lower mode_range")]
    TooManyModes(usize),
    /// The caller no longer wants the result.
    #[error("stopped at t = {0:.6} s")]
    Stopped(f64),
}

/// Reason why a motion goes beyond what a bearing can hold.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Loss {
    #[error("the inner ring has left bearing {bearing}: {departure}")]
    Left { bearing: String, departure: Departure },
    #[error(
        "in bearing {bearing}, {load:.1e} N press a ball into its raceways by {depth:.2} of its radius, and beyond \
         {MAX_RELATIVE_DEPTH} of it there is no raceway left to carry it"
    )]
    TooDeep { bearing: String, load: f64, depth: f64 },
    #[error("balls of bearing {bearing}, which has no cage, collide, which fixed steps do not resolve")]
    Collision { bearing: String },
    #[error("the motion of bearing {bearing} is no longer finite")]
    NotFinite { bearing: String },
    #[error("the motion of shaft and housing is no longer finite")]
    FrameNotFinite,
    #[error("the forces between shaft, bearings and housing are not resolved")]
    Unresolved,
}

impl Loss {
    /// True if shorter steps may resolve the motion.
    pub(super) fn is_of_steps(&self) -> bool {
        matches!(self, Self::NotFinite { .. } | Self::FrameNotFinite | Self::Unresolved)
    }
}

/// The part that the bearings move fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct FastestPart {
    pub name: String,
    /// The kind of inertia that is too small, and the field that holds it.
    pub inertia: &'static str,
    pub field: String,
    /// Natural frequency on the bearings alone [Hz].
    pub frequency: f64,
}

/// Steps in which a motion was lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepsOfLoss {
    /// None: the state that the run starts from.
    AtStart,
    /// The step that the request selected [s].
    Selected(f64),
    /// Every step down to this one [s].
    DownTo(f64),
    /// Steps down to this one, the shortest [s], of which the first failed. The others were not tried: they are unstable by the linear analysis.
    Foreseen(f64),
}

impl StepsOfLoss {
    /// Begin of a sentence about a time [s].
    fn at(&self, time: f64) -> String {
        match self {
            Self::AtStart => "in the equilibrium that the run starts from".to_owned(),
            Self::Selected(step) => format!("at t = {time:.6} s in steps of {:.3} µs", 1e6 * step),
            Self::DownTo(step) => format!("at t = {time:.6} s, in steps down to {:.3} µs", 1e6 * step),
            Self::Foreseen(step) => format!("in steps down to {:.3} µs, by the linear analysis", 1e6 * step),
        }
    }

    fn remedy(&self, fastest: Option<&FastestPart>) -> String {
        let causes = "reduce speed, loads and unbalance, take smoother surfaces, larger bearings or a stiffer shaft";
        let remedy = match fastest {
            Some(FastestPart { name, inertia, field, frequency }) => format!(
                "The bearings move {name} fastest, at {:.0} kHz: give it a larger {inertia} (`{field}`), {causes}",
                1e-3 * frequency
            ),
            None => format!("To hold it, {causes}"),
        };
        match self {
            Self::Selected(step) if *step > SHORTEST_STEP => remedy + ", or leave step_us to the program",
            Self::DownTo(_) if fastest.is_some() => remedy + ", or give a shorter step_us, down to 0.1",
            Self::AtStart | Self::Selected(_) | Self::DownTo(_) | Self::Foreseen(_) => remedy,
        }
    }
}

fn below(speed: Option<f64>) -> String {
    speed.map_or_else(String::new, |speed| {
        format!(". By the linear analysis it decays below {:.0} r/min", 60.0 * speed / TAU)
    })
}

fn at_speeds(speeds: &[f64; 2]) -> String {
    let [from, to] = speeds.map(|speed| 60.0 * speed / TAU);
    if from == to { format!("at {from:.0} r/min") } else { format!("between {from:.0} and {to:.0} r/min") }
}
