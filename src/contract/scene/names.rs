//! Names of bearings, bodies and sensors.

use crate::contract::json::defaults::Defaults;

const MAX_NAME: usize = 32;
/// Names that channels have.
const RESERVED: [&str; 5] = ["spindle", "cage", "ball", "sensor", "shaft"];

/// Refuses a name that no channel can have, or that channels have already; `at`: pointer to the object that has it.
pub(super) fn check_body_name(name: &str, defaults: &mut Defaults, at: &str) {
    check_name(name, defaults, at);
    if RESERVED.contains(&name) {
        defaults.refuse(format!("{at}/name"), format!("`{name}` is a name of channels; give another"));
    }
}

/// Refuses a name that no channel can have; `at`: pointer to the object that has it.
pub(super) fn check_name(name: &str, defaults: &mut Defaults, at: &str) {
    let mut letters = name.chars();
    let is_pattern = letters.next().is_some_and(|first| first.is_ascii_alphabetic())
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-')
        && name.len() <= MAX_NAME;
    if !is_pattern {
        let detail = format!("must be a letter, then letters, digits, `_` or `-`, at most {MAX_NAME}");
        defaults.refuse(format!("{at}/name"), detail);
    }
}
