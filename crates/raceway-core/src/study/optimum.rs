//! The best point of one range or two, by runs each of which may be wrong by an error, or fail.
//!
//! Three passes. A scan over a coarse grid finds the valleys: levels over a parameter have several. The best of these
//! are followed down, by Brent's method on one axis and by that of Nelder and Mead on two. Then each axis is walked
//! from the best point, both ways, to where a point is certainly worse: beyond both errors together. Between these ends
//! the errors do not separate the points.
//!
//! Ranges are unit intervals here. The order of the runs, and so the answer, depends on their values alone.

use std::cell::RefCell;

use argmin::core::{CostFunction, Error, Executor};
use argmin::solver::brent::BrentOpt;
use argmin::solver::neldermead::NelderMead;

use super::grid::Grid;
use super::trend::{Goal, Uncertain};

/// Stage of the search for which a point was run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    Scan,
    Search,
    Band,
}

/// A run.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// Share of the way along each axis, 0–1.
    pub at: Vec<f64>,
    pub purpose: Purpose,
    /// `None`: it failed.
    pub value: Option<Uncertain>,
}

/// All runs of a search, the best point and its band.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimum {
    /// All runs in their order, those of the scan first.
    pub evaluations: Vec<Evaluation>,
    /// The best of them; `None` where all failed.
    pub best: Option<usize>,
    /// Ends of the band along each axis, with the other axis held at the best point. An end is the nearest point that
    /// is certainly worse, the last point before runs fail, or the end of the range. `None` where the error of the best
    /// value is not known.
    pub band: Option<Vec<[f64; 2]>>,
    /// True for an axis whose band ends where runs fail.
    pub edges: Option<Vec<bool>>,
}

impl Optimum {
    /// Returns true where a run differs from the best one by no more than the sum of both errors.
    pub fn may_be_as_good(&self, evaluation: &Evaluation, goal: Goal) -> bool {
        let best = self.best.and_then(|best| self.evaluations[best].value);
        matches!((best, evaluation.value), (Some(best), Some(value)) if may_be_as_good(best, value, goal))
    }
}

/// Points of the scan along the axis, or along each of both.
const SCANNED: [usize; 2] = [17, 9];
/// Valleys that are followed down.
const VALLEYS: [usize; 2] = [3, 2];
/// Steps of the search in a valley, and the least that Brent's method makes, as a share of the range.
const MAX_STEPS: [u64; 2] = [12, 24];
const MIN_STEP: f64 = 5e-4;
/// Simplices whose values scatter by less than this share of the error are small enough.
const SCATTER: f64 = 0.1;
/// The first step from the best point along an axis, as a share of the range, and how often a gap between good and worse is halved.
const FIRST_STEP: f64 = 0.01;
const HALVINGS: u32 = 4;
/// Largest number of walks; a walk that meets a better point starts again from there.
const MAX_WALKS: usize = 3;

/// Largest number of runs of a search without Nelder and Mead's shrinking, the base of the progress.
pub fn most_runs(axes: usize) -> usize {
    let walk = 8 + HALVINGS as usize;
    match axes {
        1 => SCANNED[0] + VALLEYS[0] * (MAX_STEPS[0] as usize + 1) + 2 * walk,
        _ => SCANNED[1] * SCANNED[1] + VALLEYS[1] * (2 * MAX_STEPS[1] as usize + 3) + 4 * walk,
    }
}

/// The run of a point: its value, or `None` where it fails. An error ends the search.
pub(crate) type Run<'a, E> = dyn FnMut(&[f64]) -> Result<Option<Uncertain>, E> + 'a;

/// Searches one or two axes.
pub fn optimum<E>(axes: usize, goal: Goal, run: &mut Run<'_, E>) -> Result<Optimum, E> {
    let mut course = Course { goal, run, evaluations: Vec::new(), ended: None };
    let ends = course.go(axes)?;
    let edges = ends.as_ref().map(|ends| ends.iter().map(|[low, high]| low.fails || high.fails).collect());
    let band = ends.map(|ends| ends.into_iter().map(|ends| ends.map(|end| end.at)).collect());
    Ok(Optimum { best: course.best(), band, edges, evaluations: course.evaluations })
}

