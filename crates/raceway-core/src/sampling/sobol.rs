//! Sobol points with nested uniform scrambling.

use crate::numerics::random::SplitMix64;

/// Largest number of dimensions: pairs of points in twelve.
pub const MAX_DIMENSIONS: usize = 24;

const BITS: usize = 32;

/// Primitive polynomials beyond the first dimension, without their first and last coefficient, with the initial numbers of each, whose
/// count is its degree (S. Joe & F. Y. Kuo, SIAM J. Sci. Comput. 30, 2008, set new-joe-kuo-6).
const INITIAL: [(u32, &[u32]); MAX_DIMENSIONS - 1] = [
    (0, &[1]),
    (1, &[1, 3]),
    (1, &[1, 3, 1]),
    (2, &[1, 1, 1]),
    (1, &[1, 1, 3, 3]),
    (4, &[1, 3, 5, 13]),
    (2, &[1, 1, 5, 5, 17]),
    (4, &[1, 1, 5, 5, 5]),
    (7, &[1, 1, 7, 11, 19]),
    (11, &[1, 1, 5, 1, 1]),
    (13, &[1, 1, 1, 3, 11]),
    (14, &[1, 3, 5, 5, 31]),
    (1, &[1, 3, 3, 9, 7, 49]),
    (13, &[1, 1, 1, 15, 21, 21]),
    (16, &[1, 3, 1, 13, 27, 49]),
    (19, &[1, 1, 1, 15, 7, 5]),
    (22, &[1, 3, 1, 15, 13, 25]),
    (25, &[1, 1, 5, 5, 19, 61]),
    (1, &[1, 3, 7, 11, 23, 15, 103]),
    (4, &[1, 3, 7, 13, 13, 15, 69]),
    (7, &[1, 1, 3, 13, 7, 35, 63]),
    (8, &[1, 3, 5, 9, 1, 25, 53]),
    (14, &[1, 3, 1, 13, 9, 35, 107]),
];

/// Direction numbers of a dimension: the binary digits that each digit of a point's number contributes.
fn directions(dimension: usize) -> [u32; BITS] {
    let mut numbers = [0; BITS];
    let Some((polynomial, initial)) = dimension.checked_sub(1).and_then(|place| INITIAL.get(place)) else {
        // The first dimension reverses the digits.
        return std::array::from_fn(|digit| 1 << (BITS - 1 - digit));
    };
    let degree = initial.len();
    for digit in 0..BITS {
        numbers[digit] = match initial.get(digit) {
            Some(number) => number << (BITS - 1 - digit),
            None => {
                let first = numbers[digit - degree] ^ (numbers[digit - degree] >> degree);
                let has = |k: &usize| (polynomial >> (degree - 1 - k)) & 1 == 1;
                (1..degree).filter(has).fold(first, |number, k| number ^ numbers[digit - k])
            }
        };
    }
    numbers
}

/// The first points of the sequence in 0 … 1, both excluded, scrambled by the seed (A. B. Owen, in LNS 106, 1995): the digits of all
/// points that agree so far are kept or changed together. A power of two of points fills all intervals of its length once.
pub fn points(dimensions: usize, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut seeds = SplitMix64::new(seed);
    let columns: Vec<([u32; BITS], u64)> = (0..dimensions).map(|of| (directions(of), seeds.next())).collect();
    let point = |number: usize| {
        let coordinate = |(directions, seed): &([u32; BITS], u64)| {
            let digits = (0..BITS).filter(|digit| (number >> digit) & 1 == 1);
            let plain = digits.fold(0, |sum, digit| sum ^ directions[digit]);
            (f64::from(scrambled(plain, *seed)) + 0.5) / (1_u64 << BITS) as f64
        };
        columns.iter().map(coordinate).collect()
    };
    (0..count).map(point).collect()
}

/// Changes each digit by a random one of the digits before it.
fn scrambled(plain: u32, seed: u64) -> u32 {
    (0..BITS).fold(0, |sum, depth| {
        let before = u64::from(plain).checked_shr((BITS - depth) as u32).unwrap_or(0);
        let flip = SplitMix64::at(seed, (1 << depth) | before) >> 63;
        let digit = (plain >> (BITS - 1 - depth)) & 1;
        (sum << 1) | (digit ^ flip as u32)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of an independent implementation (SciPy 1.x, qmc.Sobol without scrambling).
    #[test]
    fn plain_numbers_are_those_of_joe_and_kuo() {
        let plain = |number: usize, dimension: usize| {
            let directions = directions(dimension);
            (0..BITS).filter(|digit| (number >> digit) & 1 == 1).fold(0, |sum, digit| sum ^ directions[digit])
        };
        let share = |number, dimension| f64::from(plain(number, dimension)) / 2_f64.powi(32);
        let of_point = |number| (0..MAX_DIMENSIONS).map(|dimension| share(number, dimension)).collect::<Vec<_>>();
        assert_eq!(of_point(1), vec![0.5; MAX_DIMENSIONS]);
        assert_eq!(of_point(100), POINT_100);
    }

    const POINT_100: [f64; MAX_DIMENSIONS] = [
        0.148_437_5,
        0.773_437_5,
        0.695_312_5,
        0.960_937_5,
        0.523_437_5,
        0.070_312_5,
        0.039_062_5,
        0.585_937_5,
        0.117_187_5,
        0.992_187_5,
        0.320_312_5,
        0.101_562_5,
        0.804_687_5,
        0.898_437_5,
        0.929_687_5,
        0.632_812_5,
        0.757_812_5,
        0.445_312_5,
        0.976_562_5,
        0.070_312_5,
        0.335_937_5,
        0.570_312_5,
        0.679_687_5,
        0.476_562_5,
    ];

    #[test]
    fn every_interval_has_one_point_whatever_the_seed() {
        for seed in [0, 1, 42] {
            let points = points(MAX_DIMENSIONS, 64, seed);
            for dimension in 0..MAX_DIMENSIONS {
                let mut places: Vec<usize> = points.iter().map(|point| (64.0 * point[dimension]) as usize).collect();
                places.sort_unstable();
                assert_eq!(places, (0..64).collect::<Vec<_>>(), "{dimension} {seed}");
            }
            // Two dimensions: every rectangle of sixty-four, whatever its shape.
            for width in 0..=6 {
                let (columns, rows) = (1 << width, 1 << (6 - width));
                let place = |point: &Vec<f64>| {
                    (f64::from(columns) * point[0]) as usize * rows as usize + (f64::from(rows) * point[1]) as usize
                };
                let mut places: Vec<usize> = points.iter().map(place).collect();
                places.sort_unstable();
                assert_eq!(places, (0..64).collect::<Vec<_>>(), "{width} {seed}");
            }
        }
        assert_ne!(points(2, 16, 1), points(2, 16, 2));
    }
}
