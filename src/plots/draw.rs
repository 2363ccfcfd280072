//! Plots of results: of a simulation, a study, an optimum job and an accuracy job.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::loads::{LoadCurve, loads_svg};
use super::map::{MapPanel, map_svg};
use super::orbit::{OrbitCurve, orbit_svg};
use super::orders::{OrderPlot, TrackCurve, orders_svg};
use super::series::{SeriesCurve, TimeSpan, series_svg};
use super::spectrum::{SpectrumCurve, spectrum_svg};
use super::trend::{TrendCurve, TrendPanel, trend_svg};
use super::varied_axis::{AxisValues, VariedAxis};
use super::waterfall::{OrderLine, Waterfall};
use super::work_precision::{ErrorPanel, FailedRun, WorkPoint, WorkPrecisionCurve, work_precision_svg};
use crate::contract::answer::headings::{field_heading, metric_heading};
use crate::contract::answer::metrics::LineAnswer;
use crate::contract::answer::optimum::{PurposeName, RangeAnswer, RunAnswer};
use crate::contract::answer::orders::{OrderLineAnswer, OrdersAnswer, WaterfallAnswer, WaterfallAxis};
use crate::contract::answer::table::AxisAnswer;
use crate::contract::answer::views::{ImpactView, LoadsView, OrbitView, TraceView};
use crate::contract::answer::work_precision::mode_point::ModePointAnswer;
use crate::contract::answer::work_precision::point::PointAnswer;
use crate::contract::answer::work_precision::reference::floors;
use crate::contract::job::input::GoalName;
use crate::contract::job::orders::ReferenceName;
use crate::contract::job::outputs::EnvelopeName;
use crate::contract::job::statistic::words;
use crate::contract::json::numbers::{short, significant};
use crate::contract::{
    MachineAnswer, Metrics, ModePrecisionAnswer, OptimumAnswer, SeriesAnswer, Simulated, SpectrumAnswer, SpectrumKind,
    TableAnswer, WorkPrecisionAnswer,
};
use raceway_core::simulation::result::lines::Line;

/// A speed that varies over a run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct VaryingSpeed {
    /// Least and greatest shaft speed [r/min]; `None` where it is constant.
    pub range_rpm: Option<[f64; 2]>,
    /// True if the run has a waterfall.
    pub has_waterfall: bool,
}

/// The amplitude spectra of a job, with their labelled lines.
pub fn spectra(metrics: &Metrics, spectra: &[SpectrumAnswer], speed: VaryingSpeed) -> String {
    labelled_spectra("Vibration spectrum", metrics, metrics.lines.as_deref(), spectra, speed)
}

/// The envelope spectra of a job's accelerations, with their labelled lines.
pub fn envelopes(metrics: &Metrics, spectra: &[SpectrumAnswer], speed: VaryingSpeed) -> String {
    labelled_spectra(envelope_title(metrics.envelope), metrics, metrics.envelope_lines.as_deref(), spectra, speed)
}

fn envelope_title(envelope: Option<EnvelopeName>) -> &'static str {
    match envelope {
        Some(EnvelopeName::Squared) => "Squared-envelope spectrum",
        _ => "Envelope spectrum",
    }
}

fn labelled_spectra(
    title: &str,
    metrics: &Metrics,
    lines: Option<&[LineAnswer]>,
    spectra: &[SpectrumAnswer],
    speed: VaryingSpeed,
) -> String {
    let lines: Vec<Vec<Line>> =
        spectra.iter().map(|spectrum| lines_of(lines.unwrap_or_default(), &spectrum.channel)).collect();
    let curves = spectra.iter().zip(&lines).map(|(spectrum, lines)| SpectrumCurve {
        name: &spectrum.channel,
        unit: &spectrum.unit,
        resolution_hz: spectrum.resolution_hz,
        amplitude: &spectrum.amplitude,
        lines,
    });
    let curves = curves.collect::<Vec<_>>();
    if let Some(range) = speed.range_rpm {
        return smeared_svg(title, &curves, range, speed.has_waterfall);
    }
    let frequencies = &metrics.frequencies_hz;
    let subtitle = format!(
        "shaft {:.1} Hz, cage {:.1} Hz, BPFO {:.1} Hz, BPFI {:.1} Hz, ball spin {:.1} Hz",
        frequencies.shaft,
        frequencies.cage,
        frequencies.ball_pass_outer,
        frequencies.ball_pass_inner,
        frequencies.ball_spin
    );
    spectrum_svg(title, &subtitle, &curves, None)
}

