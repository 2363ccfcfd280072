//! Partners of predicted lines among measured ones. All lines of one source share their shift.

use std::collections::BTreeMap;

/// Largest shift of a line against its prediction [-]. Slip of the cage, an unknown contact angle and an error of the stated speed move lines by
/// up to 1 % (docs/how-to/compare-a-measurement.md).
const MOST_SHIFT: f64 = 0.02;
/// Distance from its expected place within which a line may always lie, in bins: a line between two bins is found to a fraction of one.
pub const SHIFT_BINS: f64 = 1.5;
/// Label of the rotation of the shaft.
const SHAFT: &str = "f_r";

/// A predicted line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedLine<'a> {
    pub order: f64,
    pub amplitude: f64,
    /// As in a result, such as `2·BPFO − f_r@A`; empty without one.
    pub label: &'a str,
}

/// Source of a line, and the part of its order that comes from the shaft.
#[derive(Debug, Clone, PartialEq)]
struct Source {
    /// Name of the first frequency that is not that of the shaft, with its bearing.
    series: String,
    /// Order that does not slip.
    of_shaft: f64,
}

impl Source {
    /// Of all lines without label together.
    fn unknown() -> Self {
        Self { series: String::new(), of_shaft: 0.0 }
    }

    /// Of a label such as `2·BPFO + f_r − FTF@A`; `None` without one.
    fn of(label: &str) -> Option<Self> {
        let (sum, bearing) = label.split_once('@').unwrap_or((label, ""));
        let signed = sum.replace(" − ", " + −");
        let term = |text: &str| -> (f64, String) {
            let (sign, rest) = text.strip_prefix('−').map_or((1.0, text), |rest| (-1.0, rest));
            let (order, name) = rest.split_once('·').unwrap_or(("1", rest));
            (sign * order.parse().unwrap_or(1.0), name.to_owned())
        };
        let terms: Vec<(f64, String)> = signed.split(" + ").map(term).collect();
        let slipping = terms.iter().find(|(_, name)| name != SHAFT);
        let series = match slipping {
            _ if sum.is_empty() => return None,
            Some((_, name)) => format!("{name}@{bearing}"),
            // The whole order shifts, if the stated speed is wrong.
            None => return Some(Self { series: SHAFT.to_owned(), of_shaft: 0.0 }),
        };
        let of_shaft = terms.iter().filter(|(_, name)| name == SHAFT).map(|(order, _)| order).sum();
        Some(Self { series, of_shaft })
    }
}

/// A predicted line of a series, and the measured orders within the largest shift, strongest first.
struct Member {
    order: f64,
    of_shaft: f64,
    near: Vec<f64>,
}

impl Member {
    /// Number of places within the largest shift that a spectrum tells apart.
    fn places(&self, reach: f64) -> f64 {
        most(self.order, reach) / reach
    }

    /// Logarithm of the odds against chance of the strongest line in the range of a shift. A line of its rank or stronger would lie in the range
    /// by chance with the probability rank over places.
    fn evidence(&self, shift: f64, reach: f64) -> f64 {
        let (low, high) = range(self.order, self.of_shaft, shift, reach);
        let rank = self.near.iter().position(|order| (low..=high).contains(order));
        let chance = |rank: usize| (rank + 1) as f64 * (high - low) / (2.0 * most(self.order, reach));
        rank.map_or(0.0, |rank| -chance(rank).min(1.0).ln())
    }

    /// Mean evidence at a shift that says nothing.
    fn by_chance(&self, reach: f64) -> f64 {
        let places = self.places(reach);
        (1..=self.near.len().min(places as usize)).map(|rank| (places / rank as f64).ln() / places).sum()
    }
}

/// Orders between which a line lies at a shift of its series. Slip leaves the part of the shaft in place; a wrong speed shifts it, too.
fn range(order: f64, of_shaft: f64, shift: f64, reach: f64) -> (f64, f64) {
    let by_slip = order + shift * (order - of_shaft);
    let by_speed = order * (1.0 + shift);
    (by_slip.min(by_speed) - reach, by_slip.max(by_speed) + reach)
}

/// Largest distance of a line from its predicted order.
fn most(order: f64, reach: f64) -> f64 {
    (MOST_SHIFT * order).max(reach)
}

/// Predicted lines of one source.
#[derive(Default)]
struct Series(Vec<Member>);

/// A shift of a series [-].
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shift {
    value: f64,
    /// Logarithm of the odds of the series against chance. What is searched pays for each place that might have been found.
    odds: f64,
}

