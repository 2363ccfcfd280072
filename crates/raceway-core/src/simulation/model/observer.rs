//! Which signals are kept, and how often.
//!
//! The motion is looked at 409 600 times a second, by interpolation within the steps, and less often where long steps damp what is
//! so fast. A look is an evaluation of the equations, but where the method itself shows what it has found (`Integrator::sight`): there
//! each step is seen as it ends, and looks take their values from the steps around. The spindle's signals pass a
//! low-pass filter on their way to 102 400 values a second (contact resonances lie above the band of interest and must not
//! fold into it); all others are kept as they stand at those times, window by window (`windows.rs`). Extremes see every look.

mod snapshot;

use crate::numerics::decimation::Decimator;
use crate::numerics::interpolation::Course;
use crate::numerics::ode::Integrator;
use crate::numerics::ode::Method;
use crate::numerics::parallel::both;
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Vector, length};
use crate::simulation::input::channel::{Axis, BallContact, Channel, Motion};
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::Model;
use crate::simulation::model::step_loads::{Seen, Sight};
use crate::simulation::model::terms::Needs;
use crate::simulation::recording::load_course::LoadsAlong;
use crate::simulation::recording::load_course::LoadsTaken;
use crate::simulation::recording::record::Quantities;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::RATE;
use crate::simulation::recording::sampling::kept_values;
use crate::simulation::recording::sampling::picked_channels;
use crate::simulation::recording::windows::{Recorder, Signal, Whirl};
use snapshot::{Contact, Look, Met, Peaks, Snapshot};

/// Kept values of a part whose largest load and cage speed are noted: eight parts in 10 ms.
const PART: usize = 128;
/// Looks per kept value, unless steps of a fixed length damp what so many would see.
const OVERSAMPLING: usize = 4;
/// Steps to a look from which one sees all that the steps have left: what is faster than half of the looks turns by 120° a step and
/// more then, and loses half of its size or more with each.
const STEPS_TO_A_LOOK: f64 = 1.0 / 0.75;

/// Looks per kept value at the motion of a run.
fn looks_per_value(settings: &RunSettings) -> usize {
    let damping = settings.fixed_step.filter(|_| settings.method == Method::SemiImplicit);
    let is_enough = |looks: &usize| damping.is_some_and(|step| STEPS_TO_A_LOOK * step * RATE * *looks as f64 >= 1.0);
    [1, 2].into_iter().find(is_enough).unwrap_or(OVERSAMPLING)
}

/// Mean and variance of a growing sample, about its first value.
#[derive(Clone, Copy, Default)]
struct Moments {
    count: f64,
    origin: f64,
    sum: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f64) {
        if self.count == 0.0 {
            self.origin = value;
        }
        self.count += 1.0;
        let off = value - self.origin;
        self.sum += off;
        self.squares += off * off;
    }

    fn mean(&self) -> f64 {
        self.origin + self.sum / self.count.max(1.0)
    }

    fn variance(&self) -> f64 {
        let count = self.count.max(1.0);
        ((self.squares - self.sum * self.sum / count) / count).max(0.0)
    }
}

/// Azimuth, inner and outer load.
const OF_THE_FIRST_BALL: usize = 3;

/// Looks at a run and keeps what is needed.
pub struct Observer<'m> {
    model: &'m Model,
    start: f64,
    /// Looks per kept value.
    oversampling: usize,
    /// Number of values to keep.
    values: usize,
    /// Looks taken so far, and in all.
    looks: usize,
    all_looks: usize,
    /// Looks before the first kept value.
    lead: usize,
    decimator: Decimator,
    filtered: Recorder,
    spindle: Vec<Channel>,
    moments: Vec<Moments>,
    picked: Recorder,
    channels: Vec<Channel>,
    frame: Vec<f64>,
    pick: Vec<f64>,
    state: Vec<f64>,
    derivative: Vec<f64>,
    snapshot: Snapshot,
    /// What steps have shown of themselves: `frame`, `pick`, and of the first ball azimuth and loads.
    course: Course,
    between: Vec<f64>,
    loads: Option<LoadsTaken>,
    shaft: Moments,
    cage: Moments,
    spin: Moments,
    /// What was seen of each stretch of `PART` kept values, and the cage over the one on the way.
    parts: Vec<Quantities>,
    part_cage: CageMoments,
}

/// Speed [rad/s] and place [m] of the cage over a part of a run.
#[derive(Clone, Copy, Default)]
struct CageMoments {
    speed: Moments,
    y: Moments,
    z: Moments,
}

