//! Waves and defects of balls: the energy and the angular momentum that their lateral force keeps, lines, and surfaces that change nothing.

use raceway::numerics::ode::Method;
use raceway::physics::raceway::RelativeMotion;
use raceway::physics::surface::sphere::{BallPose, SphereProfile};
use raceway::physics::surface::waviness::Wave;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::Mechanism;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::surfaces::averaged_balls;
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::article_run::{Y, patient};
use crate::defects::{assert_near, line, motor, run};
use crate::scenes::{article, changed, disturbed, everything, model_on, needs, rates, scene, uneven_balls};

/// A ball without damping and friction rolls for 6 ms over the outer raceway, with a wave of its own of order 6 and 50 nm. Returns the largest
/// changes of its energy over its elastic energy, and of its angular momentum about the ring's axis over that of a wave. `lateral`: share
/// of the lateral force that acts.
fn lost(lateral: f64) -> (f64, f64) {
    const SPEED: f64 = 2058.0;
    const SPIN: f64 = -9600.0;
    const STEP: f64 = 2e-8;
    let frictionless = json!({ "lubricant": { "traction": { "maximum": 0, "limit": 0 } }, "damping": { "raceway": { "law": "none" } } });
    let scene = scene(&changed(article(), frictionless));
    let m = Mechanism::new(&scene, &needs(&scene, Some(ModelLevel::Planar)));
    let contact = m.raceway.outer.clone();
    let ball = SphereProfile::new(&[Wave { order: 6, amplitude: 50e-9, phase: 0.0 }], &[], true).unwrap();
    let (at_pitch, _) = contact.penetration::<true>(0.0, m.pitch_radius);
    let load = m.ball_mass * m.pitch_radius * SPEED * SPEED;
    let start = m.pitch_radius - at_pitch + (load / contact.hertz().stiffness).powf(2.0 / 3.0);
    // Radius, orbit speed, turn and spin less those of uniform motion, and their rates.
    let rate = |time: f64, [r, v, speed, turn, spin]: [f64; 5]| {
        let (radius, orbit) = (start + r, SPEED + speed);
        let motion = RelativeMotion {
            radius,
            velocity: [0.0, v, radius * orbit],
            spin: [SPIN + spin, 0.0, 0.0],
            orbit_speed: orbit,
            ..RelativeMotion::default()
        };
        let pose = BallPose { longitude: (SPEED - SPIN) * time - turn, ..BallPose::default() };
        let load = contact.load_on_ball::<true>(&motion, &ball, &pose);
        let outwards = load.force[1] / m.ball_mass + radius * orbit * orbit;
        let along = (lateral * load.force[2] / m.ball_mass - 2.0 * v * orbit) / radius;
        let elastic = 0.4 * contact.hertz().stiffness * load.penetration.max(0.0).powf(2.5);
        ([v, outwards, along, spin - speed, load.moment[0] / m.ball_inertia], elastic)
    };
    let (inertia, mass) = (m.ball_inertia, m.ball_mass);
    let energy = |[r, v, speed, _, spin]: [f64; 5], elastic: f64| {
        let gained = r * (SPEED + speed) + start * speed;
        0.5 * mass * (v * v + gained * (2.0 * start * SPEED + gained))
            + 0.5 * inertia * spin * (2.0 * SPIN + spin)
            + elastic
    };
    let momentum = |[r, _, speed, _, spin]: [f64; 5]| {
        let radius = start + r;
        mass * (radius * radius * speed + r * (2.0 * start + r) * SPEED) + inertia * spin
    };
    let mut state = [0.0; 5];
    let at_start = rate(0.0, state).1;
    let before = energy(state, at_start);
    let (mut energy_lost, mut momentum_lost, mut turned) = (0.0_f64, 0.0_f64, 0.0_f64);
    for step in 0..300_000 {
        let time = STEP * f64::from(step);
        let moved = |by: f64, along: [f64; 5]| std::array::from_fn(|i| state[i] + by * along[i]);
        let (a, elastic) = rate(time, state);
        energy_lost = energy_lost.max((energy(state, elastic) - before).abs());
        momentum_lost = momentum_lost.max(momentum(state).abs());
        turned = turned.max((inertia * state[4]).abs());
        let (b, _) = rate(time + 0.5 * STEP, moved(0.5 * STEP, a));
        let (c, _) = rate(time + 0.5 * STEP, moved(0.5 * STEP, b));
        let (d, _) = rate(time + STEP, moved(STEP, c));
        state = std::array::from_fn(|i| state[i] + STEP / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
    }
    (energy_lost / at_start, momentum_lost / turned)
}

/// Energy and angular momentum are kept. Without the lateral force the energy is off by a tenth of the elastic energy, the angular momentum
/// by all that the ball's spin gains.
#[test]
fn the_lateral_force_keeps_energy_and_angular_momentum() {
    let (energy, momentum) = lost(1.0);
    let (without, momentum_without) = lost(0.0);
    assert!(energy < 1e-8 && momentum < 1e-8, "{energy:e} {momentum:e}");
    assert!((0.05..0.2).contains(&without) && momentum_without > 0.5, "{without} {momentum_without}");
}

/// The article's bearing without clearance, load and gravity at 1000 r/min, one ball with a wave of 10 nm.
fn one_ball(order: u32) -> Value {
    let ball = json!({ "ball": 3, "waviness": [{ "order": order, "amplitude_nm": 10, "phase_deg": 20 }] });
    changed(
        article(),
        json!({
            "bearing": { "radial_clearance_um": -4 },
            "operation": { "speed_rpm": 1000, "radial_load_y_n": 0 },
            "gravity_m_s2": 0,
            "surfaces": { "balls": [ball] }
        }),
    )
}

const DISPLACEMENTS: [Channel; 2] =
    [Channel::Spindle(Axis::Y, Motion::Displacement), Channel::Spindle(Axis::Z, Motion::Displacement)];

fn run_on(json: &Value, level: ModelLevel) -> RunResult {
    let in_steps = level == ModelLevel::Planar || level == ModelLevel::Full;
    let settings = RunSettings {
        method: if in_steps { Method::SemiImplicit } else { Method::Auto },
        rung: Some(level),
        relative_tolerance: 1e-5,
        tightened: (!in_steps).then_some(1e-6),
        model_tolerance_db: 0.05,
        fixed_step: in_steps.then_some(7.5e-6),
        settle: 0.3,
        duration: 2.0,
        outputs: Outputs { spectra: DISPLACEMENTS.to_vec(), ..Outputs::vibration() },
    };
    simulate(&scene(json), &settings, &patient()).unwrap()
}

/// Lines of y and z: frequency [Hz] and amplitude [nm].
fn lines(result: &RunResult) -> impl Iterator<Item = (Channel, f64, f64)> {
    result.summary.lines.iter().map(|(of, line)| (*of, line.frequency, 1e3 * line.amplitude))
}

/// A wave of even order on one of seven balls changes its diameter twice: 2 A/Z = 2.857 nm in y and z, at each of n·BSF ∓ FTF. One of odd
/// order moves the ball and not the spindle.
#[test]
fn a_wave_of_a_ball_moves_the_spindle_at_even_orders() {
    for level in [ModelLevel::Planar, ModelLevel::RadiallyCondensed, ModelLevel::SpindleOnly] {
        for order in [2, 4] {
            let json = one_ball(order);
            let result = run_on(&json, level);
            let terms = needs(&scene(&json), Some(ModelLevel::Planar));
            let balls = averaged_balls(&Mechanism::new(&scene(&json), &terms), &scene(&json));
            let share = 0.5 * (balls[2].inner.waves.kept[0].share + balls[2].outer.waves.kept[0].share);
            let f = &result.summary.frequencies;
            for channel in DISPLACEMENTS {
                for side in [-1.0, 1.0] {
                    let expected = f64::from(order) * f.ball_spin + side * f.cage;
                    let is_there = |(of, frequency, _): &(Channel, f64, f64)| {
                        *of == channel && (frequency - expected).abs() < 1e-3 * expected + 0.1
                    };
                    let found = lines(&result).find(is_there).map_or(0.0, |(.., amplitude)| amplitude / share);
                    assert!((found / 2.857 - 1.0).abs() < 0.01, "{level:?}, order {order}, {expected} Hz: {found} nm");
                }
            }
        }
        let most = lines(&run_on(&one_ball(3), level)).map(|(.., amplitude)| amplitude).fold(0.0, f64::max);
        assert!(most < 0.03, "{level:?}: {most} nm");
    }
}

/// A ball that falls into a defect of 0.533 mm twice in its turn, as long as the load carries it round: impacts far apart, at 2·BSF with
/// sidebands of the cage. The envelope is strongest at FTF. Ratios of a spindle on massless balls, by a separate program.
#[test]
fn a_defect_of_a_ball_sounds_twice_in_a_turn() {
    let ball = json!({ "ball": 1, "defects": [{ "diameter_mm": 0.533, "depth_um": 10 }] });
    let result = run(&motor(json!({ "balls": [ball] })), 1.0);
    let (_, metrics) = result.summary.channels.iter().find(|(channel, _)| *channel == Y).unwrap();
    let f = result.summary.frequencies;
    let envelope = &result.spectra.iter().find(|spectra| spectra.channel == Y).unwrap().envelope;
    let strike = 2.0 * f.ball_spin;
    let [cage, below, passage, above] = [f.cage, strike - f.cage, strike, strike + f.cage].map(|at| line(envelope, at));
    assert_near("kurtosis", metrics.kurtosis.unwrap(), 23.0, 0.3);
    assert_near("2·BSF − FTF over 2·BSF", below / passage, 1.0, 0.3);
    assert_near("2·BSF + FTF over 2·BSF", above / passage, 0.85, 0.3);
    assert!(cage > below.max(passage).max(above), "{cage} {below} {passage} {above}");
    let labels: Vec<&str> =
        result.summary.lines.iter().filter(|(of, _)| *of == Y).take(10).map(|(_, line)| &*line.label).collect();
    assert!(labels.iter().all(|label| label.contains("BSF")), "{labels:?}");
}

/// Waves and defects without height have no effect on the rates, to the last bit.
#[test]
fn uneven_balls_without_height_are_ideal() {
    let flat = json!({ "surfaces": { "balls": [
        { "ball": 2, "waviness": [{ "order": 4, "amplitude_nm": 0 }], "defects": [{ "diameter_mm": 0.3, "depth_um": 0 }] }
    ] } });
    for (json, level) in [(everything(), ModelLevel::Full), (article(), ModelLevel::Planar)] {
        let (ideal, flat) = (model_on(&json, Some(level)), model_on(&changed(json.clone(), flat.clone()), Some(level)));
        let state = disturbed(&ideal, 3);
        assert_eq!(rates(&ideal, 1e-4, &state), rates(&flat, 1e-4, &state));
    }
}

/// A little wave on one ball gives every ball an attitude and the motion of the others the same rates, to the last bit.
#[test]
fn an_attitude_changes_nothing_but_its_ball() {
    let wave = json!({ "surfaces": { "balls": [{ "ball": 2, "waviness": [{ "order": 4, "amplitude_nm": 10 }] }] } });
    for (json, level) in [(everything(), ModelLevel::Full), (article(), ModelLevel::Planar)] {
        let (ideal, uneven) =
            (model_on(&json, Some(level)), model_on(&changed(json.clone(), wave.clone()), Some(level)));
        let (state, with) = (disturbed(&ideal, 3), disturbed(&uneven, 3));
        let (from, to) = (ideal.mechanism().layout, uneven.mechanism().layout);
        let mut lifted = vec![0.0; with.len()];
        for ball in 0..from.balls {
            to.set_ball(&mut lifted, ball, &from.ball(&state, ball));
        }
        to.set_cage(&mut lifted, &from.cage(&state));
        to.set_spindle(&mut lifted, &from.spindle(&state));
        let (a, b) = (rates(&ideal, 1e-4, &state), rates(&uneven, 1e-4, &lifted));
        for ball in 0..from.balls {
            assert_eq!(from.ball(&a, ball) == to.ball(&b, ball), ball != 1, "{level:?}, ball {ball}");
        }
        assert_eq!(from.cage(&a), to.cage(&b));
    }
}

/// Every method with error control gives the same attitude and motion, and steps of a fixed length come near.
#[test]
fn methods_agree_on_uneven_balls() {
    const END: f64 = 2e-4;
    for (json, level) in [
        (changed(everything(), uneven_balls(5.0)), ModelLevel::Full),
        (changed(article(), uneven_balls(0.0)), ModelLevel::Planar),
    ] {
        let model = model_on(&json, Some(level));
        let layout = model.mechanism().layout;
        let start = start_state(&model).unwrap();
        let run = |method: Method, step: Option<f64>| {
            let mut integrator = method.start(&model, 0.0, &start, layout.tolerances(1e-9), step);
            while integrator.time() < END {
                let end = (integrator.time() + 2e-7).min(END);
                integrator.step(if step.is_some() { END } else { end }).unwrap();
            }
            integrator.state().to_vec()
        };
        let reference = run(Method::DormandPrince, None);
        for (method, step, share) in
            [(Method::Radau, None, 0.02), (Method::Gear, None, 0.02), (Method::SemiImplicit, Some(1e-7), 0.5)]
        {
            let found = run(method, step);
            for ball in 0..layout.balls {
                let (a, b) = (layout.attitude(&reference, ball).0, layout.attitude(&found, ball).0);
                let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < share * 1e-3, "{level:?} {method:?}, ball {ball}: {a:?} {b:?}");
            }
        }
    }
}
