//! Local defects of the raceways: the drop between two edges, the places of the impacts, energy, trends of the level with size and place, and
//! lines in spectra.

use std::f64::consts::TAU;

use raceway::numerics::ode::Method;
use raceway::numerics::spectrum::Spectrum;
use raceway::physics::bearing::PerRaceway;
use raceway::physics::surface::SurfaceProfile;
use raceway::physics::surface::defects::Recess;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::Mechanism;
use raceway::simulation::model::surfaces::{AveragedSurface, averaged_surfaces};
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::article_run::{Y, Z, patient};
use crate::scenes::{article, changed, disturbed, model_on, needs, rates, scene};
use crate::waviness::energy_lost;

/// A 6205 under 500 N at 1797 r/min with some surfaces.
pub fn motor(surfaces: Value) -> Value {
    json!({
        "bearing": { "preset": "6205", "radial_clearance_um": 12.5 },
        "operation": { "speed_rpm": 1797, "radial_load_y_n": 500 },
        "spindle": { "mass_kg": 0.673 },
        // About a twentieth of the critical damping of the spindle on its loaded balls.
        "damping": { "raceway": { "law": "viscous", "viscous_n_s_per_m": 600 } },
        "surfaces": surfaces
    })
}

/// A defect over the whole groove at an azimuth.
pub fn defect(azimuth_deg: f64, length_mm: f64, depth_um: f64) -> Value {
    json!({ "azimuth_deg": azimuth_deg, "length_mm": length_mm, "depth_um": depth_um })
}

pub fn on_outer(defect: Value) -> Value {
    json!({ "outer": { "defects": [defect] } })
}

pub fn averaged(json: &Value) -> PerRaceway<AveragedSurface> {
    let scene = scene(json);
    averaged_surfaces(&Mechanism::new(&scene, &needs(&scene, Some(ModelLevel::Planar))), &scene).unwrap()
}

/// ρ_x l²/8 with the curvature of the raceway; that of a flat would give 8.97 and 31.6 µm.
#[test]
fn a_ball_drops_between_two_edges_by_the_curvature_of_its_raceway() {
    for (length, outer, inner) in [(0.5334, 7.44, 11.25), (1.0, 26.2, 39.5)] {
        let both = json!({ "defects": [defect(0.0, length, 100.0)] });
        let found = averaged(&motor(json!({ "inner": both.clone(), "outer": both })));
        for (surface, expected) in [(&found.outer, outer), (&found.inner, inner)] {
            let drop = 1e6 * surface.defects[0].edge_drop();
            assert!((drop / expected - 1.0).abs() < 2e-3, "{length} mm: {drop} µm, expected {expected}");
        }
    }
}

/// Speed of the contact, distance in which the ball reaches the floor, and the place of the strongest upward bend of its path.
#[test]
fn a_ball_that_reaches_the_floor_meets_the_last_edge_before_its_end() {
    for (length, bend_us) in [(1.0, 134.8), (2.0, 418.7), (3.0, 702.7)] {
        let outer = averaged(&motor(on_outer(defect(0.0, length, 10.0)))).outer;
        let mut recess = outer.defects[0];
        // Under 243 N, Stribeck's largest load.
        recess.contact.half_width *= (243.0 / outer.load).cbrt();
        assert!((recess.contact.speed - 1.7607).abs() < 2e-3, "{}", recess.contact.speed);
        assert!((1e3 * recess.floor_distance() - 0.309).abs() < 1e-3, "{}", recess.floor_distance());
        let spacing = recess.contact.half_width / 8.0;
        let bend = |x: f64| [-1.0, 0.0, 1.0].map(|by| recess.height(x + by * spacing, 0.0));
        let places = (0..4000).map(|step| f64::from(step) * 1e-6);
        let strongest = |x: &f64| {
            let [before, at, behind] = bend(*x);
            before - 2.0 * at + behind
        };
        let at = places.max_by(|a, b| strongest(a).total_cmp(&strongest(b))).unwrap();
        let time = 1e6 * at / recess.contact.speed;
        assert!((time - bend_us).abs() < 1.0, "{length} mm: {time} µs after the middle, expected {bend_us}");
        assert!((1e6 * recess.impact_beside_middle() - bend_us).abs() < 1.0);
        let to_middle = 5e2 * length / recess.contact.speed;
        assert!((1e6 * recess.entry_to_impact() - to_middle - bend_us).abs() < 1.0);
    }
}

