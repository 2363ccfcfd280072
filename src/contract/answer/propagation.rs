//! The result of an uncertainty job: what the sampled points say of each metric, with the errors of the statement.

use std::collections::BTreeMap;

use raceway_core::sampling::design::Design;
use raceway_core::sampling::expansion::{Expansion, InputShare, expansion};
use raceway_core::sampling::order_statistics::{histogram, interval_ranks, percentile};
use raceway_core::sampling::pairs::{PairShares, pair_shares};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::messages::{MessageAnswer, spread};
use super::point::PointStatus;
use super::table::Row;
use super::uncertainty::{MANY_FAILED, uncertain};
use crate::contract::job::axis::AxisValue;
use crate::contract::job::design::DesignName;
use crate::contract::job::distribution::Sampled;
use crate::contract::job::uncertainty::Uncertainty;

/// Percentiles of the answer.
const PERCENTILES: [u32; 5] = [5, 10, 50, 90, 95];
/// Integration error over the spread beyond which the spread is not resolved.
const UNRESOLVED: f64 = 0.5;
/// Explained share of the variance below which the ranking is not resolved.
const RANKED: f64 = 0.5;
/// Effects that no simulation of this service contains.
const OMITTED: [&str; 3] = [
    "squeeze and damping of the lubricant film in the contacts beyond the given traction and damping laws",
    "vibration of the housing and of the outer ring's seat",
    "the transfer path from the raceways to a sensor",
];

/// The response of `GET …/uncertainty`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct UncertaintyAnswer {
    /// Number of simulations: the nominal one and those of the design.
    pub points: u64,
    /// Number of simulations that have succeeded or failed.
    pub ended: u64,
    /// Number of simulations that have failed.
    pub failed: u64,
    /// How the samples were drawn.
    pub design: DesignName,
    /// Number of samples; of `pairs` in each of both sets.
    pub samples: u64,
    /// Seed of the design.
    pub seed: u64,
    /// The uncertain inputs, independent of each other.
    pub inputs: Vec<InputAnswer>,
    /// Statistics of each metric over the points, by its pointer. A metric that fewer than two points have is absent.
    pub metrics: BTreeMap<String, MetricSpreadAnswer>,
    /// Messages that concern all metrics.
    pub messages: Vec<MessageAnswer>,
}

/// An uncertain input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct InputAnswer {
    /// Path into the scene, or quantity.
    #[schema(example = "/spindle/mass_kg")]
    pub input: String,
    /// Assumption of its distribution.
    #[schema(example = "normal, mean 0.67, standard deviation 0.05, not cut")]
    pub assumption: String,
    /// Value of the nominal point: the median, the nominal value of a tolerance, or the most probable of several values.
    #[schema(value_type = AxisValue)]
    pub nominal: Value,
}

/// Distribution of a metric, in its unit, over the sampled points that have it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MetricSpreadAnswer {
    /// Value at the nominal point; absent where that has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub nominal: Option<f64>,
    /// Number of sampled points with a value.
    pub values: u64,
    /// Number of ended sampled points without a value: the run failed, or the metric is absent or not resolved.
    pub without_value: u64,
    /// Mean; of levels that of the decibels.
    pub mean: f64,
    /// Level of the mean square, for levels [dB].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub energy_mean_db: Option<f64>,
    /// Standard deviation.
    #[schema(minimum = 0)]
    pub standard_deviation: f64,
    /// Percentiles, rising.
    pub percentiles: Vec<PercentileAnswer>,
    /// Numbers of values in equal intervals.
    pub histogram: HistogramAnswer,
    /// Ranking of the inputs. Absent where all values are equal, or fewer than 2 (1 + inputs) points have one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub sensitivity: Option<SensitivityAnswer>,
    /// Errors of four kinds. They have different meanings and are never added.
    pub errors: SpreadErrorsAnswer,
    /// Judgement of the spread against the integration error.
    pub verdict: SpreadVerdict,
}

/// A percentile with an interval that contains it with at least 95 % probability: two of the values by their ranks, whatever the distribution.
/// It supposes independent draws; of Sobol points and Latin hypercubes it is mostly too wide.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PercentileAnswer {
    /// Share of the values that do not exceed it [%].
    #[schema(minimum = 0, maximum = 100, example = 90)]
    pub percentile: u32,
    /// Value of the metric, in its unit.
    pub value: f64,
    /// Lower end of the interval; absent where there are too few values for one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub from: Option<f64>,
    /// Upper end of the interval, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub to: Option<f64>,
}

/// A histogram: one edge more than counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HistogramAnswer {
    /// Rising edges of the classes, in the unit of the metric.
    pub edges: Vec<f64>,
    /// Points in each class.
    pub counts: Vec<u64>,
}

/// Shares of the variance by input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SensitivityAnswer {
    /// Degree of the polynomials of an additive expansion in the inputs' probabilities: 1 to 6, the one that predicts left-out points best.
    #[schema(minimum = 1, maximum = 6)]
    pub degree: u32,
    /// Share of the variance that the expansion predicts for points that it has not seen (leave-one-out). The rest, 1 − Q², is interaction
    /// of inputs, roughness and noise. May be below 0.
    #[schema(maximum = 1)]
    pub q2: f64,
    /// True if Q² is at least 0.5.
    pub resolved: bool,
    /// Shares of the inputs, in the order of the request.
    pub inputs: Vec<InputShareAnswer>,
}

