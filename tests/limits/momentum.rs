//! Newton's third law: each force acts on two bodies in opposite directions. The states are far from equilibrium, with spin,
//! slip, hydrodynamic forces, pocket contacts and tilt of the cage, and at rising speed.

use raceway::physics::frames::{Azimuth, Tilt, Vector, add, cross, length, scale, subtract};
use raceway::physics::raceway::{RacewayLoad, RelativeMotion};
use raceway::physics::spindle::unbalance_force;
use raceway::simulation::input::channel::BallContact;
use raceway::simulation::model::{Model, Watch};
use serde_json::{Value, json};

use crate::scenes::{
    Loads, azimuth, changed, disturbed, everything, model, sizes, turning_outer_ring, uneven_balls, watched,
};

const TIME: f64 = 1.7e-4;
/// Rounding error of sums of forces: a few units in the last place for each of the 21 contacts. The terms r θ̇² and 2 ṙ θ̇ add
/// to it, because the rates contain them and they are subtracted here.
const ROUNDING: f64 = 1e-14;

/// Scenes with all forces: radial type, misaligned, angular contact with a rising speed, each traction law.
fn all_scenes() -> Vec<(&'static str, Value)> {
    let ramp = json!([{ "at_s": 0, "rpm": 30_000 }, { "at_s": 0.01, "rpm": 50_000 }]);
    let of = |change: Value| changed(everything(), change);
    vec![
        ("everything", everything()),
        ("misaligned", of(json!({ "operation": { "misalignment_mrad": { "y": 1.0, "z": -0.7 } } }))),
        (
            "angular contact, rising speed",
            of(json!({
                "bearing": { "type": "angular_contact", "contact_angle_deg": 15 },
                "operation": { "speed_rpm": ramp }
            })),
        ),
        ("Eyring", of(json!({ "lubricant": { "traction": { "law": "eyring" } } }))),
        ("Coulomb", of(json!({ "lubricant": { "traction": { "law": "coulomb" } } }))),
        ("uneven balls", of(uneven_balls(5.0))),
        ("turning outer ring", of(turning_outer_ring())),
        ("elastic bars", of(json!({ "bearing": { "cage": { "bar_stiffness_n_per_m": 1e5 } } }))),
    ]
}

/// Force on the cage, on the spindle, and of the outer raceway on all balls, in the inertial frame.
struct Forces {
    inner: Vec<Vector>,
    outer: Vec<Vector>,
    pocket: Vec<Vector>,
}

fn forces(model: &Model, state: &[f64], loads: &Loads) -> Forces {
    let layout = model.mechanism().layout;
    let tilt = layout.cage(state).tilt;
    let tilt = Tilt::new(tilt[0], tilt[1]);
    let turned = |ball: usize, v| Azimuth::new(azimuth(model, TIME, state, ball)).to_inertial(v);
    Forces {
        inner: loads.inner.iter().enumerate().map(|(ball, load)| turned(ball, load.force)).collect(),
        outer: loads.outer.iter().enumerate().map(|(ball, load)| turned(ball, load.force)).collect(),
        pocket: loads.pocket.iter().map(|load| tilt.to_inertial(load.force)).collect(),
    }
}

fn total(vectors: &[Vector]) -> Vector {
    vectors.iter().fold([0.0; 3], |sum, v| add(sum, *v))
}

/// Acceleration of a ball in the inertial frame from its rates of state.
fn ball_acceleration(model: &Model, state: &[f64], rates: &[f64], ball: usize) -> Vector {
    let m = model.mechanism();
    let ideal = m.rotations(TIME).orbit;
    let (now, rate) = (m.layout.ball(state, ball), m.layout.ball(rates, ball));
    let radius = m.pitch_radius + now.radial;
    let orbit = ideal.speed + now.arc_velocity / m.pitch_radius;
    let orbit_rate = ideal.acceleration + rate.arc_velocity / m.pitch_radius;
    let local = [
        rate.axial_velocity,
        rate.radial_velocity - radius * orbit * orbit,
        radius * orbit_rate + 2.0 * now.radial_velocity * orbit,
    ];
    Azimuth::new(azimuth(model, TIME, state, ball)).to_inertial(local)
}