/// A slot of 0.3 of the contact's width keeps the ball above a floor that a wide one lets it reach. The ground beside it then carries the ball.
#[test]
fn a_narrow_defect_keeps_the_ball_from_its_floor() {
    let outer = averaged(&motor(on_outer(defect(0.0, 1.0, 10.0)))).outer;
    let wide = outer.defects[0];
    let of = |share: f64| {
        let mut recess = wide;
        recess.defect.width = Some(2.0 * share * wide.contact.semi_major);
        recess
    };
    // W = δ₀ (w/2a)^1.65, S = w/2a.
    let expected = (2.0 * wide.contact.approach * 0.3_f64.powf(0.65) / wide.contact.curvature).sqrt();
    let narrow = of(0.3);
    assert!((narrow.floor_distance() / expected - 1.0).abs() < 1e-6, "{}", narrow.floor_distance());
    assert!(wide.is_bottomed() && of(5.0).is_bottomed() && !narrow.is_bottomed());
    assert!(narrow.impact_beside_middle() > wide.impact_beside_middle());
}

/// A ball without damping and friction rolls twice over an outer defect, shallow enough for it to follow. Its energy is kept to 1e-8 of the
/// elastic energy. Without the lean force, which draws it into the defect and holds it back, it is not.
#[test]
fn the_lean_force_keeps_the_energy_of_a_ball_over_a_defect() {
    let mut shallow = defect(90.0, 1.0, 0.3);
    shallow["shape"] = json!("half_sine");
    let json = changed(article(), json!({ "surfaces": on_outer(shallow) }));
    let recess: Recess = averaged(&json).outer.defects[0];
    let lost = |lean: f64| energy_lost(SurfaceProfile::new(&[], &[recess], true), lean);
    let (with, without) = (lost(1.0), lost(0.0));
    assert!(with < 1e-8 && without > 0.1, "{with:e} {without}");
}

/// No depth is the ideal run to the bit; a depth of 1e-9 µm changes loads by no more than that.
#[test]
fn a_defect_without_depth_is_ideal() {
    let of = |depth: f64, rung: ModelLevel| {
        model_on(&changed(article(), json!({ "surfaces": on_outer(defect(1.0, 0.5, depth)) })), Some(rung))
    };
    for rung in [ModelLevel::Full, ModelLevel::Planar] {
        let ideal = model_on(&article(), Some(rung));
        let state = disturbed(&ideal, 4);
        let expected = rates(&ideal, 0.0, &state);
        assert_eq!(rates(&of(0.0, rung), 0.0, &state), expected);
        let (small, deep) = (rates(&of(1e-9, rung), 0.0, &state), rates(&of(1.0, rung), 0.0, &state));
        let largest = |rates: &[f64]| {
            rates.iter().zip(&expected).map(|(a, b)| (a - b).abs() / (1.0 + b.abs())).fold(0.0, f64::max)
        };
        assert!(largest(&small) < 1e-6 && largest(&deep) > 1e-3, "{} {}", largest(&small), largest(&deep));
    }
}

/// Settings of a run of the planar model.
fn settings(method: Method, relative_tolerance: f64, [settle, duration]: [f64; 2]) -> RunSettings {
    RunSettings {
        method,
        rung: Some(ModelLevel::Planar),
        relative_tolerance,
        tightened: None,
        model_tolerance_db: 0.05,
        fixed_step: None,
        settle,
        duration,
        outputs: Outputs { spectra: vec![Y, Z], ..Outputs::vibration() },
    }
}

/// A run in fixed steps after 50 ms of settling.
pub fn run(json: &Value, duration: f64) -> RunResult {
    let settings = RunSettings { fixed_step: Some(5e-6), ..settings(Method::SemiImplicit, 1e-5, [0.05, duration]) };
    simulate(&scene(json), &settings, &patient()).unwrap()
}

/// Level of the acceleration along the load under error control [dB].
fn level(json: &Value, settings: &RunSettings) -> f64 {
    let result = simulate(&scene(json), settings, &patient()).unwrap();
    result.summary.channels.iter().find(|(channel, _)| *channel == Y).unwrap().1.level_db.unwrap()
}

/// Rms of the acceleration along the load [m/s²] and its kurtosis.
fn rms_and_kurtosis(surfaces: Value) -> (f64, f64) {
    let result = run(&motor(surfaces), 0.2);
    let (_, metrics) = result.summary.channels.iter().find(|(channel, _)| *channel == Y).unwrap();
    (metrics.rms, metrics.kurtosis.unwrap())
}

pub fn assert_near(what: &str, found: f64, expected: f64, share: f64) {
    assert!((found / expected - 1.0).abs() < share, "{what}: {found}, expected {expected}");
}