/// Effect of one input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct InputShareAnswer {
    /// Path into the scene, or quantity.
    #[schema(example = "/spindle/mass_kg")]
    pub input: String,
    /// Share of the variance that the input explains alone (first-order Sobol index), by the expansion.
    pub share: f64,
    /// Bootstrap interval of the share, 95 %.
    pub share_interval: [f64; 2],
    /// The same share by the pairs, which suppose no form of the metric and scatter more; `pairs` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub pair_share: Option<f64>,
    /// Bootstrap interval of this share, 95 %.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub pair_share_interval: Option<[f64; 2]>,
    /// Share of the variance that remains while only this input is unknown (total Sobol index); `pairs` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub total_share: Option<f64>,
    /// Bootstrap interval of the total share, 95 %.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub total_share_interval: Option<[f64; 2]>,
    /// 1: the metric mostly rises with the input; −1: it mostly falls. Absent for `discrete` inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = -1, maximum = 1)]
    pub sign: Option<i32>,
}

/// Errors of four kinds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SpreadErrorsAnswer {
    /// Spread by the inputs: standard deviation, with the mean square of the integration error subtracted. 0 where that is larger.
    #[schema(minimum = 0)]
    pub tolerance_spread: f64,
    /// Standard error of the mean by the finite number of independent samples; percentiles have intervals of their own.
    #[schema(minimum = 0)]
    pub sampling: f64,
    /// Root mean square over the points of the estimated integration error, for levels with the scatter of chaotic motion. Absent where no
    /// point has an estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub integration: Option<f64>,
    /// Errors of the model.
    pub model: ModelErrorAnswer,
}

/// Errors of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ModelErrorAnswer {
    /// Bound of what a model level may omit [dB].
    #[schema(minimum = 0)]
    pub model_tolerance_db: f64,
    /// Effects that no model level contains. They have no bound.
    pub without_bound: Vec<String>,
}

/// `resolved`: the integration error is at most half of the standard deviation. `spread_not_resolved`: it is larger. `numerical_unknown`: no
/// integration error is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpreadVerdict {
    Resolved,
    SpreadNotResolved,
    NumericalUnknown,
}

impl UncertaintyAnswer {
    /// From the rows of all points, the nominal one first.
    pub fn of(job: &Uncertainty, rows: &[Row]) -> Self {
        let count = |wanted: &[PointStatus]| rows.iter().filter(|row| wanted.contains(&row.status)).count() as u64;
        let mut messages = Vec::new();
        let spreads = job.metrics.iter().filter_map(|metric| {
            let spread = MetricSpreadAnswer::of(job, rows, metric)?;
            messages.extend(messages_of(metric, &spread));
            Some((metric.clone(), spread))
        });
        let metrics = spreads.collect();
        let input = |input: &Sampled| InputAnswer {
            input: input.varied.name.clone(),
            assumption: input.assumption.clone(),
            nominal: input.nominal(),
        };
        Self {
            points: rows.len() as u64,
            ended: count(&[PointStatus::Succeeded, PointStatus::Failed]),
            failed: count(&[PointStatus::Failed]),
            design: job.plan.design,
            samples: job.plan.samples.into(),
            seed: job.plan.seed,
            inputs: job.inputs.iter().map(input).collect(),
            metrics,
            messages,
        }
    }
}

