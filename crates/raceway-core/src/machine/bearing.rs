//! A bearing between shaft and housing: its dynamics, seen from the shaft's axes.

use super::frame::Frame;
use super::input::{Loss, Machine, MachineError};
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::Vector;
use crate::physics::spindle::{AxialHold, SpindleInertia, SpindleTilt};
use crate::physics::statics::MAX_RELATIVE_DEPTH;
use crate::physics::statics::shaft::Mounted;
use crate::simulation::error::codes::Warning;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::Mechanism;
use crate::simulation::model::dynamics::on_ring::{RingLoad, Rings};
use crate::simulation::model::dynamics::{Full, Planar};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::radially_condensed::RadiallyCondensed;
use crate::simulation::model::spindle_only::equations::SpindleOnly;
use crate::simulation::model::state::{Layout, SpindleState};
use crate::simulation::model::surfaces::with_surfaces;
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::solve::fixed_step::AXIAL_STEP;
use crate::simulation::solve::surface_warnings::contact_warnings;

/// A bearing on the shaft.
#[derive(Debug, Clone)]
pub struct BearingOnShaft {
    pub dynamics: Full,
    /// `Some`: steps are those of this model, whose ring moves in the plane.
    pub reduced: Option<ReducedBearing>,
    /// Its facing, and the place of its outer ring at rest, to which its state refers.
    pub mounted: Mounted,
    /// True if its moments act on shaft and housing.
    pub has_moments: bool,
    /// Displacements of the outer ring at rest from those without loads; `None`: it does not move.
    pub outer_rest: Option<[f64; 5]>,
    /// Largest load of the shaft on it by the linear analysis [N].
    pub largest_load: [f64; 3],
    /// Limits of what a run can say about its surfaces.
    pub surface_warnings: Vec<Warning>,
}

/// A bearing on a reduced level.
#[derive(Debug, Clone)]
pub struct ReducedBearing {
    pub(super) model: ReducedModel,
    pub tilt: TiltHold,
}

/// Equations of a bearing whose ring moves in the plane.
#[derive(Debug, Clone)]
pub(super) enum ReducedModel {
    SpindleOnly(Box<SpindleOnly>),
    RadiallyCondensed(Box<RadiallyCondensed>),
    Planar(Box<Planar>),
}

impl ReducedModel {
    /// Longest step that is tried [s].
    pub(super) fn longest_step(&self) -> f64 {
        match self {
            Self::SpindleOnly(model) => model.longest_step_on_ring(),
            Self::RadiallyCondensed(model) => model.longest_step_on_ring(),
            Self::Planar(_) => AXIAL_STEP,
        }
    }

    /// Number of states of balls and cage.
    pub(super) fn states(&self) -> usize {
        match self {
            Self::SpindleOnly(_) => 0,
            Self::RadiallyCondensed(model) => model.states_on_ring(),
            Self::Planar(model) => entries(&model.mechanism().layout),
        }
    }

    pub(super) fn level(&self) -> ModelLevel {
        match self {
            Self::SpindleOnly(_) => ModelLevel::SpindleOnly,
            Self::RadiallyCondensed(_) => ModelLevel::RadiallyCondensed,
            Self::Planar(_) => ModelLevel::Planar,
        }
    }

    /// True if loads depend on the acceleration of the ring.
    pub(super) fn needs_accelerations(&self) -> bool {
        !matches!(self, Self::Planar(_))
    }
}

/// Number of states of balls and cage in a layout.
fn entries(layout: &Layout) -> usize {
    layout.dimension() - 2 * layout.freedoms().len()
}

/// Moments of the balls on the inner ring, linear in its tilt about the operating point.
#[derive(Debug, Clone, Copy)]
pub struct TiltHold {
    /// Tilts [rad] and moments [N m] of the operating point, about Y and Z in the bearing's own axes.
    pub rest: [f64; 2],
    pub moment: [f64; 2],
    /// [N m/rad], [N m s/rad]
    pub stiffness: [[f64; 2]; 2],
    pub damping: [[f64; 2]; 2],
}

impl TiltHold {
    /// Moments on a ring.
    pub(super) fn moment(&self, ring: &SpindleState) -> [f64; 2] {
        std::array::from_fn(|row| {
            (0..2).fold(self.moment[row], |sum, column| {
                let apart = ring.tilt[column] - self.rest[column];
                sum - self.stiffness[row][column] * apart - self.damping[row][column] * ring.tilt_rate[column]
            })
        })
    }
}

impl BearingOnShaft {
    /// Number of entries of balls and cage.
    pub fn entries(&self) -> usize {
        entries(&self.dynamics.mechanism().layout)
    }

    /// Motion of the rings in the bearing's own axes, by displacements and velocities of the shaft at its place, and of the outer ring where it moves.
    #[inline(always)]
    pub(crate) fn rings(&self, inner: [[f64; 5]; 2], outer: Option<[[f64; 5]; 2]>) -> Rings {
        let [place, velocity] = inner;
        let inner = motion(self.mounted.ring_pose(&place, 0.0), self.mounted.wrench_on_shaft(&velocity));
        let outer = outer.zip(self.outer_rest).map(|([place, velocity], rest)| {
            let moved = std::array::from_fn(|k| place[k] - rest[k]);
            motion(self.mounted.wrench_on_shaft(&moved), self.mounted.wrench_on_shaft(&velocity))
        });
        Rings { inner, outer }
    }

