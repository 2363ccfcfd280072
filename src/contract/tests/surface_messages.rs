//! Messages about the limits of waves and defects, the resonances that they excite, and envelopes at their rates.

use serde_json::{Value, json};

use crate::contract::{Outcome, Simulated, SpectrumKind, execute, parse_job, resolve_answer};
use raceway_core::simulation::input::control::Control;

/// The answer of `resolve` for a 6205 under 500 N at 1797 r/min with further fields of the job.
fn resolved(surfaces: Value, fields: Value) -> Value {
    let mut request = json!({ "kind": "simulation", "duration_s": 1.0, "scene": {
        "bearing": "6205", "operation": { "speed_rpm": 1797, "radial_load_y_n": 500 }, "surfaces": surfaces } });
    for (name, value) in fields.as_object().unwrap() {
        request[name] = value.clone();
    }
    serde_json::to_value(resolve_answer(&parse_job(request.to_string().as_bytes()).unwrap())).unwrap()
}

fn message<'a>(answer: &'a Value, code: &str) -> Option<&'a Value> {
    answer["messages"].as_array().unwrap().iter().find(|message| message["code"] == code)
}

/// Closed form: 5 kg on Z k/2 = 3.791e7 N/m of seven preloaded balls vibrate at 438.2 Hz in any direction.
#[test]
fn a_heavy_spindle_resonates_on_its_preloaded_balls() {
    let request = json!({ "kind": "simulation", "scene": {
        "bearing": { "preset": "article-integrated", "radial_clearance_um": -4 }, "gravity_m_s2": 0,
        "operation": { "speed_rpm": 1000 }, "spindle": { "mass_kg": 5 } } });
    let answer = serde_json::to_value(resolve_answer(&parse_job(request.to_string().as_bytes()).unwrap())).unwrap();
    let found = answer["derived"]["resonances"].as_array().unwrap();
    assert_eq!(found.len(), 2);
    for resonance in found {
        let frequency = resonance["frequency_hz"].as_f64().unwrap();
        assert!((frequency / 438.2 - 1.0).abs() < 1e-3, "{frequency}");
        assert_eq!(resonance["envelope_band_hz"], json!([220.0, 880.0]));
    }
}

/// The default band begins at 2 kHz, above the resonance along the load.
#[test]
fn a_band_without_the_resonance_has_a_message() {
    let spall =
        |azimuth: f64| json!({ "outer": { "defects": [{ "azimuth_deg": azimuth, "length_mm": 1, "depth_um": 50 }] } });
    let answer = resolved(spall(0.0), json!({}));
    let along_load = &answer["derived"]["resonances"][1];
    assert_eq!(along_load["direction"], json!([0.0, 1.0, 0.0]));
    let missed = message(&answer, "missed-resonance").unwrap();
    let ratio = missed["resonance_hz"].as_f64().unwrap() / along_load["frequency_hz"].as_f64().unwrap();
    assert!((ratio - 1.0).abs() < 5e-3, "{ratio}");
    assert!(missed["text"].as_str().unwrap().contains("outputs.envelope_band_hz to [890, 3500]"), "{missed}");
    let band = json!({ "outputs": { "envelope_band_hz": along_load["envelope_band_hz"] } });
    for (surfaces, fields) in [(spall(0.0), band), (spall(180.0), json!({})), (json!({}), json!({}))] {
        assert_eq!(message(&resolved(surfaces, fields), "missed-resonance"), None);
    }
    let inner = json!({ "inner": { "defects": [{ "length_mm": 1, "depth_um": 50 }] } });
    assert!(message(&resolved(inner, json!({})), "missed-resonance").is_some());
}

/// The load zone of 500 N along +Y is centred on 0°.
#[test]
fn a_defect_without_load_has_a_message() {
    let spalls = |azimuths: &[f64]| {
        let spalls = azimuths.iter().map(|azimuth| json!({ "azimuth_deg": azimuth, "length_mm": 1, "depth_um": 50 }));
        json!({ "outer": { "defects": spalls.collect::<Vec<_>>() } })
    };
    let answer = resolved(spalls(&[0.0, 180.0, 170.0]), json!({}));
    let found = message(&answer, "unloaded-defect").unwrap();
    assert_eq!((&found["azimuth_deg"], &found["severity"]), (&json!(180.0), &json!("info")));
    assert!(found["text"].as_str().unwrap().contains("like another one"), "{found}");
    assert_eq!(message(&resolved(spalls(&[0.0]), json!({})), "unloaded-defect"), None);
}

/// A trough of amplitude A and order n is followed while A n² ≤ ½ ρ_x R². The drop of a spall of 1 mm is ρ_x/8 mm².
#[test]
fn troughs_that_a_ball_bridges_have_a_message() {
    let of = |amplitude: f64| {
        let wave = json!([{ "order": 300, "amplitude_nm": amplitude }]);
        let spall = json!([{ "azimuth_deg": 180, "length_mm": 1, "depth_um": 50 }]);
        resolved(json!({ "outer": { "waviness": wave, "defects": spall } }), json!({}))
    };
    let answer = of(1000.0);
    let outer = &answer["derived"]["surfaces"]["outer"];
    let curvature = 8.0 * outer["defects"][0]["edge_drop_um"].as_f64().unwrap();
    let radius = 1e-6 * outer["first_zero_order"].as_f64().unwrap() * outer["half_width_um"].as_f64().unwrap()
        / std::f64::consts::PI;
    let largest = 1e9 * 0.5 * curvature * radius * radius / (300.0 * 300.0);
    let stated = message(&answer, "bridged-troughs").unwrap()["largest_amplitude_nm"].as_f64().unwrap();
    assert!((stated / largest - 1.0).abs() < 5e-3, "{stated} {largest}");
    assert_eq!(message(&of(0.99 * largest), "bridged-troughs"), None);
    assert!(message(&of(1.01 * largest), "bridged-troughs").is_some());
}

