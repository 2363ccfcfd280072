//! The record of a run: every signal at the sampling rate, and the extremes of each bearing.

use super::channel::MachineChannel;
use super::equations::MachineDynamics;
use super::input::{Machine, MachineBearing, Sensor};
use super::resolution::Resolution;
use super::stepping::MachineStepper;
use crate::numerics::decimation::Decimator;
use crate::numerics::interpolation::Course;
use crate::numerics::lanes::{InstructionSet, Task};
use crate::physics::frames::length;
use crate::simulation::input::channel::{Axis, Motion};
use crate::simulation::recording::sampling::{RATE, kept_values};

/// Steps per sample from which samples resolve all motion that the steps leave.
const STEPS_PER_SAMPLE: f64 = 1.0 / 0.75;
/// Most samples per recorded value [-], which resolve fast motion.
const OVERSAMPLING: usize = 4;

/// The signals of a run [SI], and what each bearing did.
#[derive(Debug, Clone)]
pub struct MachineRecording {
    /// Time of the first value [s]; the others follow at the sampling rate.
    pub start: f64,
    pub signals: Vec<(MachineChannel, Vec<f64>)>,
    pub bearings: Vec<BearingRecord>,
    /// True if steps resolved the forces at the rings.
    pub is_resolved: bool,
}

/// Extremes and means of a bearing over the recorded time [SI].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BearingRecord {
    /// Largest load of a ball on the inner and on the outer raceway, and of a pocket [N].
    pub inner_load: f64,
    pub outer_load: f64,
    pub pocket_load: f64,
    /// Largest slip of a loaded contact [m/s].
    pub slip: f64,
    /// Mean speed of the cage, and mean spin of a ball in the orbit frame [rad/s].
    pub cage_speed: f64,
    pub ball_spin: f64,
    /// Mean spin of the balls that make lines, in the orbit frame [rad/s]; 0 where none does.
    pub heard_spin: f64,
    /// Steps that the means count.
    steps: f64,
}

/// Recorder of a run.
pub(crate) struct Recorder<'m> {
    dynamics: &'m MachineDynamics,
    channels: Vec<MachineChannel>,
    sensors: Vec<Sensor>,
    start: f64,
    values: usize,
    /// Samples per value, samples before the first value, and samples so far.
    oversampling: usize,
    lead: usize,
    samples: usize,
    decimator: Decimator,
    course: Course,
    places: Places,
    frame: Vec<f64>,
    signals: Vec<Vec<f64>>,
    bearings: Vec<BearingRecord>,
    /// Share of each ball in the mean spin of those that make lines, for each bearing.
    heard: Vec<Vec<f64>>,
    instructions: InstructionSet,
}

