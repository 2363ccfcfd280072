//! Choices for the terms of the system around the bearings, and those that a run leaves out.

use crate::rotor::omission::SystemTerm;
use crate::simulation::input::scene::TermChoice;
use crate::simulation::model::omission::OmissionReason;
use crate::simulation::model::terms::{Justification, LeftOut};

/// A choice for each term of the system around the bearings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SystemTerms([TermChoice; SystemTerm::ALL.len()]);

impl SystemTerms {
    pub fn set(&mut self, term: SystemTerm, choice: TermChoice) {
        self.0[term as usize] = choice;
    }

    pub(super) fn of(&self, term: SystemTerm) -> TermChoice {
        self.0[term as usize]
    }

    pub fn off(&self) -> impl Iterator<Item = SystemTerm> {
        SystemTerm::ALL.into_iter().filter(|term| self.of(*term) == TermChoice::Off)
    }
}

/// A term that a run leaves out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OmittedTerm {
    pub term: SystemTerm,
    pub by: Justification,
    /// Largest change of the vibration of a place by the linear analysis [dB]; `None`: without the term there is no equilibrium, or no motion.
    pub change_db: Option<f64>,
}

impl From<&OmittedTerm> for LeftOut {
    fn from(omitted: &OmittedTerm) -> Self {
        let term = omitted.term.name();
        let reason = match omitted.by {
            Justification::Convention => OmissionReason::SwitchedOff(term),
            _ => OmissionReason::VibrationHardlyChanges,
        };
        Self { term, reason, by: omitted.by, bound: omitted.change_db.map(|change| (change, "dB")) }
    }
}
