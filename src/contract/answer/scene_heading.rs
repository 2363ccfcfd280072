//! Heading of a scene.

use serde_json::Value;

use crate::contract::job::simulation::Simulation;
use crate::contract::json::numbers::{short, significant};
use crate::contract::json::shapes::NameOr;
use crate::contract::scene::operation::SpeedInput;

/// Bearing, speed and load: `article-integrated, 50 000 r/min, 200 N radial`.
pub fn scene_heading(simulation: &Simulation) -> String {
    [bearing(simulation), speed(simulation), load(simulation)].join(", ")
}

/// Name of the preset, with `changed` where fields replace its own; main dimensions of a bearing without a preset.
fn bearing(simulation: &Simulation) -> String {
    let given = &simulation.submission.request["scene"]["bearing"];
    let preset = given.get("preset").and_then(Value::as_str);
    if let Some(name) = given.as_str() {
        return name.to_owned();
    }
    if let Some(name) = preset {
        let changed = given.as_object().is_some_and(|fields| fields.len() > 1);
        return if changed { format!("{name} changed") } else { name.to_owned() };
    }
    let NameOr::Object(bearing) = &simulation.resolved.input.bearing else { return "bearing".into() };
    let number = |field: Option<f64>| field.map_or("?".to_owned(), short);
    format!(
        "{} × {} × {} mm, {} balls",
        number(bearing.inner_diameter_mm),
        number(bearing.outer_diameter_mm),
        number(bearing.width_mm),
        number(bearing.ball_count.map(f64::from))
    )
}

fn speed(simulation: &Simulation) -> String {
    match &simulation.resolved.input.operation.speed_rpm {
        SpeedInput::Constant(rpm) => format!("{} r/min", grouped(*rpm)),
        SpeedInput::Profile(points) => {
            let least = points.iter().map(|point| point.rpm).fold(f64::INFINITY, f64::min);
            let most = points.iter().map(|point| point.rpm).fold(f64::NEG_INFINITY, f64::max);
            format!("{} to {} r/min", grouped(least), grouped(most))
        }
    }
}

fn load(simulation: &Simulation) -> String {
    let operation = &simulation.resolved.input.operation;
    let newton = |load: Option<f64>| load.unwrap_or(0.0);
    let radial = newton(operation.radial_load_y_n).hypot(newton(operation.radial_load_z_n));
    let parts = [(radial, "radial"), (newton(operation.axial_load_n), "axial")];
    let parts: Vec<String> =
        parts.iter().filter(|part| part.0 != 0.0).map(|(load, name)| format!("{} N {name}", grouped(*load))).collect();
    let loads = match operation.loads.as_ref().map_or(0, Vec::len) {
        0 => None,
        1 => Some("1 further load".to_owned()),
        several => Some(format!("{several} further loads")),
    };
    let parts: Vec<String> = parts.into_iter().chain(loads).collect();
    if parts.is_empty() { "no load".into() } else { parts.join(", ") }
}

/// At most six significant digits, thousands separated from 10 000 on, with a minus sign instead of a hyphen.
fn grouped(number: f64) -> String {
    let text = short(significant(number, 6));
    let (sign, digits) = text.strip_prefix('-').map_or(("", text.as_str()), |digits| ("−", digits));
    let whole = digits.split('.').next().unwrap_or_default();
    if whole.len() < 5 || digits.contains('e') {
        return format!("{sign}{digits}");
    }
    let mut out = String::from(sign);
    for (index, digit) in whole.chars().enumerate() {
        if index > 0 && (whole.len() - index).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out + &digits[whole.len()..]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::parse_job_or_scene;

    fn words(scene: &str) -> String {
        scene_heading(parse_job_or_scene(scene.as_bytes()).unwrap().base().unwrap())
    }

    #[test]
    fn heading_names_bearing_speed_and_load() {
        let of = |bearing: &str, operation: &str| words(&format!(r#"{{"bearing":{bearing},"operation":{operation}}}"#));
        assert_eq!(
            of(r#""article-integrated""#, r#"{"speed_rpm":50000,"radial_load_y_n":200}"#),
            "article-integrated, 50 000 r/min, 200 N radial"
        );
        assert_eq!(
            of(r#"{"preset":"608","ball_count":7}"#, r#"{"speed_rpm":-1500,"axial_load_n":-20.5}"#),
            "608 changed, −1500 r/min, −20.5 N axial"
        );
        let dimensions = r#"{"outer_diameter_mm":52,"inner_diameter_mm":25,"width_mm":15,"ball_count":9,"ball_diameter_mm":7.94,"pitch_diameter_mm":39.04}"#;
        let profile = r#"{"speed_rpm":[{"at_s":0,"rpm":0},{"at_s":1,"rpm":123456}]}"#;
        assert_eq!(of(dimensions, profile), "25 × 52 × 15 mm, 9 balls, 0 to 123 456 r/min, no load");
    }
}
