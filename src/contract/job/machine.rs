//! A machine job: a shaft on ball bearings in time.

use raceway_core::machine::channel::MachineChannel;
use raceway_core::machine::input::{Machine, MachineBearing, MachineSettings, RANGE};
use raceway_core::physics::operation::SpeedProfile;
use raceway_core::simulation::recording::sampling::RATE;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;

use super::kind::JobKind;
use super::simulation::{Submission, check_labels};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::given_fields::given_fields;
use crate::contract::json::numbers::short;
use crate::contract::json::problem::{FieldError, Refusal};
use crate::contract::json::shapes::{object, whole_number};
use crate::contract::json::typed::typed_with_errors;
use crate::contract::json::units::{DEG, US};
use crate::contract::scene::rotor_scene::{ResolvedRotor, RotorSceneInput, refuse_unsupported};
use crate::contract::scene::scene_input::ResolvedScene;

/// Recorded time by default [s].
const DURATION_S: f64 = 0.2;
/// Angle between the first balls of one bearing and the next [°]: the golden angle, so that no ball passages coincide.
const NEXT_AZIMUTH_DEG: f64 = 137.5;
/// Most values of all channels: they take 256 MB.
const MAX_VALUES: f64 = 3.2e7;

/// A machine job: a flexible shaft on ball bearings in time. Balls and cages of all bearings move with all their forces, the shaft by
/// its modes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = MachineJob)]
pub struct MachineInput {
    /// What the job computes: `machine`.
    #[schema(pattern = "^machine$")]
    pub kind: String,
    /// The shaft on its bearings. A `rotor` job takes the same scene.
    #[serde(deserialize_with = "object")]
    pub scene: RotorSceneInput,
    /// Recorded time, after settling [s]. Default 0.2.
    #[schema(nullable = false, example = 0.2)]
    pub duration_s: Option<f64>,
    /// Time simulated before recording begins [s]. Default: until the slowest motion of shaft and bearings has decayed to a fiftieth, and
    /// at least three turns of the cages; at most 5.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.1)]
    pub settle_s: Option<f64>,
    /// Step [µs]. Default: the longest whose levels a run in half steps confirms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 5.0)]
    pub step_us: Option<f64>,
    /// Highest frequency of the kept modes of the shaft over 20 kHz, the band of the levels [-]. Default 1.5.
    #[schema(nullable = false, example = 1.5)]
    pub mode_range: Option<f64>,
    /// Labels to find the job by: at most 16, each at most 200 characters.
    #[schema(nullable = false, max_items = 16, example = json!(["line 3"]))]
    pub labels: Option<Vec<String>>,
    /// Priority from 1 (first) to 4 (last). Default 2.
    #[serde(default, deserialize_with = "whole_number::<_, 1, 4>")]
    #[schema(nullable = false, example = 2)]
    pub priority: Option<u32>,
    /// Whether the result of an identical finished job may be returned. Default true.
    #[schema(nullable = false)]
    pub reuse: Option<bool>,
    /// Time that the job and its result are kept after its end [s]. Default: set by the service.
    #[schema(nullable = false)]
    pub keep_for_s: Option<f64>,
}

/// A checked machine job.
#[derive(Debug, Clone)]
pub struct MachineJob {
    pub submission: Submission,
    /// The request with all defaults.
    pub input: MachineInput,
    pub machine: Machine,
    pub settings: MachineSettings,
}

/// Everything follows from the input.
impl PartialEq for MachineJob {
    fn eq(&self, other: &Self) -> bool {
        self.submission == other.submission && self.input == other.input
    }
}

