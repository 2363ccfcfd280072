use super::*;
use crate::numerics::ode::stability::StabilityWatch;
use crate::numerics::ode::test_problems::{BlowUp, Kepler, START};

const PARTS: [LinearPart; 2] = [LinearPart::Kinematic, LinearPart::Blocks];

fn method<'a, S: OdeSystem>(
    system: &'a S,
    state: &[f64],
    tolerance: f64,
    fixed: Option<f64>,
    part: LinearPart,
) -> FineAbm<'a, S> {
    FineAbm::new(system, 0.0, state, Tolerances::uniform(state.len(), tolerance, tolerance), fixed, part)
}

/// Error after one period, and of the angular momentum midway between the points.
fn fixed(steps: u32, part: LinearPart) -> (f64, f64) {
    let period = std::f64::consts::TAU;
    let mut method = method(&Kepler, &START, 1e-12, Some(period / f64::from(steps)), part);
    let (mut between, mut middle): (f64, _) = (0.0, [0.0; 4]);
    while method.time() < period {
        method.step(period).unwrap();
        method.interpolate(0.5 * (method.time() + method.previous_time()), &mut middle);
        let momentum = middle[0] * middle[3] - middle[1] * middle[2];
        between = between.max((momentum - START[0] * START[3]).abs());
    }
    assert_eq!(method.time(), period);
    (method.state().iter().zip(START).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt(), between)
}

/// Halving the step divides the end error by 2⁴ and the error between the points by at least as much.
#[test]
fn observed_order_is_four() {
    for part in PARTS {
        let (coarse, fine) = (fixed(1600, part), fixed(3200, part));
        let order = (coarse.0 / fine.0).log2();
        assert!((order - 4.0).abs() < 0.2, "{part:?}: order {order}, {coarse:?} {fine:?}");
        let dense = (coarse.1 / fine.1).log2();
        assert!(dense > 3.8, "{part:?} between steps: order {dense}");
    }
}
#[test]
fn without_a_linear_part_it_is_the_classical_pair() {
    let mut method = method(&Logistic, &[0.1], 1e-12, Some(0.1), LinearPart::Kinematic);
    let rates = |method: &FineAbm<'_, Logistic>| -> [f64; 4] { std::array::from_fn(|k| method.past.rests[k][0]) };
    while method.past.kept < MIN_KEPT {
        method.step(10.0).unwrap();
    }
    for _ in 0..10 {
        let (state, [f0, f1, f2, f3]) = (method.state()[0], rates(&method));
        method.step(10.0).unwrap();
        let predicted = state + 0.1 / 24.0 * (55.0 * f0 - 59.0 * f1 + 37.0 * f2 - 9.0 * f3);
        let at_end = predicted * (1.0 - predicted);
        let corrected = state + 0.1 / 24.0 * (9.0 * at_end + 19.0 * f0 - 5.0 * f1 + f2);
        assert!((method.state()[0] - corrected).abs() < 1e-15);
    }
}

struct Logistic;
impl OdeSystem for Logistic {
    fn dimension(&self) -> usize {
        1
    }
    fn derivative(&self, _time: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = y[0] * (1.0 - y[0]);
    }
}

/// A fast damped oscillator and a decay, one block each.
struct Linear;
const BLOCKS: [[f64; 4]; 2] = [[0.0, 1.0, -1e4, -20.0], [-300.0, 0.0, 0.0, -1.0]];
impl OdeSystem for Linear {
    fn dimension(&self) -> usize {
        4
    }
    fn derivative(&self, _time: f64, y: &[f64], dy: &mut [f64]) {
        for (k, (y, dy)) in y.chunks_exact(2).zip(dy.chunks_exact_mut(2)).enumerate() {
            let [a, b, c, d] = BLOCKS[k];
            dy.copy_from_slice(&[a * y[0] + b * y[1], c * y[0] + d * y[1]]);
        }
    }
    fn structure(&self) -> Structure {
        Structure { blocks: 2, block: 2, ..Structure::dense(0) }
    }
    fn jacobian(&self, _time: f64, _: &[f64], _: &[f64], _: &[f64], jacobian: &mut Jacobian) -> u64 {
        for (k, block) in BLOCKS.iter().enumerate() {
            block.iter().enumerate().for_each(|(i, entry)| *jacobian.blocks.entry_mut(k, i / 2, i % 2) = *entry);
        }
        0
    }
}

