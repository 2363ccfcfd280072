//! An accuracy job of a shaft: several numbers of modes for one machine.

use raceway_core::machine::channel::MachineChannel;
use raceway_core::machine::input::Machine;
use raceway_core::machine::mode_precision::ModePlan;
use raceway_core::physics::frame::shaft::ShaftMotion;
use serde::Deserialize;
use serde_json::{Value, json};
use utoipa::ToSchema;

use super::kind::JobKind;
use super::machine::{checked_times, machine};
use super::shaft_draft::{ShaftDraft, ShaftRequest};
use super::submission::{ServiceFields, Submission};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::given_fields::given_fields;
use crate::contract::json::limits::MAX_REPETITIONS;
use crate::contract::json::numbers::short;
use crate::contract::json::problem::Refusal;
use crate::contract::json::shapes::{object, whole_number};
use crate::contract::json::units::US;
use crate::contract::json::uploads::Uploads;
use crate::contract::scene::rotor_scene::RotorSceneInput;

/// Default recorded time at a constant speed [s]: it is run many times.
pub const DURATION_S: f64 = 0.1;
/// Default highest frequencies of the kept modes over the band of the levels [-]: those of the runs, and that of the reference.
pub const MODE_RANGES: [f64; 3] = [1.0, 1.5, 2.0];
pub const REFERENCE_RANGE: f64 = 5.0;
/// Most highest frequencies.
const MAX_RANGES: usize = 12;

/// An accuracy job of a shaft: error against run time, for several numbers of modes.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ShaftAccuracyJob)]
pub struct ModeComparisonInput {
    /// Kind of the computation: `accuracy`.
    pub kind: String,
    /// The shaft on its bearings, as of a `machine` job; `shaft` is required.
    #[serde(deserialize_with = "object")]
    pub scene: RotorSceneInput,
    /// Highest frequencies of the kept modes of the shaft over 20 kHz, the band of the levels [-], one run each. Default 1, 1.5 and 2.
    #[schema(nullable = false, min_items = 1, max_items = 12, example = json!([1.0, 1.5, 2.0]))]
    pub mode_ranges: Option<Vec<f64>>,
    /// Highest frequency of the modes of the reference over 20 kHz [-], above those of `mode_ranges`. Default 5.
    #[schema(nullable = false, example = 5.0)]
    pub reference_range: Option<f64>,
    /// Recorded time, after settling [s]. Default 0.1, or up to the last point of a speed profile, at most 10.
    #[schema(nullable = false, example = 0.1)]
    pub duration_s: Option<f64>,
    /// Time simulated before recording begins [s]. Default: as of a `machine` job, equal for all runs.
    #[schema(nullable = false, example = 0.1)]
    pub settle_s: Option<f64>,
    /// Step of the runs [µs]; the reference has half of it. Default: the longest whose levels half steps confirm, with the modes of the reference.
    #[schema(nullable = false, example = 5.0)]
    pub step_us: Option<f64>,
    /// Timed runs of each number of modes. Default 1.
    #[serde(default, deserialize_with = "whole_number::<_, 1, { MAX_REPETITIONS }>")]
    #[schema(nullable = false, example = 3)]
    pub repetitions: Option<u32>,
    /// Labels to find the job by: at most 16, each at most 200 characters.
    #[schema(nullable = false, max_items = 16, example = json!(["line 3"]))]
    pub labels: Option<Vec<String>>,
    /// Priority from 1 (first) to 4 (last). Default 2.
    #[serde(default, deserialize_with = "whole_number::<_, 1, 4>")]
    #[schema(nullable = false, example = 2)]
    pub priority: Option<u32>,
    /// Run times are never reused: `false`, if it is given.
    #[schema(nullable = false)]
    pub reuse: Option<bool>,
    /// Time that the job and its result are kept after its end [s]. Default: set by the service.
    #[schema(nullable = false)]
    pub keep_for_s: Option<f64>,
}

impl ShaftRequest for ModeComparisonInput {
    fn scene(&mut self) -> &mut RotorSceneInput {
        &mut self.scene
    }

    fn service(&mut self) -> ServiceFields<'_> {
        let Self { labels, priority, reuse, keep_for_s, .. } = self;
        ServiceFields { labels, priority, reuse: *reuse, keep_for_s: *keep_for_s }
    }
}

