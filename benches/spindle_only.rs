//! Rung 3, the spindle alone, against the full dynamics: error in dB of the levels of y and z, and run time over steps.
//!
//! `cargo bench --bench spindle_only -- reference FILE` runs the full dynamics once (minutes to an hour) and keeps their levels.

use std::fmt::Write as _;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::Method;
use raceway::simulation::channel::{Axis, Channel, Motion};
use raceway::simulation::metrics::channel_metrics;
use raceway::simulation::model::Model;
use raceway::simulation::needs::Needs;
use raceway::simulation::observe::{Observer, RATE, Recording};
use raceway::simulation::run::{Outputs, RunSettings, Rung, start_state};
use raceway::simulation::scene::Scene;
use serde_json::json;

/// Diametral clearance [µm], radial load [N], speed [1000 r/min], balls, spindle [g].
const SCENES: [(f64, f64, f64, u32, f64); 18] = [
    (5.0, 200.0, 50.0, 7, 50.0),
    (2.0, 200.0, 50.0, 7, 50.0),
    (10.0, 200.0, 50.0, 7, 50.0),
    (5.0, 50.0, 50.0, 7, 50.0),
    (5.0, 100.0, 50.0, 7, 50.0),
    (5.0, 400.0, 50.0, 7, 50.0),
    (5.0, 200.0, 10.0, 7, 50.0),
    (5.0, 200.0, 20.0, 7, 50.0),
    (5.0, 200.0, 30.0, 7, 50.0),
    (5.0, 200.0, 40.0, 7, 50.0),
    (5.0, 200.0, 60.0, 7, 50.0),
    (5.0, 200.0, 50.0, 6, 50.0),
    (5.0, 200.0, 50.0, 8, 50.0),
    (5.0, 200.0, 50.0, 9, 50.0),
    (5.0, 200.0, 50.0, 7, 75.0),
    (5.0, 200.0, 50.0, 7, 100.0),
    (2.0, 400.0, 30.0, 8, 50.0),
    (10.0, 400.0, 20.0, 7, 75.0),
];
const WINDOWS: usize = 4;
const WINDOW: f64 = 0.1;
const SETTLE: f64 = 0.06;
const TOLERANCE: f64 = 1e-7;

fn scene((clearance, load, speed, balls, mass): (f64, f64, f64, u32, f64)) -> Scene {
    let json = json!({
        "bearing": { "preset": "article-integrated", "ball_count": balls, "radial_clearance_um": clearance },
        "spindle": { "mass_kg": 1e-3 * mass },
        "operation": { "speed_rpm": 1e3 * speed, "radial_load_y_n": load }
    });
    scene_from_json(&json.to_string()).expect("a scene")
}

fn settings(duration: f64) -> RunSettings {
    RunSettings {
        method: Method::Auto,
        rung: None,
        relative_tolerance: TOLERANCE,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: SETTLE,
        duration,
        outputs: Outputs { vibration: true, contacts: false, cage: false, spectra: Vec::new(), series: Vec::new() },
    }
}

/// rms of a_y, a_z [m/s²], v_y, v_z [mm/s], 0–20 kHz, of a stretch of a recording.
fn levels(recording: &Recording, window: usize) -> [f64; 4] {
    let length = (WINDOW * RATE).round() as usize;
    [
        (Axis::Y, Motion::Acceleration),
        (Axis::Z, Motion::Acceleration),
        (Axis::Y, Motion::Velocity),
        (Axis::Z, Motion::Velocity),
    ]
    .map(|(axis, motion)| {
        let channel = Channel::Spindle(axis, motion);
        let signal = recording.signal(channel).expect("always kept");
        channel_metrics(channel, &signal[window * length..(window + 1) * length], 0.0).rms
    })
}

fn reference(file: &str) {
    for parameters in SCENES {
        let scene = scene(parameters);
        let settings = settings(WINDOWS as f64 * WINDOW);
        let needs = Needs::of(&scene, &settings.outputs, Some(Rung::Full)).expect("full serves all");
        let model = Model::new(&scene, &needs);
        let start = start_state(&model).expect("an equilibrium");
        let mut observer = Observer::new(&model, &needs, &settings);
        let tolerances = model.mechanism().layout.tolerances(TOLERANCE);
        let begin = std::time::Instant::now();
        let mut integrator = settings.method.start(&model, 0.0, &start, tolerances, None);
        while integrator.time() < observer.end() {
            integrator.step(observer.end()).expect("runs through");
            observer.after(integrator.as_ref());
        }
        let recording = observer.finish();
        let mut line = format!("{parameters:?} cage {:.9}", recording.cage_speed / recording.shaft_speed);
        for window in 0..WINDOWS {
            for level in levels(&recording, window) {
                let _ = write!(line, " {level:.9e}");
            }
        }
        println!("{line} {:.1} s {:?}", begin.elapsed().as_secs_f64(), integrator.choice().method);
        let mut all = std::fs::read_to_string(file).unwrap_or_default();
        all += &line;
        all += "\n";
        std::fs::write(file, all).expect("can be written");
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    if let [word, file] = &arguments[..]
        && word == "reference"
    {
        reference(file);
    }
}
