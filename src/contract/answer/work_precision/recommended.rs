//! The cheapest method and tolerance for a given level error.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::point::{MeasuredAnswer, PointAnswer};
use super::reference::{ReferenceAnswer, floors};

/// Level errors for which a method is recommended [dB]: the repeatability of a measurement, and tighter.
pub const RECOMMENDED_ERRORS_DB: [f64; 3] = [0.1, 0.01, 0.001];

/// The cheapest point within a level error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RecommendedAnswer {
    /// Largest accepted deviation of the level from the reference [dB].
    #[schema(example = 0.01, minimum = 0)]
    pub within_db: f64,
    /// Name of the method.
    #[schema(example = "gear")]
    pub method: String,
    /// Its relative tolerance [-].
    #[schema(example = 1e-3, minimum = 0)]
    pub relative_tolerance: f64,
    /// Wall time of the point [s].
    #[schema(minimum = 0)]
    pub wall_time_s: f64,
    /// Processor time of the point [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub processor_time_s: Option<f64>,
    /// Level error of the point [dB].
    #[schema(minimum = 0)]
    pub level_error_db: f64,
}

/// One recommendation for each error that some point reaches, largest error first.
pub fn recommended(reference: &ReferenceAnswer, points: &[PointAnswer]) -> Vec<RecommendedAnswer> {
    RECOMMENDED_ERRORS_DB.into_iter().filter_map(|within_db| cheapest(within_db, reference, points)).collect()
}

/// The point with the least processor time, or the least wall time where the processor time of some point is unknown.
fn cheapest(within_db: f64, reference: &ReferenceAnswer, points: &[PointAnswer]) -> Option<RecommendedAnswer> {
    let floor = floors(reference).1.unwrap_or(0.0);
    let measured = || points.iter().filter_map(PointAnswer::measured);
    let by_processor = measured().all(|point| point.processor_time_s.is_some());
    let time = |point: &MeasuredAnswer| match point.processor_time_s {
        Some(time) if by_processor => time,
        _ => point.wall_time_s,
    };
    // An error below that of the reference may in fact be as large.
    let is_within = |point: &MeasuredAnswer| point.level_error_db.is_some_and(|error| error.max(floor) <= within_db);
    // A loose tolerance may match the level by chance; tighter ones must match it, too.
    let is_confirmed = |point: &MeasuredAnswer| {
        measured()
            .filter(|other| other.method == point.method && other.relative_tolerance <= point.relative_tolerance)
            .all(is_within)
    };
    let best = measured().filter(|point| is_confirmed(point)).min_by(|a, b| time(a).total_cmp(&time(b)))?;
    Some(RecommendedAnswer {
        within_db,
        method: best.method.clone(),
        relative_tolerance: best.relative_tolerance,
        wall_time_s: best.wall_time_s,
        processor_time_s: best.processor_time_s,
        level_error_db: best.level_error_db?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(own_error_db: f64) -> ReferenceAnswer {
        serde_json::from_value(serde_json::json!({
            "method": "radau", "relative_tolerance": 1e-11, "own_error_db": own_error_db, "levels_db": {}, "lines": [],
            "steps": 1, "rhs_evaluations": 1, "wall_time_s": 1.0
        }))
        .unwrap()
    }

    fn point(method: &str, relative_tolerance: f64, time: f64, error: f64) -> PointAnswer {
        serde_json::from_value(serde_json::json!({
            "status": "succeeded", "method": method, "relative_tolerance": relative_tolerance, "wall_time_s": time,
            "wall_time_range_s": [time, time], "ran": method, "below_reference": false, "level_error_db": error,
            "level_below_reference": false, "steps": 1, "rejected_steps": 0, "newton_failures": 0,
            "rhs_evaluations": 1, "jacobian_evaluations": 0, "factorizations": 0, "mean_step_s": 1.0,
            "least_step_s": 1.0
        }))
        .unwrap()
    }

    fn found(own_error_db: f64, points: &[PointAnswer]) -> Vec<(f64, String, f64)> {
        let found = recommended(&reference(own_error_db), points);
        found.into_iter().map(|r| (r.within_db, r.method, r.relative_tolerance)).collect()
    }

    #[test]
    fn the_cheapest_within_each_error_is_recommended() {
        let points = [
            point("gear", 1e-3, 0.1, 0.05),
            point("gear", 1e-4, 0.2, 0.005),
            point("radau", 1e-3, 0.15, 0.009),
            point("radau", 1e-4, 0.9, 0.002),
        ];
        assert_eq!(found(1e-9, &points), [(0.1, "gear".into(), 1e-3), (0.01, "radau".into(), 1e-3)]);
    }

    #[test]
    fn a_lucky_point_and_an_unsure_reference_recommend_nothing() {
        let lucky = [point("gear", 1e-3, 0.1, 1e-4), point("gear", 1e-4, 0.2, 0.02)];
        assert_eq!(found(1e-9, &lucky), [(0.1, "gear".into(), 1e-3)]);
        assert!(found(0.02, &lucky).is_empty());
    }
}
