//! The observer of the radially condensed model, which records every step.

use super::border::Border;
use super::equations::RadiallyCondensed;
use super::evaluation::{BallLoads, total};
use super::films::Films;
use super::loaded_lift::LoadedLift;
use super::stepping::{Observe, Stepper};
use crate::numerics::decimation::Decimator;
use crate::numerics::interpolation::Interpolator;
use crate::numerics::lanes::{LANES, Lanes, Singles, larger};
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::film::ThinnestFilm;
use crate::physics::kinematics::{BodySpeeds, cage_slip};
use crate::physics::life::reference::LoadMeans;
use crate::simulation::input::channel::{Axis, BallContact, Channel};
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::step_ratio::StepRatio;
use crate::simulation::model::surface_sites::SiteObserver;
use crate::simulation::recording::load_course::BallLoadRecorder;
use crate::simulation::recording::loaded_rolling::LoadedRolling;
use crate::simulation::recording::record::{ContactExtremes, Quantities, Recording};
use crate::simulation::recording::sampling::{SPINDLE_IN_PLANE, picked_channels};
use crate::simulation::recording::series::SeriesRecording;
use crate::simulation::recording::windows::Recorder;

/// Number of signals of the spindle.
const SIGNALS: usize = SPINDLE_IN_PLANE.len();

/// Number of frames that are processed together.
const FRAMES: usize = 64;
/// Number of parts of the recorded time whose extremes and means are recorded.
const PARTS: u64 = 20;

/// Steps of the recorded time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schedule {
    pub ratio: StepRatio,
    /// Step of the first recorded value.
    pub first: u64,
    /// Step of the last recorded value.
    pub last: u64,
    /// Number of recorded values.
    pub values: usize,
    /// Delay of the filter in steps.
    pub delay: usize,
}

/// Observer of a run with the recording so far.
pub(super) struct Observer<'a> {
    model: &'a RadiallyCondensed,
    schedule: Schedule,
    decimator: Decimator,
    interpolator: Interpolator<SIGNALS>,
    /// Frames of the last steps, not yet processed: several together are faster.
    frames: Vec<[f64; SIGNALS]>,
    /// Step of the first of these frames.
    waiting_from: u64,
    /// True if the first frame replaces the missing past of a run without settling time.
    primed: bool,
    filtered: Recorder,
    picked: Recorder,
    channels: Vec<Channel>,
    /// Values of these channels at the last step and at this one.
    pick: [Vec<f64>; 2],
    /// Values of these channels between two steps.
    between: Vec<f64>,
    /// Time of the next such value after the last step, in parts of a step.
    next_pick: usize,
    /// Sums of the spindle's signals and of their squares, both relative to the first values `origin`.
    sums: [f64; SIGNALS],
    squares: [f64; SIGNALS],
    origin: [f64; SIGNALS],
    /// Sums over the `kept` steps: of the shaft's speed, of the cage's velocity along the arc, and, by lane, of the balls' velocities
    /// along the arc and of their spins.
    shaft: f64,
    cage: f64,
    arc_velocity: Lanes,
    spin: Lanes,
    kept: f64,
    /// Largest distance of a ball from the middle of its pocket, along the orbit [m].
    largest_pocket_offset: Lanes,
    extremes: Option<Extremes>,
    /// Extremes and means of the current part, which ends before this step, and those of the parts before.
    part: Extremes,
    means: PartMeans,
    part_end: u64,
    parts: Vec<Quantities>,
    loads: Option<BallLoadRecorder>,
    films: Option<Films>,
    /// Loaded balls of the current part, where the slip of the cage is requested, and rolling in the parts before.
    lift: Option<LoadedLift>,
    rolling: LoadedRolling,
    /// Loads of the balls, where a life is requested.
    load_means: Option<LoadMeans>,
    /// Balls in the load zone and over defects, on raceways that are no circles.
    sites: Option<SiteObserver<'a>>,
}

