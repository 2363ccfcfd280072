//! The simulation of a machine: its model, the run, and what verifies the model.

use super::codes::{LeanModel, MachineWarning};
use super::confirmation::{ALLOWED_DB, Confirmed, Pair, level_deviations};
use super::equations::MachineDynamics;
use super::growth::check_growth;
use super::input::{Machine, MachineError};
use super::level::{LevelChoice, ReducedLevel, missing_signal};
use super::omission::omitted;
use super::recording::MachineRecording;
use super::result::{Accuracy, MachineResult, ModelErrors};
use super::run::{Run, settling_time, times};
use super::settings::MachineSettings;
use super::start::start_state;
use super::terms::OmittedTerm;
use super::warnings::warnings;
use crate::simulation::input::control::Control;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::model::terms::Justification;

/// Share of the progress that a lean model takes beside its verification on `full`, and both where `full` may follow.
const MODEL_SHARE: f64 = 0.3;
const TRIAL_SHARE: f64 = 0.4;

/// Simulates a machine on the level `full`. The same arguments give the same bits.
pub fn simulate(
    machine: &Machine,
    settings: &MachineSettings,
    control: &Control<'_>,
) -> Result<MachineResult, MachineError> {
    simulate_on(LevelChoice::Full, machine, settings, control)
}

/// Simulates a machine on a level. The same arguments give the same bits.
pub fn simulate_on(
    level: LevelChoice,
    machine: &Machine,
    settings: &MachineSettings,
    control: &Control<'_>,
) -> Result<MachineResult, MachineError> {
    let dynamics = MachineDynamics::new(machine, settings.range, control.stop)?;
    if (control.stop)() {
        return Err(MachineError::Stopped(0.0));
    }
    let settle = settings.settle.unwrap_or_else(|| settling_time(&dynamics));
    check_growth(machine, &dynamics, settle, settings.duration)?;
    let start = start_state(machine, &dynamics)?;
    let left_out = omitted(machine, settings, level.tolerance_db(), control.stop)?;
    let (off, small): (Vec<_>, Vec<_>) = left_out.into_iter().partition(|term| term.by == Justification::Convention);
    let run = Run { machine, dynamics: &dynamics, start: &start, settle, series: &settings.series };
    let full = Model { run, left_out: &off };
    match level {
        LevelChoice::Full => full.result(settings, control),
        LevelChoice::Reduced(level) => full.verify(&full, Some(level), settings, &mut None, control),
        LevelChoice::Within(tolerance_db) if small.is_empty() => full.leanest(&full, settings, tolerance_db, control),
        LevelChoice::Within(tolerance_db) => {
            let lean = machine.clone().without(small.iter().map(|omitted| omitted.term));
            let dynamics = MachineDynamics::new(&lean, settings.range, control.stop)?;
            let start = start_state(&lean, &dynamics)?;
            let run = Run { machine: &lean, dynamics: &dynamics, start: &start, ..full.run };
            let left_out = [off.as_slice(), &small].concat();
            full.leanest(&Model { run, left_out: &left_out }, settings, tolerance_db, control)
        }
    }
}

/// A run, and the terms that it leaves out.
#[derive(Clone, Copy)]
struct Model<'a> {
    run: Run<'a>,
    left_out: &'a [OmittedTerm],
}

