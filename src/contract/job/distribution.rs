//! Uncertain inputs: as they are sent, and as checked distributions.

use raceway_core::physics::clearance::{bores_of, limits_um};
use raceway_core::sampling::basis::Basis;
use raceway_core::sampling::distribution::{Discrete, Distribution, LIMIT_SIGMAS};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::axis::AxisValue;
use super::varied::{MAX_NAME, Varied};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::{short, significant};
use crate::contract::json::problem::listed;
use crate::contract::json::shapes::object;
use crate::contract::scene::mounting::ClearanceGroupName;

/// Most values of a `discrete` distribution: each beyond the first takes a coefficient of the ranking.
const MAX_LEVELS: usize = 16;
/// Significant digits of sampled values.
const DIGITS: usize = 9;
/// The field that a clearance group describes.
pub const CLEARANCE: &str = "/bearing/radial_clearance_um";

/// An uncertain field of the scene, or a derived quantity, and its distribution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"path": "/spindle/mass_kg", "distribution": {"type": "normal", "mean": 0.67, "standard_deviation": 0.05}}))]
pub struct UncertainInput {
    /// JSON pointer from the scene to the uncertain field; either this or `quantity`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, max_length = 200, example = "/spindle/mass_kg")]
    pub path: Option<String>,
    /// `axial_load_over_rating`: axial load divided by the dynamic load rating.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<super::axis::QuantityName>)]
    pub quantity: Option<String>,
    /// Distribution of its values, independent of the other inputs.
    #[serde(deserialize_with = "object")]
    pub distribution: DistributionInput,
}

/// An uncertain input, read from an object only: derived structs also read arrays.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(transparent)]
#[schema(value_type = UncertainInput)]
pub struct StrictInput(pub UncertainInput);

impl<'de> Deserialize<'de> for StrictInput {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        object(deserializer).map(Self)
    }
}

/// `uniform`: between `from` and `to`. `normal`: `mean` and `standard_deviation`, cut at `from` and `to` where these are given. `triangular`: from
/// `from` over the most probable `mode` to `to`. `lognormal`: a number above 0 with this `mean` and `standard_deviation`. `discrete`: one of
/// `values`, equally probable or by `weights`. `tolerance`: normal, with `nominal` + `plus` and `nominal` − `minus` at ±3 standard deviations.
/// `clearance_group`: normal, with the limits of a clearance `group` for the bore at ±3 standard deviations, less what the scene's fits and
/// temperatures take away; only for `/bearing/radial_clearance_um`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum DistributionName {
    Uniform,
    Normal,
    Triangular,
    Lognormal,
    Discrete,
    Tolerance,
    ClearanceGroup,
}

impl DistributionName {
    fn name(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::Normal => "normal",
            Self::Triangular => "triangular",
            Self::Lognormal => "lognormal",
            Self::Discrete => "discrete",
            Self::Tolerance => "tolerance",
            Self::ClearanceGroup => "clearance_group",
        }
    }

    /// Fields that the distribution takes, those that it requires first, and how many it requires.
    fn takes(self) -> (&'static [&'static str], usize) {
        match self {
            Self::Uniform => (&["from", "to"], 2),
            Self::Normal => (&["mean", "standard_deviation", "from", "to"], 2),
            Self::Triangular => (&["from", "mode", "to"], 3),
            Self::Lognormal => (&["mean", "standard_deviation"], 2),
            Self::Discrete => (&["values", "weights"], 1),
            Self::Tolerance => (&["nominal", "plus", "minus"], 3),
            Self::ClearanceGroup => (&["group"], 1),
        }
    }
}

