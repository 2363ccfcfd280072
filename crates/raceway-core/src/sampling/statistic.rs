//! A statistic of a sample with its error, as the value of a point that is searched for.

use super::order_statistics::{interval_ranks, percentile};
use crate::numerics::statistics::mean;

/// Statistic of a metric over uncertain inputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Statistic {
    Mean,
    /// By its share of the values, 0 … 1.
    Percentile(f64),
}

/// Half-width of an interval of 95 % of a normal distribution, in standard deviations.
const NORMAL_95: f64 = 1.96;

impl Statistic {
    /// The statistic and half of an interval that contains it with 95 % probability, of a percentile the longer side, where one has both or
    /// one end. `None` of no values.
    pub fn of(self, values: &[f64]) -> Option<(f64, Option<f64>)> {
        match self {
            Self::Mean if values.is_empty() => None,
            Self::Mean => {
                let (middle, count) = (mean(values), values.len() as f64);
                let squares: f64 = values.iter().map(|value| (value - middle).powi(2)).sum();
                let error = (count > 1.0).then(|| NORMAL_95 * (squares / (count - 1.0) / count).sqrt());
                Some((middle, error))
            }
            Self::Percentile(share) => {
                let mut sorted = values.to_vec();
                sorted.sort_by(f64::total_cmp);
                let value = percentile(&sorted, share)?;
                let ends = interval_ranks(sorted.len(), share).into_iter().flatten();
                let distances = ends.filter_map(|rank| sorted.get(rank - 1)).map(|end| (end - value).abs());
                Some((value, distances.reduce(f64::max)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::design::Design;
    use crate::study::{Goal, optimum};

    /// z = x + u, u uniform ± ½: the narrow valley at 0 is best without scatter, the wide one at 3 with it.
    #[test]
    fn a_robust_optimum_avoids_a_narrow_valley() {
        let f = |z: f64| (20.0 * z.abs()).min(4.0 + (z - 3.0).abs());
        let at = |share: f64| -2.0 + 6.0 * share;
        let nominal = optimum(1, Goal::Least, &mut |x| Ok::<_, ()>(Some((f(at(x[0])), Some(1e-6))))).unwrap();
        let best = &nominal.evaluations[nominal.best.unwrap()];
        assert!(at(best.at[0]).abs() < 0.05, "{best:?}");
        let scattered = |x: f64, cube: &[Vec<f64>]| cube.iter().map(|u| f(x + u[0] - 0.5)).collect::<Vec<_>>();
        let p90 = Statistic::Percentile(0.9);
        let fine = Design::Sobol.cube(1, 256, 1);
        let (there, _) = p90.of(&scattered(0.0, &fine)).unwrap();
        assert!((there - 7.40).abs() < 0.03, "{there}");
        let cube = Design::Sobol.cube(1, 32, 1);
        let robust = optimum(1, Goal::Least, &mut |x| Ok::<_, ()>(p90.of(&scattered(at(x[0]), &cube)))).unwrap();
        let best = &robust.evaluations[robust.best.unwrap()];
        // Of all u, P90 is the same from 2.95 to 3.05.
        assert!((at(best.at[0]) - 3.0).abs() < 0.05, "{best:?}");
        let (value, _) = p90.of(&scattered(at(best.at[0]), &fine)).unwrap();
        assert!((value - 4.45).abs() < 0.03, "{value}");
    }

    #[test]
    fn errors_are_those_of_the_intervals() {
        let values: Vec<f64> = (1..=64).map(f64::from).collect();
        let (value, error) = Statistic::Percentile(0.9).of(&values).unwrap();
        // Ranks 53 to 63 about 58.1.
        assert!((value - 58.1).abs() < 1e-9 && (error.unwrap() - 5.1).abs() < 1e-9, "{value} {error:?}");
        let (value, error) = Statistic::Mean.of(&values).unwrap();
        assert!((value - 32.5).abs() < 1e-9 && (error.unwrap() - 1.96 * 18.618_987 / 8.0).abs() < 1e-5, "{error:?}");
        assert_eq!((Statistic::Mean.of(&[]), Statistic::Percentile(0.5).of(&[])), (None, None));
        assert_eq!(Statistic::Mean.of(&[1.0]), Some((1.0, None)));
    }
}
