//! Balls that no cage keeps apart: they touch with equal and opposite forces, and full-complement bearings run.

use raceway::numerics::ode::OdeSystem;
use raceway::numerics::ode::structure::Jacobian;
use raceway::physics::frames::{Azimuth, Vector, add, cross, dot, length, scale, subtract};
use raceway::physics::neighbour::NeighbourLoad;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::RunSettings;
use raceway::simulation::model::failure::SimulationError;
use raceway::simulation::model::{Model, Watch};
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::mirror_symmetry::{difference, mirrored, mirrored_scene};
use crate::scenes::{advance, article, azimuth, changed, disturbed, model_on, nothing_asked, rates, scene};

const TIME: f64 = 1.7e-4;

/// The article's bearing without cage and with as many balls as fit: 14, with gaps of 2.893 − 2.778 mm = 115 µm between them.
fn crowded(change: Value) -> Value {
    changed(
        changed(
            article(),
            json!({ "bearing": { "ball_count": 14 }, "terms": { "cage": "off", "drag": "off", "churning": "off" } }),
        ),
        change,
    )
}

/// A disturbed state in which four pairs of balls touch, one of them across the end of the numbering.
fn touching(model: &Model, seed: u64) -> Vec<f64> {
    let layout = model.mechanism().layout;
    let m = model.mechanism();
    let mut state = disturbed(model, seed);
    for (ball, penetration) in [(1, 0.5e-6), (4, 1.5e-6), (8, 0.2e-6), (layout.balls - 1, 0.9e-6)] {
        let next = (ball + 1) % layout.balls;
        let other = layout.ball(&state, next);
        let mut moved = layout.ball(&state, ball);
        (moved.axial, moved.radial) = (other.axial, other.radial);
        let apart = 2.0 * ((m.ball_radius - 0.5 * penetration) / (m.pitch_radius + moved.radial)).asin();
        moved.arc = other.arc + m.pitch_radius * (std::f64::consts::TAU / layout.balls as f64 - apart);
        layout.set_ball(&mut state, ball, &moved);
    }
    state
}

#[derive(Default)]
struct Contacts(Vec<NeighbourLoad>);

impl Watch for Contacts {
    fn neighbour(&mut self, ball: usize, load: &NeighbourLoad) {
        assert_eq!(ball, self.0.len());
        self.0.push(*load);
    }
}

fn contacts(model: &Model, state: &[f64]) -> Vec<NeighbourLoad> {
    let (mut rates, mut contacts) = (vec![0.0; state.len()], Contacts::default());
    model.derivative_watched(TIME, state, &mut rates, &mut contacts);
    contacts.0
}

/// Place, velocity and angular velocity of a ball in the inertial frame.
fn motion(model: &Model, time: f64, state: &[f64], ball: usize) -> [Vector; 3] {
    let m = model.mechanism();
    let (speed, now) = (m.rotation.inner.at(time).1, m.layout.ball(state, ball));
    let radius = m.pitch_radius + now.radial;
    let along = radius * (m.orbit_ratio * speed + now.arc_velocity / m.pitch_radius);
    let turned = Azimuth::new(azimuth(model, time, state, ball));
    let spin = [now.spin[0] + m.spin_ratio * speed, now.spin[1], now.spin[2]];
    [[now.axial, radius, 0.0], [now.axial_velocity, now.radial_velocity, along], spin].map(|v| turned.to_inertial(v))
}

/// Momentum and angular momentum of all balls about the bearing centre.
fn momenta(model: &Model, time: f64, state: &[f64]) -> [Vector; 2] {
    let m = model.mechanism();
    (0..m.layout.balls).fold([[0.0; 3]; 2], |[momentum, angular], ball| {
        let [place, velocity, spin] = motion(model, time, state, ball);
        let p = scale(m.ball_mass, velocity);
        [add(momentum, p), add(angular, add(cross(place, p), scale(m.ball_inertia, spin)))]
    })
}