/// A distribution. `type` decides which other fields it takes. Numbers are in the unit of the field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"type": "uniform", "from": 2950, "to": 3050}))]
pub struct DistributionInput {
    /// Kind of distribution.
    #[serde(rename = "type")]
    pub kind: DistributionName,
    /// Least value (`uniform`, `triangular`; `normal` where it is cut).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub from: Option<f64>,
    /// Greatest value, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub to: Option<f64>,
    /// Mean (`normal`, `lognormal`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub mean: Option<f64>,
    /// Standard deviation (`normal`, `lognormal`), above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub standard_deviation: Option<f64>,
    /// Most probable value (`triangular`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub mode: Option<f64>,
    /// Nominal value (`tolerance`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub nominal: Option<f64>,
    /// Upper limit less nominal value (`tolerance`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub plus: Option<f64>,
    /// Nominal value less lower limit (`tolerance`); negative where both limits lie above the nominal value.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub minus: Option<f64>,
    /// Clearance group of the unmounted bearing (`clearance_group`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub group: Option<ClearanceGroupName>,
    /// Numbers or names, 2 to 16 (`discrete`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<Vec<AxisValue>>, min_items = 2, max_items = 16)]
    pub values: Option<Vec<Value>>,
    /// Weight of each value, above 0 (`discrete`). Default: equal.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, min_items = 2, max_items = 16)]
    pub weights: Option<Vec<f64>>,
}

/// A checked input.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    pub varied: Varied,
    values: Values,
    /// Assumption of the distribution, as a sentence.
    pub assumption: String,
}

#[derive(Debug, Clone, PartialEq)]
enum Values {
    Numbers { distribution: Distribution, nominal: f64 },
    Levels { shares: Discrete, values: Vec<Value> },
}

/// Dimensions of the scene that a clearance group needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoreAndLoss {
    pub bore_mm: f64,
    /// Clearance that fits and temperatures take away.
    pub loss_um: f64,
}

impl Sampled {
    /// The input at `pointer` of the request; `None` after an error. `bearing`: `None` where the scene has errors.
    pub fn of(
        input: UncertainInput,
        pointer: &str,
        bearing: Option<BoreAndLoss>,
        defaults: &mut Defaults,
    ) -> Option<Self> {
        let varied = Varied::of(input.path, input.quantity, pointer, defaults)?;
        let at = format!("{pointer}/distribution");
        let given = input.distribution;
        given.check_fields(&at, defaults)?;
        if given.kind == DistributionName::ClearanceGroup {
            return of_group(varied, given.group?, &at, bearing, defaults);
        }
        if given.kind == DistributionName::Discrete {
            return given.levels(varied, &at, defaults);
        }
        let (distribution, nominal, assumption) = given.numbers(&at, defaults)?;
        Some(Self { varied, values: Values::Numbers { distribution, nominal }, assumption })
    }

    /// The value at a probability, 0 … 1, both excluded.
    pub fn value(&self, share: f64) -> Value {
        match &self.values {
            Values::Numbers { distribution, .. } => significant(distribution.quantile(share), DIGITS).into(),
            Values::Levels { shares, values } => values.get(shares.place(share)).cloned().unwrap_or_default(),
        }
    }

    /// The middle of the distribution, the nominal value of a tolerance, or the most probable of several values.
    pub fn nominal(&self) -> Value {
        match &self.values {
            Values::Numbers { nominal, .. } => significant(*nominal, DIGITS).into(),
            Values::Levels { shares, values } => values.get(shares.mode()).cloned().unwrap_or_default(),
        }
    }

    /// Functions of the input for the ranking.
    pub fn basis(&self) -> Basis {
        match &self.values {
            Values::Numbers { .. } => Basis::Legendre,
            Values::Levels { shares, .. } => Basis::Levels(shares.clone()),
        }
    }

    /// True if the input rises from its first to its last value.
    pub fn is_ordered(&self) -> bool {
        matches!(self.values, Values::Numbers { .. })
    }
}

