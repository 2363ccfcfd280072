//! Bearings of a machine on a reduced level: machines that it can represent, and its equations.

use std::array::from_fn;

use super::bearing::{ReducedBearing, ReducedModel, TiltHold, scene_on_shaft};
use super::channel::MachineChannel;
use super::equations::MachineDynamics;
use super::inapplicable::{BearingInapplicable, MachineInapplicable};
use super::input::{Machine, MachineError};
use crate::physics::contact::damping::DampingFactor;
use crate::physics::spindle::{AxialHold, SpindleTilt};
use crate::physics::statics::Matrix;
use crate::physics::statics::ring::RingState;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::dynamics::Planar;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::model::radially_condensed::{self, RadiallyCondensed};
use crate::simulation::model::spindle_only;
use crate::simulation::model::surfaces::with_surfaces;
use crate::simulation::model::terms::ActiveTerms;

/// Model level of the bearings of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum LevelChoice {
    #[default]
    Full,
    Reduced(ReducedLevel),
    /// The leanest of `ReducedLevel::TRIED` for which `full` shows no larger error of a level [dB], else `full`.
    Within(f64),
}

impl LevelChoice {
    /// Largest accepted error of a level by the model [dB], where a lean one is sought.
    pub fn tolerance_db(self) -> Option<f64> {
        if let Self::Within(tolerance_db) = self { Some(tolerance_db) } else { None }
    }
}

/// Level that leaves out axial motion of the bearings and couples them to the shaft by radial ports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReducedLevel {
    SpindleOnly,
    RadiallyCondensed,
    Planar,
}

impl ReducedLevel {
    pub const ALL: [Self; 3] = [Self::SpindleOnly, Self::RadiallyCondensed, Self::Planar];
    /// Levels that are tried, the leanest first. `planar` holds the tilt in the same way as `radially_condensed`, and saves little of `full`.
    pub const TRIED: [Self; 2] = [Self::SpindleOnly, Self::RadiallyCondensed];

    pub fn level(self) -> ModelLevel {
        match self {
            Self::SpindleOnly => ModelLevel::SpindleOnly,
            Self::RadiallyCondensed => ModelLevel::RadiallyCondensed,
            Self::Planar => ModelLevel::Planar,
        }
    }

    /// The level of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|level| level.level().name() == name)
    }
}

/// Reason why a level cannot represent the bearings of a machine; `None`: it can.
pub fn inapplicability(machine: &Machine, level: ReducedLevel) -> Option<MachineInapplicable> {
    let of_machine = if machine.bearings.is_empty() {
        Some(MachineInapplicable::NoBearing)
    } else if machine.rotor.shaft.is_axially_free {
        Some(MachineInapplicable::AxiallyFree)
    } else if !machine.speed.is_constant() {
        Some(MachineInapplicable::SpeedChanges)
    } else {
        None
    };
    of_machine.or_else(|| (0..machine.bearings.len()).find_map(|index| of_bearing(machine, level, index)))
}

/// Reason why a level has no values of signals that are asked for. Places of `spindle_only` keep their azimuth, and balls pass through them.
pub fn missing_signal(series: &[MachineChannel], level: ReducedLevel) -> Option<MachineInapplicable> {
    let is_missing = level == ReducedLevel::SpindleOnly && series.iter().any(MachineChannel::is_of_ball);
    is_missing.then_some(MachineInapplicable::SingleBalls)
}

fn of_bearing(machine: &Machine, level: ReducedLevel, index: usize) -> Option<MachineInapplicable> {
    let (of, placed) = (&machine.bearings[index], &machine.rotor.bearings[index]);
    let bearing = || of.name.clone();
    let [x, _, _, about_y, about_z] = placed.mounted.outer;
    if placed.has_moving_outer_ring() {
        Some(MachineInapplicable::OuterRingMoves { bearing: bearing() })
    } else if [x, about_y, about_z] != [0.0; 3] || placed.mounted.spring.is_some() {
        Some(MachineInapplicable::OuterRingOff { bearing: bearing() })
    } else {
        let reason = of_scene(&in_plane(scene_on_shaft(machine, index, [0.0; 3])), level)?;
        Some(MachineInapplicable::Bearing { bearing: bearing(), reason })
    }
}

