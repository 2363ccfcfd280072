//! The way that every run of a study goes: from one state over one stretch of time, looked at alike.

use std::time::Instant;

use super::SETTLED;
use crate::numerics::ode::{Choice, Integrator, OdeSystem, Statistics};
use crate::simulation::input::control::Control;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::Model;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::{Span, Stepping, integrate};
use crate::simulation::model::observer::Observer;
use crate::simulation::model::terms::Needs;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::RATE;

/// Points of the output grid at most; fewer where the rate of kept signals gives fewer.
const MOST_GRID_POINTS: usize = 4096;
/// Share of the stretch that each run goes once before it is timed.
const WARM_UP: f64 = 0.05;

/// From where to where, and what is looked at.
pub struct Course<'m> {
    model: &'m Model,
    needs: &'m Needs,
    pub settings: RunSettings,
    /// [s]
    pub begin: f64,
    /// The state then.
    pub start: Vec<f64>,
    /// Distance of the points of the output grid [s].
    pub grid_step: f64,
    pub grid_count: usize,
}

/// A run that has reached the end.
pub struct Finished {
    pub recording: Recording,
    /// States on the output grid, one after the other.
    pub trajectory: Vec<f64>,
    pub statistics: Statistics,
    pub choice: Choice,
    pub taken: Taken,
}

/// Time that a run took [s].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taken {
    pub wall: f64,
    /// What of it the processor was given to this thread; `None` where the system does not tell.
    pub processor: Option<f64>,
}

/// A clock of both kinds.
struct Clock {
    begin: Instant,
    processor: Option<f64>,
}

impl Clock {
    fn start() -> Self {
        Self { processor: processor_time(), begin: Instant::now() }
    }

    fn taken(&self) -> Taken {
        let wall = self.begin.elapsed().as_secs_f64();
        let processor = self.processor.and_then(|begin| Some(processor_time()? - begin));
        Taken { wall, processor }
    }
}

/// Time that this thread has been given by the processor [s].
#[cfg(target_os = "linux")]
fn processor_time() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

#[cfg(not(target_os = "linux"))]
fn processor_time() -> Option<f64> {
    None
}

/// Values between the start of the runs and the first one kept: past the filter's delay.
const SKIPPED: usize = 100;

impl<'m> Course<'m> {
    /// Lets the scene settle from a state at rest by the method and tolerance of `settings`. Runs begin a little before
    /// the kept time, for the filters to fill.
    pub fn settled(
        model: &'m Model,
        needs: &'m Needs,
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
        let grid_count = ((length * RATE).ceil() as usize).clamp(1, MOST_GRID_POINTS);
        let grid_step = length / grid_count as f64;
        Ok(Self { model, needs, settings: settings.clone(), begin, start, grid_step, grid_count })
    }

    /// From the common start to the end of the kept time [s].
    pub fn length(&self) -> f64 {
        self.grid_step * self.grid_count as f64
    }

    /// Entries of a state.
    pub fn dimension(&self) -> usize {
        self.model.dimension()
    }

    /// Sizes of the entries at which deviations begin to matter.
    pub fn sizes(&self) -> Vec<f64> {
        self.model.mechanism().layout.sizes()
    }

    /// Runs once; the progress goes through `share`.
    pub fn run(
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

    /// Runs `repetitions` times after a short untimed run: what each took, and how the first ended. A failure is
    /// not repeated. Fails itself only when it is stopped.
    pub fn timed(
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
                // What has ended well once ends well again: runs repeat bit for bit.
                Err(error) => return Ok((taken, Err(error))),
            }
        }
        Ok((taken, Ok(first)))
    }

    /// A failure is left to the timed run, which tells of it.
    fn warm_up(&self, stepping: &Stepping, at: f64, control: &Control<'_>) -> Result<(), SimulationError> {
        let end = self.begin + WARM_UP * self.length();
        let span = Span { start: self.begin, end, checkpoint: self.begin, share: (at, at) };
        match integrate(self.model, &self.start, stepping, &span, control, |_| ()) {
            Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
            _ => Ok(()),
        }
    }
}

/// Keeps the state at evenly spaced times.
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

    /// Keeps the states that lie within the last step.
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
