//! Error against run time for the number of modes of a shaft. Runs with free modes up to several frequencies are compared with a reference
//! of more modes and half steps.
//!
//! All runs have the same settling, step and recorded time. Their starts differ only by the modes that each keeps. The timed part is the
//! run from its start to the end of the record.

use super::channel::MachineChannel;
use super::equations::MachineDynamics;
use super::growth::check_growth;
use super::input::{Machine, MachineError, StepsOfLoss};
use super::recording::MachineRecording;
use super::run::{Run, Work, settling_time};
use super::start::start_state;
use super::stepping::StepLength;
use crate::numerics::ode::OdeSystem;
use crate::simulation::error::comparison::FAINT;
use crate::simulation::input::control::Control;
use crate::simulation::recording::windows::InBand;
use crate::simulation::result::metrics::level_db;
use crate::simulation::work_precision::{Clock, Taken};

/// Highest frequencies that are compared, over the band of the levels [-], and times of the runs.
#[derive(Debug, Clone, PartialEq)]
pub struct ModePlan {
    pub ranges: Vec<f64>,
    /// That of the reference, larger than all others.
    pub reference_range: f64,
    /// Time before the record [s]; `None`: as of a machine job.
    pub settle: Option<f64>,
    /// Recorded time [s].
    pub duration: f64,
    /// Step [s]; `None`: the longest whose levels half steps confirm, with the modes of the reference.
    pub step: Option<f64>,
    /// Timed runs of each range; at least 1.
    pub repetitions: u32,
}

/// Outcome of a comparison. Times in seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct ModePrecision {
    pub settle: f64,
    pub duration: f64,
    /// Step of all runs but the reference, which has half of it.
    pub step: f64,
    pub reference: ModeReference,
    pub points: Vec<ModePoint>,
}

/// The run that all others are compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeReference {
    pub size: ModeSize,
    /// The levels that are compared [dB].
    pub levels: Vec<(MachineChannel, f64)>,
    /// Deviation of a run of the same modes at the step of the others [dB].
    pub step_errors: Vec<(MachineChannel, f64)>,
    /// Of the reference, of that run, and of rejected longer steps.
    pub work: Work,
    pub taken: Taken,
}

/// Size of the equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModeSize {
    /// Coordinates of shaft and housing: modes, and static answers of the rest.
    pub coordinates: usize,
    /// First-order states of the whole.
    pub states: usize,
}

/// Runs with modes up to one frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct ModePoint {
    pub range: f64,
    /// Duration of each repetition until its end or its failure.
    pub taken: Vec<Taken>,
    /// The measurement, or the reason for its absence.
    pub measured: Result<ModeMeasured, String>,
}

/// Measurement of a finished run.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeMeasured {
    pub size: ModeSize,
    pub work: Work,
    /// Deviation of each compared level from the reference [dB].
    pub errors: Vec<(MachineChannel, f64)>,
    /// Deviation from a run with the modes of the reference at the same step [dB].
    pub mode_errors: Vec<(MachineChannel, f64)>,
}

/// Share of the progress that the reference takes.
const REFERENCE_SHARE: f64 = 0.5;

/// Compares runs with modes up to each range. Deterministic apart from the times.
pub fn compare(machine: &Machine, plan: &ModePlan, control: &Control<'_>) -> Result<ModePrecision, MachineError> {
    let control = &control.without_live();
    let clock = Clock::start();
    let dynamics = dynamics(machine, plan.reference_range, control)?;
    let settle = plan.settle.unwrap_or_else(|| settling_time(&dynamics));
    check_growth(machine, &dynamics, settle, plan.duration)?;
    let start = start_state(machine, &dynamics)?;
    let run = Run { machine, dynamics: &dynamics, start: &start, settle, series: &[] };
    let times = [plan.duration, plan.duration];
    let confirmed = control.part((0.0, REFERENCE_SHARE), |control| run.confirmed(plan.step, times, control))?;
    let (same_step, levels) = (levels(&confirmed.pair.recording), judged(levels(&confirmed.pair.again)));
    let reference = ModeReference {
        size: size_of(&dynamics),
        step_errors: deviations(&levels, &same_step),
        work: confirmed.work,
        taken: clock.taken(),
        levels,
    };
    let step = confirmed.step;
    let mut points = Vec::with_capacity(plan.ranges.len());
    for (index, range) in plan.ranges.iter().enumerate() {
        let share = |done: usize| REFERENCE_SHARE + (1.0 - REFERENCE_SHARE) * done as f64 / plan.ranges.len() as f64;
        let all = Runs { machine, plan, settle, step, reference: &reference, same_step: &same_step };
        points.push(control.part((share(index), share(index + 1)), |control| all.point(*range, control))?);
    }
    Ok(ModePrecision { settle, duration: plan.duration, step: step.full(), reference, points })
}

