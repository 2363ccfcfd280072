//! Published and exact cases through designs, distributions and expansions together.

use std::f64::consts::PI;

use super::basis::Basis;
use super::design::Design;
use super::distribution::{Discrete, Distribution, normal_quantile};
use super::expansion::{Expansion, expansion, expansion_up_to};
use super::order_statistics::percentile;
use super::pairs::pair_shares;
use crate::numerics::statistics::mean;

/// Number of seeds of a mean.
const SEEDS: u64 = 40;

fn uniform(from: f64, to: f64, inputs: usize) -> Vec<Distribution> {
    vec![Distribution::Uniform { from, to }; inputs]
}

fn values(points: &[Vec<f64>], inputs: &[Distribution], f: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let at =
        |point: &Vec<f64>| inputs.iter().zip(point).map(|(input, share)| input.quantile(*share)).collect::<Vec<_>>();
    points.iter().map(|point| f(&at(point))).collect()
}

fn expanded(points: &[Vec<f64>], values: &[f64]) -> Expansion {
    let bases = vec![Basis::Legendre; points[0].len()];
    let points: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
    expansion(&bases, &points, values, 1).unwrap()
}

fn variance(values: &[f64]) -> f64 {
    let middle = mean(values);
    mean(&values.iter().map(|value| (value - middle).powi(2)).collect::<Vec<_>>())
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

fn ishigami(x: &[f64]) -> f64 {
    x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
}

#[test]
fn a_linear_sum_is_explained_completely() {
    let inputs = uniform(-1.0, 1.0, 3);
    let points = Design::Sobol.cube(3, 256, 1);
    let values = values(&points, &inputs, |u| 4.0 * u[0] + 2.0 * u[1] - u[2]);
    assert!((variance(&values) - 7.0).abs() < 0.03, "{}", variance(&values));
    let found = expanded(&points, &values);
    assert!((found.q2 - 1.0).abs() < 1e-9);
    for (input, expected) in found.inputs.iter().zip([16.0 / 21.0, 4.0 / 21.0, 1.0 / 21.0]) {
        assert!((input.share - expected).abs() < 4e-3, "{input:?}");
        assert!((input.interval[0] - input.share).abs() < 1e-6 && (input.interval[1] - input.share).abs() < 1e-6);
    }
    assert!(found.inputs[0].slope > 0.0 && found.inputs[2].slope < 0.0);
}

#[test]
fn percentiles_of_a_sum_of_normal_inputs() {
    let normal =
        Distribution::Normal { mean: 0.0, standard_deviation: 1.0, limits: [f64::NEG_INFINITY, f64::INFINITY] };
    for (design, tolerance) in [(Design::Sobol, 0.04), (Design::LatinHypercube, 0.1)] {
        let sample = |seed| values(&design.cube(2, 1024, seed), &[normal; 2], |n| 10.0 + 3.0 * n[0] + 4.0 * n[1]);
        let samples: Vec<Vec<f64>> = (0..SEEDS).map(|seed| sorted(sample(seed))).collect();
        let mean_of = |of: &dyn Fn(&Vec<f64>) -> f64| mean(&samples.iter().map(of).collect::<Vec<_>>());
        assert!((mean_of(&|sample| variance(sample).sqrt()) - 5.0).abs() < 0.02);
        for (share, expected) in [(0.05, 1.776), (0.9, 16.408), (0.95, 18.224)] {
            let found = mean_of(&|sample| percentile(sample, share).unwrap());
            assert!((found - expected).abs() < tolerance, "{design:?} {share}: {found}");
        }
    }
}

/// Mean over seeds of shares and Q² of the Ishigami function.
fn ishigami_means(samples: usize) -> [f64; 4] {
    let inputs = uniform(-PI, PI, 3);
    let mut sums = [0.0; 4];
    for seed in 0..SEEDS {
        let points = Design::Sobol.cube(3, samples, seed);
        let found = expanded(&points, &values(&points, &inputs, ishigami));
        for (sum, share) in sums.iter_mut().zip(&found.inputs) {
            *sum += share.share / SEEDS as f64;
        }
        sums[3] += found.q2 / SEEDS as f64;
    }
    sums
}

#[test]
fn shares_of_the_ishigami_function() {
    let [first, second, third, q2] = ishigami_means(256);
    for (found, expected) in [(first, 0.313), (second, 0.437), (third, 0.001)] {
        assert!((found - expected).abs() < 0.01, "{found} instead of {expected}");
    }
    assert!((q2 - 0.69).abs() < 0.02, "{q2}");
    let [first, second, third, q2] = ishigami_means(64);
    for (found, expected) in [(first, 0.312), (second, 0.46), (third, 0.02)] {
        assert!((found - expected).abs() < 0.04, "{found} instead of {expected}");
    }
    assert!((q2 - 0.47).abs() < 0.12, "{q2}");
}

/// Polynomials up to degree 3 do not follow sin² over two periods: the second input, the strongest alone, seems to have no effect.
#[test]
fn degree_3_misses_the_second_input_of_the_ishigami_function() {
    let (inputs, bases) = (uniform(-PI, PI, 3), vec![Basis::Legendre; 3]);
    let [mut second, mut q2] = [0.0; 2];
    for seed in 0..SEEDS {
        let points = Design::Sobol.cube(3, 256, seed);
        let refs: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
        let found = expansion_up_to(3, &bases, &refs, &values(&points, &inputs, ishigami), 1).unwrap();
        assert_eq!(found.degree, 3);
        second += found.inputs[1].share / SEEDS as f64;
        q2 += found.q2 / SEEDS as f64;
    }
    assert!((second - 0.026).abs() < 0.002 && (q2 - 0.28).abs() < 0.01, "{second} {q2}");
}

#[test]
fn mean_variance_and_percentile_of_the_ishigami_function() {
    let mut sums = [0.0; 3];
    for seed in 0..SEEDS {
        let values = sorted(values(&Design::Sobol.cube(3, 1024, seed), &uniform(-PI, PI, 3), ishigami));
        let found = [mean(&values), variance(&values), percentile(&values, 0.9).unwrap()];
        sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += found / SEEDS as f64);
    }
    for (found, expected) in sums.into_iter().zip([3.5, 13.8446, 7.82]) {
        assert!((found / expected - 1.0).abs() < 3e-3, "{found} instead of {expected}");
    }
}

