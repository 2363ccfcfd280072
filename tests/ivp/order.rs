//! Order of convergence: the error against the step.
//!
//! A method with step control takes the steps of a grid where each point of the grid is its limit and the tolerance accepts
//! every error. Such a tolerance also ends Newton's iteration after one increment. That is exact for the linear problems
//! here, because their Jacobian is exact.

use raceway::numerics::ode::structure::Jacobian;
use raceway::numerics::ode::{Integrator, Method, OdeSystem, Tolerances};

use crate::problems::all;

/// Runs with `steps` equal steps to `end`.
fn on_grid<'a>(system: &'a dyn OdeSystem, start: &[f64], end: f64, steps: u32) -> Box<dyn Integrator + 'a> {
    let loose = Tolerances::uniform(start.len(), 0.0, 1e60);
    let mut integrator = Method::Radau.start(system, 0.0, start, loose, None);
    for step in 1..=steps {
        integrator.step(end * f64::from(step) / f64::from(steps)).unwrap();
    }
    assert_eq!(integrator.time(), end, "a step fell short of the grid");
    assert_eq!(integrator.statistics().steps, u64::from(steps));
    assert_eq!(integrator.statistics().rejected_steps, 0);
    integrator
}

/// `y'' = 3 cos 2t − y`, that is `y = 2 cos t − cos 2t`.
struct Forced;
impl Forced {
    fn exact(time: f64) -> f64 {
        2.0 * time.cos() - (2.0 * time).cos()
    }
}
impl OdeSystem for Forced {
    fn dimension(&self) -> usize {
        2
    }
    fn derivative(&self, time: f64, y: &[f64], dy: &mut [f64]) {
        dy.copy_from_slice(&[y[1], 3.0 * (2.0 * time).cos() - y[0]]);
    }
    fn jacobian(&self, _time: f64, _y: &[f64], _rate: &[f64], _displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        jacobian.corner_mut().copy_from_slice(&[0.0, 1.0, -1.0, 0.0]);
        0
    }
}

/// Order 5 at the ends of steps. Order 4 within a step, the best that a polynomial of degree 3 gives.
#[test]
fn radau_has_order_five_and_four_between_steps() {
    let errors = |steps: u32| {
        let integrator = on_grid(&Forced, &[1.0, 0.0], 2.0, steps);
        let between = 0.5 * (integrator.time() + integrator.previous_time());
        let mut middle = [0.0; 2];
        integrator.interpolate(between, &mut middle);
        ((integrator.state()[0] - Forced::exact(2.0)).abs(), (middle[0] - Forced::exact(between)).abs())
    };
    let (coarse, fine) = (errors(20), errors(40));
    let (order, between) = ((coarse.0 / fine.0).log2(), (coarse.1 / fine.1).log2());
    println!("Radau IIA: order {order:.3}, between steps {between:.3}");
    assert!((order - 5.0).abs() < 0.2, "{order}");
    assert!((between - 4.0).abs() < 0.3, "{between}");
}

/// On a nonlinear problem with step control, the error falls with the fifth power of the mean step.
#[test]
fn radau_keeps_order_five_with_its_own_steps() {
    let problem = all().into_iter().find(|problem| problem.name == "Pleiades").expect("one of the problems");
    let run = |tolerance: f64| {
        let mut integrator = Method::Radau.start(&problem, 0.0, &problem.start, problem.tolerances(tolerance), None);
        while integrator.time() < problem.end {
            integrator.step(problem.end).unwrap();
        }
        (problem.error(integrator.state()), integrator.statistics().steps as f64)
    };
    let (coarse, fine) = (run(1e-6), run(1e-10));
    let order = (coarse.0 / fine.0).ln() / (fine.1 / coarse.1).ln();
    println!("Radau IIA with its own steps: order {order:.3}");
    assert!((order - 5.0).abs() < 0.5, "{order}");
}

/// `y' = λ (y − sin t) + cos t`, that is `y = sin t`.
struct Follower(f64);
impl OdeSystem for Follower {
    fn dimension(&self) -> usize {
        1
    }
    fn derivative(&self, time: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = self.0 * (y[0] - time.sin()) + time.cos();
    }
    fn jacobian(&self, _time: f64, _y: &[f64], _rate: &[f64], _displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        jacobian.corner_mut()[0] = self.0;
        0
    }
}

/// With steps long against 1/|λ| the order is 3, that of the stages, and not 5. The error then has a factor 1/|λ|
/// (Hairer & Wanner II, table IV.15.1: h⁴/(hλ)).
#[test]
fn radau_falls_to_order_three_on_a_stiff_follower_with_a_small_error() {
    let error = |lambda: f64, steps: u32| {
        let follower = Follower(lambda);
        let integrator = on_grid(&follower, &[0.0], 1.0, steps);
        (integrator.state()[0] - 1f64.sin()).abs()
    };
    for lambda in [-1e5, -1e6, -1e7] {
        let order = (error(lambda, 8) / error(lambda, 16)).log2();
        println!("Radau IIA, lambda = {lambda:e}: order {order:.3}, error {:.2e}", error(lambda, 16));
        assert!((order - 3.0).abs() < 0.3, "{lambda:e}: {order}");
        assert!(error(lambda, 8) * lambda.abs() < 1e-3, "{lambda:e}: {:e}", error(lambda, 8));
    }
    let gentle = (error(-1.0, 8) / error(-1.0, 16)).log2();
    assert!((gentle - 5.0).abs() < 0.2, "{gentle}");
}

/// `y' = λ y`
struct Decay(f64);
impl OdeSystem for Decay {
    fn dimension(&self) -> usize {
        1
    }
    fn derivative(&self, _time: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = self.0 * y[0];
    }
    fn jacobian(&self, _time: f64, _y: &[f64], _rate: &[f64], _displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        jacobian.corner_mut()[0] = self.0;
        0
    }
}

/// One step multiplies by R(z) = (1 + 2z/5 + z²/20)/(1 − 3z/5 + 3z²/20 − z³/60).
///
/// R is the Padé approximation of e^z that defines Radau IIA (Hairer & Wanner II, §IV.5). Fast components vanish in one
/// step, without a change of sign.
#[test]
fn radau_damps_fast_components_without_oscillation() {
    for z in [-0.1, -1.0, -10.0, -1e3, -1e6, -1e9] {
        let expected = (1.0 + 0.4 * z + 0.05 * z * z) / (1.0 - 0.6 * z + 0.15 * z * z - z * z * z / 60.0);
        let decay = Decay(z);
        let integrator = on_grid(&decay, &[1.0], 1.0, 1);
        let found = integrator.state()[0];
        assert!((found - expected).abs() < 1e-14, "{z}: {found:e} for {expected:e}");
        assert!(found > 0.0, "{z}: {found:e}");
    }
}
