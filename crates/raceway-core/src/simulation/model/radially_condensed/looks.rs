//! Looks at the motion, one a step: what of it is kept.

use super::{Look, RadiallyCondensed, Seen, Stepper};
use crate::numerics::decimation::Decimator;
use crate::numerics::interpolation::Interpolator;
use crate::numerics::lanes::{LANES, Lanes, Singles, larger};
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::film::ThinnestFilm;
use crate::physics::raceway::{RacewayContact, RelativeMotion};
use crate::simulation::input::channel::{Axis, BallContact, Channel, Motion};
use crate::simulation::input::settings::Outputs;
use crate::simulation::recording::load_course::LoadsTaken;
use crate::simulation::recording::record::ContactExtremes;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::picked_channels;
use crate::simulation::recording::windows::Recorder;

use super::evaluation::total;
use super::recording::{Pace, Schedule};

/// Spindle signals: place in y and z, velocity, acceleration.
pub(super) const SIGNALS: usize = 6;

/// Frames that are taken in at once.
const FRAMES: usize = 64;

/// What was seen so far.
pub(super) struct Looks<'a> {
    model: &'a RadiallyCondensed,
    schedule: Schedule,
    decimator: Decimator,
    interpolator: Interpolator<SIGNALS>,
    /// Frames that wait, one a step, and the step of the first of them: some at once are quicker.
    frames: Vec<[f64; SIGNALS]>,
    waiting_from: u64,
    /// The first frame stands for what was before: the run has none.
    primed: bool,
    filtered: Recorder,
    picked: Recorder,
    channels: Vec<Channel>,
    /// Of those at the last look and at this one.
    pick: [Vec<f64>; 2],
    /// Room for those between two looks, and the next of them, in parts of a step from the last look.
    between: Vec<f64>,
    next_pick: usize,
    /// Of the spindle's signals and of their squares, from the first one on, and what they are counted from.
    sums: [f64; SIGNALS],
    squares: [f64; SIGNALS],
    origin: [f64; SIGNALS],
    /// Sums at the kept values, and their number: of the shaft's speed, of the cage's velocity along the arc, and, lane by lane, of the
    /// balls' velocities along it and of their spins.
    shaft: f64,
    cage: f64,
    arc_velocity: Lanes,
    spin: Lanes,
    kept: f64,
    /// Largest distance of a ball from the middle of its pocket, along the orbit [m].
    wander: Lanes,
    extremes: Option<Extremes>,
    loads: Option<LoadsTaken>,
    thinnest: Option<PerRaceway<ThinnestFilm>>,
}

/// Largest values so far, group by group.
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

impl Extremes {
    #[inline(always)]
    fn look(&mut self, group: usize, seen: &Seen) {
        let (load, slip) = (&seen.load, &seen.slip);
        grow(&mut self.load[group].inner, |lane| load.inner[lane]);
        grow(&mut self.load[group].outer, |lane| load.outer[lane]);
        grow(&mut self.pocket, |lane| seen.pocket[lane]);
        let under = |load: &Singles, slip: &Singles, lane: usize| if load[lane] > 0.0 { slip[lane].abs() } else { 0.0 };
        grow(&mut self.slip.inner, |lane| under(&load.inner, &slip.inner, lane));
        grow(&mut self.slip.outer, |lane| under(&load.outer, &slip.outer, lane));
    }
}

impl<'a> Looks<'a> {
    pub fn new(model: &'a RadiallyCondensed, outputs: &Outputs, schedule: Schedule, primed: bool) -> Self {
        let channels = picked_channels(outputs, model.mechanism().layout.cage);
        let recorder = |channels: &[Channel]| Recorder::new(channels.iter().copied(), outputs, schedule.values);
        let extremes = Extremes {
            load: vec![PerRaceway::default(); model.groups()],
            slip: PerRaceway::default(),
            pocket: Singles::default(),
        };
        Self {
            model,
            schedule,
            decimator: Decimator::new(if schedule.pace.is_long() { 1 } else { schedule.pace.steps }, SIGNALS),
            interpolator: Interpolator::new(schedule.pace.steps, schedule.pace.values),
            frames: Vec::with_capacity(FRAMES),
            waiting_from: 0,
            primed,
            filtered: recorder(&spindle_channels()),
            picked: recorder(&channels),
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
            wander: Lanes::default(),
            extremes: (outputs.contacts || outputs.cage).then_some(extremes),
            loads: (outputs.contacts && outputs.keep_signals())
                .then(|| LoadsTaken::new(schedule.values, model.mechanism().steady_orbit_speed())),
            thinnest: model
                .needs()
                .film_thickness
                .then_some(PerRaceway { inner: ThinnestFilm::NONE, outer: ThinnestFilm::NONE }),
        }
    }