#[test]
fn total_shares_of_the_ishigami_function_from_pairs() {
    let inputs = uniform(-PI, PI, 3);
    let mut found = vec![[[0.0; 2]; 3]; SEEDS as usize];
    let mut covered = 0;
    for (seed, shares) in found.iter_mut().enumerate() {
        let points = Design::Pairs.cube(3, 256, seed as u64);
        let values: Vec<_> = values(&points, &inputs, ishigami).into_iter().map(Some).collect();
        let of_pairs = pair_shares(&values, 3, 256, 1).unwrap();
        for (share, pair) in shares.iter_mut().zip(&of_pairs) {
            *share = [pair.first, pair.total];
        }
        let [low, high] = of_pairs[0].total_interval;
        covered += u32::from((low..=high).contains(&0.5576));
    }
    let expected = [[0.3139, 0.5576], [0.4424, 0.4424], [0.0, 0.2437]];
    for input in 0..3 {
        for place in 0..2 {
            let of: Vec<f64> = found.iter().map(|shares| shares[input][place]).collect();
            let (middle, scatter) = (mean(&of), variance(&of).sqrt());
            assert!((middle - expected[input][place]).abs() < 0.02, "{input} {place}: {middle}");
            assert!(scatter < 0.06, "{input} {place}: {scatter}");
        }
    }
    assert!(covered >= 36, "{covered} of 40 intervals contain the total share");
}

#[test]
fn rows_with_a_missing_value_are_left_out_of_the_pairs() {
    let points = Design::Pairs.cube(2, 64, 1);
    let inputs = uniform(0.0, 1.0, 2);
    let mut values: Vec<_> = values(&points, &inputs, |x| x[0] + x[1]).into_iter().map(Some).collect();
    values[5] = None;
    values[100] = None;
    let found = pair_shares(&values, 2, 64, 1).unwrap();
    assert!((found[0].first - 0.5).abs() < 0.1 && (found[1].total - 0.5).abs() < 0.1);
    assert_eq!(pair_shares(&[Some(1.0); 256], 2, 64, 1), None);
    assert_eq!(pair_shares(&[], 2, 64, 1), None);
}

