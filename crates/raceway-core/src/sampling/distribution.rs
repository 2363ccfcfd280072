//! Distributions of a number by their inverse distribution functions. They use the own logarithm, so that one seed gives the same
//! points on every machine.

use crate::numerics::exponential::{exponential, logarithm};
use crate::numerics::roots::bracketed_root;

/// Distance of the limits of a tolerance from its middle, in standard deviations.
pub const LIMIT_SIGMAS: f64 = 3.0;

/// A continuous distribution. Its parameters have been checked: deviations are above 0, and limits rise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distribution {
    Uniform {
        from: f64,
        to: f64,
    },
    /// Cut at the limits, which contain the mean; infinite where it is not cut.
    Normal {
        mean: f64,
        standard_deviation: f64,
        limits: [f64; 2],
    },
    Triangular {
        from: f64,
        mode: f64,
        to: f64,
    },
    /// Of a number above 0 with this mean and standard deviation.
    Lognormal {
        mean: f64,
        standard_deviation: f64,
    },
}

impl Distribution {
    /// A normal distribution whose limits lie at ±3 standard deviations, and that is not cut.
    pub fn of_limits([least, greatest]: [f64; 2]) -> Self {
        Self::Normal {
            mean: 0.5 * (least + greatest),
            standard_deviation: (greatest - least) / (2.0 * LIMIT_SIGMAS),
            limits: [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// The value that a share of all values does not exceed, 0 < share < 1.
    pub fn quantile(&self, share: f64) -> f64 {
        match *self {
            Self::Uniform { from, to } => from + share * (to - from),
            Self::Normal { mean, standard_deviation, limits: [least, greatest] } => {
                let [low, high] = [least, greatest].map(|limit| normal_share((limit - mean) / standard_deviation));
                let value = mean + standard_deviation * normal_quantile(low + share * (high - low));
                value.clamp(least, greatest)
            }
            Self::Triangular { from, mode, to } => {
                let rise = (mode - from) / (to - from);
                if share < rise {
                    from + (share * (to - from) * (mode - from)).sqrt()
                } else {
                    to - ((1.0 - share) * (to - from) * (to - mode)).sqrt()
                }
            }
            Self::Lognormal { mean, standard_deviation } => {
                let variance = logarithm(1.0 + (standard_deviation / mean) * (standard_deviation / mean));
                mean * exponential(variance.sqrt() * normal_quantile(share) - 0.5 * variance)
            }
        }
    }
}

/// Shares of the standard normal distribution nearer to 0 and 1 than this are those of the limit of the rational functions.
const SMALLEST_SHARE: f64 = 1e-300;

/// The inverse of the standard normal distribution function to 16 digits (M. J. Wichura, AS 241, Appl. Statist. 37, 1988).
pub fn normal_quantile(share: f64) -> f64 {
    const A: [f64; 8] = [
        3.387_132_872_796_366_6,
        133.141_667_891_784_38,
        1_971.590_950_306_551_3,
        13_731.693_765_509_46,
        45_921.953_931_549_87,
        67_265.770_927_008_7,
        33_430.575_583_588_13,
        2_509.080_928_730_122_7,
    ];
    const B: [f64; 8] = [
        1.0,
        42.313_330_701_600_91,
        687.187_007_492_057_9,
        5_394.196_021_424_751,
        21_213.794_301_586_597,
        39_307.895_800_092_71,
        28_729.085_735_721_943,
        5_226.495_278_852_854,
    ];
    const C: [f64; 8] = [
        1.423_437_110_749_683_5,
        4.630_337_846_156_546,
        5.769_497_221_460_691,
        3.647_848_324_763_204_5,
        1.270_458_252_452_368_4,
        0.241_780_725_177_450_6,
        0.022_723_844_989_269_184,
        7.745_450_142_783_414e-4,
    ];
    const D: [f64; 8] = [
        1.0,
        2.053_191_626_637_759,
        1.676_384_830_183_803_8,
        0.689_767_334_985_1,
        0.148_103_976_427_480_08,
        0.015_198_666_563_616_457,
        5.475_938_084_995_345e-4,
        1.050_750_071_644_416_9e-9,
    ];
    const E: [f64; 8] = [
        6.657_904_643_501_103,
        5.463_784_911_164_114,
        1.784_826_539_917_291_3,
        0.296_560_571_828_504_87,
        0.026_532_189_526_576_124,
        0.001_242_660_947_388_078_4,
        2.711_555_568_743_487_6e-5,
        2.010_334_399_292_288_1e-7,
    ];
    const F: [f64; 8] = [
        1.0,
        0.599_832_206_555_887_9,
        0.136_929_880_922_735_8,
        0.014_875_361_290_850_615,
        7.868_691_311_456_133e-4,
        1.846_318_317_510_054_8e-5,
        1.421_511_758_316_446e-7,
        2.044_263_103_389_939_8e-15,
    ];
    let from_half = share - 0.5;
    if from_half.abs() <= 0.425 {
        let r = 0.180_625 - from_half * from_half;
        return from_half * ratio(&A, &B, r);
    }
    let tail = if from_half < 0.0 { share } else { 1.0 - share };
    let r = (-logarithm(tail.max(SMALLEST_SHARE))).sqrt();
    let distance = if r <= 5.0 { ratio(&C, &D, r - 1.6) } else { ratio(&E, &F, r - 5.0) };
    if from_half < 0.0 { -distance } else { distance }
}

/// Ratio of two polynomials with rising powers.
fn ratio(above: &[f64; 8], below: &[f64; 8], x: f64) -> f64 {
    let value = |of: &[f64; 8]| of.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient);
    value(above) / value(below)
}

/// Share of the standard normal distribution up to a value, as the root of its inverse.
fn normal_share(value: f64) -> f64 {
    if value > 0.0 {
        return 1.0 - normal_share(-value);
    }
    if value <= normal_quantile(SMALLEST_SHARE) {
        return 0.0;
    }
    bracketed_root(|share| normal_quantile(share) - value, SMALLEST_SHARE, 0.5)
}

/// Names or numbers with weights.
#[derive(Debug, Clone, PartialEq)]
pub struct Discrete {
    /// Share of each, all together 1.
    pub shares: Vec<f64>,
}

impl Discrete {
    /// Of weights above 0.
    pub fn of(weights: &[f64]) -> Self {
        let sum: f64 = weights.iter().sum();
        Self { shares: weights.iter().map(|weight| weight / sum).collect() }
    }

    /// The place at a share of the sum of the weights, 0 < share < 1.
    pub fn place(&self, share: f64) -> usize {
        let mut below = 0.0;
        for (place, own) in self.shares.iter().enumerate() {
            below += own;
            if share < below {
                return place;
            }
        }
        self.shares.len().saturating_sub(1)
    }

    /// The most probable place; of equal ones the first.
    pub fn mode(&self) -> usize {
        let places = 0..self.shares.len();
        places.reduce(|a, b| if self.shares[b] > self.shares[a] { b } else { a }).unwrap_or(0)
    }
}
