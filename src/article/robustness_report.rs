//! The report on the sampled parameter sets, and their table.

use std::fmt::Write;

use super::claims::{SHOWN, Verdict};
use super::robustness::{Judged, PARAMETERS, QUESTIONS, Set, influences};

/// Strength from which on a parameter counts as decisive [-]: with this number of parameters, chance alone reaches it for about one in a dozen.
const DECIDES: f64 = 4.0;
/// Optimal curvature according to the article.
const BEST_CURVATURE: (f64, f64) = (0.52, 0.53);

/// The sampled sets: number and seed.
#[derive(Debug, Clone, Copy)]
pub struct Chosen {
    pub sets: u32,
    pub seed: u64,
}

/// Number and seed of the published report.
pub const SETS: u32 = 200;
pub const SEED: u64 = 2025;

impl Chosen {
    /// The command that reproduces them.
    fn command(&self) -> String {
        let other = |name: &str, value: u64, usual: u64| {
            if value == usual { String::new() } else { format!(" --{name} {value}") }
        };
        let (sets, seed) = (other("sets", self.sets.into(), SETS.into()), other("seed", self.seed, SEED));
        format!("raceway article --robustness{sets}{seed} --output docs")
    }
}

/// The complete report in Markdown.
pub fn robustness_document(sets: &[Judged], chosen: &Chosen) -> String {
    let mut text = head(sets, chosen);
    overview(&mut text, sets);
    for (number, question) in QUESTIONS.iter().enumerate() {
        let _ = writeln!(text, "\n## Figure {}, {}\n", question.figure, question.title);
        shares(&mut text, sets, number);
        let scores: Vec<f64> = sets.iter().map(|set| set.score(number)).collect();
        text.push_str(
            "\nConfirmed share of the statement (partly confirmed counts half), by thirds of each parameter:\n\n",
        );
        thirds(&mut text, sets, &scores);
    }
    curvature(&mut text, sets);
    text
}

fn head(sets: &[Judged], chosen: &Chosen) -> String {
    let (seed, command) = (chosen.seed, chosen.command());
    let failed: u64 = sets.iter().map(|set| set.failed).sum();
    let mut text = format!(
        "# Do the article's statements hold for the parameters that it does not give?\n\n\
         The article names its bearing, its load and its speed, but not the mass of the spindle, the clearance, the damping, the traction, the lubricant, the unbalance or the mass of the cage. \
         [ARTICLE.md](ARTICLE.md) judges its statements with one value for each of these. Here they are put to {} sets of such values: a Latin hypercube over the ranges below, seed {seed}. \
         Written by `{command}`; all values and verdicts are in [robustness.csv](robustness.csv).\n\n\
         | not given | sampled from … to | why |\n|---|---|---|\n",
        sets.len()
    );
    for (parameter, why) in PARAMETERS.iter().zip(REASONS) {
        let (from, to) = parameter.range();
        let evenly = if parameter.is_logarithmic() { ", logarithmic" } else { "" };
        let unit = if parameter.unit.is_empty() { String::new() } else { format!(" {}", parameter.unit) };
        let _ = writeln!(text, "| {} | {from} … {to}{unit}{evenly} | {why} |", parameter.name);
    }
    let _ = write!(
        text,
        "\nEach set runs the studies of figures 10 to 16, each point 0.05 s after 0.02 s with the automatic model level (`auto`, within 0.05 dB). The criteria are those of the figures: \
         *in part* and *not shown* have the same meaning, and a trend smaller than ten times the error of its points counts as not shown. Failed points: {failed}. \
         The deep-groove bearing of Figure 16 has the same spindle mass here as the integrated one.\n"
    );
    text
}

const REASONS: [&str; PARAMETERS.len()] = [
    "steel shafts of 8.5 to 10.2 mm, 25 mm to 250 mm long, or with a rotor on them",
    "miniature bearings, C2 to C3",
    "nearly elastic to heavily damped by the grease",
    "greases and light oils between steel",
    "the article states ambient temperature and no oil: from a light base oil at 70 °C to a heavy one at 25 °C",
    "none, as in its equations, to the usual grade of small rotors",
    "crown cages of the same bearing, thin to thick",
];

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// Share of the sets that satisfy a condition.
fn share(sets: &[Judged], holds: impl Fn(&Judged) -> bool) -> f64 {
    sets.iter().filter(|set| holds(set)).count() as f64 / sets.len().max(1) as f64
}

fn overview(text: &mut String, sets: &[Judged]) {
    text.push_str("\n| figure, statement | shown in all four metrics | shown in at least one metric | not shown in any metric | most influential parameter |\n|---|---|---|---|---|\n");
    for (number, question) in QUESTIONS.iter().enumerate() {
        let verdicts = |set: &Judged| set.findings[number].iter().map(|finding| finding.verdict).collect::<Vec<_>>();
        let all = share(sets, |set| verdicts(set).iter().all(|verdict| *verdict == Verdict::Shown));
        let one = share(sets, |set| verdicts(set).contains(&Verdict::Shown));
        let none = share(sets, |set| verdicts(set).iter().all(|verdict| *verdict == Verdict::NotShown));
        let scores: Vec<f64> = sets.iter().map(|set| set.score(number)).collect();
        let _ = writeln!(
            text,
            "| {}, {} | {} | {} | {} | {} |",
            question.figure,
            question.title,
            percent(all),
            percent(one),
            percent(none),
            decider(sets, &scores)
        );
    }
}

