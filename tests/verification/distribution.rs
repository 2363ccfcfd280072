//! Load distribution among the balls of a bearing at rest, and at speed without friction.

use std::f64::consts::{PI, TAU};

use raceway::contract::scene_from_json;
use raceway::numerics::roots::bracketed_root;
use raceway::physics::bearing::PerRaceway;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::Outputs;
use raceway::simulation::model::Mechanism;
use raceway::simulation::model::equilibrium::{StaticLoads, equilibrium, static_loads};
use raceway::simulation::model::terms::ActiveTerms;
use serde_json::{Value, json};

use crate::table::{check, check_computed};

pub fn scene(json: &Value) -> Scene {
    let mut json = json.clone();
    if json["operation"].is_null() {
        json["operation"] = json!({ "speed_rpm": 1000, "radial_load_y_n": 100 });
    }
    scene_from_json(&json.to_string()).unwrap_or_else(|refusal| panic!("{refusal:?}\n{json:#}"))
}

pub fn needs(scene: &Scene) -> ActiveTerms {
    let outputs = Outputs { contacts: true, cage: true, ..Outputs::vibration() };
    ActiveTerms::of(scene, &outputs, None).unwrap()
}

fn at_rest(scene: &Scene) -> StaticLoads {
    static_loads(scene, &needs(scene)).unwrap()
}

/// Largest ball load times the number of balls over the load.
fn share_of_the_largest(scene: &Scene) -> f64 {
    let loads = at_rest(scene);
    loads.max_ball_load * loads.ball_loads.len() as f64 / scene.operation.load[1]
}

/// A bearing of 40 balls on a wide pitch circle, at a clearance [µm] and a load [N].
fn many_balls(clearance_um: f64, load: f64) -> Scene {
    scene(&json!({
        "bearing": {
            "outer_diameter_mm": 130, "inner_diameter_mm": 70, "width_mm": 15, "ball_count": 40, "ball_diameter_mm": 6,
            "pitch_diameter_mm": 100, "inner_groove_curvature": 0.52, "outer_groove_curvature": 0.52,
            "radial_clearance_um": clearance_um
        },
        "operation": { "speed_rpm": 0, "radial_load_y_n": load },
        "gravity_m_s2": 0
    }))
}

/// Zero clearance. The loads are so small that the spindle is displaced by 1e-4 of the raceway radius. The contacts incline by
/// the same ratio.
#[test]
fn stribeck() {
    check("stribeck", &[share_of_the_largest(&many_balls(0.0, 200.0))]);
    let sum: f64 = (0..7).map(|ball| (TAU * f64::from(ball) / 7.0).cos().max(0.0).powf(2.5)).sum();
    let seven = scene(&json!({
        "bearing": { "preset": "article-integrated", "radial_clearance_um": 0 },
        "operation": { "speed_rpm": 0, "radial_load_y_n": 2 },
        "gravity_m_s2": 0
    }));
    check_computed("stribeck-7", &[7.0 / sum], &[share_of_the_largest(&seven)]);
}

/// J_r(ε) = F/(Z Q_max), at the clearance for which ε = ½ (1 − P_d/2δ_r).
#[test]
fn sjovall() {
    for (case, extent) in [("sjovall-0.3", 0.3), ("sjovall-0.4", 0.4), ("sjovall-0.5", 0.5), ("sjovall-0.7", 0.7)] {
        let missed = |clearance: f64| {
            let sunk = at_rest(&many_balls(clearance, 2000.0)).radial_displacement * 1e6;
            0.5 * (1.0 - 0.5 * clearance / sunk) - extent
        };
        let clearance = if extent == 0.5 { 0.0 } else { bracketed_root(missed, -60.0, 100.0) };
        check(case, &[1.0 / share_of_the_largest(&many_balls(clearance, 2000.0))]);
    }
}

/// Load–deflection factor K of a ball between both raceways [N/m^1.5].
fn series_stiffness(scene: &Scene) -> f64 {
    let stiffness =
        Mechanism::new(scene, &needs(scene)).raceway.map(|contact| contact.hertz().stiffness.powf(-2.0 / 3.0));
    (stiffness.inner + stiffness.outer).powf(-1.5)
}

