//! The contact of a ball with its pocket against finite elements (`verification/pocket`).

use raceway::contract::scene_from_json;
use raceway::simulation::input::settings::Outputs;
use raceway::simulation::model::Model;
use raceway::simulation::model::terms::ActiveTerms;

use crate::table::{check, read};

/// Penetration [m], converged force of the finite elements [N] and force of the law [N] of a case in results.csv.
fn rows(case: &str) -> Vec<[f64; 3]> {
    let text = read("verification/pocket/results.csv");
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().expect("a head");
    let place = |name: &str| head.iter().position(|cell| *cell == name).unwrap_or_else(|| panic!("no column {name}"));
    let columns = ["penetration_um", "force_fe_converged_n", "force_law_n"].map(place);
    let numbers = |line: Vec<&str>| {
        let [penetration, fe, law] = columns.map(|column| line[column].parse::<f64>().expect("a number"));
        [1e-6 * penetration, fe, law]
    };
    let rows: Vec<_> = lines.filter(|line| line[0] == case).map(numbers).collect();
    assert!(rows.len() > 4, "{case}: {rows:?}");
    rows
}

/// Forces of the program at the penetrations of a case.
fn forces(case: &str, bearing: &str) -> Vec<f64> {
    let scene = format!(r#"{{ "bearing": {bearing}, "operation": {{ "speed_rpm": 10000 }} }}"#);
    let scene = scene_from_json(&scene).unwrap_or_else(|refusal| panic!("{bearing}: {refusal}"));
    let outputs = Outputs { cage: true, ..Outputs::vibration() };
    let needs = ActiveTerms::of(&scene, &outputs, None).expect("a model");
    let model = Model::new(&scene, &needs);
    rows(case).into_iter().map(|[penetration, ..]| model.mechanism().pocket.solid_load(penetration)).collect()
}

#[test]
fn finite_elements() {
    let article = |clearance: &str| {
        format!(r#"{{ "preset": "article-integrated", "cage": {{ "pocket_clearance_mm": {clearance} }} }}"#)
    };
    for (row, bearing) in [
        ("pocket-clearance-10", article("0.01")),
        ("pocket-clearance-20", article("0.02")),
        ("pocket-clearance-51", article("0.051")),
        ("pocket-clearance-100", article("0.1")),
        ("pocket-bearing-6205", r#""6205""#.to_owned()),
    ] {
        let case = row.trim_start_matches("pocket-");
        let ours = forces(case, &bearing);
        for (force, [penetration, fe, law]) in ours.iter().zip(rows(case)) {
            assert!((force / law - 1.0).abs() < 2e-3, "{case} at {penetration} m: {force} N, the file has {law} N");
            assert!((force / fe - 1.0).abs() < 0.01, "{case} at {penetration} m: {force} N against {fe} N");
        }
        check(row, &ours);
    }
}
