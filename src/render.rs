//! Answers as pictures and tables: what the service sends and the commands write.

use std::fmt::Write;

use crate::contract::optimum::{GoalName, PurposeName, RangeAnswer, RunAnswer};
use crate::contract::table::AxisAnswer;
use crate::contract::work_precision::{PointAnswer, floors};
use crate::contract::{Metrics, OptimumAnswer, SeriesAnswer, SpectrumAnswer, TableAnswer, WorkPrecisionAnswer};
use crate::plots::{
    AxisPlaces, ErrorPanel, FailedRun, MapPanel, SeriesCurve, SpectrumCurve, TrendCurve, TrendPanel, VariedAxis,
    WorkPoint, WorkPrecisionCurve, map_svg, series_svg, spectrum_svg, trend_svg, work_precision_svg,
};
use crate::simulation::lines::Line;

/// The spectra of a job, with their labelled lines.
pub fn spectra(metrics: &Metrics, spectra: &[SpectrumAnswer]) -> String {
    let lines: Vec<Vec<Line>> = spectra.iter().map(|spectrum| lines_of(metrics, &spectrum.channel)).collect();
    let curves = spectra.iter().zip(&lines).map(|(spectrum, lines)| SpectrumCurve {
        name: &spectrum.channel,
        unit: &spectrum.unit,
        resolution_hz: spectrum.resolution_hz,
        amplitude: &spectrum.amplitude,
        lines,
    });
    let frequencies = &metrics.frequencies_hz;
    let subtitle = format!(
        "shaft {:.1} Hz, cage {:.1} Hz, BPFO {:.1} Hz, BPFI {:.1} Hz, ball spin {:.1} Hz",
        frequencies.shaft,
        frequencies.cage,
        frequencies.ball_pass_outer,
        frequencies.ball_pass_inner,
        frequencies.ball_spin
    );
    spectrum_svg("Vibration spectrum", &subtitle, &curves.collect::<Vec<_>>())
}

fn lines_of(metrics: &Metrics, channel: &str) -> Vec<Line> {
    let lines = metrics.lines.iter().flatten().filter(|line| line.channel == channel);
    lines
        .map(|line| Line {
            frequency: line.frequency_hz,
            amplitude: line.amplitude,
            label: line.label.clone(),
            deviation: line.deviation_hz,
        })
        .collect()
}

/// Time series above each other.
pub fn series(series: &[SeriesAnswer]) -> String {
    let curves = series.iter().map(|series| SeriesCurve {
        name: &series.channel,
        unit: &series.unit,
        time_s: &series.time_s,
        value: &series.value,
    });
    series_svg("Motion of the spindle", "time since the start of the run", &curves.collect::<Vec<_>>())
}

/// Error against run time, a curve a method.
pub fn work_precision(answer: &WorkPrecisionAnswer) -> String {
    let mut curves: Vec<WorkPrecisionCurve<'_>> = Vec::new();
    for point in &answer.points {
        if curves.last().is_none_or(|curve| curve.name != point.method()) {
            curves.push(WorkPrecisionCurve { name: point.method(), points: Vec::new(), failures: Vec::new() });
        }
        let Some(curve) = curves.last_mut() else { continue };
        match point {
            PointAnswer::Succeeded(point) => curve.points.push(WorkPoint {
                relative_tolerance: Some(point.relative_tolerance),
                time_s: point.wall_time_s,
                errors: [
                    point.level_error_db.map(|error| (error, !point.level_below_reference)),
                    point.trajectory_error.map(|error| (error, !point.below_reference)),
                ],
            }),
            PointAnswer::Failed(point) => curve
                .failures
                .push(FailedRun { relative_tolerance: point.relative_tolerance, time_s: point.wall_time_s }),
        }
    }
    let (reference, compared) = (&answer.reference, &answer.compared);
    let subtitle = format!(
        "Error against run time: {} s after {} s; reference {} at {:e}",
        compared.duration_s, compared.settle_s, reference.method, reference.relative_tolerance
    );
    let (trajectory, level) = floors(reference);
    // Reports of older versions do not name their scene.
    let title = if compared.scene.is_empty() { "Error against run time" } else { &compared.scene };
    let panels = [
        ErrorPanel { name: "Error of the level, worst of y and z", unit: "dB", floor: level },
        ErrorPanel { name: "Error of the trajectory", unit: "rms, in standard deviations", floor: trajectory },
    ];
    work_precision_svg(title, &subtitle, &curves, panels)
}

/// Panels of a trend from which on no further quantity is shown.
const MOST_PANELS: usize = 4;

