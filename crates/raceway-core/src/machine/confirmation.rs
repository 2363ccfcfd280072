//! A run in the longest steps for which half steps confirm the levels.

use super::channel::MachineChannel;
use super::codes::{LastStep, MachineWarning, RejectedStep, StepCause};
use super::input::{Loss, MachineError, SHORTEST_STEP, StepsOfLoss};
use super::recording::MachineRecording;
use super::run::{Run, Unrecorded, Work, first_step};
use super::stability::is_stable;
use super::stepping::StepLength;
use crate::numerics::statistics::rms;
use crate::simulation::error::comparison::{FAINT, level_of_both};
use crate::simulation::input::control::Control;

/// Error of a run over its deviation from half steps: both methods are of order 2 [-].
const ERROR_OVER_DEVIATION: f64 = 4.0 / 3.0;
/// Largest error of a level that needs no shorter step [dB].
pub(super) const ALLOWED_DB: f64 = 0.1;
/// Error of a level that is as large as the value, 20 lg 2 [dB].
const AS_LARGE_AS_THE_VALUE_DB: f64 = 6.02;
/// Share of the rest of the progress that steps of one length take, because shorter ones may follow; and that of their first run in it.
const STEP_SHARE: f64 = 0.8;
const RUN_SHARE: f64 = 0.6;

/// A run in steps that half steps confirm.
pub(super) struct Confirmed {
    /// The run, with its repetition in half steps.
    pub pair: Pair,
    pub step: StepLength,
    /// Reason why no shorter one was tried.
    pub last: LastStep,
    /// Longer steps that were rejected.
    pub rejections: Vec<MachineWarning>,
    /// Work of all runs.
    pub work: Work,
}

/// A run, and its repetition in half steps.
pub(super) struct Pair {
    pub recording: MachineRecording,
    pub again: MachineRecording,
    /// Estimated error of the level of each acceleration [dB]; `None` where it is silent or faint.
    pub errors: Vec<(MachineChannel, Option<f64>)>,
}

/// Judgement of a step.
enum Verdict {
    Accepted(LastStep),
    /// The largest error [dB], which shorter steps may reduce.
    Deviates(MachineChannel, f64),
    /// No step resolves the motion, and the error is as large as the value.
    Unresolved,
}

impl Run<'_> {
    /// Records the first of two times after settling [s]. Its steps are the selected ones [s], or the longest for which half steps confirm
    /// the levels over the second time.
    pub(super) fn confirmed(
        &self,
        selected: Option<f64>,
        times: [f64; 2],
        control: &Control<'_>,
    ) -> Result<Confirmed, MachineError> {
        let mut step = StepLength { longest: selected.unwrap_or_else(|| first_step(self.dynamics)), share: 1.0 };
        let (mut rejections, mut work, mut last_error, mut done) = (Vec::new(), Work::default(), None, 0.0);
        let end = self.settle + times[0];
        loop {
            let part = (done, done + STEP_SHARE * (1.0 - done));
            done = part.1;
            let may_shorten = selected.is_none() && step.halved().full() >= SHORTEST_STEP;
            let cause = match control.part(part, |control| self.pair(step, times, control, &mut work)) {
                Ok(pair) => match pair.verdict(selected, may_shorten, last_error) {
                    Verdict::Accepted(last) => return Ok(Confirmed { pair, step, last, rejections, work }),
                    Verdict::Unresolved => return Err(self.unresolved(end, StepsOfLoss::DownTo(step.full()))),
                    Verdict::Deviates(channel, error_db) => {
                        last_error = Some(error_db);
                        StepCause::Deviation { channel, error_db }
                    }
                },
                Err(Unrecorded::Lost { time, cause }) if may_shorten => StepCause::Lost { time, loss: cause },
                Err(unrecorded) => {
                    let steps = selected.map_or(StepsOfLoss::DownTo(step.full()), StepsOfLoss::Selected);
                    return Err(self.failed(unrecorded, steps));
                }
            };
            let is_stable = |step: StepLength| is_stable(self.dynamics, step.full());
            let rejected = RejectedStep { step: step.full(), cause, stiff_bearings: !is_stable(step) };
            rejections.push(MachineWarning::StepRejected(rejected));
            // Steps between this one and the shortest need not be tried where not even the shortest is stable.
            let last = shortest(step);
            if !is_stable(last) {
                return Err(self.unresolved(end, StepsOfLoss::Foreseen(last.full())));
            }
            step = step.halved();
        }
    }

    /// A run in steps over the first of two times, and one in half steps over the second.
    fn pair(
        &self,
        step: StepLength,
        [duration, window]: [f64; 2],
        control: &Control<'_>,
        work: &mut Work,
    ) -> Result<Pair, Unrecorded> {
        let recording = control.part((0.0, RUN_SHARE), |control| self.record(duration, step, control, work))?;
        let again = control.part((RUN_SHARE, 1.0), |control| self.record(window, step.halved(), control, work))?;
        let errors = level_errors(&recording, &again);
        if errors.iter().any(|(_, error)| error.is_some_and(|error| !error.is_finite())) {
            return Err(Unrecorded::Lost { time: self.settle + duration, cause: Loss::FrameNotFinite });
        }
        Ok(Pair { recording, again, errors })
    }

    /// The error of forces that no step resolves, seen at a time [s].
    fn unresolved(&self, time: f64, steps: StepsOfLoss) -> MachineError {
        self.failed(Unrecorded::Lost { time, cause: Loss::Unresolved }, steps)
    }
}

impl Pair {
    /// Accepts a level whose error is small, that shorter steps cannot improve, or whose step is selected. `last_error`: the largest error in
    /// twice these steps [dB].
    fn verdict(&self, selected: Option<f64>, may_shorten: bool, last_error: Option<f64>) -> Verdict {
        let known = self.errors.iter().filter_map(|(channel, error)| Some((*channel, (*error)?)));
        let worst = known.max_by(|one, other| one.1.total_cmp(&other.1));
        // The error of a regular motion that steps resolve falls with the square of the step.
        let falls = worst.zip(last_error).is_none_or(|((_, error), last)| error < last);
        let is_resolved = self.recording.is_resolved && self.again.is_resolved;
        let is_regular = falls || !is_resolved;
        match worst {
            Some((channel, error)) if error > ALLOWED_DB && may_shorten && is_regular => {
                Verdict::Deviates(channel, error)
            }
            Some((_, error)) if error > AS_LARGE_AS_THE_VALUE_DB && selected.is_none() && !is_resolved => {
                Verdict::Unresolved
            }
            _ if selected.is_some() => Verdict::Accepted(LastStep::Selected),
            _ if is_regular => Verdict::Accepted(LastStep::Shortest),
            _ => Verdict::Accepted(LastStep::Irregular),
        }
    }
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