/// Steps of 0.2 are 20 radians of the oscillator and 60 decay times.
#[test]
fn a_linear_system_is_exact_with_any_step() {
    let mut method = method(&Linear, &[1.0, 0.0, 1.0, 2.0], 1e-13, Some(0.2), LinearPart::Blocks);
    while method.time() < 2.0 {
        method.step(2.0).unwrap();
    }
    let frequency = (1e4_f64 - 100.0).sqrt();
    let (sine, cosine) = (frequency * 2.0).sin_cos();
    let exact = [(-20.0_f64).exp() * (cosine + 10.0 / frequency * sine), 0.0, 0.0, 2.0 * (-2.0_f64).exp()];
    for (k, value) in method.state().iter().enumerate().filter(|(k, _)| *k != 1) {
        assert!((value - exact[k]).abs() < 1e-12, "{k}: {value:e} {:e}", exact[k]);
    }
}

/// ẏ = λ (y − cos t) − sin t (A. Prothero & A. Robinson, Math. Comp. 28 (1974) 145–162).
struct ProtheroRobinson(f64);
impl OdeSystem for ProtheroRobinson {
    fn dimension(&self) -> usize {
        1
    }
    fn derivative(&self, time: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = self.0 * (y[0] - time.cos()) - time.sin();
    }
}

/// The blocks take stiffness out of `f`; the kinematic part leaves the explicit limit h |λ| = 1.28.
#[test]
fn only_the_blocks_step_over_a_fast_decay() {
    let work = |part: LinearPart| {
        let mut method = method(&ProtheroRobinson(-1e4), &[1.0], 1e-6, None, part);
        while method.time() < 10.0 {
            method.step(10.0).unwrap();
            assert!((method.state()[0] - method.time().cos()).abs() < 3e-5);
        }
        method.statistics()
    };
    let (kinematic, blocks) = (work(LinearPart::Kinematic), work(LinearPart::Blocks));
    assert!(kinematic.steps > 70_000, "{kinematic:?}");
    assert!(blocks.steps < 500, "{blocks:?}");
}

#[test]
fn error_falls_with_the_tolerance() {
    for part in PARTS {
        let mut last = f64::INFINITY;
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
            let mut method = method(&Kepler, &START, tolerance, None, part);
            while method.time() < std::f64::consts::TAU {
                method.step(std::f64::consts::TAU).unwrap();
            }
            let error = (method.state()[1] - START[1]).abs();
            assert!(error < 1e3 * tolerance && error < last, "{part:?} {tolerance:e}: {error:e}");
            last = error;
            assert_eq!(method.time(), std::f64::consts::TAU);
        }
    }
}

/// Near the centre an orbit needs short steps, far from it long ones; twice the same bits.
#[test]
fn steps_are_halved_and_doubled_the_same_way_each_time() {
    let run = || {
        let mut method = method(&Kepler, &[1.8, 0.0, 0.0, 0.333_333_333_333_333_3], 1e-7, None, LinearPart::Blocks);
        let mut lengths = Vec::new();
        while method.time() < 20.0 {
            method.step(20.0).unwrap();
            if method.walker.is_none() {
                lengths.push(method.step);
            }
        }
        (lengths, method.state().to_vec())
    };
    let (lengths, again) = (run(), run());
    let ratios: Vec<f64> = lengths.0.windows(2).map(|pair| pair[1] / pair[0]).filter(|ratio| *ratio != 1.0).collect();
    assert!(ratios.contains(&2.0) && ratios.contains(&0.5), "{ratios:?}");
    assert_eq!(lengths, again);
}

/// Between the known points the halved grid lies on the quartic through them.
#[test]
fn a_quartic_survives_halving() {
    let mut method = method(&Logistic, &[0.1], 1e-6, Some(1.0), LinearPart::Kinematic);
    let quartic = |time: f64| 1.0 + time * (2.0 - time * (0.5 + time * (0.25 - 0.125 * time)));
    for (k, state) in method.past.states.iter_mut().enumerate() {
        state[0] = quartic(-(k as f64));
    }
    method.halve_step();
    for k in 0..MIN_KEPT {
        assert!((method.past.states[k][0] - quartic(-0.5 * k as f64)).abs() < 1e-12);
    }
    assert_eq!(method.step, 0.5);
}

