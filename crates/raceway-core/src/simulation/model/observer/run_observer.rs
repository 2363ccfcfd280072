//! The observer of a run: its sampling times, and the path of each sample into the recording.

use super::moments::{CageMoments, Moments};
use super::powers::PowerObserver;
use super::snapshot::{Contact, Peaks, RunningExtremes, Snapshot, SnapshotWatch};
use crate::numerics::decimation::Decimator;
use crate::numerics::interpolation::Course;
use crate::numerics::ode::Integrator;
use crate::numerics::ode::Method;
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Azimuth, Vector, dot, length};
use crate::physics::kinematics::{BodySpeeds, LoadedBall, RingSpeeds};
use crate::physics::life::reference::LoadMeans;
use crate::simulation::input::channel::{Axis, BallContact, Channel, Motion};
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::mechanism::direction;
use crate::simulation::model::step_loads::{PackedStepLoads, StepLoads};
use crate::simulation::model::surface_sites::SiteObserver;
use crate::simulation::model::system::Model;
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::recording::ball_tracks::BallTracks;
use crate::simulation::recording::load_course::BallLoadRecorder;
use crate::simulation::recording::loaded_rolling::LoadedRolling;
use crate::simulation::recording::record::{Quantities, Recording};
use crate::simulation::recording::sampling::kept_values;
use crate::simulation::recording::sampling::picked_channels;
use crate::simulation::recording::sampling::{PART, RATE};
use crate::simulation::recording::series::SeriesRecording;
use crate::simulation::recording::windows::Recorder;

/// Samples per recorded value [-], which resolve fast motion; not needed if long fixed steps damp this motion.
const OVERSAMPLING: usize = 4;
/// Steps per sample from which samples resolve all motion that the steps leave. Motion faster than half the sampling rate then turns by
/// 120° a step or more, and loses half of its amplitude or more with each step.
const STEPS_PER_SAMPLE: f64 = 1.0 / 0.75;

/// Samples per recorded value of a run.
fn samples_per_value(settings: &RunSettings) -> usize {
    let damping = settings.fixed_step.filter(|_| settings.method == Method::SemiImplicit);
    let is_enough =
        |samples: &usize| damping.is_some_and(|step| STEPS_PER_SAMPLE * step * RATE * *samples as f64 >= 1.0);
    [1, 2].into_iter().find(is_enough).unwrap_or(OVERSAMPLING)
}

/// Number of values of the first ball: azimuth, inner and outer load.
const FIRST_BALL_VALUES: usize = 3;

/// Observer of a run, which records the requested outputs.
pub struct Observer<'m> {
    model: &'m Model,
    /// Time of the first recorded value [s].
    start: f64,
    /// Samples per recorded value.
    oversampling: usize,
    /// Number of values to record.
    values: usize,
    /// Number of samples so far.
    samples: usize,
    /// Number of samples of the whole run.
    all_samples: usize,
    /// Samples before the first recorded value.
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
    /// Values at the ends of the last steps: `frame`, `pick`, azimuth and loads of the first ball.
    history: Course,
    between: Vec<f64>,
    loads: Option<BallLoadRecorder>,
    shaft: Moments,
    outer_ring: Moments,
    cage: Moments,
    spin: Moments,
    /// `None` where all balls are spheres.
    tracks: Option<BallTracks>,
    /// True if the slip of the cage is recorded.
    slips: bool,
    rolling: LoadedRolling,
    /// Loads of the balls, where a life is requested.
    load_means: Option<LoadMeans>,
    /// Powers, where the friction is requested.
    powers: Option<PowerObserver>,
    /// Scalar results of each part of `PART` recorded values.
    parts: Vec<Quantities>,
    /// Moments of the cage over the current part.
    part_cage: CageMoments,
    /// Balls in the load zone and over defects, on raceways that are no circles.
    sites: Option<SiteObserver<'m>>,
}