/// 1 for words a and b, 3 for c: a jump that no polynomial follows.
#[test]
fn words_are_explained_by_indicators() {
    let words = Discrete::of(&[1.0, 1.0, 2.0]);
    let points = Design::Sobol.cube(2, 64, 1);
    let values: Vec<f64> =
        points.iter().map(|point| if words.place(point[0]) == 2 { 3.0 } else { 1.0 } + 0.1 * point[1]).collect();
    let refs: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
    let found = expansion(&[Basis::Levels(words), Basis::Legendre], &refs, &values, 1).unwrap();
    assert!(found.q2 > 0.999 && found.inputs[0].share > 0.99, "{found:?}");
}

#[test]
fn too_few_or_equal_values_have_no_expansion() {
    let points = Design::LatinHypercube.cube(3, 7, 1);
    let refs: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
    let bases = vec![Basis::Legendre; 3];
    assert_eq!(expansion(&bases, &refs, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0], 1), None);
    let points = Design::Sobol.cube(3, 16, 1);
    let refs: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
    assert_eq!(expansion(&bases, &refs, &[2.0; 16], 1), None);
}

#[test]
fn noise_alone_is_not_explained() {
    let points = Design::Sobol.cube(3, 64, 1);
    let values: Vec<f64> = Design::LatinHypercube.cube(1, 64, 9).into_iter().map(|point| point[0]).collect();
    let found = expanded(&points, &values);
    assert!(found.q2 < 0.2, "{found:?}");
    assert!(found.inputs.iter().all(|input| input.interval[0] <= input.share && input.share <= input.interval[1]));
}

#[test]
fn quantiles_of_the_distributions() {
    let close = |found: f64, expected: f64| {
        assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{found} {expected}")
    };
    // Abramowitz & Stegun, table 26.5, and one far out.
    close(normal_quantile(0.975), 1.959_963_984_540_054);
    close(normal_quantile(0.1), -1.281_551_565_544_600_5);
    close(normal_quantile(1e-12), -7.034_483_825_301_131);
    close(normal_quantile(0.5), 0.0);
    let infinite = [f64::NEG_INFINITY, f64::INFINITY];
    close(Distribution::of_limits([5.0, 20.0]).quantile(normal_share_of_three()), 20.0);
    assert_eq!(
        Distribution::of_limits([5.0, 20.0]),
        Distribution::Normal { mean: 12.5, standard_deviation: 2.5, limits: infinite }
    );
    // Cut at ±1: the quartile is that of a share of 0.1587 + 0.25 · 0.6827.
    let cut = Distribution::Normal { mean: 0.0, standard_deviation: 1.0, limits: [-1.0, 1.0] };
    close(cut.quantile(0.25), -0.441_770_546_686_581_3);
    assert!(cut.quantile(1e-9) >= -1.0 && cut.quantile(1.0 - 1e-9) <= 1.0);
    let triangle = Distribution::Triangular { from: 0.0, mode: 1.0, to: 4.0 };
    close(triangle.quantile(0.25), 1.0);
    close(triangle.quantile(1.0 / 16.0), 0.5);
    close(triangle.quantile(0.75), 4.0 - 3_f64.sqrt());
    let corner = Distribution::Triangular { from: 0.0, mode: 0.0, to: 1.0 };
    close(corner.quantile(0.75), 0.5);
    let lognormal = Distribution::Lognormal { mean: 2.0, standard_deviation: 1.0 };
    close(lognormal.quantile(0.5), 2.0 / 1.25_f64.sqrt());
    let sample = values(&Design::Sobol.cube(1, 4096, 1), &[lognormal], |x| x[0]);
    assert!((mean(&sample) - 2.0).abs() < 2e-3 && (variance(&sample) - 1.0).abs() < 0.02);
    let discrete = Discrete::of(&[1.0, 3.0]);
    assert_eq!([0.1, 0.24, 0.26, 0.999].map(|share| discrete.place(share)), [0, 0, 1, 1]);
    assert_eq!((discrete.mode(), Discrete::of(&[1.0, 1.0]).mode()), (1, 0));
}

/// Share of a normal distribution below three standard deviations.
fn normal_share_of_three() -> f64 {
    0.998_650_101_968_369_9
}
