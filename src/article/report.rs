//! The report: each figure with its plot, its statement, the findings and the verdict.

use std::fmt::Write;

use serde_json::Value;

use super::claims::{Finding, Verdict, compared, judged};
use super::figures::{Compared, Figure, Lines, Subject};
use crate::contract::{LineAnswer, Metrics, OptimumAnswer, Simulated, TableAnswer};
use crate::plots::draw;

/// Results of the jobs of a figure.
pub enum Evidence {
    Run(Box<Simulated>),
    Runs(Box<[Simulated; 2]>),
    Study(Box<TableAnswer>),
    Studies(Box<[TableAnswer; 2]>),
    Optima(Vec<OptimumAnswer>),
    /// Forces, as `forces` returns them.
    Forces(Vec<[f64; 4]>),
}

/// Names and texts of the plots of a figure.
pub fn pictures(figure: &Figure, evidence: &Evidence) -> Vec<(String, String)> {
    let name = |part: &str| format!("figure-{}{part}.svg", figure.number);
    match evidence {
        Evidence::Run(run) => vec![(name(""), draw::series(&run.series))],
        Evidence::Runs(runs) => {
            let spectrum = |run: &Simulated| {
                let amplitudes: Vec<_> = run.spectra.iter().filter(|s| s.is_amplitude()).cloned().collect();
                draw::spectra(&run.metrics, &amplitudes)
            };
            vec![(name(""), spectrum(&runs[0])), (name("-unbalanced"), spectrum(&runs[1]))]
        }
        Evidence::Optima(answers) => answers
            .iter()
            .enumerate()
            .map(|(k, answer)| (name(&format!("-optimum-{}", k + 1)), draw::optimum(answer)))
            .collect(),
        Evidence::Forces(forces) => vec![(name(""), draw::forces(forces))],
        Evidence::Study(table) => draw::trend(table).map(|svg| (name(""), svg)).into_iter().collect(),
        Evidence::Studies(tables) => {
            let titles = ["-integrated", "-deep-groove"];
            tables.iter().zip(titles).filter_map(|(table, part)| Some((name(part), draw::trend(table)?))).collect()
        }
    }
}

/// The complete report in Markdown; the plots are in a folder next to it.
pub fn document(all: &[(Figure, Evidence)], folder: &str) -> String {
    let rows: String = all
        .iter()
        .map(|(figure, evidence)| {
            let verdict = findings(figure, evidence).0;
            format!("| {} | {} | **{}** |\n", figure.title, figure.says, in_a_word(verdict))
        })
        .collect();
    let sections: String = all.iter().map(|(figure, evidence)| section(figure, evidence, folder)).collect();
    format!("{HEAD}| figure | the article | seen here |\n|---|---|---|\n{rows}{sections}")
}

/// The section of one figure.
pub fn document_of_one(all: &[(Figure, Evidence)], number: u32, folder: &str) -> String {
    let sections: String = all.iter().map(|(figure, evidence)| section(figure, evidence, folder)).collect();
    format!(
        "# Figure {number} of the article, made again and judged\n\nWritten by `raceway article --figure {number}`; how it is judged stands in the report on all figures, which `raceway article` writes.\n{sections}"
    )
}

fn in_a_word(verdict: Option<Verdict>) -> &'static str {
    verdict.map_or("to look at", Verdict::words)
}

fn section(figure: &Figure, evidence: &Evidence, folder: &str) -> String {
    let (verdict, findings) = findings(figure, evidence);
    let mut text = format!("\n## {}\n\n*The article:* {}\n\n", figure.title, figure.says);
    for (file, _) in pictures(figure, evidence) {
        let _ = writeln!(text, "![{}]({folder}/{file})\n", figure.title);
    }
    for finding in findings {
        let _ = writeln!(text, "- {}: {} – {}", finding.name, finding.seen, finding.verdict.words());
    }
    if let Some(runs) = runs(&figure.subject, evidence) {
        let _ = writeln!(text, "\n*Runs:* {runs}.");
    }
    let _ = writeln!(text, "\n*Verdict:* **{}**. {}", in_a_word(verdict), figure.remark);
    text
}

