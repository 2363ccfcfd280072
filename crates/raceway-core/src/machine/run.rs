//! A run in time: settling, record, and a repetition in half steps that shows the error.

use std::f64::consts::TAU;

use super::bearing::BearingOnShaft;
use super::bearing_stepper::BearingStepper;
use super::channel::MachineChannel;
use super::codes::{LastStep, MachineWarning, RejectedStep, StepCause};
use super::equations::MachineDynamics;
use super::input::{Loss, Machine, MachineError, SHORTEST_STEP, StepsOfLoss};
use super::recording::{MachineRecording, Recorder};
use super::settings::MachineSettings;
use super::stability::{fastest_part, is_stable};
use super::stepping::{MachineStepper, StepLength};
use crate::numerics::statistics::rms;
use crate::physics::operation::SpeedProfile;
use crate::simulation::error::comparison::{FAINT, level_of_both};
use crate::simulation::input::control::Control;
use crate::simulation::solve::fixed_step::AXIAL_STEP;
use crate::simulation::solve::startup::{CAGE_SETTLE_RANGE_S, MAX_SETTLE_S, SETTLE_CAGE_TURNS, SETTLED_EFOLDS};

/// Steps between two looks at the motion and at the caller.
const STEPS_PER_LOOK: u64 = 64;
/// Error of a run over its deviation from half steps: both methods are of order 2 [-].
const ERROR_OVER_DEVIATION: f64 = 4.0 / 3.0;
/// Time that is repeated in half steps [s], unless a period is longer, and largest error of a level that needs no shorter step [dB].
const REPEATED: f64 = 0.1;
pub(super) const ALLOWED_DB: f64 = 0.1;
/// Error of a level that is as large as the value, 20 lg 2 [dB].
const AS_LARGE_AS_THE_VALUE_DB: f64 = 6.02;
/// Share of the rest of the progress that steps of one length take, because shorter ones may follow; and that of their first run in it.
const STEP_SHARE: f64 = 0.8;
const RUN_SHARE: f64 = 0.6;

