//! Which signals are kept, and how often.
//!
//! The motion is looked at 409 600 times a second, by interpolation within the steps, and less often where long steps damp what is
//! so fast. The spindle's signals pass a
//! low-pass filter on their way to 102 400 values a second (contact resonances lie above the band of interest and must not
//! fold into it); all others are kept as they stand at those times, window by window (`windows.rs`). Extremes see every look.

use super::channel::{Axis, BallContact, Channel, Motion};
use super::model::{Model, Watch};
use super::needs::Needs;
use super::run::{Method, Outputs, RunSettings};
use super::views::{LoadsAlong, LoadsTaken};
use super::windows::{Recorder, Signal, Whirl};
use crate::numerics::ode::Integrator;
use crate::numerics::parallel::both;
use crate::numerics::spectrum::Decimator;
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::film::ThinnestFilm;
use crate::physics::frames::length;
use crate::physics::pocket::PocketLoad;
use crate::physics::raceway::{RacewayLoad, RelativeMotion};

/// Rate at which signals are kept [Hz].
pub const RATE: f64 = 102_400.0;
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

/// What was seen of one kind of raceway contact, all balls, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactExtremes {
    pub max_load: Vec<f64>,
    /// Range of contact angles under load [rad].
    pub angle: Option<(f64, f64)>,
    pub max_slip: f64,
    /// Least minimum film thickness under load [m]; `None` where it was not asked for.
    pub least_film: Option<f64>,
}

/// Single numbers of a motion that are compared with those of a repetition, in SI.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Quantities {
    /// Largest load of any raceway contact [N].
    pub max_load: f64,
    /// Mean over the time, absolute value [rad/s].
    pub cage_speed: f64,
    /// Sine of the largest contact angle under load, either way [-].
    pub out_of_plane: f64,
    /// Largest load of any pocket [N].
    pub max_pocket_load: f64,
    /// Largest slip at a contact's centre under load [m/s].
    pub max_slip: PerRaceway<f64>,
    /// Rms distance of the cage's centre from its mean position [m].
    pub orbit_radius: f64,
}

/// What a run has shown, in SI.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Time of the first kept value [s]; the others follow at `RATE`.
    pub start: f64,
    pub signals: Vec<Signal>,
    /// Of the cage's centre over several windows.
    pub whirl: Option<Whirl>,
    /// Variance of the spindle's signals before the filter, where they passed one.
    pub total_variance: Vec<(Channel, f64)>,
    pub contacts: PerRaceway<ContactExtremes>,
    pub max_pocket_load: f64,
    /// Sign of the shaft's mean speed.
    pub direction: f64,
    /// Means over the kept time, absolute values [rad/s].
    pub shaft_speed: f64,
    pub cage_speed: f64,
    /// Of a ball about its own axis, seen from the orbit frame.
    pub ball_spin: f64,
    /// Over each stretch of `PART` kept values.
    pub parts: Vec<Quantities>,
    /// Of the first ball along its way, where contacts are asked for.
    pub loads: Option<LoadsAlong>,
    /// Largest distance along the orbit of a ball from the middle of its pocket [m]; `None` where nobody looked.
    pub wander: Option<f64>,
}

impl Recording {
    /// What is known of a channel.
    pub fn of(&self, channel: Channel) -> Option<&Signal> {
        self.signals.iter().find(|signal| signal.channel == channel)
    }

    /// Works out on two cores what levels and spectra ask of the spindle's signals, which takes as long as a short run. Where no signals
    /// are kept, many such runs go side by side, and each does what it is asked for when it is asked.
    pub fn evaluate(&self, outputs: &Outputs) {
        let one = |signal: &Signal| {
            if outputs.vibration {
                signal.in_band();
            }
            signal.spectra();
        };
        let is_of_y = |signal: &&Signal| matches!(signal.channel, Channel::Spindle(Axis::Y, _));
        if outputs.keep_signals() {
            let others = || self.signals.iter().filter(|signal| !is_of_y(signal)).for_each(one);
            both(|| self.signals.iter().filter(is_of_y).for_each(one), others);
        }
    }

    /// Every kept value of a channel [SI], in a run of one window or where the series is asked for.
    pub fn signal(&self, channel: Channel) -> Option<&[f64]> {
        self.of(channel)?.values()
    }

    /// How the cage's centre turned; `None` where it was not looked at.
    pub fn whirl(&self) -> Option<Whirl> {
        let place = |axis| self.signal(Channel::CageDisplacement(axis));
        self.whirl.or_else(|| Some(Whirl::of(place(Axis::Y)?, place(Axis::Z)?)))
    }