fn of_group(
    varied: Varied,
    group: ClearanceGroupName,
    at: &str,
    bearing: Option<BoreAndLoss>,
    defaults: &mut Defaults,
) -> Option<Sampled> {
    if varied.name != CLEARANCE {
        defaults.refuse(at, format!("`clearance_group` describes `{CLEARANCE}`, not `{}`", varied.name));
        return None;
    }
    let BoreAndLoss { bore_mm, loss_um } = bearing?;
    let group = group.in_physics();
    let Some(limits) = limits_um(group, bore_mm) else {
        let bores = bores_of(group);
        let (over, up_to) = (short(bores.over), short(bores.up_to));
        let detail = format!("{}: a bore of {} mm: the group has {over} to {up_to} mm", group.name(), short(bore_mm));
        defaults.refuse(format!("{at}/group"), detail);
        return None;
    };
    let distribution = Distribution::of_limits(limits.map(|limit| limit - loss_um));
    let nominal = distribution.quantile(0.5);
    let less = if loss_um == 0.0 {
        String::new()
    } else {
        format!(", less {} µm by fits and temperatures", short(significant(loss_um, 4)))
    };
    let assumption = format!(
        "normal, group {} of bore {} mm: {} and {} µm at ±{LIMIT_SIGMAS} standard deviations, not cut{less}",
        group.name(),
        short(bore_mm),
        short(limits[0]),
        short(limits[1]),
    );
    Some(Sampled { varied, values: Values::Numbers { distribution, nominal }, assumption })
}

impl DistributionInput {
    /// Refuses missing fields and those of other distributions.
    fn check_fields(&self, at: &str, defaults: &mut Defaults) -> Option<()> {
        let numbers = [
            ("from", self.from),
            ("to", self.to),
            ("mean", self.mean),
            ("standard_deviation", self.standard_deviation),
            ("mode", self.mode),
            ("nominal", self.nominal),
            ("plus", self.plus),
            ("minus", self.minus),
        ];
        let given = numbers.map(|(name, value)| (name, value.is_some()));
        let others =
            [("group", self.group.is_some()), ("values", self.values.is_some()), ("weights", self.weights.is_some())];
        let (takes, required) = self.kind.takes();
        let known = defaults.errors.len();
        for (name, is_given) in given.into_iter().chain(others) {
            let pointer = format!("{at}/{name}");
            if is_given && !takes.contains(&name) {
                let takes = listed(takes.iter().copied());
                defaults.refuse(pointer, format!("`{}` takes {takes}", self.kind.name()));
            } else if !is_given && takes[..required].contains(&name) {
                defaults.refuse(pointer, format!("required by `{}`, but missing", self.kind.name()));
            }
        }
        for (name, value) in numbers {
            if let Some(value) = value.filter(|_| takes.contains(&name)) {
                let pointer = format!("/inputs/distribution/{name}");
                if let Some(detail) = defaults.out_of_limits(&pointer, value) {
                    defaults.refuse(format!("{at}/{name}"), detail);
                }
            }
        }
        (defaults.errors.len() == known).then_some(())
    }

