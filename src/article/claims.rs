//! Statements about a trend, and whether a table confirms them.

use serde_json::Value;

use crate::contract::TableAnswer;
use raceway_core::study::{Goal, best, trend};

/// A statement about the trend of a metric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Claim {
    /// The metric falls, then rises; its minimum is between two values.
    LeastWithin(f64, f64),
    /// The metric rises over the whole range.
    Rises,
}

/// How far the results confirm a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    NotShown,
    InPart,
    Shown,
}

impl Verdict {
    pub fn words(self) -> &'static str {
        match self {
            Self::Shown => "shown",
            Self::InPart => "shown in part",
            Self::NotShown => "not shown",
        }
    }

    /// The verdict on several statements together.
    pub fn of_all(all: &[Self]) -> Self {
        match (all.iter().min(), all.iter().max()) {
            (Some(Self::Shown), _) => Self::Shown,
            (_, Some(Self::NotShown)) | (None, _) => Self::NotShown,
            _ => Self::InPart,
        }
    }
}

/// A verdict with its observation.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    pub name: &'static str,
    pub verdict: Verdict,
    pub seen: String,
    /// True if the trend is smaller than ten times its error, so that it confirms nothing.
    pub unresolved: bool,
}

/// Metrics in the article: name, pointer, unit, digits.
pub const SHOWN: [(&str, &str, &str, usize); 4] = [
    ("velocity, rms, Y", "/channels/spindle.y.velocity/rms", "mm/s", 3),
    ("velocity, rms, Z", "/channels/spindle.z.velocity/rms", "mm/s", 3),
    ("acceleration level, Y", "/channels/spindle.y.acceleration/level_db", "dB", 2),
    ("acceleration level, Z", "/channels/spindle.z.acceleration/level_db", "dB", 2),
];

/// Rank correlation from which on a metric counts as rising over the whole range, and as mostly rising [-].
const RISES: f64 = 0.98;
const MOSTLY: f64 = 0.7;

/// Findings of a statement from the table of a study over one axis, one for each metric.
pub fn judged(table: &TableAnswer, claim: Claim) -> Vec<Finding> {
    SHOWN
        .iter()
        .map(|&(name, pointer, unit, digits)| judged_metric(table, claim, name, pointer, unit, digits))
        .collect()
}

fn judged_metric(
    table: &TableAnswer,
    claim: Claim,
    name: &'static str,
    pointer: &str,
    unit: &str,
    digits: usize,
) -> Finding {
    let column = table.column(pointer);
    let axis: Vec<f64> =
        table.axes.first().map(|axis| axis.values.iter().filter_map(Value::as_f64).collect()).unwrap_or_default();
    let (Some(least), Some(seen)) = (best(&column, Goal::Least), trend(&column)) else {
        let seen = "too few points succeeded".into();
        return Finding { name, verdict: Verdict::NotShown, seen, unresolved: true };
    };
    let value = |point: usize| column.get(point).copied().flatten().map_or(f64::NAN, |value| value.0);
    let known: Vec<usize> = (0..column.len()).filter(|point| column[*point].is_some()).collect();
    let (first, last) = (known[0], known[known.len() - 1]);
    let ends =
        format!("{:.digits$} {unit} at {} to {:.digits$} at {}", value(first), axis[first], value(last), axis[last]);
    let error = seen.error.map_or("of unknown error".to_owned(), |error| format!("± {error:.1e}"));
    let unresolved = seen.is_resolved() == Some(false);
    let (verdict, words) = match claim {
        Claim::Rises => {
            let words = format!("rank correlation {:+.2}", seen.monotony).replace('-', "−");
            let verdict = match seen.monotony {
                RISES.. => Verdict::Shown,
                MOSTLY.. => Verdict::InPart,
                _ => Verdict::NotShown,
            };
            (verdict, words)
        }
        Claim::LeastWithin(from, to) => {
            let part = |points: &[usize]| trend(&points.iter().map(|point| column[*point]).collect::<Vec<_>>());
            let (before, after): (Vec<usize>, Vec<usize>) = known.iter().partition(|point| **point <= least.point);
            let after: Vec<usize> = std::iter::once(least.point).chain(after).collect();
            let falls = part(&before).is_some_and(|trend| trend.monotony < -MOSTLY);
            let rises = part(&after).is_some_and(|trend| trend.monotony > MOSTLY);
            let as_good = least.as_good.unwrap_or_else(|| vec![least.point]);
            let as_good: Vec<f64> = as_good.iter().map(|point| axis[*point]).collect();
            let (low, high) = (
                as_good.iter().copied().fold(f64::INFINITY, f64::min),
                as_good.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            );
            let within = as_good.iter().any(|value| (from..=to).contains(value));
            let place = if low < high { format!("{low} … {high}") } else { format!("{low}") };
            let shape = match (least.point == first, least.point == last) {
                (true, _) if rises => "rises from the first point on",
                (true, _) => "no minimum",
                (_, true) if falls => "falls to the last point",
                (_, true) => "no minimum",
                _ if falls && rises => "falls, then rises",
                _ if falls => "falls to the minimum, but does not rise steadily after it",
                _ if rises => "does not fall steadily to the minimum, but rises after it",
                _ => "neither falls steadily to the minimum nor rises steadily after it",
            };
            let verdict = match (falls && rises, within) {
                (true, true) => Verdict::Shown,
                (false, false) => Verdict::NotShown,
                _ => Verdict::InPart,
            };
            (verdict, format!("{shape}; minimum at {place}"))
        }
    };
    let resolved = if unresolved { "; the trend is not resolved beyond its error" } else { "" };
    Finding {
        name,
        verdict: if unresolved { Verdict::NotShown } else { verdict },
        unresolved,
        seen: format!("{ends}; {words}; span {:.digits$} {unit} {error}{resolved}", seen.span),
    }
}