/// Load, weight and unbalance of the spindle.
fn spindle_load(model: &Model) -> Vector {
    let m = model.mechanism();
    let (angle, speed, acceleration) = m.rotation.inner.at(TIME);
    let weight = [0.0, m.spindle_mass * m.gravity, 0.0];
    add(add(m.load, weight), unbalance_force(m.unbalance, angle, speed, acceleration))
}

fn assert_near(what: &str, a: Vector, b: Vector, tolerance: f64) {
    let off = length(subtract(a, b));
    assert!(off <= tolerance, "{what}: {a:?} and {b:?} differ by {off:e}, allowed {tolerance:e}");
}

/// dp/dt of all bodies = loads, weights and reaction of the outer ring. The forces between bodies cancel.
#[test]
fn momentum_changes_by_outer_forces_alone() {
    for (name, json) in all_scenes() {
        let model = model(&json);
        let m = model.mechanism();
        for seed in 1..=20 {
            let state = disturbed(&model, seed);
            let (rates, loads) = watched(&model, TIME, &state);
            let forces = forces(&model, &state, &loads);
            let balls = (0..m.layout.balls)
                .map(|ball| scale(m.ball_mass, ball_acceleration(&model, &state, &rates, ball)))
                .fold([0.0; 3], add);
            let cage = scale(m.cage.mass, m.layout.cage(&rates).velocity);
            let spindle = scale(m.spindle_mass, m.layout.spindle(&rates).velocity);
            let weight = (m.layout.balls as f64 * m.ball_mass + m.cage.mass) * m.gravity;
            let outside = add(add(spindle_load(&model), [0.0, weight, 0.0]), total(&forces.outer));
            let size = sizes(&forces.inner) + sizes(&forces.outer) + sizes(&forces.pocket);
            let what = format!("{name}, state {seed}");
            assert_near(&what, add(balls, add(cage, spindle)), outside, ROUNDING * size);
        }
    }
}

/// The force on the spindle is its loads minus the sum of the forces of the inner raceway on the balls.
#[test]
fn force_on_the_spindle_is_opposite_to_that_on_the_balls() {
    for (name, json) in all_scenes() {
        let model = model(&json);
        let m = model.mechanism();
        for seed in 1..=20 {
            let state = disturbed(&model, seed);
            let (rates, loads) = watched(&model, TIME, &state);
            let inner = forces(&model, &state, &loads).inner;
            let reaction = subtract(scale(m.spindle_mass, m.layout.spindle(&rates).velocity), spindle_load(&model));
            let what = format!("{name}, state {seed}");
            assert_near(&what, reaction, scale(-1.0, total(&inner)), ROUNDING * (sizes(&inner) + 1.0));
        }
    }
}

/// The force on the cage is its weight minus the sum of the forces of the pockets on the balls. In these states most pockets
/// carry a load.
#[test]
fn force_on_the_cage_is_opposite_to_that_of_its_pockets() {
    for (name, json) in all_scenes() {
        let model = model(&json);
        let m = model.mechanism();
        for seed in 1..=20 {
            let state = disturbed(&model, seed);
            let (rates, loads) = watched(&model, TIME, &state);
            let pocket = forces(&model, &state, &loads).pocket;
            assert!(pocket.iter().filter(|force| length(**force) > 0.0).count() >= 4);
            let weight = [0.0, m.cage.mass * m.gravity, 0.0];
            let change = scale(m.cage.mass, m.layout.cage(&rates).velocity);
            let what = format!("{name}, state {seed}");
            assert_near(&what, change, subtract(weight, total(&pocket)), ROUNDING * (sizes(&pocket) + 1.0));
        }
    }
}