fn dynamics(machine: &Machine, range: f64, control: &Control<'_>) -> Result<MachineDynamics, MachineError> {
    let dynamics = MachineDynamics::new(machine, range, control.stop)?;
    if (control.stop)() { Err(MachineError::Stopped(0.0)) } else { Ok(dynamics) }
}

/// Data that the runs of a comparison share.
struct Runs<'a> {
    machine: &'a Machine,
    plan: &'a ModePlan,
    settle: f64,
    step: StepLength,
    reference: &'a ModeReference,
    /// Levels with the modes of the reference at the step of the runs [dB].
    same_step: &'a [(MachineChannel, Option<f64>)],
}

impl Runs<'_> {
    /// Runs with modes up to a range. Fails only when the caller stops it.
    fn point(&self, range: f64, control: &Control<'_>) -> Result<ModePoint, MachineError> {
        let mut taken = Vec::new();
        let measured = match self.measured(range, control, &mut taken) {
            Err(stopped @ MachineError::Stopped(_)) => return Err(stopped),
            measured => measured.map_err(|error| error.to_string()),
        };
        Ok(ModePoint { range, taken, measured })
    }

    fn measured(
        &self,
        range: f64,
        control: &Control<'_>,
        taken: &mut Vec<Taken>,
    ) -> Result<ModeMeasured, MachineError> {
        let Self { machine, plan, settle, step, .. } = *self;
        let dynamics = dynamics(machine, range, control)?;
        let start = start_state(machine, &dynamics)?;
        let run = Run { machine, dynamics: &dynamics, start: &start, settle, series: &[] };
        let mut once = |index: u32| {
            let mut work = Work::default();
            let share = |done: u32| f64::from(done) / f64::from(plan.repetitions);
            let clock = Clock::start();
            let recorded = control
                .part((share(index), share(index + 1)), |control| run.record(plan.duration, step, control, &mut work));
            taken.push(clock.taken());
            recorded
                .map(|recording| (recording, work))
                .map_err(|error| run.failed(error, StepsOfLoss::Selected(step.full())))
        };
        let (recording, work) = once(0)?;
        // Runs repeat bit for bit.
        (1..plan.repetitions).try_for_each(|index| once(index).map(drop))?;
        let found = levels(&recording);
        let errors = deviations(&self.reference.levels, &found);
        let of_same_step: Vec<_> =
            self.same_step.iter().filter_map(|(channel, level)| Some((*channel, (*level)?))).collect();
        let is_compared = |channel: &MachineChannel| self.reference.levels.iter().any(|(of, _)| of == channel);
        let mode_errors = deviations(&of_same_step, &found).into_iter().filter(|(channel, _)| is_compared(channel));
        Ok(ModeMeasured { size: size_of(&dynamics), work, errors, mode_errors: mode_errors.collect() })
    }
}

fn size_of(dynamics: &MachineDynamics) -> ModeSize {
    ModeSize { coordinates: dynamics.frame.len(), states: dynamics.dimension() }
}

/// Levels of the accelerations from 0 to 20 kHz [dB]; `None` where nothing moves.
fn levels(recording: &MachineRecording) -> Vec<(MachineChannel, Option<f64>)> {
    let accelerations = recording.signals.iter().filter(|(channel, _)| channel.is_acceleration());
    accelerations.map(|(channel, values)| (*channel, level_db(InBand::of(values, &[]).moments.rms()))).collect()
}

/// The levels that are compared: those of channels that are not faint.
fn judged(levels: Vec<(MachineChannel, Option<f64>)>) -> Vec<(MachineChannel, f64)> {
    let known = levels.into_iter().filter_map(|(channel, level)| Some((channel, level?)));
    let known: Vec<_> = known.collect();
    let strongest = known.iter().map(|(_, level)| *level).fold(f64::NEG_INFINITY, f64::max);
    known.into_iter().filter(|(_, level)| *level >= strongest - FAINT).collect()
}

/// Deviations of levels from those of a reference [dB], of the channels that move in both.
fn deviations(
    reference: &[(MachineChannel, f64)],
    levels: &[(MachineChannel, Option<f64>)],
) -> Vec<(MachineChannel, f64)> {
    let level = |channel: MachineChannel| levels.iter().find(|(of, _)| *of == channel)?.1;
    let deviation =
        |(channel, reference): &(MachineChannel, f64)| Some((*channel, (level(*channel)? - reference).abs()));
    reference.iter().filter_map(deviation).collect()
}
