//! The plot of an uncertainty job.

use super::uncertainty::{SpreadPanel, uncertainty_svg};
use crate::contract::UncertaintyAnswer;
use crate::contract::answer::headings::{field_heading, metric_heading};
use crate::contract::answer::propagation::MetricSpreadAnswer;

/// Percentiles that are drawn.
const SHOWN: [u32; 3] = [5, 50, 90];

/// Histogram of each metric with percentiles, and the ranking of the inputs.
pub fn histograms(answer: &UncertaintyAnswer) -> String {
    let panels: Vec<SpreadPanel> = answer.metrics.iter().map(|(metric, spread)| panel(metric, spread)).collect();
    let inputs = if answer.inputs.len() == 1 { "input" } else { "inputs" };
    let failed = if answer.failed == 0 { String::new() } else { format!(", {} failed", answer.failed) };
    let subtitle =
        format!("{} uncertain {inputs}; {} of {} points{failed}", answer.inputs.len(), answer.ended, answer.points);
    uncertainty_svg("Uncertainty", &subtitle, &panels)
}

fn panel(metric: &str, spread: &MetricSpreadAnswer) -> SpreadPanel {
    let shown = spread.percentiles.iter().filter(|of| SHOWN.contains(&of.percentile));
    let ranking = spread.sensitivity.as_ref();
    let mut bars: Vec<_> = ranking
        .iter()
        .flat_map(|ranking| &ranking.inputs)
        .map(|of| (field_heading(&of.input), of.share, of.share_interval))
        .collect();
    bars.sort_by(|a, b| b.1.total_cmp(&a.1));
    let note = match ranking {
        None => "No ranking: too few points, or equal values".to_owned(),
        Some(of) if of.resolved => format!("Share of the variance by input; Q² {:.2}", of.q2),
        Some(of) => format!("Ranking not resolved: Q² {:.2}; share of the variance by input", of.q2),
    };
    SpreadPanel {
        quantity: metric_heading(metric),
        edges: spread.histogram.edges.clone(),
        counts: spread.histogram.counts.clone(),
        marks: shown.map(|of| (format!("P{}", of.percentile), of.value)).collect(),
        bars,
        ranking: note,
    }
}