fn values(sets: &[Judged]) -> Vec<Set> {
    sets.iter().map(|set| set.set).collect()
}

/// The parameter with the largest influence on a score, with its direction.
fn decider(sets: &[Judged], scores: &[f64]) -> String {
    let all = influences(&values(sets), scores);
    let strongest = PARAMETERS.iter().zip(&all).max_by(|a, b| a.1.strength.total_cmp(&b.1.strength));
    match strongest {
        Some((parameter, influence)) if influence.strength >= DECIDES => {
            let [low, middle, high] = influence.thirds.map(percent);
            format!("{}: {low}, {middle}, {high} shown in its lower, middle and upper third", parameter.name)
        }
        _ => "none beyond chance".to_owned(),
    }
}

fn shares(text: &mut String, sets: &[Judged], question: usize) {
    text.push_str("| metric | shown | in part | not shown | of these unresolved |\n|---|---|---|---|---|\n");
    for (metric, (name, ..)) in SHOWN.iter().enumerate() {
        let of = |verdict: Verdict| percent(share(sets, |set| set.findings[question][metric].verdict == verdict));
        let unresolved = percent(share(sets, |set| set.findings[question][metric].unresolved));
        let (shown, part, not) = (of(Verdict::Shown), of(Verdict::InPart), of(Verdict::NotShown));
        let _ = writeln!(text, "| {name} | {shown} | {part} | {not} | {unresolved} |");
    }
}

fn thirds(text: &mut String, sets: &[Judged], scores: &[f64]) {
    text.push_str("| parameter | lower | middle | upper | span over chance |\n|---|---|---|---|---|\n");
    for (parameter, influence) in PARAMETERS.iter().zip(influences(&values(sets), scores)) {
        let [low, middle, high] = influence.thirds.map(percent);
        let mark = if influence.strength >= DECIDES { "**" } else { "" };
        let _ = writeln!(
            text,
            "| {mark}{}{mark} | {low} | {middle} | {high} | {mark}{:.1}{mark} |",
            parameter.name, influence.strength
        );
    }
    let _ = writeln!(
        text,
        "\n*Span over chance*: the largest difference between two thirds, divided by its standard deviation for a parameter without influence. From {DECIDES:.0} on (bold) the parameter counts as decisive."
    );
}

/// Inner groove curvature of the lowest level.
fn curvature(text: &mut String, sets: &[Judged]) {
    let mut places: Vec<f64> = sets.iter().flat_map(|set| set.best_curvature).flatten().collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let is_inside = |at: Option<f64>| at.is_some_and(|at| (BEST_CURVATURE.0..=BEST_CURVATURE.1).contains(&at));
    let names = ["Y", "Z"];
    text.push_str("\n## Inner groove curvature of the lowest level\n\n| lowest level at |");
    let _ = write!(text, " {} | {} |", names[0], names[1]);
    text.push_str("\n|---|---|---|\n");
    for place in &places {
        let of = |direction: usize| percent(share(sets, |set| set.best_curvature[direction] == Some(*place)));
        let _ = writeln!(text, "| {place:.5} | {} | {} |", of(0), of(1));
    }
    let inside = [0, 1].map(|direction| share(sets, |set| is_inside(set.best_curvature[direction])));
    let _ = writeln!(
        text,
        "\nIt is within {} to {} for {} of the sets in Y and {} in Z. This range contains 4 of the 13 simulated curvatures, or 31 % if all were equally likely. By thirds of each parameter (share of the sets with the lowest level in Y in this range):\n",
        BEST_CURVATURE.0,
        BEST_CURVATURE.1,
        percent(inside[0]),
        percent(inside[1])
    );
    for (direction, name) in names.iter().enumerate() {
        if direction > 0 {
            let _ = writeln!(text, "\nIn {name}:\n");
        }
        let scores: Vec<f64> =
            sets.iter().map(|set| f64::from(u8::from(is_inside(set.best_curvature[direction])))).collect();
        thirds(text, sets, &scores);
    }
}

/// One row for each set: its values, the verdict on each metric of each figure, and the curvature of the lowest level.
pub fn robustness_csv(sets: &[Judged]) -> String {
    let short = ["velocity_y", "velocity_z", "level_y", "level_z"];
    let mut heads: Vec<String> = PARAMETERS.iter().map(|parameter| parameter.name.replace(',', "")).collect();
    heads.extend(
        QUESTIONS.iter().flat_map(|question| short.map(|metric| format!("figure_{}_{metric}", question.figure))),
    );
    heads.extend(["least_level_y_at_curvature", "least_level_z_at_curvature", "failed_points"].map(str::to_owned));
    let mut text = heads.join(",") + "\n";
    for set in sets {
        let mut cells: Vec<String> = set.set.iter().map(f64::to_string).collect();
        for finding in set.findings.iter().flatten() {
            let word = if finding.unresolved { "unresolved" } else { finding.verdict.words() };
            cells.push(word.to_owned());
        }
        cells.extend(set.best_curvature.map(|at| at.map_or(String::new(), |at| at.to_string())));
        cells.push(set.failed.to_string());
        text += &cells.join(",");
        text.push('\n');
    }
    text
}