/// What pictures of a study show: quantity with its unit, and the metrics of it with their short names. The first that are there
/// are drawn, at most two quantities.
const SHOWN: [(&str, &[(&str, &str)]); 4] = [
    (
        "velocity, rms, in mm/s",
        &[("spindle Y", "/channels/spindle.y.velocity/rms"), ("spindle Z", "/channels/spindle.z.velocity/rms")],
    ),
    (
        "acceleration level in dB",
        &[
            ("spindle Y", "/channels/spindle.y.acceleration/level_db"),
            ("spindle Z", "/channels/spindle.z.acceleration/level_db"),
        ],
    ),
    (
        "largest load in N",
        &[("inner raceway", "/contacts/inner/max_load_n"), ("outer raceway", "/contacts/outer/max_load_n")],
    ),
    ("orbit of the cage in µm", &[("cage", "/cage/orbit_radius_um")]),
];

fn places(axis: &AxisAnswer) -> AxisPlaces {
    let numbers: Option<Vec<f64>> = axis.values.iter().map(serde_json::Value::as_f64).collect();
    let word = |value: &serde_json::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    numbers.map_or_else(|| AxisPlaces::Words(axis.values.iter().map(word).collect()), AxisPlaces::Numbers)
}

fn counted(table: &TableAnswer) -> String {
    let failed = table.ended - table.succeeded;
    let failed = if failed > 0 { format!(", {failed} of them failed") } else { String::new() };
    format!("{} of {} points{failed}", table.ended, table.points)
}

/// A study over its one axis; `None` of several axes.
pub fn trend(table: &TableAnswer) -> Option<String> {
    let [axis] = &table.axes[..] else { return None };
    let mut panels = Vec::new();
    for (quantity, metrics) in SHOWN {
        let curves = metrics.iter().map(|(name, pointer)| TrendCurve { name, values: table.column(pointer) });
        let curves = curves.filter(|curve| curve.values.iter().any(Option::is_some));
        // A panel each: on one scale the larger would hide how the smaller one changes.
        let of_quantity = curves.map(|curve| TrendPanel { quantity, curves: vec![curve], best: None });
        if panels.len() < MOST_PANELS {
            panels.extend(of_quantity);
        }
    }
    let varied = VariedAxis { name: &axis.axis, values: places(axis) };
    Some(trend_svg(&format!("Trend over {}", axis.axis), &counted(table), &varied, &panels))
}

/// A study over its two axes; `None` of another number.
pub fn map(table: &TableAnswer) -> Option<String> {
    let [right, up] = &table.axes[..] else { return None };
    let mut panels = Vec::new();
    let names: Vec<(String, &str)> = SHOWN[1..]
        .iter()
        .flat_map(|(quantity, metrics)| metrics.iter().map(move |(name, at)| (format!("{name}: {quantity}"), *at)))
        .collect();
    for (name, pointer) in &names {
        let values: Vec<Option<f64>> = table.column(pointer).into_iter().map(|value| value.map(|v| v.0)).collect();
        if panels.len() < 2 && values.iter().any(Option::is_some) {
            let best =
                table.best.get(*pointer).and_then(|best| table.rows.iter().position(|row| row.point == best.point));
            panels.push(MapPanel { name, values, best });
        }
    }
    let [right, up] = [right, up].map(|axis| VariedAxis { name: &axis.axis, values: places(axis) });
    Some(map_svg(&format!("{} and {}", right.name, up.name), &counted(table), [&right, &up], &panels))
}

