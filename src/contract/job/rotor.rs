//! A rotor job: natural frequencies, critical speeds and responses of a shaft on its supports.

use raceway_core::machine::terms::OmittedTerm;
use raceway_core::physics::operation::RingRotation;
use raceway_core::rotor::input::{Request, Rotor};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;

use super::kind::JobKind;
use super::shaft_draft::{ShaftDraft, ShaftRequest};
use super::submission::{ServiceFields, Submission};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::given_fields::given_fields;
use crate::contract::json::numbers::{short, significant};
use crate::contract::json::problem::Refusal;
use crate::contract::json::shapes::{object, whole_number};
use crate::contract::json::units::RPM;
use crate::contract::json::uploads::Uploads;
use crate::contract::scene::rotor_scene::{ResolvedRotor, RotorSceneInput};

/// Default number of natural frequencies, and of speeds.
const MODES: u32 = 8;
const SPEEDS: usize = 50;
const MAX_SPEEDS: usize = 1000;

/// A rotor job: natural frequencies and damping over speed, critical speeds, response to unbalance, static deflection. Linear; a result
/// takes milliseconds, which is why `POST /v1/rotor` also answers at once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = RotorJob)]
pub struct RotorInput {
    /// Kind of the computation: `rotor`.
    pub kind: String,
    /// The shaft on its supports.
    #[serde(deserialize_with = "object")]
    pub scene: RotorSceneInput,
    /// Speeds of the Campbell diagram and of the unbalance response [r/min], rising: a list, or a range. Critical speeds are given up
    /// to the highest. Default: 50 from 0 to 1.5 times the operating speed.
    #[schema(nullable = false)]
    pub speeds_rpm: Option<SpeedsInput>,
    /// Number of natural frequencies, the lowest at the first speed. Default 8.
    #[serde(default, deserialize_with = "whole_number::<_, 1, 20>")]
    #[schema(nullable = false, example = 8)]
    pub modes: Option<u32>,
    /// Labels to find the job by: at most 16, each at most 200 characters.
    #[schema(nullable = false, max_items = 16, example = json!(["line 3"]))]
    pub labels: Option<Vec<String>>,
    /// Priority from 1 (first) to 4 (last). Default 2.
    #[serde(default, deserialize_with = "whole_number::<_, 1, 4>")]
    #[schema(nullable = false, example = 2)]
    pub priority: Option<u32>,
    /// True if the result of an identical finished job may be returned. Default true.
    #[schema(nullable = false)]
    pub reuse: Option<bool>,
    /// Time that the job and its result are kept after its end [s]. Default: set by the service.
    #[schema(nullable = false)]
    pub keep_for_s: Option<f64>,
}

/// Speeds as a list of at most 1000, or as a range.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum SpeedsInput {
    /// Speeds [r/min].
    List(Vec<f64>),
    Range(SpeedRangeInput),
}

/// Equally spaced speeds, both ends included.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedRangeInput {
    /// First speed [r/min].
    #[schema(example = 0.0)]
    pub from: f64,
    /// Last speed [r/min], above the first.
    #[schema(example = 30000.0)]
    pub to: f64,
    /// Number of speeds. Default 50.
    #[serde(default, deserialize_with = "whole_number::<_, 2, 1000>")]
    #[schema(nullable = false, example = 50)]
    pub count: Option<u32>,
}

impl<'de> Deserialize<'de> for SpeedsInput {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = SpeedsInput;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a list of speeds or a range with `from` and `to`")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<SpeedsInput, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(list)).map(SpeedsInput::List)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<SpeedsInput, A::Error> {
                SpeedRangeInput::deserialize(MapAccessDeserializer::new(map)).map(SpeedsInput::Range)
            }
        }
        deserializer.deserialize_any(Either)
    }
}

impl ShaftRequest for RotorInput {
    fn scene(&mut self) -> &mut RotorSceneInput {
        &mut self.scene
    }

    fn service(&mut self) -> ServiceFields<'_> {
        let Self { labels, priority, reuse, keep_for_s, .. } = self;
        ServiceFields { labels, priority, reuse: *reuse, keep_for_s: *keep_for_s }
    }
}

