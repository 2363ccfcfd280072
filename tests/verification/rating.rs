//! Basic dynamic load ratings.

use raceway::physics::rating::{dynamic_load_rating, table_applies};
use serde_json::json;

use crate::distribution::scene;
use crate::table::check;

/// Catalogue ratings after ISO 281, with the groove curvature that the standard assumes.
#[test]
fn catalogue() {
    for (case, balls, diameter, pitch) in [
        ("rating-608", 7, 3.969, 15.0),
        ("rating-6203", 8, 6.746, 28.5),
        ("rating-6204", 8, 7.938, 33.5),
        ("rating-6205", 9, 7.94, 39.04),
        ("rating-6206", 9, 9.525, 46.0),
        ("rating-6208", 9, 11.906, 60.0),
        ("rating-6210", 10, 12.7, 70.0),
        ("rating-uer204", 8, 7.92, 34.55),
        ("rating-6804", 13, 3.5, 25.6),
    ] {
        let bearing = scene(&json!({ "bearing": {
            "type": "deep_groove", "outer_diameter_mm": pitch + 1.8 * diameter, "inner_diameter_mm": pitch - 1.8 * diameter,
            "width_mm": 2.0 * diameter, "ball_count": balls, "ball_diameter_mm": diameter, "pitch_diameter_mm": pitch,
            "inner_groove_curvature": 0.52, "outer_groove_curvature": 0.53, "radial_clearance_um": 5
        }}))
        .bearing;
        assert!(table_applies(&bearing));
        check(case, &[dynamic_load_rating(&bearing) * 1e-3]);
    }
}
