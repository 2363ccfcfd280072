//! Loads before a run: what acts at the start, how far each load changes, and until when.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::units::US;
use raceway_core::physics::loads::{
    Load, LoadCourse, LoadDirection, SpindleLoad, VaryingLoads, start_and_largest_change,
};
use raceway_core::simulation::input::scene::Scene;

/// A load of `operation.loads`. A run starts in equilibrium with the loads at the start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LoadAnswer {
    /// `constant`, `points`, `harmonic`, `rotating`, `shock` or `series`.
    pub kind: String,
    /// `x`, `y`, `z`, `about_y`, `about_z`; `y, z` of a rotating load.
    pub direction: String,
    /// Unit of `at_start` and `largest_change`: `N` or `N·m`.
    pub unit: String,
    /// Load at the start; of a harmonic or rotating load the mean, 0.
    pub at_start: f64,
    /// Largest difference from the load at the start.
    #[schema(minimum = 0)]
    pub largest_change: f64,
    /// Frequency of a harmonic or rotating load at the largest speed [Hz]. Lines there have the label `load`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub frequency_hz: Option<f64>,
    /// Time of the last change of a load that does not repeat [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub end_s: Option<f64>,
    /// Longest step that resolves the load [µs].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub longest_step_us: Option<f64>,
}

/// The loads of a scene beside its constant forces.
pub fn loads(scene: &Scene) -> Vec<LoadAnswer> {
    let speed = scene.operation.speed.largest();
    scene.operation.loads.iter().map(|load| answer(load, speed)).collect()
}

fn answer(load: &Load, speed: f64) -> LoadAnswer {
    let (direction, unit) = match load.direction() {
        None => ("y, z", "N"),
        Some(LoadDirection::X) => ("x", "N"),
        Some(LoadDirection::Y) => ("y", "N"),
        Some(LoadDirection::Z) => ("z", "N"),
        Some(LoadDirection::AboutY) => ("about_y", "N·m"),
        Some(LoadDirection::AboutZ) => ("about_z", "N·m"),
    };
    let kind = match load {
        Load::Along(_, LoadCourse::Constant(_)) => "constant",
        Load::Along(_, LoadCourse::Points(_)) => "points",
        Load::Along(_, LoadCourse::Harmonic(_)) => "harmonic",
        Load::Along(_, LoadCourse::Shock(_)) => "shock",
        Load::Along(_, LoadCourse::Samples(_)) => "series",
        Load::Rotating(_) => "rotating",
    };
    let (start, change) = start_and_largest_change(std::slice::from_ref(load));
    let step = VaryingLoads::of(std::slice::from_ref(load), speed).map(|varying| varying.longest_fixed_step());
    // Its one direction, or the equal ones of a rotating load.
    let own = |of: SpindleLoad| load.direction().map_or(of[1], |direction| of[direction as usize]);
    LoadAnswer {
        kind: kind.to_owned(),
        direction: direction.to_owned(),
        unit: unit.to_owned(),
        at_start: own(start),
        largest_change: own(change),
        frequency_hz: load.harmonic().map(|harmonic| harmonic.frequency(speed)),
        end_s: load.end(),
        longest_step_us: step.filter(|step| step.is_finite()).map(|step| US.to_user(step)),
    }
}