/// Waves shorter than the contact, 400 of 20 nm, have 283 nm rms; each keeps less than 0.3 of its height. Long waves of 5 µm are no roughness.
#[test]
fn roughness_above_the_film_has_a_message() {
    let of = |from: u32, to: u32, amplitude: f64| {
        let random = json!({ "amplitude_nm": amplitude, "exponent": 0, "from_order": from, "to_order": to });
        resolved(json!({ "outer": { "random_waviness": random } }), json!({}))
    };
    let rough = of(601, 1000, 20.0);
    let stated = message(&rough, "rough-contact").unwrap();
    let roughness = stated["roughness_nm"].as_f64().unwrap();
    assert!((roughness / 283.0 - 1.0).abs() < 0.03, "{roughness}");
    assert!(stated["film_nm"].as_f64().unwrap() < roughness);
    assert_eq!(message(&of(2, 3, 5000.0), "rough-contact"), None);
}

/// The contact of the outer raceway averages orders beyond 1698 away, three times its first zero of 566; zero amplitudes need no message.
#[test]
fn a_given_wave_that_changes_nothing_has_a_message() {
    let of = |surfaces: Value| resolved(surfaces, json!({}));
    let waves = |orders: &[u32]| -> Value {
        orders.iter().map(|order| json!({ "order": order, "amplitude_nm": 100 })).collect()
    };
    let answer = of(json!({ "outer": { "waviness": waves(&[8, 5000, 6000]) } }));
    let stated = message(&answer, "waves-left-out").unwrap();
    assert_eq!((&stated["order"], &stated["count"], &stated["severity"]), (&json!(5000), &json!(2), &json!("info")));
    let text = stated["text"].as_str().unwrap();
    assert!(text.contains("order 5000 on the outer raceway and 1 more changes nothing: the contact"), "{text}");
    let fast = of(json!({ "inner": { "waviness": waves(&[1450]) } }));
    assert!(message(&fast, "waves-left-out").unwrap()["text"].as_str().unwrap().contains("25600 Hz"), "{fast}");
    let of_ball = of(json!({ "balls": [{ "ball": 2, "waviness": waves(&[50_000]) }] }));
    assert!(message(&of_ball, "waves-left-out").unwrap()["text"].as_str().unwrap().contains("ball 2"), "{of_ball}");
    let silent = json!([{ "order": 5000, "amplitude_nm": 0 }]);
    let drawn = json!({ "amplitude_nm": 1, "to_order": 5000 });
    for surfaces in [json!({ "waviness": waves(&[8]), "random_waviness": drawn }), json!({ "waviness": silent })] {
        assert_eq!(message(&of(json!({ "outer": surfaces })), "waves-left-out"), None);
    }
}

/// The result of a spall of a 6205 under 500 N at 1797 r/min, planar.
fn simulated(outputs: Value) -> Simulated {
    let request = json!({ "kind": "simulation", "settle_s": 0.05, "duration_s": 0.1, "solver": { "rung": "planar" },
        "outputs": outputs, "scene": {
            "bearing": "6205", "operation": { "speed_rpm": 1797, "radial_load_y_n": 500 },
            "surfaces": { "outer": { "defects": [{ "length_mm": 0.6, "depth_um": 50 }] } } } });
    let job = parse_job(request.to_string().as_bytes()).unwrap();
    let Ok(Outcome::Simulation(simulated)) = execute(&job, &Control::until(&|| false)) else {
        panic!("the run failed")
    };
    *simulated
}

/// A point of a study has no spectra, but the same envelope as the simulation with them; its first harmonic is that of the listed line.
#[test]
fn envelopes_at_the_rates_of_defects_are_metrics() {
    let band = json!([890, 3500]);
    let with_lines = simulated(json!({ "metrics": ["vibration"], "envelope_band_hz": band }));
    let point = simulated(json!({ "metrics": ["vibration"], "envelope_band_hz": band, "spectra": [] }));
    let of = |run: &Simulated| serde_json::to_value(&run.metrics).unwrap();
    let (metrics, of_point) = (of(&with_lines), of(&point));
    let channel = "spindle.y.acceleration";
    let envelope = &metrics["channels"][channel]["envelope"];
    assert_eq!(*envelope, of_point["channels"][channel]["envelope"]);
    let lines = metrics["envelope_lines"].as_array().unwrap();
    let listed = lines.iter().find(|line| line["channel"] == channel && line["label"] == "BPFO").unwrap();
    let first = envelope["ball_pass_outer"]["first"].as_f64().unwrap();
    assert!((first / listed["amplitude"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{envelope} {listed}");
    let ratio = first / metrics["channels"][channel]["rms"].as_f64().unwrap();
    assert!((envelope["ball_pass_outer"]["first_over_rms"].as_f64().unwrap() / ratio - 1.0).abs() < 1e-12);
    assert!(envelope["ball_pass_inner"]["first"].as_f64().unwrap() < 0.3 * first);
    assert_eq!(metrics["resonances"].as_array().unwrap().len(), 2);
}

#[test]
fn a_squared_envelope_has_the_square_of_the_unit() {
    let run = simulated(json!({ "envelope_band_hz": [890, 3500], "envelope": "squared" }));
    let units: Vec<&str> = run.spectra.iter().map(|spectrum| spectrum.unit.as_str()).collect();
    assert_eq!(units, ["m/s²", "(m/s²)²"].repeat(2));
    assert!(run.spectra.iter().any(|spectrum| spectrum.kind == SpectrumKind::Envelope));
    assert_eq!(serde_json::to_value(&run.metrics).unwrap()["envelope"], "squared");
}