impl<'m> Observer<'m> {
    /// Keeps what metrics, spectra and series of `settings` need.
    pub fn new(model: &'m Model, needs: &Needs, settings: &RunSettings) -> Self {
        let layout = model.mechanism().layout;
        let axes = if layout.axial_spindle { &[Axis::X, Axis::Y, Axis::Z][..] } else { &[Axis::Y, Axis::Z] };
        let values = kept_values(settings.duration);
        let spindle: Vec<Channel> = axes
            .iter()
            .flat_map(|&axis| {
                [Motion::Displacement, Motion::Velocity, Motion::Acceleration]
                    .map(|motion| Channel::Spindle(axis, motion))
            })
            .collect();
        let channels = picked_channels(&settings.outputs, layout.cage);
        let recorder = |channels: &[Channel]| Recorder::new(channels.iter().copied(), &settings.outputs, values);
        let oversampling = looks_per_value(settings);
        let decimator = Decimator::new(oversampling, spindle.len());
        let delay = decimator.delay();
        // A run without time to settle has no past for the filter: it starts from a standstill then.
        let lead = if settings.settle * RATE * oversampling as f64 >= delay as f64 { delay } else { 0 };
        let balls = layout.balls;
        Self {
            model,
            start: settings.settle,
            oversampling,
            values,
            looks: 0,
            all_looks: lead + (values - 1) * oversampling + delay + 1,
            lead,
            decimator,
            moments: vec![Moments::default(); spindle.len()],
            frame: vec![0.0; spindle.len()],
            pick: vec![0.0; channels.len()],
            course: Course::new(spindle.len() + channels.len() + OF_THE_FIRST_BALL),
            between: vec![0.0; spindle.len() + channels.len() + OF_THE_FIRST_BALL],
            filtered: recorder(&spindle),
            spindle,
            picked: recorder(&channels),
            channels,
            state: vec![0.0; layout.dimension()],
            derivative: vec![0.0; layout.dimension()],
            snapshot: Snapshot {
                film: needs.film_thickness,
                inner: vec![0.0; balls],
                outer: vec![0.0; balls],
                pocket: vec![0.0; balls],
                met: PerRaceway { inner: Met::new(balls), outer: Met::new(balls) },
                peaks: Peaks::default(),
                counts: false,
            },
            loads: (settings.outputs.contacts && settings.outputs.keep_signals())
                .then(|| LoadsTaken::new(values, model.mechanism().steady_orbit_speed())),
            shaft: Moments::default(),
            cage: Moments::default(),
            spin: Moments::default(),
            parts: Vec::with_capacity(values.div_ceil(PART)),
            part_cage: CageMoments::default(),
        }
    }

    fn look_time(&self, look: usize) -> f64 {
        (self.start + (look as f64 - self.lead as f64) / (RATE * self.oversampling as f64)).max(0.0)
    }

    /// Time of the next look [s]; `None` when all are taken.
    pub fn next_look(&self) -> Option<f64> {
        (self.looks < self.all_looks).then(|| self.look_time(self.looks))
    }

    /// Time of the last look [s]: the filter's delay after the last kept value.
    pub fn end(&self) -> f64 {
        self.look_time(self.all_looks - 1)
    }

    /// Takes the looks that the last step has made known.
    pub fn after(&mut self, step: &dyn Integrator) {
        let Some(sight) = step.sight() else {
            self.look_within(step);
            return;
        };
        if self.course.end() != Some(step.previous_time()) {
            // A start of its own, which shows no more than its end.
            if let Some(end) = self.course.end() {
                self.keep_between(end);
            }
            self.course.clear();
            self.look_within(step);
        }
        self.see(step.time(), step.state(), &Sight(sight));
        if let Some(known) = self.course.known() {
            self.keep_between(known);
        }
    }

    /// All looks that lie within the last step, an evaluation each.
    fn look_within(&mut self, step: &dyn Integrator) {
        while let Some(time) = self.next_look().filter(|time| *time <= step.time()) {
            step.interpolate(time, &mut self.state);
            self.look(time);
        }
    }

    /// Takes a look at a state.
    fn look(&mut self, time: f64) {
        self.begin(time);
        let mut watch = Look { model: self.model, snapshot: &mut self.snapshot };
        self.model.derivative_watched(time, &self.state, &mut self.derivative, &mut watch);
        let rate = self.model.mechanism().layout.spindle(&self.derivative);
        self.gather_spindle(rate.velocity);
        self.count(time);
        if self.falls_on_a_value() {
            self.pick(time);
            self.picked.push(&self.pick);
            self.take_loads(self.of_the_first_ball(time));
        }
        self.keep();
    }

