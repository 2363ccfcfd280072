//! Bearings by designation, clearances by group, oils by grade.

use serde_json::{Value, json};

use crate::contract::scene::catalogue::{CatalogueSearch, ConfidenceName, catalogue_answer};
use crate::contract::{Refusal, ResolveAnswer, parse_job, parse_scene_request, resolve_answer};
use raceway_core::physics::catalogue;
use raceway_core::physics::rating::dynamic_load_rating;

fn request(bearing: &Value, lubricant: &Value) -> Value {
    json!({"scene": {"bearing": bearing, "lubricant": lubricant,
        "operation": {"speed_rpm": 3000, "radial_load_y_n": 100, "axial_load_n": 20}}})
}

fn resolved(bearing: &Value, lubricant: &Value) -> ResolveAnswer {
    let body = request(bearing, lubricant).to_string();
    let job = parse_scene_request(body.as_bytes()).unwrap_or_else(|refusal| panic!("{body}: {refusal}"));
    resolve_answer(&job).unwrap()
}

fn bearing(bearing: Value) -> ResolveAnswer {
    resolved(&bearing, &json!("grease"))
}

fn lubricant(lubricant: Value) -> ResolveAnswer {
    resolved(&json!("6205"), &lubricant)
}

/// The errors of a scene, each as pointer and text.
fn refused(bearing: Value, lubricant: Value) -> Vec<String> {
    match parse_scene_request(request(&bearing, &lubricant).to_string().as_bytes()) {
        Err(Refusal::Invalid { errors }) => {
            errors.iter().map(|error| format!("{}: {}", error.pointer, error.detail)).collect()
        }
        other => panic!("{bearing}: {:?}", other.map(|_| "a job")),
    }
}

fn assert_refused(bearing: Value, lubricant: Value, begin: &str, part: &str) {
    let errors = refused(bearing, lubricant);
    let is_it = |error: &String| error.starts_with(&format!("/scene/{begin}: ")) && error.contains(part);
    assert!(errors.len() == 1 && errors.iter().all(is_it), "{errors:?}");
}

fn assert_close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} instead of {expected}");
}

#[test]
fn every_designation_is_a_bearing() {
    for one in catalogue::bearings() {
        let body = request(&json!(one.designation), &json!("grease")).to_string();
        let job =
            parse_scene_request(body.as_bytes()).unwrap_or_else(|refusal| panic!("{}: {refusal}", one.designation));
        let bearing = &job.scene().unwrap().bearing;
        assert_close(dynamic_load_rating(bearing) / one.rating_kn / 1e3, 1.0, 1e-3);
        if one.contact_angle_deg > 0.0 {
            assert_close(bearing.free_contact_angle.to_degrees(), one.contact_angle_deg, 1e-9);
        }
    }
    let derived = bearing(json!("6309")).derived;
    let designation = derived.designation.unwrap();
    assert_eq!((designation.source.as_str(), designation.confidence), ("ratings JTEKT", ConfidenceName::Medium));
    assert!(designation.note.contains("17.462"));
}

#[test]
fn presets_keep_their_numbers() {
    let ball = |name: &str| bearing(json!(name)).scene["bearing"]["ball_diameter_mm"].clone();
    assert_eq!(ball("6205"), 7.94004);
    assert_eq!(ball("6205-2RS"), 7.94004);
    assert_eq!(ball("6203"), 6.746);
    assert_eq!(ball("6207"), 11.112);
    let [plain, sealed] = ["6205", "6205-2RS"].map(|name| bearing(json!(name)).scene);
    assert_eq!(plain, sealed);
}

