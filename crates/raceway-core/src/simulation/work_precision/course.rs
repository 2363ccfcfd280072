//! The common task of all runs of a study: one initial state, one time span, one observer.

use super::clock::{Clock, Taken};
use crate::numerics::ode::{Choice, Integrator, OdeSystem, Statistics};
use crate::simulation::input::control::Control;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::Model;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::{Span, Stepping, integrate};
use crate::simulation::model::observer::Observer;
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::RATE;

/// Largest number of points of the output grid; a short run has as many as recorded values.
const MAX_GRID_POINTS: usize = 4096;
/// Share of the progress at which the scene has settled.
pub(super) const SETTLED: f64 = 0.05;
/// Share of the time span that each run simulates once before it is timed.
const WARM_UP: f64 = 0.05;

/// Time span, initial state and observed outputs of the runs.
pub(crate) struct Course<'m> {
    model: &'m Model,
    needs: &'m ActiveTerms,
    pub settings: RunSettings,
    /// Begin of the runs [s].
    pub begin: f64,
    /// State at the begin.
    pub start: Vec<f64>,
    /// Distance of the points of the output grid [s].
    pub grid_step: f64,
    pub grid_count: usize,
}

/// A run that has reached its end.
pub struct Finished {
    pub recording: Recording,
    /// States on the output grid, one after the other.
    pub trajectory: Vec<f64>,
    pub statistics: Statistics,
    pub choice: Choice,
    pub taken: Taken,
}

/// Values between the start of the runs and the first one kept: past the filter's delay.
const SKIPPED: usize = 100;

impl<'m> Course<'m> {
    /// Simulates the scene from a state at rest until it has settled, by the method and tolerance of `settings`. Runs begin
    /// a little before the recorded time, so that the filters have a past.
    pub(crate) fn settled(
        model: &'m Model,
        needs: &'m ActiveTerms,
        settings: &RunSettings,
        rest: Vec<f64>,
        control: &Control<'_>,
    ) -> Result<Self, SimulationError> {
        let begin = (settings.settle - SKIPPED as f64 / RATE).max(0.0);
        let start = if begin > 0.0 {
            let span = Span { start: 0.0, end: begin, checkpoint: begin, share: (0.0, SETTLED) };
            integrate(model, &rest, &Stepping::of(settings), &span, control, |_| ())?.checkpoint
        } else {
            rest
        };
        let length = settings.settle + settings.duration - begin;
        let grid_count = ((length * RATE).ceil() as usize).clamp(1, MAX_GRID_POINTS);
        let grid_step = length / grid_count as f64;
        Ok(Self { model, needs, settings: settings.clone(), begin, start, grid_step, grid_count })
    }

    /// Time from the common start to the end of the recorded time [s].
    pub(crate) fn length(&self) -> f64 {
        self.grid_step * self.grid_count as f64
    }

    /// Number of entries of a state.
    pub(crate) fn dimension(&self) -> usize {
        self.model.dimension()
    }

    /// Sizes of the entries at which deviations begin to matter.
    pub(crate) fn sizes(&self) -> Vec<f64> {
        self.model.mechanism().layout.sizes()
    }

    /// Runs once; the progress goes through `share`.
    pub(crate) fn run(
        &self,
        stepping: &Stepping,
        share: (f64, f64),
        control: &Control<'_>,
    ) -> Result<Finished, SimulationError> {
        let mut observer = Observer::new(self.model, self.needs, &self.settings);
        let mut grid = Grid::new(self);
        let span = Span { start: self.begin, end: observer.end(), checkpoint: self.begin, share };
        let clock = Clock::start();
        let done = integrate(self.model, &self.start, stepping, &span, control, |step| {
            observer.after(step);
            grid.after(step);
        })?;
        let taken = clock.taken();
        let trajectory = grid.trajectory;
        let recording = observer.finish();
        Ok(Finished { recording, trajectory, statistics: done.statistics, choice: done.choice, taken })
    }

    /// Runs `repetitions` times after a short untimed run. Returns the duration of each and the outcome of the first. A failure is
    /// not repeated. Fails only when the caller stops it.
    pub(crate) fn timed(
        &self,
        stepping: &Stepping,
        repetitions: u32,
        share: (f64, f64),
        control: &Control<'_>,
    ) -> Result<(Vec<Taken>, Result<Finished, SimulationError>), SimulationError> {
        self.warm_up(stepping, share.0, control)?;
        let part = (share.1 - share.0) / f64::from(repetitions.max(1));
        let share_of = |index: u32| (share.0 + part * f64::from(index), share.0 + part * f64::from(index + 1));
        let clock = Clock::start();
        let first = match self.run(stepping, share_of(0), control) {
            Ok(first) => first,
            Err(stopped @ SimulationError::Stopped { .. }) => return Err(stopped),
            Err(error) => return Ok((vec![clock.taken()], Err(error))),
        };
        let mut taken = vec![first.taken];
        for index in 1..repetitions {
            match self.run(stepping, share_of(index), control) {
                Ok(again) => taken.push(again.taken),
                Err(stopped @ SimulationError::Stopped { .. }) => return Err(stopped),
                // Runs repeat bit for bit, so that a failure after a success is not expected.
                Err(error) => return Ok((taken, Err(error))),
            }
        }
        Ok((taken, Ok(first)))
    }

    /// Ignores a failure, because the timed run fails in the same way and returns it.
    fn warm_up(&self, stepping: &Stepping, at: f64, control: &Control<'_>) -> Result<(), SimulationError> {
        let end = self.begin + WARM_UP * self.length();
        let span = Span { start: self.begin, end, checkpoint: self.begin, share: (at, at) };
        match integrate(self.model, &self.start, stepping, &span, control, |_| ()) {
            Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
            _ => Ok(()),
        }
    }
}

/// Recorder of the state at evenly spaced times.
struct Grid {
    begin: f64,
    step: f64,
    count: usize,
    dimension: usize,
    kept: usize,
    trajectory: Vec<f64>,
}

impl Grid {
    fn new(course: &Course<'_>) -> Self {
        let dimension = course.dimension();
        let trajectory = vec![0.0; dimension * course.grid_count];
        Self { begin: course.begin, step: course.grid_step, count: course.grid_count, dimension, kept: 0, trajectory }
    }

    /// Records the states that lie within the last step.
    fn after(&mut self, step: &dyn Integrator) {
        while self.kept < self.count {
            let time = self.begin + self.step * (self.kept + 1) as f64;
            if time > step.time() {
                return;
            }
            let at = self.kept * self.dimension;
            step.interpolate(time, &mut self.trajectory[at..at + self.dimension]);
            self.kept += 1;
        }
    }
}