    /// Reason why the bearing of this name cannot hold a ring at this place and tilt.
    pub(crate) fn loss_of_ring(&self, name: &str, (position, tilt): ([f64; 3], [f64; 2])) -> Option<Loss> {
        let bearing = || name.to_owned();
        if !position.iter().chain(&tilt).all(|value| value.is_finite()) {
            return Some(Loss::NotFinite { bearing: bearing() });
        }
        let departure = self.dynamics.mechanism().departure(position, tilt)?;
        Some(Loss::Left { bearing: bearing(), departure })
    }

    /// Reason why the bearing of this name cannot carry the loads of its balls, by their numbers.
    pub(crate) fn loss_of_balls(&self, name: &str, loads: impl Fn(usize) -> PerRaceway<f64>) -> Option<Loss> {
        let mechanism = self.dynamics.mechanism();
        let raceway = &mechanism.raceway;
        let pressed = (0..mechanism.layout.balls).map(|ball| {
            let load = loads(ball);
            let depth = raceway.inner.relative_depth(load.inner).max(raceway.outer.relative_depth(load.outer));
            (load.inner.max(load.outer), depth)
        });
        let (load, depth) = pressed.fold((0.0, 0.0), |most, ball| if ball.1 > most.1 { ball } else { most });
        (depth > MAX_RELATIVE_DEPTH).then(|| Loss::TooDeep { bearing: name.to_owned(), load, depth })
    }

    /// Forces and moments of a ring on shaft or housing; a hinge has no moments.
    pub(crate) fn on_shaft(&self, load: &RingLoad) -> [f64; 5] {
        let mut wrench = self.mounted.wrench_on_shaft(&load.wrench());
        if !self.has_moments {
            wrench[3..].fill(0.0);
        }
        wrench
    }
}

#[inline(always)]
fn motion([x, y, z, about_y, about_z]: [f64; 5], [vx, vy, vz, rate_y, rate_z]: [f64; 5]) -> SpindleState {
    SpindleState { position: [x, y, z], velocity: [vx, vy, vz], tilt: [about_y, about_z], tilt_rate: [rate_y, rate_z] }
}

/// Balls and cage of each bearing, with the terms that its load about the operating point needs.
pub(super) fn bearings(machine: &Machine, frame: &Frame) -> Result<Vec<BearingOnShaft>, MachineError> {
    let changes = machine.rotor.loads.iter().map(|load| load.start_and_largest_change().1);
    let most = changes.fold([0.0; 3], |sum, change| std::array::from_fn(|axis| sum[axis] + change[axis]));
    let mut bearings = Vec::with_capacity(machine.bearings.len());
    for (index, (moving, placed)) in machine.bearings.iter().zip(&machine.rotor.bearings).enumerate() {
        let [x, y, z, _, _] = frame.system.operating[0].rings[index].wrench;
        // The shaft presses with the opposite of what the balls exert, and with all that may be added to it.
        let largest_load = std::array::from_fn(|axis| {
            let load = -[x, y, z][axis];
            load + most[axis].copysign(load)
        });
        let mut scene = scene_on_shaft(machine, index, largest_load);
        scene.spindle.axial = AxialHold::Free;
        scene.spindle.tilt = SpindleTilt::Free(SpindleInertia { transverse: 1.0, axial: 1.0 });
        let failed = |source: SimulationError| MachineError::Bearing { bearing: moving.name.clone(), source };
        let terms = ActiveTerms::of(&scene, &Outputs::vibration(), Some(ModelLevel::Full))
            .map_err(|choice| failed(choice.into()))?;
        let ideal = Mechanism::new(&scene, &terms);
        let surface_warnings = contact_warnings(&scene, &ideal);
        let mut mechanism = with_surfaces(ideal, &scene);
        mechanism.start = mechanism.start.turned(moving.start_azimuth);
        let outer_rest = frame.outer[index].as_ref().map(|outer| outer.rest);
        let mut mounted = placed.mounted.clone();
        for (value, rest) in mounted.outer.iter_mut().zip(outer_rest.unwrap_or_default()) {
            *value += rest;
        }
        bearings.push(BearingOnShaft {
            dynamics: Full::new(mechanism),
            reduced: None,
            largest_load,
            mounted,
            has_moments: placed.has_moments,
            outer_rest,
            surface_warnings,
        });
    }
    Ok(bearings)
}

/// The scene of a bearing under a load of the shaft [N].
pub(super) fn scene_on_shaft(machine: &Machine, index: usize, load: Vector) -> Scene {
    let mut scene = machine.bearings[index].scene.clone();
    scene.operation.speed = machine.speed.clone();
    scene.operation.outer_speed = machine.outer_speed.clone();
    scene.operation.load = load;
    scene.operation.misalignment = [0.0; 2];
    scene.gravity = machine.rotor.gravity;
    scene
}
