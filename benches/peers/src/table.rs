//! The two tables of a report, in Markdown that is readable as plain text.

use crate::scenes::Deviation;
use crate::solver::{Failure, Work};

/// A solver at a tolerance.
pub struct Row {
    pub solver: String,
    pub relative: f64,
    pub outcome: Result<Point, Failure>,
}

/// Result of a solver at a tolerance.
pub struct Point {
    /// Times of the runs [s].
    pub wall: Vec<f64>,
    pub processor: Vec<f64>,
    pub deviation: Deviation,
    pub work: Work,
    pub rhs: u64,
    /// Detail of the method that the name of the solver does not contain.
    pub ran: Option<String>,
}

/// Kind of time by which solvers are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Clock {
    /// Processor time of all threads, which depends less on other processes of the machine.
    Processor,
    Wall,
}

impl Point {
    fn time(&self, clock: Clock) -> f64 {
        match clock {
            Clock::Processor => spread(&self.processor).0,
            Clock::Wall => spread(&self.wall).0,
        }
    }
}

/// Median, least and largest value.
fn spread(values: &[f64]) -> (f64, f64, f64) {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    (values[values.len() / 2], values[0], values[values.len() - 1])
}

/// Table of all measurements. `own` is the error of the reference. Errors below ten times that are not reliable.
pub fn measured(rows: &[Row], own: Deviation, limit: f64) -> String {
    let head = [
        "solver",
        "tolerance",
        "processor [s]",
        "range",
        "wall [s]",
        "range",
        "level error [dB]",
        "trajectory error",
        "steps",
        "rejected",
        "evaluations",
        "a step",
        "Jacobians",
        "factorizations",
        "a step",
    ];
    let cells = rows.iter().map(|row| {
        let ran = row.outcome.as_ref().ok().and_then(|point| point.ran.as_ref());
        let name = ran.map_or_else(|| row.solver.clone(), |ran| format!("{} → {ran}", row.solver));
        let mut cells = vec![name, format!("{:.0e}", row.relative)];
        match &row.outcome {
            Ok(point) => {
                for times in [&point.processor, &point.wall] {
                    let (median, least, largest) = spread(times);
                    cells.push(seconds(median));
                    cells.push(format!("{}–{}", seconds(least), seconds(largest)));
                }
                cells.push(error(point.deviation.level, own.level));
                cells.push(error(point.deviation.trajectory, own.trajectory));
                let steps = point.work.steps as f64;
                let count = |count: Option<u64>| count.map_or_else(|| "–".into(), |count| count.to_string());
                cells.push(point.work.steps.to_string());
                cells.push(count(point.work.rejected));
                cells.push(point.rhs.to_string());
                cells.push(format!("{:.2}", point.rhs as f64 / steps));
                cells.push(count(point.work.jacobians));
                cells.push(count(point.work.factorizations));
                let each = point.work.factorizations.map(|count| count as f64 / steps);
                cells.push(each.map_or_else(|| "–".into(), |each| format!("{each:.3}")));
            }
            Err(Failure::OverLimit) => cells.push(format!("over {limit}")),
            Err(Failure::Refused(_)) => cells.push("failed".into()),
        }
        cells
    });
    let mut text = markdown(&head.map(String::from), &cells.collect::<Vec<_>>());
    for row in rows {
        if let Err(Failure::Refused(reason)) = &row.outcome {
            text += &format!("\n{} at {:.0e} failed: {reason}.\n", row.solver, row.relative);
        }
    }
    text
}

fn error(found: f64, own: f64) -> String {
    format!("{found:.1e}{}", if found < 10.0 * own { " *" } else { "" })
}

fn seconds(time: f64) -> String {
    let digits = if time < 0.995 {
        3
    } else if time < 99.5 {
        2
    } else {
        0
    };
    format!("{time:.digits$}")
}

/// Kind of error by which solvers are compared.
#[derive(Debug, Clone, Copy)]
pub enum Goal {
    Level(f64),
    Trajectory(f64),
}

pub const GOALS: [Goal; 4] = [Goal::Level(0.01), Goal::Level(0.001), Goal::Trajectory(1e-3), Goal::Trajectory(1e-5)];

impl Goal {
    fn value(self) -> f64 {
        match self {
            Self::Level(value) | Self::Trajectory(value) => value,
        }
    }

    fn of(self, deviation: Deviation) -> f64 {
        match self {
            Self::Level(_) => deviation.level,
            Self::Trajectory(_) => deviation.trajectory,
        }
    }

    fn name(self) -> String {
        match self {
            Self::Level(value) => format!("level {value} dB [s]"),
            Self::Trajectory(value) => format!("trajectory {value:.0e} [s]"),
        }
    }
}

