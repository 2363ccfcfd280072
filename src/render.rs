//! Answers as pictures and tables: what the service sends and the commands write.

use std::fmt::Write;

use crate::contract::work_precision::{PointAnswer, floors};
use crate::contract::{Metrics, SeriesAnswer, SpectrumAnswer, WorkPrecisionAnswer};
use crate::plots::{
    FailedRun, SeriesCurve, SpectrumCurve, WorkPoint, WorkPrecisionCurve, series_svg, spectrum_svg, work_precision_svg,
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
                relative_tolerance: point.relative_tolerance,
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
    work_precision_svg(title, &subtitle, &curves, [level, trajectory])
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