#[test]
fn a_designation_shows_its_assumptions() {
    let answer = bearing(json!({"preset": "7008C/P4", "cage": {"mass_g": 20}}));
    assert_eq!(answer.scene["bearing"]["type"], "angular_contact");
    assert_eq!(answer.scene["bearing"]["contact_angle_deg"], 15.0);
    let designation = answer.derived.designation.unwrap();
    assert_eq!((designation.designation.as_str(), designation.suffixes[0].suffix.as_str()), ("7008C", "P4"));
    let assumed = |field: &str| designation.assumptions.contains(&format!("/scene/bearing/{field}"));
    assert!(assumed("inner_groove_curvature") && assumed("cage/pocket_clearance_mm") && assumed("materials/ball"));
    assert!(!assumed("ball_count") && !assumed("contact_angle_deg") && !assumed("cage/mass_g"));
}

#[test]
fn unknown_designations_are_refused() {
    let grease = || json!("grease");
    assert_refused(json!({"preset": "7206"}), grease(), "bearing/preset", "`7206A`, `7206B`, `7206C`");
    assert_refused(json!("6206-NR"), grease(), "bearing", "unknown suffix `NR` of 6206");
    assert_refused(json!("6206C3/C4"), grease(), "bearing", "two clearance groups");
}

/// 6205 with 8 µm on a solid shaft: C3 has 13 to 28 µm, and 0.804 of the interference is lost.
#[test]
fn clearance_is_the_group_less_fit_and_temperature() {
    let answer =
        bearing(json!({"preset": "6205", "radial_clearance_group": "C3", "fits": {"shaft_interference_um": 10},
        "temperatures": {"inner_ring_c": 30, "balls_c": 20}}));
    let clearance = answer.derived.clearance.unwrap();
    assert_eq!((clearance.limits_um, clearance.unmounted_um), ([13.0, 28.0], 20.5));
    assert_close(clearance.shaft_fit_um, 8.04, 0.005);
    assert_close(clearance.temperature_um, 3.58, 0.005);
    assert_eq!(clearance.housing_fit_um, 0.0);
    assert_close(clearance.operating_um, 20.5 - 8.04 - 3.58, 0.01);
    assert_eq!(answer.scene["bearing"]["radial_clearance_um"], clearance.operating_um);
    assert!(answer.defaults.contains(&"/scene/bearing/radial_clearance_um".to_owned()));
    assert_eq!(answer.derived.radial_clearance_um, clearance.operating_um);
    assert!(answer.warnings.is_empty(), "{:?}", answer.warnings);
}

/// 6205 on k5 in N7: shaft +2 to +11 µm, bore −10 to 0 µm, housing −39 to −9 µm, outside −13 to 0 µm.
#[test]
fn fits_go_by_tolerance_class() {
    let with = |fits: Value| {
        let given = json!({"preset": "6205", "radial_clearance_group": "C3", "fits": fits});
        let answer = bearing(given);
        let clearance = answer.derived.clearance.unwrap();
        assert_eq!(answer.warnings.len(), usize::from(clearance.operating_um < 0.0), "{:?}", answer.warnings);
        clearance
    };
    let named = with(json!({"shaft": "k5", "housing": "N7"}));
    let shaft = named.shaft.unwrap();
    assert_eq!((shaft.class.as_str(), shaft.limits_um, shaft.ring_limits_um), ("k5", [2.0, 11.0], [-10.0, 0.0]));
    assert_eq!((shaft.interference_um, named.housing.unwrap().interference_um), (6.5 + 5.0, 24.0 - 6.5));
    assert!(shaft.assumption.contains("middles of both tolerance fields") && shaft.assumption.contains("ISO 492"));
    assert_close(named.shaft_fit_um, 0.804 * 11.5, 0.01);
    let given = with(json!({"shaft_interference_um": 11.5, "housing_interference_um": 17.5}));
    assert_eq!((named.shaft_fit_um, named.housing_fit_um), (given.shaft_fit_um, given.housing_fit_um));
    assert_eq!((named.operating_um, given.shaft), (given.operating_um, None));
    let loose = with(json!({"shaft": "g6", "housing": "H7"}));
    assert_eq!(loose.housing.unwrap().interference_um, -15.0 - 6.5);
    assert_eq!((loose.shaft_fit_um, loose.housing_fit_um, loose.operating_um), (0.0, 0.0, 20.5));
}