/// Longer defects are louder until the ball meets the floor. Then the level stays and the kurtosis falls. Levels [m/s²] of a spindle on
/// massless balls with a damper of its own, ζ = 0.05, by a separate program.
#[test]
fn levels_grow_with_the_length_until_the_ball_meets_the_floor() {
    let lengths = [(0.178, 13.0), (0.356, 56.0), (0.533, 132.0), (1.0, 166.0), (2.0, 164.0), (3.0, 161.0)];
    let kurtoses = lengths.map(|(length, expected)| {
        let (rms, kurtosis) = rms_and_kurtosis(on_outer(defect(0.0, length, 10.0)));
        assert_near(&format!("rms at {length} mm"), rms, expected, 0.15);
        kurtosis
    });
    assert!(kurtoses.is_sorted_by(|one, next| one > next), "{kurtoses:?}");
    assert_near("kurtosis of the shortest", kurtoses[0], 6.8, 0.15);
    assert_near("kurtosis of the longest", kurtoses[5], 4.1, 0.15);
}

/// A half sine is quieter than a rectangle, and the load zone decides. Ratios of the same program.
#[test]
fn shape_and_place_decide_the_level() {
    let rms = |surfaces: Value| rms_and_kurtosis(surfaces).0;
    let shaped = |length: f64, depth: f64, shape: &str| {
        let mut defect = defect(0.0, length, depth);
        defect["shape"] = json!(shape);
        rms(on_outer(defect))
    };
    let (long, half_sine) = (shaped(2.0, 10.0, "rectangular"), shaped(2.0, 10.0, "half_sine"));
    assert_near("half sine of 2 mm", half_sine / long, 66.0 / 164.0, 0.3);
    let (short, short_sine) = (shaped(0.533, 2.0, "rectangular"), shaped(0.533, 2.0, "half_sine"));
    assert_near("half sine of 0.533 mm", short_sine / short, 41.0 / 50.0, 0.3);
    assert_near("0.533 mm, 2 µm", short / long, 50.0 / 164.0, 0.3);
    let ideal = rms(json!({}));
    for azimuth in [90.0, 180.0] {
        let away = rms(on_outer(defect(azimuth, 2.0, 10.0)));
        let added = (away * away - ideal * ideal).max(0.0).sqrt();
        assert!(added < 0.01 * long, "{azimuth}°: {away}, ideal {ideal}, in the load {long}");
    }
    // A drilled hole of 0.533 mm under an ellipse of 1.33 mm is felt as a fifth of the slot.
    let hole = rms(on_outer(json!({ "length_mm": 0.533, "width_mm": 0.533, "depth_um": 280 })));
    let slot = rms(on_outer(defect(0.0, 0.533, 280.0)));
    assert_near("drilled hole", hole / slot, 0.2, 0.3);
}

/// Largest amplitude within a bin of a frequency.
pub fn line(spectrum: &Spectrum, frequency: f64) -> f64 {
    let bin = (frequency / spectrum.resolution).round() as usize;
    spectrum.amplitude[bin - 1..=bin + 1].iter().copied().fold(0.0, f64::max)
}

/// An outer defect sounds at harmonics of BPFO, an inner one at BPFI with sidebands of the shaft, in lines and envelope.
#[test]
fn defects_have_their_lines() {
    let surfaces = [on_outer(defect(0.0, 0.533, 10.0)), json!({ "inner": { "defects": [defect(0.0, 0.533, 10.0)] } })];
    let [outer, inner] = surfaces.map(|surfaces| run(&motor(surfaces), 0.5));
    let strongest = |result: &RunResult| -> Vec<String> {
        let of_y = result.summary.lines.iter().filter(|(channel, _)| *channel == Y);
        of_y.take(10).map(|(_, line)| line.label.clone()).collect()
    };
    assert!(strongest(&outer).iter().all(|label| label.ends_with("·BPFO")), "{:?}", strongest(&outer));
    assert!(strongest(&inner).iter().all(|label| label.contains("BPFI")), "{:?}", strongest(&inner));
    let f = inner.summary.frequencies;
    let envelope = &inner.spectra.iter().find(|spectra| spectra.channel == Y).unwrap().envelope;
    let [shaft, below, passage, above] =
        [f.shaft, f.ball_pass_inner - f.shaft, f.ball_pass_inner, f.ball_pass_inner + f.shaft]
            .map(|at| line(envelope, at));
    assert_near("f_r over BPFI", shaft / passage, 1.9, 0.3);
    assert_near("BPFI − f_r over BPFI", below / passage, 1.05, 0.3);
    assert_near("BPFI + f_r over BPFI", above / passage, 0.8, 0.3);
    let f = outer.summary.frequencies;
    let envelope = &outer.spectra.iter().find(|spectra| spectra.channel == Y).unwrap().envelope;
    let beside = line(envelope, f.ball_pass_outer + f.shaft);
    assert!(line(envelope, f.ball_pass_outer) > 100.0 * beside, "{} {beside}", line(envelope, f.ball_pass_outer));
}