/// Spectra of a run whose shaft has no single frequency.
fn smeared_svg(title: &str, curves: &[SpectrumCurve<'_>], [from, to]: [f64; 2], has_waterfall: bool) -> String {
    let subtitle = format!("shaft speed from {from:.0} to {to:.0} r/min: lines that follow it are smeared");
    spectrum_svg(title, &subtitle, curves, has_waterfall.then_some("waterfall.svg"))
}

/// True if the plots of a machine job show a channel: those of its sensors, or without any, of the bearings' inner rings along Y.
pub fn is_of_machine(channel: &str, has_sensors: bool) -> bool {
    if has_sensors { channel.starts_with("sensor.") } else { channel.ends_with(".y.acceleration") }
}

/// The spectra of a machine job, with their labelled lines.
pub fn machine_spectra(
    answer: &MachineAnswer,
    kind: SpectrumKind,
    spectra: &[SpectrumAnswer],
    speed: VaryingSpeed,
) -> String {
    let (title, lines) = match kind {
        SpectrumKind::Amplitude => ("Vibration spectrum", &answer.lines),
        SpectrumKind::Envelope => (envelope_title(answer.envelope), &answer.envelope_lines),
    };
    let has_sensors = answer.channels.keys().any(|channel| channel.starts_with("sensor."));
    let shown: Vec<&SpectrumAnswer> = spectra
        .iter()
        // A single one was asked for by its name.
        .filter(|spectrum| {
            spectrum.kind == kind && (spectra.len() == 1 || is_of_machine(&spectrum.channel, has_sensors))
        })
        .take(MOST_PANELS)
        .collect();
    let lines: Vec<Vec<Line>> = shown.iter().map(|spectrum| lines_of(lines, &spectrum.channel)).collect();
    let curves: Vec<SpectrumCurve<'_>> = shown
        .iter()
        .zip(&lines)
        .map(|(spectrum, lines)| SpectrumCurve {
            name: &spectrum.channel,
            unit: &spectrum.unit,
            resolution_hz: spectrum.resolution_hz,
            amplitude: &spectrum.amplitude,
            lines,
        })
        .collect();
    if let Some(range) = speed.range_rpm {
        return smeared_svg(title, &curves, range, speed.has_waterfall);
    }
    let of_bearings = answer.bearings.iter().map(|(name, bearing)| {
        let [outer, inner] = [bearing.ball_pass_outer_hz, bearing.ball_pass_inner_hz];
        format!("{name}: BPFO {outer:.1} Hz, BPFI {inner:.1} Hz")
    });
    let shaft = answer.bearings.values().next().map_or(0.0, |bearing| bearing.shaft_hz);
    let subtitle = format!("shaft {shaft:.1} Hz; {}", of_bearings.collect::<Vec<_>>().join("; "));
    spectrum_svg(title, &subtitle, &curves, None)
}

/// Most panels of a plot of a machine job.
const MOST_PANELS: usize = 4;

fn lines_of(lines: &[LineAnswer], channel: &str) -> Vec<Line> {
    let lines = lines.iter().filter(|line| line.channel == channel);
    lines
        .map(|line| Line {
            frequency: line.frequency_hz,
            amplitude: line.amplitude,
            label: line.label.clone(),
            deviation: line.deviation_hz,
        })
        .collect()
}

/// Paths of the spindle's and the cage's centre.
pub fn orbits(orbits: &[OrbitView]) -> String {
    let curves = orbits.iter().map(|orbit| OrbitCurve { name: &orbit.body, unit: "µm", y: &orbit.y, z: &orbit.z });
    orbit_svg(
        "Orbits",
        "paths of the centres over the last turns; y points downwards, as the load acts",
        &curves.collect::<Vec<_>>(),
    )
}

/// Raceway loads of ball 1 against its azimuth.
pub fn loads(loads: &LoadsView) -> String {
    let curve = |name, load| LoadCurve { name, azimuth: &loads.azimuth_deg, load };
    let curves = [curve("inner raceway", &loads.inner_n), curve("outer raceway", &loads.outer_n)];
    loads_svg("Loads of a ball along its way", "ball 1, turns over each other", &curves)
}

/// Longest part of a time series that a plot shows, from its beginning [s].
pub const LONGEST_SERIES_S: f64 = 1.0;

/// The beginning of time series, one panel for each channel.
pub fn series(series: &[SeriesAnswer]) -> String {
    let curves = series.iter().map(|series| {
        let begin = series.time_s.first().copied().unwrap_or_default();
        let shown = series.time_s.partition_point(|time| time - begin <= LONGEST_SERIES_S).min(series.value.len());
        SeriesCurve {
            name: &series.channel,
            unit: &series.unit,
            time_s: &series.time_s[..shown],
            value: &series.value[..shown],
        }
    });
    series_svg("Motion of the spindle", "time since the start of the run", &curves.collect::<Vec<_>>(), &[])
}

/// The acceleration around its largest peak, with the times at which balls are over defects.
pub fn impact(impact: &ImpactView) -> String {
    let series: Vec<SeriesAnswer> = impact.traces.iter().cloned().map(TraceView::series).collect();
    let curves = series.iter().map(|series| SeriesCurve {
        name: &series.channel,
        unit: &series.unit,
        time_s: &series.time_s,
        value: &series.value,
    });
    let spans: Vec<TimeSpan> = impact.passages_s.iter().map(|&(from_s, to_s)| TimeSpan { from_s, to_s }).collect();
    let subtitle = "three ball passages around the largest peak; shaded: a ball's centre over a defect";
    series_svg("Acceleration around an impact", subtitle, &curves.collect::<Vec<_>>(), &spans)
}

/// Error against run time, one curve for each method.
pub fn work_precision(answer: &WorkPrecisionAnswer) -> String {
    let mut curves: Vec<WorkPrecisionCurve<'_>> = Vec::new();
    for point in &answer.points {
        if curves.last().is_none_or(|curve| curve.name != point.method()) {
            curves.push(WorkPrecisionCurve { name: point.method(), points: Vec::new(), failures: Vec::new() });
        }
        let Some(curve) = curves.last_mut() else { continue };
        match point {
            PointAnswer::Succeeded(point) => curve.points.push(WorkPoint {
                label: Some(format!("{:e}", point.relative_tolerance)),
                time_s: point.wall_time_s,
                errors: [
                    point.level_error_db.map(|error| (error, !point.level_below_reference)),
                    point.trajectory_error.map(|error| (error, !point.below_reference)),
                ],
            }),
            PointAnswer::Failed(point) => curve
                .failures
                .push(FailedRun { label: format!("{:e}", point.relative_tolerance), time_s: point.wall_time_s }),
        }
    }
    let (reference, compared) = (&answer.reference, &answer.compared);
    let subtitle = format!(
        "Error against run time: {} s after {} s; reference {} at {:e}",
        compared.duration_s, compared.settle_s, reference.method, reference.relative_tolerance
    );
    let (trajectory, level) = floors(reference);
    // Results of older versions do not name their scene.
    let title = if compared.scene.is_empty() { "Error against run time" } else { &compared.scene };
    let panels = [
        ErrorPanel { name: "Error of the level, worst of all axes", unit: "dB", floor: level },
        ErrorPanel { name: "Error of the trajectory", unit: "rms, in standard deviations", floor: trajectory },
    ];
    work_precision_svg([title, &subtitle, "relative tolerances"], &curves, panels)
}

/// Error against run time for the number of modes: one curve for each bearing, sensor and body, of its largest error.
pub fn mode_precision(answer: &ModePrecisionAnswer) -> String {
    let part = |channel: &'_ str| match channel.strip_prefix("sensor.") {
        Some(rest) => rest.split('.').next().unwrap_or_default().to_owned(),
        None => channel.split('.').next().unwrap_or_default().to_owned(),
    };
    let mut parts: Vec<String> = Vec::new();
    for name in answer.reference.levels_db.keys().map(|channel| part(channel)) {
        if !parts.contains(&name) {
            parts.push(name);
        }
    }
    let mut points: Vec<&ModePointAnswer> = answer.points.iter().collect();
    points.sort_by(|one, other| one.mode_range().total_cmp(&other.mode_range()));
    let curve = |name: &'_ String| {
        let largest = |errors: &BTreeMap<String, f64>| {
            let of_part = errors.iter().filter(|(channel, _)| part(channel) == *name);
            of_part.map(|(_, error)| (*error, true)).reduce(|one, other| if other.0 > one.0 { other } else { one })
        };
        let measured = points.iter().filter_map(|point| point.measured()).map(|point| WorkPoint {
            label: Some(short(point.mode_range)),
            time_s: point.wall_time_s,
            errors: [largest(&point.level_errors_db), largest(&point.mode_errors_db)],
        });
        (name.clone(), measured.collect())
    };
    let curves: Vec<(String, Vec<WorkPoint>)> = parts.iter().map(curve).collect();
    let mut curves: Vec<WorkPrecisionCurve<'_>> = curves
        .iter()
        .map(|(name, points)| WorkPrecisionCurve { name, points: points.clone(), failures: Vec::new() })
        .collect();
    let failure = |point: &&ModePointAnswer| match point {
        ModePointAnswer::Failed(of) => Some(FailedRun { label: short(of.mode_range), time_s: Some(of.wall_time_s) }),
        ModePointAnswer::Succeeded(_) => None,
    };
    let failures: Vec<FailedRun> = points.iter().filter_map(failure).collect();
    if !failures.is_empty() {
        curves.push(WorkPrecisionCurve { name: "run", points: Vec::new(), failures });
    }
    let (reference, compared) = (&answer.reference, &answer.compared);
    let subtitle = format!(
        "Error against run time: {} s after {} s; reference: modes to {} × 20 kHz, {} µs",
        compared.duration_s,
        compared.settle_s,
        short(reference.mode_range),
        short(reference.step_us)
    );
    let panels = [
        ErrorPanel { name: "Error of the level, modes and step together", unit: "dB", floor: None },
        ErrorPanel { name: "Error of the level by the modes left out", unit: "dB", floor: None },
    ];
    work_precision_svg([&compared.scene, &subtitle, "highest kept modes over 20 kHz"], &curves, panels)
}

