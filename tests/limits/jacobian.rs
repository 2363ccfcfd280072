//! The Jacobian of the model against plain difference quotients of its right-hand side, entry by entry.

use raceway::numerics::ode::OdeSystem;
use raceway::numerics::ode::structure::Jacobian;
use raceway::simulation::error::twin_system::Pair;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::model::equilibrium::start_state;
use serde_json::json;

use crate::scenes::{article, changed, defects, disturbed, everything, model_on, uneven_balls, waves};

/// Central differences of the whole right-hand side, dense.
fn dense(system: &impl OdeSystem, state: &[f64], sizes: &[f64]) -> Vec<Vec<f64>> {
    let n = state.len();
    let mut moved = state.to_vec();
    (0..n)
        .map(|column| {
            let displacement = 1e-5 * sizes[column];
            let mut rates = [vec![0.0; n], vec![0.0; n]];
            for (sign, rate) in [-1.0, 1.0].into_iter().zip(&mut rates) {
                moved[column] = state[column] + sign * displacement;
                system.derivative(0.0, &moved, rate);
            }
            moved[column] = state[column];
            (0..n).map(|row| (rates[1][row] - rates[0][row]) / (2.0 * displacement)).collect()
        })
        .collect()
}

/// `J e` of each unit vector equals the column of the difference quotients. Errors are relative to the size of the row.
#[test]
fn the_arrowhead_is_the_whole_jacobian() {
    let oil = changed(everything(), json!({ "operation": { "misalignment_mrad": { "y": 0.3 } } }));
    let wavy = changed(oil.clone(), waves());
    for (json, rung) in [
        (oil.clone(), ModelLevel::Full),
        (wavy, ModelLevel::Full),
        (changed(oil, defects(0.1)), ModelLevel::Full),
        (changed(everything(), uneven_balls(5.0)), ModelLevel::Full),
        (changed(everything(), json!({ "spindle": { "tilt": "free" } })), ModelLevel::Full),
        (changed(article(), uneven_balls(0.0)), ModelLevel::Planar),
        (article(), ModelLevel::Full),
        (article(), ModelLevel::Planar),
    ] {
        let model = model_on(&json, Some(rung));
        let layout = model.mechanism().layout;
        let state = disturbed(&model, 3);
        let sizes = layout.sizes();
        let n = state.len();
        let mut jacobian = Jacobian::new(&model.structure());
        let mut rate = vec![0.0; n];
        model.derivative(0.0, &state, &mut rate);
        let evaluations = model.jacobian(0.0, &state, &rate, &[], &mut jacobian);
        assert!(evaluations < 30, "{evaluations}");
        let expected = dense(&model, &state, &sizes);
        let mut worst = vec![0.0_f64; n];
        for (column, entries) in expected.iter().enumerate() {
            for (row, entry) in entries.iter().enumerate() {
                worst[row] = worst[row].max((entry * sizes[column]).abs());
            }
        }
        let (mut unit, mut product) = (vec![0.0; n], vec![0.0; n]);
        for column in 0..n {
            unit.fill(0.0);
            unit[column] = 1.0;
            jacobian.multiply(&unit, &mut product);
            for row in 0..n {
                let error = (product[row] - expected[column][row]).abs() * sizes[column];
                assert!(
                    error < 2e-4 * worst[row] + 1e-9,
                    "{rung:?}, d {}/d {}: {} instead of {}",
                    layout.name(row),
                    layout.name(column),
                    product[row],
                    expected[column][row]
                );
            }
        }
    }
}

/// Two distant states: each copy has its own Jacobian, in its own block.
#[test]
fn jacobian_of_a_pair_is_that_of_both() {
    let model = model_on(&article(), Some(ModelLevel::Full));
    let sizes = model.mechanism().layout.sizes();
    let start = start_state(&model).unwrap();
    let moved = |by: f64| -> Vec<f64> {
        start.iter().zip(&sizes).enumerate().map(|(i, (y, size))| y + by * (i as f64).sin() * size).collect()
    };
    let pair = Pair::new(&model);
    let (state, both_sizes) = (pair.joined(&moved(0.1), &moved(-0.3)), pair.joined(&sizes, &sizes));
    let n = pair.dimension();
    let mut jacobian = Jacobian::new(&pair.structure());
    let unused = vec![0.0; n];
    pair.jacobian(0.0, &state, &unused, &unused, &mut jacobian);

    let direction: Vec<f64> = both_sizes.iter().enumerate().map(|(i, size)| (1.7 * i as f64).cos() * size).collect();
    let mut product = unused.clone();
    jacobian.multiply(&direction, &mut product);
    let rate = |by: f64| {
        let moved: Vec<f64> = state.iter().zip(&direction).map(|(y, d)| y + by * d).collect();
        let mut rate = unused.clone();
        pair.derivative(0.0, &moved, &mut rate);
        rate
    };
    let (ahead, behind) = (rate(1e-5), rate(-1e-5));
    for i in 0..n {
        let expected = (ahead[i] - behind[i]) / 2e-5;
        let scale = product.iter().zip(&both_sizes).map(|(p, size)| (p / size).abs()).fold(0.0, f64::max);
        assert!((product[i] - expected).abs() < 1e-3 * scale * both_sizes[i], "{i}: {} {expected}", product[i]);
    }
}