/// Time of a solver for an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Needed {
    Time(f64),
    /// Even its loosest tolerance has a smaller error.
    AtMost(f64),
    NotReached,
}

impl Needed {
    fn time(self) -> Option<f64> {
        match self {
            Self::Time(time) | Self::AtMost(time) => Some(time),
            Self::NotReached => None,
        }
    }
}

/// Time for an error, from (error, time) at falling tolerances, by interpolation of the logarithms. The error at a tolerance is
/// the largest one at this and all tighter tolerances, so that an error that is small by a change of sign has no effect.
pub fn time_for(goal: f64, points: &[(f64, f64)]) -> Needed {
    let mut rest = 0.0;
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for &(error, time) in points.iter().rev() {
        rest = f64::max(rest, error);
        kept.push((rest, time));
    }
    kept.reverse();
    match kept.iter().position(|(error, _)| *error <= goal) {
        None => Needed::NotReached,
        Some(0) => Needed::AtMost(kept[0].1),
        Some(first) => {
            let ((above, before), (below, after)) = (kept[first - 1], kept[first]);
            let share = (above / goal).ln() / (above / below).ln();
            Needed::Time((before.ln() + share * (after / before).ln()).exp())
        }
    }
}

/// Time at equal error, absolute and over the times of `base` and of the best of `own`.
pub fn equal_error(rows: &[Row], own: &[String], base: &str, clock: Clock, limit: f64) -> String {
    let mut solvers: Vec<&str> = Vec::new();
    for row in rows {
        if !solvers.contains(&row.solver.as_str()) {
            solvers.push(&row.solver);
        }
    }
    let needed = |solver: &str, goal: Goal| {
        let of = rows.iter().filter(|row| row.solver == solver);
        let point = |row: &Row| row.outcome.as_ref().ok().map(|p| (goal.of(p.deviation), p.time(clock)));
        time_for(goal.value(), &of.filter_map(point).collect::<Vec<_>>())
    };
    let cut = |solver: &str| {
        rows.iter().any(|row| row.solver == solver && row.outcome.as_ref().err() == Some(&Failure::OverLimit))
    };
    let mut head = vec!["solver".to_owned()];
    for goal in GOALS {
        head.extend([goal.name(), format!("/ {base}"), "/ our best".into()]);
    }
    let best = GOALS.map(|goal| own.iter().filter_map(|name| needed(name, goal).time()).min_by(f64::total_cmp));
    let cells = solvers.iter().map(|&solver| {
        let mut cells = vec![solver.to_owned()];
        for (goal, best) in GOALS.into_iter().zip(best) {
            let found = needed(solver, goal);
            cells.push(match found {
                Needed::Time(time) => seconds(time),
                Needed::AtMost(time) => format!("≤ {}", seconds(time)),
                Needed::NotReached if cut(solver) => format!("over {limit}"),
                Needed::NotReached => "not reached".into(),
            });
            for other in [needed(base, goal).time(), best] {
                let ratio = found.time().zip(other).map(|(time, other)| format!("{:.2}", time / other));
                cells.push(ratio.unwrap_or_else(|| "–".into()));
            }
        }
        cells
    });
    markdown(&head, &cells.collect::<Vec<_>>())
}

fn markdown(head: &[String], rows: &[Vec<String>]) -> String {
    let cell = |row: &[String], column: usize| row.get(column).cloned().unwrap_or_default();
    let width = |column: usize| {
        let longest = rows.iter().map(|row| cell(row, column).chars().count()).max().unwrap_or(0);
        longest.max(head[column].chars().count()).max(3)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let line = |row: &[String]| {
        let cells: Vec<String> =
            (0..head.len()).map(|column| format!("{:<1$}", cell(row, column), widths[column])).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let rule = format!("|{}\n", widths.iter().map(|width| format!("{}|", "-".repeat(width + 2))).collect::<String>());
    [line(head), rule].into_iter().chain(rows.iter().map(|row| line(row))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_interpolated_between_logarithms() {
        let points = [(1e-2, 1.0), (1e-4, 100.0), (1e-6, 1000.0)];
        let Needed::Time(time) = time_for(1e-3, &points) else { panic!("reached between the first two") };
        assert!((time - 10.0).abs() < 1e-9);
        assert_eq!(time_for(1e-2, &points), Needed::AtMost(1.0));
        assert_eq!(time_for(1e-7, &points), Needed::NotReached);
    }

    #[test]
    fn a_lucky_error_does_not_count() {
        let points = [(1e-2, 1.0), (1e-9, 2.0), (1e-3, 4.0), (1e-5, 8.0)];
        assert_eq!(time_for(1e-3, &points), Needed::Time(2.0));
        assert!(matches!(time_for(1e-4, &points), Needed::Time(time) if time > 4.0 && time < 8.0));
    }
}