/// Number of panels of a trend from which on no further quantity is added.
const MAX_PANELS: usize = 4;

/// Quantities in plots of a study, each with its unit, and their metrics with short names. Plots show the first two that the results
/// contain.
const SHOWN: [(&str, &[(&str, &str)]); 4] = [
    (
        "velocity, rms, in mm/s",
        &[("spindle Y", "/channels/spindle.y.velocity/rms"), ("spindle Z", "/channels/spindle.z.velocity/rms")],
    ),
    (
        "acceleration level in dB re 9.81 mm/s²",
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

fn places(axis: &AxisAnswer) -> AxisValues {
    let numbers: Option<Vec<f64>> = axis.values.iter().map(Value::as_f64).collect();
    let word = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    numbers.map_or_else(|| AxisValues::Names(axis.values.iter().map(word).collect()), AxisValues::Numbers)
}

fn counted(table: &TableAnswer) -> String {
    let failed = table.ended - table.succeeded;
    let failed = if failed > 0 { format!(", {failed} of them failed") } else { String::new() };
    let statistic =
        table.statistic.as_ref().map_or(String::new(), |of| format!("; {} over uncertain inputs", words(of)));
    format!("{} of {} points{failed}{statistic}", table.ended, table.points)
}

/// Metrics of a study against its axis; `None` for several axes.
pub fn trend(table: &TableAnswer) -> Option<String> {
    let [axis] = &table.axes[..] else { return None };
    let mut panels = Vec::new();
    for (quantity, metrics) in SHOWN {
        let curves = metrics.iter().map(|(name, pointer)| TrendCurve { name, values: table.column(pointer) });
        let curves = curves.filter(|curve| curve.values.iter().any(Option::is_some));
        // One panel for each metric: on a common scale the larger one would hide changes of the smaller one.
        let of_quantity = curves.map(|curve| TrendPanel { quantity, curves: vec![curve], best: None, band: None });
        if panels.len() < MAX_PANELS {
            panels.extend(of_quantity);
        }
    }
    let name = field_heading(&axis.axis);
    let varied = VariedAxis { name: &name, values: places(axis) };
    Some(trend_svg(&format!("Trend over {name}"), &counted(table), &varied, &panels))
}

/// Metrics of a study against its two axes; `None` for another number of axes.
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
            let rows = up.values.len().max(1);
            let best = best.map(|point| [(point / rows) as f64, (point % rows) as f64]);
            panels.push(MapPanel { name, values, best, runs: Vec::new() });
        }
    }
    let names = [right, up].map(|axis| field_heading(&axis.axis));
    let axes =
        [VariedAxis { name: &names[0], values: places(right) }, VariedAxis { name: &names[1], values: places(up) }];
    Some(map_svg(&format!("{} and {}", names[0], names[1]), &counted(table), [&axes[0], &axes[1]], &panels))
}

