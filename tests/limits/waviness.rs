//! Waves of the raceways: the energy that the lean force keeps, the displacements that rigid shifts, compliance and load demand, and
//! surfaces that change nothing.

use std::f64::consts::{FRAC_PI_2, TAU};

use raceway::numerics::ode::Method;
use raceway::physics::raceway::RelativeMotion;
use raceway::physics::surface::SurfaceProfile;
use raceway::physics::surface::waviness::Wave;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::Mechanism;
use raceway::simulation::model::equilibrium::equilibrium;
use raceway::simulation::model::surfaces::{AveragedSurface, averaged_surfaces};
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::article_run::patient;
use crate::scenes::{article, changed, disturbed, model_on, needs, rates, scene};

fn wave(order: u32, amplitude: f64, phase: f64) -> Wave {
    Wave { order, amplitude, phase }
}

/// Change of the energy of a ball over its elastic energy, on a surface of the outer raceway. `lean`: share of the tangential force that acts,
/// all, none, or its opposite.
pub fn energy_lost(surface: SurfaceProfile, lean: f64) -> f64 {
    const SPEED: f64 = 2058.0;
    const STEP: f64 = 2e-8;
    let frictionless = json!({ "lubricant": { "traction": { "maximum": 0, "limit": 0 } }, "damping": { "raceway": { "law": "none" } } });
    let scene = scene(&changed(article(), frictionless));
    let m = Mechanism::new(&scene, &needs(&scene, Some(ModelLevel::Planar)));
    let contact = m.raceway.outer.clone().with_surface(surface);
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
    let [with, without, opposite] =
        [1.0, 0.0, -1.0].map(|lean| energy_lost(SurfaceProfile::of_waves(&[wave(40, 20e-9, 0.0)]), lean));
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

/// The article's bearing at 1000 r/min, without gravity, with a clearance [µm] and a load [N].
pub fn slow(clearance_um: f64, load_n: f64, change: Value) -> Value {
    let slow = json!({
        "bearing": { "radial_clearance_um": clearance_um },
        "operation": { "speed_rpm": 1000, "radial_load_y_n": load_n },
        "gravity_m_s2": 0
    });
    changed(changed(article(), slow), change)
}

/// One wave of 10 nm on a raceway.
fn one_wave(ring: &str, order: u32) -> Value {
    json!({ "surfaces": { ring: { "waviness": [{ "order": order, "amplitude_nm": 10, "phase_deg": 20 }] } } })
}

/// A run of a scene on a model level, by default steps on the reduced ones, with spectra of the displacements.
pub fn run_on(scene: &Scene, level: ModelLevel) -> RunResult {
    let channels = [Axis::Y, Axis::Z].map(|axis| Channel::Spindle(axis, Motion::Displacement));
    let is_planar = level == ModelLevel::Planar;
    let settings = RunSettings {
        method: if is_planar { Method::SemiImplicit } else { Method::Auto },
        rung: Some(level),
        relative_tolerance: 1e-5,
        tightened: (!is_planar).then_some(1e-6),
        model_tolerance_db: 0.05,
        fixed_step: is_planar.then_some(7.5e-6),
        settle: 0.3,
        duration: 1.0,
        outputs: Outputs { cage: is_planar, spectra: channels.to_vec(), ..Outputs::vibration() },
    };
    simulate(scene, &settings, &patient()).unwrap()
}

/// Amplitudes [nm] of the displacements in y and z at a frequency over those of BPFO and the shaft, over the share of the wave that the
/// contact leaves.
fn simulated(json: &Value, level: ModelLevel, (of_passage, of_shaft): (f64, f64)) -> [f64; 2] {
    let scene = scene(json);
    let result = run_on(&scene, level);
    let f = &result.summary.frequencies;
    let frequency = (of_passage * f.ball_pass_outer + of_shaft * f.shaft).abs();
    let terms = needs(&scene, Some(ModelLevel::Planar));
    let waves = averaged_surfaces(&Mechanism::new(&scene, &terms), &scene).unwrap();
    let kept = waves.inner.waves.kept.iter().chain(&waves.outer.waves.kept).next().unwrap();
    [Axis::Y, Axis::Z].map(|axis| {
        let channel = Channel::Spindle(axis, Motion::Displacement);
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

/// Model levels that carry waves in a run, with those of the outer raceway alone.
const LEVELS: [(ModelLevel, bool); 4] = [
    (ModelLevel::Planar, false),
    (ModelLevel::RadiallyCondensed, false),
    (ModelLevel::SpindleOnly, false),
    (ModelLevel::Periodic, true),
];

/// The same in time, on each model level: waves of 10 nm of orders beside Z.
#[test]
fn a_run_moves_as_its_equilibria() {
    for (level, outer_only) in LEVELS {
        let moves = |ring: &str, order: u32, multiples: (f64, f64)| {
            let found = simulated(&slow(-4.0, 0.0, one_wave(ring, order)), level, multiples);
            assert_near(&format!("{level:?}, {ring} {order}"), found, [10.002; 2], 0.01);
            found[0]
        };
        // The planar runs take longest.
        let orders: &[(u32, f64)] =
            if level == ModelLevel::Planar { &[(8, 1.0)] } else { &[(6, 1.0), (8, 1.0), (13, 2.0), (15, 2.0)] };
        for &(order, q) in orders {
            moves("outer", order, (q, 0.0));
        }
        if !outer_only {
            let found: Vec<f64> =
                orders.iter().map(|&(order, q)| moves("inner", order, (q, -f64::from(order)))).collect();
            // Rolling balls pass on half of the lean, + D n/3r below qZ and − above it.
            assert!(found.len() == 1 || (found[0] > found[1] && found[2] > found[3]), "{level:?}: {found:?}");
        }
    }
}

/// Where all balls carry alike, waves of other orders than qZ ± 1 do not move the spindle.
#[test]
fn waves_of_other_orders_do_not_move_a_preloaded_run() {
    for (level, outer_only) in LEVELS.into_iter().skip(1) {
        for order in [5, 7, 9, 14] {
            for ring in if outer_only { &["outer"][..] } else { &["inner", "outer"][..] } {
                let result = run_on(&scene(&slow(-4.0, 0.0, one_wave(ring, order))), level);
                let moved = |axis: Axis| {
                    let channel = Channel::Spindle(axis, Motion::Displacement);
                    let lines = result.summary.lines.iter().filter(|(of, _)| *of == channel);
                    lines.map(|(_, line)| 1e3 * line.amplitude).fold(0.0, f64::max)
                };
                let found = [moved(Axis::Y), moved(Axis::Z)];
                assert!(found.iter().all(|amplitude| *amplitude < 1e-3), "{level:?}, {ring} {order}: {found:?} nm");
            }
        }
    }
}

/// A spindle of 5 kg on a stiffness Z k/2 of 3.791e7 N/m: 1/(1 − (f/f₀)²) = 1.377 at five passages of the balls, with f₀ 438.2 Hz.
#[test]
fn a_heavy_spindle_magnifies_waves() {
    for (level, _) in LEVELS.into_iter().skip(1) {
        for order in [34, 36] {
            let heavy = changed(one_wave("outer", order), json!({ "spindle": { "mass_kg": 5 } }));
            let found = simulated(&slow(-4.0, 0.0, heavy), level, (5.0, 0.0));
            assert_near(&format!("{level:?}, order {order}"), found, [10.0 * 1.377; 2], 0.01);
        }
    }
}

/// 200 N and a clearance of 5 µm on the reduced levels: the amplitudes of the equilibria. On the condensed level balls move in their pockets,
/// and n times their angle changes the phase of a wave of order n; the planar model has the same 10.19 and 9.56 nm at order 6.
#[test]
fn a_loaded_run_moves_as_its_equilibria() {
    for (level, share) in [(ModelLevel::RadiallyCondensed, 0.05), (ModelLevel::SpindleOnly, 0.01)] {
        for (order, multiples, expected) in
            [(6, (1.0, -6.0), [10.008, 10.005]), (2, (0.0, 2.0), [5.726, 12.330]), (7, (1.0, -7.0), [11.847, 0.0])]
        {
            let found = simulated(&slow(5.0, 200.0, one_wave("inner", order)), level, multiples);
            assert_near(&format!("{level:?}, inner {order}"), found, expected, share);
        }
    }
}

/// Levels of a_y and a_z [dB] over some hundredths of a second.
fn levels(scene: &Scene, level: ModelLevel) -> [f64; 2] {
    let settings = RunSettings {
        method: Method::Auto,
        rung: Some(level),
        relative_tolerance: 1e-6,
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: 0.03,
        duration: 0.05,
        outputs: Outputs::vibration(),
    };
    let result = simulate(scene, &settings, &patient()).unwrap();
    [Axis::Y, Axis::Z].map(|axis| {
        let channel = Channel::Spindle(axis, Motion::Acceleration);
        20.0 * result.summary.channels.iter().find(|(of, _)| *of == channel).unwrap().1.rms.log10()
    })
}

/// Levels of spindles whose resonance many waves excite: the reduced levels against the planar one. On `spindle_only` balls keep their even
/// spacing, which inner waves feel as a jitter of their lines.
#[test]
fn reduced_levels_are_those_of_the_dynamics() {
    let random = |amplitude: f64, to: u32| json!({ "random_waviness": { "amplitude_nm": amplitude, "to_order": to } });
    let condensed = (ModelLevel::RadiallyCondensed, 0.01);
    for (bearing, speed, load, to, inner, tested) in [
        ("6205", 6000, 300, 200, 10.0, vec![condensed]),
        ("6205", 6000, 300, 200, 0.0, vec![condensed, (ModelLevel::SpindleOnly, 0.1)]),
        ("article-integrated", 30_000, 100, 60, 10.0, vec![condensed, (ModelLevel::SpindleOnly, 0.1)]),
    ] {
        let scene = scene(&json!({
            "bearing": bearing,
            "operation": { "speed_rpm": speed, "radial_load_y_n": load },
            "surfaces": { "inner": random(inner, to), "outer": random(20.0, to) }
        }));
        let reference = levels(&scene, ModelLevel::Planar);
        for (level, tolerance) in tested {
            let found = levels(&scene, level);
            let off = [0, 1].map(|axis| (found[axis] - reference[axis]).abs());
            assert!(off.iter().all(|off| *off < tolerance), "{bearing} {inner} {level:?}: {off:?} dB");
        }
    }
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
    let waves = averaged_surfaces(&Mechanism::new(&scene, &needs(&scene, Some(ModelLevel::Planar))), &scene).unwrap();
    let zero = |of: &AveragedSurface| of.contact.first_zero() * (of.load / 243.0).cbrt();
    assert!((zero(&waves.inner) / 565.0 - 1.0).abs() < 0.01, "{}", zero(&waves.inner));
    assert!((zero(&waves.outer) / 635.0 - 1.0).abs() < 0.01, "{}", zero(&waves.outer));
}
