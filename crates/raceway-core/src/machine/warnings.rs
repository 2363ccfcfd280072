//! Reasons to doubt the numbers of a run, and what limits its steps.

use super::channel::MachineChannel;
use super::codes::{LastStep, LaterChange, MachineWarning};
use super::equations::MachineDynamics;
use super::input::{Machine, MachineBearing};
use super::result::{BearingMetrics, MachineResult, SignalMetrics};
use crate::physics::contact::hertz::STATIC_PRESSURE_LIMIT;
use crate::simulation::error::thresholds::{MIN_DECAY_EFOLDS, QUIET};
use crate::simulation::solve::startup::SETTLED_EFOLDS;

/// Reasons to doubt the numbers of a run.
pub(super) fn warnings(
    machine: &Machine,
    dynamics: &MachineDynamics,
    result: &MachineResult,
    (allowed_db, last): (f64, LastStep),
) -> Vec<MachineWarning> {
    let of_steps = uncertain(result, allowed_db, last).into_iter().chain(partly_verified(machine, result));
    let of_steps = of_steps.chain(result.beyond(allowed_db).map(MachineWarning::ModelNotConfirmed));
    let start = start_transient(machine, result);
    let is_steady = is_steady(machine, result);
    let trends = if is_steady { not_stationary(result) } else { Vec::new() };
    // Free motion of the start has the same lines, and uneven surfaces have more lines than have labels.
    let is_known = |bearing: &MachineBearing| bearing.scene.surfaces.are_ideal() && !bearing.scene.has_unequal_balls();
    let can_tell = is_steady && start.is_none() && machine.bearings.iter().all(is_known);
    let unnamed = if can_tell { unnamed_line(result) } else { None };
    let bearings = result.bearings.iter().enumerate();
    let overloaded = bearings.filter_map(|(index, metrics)| overloaded(dynamics, index, metrics));
    of_steps
        .chain(start)
        .chain(trends)
        .chain(unnamed)
        .chain(overloaded)
        .chain(open_sides(dynamics))
        .chain(of_surfaces(dynamics))
        .collect()
}

/// Angular-contact bearings that carry thrust at the operating point in the direction in which real ones come apart.
fn open_sides(dynamics: &MachineDynamics) -> impl Iterator<Item = MachineWarning> + '_ {
    // Without bearings there is no operating point.
    let rings = dynamics.frame.system.operating.first().into_iter().flat_map(|point| &point.rings);
    rings.enumerate().filter_map(|(bearing, ring)| {
        ring.thrust_over_open_side().map(|load| MachineWarning::OpenSide { bearing, load })
    })
}

fn of_surfaces(dynamics: &MachineDynamics) -> impl Iterator<Item = MachineWarning> + '_ {
    let bearings = dynamics.bearings.iter().enumerate();
    bearings.flat_map(|(bearing, of)| {
        of.surface_warnings.iter().map(move |warning| MachineWarning::Surface { bearing, warning: warning.clone() })
    })
}

/// Free motion that may remain from the start, by the linear analysis at the first speed.
fn start_transient(machine: &Machine, result: &MachineResult) -> Option<MachineWarning> {
    let (decay, settle) = (-result.growth_rate?, result.settle);
    let constant_speed = machine.speed.is_constant();
    let decay = decay.max(0.0);
    let warning = MachineWarning::StartTransient {
        time_constant: 1.0 / decay,
        settle,
        required: SETTLED_EFOLDS / decay,
        constant_speed,
    };
    (settle * decay < MIN_DECAY_EFOLDS).then_some(warning)
}

/// The level whose error by the steps is largest, if it is too large.
fn uncertain(result: &MachineResult, allowed_db: f64, last: LastStep) -> Option<MachineWarning> {
    let known = result.accuracy.errors.iter().filter_map(|(channel, error)| Some((*channel, (*error)?)));
    let (channel, error_db) = known.max_by(|one, other| one.1.total_cmp(&other.1))?;
    let warning = MachineWarning::Uncertain { channel, error_db, allowed_db, step: result.accuracy.step, last };
    (error_db > allowed_db).then_some(warning)
}

/// A change of speed or load within the record, after the time that was repeated.
fn partly_verified(machine: &Machine, result: &MachineResult) -> Option<MachineWarning> {
    let window = result.accuracy.window;
    let verified = result.settle + window;
    if window >= result.duration {
        return None;
    }
    let shock = |place: usize| machine.rotor.loads[place].load.shock().map(|shock| shock.at);
    let later = ends_of_loads(machine, result).find(|(_, end)| *end > verified);
    let load = later.map(|(place, _)| LaterChange::Load { place, at: shock(place) });
    let turns = !machine.speed.is_constant() && machine.speed.end() > verified;
    let change = load.or(turns.then_some(LaterChange::Speed))?;
    Some(MachineWarning::PartlyVerified { window, change, step: result.accuracy.step })
}

/// True where neither speed nor loads change in the recorded time but periodically.
fn is_steady(machine: &Machine, result: &MachineResult) -> bool {
    let ends = ends_of_loads(machine, result).map(|(_, end)| end);
    let speed_is_steady = machine.speed.is_constant() || machine.speed.end() <= result.settle;
    ends.fold(0.0, f64::max) <= result.settle && speed_is_steady
}

/// Places of the loads that change before the end of the record, each with the time of its last change [s].
fn ends_of_loads<'a>(machine: &'a Machine, result: &MachineResult) -> impl Iterator<Item = (usize, f64)> + 'a {
    let end = result.settle + result.duration;
    let loads = machine.rotor.loads.iter().enumerate();
    loads.filter_map(move |(place, placed)| Some((place, placed.load.until(end).end()?)))
}

/// The accelerations whose levels rise or fall throughout the recorded time.
fn not_stationary(result: &MachineResult) -> Vec<MachineWarning> {
    let change = |(channel, metrics): &(MachineChannel, SignalMetrics)| {
        Some(MachineWarning::NotStationary { channel: *channel, change_db: metrics.trend_db? })
    };
    result.channels.iter().filter_map(change).collect()
}

/// The strongest line of all accelerations, if it has no label. Motion that is quiet or decays is free motion of the start.
fn unnamed_line(result: &MachineResult) -> Option<MachineWarning> {
    let strongest = result.spectra.iter().filter_map(|spectra| Some((spectra.channel, spectra.lines.first()?)));
    let (channel, line) = strongest.max_by(|one, other| one.1.amplitude.total_cmp(&other.1.amplitude))?;
    let decays =
        result.channels.iter().any(|(of, metrics)| *of == channel && metrics.trend_db.is_some_and(|db| db < 0.0));
    let warning = MachineWarning::UnnamedLine { channel, frequency: line.frequency, amplitude: line.amplitude };
    (line.label.is_empty() && line.amplitude >= QUIET && !decays).then_some(warning)
}

/// The largest pressure of a bearing over the recorded time, if it is too large.
fn overloaded(dynamics: &MachineDynamics, bearing: usize, metrics: &BearingMetrics) -> Option<MachineWarning> {
    let raceway = &dynamics.bearings[bearing].dynamics.mechanism().raceway;
    let record = &metrics.record;
    let of = [(&raceway.inner, record.inner_load), (&raceway.outer, record.outer_load)];
    let pressures = of.map(|(contact, load)| (load, contact.hertz().max_pressure(load)));
    let (load, pressure) = pressures.into_iter().max_by(|one, other| one.1.total_cmp(&other.1))?;
    (pressure > STATIC_PRESSURE_LIMIT).then_some(MachineWarning::Overloaded { bearing, load, pressure })
}
