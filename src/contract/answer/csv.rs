//! Spectra, series and tables as CSV, and series as NumPy array files.

use std::io::Write;

use serde_json::Value;

use super::signals::{SeriesAnswer, SpectrumAnswer};
use super::table::TableAnswer;

/// A study as CSV: axes, status, error, text fields of the metrics, then every number of the metrics, each under its pointer.
pub fn table_csv(table: &TableAnswer) -> String {
    let heads = ["status", "error"].into_iter().chain(table.text_columns());
    let columns = table.columns();
    let axes = || table.axes.iter().map(|axis| &axis.axis);
    let heads = axes().map(|axis| quoted(axis)).chain(heads.map(quoted)).chain(columns.iter().map(|head| quoted(head)));
    let mut lines = vec![heads.collect::<Vec<_>>().join(",")];
    for row in &table.rows {
        let values = axes().map(|axis| row.point.get(axis).map_or(String::new(), cell));
        let status = serde_json::to_value(row.status).map_or(String::new(), |status| cell(&status));
        let error = row.error.as_ref().map_or(String::new(), |error| quoted(&error.detail));
        let metric =
            |column| row.metrics.as_ref().and_then(|metrics| metrics.pointer(column)).map_or(String::new(), cell);
        let texts = table.text_columns().into_iter().map(metric);
        let cells = values.chain([status, error]).chain(texts).chain(columns.iter().map(|column| metric(column)));
        lines.push(cells.collect::<Vec<_>>().join(","));
    }
    lines.push(String::new());
    lines.join("\n")
}

/// A table cell: text as it is, numbers as in JSON.
fn cell(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), quoted)
}

/// The text, in quotation marks where it contains commas, line ends or quotation marks.
pub(super) fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// The heads of two columns, the second with channel and unit.
fn heads(first: &str, channel: &str, unit: &str) -> String {
    format!("{first},{}\n", quoted(&format!("{channel} [{unit}]")))
}

/// Writes one line of two columns.
pub fn write_line(first: f64, second: f64, to: &mut Vec<u8>) {
    // Writing to memory cannot fail.
    let _ = writeln!(to, "{first},{second}");
}

/// Two columns under their heads.
fn csv(heads: String, columns: [&[f64]; 2]) -> String {
    let mut text = heads.into_bytes();
    text.reserve(32 * columns[0].len());
    columns[0].iter().zip(columns[1]).for_each(|(a, b)| write_line(*a, *b, &mut text));
    String::from_utf8(text).unwrap_or_default()
}

/// A spectrum as CSV.
pub fn spectrum_csv(spectrum: &SpectrumAnswer) -> String {
    csv(heads("frequency_hz", &spectrum.channel, &spectrum.unit), [&spectrum.frequency_hz, &spectrum.amplitude])
}

/// The head of a NumPy array file with records of `time_s` and `value`.
pub fn npy_head(count: usize) -> Vec<u8> {
    npy_head_of("[('time_s', '<f8'), ('value', '<f8')]", &format!("({count},)"))
}

/// A table of numbers in single precision as a NumPy array file.
pub fn npy_table(rows: usize, columns: usize, values: impl Iterator<Item = f32>) -> Vec<u8> {
    let mut bytes = npy_head_of("'<f4'", &format!("({rows}, {columns})"));
    values.for_each(|value| bytes.extend(value.to_le_bytes()));
    bytes
}

/// The head of a NumPy array file, version 1.0.
fn npy_head_of(values: &str, shape: &str) -> Vec<u8> {
    let head = format!("{{'descr': {values}, 'fortran_order': False, 'shape': {shape}, }}");
    // Magic number, version and length take ten bytes; the header ends in a line feed, at a multiple of 64 bytes.
    let padded = (10 + head.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((padded as u16).to_le_bytes());
    bytes.extend(format!("{head:<0$}\n", padded - 1).into_bytes());
    bytes
}

/// Size of a record of a NumPy array file [B].
pub const NPY_RECORD_BYTES: usize = 2 * size_of::<f64>();

/// Writes one record of a NumPy array file.
pub fn write_record(time: f64, value: f64, to: &mut Vec<u8>) {
    to.extend(time.to_le_bytes());
    to.extend(value.to_le_bytes());
}

/// The heads of a series as CSV.
pub fn series_head(channel: &str, unit: &str) -> String {
    heads("time_s", channel, unit)
}

/// A series as CSV.
pub fn series_csv(series: &SeriesAnswer) -> String {
    csv(series_head(&series.channel, &series.unit), [&series.time_s, &series.value])
}
