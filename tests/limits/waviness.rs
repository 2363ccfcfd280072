//! Waves of the raceways: the energy that the lean force keeps, the displacements that rigid shifts, compliance and load demand, and
//! surfaces that change nothing.

use std::f64::consts::{FRAC_PI_2, TAU};

use raceway::numerics::ode::Method;
use raceway::physics::raceway::RelativeMotion;
use raceway::physics::surface::SurfaceProfile;
use raceway::physics::surface::waviness::Wave;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::Mechanism;
use raceway::simulation::model::equilibrium::equilibrium;
use raceway::simulation::model::surfaces::waves;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::article_run::patient;
use crate::scenes::{article, changed, disturbed, model_on, needs, rates, scene};

fn wave(order: u32, amplitude: f64, phase: f64) -> Wave {
    Wave { order, amplitude, phase }
}

/// Share of the tangential force that acts in the balance of energy: all, none, or its opposite.
fn energy_lost(lean: f64) -> f64 {
    const SPEED: f64 = 2058.0;
    const STEP: f64 = 2e-8;
    let frictionless = json!({ "lubricant": { "traction": { "maximum": 0, "limit": 0 } }, "damping": { "raceway": { "law": "none" } } });
    let scene = scene(&changed(article(), frictionless));
    let m = Mechanism::new(&scene, &needs(&scene, Some(ModelLevel::Planar)));
    let contact = m.raceway.outer.clone().with_surface(SurfaceProfile::of_waves(&[wave(40, 20e-9, 0.0)]));
    let (at_pitch, _) = contact.penetration::<true>(0.0, m.pitch_radius);
    // Radial equilibrium on a circle.
    let load = m.ball_mass * m.pitch_radius * SPEED * SPEED;
    let start = m.pitch_radius - at_pitch + (load / contact.hertz().stiffness).powf(2.0 / 3.0);
    // Radius and azimuth less those of uniform motion, and their rates.
    let rate = |time: f64, [r, v, turn, speed]: [f64; 4]| {
        let (radius, orbit) = (start + r, SPEED + speed);
        let motion = RelativeMotion {
            radius,
            velocity: [0.0, v, radius * orbit],
            orbit_speed: orbit,
            azimuth: SPEED * time + turn,
            ..RelativeMotion::default()
        };
        let load = contact.load::<true>(&motion);
        let outwards = load.force[1] / m.ball_mass + radius * orbit * orbit;
        let along = (lean * load.force[2] / m.ball_mass - 2.0 * v * orbit) / radius;
        ([v, outwards, speed, along], 0.4 * contact.hertz().stiffness * load.penetration.max(0.0).powf(2.5))
    };
    let energy = |state: [f64; 4], elastic: f64| {
        let [r, v, _, speed] = state;
        let gained = r * (SPEED + speed) + start * speed;
        0.5 * m.ball_mass * (v * v + gained * (2.0 * start * SPEED + gained)) + elastic
    };
    let mut state = [0.0; 4];
    let at_start = rate(0.0, state).1;
    let before = energy(state, at_start);
    let mut most = 0.0_f64;
    for step in 0..300_000 {
        let time = STEP * f64::from(step);
        let moved = |by: f64, along: [f64; 4]| std::array::from_fn(|i| state[i] + by * along[i]);
        let (a, elastic) = rate(time, state);
        most = most.max((energy(state, elastic) - before).abs());
        let (b, _) = rate(time + 0.5 * STEP, moved(0.5 * STEP, a));
        let (c, _) = rate(time + 0.5 * STEP, moved(0.5 * STEP, b));
        let (d, _) = rate(time + STEP, moved(STEP, c));
        state = std::array::from_fn(|i| state[i] + STEP / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
    }
    most / at_start
}

/// A ball without damping and friction rolls for 6 ms over an outer wave of order 40 and 20 nm, at the orbit speed of the article's
/// case. Its energy is kept to 1e-8 of the elastic energy; without the lean force it is off by some 30 %, with its opposite by twice that.
#[test]
fn the_lean_force_keeps_the_energy_of_a_ball() {
    let [with, without, opposite] = [1.0, 0.0, -1.0].map(energy_lost);
    assert!(with < 1e-8, "{with:e}");
    assert!((0.2..0.4).contains(&without) && (0.4..0.8).contains(&opposite), "{without} {opposite}");
}

/// The article's bearing at rest on massless balls, without gravity.
fn at_rest(clearance_um: f64, load_n: f64) -> Mechanism {
    let change = json!({
        "bearing": { "radial_clearance_um": clearance_um },
        "operation": { "speed_rpm": 0, "radial_load_y_n": load_n },
        "gravity_m_s2": 0
    });
    let scene = scene(&changed(article(), change));
    Mechanism::new(&scene, &needs(&scene, Some(ModelLevel::Planar)))
}

/// Waves of one ring, as the balls feel them.
#[derive(Clone, Copy)]
enum Ring {
    Inner,
    Outer,
}

/// Amplitudes [nm] of the displacements in y and z at the line |q·BPFO − n f_r| of an inner wave or at q·BPFO of an outer one, from
/// equilibria over a passage of the balls. An ideal ring has the lines of varying compliance.
fn line(mechanism: &Mechanism, waves: Option<(Ring, u32)>, q: i32) -> [f64; 2] {
    const PLACES: usize = 64;
    let balls = mechanism.layout.balls;
    let mut sums = [[0.0; 2]; 2];
    let phases = if matches!(waves, Some((Ring::Inner, _))) { 4 } else { 1 };
    for place in 0..PLACES {
        let turned = TAU * place as f64 / (PLACES * balls) as f64;
        for phase in 0..phases {
            let shaft = FRAC_PI_2 * f64::from(phase);
            let mut m = mechanism.clone();
            // In the frame of the balls load and rings turn backwards.
            let [_, y, z] = m.load;
            let (sine, cosine) = turned.sin_cos();
            m.load = [0.0, y * cosine + z * sine, z * cosine - y * sine];
            let raised = |order: u32, phase: f64| SurfaceProfile::of_waves(&[wave(order, 10e-9, phase)]);
            match waves {
                Some((Ring::Inner, n)) => {
                    m.raceway.inner = m.raceway.inner.with_surface(raised(n, f64::from(n) * turned - shaft));
                }
                Some((Ring::Outer, n)) => {
                    m.raceway.outer = m.raceway.outer.with_surface(raised(n, f64::from(n) * turned));
                }
                None => {}
            }
            let [_, y, z] = equilibrium(&m, 0.0).unwrap().spindle;
            let found = [y * cosine - z * sine, y * sine + z * cosine];
            let (s, c) = (f64::from(q) * balls as f64 * turned - shaft).sin_cos();
            for (sum, found) in sums.iter_mut().zip(found) {
                *sum = [sum[0] + found * c, sum[1] + found * s];
            }
        }
    }
    let samples = (PLACES * phases as usize) as f64;
    sums.map(|[c, s]| 1e9 * 2.0 / samples * c.hypot(s))
}

fn assert_near(name: &str, found: [f64; 2], expected: [f64; 2], share: f64) {
    let is_near = |(found, expected): (f64, f64)| (found - expected).abs() <= share * expected + 1e-3;
    assert!(found.into_iter().zip(expected).all(is_near), "{name}: {found:?} nm for {expected:?} nm");
}

/// All balls carry alike: only n = qZ ± 1 move the spindle, as a rigid shift would. Waves of 10 nm as the balls feel them.
#[test]
fn a_preloaded_bearing_moves_with_the_waves_beside_multiples_of_its_balls() {
    let preloaded = at_rest(-4.0, 0.0);
    for ring in [Ring::Inner, Ring::Outer] {
        for (order, q) in [(6, 1), (8, 1), (13, 2), (15, 2)] {
            let found = line(&preloaded, Some((ring, order)), q);
            assert_near(&format!("order {order}"), found, [10.002; 2], 0.01);
        }
        for order in [5, 7, 9, 14] {
            for q in 0..=2 {
                let found = line(&preloaded, Some((ring, order)), q);
                assert!(found.iter().all(|amplitude| *amplitude < 1e-3), "order {order}, q {q}: {found:?}");
            }
        }
    }
    // The lean acts on the spindle in full, where balls do not roll: + 2 D n/3 r below qZ, − above it.
    let [below, above] = [6, 8].map(|order| line(&preloaded, Some((Ring::Inner, order)), 1)[0]);
    assert!((below - 10.014).abs() < 0.002 && (above - 9.986).abs() < 0.002, "{below} {above}");
}

/// 200 N and a clearance of 5 µm: varying compliance, waves that are rigid shifts all the same, ovality and n = Z.
#[test]
fn a_loaded_bearing_moves_with_every_wave() {
    let loaded = at_rest(5.0, 200.0);
    assert_near("BPFO", line(&loaded, None, 1), [16.91, 318.26], 0.01);
    assert_near("2·BPFO", line(&loaded, None, 2), [2.83, 80.77], 0.01);
    for (name, order, q, expected) in [
        ("inner 6 at BPFI − f_r", 6, 1, [10.008, 10.005]),
        ("inner 8 at BPFI + f_r", 8, 1, [10.008, 10.005]),
        ("ovality at 2·f_r", 2, 0, [5.726, 12.330]),
        ("inner 5 at BPFI − 2·f_r", 5, 1, [5.726, 12.330]),
        ("inner 7 at BPFI", 7, 1, [11.847, 0.0]),
    ] {
        assert_near(name, line(&loaded, Some((Ring::Inner, order)), q), expected, 0.01);
    }
}

/// Amplitudes [nm] at a frequency over that of the cage and the shaft, from a run of the planar model at 1000 r/min.
fn simulated(surfaces: Value, multiples: (f64, f64)) -> [f64; 2] {
    let change = json!({
        "bearing": { "radial_clearance_um": -4 },
        "operation": { "speed_rpm": 1000, "radial_load_y_n": 0 },
        "gravity_m_s2": 0,
        "surfaces": surfaces
    });
    let scene = scene(&changed(article(), change));
    let channels = [Axis::Y, Axis::Z].map(|axis| Channel::Spindle(axis, Motion::Displacement));
    let settings = RunSettings {
        method: Method::Auto,
        rung: Some(ModelLevel::Planar),
        relative_tolerance: 1e-5,
        tightened: None,
        model_tolerance_db: 0.05,
        fixed_step: Some(7.5e-6),
        settle: 0.3,
        duration: 1.0,
        outputs: Outputs {
            vibration: true,
            contacts: false,
            cage: true,
            spectra: channels.to_vec(),
            series: Vec::new(),
            ..Outputs::vibration()
        },
    };
    let settings = RunSettings { method: Method::SemiImplicit, ..settings };
    let result = simulate(&scene, &settings, &patient()).unwrap();
    let f = &result.summary.frequencies;
    let frequency = (multiples.0 * f.ball_pass_outer + multiples.1 * f.shaft).abs();
    let terms = needs(&scene, Some(ModelLevel::Planar));
    let waves = waves(&Mechanism::new(&scene, &terms), &scene).unwrap();
    let kept = waves.inner.waves.kept.iter().chain(&waves.outer.waves.kept).next().unwrap();
    channels.map(|channel| {
        let line = result
            .summary
            .lines
            .iter()
            .filter(|(of, line)| *of == channel && (line.frequency / frequency - 1.0).abs() < 5e-3)
            .map(|(_, line)| line.amplitude)
            .fold(0.0, f64::max);
        1e3 * line / kept.share
    })
}

/// The same in time: an outer and an inner wave of 10 nm on the planar model.
#[test]
fn a_run_moves_as_its_equilibria() {
    let waves = |order: u32| json!({ "waviness": [{ "order": order, "amplitude_nm": 10, "phase_deg": 20 }] });
    assert_near("outer 8", simulated(json!({ "outer": waves(8) }), (1.0, 0.0)), [10.002; 2], 0.01);
    assert_near("inner 6", simulated(json!({ "inner": waves(6) }), (1.0, -6.0)), [10.002; 2], 0.01);
}

/// Waves without height change no bit.
#[test]
fn waves_of_no_height_are_ideal() {
    let flat = json!({ "surfaces": { "inner": { "waviness": [{ "order": 8, "amplitude_nm": 0 }] } } });
    for rung in [ModelLevel::Full, ModelLevel::Planar] {
        let (ideal, flat) = (model_on(&article(), Some(rung)), model_on(&changed(article(), flat.clone()), Some(rung)));
        let state = disturbed(&ideal, 4);
        assert_eq!(rates(&ideal, 2.3e-4, &state), rates(&flat, 2.3e-4, &state));
    }
}

/// The first zero of the averaging of a 6205 under 243 N at its most loaded ball: orders 565 and 635.
#[test]
fn contacts_average_waves_of_their_width() {
    let json = json!({
        "bearing": "6205",
        "operation": { "speed_rpm": 1797, "radial_load_y_n": 500 },
        "surfaces": { "outer": { "random_waviness": { "amplitude_nm": 5 } } }
    });
    let scene = scene(&json);
    let waves = waves(&Mechanism::new(&scene, &needs(&scene, Some(ModelLevel::Planar))), &scene).unwrap();
    let zero =
        |of: &raceway::simulation::model::surfaces::RacewayWaves| of.contact.first_zero() * (of.load / 243.0).cbrt();
    assert!((zero(&waves.inner) / 565.0 - 1.0).abs() < 0.01, "{}", zero(&waves.inner));
    assert!((zero(&waves.outer) / 635.0 - 1.0).abs() < 0.01, "{}", zero(&waves.outer));
}