/// Largest values of a part of the recorded time, by group of balls.
#[derive(Clone)]
struct Extremes {
    load: Vec<PerRaceway<Singles>>,
    slip: PerRaceway<Singles>,
    pocket: Singles,
}

#[inline(always)]
fn grow(largest: &mut Singles, seen: impl Fn(usize) -> f32) {
    for lane in 0..LANES {
        largest[lane] = larger(largest[lane], seen(lane));
    }
}

/// Means of a part of the recorded time.
#[derive(Clone, Copy, Default)]
struct PartMeans {
    steps: f64,
    shaft: f64,
    /// Velocity of the cage along the arc.
    cage: f64,
    /// Place of the cage, relative to the place at the start of the part, and its squares.
    origin: [f64; 2],
    place: [f64; 2],
    squares: [f64; 2],
}

impl PartMeans {
    #[inline(always)]
    fn add(&mut self, shaft: f64, border: &Border) {
        if self.steps == 0.0 {
            self.origin = border.cage;
        }
        self.steps += 1.0;
        self.shaft += shaft;
        self.cage += border.cage_velocity[2];
        for axis in 0..2 {
            let off = border.cage[axis] - self.origin[axis];
            self.place[axis] += off;
            self.squares[axis] += off * off;
        }
    }

    /// Rms distance of the cage from its mean place [m].
    fn orbit_radius(&self) -> f64 {
        let variance =
            |axis: usize| (self.squares[axis] - self.place[axis] * self.place[axis] / self.steps) / self.steps;
        (variance(0) + variance(1)).max(0.0).sqrt()
    }
}

impl Extremes {
    fn new(groups: usize) -> Self {
        Self { load: vec![PerRaceway::default(); groups], slip: PerRaceway::default(), pocket: Singles::default() }
    }

    /// Takes the extremes of a part, and empties them.
    fn absorb(&mut self, part: &mut Self) {
        for (load, part) in self.load.iter_mut().zip(&part.load) {
            grow(&mut load.inner, |lane| part.inner[lane]);
            grow(&mut load.outer, |lane| part.outer[lane]);
        }
        grow(&mut self.slip.inner, |lane| part.slip.inner[lane]);
        grow(&mut self.slip.outer, |lane| part.slip.outer[lane]);
        grow(&mut self.pocket, |lane| part.pocket[lane]);
        *part = Self::new(part.load.len());
    }

    #[inline(always)]
    fn observe(&mut self, group: usize, seen: &BallLoads) {
        let (load, slip) = (&seen.load, &seen.slip);
        grow(&mut self.load[group].inner, |lane| load.inner[lane]);
        grow(&mut self.load[group].outer, |lane| load.outer[lane]);
        grow(&mut self.pocket, |lane| seen.pocket[lane]);
        let under = |load: &Singles, slip: &Singles, lane: usize| if load[lane] > 0.0 { slip[lane].abs() } else { 0.0 };
        grow(&mut self.slip.inner, |lane| under(&load.inner, &slip.inner, lane));
        grow(&mut self.slip.outer, |lane| under(&load.outer, &slip.outer, lane));
    }
}

