//! Data of a run for an order analysis: the turns of its shaft and the ideal speeds in its bearings.

use raceway_core::machine::input::Machine;
use raceway_core::orders::angle::ShaftAngle;
use raceway_core::orders::rotations::Ratios;
use raceway_core::orders::settings::Reference;
use raceway_core::physics::operation::SpeedProfile;
use raceway_core::simulation::input::channel::Channel;
use raceway_core::simulation::input::scene::{Scene, Term, TermChoice};
use raceway_core::simulation::recording::sampling::RATE;

/// Order in place of BPFI where there is no bearing.
const USUAL_BALL_PASS: f64 = 5.0;

/// Recorded turns of a run, and its bearings.
#[derive(Debug, Clone)]
pub struct RecordedTurns {
    /// `None` where the shaft reverses, or the outer ring turns.
    pub angle: Option<ShaftAngle>,
    pub outer_ring_turns: bool,
    pub bearings: Vec<RecordedBearing>,
}

/// A bearing of a run: its name and the ideal speeds of its balls.
#[derive(Debug, Clone)]
pub struct RecordedBearing {
    /// Name in orders such as `BPFO@A`; `None` where the scene is that of one bearing.
    pub name: Option<String>,
    pub ratios: Ratios,
    pub balls: f64,
    pub has_cage: bool,
}

impl RecordedTurns {
    /// Turns between the end of settling [s] and the last value of a recorded time [s].
    pub fn of(scene: &Scene, settle: f64, duration: f64) -> Self {
        Self {
            angle: recorded_angle([&scene.operation.speed, &scene.operation.outer_speed], settle, duration),
            outer_ring_turns: turns(&scene.operation.outer_speed, settle + duration),
            bearings: vec![RecordedBearing::of(scene, None)],
        }
    }

    /// The same of a machine.
    pub fn of_machine(machine: &Machine, settle: f64, duration: f64) -> Self {
        Self {
            angle: recorded_angle([&machine.speed, &machine.outer_speed], settle, duration),
            outer_ring_turns: turns(&machine.outer_speed, settle + duration),
            bearings: RecordedBearing::of_machine(machine).collect(),
        }
    }

    pub fn ratios(&self) -> Vec<Ratios> {
        self.bearings.iter().map(|bearing| bearing.ratios).collect()
    }

    /// Order of the fastest ball passage over an inner raceway; without bearings a usual one.
    pub fn ball_pass_inner(&self) -> f64 {
        let orders = self.bearings.iter().map(|bearing| bearing.ratios.ball_pass_inner);
        orders.reduce(f64::max).unwrap_or(USUAL_BALL_PASS)
    }

    /// Ratio of the reference's speed to that of the shaft [-].
    pub fn of_reference(&self, reference: Reference) -> f64 {
        self.bearings.first().map_or(1.0, |bearing| bearing.ratios.of_reference(reference))
    }

    /// The reason why the cage is no reference.
    pub fn without_cage(&self) -> Option<&'static str> {
        match &self.bearings[..] {
            [bearing] if bearing.has_cage => None,
            [_] => Some("the cage is not simulated (/scene/terms/cage is off)"),
            [] => Some("the scene has no bearing with a cage"),
            _ => Some("the scene has several cages: give `shaft`"),
        }
    }
}

impl RecordedBearing {
    /// The bearings of a machine, in their order.
    pub fn of_machine(machine: &Machine) -> impl Iterator<Item = Self> {
        machine.bearings.iter().map(|bearing| Self::of(&bearing.scene, Some(&bearing.name)))
    }

    fn of(scene: &Scene, name: Option<&String>) -> Self {
        Self {
            name: name.cloned(),
            ratios: Ratios::of(&scene.bearing),
            balls: scene.bearing.parameters.ball_count as f64,
            has_cage: has_cage(scene),
        }
    }

    /// Channels with the simulated speeds of its cage and its ball 1.
    pub fn turning_channels(&self) -> [String; 2] {
        [Channel::CageSpeed, Channel::BallSpin(0)].map(|channel| match &self.name {
            Some(name) => format!("{name}.{channel}"),
            None => channel.to_string(),
        })
    }
}

/// Angle between the end of settling [s] and the last value of a recorded time [s].
fn recorded_angle([shaft, outer]: [&SpeedProfile; 2], settle: f64, duration: f64) -> Option<ShaftAngle> {
    let last = (settle + duration - RATE.recip()).max(settle);
    (!turns(outer, settle + duration)).then(|| ShaftAngle::new(shaft, settle, last)).flatten()
}

/// True if a ring turns before a time [s].
fn turns(speed: &SpeedProfile, end: f64) -> bool {
    speed.until(end).largest() > 0.0
}

fn has_cage(scene: &Scene) -> bool {
    scene.terms.get(Term::Cage) != TermChoice::Off
}

/// Channels with the simulated turns of cage and ball, which an order analysis keeps beside its own.
pub fn turning_channels(scene: &Scene) -> Vec<Channel> {
    let cage = has_cage(scene).then_some(Channel::CageSpeed);
    cage.into_iter().chain([Channel::BallSpin(0)]).collect()
}