/// y' = y², y(0) = 1 leaves the real numbers at t = 1.
#[test]
fn a_pole_is_a_failure_that_names_time_and_component() {
    for part in PARTS {
        for step in [None, Some(0.01)] {
            let mut method = method(&BlowUp, &[1.0, 1.0], 1e-8, step, part);
            let failure = loop {
                if let Err(failure) = method.step(20.0) {
                    break failure;
                }
            };
            match failure {
                IntegrationError::StepTooSmall { time, component: 1, .. } if step.is_none() => {
                    assert!((time - 1.0).abs() < 1e-3, "{time}");
                }
                IntegrationError::NotFinite { time, component: 1, .. } => {
                    assert!(time > 0.99 && time < 1.2, "{time}")
                }
                other => panic!("{step:?}: {other}"),
            }
        }
    }
}

/// Limits between two points of the grid, and a restart, cost accuracy nothing.
#[test]
fn limits_are_met_exactly() {
    let mut method = method(&Kepler, &START, 1e-9, None, LinearPart::Blocks);
    for k in 1..=20 {
        let limit = std::f64::consts::TAU * f64::from(k) / 20.0;
        while method.time() < limit {
            method.step(limit).unwrap();
            assert!(method.time() <= limit && method.previous_time() < method.time());
        }
        assert_eq!(method.time(), limit);
        if k == 10 {
            method.restart();
        }
    }
    let error = (method.state()[1] - START[1]).abs();
    assert!(error < 2e-6, "{error:e}");
}

/// A slow motion followed by one so fast that an error within tolerance makes its rate a million times too large.
struct Followed;
impl OdeSystem for Followed {
    fn dimension(&self) -> usize {
        2
    }
    fn derivative(&self, _: f64, y: &[f64], dy: &mut [f64]) {
        // Not quite what the linear part holds.
        dy.copy_from_slice(&[-y[0], -1e8 * (y[1] - y[0]) * (1.0 + 0.1 * y[0])]);
    }
    fn jacobian(&self, _: f64, _: &[f64], _: &[f64], _: &[f64], jacobian: &mut Jacobian) -> u64 {
        jacobian.corner_mut().copy_from_slice(&[-1.0, 0.0, 1e8, -1e8]);
        1
    }
}

#[test]
fn stiff_components_are_right_within_steps_too() {
    let tolerances = Tolerances::uniform(2, 1e-6, 1e-6);
    let mut method = FineAbm::new(&Followed, 0.0, &[1.0, 1.0], tolerances, None, LinearPart::Blocks);
    let (mut worst, mut state) = (0.0_f64, [0.0; 2]);
    while method.time() < 1e-2 {
        method.step(1e-2).unwrap();
        for share in [0.25, 0.5, 0.75] {
            let time = method.previous_time() + share * (method.time() - method.previous_time());
            method.interpolate(time, &mut state);
            worst = worst.max((state[1] - (-time).exp()).abs());
        }
    }
    assert!(worst < 1e-4, "{worst:e}");
}

/// y' = −2 y, half of which is in the linear part: the measured rate is the other half.
struct Halved;
impl OdeSystem for Halved {
    fn dimension(&self) -> usize {
        1
    }
    fn derivative(&self, _: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = -2.0 * y[0];
    }
    fn jacobian(&self, _: f64, _: &[f64], _: &[f64], _: &[f64], jacobian: &mut Jacobian) -> u64 {
        jacobian.corner_mut()[0] = -1.0;
        0
    }
}

#[test]
fn stability_is_that_of_what_the_linear_part_leaves() {
    for (step, beyond) in [(1.0, false), (2.0, true)] {
        let mut method = method(&Halved, &[1.0], 1e-9, Some(step), LinearPart::Blocks);
        let mut watch = StabilityWatch::new(step);
        let mut looks = 0;
        while looks < 60 {
            method.step(1e6).unwrap();
            // Nothing is seen on the way to the first points.
            if let Some(seen) = method.stability() {
                assert!(seen.rate < 1.0 + 1e-6, "{seen:?}");
                watch.look(seen);
                looks += 1;
            }
        }
        assert_eq!(watch.unstable().is_some(), beyond, "{step}: {watch:?}");
    }
}
