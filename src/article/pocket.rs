//! Force of a ball in its pocket: by finite elements, from `verification/pocket`, and by the model.

use serde_json::Value;

use crate::contract;
use raceway_core::simulation::model::Model;

const RESULTS: &str = include_str!("../../verification/pocket/results.csv");

/// Penetration [µm], and forces of the finite elements, of the model, and of Hertz's contact alone [N], for a case with the pocket of the scene.
pub fn forces(scene: &Value, case: &str) -> Result<Vec<[f64; 4]>, String> {
    let request = serde_json::json!({ "scene": scene }).to_string();
    let job = contract::parse_scene_request(request.as_bytes()).map_err(|refusal| refusal.to_string())?;
    let base = job.base().ok_or("a scene alone is a simulation")?;
    let model = Model::new(base.scene(), &base.terms);
    let pocket = &model.mechanism().pocket;
    let mut lines = RESULTS.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap_or_default();
    let place =
        |name: &str| head.iter().position(|cell| *cell == name).ok_or(format!("results.csv has no column {name}"));
    let (penetrations, forces) = (place("penetration_um")?, place("force_fe_converged_n")?);
    let number = |line: &[&str], column: usize| line.get(column).and_then(|cell| cell.parse::<f64>().ok());
    let of = |line: Vec<&str>| {
        let (penetration, force) = (number(&line, penetrations)?, number(&line, forces)?);
        let depth = 1e-6 * penetration;
        Some([penetration, force, pocket.solid_load(depth), pocket.solid_stiffness() * depth.powf(1.5)])
    };
    lines
        .filter(|line| line.first() == Some(&case))
        .map(|line| of(line).ok_or("results.csv has no number".into()))
        .collect()
}