/// A checked accuracy job of a shaft.
#[derive(Debug, Clone)]
pub struct ModeComparison {
    pub submission: Submission,
    /// The request with all defaults.
    pub input: ModeComparisonInput,
    pub machine: Machine,
    pub plan: ModePlan,
}

/// Everything follows from the input.
impl PartialEq for ModeComparison {
    fn eq(&self, other: &Self) -> bool {
        self.submission == other.submission && self.input == other.input
    }
}

impl ModeComparison {
    /// The job of a request of this kind.
    pub fn of(request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let mut draft = ShaftDraft::<ModeComparisonInput>::of(request, uploads)?;
        let (input, defaults) = (&mut draft.input, &mut draft.defaults);
        if input.reuse == Some(true) {
            let detail = "a job of kind `accuracy` measures run time: its result is never reused";
            defaults.refuse("/reuse", detail);
        }
        if draft.resolved.rotor.shaft.motion != ShaftMotion::Bends {
            defaults.refuse("/scene/terms/shaft_bending", "`off` leaves no modes to compare");
        }
        let machine = machine(&mut input.scene, &draft.resolved, defaults);
        let plan = plan(input, machine.as_ref(), defaults);
        let (submission, input, _) = draft.finish()?;
        // Without errors there is one. Without a settling time all speeds are constant.
        let end = plan.settle.map_or(f64::INFINITY, |settle| settle + plan.duration);
        let machine = machine.map(|machine| machine.until(end)).ok_or(Refusal::Invalid { errors: Vec::new() })?;
        Ok(Self { submission, input, machine, plan })
    }

    /// The job with all defaults, without the fields that concern only the service.
    pub fn complete(&self) -> Value {
        let mut job = json!({
            "kind": JobKind::Accuracy.name(),
            "scene": given_fields(&self.input.scene),
            "mode_ranges": self.plan.ranges,
            "reference_range": self.plan.reference_range,
            "duration_s": self.input.duration_s,
            "repetitions": self.plan.repetitions,
        });
        for (field, value) in [("settle_s", self.input.settle_s), ("step_us", self.input.step_us)] {
            if let Some(value) = value {
                job[field] = value.into();
            }
        }
        job
    }
}

/// The runs of the comparison. Errors are noted in `defaults`.
fn plan(input: &mut ModeComparisonInput, machine: Option<&Machine>, defaults: &mut Defaults) -> ModePlan {
    let ranges = defaults.fill("/mode_ranges", &mut input.mode_ranges, MODE_RANGES.to_vec());
    let reference_range = defaults.fill("/reference_range", &mut input.reference_range, REFERENCE_RANGE);
    check_ranges(&ranges, reference_range, defaults);
    let channels = machine.map_or(1, |machine| MachineChannel::all(machine).len());
    let duration = checked_times(&mut input.settle_s, &mut input.duration_s, (DURATION_S, channels), machine, defaults);
    if let Some(step) = input.step_us {
        defaults.check_of_rotor("/step_us", step);
    }
    let repetitions = defaults.fill("/repetitions", &mut input.repetitions, 1);
    defaults.check_of_rotor("/repetitions", f64::from(repetitions));
    ModePlan {
        ranges,
        reference_range,
        settle: input.settle_s,
        duration,
        step: input.step_us.map(|step| US.to_si(step)),
        repetitions: repetitions.clamp(1, MAX_REPETITIONS),
    }
}

fn check_ranges(ranges: &[f64], reference: f64, defaults: &mut Defaults) {
    let reference_is_inside = defaults.check_of_rotor("/reference_range", reference);
    if ranges.is_empty() || ranges.len() > MAX_RANGES {
        defaults.refuse("/mode_ranges", format!("{} ranges: must be from 1 to {MAX_RANGES}", ranges.len()));
        return;
    }
    for (index, range) in ranges.iter().enumerate() {
        let pointer = format!("/mode_ranges/{index}");
        if ranges[..index].contains(range) {
            defaults.refuse(pointer, "given more than once");
        } else if defaults.check_of_rotor(&pointer, *range) && reference_is_inside && *range >= reference {
            let (range, reference) = (short(*range), short(reference));
            defaults.refuse(pointer, format!("{range}: must be below reference_range, {reference}"));
        }
    }
}