/// Angular momentum of the cage about its centre of mass, inertial frame.
fn cage_spin_momentum(model: &Model, time: f64, state: &[f64]) -> Vector {
    let m = model.mechanism();
    let cage = m.layout.cage(state);
    let spin = m.rotations(time).orbit.speed + cage.arc_velocity / m.pitch_radius;
    let (axial, transverse) = (m.cage.axial_inertia, m.cage.transverse_inertia);
    let local = [axial * spin, transverse * cage.tilt_rate[0], transverse * cage.tilt_rate[1]];
    Tilt::new(cage.tilt[0], cage.tilt[1]).to_inertial(local)
}

/// Position of the centre of mass of the cage from the bearing centre.
fn cage_centre(model: &Model, state: &[f64]) -> Vector {
    let m = model.mechanism();
    let [x, y, z] = m.layout.cage(state).centre;
    [x - m.cage.offset, y, z]
}

/// Angular momentum of balls and cage about the bearing centre, inertial frame.
fn angular_momentum(model: &Model, time: f64, state: &[f64]) -> Vector {
    let m = model.mechanism();
    let ideal = m.rotations(time);
    let cage = scale(m.cage.mass, cross(cage_centre(model, state), m.layout.cage(state).velocity));
    let mut sum = add(cage_spin_momentum(model, time, state), cage);
    for index in 0..m.layout.balls {
        let ball = m.layout.ball(state, index);
        let radius = m.pitch_radius + ball.radial;
        let orbit = ideal.orbit.speed + ball.arc_velocity / m.pitch_radius;
        let place = [ball.axial, radius, 0.0];
        let velocity = [ball.axial_velocity, ball.radial_velocity, radius * orbit];
        let spin = add(ball.spin, [ideal.spin.speed, 0.0, 0.0]);
        let own = add(scale(m.ball_mass, cross(place, velocity)), scale(m.ball_inertia, spin));
        sum = add(sum, Azimuth::new(azimuth(model, time, state, index)).to_inertial(own));
    }
    sum
}

/// Rate of a quantity of the motion, by a central difference over `2 STEP` along the rates of state.
fn rate_of(quantity: impl Fn(f64, &[f64]) -> Vector, state: &[f64], rates: &[f64]) -> Vector {
    const STEP: f64 = 2e-9;
    let moved = |by: f64| -> Vec<f64> { state.iter().zip(rates).map(|(y, dy)| y + by * dy).collect() };
    let change = subtract(quantity(TIME + STEP, &moved(STEP)), quantity(TIME - STEP, &moved(-STEP)));
    scale(0.5 / STEP, change)
}

/// dL/dt of the cage about its centre = moments of the forces at the contact points of its pockets. This tests levers,
/// gyroscopic terms and rates of the tilt angles together. To the rounding of the difference quotient, 1e-16 L / 2 ns.
#[test]
fn cage_turns_by_the_moments_of_its_pockets() {
    for (name, json) in all_scenes() {
        let model = model(&json);
        let m = model.mechanism();
        for seed in 1..=20 {
            let state = disturbed(&model, seed);
            let (rates, loads) = watched(&model, TIME, &state);
            let pocket = forces(&model, &state, &loads).pocket;
            let cage = m.layout.cage(&state);
            let tilt = Tilt::new(cage.tilt[0], cage.tilt[1]);
            let centre = cage_centre(&model, &state);
            let (mut moment, mut size) = ([0.0; 3], 0.0);
            for (ball, load) in loads.pocket.iter().enumerate() {
                let now = m.layout.ball(&state, ball);
                let place = [now.axial, m.pitch_radius + now.radial, 0.0];
                let place = Azimuth::new(azimuth(&model, TIME, &state, ball)).to_inertial(place);
                let point = add(place, tilt.to_inertial(load.lever));
                let one = cross(subtract(point, centre), scale(-1.0, pocket[ball]));
                moment = add(moment, one);
                size += length(one);
            }
            let change = rate_of(|time, y| cage_spin_momentum(&model, time, y), &state, &rates);
            assert_near(&format!("{name}, state {seed}"), change, moment, 1e-10 * size + 1e-12);
        }
    }
}

