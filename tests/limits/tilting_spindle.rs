//! A spindle that the bearing alone holds against tilt.

use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use serde_json::{Value, json};

use crate::scenes::{article, changed, model, rates};

/// The article's bearing without gravity and cage forces on its balls, under loads along Y and X [N], at rest.
fn standing(radial: f64, axial: f64, spindle: Value) -> Model {
    model(&changed(
        article(),
        json!({
            "gravity_m_s2": 0,
            "operation": { "speed_rpm": 0, "radial_load_y_n": radial, "radial_load_z_n": 0, "axial_load_n": axial },
            "spindle": spindle
        }),
    ))
}

/// Under a radial load beside the axial one, balls on one side carry more, and the ring tilts until no moment is left: its tilt rates do not
/// change, to the residual of the equilibrium. A held spindle takes the moment.
#[test]
fn the_start_is_an_equilibrium_of_moments() {
    let held = standing(20.0, 60.0, json!({}));
    let free = standing(20.0, 60.0, json!({ "tilt": "free" }));
    let state = start_state(&free).unwrap();
    let spindle = free.mechanism().layout.spindle(&state);
    let inertia = free.mechanism().spindle_inertia.unwrap();
    let [about_y, about_z] = spindle.tilt;
    assert!(about_y.abs() < 1e-9 && about_z.abs() > 1e-5, "{:?}", spindle.tilt);
    let rate = free.mechanism().layout.spindle(&rates(&free, 0.0, &state)).tilt_rate;
    let moment = rate.map(|rate| inertia.transverse * rate);
    assert!(moment.iter().all(|moment| moment.abs() < 1e-8), "{moment:?} N m");
    // The free ring yields more along the radial load.
    let yielded = |model: &Model| model.mechanism().layout.spindle(&start_state(model).unwrap()).position[1];
    assert!(yielded(&free) > 1.05 * yielded(&held), "{} {}", yielded(&free), yielded(&held));
}

/// A torque-free ring at an angle precesses: I_t β̈_y = −I_p Ω β̇_z and I_t β̈_z = I_p Ω β̇_y. Without load and contact nothing else acts.
#[test]
fn a_ring_without_contact_is_a_gyroscope() {
    let json = changed(
        article(),
        json!({
            "gravity_m_s2": 0,
            "bearing": { "radial_clearance_um": 40 },
            "operation": { "speed_rpm": 30000, "radial_load_y_n": 0, "radial_load_z_n": 0 },
            "spindle": { "tilt": "free", "transverse_inertia_kg_m2": 2e-5, "axial_inertia_kg_m2": 5e-7 }
        }),
    );
    let model = model(&json);
    let layout = model.mechanism().layout;
    let mut state = start_state(&model).unwrap();
    let mut spindle = layout.spindle(&state);
    (spindle.position, spindle.tilt, spindle.tilt_rate) = ([0.0; 3], [0.0; 2], [3.0, -2.0]);
    layout.set_spindle(&mut state, &spindle);
    let rate = layout.spindle(&rates(&model, 0.0, &state));
    let gyroscopic = 5e-7 / 2e-5 * model.mechanism().rotation.inner.at(0.0).1;
    assert_eq!(rate.tilt, [3.0, -2.0]);
    let expected = [gyroscopic * 2.0, gyroscopic * 3.0];
    for (rate, expected) in rate.tilt_rate.into_iter().zip(expected) {
        assert!((rate - expected).abs() < 1e-9 * expected, "{rate} {expected}");
    }
}