/// Balls pass 1 mm at the speed of their contact, with the distance of two balls between them. In the load zone they leave the raceways for
/// some of the time; on ideal raceways nothing of this is stated.
#[test]
fn flights_and_passages_of_a_spall_are_recorded() {
    let contacts = |surfaces: Value, rung: ModelLevel| {
        let basis = settings(Method::SemiImplicit, 1e-5, [0.05, 0.1]);
        let outputs = Outputs { contacts: true, ..basis.outputs.clone() };
        let settings = RunSettings { fixed_step: Some(5e-6), rung: Some(rung), outputs, ..basis };
        // The damping of the trends is so strong that no ball flies.
        let mut motor = motor(surfaces);
        motor.as_object_mut().unwrap().remove("damping");
        let result = simulate(&scene(&motor), &settings, &patient()).unwrap();
        (
            result.summary.contacts.unwrap().raceway.map(|raceway| raceway.off),
            result.plot_data.impact,
            result.summary.frequencies,
        )
    };
    let (off, impact, f) = contacts(on_outer(defect(0.0, 1.0, 10.0)), ModelLevel::Planar);
    let (inner, outer) = (off.inner.unwrap(), off.outer.unwrap());
    assert!(inner.mean > 1e-3 && inner.mean < 0.05 && inner.largest >= inner.mean, "{inner:?}");
    assert!(outer.mean < inner.mean, "{outer:?} {inner:?}");
    let impact = impact.unwrap();
    assert!((3..=4).contains(&impact.passages.len()), "{:?}", impact.passages);
    for passage in &impact.passages {
        assert_near("time over the spall", passage.exit - passage.entry, 1e-3 / 1.7607, 0.02);
    }
    for pair in impact.passages.windows(2) {
        assert_near("time between balls", pair[1].entry - pair[0].entry, 1.0 / f.ball_pass_outer, 0.02);
    }
    let (ideal, none, _) = contacts(json!({}), ModelLevel::Planar);
    assert!(ideal.inner.is_none() && ideal.outer.is_none() && none.is_none());
    let waves = json!({ "outer": { "waviness": [{ "order": 10, "amplitude_nm": 10 }] } });
    let (off, impact, _) = contacts(waves, ModelLevel::Planar);
    assert!(off.inner.is_some_and(|off| off.largest == 0.0) && impact.is_none(), "{off:?}");
}

/// Error control ends steps at the entry: a short defect between long steps is felt alike by every method.
#[test]
fn no_method_steps_over_a_defect() {
    let json = changed(
        article(),
        json!({
            "operation": { "speed_rpm": 3000, "radial_load_y_n": 30 },
            "surfaces": on_outer(defect(40.0, 0.1, 3.0))
        }),
    );
    let level = |method: Method, tolerance: f64| level(&json, &settings(method, tolerance, [0.02, 0.1]));
    let loose = [Method::Gear, Method::Radau].map(|method| level(method, 1e-3));
    let exact = level(Method::DormandPrince, 1e-7);
    for level in loose {
        assert!((level - exact).abs() < 0.5, "{loose:?} {exact}");
    }
}

/// Slots shorter than the contact, spalls of a millimetre's depth, a spall under two balls, and a ball that flies out of a spall: finite
/// levels.
#[test]
fn extreme_defects_end_in_a_finite_answer() {
    for (name, length, depth) in
        [("short", 0.01, 1000.0), ("shallow", 0.05, 0.1), ("deep", 5.0, 1000.0), ("under two balls", 20.0, 30.0)]
    {
        let (rms, kurtosis) = rms_and_kurtosis(on_outer(defect(10.0, length, depth)));
        assert!(rms.is_finite() && rms > 0.0 && kurtosis > 1.0, "{name}: {rms} {kurtosis}");
    }
    let pitch = TAU * 23.5 / 9.0;
    assert!(20.0 > pitch, "longer than the distance of two balls on the raceway, {pitch} mm");
}

/// At 500 000 r/min a ball flies over a deep spall of the article's bearing: explicit and implicit steps agree.
#[test]
fn a_ball_jumps_out_of_a_spall_at_the_highest_speed() {
    let json = changed(
        article(),
        json!({ "operation": { "speed_rpm": 500_000 }, "surfaces": on_outer(defect(10.0, 0.5, 1000.0)) }),
    );
    let level = |method: Method| level(&json, &settings(method, 1e-5, [1e-3, 2e-3]));
    let (explicit, implicit) = (level(Method::DormandPrince), level(Method::Gear));
    assert!((explicit - implicit).abs() < 0.5 && explicit > 80.0, "{explicit} {implicit} dB");
}
