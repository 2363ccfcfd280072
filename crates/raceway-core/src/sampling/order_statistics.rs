//! Percentiles of a sample with intervals that suppose no distribution, and its histogram.

/// Probability that an interval misses on one side.
const MISSED: f64 = 0.025;

/// The percentile of sorted values at a share, between the two nearest ones: the value of rank r lies at the share (r − ½)/n (Hazen).
/// `None` of no values.
pub fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let at = (share * sorted.len() as f64 - 0.5).clamp(0.0, last as f64);
    let below = at.floor() as usize;
    let (low, high) = (sorted[below], sorted[(below + 1).min(last)]);
    Some(low + (at - below as f64) * (high - low))
}

/// Ranks, from 1, of independent values between which the percentile at a share lies with a probability of at least 95 %, at most 2.5 %
/// beyond each; `None` for a bound that so few values do not give.
pub fn interval_ranks(count: usize, share: f64) -> [Option<usize>; 2] {
    let probabilities = binomial(count, share);
    // At most this many values are below the percentile.
    let mut sum = 0.0;
    let low = probabilities.iter().take_while(|probability| {
        sum += **probability;
        sum <= MISSED
    });
    let low = low.count();
    let mut sum = 0.0;
    let high = probabilities.iter().rev().take_while(|probability| {
        sum += **probability;
        sum <= MISSED
    });
    let high = count + 1 - high.count();
    [Some(low).filter(|rank| *rank > 0), Some(high).filter(|rank| *rank <= count)]
}

/// Probabilities of 0 … `count` successes, from the most probable number outwards so that no factor underflows.
fn binomial(count: usize, share: f64) -> Vec<f64> {
    let odds = share / (1.0 - share);
    let mode = ((count + 1) as f64 * share).floor().clamp(0.0, count as f64) as usize;
    let mut weights = vec![0.0; count + 1];
    weights[mode] = 1.0;
    for k in mode..count {
        weights[k + 1] = weights[k] * (count - k) as f64 / (k + 1) as f64 * odds;
    }
    for k in (0..mode).rev() {
        weights[k] = weights[k + 1] * (k + 1) as f64 / (count - k) as f64 / odds;
    }
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    weights
}

/// Numbers of values in equal intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    pub edges: Vec<f64>,
    pub counts: Vec<u64>,
}

/// Fewest and most intervals of a histogram.
const INTERVALS: [usize; 2] = [5, 40];

/// Histogram of sorted values: √n intervals, 5 to 40, from the least to the greatest; one interval where all are equal. `None` of no values.
pub fn histogram(sorted: &[f64]) -> Option<Histogram> {
    let (least, greatest) = (*sorted.first()?, *sorted.last()?);
    let wanted = ((sorted.len() as f64).sqrt().ceil() as usize).clamp(INTERVALS[0], INTERVALS[1]);
    let width = (greatest - least) / wanted as f64;
    // Values that differ by rounding alone have no intervals between them.
    let is_split = least + width > least && greatest - width < greatest;
    let intervals = if is_split { wanted } else { 1 };
    let mut edges: Vec<f64> = (0..intervals).map(|k| least + k as f64 * width).collect();
    edges.push(greatest);
    let mut counts = vec![0; intervals];
    for value in sorted {
        let place = if is_split { ((value - least) / width) as usize } else { 0 };
        counts[place.min(intervals - 1)] += 1;
    }
    Some(Histogram { edges, counts })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_of_the_ninetieth_percentile() {
        let expected = [(64, 53, 63), (100, 84, 96), (128, 108, 122), (256, 221, 240)];
        for (count, low, high) in expected {
            assert_eq!(interval_ranks(count, 0.9), [Some(low), Some(high)], "{count}");
            let mirrored = [Some(count + 1 - high), Some(count + 1 - low)];
            assert_eq!(interval_ranks(count, 0.1), mirrored, "{count}");
        }
    }

    #[test]
    fn a_bound_that_few_values_do_not_give_is_absent() {
        assert_eq!(interval_ranks(64, 0.95), [Some(57), None]);
        assert_eq!(interval_ranks(64, 0.05), [None, Some(8)]);
        assert_eq!((interval_ranks(71, 0.95)[1], interval_ranks(71, 0.05)[0]), (None, None));
        assert_eq!((interval_ranks(72, 0.95)[1], interval_ranks(72, 0.05)[0]), (Some(72), Some(1)));
        assert_eq!(interval_ranks(0, 0.5), [None, None]);
        let [low, high] = interval_ranks(4096, 0.95);
        assert!(low > Some(3800) && high < Some(3950), "{low:?} {high:?}");
    }

    #[test]
    fn percentiles_lie_between_the_nearest_values() {
        let values = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(percentile(&values, 0.5), Some(2.5));
        assert_eq!(percentile(&values, 0.01), Some(1.0));
        assert_eq!(percentile(&values, 0.99), Some(4.0));
        assert_eq!(percentile(&[], 0.5), None);
    }

    #[test]
    fn a_histogram_counts_every_value_once() {
        let values: Vec<f64> = (0..100).map(|k| f64::from(k * k)).collect();
        let of = histogram(&values).unwrap();
        assert_eq!((of.edges.len(), of.counts.len(), of.counts.iter().sum::<u64>()), (11, 10, 100));
        assert_eq!((of.edges[0], of.edges[10], of.counts[0]), (0.0, 9801.0, 32));
        let equal = histogram(&[2.0, 2.0]).unwrap();
        assert_eq!((equal.edges, equal.counts), (vec![2.0, 2.0], vec![2]));
        assert_eq!(histogram(&[]), None);
    }
}
