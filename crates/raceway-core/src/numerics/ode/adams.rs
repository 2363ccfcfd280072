//! Weights of Adams' formulas: the polynomial through the last rates, integrated once for a velocity and twice for a place.

/// Latest node first, in units of the step h. Velocity: v(h) = v(0) + h Σ velocity_i a_i; place: q(h) = q(0) + h v(0) +
/// h² Σ place_i a_i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weights<const N: usize> {
    pub velocity: [f64; N],
    pub place: [f64; N],
}

/// For `known` ≤ N nodes at latest, latest − 1, …, in steps; the others weigh nothing. `latest` 0: Adams–Bashforth, 1:
/// Adams–Moulton (Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I, III.1).
pub(crate) fn weights<const N: usize>(latest: f64, known: usize) -> Weights<N> {
    let mut weights = Weights { velocity: [0.0; N], place: [0.0; N] };
    let node = |i: usize| latest - i as f64;
    for i in 0..known.min(N) {
        // Lagrange's polynomial of the node, by rising powers.
        let mut polynomial = [0.0; N];
        polynomial[0] = 1.0;
        for other in (0..known.min(N)).filter(|other| *other != i) {
            let per_distance = 1.0 / (node(i) - node(other));
            for power in (0..N).rev() {
                let below = if power > 0 { polynomial[power - 1] } else { 0.0 };
                polynomial[power] = (below - node(other) * polynomial[power]) * per_distance;
            }
        }
        for (power, coefficient) in polynomial.into_iter().enumerate() {
            let once = power as f64 + 1.0;
            // ∫₀¹ sᵏ ds and ∫₀¹ (1 − s) sᵏ ds.
            weights.velocity[i] += coefficient / once;
            weights.place[i] += coefficient / (once * (once + 1.0));
        }
    }
    weights
}

/// Of the `known` ≤ N last values, latest first, in the next one by the polynomial through them: (−1)ⁱ⁺¹ `known` over i.
pub(crate) fn ahead<const N: usize>(known: usize) -> [f64; N] {
    let mut binomial = -1.0;
    std::array::from_fn(|i| {
        binomial *= -(known.saturating_sub(i) as f64) / (i as f64 + 1.0);
        binomial
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published formulas of order 4.
    #[test]
    fn weights_are_those_of_the_books() {
        let close = |found: [f64; 4], over: f64, expected: [f64; 4]| {
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found * over - expected).abs() < 1e-12 * over, "{found} {expected}/{over}");
            }
        };
        let bashforth = weights::<4>(0.0, 4);
        close(bashforth.velocity, 24.0, [55.0, -59.0, 37.0, -9.0]);
        close(bashforth.place, 360.0, [323.0, -264.0, 159.0, -38.0]);
        let moulton = weights::<4>(1.0, 4);
        close(moulton.velocity, 24.0, [9.0, 19.0, -5.0, 1.0]);
        close(moulton.place, 360.0, [38.0, 171.0, -36.0, 7.0]);
        close(weights::<4>(1.0, 2).velocity, 2.0, [1.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn the_next_value_continues_the_polynomial() {
        assert_eq!(ahead(4), [4.0, -6.0, 4.0, -1.0]);
        assert_eq!(ahead(2), [2.0, -1.0, 0.0, 0.0]);
        let cube = |x: f64| x * x * x - x;
        let next: f64 = ahead::<7>(7).iter().enumerate().map(|(i, weight)| weight * cube(-(i as f64))).sum();
        assert!((next - cube(1.0)).abs() < 1e-12);
    }
}