    /// Rms distance of the cage's centre from its mean position [m]; `None` where it was not looked at.
    pub fn orbit_radius(&self) -> Option<f64> {
        let rms = |axis| Some(self.of(Channel::CageDisplacement(axis))?.all().rms());
        Some(rms(Axis::Y)?.hypot(rms(Axis::Z)?))
    }

    /// Variance of a signal before any filter.
    pub fn total_variance(&self, channel: Channel) -> f64 {
        let before = self.total_variance.iter().find(|(of, _)| *of == channel);
        let unfiltered = || self.of(channel).map_or(0.0, |signal| signal.all().rms().powi(2));
        before.map_or_else(unfiltered, |(_, variance)| *variance)
    }

    /// Over all that was kept.
    pub fn quantities(&self) -> Quantities {
        let loads = self.contacts.inner.max_load.iter().chain(&self.contacts.outer.max_load);
        Quantities {
            max_load: loads.copied().fold(0.0, f64::max),
            cage_speed: self.cage_speed,
            out_of_plane: self.parts.iter().fold(0.0, |most, part| f64::max(most, part.out_of_plane)),
            max_pocket_load: self.max_pocket_load,
            max_slip: self.contacts.map(|contact| contact.max_slip),
            orbit_radius: self.orbit_radius().unwrap_or_default(),
        }
    }
}

/// Loads of one look.
struct Snapshot {
    film: bool,
    inner: Vec<f64>,
    outer: Vec<f64>,
    pocket: Vec<f64>,
    /// What was met so far; it grows only while `counts` is set.
    met: PerRaceway<Met>,
    /// The same since the last part ended.
    peaks: Peaks,
    counts: bool,
}

/// Largest values over a part of a run.
#[derive(Clone, Copy, Default)]
struct Peaks {
    /// Of any raceway contact [N].
    load: f64,
    /// Of any pocket [N].
    pocket_load: f64,
    /// Sine of the contact angle, either way.
    out_of_plane: f64,
    /// Square of the slip [m²/s²].
    slip_square: PerRaceway<f64>,
}

/// Extremes of one kind of contact on the way, in the form that costs least to compare.
#[derive(Clone)]
struct Met {
    max_load: Vec<f64>,
    /// Sine and cosine of the least and the largest contact angle, between ±90°: the sine grows with the angle.
    angles: Option<[(f64, f64); 2]>,
    film: ThinnestFilm,
}

impl Met {
    fn new(balls: usize) -> Self {
        Self { max_load: vec![0.0; balls], angles: None, film: ThinnestFilm::NONE }
    }

    fn extremes(self, max_slip: f64) -> ContactExtremes {
        ContactExtremes {
            max_load: self.max_load,
            angle: self.angles.map(|[least, most]| (least.0.atan2(least.1), most.0.atan2(most.1))),
            max_slip,
            least_film: Some(self.film.thickness).filter(|film| film.is_finite()),
        }
    }
}

/// The watch of one look, with the model it looks at.
struct Look<'a> {
    model: &'a Model,
    snapshot: &'a mut Snapshot,
}

impl Watch for Look<'_> {
    fn raceway(&mut self, ball: usize, side: BallContact, motion: &RelativeMotion, load: &RacewayLoad) {
        let snapshot = &mut *self.snapshot;
        let raceway = &self.model.mechanism().raceway;
        let (met, peaks) = (&mut snapshot.met, &mut snapshot.peaks);
        let (loads, met, slip_square, contact) = match side {
            BallContact::Inner => (&mut snapshot.inner, &mut met.inner, &mut peaks.slip_square.inner, &raceway.inner),
            _ => (&mut snapshot.outer, &mut met.outer, &mut peaks.slip_square.outer, &raceway.outer),
        };
        loads[ball] = load.normal;
        if !snapshot.counts || load.normal <= 0.0 {
            return;
        }
        met.max_load[ball] = met.max_load[ball].max(load.normal);
        *slip_square = slip_square.max(load.slip.0 * load.slip.0 + load.slip.1 * load.slip.1);
        peaks.load = peaks.load.max(load.normal);
        peaks.out_of_plane = peaks.out_of_plane.max(load.angle.0.abs());
        let [least, most] = met.angles.get_or_insert([load.angle; 2]);
        if load.angle.0 < least.0 {
            *least = load.angle;
        }
        if load.angle.0 > most.0 {
            *most = load.angle;
        }
        if snapshot.film {
            contact.meet_film(motion, load, &mut met.film);
        }
    }

    fn pocket(&mut self, ball: usize, load: &PocketLoad) {
        self.snapshot.pocket[ball] = load.normal;
        if self.snapshot.counts {
            self.snapshot.peaks.pocket_load = self.snapshot.peaks.pocket_load.max(load.normal);
        }
    }
}

