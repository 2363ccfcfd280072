//! The ellipse of contact, cut into strips along rolling.

/// A strip of the ellipse of contact, parallel to rolling.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Strip {
    /// Place of the strip's load, t = η/a in −1 … 1 [-].
    pub position: f64,
    /// Share of the normal load [-].
    pub weight: f64,
    /// Mean pressure over the largest pressure p₀ [-].
    pub pressure: f64,
}

/// Largest number of strips.
pub const MAX_STRIPS: usize = 33;
/// Number of strips where nothing else is asked.
pub const DEFAULT_STRIPS: usize = 9;

/// Places t > 0 and weights of ∫ ¾ (1 − t²) g(t) dt over −1 … 1 (Gauss–Jacobi), for 2, 4 and 6 points. The places are
/// the inner ones of Lobatto's rule with two more points (Abramowitz & Stegun, table 25.6), the weights those of the
/// table times ¾ (1 − t²).
const GAUSS: [&[(f64, f64)]; 3] = [
    &[(0.447_213_595_499_958, 0.5)],
    &[(0.285_231_516_480_645, 0.382_287_565_553_229), (0.765_055_323_929_465, 0.117_712_434_446_770)],
    &[
        (0.209_299_217_902_479, 0.295_792_918_221_050),
        (0.591_700_181_433_142, 0.166_269_399_016_888),
        (0.871_740_148_509_607, 0.037_937_682_762_061),
    ],
];

/// The ellipse of contact in strips of equal width over t = η/a, made once a scene.
///
/// The semi-ellipsoid of pressure, integrated along rolling, gives ¾ (1 − t²) of the load per unit of t. Weights and
/// positions integrate that exactly, so that traction is exact where it is linear within each strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strips {
    count: usize,
    strips: [Strip; MAX_STRIPS],
}

impl Strips {
    /// `count` strips, at least 1 and at most `MAX_STRIPS`.
    pub fn new(count: usize) -> Self {
        let count = count.clamp(1, MAX_STRIPS);
        let mut strips = [Strip::default(); MAX_STRIPS];
        // Half of the strips from the middle outwards, mirrored, so that symmetry holds to the bit.
        for (i, slot) in strips[..count].iter_mut().enumerate() {
            let mirrored = 2 * i + 1 < count;
            let i = if mirrored { count - 1 - i } else { i };
            let edge = |i: usize| (2 * i) as f64 / count as f64 - 1.0;
            let mut strip = strip_between(edge(i), edge(i + 1));
            if 2 * i + 1 == count {
                strip.position = 0.0;
            } else if mirrored {
                strip.position = -strip.position;
            }
            *slot = strip;
        }
        Self { count, strips }
    }

    /// The Gauss rule of the load with `2 × pairs` points (one to three pairs). It is exact for polynomials of t up to
    /// degree 4 `pairs` − 1, strips only up to degree 1. Traction laws with sharp bends need strips.
    pub fn gauss(pairs: usize) -> Self {
        let nodes = GAUSS[pairs.clamp(1, GAUSS.len()) - 1];
        let count = 2 * nodes.len();
        let mut strips = [Strip::default(); MAX_STRIPS];
        for (i, &(position, weight)) in nodes.iter().enumerate() {
            // The mean pressure of a chord of the ellipse.
            let pressure = std::f64::consts::FRAC_PI_4 * (1.0 - position * position).sqrt();
            let strip = Strip { position, weight, pressure };
            strips[nodes.len() + i] = strip;
            strips[nodes.len() - 1 - i] = Strip { position: -position, ..strip };
        }
        Self { count, strips }
    }

    /// The strips from t = −1 to t = 1.
    #[inline]
    pub fn as_slice(&self) -> &[Strip] {
        &self.strips[..self.count]
    }
}

impl Default for Strips {
    fn default() -> Self {
        Self::new(DEFAULT_STRIPS)
    }
}

/// Share of the normal load at t' < t, ½ + ¾ (t − t³/3) [-].
pub fn load_share_below(t: f64) -> f64 {
    0.5 + 0.75 * (t - t * t * t / 3.0)
}

/// The strip from t = `low` to t = `high`.
fn strip_between(low: f64, high: f64) -> Strip {
    let weight = load_share_below(high) - load_share_below(low);
    let first_moment = |t: f64| 0.75 * t * t * (0.5 - 0.25 * t * t);
    // Area under √(1 − t²), as a share of the half circle.
    let area_below = |t: f64| (t * (1.0 - t * t).max(0.0).sqrt() + t.asin()) / std::f64::consts::PI;
    Strip {
        position: (first_moment(high) - first_moment(low)) / weight,
        weight,
        // The mean pressure of the whole ellipse is ⅔ p₀.
        pressure: 2.0 / 3.0 * weight / (area_below(high) - area_below(low)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ ¾ (1 − t²) t^n dt is 3/((n + 1)(n + 3)) for even n; the points give it up to twice their number less one, and not beyond.
    #[test]
    fn gauss_points_are_exact_for_polynomials() {
        for pairs in 1..=3 {
            let points = Strips::gauss(pairs);
            assert_eq!(points.as_slice().len(), 2 * pairs);
            for n in 0..=4 * pairs {
                let sum: f64 = points.as_slice().iter().map(|p| p.weight * p.position.powi(n as i32)).sum();
                let exact = if n % 2 == 0 { 3.0 / ((n + 1) * (n + 3)) as f64 } else { 0.0 };
                assert_eq!((sum - exact).abs() < 1e-14, n < 4 * pairs, "{pairs} {n}: {sum} {exact}");
            }
        }
    }

    /// Weights sum to 1, positions mirror to the bit, pressures average to ⅔ p₀ of the whole ellipse.
    #[test]
    fn strips_share_the_whole_load() {
        for count in 1..=MAX_STRIPS {
            let strips = Strips::new(count);
            let slice = strips.as_slice();
            assert_eq!(slice.len(), count);
            assert!((slice.iter().map(|s| s.weight).sum::<f64>() - 1.0).abs() < 1e-14);
            for (left, right) in slice.iter().zip(slice.iter().rev()) {
                assert_eq!((left.position, left.weight), (-right.position, right.weight));
            }
            assert!(slice.windows(2).all(|pair| pair[0].position < pair[1].position));
            let areas: f64 = slice.iter().map(|s| s.weight / s.pressure).sum();
            assert!((areas - 1.5).abs() < 1e-13);
        }
        assert_eq!(Strips::new(0).as_slice().len(), 1);
        assert_eq!(Strips::new(1000).as_slice().len(), MAX_STRIPS);
    }
}
