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
    /// Of a label such as `2·BPFO + f_r − FTF@A`. All lines without label are one series, which shifts as a whole.
    fn of(label: &str) -> Self {
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
            Some((_, name)) => format!("{name}@{bearing}"),
            // The whole order shifts, if the stated speed is wrong.
            None => return Self { series: SHAFT.to_owned(), of_shaft: 0.0 },
        };
        let of_shaft = terms.iter().filter(|(_, name)| name == SHAFT).map(|(order, _)| order).sum();
        Self { series, of_shaft }
    }
}

/// A predicted line, and the measured orders within its largest distance, strongest first.
struct Member {
    order: f64,
    source: Source,
    /// Largest distance of the line from its order. Beyond half of that to the next line of its series it would be taken for that one.
    most: f64,
    near: Vec<f64>,
}

impl Member {
    /// Of all predicted lines.
    fn all(predicted: &[PredictedLine<'_>], measured: &[f64], reach: f64) -> Vec<Self> {
        let mut orders: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        for line in predicted {
            orders.entry(Source::of(line.label).series).or_default().push(line.order);
        }
        let one = |&PredictedLine { order, label, .. }: &PredictedLine<'_>| {
            let source = Source::of(label);
            let others = orders[&source.series].iter().filter(|other| **other != order);
            let nearest = others.map(|other| (other - order).abs()).fold(f64::INFINITY, f64::min);
            let most = (MOST_SHIFT * order).min(0.5 * nearest).max(reach);
            let is_near = |other: &f64| (other - order).abs() <= most;
            Self { order, source, most, near: measured.iter().copied().filter(is_near).collect() }
        };
        predicted.iter().map(one).collect()
    }

    /// Number of distinct places of a line within the largest distance.
    fn places(&self, reach: f64) -> f64 {
        self.most / reach
    }

    /// Logarithm of the odds that a shift is true rather than says nothing, and whether a measured line is in its range. If it is true, the line is
    /// measured with even odds, and is then one of the `near` ones, of rank r with odds 1/r. Chance puts each of these into the range with the
    /// probability 1/places.
    fn odds(&self, shift: f64, reach: f64) -> (f64, bool) {
        let (low, high) = range(self.order, self.source.of_shaft, shift, reach);
        let rank = self.near.iter().position(|order| is_within(*order, (low, high)));
        let places = (2.0 * self.most / (high - low)).max(1.0);
        let harmonic = |count: usize| (1..=count).map(|rank| 1.0 / rank as f64).sum::<f64>();
        let gain = rank.map_or(0.0, |rank| places / ((rank + 1) as f64 * harmonic(self.near.len())));
        ((0.5 * (1.0 + gain)).ln(), rank.is_some())
    }
}

/// Orders between which a line lies at a shift of its series. Slip leaves the part of the shaft in place; a wrong speed shifts it, too.
fn range(order: f64, of_shaft: f64, shift: f64, reach: f64) -> (f64, f64) {
    let by_slip = order + shift * (order - of_shaft);
    let by_speed = order * (1.0 + shift);
    (by_slip.min(by_speed) - reach, by_slip.max(by_speed) + reach)
}

fn is_within(order: f64, (low, high): (f64, f64)) -> bool {
    (low..=high).contains(&order)
}

/// A shift of lines [-].
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shift {
    value: f64,
    /// Logarithm of the odds of this shift against chance, less that of the number of places at which a search could have found it.
    odds: f64,
    /// A predicted line meets a measured one.
    meets: bool,
}

impl Shift {
    /// The one with more evidence, and the first of equal ones.
    fn better(self, other: Self) -> Self {
        if other.odds > self.odds { other } else { self }
    }

    /// Returns true where chance does not explain better which lines meet.
    fn is_evident(&self) -> bool {
        self.meets && self.odds >= 0.0
    }
}

/// Predicted lines that share a shift.
struct Series<'a> {
    lines: Vec<&'a Member>,
    reach: f64,
}