    /// Sees the end of a step.
    fn see(&mut self, time: f64, state: &[f64], sight: &Sight<'_>) {
        self.state.copy_from_slice(state);
        self.begin(time);
        let m = self.model.mechanism();
        for ball in 0..m.layout.balls {
            let Seen { load, pocket, slip_square, angle, rolling_speed } = sight.of(ball);
            let inner = Contact { load: load.inner, slip_square: slip_square.inner, angle: angle.inner };
            let outer = Contact { load: load.outer, slip_square: slip_square.outer, angle: angle.outer };
            self.snapshot.meet(&m.raceway, (ball, BallContact::Inner), &inner, |_| rolling_speed.inner);
            self.snapshot.meet(&m.raceway, (ball, BallContact::Outer), &outer, |_| rolling_speed.outer);
            if m.layout.cage {
                self.snapshot.meet_pocket(ball, pocket);
            }
        }
        self.gather_spindle(sight.acceleration());
        self.count(time);
        self.pick(time);
        let sample = self.frame.iter().chain(&self.pick).copied().chain(self.of_the_first_ball(time));
        self.course.push(time, sample);
    }

    /// Takes the looks up to a time from the steps around them.
    fn keep_between(&mut self, known: f64) {
        let smooth = self.frame.len();
        while let Some(time) = self.next_look().filter(|time| *time <= known && self.course.end().is_some()) {
            self.course.at(time, smooth, &mut self.between);
            self.frame.copy_from_slice(&self.between[..smooth]);
            if self.falls_on_a_value() {
                let (picked, of_the_first) = self.between[smooth..].split_at(self.pick.len());
                self.picked.push(picked);
                let [azimuth, inner, outer] = [0, 1, 2].map(|i| of_the_first[i]);
                self.take_loads([azimuth, inner, outer]);
            }
            self.keep();
        }
    }

    /// At a time whose loads are about to be seen.
    fn begin(&mut self, time: f64) {
        // To a quarter of a look: times are counted in different ways.
        let off = 0.25 / (RATE * self.oversampling as f64);
        let start = self.start;
        let value = |place: usize| start + place as f64 / RATE;
        self.snapshot.counts = time > value(0) - off && time < value(self.values - 1) + off;
        while self.snapshot.counts && time > value(PART * (self.parts.len() + 1)) - off {
            self.end_part();
        }
    }

    /// Takes what is in `frame` and `state` into the means.
    fn count(&mut self, time: f64) {
        if !self.snapshot.counts {
            return;
        }
        for (moments, value) in self.moments.iter_mut().zip(&self.frame) {
            moments.add(*value);
        }
        let cage_speed = self.gather_speeds(time);
        self.part_cage.speed.add(cage_speed);
        if self.model.mechanism().layout.cage {
            let [_, y, z] = self.model.mechanism().layout.cage(&self.state).centre;
            self.part_cage.y.add(y);
            self.part_cage.z.add(z);
        }
    }

    /// Whether the next look stands at a kept value.
    fn falls_on_a_value(&self) -> bool {
        let place = self.looks.checked_sub(self.lead);
        place.is_some_and(|place| place <= (self.values - 1) * self.oversampling && place % self.oversampling == 0)
    }

    /// Takes `frame` as the next look.
    fn keep(&mut self) {
        if self.lead == 0 && self.looks == 0 {
            self.decimator.prime(&self.frame);
        }
        if let Some(frame) = self.decimator.push(&self.frame) {
            self.filtered.push(frame);
        }
        self.looks += 1;
    }

    fn gather_spindle(&mut self, acceleration: Vector) {
        let now = self.model.mechanism().layout.spindle(&self.state);
        for (value, channel) in self.frame.iter_mut().zip(&self.spindle) {
            if let Channel::Spindle(axis, motion) = *channel {
                let vector = match motion {
                    Motion::Displacement => now.position,
                    Motion::Velocity => now.velocity,
                    Motion::Acceleration => acceleration,
                };
                *value = vector[axis as usize];
            }
        }
    }

