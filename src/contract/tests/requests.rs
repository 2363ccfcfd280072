//! Requests with a few fields replaced.

/// A job of the article's bearing with `operation` replaced.
pub(super) fn operation(fields: &str) -> String {
    format!(r#"{{"kind":"simulation","scene":{{"bearing":"article-integrated","operation":{{{fields}}}}}}}"#)
}

/// A job with further fields of the scene.
pub(super) fn scene(fields: &str) -> String {
    format!(
        r#"{{"kind":"simulation","scene":{{"bearing":"article-integrated","operation":{{"speed_rpm":50000}},{fields}}}}}"#
    )
}

/// A job with fields of the bearing changed in the article's preset.
pub(super) fn preset(fields: &str) -> String {
    bearing(&format!(r#""preset":"article-integrated",{fields}"#))
}

/// A job with this bearing object.
pub(super) fn bearing(fields: &str) -> String {
    format!(r#"{{"kind":"simulation","scene":{{"bearing":{{{fields}}},"operation":{{"speed_rpm":50000}}}}}}"#)
}

/// A job with further fields at the top.
pub(super) fn job(fields: &str) -> String {
    format!(
        r#"{{"kind":"simulation","scene":{{"bearing":"article-integrated","operation":{{"speed_rpm":50000}}}},{fields}}}"#
    )
}

pub(super) const DIMENSIONS: &str = r#""outer_diameter_mm":52,"inner_diameter_mm":25,"width_mm":15,"ball_count":9,"ball_diameter_mm":7.94,"pitch_diameter_mm":39.04"#;
