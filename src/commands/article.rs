//! `raceway article`: the article's figures made again and judged.

use serde_json::Value;

use super::local::{Directory, badly};
use super::{Ended, study};
use crate::article::{Evidence, Figure, Subject, document, figures, pictures};
use crate::config::ArticleOptions;
use crate::contract::{self, Outcome, Simulated, TableAnswer};
use crate::simulation::run::Control;

/// Folder of the plots beside the report.
const PLOTS: &str = "plots/article";

/// Runs the figures, one or all, and writes `ARTICLE.md` with its plots.
pub fn run(options: &ArticleOptions) -> Ended {
    let wanted = |figure: &Figure| options.figure.is_none_or(|number| shows(figure, number));
    let chosen: Vec<Figure> = figures().into_iter().filter(wanted).collect();
    if chosen.is_empty() {
        return badly("no run shows this figure: 5 to 16 are there");
    }
    let mut all = Vec::new();
    for figure in chosen {
        if !options.quiet {
            eprintln!("{}", figure.title);
        }
        match evidence(&figure, options.quiet) {
            Ok(evidence) => all.push((figure, evidence)),
            Err(why) => return badly(&format!("{}: {why}", figure.title)),
        }
    }
    let written = Directory::at(&options.output)
        .and_then(|directory| directory.write("ARTICLE.md", &document(&all, PLOTS)))
        .and_then(|()| Directory::at(&options.output.join(PLOTS)))
        .and_then(|plots| {
            let mut pictures = all.iter().flat_map(|(figure, evidence)| pictures(figure, evidence));
            pictures.try_for_each(|(name, svg)| plots.write(&name, &svg))
        });
    written.map_or_else(|error| badly(&error), |()| Ended::Well)
}

/// Figures 5 and 6, 7 and 8 are one run each.
fn shows(figure: &Figure, number: u32) -> bool {
    figure.number == number || matches!(figure.subject, Subject::Series { .. }) && figure.number + 1 == number
}

fn evidence(figure: &Figure, quiet: bool) -> Result<Evidence, String> {
    Ok(match &figure.subject {
        Subject::Series { job, .. } => Evidence::Run(Box::new(simulated(job)?)),
        Subject::Spectrum(lines) => Evidence::Runs(Box::new([simulated(&lines.job)?, simulated(&lines.unbalanced)?])),
        Subject::Trend { study, .. } => Evidence::Study(Box::new(table(study, quiet)?)),
        Subject::Comparison(both) => {
            Evidence::Studies(Box::new([table(&both.integrated, quiet)?, table(&both.deep_groove, quiet)?]))
        }
    })
}

fn simulated(job: &Value) -> Result<Simulated, String> {
    let job = contract::parse_job(job.to_string().as_bytes()).map_err(|refusal| refusal.to_string())?;
    match contract::execute(&job, &Control { stop: &|| false, progress: &|_| () }) {
        Ok(Outcome::Simulation(simulated)) => Ok(*simulated),
        Ok(_) => Err("no simulation".to_owned()),
        Err(failure) => Err(failure.to_string()),
    }
}

fn table(request: &Value, quiet: bool) -> Result<TableAnswer, String> {
    let job = contract::parse_job(request.to_string().as_bytes()).map_err(|refusal| refusal.to_string())?;
    let varied = job.study.as_ref().ok_or("no study")?;
    Ok(study::table_of(&job, varied, study::cores(), quiet))
}
