//! Terms of the system around the bearings that a scene switches on or off.

use raceway_core::machine::terms::SystemTerms;
use raceway_core::rotor::omission::SystemTerm;
use raceway_core::rotor::sensor::Sensor;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::terms::TermChoiceName;
use crate::contract::json::defaults::Defaults;

const POINTER: &str = "/scene/terms";

/// A choice for each term of the system around the bearings. `on`: always included. `off`: never; `left_out` of the result bounds the change of a
/// place, all directions together, by the linear analysis. `auto`, the default: included, unless `solver.model_tolerance_db` of a `machine` job is above 0 and that
/// bound is no larger.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = SystemTerms)]
pub struct SystemTermsInput {
    /// Bending of the shaft, and its strain along X. Without it the shaft is rigid.
    #[schema(nullable = false)]
    pub shaft_bending: Option<TermChoiceName>,
    /// Tilt of the rings against each other, and the moments of the balls against it. Without it each bearing is a hinge.
    #[schema(nullable = false)]
    pub tilt: Option<TermChoiceName>,
    /// Gyroscopic moments of shaft and discs. Those of the balls remain.
    #[schema(nullable = false)]
    pub gyroscopic: Option<TermChoiceName>,
    /// Motion of the housing. Without it outer rings and supports stand on the ground, each on its own seat.
    #[schema(nullable = false)]
    pub housing: Option<TermChoiceName>,
}

impl SystemTermsInput {
    /// The choices.
    pub fn resolve(&mut self, defaults: &mut Defaults) -> SystemTerms {
        let Self { shaft_bending, tilt, gyroscopic, housing } = self;
        let mut terms = SystemTerms::default();
        for (term, field) in SystemTerm::ALL.into_iter().zip([shaft_bending, tilt, gyroscopic, housing]) {
            let pointer = format!("{POINTER}/{}", term.name());
            terms.set(term, defaults.fill(pointer, field, TermChoiceName::Auto).into());
        }
        terms
    }
}

/// Refuses a housing without motion where a sensor is on it.
pub fn check_sensors(terms: &SystemTerms, sensors: &[Sensor], defaults: &mut Defaults) {
    let is_off = terms.off().any(|term| term == SystemTerm::Housing);
    if let Some(sensor) = sensors.iter().find(|sensor| sensor.concerns_housing()).filter(|_| is_off) {
        let detail = format!("`off` leaves no motion of the housing to sensor `{}`", sensor.name);
        defaults.refuse(format!("{POINTER}/{}", SystemTerm::Housing.name()), detail);
    }
}
