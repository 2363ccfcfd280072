//! Headings of fields and metrics: their names in words, with the unit that the name ends in.

use raceway_core::simulation::result::metrics::LEVEL_UNIT;

/// Suffixes of field names and their units; a suffix precedes the shorter suffixes that it ends in.
const UNITS: [(&str, &str); 22] = [
    ("_n_s_per_m", "N s/m"),
    ("_n_per_m", "N/m"),
    ("_per_pa", "1/Pa"),
    ("_pa_s", "Pa s"),
    ("_kg_m3", "kg/m³"),
    ("_kg_m2", "kg m²"),
    ("_g_mm", "g mm"),
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_mrad", "mrad"),
    ("_rpm", "r/min"),
    ("_deg", "°"),
    ("_gpa", "GPa"),
    ("_mpa", "MPa"),
    ("_pa", "Pa"),
    ("_um", "µm"),
    ("_mm", "mm"),
    ("_kg", "kg"),
    ("_hz", "Hz"),
    ("_db", "dB"),
    ("_g", "g"),
    ("_n", "N"),
];
/// Fields whose heading needs the name of the object that contains them.
const NEEDS_PARENT: [&str; 9] =
    ["/y", "/z", "/law", "/kind", "/limit", "/restitution", "/maximum", "/stiffness_n_per_m", "/damping_n_s_per_m"];

/// Heading of a field of the scene, or of a derived quantity: `/bearing/radial_clearance_um` gives `radial clearance in µm`.
pub fn field_heading(pointer: &str) -> String {
    let mut tokens = pointer.rsplit('/');
    let name = tokens.next().unwrap_or_default();
    let (words, unit) = words_and_unit(name);
    let of = NEEDS_PARENT.iter().any(|short| pointer.ends_with(short)).then(|| tokens.next()).flatten();
    let of = of.map(words_and_unit);
    let unit = unit.or(of.as_ref().and_then(|(_, unit)| *unit));
    let of = of.map_or(String::new(), |(of, _)| format!("{of}: "));
    unit.map_or_else(|| format!("{of}{words}"), |unit| format!("{of}{words} in {unit}"))
}

/// Heading of a metric: `/channels/spindle.y.acceleration/level_db` gives `acceleration of spindle Y: level in dB re 9.81 mm/s²`.
pub fn metric_heading(pointer: &str) -> String {
    let parts: Vec<&str> = pointer.split('/').skip(1).collect();
    let [of @ .., name] = &parts[..] else { return pointer.to_owned() };
    let (words, unit) = words_and_unit(name);
    let unit = if *name == "level_db" { Some(LEVEL_UNIT) } else { unit };
    let (of, of_channel) = match of {
        ["channels", channel] => match &channel.split('.').collect::<Vec<_>>()[..] {
            ["spindle", axis, quantity] => {
                let unit = match *quantity {
                    "acceleration" => "m/s²",
                    "velocity" => "mm/s",
                    _ => "µm",
                };
                let has_its_unit = ["rms", "peak", "above_band"].contains(name);
                (format!("{quantity} of spindle {}: ", axis.to_uppercase()), Some(unit).filter(|_| has_its_unit))
            }
            _ => (format!("{channel}: "), None),
        },
        ["contacts", "pocket"] => ("cage pocket: ".to_owned(), None),
        ["contacts", raceway] => (format!("{raceway} raceway: "), None),
        ["cage"] if !words.contains("cage") => ("cage: ".to_owned(), None),
        _ => (String::new(), None),
    };
    unit.or(of_channel).map_or_else(|| format!("{of}{words}"), |unit| format!("{of}{words} in {unit}"))
}

/// A name without its unit, in words, and the unit.
fn words_and_unit(name: &str) -> (String, Option<&'static str>) {
    let found = UNITS.iter().find_map(|(ending, unit)| Some((name.strip_suffix(ending)?, *unit)));
    let (words, unit) = found.map_or((name, None), |(words, unit)| (words, Some(unit)));
    (words.replace('_', " "), unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_have_units() {
        for (pointer, words) in [
            ("/bearing/radial_clearance_um", "radial clearance in µm"),
            ("/bearing/inner_groove_curvature", "inner groove curvature"),
            ("/operation/speed_rpm", "speed in r/min"),
            ("/operation/radial_load_y_n", "radial load y in N"),
            ("/operation/misalignment_mrad/y", "misalignment: y in mrad"),
            ("/lubricant/viscosity_pa_s", "viscosity in Pa s"),
            ("/damping/raceway/law", "raceway: law"),
            ("axial_load_over_rating", "axial load over rating"),
        ] {
            assert_eq!(field_heading(pointer), words);
        }
        for (pointer, words) in [
            ("/channels/spindle.y.acceleration/level_db", "acceleration of spindle Y: level in dB re 9.81 mm/s²"),
            ("/accuracy/level_error_db", "level error in dB"),
            ("/channels/spindle.z.velocity/rms", "velocity of spindle Z: rms in mm/s"),
            ("/contacts/inner/max_load_n", "inner raceway: max load in N"),
            ("/contacts/pocket/max_load_n", "cage pocket: max load in N"),
            ("/kinematics/cage_speed_hz", "cage speed in Hz"),
            ("/cage/orbit_radius_um", "cage: orbit radius in µm"),
        ] {
            assert_eq!(metric_heading(pointer), words);
        }
    }
}
