//! Orders of the characteristic frequencies, by formula and from a simulated run.

use std::f64::consts::TAU;

use raceway::numerics::ode::Method;
use raceway::physics::bearing::Bearing;
use raceway::physics::kinematics::ideal_frequencies;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::loaded_frequencies::loaded_frequencies;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::distribution::{needs, scene};
use crate::table::check;

const INCH: f64 = 25.4;

fn bearing(balls: u32, diameter: f64, pitch: f64) -> Value {
    json!({
        "type": "deep_groove", "outer_diameter_mm": pitch + 1.8 * diameter, "inner_diameter_mm": pitch - 1.8 * diameter,
        "width_mm": 15, "ball_count": balls, "ball_diameter_mm": diameter, "pitch_diameter_mm": pitch,
        "inner_groove_curvature": 0.52, "outer_groove_curvature": 0.53, "radial_clearance_um": 12.5
    })
}

fn drive_end() -> Value {
    bearing(9, 0.3126 * INCH, 1.537 * INCH)
}

/// BPFO, BPFI, FTF and 2·BSF over the shaft frequency.
fn orders(bearing: &Bearing) -> [f64; 4] {
    let at = ideal_frequencies(bearing, TAU);
    [at.ball_pass_outer, at.ball_pass_inner, at.cage, 2.0 * at.ball_spin]
}

#[test]
fn case_western() {
    check("orders-6205", &orders(&scene(&json!({ "bearing": drive_end() })).bearing));
    let fan_end = scene(&json!({ "bearing": bearing(8, 0.2656 * INCH, 1.122 * INCH) })).bearing;
    check("orders-6203", &orders(&fan_end)[..3]);
}

/// FTF and BPFO [Hz] of a 6205 at 3000 r/min and the loaded contact angles: each for inner and outer control.
#[test]
fn loaded_angles() {
    for (case, load) in [("loaded-50", 50), ("loaded-200", 200), ("loaded-1000", 1000), ("loaded-3000", 3000)] {
        let scene = scene(&json!({
            "bearing": "6205", "operation": { "speed_rpm": 3000, "radial_load_y_n": 20, "axial_load_n": load },
            "gravity_m_s2": 0
        }));
        let found = loaded_frequencies(&scene, &needs(&scene)).unwrap().unwrap();
        let (inner, outer) = (found.inner_control, found.outer_control);
        check(case, &[inner.cage, outer.cage, inner.ball_pass_outer, outer.ball_pass_outer]);
    }
}

/// Strongest line along Z and mean cage speed of a run, both over the shaft frequency.
#[test]
fn simulated() {
    let scene = scene(&json!({
        "bearing": drive_end(), "operation": { "speed_rpm": 12_000, "radial_load_y_n": 500 }
    }));
    let channel = Channel::Spindle(Axis::Z, Motion::Acceleration);
    let settings = RunSettings {
        method: Method::Auto,
        rung: Some(ModelLevel::RadiallyCondensed),
        relative_tolerance: 1e-5,
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: 0.05,
        duration: 0.2,
        outputs: Outputs { cage: true, spectra: vec![channel], ..Outputs::vibration() },
    };
    let result = simulate(&scene, &settings, &Control::until(&|| false)).unwrap();
    let strongest = result.summary.lines.iter().find(|(of, line)| *of == channel && line.label == "BPFO");
    let frequency = strongest.unwrap_or_else(|| panic!("{:?}", result.summary.lines)).1.frequency;
    let shaft = result.summary.frequencies.shaft;
    check("simulated-6205", &[frequency / shaft, result.summary.frequencies.cage / shaft]);
}