#[test]
fn a_group_without_fits_warns() {
    for name in [json!({"preset": "6205", "radial_clearance_group": "C3"}), json!("6205/C3")] {
        let answer = bearing(name);
        assert_eq!(answer.scene["bearing"]["radial_clearance_um"], 20.5);
        assert_eq!(answer.warnings.len(), 1);
        assert_eq!(answer.warnings[0].pointer, "/scene/bearing/radial_clearance_group");
    }
    let sizes_only = bearing(json!({"preset": "6205/C3", "fits": {"shaft_bore_mm": 5}}));
    assert!(sizes_only.warnings[0].detail.contains("give `fits`"), "{:?}", sizes_only.warnings);
}

/// The normal group of a 6205 has 12.5 µm, and a seat with 20 µm of interference takes 16.1 µm.
#[test]
fn a_clearance_below_zero_warns() {
    let answer = bearing(json!({"preset": "6205/CN", "fits": {"shaft_interference_um": 20}}));
    let [warning] = &answer.warnings[..] else { panic!("one warning: {:?}", answer.warnings) };
    assert_eq!(warning.pointer, "/scene/bearing/radial_clearance_group");
    assert!(warning.detail.contains("CN, 12.5 µm, is -3.58 µm in operation"), "{}", warning.detail);
}

#[test]
fn fits_are_those_of_deep_groove_bearings() {
    let fits = json!({"shaft": "k5"});
    assert_refused(json!({"preset": "7008C", "fits": fits}), json!("grease"), "bearing/fits", "leave it out");
    let given = json!({"preset": "6205", "radial_clearance_um": 5, "fits": fits});
    assert_refused(given, json!("grease"), "bearing/fits", "give radial_clearance_group, too");
}

/// Groups over 24 to 30 mm, and the middle of CN is the default.
#[test]
fn groups_have_their_middles() {
    let clearance = |group: &str| {
        let given = json!({"preset": "6205", "radial_clearance_group": group});
        bearing(given).scene["bearing"]["radial_clearance_um"].as_f64().unwrap()
    };
    assert_eq!(["C2", "CN", "C3", "C4", "C5"].map(clearance), [6.0, 12.5, 20.5, 32.0, 41.5]);
    for one in catalogue::bearings().iter().filter(|one| one.contact_angle_deg == 0.0) {
        let clearance = |bearing: Value| {
            let body = request(&bearing, &json!("grease")).to_string();
            parse_scene_request(body.as_bytes()).unwrap().scene().unwrap().bearing.radial_clearance
        };
        let group = clearance(json!({"preset": one.designation, "radial_clearance_group": "CN"}));
        assert_eq!(group, clearance(json!(one.designation)), "{}", one.designation);
    }
}

#[test]
fn hybrid_balls_expand_less() {
    let loss = |balls: &str| {
        let given = json!({"preset": "6205", "radial_clearance_group": "C3", "materials": {"ball": balls},
            "temperatures": {"inner_ring_c": 70, "balls_c": 70, "outer_ring_c": 70}});
        bearing(given).derived.clearance.unwrap().temperature_um
    };
    assert_close(loss("gcr15"), 0.0, 0.02);
    assert_close(loss("gcr15") - loss("si3n4"), 2.0 * (11.5 - 3.2) * 1e-3 * 50.0 * 7.94004, 1e-3);
}

