//! The root of a function of one variable between two points.

/// Root of `f` between `low` and `high`, to the last few bits.
///
/// Bisection with regula falsi in the Illinois form (Dowell & Jarratt 1971) between the halvings, so that it needs no
/// derivative and never leaves the bracket. Returns the end with the smaller |f| if `f` does not change sign.
pub fn bracketed_root(f: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    let (mut a, mut b) = (low, high);
    let (mut fa, mut fb) = (f(a), f(b));
    if fa == 0.0 || fa.signum() == fb.signum() {
        return if fa.abs() <= fb.abs() { a } else { b };
    }
    for step in 0..400 {
        let bisect = 0.5 * (a + b);
        let secant = (a * fb - b * fa) / (fb - fa);
        // Every third step halves the bracket, which bounds the work for any f.
        let inside = secant > a.min(b) && secant < a.max(b);
        let x = if step % 3 == 2 || !inside { bisect } else { secant };
        if x == a || x == b || (b - a).abs() <= f64::EPSILON * a.abs().max(b.abs()) {
            break;
        }
        let fx = f(x);
        if fx == 0.0 {
            return x;
        }
        if fx.signum() == fb.signum() {
            fa *= 0.5;
        } else {
            (a, fa) = (b, fb);
        }
        (b, fb) = (x, fx);
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed forms: √2, the Dottie number (OEIS A003957) and a root where f is flat, to 1e-14 or 1e-5.
    #[test]
    fn known_roots_are_found() {
        assert!((bracketed_root(|x| x * x - 2.0, 0.0, 2.0) - 2f64.sqrt()).abs() < 1e-14);
        assert!((bracketed_root(|x| x.cos() - x, 0.0, 1.0) - 0.739_085_133_215_160_6).abs() < 1e-14);
        assert!(bracketed_root(|x| x.powi(9), -1.0, 3.0).abs() < 1e-5);
        assert!((bracketed_root(|x| x - 1e-12, 0.0, 1e12) / 1e-12 - 1.0).abs() < 1e-9);
    }
}
