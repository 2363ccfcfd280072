//! Uncertain inputs of every point of a study or an optimum, and the statistic of its metrics over them.

use raceway_core::sampling::design::Design;
use raceway_core::sampling::statistic::Statistic;
use serde_json::{Value, json};

use super::distribution::Sampled;
use super::kind::JobKind;
use super::many_runs::already_varied;
use super::sampled_inputs::inputs;
use super::simulation::Draft;
use super::statistic::{PercentileInput, StatisticInput, in_core};
use super::varied::Varied;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::shapes::NameOr;

/// Samples of each point, and of the best ones of a search when they are repeated.
const SAMPLES: u32 = 32;
pub const REPEATED: usize = 256;
/// The statistic where the request names none.
const PERCENTILE: f64 = 90.0;

/// Uncertain inputs of a study or an optimum.
#[derive(Debug, Clone, PartialEq)]
pub struct Robust {
    pub inputs: Vec<Sampled>,
    pub statistic: Statistic,
    /// The statistic as in the request.
    pub given_statistic: StatisticInput,
    /// Points in the unit cube, the same at every point of the job so that its differences are not those of the draws.
    pub cube: Vec<Vec<f64>>,
    /// More points, for the best ones of a search.
    pub fine: Vec<Vec<f64>>,
    /// The fields `inputs`, `samples`, `seed` and `statistic` with their defaults, as JSON.
    given: Value,
}

impl Robust {
    /// The uncertain part of a request of this kind, whose axes vary these fields; `None` without `inputs`.
    pub fn of<'a>(kind: JobKind, draft: &mut Draft, axes: impl Iterator<Item = &'a Varied> + Clone) -> Option<Self> {
        if draft.input.inputs.is_none() {
            let (input, defaults) = (&draft.input, &mut draft.defaults);
            let given = [
                ("samples", input.samples.is_some()),
                ("seed", input.seed.is_some()),
                ("statistic", input.statistic.is_some()),
            ];
            for (field, _) in given.into_iter().filter(|(_, is_given)| *is_given) {
                defaults.refuse(format!("/{field}"), format!("`{}` takes it with `inputs` only", kind.name()));
            }
            return None;
        }
        let inputs = inputs(draft);
        for (place, input) in inputs.iter().enumerate() {
            if let Some(axis) = axes.clone().find(|axis| axis.overlaps(&input.varied)) {
                draft.defaults.refuse(format!("/inputs/{place}"), already_varied(&input.varied, axis));
            }
        }
        let (input, defaults) = (&mut draft.input, &mut draft.defaults);
        let samples = defaults.fill("/samples", &mut input.samples, SAMPLES);
        let seed = defaults.fill("/seed", &mut input.seed, 1);
        let usual = NameOr::Object(PercentileInput { percentile: PERCENTILE });
        let given_statistic = defaults.fill("/statistic", &mut input.statistic, usual);
        check(samples, &given_statistic, defaults);
        let given = json!({ "inputs": input.inputs, "samples": samples, "seed": seed, "statistic": given_statistic });
        // Of refused numbers no points are made.
        let samples = if defaults.errors.is_empty() { samples as usize } else { 0 };
        let cube = |samples: usize| Design::Sobol.cube(inputs.len(), samples, seed);
        let (coarse, fine) = (cube(samples), cube(if samples > 0 { samples.max(REPEATED) } else { 0 }));
        Some(Self { statistic: in_core(&given_statistic), given_statistic, cube: coarse, fine, inputs, given })
    }

    /// The inputs at a sample.
    pub fn values(&self, sample: usize) -> impl Iterator<Item = (&Varied, Value)> {
        let point = self.cube.get(sample).map_or(&[][..], Vec::as_slice);
        self.inputs.iter().zip(point).map(|(input, probability)| (&input.varied, input.value(*probability)))
    }

    /// Everything that determines the result, as JSON.
    pub fn canonical(&self) -> &Value {
        &self.given
    }
}

fn check(samples: u32, statistic: &StatisticInput, defaults: &mut Defaults) {
    let known = defaults.errors.len();
    defaults.check("/samples", f64::from(samples));
    if defaults.errors.len() == known && !samples.is_power_of_two() {
        let (below, above) = (samples.next_power_of_two() / 2, samples.next_power_of_two());
        defaults.refuse("/samples", format!("{samples}: must be a power of two, such as {below} or {above}"));
    }
    if let NameOr::Object(of) = statistic {
        defaults.check("/statistic/percentile", of.percentile);
    }
}