/// Number of runs, their duration and their model levels; `None` where nothing ran.
fn runs(subject: &Subject, evidence: &Evidence) -> Option<String> {
    let of = |request: &Value, count: String| {
        let seconds = |field: &str| request[field].as_f64().map_or(String::new(), |seconds| seconds.to_string());
        let rung = request["solver"]["rung"].as_str().unwrap_or("auto");
        let terms = if request["solver"]["model_tolerance_db"] == 0 { ", with every term" } else { "" };
        let (kept, settled) = (seconds("duration_s"), seconds("settle_s"));
        format!("{count}{kept} s kept after {settled} s of settling; rung `{rung}`{terms}")
    };
    let points = |points: usize| format!("{points} points, each ");
    Some(match (subject, evidence) {
        (Subject::Series { job, .. }, _) => of(job, String::new()),
        (Subject::Spectrum(lines), _) => of(&lines.job, "two, each ".into()),
        (Subject::Optimum { jobs, .. }, Evidence::Optima(answers)) => {
            let runs: u64 = answers.iter().map(|answer| answer.runs).sum();
            of(&jobs.first()?.1, points(runs as usize))
        }
        (Subject::Trend { study, .. }, Evidence::Study(table)) => of(study, points(table.rows.len())),
        (Subject::Comparison(both), Evidence::Studies(tables)) => {
            of(&both.integrated, points(tables.iter().map(|table| table.rows.len()).sum()))
        }
        _ => return None,
    })
}

const HEAD: &str = "\
# The article, made again and judged

Figures and Table 4 of Zhi, Zhai, Wen and Li, *Appl. Sci.* 2025, 15(1), 98, from runs of this program; each beside what the article says of it. Written by `raceway article --output docs`: no number is put in by hand, \
and nothing was tuned until a statement appeared. What the article does not give (spindle mass 50 g, clearance 5 µm, damping, traction, lubricant, cage mass) is that of the preset `article-integrated` ([PARAMETERS.md](PARAMETERS.md#presets)); other values can give other trends. \
Each value comes with its estimated error. A trend counts as resolved where no point is wrong by more than a tenth of its span; one that is not resolved is not shown. *Rises* and *falls* are told by the correlation of ranks: 0.98 and more all along, 0.7 and more mostly. \
*In part*: a rise that is there mostly; a valley without its best value where it is said, or the best value there without a valley; two bearings of which the one is lower at most speeds only, or that go different ways; a line that needs unbalance. A figure with several statements is shown where all are, not shown where none is even in part, and else shown in part. Whether the statements hold for other values of what is not given is in [ROBUSTNESS.md](ROBUSTNESS.md).

";

/// Verdict and findings; no verdict where the article makes no testable statement.
fn findings(figure: &Figure, evidence: &Evidence) -> (Option<Verdict>, Vec<Finding>) {
    let findings = match (&figure.subject, evidence) {
        (Subject::Trend { claim, .. }, Evidence::Study(table)) => judged(table, *claim),
        (Subject::Spectrum(lines), Evidence::Runs(runs)) => spectrum(lines, &runs[0].metrics, &runs[1].metrics),
        (Subject::Optimum { jobs, within }, Evidence::Optima(answers)) => {
            jobs.iter().zip(answers).map(|(job, answer)| optimum(job.0, answer, *within)).collect()
        }
        (Subject::Pocket { .. }, Evidence::Forces(forces)) => pocket(forces),
        (Subject::Comparison(Compared { .. }), Evidence::Studies(tables)) => compared(&tables[0], &tables[1]),
        _ => Vec::new(),
    };
    let verdicts: Vec<Verdict> = findings.iter().map(|finding| finding.verdict).collect();
    ((!findings.is_empty()).then(|| Verdict::of_all(&verdicts)), findings)
}

/// Whether the optimum of one axis is where the article states it, with a sufficiently small uncertainty.
fn optimum(name: &'static str, answer: &OptimumAnswer, (from, to): (f64, f64)) -> Finding {
    let value = |of: &serde_json::Map<String, Value>| of.values().find_map(Value::as_f64);
    let at = value(&answer.point).unwrap_or(f64::NAN);
    let band = answer.within.as_ref().and_then(|within| within.values().next().copied()).unwrap_or([f64::NAN; 2]);
    let rivals: Vec<f64> = answer.rivals.iter().filter_map(|rival| value(&rival.point)).collect();
    let is_inside = |at: &f64| (from..=to).contains(at);
    let all = || band.iter().chain(&rivals);
    let verdict = match (is_inside(&at), all().all(is_inside)) {
        (true, true) => Verdict::Shown,
        (true, false) => Verdict::InPart,
        (false, _) if all().any(is_inside) => Verdict::InPart,
        _ => Verdict::NotShown,
    };
    let error = answer.error.map_or(String::new(), |error| format!(" ± {error:.1e}"));
    let end = if answer.at_end_of_range.is_empty() { "" } else { ", the end of the range" };
    let others = match &rivals[..] {
        [] => String::new(),
        some => format!(
            "; as good it may be at {}",
            some.iter().map(|at| format!("{at:.5}")).collect::<Vec<_>>().join(", ")
        ),
    };
    let seen = format!(
        "{:.3}{error} dB at {at:.5}{end}, known to lie within {:.5} … {:.5}{others}; {} runs",
        answer.value, band[0], band[1], answer.runs
    );
    Finding { name, verdict, seen, unresolved: false }
}

/// The number with its sign, and with a minus sign instead of a hyphen.
fn signed(percent: f64) -> String {
    format!("{percent:+.1}").replace('-', "−")
}

/// Difference of the article's two forces.
const AGREED: f64 = 0.13;

fn pocket(forces: &[[f64; 4]]) -> Vec<Finding> {
    let worst = |place: usize| {
        let apart = forces.iter().map(|of| of[place] / of[1] - 1.0);
        apart.fold(0.0, |worst: f64, apart| if apart.abs() > worst.abs() { apart } else { worst })
    };
    let (law, hertz) = (worst(2), worst(3));
    let of = || forces.iter().map(|force| force[1]);
    let (from, to) = (of().fold(f64::INFINITY, f64::min), of().fold(0.0, f64::max));
    vec![
        Finding {
            name: "forces within 13 % of each other",
            verdict: if hertz.abs().max(law.abs()) <= AGREED { Verdict::Shown } else { Verdict::NotShown },
            seen: format!(
                "{} penetrations, {from:.2} to {to:.1} N; Hertz's contact, which nobody has fitted, is {} % off at worst, the law, which is fitted, {} %",
                forces.len(),
                signed(100.0 * hertz),
                signed(100.0 * law)
            ),
            unresolved: false,
        },
        Finding {
            name: "this validates the model",
            verdict: Verdict::NotShown,
            seen: "a static force of one contact says nothing about levels or lines; and what the wall of the pocket is held by moves the force by up to a factor of two".into(),
            unresolved: false,
        },
    ]
}

/// Largest relative deviation of a line from the stated frequency [-].
const NEAR: f64 = 0.01;

/// The strongest line near a frequency.
fn nearest(metrics: &Metrics, frequency: f64) -> Option<&LineAnswer> {
    let near = |line: &&LineAnswer| (line.frequency_hz / frequency - 1.0).abs() < NEAR;
    metrics.lines.iter().flatten().filter(near).max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))
}