/// dL/dt of balls and cage about the bearing centre = moments of raceways and weights. Forces and moments between balls and
/// pockets cancel. Tolerance as above.
#[test]
fn angular_momentum_changes_by_raceways_and_weight_alone() {
    for (name, json) in all_scenes() {
        let model = model(&json);
        let m = model.mechanism();
        for seed in 1..=20 {
            let state = disturbed(&model, seed);
            let (rates, loads) = watched(&model, TIME, &state);
            let cage_weight = [0.0, m.cage.mass * m.gravity, 0.0];
            let mut moment = cross(cage_centre(&model, &state), cage_weight);
            let mut size = 0.0;
            for index in 0..m.layout.balls {
                let ball = m.layout.ball(&state, index);
                let azimuth = Azimuth::new(azimuth(&model, TIME, &state, index));
                let place = [ball.axial, m.pitch_radius + ball.radial, 0.0];
                let weight = azimuth.to_orbit([0.0, m.ball_mass * m.gravity, 0.0]);
                let (inner, outer) = (&loads.inner[index], &loads.outer[index]);
                let own =
                    add(cross(place, add(weight, add(inner.force, outer.force))), add(inner.moment, outer.moment));
                moment = add(moment, azimuth.to_inertial(own));
                size += m.pitch_radius * (length(inner.force) + length(outer.force));
            }
            let change = rate_of(|time, y| angular_momentum(&model, time, y), &state, &rates);
            assert_near(&format!("{name}, state {seed}"), change, moment, 1e-10 * size);
        }
    }
}

/// Drag and churning are external: they reduce the momentum of the balls alone, equally at equal speed.
#[test]
fn drag_brakes_balls_only() {
    let bare = model(&everything());
    let braked = model(&changed(everything(), json!({ "terms": { "drag": "on", "churning": "on" } })));
    let m = braked.mechanism();
    let state = disturbed(&bare, 3);
    let (with, without) = (watched(&braked, TIME, &state).0, watched(&bare, TIME, &state).0);
    for index in 0..m.layout.balls {
        let (a, b) = (m.layout.ball(&with, index), m.layout.ball(&without, index));
        let ball = m.layout.ball(&state, index);
        let orbit = m.orbit_ratio * m.rotation.inner.at(TIME).1 + ball.arc_velocity / m.pitch_radius;
        let force = m.drag.unwrap().force(m.pitch_radius * orbit);
        let radius = m.pitch_radius + ball.radial;
        let expected = m.pitch_radius * force / (m.ball_mass * radius);
        assert!(force < 0.0 && (a.arc_velocity - b.arc_velocity - expected).abs() < 1e-6 * expected.abs());
        assert_eq!((a.axial_velocity, a.radial_velocity), (b.axial_velocity, b.radial_velocity));
        assert!(a.spin[0] > b.spin[0], "balls spin negatively about x");
    }
    assert_eq!(m.layout.cage(&with), m.layout.cage(&without));
    assert_eq!(m.layout.spindle(&with), m.layout.spindle(&without));
}

/// The unbalance is the inertia of a mass that turns with the spindle: F = −m e d²(cos ψ, sin ψ)/dt², at changing speed, too.
/// To the error of the difference quotient, 1e-6.
#[test]
fn unbalance_is_the_inertia_of_a_turning_mass() {
    let ramp = json!([{ "at_s": 0, "rpm": 1_000 }, { "at_s": 0.001, "rpm": 60_000 }]);
    let model = model(&changed(everything(), json!({ "operation": { "speed_rpm": ramp } })));
    let m = model.mechanism();
    assert!(m.unbalance > 0.0);
    const STEP: f64 = 1e-7;
    for time in [1e-5, 1e-4, 5e-4, 9e-4] {
        let (angle, speed, acceleration) = m.rotation.inner.at(time);
        let found = unbalance_force(m.unbalance, angle, speed, acceleration);
        let place = |time: f64| {
            let (sine, cosine) = m.rotation.inner.at(time).0.sin_cos();
            [0.0, cosine, sine]
        };
        let bend = subtract(add(place(time + STEP), place(time - STEP)), scale(2.0, place(time)));
        let expected = scale(-m.unbalance / (STEP * STEP), bend);
        assert_near(&format!("at {time} s"), found, expected, 1e-5 * m.unbalance * acceleration.max(speed * speed));
    }
}