/// Mean and variance of a growing sample (Welford).
#[derive(Clone, Copy, Default)]
struct Moments {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f64) {
        self.count += 1.0;
        let off = value - self.mean;
        self.mean += off / self.count;
        self.squares += off * (value - self.mean);
    }

    fn variance(&self) -> f64 {
        if self.count > 0.0 { self.squares / self.count } else { 0.0 }
    }
}

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

    /// Takes all looks that lie within the last step.
    pub fn after(&mut self, step: &dyn Integrator) {
        while self.next_look().is_some_and(|time| time <= step.time()) {
            self.look(|time, state| step.interpolate(time, state));
        }
    }

    /// Takes the look at `next_look()`; `fill` writes the state then.
    fn look(&mut self, fill: impl FnOnce(f64, &mut [f64])) {
        let time = self.look_time(self.looks);
        fill(time, &mut self.state);
        let place = self.looks.checked_sub(self.lead).filter(|place| *place <= (self.values - 1) * self.oversampling);
        self.snapshot.counts = place.is_some();
        if place.is_some_and(|place| place > 0 && place % (PART * self.oversampling) == 0) {
            self.end_part();
        }
        let mut watch = Look { model: self.model, snapshot: &mut self.snapshot };
        self.model.derivative_watched(time, &self.state, &mut self.derivative, &mut watch);
        self.gather_spindle();
        if self.lead == 0 && self.looks == 0 {
            self.decimator.prime(&self.frame);
        }
        if let Some(place) = place {
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
            if place % self.oversampling == 0 {
                self.pick(time);
                self.take_loads(time);
            }
        }
        if let Some(frame) = self.decimator.push(&self.frame) {
            self.filtered.push(frame);
        }
        self.looks += 1;
    }

    fn gather_spindle(&mut self) {
        let layout = self.model.mechanism().layout;
        let (now, rate) = (layout.spindle(&self.state), layout.spindle(&self.derivative));
        for (value, channel) in self.frame.iter_mut().zip(&self.spindle) {
            if let Channel::Spindle(axis, motion) = *channel {
                let vector = match motion {
                    Motion::Displacement => now.position,
                    Motion::Velocity => now.velocity,
                    Motion::Acceleration => rate.velocity,
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
        self.picked.push(&self.pick);
    }

    fn end_part(&mut self) {
        let (peaks, cage) = (std::mem::take(&mut self.snapshot.peaks), std::mem::take(&mut self.part_cage));
        self.parts.push(Quantities {
            max_load: peaks.load,
            cage_speed: cage.speed.mean.abs(),
            out_of_plane: peaks.out_of_plane,
            max_pocket_load: peaks.pocket_load,
            max_slip: peaks.slip_square.map(|square| square.sqrt()),
            orbit_radius: (cage.y.variance() + cage.z.variance()).sqrt(),
        });
    }

    fn take_loads(&mut self, time: f64) {
        let Some(loads) = &mut self.loads else { return };
        let (m, snapshot, state) = (self.model.mechanism(), &self.snapshot, &self.state);
        loads.look(|| {
            let (angle, _, _) = m.speed.at(time);
            let arc = m.layout.ball(state, 0).arc;
            (m.start_azimuth(0) + m.orbit_ratio * angle + arc / m.pitch_radius, snapshot.inner[0], snapshot.outer[0])
        });
    }

    /// rms of the spindle's accelerations in y and z so far [m/s²], any frequency; `None` before anything is kept.
    pub fn accelerations(&self) -> Option<[f64; 2]> {
        self.filtered.accelerations()
    }

    /// What was seen.
    pub fn finish(mut self) -> Recording {
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
            direction: if self.shaft.mean < 0.0 { -1.0 } else { 1.0 },
            shaft_speed: self.shaft.mean.abs(),
            cage_speed: self.cage.mean.abs(),
            ball_spin: self.spin.mean,
            parts: self.parts,
            loads: self.loads.map(LoadsTaken::finish),
            wander: None,
        }
    }
}

/// Channels besides the spindle's that the outputs need, kept as they stand; `cage`: whether there is one.
pub fn picked_channels(outputs: &Outputs, cage: bool) -> Vec<Channel> {
    let orbit = [Channel::CageDisplacement(Axis::Y), Channel::CageDisplacement(Axis::Z)];
    let mut picked: Vec<Channel> = if outputs.cage && cage { orbit.to_vec() } else { Vec::new() };
    for &channel in outputs.spectra.iter().chain(&outputs.series) {
        if !matches!(channel, Channel::Spindle(..)) && !picked.contains(&channel) {
            picked.push(channel);
        }
    }
    picked
}

/// Number of values kept of a channel over a duration [s]; at least one.
pub fn kept_values(duration: f64) -> usize {
    ((duration * RATE).round() as usize).max(1)
}
