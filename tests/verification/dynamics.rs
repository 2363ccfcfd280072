//! Motion: varying compliance computed independently, unbalance, level.

use std::f64::consts::{PI, TAU};

use raceway::numerics::ode::{Method, OdeSystem};
use raceway::numerics::roots::bracketed_root;
use raceway::physics::frames::{Azimuth, Vector, add, scale, subtract};
use raceway::physics::kinematics::ideal_orbit_ratio;
use raceway::physics::pocket::PocketLoad;
use raceway::physics::raceway::{RacewayLoad, RelativeMotion};
use raceway::simulation::input::channel::{Axis, BallContact, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::{Scene, Term, TermChoice};
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::equilibrium::{equilibrium, start_state};
use raceway::simulation::model::spindle_only::simulate;
use raceway::simulation::model::state::BallState;
use raceway::simulation::model::terms::ActiveTerms;
use raceway::simulation::model::{Mechanism, Model, Watch};
use raceway::simulation::result::metrics::{channel_metrics, level_db};
use serde_json::json;

use crate::distribution::{bearing_218, needs, scene};
use crate::table::{check, check_computed};

/// 6204 at 6000 r/min under 200 N, a spindle of 1 kg, balls of a density [kg/m³].
fn turning(density: f64) -> Scene {
    let steel = |density: f64| json!({ "elastic_modulus_gpa": 206, "poisson_ratio": 0.3, "density_kg_m3": density });
    scene(&json!({
        "bearing": {
            "type": "deep_groove", "outer_diameter_mm": 47, "inner_diameter_mm": 20, "width_mm": 14, "ball_count": 8,
            "ball_diameter_mm": 7.938, "pitch_diameter_mm": 33.5, "inner_groove_curvature": 0.52,
            "outer_groove_curvature": 0.53, "radial_clearance_um": 5,
            "materials": { "ball": steel(density), "inner_raceway": steel(7830.0), "outer_raceway": steel(7830.0) }
        },
        "operation": { "speed_rpm": SPEED, "radial_load_y_n": LOAD },
        "spindle": { "mass_kg": 1 },
        "gravity_m_s2": 0
    }))
}

const SPEED: f64 = 6000.0;
const LOAD: f64 = 200.0;
const SETTLE: f64 = 0.2;
const KEEP: f64 = 0.1;

/// rms of acceleration along Y and Z [m/s²] of Sunnersjö's model with two degrees of freedom.
///
/// Balls are equally spaced on the cage, and each is a nonlinear spring between spindle and ring without inertia. Added here
/// are the centrifugal force F of the balls and contacts that incline with the displacement of the spindle. Traction gives
/// each raceway half of that inclination. RK4 in time.
fn two_degrees_of_freedom(scene: &Scene, outputs: &Outputs) -> [f64; 2] {
    let mechanism = Mechanism::new(scene, &ActiveTerms::of(scene, outputs, None).unwrap());
    let stiffness = mechanism.raceway.map(|contact| contact.hertz().stiffness);
    let damping = scene.raceway_damping.resolve().chi;
    let balls = scene.bearing.parameters.ball_count;
    let orbit = ideal_orbit_ratio(&scene.bearing) * SPEED * PI / 30.0;
    let centrifugal = mechanism.ball_mass * orbit * orbit * mechanism.pitch_radius;
    let acceleration = |time: f64, [y, z, vy, vz]: [f64; 4]| {
        let mut force = [LOAD, 0.0];
        for ball in 0..balls {
            let (sine, cosine) = (orbit * time + TAU * ball as f64 / balls as f64).sin_cos();
            let (towards, aside) = (y * cosine + z * sine, z * cosine - y * sine);
            let lean = aside / mechanism.pitch_radius;
            let depth = towards - 0.5 * aside * lean - 0.5 * scene.bearing.radial_clearance;
            let rate = vy * cosine + vz * sine + orbit * aside;
            // K_e (D − δ_i)^1.5 = K_i δ_i^1.5 + F. Each contact is damped in proportion to its part of the rate.
            let inner = bracketed_root(
                |inner| stiffness.outer * (depth - inner).powf(1.5) - stiffness.inner * inner.powf(1.5) - centrifugal,
                0.0,
                depth.max(0.0),
            );
            let slopes = [stiffness.inner * inner.sqrt(), stiffness.outer * (depth - inner).max(0.0).sqrt()];
            let [outer_share, inner_share] = slopes.map(|slope| slope / (slopes[0] + slopes[1]).max(1.0));
            let elastic = stiffness.inner * inner.powf(1.5);
            let spent = inner_share * inner_share * elastic + outer_share * outer_share * (elastic + centrifugal);
            let load = if elastic > 0.0 { elastic + damping * spent * rate } else { 0.0 };
            let tangential = 0.5 * lean * load;
            force = [force[0] - load * cosine - tangential * sine, force[1] - load * sine + tangential * cosine];
        }
        force.map(|force| force / scene.spindle.mass)
    };
    let rates = |time: f64, state: [f64; 4]| {
        let [ay, az] = acceleration(time, state);
        [state[2], state[3], ay, az]
    };
    let along = |state: [f64; 4], step: f64, rates: [f64; 4]| std::array::from_fn(|i| state[i] + step * rates[i]);
    let step = 1e-5;
    let (mut state, mut squares) = ([1e-5, 0.0, 0.0, 0.0], [0.0; 2]);
    let steps = ((SETTLE + KEEP) / step) as u32;
    let settling = (SETTLE / step) as u32;
    for i in 0..steps {
        let time = f64::from(i) * step;
        if i >= settling {
            let now = acceleration(time, state);
            squares = [squares[0] + now[0] * now[0], squares[1] + now[1] * now[1]];
        }
        let k1 = rates(time, state);
        let k2 = rates(time + 0.5 * step, along(state, 0.5 * step, k1));
        let k3 = rates(time + 0.5 * step, along(state, 0.5 * step, k2));
        let k4 = rates(time + step, along(state, step, k3));
        let mean = std::array::from_fn(|j| (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]) / 6.0);
        state = along(state, step, mean);
    }
    squares.map(|sum| (sum / f64::from(steps - settling)).sqrt())
}