impl MachineJob {
    /// The job of a request of this kind.
    pub fn of(request: Value) -> Result<Self, Refusal> {
        let mut defaults = Defaults::default();
        let mut supported = request.clone();
        refuse_unsupported(&mut supported, &mut defaults);
        let (input, mut unread) = typed_with_errors::<MachineInput>(&supported);
        let Some(mut input) = input else {
            unread.append(&mut defaults.errors);
            return Err(Refusal::Invalid { errors: unread });
        };
        let resolved = input.scene.resolve(&mut defaults);
        if input.scene.bearings.as_ref().is_none_or(Vec::is_empty) {
            defaults.refuse(
                "/scene/bearings",
                "required: without ball bearings nothing moves in time; give `kind` `rotor`",
            );
        }
        let machine = machine(&mut input.scene, resolved, &mut defaults);
        let settings = settings(&mut input, machine.as_ref(), &mut defaults);
        let labels = input.labels.clone().unwrap_or_default();
        check_labels(&labels, &mut defaults);
        let priority = defaults.fill("/priority", &mut input.priority, 2);
        defaults.check_of_rotor("/priority", f64::from(priority));
        if let Some(keep) = input.keep_for_s {
            defaults.check_of_rotor("/keep_for_s", keep);
        }
        let mut errors = std::mem::take(&mut defaults.errors);
        errors.retain(|error: &FieldError| !unread.iter().any(|unread| unread.concerns(&error.pointer)));
        errors.splice(0..0, unread);
        let machine = match (machine, errors.is_empty()) {
            (Some(machine), true) => machine,
            _ => return Err(Refusal::Invalid { errors }),
        };
        let submission = Submission {
            request,
            labels,
            priority: u8::try_from(priority).unwrap_or(2),
            reuse: input.reuse.unwrap_or(true),
            keep_for_s: input.keep_for_s,
        };
        Ok(Self { submission, input, machine, settings })
    }

    /// The job with all defaults, without the fields that concern only the service.
    pub fn complete(&self) -> Value {
        let mut job = json!({
            "kind": JobKind::Machine.name(),
            "scene": given_fields(&self.input.scene),
            "duration_s": self.input.duration_s,
            "mode_range": self.input.mode_range,
        });
        for (field, value) in [("settle_s", self.input.settle_s), ("step_us", self.input.step_us)] {
            if let Some(value) = value {
                job[field] = value.into();
            }
        }
        job
    }
}

/// The machine in SI; `None` after errors in its bearings or its speed.
fn machine(scene: &mut RotorSceneInput, resolved: ResolvedRotor, defaults: &mut Defaults) -> Option<Machine> {
    let ResolvedRotor { rotor, scenes, sensors, .. } = resolved;
    let inputs = scene.bearings.as_deref_mut().unwrap_or_default();
    if inputs.len() != scenes.len() {
        return None;
    }
    let mut bearings = Vec::with_capacity(inputs.len());
    for (index, (input, ResolvedScene { input: filled, scene, .. })) in inputs.iter_mut().zip(scenes).enumerate() {
        (input.lubricant, input.surfaces) = (filled.lubricant, filled.surfaces);
        let usual = NEXT_AZIMUTH_DEG * index as f64 % 360.0;
        let pointer = format!("/scene/bearings/{index}/start_azimuth_deg");
        let azimuth = DEG.to_si(defaults.fill(pointer, &mut input.start_azimuth_deg, usual));
        bearings.push(MachineBearing { name: input.name.clone(), scene, start_azimuth: azimuth });
    }
    let speed = SpeedProfile::constant(rotor.speed).ok()?;
    Some(Machine { rotor, bearings, speed, sensors })
}

/// Times and accuracy of the run. Errors are noted in `defaults`.
fn settings(input: &mut MachineInput, machine: Option<&Machine>, defaults: &mut Defaults) -> MachineSettings {
    let duration = defaults.fill("/duration_s", &mut input.duration_s, DURATION_S);
    let range = defaults.fill("/mode_range", &mut input.mode_range, RANGE);
    defaults.check_of_rotor("/mode_range", range);
    for (pointer, value) in [("/settle_s", input.settle_s), ("/step_us", input.step_us)] {
        if let Some(value) = value {
            defaults.check_of_rotor(pointer, value);
        }
    }
    if let Some(machine) = machine.filter(|_| defaults.check_of_rotor("/duration_s", duration)) {
        let channels = MachineChannel::all(machine).len() as f64;
        if duration * RATE * channels > MAX_VALUES {
            let (longest, given) = (short(MAX_VALUES / (RATE * channels)), short(duration));
            defaults.refuse("/duration_s", format!("{given} s: at most {longest} s with {channels} channels"));
        }
    }
    MachineSettings { settle: input.settle_s, duration, step: input.step_us.map(|step| US.to_si(step)), range }
}