#[test]
fn groups_that_do_not_fit_are_refused() {
    let of = |fields: Value| {
        let mut bearing = json!({"preset": "6205"});
        bearing.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        bearing
    };
    let check = |bearing: Value, field: &str, part: &str| {
        assert_refused(bearing, json!("grease"), &format!("bearing/{field}"), part);
    };
    let group = "radial_clearance_group";
    check(of(json!({group: "C3", "radial_clearance_um": 10})), group, "give either");
    check(of(json!({group: "C3", "contact_angle_deg": 10})), group, "give either");
    check(of(json!({group: "MC3"})), group, "MC3 is for bores below 10 mm, this one has 25 mm");
    check(json!({"preset": "7008C", group: "C3"}), group, "give contact_angle_deg");
    check(json!({"preset": "608", "inner_diameter_mm": 2, group: "C3"}), group, "MC1 to MC6");
    check(of(json!({"fits": {"shaft_interference_um": 10}})), "fits", "give radial_clearance_group");
    check(of(json!({"temperatures": {"inner_ring_c": 50}})), "temperatures", "give radial_clearance_group");
    let with = |fits: Value| of(json!({group: "C3", "fits": fits}));
    check(with(json!({"shaft_interference_um": 2000})), "fits/shaft_interference_um", "from -1000 to 1000 µm");
    check(with(json!({"shaft_bore_mm": 25})), "fits/shaft_bore_mm", "must be below the bore, 25 mm");
    check(
        with(json!({"shaft": "k5", "shaft_interference_um": 5})),
        "fits/shaft",
        "either shaft or shaft_interference_um",
    );
    let both = json!({"housing": "H7", "housing_interference_um": 5});
    check(with(both), "fits/housing", "either housing or housing_interference_um");
    check(with(json!({"shaft": "K5"})), "fits/shaft", "unknown class `K5`; known are `g6`, `h5`");
    check(with(json!({"housing": "h7"})), "fits/housing", "unknown class `h7`; known are `G7`, `H6`");
    check(with(json!({"shaft": 5})), "fits/shaft", "string");
    let large = json!({"preset": "6205", group: "C3", "outer_diameter_mm": 600, "fits": {"housing": "H7"}});
    check(large, "fits/housing", "H7 is for sizes above 0 up to 400 mm, the outer diameter has 600 mm");
    let housing = "fits/housing_outer_diameter_mm";
    check(with(json!({"housing_outer_diameter_mm": 52})), housing, "above the outer diameter of the bearing, 52 mm");
    let hot = of(json!({group: "C3", "temperatures": {"balls_c": 1000}}));
    check(hot, "temperatures/balls_c", "from -100 to 400 °C");
    assert_eq!(bearing(json!({"preset": "608", group: "MC3"})).scene["bearing"]["radial_clearance_um"], 7.5);
}

/// VG 46 at 80 °C: 10.89 mm²/s, 827.75 kg/m³, 1.52e-8 per Pa.
#[test]
fn an_oil_has_the_viscosity_of_its_grade() {
    let answer = lubricant(json!({"viscosity_grade": "iso-vg-46", "temperature_c": 80}));
    let oil = answer.derived.oil.unwrap();
    assert_eq!(oil.grade.as_deref(), Some("iso-vg-46"));
    assert_close(oil.kinematic_viscosity_mm2_s, 10.89, 0.005);
    assert_close(oil.density_kg_m3, 827.75, 1e-9);
    let lubricant = &answer.scene["lubricant"];
    assert_eq!(lubricant["kind"], "oil");
    assert_close(lubricant["viscosity_pa_s"].as_f64().unwrap(), 10.89e-6 * 827.75, 5e-9 * 827.75);
    assert_close(lubricant["pressure_viscosity_per_pa"].as_f64().unwrap(), 1.52e-8, 0.005e-8);
    assert!(lubricant.get("viscosity_grade").is_none() && lubricant.get("temperature_c").is_none());
}