#[test]
fn varying_compliance() {
    for (case, density) in [("varying-compliance", 7830.0), ("varying-compliance-light", 78.3)] {
        let scene = turning(density);
        let outputs = Outputs::vibration();
        let expected = two_degrees_of_freedom(&scene, &outputs);
        let settings = RunSettings {
            method: Method::Auto,
            rung: Some(ModelLevel::SpindleOnly),
            relative_tolerance: 1e-5,
            tightened: None,
            model_tolerance_db: 0.0,
            fixed_step: None,
            settle: SETTLE,
            duration: KEEP,
            outputs,
        };
        let recording = simulate(&scene, &settings, &Control::until(&|| false)).unwrap().0;
        let ours = [Axis::Y, Axis::Z].map(|axis| {
            let channel = Channel::Spindle(axis, Motion::Acceleration);
            channel_metrics(channel, recording.signal(channel).unwrap(), 0.0).rms
        });
        check_computed(case, &expected, &ours);
    }
}

/// Sum of the moments of raceways and pocket on the first ball, in its orbit frame [N m].
#[derive(Default)]
struct Moments(Vector);

impl Watch for Moments {
    fn raceway(&mut self, ball: usize, _side: BallContact, _motion: &RelativeMotion, load: &RacewayLoad) {
        if ball == 0 {
            self.0 = add(self.0, load.moment);
        }
    }

    fn pocket(&mut self, ball: usize, load: &PocketLoad) {
        if ball == 0 {
            self.0 = add(self.0, load.moment);
        }
    }
}

/// Gyroscopic moment [N mm] of a ball of bearing 218 in its orbit frame (x, r, t): I_b times the rates of its spin in the model, less the
/// moments on it. The spin axis is that of outer control, tilted further by a part about t, as skew friction does.
///
/// The expectation is the moment that is missing in the inertial frame while the components of the spin in the orbit frame are held:
/// −d/dt of I_b ω, by a central difference over a small turn of the frame. It knows no formula of a turning frame.
#[test]
fn gyroscopic_moment() {
    let mut scene = bearing_218();
    scene.terms.set(Term::Churning, TermChoice::Off);
    let of = |about_t: f64| {
        let model = Model::new(&scene, &needs(&scene));
        let m = model.mechanism();
        let (_, speed, _) = m.rotation.inner.at(0.0);
        let rest = equilibrium(m, speed).unwrap();
        let orbit = m.orbit_ratio * speed;
        let (sine, cosine) = rest.angles[0].outer;
        let pitch = sine.atan2(cosine + m.ball_radius / (m.pitch_radius + rest.balls[0].1));
        let spin_speed = ((m.spin_ratio - m.orbit_ratio) * speed).abs();
        // In the orbit frame the ball turns against the spindle; its spin in space includes the orbit.
        let spin = [orbit - spin_speed * pitch.cos(), spin_speed * pitch.sin(), about_t * spin_speed];
        let mut state = start_state(&model).unwrap();
        let ball = m.layout.ball(&state, 0);
        let spin_state = [spin[0] - m.spin_ratio * speed, spin[1], spin[2]];
        m.layout.set_ball(&mut state, 0, &BallState { spin: spin_state, ..ball });
        let (mut rates, mut moments) = (vec![0.0; model.dimension()], Moments::default());
        model.derivative_watched(0.0, &state, &mut rates, &mut moments);
        let changed = scale(m.ball_inertia, m.layout.ball(&rates, 0).spin);
        let ours = scale(1e3, subtract(changed, moments.0));
        let momentum = |angle: f64| Azimuth::new(angle).to_inertial(scale(m.ball_inertia, spin));
        let turn = 1e-4;
        let rate = scale(0.5 * orbit / turn, subtract(momentum(turn), momentum(-turn)));
        assert!(ours[0].abs() < 1e-6 * ours[2].abs(), "{ours:?}");
        (scale(-1e3, rate), ours, (spin_speed, orbit, pitch))
    };
    let (expected, ours, _) = of(0.1);
    check_computed("gyroscopic-moment", &expected[1..], &ours[1..]);
    let (_, [_, _, about_t], (spin_speed, orbit, pitch)) = of(0.0);
    let per_minute = 30.0 / PI;
    let diameter = 1e3 * scene.bearing.parameters.ball_diameter;
    let printed = 4.47e-12 * diameter.powi(5) * spin_speed * per_minute * orbit * per_minute * pitch.sin();
    check_computed("gyroscopic-218", &[printed], &[-about_t]);
}

/// Specific unbalance [µm] of a grade at a speed: mass times eccentricity over mass.
#[test]
fn balance_grade() {
    let json = json!({
        "bearing": "article-integrated", "operation": { "speed_rpm": 3000, "radial_load_y_n": 100 },
        "spindle": { "mass_kg": 2, "balance_grade": 6.3 }
    });
    let spindle = scene(&json).spindle;
    check("balance-grade", &[spindle.unbalance_product(3000.0 * PI / 30.0) / spindle.mass * 1e6]);
}

#[test]
fn level() {
    check("level", &[level_db(1.0).unwrap()]);
}