/// Runs of an optimum job with their errors, and the best of them. For one axis: a curve with the interval of the optimum. For two axes: a
/// map of the scan, with a dot for each other run.
pub fn optimum(answer: &OptimumAnswer) -> String {
    let metric = metric_heading(&answer.metric);
    // The axis shows the unit.
    let named = metric.rsplit_once(" in ").map_or(&*metric, |(named, _)| named);
    let of = answer.statistic.as_ref().map_or(String::new(), |statistic| format!("{} of ", words(statistic)));
    let title = format!("{} of {of}{named}", if answer.goal == GoalName::Minimum { "Minimum" } else { "Maximum" });
    let place = |axis: &RangeAnswer| {
        let within = answer.within.as_ref().and_then(|within| within.get(&axis.axis));
        let within = within.map_or(String::new(), |[low, high]| format!(" ({low} … {high})"));
        format!("{}{within}", along(&answer.point, &axis.axis))
    };
    let places: Vec<String> = answer.axes.iter().map(place).collect();
    let error = answer.error.map_or(String::new(), |error| format!(" ± {error:.1e}"));
    let subtitle = format!("{:.4}{error} at {}; {} runs", answer.value, places.join(", "), answer.runs);
    match &answer.axes[..] {
        [right, up] => optimum_map(answer, (&title, &subtitle, &metric), [right, up]),
        [axis] => optimum_trend(answer, (&title, &subtitle, &metric), axis),
        _ => String::new(),
    }
}