#[test]
fn an_oil_may_be_given_by_two_viscosities() {
    let given =
        json!({"viscosity_40_mm2_s": 120, "viscosity_100_mm2_s": 12, "density_15_kg_m3": 900, "temperature_c": 80});
    let oil = lubricant(given).derived.oil.unwrap();
    assert_close(oil.kinematic_viscosity_mm2_s, 21.55, 0.005);
    assert_close(oil.density_kg_m3, 857.75, 1e-9);
    let grease = lubricant(json!({"kind": "grease", "viscosity_grade": "iso-vg-100", "temperature_c": 70}));
    assert_eq!(grease.scene["lubricant"]["kind"], "grease");
    let hot = lubricant(json!({"viscosity_grade": "iso-vg-10", "temperature_c": 150}));
    assert_eq!(hot.warnings[0].pointer, "/scene/lubricant/temperature_c");
}

#[test]
fn oils_that_do_not_fit_are_refused() {
    let check = |lubricant: Value, field: &str, part: &str| {
        assert_refused(json!("6205"), lubricant, &format!("lubricant{field}"), part);
    };
    let grade = |fields: Value| {
        let mut oil = json!({"viscosity_grade": "iso-vg-46", "temperature_c": 60});
        oil.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        oil
    };
    check(json!("iso-vg-46"), "", "\"temperature_c\": 60");
    check(json!({"viscosity_grade": "iso-vg-46"}), "/temperature_c", "required");
    check(grade(json!({"viscosity_grade": "iso-vg-47"})), "/viscosity_grade", "known are `iso-vg-10`");
    check(grade(json!({"temperature_c": 500})), "/temperature_c", "500 °C: must be from -50 to 200 °C");
    check(grade(json!({"viscosity_pa_s": 0.02})), "/viscosity_pa_s", "give either");
    check(grade(json!({"viscosity_40_mm2_s": 46})), "/viscosity_grade", "give either");
    check(grade(json!({"kind": "dry"})), "/kind", "no oil");
    check(grade(json!({"oil_base": "synthetic"})), "/pressure_viscosity_per_pa", "required");
    check(json!({"temperature_c": 60}), "/temperature_c", "goes with `viscosity_grade`");
    check(json!({"viscosity_40_mm2_s": 46, "temperature_c": 60}), "/viscosity_100_mm2_s", "required");
    let rising = json!({"viscosity_40_mm2_s": 46, "viscosity_100_mm2_s": 46, "temperature_c": 60});
    check(rising, "/viscosity_100_mm2_s", "must be below the viscosity at 40 °C, 46 mm²/s");
}

/// A bearing that cannot be built has no errors of its group.
#[test]
fn a_missing_size_is_the_only_error() {
    let errors = refused(json!({"ball_count": 9, "radial_clearance_group": "C3"}), json!("grease"));
    assert!(errors.iter().all(|error| error.contains("required, but missing")), "{errors:?}");
    let thick = json!({"viscosity_40_mm2_s": 10_000, "viscosity_100_mm2_s": 0.5, "temperature_c": -50});
    assert_refused(json!("6205"), thick, "lubricant/temperature_c", "no finite viscosity");
}

/// The job that resolving prints is the same work.
#[test]
fn ordered_scenes_resolve_to_themselves() {
    let oil = json!({"viscosity_grade": "iso-vg-46", "temperature_c": 60, "oil_base": "mineral"});
    let bearings = [
        json!("6206-2RS/C3"),
        json!("7008C"),
        json!({"preset": "6309", "radial_clearance_group": "C4", "fits": {"shaft_interference_um": 12.3, "shaft_bore_mm": 20,
            "housing_interference_um": 4, "housing_outer_diameter_mm": 120}, "temperatures": {"inner_ring_c": 65.4, "outer_ring_c": 50}}),
        json!({"preset": "6309/C3", "fits": {"shaft": "m5", "housing": "P7"}}),
    ];
    for bearing in bearings {
        let first = parse_scene_request(request(&bearing, &oil).to_string().as_bytes()).unwrap();
        let again = json!({"scene": first.scene_json()}).to_string();
        let second = parse_scene_request(again.as_bytes()).unwrap();
        assert_eq!((first.scene(), first.canonical()), (second.scene(), second.canonical()));
    }
}

