//! The equations of motion of a machine: each bearing at the motion of its rings, shaft and housing under their loads.

use nalgebra::Complex;

use super::bearing::{BearingOnShaft, ReducedModel, bearings};
use super::frame::{Frame, OuterPort};
use super::input::{Machine, MachineError};
use crate::numerics::ode::OdeSystem;
use crate::physics::limits::SHORTEST_RAMP;
use crate::physics::operation::SpeedProfile;
use crate::rotor::input::rising;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::model::dynamics::Watch;
use crate::simulation::model::dynamics::on_ring::{RingLoads, Rings};

/// The equations of a machine. The state holds balls and cage of one bearing after the other, then places and velocities of the
/// coordinates of shaft and housing.
#[derive(Debug, Clone)]
pub struct MachineDynamics {
    pub frame: Frame,
    pub bearings: Vec<BearingOnShaft>,
    pub speed: SpeedProfile,
    pub outer_speed: SpeedProfile,
    /// Of the linear analysis at the first speed; `None` where a bearing is loose.
    pub free_motion: Option<FreeMotion>,
}

/// Free motions of shaft and housing on linear bearings.
#[derive(Debug, Clone)]
pub struct FreeMotion {
    /// Largest growth rate [1/s]; negative: all motions decay.
    pub growth_rate: f64,
    /// λ of every oscillation, by its natural frequency [1/s].
    pub oscillating: Vec<Complex<f64>>,
}

/// Loads of all bearings at one time.
pub(crate) struct Loads {
    /// On the rings, in the bearings' own axes.
    pub rings: Vec<RingLoads>,
}

impl MachineDynamics {
    /// The equations of a machine with free modes up to `range` times the band of levels.
    pub fn new(machine: &Machine, range: f64, stop: &dyn Fn() -> bool) -> Result<Self, MachineError> {
        let frame = Frame::of(machine, range, stop)?;
        let bearings = bearings(machine, &frame)?;
        let (speed, outer_speed) = (machine.speed.clone(), machine.outer_speed.clone());
        let free_motion = frame.system.free_motion(speed.at(0.0).1, |motion| {
            Some(FreeMotion { growth_rate: motion.growth_rate(), oscillating: motion.oscillating() })
        });
        Ok(Self { frame, bearings, speed, outer_speed, free_motion: free_motion.ok() })
    }

    /// Models of the bearings that are on a reduced level.
    fn reduced(&self) -> impl Iterator<Item = &ReducedModel> {
        self.bearings.iter().filter_map(|bearing| Some(&bearing.reduced.as_ref()?.model))
    }

    /// True if loads of bearings depend on the accelerations of their rings.
    pub(super) fn needs_accelerations(&self) -> bool {
        self.reduced().any(ReducedModel::needs_accelerations)
    }

    /// Places and velocities of the coordinates of shaft and housing in a state.
    pub fn coordinates<'y>(&self, state: &'y [f64]) -> (&'y [f64], &'y [f64]) {
        let size = self.frame.len();
        let (place, velocity) = state[state.len() - 2 * size..].split_at(size);
        (place, velocity)
    }

    /// Motion of the rings of a bearing, in its own axes, by the coordinates.
    #[inline(always)]
    pub(crate) fn rings(&self, bearing: usize, place: &[f64], velocity: &[f64]) -> Rings {
        let ports = &self.frame.ports;
        let inner = [ports[bearing].of_place(place), ports[bearing].of_place(velocity)];
        #[expect(clippy::manual_map, reason = "a closure is called apart, and has no lanes then")]
        let outer = match &self.frame.outer[bearing] {
            None => None,
            Some(OuterPort { port, .. }) => Some([ports[*port].of_place(place), ports[*port].of_place(velocity)]),
        };
        self.bearings[bearing].rings(inner, outer)
    }

    /// Adds the forces of the rings of a bearing on the coordinates.
    fn add_loads(&self, bearing: usize, loads: &RingLoads, forces: &mut [f64]) {
        let of = &self.bearings[bearing];
        self.frame.ports[bearing].add_forces(&of.on_shaft(&loads.inner), forces);
        if let Some(outer) = &self.frame.outer[bearing] {
            self.frame.ports[outer.port].add_forces(&of.on_shaft(&loads.outer), forces);
        }
    }

    /// Model level of the bearings.
    pub fn level(&self) -> ModelLevel {
        self.reduced().next().map_or(ModelLevel::Full, ReducedModel::level)
    }

    /// Number of first-order states in the steps of a run.
    pub fn states(&self) -> usize {
        let of_bearing = |bearing: &BearingOnShaft| match &bearing.reduced {
            None => bearing.entries(),
            Some(reduced) => reduced.model.states(),
        };
        self.bearings.iter().map(of_bearing).sum::<usize>() + 2 * self.frame.len()
    }

    /// Entries of each bearing in a state.
    pub fn parts<'y>(&self, mut state: &'y [f64]) -> Vec<&'y [f64]> {
        let take = |bearing: &BearingOnShaft| {
            let (part, rest) = state.split_at(bearing.entries());
            state = rest;
            part
        };
        self.bearings.iter().map(take).collect()
    }

    /// Writes the rates and returns the loads. `watch` sees the loads of the balls of a bearing.
    pub(crate) fn evaluate(
        &self,
        time: f64,
        state: &[f64],
        rates: &mut [f64],
        mut watch: impl FnMut(usize) -> Option<Box<dyn Watch>>,
    ) -> Loads {
        let (place, velocity) = self.coordinates(state);
        let split = state.len() - 2 * self.frame.len();
        let (of_bearings, of_frame) = rates.split_at_mut(split);
        let (of_place, of_velocity) = of_frame.split_at_mut(self.frame.len());
        of_place.copy_from_slice(velocity);
        let turning = self.speed.at(time);
        let mut inputs = vec![0.0; self.frame.inputs.ncols()];
        self.frame.write_loads(time, turning, &mut inputs);
        self.frame.write_accelerations(turning.1, (place, velocity), &inputs, of_velocity);
        let mut rest = of_bearings;
        let mut rings = Vec::with_capacity(self.bearings.len());
        for (index, (bearing, part)) in self.bearings.iter().zip(self.parts(state)).enumerate() {
            let (of_part, others) = std::mem::take(&mut rest).split_at_mut(part.len());
            let motion = self.rings(index, place, velocity);
            let mut watch = watch(index);
            let loads = bearing.dynamics.rates_on_ring(time, part, motion, of_part, watch.as_deref_mut());
            self.add_loads(index, &loads, of_velocity);
            rings.push(loads);
            rest = others;
        }
        Loads { rings }
    }

    /// Times after 0 at which a load or a speed has a kink, rising [s].
    pub fn kinks(&self) -> Vec<f64> {
        let of_speeds = self.speed.kinks().chain(self.outer_speed.kinks());
        rising(self.frame.kinks().chain(of_speeds).filter(|time| *time >= SHORTEST_RAMP).collect())
    }

    /// Torque of the drive on the shaft that balances the bearings [N m].
    pub fn drive_torque(&self, time: f64, state: &[f64]) -> f64 {
        let mut rates = vec![0.0; state.len()];
        -self.evaluate(time, state, &mut rates, |_| None).rings.iter().map(|ring| ring.inner.drive).sum::<f64>()
    }
}

impl OdeSystem for MachineDynamics {
    fn dimension(&self) -> usize {
        self.bearings.iter().map(BearingOnShaft::entries).sum::<usize>() + 2 * self.frame.len()
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        self.evaluate(time, state, derivative, |_| None);
    }
}
