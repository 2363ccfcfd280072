//! Scenes from JSON, their models, and states away from equilibrium.

use raceway::contract::scene_from_json;
use raceway::numerics::ode::dormand_prince::DormandPrince;
use raceway::numerics::ode::{Integrator, OdeSystem};
use raceway::physics::frames::Vector;
use raceway::physics::pocket::PocketLoad;
use raceway::physics::raceway::{RacewayLoad, RelativeMotion};
use raceway::simulation::input::channel::BallContact;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::Outputs;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::state::BallAttitude;
use raceway::simulation::model::terms::ActiveTerms;
use raceway::simulation::model::{Model, Watch};
use serde_json::{Value, json};

pub use crate::article::{article, changed};

/// The article's case in flooding oil with hydrodynamic forces, free along X under an axial load. It has every force between
/// bodies. Drag and churning are off, because they are external.
pub fn everything() -> Value {
    changed(
        article(),
        json!({
            "lubricant": { "kind": "oil" },
            "operation": { "radial_load_z_n": -60, "axial_load_n": 25 },
            "spindle": { "balance_grade": 6.3 },
            "terms": { "hydrodynamics": "on", "drag": "off", "churning": "off" }
        }),
    )
}

/// An outer ring that turns against the inner one at a falling speed.
pub fn turning_outer_ring() -> Value {
    json!({ "operation": { "outer_speed_rpm": [{ "at_s": 0, "rpm": -20_000 }, { "at_s": 0.01, "rpm": 5_000 }] } })
}

/// Surfaces with waves on both raceways.
pub fn waves() -> Value {
    json!({
        "surfaces": {
            "inner": { "waviness": [{ "order": 9, "amplitude_nm": 200, "phase_deg": 40 }, { "order": 1, "amplitude_nm": 900 }] },
            "outer": { "waviness": [{ "order": 40, "amplitude_nm": 100, "phase_deg": -70 }] }
        }
    })
}

/// Grooves whose places along the axis have waves.
pub fn axial_waves() -> Value {
    json!({
        "surfaces": {
            "inner": { "axial_waviness": [{ "order": 5, "amplitude_nm": 900, "phase_deg": 40 }] },
            "outer": { "axial_waviness": [{ "order": 20, "amplitude_nm": 300, "phase_deg": -70 }] }
        }
    })
}

/// Balls of unequal size in uneven pockets of a cage for seven.
pub fn unequal() -> Value {
    json!({
        "bearing": { "cage": { "pocket_spacing_mrad": [0, 3, -2, 0, 0, 4, 0] } },
        "surfaces": { "balls": [
            { "ball": 1, "diameter_um": -0.4 }, { "ball": 3, "diameter_um": 1.5 }, { "ball": 7, "diameter_um": 0.8 }
        ] }
    })
}

/// Surfaces with defects over the whole groove, and with narrow ones whose middle lies `across_mm` beside the groove's bottom. Balls of the
/// article's case are in them at t = 0 and at 0.23 ms.
pub fn defects(across_mm: f64) -> Value {
    json!({
        "surfaces": {
            "inner": { "defects": [
                { "azimuth_deg": 52, "length_mm": 0.4, "width_mm": 0.5, "across_mm": across_mm, "depth_um": 2, "shape": "half_sine" },
                { "azimuth_deg": 10, "length_mm": 0.3, "depth_um": 1 }
            ] },
            "outer": { "defects": [
                { "azimuth_deg": 2, "length_mm": 0.5, "depth_um": 4 },
                { "azimuth_deg": 26, "length_mm": 0.5, "width_mm": 0.4, "across_mm": across_mm, "depth_um": 10 },
                { "azimuth_deg": 106, "length_mm": 0.6, "width_mm": 0.3, "across_mm": across_mm, "depth_um": 20 }
            ] }
        }
    })
}

/// Surfaces with defects that carry the balls of the article's case.
pub fn carrying_defects() -> Value {
    json!({
        "surfaces": {
            "inner": { "defects": [{ "azimuth_deg": 10, "length_mm": 0.3, "depth_um": 1, "shape": "half_sine" }] },
            "outer": { "defects": [{ "azimuth_deg": 2, "length_mm": 0.5, "width_mm": 0.4, "depth_um": 1 }] }
        }
    })
}

pub fn scene(json: &Value) -> Scene {
    scene_from_json(&json.to_string()).unwrap_or_else(|refusal| panic!("{refusal:?}\n{json:#}"))
}

pub fn nothing_asked() -> Outputs {
    Outputs { contacts: true, cage: true, ..Outputs::vibration() }
}

pub fn needs(scene: &Scene, rung: Option<ModelLevel>) -> ActiveTerms {
    ActiveTerms::of(scene, &nothing_asked(), rung).unwrap()
}

/// The model that a scene in JSON needs.
pub fn model(json: &Value) -> Model {
    model_on(json, None)
}

pub fn model_on(json: &Value, rung: Option<ModelLevel>) -> Model {
    let scene = scene(json);
    Model::new(&scene, &needs(&scene, rung))
}

pub fn rates(model: &Model, time: f64, state: &[f64]) -> Vec<f64> {
    let mut rates = vec![0.0; model.dimension()];
    model.derivative(time, state, &mut rates);
    rates
}