    /// Distribution of a number, its nominal value, and what it supposes.
    fn numbers(&self, at: &str, defaults: &mut Defaults) -> Option<(Distribution, f64, String)> {
        let number = |field: Option<f64>| field.unwrap_or(f64::NAN);
        let mut refuse = |field: &str, detail: String| {
            defaults.refuse(format!("{at}/{field}"), detail);
            None
        };
        let (from, to) = (number(self.from), number(self.to));
        let (mean, deviation) = (number(self.mean), number(self.standard_deviation));
        let of_deviation = || format!("{}: must be above 0", short(deviation));
        match self.kind {
            DistributionName::Uniform if from >= to => refuse("to", above(to, "from", from)),
            DistributionName::Uniform => {
                let distribution = Distribution::Uniform { from, to };
                Some((distribution, 0.5 * (from + to), format!("uniform from {} to {}", short(from), short(to))))
            }
            DistributionName::Normal | DistributionName::Lognormal if deviation <= 0.0 => {
                refuse("standard_deviation", of_deviation())
            }
            DistributionName::Normal => {
                let limits = [self.from.unwrap_or(f64::NEG_INFINITY), self.to.unwrap_or(f64::INFINITY)];
                if limits[0] >= limits[1] {
                    return refuse("to", above(to, "from", from));
                }
                if !(limits[0]..=limits[1]).contains(&mean) {
                    return refuse("mean", format!("{}: must lie between `from` and `to`", short(mean)));
                }
                let distribution = Distribution::Normal { mean, standard_deviation: deviation, limits };
                let side = |limit: Option<f64>, side: &str| limit.map(|limit| format!("{side} {}", short(limit)));
                let cut: Vec<String> =
                    [side(self.from, "below"), side(self.to, "above")].into_iter().flatten().collect();
                let cut = if cut.is_empty() { "not cut".to_owned() } else { format!("cut {}", cut.join(" and ")) };
                let text = format!("normal, mean {}, standard deviation {}, {cut}", short(mean), short(deviation));
                Some((distribution, distribution.quantile(0.5), text))
            }
            DistributionName::Triangular => {
                let mode = number(self.mode);
                if from >= to {
                    return refuse("to", above(to, "from", from));
                }
                if !(from..=to).contains(&mode) {
                    return refuse("mode", format!("{}: must lie between `from` and `to`", short(mode)));
                }
                let distribution = Distribution::Triangular { from, mode, to };
                let text = format!("triangular, {} over {} to {}", short(from), short(mode), short(to));
                Some((distribution, distribution.quantile(0.5), text))
            }
            DistributionName::Lognormal if mean <= 0.0 => refuse("mean", format!("{}: must be above 0", short(mean))),
            DistributionName::Lognormal => {
                let distribution = Distribution::Lognormal { mean, standard_deviation: deviation };
                let text = format!("lognormal, mean {}, standard deviation {}", short(mean), short(deviation));
                Some((distribution, distribution.quantile(0.5), text))
            }
            DistributionName::Tolerance => {
                let (nominal, plus, minus) = (number(self.nominal), number(self.plus), number(self.minus));
                let limits = [nominal - minus, nominal + plus];
                if limits[0] >= limits[1] {
                    return refuse("plus", format!("{}: the upper limit must be above the lower one", short(plus)));
                }
                let text = format!(
                    "normal, limits {} and {} at ±{LIMIT_SIGMAS} standard deviations, not cut",
                    short(significant(limits[0], DIGITS)),
                    short(significant(limits[1], DIGITS))
                );
                Some((Distribution::of_limits(limits), nominal, text))
            }
            DistributionName::Discrete | DistributionName::ClearanceGroup => None,
        }
    }

    /// One of several values.
    fn levels(self, varied: Varied, at: &str, defaults: &mut Defaults) -> Option<Sampled> {
        let values = self.values?;
        let mut refuse = |field: String, detail: String| {
            defaults.refuse(format!("{at}/{field}"), detail);
            None
        };
        let count = values.len();
        if !(2..=MAX_LEVELS).contains(&count) {
            return refuse("values".to_owned(), format!("{count} values: must be from 2 to {MAX_LEVELS}"));
        }
        for (place, value) in values.iter().enumerate() {
            let detail = if value.as_str().is_some_and(|name| name.chars().count() > MAX_NAME) {
                format!("more than {MAX_NAME} characters")
            } else if !(value.is_number() || value.is_string() && varied.takes_names()) {
                "must be a number or a name".to_owned()
            } else if values[..place].contains(value) {
                "given more than once".to_owned()
            } else {
                continue;
            };
            return refuse(format!("values/{place}"), detail);
        }
        let weights = self.weights.unwrap_or_else(|| vec![1.0; count]);
        if weights.len() != count {
            return refuse(
                "weights".to_owned(),
                format!("{} weights: must be {count}, one for each value", weights.len()),
            );
        }
        if let Some(place) = weights.iter().position(|weight| !(1e-6..=1e6).contains(weight)) {
            let detail = format!("{}: must be from 1e-6 to 1e6", short(weights[place]));
            return refuse(format!("weights/{place}"), detail);
        }
        let shares = Discrete::of(&weights);
        let shown = |(value, share): (&Value, &f64)| format!("{value} ({} %)", short(significant(100.0 * share, 3)));
        let list: Vec<String> = values.iter().zip(&shares.shares).map(shown).collect();
        let assumption = format!("one of {}", list.join(", "));
        Some(Sampled { varied, values: Values::Levels { shares, values }, assumption })
    }
}

fn above(value: f64, other: &str, its: f64) -> String {
    format!("{}: must be above `{other}`, {}", short(value), short(its))
}