/// The value of a point on an axis.
fn along(point: &Map<String, Value>, axis: &str) -> f64 {
    point.get(axis).and_then(Value::as_f64).unwrap_or(f64::NAN)
}

fn optimum_trend(answer: &OptimumAnswer, (title, subtitle, metric): (&str, &str, &str), range: &RangeAnswer) -> String {
    let at = |run: &RunAnswer| along(&run.point, &range.axis);
    let mut runs: Vec<&RunAnswer> = answer.evaluations.iter().collect();
    runs.sort_by(|a, b| at(a).total_cmp(&at(b)));
    let values = runs.iter().map(|run| run.value.map(|value| (value, run.error))).collect();
    let panel = TrendPanel {
        // The title contains the complete name.
        quantity: metric.rsplit(": ").next().unwrap_or(metric),
        curves: vec![TrendCurve { name: if answer.statistic.is_some() { "every point" } else { "every run" }, values }],
        best: runs.iter().position(|run| run.point == answer.point),
        band: answer.within.as_ref().and_then(|within| within.get(&range.axis).copied()),
    };
    let places = AxisValues::Numbers(runs.iter().map(|run| at(run)).collect());
    let axis = VariedAxis { name: &field_heading(&range.axis), values: places };
    trend_svg(title, subtitle, &axis, &[panel])
}

