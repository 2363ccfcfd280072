//! First step and expected time of a machine before it runs.

use super::equations::MachineDynamics;
use super::input::{Machine, MachineBearing, MachineError};
use super::level::{LevelChoice, ReducedLevel};
use super::omission::omitted;
use super::run::{first_step, settling_time, times};
use super::settings::MachineSettings;
use super::terms::OmittedTerm;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::solve::cost::fixed_step_time;

/// Time of a coordinate in a step, recording included [s], and time of a bearing on a reduced level over that on `full` [-]. `benches/modes/cost.py`
/// counts the instructions; a core runs some 2·10⁹ of them a second.
const SECONDS_PER_COORDINATE: f64 = 0.1e-6;
const REDUCED: f64 = 0.3;
/// Work of all attempts over that of the first where the step is halved twice [-].
const TWICE_HALVED: f64 = 7.0;

/// A run before it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct MachinePlan {
    /// Coordinates of shaft and housing.
    pub coordinates: usize,
    /// First-order states on `full`.
    pub states: usize,
    /// Time before the record [s].
    pub settle: f64,
    /// First step that is tried [s].
    pub step: f64,
    /// Terms of the system around the bearings that are off, and those that a lean model leaves out.
    pub omitted: Vec<OmittedTerm>,
    /// Likely wall time on one core, with the verification, and that with twice halved steps and all levels [s].
    pub wall_time: (f64, f64),
}

/// The plan of a machine on a level. `stop` is polled; true ends the analysis.
pub fn plan(
    machine: &Machine,
    settings: &MachineSettings,
    level: LevelChoice,
    stop: &dyn Fn() -> bool,
) -> Result<MachinePlan, MachineError> {
    let full = MachineDynamics::new(machine, settings.range, stop)?;
    let settle = settings.settle.unwrap_or_else(|| settling_time(&full));
    let [duration, window] = times(machine, settings);
    let coordinates = full.frame.len();
    let of_coordinates = coordinates as f64 * SECONDS_PER_COORDINATE;
    let of_bearing = |bearing: &MachineBearing| {
        let terms = ActiveTerms::of(&bearing.scene, &Outputs::vibration(), Some(ModelLevel::Full)).ok()?;
        Some(fixed_step_time(bearing.scene.bearing.parameters.ball_count, &terms.raceway))
    };
    let of_bearings: f64 = machine.bearings.iter().filter_map(of_bearing).sum();
    let runs = |step: f64, of_bearings: f64| {
        let steps = (settle + duration) / step + 2.0 * (settle + window) / step;
        steps * (of_bearings + of_coordinates)
    };
    let step_of = |dynamics: &MachineDynamics| settings.step.unwrap_or_else(|| first_step(dynamics));
    let on_full = (step_of(&full), runs(step_of(&full), of_bearings));
    // A reduced level is compared with a run on `full`.
    let compared = (settle + window) / first_step(&full) * (of_bearings + of_coordinates);
    let reduced = |level: ReducedLevel| {
        let step = step_of(&full.clone().reduced_to(level, machine)?);
        Ok::<_, MachineError>((step, runs(step, REDUCED * of_bearings)))
    };
    let (step, likely, all) = match level {
        LevelChoice::Full => (on_full.0, on_full.1, TWICE_HALVED * on_full.1),
        LevelChoice::Reduced(level) => {
            let (step, time) = reduced(level)?;
            (step, time + compared, TWICE_HALVED * time + compared)
        }
        LevelChoice::Within(_) => {
            let tried: Vec<(f64, f64)> =
                ReducedLevel::TRIED.into_iter().filter_map(|level| reduced(level).ok()).collect();
            let all = tried.iter().map(|(_, time)| time).sum::<f64>() + compared + TWICE_HALVED * on_full.1;
            match tried.first() {
                None => (on_full.0, on_full.1, all),
                Some((step, time)) => (*step, time + compared, all),
            }
        }
    };
    let omitted = omitted(machine, settings, level.tolerance_db(), stop)?;
    Ok(MachinePlan { coordinates, states: full.states(), settle, step, omitted, wall_time: (likely, all) })
}