/// A checked rotor job.
#[derive(Debug, Clone)]
pub struct RotorJob {
    pub submission: Submission,
    /// The request with all defaults.
    pub input: RotorInput,
    pub rotor: Rotor,
    pub request: Request,
    /// The requested speeds [r/min].
    pub speeds_rpm: Vec<f64>,
    /// Terms that `rotor` is without because they are off.
    pub omitted: Vec<OmittedTerm>,
}

/// Everything follows from the input.
impl PartialEq for RotorJob {
    fn eq(&self, other: &Self) -> bool {
        self.submission == other.submission && self.input == other.input
    }
}

impl RotorJob {
    /// The job of a request of this kind.
    pub fn of(request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let mut draft = ShaftDraft::<RotorInput>::of(request, uploads)?;
        let (input, defaults) = (&mut draft.input, &mut draft.defaults);
        let speeds_rpm = speeds(input, draft.resolved.speed.largest(), defaults);
        let modes = defaults.fill("/modes", &mut input.modes, MODES);
        defaults.check_of_rotor("/modes", f64::from(modes));
        let (submission, input, resolved) = draft.finish()?;
        let omitted = resolved.omitted();
        let ResolvedRotor { rotor, elements, speed, outer_speed, sensors, .. } = resolved;
        let rotor = rotor.at_speeds(RingRotation { inner: speed, outer: outer_speed }.operating());
        let speeds = speeds_rpm.iter().map(|rpm| RPM.to_si(*rpm)).collect();
        let request = Request { elements, speeds, modes: modes as usize, sensors };
        Ok(Self { submission, input, rotor, request, speeds_rpm, omitted })
    }

    /// The job with all defaults, without the fields that concern only the service.
    pub fn complete(&self) -> Value {
        json!({
            "kind": JobKind::Rotor.name(),
            "scene": given_fields(&self.input.scene),
            "speeds_rpm": self.speeds_rpm,
            "modes": self.request.modes,
        })
    }
}

/// The speeds of the request, or the default by the operating speed [rad/s], in r/min. Errors are noted in `defaults`.
fn speeds(input: &mut RotorInput, operating: f64, defaults: &mut Defaults) -> Vec<f64> {
    const POINTER: &str = "/speeds_rpm";
    let operating = significant(RPM.to_user(operating), 12);
    let usual = match operating > 0.0 {
        true => SpeedsInput::Range(SpeedRangeInput { from: 0.0, to: significant(1.5 * operating, 9), count: None }),
        false => SpeedsInput::List(vec![0.0]),
    };
    match defaults.fill(POINTER, &mut input.speeds_rpm, usual) {
        SpeedsInput::List(list) => {
            if list.is_empty() || list.len() > MAX_SPEEDS {
                defaults.refuse(POINTER, format!("{} speeds: must be from 1 to {MAX_SPEEDS}", list.len()));
            }
            for (index, speed) in list.iter().enumerate() {
                let pointer = format!("{POINTER}/{index}");
                let is_inside = defaults.check_of_rotor(&pointer, *speed);
                if is_inside && index > 0 && list[index - 1] >= *speed {
                    let detail = format!("{} r/min: must be above the speed before it", short(*speed));
                    defaults.refuse(pointer, detail);
                }
            }
            list
        }
        SpeedsInput::Range(SpeedRangeInput { from, to, count }) => {
            let count = count.map_or(SPEEDS, |count| count as usize);
            let fields = [("from", from), ("to", to), ("count", count as f64)];
            let inside = fields.map(|(name, value)| defaults.check_of_rotor(&format!("{POINTER}/{name}"), value));
            if inside[0] && inside[1] && to <= from {
                defaults.refuse(format!("{POINTER}/to"), format!("{} r/min: must be above `from`", short(to)));
            }
            let last = (count.clamp(2, MAX_SPEEDS) - 1) as f64;
            (0..count.clamp(2, MAX_SPEEDS)).map(|k| significant(from + (to - from) * k as f64 / last, 12)).collect()
        }
    }
}