impl<'a> Observer<'a> {
    pub(super) fn new(
        model: &'a RadiallyCondensed,
        outputs: &Outputs,
        schedule: Schedule,
        primed: bool,
        series: Option<SeriesRecording>,
    ) -> Self {
        let channels = picked_channels(outputs, model.mechanism().layout.cage);
        let picked = Recorder::new(channels.iter().copied(), outputs, schedule.values).with_series(series.clone());
        let extremes = Extremes::new(model.groups());
        Self {
            model,
            schedule,
            decimator: Decimator::new(if schedule.ratio.is_long() { 1 } else { schedule.ratio.steps }, SIGNALS),
            interpolator: Interpolator::new(schedule.ratio.steps, schedule.ratio.values),
            frames: Vec::with_capacity(FRAMES),
            waiting_from: 0,
            primed,
            filtered: Recorder::behind_filter(SPINDLE_IN_PLANE, outputs, schedule.values).with_series(series),
            picked,
            pick: [vec![0.0; channels.len()], vec![0.0; channels.len()]],
            between: Vec::with_capacity(channels.len()),
            next_pick: 0,
            channels,
            sums: [0.0; SIGNALS],
            squares: [0.0; SIGNALS],
            origin: [0.0; SIGNALS],
            shaft: 0.0,
            cage: 0.0,
            arc_velocity: Lanes::default(),
            spin: Lanes::default(),
            kept: 0.0,
            largest_pocket_offset: Lanes::default(),
            part_end: schedule.first + part_steps(&schedule),
            part: extremes.clone(),
            means: PartMeans::default(),
            parts: Vec::with_capacity(PARTS as usize + 1),
            extremes: (outputs.contacts || outputs.cage).then_some(extremes),
            loads: (outputs.contacts && outputs.keep_signals())
                .then(|| BallLoadRecorder::new(schedule.values, model.mechanism().steady_orbit_speed())),
            films: model.needs().film_thickness.then(Films::new),
            lift: outputs.cage.then(LoadedLift::default),
            rolling: LoadedRolling::default(),
            load_means: outputs.life.then(|| model.mechanism().load_means()),
            sites: model.mechanism().sites.as_ref().map(|sites| {
                let window = outputs.keep_signals().then_some(outputs.longest_window);
                SiteObserver::new(sites, model.mechanism().layout.balls, outputs.contacts, window)
            }),
        }
    }

    /// Prepares filter and sums at the first recorded value.
    #[inline(never)]
    fn begin(&mut self, frame: &[f64; SIGNALS]) {
        self.origin = *frame;
        if self.primed {
            self.decimator.prime(frame);
            self.interpolator.prime(frame);
        }
    }

    /// Processes the waiting frames. Those of the recorded time enter the sums. All of them pass the filter where steps are shorter than the
    /// interval of recorded values, or the interpolation where steps are longer.
    #[inline(never)]
    fn keep_frames(&mut self) {
        let (mut sums, mut squares) = (self.sums, self.squares);
        for (step, frame) in (self.waiting_from..).zip(&self.frames) {
            if (self.schedule.first..=self.schedule.last).contains(&step) {
                for i in 0..SIGNALS {
                    let off = frame[i] - self.origin[i];
                    sums[i] += off;
                    squares[i] += off * off;
                }
            }
        }
        (self.sums, self.squares) = (sums, squares);
        if self.schedule.ratio.is_long() {
            self.filtered.extend(self.interpolator.push(&self.frames, self.model.instructions));
        } else if self.schedule.ratio.steps == 1 {
            self.filtered.extend(&self.frames);
        } else {
            for frame in &self.frames {
                if let Some(frame) = self.decimator.push(frame) {
                    self.filtered.push(frame);
                }
            }
        }
        self.frames.clear();
    }

