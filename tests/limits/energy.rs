//! Energy is conserved without damping, traction, friction, drag and churning. The remaining change is the error of the
//! integrator and falls with its tolerance.

use raceway::physics::frames::{Azimuth, dot};
use raceway::physics::pocket::Pocket;
use raceway::simulation::model::Model;
use serde_json::{Value, json};

use crate::scenes::{
    advance, article, axial_waves, azimuth, changed, defects, disturbed, model, uneven_balls, watched, waves,
};

/// The article's case without dissipation.
fn frictionless(changes: Value) -> Value {
    let none = json!({
        "lubricant": { "kind": "grease", "traction": { "maximum": 0, "limit": 0 } },
        "damping": { "raceway": { "law": "none" }, "pocket": { "law": "none" } },
        "bearing": {
            "cage": { "friction": 0, "film": { "stiffness_n_per_m": FILM, "damping_n_s_per_m": 0 } }
        },
        "terms": { "drag": "off", "churning": "off", "hydrodynamics": "off" }
    });
    changed(changed(article(), none), changes)
}

/// Waves of the ring that stands: a turning one would do work.
fn outer_waves() -> Value {
    json!({ "surfaces": { "outer": waves()["surfaces"]["outer"] } })
}

fn at_rest() -> Value {
    json!({ "operation": { "speed_rpm": 0 } })
}

/// Stiffness of the pocket film [N/m].
const FILM: f64 = 3.8e4;

/// Energy of all bodies [J]: kinetic energy, elastic contacts ⅖ K δ^2.5, pocket films, loads and weights.
fn energy(model: &Model, time: f64, state: &[f64]) -> f64 {
    let m = model.mechanism();
    let layout = m.layout;
    let (_, loads) = watched(model, time, state);
    let speed = m.rotation.inner.at(time).1;
    let spindle = layout.spindle(state);
    let mut sum = 0.5 * m.spindle_mass * dot(spindle.velocity, spindle.velocity) - dot(m.load, spindle.position);
    sum -= m.spindle_mass * m.gravity * spindle.position[1];
    if let Some(inertia) = m.spindle_inertia {
        sum += 0.5 * inertia.transverse * spindle.tilt_rate.iter().map(|rate| rate * rate).sum::<f64>();
    }
    for index in 0..layout.balls {
        let ball = layout.ball(state, index);
        let radius = m.pitch_radius + ball.radial;
        let along = radius * (m.orbit_ratio * speed + ball.arc_velocity / m.pitch_radius);
        let velocity = [ball.axial_velocity, ball.radial_velocity, along];
        let spin = [ball.spin[0] + m.spin_ratio * speed, ball.spin[1], ball.spin[2]];
        sum += 0.5 * m.ball_mass * dot(velocity, velocity) + 0.5 * m.ball_inertia * dot(spin, spin);
        sum -= m.ball_mass * m.gravity * radius * Azimuth::new(azimuth(model, time, state, index)).cosine;
        for (contact, load) in [(&m.raceway.inner, &loads.inner[index]), (&m.raceway.outer, &loads.outer[index])] {
            sum += 0.4 * contact.hertz().stiffness * load.penetration.max(0.0).powf(2.5);
        }
    }
    if layout.cage {
        let cage = layout.cage(state);
        let spin = m.orbit_ratio * speed + cage.arc_velocity / m.pitch_radius;
        sum += 0.5 * m.cage.mass * dot(cage.velocity, cage.velocity);
        sum += 0.5 * m.cage.axial_inertia * spin * spin;
        sum += 0.5 * m.cage.transverse_inertia * (cage.tilt_rate[0].powi(2) + cage.tilt_rate[1].powi(2));
        sum -= m.cage.mass * m.gravity * cage.centre[1];
        sum += loads.pocket.iter().map(|load| pocket_energy(model, load.normal)).sum::<f64>();
    }
    sum
}

/// Elastic energy of a pocket from its normal load: a linear film up to the clearance, then the solid contact in addition to
/// the largest force of the film.
fn pocket_energy(model: &Model, normal: f64) -> f64 {
    let pocket = &model.mechanism().pocket;
    let film = pocket.film_stiffness();
    let clearance = 0.5 * model.mechanism().cage.pocket_clearance;
    let edge = film * clearance;
    if normal <= edge {
        return if film > 0.0 { 0.5 * normal * normal / film } else { 0.0 };
    }
    let penetration = penetration_at(pocket, normal - edge);
    0.5 * edge * clearance + edge * penetration + solid_energy(pocket, penetration)
}

/// Penetration at which the solid contact carries a load, by bisection in the logarithm.
fn penetration_at(pocket: &Pocket, load: f64) -> f64 {
    let (mut low, mut high) = (1e-15_f64, 1e-2_f64);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if pocket.solid_load(middle) < load { low = middle } else { high = middle }
    }
    low
}