/// A study varies the tolerance class of the shaft.
#[test]
fn tolerance_classes_are_varied() {
    let mut study = request(&json!({"preset": "6205/C3", "fits": {"shaft": "k5"}}), &json!("grease"));
    study["kind"] = json!("study");
    study["axes"] = json!([{"path": "/bearing/fits/shaft", "values": ["k5", "m5"]}]);
    let study = parse_job(study.to_string().as_bytes()).unwrap().into_study().unwrap();
    let [k5, m5] = [0, 1].map(|point| study.point(point).unwrap().scene().bearing.radial_clearance);
    // m5 lies 6 µm above k5.
    assert_close(1e6 * (k5 - m5), 0.804 * 6.0, 0.01);
}

/// A study varies the group, and a shaft takes bearings by designation.
#[test]
fn groups_are_varied_and_stand_on_shafts() {
    let mut study = request(&json!("6205"), &json!({"viscosity_grade": "iso-vg-46", "temperature_c": 60}));
    study["kind"] = json!("study");
    study["axes"] = json!([
        {"path": "/bearing/radial_clearance_group", "values": ["CN", "C3"]},
        {"path": "/lubricant/temperature_c", "values": [40, 60]},
    ]);
    let study = parse_job(study.to_string().as_bytes()).unwrap().into_study().unwrap();
    let clearances = [0, 3].map(|point| study.point(point).unwrap().scene().bearing.radial_clearance);
    assert_eq!(clearances, [12.5e-6, 20.5e-6]);
    let viscosities = [0, 3].map(|point| study.point(point).unwrap().scene().lubricant.viscosity);
    assert!(viscosities[0] > 2.0 * viscosities[1]);
    let rotor = json!({"kind": "rotor", "speeds_rpm": [0], "scene": {
        "bearings": [{"name": "A", "bearing": "6205/C3", "at_mm": 40}, {"name": "B", "bearing": "7205C", "at_mm": 260}],
        "shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 25}]},
        "operation": {"speed_rpm": 3000, "radial_load_y_n": 100}}});
    let rotor = parse_job(rotor.to_string().as_bytes());
    assert!(rotor.is_ok(), "{:?}", rotor.map(|_| ()).unwrap_err().to_string());
}

#[test]
fn the_catalogue_is_searched() {
    let found = |search: CatalogueSearch| -> Vec<&'static str> {
        catalogue_answer(&search).bearings.iter().map(|one| one.designation).collect()
    };
    let all = CatalogueSearch::default;
    assert_eq!(catalogue_answer(&all()).count, 394);
    assert_eq!(found(CatalogueSearch { text: Some(" 6205 ".to_owned()), ..all() }), ["6205"]);
    assert_eq!(found(CatalogueSearch { text: Some("7206".to_owned()), ..all() }), ["7206A", "7206B", "7206C"]);
    let of_series = found(CatalogueSearch { series: Some("62".to_owned()), bore_mm: Some(25.0), ..all() });
    assert_eq!(of_series, ["6205"]);
    let strong = found(CatalogueSearch { bore_mm: Some(25.0), min_c_kn: Some(20.0), ..all() });
    assert!(strong.contains(&"6305") && !strong.contains(&"6205"));
    let text = Some("6309".to_owned());
    let note = catalogue_answer(&CatalogueSearch { text, ..all() }).bearings[0].note;
    assert!(!note.is_empty(), "makers differ");
}

/// A hybrid bearing by its designation is the steel one with balls of silicon nitride.
#[test]
fn a_hybrid_bearing_has_balls_of_silicon_nitride() {
    let by_name = bearing(json!("HC7008C"));
    let by_material = bearing(json!({"preset": "7008C", "materials": {"ball": "si3n4"}}));
    assert_eq!(json!(by_name.scene), json!(by_material.scene));
    let designation = by_name.derived.designation.unwrap();
    assert_eq!((designation.designation.as_str(), designation.suffixes[0].suffix.as_str()), ("7008C", "HC"));
}