/// The value of a point, and its mean square integration error where it is known.
fn value_of(row: &Row, metric: &str) -> Option<(f64, Option<f64>)> {
    let metrics = row.metrics.as_ref()?;
    let (value, error) = uncertain(metrics, metric)?;
    let scatter = || metrics.pointer(&format!("{}_scatter_db", metric.strip_suffix("_db")?))?.as_f64();
    Some((value, error.map(|error| error.powi(2) + scatter().unwrap_or(0.0).powi(2))))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

impl MetricSpreadAnswer {
    /// `None` of fewer than two values.
    fn of(job: &Uncertainty, rows: &[Row], metric: &str) -> Option<Self> {
        let (nominal, sampled) = rows.split_first()?;
        let found: Vec<Option<(f64, Option<f64>)>> = sampled.iter().map(|row| value_of(row, metric)).collect();
        let design = job.plan.design.in_core();
        let of_distribution = design.sampled(job.plan.samples as usize).min(found.len());
        let drawn = &found[..of_distribution];
        let values: Vec<f64> = drawn.iter().flatten().map(|(value, _)| *value).collect();
        if values.len() < 2 {
            return None;
        }
        let has_ended = |row: &&Row| matches!(row.status, PointStatus::Succeeded | PointStatus::Failed);
        let ended = sampled[..of_distribution].iter().filter(has_ended).count();
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        let middle = mean(&values);
        let squares: f64 = values.iter().map(|value| (value - middle).powi(2)).sum();
        let variance = squares / (values.len() - 1) as f64;
        let known: Vec<f64> = drawn.iter().flatten().filter_map(|(_, square)| *square).collect();
        let integration = (!known.is_empty()).then(|| mean(&known).sqrt());
        let verdict = match integration {
            None => SpreadVerdict::NumericalUnknown,
            Some(error) if error > UNRESOLVED * variance.sqrt() => SpreadVerdict::SpreadNotResolved,
            Some(_) => SpreadVerdict::Resolved,
        };
        let histogram = histogram(&sorted)?;
        let is_level = metric.ends_with("/level_db");
        Some(Self {
            nominal: value_of(nominal, metric).map(|(value, _)| value),
            values: values.len() as u64,
            without_value: (ended - values.len().min(ended)) as u64,
            mean: middle,
            energy_mean_db: is_level.then(|| energy_mean(&values)),
            standard_deviation: variance.sqrt(),
            percentiles: PERCENTILES.into_iter().filter_map(|of| percentile_of(&sorted, of)).collect(),
            histogram: HistogramAnswer { edges: histogram.edges, counts: histogram.counts },
            sensitivity: sensitivity(job, &found, of_distribution),
            errors: SpreadErrorsAnswer {
                tolerance_spread: (variance - integration.unwrap_or(0.0).powi(2)).max(0.0).sqrt(),
                sampling: (variance / values.len() as f64).sqrt(),
                integration,
                model: ModelErrorAnswer {
                    model_tolerance_db: job.study.base.settings.model_tolerance_db,
                    without_bound: OMITTED.map(str::to_owned).to_vec(),
                },
            },
            verdict,
        })
    }
}

/// Messages about a metric's spread.
fn messages_of(metric: &str, of: &MetricSpreadAnswer) -> Vec<MessageAnswer> {
    let without = of.without_value as f64 / (of.values + of.without_value) as f64;
    let failed = (without > MANY_FAILED).then(|| spread::failed_samples(metric, without));
    let is_unresolved = of.verdict == SpreadVerdict::SpreadNotResolved;
    let integration = of.errors.integration.filter(|_| is_unresolved);
    let unresolved = integration.map(|error| spread::spread_not_resolved(metric, error, of.standard_deviation));
    let ranking = of.sensitivity.as_ref().filter(|ranking| !ranking.resolved);
    let ranking = ranking.map(|ranking| spread::ranking_not_resolved(metric, ranking.q2));
    failed.into_iter().chain(unresolved).chain(ranking).collect()
}

/// Level of the mean square of levels [dB].
fn energy_mean(levels: &[f64]) -> f64 {
    let most = levels.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let powers: Vec<f64> = levels.iter().map(|level| 10_f64.powf((level - most) / 10.0)).collect();
    most + 10.0 * mean(&powers).log10()
}

fn percentile_of(sorted: &[f64], of: u32) -> Option<PercentileAnswer> {
    let share = f64::from(of) / 100.0;
    let [from, to] =
        interval_ranks(sorted.len(), share).map(|rank| rank.and_then(|rank| sorted.get(rank - 1).copied()));
    Some(PercentileAnswer { percentile: of, value: percentile(sorted, share)?, from, to })
}

/// Ranking of the inputs by the points with a value.
fn sensitivity(
    job: &Uncertainty,
    found: &[Option<(f64, Option<f64>)>],
    of_distribution: usize,
) -> Option<SensitivityAnswer> {
    let bases: Vec<_> = job.inputs.iter().map(|input| input.basis()).collect();
    let known =
        job.cube.iter().zip(&found[..of_distribution]).filter_map(|(point, value)| Some((&**point, (*value)?.0)));
    let (points, values): (Vec<&[f64]>, Vec<f64>) = known.unzip();
    let Expansion { degree, q2, inputs } = expansion(&bases, &points, &values, job.plan.seed)?;
    let all: Vec<Option<f64>> = found.iter().map(|value| value.map(|(value, _)| value)).collect();
    let pairs = (job.plan.design.in_core() == Design::Pairs)
        .then(|| pair_shares(&all, job.inputs.len(), job.plan.samples as usize, job.plan.seed))
        .flatten();
    let share = |(place, own): (usize, &InputShare)| {
        let of: Option<&PairShares> = pairs.as_ref().and_then(|pairs| pairs.get(place));
        InputShareAnswer {
            input: job.inputs[place].varied.name.clone(),
            // Squares of a fit to few points may exceed the variance.
            share: own.share.min(1.0),
            share_interval: own.interval,
            pair_share: of.map(|pair| pair.first),
            pair_share_interval: of.map(|pair| pair.first_interval),
            total_share: of.map(|pair| pair.total),
            total_share_interval: of.map(|pair| pair.total_interval),
            sign: job.inputs[place].is_ordered().then_some(if own.slope < 0.0 { -1 } else { 1 }),
        }
    };
    Some(SensitivityAnswer {
        degree: degree as u32,
        q2,
        resolved: q2 >= RANKED,
        inputs: inputs.iter().enumerate().map(share).collect(),
    })
}