    /// Records speeds and all channels other than the spindle's at this step.
    #[inline(always)]
    fn keep(&mut self, stepper: &Stepper<'_>) {
        let model = self.model;
        let m = model.mechanism();
        let speed = model.speed_at(stepper.time());
        let cage_arc = stepper.border().cage_arc;
        // Local copies, which no store in the loop can change.
        let (mut largest_pocket_offset, mut arc_velocity, mut spin) =
            (self.largest_pocket_offset, self.arc_velocity, self.spin);
        for (balls, present) in stepper.balls().iter().zip(&model.present) {
            let (balls, present) = (*balls, *present);
            for lane in 0..LANES {
                // Copies of the last ball have the same offset as the ball.
                largest_pocket_offset[lane] = larger(largest_pocket_offset[lane], (balls.arc[lane] - cage_arc).abs());
                arc_velocity[lane] += f64::from(balls.arc_velocity[lane] * present[lane]);
                spin[lane] += f64::from(balls.spin[lane] * present[lane]);
            }
        }
        (self.largest_pocket_offset, self.arc_velocity, self.spin) = (largest_pocket_offset, arc_velocity, spin);
        self.shaft += speed;
        self.cage += stepper.border().cage_velocity[2];
        let [last, now] = &mut self.pick;
        for (channel, now) in self.channels.iter().zip(now.iter_mut()) {
            *now = value(model, *channel, stepper, speed);
        }
        let StepRatio { steps, values } = self.schedule.ratio;
        if values > 1 && self.kept > 0.0 && !now.is_empty() {
            // Linear interpolation between steps.
            while self.next_pick < values {
                let part = self.next_pick as f64 / values as f64;
                let between = last.iter_mut().zip(now.iter()).map(|(last, now)| *last + part * (now - *last));
                self.between.clear();
                self.between.extend(between);
                self.picked.push(&self.between);
                self.next_pick += steps;
            }
            self.next_pick -= values;
        } else if values == 1 {
            self.picked.push(now);
        }
        std::mem::swap(last, now);
        if let Some(loads) = &mut self.loads {
            loads.offer(|| {
                let (angle, _, _) = m.rotation.inner.at(stepper.time());
                let (arc, load) = (stepper.balls()[0].arc[0], &stepper.ball_loads()[0].load);
                let azimuth = m.start_azimuth(0) + m.orbit_ratio * angle + arc / m.pitch_radius;
                (azimuth, load.inner[0].into(), load.outer[0].into())
            });
        }
        self.kept += 1.0;
        if let Some(lift) = &mut self.lift {
            lift.observe(stepper.ball_loads(), &model.present);
        }
        if let Some(means) = &mut self.load_means {
            for ball in 0..m.layout.balls {
                let PerRaceway { inner, outer } = &stepper.ball_loads()[ball / LANES].load;
                let [inner, outer] = [inner, outer].map(|load| f64::from(load[ball % LANES]));
                means.add(PerRaceway { inner, outer });
            }
        }
        if let Some(films) = &mut self.films {
            films.record(m, stepper.balls(), stepper.ball_loads(), speed);
        }
        self.observe_sites(stepper);
    }

    #[inline(never)]
    fn observe_sites(&mut self, stepper: &Stepper<'_>) {
        let m = self.model.mechanism();
        let Some(sites) = &mut self.sites else { return };
        let (angle, _, _) = m.rotation.inner.at(stepper.time());
        sites.observe(stepper.time(), PerRaceway { inner: angle, outer: 0.0 }, |ball| {
            let (group, lane) = (ball / LANES, ball % LANES);
            let (arc, load) = (stepper.balls()[group].arc[lane], &stepper.ball_loads()[group].load);
            let azimuth = m.start_azimuth(ball) + m.orbit_ratio * angle + arc / m.pitch_radius;
            (azimuth, PerRaceway { inner: load.inner[lane].into(), outer: load.outer[lane].into() })
        });
    }

    /// Records the extremes and means of the current part.
    #[inline(never)]
    fn end_part(&mut self) {
        let Some(extremes) = &mut self.extremes else { return };
        if self.means.steps == 0.0 {
            return;
        }
        let most = |seen: &Singles| f64::from(seen.0.into_iter().fold(0.0, f32::max));
        let m = self.model.mechanism();
        let loads = self.part.load.iter().map(|load| most(&load.inner).max(most(&load.outer)));
        let PartMeans { steps, shaft, cage, .. } = self.means;
        let cage_speed = (m.orbit_ratio * shaft / steps + cage / steps / m.pitch_radius).abs();
        let rolling = self.lift.as_mut().map(|lift| std::mem::take(lift).rolling(m)).unwrap_or_default();
        self.rolling.join(rolling);
        self.parts.push(Quantities {
            max_load: loads.fold(0.0, f64::max),
            cage_speed,
            out_of_plane: 0.0,
            max_pocket_load: most(&self.part.pocket),
            max_slip: PerRaceway { inner: most(&self.part.slip.inner), outer: most(&self.part.slip.outer) },
            orbit_radius: self.means.orbit_radius(),
            cage_slip: rolling.mean().and_then(|ratio| cage_slip(cage_speed, (shaft / steps).abs(), ratio)),
        });
        extremes.absorb(&mut self.part);
        self.means = PartMeans::default();
    }

