use super::coefficients::*;
use super::*;
use crate::numerics::ode::structure::Structure;

/// The constants have their defining property: A⁻¹ differentiates polynomials that vanish at 0.
#[test]
fn the_transformation_diagonalizes() {
    let difference = 1e-6;
    // A⁻¹ by definition: slopes of the basis at the stages.
    let inverse: [[f64; 3]; 3] = std::array::from_fn(|row| {
        let (after, before) = (basis(C[row] + difference), basis(C[row] - difference));
        std::array::from_fn(|k| (after[k] - before[k]) / (2.0 * difference))
    });
    let product = |a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]| -> [[f64; 3]; 3] {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
    };
    let transformed = product(&product(&T_INVERSE, &inverse), &T);
    let expected = [[REAL, 0.0, 0.0], [0.0, PAIR.re, -PAIR.im], [0.0, PAIR.im, PAIR.re]];
    let identity = product(&T_INVERSE, &T);
    for i in 0..3 {
        for j in 0..3 {
            assert!((transformed[i][j] - expected[i][j]).abs() < 1e-8, "{transformed:?}");
            assert!((identity[i][j] - f64::from(u8::from(i == j))).abs() < 1e-15, "{identity:?}");
        }
    }
    let (at, before) = (basis(difference), basis(-difference));
    for k in 0..3 {
        assert!(((at[k] - before[k]) / (2.0 * difference) - SLOPE_AT_START[k]).abs() < 1e-8);
    }
}

fn run<'a, S: OdeSystem + ?Sized>(
    system: &'a S,
    start: &[f64],
    end: f64,
    tolerance: f64,
) -> Result<Radau<'a, S>, IntegrationError> {
    let tolerances = Tolerances::uniform(start.len(), tolerance, tolerance);
    let mut method = Radau::new(system, 0.0, start, tolerances);
    while method.time() < end {
        method.step(end)?;
    }
    Ok(method)
}

/// Two masses on springs, one of them stiff and damped, coupled through a third: an arrowhead.
struct Springs {
    arrow: bool,
}
impl Springs {
    const START: [f64; 6] = [0.1, 0.0, 0.0, 0.0, 1.0, 0.0];
    const MATRIX: [[f64; 6]; 6] = [
        [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [-2.0, -0.1, 0.0, 0.0, 2.0, 0.0],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, -1e6, -3e3, 1e6, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        [0.2, 0.0, 0.3, 0.0, -1.5, 0.0],
    ];
}
impl OdeSystem for Springs {
    fn dimension(&self) -> usize {
        6
    }
    fn derivative(&self, _time: f64, y: &[f64], dy: &mut [f64]) {
        for (row, dy) in Self::MATRIX.iter().zip(dy) {
            *dy = row.iter().zip(y).map(|(a, y)| a * y).sum();
        }
    }
    fn structure(&self) -> Structure {
        if !self.arrow {
            return Structure::dense(self.dimension());
        }
        let pairs = || vec![(0, 1)];
        Structure { blocks: 2, block: 2, border: 2, block_pairs: pairs(), border_pairs: pairs() }
    }
    fn jacobian(&self, _: f64, _: &[f64], _: &[f64], _: &[f64], jacobian: &mut Jacobian) -> u64 {
        let n = self.dimension();
        for (row, entries) in Self::MATRIX.iter().enumerate() {
            for (column, &entry) in entries.iter().enumerate() {
                if !self.arrow {
                    jacobian.corner_mut()[row * n + column] = entry;
                    continue;
                }
                match (row / 2, column / 2) {
                    (2, 2) => jacobian.corner_mut()[(row - 4) * 2 + column - 4] = entry,
                    (2, of) => *jacobian.below.entry_mut(of, row - 4, column - 2 * of) = entry,
                    (of, 2) => *jacobian.right.entry_mut(of, row - 2 * of, column - 4) = entry,
                    (of, same) if of == same => *jacobian.blocks.entry_mut(of, row - 2 * of, column - 2 * of) = entry,
                    _ => assert_eq!(entry, 0.0),
                }
            }
        }
        0
    }
}

/// Arrowhead or dense: the same motion.
#[test]
fn structure_changes_the_cost_only() {
    let dense = run(&Springs { arrow: false }, &Springs::START, 5.0, 1e-9).unwrap();
    let arrow = run(&Springs { arrow: true }, &Springs::START, 5.0, 1e-9).unwrap();
    for (a, b) in arrow.state().iter().zip(dense.state()) {
        assert!((a - b).abs() < 1e-10, "{:?}", arrow.state());
    }
    assert_eq!(arrow.statistics().steps, dense.statistics().steps);
}

/// `y' = f(y)`
struct Scalar(fn(f64) -> f64);
impl OdeSystem for Scalar {
    fn dimension(&self) -> usize {
        1
    }
    fn derivative(&self, _time: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = (self.0)(y[0]);
    }
}

/// y' = −√y ends at y = 0: a rate that is not a number shortens the step, and the integrator reports the time where no
/// step is short enough.
#[test]
fn a_rate_that_is_not_finite_is_avoided_or_reported() {
    let root = Scalar(|y| -y.sqrt());
    let before = run(&root, &[1.0], 1.999, 1e-8).unwrap();
    assert!((before.state()[0] - 0.000_5f64.powi(2)).abs() < 1e-8, "{:?}", before.state());
    assert!(run(&root, &[1.0], 3.0, 1e-8).is_err());
    let told = run(&Scalar(|_| f64::NAN), &[1.0], 1.0, 1e-8).map(|method| method.time());
    assert!(matches!(told, Err(IntegrationError::NotFinite { time: 0.0, component: 0, .. })), "{told:?}");
}

/// The limit is met exactly, however the steps fall, and the polynomial passes through both ends.
#[test]
fn steps_end_at_the_limit_and_join() {
    let system = Scalar(|y| -y);
    let mut method = Radau::new(&system, 0.0, &[1.0], Tolerances::uniform(1, 1e-8, 1e-8));
    let mut between = [0.0];
    let mut last = 1.0;
    for part in 1..=40 {
        let limit = f64::from(part) * 0.1;
        while method.time() < limit {
            method.step(limit).unwrap();
            method.interpolate(method.previous_time(), &mut between);
            assert!((between[0] - last).abs() < 1e-15);
            method.interpolate(method.time(), &mut between);
            last = method.state()[0];
            assert!((between[0] - last).abs() < 1e-15);
        }
        assert_eq!(method.time(), limit);
        assert!((last - (-limit).exp()).abs() < 1e-7, "{limit}: {last}");
    }
}

/// After a jump of the right-hand side nothing of the past counts.
#[test]
fn a_restart_forgets_the_past() {
    struct Switched(std::cell::Cell<f64>);
    impl OdeSystem for Switched {
        fn dimension(&self) -> usize {
            1
        }
        fn derivative(&self, _time: f64, y: &[f64], dy: &mut [f64]) {
            dy[0] = -1e3 * (y[0] - self.0.get());
        }
    }
    let system = Switched(std::cell::Cell::new(1.0));
    let mut method = Radau::new(&system, 0.0, &[0.0], Tolerances::uniform(1, 1e-8, 1e-8));
    while method.time() < 1.0 {
        method.step(1.0).unwrap();
    }
    assert!((method.state()[0] - 1.0).abs() < 1e-9);
    system.0.set(-1.0);
    method.restart();
    while method.time() < 1.002 {
        method.step(1.002).unwrap();
    }
    assert!((method.state()[0] - (2.0 * (-2f64).exp() - 1.0)).abs() < 1e-6, "{}", method.state()[0]);
}
