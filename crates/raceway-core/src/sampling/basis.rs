//! Functions of one input that have mean 0 and mean square 1 over its distribution, and are orthogonal to each other.

use super::distribution::Discrete;

/// The functions of an input.
#[derive(Debug, Clone, PartialEq)]
pub enum Basis {
    /// Legendre polynomials of the probability: as many as the degree.
    Legendre,
    /// Indicators of names or numbers, made orthogonal: one less than there are, whatever the degree.
    Levels(Discrete),
}

impl Basis {
    /// Number of functions up to a degree.
    pub fn count(&self, degree: usize) -> usize {
        match self {
            Self::Legendre => degree,
            Self::Levels(of) => of.shares.len().saturating_sub(1),
        }
    }

    /// The function at a probability, 0 the first one.
    pub fn value(&self, function: usize, at: f64) -> f64 {
        match self {
            Self::Legendre => legendre(function + 1, 2.0 * at - 1.0),
            // Level k + 1 against those before it.
            Self::Levels(of) => {
                let (place, own) = (of.place(at), of.shares[function + 1]);
                let before: f64 = of.shares[..=function].iter().sum();
                if place <= function {
                    (own / (before * (before + own))).sqrt()
                } else if place == function + 1 {
                    -(before / (own * (before + own))).sqrt()
                } else {
                    0.0
                }
            }
        }
    }
}

/// Legendre polynomial over −1 … 1 with mean square 1.
fn legendre(degree: usize, x: f64) -> f64 {
    let (mut last, mut value) = (1.0, x);
    for n in 1..degree {
        let n = n as f64;
        (last, value) = (value, ((2.0 * n + 1.0) * x * value - n * last) / (n + 1.0));
    }
    value * (2.0 * degree as f64 + 1.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_orthonormal() {
        let levels = Basis::Levels(Discrete::of(&[1.0, 2.0, 5.0, 2.0]));
        for basis in [Basis::Legendre, levels] {
            let count = basis.count(6);
            let points = 20_000;
            let mean = |f: &dyn Fn(f64) -> f64| {
                (0..points).map(|k| f((f64::from(k) + 0.5) / f64::from(points))).sum::<f64>() / f64::from(points)
            };
            for one in 0..count {
                assert!(mean(&|at| basis.value(one, at)).abs() < 1e-6);
                for other in 0..count {
                    let product = mean(&|at| basis.value(one, at) * basis.value(other, at));
                    assert!((product - f64::from(u8::from(one == other))).abs() < 1e-5, "{one} {other} {product}");
                }
            }
        }
    }
}
