//! Best point and trend of a metric over a grid, given the error of each value.

/// Direction of the optimum of a metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    Least,
    Largest,
}

impl Goal {
    /// The value with the sign that makes less better.
    pub fn cost(self, value: f64) -> f64 {
        match self {
            Self::Least => value,
            Self::Largest => -value,
        }
    }
}

/// A value with its error; `None` where the error is unknown.
pub type Uncertain = (f64, Option<f64>);

/// The best of several points.
#[derive(Debug, Clone, PartialEq)]
pub struct Best {
    pub point: usize,
    pub value: f64,
    /// Points that may be as good as the best one, which is among them. Their values differ from the best by no more
    /// than the sum of both errors, or their error is unknown. `None` where the error of the best is unknown.
    pub as_good: Option<Vec<usize>>,
}

/// The best point; points without a value do not compete, of equal ones the first wins.
pub fn best(values: &[Option<Uncertain>], goal: Goal) -> Option<Best> {
    let known = || values.iter().enumerate().filter_map(|(point, value)| value.map(|value| (point, value)));
    let (point, (value, error)) = known().reduce(|a, b| if goal.cost(b.1.0) < goal.cost(a.1.0) { b } else { a })?;
    let as_good = error.map(|error| {
        let may_be = |&(_, (its, its_error)): &(usize, Uncertain)| {
            its_error.is_none_or(|its_error| goal.cost(its) - goal.cost(value) <= error + its_error)
        };
        known().filter(may_be).map(|(other, _)| other).collect()
    });
    Some(Best { point, value, as_good })
}

/// Change of a metric over the points of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    /// Largest value less the least one.
    pub span: f64,
    /// Largest error of a point; `None` where one is unknown.
    pub error: Option<f64>,
    /// Correlation of the ranks of axis and metric (Spearman): 1 where it only rises, −1 where it only falls.
    pub monotony: f64,
}

/// A trend counts as resolved where no point is wrong by more than this share of its span.
const RESOLVED: f64 = 0.1;

impl Trend {
    /// Returns true where the change is well beyond the errors of the points; `None` where these are unknown.
    pub fn is_resolved(&self) -> Option<bool> {
        self.error.map(|error| error < RESOLVED * self.span)
    }
}

/// The trend of values over an axis in the order of the axis; `None` of fewer than two values.
pub fn trend(values: &[Option<Uncertain>]) -> Option<Trend> {
    let known: Vec<Uncertain> = values.iter().copied().flatten().collect();
    if known.len() < 2 {
        return None;
    }
    let (least, largest) =
        known.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (value, _)| (a.min(*value), b.max(*value)));
    let error = known.iter().map(|(_, error)| *error).reduce(|a, b| Some(a?.max(b?))).flatten();
    Some(Trend { span: largest - least, error, monotony: rank_correlation(&known) })
}

/// Rank correlation of the values with their order; ties share a rank. 0 where all are equal.
fn rank_correlation(values: &[Uncertain]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().map(|value| value.0).collect();
    sorted.sort_by(f64::total_cmp);
    let rank = |value: f64| {
        let below = sorted.partition_point(|other| *other < value) as f64;
        let equal = sorted.partition_point(|other| *other <= value) as f64 - below;
        below + 0.5 * (equal - 1.0)
    };
    let middle = 0.5 * (values.len() as f64 - 1.0);
    let off: Vec<(f64, f64)> =
        values.iter().enumerate().map(|(place, value)| (place as f64 - middle, rank(value.0) - middle)).collect();
    let sum = |f: fn(&(f64, f64)) -> f64| off.iter().map(f).sum::<f64>();
    let scale = (sum(|o| o.0 * o.0) * sum(|o| o.1 * o.1)).sqrt();
    if scale > 0.0 { sum(|o| o.0 * o.1) / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[f64], error: f64) -> Vec<Option<Uncertain>> {
        values.iter().map(|value| Some((*value, Some(error)))).collect()
    }

    #[test]
    fn the_best_point_and_those_that_may_be_as_good() {
        let values = of(&[3.0, 1.0, 1.15, 1.3, 5.0], 0.1);
        let least = best(&values, Goal::Least).unwrap();
        assert_eq!((least.point, least.value, least.as_good), (1, 1.0, Some(vec![1, 2])));
        assert_eq!(best(&values, Goal::Largest).unwrap().point, 4);
        let unknown = [None, Some((2.0, None)), Some((2.0, Some(0.1)))];
        assert_eq!(best(&unknown, Goal::Least), Some(Best { point: 1, value: 2.0, as_good: None }));
        let beside = [Some((2.0, Some(0.1))), Some((9.0, None)), Some((3.0, Some(0.1)))];
        assert_eq!(best(&beside, Goal::Least).unwrap().as_good, Some(vec![0, 1]), "nobody knows of the second");
        assert_eq!(best(&[None], Goal::Least), None);
    }

    #[test]
    fn a_trend_is_resolved_beyond_ten_times_its_error() {
        let rising = trend(&of(&[1.0, 2.0, 2.5, 4.0], 0.2)).unwrap();
        assert_eq!((rising.span, rising.error, rising.is_resolved()), (3.0, Some(0.2), Some(true)));
        assert!((rising.monotony - 1.0).abs() < 1e-12);
        let falling = trend(&of(&[4.0, 3.0, 1.0], 0.4)).unwrap();
        assert!((falling.monotony + 1.0).abs() < 1e-12);
        assert_eq!(falling.is_resolved(), Some(false));
        assert_eq!(trend(&of(&[1.0, 1.0], 0.0)).unwrap().monotony, 0.0);
        assert_eq!(trend(&[Some((1.0, None)), Some((2.0, Some(0.1)))]).unwrap().is_resolved(), None);
        assert_eq!(trend(&of(&[1.0], 0.1)), None);
    }
}
