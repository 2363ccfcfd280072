//! A run in time: settling, then the record.

use std::f64::consts::TAU;

use super::bearing::BearingOnShaft;
use super::bearing_stepper::BearingStepper;
use super::channel::MachineChannel;
use super::equations::MachineDynamics;
use super::input::{Loss, Machine, MachineError, StepsOfLoss};
use super::recording::{MachineRecording, Recorder};
use super::settings::MachineSettings;
use super::stability::{fastest_part, is_stable};
use super::stepping::{MachineStepper, StepLength};
use crate::physics::operation::SpeedProfile;
use crate::simulation::input::control::Control;
use crate::simulation::solve::fixed_step::AXIAL_STEP;
use crate::simulation::solve::startup::{CAGE_SETTLE_RANGE_S, MAX_SETTLE_S, SETTLE_CAGE_TURNS, SETTLED_EFOLDS};

/// Steps between two looks at the motion and at the caller.
const STEPS_PER_LOOK: u64 = 64;
/// Time that is repeated in half steps [s], unless a period is longer.
const REPEATED: f64 = 0.1;

/// Work of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Work {
    pub steps: u64,
    /// Evaluations of the bearings.
    pub evaluations: u64,
}

/// Reason why a run recorded nothing.
pub(super) enum Unrecorded {
    /// The caller no longer wants the result [s].
    Stopped(f64),
    /// No bearing can hold the motion any more.
    Lost { time: f64, cause: Loss },
}

/// A run from the start.
#[derive(Clone, Copy)]
pub(super) struct Run<'a> {
    pub machine: &'a Machine,
    pub dynamics: &'a MachineDynamics,
    pub start: &'a [f64],
    pub settle: f64,
    /// Signals that are asked for, of which those of single balls are recorded beside all others.
    pub series: &'a [MachineChannel],
}

impl Run<'_> {
    /// The error of this run in steps.
    pub(super) fn failed(&self, unrecorded: Unrecorded, steps: StepsOfLoss) -> MachineError {
        match unrecorded {
            Unrecorded::Stopped(time) => MachineError::Stopped(time),
            Unrecorded::Lost { time, cause } => {
                let fastest = cause.is_of_steps().then(|| Box::new(fastest_part(self.machine, self.dynamics)));
                MachineError::Lost { time, cause, steps, fastest }
            }
        }
    }

    /// The recording of this run over the time that is compared.
    pub(super) fn compared(
        &self,
        settings: &MachineSettings,
        control: &Control<'_>,
        work: &mut Work,
    ) -> Result<MachineRecording, MachineError> {
        let step = StepLength { longest: first_step(self.dynamics), share: 1.0 };
        let [_, window] = times(self.machine, settings);
        let steps = settings.step.map_or(StepsOfLoss::DownTo(step.full()), StepsOfLoss::Selected);
        self.record(window, step, control, work).map_err(|error| self.failed(error, steps))
    }

    /// Records a time after settling, in steps of a length.
    pub(super) fn record(
        &self,
        duration: f64,
        step: StepLength,
        control: &Control<'_>,
        work: &mut Work,
    ) -> Result<MachineRecording, Unrecorded> {
        let mut recorder =
            Recorder::new((self.machine, self.dynamics), self.series, self.settle, duration, step.full());
        let mut stepper = MachineStepper::new(self.dynamics, 0.0, self.start, step);
        let (mut steps, end) = (0_u64, recorder.end());
        while !recorder.is_full() {
            stepper.advance();
            recorder.after(&stepper);
            steps += 1;
            if steps.is_multiple_of(STEPS_PER_LOOK) {
                if (control.stop)() {
                    return Err(Unrecorded::Stopped(stepper.time()));
                }
                (control.progress)((stepper.time() / end).min(1.0));
                self.check(&stepper)?;
            }
        }
        work.steps += steps;
        work.evaluations += stepper.evaluations();
        self.check(&stepper)?;
        Ok(recorder.finish(stepper.resolution()))
    }

    /// Refuses a motion that no bearing can hold any more.
    fn check(&self, stepper: &MachineStepper<'_>) -> Result<(), Unrecorded> {
        let (place, velocity) = stepper.coordinates();
        let loss = |(index, of): (usize, &BearingStepper<'_>)| {
            let (bearing, name) = (&self.dynamics.bearings[index], &self.machine.bearings[index].name);
            let collision = of.touching().map(|_| Loss::Collision { bearing: name.clone() });
            collision
                .or_else(|| bearing.loss_of_ring(name, self.dynamics.rings(index, place, velocity).apart()))
                .or_else(|| bearing.loss_of_balls(name, |ball| of.seen(ball).load))
        };
        let is_finite = place.iter().chain(velocity).all(|value| value.is_finite());
        let of_frame = || (!is_finite).then_some(Loss::FrameNotFinite);
        match stepper.bearings().iter().enumerate().find_map(loss).or_else(of_frame) {
            None => Ok(()),
            Some(cause) => Err(Unrecorded::Lost { time: stepper.time(), cause }),
        }
    }
}

/// Recorded time, and the part of it that is repeated [s].
pub(super) fn times(machine: &Machine, settings: &MachineSettings) -> [f64; 2] {
    [settings.duration, settings.duration.min(REPEATED.max(slowest_period(machine)))]
}

/// Longest period of the loads that repeat, and of a turn of the rings [s]: a shorter time shows a part of the motion only.
fn slowest_period(machine: &Machine) -> f64 {
    let [inner, outer] = [&machine.speed, &machine.outer_speed].map(SpeedProfile::largest);
    let loads = machine.rotor.loads.iter().filter_map(|placed| placed.load.harmonic());
    let frequencies = loads.map(|load| load.frequency(inner)).chain([inner / TAU, outer / TAU]);
    frequencies.filter(|frequency| *frequency > 0.0).map(f64::recip).fold(0.0, f64::max)
}

/// Time in which the slowest motion of the linear analysis decays by four e-folds, and cages turn three times against their outer rings [s]. The run starts near its
/// stationary motion already.
pub(super) fn settling_time(dynamics: &MachineDynamics) -> f64 {
    let rate = dynamics.free_motion.as_ref().map_or(0.0, |motion| motion.growth_rate);
    let turning = dynamics.bearings.iter().map(|bearing| {
        let m = bearing.dynamics.mechanism();
        let turn = m.orbit_ratio * m.rotation.operating().relative().abs() / TAU;
        if turn > 0.0 { SETTLE_CAGE_TURNS / turn } else { 0.0 }
    });
    let turning = turning.fold(0.0, f64::max).clamp(CAGE_SETTLE_RANGE_S[0], CAGE_SETTLE_RANGE_S[1]);
    if rate < 0.0 { (SETTLED_EFOLDS / -rate).clamp(turning, MAX_SETTLE_S) } else { turning }
}

/// First step that is tried [s]. It resolves the waves and defects of every bearing, and the correction of the ports' forces is stable where
/// balls are in radial equilibrium.
pub(super) fn first_step(dynamics: &MachineDynamics) -> f64 {
    let of_bearing = |bearing: &BearingOnShaft| {
        let m = bearing.dynamics.mechanism();
        let longest = bearing.reduced.as_ref().map_or(AXIAL_STEP, |reduced| reduced.model.longest_step());
        m.longest_wave_step().min(m.defect_step).min(longest)
    };
    let mut step = dynamics.bearings.iter().map(of_bearing).reduce(f64::min).unwrap_or(AXIAL_STEP);
    while step > AXIAL_STEP && !is_stable(dynamics, step) {
        step *= 0.5;
    }
    step
}