fn optimum_map(
    answer: &OptimumAnswer,
    (title, subtitle, metric): (&str, &str, &str),
    ranges: [&RangeAnswer; 2],
) -> String {
    let (scan, others): (Vec<&RunAnswer>, Vec<&RunAnswer>) =
        answer.evaluations.iter().partition(|run| run.purpose == PurposeName::Scan);
    let both = ranges.map(|range| {
        let mut values: Vec<f64> = scan.iter().map(|run| along(&run.point, &range.axis)).collect();
        values.sort_by(|a, b| if range.from < range.to { a.total_cmp(b) } else { b.total_cmp(a) });
        values.dedup();
        values
    });
    let place = |point: &Map<String, Value>| {
        let at = |axis: usize| fields_along(&both[axis], along(point, &ranges[axis].axis));
        [at(0), at(1)]
    };
    let panel = MapPanel {
        name: metric,
        values: scan.iter().map(|run| run.value).collect(),
        best: Some(place(&answer.point)),
        runs: others.iter().map(|run| place(&run.point)).collect(),
    };
    let names = ranges.map(|range| field_heading(&range.axis));
    let [right, up] = both.map(AxisValues::Numbers);
    let axes = [VariedAxis { name: &names[0], values: right }, VariedAxis { name: &names[1], values: up }];
    map_svg(title, subtitle, [&axes[0], &axes[1]], &[panel])
}

/// Position of a value among ordered values, in intervals from the first one.
fn fields_along(values: &[f64], value: f64) -> f64 {
    let between = |pair: &[f64]| (value - pair[0]) * (value - pair[1]) <= 0.0;
    let found = values.windows(2).position(between);
    found.map_or(0.0, |place| place as f64 + (value - values[place]) / (values[place + 1] - values[place]))
}

/// Pocket force of the model and of Hertz's contact alone, both divided by that of finite elements.
pub fn forces(forces: &[[f64; 4]]) -> String {
    let curve = |name, place: usize| TrendCurve {
        name,
        values: forces.iter().map(|of| Some((of[place] / of[1], None))).collect(),
    };
    let curves = vec![curve("law of the model", 2), curve("Hertz alone", 3)];
    let panel = TrendPanel { quantity: "force over that of finite elements", curves, best: None, band: None };
    let axis =
        VariedAxis { name: "penetration in µm", values: AxisValues::Numbers(forces.iter().map(|of| of[0]).collect()) };
    trend_svg("Ball in its pocket", "forces over those of CalculiX, converged", &axis, &[panel])
}

/// All plots of a simulation but those of orders, by their names in the service; plots without data are omitted.
pub fn pictures(simulated: &Simulated, has_waterfall: bool) -> Vec<(&'static str, String)> {
    let Simulated { metrics, spectra: kept, series: whole, views, varying_speed_rpm } = simulated;
    let speed = VaryingSpeed { range_rpm: *varying_speed_rpm, has_waterfall };
    let amplitudes = kept.iter().filter(|spectrum| spectrum.kind == SpectrumKind::Amplitude);
    let amplitudes: Vec<SpectrumAnswer> = amplitudes.cloned().collect();
    let enveloped =
        kept.iter().filter(|one| one.kind == SpectrumKind::Envelope && is_of_spindle(&one.channel, "acceleration"));
    let enveloped: Vec<SpectrumAnswer> = enveloped.cloned().collect();
    let motion = |quantity| {
        let whole = whole.iter().map(SeriesAnswer::of).filter(|series| is_of_spindle(&series.channel, quantity));
        let thinned = views.traces.iter().filter(|trace| is_of_spindle(&trace.channel, quantity));
        let shown: Vec<SeriesAnswer> = whole.collect();
        let shown = if shown.is_empty() { thinned.cloned().map(TraceView::series).collect() } else { shown };
        (!shown.is_empty()).then(|| series(&shown))
    };
    let pictures = [
        ("spectrum.svg", (!amplitudes.is_empty()).then(|| spectra(metrics, &amplitudes, speed))),
        ("velocity.svg", motion("velocity")),
        ("acceleration.svg", motion("acceleration")),
        ("orbit.svg", (!views.orbits.is_empty()).then(|| orbits(&views.orbits))),
        ("loads.svg", views.loads.as_ref().map(loads)),
        ("envelope.svg", (!enveloped.is_empty()).then(|| envelopes(metrics, &enveloped, speed))),
        ("impact.svg", views.impact.as_ref().map(impact)),
    ];
    pictures.into_iter().filter_map(|(name, picture)| Some((name, picture?))).collect()
}