fn spectrum(lines: &Lines, balanced: &Metrics, unbalanced: &Metrics) -> Vec<Finding> {
    let told = |line: Option<&LineAnswer>| {
        line.map_or("no line".to_owned(), |line| {
            let label = if line.label.is_empty() { "unnamed" } else { &line.label };
            format!("{:.1} Hz, {:.3} m/s² ({label}, {})", line.frequency_hz, line.amplitude, line.channel)
        })
    };
    let one = |&(frequency, name): &(f64, &'static str)| {
        let (here, there) = (nearest(balanced, frequency), nearest(unbalanced, frequency));
        let verdict = match (here, there) {
            (Some(_), _) => Verdict::Shown,
            (None, Some(_)) => Verdict::InPart,
            (None, None) => Verdict::NotShown,
        };
        Finding {
            name,
            verdict,
            unresolved: false,
            seen: format!("{frequency:.0} Hz: {}; with G 6.3: {}", told(here), told(there)),
        }
    };
    let strongest = |metrics: &Metrics| {
        let mut all: Vec<&LineAnswer> = metrics.lines.iter().flatten().collect();
        all.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        all.iter().take(4).map(|line| told(Some(line))).collect::<Vec<_>>().join("; ")
    };
    let mut findings: Vec<Finding> = lines.said.iter().map(one).collect();
    if let Some(last) = findings.last_mut() {
        last.seen += &format!(". The strongest lines here: {}", strongest(balanced));
    }
    findings
}