impl Shift {
    /// The one with more evidence, and the first of equal ones.
    fn better(self, other: Self) -> Self {
        if other.odds > self.odds { other } else { self }
    }
}

impl Series {
    fn known(&self, value: f64, reach: f64) -> Shift {
        let odds = self.0.iter().map(|line| line.evidence(value, reach) - line.by_chance(reach)).sum();
        Shift { value, odds }
    }

    /// The best shift that moves a predicted line onto a measured one; `None` where nothing was measured in reach.
    fn searched(&self, reach: f64) -> Option<Shift> {
        let seen = self.0.iter().filter(|line| !line.near.is_empty());
        let places = seen.map(|line| line.places(reach)).fold(1.0, f64::max);
        let shifts = self.0.iter().flat_map(|line| line.near.iter().map(|order| order / line.order - 1.0));
        let best = shifts.map(|shift| self.known(shift, reach)).reduce(Shift::better)?;
        Some(Shift { odds: best.odds - places.ln(), ..best })
    }
}

/// Shifts by which measured lines differ from predicted ones, one for each series: harmonics of one frequency and their sidebands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shifts {
    by_series: BTreeMap<String, f64>,
    /// That with the most evidence; `None` where no series is more than chance.
    best: Option<f64>,
}

impl Shifts {
    /// The shifts with the most evidence. A series has none, that of the most evident series, or one of its own if that is worth its search.
    ///
    /// `measured`: orders, strongest first. `reach`: [`SHIFT_BINS`] as orders.
    pub fn of(predicted: &[PredictedLine<'_>], measured: &[f64], reach: f64) -> Self {
        let mut all: BTreeMap<String, Series> = BTreeMap::new();
        for &PredictedLine { order, label, .. } in predicted {
            let Source { series, of_shaft } = Source::of(label).unwrap_or_else(Source::unknown);
            let is_near = |other: &f64| (other - order).abs() <= most(order, reach);
            let near = measured.iter().copied().filter(is_near).collect();
            all.entry(series).or_default().0.push(Member { order, of_shaft, near });
        }
        let own = |series: &Series| {
            let unshifted = series.known(0.0, reach);
            series.searched(reach).map_or(unshifted, |searched| unshifted.better(searched))
        };
        let best =
            all.values().map(own).filter(|shift| shift.odds > 0.0).reduce(Shift::better).map(|shift| shift.value);
        let of_series = |series: &Series| {
            let others = best.map_or(own(series), |best| series.known(best, reach).better(own(series)));
            if others.odds > 0.0 { others.value } else { best.unwrap_or(0.0) }
        };
        Self { best, by_series: all.iter().map(|(name, series)| (name.clone(), of_series(series))).collect() }
    }

    /// Whether a measured order may be the partner of a predicted line. A line whose source is unknown has its own order or that of the most
    /// evident shift, and no partner where no shift is known.
    fn joins(&self, line: &PredictedLine<'_>, measured: f64, reach: f64) -> bool {
        let order = line.order;
        let is_at = |place: f64| (measured - place).abs() <= reach;
        match Source::of(line.label) {
            Some(Source { series, of_shaft }) => {
                let shift = self.by_series.get(&series).or(self.best.as_ref()).copied().unwrap_or(0.0);
                let (low, high) = range(order, of_shaft, shift, reach);
                (low..=high).contains(&measured)
            }
            None => self.best.is_some_and(|shift| is_at(order) || is_at(order * (1.0 + shift))),
        }
    }
}

/// Number of the measured line that belongs to each predicted one: the strongest at the shift of its series. A measured line has one partner; stronger
/// predicted lines choose first.
///
/// `measured`: orders, strongest first. `reach`: [`SHIFT_BINS`] as orders.
pub fn partners(predicted: &[PredictedLine<'_>], measured: &[f64], shifts: &Shifts, reach: f64) -> Vec<Option<usize>> {
    let mut sequence: Vec<usize> = (0..predicted.len()).collect();
    sequence.sort_by(|a, b| predicted[*b].amplitude.total_cmp(&predicted[*a].amplitude));
    let (mut found, mut is_taken) = (vec![None; predicted.len()], vec![false; measured.len()]);
    for own in sequence {
        found[own] = (0..measured.len()).find(|k| !is_taken[*k] && shifts.joins(&predicted[own], measured[*k], reach));
        if let Some(partner) = found[own] {
            is_taken[partner] = true;
        }
    }
    found
}
