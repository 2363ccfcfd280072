use super::coefficients::MAX_ORDER;
use super::*;

/// y' = −2 t y², y = 1/(1 + t²).
struct Witch;
impl OdeSystem for Witch {
    fn dimension(&self) -> usize {
        1
    }
    fn derivative(&self, time: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = -2.0 * time * y[0] * y[0];
    }
}

fn witch(time: f64) -> f64 {
    1.0 / (1.0 + time * time)
}

/// Error at t = 2, and the largest halfway between steps, with steps and order held, from an exact past.
fn held(order: usize, steps: usize) -> (f64, f64) {
    let step = 1.0 / steps as f64;
    let mut method = Gear::new(&Witch, 1.0, &[witch(1.0)], Tolerances::uniform(1, 1.0, 1.0));
    let mut table: Vec<f64> = (0..=order).map(|back| witch(1.0 - back as f64 * step)).collect();
    for i in 0..=order {
        method.differences[i][0] = table[0];
        table = table.windows(2).map(|pair| pair[0] - pair[1]).collect();
    }
    (method.order, method.known, method.steps) = (order, order + 1, [step; DIFFERENCES]);
    // The corrector is solved to rounding.
    method.weights = vec![1e14];
    let (mut between, mut state) = (0.0_f64, [0.0]);
    for n in 1..=steps {
        let c = Coefficients::new(step, &method.steps, order);
        let end = 1.0 + n as f64 * step;
        let tried = Try { step, end, cut: false };
        method.predict(&c);
        assert!(method.correct(&tried, &c).is_ok());
        method.accept(&tried, &c);
        method.interpolate(end - 0.5 * step, &mut state);
        between = between.max((state[0] - witch(end - 0.5 * step)).abs());
    }
    ((method.state()[0] - witch(2.0)).abs(), between)
}

#[test]
fn observed_orders_are_one_to_five() {
    for order in 1..=MAX_ORDER {
        let (coarse, fine) = (held(order, 80), held(order, 160));
        let observed = (coarse.0 / fine.0).log2();
        assert!((observed - order as f64).abs() < 0.2, "order {order}: {observed}");
        let observed = (coarse.1 / fine.1).log2();
        assert!(observed > order as f64 - 0.2, "order {order} between steps: {observed}");
    }
}

/// Steps of any sizes: a polynomial as high as the order is its own solution.
#[test]
fn polynomials_are_exact_on_uneven_steps() {
    struct Power(i32);
    impl OdeSystem for Power {
        fn dimension(&self) -> usize {
            1
        }
        fn derivative(&self, time: f64, _y: &[f64], dy: &mut [f64]) {
            dy[0] = f64::from(self.0) * time.powi(self.0 - 1);
        }
    }
    for order in 1..=MAX_ORDER {
        let system = Power(order as i32);
        let mut method = Gear::new(&system, 1.0, &[1.0], Tolerances::uniform(1, 1.0, 1.0));
        // Steps grow and shrink from a past that is exact.
        let past = [0.1, 0.07, 0.12, 0.09, 0.11];
        let mut times = vec![1.0_f64];
        for step in &past[..order] {
            times.push(times[times.len() - 1] - step);
        }
        // Modified divided differences: divided differences times the distances to the past.
        let mut table: Vec<f64> = times.iter().map(|t| t.powi(order as i32)).collect();
        let mut distance = 1.0;
        for i in 0..=order {
            method.differences[i][0] = table[0] * distance;
            distance *= if i < order { times[0] - times[i + 1] } else { 1.0 };
            table = (0..order - i).map(|k| (table[k] - table[k + 1]) / (times[k] - times[k + 1 + i])).collect();
        }
        (method.order, method.known) = (order, order + 1);
        method.steps[..order].copy_from_slice(&past[..order]);
        method.weights = vec![1e14];
        let mut end = 1.0_f64;
        for step in [0.08, 0.2, 0.05, 0.3, 0.15, 0.15] {
            let c = Coefficients::new(step, &method.steps, order);
            end += step;
            let tried = Try { step, end, cut: false };
            method.predict(&c);
            assert!(method.correct(&tried, &c).is_ok());
            method.accept(&tried, &c);
            let exact = end.powi(order as i32);
            assert!((method.state()[0] / exact - 1.0).abs() < 1e-12, "order {order}: {}", method.state()[0] - exact);
        }
    }
}

/// A right-hand side that jumps at t = 1, where the method restarts.
#[test]
fn a_restart_forgets_the_past() {
    struct Ramp;
    impl OdeSystem for Ramp {
        fn dimension(&self) -> usize {
            1
        }
        fn derivative(&self, time: f64, _y: &[f64], dy: &mut [f64]) {
            dy[0] = if time < 1.0 { 1.0 } else { -2.0 * (time - 0.5) };
        }
    }
    let mut method = Gear::new(&Ramp, 0.0, &[0.0], Tolerances::uniform(1, 1e-8, 1e-8));
    for stop in [1.0, 2.0] {
        while method.time() < stop {
            method.step(stop).unwrap();
        }
        assert_eq!(method.time(), stop);
        method.restart();
    }
    assert!((method.state()[0] + 1.0).abs() < 1e-6, "{}", method.state()[0]);
}
