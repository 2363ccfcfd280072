//! Waves and defects of balls: the energy and the angular momentum that their lateral force keeps, lines, and surfaces that change nothing.

use raceway::physics::raceway::RelativeMotion;
use raceway::physics::surface::sphere::{BallPose, SphereProfile};
use raceway::physics::surface::waviness::Wave;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::model::Mechanism;
use serde_json::json;

use crate::scenes::{article, changed, needs, scene};

/// Largest changes of the energy of a ball over its elastic energy, and of its angular momentum about the ring's axis over that of a wave: a
/// ball without damping and friction rolls for 6 ms over the outer raceway, with a wave of its own of order 6 and 50 nm. `lateral`: share of
/// the lateral force that acts.
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

/// Energy and angular momentum are kept; without the lateral force both are off.
#[test]
fn the_lateral_force_keeps_energy_and_angular_momentum() {
    let (energy, momentum) = lost(1.0);
    let (without, momentum_without) = lost(0.0);
    println!("{energy:e} {momentum:e} {without} {momentum_without}");
    assert!(energy < 1e-8 && momentum < 1e-8, "{energy:e} {momentum:e}");
    assert!((0.02..0.1).contains(&without) && momentum_without > 0.5, "{without} {momentum_without}");
}