impl<'m> Observer<'m> {
    /// Observer that records what metrics and spectra of `settings` need.
    pub fn new(model: &'m Model, needs: &ActiveTerms, settings: &RunSettings) -> Self {
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
        let oversampling = samples_per_value(settings);
        let decimator = Decimator::new(oversampling, spindle.len());
        let delay = decimator.delay();
        // A run without settling time has no past for the filter, which then starts from a standstill.
        let lead = if settings.settle * RATE * oversampling as f64 >= delay as f64 { delay } else { 0 };
        let balls = layout.balls;
        Self {
            model,
            start: settings.settle,
            oversampling,
            values,
            samples: 0,
            all_samples: lead + (values - 1) * oversampling + delay + 1,
            lead,
            decimator,
            moments: vec![Moments::default(); spindle.len()],
            frame: vec![0.0; spindle.len()],
            pick: vec![0.0; channels.len()],
            history: Course::new(spindle.len() + channels.len() + FIRST_BALL_VALUES),
            between: vec![0.0; spindle.len() + channels.len() + FIRST_BALL_VALUES],
            filtered: Recorder::behind_filter(spindle.iter().copied(), &settings.outputs, values),
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
                angle: vec![PerRaceway::default(); balls],
                extremes: PerRaceway { inner: RunningExtremes::new(balls), outer: RunningExtremes::new(balls) },
                peaks: Peaks::default(),
                is_recording: false,
            },
            loads: (settings.outputs.contacts && settings.outputs.keep_signals())
                .then(|| BallLoadRecorder::new(values, model.mechanism().steady_orbit_speed())),
            shaft: Moments::default(),
            outer_ring: Moments::default(),
            cage: Moments::default(),
            spin: Moments::default(),
            slips: settings.outputs.cage,
            rolling: LoadedRolling::default(),
            load_means: settings.outputs.life.then(|| model.mechanism().load_means()),
            powers: settings.outputs.friction.then(|| PowerObserver::new(model)),
            parts: Vec::with_capacity(values.div_ceil(PART)),
            part_cage: CageMoments::default(),
            tracks: (!model.mechanism().uneven_balls.is_empty()).then(|| BallTracks::new(balls)),
            sites: model.mechanism().sites.as_ref().map(|sites| {
                let window = settings.outputs.keep_signals().then_some(settings.outputs.longest_window);
                SiteObserver::new(sites, balls, settings.outputs.contacts, window)
            }),
        }
    }

    /// The observer with a receiver of the requested series.
    pub(crate) fn with_series(mut self, series: Option<SeriesRecording>) -> Self {
        self.picked = self.picked.with_series(series.clone());
        self.filtered = self.filtered.with_series(series);
        self
    }

    fn sample_time(&self, sample: usize) -> f64 {
        (self.start + (sample as f64 - self.lead as f64) / (RATE * self.oversampling as f64)).max(0.0)
    }

    /// Time of the next sample [s]; `None` after the last.
    pub fn next_sample_time(&self) -> Option<f64> {
        (self.samples < self.all_samples).then(|| self.sample_time(self.samples))
    }

    /// Time of the last sample [s]: the filter's delay after the last recorded value.
    pub fn end(&self) -> f64 {
        self.sample_time(self.all_samples - 1)
    }

    /// Records the samples that lie within the last step.
    pub fn after(&mut self, step: &dyn Integrator) {
        let Some(loads_of_step) = step.sight() else {
            self.sample_within(step);
            return;
        };
        if self.history.end() != Some(step.previous_time()) {
            // The integrator started again, and its start states loads at its end alone.
            if let Some(end) = self.history.end() {
                self.keep_samples_until(end);
            }
            self.history.clear();
            self.sample_within(step);
        }
        self.record_step(step.time(), step.state(), &PackedStepLoads(loads_of_step));
        if let Some(known) = self.history.known() {
            self.keep_samples_until(known);
        }
    }

    /// Evaluates every sample within the last step.
    fn sample_within(&mut self, step: &dyn Integrator) {
        while let Some(time) = self.next_sample_time().filter(|time| *time <= step.time()) {
            step.interpolate(time, &mut self.state);
            self.sample(time);
        }
    }

    /// Evaluates and records one sample at the current state.
    fn sample(&mut self, time: f64) {
        self.begin(time);
        let mut watch = SnapshotWatch { model: self.model, snapshot: &mut self.snapshot };
        self.model.derivative_watched(time, &self.state, &mut self.derivative, &mut watch);
        let rate = self.model.mechanism().layout.spindle(&self.derivative);
        self.gather_spindle(rate.velocity);
        self.count(time);
        if self.is_at_recorded_value() {
            self.pick(time);
            self.picked.push(&self.pick);
            self.keep_loads(self.first_ball_loads(time));
        }
        self.keep_sample();
    }

    /// Records the end of a step from the loads that the integrator states.
    fn record_step(&mut self, time: f64, state: &[f64], loads_of_step: &PackedStepLoads<'_>) {
        self.state.copy_from_slice(state);
        self.begin(time);
        let m = self.model.mechanism();
        for ball in 0..m.layout.balls {
            let StepLoads { load, pocket, slip_square, angle, rolling_speed } = loads_of_step.of(ball);
            let inner = Contact { load: load.inner, slip_square: slip_square.inner, angle: angle.inner };
            let outer = Contact { load: load.outer, slip_square: slip_square.outer, angle: angle.outer };
            self.snapshot.record_contact(&m.raceway, (ball, BallContact::Inner), &inner, |_| rolling_speed.inner);
            self.snapshot.record_contact(&m.raceway, (ball, BallContact::Outer), &outer, |_| rolling_speed.outer);
            if m.layout.cage {
                self.snapshot.record_pocket(ball, pocket);
            }
        }
        self.gather_spindle(loads_of_step.acceleration());
        self.count(time);
        self.pick(time);
        let sample = self.frame.iter().chain(&self.pick).copied().chain(self.first_ball_loads(time));
        self.history.push(time, sample);
    }

    /// Interpolates the samples up to a time between the steps around them.
    fn keep_samples_until(&mut self, known: f64) {
        let smooth = self.frame.len();
        while let Some(time) = self.next_sample_time().filter(|time| *time <= known && self.history.end().is_some()) {
            self.history.at(time, smooth, &mut self.between);
            self.frame.copy_from_slice(&self.between[..smooth]);
            if self.is_at_recorded_value() {
                let (picked, first_ball) = self.between[smooth..].split_at(self.pick.len());
                self.picked.push(picked);
                let [azimuth, inner, outer] = [0, 1, 2].map(|i| first_ball[i]);
                self.keep_loads([azimuth, inner, outer]);
            }
            self.keep_sample();
        }
    }

    /// Prepares the snapshot and the parts for a time.
    fn begin(&mut self, time: f64) {
        // A quarter of a sample covers the rounding between step times and sample times.
        let off = 0.25 / (RATE * self.oversampling as f64);
        let start = self.start;
        let value = |place: usize| start + place as f64 / RATE;
        self.snapshot.is_recording = time > value(0) - off && time < value(self.values - 1) + off;
        while self.snapshot.is_recording && time > value(PART * (self.parts.len() + 1)) - off {
            self.end_part();
        }
    }

    /// Adds `frame` and `state` to the moments.
    fn count(&mut self, time: f64) {
        if !self.snapshot.is_recording {
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
        self.observe_sites(time);
        self.observe_tracks(time);
        if let Some(means) = &mut self.load_means {
            for (inner, outer) in self.snapshot.inner.iter().zip(&self.snapshot.outer) {
                means.add(PerRaceway { inner: *inner, outer: *outer });
            }
        }
        if let Some(powers) = &mut self.powers {
            powers.observe(self.model, time, &self.state);
        }
    }

    /// Latitudes of the contacts on balls that may leave their plane.
    fn observe_tracks(&mut self, time: f64) {
        let m = self.model.mechanism();
        let Some(tracks) = self.tracks.as_mut().filter(|_| !m.layout.planar) else { return };
        let ideal = Azimuth::new(m.rotations(time).turn);
        for (ball, uneven) in m.uneven_balls.iter().enumerate() {
            let [pole, ..] = m.layout.attitude(&self.state, ball).axes(&uneven.axes, ideal, false);
            let PerRaceway { inner, outer } = self.snapshot.angle[ball];
            let contacts = [(self.snapshot.inner[ball], inner), (self.snapshot.outer[ball], outer)];
            for (load, (sine, cosine)) in contacts {
                tracks.add_contact(ball, load, dot(pole, [sine, cosine, 0.0]));
            }
        }
    }

    fn observe_sites(&mut self, time: f64) {
        let (m, state, snapshot) = (self.model.mechanism(), &self.state, &self.snapshot);
        let Some(sites) = &mut self.sites else { return };
        let rotations = m.rotations(time);
        let rings = PerRaceway { inner: rotations.inner.angle, outer: rotations.outer.angle };
        sites.observe(time, rings, |ball| {
            let azimuth = m.azimuth(ball, &rotations, m.layout.ball(state, ball).arc);
            (azimuth, PerRaceway { inner: snapshot.inner[ball], outer: snapshot.outer[ball] })
        });
    }

    /// Returns whether the next sample is at the time of a recorded value.
    fn is_at_recorded_value(&self) -> bool {
        let place = self.samples.checked_sub(self.lead);
        place.is_some_and(|place| place <= (self.values - 1) * self.oversampling && place % self.oversampling == 0)
    }

    /// Passes `frame` on as the next sample.
    fn keep_sample(&mut self) {
        if self.lead == 0 && self.samples == 0 {
            self.decimator.prime(&self.frame);
        }
        if let Some(frame) = self.decimator.push(&self.frame) {
            self.filtered.push(frame);
        }
        self.samples += 1;
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

    /// Adds the speeds of rings, cage and balls to the moments, and returns the cage speed [rad/s].
    fn gather_speeds(&mut self, time: f64) -> f64 {
        let m = self.model.mechanism();
        let rotations = m.rotations(time);
        // A copy, so that the compiler knows that no store in the loop changes it.
        let layout = m.layout;
        let balls = layout.balls;
        let (mut orbit, mut spin) = (0.0, 0.0);
        for ball in 0..balls {
            let state = layout.ball(&self.state, ball);
            orbit += state.arc_velocity / balls as f64;
            // Spin in the orbit frame, about the axis that the contact angle tilts.
            let about_x = rotations.turn_speed + state.spin[0] - state.arc_velocity / m.pitch_radius;
            if self.slips {
                let loaded = LoadedBall {
                    orbit_radius: m.pitch_radius + state.radial,
                    ball_radius: m.ball_radius + m.oversize(ball),
                    angle: self.snapshot.angle[ball],
                };
                let load = PerRaceway { inner: self.snapshot.inner[ball], outer: self.snapshot.outer[ball] };
                self.part_cage.rolling.add(load, || loaded.orbit_ratio((about_x, state.spin[1])));
            }
            let own = length([about_x, state.spin[1], state.spin[2]]);
            if let Some(tracks) = &mut self.tracks {
                tracks.add_spin(ball, own);
            }
            spin += own / balls as f64;
        }
        // Without a cage the mean orbit speed of the balls replaces its speed.
        let arc_velocity = if m.layout.cage { m.layout.cage(&self.state).arc_velocity } else { orbit };
        for (whole, part, ring) in [
            (&mut self.shaft, &mut self.part_cage.shaft, rotations.inner),
            (&mut self.outer_ring, &mut self.part_cage.outer_ring, rotations.outer),
        ] {
            whole.add(ring.speed);
            part.add(ring.speed);
        }
        let cage_speed = m.orbit_speed(&rotations, arc_velocity);
        self.cage.add(cage_speed);
        self.spin.add(spin);
        cage_speed
    }

    fn pick(&mut self, time: f64) {
        let m = self.model.mechanism();
        let rotations = m.rotations(time);
        let (cage, spindle) = (m.layout.cage(&self.state), m.layout.spindle(&self.state));
        for (value, channel) in self.pick.iter_mut().zip(&self.channels) {
            *value = match *channel {
                Channel::CageDisplacement(axis) => cage.centre[axis as usize],
                Channel::CageSpeed => m.orbit_speed(&rotations, cage.arc_velocity),
                Channel::BallSpin(ball) => {
                    let state = m.layout.ball(&self.state, ball);
                    let orbit = m.orbit_speed(&rotations, state.arc_velocity);
                    rotations.spin.speed + state.spin[0] - orbit
                }
                Channel::BallLoad(ball, BallContact::Inner) => self.snapshot.inner[ball],
                Channel::BallLoad(ball, BallContact::Outer) => self.snapshot.outer[ball],
                Channel::BallLoad(ball, BallContact::Pocket) => self.snapshot.pocket[ball],
                Channel::SpindleTilt(axis) => spindle.tilt[usize::from(axis == Axis::Z)],
                Channel::Spindle(..) => 0.0,
            };
        }
    }

    fn end_part(&mut self) {
        let (peaks, cage) = (std::mem::take(&mut self.snapshot.peaks), std::mem::take(&mut self.part_cage));
        self.rolling.join(cage.rolling);
        let rings = RingSpeeds { inner: cage.shaft.mean(), outer: cage.outer_ring.mean() };
        let speeds = BodySpeeds::new(rings, cage.speed.mean(), 0.0);
        self.parts.push(Quantities {
            max_load: peaks.load,
            cage_speed: speeds.cage,
            out_of_plane: peaks.out_of_plane,
            max_pocket_load: peaks.pocket_load,
            max_slip: peaks.slip_square.map(|square| square.sqrt()),
            orbit_radius: (cage.y.variance() + cage.z.variance()).sqrt(),
            cage_slip: cage.rolling.mean().and_then(|orbit_ratio| speeds.cage_slip(orbit_ratio)),
        });
    }

    /// Azimuth [rad], inner and outer load [N] of the first ball.
    fn first_ball_loads(&self, time: f64) -> [f64; FIRST_BALL_VALUES] {
        let (m, snapshot) = (self.model.mechanism(), &self.snapshot);
        let azimuth = m.azimuth(0, &m.rotations(time), m.layout.ball(&self.state, 0).arc);
        [azimuth, snapshot.inner[0], snapshot.outer[0]]
    }

    fn keep_loads(&mut self, [azimuth, inner, outer]: [f64; FIRST_BALL_VALUES]) {
        if let Some(loads) = &mut self.loads {
            loads.offer(|| (azimuth, inner, outer));
        }
    }

    /// rms of the spindle's accelerations in y and z so far [m/s²], at all frequencies; `None` before the first recorded value.
    pub fn accelerations(&self) -> Option<[f64; 2]> {
        self.filtered.accelerations()
    }

    /// The recording.
    pub fn finish(mut self) -> Recording {
        self.keep_samples_until(f64::INFINITY);
        self.end_part();
        let total_variance = self.spindle.iter().zip(&self.moments).map(|(c, m)| (*c, m.variance())).collect();
        let series = self.filtered.series();
        let (spindle, spindle_whirl) = self.filtered.finish();
        let (picked, whirl) = self.picked.finish();
        let largest = |of: fn(&Quantities) -> f64| self.parts.iter().map(of).fold(0.0, f64::max);
        let off = self.sites.as_ref().and_then(SiteObserver::off_shares);
        let rings = RingSpeeds { inner: self.shaft.mean(), outer: self.outer_ring.mean() };
        Recording {
            start: self.start,
            signals: spindle.into_iter().chain(picked).collect(),
            series,
            whirl,
            spindle_whirl,
            total_variance,
            contacts: PerRaceway {
                inner: self
                    .snapshot
                    .extremes
                    .inner
                    .extremes(largest(|part| part.max_slip.inner), off.map(|off| off.inner)),
                outer: self
                    .snapshot
                    .extremes
                    .outer
                    .extremes(largest(|part| part.max_slip.outer), off.map(|off| off.outer)),
            },
            max_pocket_load: largest(|part| part.max_pocket_load),
            direction: direction(rings, self.model.mechanism()),
            speeds: BodySpeeds::new(rings, self.cage.mean(), self.spin.mean()),
            loaded_orbit_ratio: self.rolling.mean(),
            load_means: self.load_means.map(|means| means.means()),
            powers: self.powers.and_then(|powers| powers.into_recorder().finish()),
            tracks: self.tracks.map(BallTracks::finish).unwrap_or_default(),
            parts: self.parts,
            loads: self.loads.map(BallLoadRecorder::finish),
            passages: self.sites.map(SiteObserver::into_passages).unwrap_or_default(),
            largest_pocket_offset: None,
        }
    }
}