/// A run in steps that half steps confirm.
pub(super) struct Confirmed {
    pub recording: MachineRecording,
    /// The run in half steps.
    pub again: MachineRecording,
    /// Estimated error of the level of each acceleration [dB]; `None` where it is silent or faint.
    pub errors: Vec<(MachineChannel, Option<f64>)>,
    pub step: StepLength,
    /// Reason why no shorter one was tried.
    pub last: LastStep,
    /// Longer steps that were rejected.
    pub rejections: Vec<MachineWarning>,
    /// Of all runs.
    pub work: Work,
}

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
        self.record(window, step, control, work).map_err(|error| self.failed(error, StepsOfLoss::Selected(step.full())))
    }

    /// Records the first of two times after settling [s]. Its steps are the selected ones [s], or the longest for which half steps confirm
    /// the levels over the second time.
    pub(super) fn confirmed(
        &self,
        selected: Option<f64>,
        [duration, window]: [f64; 2],
        control: &Control<'_>,
    ) -> Result<Confirmed, MachineError> {
        let mut step = StepLength { longest: selected.unwrap_or_else(|| first_step(self.dynamics)), share: 1.0 };
        let may_shorten = |step: StepLength| selected.is_none() && step.halved().full() >= SHORTEST_STEP;
        let is_stable = |step: StepLength| is_stable(self.dynamics, step.full());
        let unresolved = |steps: fn(f64) -> StepsOfLoss, step: StepLength| {
            let lost = Unrecorded::Lost { time: self.settle + duration, cause: Loss::Unresolved };
            self.failed(lost, steps(step.full()))
        };
        let rejected = |step: StepLength, cause| {
            let warning = MachineWarning::StepRejected(RejectedStep {
                step: step.full(),
                cause,
                stiff_bearings: !is_stable(step),
            });
            let last = shortest(step);
            if is_stable(last) { Ok(warning) } else { Err(unresolved(StepsOfLoss::Foreseen, last)) }
        };
        let (mut rejections, mut work, mut last_error) = (Vec::new(), Work::default(), None);
        let mut done = 0.0;
        loop {
            let (from, to) = (done, done + STEP_SHARE * (1.0 - done));
            let between = from + RUN_SHARE * (to - from);
            done = to;
            let recorded = control
                .part((from, between), |control| self.record(duration, step, control, &mut work))
                .and_then(|recording| {
                    let half = step.halved();
                    let again = control.part((between, to), |control| self.record(window, half, control, &mut work))?;
                    Ok((recording, again))
                });
            let recorded = recorded.and_then(|(recording, again)| match level_errors(&recording, &again) {
                errors if errors.iter().any(|(_, error)| error.is_some_and(|error| !error.is_finite())) => {
                    Err(Unrecorded::Lost { time: self.settle + duration, cause: Loss::FrameNotFinite })
                }
                errors => Ok((recording, again, errors)),
            });
            let (recording, again, errors) = match recorded {
                Err(Unrecorded::Lost { time, cause }) if may_shorten(step) => {
                    rejections.push(rejected(step, StepCause::Lost { time, loss: cause })?);
                    step = step.halved();
                    continue;
                }
                Err(unrecorded) => {
                    let steps = selected.map_or(StepsOfLoss::DownTo(step.full()), StepsOfLoss::Selected);
                    return Err(self.failed(unrecorded, steps));
                }
                Ok(recorded) => recorded,
            };
            let known = errors.iter().filter_map(|(channel, error)| Some((*channel, (*error)?)));
            let worst = known.max_by(|one, other| one.1.total_cmp(&other.1));
            // The error of a regular motion that steps resolve falls with the square of the step.
            let falls = worst.zip(last_error).is_none_or(|((_, error), last)| error < last);
            let is_resolved = recording.is_resolved && again.is_resolved;
            if let Some((channel, error_db)) = worst.filter(|(_, error)| *error > ALLOWED_DB) {
                if may_shorten(step) && (falls || !is_resolved) {
                    rejections.push(rejected(step, StepCause::Deviation { channel, error_db })?);
                    last_error = Some(error_db);
                    step = step.halved();
                    continue;
                }
                if !is_resolved && selected.is_none() && error_db > AS_LARGE_AS_THE_VALUE_DB {
                    return Err(unresolved(StepsOfLoss::DownTo, step));
                }
            }
            let last = match selected {
                Some(_) => LastStep::Selected,
                None if falls || !is_resolved => LastStep::Shortest,
                None => LastStep::Irregular,
            };
            return Ok(Confirmed { recording, again, errors, step, last, rejections, work });
        }
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

/// The shortest step that halves of a step may end at.
fn shortest(mut step: StepLength) -> StepLength {
    while step.halved().full() >= SHORTEST_STEP {
        step = step.halved();
    }
    step
}

/// Estimated error of the level of each acceleration [dB], from a run in half steps over the first part of the time; `None` where both are
/// silent or faint.
fn level_errors(recording: &MachineRecording, again: &MachineRecording) -> Vec<(MachineChannel, Option<f64>)> {
    let mut deviations = level_deviations(recording, again);
    for (_, deviation) in &mut deviations {
        *deviation = deviation.map(|deviation| ERROR_OVER_DEVIATION * deviation);
    }
    deviations
}

/// Deviation of the level of each acceleration over the first part of the time [dB]; `None` where both are silent or faint.
pub(super) fn level_deviations(
    recording: &MachineRecording,
    again: &MachineRecording,
) -> Vec<(MachineChannel, Option<f64>)> {
    let accelerations = || recording.signals.iter().filter(|(channel, _)| channel.is_acceleration());
    let larger = |values: &[f64], repeated: &[f64]| rms(values).max(rms(repeated));
    let strongest = accelerations().map(|(channel, values)| larger(values, again.of(*channel))).fold(0.0, f64::max);
    let of = |(channel, values): &(MachineChannel, Vec<f64>)| {
        let repeated = again.of(*channel);
        // Rounding makes most of a motion that is a thousandth of the strongest one.
        if larger(values, repeated) < strongest * 10_f64.powf(-FAINT / 20.0) {
            return (*channel, None);
        }
        (*channel, level_of_both(&values[..repeated.len().min(values.len())], repeated))
    };
    accelerations().map(of).collect()
}