    /// Returns the speed of the cage [rad/s].
    fn gather_speeds(&mut self, time: f64) -> f64 {
        let m = self.model.mechanism();
        let (_, speed, _) = m.speed.at(time);
        let balls = m.layout.balls;
        let states = (0..balls).map(|ball| m.layout.ball(&self.state, ball));
        let (mut orbit, mut spin) = (0.0, 0.0);
        for state in states {
            orbit += state.arc_velocity / balls as f64;
            // Seen from the orbit frame, about the axis that a contact angle leans.
            let about_x = (m.spin_ratio - m.orbit_ratio) * speed + state.spin[0] - state.arc_velocity / m.pitch_radius;
            spin += length([about_x, state.spin[1], state.spin[2]]) / balls as f64;
        }
        // Without a cage the balls' mean orbit speed stands for it.
        let arc_velocity = if m.layout.cage { m.layout.cage(&self.state).arc_velocity } else { orbit };
        self.shaft.add(speed);
        let cage_speed = m.orbit_ratio * speed + arc_velocity / m.pitch_radius;
        self.cage.add(cage_speed);
        self.spin.add(spin);
        cage_speed
    }

    fn pick(&mut self, time: f64) {
        let m = self.model.mechanism();
        let (_, speed, _) = m.speed.at(time);
        let cage = m.layout.cage(&self.state);
        for (value, channel) in self.pick.iter_mut().zip(&self.channels) {
            *value = match *channel {
                Channel::CageDisplacement(axis) => cage.centre[axis as usize],
                Channel::CageSpeed => m.orbit_ratio * speed + cage.arc_velocity / m.pitch_radius,
                Channel::BallSpin(ball) => {
                    let state = m.layout.ball(&self.state, ball);
                    let orbit = m.orbit_ratio * speed + state.arc_velocity / m.pitch_radius;
                    m.spin_ratio * speed + state.spin[0] - orbit
                }
                Channel::BallLoad(ball, BallContact::Inner) => self.snapshot.inner[ball],
                Channel::BallLoad(ball, BallContact::Outer) => self.snapshot.outer[ball],
                Channel::BallLoad(ball, BallContact::Pocket) => self.snapshot.pocket[ball],
                Channel::Spindle(..) => 0.0,
            };
        }
    }

    fn end_part(&mut self) {
        let (peaks, cage) = (std::mem::take(&mut self.snapshot.peaks), std::mem::take(&mut self.part_cage));
        self.parts.push(Quantities {
            max_load: peaks.load,
            cage_speed: cage.speed.mean().abs(),
            out_of_plane: peaks.out_of_plane,
            max_pocket_load: peaks.pocket_load,
            max_slip: peaks.slip_square.map(|square| square.sqrt()),
            orbit_radius: (cage.y.variance() + cage.z.variance()).sqrt(),
        });
    }

    /// Azimuth [rad], inner and outer load [N].
    fn of_the_first_ball(&self, time: f64) -> [f64; OF_THE_FIRST_BALL] {
        let (m, snapshot) = (self.model.mechanism(), &self.snapshot);
        let (angle, _, _) = m.speed.at(time);
        let arc = m.layout.ball(&self.state, 0).arc;
        [m.start_azimuth(0) + m.orbit_ratio * angle + arc / m.pitch_radius, snapshot.inner[0], snapshot.outer[0]]
    }

    fn take_loads(&mut self, [azimuth, inner, outer]: [f64; OF_THE_FIRST_BALL]) {
        if let Some(loads) = &mut self.loads {
            loads.look(|| (azimuth, inner, outer));
        }
    }

    /// rms of the spindle's accelerations in y and z so far [m/s²], any frequency; `None` before anything is kept.
    pub fn accelerations(&self) -> Option<[f64; 2]> {
        self.filtered.accelerations()
    }

    /// What was seen.
    pub fn finish(mut self) -> Recording {
        self.keep_between(f64::INFINITY);
        self.end_part();
        let total_variance = self.spindle.iter().zip(&self.moments).map(|(c, m)| (*c, m.variance())).collect();
        let (spindle, _) = self.filtered.finish();
        let (picked, whirl) = self.picked.finish();
        let largest = |of: fn(&Quantities) -> f64| self.parts.iter().map(of).fold(0.0, f64::max);
        Recording {
            start: self.start,
            signals: spindle.into_iter().chain(picked).collect(),
            whirl,
            total_variance,
            contacts: PerRaceway {
                inner: self.snapshot.met.inner.extremes(largest(|part| part.max_slip.inner)),
                outer: self.snapshot.met.outer.extremes(largest(|part| part.max_slip.outer)),
            },
            max_pocket_load: largest(|part| part.max_pocket_load),
            direction: if self.shaft.mean() < 0.0 { -1.0 } else { 1.0 },
            shaft_speed: self.shaft.mean().abs(),
            cage_speed: self.cage.mean().abs(),
            ball_spin: self.spin.mean(),
            parts: self.parts,
            loads: self.loads.map(LoadsTaken::finish),
            wander: None,
        }
    }
}