impl Model<'_> {
    /// The result of this model.
    fn result(&self, settings: &MachineSettings, control: &Control<'_>) -> Result<MachineResult, MachineError> {
        let confirmed = self.run.confirmed(settings.step, times(self.run.machine, settings), control)?;
        Ok(self.evaluated(confirmed, None, settings))
    }

    /// The result of a lean model with its bearings on a level, and its deviations from this one. `of_full`: the recording of this model over the
    /// compared time, made by the first call.
    fn verify(
        &self,
        lean: &Model<'_>,
        level: Option<ReducedLevel>,
        settings: &MachineSettings,
        of_full: &mut Option<MachineRecording>,
        control: &Control<'_>,
    ) -> Result<MachineResult, MachineError> {
        let dynamics = match level {
            None => lean.run.dynamics.clone(),
            Some(level) => {
                if let Some(reason) = missing_signal(lean.run.series, level) {
                    return Err(MachineError::NotApplicable { level: level.level(), reason });
                }
                lean.run.dynamics.clone().reduced_to(level, lean.run.machine)?
            }
        };
        let lean = Model { run: Run { dynamics: &dynamics, ..lean.run }, ..*lean };
        let [duration, window] = times(self.run.machine, settings);
        let confirmed = |control: &Control<'_>| lean.run.confirmed(settings.step, [duration, window], control);
        let mut confirmed = control.part((0.0, MODEL_SHARE), confirmed)?;
        let of_full = match of_full {
            Some(known) => known,
            None => {
                let compared = |control: &Control<'_>| self.run.compared(settings, control, &mut confirmed.work);
                of_full.insert(control.part((MODEL_SHARE, 1.0), compared)?)
            }
        };
        let model = ModelErrors { window, levels: level_deviations(&confirmed.pair.recording, of_full) };
        Ok(lean.evaluated(confirmed, Some(model), settings))
    }

    fn evaluated(&self, confirmed: Confirmed, model: Option<ModelErrors>, settings: &MachineSettings) -> MachineResult {
        let Confirmed { pair: Pair { recording, errors, .. }, step, last, rejections, work } = confirmed;
        let Run { machine, dynamics, .. } = self.run;
        let [_, window] = times(machine, settings);
        let accuracy = Accuracy { step: step.full(), window, errors, evaluations: work.evaluations, model };
        let mut result = MachineResult::of(machine, dynamics, recording, settings, accuracy);
        result.omitted = self.left_out.to_vec();
        result.warnings = warnings(machine, dynamics, &result, (ALLOWED_DB, last));
        result.warnings.extend(rejections);
        result
    }

    /// The result of the leanest model where no level deviates by more than a tolerance [dB] from this one, else of this one. Tried are the reduced
    /// levels of a lean model, and this itself where it leaves out more than this one. One of which no level could be compared is passed over.
    fn leanest(
        &self,
        lean: &Model<'_>,
        settings: &MachineSettings,
        tolerance_db: f64,
        control: &Control<'_>,
    ) -> Result<MachineResult, MachineError> {
        let (mut reasons, mut of_full) = (Vec::new(), None);
        let is_leaner = lean.left_out.len() > self.left_out.len();
        let tried: Vec<_> =
            ReducedLevel::TRIED.into_iter().map(Some).chain(if is_leaner { Some(None) } else { None }).collect();
        let share = TRIAL_SHARE / tried.len() as f64;
        for (place, level) in tried.into_iter().enumerate() {
            let part = (place as f64 * share, (place + 1) as f64 * share);
            let trial = control.part(part, |control| self.verify(lean, level, settings, &mut of_full, control));
            let not_eligible = |reason: String| {
                let level = level.map_or(ModelLevel::Full, ReducedLevel::level);
                let without = lean.left_out.iter().map(|omitted| omitted.term).collect();
                MachineWarning::LevelNotEligible { model: LeanModel { level, without }, reason }
            };
            reasons.push(match trial {
                Err(stopped @ MachineError::Stopped(_)) => return Err(stopped),
                Err(MachineError::NotApplicable { reason, .. }) => not_eligible(reason.to_string()),
                Err(error) => not_eligible(error.to_string()),
                Ok(result) if result.accuracy.model.as_ref().is_none_or(|model| model.largest().is_none()) => {
                    not_eligible("nothing vibrates in the time that is compared with full".to_owned())
                }
                Ok(mut result) => match result.beyond(tolerance_db) {
                    None => {
                        result.warnings.retain(|warning| !matches!(warning, MachineWarning::ModelNotConfirmed(_)));
                        result.warnings.append(&mut reasons);
                        return Ok(result);
                    }
                    Some(deviation) => MachineWarning::LevelRejected(deviation),
                },
            });
        }
        let mut result = control.part((TRIAL_SHARE, 1.0), |control| self.result(settings, control))?;
        result.warnings.append(&mut reasons);
        Ok(result)
    }
}