    /// At the first kept value.
    #[inline(never)]
    fn begin(&mut self, frame: &[f64; SIGNALS]) {
        self.origin = *frame;
        if self.primed {
            self.decimator.prime(frame);
            self.interpolator.prime(frame);
        }
    }

    /// Takes in the frames that wait: those of the kept time into the sums, and all of them through the filter where steps are shorter
    /// than the interval of the kept values, or with the values between steps where they are longer.
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
        if self.schedule.pace.is_long() {
            self.filtered.extend(self.interpolator.push(&self.frames, self.model.instructions));
        } else if self.schedule.pace.steps == 1 {
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

    /// Speeds and all channels besides the spindle's, as they stand.
    #[inline(always)]
    fn keep(&mut self, stepper: &Stepper<'_>) {
        let model = self.model;
        let m = model.mechanism();
        let speed = model.speed_at(stepper.time());
        let cage_arc = stepper.border().cage_arc;
        // Copies: what is stored in the loop cannot change them.
        let (mut wander, mut arc_velocity, mut spin) = (self.wander, self.arc_velocity, self.spin);
        for (balls, present) in stepper.balls().iter().zip(&model.present) {
            let (balls, present) = (*balls, *present);
            for lane in 0..LANES {
                // Copies of the last ball are as far as it is.
                wander[lane] = larger(wander[lane], (balls.arc[lane] - cage_arc).abs());
                arc_velocity[lane] += f64::from(balls.arc_velocity[lane] * present[lane]);
                spin[lane] += f64::from(balls.spin[lane] * present[lane]);
            }
        }
        (self.wander, self.arc_velocity, self.spin) = (wander, arc_velocity, spin);
        self.shaft += speed;
        self.cage += stepper.border().cage_velocity[2];
        let [last, now] = &mut self.pick;
        for (channel, now) in self.channels.iter().zip(now.iter_mut()) {
            *now = value(model, *channel, stepper, speed);
        }
        let Pace { steps, values } = self.schedule.pace;
        if values > 1 && self.kept > 0.0 && !now.is_empty() {
            // Straight between steps.
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
            loads.look(|| {
                let (angle, _, _) = m.speed.at(stepper.time());
                let (arc, load) = (stepper.balls()[0].arc[0], &stepper.seen()[0].load);
                let azimuth = m.start_azimuth(0) + m.orbit_ratio * angle + arc / m.pitch_radius;
                (azimuth, load.inner[0].into(), load.outer[0].into())
            });
        }
        self.kept += 1.0;
        if let Some(thinnest) = &mut self.thinnest {
            meet_films(model, stepper, speed, thinnest);
        }
    }

    /// rms of the spindle's accelerations in y and z so far [m/s²]; `None` before anything is kept.
    pub fn accelerations(&self) -> Option<[f64; 2]> {
        self.filtered.accelerations()
    }

    /// What was seen.
    pub fn finish(mut self, start: f64) -> Recording {
        self.keep_frames();
        if self.schedule.pace.is_long() && !self.channels.is_empty() {
            // The last value of all may fall on the last step.
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
        // Without a cage the balls' mean orbit speed stands for it.
        let cage = if m.layout.cage { self.cage / self.kept / m.pitch_radius } else { orbit };
        let contacts = self.contacts();
        let (spindle, _) = self.filtered.finish();
        let (picked, whirl) = self.picked.finish();
        Recording {
            start,
            total_variance: spindle_channels().into_iter().zip((0..SIGNALS).map(variance)).collect(),
            contacts,
            max_pocket_load: self.extremes.map_or(0.0, |seen| seen.pocket.0.into_iter().fold(0.0, f32::max).into()),
            signals: spindle.into_iter().chain(picked).collect(),
            whirl,
            direction: if shaft < 0.0 { -1.0 } else { 1.0 },
            shaft_speed: shaft.abs(),
            cage_speed: (m.orbit_ratio * shaft + cage).abs(),
            ball_spin: ((m.spin_ratio - m.orbit_ratio) * shaft + total(&self.spin) * per_ball - orbit).abs(),
            parts: Vec::new(),
            loads: self.loads.map(LoadsTaken::finish),
            wander: m.layout.cage.then(|| self.wander.0.into_iter().fold(0.0, f64::max)),
        }
    }

    fn contacts(&self) -> PerRaceway<ContactExtremes> {
        let balls = self.model.mechanism().layout.balls;
        let none = ContactExtremes { max_load: vec![0.0; balls], angle: None, max_slip: 0.0, least_film: None };
        let Some(extremes) = &self.extremes else {
            return PerRaceway { inner: none.clone(), outer: none };
        };
        let one = |load: &dyn Fn(&PerRaceway<Singles>) -> Singles, slip: &Singles, film: Option<ThinnestFilm>| {
            let max_load: Vec<f64> =
                (0..balls).map(|ball| load(&extremes.load[ball / LANES])[ball % LANES].into()).collect();
            let touched = max_load.iter().any(|load| *load > 0.0);
            ContactExtremes {
                max_load,
                angle: touched.then_some((0.0, 0.0)),
                max_slip: slip.0.into_iter().fold(0.0, f32::max).into(),
                least_film: film.map(|film| film.thickness).filter(|film| film.is_finite()),
            }
        };
        PerRaceway {
            inner: one(&|load| load.inner, &extremes.slip.inner, self.thinnest.map(|films| films.inner)),
            outer: one(&|load| load.outer, &extremes.slip.outer, self.thinnest.map(|films| films.outer)),
        }
    }
}

/// One look after the other, in the order of the steps.
impl Look for Looks<'_> {
    #[inline(always)]
    fn look(&mut self, stepper: &Stepper<'_>) {
        let (now, schedule) = (stepper.steps(), self.schedule);
        if now + (schedule.delay as u64) < schedule.first {
            return;
        }
        let counts = (schedule.first..=schedule.last).contains(&now);
        if now == schedule.first {
            self.begin(&frame(stepper));
        }
        if let (true, Some(extremes)) = (counts, &mut self.extremes) {
            stepper.seen().iter().enumerate().for_each(|(group, seen)| extremes.look(group, seen));
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
        let pace = schedule.pace;
        if counts && (pace.is_long() || (now - schedule.first).is_multiple_of(pace.steps as u64)) {
            self.keep(stepper);
        }
    }
}

fn spindle_channels() -> Vec<Channel> {
    let motions = [Motion::Displacement, Motion::Velocity, Motion::Acceleration];
    motions.into_iter().flat_map(|motion| [Axis::Y, Axis::Z].map(|axis| Channel::Spindle(axis, motion))).collect()
}

/// The spindle's signals at a look, as they stand in the stepper: what has just been stored in pairs can be read at once only so.
#[inline(always)]
fn frame(stepper: &Stepper<'_>) -> [f64; SIGNALS] {
    let (border, [ay, az]) = (stepper.border(), stepper.spindle_acceleration());
    let ([y, z], [vy, vz]) = (border.spindle, border.spindle_velocity);
    [y, z, vy, vz, ay, az]
}

/// A channel besides the spindle's.
fn value(model: &RadiallyCondensed, channel: Channel, stepper: &Stepper<'_>, speed: f64) -> f64 {
    let m = model.mechanism();
    let border = stepper.border();
    match channel {
        Channel::Spindle(..) | Channel::CageDisplacement(Axis::X) => 0.0,
        Channel::CageDisplacement(Axis::Y) => border.cage[0],
        Channel::CageDisplacement(Axis::Z) => border.cage[1],
        Channel::CageSpeed => m.orbit_ratio * speed + border.cage_velocity[2] / m.pitch_radius,
        Channel::BallSpin(ball) => {
            let (balls, lane) = (&stepper.balls()[ball / LANES], ball % LANES);
            let orbit = m.orbit_ratio * speed + f64::from(balls.arc_velocity[lane]) / m.pitch_radius;
            m.spin_ratio * speed + f64::from(balls.spin[lane]) - orbit
        }
        Channel::BallLoad(ball, contact) => {
            let (seen, lane) = (&stepper.seen()[ball / LANES], ball % LANES);
            f64::from(match contact {
                BallContact::Inner => seen.load.inner[lane],
                BallContact::Outer => seen.load.outer[lane],
                BallContact::Pocket => seen.pocket[lane],
            })
        }
    }
}

/// Meets the films under load, at the kept values.
fn meet_films(model: &RadiallyCondensed, stepper: &Stepper<'_>, speed: f64, thinnest: &mut PerRaceway<ThinnestFilm>) {
    let m = model.mechanism();
    for ball in 0..m.layout.balls {
        let (balls, lane) = (&stepper.balls()[ball / LANES], ball % LANES);
        let seen = &stepper.seen()[ball / LANES];
        let orbit = m.orbit_ratio * speed + f64::from(balls.arc_velocity[lane]) / m.pitch_radius;
        let meet = |contact: &RacewayContact, raceway_speed: f64, normal: f64, thinnest: &mut ThinnestFilm| {
            if normal <= 0.0 {
                return;
            }
            let motion = RelativeMotion {
                axial: 0.0,
                radius: m.pitch_radius,
                velocity: [0.0, 0.0, m.pitch_radius * orbit],
                spin: [m.spin_ratio * speed + f64::from(balls.spin[lane]), 0.0, 0.0],
                raceway_speed,
                orbit_speed: orbit,
                azimuth: 0.0,
            };
            contact.meet_film(contact.rolling_speed(&motion), normal, thinnest);
        };
        meet(&m.raceway.inner, speed, seen.load.inner[lane].into(), &mut thinnest.inner);
        meet(&m.raceway.outer, 0.0, seen.load.outer[lane].into(), &mut thinnest.outer);
    }
}
