//! `raceway article`: the article's figures reproduced and compared with the article.

use raceway_core::simulation::input::control::Control;
use serde_json::Value;

use super::exit::{Exit, failed};
use super::output_directory::OutputDirectory;
use super::{parallel_map, progress, study};
use crate::article::{
    Chosen, Evidence, Figure, Judged, SEED, SETS, Subject, document, document_of_one, figures, forces, pictures,
    robustness_csv, robustness_document, sampled, studies,
};
use crate::config::ArticleOptions;
use crate::contract::{self, Job, OptimumAnswer, Outcome, Simulated, Study, TableAnswer};

/// Folder of the plots beside the report.
const PLOTS: &str = "plots/article";

/// Writes `article.md` of all figures, or `FIGURE-N.md` of one, with plots; with `robustness` writes `robustness.md` of the sampled sets.
pub fn run(options: &ArticleOptions) -> Exit {
    if options.robustness {
        return robustness(options);
    }
    if options.sets.is_some() || options.seed.is_some() {
        return failed("--sets and --seed need --robustness");
    }
    let wanted = |figure: &Figure| options.figure.is_none_or(|number| shows(figure, number));
    let chosen: Vec<Figure> = figures().into_iter().filter(wanted).collect();
    if chosen.is_empty() {
        return failed("no run reproduces this figure; the figures are 5 to 18");
    }
    let output = match OutputDirectory::open(&options.output) {
        Ok(output) => output,
        Err(error) => return failed(&error),
    };
    let mut all = Vec::new();
    for figure in chosen {
        if !options.quiet {
            eprintln!("{}", figure.title);
        }
        match evidence(&figure, options.quiet) {
            Ok(evidence) => all.push((figure, evidence)),
            Err(why) => return failed(&format!("{}: {why}", figure.title)),
        }
    }
    let (file, text) = match options.figure {
        None => ("article.md".to_owned(), document(&all, PLOTS)),
        Some(number) => (format!("FIGURE-{number}.md"), document_of_one(&all, number, PLOTS)),
    };
    let written = output
        .write(&file, &text)
        .and_then(|()| OutputDirectory::open(&options.output.join(PLOTS)))
        .and_then(|plots| {
            let mut pictures = all.iter().flat_map(|(figure, evidence)| pictures(figure, evidence));
            pictures.try_for_each(|(name, svg)| plots.write(&name, &svg))
        });
    written.map_or_else(|error| failed(&error), |()| Exit::Success)
}

/// Returns whether a run reproduces a figure. Figures 5 and 6 are one run, 7 and 8 another, 17 and 18 one comparison.
fn shows(figure: &Figure, number: u32) -> bool {
    let two = matches!(figure.subject, Subject::Series { .. } | Subject::Pocket { .. });
    figure.number == number || two && figure.number + 1 == number
}

fn evidence(figure: &Figure, quiet: bool) -> Result<Evidence, String> {
    Ok(match &figure.subject {
        Subject::Series { job, .. } => Evidence::Run(Box::new(simulated(job)?)),
        Subject::Spectrum(lines) => Evidence::Runs(Box::new([simulated(&lines.job)?, simulated(&lines.unbalanced)?])),
        Subject::Optimum { jobs, .. } => Evidence::Optima(optima(jobs)?),
        Subject::Pocket { scene, case } => Evidence::Forces(forces(scene, case)?),
        Subject::Trend { study, .. } => Evidence::Study(Box::new(table(study, quiet)?)),
        Subject::Comparison(both) => {
            Evidence::Studies(Box::new([table(&both.integrated, quiet)?, table(&both.deep_groove, quiet)?]))
        }
    })
}

fn parsed(request: &Value) -> Result<Job, String> {
    contract::parse_job(request.to_string().as_bytes()).map_err(|refusal| refusal.to_string())
}

fn outcome(request: &Value) -> Result<Outcome, String> {
    let control = Control::until(&|| false);
    contract::execute(&parsed(request)?, &control).map_err(|failure| failure.to_string())
}

fn simulated(request: &Value) -> Result<Simulated, String> {
    match outcome(request)? {
        Outcome::Simulation(simulated) => Ok(*simulated),
        _ => Err("the job is not a simulation".to_owned()),
    }
}

/// The optima of several searches. The runs of one search are sequential, so the searches run in parallel.
fn optima(jobs: &[(&str, Value)]) -> Result<Vec<OptimumAnswer>, String> {
    let answers =
        parallel_map::map(jobs.len(), parallel_map::cores(), &|_| (), |number| match outcome(&jobs[number].1)? {
            Outcome::Optimum(answer) => Ok(*answer),
            _ => Err("the job is not of kind optimum".to_owned()),
        });
    answers.into_iter().collect()
}

fn table(request: &Value, quiet: bool) -> Result<TableAnswer, String> {
    let job = parsed(request)?;
    let Job::Study(varied) = &job else { return Err("the job is not of kind study".to_owned()) };
    Ok(study::table_of(&job, varied, parallel_map::cores(), quiet))
}

/// Runs all points of all studies of all sets.
fn robustness(options: &ArticleOptions) -> Exit {
    let chosen = Chosen { sets: options.sets.unwrap_or(SETS), seed: options.seed.unwrap_or(SEED) };
    let sets = sampled(chosen.sets as usize, chosen.seed);
    let of_set = |set| {
        studies(set)
            .iter()
            .map(|request| parsed(request)?.into_study().ok_or("the job is not of kind study".to_owned()))
            .collect()
    };
    let varied: Vec<Vec<Study>> = match sets.iter().map(of_set).collect::<Result<_, _>>() {
        Ok(varied) => varied,
        Err(why) => return failed(&why),
    };
    let all: Vec<(&Study, usize)> =
        varied.iter().flatten().flat_map(|study| (0..study.points).map(move |point| (study, point))).collect();
    let output = match OutputDirectory::open(&options.output) {
        Ok(output) => output,
        Err(error) => return failed(&error),
    };
    let announcement = || format!("{} sets, {} runs of tens to hundreds of milliseconds each", sets.len(), all.len());
    let rows = progress::announced(announcement, options.quiet, |progress| {
        parallel_map::map(all.len(), parallel_map::cores(), progress, |number| {
            study::row_of(all[number].0, all[number].1)
        })
    });
    let mut rows = rows.into_iter();
    let judged = sets.iter().zip(&varied).map(|(set, studies)| {
        let table = |study: &Study| TableAnswer::of(study, rows.by_ref().take(study.points).collect());
        Judged::of(*set, &studies.iter().map(table).collect::<Vec<_>>())
    });
    let judged: Vec<Judged> = judged.collect();
    let written = output
        .write("robustness.md", &robustness_document(&judged, &chosen))
        .and_then(|()| output.write("robustness.csv", &robustness_csv(&judged)));
    written.map_or_else(|error| failed(&error), |()| Exit::Success)
}