/// Correlation of two curves from which on they count as similar [-].
const ALIKE: f64 = 0.9;

/// Findings of two bearings over the same speeds, one for each metric. The statement: similar curves, the first slightly lower.
pub fn compared(integrated: &TableAnswer, deep_groove: &TableAnswer) -> Vec<Finding> {
    let one = |&(name, pointer, unit, digits): &(&'static str, &str, &str, usize)| {
        let both: Vec<(f64, f64)> = integrated
            .column(pointer)
            .into_iter()
            .zip(deep_groove.column(pointer))
            .filter_map(|(a, b)| Some((a?.0, b?.0)))
            .collect();
        let lower = both.iter().filter(|(a, b)| a < b).count();
        let mean = both.iter().map(|(a, b)| b - a).sum::<f64>() / both.len().max(1) as f64;
        let alike = correlation(&both);
        let verdict = match (alike > ALIKE, 2 * lower > both.len()) {
            (true, true) if lower == both.len() => Verdict::Shown,
            (false, false) => Verdict::NotShown,
            _ => Verdict::InPart,
        };
        let seen = format!(
            "correlation over speed {alike:.2}; the integrated bearing is lower at {lower} of {} speeds, by {mean:.digits$} {unit} on average",
            both.len()
        );
        Finding { name, verdict, seen, unresolved: false }
    };
    SHOWN.iter().map(one).collect()
}

/// Pearson correlation of pairs; 0 where one of them is constant.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len().max(1) as f64;
    let (x, y) = (pairs.iter().map(|p| p.0).sum::<f64>() / n, pairs.iter().map(|p| p.1).sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|p| f(p.0 - x, p.1 - y)).sum::<f64>();
    let scale = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    if scale > 0.0 { sum(&|a, b| a * b) / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::contract::{PointEnd, Row, parse_job};

    /// A study of the spindle's mass with these levels, each with its error.
    fn table(levels: &[f64], error: f64) -> TableAnswer {
        let masses: Vec<f64> = (0..levels.len()).map(|i| 0.05 + 0.01 * i as f64).collect();
        let request = json!({
            "kind": "study", "axes": [{ "path": "/spindle/mass_kg", "values": masses }],
            "scene": { "bearing": "608", "operation": { "speed_rpm": 3000 } },
        });
        let study = parse_job(request.to_string().as_bytes()).unwrap().into_study().unwrap();
        let row = |(point, level): (usize, &f64)| {
            let metrics = json!({
                "channels": { "spindle.y.acceleration": { "level_db": level } },
                "accuracy": { "level_error_db": error }
            });
            Row::queued(&study, point).ended(PointEnd::Succeeded(metrics))
        };
        TableAnswer::of(&study, levels.iter().enumerate().map(row).collect())
    }

    fn verdict(levels: &[f64], error: f64, claim: Claim) -> Verdict {
        judged(&table(levels, error), claim)[2].verdict
    }

    #[test]
    fn a_valley_is_told_by_its_shape_and_its_place() {
        let valley = [64.0, 62.0, 60.0, 61.0, 63.0];
        assert_eq!(verdict(&valley, 0.1, Claim::LeastWithin(0.065, 0.075)), Verdict::Shown);
        assert_eq!(verdict(&valley, 0.1, Claim::LeastWithin(0.055, 0.061)), Verdict::InPart);
        assert_eq!(verdict(&[60.0, 61.0, 62.0, 63.0], 0.1, Claim::LeastWithin(0.065, 0.075)), Verdict::NotShown);
        // The error is a tenth of the depth of the minimum.
        assert_eq!(verdict(&valley, 0.5, Claim::LeastWithin(0.065, 0.075)), Verdict::NotShown);
    }

    #[test]
    fn a_rise_is_told_by_its_ranks() {
        assert_eq!(verdict(&[60.0, 61.0, 62.0, 63.0], 0.1, Claim::Rises), Verdict::Shown);
        assert_eq!(verdict(&[60.0, 62.0, 61.0, 63.0, 64.0], 0.1, Claim::Rises), Verdict::InPart);
        assert_eq!(verdict(&[63.0, 62.0, 61.0], 0.1, Claim::Rises), Verdict::NotShown);
    }

    #[test]
    fn several_verdicts_make_one() {
        use Verdict::{InPart, NotShown, Shown};
        assert_eq!(Verdict::of_all(&[Shown, Shown]), Shown);
        assert_eq!(Verdict::of_all(&[Shown, NotShown]), InPart);
        assert_eq!(Verdict::of_all(&[NotShown, NotShown]), NotShown);
        assert_eq!(Verdict::of_all(&[]), NotShown);
    }
}