/// An end of the band, and whether runs fail beyond it.
#[derive(Debug, Clone, Copy)]
struct End {
    at: f64,
    fails: bool,
}

/// A point next to the best one, compared with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Beside {
    Good,
    Worse,
    Fails,
}

struct Course<'a, E> {
    goal: Goal,
    run: &'a mut Run<'a, E>,
    evaluations: Vec<Evaluation>,
    /// The error of `run` that ended an optimiser, which has errors of its own.
    ended: Option<E>,
}

impl<E> Course<'_, E> {
    fn go(&mut self, axes: usize) -> Result<Option<Vec<[End; 2]>>, E> {
        let count = SCANNED[axes.clamp(1, 2) - 1];
        let grid = Grid::new(vec![count; axes]);
        let share = |place: usize| place as f64 / (count - 1) as f64;
        for point in 0..grid.points().unwrap_or(0) {
            let at: Vec<f64> = grid.places(point).into_iter().map(share).collect();
            self.value(&at, Purpose::Scan)?;
        }
        for valley in self.valleys(&grid, count, axes) {
            let spacing = share(1);
            match &self.evaluations[valley].at.clone()[..] {
                [at] => self.down_one(*at, spacing)?,
                at => self.down_several(at, spacing)?,
            }
        }
        self.band()
    }

    /// The value at a point; one that has been run is not run again.
    fn value(&mut self, at: &[f64], purpose: Purpose) -> Result<Option<Uncertain>, E> {
        if let Some(known) = self.evaluations.iter().find(|known| known.at == at) {
            return Ok(known.value);
        }
        let value = (self.run)(at)?;
        self.evaluations.push(Evaluation { at: at.to_vec(), purpose, value });
        Ok(value)
    }

    /// Value for an optimiser: less is better, finite also where a run fails or a point lies outside, and worse the farther out.
    fn cost(&mut self, at: &[f64]) -> Result<f64, E> {
        let outside: f64 = at.iter().map(|x| (x - x.clamp(0.0, 1.0)).abs()).sum();
        let value = if outside > 0.0 { None } else { self.value(at, Purpose::Search)? };
        let costs = self.evaluations.iter().filter_map(|run| run.value).map(|value| self.goal.cost(value.0));
        let (least, most) = costs.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), cost| (a.min(cost), b.max(cost)));
        Ok(value
            .map_or_else(|| most + (1.0 + outside) * (most - least).max(f64::MIN_POSITIVE), |v| self.goal.cost(v.0)))
    }

    fn best(&self) -> Option<usize> {
        let costs = self.evaluations.iter().enumerate().filter_map(|(run, e)| Some((run, self.goal.cost(e.value?.0))));
        costs.reduce(|a, b| if b.1 < a.1 { b } else { a }).map(|(run, _)| run)
    }

    /// Runs of the scan that none of their neighbours is better than, the best first.
    fn valleys(&self, grid: &Grid, count: usize, axes: usize) -> Vec<usize> {
        let cost = |point: usize| self.evaluations[point].value.map(|value| self.goal.cost(value.0));
        let neighbours = |point: usize| {
            let places = grid.places(point);
            let step = |axis: usize, by: isize| {
                let place = places[axis].checked_add_signed(by).filter(|place| *place < count)?;
                let mut to = places.clone();
                to[axis] = place;
                Some(grid.point(&to))
            };
            (0..axes).flat_map(|axis| [step(axis, -1), step(axis, 1)]).flatten().collect::<Vec<_>>()
        };
        let mut valleys: Vec<(usize, f64)> = (0..self.evaluations.len())
            .filter_map(|point| Some((point, cost(point)?)))
            .filter(|(point, its)| neighbours(*point).into_iter().filter_map(cost).all(|other| *its <= other))
            .collect();
        valleys.sort_by(|a, b| a.1.total_cmp(&b.1));
        valleys.into_iter().take(VALLEYS[axes.clamp(1, 2) - 1]).map(|(point, _)| point).collect()
    }

    /// Down a valley of one axis, between the neighbours of its lowest point.
    fn down_one(&mut self, at: f64, spacing: f64) -> Result<(), E> {
        let (from, to) = ((at - spacing).max(0.0), (at + spacing).min(1.0));
        let solver = BrentOpt::new(from, to).set_tolerance(f64::EPSILON.sqrt(), MIN_STEP);
        let problem = One(RefCell::new(self));
        let _ = Executor::new(problem, solver).configure(|state| state.max_iters(MAX_STEPS[0])).timer(false).run();
        self.unless_ended()
    }

    /// Down a valley of several axes, from a simplex at its lowest point.
    fn down_several(&mut self, at: &[f64], spacing: f64) -> Result<(), E> {
        let mut simplex = vec![at.to_vec()];
        for axis in 0..at.len() {
            let mut corner = at.to_vec();
            let step = 0.5 * spacing;
            corner[axis] += if corner[axis] + step <= 1.0 { step } else { -step };
            simplex.push(corner);
        }
        let error = self.best().and_then(|best| self.evaluations[best].value).and_then(|value| value.1).unwrap_or(0.0);
        let Ok(solver) = NelderMead::new(simplex).with_sd_tolerance(SCATTER * error) else { return Ok(()) };
        let problem = Several(RefCell::new(self));
        let _ = Executor::new(problem, solver).configure(|state| state.max_iters(MAX_STEPS[1])).timer(false).run();
        self.unless_ended()
    }

    /// The runs of an optimiser are noted, also where it fails for a reason of its own.
    fn unless_ended(&mut self) -> Result<(), E> {
        self.ended.take().map_or(Ok(()), Err)
    }

    /// The cost, as an optimiser takes it.
    fn cost_for_optimiser(&mut self, at: &[f64]) -> Result<f64, Error> {
        self.cost(at).map_err(|error| {
            self.ended = Some(error);
            Error::msg("the search was ended")
        })
    }

    /// The ends along each axis, from the best point; where the walk comes upon a better one, from that one again.
    fn band(&mut self) -> Result<Option<Vec<[End; 2]>>, E> {
        let mut band = None;
        for _ in 0..MAX_WALKS {
            let Some(best) = self.best() else { return Ok(None) };
            let Evaluation { at, value: Some(value @ (_, Some(_))), .. } = self.evaluations[best].clone() else {
                return Ok(None);
            };
            let mut ends = Vec::new();
            for axis in 0..at.len() {
                ends.push([self.end(&at, axis, 0.0, value)?, self.end(&at, axis, 1.0, value)?]);
            }
            for (axis, [low, high]) in ends.iter_mut().enumerate() {
                *low = self.nearer(*low, &at, axis, value);
                *high = self.nearer(*high, &at, axis, value);
            }
            band = Some(ends);
            if self.best() == Some(best) {
                break;
            }
        }
        Ok(band)
    }

    /// The end, or a run of the search on the way to it that is certainly worse, too: values may be uneven.
    fn nearer(&self, end: End, from: &[f64], axis: usize, best: Uncertain) -> End {
        let beside = |run: &&Evaluation| (0..from.len()).all(|other| other == axis || run.at[other] == from[other]);
        let worse = |run: &&Evaluation| run.value.is_some_and(|value| !may_be_as_good(best, value, self.goal));
        let distance = |at: f64| (at - from[axis]).abs();
        let on_the_way = |run: &&Evaluation| {
            (run.at[axis] - from[axis]) * (end.at - from[axis]) > 0.0 && distance(run.at[axis]) < distance(end.at)
        };
        let nearest = self.evaluations.iter().filter(beside).filter(on_the_way).filter(worse);
        let nearest = nearest.map(|run| run.at[axis]).min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        nearest.map_or(end, |at| End { at, fails: false })
    }

    /// Where points along an axis, from one towards an end of the range, become certainly worse than the best, or fail.
    fn end(&mut self, from: &[f64], axis: usize, bound: f64, best: Uncertain) -> Result<End, E> {
        let (mut good, mut step) = (from[axis], FIRST_STEP);
        let beside = |course: &mut Self, x: f64| {
            let mut at = from.to_vec();
            at[axis] = x;
            Ok(match course.value(&at, Purpose::Band)? {
                Some(value) if may_be_as_good(best, value, course.goal) => Beside::Good,
                Some(_) => Beside::Worse,
                None => Beside::Fails,
            })
        };
        let (mut worse, mut what) = loop {
            if good == bound {
                return Ok(End { at: bound, fails: false });
            }
            let next = if bound > good { (good + step).min(bound) } else { (good - step).max(bound) };
            match beside(self, next)? {
                Beside::Good => (good, step) = (next, 2.0 * step),
                other => break (next, other),
            }
        };
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + worse);
            match beside(self, middle)? {
                Beside::Good => good = middle,
                other => (worse, what) = (middle, other),
            }
        }
        let fails = what == Beside::Fails;
        Ok(End { at: if fails { good } else { worse }, fails })
    }
}