/// The rates of momentum and angular momentum of all balls with contacts between them, less those without, vanish. The difference
/// quotients follow the rates over 1 ps, which leaves 1e-6 of the loads.
#[test]
fn contacts_between_balls_keep_momentum_and_angular_momentum() {
    for (level, change) in [
        (ModelLevel::Full, json!({})),
        (ModelLevel::Planar, json!({})),
        (ModelLevel::Full, json!({ "bearing": { "cage": { "friction": 0.5 } }, "lubricant": { "kind": "oil" } })),
    ] {
        let with = model_on(&crowded(change.clone()), Some(level));
        let without = model_on(&crowded(change), Some(level)).without_neighbours();
        for seed in 1..=10 {
            let state = touching(&with, seed);
            let loads = contacts(&with, &state);
            assert!(loads.iter().filter(|load| load.penetration > 0.0).count() >= 4, "{loads:?}");
            let total: f64 = loads.iter().map(|load| length(load.force)).sum();
            assert!(total > 5.0, "{total} N");
            const STEP: f64 = 1e-12;
            let ahead = |model: &Model| {
                let rates = rates(model, TIME, &state);
                let moved: Vec<f64> = state.iter().zip(&rates).map(|(y, dy)| y + STEP * dy).collect();
                momenta(model, TIME + STEP, &moved)
            };
            let [[p, l], [p0, l0]] = [ahead(&with), ahead(&without)];
            let force = length(scale(1.0 / STEP, subtract(p, p0)));
            let moment = length(scale(1.0 / STEP, subtract(l, l0)));
            assert!(force < 1e-5 * total, "{level:?}, state {seed}: {force:e} of {total} N");
            assert!(moment < 1e-5 * 6.5e-3 * total, "{level:?}, state {seed}: {moment:e} N m");
        }
    }
}

/// Kinetic energy of spindle and balls, and elastic energy ⅖ K δ^2.5 of all contacts [J].
fn energy(model: &Model, time: f64, state: &[f64]) -> f64 {
    let m = model.mechanism();
    let spindle = m.layout.spindle(state);
    let (_, loads) = crate::scenes::watched(model, time, state);
    let mut sum = 0.5 * m.spindle_mass * dot(spindle.velocity, spindle.velocity) - dot(m.load, spindle.position);
    for ball in 0..m.layout.balls {
        let [place, velocity, spin] = motion(model, time, state, ball);
        let [next, ..] = motion(model, time, state, (ball + 1) % m.layout.balls);
        sum += 0.5 * m.ball_mass * dot(velocity, velocity) + 0.5 * m.ball_inertia * dot(spin, spin);
        let penetration = 2.0 * m.ball_radius - length(subtract(place, next));
        let of = |stiffness: f64, penetration: f64| 0.4 * stiffness * penetration.max(0.0).powf(2.5);
        sum += of(m.neighbours.unwrap().stiffness(), penetration);
        sum += of(m.raceway.inner.hertz().stiffness, loads.inner[ball].penetration);
        sum += of(m.raceway.outer.hertz().stiffness, loads.outer[ball].penetration);
    }
    sum
}

/// Over 1 ms in which 14 balls collide again and again, their energy of 0.1 J changes by less than 1e-8 of itself.
#[test]
fn collisions_keep_energy_without_dissipation() {
    let none = json!({
        "lubricant": { "kind": "grease", "traction": { "maximum": 0, "limit": 0 } },
        "damping": { "raceway": { "law": "none" }, "pocket": { "law": "none" } },
        "bearing": { "cage": { "friction": 0, "film": "none" } },
        "gravity_m_s2": 0, "terms": { "hydrodynamics": "off" }
    });
    for level in [ModelLevel::Full, ModelLevel::Planar] {
        let model = model_on(&crowded(none.clone()), Some(level));
        let start = touching(&model, 2);
        let before = energy(&model, 0.0, &start);
        let (mut most, mut hits, mut was) = (0.0_f64, 0, 0);
        advance(&model, &start, (0.0, 1e-3), 1e-12, |step| {
            most = most.max((energy(&model, step.time(), step.state()) / before - 1.0).abs());
            let touch = contacts(&model, step.state()).iter().filter(|load| load.penetration > 0.0).count();
            hits += touch.saturating_sub(was);
            was = touch;
        });
        println!("{level:?}: {before} J, {most:e}, {hits} contacts");
        assert!(hits >= 4 && most < 1e-8, "{level:?}: {most:e}, {hits} contacts");
    }
}

