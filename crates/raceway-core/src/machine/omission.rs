//! Which terms of the system around the bearings a run leaves out.

use super::channel::MachineChannel;
use super::frame::mesh;
use super::input::{Machine, MachineError, Sensor};
use super::settings::MachineSettings;
use super::terms::OmittedTerm;
use crate::rotor::input::Rotor;
use crate::rotor::level_change::Responses;
use crate::rotor::omission::SystemTerm;
use crate::simulation::input::scene::TermChoice;
use crate::simulation::model::terms::Justification;

/// True if sensors, or signals that are asked for, are of a term.
fn is_recorded(machine: &Machine, settings: &MachineSettings, term: SystemTerm) -> bool {
    if term == SystemTerm::Housing && machine.sensors.iter().any(Sensor::concerns_housing) {
        return true;
    }
    settings.series.iter().any(|channel| match channel {
        MachineChannel::Body(..) => term == SystemTerm::Housing,
        MachineChannel::Tilt(..) | MachineChannel::Moment(..) => term == SystemTerm::Tilt,
        _ => false,
    })
}

/// The terms that are off, and those that may be left out because they change the vibration by no more than a tolerance [dB].
pub(super) fn omitted(
    machine: &Machine,
    settings: &MachineSettings,
    tolerance_db: Option<f64>,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<OmittedTerm>, MachineError> {
    let complete = machine.complete.as_deref().unwrap_or(&machine.rotor);
    let is_candidate = |term: &SystemTerm| match machine.terms.of(*term) {
        TermChoice::Off => complete.has(*term),
        TermChoice::Auto => {
            tolerance_db.is_some() && machine.rotor.has(*term) && !is_recorded(machine, settings, *term)
        }
        TermChoice::On => false,
    };
    let mut candidates = SystemTerm::ALL.into_iter().filter(is_candidate).peekable();
    if candidates.peek().is_none() {
        return Ok(Vec::new());
    }
    let (sensors, speed) = (&machine.sensors, machine.speed.largest());
    let on_mesh = mesh(complete, sensors, settings.range, stop)?;
    let responses = |rotor: &Rotor| {
        Responses::of(rotor, sensors, on_mesh.clone(), speed, stop).map_err(|_| MachineError::Stopped(0.0))
    };
    let of_complete = responses(complete)?;
    let of_rotor = if machine.complete.is_some() { responses(&machine.rotor)? } else { of_complete.clone() };
    let mut omitted = Vec::new();
    for term in candidates {
        let (by, rotor, with) = match machine.terms.of(term) {
            TermChoice::Off => (Justification::Convention, complete, &of_complete),
            _ => (Justification::Judgement, &machine.rotor, &of_rotor),
        };
        let without = responses(&rotor.clone().without(term))?;
        let change = with.as_ref().zip(without).map(|(with, without)| with.change(&without));
        let change_db = change.filter(|change| change.is_finite());
        let is_small = || change_db.zip(tolerance_db).is_some_and(|(change, tolerance)| change <= tolerance);
        if by == Justification::Convention || is_small() {
            omitted.push(OmittedTerm { term, by, change_db });
        }
    }
    Ok(omitted)
}