/// Reason why a level cannot represent the scene of a bearing.
fn of_scene(scene: &Scene, level: ReducedLevel) -> Option<BearingInapplicable> {
    let outputs = Outputs::vibration();
    let terms = |level| ActiveTerms::of(scene, &outputs, Some(level)).map_err(BearingInapplicable::from);
    let condensed = || radially_condensed::inapplicability(scene, &outputs);
    let reason = match level {
        ReducedLevel::Planar => return terms(ModelLevel::Planar).err(),
        ReducedLevel::RadiallyCondensed => condensed(),
        ReducedLevel::SpindleOnly => match terms(ModelLevel::Full) {
            Err(reason) => return Some(reason),
            Ok(terms) => spindle_only::inapplicability(scene, &terms, &outputs).or_else(condensed),
        },
    };
    reason.map(BearingInapplicable::Scene)
}

/// The scene of a bearing whose ring moves in the plane alone.
fn in_plane(mut scene: Scene) -> Scene {
    (scene.spindle.axial, scene.spindle.tilt) = (AxialHold::Fixed, SpindleTilt::Held);
    scene.operation.load[0] = 0.0;
    // The load contains the weight that the bearing carries.
    scene.operation.load[1] -= scene.spindle.mass * scene.gravity;
    scene
}

impl MachineDynamics {
    /// The machine with its bearings on a level, or the reason why that cannot represent it.
    pub fn reduced_to(mut self, level: ReducedLevel, machine: &Machine) -> Result<Self, MachineError> {
        if let Some(reason) = inapplicability(machine, level) {
            return Err(MachineError::NotApplicable { level: level.level(), reason });
        }
        for (index, bearing) in self.bearings.iter_mut().enumerate() {
            let scene = in_plane(scene_on_shaft(machine, index, bearing.largest_load));
            let of = &machine.bearings[index];
            let model = model(&scene, level, of.start_azimuth)
                .map_err(|source| MachineError::Bearing { bearing: of.name.clone(), source })?;
            let tilt = tilt_hold(&self.frame.system.operating[0].rings[index], &machine.rotor.bearings[index].damping);
            bearing.reduced = Some(ReducedBearing { model, tilt });
        }
        Ok(self)
    }
}

fn model(scene: &Scene, level: ReducedLevel, start_azimuth: f64) -> Result<ReducedModel, SimulationError> {
    let outputs = Outputs::vibration();
    Ok(match level {
        ReducedLevel::SpindleOnly => {
            ReducedModel::SpindleOnly(Box::new(spindle_only::turned_model(scene, &outputs, start_azimuth)?))
        }
        ReducedLevel::RadiallyCondensed => {
            ReducedModel::RadiallyCondensed(Box::new(RadiallyCondensed::new(scene, &outputs)?.turned(start_azimuth)))
        }
        ReducedLevel::Planar => {
            let terms = ActiveTerms::of(scene, &outputs, Some(ModelLevel::Planar))?;
            let mut mechanism = with_surfaces(Mechanism::new(scene, &terms), scene);
            mechanism.start = mechanism.start.turned(start_azimuth);
            ReducedModel::Planar(Box::new(Planar::new(mechanism)))
        }
    })
}

fn tilt_hold(ring: &RingState, damping: &DampingFactor) -> TiltHold {
    let of_tilt = |matrix: &Matrix| from_fn(|row| from_fn(|column| matrix[3 + row][3 + column]));
    TiltHold {
        rest: from_fn(|axis| ring.pose[3 + axis]),
        moment: from_fn(|axis| ring.wrench[3 + axis]),
        stiffness: of_tilt(&ring.stiffness.mean),
        damping: of_tilt(&ring.damping(damping)),
    }
}
