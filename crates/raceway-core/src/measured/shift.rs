//! Shift of measured lines against predicted ones, which all lines of one source share.

use std::collections::BTreeMap;

use super::lines::PredictedLine;

/// Largest shift of a line against its prediction [-]. Slip of the cage, an unknown contact angle and an error of the stated speed move lines by
/// up to 1 % (docs/how-to/compare-a-measurement.md).
const MOST_SHIFT: f64 = 0.02;
/// Distance from its expected place within which a line may always lie, in bins: a line between two bins is found to a fraction of one.
pub const SHIFT_BINS: f64 = 1.5;
/// Label of the rotation of the shaft.
const SHAFT: &str = "f_r";

/// Source of a line, and the part of its order that comes from the shaft.
#[derive(Debug, Clone, PartialEq)]
struct Source {
    /// Name of the first frequency that is not that of the shaft, with its bearing.
    series: String,
    /// Order that does not slip.
    of_shaft: f64,
}

impl Source {
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
    /// Shifts of the series that move this line onto a measured one.
    fn shifts(&self) -> impl Iterator<Item = f64> + '_ {
        let slipping = self.order - self.of_shaft;
        self.near.iter().map(move |order| (order - self.order) / slipping).filter(|shift| shift.is_finite())
    }

    /// Logarithm of the odds against chance of the strongest line in the range of a shift: a line of its rank lies somewhere within the largest
    /// shift, and would lie in the range with the share of its width, times the rank.
    fn evidence(&self, shift: f64, reach: f64) -> f64 {
        let (low, high) = range(self.order, self.of_shaft, shift, reach);
        let rank = self.near.iter().position(|order| (low..=high).contains(order));
        let chance = |rank: usize| (rank + 1) as f64 * (high - low) / (2.0 * most(self.order, reach));
        rank.map_or(0.0, |rank| -chance(rank).min(1.0).ln())
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

/// Shift of a series.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shift {
    shift: f64,
    /// Logarithm of the odds against chance.
    evidence: f64,
}

impl Shift {
    /// The shift of lines that is least likely by chance; `None` where nothing was measured near any of them.
    fn of(lines: &[Member], reach: f64) -> Option<Self> {
        let evidence = |shift: f64| lines.iter().map(|line| line.evidence(shift, reach)).sum();
        let shifts = lines.iter().flat_map(Member::shifts);
        shifts.map(|shift| Self { shift, evidence: evidence(shift) }).reduce(Self::better)
    }

    /// The one with more evidence, and the first of equal ones.
    fn better(self, other: Self) -> Self {
        if other.evidence > self.evidence { other } else { self }
    }
}

/// Shifts by which measured lines differ from predicted ones [-], one for each series: harmonics of one frequency and their sidebands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shifts {
    by_series: BTreeMap<String, Shift>,
}

impl Shifts {
    /// The shift of each series that is least likely by chance. A single line takes the strongest measured line in reach.
    ///
    /// `measured`: orders, strongest first. `reach`: [`SHIFT_BINS`] as orders.
    pub fn of(predicted: &[PredictedLine<'_>], measured: &[f64], reach: f64) -> Self {
        let mut members: BTreeMap<String, Vec<Member>> = BTreeMap::new();
        for &PredictedLine { order, label, .. } in predicted {
            if let Some(Source { series, of_shaft }) = Source::of(label) {
                let is_near = |other: &f64| (other - order).abs() <= most(order, reach);
                let near = measured.iter().copied().filter(is_near).collect();
                members.entry(series).or_default().push(Member { order, of_shaft, near });
            }
        }
        let shifts = members.into_iter().filter_map(|(series, lines)| Some((series, Shift::of(&lines, reach)?)));
        Self { by_series: shifts.collect() }
    }

    /// Orders between which the partner of a predicted line lies. A line without series lies between its order and that of the shift with the
    /// most evidence, or within the largest shift, and is nearer to it than to the `nearest` predicted line.
    pub(super) fn range(&self, line: &PredictedLine<'_>, nearest: f64, reach: f64) -> (f64, f64) {
        let order = line.order;
        if let Some(Source { series, of_shaft }) = Source::of(line.label) {
            // Without a measured line in reach the series has no shift, and the line no partner.
            let found = self.by_series.get(&series);
            return found.map_or((order, order), |of_series| range(order, of_shaft, of_series.shift, reach));
        }
        let (low, high) = match self.by_series.values().copied().reduce(Shift::better) {
            Some(Shift { shift, .. }) => (shift.min(0.0) * order - reach, shift.max(0.0) * order + reach),
            None => (-most(order, reach), most(order, reach)),
        };
        let cap = (0.5 * nearest).max(reach);
        (order + low.max(-cap), order + high.min(cap))
    }
}
