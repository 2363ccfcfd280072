//! Where the cage is symmetric and nothing acts along X, nothing leaves the plane: the planar rung is the full one.

use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use serde_json::{Value, json};

use crate::mirror_symmetry::difference;
use crate::scenes::{advance, article, changed, disturbed, model, model_on, rates};

fn symmetric() -> Value {
    changed(
        article(),
        json!({ "bearing": { "cage": { "seat": "closed", "offset_mm": 0 } }, "spindle": { "balance_grade": 6.3 } }),
    )
}

/// A planar state, or rates of it, in the full layout.
fn lifted(planar: &Model, full: &Model, y: &[f64]) -> Vec<f64> {
    let (from, to) = (planar.mechanism().layout, full.mechanism().layout);
    let mut lifted = vec![0.0; to.dimension()];
    for ball in 0..from.balls {
        to.set_ball(&mut lifted, ball, &from.ball(y, ball));
    }
    to.set_cage(&mut lifted, &from.cage(y));
    to.set_spindle(&mut lifted, &from.spindle(y));
    lifted
}

/// The scene is given the planar rung by itself, and both rungs have the same rates in the plane to rounding, the full
/// one none out of it.
#[test]
fn rates_in_the_plane_are_the_same_on_both_rungs() {
    for change in [json!({}), json!({ "lubricant": { "kind": "oil" }, "terms": { "hydrodynamics": "on" } })] {
        let json = changed(symmetric(), change);
        let (planar, full) = (model(&json), model_on(&json, Some(ModelLevel::Full)));
        assert!(matches!(planar, Model::Planar(_)) && matches!(full, Model::Full(_)));
        for seed in 1..=10 {
            let state = disturbed(&planar, seed);
            let expected = lifted(&planar, &full, &rates(&planar, 1e-4, &state));
            let found = rates(&full, 1e-4, &lifted(&planar, &full, &state));
            let off = difference(&full, &found, &expected);
            // Strips in the full contact are added one by one, in the planar one in pairs.
            assert!(off < 1e-14, "state {seed}: {off:e}");
        }
    }
}

/// From the same equilibrium both rungs take the same path, to integration error: steps differ, because errors are
/// averaged over another number of states.
#[test]
fn both_rungs_take_the_same_path() {
    let json = symmetric();
    let (planar, full) = (model(&json), model_on(&json, Some(ModelLevel::Full)));
    let start = start_state(&planar).unwrap();
    let lifted_start = lifted(&planar, &full, &start);
    let own_start = start_state(&full).unwrap();
    assert!(lifted_start.iter().zip(&own_start).all(|(a, b)| (a - b).abs() < 1e-14));
    let [coarse, fine] = [1e-5, 1e-7].map(|tolerance| {
        let a = advance(&planar, &start, (0.0, 3e-3), tolerance, |_| {});
        let b = advance(&full, &lifted_start, (0.0, 3e-3), tolerance, |_| {});
        let sizes = full.mechanism().layout.sizes();
        let off = lifted(&planar, &full, &a).into_iter().zip(&b).zip(sizes).map(|((a, b), size)| (a - b).abs() / size);
        off.fold(0.0, f64::max)
    });
    assert!(coarse < 1e-3 && fine < 1e-5 && fine < 0.2 * coarse, "{coarse:e}, then {fine:e}");
}
