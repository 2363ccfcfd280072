//! Designs: points in the unit cube, the same for one seed on every machine.

use super::sobol;
use crate::numerics::random::SplitMix64;

/// Largest number of inputs.
pub const MAX_INPUTS: usize = 12;

/// How points are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Design {
    /// Scrambled Sobol points; their number is a power of two.
    Sobol,
    /// One point in each of equal intervals of each input, in random order.
    LatinHypercube,
    /// Two sets of Sobol points, and the first with one coordinate after the other from the second (A. Saltelli, Comput. Phys. Commun. 145,
    /// 2002).
    Pairs,
}

impl Design {
    /// Number of points for `samples` of `inputs`.
    pub fn points(self, inputs: usize, samples: usize) -> usize {
        samples.saturating_mul(match self {
            Self::Sobol | Self::LatinHypercube => 1,
            Self::Pairs => inputs + 2,
        })
    }

    /// Number of the points, the first ones, that are a sample of the distribution.
    pub fn sampled(self, samples: usize) -> usize {
        match self {
            Self::Sobol | Self::LatinHypercube => samples,
            Self::Pairs => 2 * samples,
        }
    }

    /// True if the number of samples must be a power of two.
    pub fn takes_powers_of_two(self) -> bool {
        self != Self::LatinHypercube
    }

    /// The points, at most twelve inputs. Pairs: both sets, then for each input the first set with that coordinate from the second.
    pub fn cube(self, inputs: usize, samples: usize, seed: u64) -> Vec<Vec<f64>> {
        match self {
            Self::Sobol => sobol::points(inputs, samples, seed),
            Self::LatinHypercube => latin_hypercube(inputs, samples, seed),
            Self::Pairs => {
                let both = sobol::points(2 * inputs, samples, seed);
                let set = |from: usize| both.iter().map(move |point| point[from..from + inputs].to_vec());
                let exchanged = |input: usize| {
                    both.iter().map(move |point| {
                        let mut own = point[..inputs].to_vec();
                        own[input] = point[inputs + input];
                        own
                    })
                };
                set(0).chain(set(inputs)).chain((0..inputs).flat_map(exchanged)).collect()
            }
        }
    }
}

/// Latin hypercube (M. D. McKay, R. J. Beckman & W. J. Conover, Technometrics 21, 1979).
fn latin_hypercube(inputs: usize, samples: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = SplitMix64::new(seed);
    let mut points = vec![Vec::with_capacity(inputs); samples];
    for _ in 0..inputs {
        let mut places: Vec<usize> = (0..samples).collect();
        for last in (1..samples).rev() {
            // The bias of the remainder is below 2⁻⁵⁰.
            places.swap(last, (random.next() % (last as u64 + 1)) as usize);
        }
        for (point, place) in points.iter_mut().zip(places) {
            point.push((place as f64 + random.inside()) / samples as f64);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_latin_hypercube_has_one_point_in_each_interval() {
        let points = Design::LatinHypercube.cube(3, 100, 7);
        assert!(points.iter().flatten().all(|x| *x > 0.0 && *x < 1.0));
        for input in 0..3 {
            let mut places: Vec<usize> = points.iter().map(|point| (100.0 * point[input]) as usize).collect();
            places.sort_unstable();
            assert_eq!(places, (0..100).collect::<Vec<_>>());
        }
        assert_eq!(points, Design::LatinHypercube.cube(3, 100, 7));
        assert_ne!(points, Design::LatinHypercube.cube(3, 100, 8));
    }

    #[test]
    fn pairs_exchange_one_coordinate() {
        let (inputs, samples) = (3, 16);
        let points = Design::Pairs.cube(inputs, samples, 1);
        assert_eq!(points.len(), Design::Pairs.points(inputs, samples));
        for row in 0..samples {
            for input in 0..inputs {
                let exchanged = &points[(2 + input) * samples + row];
                for other in 0..inputs {
                    let from = if other == input { samples + row } else { row };
                    assert_eq!(exchanged[other], points[from][other]);
                }
            }
        }
    }
}