/// The block of each ball holds its own contacts with both neighbours.
#[test]
fn blocks_of_the_jacobian_hold_the_contacts() {
    for level in [ModelLevel::Full, ModelLevel::Planar] {
        let model = model_on(&crowded(json!({})), Some(level));
        let (state, sizes) = (touching(&model, 3), model.mechanism().layout.sizes());
        let structure = model.structure();
        let mut jacobian = Jacobian::new(&structure);
        model.jacobian(0.0, &state, &[], &[], &mut jacobian);
        let block = structure.block;
        for ball in 0..structure.blocks {
            let entries: Vec<f64> = jacobian.blocks.of(ball).collect();
            for column in 0..block {
                let by = 1e-5 * sizes[column];
                let rate = |sign: f64| {
                    let mut moved = state.clone();
                    moved[ball * block + column] += sign * by;
                    rates(&model, 0.0, &moved)[ball * block..][..block].to_vec()
                };
                let (ahead, behind) = (rate(1.0), rate(-1.0));
                for row in 0..block {
                    let expected = (ahead[row] - behind[row]) / (2.0 * by);
                    let off = (entries[row * block + column] - expected).abs() * sizes[column];
                    let worst = (0..block).map(|k| (entries[row * block + k] * sizes[k]).abs()).fold(0.0, f64::max);
                    assert!(off < 1e-3 * worst + 1e-9, "{level:?}, ball {ball}: {row}/{column}, {off:e} of {worst:e}");
                }
            }
        }
    }
}

/// The mirror image of touching balls has the mirror image of their rates.
#[test]
fn touching_balls_have_a_mirror_image() {
    for level in [ModelLevel::Full, ModelLevel::Planar] {
        let json = crowded(json!({ "operation": { "radial_load_z_n": -60 } }));
        let (one, other) = (model_on(&json, Some(level)), model_on(&mirrored_scene(json), Some(level)));
        for seed in 1..=10 {
            let state = touching(&one, seed);
            let expected = mirrored(&one, &rates(&one, TIME, &state));
            let off = difference(&one, &rates(&other, TIME, &mirrored(&one, &state)), &expected);
            assert!(off < 1e-12, "{level:?}, state {seed}: {off:e}");
        }
    }
}

const CONTROL: Control<'static> = Control::until(&|| false);

fn ran(json: &Value, settle: f64, duration: f64) -> Result<RunResult, SimulationError> {
    let mut outputs = nothing_asked();
    outputs.series =
        vec![Axis::Y, Axis::Z].into_iter().map(|axis| Channel::Spindle(axis, Motion::Displacement)).collect();
    simulate(&scene(json), &RunSettings::new(settle, duration, outputs), &CONTROL)
}

/// A full-complement 6206: 15 balls at 3000 r/min under 500 N. The spindle stays within its clearance and a few deflections.
#[test]
fn a_full_complement_bearing_stays_together() {
    let json = json!({
        "bearing": { "preset": "6206", "ball_count": 15 },
        "operation": { "speed_rpm": 3000, "radial_load_y_n": 500 },
        "terms": { "cage": "off" }
    });
    let result = ran(&json, 0.02, 0.05).unwrap();
    for series in &result.series {
        let most = series.values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        println!("{}: {most} µm", series.channel);
        assert!(most < 30.0, "{}: {most} µm", series.channel);
    }
    assert_eq!(result.summary.solver.level, ModelLevel::Planar);
}

/// Five balls of fifteen gather on one side, and the spindle leaves on the other. Raceways of 6206 touch at d + P_d/2 = 9.53 mm.
#[test]
fn a_spindle_that_nothing_holds_leaves_its_bearing() {
    let json = json!({
        "bearing": { "preset": "6206", "ball_count": 3 },
        "operation": { "speed_rpm": 600, "radial_load_y_n": 500 },
        "terms": { "cage": "off" }
    });
    match ran(&json, 0.5, 0.5) {
        Err(SimulationError::SpindleLeft { time, departure }) => {
            assert!((0.0..1.0).contains(&time), "{time}");
            assert!((departure.displacement / departure.limit - 1.0).abs() < 1e-6, "{departure:?}");
            assert!((departure.limit / 9.53e-3 - 1.0).abs() < 1e-3, "{departure:?}");
        }
        other => panic!("{:?}", other.map(|result| result.summary.solver.level)),
    }
}