/// Random numbers in −1 … 1, the same in every run.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Balls with waves, and with defects at a latitude that meet both raceways at t = 0.
pub fn uneven_balls(latitude_deg: f64) -> Value {
    json!({
        "surfaces": { "balls": [
            {
                "ball": 1,
                "waviness": [{ "order": 3, "amplitude_nm": 200, "phase_deg": 40 }, { "order": 40, "amplitude_nm": 30, "phase_deg": -70 }],
                "defects": [
                    { "diameter_mm": 0.3, "depth_um": 2, "latitude_deg": latitude_deg, "longitude_deg": 5 },
                    { "diameter_mm": 0.3, "depth_um": 2, "latitude_deg": latitude_deg, "longitude_deg": 190 }
                ]
            },
            { "ball": 2, "waviness": [{ "order": 2, "amplitude_nm": 300, "phase_deg": -30 }] },
            { "ball": 7, "defects": [{ "diameter_mm": 0.2, "depth_um": 1, "longitude_deg": -3 }] }
        ] }
    })
}

/// Equilibrium with a random displacement of every entry. Some contacts are open, some pockets in contact up to their rims.
///
/// Largest displacements: 2 µm for positions (cage 30 µm, arcs 40 µm), 0.2 m/s for velocities, 1000 rad/s for spins, 1 mrad for
/// the tilt of the cage.
pub fn disturbed(model: &Model, seed: u64) -> Vec<f64> {
    let layout = model.mechanism().layout;
    let mut random = Random::new(seed);
    let mut state = start_state(model).unwrap();
    let mut spread = |size: f64| size * random.next();
    for index in 0..layout.balls {
        let mut ball = layout.ball(&state, index);
        ball.axial += spread(2e-6);
        ball.radial += spread(2e-6);
        ball.arc += spread(40e-6);
        ball.axial_velocity += spread(0.2);
        ball.radial_velocity += spread(0.2);
        ball.arc_velocity += spread(0.2);
        ball.spin = ball.spin.map(|spin| spin + spread(1000.0));
        layout.set_ball(&mut state, index, &ball);
    }
    for index in (0..layout.balls).filter(|_| layout.attitude) {
        let attitude = layout.attitude(&state, index);
        let attitude = BallAttitude(attitude.0.map(|entry| entry + spread(0.02)));
        layout.set_attitude(&mut state, index, &attitude);
    }
    let mut cage = layout.cage(&state);
    cage.centre = cage.centre.map(|_| spread(30e-6));
    cage.arc = spread(20e-6);
    cage.tilt = cage.tilt.map(|_| spread(1e-3));
    cage.velocity = cage.velocity.map(|_| spread(0.2));
    cage.arc_velocity = spread(0.2);
    cage.tilt_rate = cage.tilt_rate.map(|_| spread(30.0));
    layout.set_cage(&mut state, &cage);
    let mut spindle = layout.spindle(&state);
    spindle.position = spindle.position.map(|x| x + spread(2e-6));
    spindle.velocity = spindle.velocity.map(|_| spread(0.1));
    if layout.tilting_spindle {
        spindle.tilt = spindle.tilt.map(|tilt| tilt + spread(3e-4));
        spindle.tilt_rate = spindle.tilt_rate.map(|_| spread(10.0));
    }
    layout.set_spindle(&mut state, &spindle);
    state
}

/// Every load of one evaluation, for each ball.
#[derive(Default, Clone)]
pub struct Loads {
    pub inner: Vec<RacewayLoad>,
    pub outer: Vec<RacewayLoad>,
    pub pocket: Vec<PocketLoad>,
}

impl Watch for Loads {
    fn raceway(&mut self, _ball: usize, side: BallContact, _motion: &RelativeMotion, load: &RacewayLoad) {
        match side {
            BallContact::Inner => self.inner.push(*load),
            _ => self.outer.push(*load),
        }
    }

    fn pocket(&mut self, _ball: usize, load: &PocketLoad) {
        self.pocket.push(*load);
    }
}

/// Rates and loads of one state.
pub fn watched(model: &Model, time: f64, state: &[f64]) -> (Vec<f64>, Loads) {
    let mut rates = vec![0.0; model.dimension()];
    let mut loads = Loads::default();
    model.derivative_watched(time, state, &mut rates, &mut loads);
    (rates, loads)
}

/// Azimuth of a ball [rad].
pub fn azimuth(model: &Model, time: f64, state: &[f64], ball: usize) -> f64 {
    let m = model.mechanism();
    m.start_azimuth(ball) + m.rotations(time).orbit.angle + m.layout.ball(state, ball).arc / m.pitch_radius
}

/// Advances a model with the built-in integrator and passes on the state after each step.
pub fn advance(
    model: &Model,
    state: &[f64],
    (start, end): (f64, f64),
    tolerance: f64,
    mut after: impl FnMut(&dyn Integrator),
) -> Vec<f64> {
    let tolerances = model.mechanism().layout.tolerances(tolerance);
    let mut integrator = DormandPrince::new(model, start, state, tolerances, None);
    while integrator.time() < end {
        integrator.step(end).unwrap();
        after(&integrator);
    }
    integrator.state().to_vec()
}

/// Sum of the magnitudes of some vectors.
pub fn sizes(vectors: &[Vector]) -> f64 {
    vectors.iter().map(|v| raceway::physics::frames::length(*v)).sum()
}