/// Returns true where a value differs from the best one by no more than the sum of both errors; false where an error is
/// unknown.
fn may_be_as_good(best: Uncertain, value: Uncertain, goal: Goal) -> bool {
    match (best.1, value.1) {
        (Some(error), Some(its)) => goal.cost(value.0) - goal.cost(best.0) <= error + its,
        _ => false,
    }
}

/// Cost function of one axis.
struct One<'c, 'a, E>(RefCell<&'c mut Course<'a, E>>);

impl<E> CostFunction for One<'_, '_, E> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, at: &f64) -> Result<f64, Error> {
        self.0.borrow_mut().cost_for_optimiser(&[*at])
    }
}

/// Cost function of several axes.
struct Several<'c, 'a, E>(RefCell<&'c mut Course<'a, E>>);

impl<E> CostFunction for Several<'_, '_, E> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, at: &Vec<f64>) -> Result<f64, Error> {
        self.0.borrow_mut().cost_for_optimiser(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn searched(axes: usize, goal: Goal, f: impl Fn(&[f64]) -> Option<Uncertain>) -> Optimum {
        let found = optimum(axes, goal, &mut |at| Ok::<_, ()>(f(at))).unwrap();
        assert!(
            found.evaluations.iter().all(|run| run.at.iter().all(|x| (0.0..=1.0).contains(x))),
            "outside the range"
        );
        found
    }

    fn best(found: &Optimum) -> &Evaluation {
        &found.evaluations[found.best.unwrap()]
    }

    /// Where (x − x₀)² grows beyond twice the error, the band ends.
    #[test]
    fn a_parabola_has_its_least_value_and_its_band() {
        let found = searched(1, Goal::Least, |at| Some(((at[0] - 0.4137).powi(2), Some(0.0008))));
        assert!((best(&found).at[0] - 0.4137).abs() < 2e-3, "{:?}", best(&found));
        let [low, high] = found.band.as_ref().unwrap()[0];
        let half = 0.0016_f64.sqrt();
        assert!((0.4137 - half - low).abs() < 0.004 && (high - 0.4137 - half).abs() < 0.004, "{low} {high}");
        assert!(low < 0.4137 - half && high > 0.4137 + half, "the ends are certainly worse");
        assert!(found.evaluations.len() <= most_runs(1), "{}", found.evaluations.len());
    }

    /// The deepest of several valleys, though the scan shows another as the deepest.
    #[test]
    fn the_deepest_valley_wins() {
        let tent = |x: f64| (0.15 - 4.0 * (x - 0.28125).abs()).max(0.0);
        let f = |x: f64| 1.0 - tent(x) - 0.12 * (-(60.0 * (x - 0.75)).powi(2)).exp();
        let found = searched(1, Goal::Least, |at| Some((f(at[0]), Some(1e-3))));
        assert!((best(&found).at[0] - 0.28125).abs() < 1e-3, "{:?}", best(&found));
    }

    #[test]
    fn two_axes_with_a_slanted_valley() {
        let f = |at: &[f64]| (at[0] - 0.62).powi(2) + 20.0 * (at[1] - 0.3 - 0.4 * (at[0] - 0.62)).powi(2);
        let found = searched(2, Goal::Least, |at| Some((f(at), Some(1e-5))));
        let at = &best(&found).at;
        assert!((at[0] - 0.62).abs() < 0.01 && (at[1] - 0.3).abs() < 0.005, "{at:?}");
        assert_eq!(found.band.as_ref().unwrap().len(), 2);
        assert!(found.evaluations.len() <= most_runs(2), "{}", found.evaluations.len());
    }

    #[test]
    fn an_end_of_the_range_can_be_best_and_the_largest_value_can_be_sought() {
        let found = searched(1, Goal::Largest, |at| Some((at[0], Some(0.01))));
        assert_eq!(best(&found).at, [1.0]);
        let [low, high] = found.band.as_ref().unwrap()[0];
        assert!((low - 0.98).abs() < 2e-3 && high == 1.0, "{low} {high}");
    }

    #[test]
    fn failed_runs_are_never_the_best_and_unknown_errors_give_no_band() {
        let found = searched(1, Goal::Least, |at| (at[0] > 0.5).then_some((at[0], None)));
        assert!(best(&found).at[0] > 0.5 && best(&found).at[0] < 0.51, "{:?}", best(&found));
        assert_eq!(found.band, None);
        let none = searched(2, Goal::Least, |_| None);
        assert_eq!((none.best, none.band), (None, None));
    }

    /// Nothing is known beyond the edge, so it does not count as a worse point.
    #[test]
    fn a_band_ends_where_runs_fail() {
        let found = searched(1, Goal::Largest, |at| (at[0] < 0.7).then_some((at[0], Some(0.01))));
        let [low, high] = found.band.as_ref().unwrap()[0];
        assert!(low < 0.69 && high < 0.7 && high > 0.69, "{low} {high}");
        assert_eq!(found.edges, Some(vec![true]));
        let inside = searched(1, Goal::Least, |at| Some(((at[0] - 0.5).powi(2), Some(1e-4))));
        assert_eq!(inside.edges, Some(vec![false]));
    }

    /// A narrow spike within the band is certainly worse, and the walk may find a narrow dip that is better than all before.
    #[test]
    fn a_band_is_as_near_as_any_run_says() {
        let uneven = |x: f64| if (x - 0.5625).abs() < 1e-3 { 1.0 } else { (x - 0.5).powi(2) };
        let found = searched(1, Goal::Least, |at| Some((uneven(at[0]), Some(0.01))));
        let [low, high] = found.band.as_ref().unwrap()[0];
        assert!(low < 0.36 && high <= 0.5625, "{low} {high}");
        let dip = |x: f64| if (x - 0.525).abs() < 0.006 { -1.0 } else { (x - 0.5).powi(2) };
        let found = searched(1, Goal::Least, |at| Some((dip(at[0]), Some(0.01))));
        let [low, high] = found.band.as_ref().unwrap()[0];
        let at = best(&found).at[0];
        assert!(low <= at && at <= high && high < 0.54, "{low} {at} {high}");
    }

    #[test]
    fn an_error_of_a_run_ends_the_search() {
        let mut runs = 0;
        let ended = optimum(1, Goal::Least, &mut |at| {
            runs += 1;
            if runs == 20 { Err("stop") } else { Ok(Some((at[0].sin(), Some(1e-6)))) }
        });
        assert_eq!((ended, runs), (Err("stop"), 20));
    }
}
