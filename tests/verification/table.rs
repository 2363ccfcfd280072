//! The table of `docs/VERIFICATION.md`, compared with the tests.

use std::path::Path;
use std::sync::OnceLock;

/// A file of this repository.
pub fn read(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// A row: `case` | input | expected | ours | difference | allowed | test.
struct Row {
    case: &'static str,
    expected: &'static str,
    ours: &'static str,
    difference: &'static str,
    allowed: &'static str,
    test: &'static str,
}

/// Cells of the table rows with this number of cells whose first one is a name in backticks.
fn lines(cells: usize) -> impl Iterator<Item = Vec<&'static str>> {
    static DOCUMENT: OnceLock<String> = OnceLock::new();
    DOCUMENT
        .get_or_init(|| read("docs/VERIFICATION.md"))
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| line.trim_matches('|').split('|').map(|cell| cell.trim().trim_matches('`')).collect::<Vec<_>>())
        .filter(move |line| line.len() == cells)
}

fn rows() -> impl Iterator<Item = Row> {
    lines(7).map(|line| {
        let [case, _input, expected, ours, difference, allowed, test] = line[..] else { unreachable!() };
        Row { case, expected, ours, difference, allowed, test }
    })
}

/// Compares a row with the computed numbers: `ours`, to the digits printed, and the largest relative difference from the
/// expected numbers, which must be within the allowed one.
pub fn check(case: &str, ours: &[f64]) {
    let row = rows().find(|row| row.case == case).unwrap_or_else(|| panic!("no row `{case}`"));
    compare(&row, &numbers(row.expected), ours);
}

/// Compares a row whose expected numbers are computed, too. The row must print both.
pub fn check_computed(case: &str, expected: &[f64], ours: &[f64]) {
    let row = rows().find(|row| row.case == case).unwrap_or_else(|| panic!("no row `{case}`"));
    let printed = like(row.expected, expected);
    assert_eq!(row.expected, printed, "`{case}`: expected are {expected:?}");
    compare(&row, expected, ours);
}

fn compare(row: &Row, expected: &[f64], ours: &[f64]) {
    assert_eq!(expected.len(), ours.len(), "`{}`", row.case);
    let apart = |(ours, expected): (&f64, &f64)| 100.0 * (ours / expected - 1.0);
    let largest = ours.iter().zip(expected).map(apart).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let difference = format!("{largest:+.*}", decimals(row.difference)).replace('-', "−");
    let zero = !difference.contains(|digit: char| ('1'..='9').contains(&digit));
    let difference = format!("{} %", if zero { difference.trim_start_matches(['+', '−']) } else { &difference });
    let cells = (like(row.ours, ours), difference);
    assert_eq!((row.ours, row.difference), (&*cells.0, &*cells.1), "`{}` is {ours:?}, {largest} % apart", row.case);
    let allowed = numbers(row.allowed)[0];
    assert!(largest.abs() <= allowed, "`{}` is {largest} % apart, {allowed} % are allowed", row.case);
}

/// The numbers of a cell without their units.
fn numbers(cell: &str) -> Vec<f64> {
    let number = |part: &str| part.split_whitespace().next().and_then(|number| number.replace('−', "-").parse().ok());
    cell.split(", ").map(|part| number(part).unwrap_or_else(|| panic!("no number in {part:?}"))).collect()
}

/// `values`, printed with as many digits as the numbers of `cell`.
fn like(cell: &str, values: &[f64]) -> String {
    let printed = cell.split(", ").zip(values).map(|(part, value)| format!("{value:.*}", decimals(part)));
    printed.collect::<Vec<_>>().join(", ").replace('-', "−")
}

fn decimals(number: &str) -> usize {
    let digits = number.split_once('.').map_or("", |(_, digits)| digits);
    digits.chars().take_while(char::is_ascii_digit).count()
}

/// Whether a file has this function, and this word in it.
fn has(file: &str, function: &str, word: &str) -> bool {
    read(file).split(&format!("fn {function}()")).nth(1).is_some_and(|rest| {
        let body = rest.split("\n#[test]").next().unwrap_or(rest);
        body.contains(word)
    })
}

/// Each row names a test that exists and compares that row. Tests that other tables name exist, too.
#[test]
fn every_row_is_held_by_its_test() {
    let mut cases: Vec<&str> = rows().map(|row| row.case).collect();
    assert!(cases.len() > 40, "{} rows", cases.len());
    for row in rows() {
        let (module, function) = row.test.split_once("::").unwrap_or_else(|| panic!("`{}`: {}", row.case, row.test));
        let file = format!("tests/verification/{module}.rs");
        assert!(has(&file, function, &format!("\"{}\"", row.case)), "`{}`: not in {}", row.case, row.test);
    }
    cases.sort_unstable();
    cases.dedup();
    assert_eq!(cases.len(), rows().count(), "a name stands twice");
    let elsewhere: Vec<_> = lines(3).collect();
    assert!(!elsewhere.is_empty());
    for line in elsewhere {
        let (file, function) = line[0].split_once("::").unwrap_or_else(|| panic!("{}", line[0]));
        assert!(has(file, function, ""), "no test {}", line[0]);
    }
}
