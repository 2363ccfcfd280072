//! Which terms of the system around the bearings a run leaves out.

use super::channel::MachineChannel;
use super::frame::mesh;
use super::input::{Machine, MachineError};
use super::settings::MachineSettings;
use super::terms::OmittedTerm;
use crate::rotor::level_change::Responses;
use crate::rotor::omission::SystemTerm;
use crate::simulation::input::scene::TermChoice;
use crate::simulation::model::terms::Justification;

/// Whether signals that are asked for are of a term.
fn is_recorded(settings: &MachineSettings, term: SystemTerm) -> bool {
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
        TermChoice::Auto => tolerance_db.is_some() && machine.rotor.has(*term) && !is_recorded(settings, *term),
        TermChoice::On => false,
    };
    let mut candidates = SystemTerm::ALL.into_iter().filter(is_candidate).peekable();
    if candidates.peek().is_none() {
        return Ok(Vec::new());
    }
    let (mesh, count) = mesh(complete, &machine.sensors, settings.range, stop)?;
    let responses = |rotor| Responses::of(&rotor, &machine.sensors, mesh.clone(), count, machine.speed.largest());
    let of_complete = responses(complete.clone());
    let of_rotor = machine.complete.as_ref().map_or_else(|| of_complete.clone(), |_| responses(machine.rotor.clone()));
    let mut omitted = Vec::new();
    for term in candidates {
        if stop() {
            return Err(MachineError::Stopped(0.0));
        }
        let (by, rotor, with) = match machine.terms.of(term) {
            TermChoice::Off => (Justification::Convention, complete, &of_complete),
            _ => (Justification::Judgement, &machine.rotor, &of_rotor),
        };
        let change =
            with.as_ref().zip(responses(rotor.clone().without(term))).map(|(with, without)| with.change(&without));
        let change_db = change.filter(|change| change.is_finite());
        let is_small = || change_db.zip(tolerance_db).is_some_and(|(change, tolerance)| change <= tolerance);
        if by == Justification::Convention || is_small() {
            omitted.push(OmittedTerm { term, by, change_db });
        }
    }
    Ok(omitted)
}