/// Positions of the balls in the coordinates of their raceways.
#[derive(Default)]
struct Motions(Vec<RelativeMotion>);

impl Watch for Motions {
    fn raceway(&mut self, _ball: usize, _side: BallContact, motion: &RelativeMotion, _load: &RacewayLoad) {
        self.0.push(*motion);
    }
}

/// The velocity in a contact is the rate of the position in it, motion and tilt of the spindle included. To the error of the
/// central difference, 1e-7 m/s.
#[test]
fn velocities_in_contacts_are_rates_of_their_positions() {
    const STEP: f64 = 1e-9;
    for (name, json) in all_scenes() {
        let model = model(&json);
        for seed in 1..=20 {
            let state = disturbed(&model, seed);
            let (rates, _) = watched(&model, TIME, &state);
            let seen = |by: f64| {
                let moved: Vec<f64> = state.iter().zip(&rates).map(|(y, dy)| y + by * dy).collect();
                let mut motions = Motions::default();
                model.derivative_watched(TIME + by, &moved, &mut vec![0.0; moved.len()], &mut motions);
                motions.0
            };
            for ((now, after), before) in seen(0.0).iter().zip(seen(STEP)).zip(seen(-STEP)) {
                let axial = (after.axial - before.axial) / (2.0 * STEP);
                let radial = (after.radius - before.radius) / (2.0 * STEP);
                let off = (axial - now.velocity[0]).abs().max((radial - now.velocity[1]).abs());
                assert!(off < 1e-6, "{name}, state {seed}: {off:e} m/s of {:?}", now.velocity);
            }
        }
    }
}

/// The squeeze rate of a pocket film is the rate of the ball displacement in the pocket, with motion, rotation and tilt of the
/// cage. Damping force over damping is compared with the central difference of elastic force over stiffness.
#[test]
fn velocities_in_pockets_are_rates_of_their_positions() {
    const STEP: f64 = 1e-9;
    const STIFFNESS: f64 = 1e5;
    const DAMPING: f64 = 1.0;
    let with = |damping: f64| {
        let film = json!({ "stiffness_n_per_m": STIFFNESS, "damping_n_s_per_m": damping });
        let terms = json!({ "hydrodynamics": "off", "pocket_friction": "off" });
        model(&changed(everything(), json!({ "bearing": { "cage": { "film": film } }, "terms": terms })))
    };
    let (elastic, damped) = (with(0.0), with(DAMPING));
    let edge = 0.5 * elastic.mechanism().cage.pocket_clearance * STIFFNESS;
    let mut compared = 0;
    for seed in 1..=100 {
        let state = disturbed(&elastic, seed);
        let (rates, loads) = watched(&elastic, TIME, &state);
        let (_, damped_loads) = watched(&damped, TIME, &state);
        let seen = |by: f64| {
            let moved: Vec<f64> = state.iter().zip(&rates).map(|(y, dy)| y + by * dy).collect();
            watched(&elastic, TIME + by, &moved).1.pocket
        };
        let (after, before) = (seen(STEP), seen(-STEP));
        for ball in 0..7 {
            let (slow, fast) = (loads.pocket[ball].normal, damped_loads.pocket[ball].normal);
            // Within the clearance, beyond the onset of the film, and not separating faster than the film follows.
            if slow < 0.2e-6 * STIFFNESS || slow > 0.99 * edge || fast == 0.0 {
                continue;
            }
            let rate = (after[ball].normal - before[ball].normal) / (2.0 * STEP * STIFFNESS);
            let felt = (fast - slow) / DAMPING;
            assert!((felt - rate).abs() < 1e-5, "state {seed}, ball {ball}: {felt} m/s, not {rate} m/s");
            compared += 1;
        }
    }
    assert!(compared > 100, "{compared}");
}