/// The runs of an optimum job and the best of them: over the one axis, or over both by the scan alone, where the cell that is
/// nearest to the best point is marked.
pub fn optimum(answer: &OptimumAnswer) -> String {
    let at = |run: &RunAnswer, axis: &str| run.point.get(axis).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    let best = |axis: &str| answer.point.get(axis).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    let name = |axis: &RangeAnswer| axis.axis.clone();
    let place = |axis: &RangeAnswer| {
        let within = answer.within.as_ref().and_then(|within| within.get(&axis.axis));
        let within = within.map_or(String::new(), |[low, high]| format!(" ({low} … {high})"));
        format!("{}{within}", best(&axis.axis))
    };
    let places: Vec<String> = answer.axes.iter().map(place).collect();
    let error = answer.error.map_or(String::new(), |error| format!(" ± {error:.1e}"));
    let title =
        format!("{} of {}", if answer.goal == GoalName::Minimum { "Minimum" } else { "Maximum" }, answer.metric);
    let subtitle = format!("{:.4}{error} at {}; {} runs", answer.value, places.join(", "), answer.runs);
    match &answer.axes[..] {
        [right, up] => {
            let scan: Vec<&RunAnswer> =
                answer.evaluations.iter().filter(|run| run.purpose == PurposeName::Scan).collect();
            let axis = |axis: &RangeAnswer| {
                let mut values: Vec<f64> = scan.iter().map(|run| at(run, &axis.axis)).collect();
                values.sort_by(|a, b| if axis.from < axis.to { a.total_cmp(b) } else { b.total_cmp(a) });
                values.dedup();
                values
            };
            let both = [axis(right), axis(up)];
            let nearest = |values: &[f64], best: f64| {
                (0..values.len())
                    .min_by(|a, b| (values[*a] - best).abs().total_cmp(&(values[*b] - best).abs()))
                    .unwrap_or(0)
            };
            let marked = nearest(&both[0], best(&right.axis)) * both[1].len() + nearest(&both[1], best(&up.axis));
            let panel = MapPanel {
                name: &answer.metric,
                values: scan.iter().map(|run| run.value).collect(),
                best: Some(marked),
            };
            let (names, [a, b]) = ([name(right), name(up)], both.map(AxisPlaces::Numbers));
            let axes = [VariedAxis { name: &names[0], values: a }, VariedAxis { name: &names[1], values: b }];
            map_svg(&title, &subtitle, [&axes[0], &axes[1]], &[panel])
        }
        axes => {
            let name = axes.first().map(name).unwrap_or_default();
            let mut runs: Vec<&RunAnswer> = answer.evaluations.iter().collect();
            runs.sort_by(|a, b| at(a, &name).total_cmp(&at(b, &name)));
            let values = runs.iter().map(|run| run.value.map(|value| (value, run.error))).collect();
            let marked = runs.iter().position(|run| run.point == answer.point);
            let curves = vec![TrendCurve { name: "every run", values }];
            let panel =
                TrendPanel { quantity: answer.metric.rsplit('/').next().unwrap_or_default(), curves, best: marked };
            let axis = VariedAxis {
                name: &name,
                values: AxisPlaces::Numbers(runs.iter().map(|run| at(run, &name)).collect()),
            };
            trend_svg(&title, &subtitle, &axis, &[panel])
        }
    }
}

/// Force over penetration: finite elements, the law, and Hertz's contact alone.
pub fn forces(forces: &[[f64; 4]]) -> String {
    let curve =
        |name, place: usize| TrendCurve { name, values: forces.iter().map(|of| Some((of[place], None))).collect() };
    let curves = vec![curve("finite elements", 1), curve("law", 2), curve("Hertz alone", 3)];
    let panel = TrendPanel { quantity: "force in N", curves, best: None };
    let axis =
        VariedAxis { name: "penetration in µm", values: AxisPlaces::Numbers(forces.iter().map(|of| of[0]).collect()) };
    trend_svg("Ball in its pocket", "CalculiX, converged, against the law of the model", &axis, &[panel])
}

/// A study as CSV: axes, status, then every number of the metrics under its pointer.
pub fn table_csv(table: &TableAnswer) -> String {
    let columns = table.columns();
    let quoted = |text: &str| {
        if text.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    let heads = table.axes.iter().map(|axis| quoted(&axis.axis));
    let mut lines = vec![
        heads
            .chain(["status".to_owned(), "error".to_owned()])
            .chain(columns.iter().map(|column| quoted(column)))
            .collect::<Vec<_>>()
            .join(","),
    ];
    for row in &table.rows {
        let word = |value: &serde_json::Value| value.as_str().map_or_else(|| value.to_string(), quoted);
        let values = table.axes.iter().map(|axis| row.point.get(&axis.axis).map_or(String::new(), word));
        let error = row.error.as_ref().map_or(String::new(), |error| quoted(&error.detail));
        let status = serde_json::to_value(row.status).ok().and_then(|status| status.as_str().map(str::to_owned));
        let metric = |column: &String| {
            let value = row.metrics.as_ref().and_then(|metrics| metrics.pointer(column));
            value.map_or(String::new(), ToString::to_string)
        };
        let cells = values.chain([status.unwrap_or_default(), error]).chain(columns.iter().map(metric));
        lines.push(cells.collect::<Vec<_>>().join(","));
    }
    lines.push(String::new());
    lines.join("\n")
}

/// Whether a channel is the spindle's velocity, acceleration or displacement.
pub fn is_of_spindle(channel: &str, quantity: &str) -> bool {
    let parts: Vec<&str> = channel.split('.').collect();
    matches!(parts.as_slice(), ["spindle", _, of] if *of == quantity)
}

/// Two columns below their names.
fn csv(head: &str, first: &[f64], second: &[f64]) -> String {
    let mut text = String::with_capacity(32 * first.len());
    text.push_str(head);
    text.push('\n');
    for (a, b) in first.iter().zip(second) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{a},{b}");
    }
    text
}

/// A spectrum as CSV.
pub fn spectrum_csv(spectrum: &SpectrumAnswer) -> String {
    csv("frequency_hz,amplitude", &spectrum.frequency_hz, &spectrum.amplitude)
}

/// A series as CSV.
pub fn series_csv(series: &SeriesAnswer) -> String {
    csv("time_s,value", &series.time_s, &series.value)
}