/// Orders of a run: mean order spectrum, and tracks over speed.
pub fn orders(answer: &OrdersAnswer) -> String {
    let tracks: Vec<TrackCurve<'_>> = answer
        .tracks
        .iter()
        .map(|track| TrackCurve { name: &track.name, order: track.order, amplitude: &track.amplitude })
        .collect();
    let subtitle = format!(
        "{}: {} blocks of {} turns of the {}, {} turns in all",
        answer.channel,
        answer.averages,
        answer.turns_per_block,
        answer.reference.name(),
        significant(answer.turns, 5)
    );
    let plot = OrderPlot {
        reference: answer.reference.name(),
        unit: &answer.unit,
        resolution: answer.resolution,
        amplitude: &answer.amplitude,
        speed: &answer.speed_rpm,
        tracks: &tracks,
    };
    orders_svg("Orders", &subtitle, &plot)
}

/// Range of amplitudes that a waterfall shows unless another is asked for [dB].
pub const WATERFALL_RANGE_DB: f64 = 60.0;

/// A waterfall with axes and labelled orders.
pub fn waterfall(answer: &WaterfallAnswer, range_db: f64) -> String {
    let subtitle = match (answer.window_s, answer.smear_bins, answer.turns_per_block) {
        (Some(window), Some(smear), _) => {
            format!("{}: windows of {:.3} s, in which BPFI moves by {smear:.2} bins", answer.channel, window)
        }
        (_, _, Some(turns)) => {
            format!("{}: blocks of {turns} turns of the {}", answer.channel, answer.reference.name())
        }
        _ => answer.channel.clone(),
    };
    plain_waterfall(answer).svg("Waterfall", &subtitle, range_db)
}

/// The colours of a waterfall as a PNG file.
pub fn waterfall_png(answer: &WaterfallAnswer, (width, height): (usize, usize), range_db: f64) -> Vec<u8> {
    plain_waterfall(answer).picture(width, height, range_db).png()
}

fn plain_waterfall(answer: &WaterfallAnswer) -> Waterfall<'_> {
    let by_frequency = answer.axis_unit == WaterfallAxis::Hz;
    let line = |line: &'_ OrderLineAnswer| {
        let at = |speed: &f64| if by_frequency { line.order * speed / 60.0 } else { line.order };
        answer.speed_rpm.iter().map(at).collect()
    };
    Waterfall {
        axis_name: match (by_frequency, answer.reference) {
            (true, _) => "frequency in Hz",
            (false, ReferenceName::Shaft) => "order of the shaft",
            (false, ReferenceName::Cage) => "order of the cage",
        },
        speed: &answer.speed_rpm,
        time: &answer.time_s,
        resolution: answer.resolution,
        columns: answer.axis.len(),
        amplitude: &answer.amplitude,
        unit: &answer.unit,
        lines: answer.order_lines.iter().map(|of| OrderLine { name: &of.name, at: line(of) }).collect(),
    }
}

/// True if a channel is the spindle's velocity, acceleration or displacement.
pub fn is_of_spindle(channel: &str, quantity: &str) -> bool {
    let parts: Vec<&str> = channel.split('.').collect();
    matches!(parts.as_slice(), ["spindle", _, of] if *of == quantity)
}