/// Displacement [m] and ball loads [N] of the classical theory, whose contacts keep their direction:
/// Q_j = K (δ_r cos φ_j − P_d/2)^1.5, Σ Q_j cos φ_j = F.
fn classical(scene: &Scene) -> (f64, Vec<f64>) {
    let stiffness = series_stiffness(scene);
    let balls = scene.bearing.parameters.ball_count;
    let cosine = |ball: usize| (TAU * ball as f64 / balls as f64).cos();
    let loads = |sunk: f64| -> Vec<f64> {
        let penetration = |ball| (sunk * cosine(ball) - 0.5 * scene.bearing.radial_clearance).max(0.0);
        (0..balls).map(|ball| stiffness * penetration(ball).powf(1.5)).collect()
    };
    let carried = |sunk: f64| loads(sunk).iter().enumerate().map(|(ball, load)| load * cosine(ball)).sum::<f64>();
    let sunk = bracketed_root(|sunk| carried(sunk) - scene.operation.load[1], 0.0, 1e-3);
    (sunk, loads(sunk))
}

/// 8900 N on the 209. Its contacts incline with the displacement of the spindle, 61 µm on a radius of 32.5 mm.
#[test]
fn bearing_209() {
    let steel = json!({ "elastic_modulus_gpa": 206.9, "poisson_ratio": 0.3, "density_kg_m3": 7800 });
    let scene = scene(&json!({
        "bearing": {
            "type": "deep_groove", "outer_diameter_mm": 85, "inner_diameter_mm": 45, "width_mm": 19, "ball_count": 9,
            "ball_diameter_mm": 12.7, "pitch_diameter_mm": 65, "inner_groove_curvature": 0.52,
            "outer_groove_curvature": 0.52, "radial_clearance_um": 15,
            "materials": { "ball": steel, "inner_raceway": steel, "outer_raceway": steel }
        },
        "operation": { "speed_rpm": 1800, "radial_load_y_n": 8900 },
        "gravity_m_s2": 0
    }));
    let StaticLoads { ball_loads: loads, radial_displacement, .. } = at_rest(&scene);
    let (sunk, classical) = classical(&scene);
    check_computed("209-displacement", &[sunk * 1e6], &[radial_displacement * 1e6]);
    check("209-0-40", &loads[..2]);
    check("209-80", &loads[2..3]);
    check_computed("209-0-40-classical", &classical[..2], &loads[..2]);
    check_computed("209-80-classical", &classical[2..3], &loads[2..3]);
    assert!(loads[3..=6].iter().all(|load| *load == 0.0));
    assert!((1..9).all(|ball| (loads[ball] - loads[9 - ball]).abs() < 1e-6), "left and right alike");
}

/// The 218 angular-contact bearing of Jones and Harris under an axial load of 17 800 N.
/// Bearing 218 under thrust at 10 000 r/min.
pub fn bearing_218() -> Scene {
    let steel = json!({ "elastic_modulus_gpa": 206.9, "poisson_ratio": 0.3, "density_kg_m3": 7830 });
    scene(&json!({
        "bearing": {
            "type": "angular_contact", "outer_diameter_mm": 160, "inner_diameter_mm": 90, "width_mm": 30, "ball_count": 16,
            "ball_diameter_mm": 22.225, "pitch_diameter_mm": 125.26, "inner_groove_curvature": 0.5232,
            "outer_groove_curvature": 0.5232, "contact_angle_deg": 40,
            "materials": { "ball": steel, "inner_raceway": steel, "outer_raceway": steel }
        },
        "operation": { "speed_rpm": 10_000, "axial_load_n": AXIAL_LOAD },
        "gravity_m_s2": 0
    }))
}

const AXIAL_LOAD: f64 = 17_800.0;