/// ∫ Q dδ from first contact, by Simpson's rule in √δ, because the integrand is smooth in √δ.
fn solid_energy(pocket: &Pocket, penetration: f64) -> f64 {
    const PARTS: usize = 64;
    let step = penetration.sqrt() / PARTS as f64;
    let integrand = |k: usize| {
        let root = k as f64 * step;
        2.0 * root * pocket.solid_load(root * root)
    };
    let weight = |k: usize| match k {
        0 | PARTS => 1.0,
        k if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    (0..=PARTS).map(|k| weight(k) * integrand(k)).sum::<f64>() * step / 3.0
}

/// Largest change of the energy over `duration` [J].
fn drift(model: &Model, start: &[f64], duration: f64, tolerance: f64) -> f64 {
    let before = energy(model, 0.0, start);
    let mut most = 0.0_f64;
    advance(model, start, (0.0, duration), tolerance, |step| {
        most = most.max((energy(model, step.time(), step.state()) - before).abs());
    });
    most
}

/// The energy is 0.09 J, of which about 1e-3 J is elastic. At a tolerance of 1e-10 it changes by less than 1e-8 J. The change
/// falls with the tolerance, at least tenfold for a hundredth of it.
///
/// The run of 1 ms holds two ball passages and about 150 oscillations of the balls between their raceways. Balls leave their
/// raceways and hit pockets and rims.
#[test]
fn energy_is_kept_without_dissipation() {
    for (name, json) in [
        ("grease film", frictionless(json!({}))),
        ("no gravity, no film", frictionless(json!({ "gravity_m_s2": 0, "bearing": { "cage": { "film": "none" } } }))),
        ("free along X", frictionless(json!({ "operation": { "axial_load_n": 15 } }))),
        ("misaligned", frictionless(json!({ "operation": { "misalignment_mrad": { "y": 0.5, "z": 0.5 } } }))),
        ("free to tilt", frictionless(json!({ "spindle": { "tilt": "free" } }))),
        (
            "free along X and to tilt",
            frictionless(json!({ "operation": { "axial_load_n": 15 }, "spindle": { "tilt": "free" } })),
        ),
        ("outer waves", frictionless(outer_waves())),
        ("waves at rest", frictionless(changed(waves(), at_rest()))),
        (
            "waves at rest, misaligned",
            frictionless(changed(
                changed(waves(), at_rest()),
                json!({ "operation": { "misalignment_mrad": { "y": 5 } } }),
            )),
        ),
        ("outer defects", frictionless(json!({ "surfaces": { "outer": defects(0.1)["surfaces"]["outer"] } }))),
        ("defects at rest", frictionless(changed(defects(0.1), at_rest()))),
        (
            "axial waves at rest, free along X",
            frictionless(changed(changed(axial_waves(), at_rest()), json!({ "operation": { "axial_load_n": 15 } }))),
        ),
        ("uneven balls at rest", frictionless(changed(uneven_balls(5.0), at_rest()))),
        (
            "uneven balls at rest, free along X",
            frictionless(changed(
                changed(uneven_balls(5.0), at_rest()),
                json!({ "operation": { "axial_load_n": 15 } }),
            )),
        ),
        ("strong gravity", frictionless(json!({ "gravity_m_s2": 1000 }))),
    ] {
        let model = model(&json);
        let start = disturbed(&model, 2);
        let [coarse, fine] = [1e-8, 1e-10].map(|tolerance| drift(&model, &start, 1e-3, tolerance));
        assert!(fine < 1e-8 && fine < 0.1 * coarse, "{name}: {coarse:e} J, then {fine:e} J");
    }
}

/// With damping of the raceways the energy falls, so that the test above detects dissipation.
#[test]
fn damping_takes_energy() {
    let damped = json!({ "damping": { "raceway": { "law": "restitution", "restitution": 0.9, "at_speed_m_s": 0.1 } } });
    let model = model(&frictionless(damped));
    let start = disturbed(&model, 2);
    let before = energy(&model, 0.0, &start);
    let end = advance(&model, &start, (0.0, 1e-3), 1e-6, |_| {});
    let lost = before - energy(&model, 1e-3, &end);
    assert!(lost > 1e-6, "{lost:e} J");
}

/// Nothing drives a disturbed bearing at rest. With traction, rolling friction, pocket friction, drag and churning its energy
/// falls at every instant, in any motion of its bodies. The rate is a central difference along the rates of the state.
#[test]
fn a_standing_bearing_loses_energy_at_every_instant() {
    const STEP: f64 = 1e-9;
    let lossy = json!({
        "operation": { "speed_rpm": 0, "axial_load_n": 15 },
        "lubricant": { "kind": "oil", "traction": { "law": "coulomb", "coefficient": 0.2, "regularisation_m_s": 0.01 } },
        "damping": { "raceway": { "law": "none" }, "pocket": { "law": "none" } },
        "bearing": { "cage": { "friction": 0.5, "film": { "stiffness_n_per_m": FILM, "damping_n_s_per_m": 0 } } }
    });
    let raceways = json!({ "terms": { "pocket_friction": "off", "drag": "off", "churning": "off" } });
    let pockets = json!({
        "lubricant": { "traction": { "coefficient": 0 } }, "terms": { "hydrodynamics": "off", "drag": "off", "churning": "off" }
    });
    let tilting = json!({ "spindle": { "tilt": "free" } });
    for (name, change) in [("all", json!({})), ("tilting", tilting), ("raceways", raceways), ("pockets", pockets)] {
        let model = model(&changed(changed(article(), lossy.clone()), change));
        for seed in 1..=200 {
            let state = disturbed(&model, seed);
            let (rates, _) = watched(&model, 0.0, &state);
            let moved = |by: f64| -> Vec<f64> { state.iter().zip(&rates).map(|(y, dy)| y + by * dy).collect() };
            let rate = (energy(&model, STEP, &moved(STEP)) - energy(&model, -STEP, &moved(-STEP))) / (2.0 * STEP);
            assert!(rate < 1e-7, "{name}, state {seed}: {rate:e} W");
        }
    }
}
