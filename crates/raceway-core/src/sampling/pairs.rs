//! First-order and total shares from pairs of samples, which suppose no form of the result (A. Saltelli et al., Comput. Phys. Commun. 181,
//! 2010, table 2, formulas b and f).

use super::expansion::{REPEATS, interval};
use crate::numerics::random::SplitMix64;
use crate::numerics::statistics::mean;

/// Shares of one input, each with an interval of 95 % of repeated draws of the rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairShares {
    /// Share of the variance that the input explains alone.
    pub first: f64,
    pub first_interval: [f64; 2],
    /// Share of the variance that remains where all other inputs are known: interactions with them included.
    pub total: f64,
    pub total_interval: [f64; 2],
}

/// The shares of each input from values in the order of the design's points; rows with a value missing are left out. `None` where fewer
/// than two rows are complete, or all values are equal.
pub fn pair_shares(values: &[Option<f64>], inputs: usize, samples: usize, seed: u64) -> Option<Vec<PairShares>> {
    let row =
        |row: usize| -> Option<Vec<f64>> { (0..inputs + 2).map(|set| *values.get(set * samples + row)?).collect() };
    let rows: Vec<Vec<f64>> = (0..samples).filter_map(row).collect();
    let all: Vec<usize> = (0..rows.len()).collect();
    if rows.len() < 2 {
        return None;
    }
    let shares = of_rows(&rows, &all, inputs)?;
    let mut random = SplitMix64::new(seed);
    let mut drawn = || -> Vec<usize> { all.iter().map(|_| (random.next() % rows.len() as u64) as usize).collect() };
    let repeats: Vec<_> = (0..REPEATS).filter_map(|_| of_rows(&rows, &drawn(), inputs)).collect();
    let of_input = |(input, [first, total]): (usize, &[f64; 2])| {
        let around = |place: usize, share: f64| {
            let repeated: Vec<f64> = repeats.iter().map(|shares| shares[input][place]).collect();
            if repeated.is_empty() { [0.0, 1.0] } else { interval(share, repeated) }
        };
        PairShares {
            first: *first,
            first_interval: around(0, *first),
            total: *total,
            total_interval: around(1, *total),
        }
    };
    Some(shares.iter().enumerate().map(of_input).collect())
}

/// First-order and total share of each input from some of the rows.
fn of_rows(rows: &[Vec<f64>], drawn: &[usize], inputs: usize) -> Option<Vec<[f64; 2]>> {
    let both: Vec<f64> = drawn.iter().flat_map(|row| rows[*row][..2].iter().copied()).collect();
    let middle = mean(&both);
    let variance = mean(&both.iter().map(|value| (value - middle).powi(2)).collect::<Vec<_>>());
    let over_variance =
        |of: &dyn Fn(&[f64]) -> f64| mean(&drawn.iter().map(|row| of(&rows[*row])).collect::<Vec<_>>()) / variance;
    let share = |input| {
        let first = over_variance(&|row| (row[1] - middle) * (row[2 + input] - row[0]));
        [first, over_variance(&|row| 0.5 * f64::powi(row[0] - row[2 + input], 2))]
    };
    (variance > (f64::EPSILON * middle).powi(2)).then(|| (0..inputs).map(share).collect())
}