impl Series<'_> {
    fn known(&self, value: f64) -> Shift {
        let nothing = Shift { value, odds: 0.0, meets: false };
        self.lines.iter().map(|line| line.odds(value, self.reach)).fold(nothing, |sum, (odds, meets)| Shift {
            odds: sum.odds + odds,
            meets: sum.meets || meets,
            ..sum
        })
    }

    /// No shift, or the best one that moves a predicted line onto a measured one.
    fn own(&self) -> Shift {
        let seen = self.lines.iter().filter(|line| !line.near.is_empty());
        let places = seen.map(|line| line.places(self.reach)).fold(1.0, f64::max);
        let shifts = self.lines.iter().flat_map(|line| line.near.iter().map(|order| order / line.order - 1.0));
        let searched = shifts.map(|shift| self.known(shift)).reduce(Shift::better);
        let none = self.known(0.0);
        searched.map_or(none, |best| none.better(Shift { odds: best.odds - places.ln(), ..best }))
    }
}

/// Shifts by which measured lines differ from predicted ones, for each series: harmonics of one frequency and their sidebands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shifts {
    by_series: BTreeMap<String, Vec<f64>>,
    /// The most evident one of a series, or of all lines together; `None` where chance explains all.
    best: Option<f64>,
}

impl Shifts {
    /// The shift of each series is the most evident one of three: none, that of the most evident series, and one of its own, which pays for its search. A
    /// wrong speed shifts all lines alike, so that they may be evident together. Series without evidence follow the most evident shift.
    ///
    /// `measured`: orders, strongest first. `reach`: [`SHIFT_BINS`] as orders.
    pub fn of(predicted: &[PredictedLine<'_>], measured: &[f64], reach: f64) -> Self {
        let members = Member::all(predicted, measured, reach);
        let mut all: BTreeMap<&str, Vec<&Member>> = BTreeMap::new();
        for line in &members {
            all.entry(&line.source.series).or_default().push(line);
        }
        let together = Series { lines: members.iter().collect(), reach };
        let all: Vec<(&str, Series<'_>)> =
            all.into_iter().map(|(name, lines)| (name, Series { lines, reach })).collect();
        let candidates = all.iter().map(|(_, series)| series).chain([&together]);
        let best = candidates.map(Series::own).filter(Shift::is_evident).reduce(Shift::better).map(|shift| shift.value);
        let of_series = |series: &Series<'_>| {
            let own = series.own();
            let found = best.map_or(own, |best| series.known(best).better(own));
            if found.is_evident() { Some(found.value) } else { best }
        };
        let by_series = all.iter().map(|(name, series)| ((*name).to_owned(), of_series(series).into_iter().collect()));
        Self { by_series: by_series.collect(), best }
    }

    /// The shifts of peaks without labels: none and the best one, if what was measured meets more of the peaks than chance would. Peaks of shaft and
    /// balls are among them.
    ///
    /// `peaks` and `measured`: strongest first.
    pub fn of_peaks(&self, peaks: &[PredictedLine<'_>], measured: &[f64], reach: f64) -> Self {
        let lines: Vec<PredictedLine<'_>> =
            measured.iter().map(|&order| PredictedLine { order, amplitude: 0.0, label: "" }).collect();
        let is_evident = |shift: &f64| {
            let moved: Vec<f64> = peaks.iter().map(|peak| (1.0 + shift) * peak.order).collect();
            let members = Member::all(&lines, &moved, reach);
            Series { lines: members.iter().collect(), reach }.known(0.0).is_evident()
        };
        let shifts = [Some(0.0), self.best].into_iter().flatten().filter(is_evident).collect();
        Self { by_series: BTreeMap::from([(Source::of("").series, shifts)]), best: self.best }
    }

    /// Orders between which the partner of a predicted line lies, for each shift of its series.
    fn ranges(&self, line: &PredictedLine<'_>, reach: f64) -> Vec<(f64, f64)> {
        let Source { series, of_shaft } = Source::of(line.label);
        let shifts = self.by_series.get(&series).into_iter().flatten();
        shifts.map(|shift| range(line.order, of_shaft, *shift, reach)).collect()
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
        let ranges = shifts.ranges(&predicted[own], reach);
        let is_partner = |order: f64| ranges.iter().any(|range| is_within(order, *range));
        found[own] = (0..measured.len()).find(|k| !is_taken[*k] && is_partner(measured[*k]));
        if let Some(partner) = found[own] {
            is_taken[partner] = true;
        }
    }
    found
}
