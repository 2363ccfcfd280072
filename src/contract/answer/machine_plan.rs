//! A machine before it runs: all defaults, what follows of each bearing, first step and estimated cost.

use raceway_core::machine::cost::{MachinePlan, plan};
use raceway_core::machine::input::{Machine, MachineBearing, MachineError};
use raceway_core::physics::kinematics::{RingSpeeds, ideal_frequencies};
use raceway_core::physics::rating::dynamic_load_rating;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::ordered::{self, ClearanceAnswer, DesignationAnswer, OilAnswer};
use super::report::{FrequenciesAnswer, LeftOutAnswer};
use crate::contract::job::cost::CostAnswer;
use crate::contract::job::machine::{MachineInput, MachineJob};
use crate::contract::json::numbers::significant;
use crate::contract::json::problem::FieldError;
use crate::contract::json::units::{DEG, UM, US};
use crate::contract::scene::scene_input::ResolvedScene;

/// The response of `POST /v1/machine/resolve`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MachinePlanAnswer {
    /// The job with all defaults filled in; sent again, it gives the same work.
    #[schema(value_type = MachineInput)]
    pub job: Value,
    /// Pointers to the fields of the job that got their default. Those inside a bearing are not among them.
    #[schema(example = json!(["/duration_s"]))]
    pub defaults: Vec<String>,
    /// Derived numbers of each bearing, in their order.
    pub bearings: Vec<PlannedBearingAnswer>,
    /// Number of coordinates of shaft and housing: rigid motions, modes and residual vectors.
    pub coordinates: u64,
    /// Terms of shaft and housing that are off, and with `solver.model_tolerance_db` those that a leaner model leaves out, which the run tries.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOutAnswer>,
    /// Time simulated before recording begins [s].
    #[schema(minimum = 0)]
    pub settle_s: f64,
    /// First step that is tried [µs]. It is halved where half steps change a level by more than 0.1 dB.
    #[schema(minimum = 0)]
    pub step_us: f64,
    /// Estimated cost of the job.
    pub cost: CostAnswer,
    /// Fields whose values deserve a second look; they do not prevent the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<FieldError>,
}

/// Derived numbers of a bearing before the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PlannedBearingAnswer {
    /// Name in the job.
    pub name: String,
    /// Basic dynamic load rating by the table of f_c of ISO 281 [N].
    #[schema(minimum = 0)]
    pub dynamic_load_rating_n: f64,
    /// Free contact angle [°].
    #[schema(minimum = 0)]
    pub free_contact_angle_deg: f64,
    /// Diametral radial clearance in operation [µm]; negative: a radial preload.
    pub radial_clearance_um: f64,
    /// Characteristic frequencies of ideal rolling at the speed at time 0 and the free contact angle, 0 for a deep-groove bearing.
    pub frequencies_hz: FrequenciesAnswer,
    /// The bearing of the catalogue; absent where no designation is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub designation: Option<DesignationAnswer>,
    /// How the clearance follows from its group; absent where no group is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub clearance: Option<ClearanceAnswer>,
    /// The oil; absent where neither grade nor kinematic viscosities are given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub oil: Option<OilAnswer>,
}

impl MachinePlanAnswer {
    /// Plans a machine job. `stop` is polled; true ends the analysis.
    pub fn of(job: &MachineJob, stop: &dyn Fn() -> bool) -> Result<Self, MachineError> {
        let MachinePlan { coordinates, states, settle, step, omitted, wall_time: (likely, most) } =
            plan(&job.machine, &job.settings, job.level, stop)?;
        let bearings = job.machine.bearings.iter().zip(&job.scenes);
        Ok(Self {
            job: job.complete(),
            defaults: job.defaults.clone(),
            bearings: bearings.enumerate().map(|(index, of)| planned(index, of, &job.machine)).collect(),
            coordinates: coordinates as u64,
            left_out: omitted.iter().map(LeftOutAnswer::from).collect(),
            settle_s: significant(settle, 4),
            step_us: US.to_user(step),
            cost: CostAnswer {
                states: states as u64,
                estimated_wall_time_s: Some(significant(likely, 2)),
                most_wall_time_s: Some(significant(most, 2)),
                ..CostAnswer::default()
            },
            warnings: job.scenes.iter().enumerate().flat_map(|(index, scene)| of_bearing(index, scene)).collect(),
        })
    }
}

/// Warnings of a bearing, with their place in the job.
fn of_bearing(index: usize, scene: &ResolvedScene) -> impl Iterator<Item = FieldError> {
    let place = format!("/scene/bearings/{index}");
    ordered::warnings(scene).into_iter().map(move |warning| {
        let field = warning.pointer.trim_start_matches("/scene").to_owned();
        FieldError::new(format!("{place}{field}"), warning.detail)
    })
}

fn planned(
    index: usize,
    (MachineBearing { name, .. }, scene): (&MachineBearing, &ResolvedScene),
    machine: &Machine,
) -> PlannedBearingAnswer {
    let bearing = &scene.scene.bearing;
    let speeds = RingSpeeds { inner: machine.speed.at(0.0).1, outer: machine.outer_speed.at(0.0).1 };
    PlannedBearingAnswer {
        name: name.clone(),
        dynamic_load_rating_n: dynamic_load_rating(bearing),
        free_contact_angle_deg: DEG.to_user(bearing.free_contact_angle),
        radial_clearance_um: UM.to_user(bearing.radial_clearance),
        frequencies_hz: ideal_frequencies(bearing, speeds).into(),
        designation: DesignationAnswer::of(scene).map(|designation| designation.of_item(index)),
        clearance: scene.ordered.clearance.as_ref().map(ClearanceAnswer::from),
        oil: scene.ordered.oil.as_ref().map(OilAnswer::from),
    }
}