    /// rms of the spindle's accelerations in y and z so far [m/s²]; `None` before the first recorded value.
    pub(super) fn accelerations(&self) -> Option<[f64; 2]> {
        self.filtered.accelerations()
    }

    /// The recording; `start`: time of the first recorded value [s].
    pub(super) fn finish(mut self, start: f64) -> Recording {
        self.keep_frames();
        self.end_part();
        if self.schedule.ratio.is_long() && !self.channels.is_empty() {
            // The last value may be at the time of the last step.
            self.picked.push(&self.pick[0]);
        }
        let count = (self.schedule.last - self.schedule.first + 1) as f64;
        let variance = |signal: usize| {
            let (sum, squares) = (self.sums[signal], self.squares[signal]);
            ((squares - sum * sum / count) / count).max(0.0)
        };
        let m = self.model.mechanism();
        let per_ball = 1.0 / (self.kept * m.layout.balls as f64);
        let shaft = self.shaft / self.kept;
        let orbit = total(&self.arc_velocity) * per_ball / m.pitch_radius;
        // Without a cage the mean orbit speed of the balls replaces its speed.
        let cage = if m.layout.cage { self.cage / self.kept / m.pitch_radius } else { orbit };
        let contacts = self.contacts();
        let series = self.filtered.series();
        let (spindle, spindle_whirl) = self.filtered.finish();
        let (picked, whirl) = self.picked.finish();
        Recording {
            start,
            total_variance: SPINDLE_IN_PLANE.into_iter().zip((0..SIGNALS).map(variance)).collect(),
            contacts,
            max_pocket_load: self.extremes.map_or(0.0, |seen| seen.pocket.0.into_iter().fold(0.0, f32::max).into()),
            signals: spindle.into_iter().chain(picked).collect(),
            series,
            whirl,
            spindle_whirl,
            direction: if shaft < 0.0 { -1.0 } else { 1.0 },
            speeds: BodySpeeds::new(
                shaft.into(),
                m.orbit_ratio * shaft + cage,
                ((m.spin_ratio - m.orbit_ratio) * shaft + total(&self.spin) * per_ball - orbit).abs(),
            ),
            loaded_orbit_ratio: self.rolling.mean(),
            load_means: self.load_means.map(|means| means.means()),
            powers: None,
            tracks: Vec::new(),
            parts: self.parts,
            loads: self.loads.map(BallLoadRecorder::finish),
            passages: self.sites.map(SiteObserver::into_passages).unwrap_or_default(),
            largest_pocket_offset: m.layout.cage.then(|| self.largest_pocket_offset.0.into_iter().fold(0.0, f64::max)),
        }
    }

    fn contacts(&self) -> PerRaceway<ContactExtremes> {
        let balls = self.model.mechanism().layout.balls;
        let none =
            ContactExtremes { max_load: vec![0.0; balls], angle: None, max_slip: 0.0, least_film: None, off: None };
        let Some(extremes) = &self.extremes else {
            return PerRaceway { inner: none.clone(), outer: none };
        };
        let off = self.sites.as_ref().and_then(SiteObserver::off_shares);
        let one = |load: &dyn Fn(&PerRaceway<Singles>) -> Singles, slip: &Singles, film: Option<ThinnestFilm>| {
            let max_load: Vec<f64> =
                (0..balls).map(|ball| load(&extremes.load[ball / LANES])[ball % LANES].into()).collect();
            let touched = max_load.iter().any(|load| *load > 0.0);
            ContactExtremes {
                max_load,
                angle: touched.then_some((0.0, 0.0)),
                max_slip: slip.0.into_iter().fold(0.0, f32::max).into(),
                least_film: film.map(|film| film.thickness).filter(|film| film.is_finite()),
                off: None,
            }
        };
        let film =
            |of: fn(&PerRaceway<ThinnestFilm>) -> ThinnestFilm| self.films.as_ref().map(|films| of(&films.thinnest));
        let inner = one(&|load| load.inner, &extremes.slip.inner, film(|thinnest| thinnest.inner));
        let outer = one(&|load| load.outer, &extremes.slip.outer, film(|thinnest| thinnest.outer));
        PerRaceway {
            inner: ContactExtremes { off: off.map(|off| off.inner), ..inner },
            outer: ContactExtremes { off: off.map(|off| off.outer), ..outer },
        }
    }
}

