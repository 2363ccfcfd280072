//! Messages about the spread of a metric over uncertain inputs.

use serde_json::json;

use super::answer::{MessageAnswer, MessageCode, Severity, message};
use crate::contract::json::numbers::{short, significant};

/// `share`: of the sampled points without a value.
pub fn failed_samples(metric: &str, share: f64) -> MessageAnswer {
    let percent = significant(100.0 * share, 2);
    let text = format!(
        "{} % of the sampled points have no value of {metric}: percentiles may leave out the worst. The table has the reasons.",
        short(percent)
    );
    let values = [("metric", json!(metric)), ("without_value_percent", json!(percent))];
    message(MessageCode::FailedSamples, Severity::Warning, text, values)
}

pub fn spread_not_resolved(metric: &str, integration: f64, standard_deviation: f64) -> MessageAnswer {
    let [error, spread] = [integration, standard_deviation].map(|number| significant(number, 2));
    let text = format!(
        "Spread not resolved: the integration error of {metric}, {}, exceeds half of its standard deviation, {}. Tighten \
         `solver.relative_tolerance` or increase `duration_s`.",
        short(error),
        short(spread)
    );
    let values = [("metric", json!(metric)), ("integration", json!(error)), ("standard_deviation", json!(spread))];
    message(MessageCode::SpreadNotResolved, Severity::Warning, text, values)
}

pub fn ranking_not_resolved(metric: &str, q2: f64) -> MessageAnswer {
    let q2 = significant(q2, 2);
    let text = format!(
        "Ranking not resolved: effects of single inputs predict a share of {} of the variance of {metric}. The rest is interaction, \
         roughness or noise.",
        short(q2)
    );
    message(MessageCode::RankingNotResolved, Severity::Warning, text, [("metric", json!(metric)), ("q2", json!(q2))])
}
