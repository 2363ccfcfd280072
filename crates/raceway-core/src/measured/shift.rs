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

/// A predicted line of a series.
struct Member {
    order: f64,
    of_shaft: f64,
}

impl Member {
    /// Orders between which the line lies at a shift of its series. Slip leaves the part of the shaft in place; a wrong speed shifts it, too.
    fn range(&self, shift: f64, reach: f64) -> (f64, f64) {
        let by_slip = self.order + shift * (self.order - self.of_shaft);
        let by_speed = self.order * (1.0 + shift);
        (by_slip.min(by_speed) - reach, by_slip.max(by_speed) + reach)
    }

    /// Measured orders within the largest shift, strongest first, and their shifts.
    fn candidates<'a>(&'a self, measured: &'a [f64], reach: f64) -> impl Iterator<Item = f64> + 'a {
        let most = most(self.order, reach);
        measured.iter().copied().filter(move |order| (order - self.order).abs() <= most)
    }

    /// Logarithm of the odds against chance of the strongest line in the range of a shift: a line of its rank lies somewhere within the largest
    /// shift, and would lie in the range with the share of its width, times the rank.
    fn evidence(&self, shift: f64, candidates: &[f64], reach: f64) -> f64 {
        let (low, high) = self.range(shift, reach);
        let rank = candidates.iter().position(|order| (low..=high).contains(order));
        let chance = |rank: usize| (rank + 1) as f64 * (high - low) / (2.0 * most(self.order, reach));
        rank.map_or(0.0, |rank| -chance(rank).min(1.0).ln())
    }
}

/// Largest distance of a line from its predicted order.
fn most(order: f64, reach: f64) -> f64 {
    (MOST_SHIFT * order).max(reach)
}

/// Shifts by which measured lines differ from predicted ones [-], one for each series: harmonics of one frequency and their sidebands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shifts {
    by_series: BTreeMap<String, f64>,
    /// That with the most evidence.
    best: Option<f64>,
}

impl Shifts {
    /// The shift of each series that is least likely by chance. A single line takes the strongest measured line in reach.
    ///
    /// `measured`: orders, strongest first. `reach`: [`SHIFT_BINS`] as orders.
    pub fn of(predicted: &[PredictedLine<'_>], measured: &[f64], reach: f64) -> Self {
        let mut members: BTreeMap<String, Vec<Member>> = BTreeMap::new();
        for line in predicted {
            if let Some(Source { series, of_shaft }) = Source::of(line.label) {
                members.entry(series).or_default().push(Member { order: line.order, of_shaft });
            }
        }
        let shifts = members.into_iter().filter_map(|(series, lines)| Some((series, common(&lines, measured, reach)?)));
        let shifts: Vec<(String, (f64, f64))> = shifts.collect();
        let best =
            shifts.iter().map(|(_, found)| *found).reduce(|best, other| if other.1 > best.1 { other } else { best });
        Self {
            best: best.map(|(shift, _)| shift),
            by_series: shifts.into_iter().map(|(series, (shift, _))| (series, shift)).collect(),
        }
    }

    /// Orders between which the partner of a predicted line lies. A line without series lies between its order and that of the best shift, or
    /// within the largest one, and is nearer to it than to the `nearest` predicted line.
    pub(super) fn range(&self, line: &PredictedLine<'_>, nearest: f64, reach: f64) -> (f64, f64) {
        let order = line.order;
        if let Some(source) = Source::of(line.label) {
            let member = Member { order, of_shaft: source.of_shaft };
            // Without a measured line in reach the series has no shift, and the line no partner.
            return self.by_series.get(&source.series).map_or((order, order), |shift| member.range(*shift, reach));
        }
        let shifted = self.best.map_or([-MOST_SHIFT, MOST_SHIFT], |shift| [shift.min(0.0), shift.max(0.0)]);
        let cap = (0.5 * nearest).max(reach);
        let margin = if self.best.is_some() { reach } else { 0.0 };
        let [low, high] = shifted.map(|shift| shift * order);
        ((low - margin).max(-cap).min(-reach) + order, (high + margin).min(cap).max(reach) + order)
    }
}

/// The shift of lines that is least likely by chance, and its evidence.
fn common(lines: &[Member], measured: &[f64], reach: f64) -> Option<(f64, f64)> {
    let candidates: Vec<Vec<f64>> = lines.iter().map(|line| line.candidates(measured, reach).collect()).collect();
    let of_line = |(line, near): (&Member, &Vec<f64>)| {
        let slipping = line.order - line.of_shaft;
        near.iter().map(|order| (order - line.order) / slipping).filter(|shift| shift.is_finite()).collect::<Vec<f64>>()
    };
    let shifts = lines.iter().zip(&candidates).flat_map(of_line);
    let evidence =
        |shift: f64| lines.iter().zip(&candidates).map(|(line, near)| line.evidence(shift, near, reach)).sum();
    let found = shifts.map(|shift| (shift, evidence(shift)));
    found.reduce(|best: (f64, f64), other| if other.1 > best.1 { other } else { best })
}