/// Observes each step in order.
impl Observe for Observer<'_> {
    #[inline(always)]
    fn observe(&mut self, stepper: &Stepper<'_>) {
        let (now, schedule) = (stepper.steps(), self.schedule);
        if now + (schedule.delay as u64) < schedule.first {
            return;
        }
        let counts = (schedule.first..=schedule.last).contains(&now);
        if now == schedule.first {
            self.begin(&frame(stepper));
        }
        if let (true, true) = (counts, self.extremes.is_some()) {
            if now >= self.part_end {
                self.end_part();
                self.part_end = now + part_steps(&schedule);
            }
            let part = &mut self.part;
            stepper.ball_loads().iter().enumerate().for_each(|(group, seen)| part.observe(group, seen));
            self.means.add(self.model.speed_at(stepper.time()), stepper.border());
        }
        if !self.primed || now >= schedule.first {
            if self.frames.is_empty() {
                self.waiting_from = now;
            }
            self.frames.push(frame(stepper));
            if self.frames.len() == FRAMES {
                self.keep_frames();
            }
        }
        let ratio = schedule.ratio;
        if counts && (ratio.is_long() || (now - schedule.first).is_multiple_of(ratio.steps as u64)) {
            self.keep(stepper);
        }
    }
}

/// Steps of a part of the recorded time.
fn part_steps(schedule: &Schedule) -> u64 {
    (schedule.last - schedule.first + 1).div_ceil(PARTS)
}

/// The spindle's signals at a step, in the order of the stepper: values that were just stored in pairs can be loaded in pairs at once.
#[inline(always)]
fn frame(stepper: &Stepper<'_>) -> [f64; SIGNALS] {
    let (border, [ay, az]) = (stepper.border(), stepper.spindle_acceleration());
    let ([y, z], [vy, vz]) = (border.spindle, border.spindle_velocity);
    [y, z, vy, vz, ay, az]
}

/// Value of a channel other than the spindle's.
fn value(model: &RadiallyCondensed, channel: Channel, stepper: &Stepper<'_>, speed: f64) -> f64 {
    let m = model.mechanism();
    let border = stepper.border();
    match channel {
        Channel::Spindle(..) | Channel::SpindleTilt(_) | Channel::CageDisplacement(Axis::X) => 0.0,
        Channel::CageDisplacement(Axis::Y) => border.cage[0],
        Channel::CageDisplacement(Axis::Z) => border.cage[1],
        Channel::CageSpeed => m.orbit_ratio * speed + border.cage_velocity[2] / m.pitch_radius,
        Channel::BallSpin(ball) => {
            let (balls, lane) = (&stepper.balls()[ball / LANES], ball % LANES);
            let orbit = m.orbit_ratio * speed + f64::from(balls.arc_velocity[lane]) / m.pitch_radius;
            m.spin_ratio * speed + f64::from(balls.spin[lane]) - orbit
        }
        Channel::BallLoad(ball, contact) => {
            let (seen, lane) = (&stepper.ball_loads()[ball / LANES], ball % LANES);
            f64::from(match contact {
                BallContact::Inner => seen.load.inner[lane],
                BallContact::Outer => seen.load.outer[lane],
                BallContact::Pocket => seen.pocket[lane],
            })
        }
    }
}
