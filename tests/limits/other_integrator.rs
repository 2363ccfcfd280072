//! The model of the library is a system dy/dt = f(t, y) for any integrator.

use raceway::contract::scene_from_json;
use raceway::numerics::ode::OdeSystem;
use raceway::simulation::input::settings::Outputs;
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::terms::ActiveTerms;

use crate::scenes::advance;

/// The classical Runge–Kutta method with a constant step, written without the library.
fn runge_kutta_4(system: &impl OdeSystem, state: &[f64], steps: u32, step: f64) -> Vec<f64> {
    let slope = |time: f64, y: &[f64]| {
        let mut dy = vec![0.0; system.dimension()];
        system.derivative(time, y, &mut dy);
        dy
    };
    let moved = |y: &[f64], by: f64, dy: &[f64]| -> Vec<f64> { y.iter().zip(dy).map(|(y, d)| y + by * d).collect() };
    let mut y = state.to_vec();
    for k in 0..steps {
        let time = f64::from(k) * step;
        let k1 = slope(time, &y);
        let k2 = slope(time + 0.5 * step, &moved(&y, 0.5 * step, &k1));
        let k3 = slope(time + 0.5 * step, &moved(&y, 0.5 * step, &k2));
        let k4 = slope(time + step, &moved(&y, step, &k3));
        for i in 0..y.len() {
            y[i] += step / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    y
}

/// A run of 0.5 ms, more than a ball passage, by steps of 0.25 µs from the equilibrium of a scene. It agrees with the built-in
/// integrator at 1e-10 to 1e-11 m in positions and 1e-7 m/s in velocities, which is 1e-5 of relevant deviations.
#[test]
fn a_plain_runge_kutta_loop_takes_the_same_path() {
    let json = r#"{ "bearing": "article-integrated",
                    "operation": { "speed_rpm": 50000, "radial_load_y_n": 200 },
                    "spindle": { "balance_grade": 6.3 } }"#;
    let scene = scene_from_json(json).unwrap();
    let outputs = Outputs::vibration();
    let model = Model::new(&scene, &ActiveTerms::of(&scene, &outputs, None).unwrap());
    let start = start_state(&model).unwrap();
    let expected = advance(&model, &start, (0.0, 5e-4), 1e-10, |_| {});
    let found = runge_kutta_4(&model, &start, 2000, 2.5e-7);
    let layout = model.mechanism().layout;
    let mut worst: f64 = 0.0;
    for (entry, size) in layout.sizes().into_iter().enumerate() {
        let off = (found[entry] - expected[entry]).abs() / size;
        worst = worst.max(off);
        assert!(off < 1e-5, "{}: {off:e}", layout.name(entry));
    }
}