/// Contact angles [°] and loads [N] of the first ball, and the spindle's displacement from first touch [µm], at a speed
/// [rad/s].
fn under_thrust(scene: &Scene, speed: f64) -> (PerRaceway<f64>, PerRaceway<f64>, f64) {
    let mechanism = Mechanism::new(scene, &needs(scene));
    let rest = equilibrium(&mechanism, speed).unwrap();
    let (axial, radial) = rest.balls[0];
    let radius = 0.5 * scene.bearing.parameters.pitch_diameter + radial;
    let centre = scene.bearing.groove_centre_radius;
    let angle = PerRaceway {
        inner: (rest.spindle[0] - axial).atan2(centre.inner - radius).to_degrees(),
        outer: axial.atan2(radius - centre.outer).to_degrees(),
    };
    assert!(rest.loads.iter().all(|load| (load.inner / rest.loads[0].inner - 1.0).abs() < 1e-9), "all balls alike");
    let play = scene.bearing.groove_centre_distance * scene.bearing.free_contact_angle.sin();
    (angle, rest.loads[0], (rest.spindle[0] - play) * 1e6)
}

/// Jones: F_a = Z K A^1.5 sin α (cos α₀/cos α − 1)^1.5, δ_a = A sin(α − α₀)/cos α.
#[test]
fn axial_load() {
    let scene = bearing_218();
    let (angle, load, displacement) = under_thrust(&scene, 0.0);
    assert!((load.inner / load.outer - 1.0).abs() < 1e-9 && (angle.inner - angle.outer).abs() < 1e-6);
    check("218-angle", &[angle.inner]);
    check("218-displacement", &[displacement * 1e-3]);
    let (free, distance) = (scene.bearing.free_contact_angle, scene.bearing.groove_centre_distance);
    let (balls, stiffness) = (scene.bearing.parameters.ball_count as f64, series_stiffness(&scene));
    let excess = |angle: f64| {
        let load = stiffness * (distance * (free.cos() / angle.cos() - 1.0)).max(0.0).powf(1.5);
        balls * load * angle.sin() - AXIAL_LOAD
    };
    let loaded = bracketed_root(excess, free, free + 0.3);
    let along = distance * (loaded - free).sin() / loaded.cos();
    check_computed("218-closed-form", &[loaded.to_degrees(), along * 1e6], &[angle.inner, displacement]);
}

/// At 10 000 r/min the centrifugal force of the balls separates the contact angles.
///
/// Without friction and gyroscopic moment the outer angle is the only unknown: Q_e sin α_e = Q_i sin α_i = F_a/Z and
/// Q_e cos α_e − Q_i cos α_i = m θ̇² r. The radial distance of the groove centres remains A cos α₀.
#[test]
fn axial_load_at_speed() {
    let scene = bearing_218();
    let speed = 10_000.0 * PI / 30.0;
    let (angle, load, displacement) = under_thrust(&scene, speed);
    let (bearing, mechanism) = (&scene.bearing, Mechanism::new(&scene, &needs(&scene)));
    let p = &bearing.parameters;
    let stiffness = mechanism.raceway.map(|contact| contact.hertz().stiffness);
    let touching = (p.groove_curvature.inner - 0.5) * p.ball_diameter;
    let (free, distance) = (bearing.free_contact_angle, bearing.groove_centre_distance);
    let orbit = 0.5 * (1.0 - p.ball_diameter * free.cos() / p.pitch_diameter) * speed;
    let along = AXIAL_LOAD / p.ball_count as f64;
    let solve = |outer: f64| {
        let outer_load = along / outer.sin();
        let outer_length = touching + (outer_load / stiffness.outer).powf(2.0 / 3.0);
        let radius = 0.5 * p.pitch_diameter - touching * free.cos() + outer_length * outer.cos();
        let inner = along.atan2(outer_load * outer.cos() - bearing.ball_mass * orbit * orbit * radius);
        let inner_load = along / inner.sin();
        let inner_length = touching + (inner_load / stiffness.inner).powf(2.0 / 3.0);
        let missed = outer_length * outer.cos() + inner_length * inner.cos() - distance * free.cos();
        let displacement = outer_length * outer.sin() + inner_length * inner.sin() - distance * free.sin();
        (missed, [outer.to_degrees(), inner.to_degrees(), outer_load, inner_load, displacement * 1e6])
    };
    let outer = bracketed_root(|outer| solve(outer).0, 0.1, free);
    check_computed("218-at-speed", &solve(outer).1, &[angle.outer, angle.inner, load.outer, load.inner, displacement]);
}