impl<'m> Recorder<'m> {
    /// Recorder of `duration` after `start` [s] in steps of a length: of all signals, and of those of single balls in `series`.
    pub(crate) fn new(
        (machine, dynamics): (&Machine, &'m MachineDynamics),
        series: &[MachineChannel],
        start: f64,
        duration: f64,
        step: f64,
    ) -> Self {
        let mut channels = MachineChannel::all(machine);
        channels.extend(series.iter().filter(|channel| channel.is_of_ball()));
        let is_enough = |samples: &usize| STEPS_PER_SAMPLE * step * RATE * *samples as f64 >= 1.0;
        let oversampling = [1, 2].into_iter().find(is_enough).unwrap_or(OVERSAMPLING);
        let decimator = Decimator::new(oversampling, channels.len());
        let lead = if start * RATE * oversampling as f64 >= decimator.delay() as f64 { decimator.delay() } else { 0 };
        let values = kept_values(duration);
        let shares = |bearing: &MachineBearing| {
            let heard = bearing.scene.surfaces.heard_balls();
            let count = heard.iter().filter(|is_heard| **is_heard).count() as f64;
            heard.into_iter().map(|is_heard| if is_heard { 1.0 / count } else { 0.0 }).collect()
        };
        Self {
            heard: machine.bearings.iter().map(shares).collect(),
            sensors: machine.sensors.clone(),
            course: Course::new(channels.len()),
            places: Places {
                rings: vec![Moved::default(); dynamics.bearings.len()],
                sensors: vec![Moved::default(); dynamics.frame.sensors.len()],
                bodies: vec![Moved::default(); dynamics.frame.bodies.len()],
            },
            frame: vec![0.0; channels.len()],
            signals: channels.iter().map(|_| Vec::with_capacity(values)).collect(),
            bearings: vec![BearingRecord::default(); dynamics.bearings.len()],
            dynamics,
            channels,
            start,
            values,
            oversampling,
            lead,
            samples: 0,
            instructions: InstructionSet::best(),
            decimator,
        }
    }

    /// Time of the last sample [s].
    pub(crate) fn end(&self) -> f64 {
        // Four steps follow a sample before it is known.
        self.time_of(self.lead + (self.values - 1) * self.oversampling + self.decimator.delay())
    }

    fn time_of(&self, sample: usize) -> f64 {
        (self.start + (sample as f64 - self.lead as f64) / (RATE * self.oversampling as f64)).max(0.0)
    }

    /// True once every value is recorded.
    pub(crate) fn is_full(&self) -> bool {
        self.signals[0].len() >= self.values
    }

    /// Records the end of a step.
    pub(crate) fn after(&mut self, stepper: &MachineStepper<'_>) {
        // Samples begin a few steps ahead, so that the first has neighbours.
        let before = 16.0 * (stepper.time() - self.course.end().unwrap_or(stepper.time()));
        if stepper.time() + before.max(1e-4) < self.time_of(0) {
            return;
        }
        self.gather(stepper);
        let frame = &self.frame;
        self.course.push(stepper.time(), frame.iter().copied());
        let Some(known) = self.course.known() else { return };
        while self.time_of(self.samples) <= known && !self.is_full() {
            self.course.at(self.time_of(self.samples), self.frame.len(), &mut self.frame);
            self.keep();
        }
        if (self.start..self.end()).contains(&stepper.time()) {
            self.count(stepper);
        }
    }

    /// Passes the frame on as the next sample.
    fn keep(&mut self) {
        if self.lead == 0 && self.samples == 0 {
            self.decimator.prime(&self.frame);
        }
        if let Some(frame) = self.decimator.push(&self.frame) {
            for (signal, value) in self.signals.iter_mut().zip(frame) {
                signal.push(*value);
            }
        }
        self.samples += 1;
    }

    fn gather(&mut self, stepper: &MachineStepper<'_>) {
        self.instructions.run(Gather { recorder: self, stepper });
    }

    #[inline(always)]
    fn gather_by(&mut self, stepper: &MachineStepper<'_>) {
        let (place, velocity) = stepper.coordinates();
        let (inputs, speed) = (stepper.inputs(), self.dynamics.speed.at(stepper.time()).1);
        let frame = &self.dynamics.frame;
        let Places { rings, sensors, bodies } = &mut self.places;
        let of = &frame.accelerations;
        for (places, rows, accelerations) in [
            (&mut *rings, &frame.ports, &of.ports),
            (&mut *sensors, &frame.sensors, &of.sensors),
            (&mut *bodies, &frame.bodies, &of.bodies),
        ] {
            for ((moved, rows), acceleration) in places.iter_mut().zip(rows).zip(accelerations) {
                moved.displacement = rows.of_place(place);
                moved.velocity = rows.of_place(velocity);
                moved.acceleration = acceleration.at(speed, (place, velocity), inputs);
            }
        }
        let tilt = |axis: Axis| if axis == Axis::Y { 3 } else { 4 };
        let time = stepper.time();
        for (value, channel) in self.frame.iter_mut().zip(&self.channels) {
            *value = match *channel {
                MachineChannel::Ring(bearing, axis, motion) => rings[bearing].of(motion)[axis as usize],
                MachineChannel::Tilt(bearing, axis) => rings[bearing].displacement[tilt(axis)],
                MachineChannel::Force(bearing, axis) => -stepper.wrench(bearing)[axis as usize],
                MachineChannel::Moment(bearing, axis) => -stepper.wrench(bearing)[tilt(axis)],
                MachineChannel::CageSpeed(bearing) => stepper.bearings()[bearing].cage_speed(time),
                MachineChannel::BallLoad(bearing, ball, contact) => {
                    stepper.bearings()[bearing].seen(ball).load_at(contact)
                }
                MachineChannel::BallSpin(bearing) => stepper.bearings()[bearing].spin(0, time)[0],
                MachineChannel::Sensor(sensor, motion) => self.sensors[sensor].reading(*sensors[sensor].of(motion)),
                MachineChannel::Body(body, axis, motion) => bodies[body].of(motion)[axis as usize],
            };
        }
    }

    fn count(&mut self, stepper: &MachineStepper<'_>) {
        let time = stepper.time();
        for (index, (record, of)) in self.bearings.iter_mut().zip(stepper.bearings()).enumerate() {
            let m = self.dynamics.bearings[index].dynamics.mechanism();
            let heard = &self.heard[index];
            let (mut spin_sum, mut heard_sum) = (0.0, 0.0);
            for ball in 0..m.layout.balls {
                let now = of.seen(ball);
                record.inner_load = record.inner_load.max(now.load.inner);
                record.outer_load = record.outer_load.max(now.load.outer);
                record.pocket_load = record.pocket_load.max(now.pocket);
                for (load, slip) in [(now.load.inner, now.slip.inner), (now.load.outer, now.slip.outer)] {
                    if load > 0.0 {
                        record.slip = record.slip.max(slip);
                    }
                }
                let spin = length(of.spin(ball, time));
                spin_sum += spin / m.layout.balls as f64;
                heard_sum += heard.get(ball).map_or(0.0, |weight| weight * spin);
            }
            record.steps += 1.0;
            record.cage_speed += (of.cage_speed(time) - record.cage_speed) / record.steps;
            record.ball_spin += (spin_sum - record.ball_spin) / record.steps;
            record.heard_spin += (heard_sum - record.heard_spin) / record.steps;
        }
    }

    /// The record.
    pub(crate) fn finish(self, resolution: &Resolution) -> MachineRecording {
        let signals = self.channels.into_iter().zip(self.signals).collect();
        MachineRecording { start: self.start, signals, bearings: self.bearings, is_resolved: resolution.is_resolved() }
    }
}

impl MachineRecording {
    /// The values of a signal [SI]; none of a signal that was not recorded.
    pub fn of(&self, channel: MachineChannel) -> &[f64] {
        self.signals.iter().find(|(of, _)| *of == channel).map_or(&[], |(_, values)| values)
    }
}

/// The frame of one step, compiled for each instruction set.
struct Gather<'a, 'm, 's> {
    recorder: &'a mut Recorder<'m>,
    stepper: &'a MachineStepper<'s>,
}

impl Task for Gather<'_, '_, '_> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        self.recorder.gather_by(self.stepper);
    }
}

/// Motion of the places of the signals, in the order of their rows.
struct Places {
    rings: Vec<Moved>,
    sensors: Vec<Moved>,
    bodies: Vec<Moved>,
}

/// Motion of a place of the shaft.
#[derive(Clone, Default)]
struct Moved {
    displacement: [f64; 5],
    velocity: [f64; 5],
    acceleration: [f64; 5],
}

impl Moved {
    fn of(&self, motion: Motion) -> &[f64; 5] {
        match motion {
            Motion::Displacement => &self.displacement,
            Motion::Velocity => &self.velocity,
            Motion::Acceleration => &self.acceleration,
        }
    }
}
