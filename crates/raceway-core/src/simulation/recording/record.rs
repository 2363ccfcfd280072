//! The recording of a run, in SI units.

use crate::numerics::parallel::both;
use crate::physics::bearing::PerRaceway;
use crate::physics::kinematics::BodySpeeds;
use crate::simulation::input::channel::{Axis, Channel, Motion};
use crate::simulation::input::settings::Outputs;
use crate::simulation::recording::ball_tracks::BallTrack;
use crate::simulation::recording::defect_passages::Passage;
use crate::simulation::recording::load_course::BallLoadCourse;
use crate::simulation::recording::off_raceway::OffShare;
use crate::simulation::recording::power_balance::PowerBalance;
use crate::simulation::recording::series::SeriesRecording;
use crate::simulation::recording::windows::{Signal, Whirl};

/// Extremes of the contacts of all balls on one raceway [SI].
#[derive(Debug, Clone, PartialEq)]
pub struct ContactExtremes {
    /// Largest load of each ball [N].
    pub max_load: Vec<f64>,
    /// Range of contact angles under load [rad].
    pub angle: Option<(f64, f64)>,
    /// Largest slip speed under load [m/s].
    pub max_slip: f64,
    /// Smallest minimum film thickness under load [m]; `None` where it was not requested.
    pub least_film: Option<f64>,
    /// Share of the time that loaded balls do not touch the raceway; `None` on ideal raceways, and where it was not observed.
    pub off: Option<OffShare>,
}

/// Scalar results of a motion, for the comparison with a repeated run [SI].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Quantities {
    /// Largest load of any raceway contact [N].
    pub max_load: f64,
    /// Magnitude of the mean cage speed [rad/s].
    pub cage_speed: f64,
    /// Sine of the largest contact angle under load, magnitude [-].
    pub out_of_plane: f64,
    /// Largest load of any pocket [N].
    pub max_pocket_load: f64,
    /// Largest slip at a contact's centre under load [m/s].
    pub max_slip: PerRaceway<f64>,
    /// Rms distance of the cage's centre from its mean position [m].
    pub orbit_radius: f64,
    /// 1 − cage speed / speed of rolling at the loaded contact angles [-]; `None` where too few balls carry load, and where it was not
    /// requested.
    pub cage_slip: Option<f64>,
}

/// The recording of a run [SI].
#[derive(Debug, Clone)]
pub struct Recording {
    /// Time of the first recorded value [s]; the others follow at `RATE`.
    pub start: f64,
    pub signals: Vec<Signal>,
    /// The requested series, which their receiver has.
    pub(crate) series: Option<SeriesRecording>,
    /// Whirl of the cage's centre, where the run has several windows.
    pub whirl: Option<Whirl>,
    /// Whirl of the spindle's centre, likewise.
    pub spindle_whirl: Option<Whirl>,
    /// Variance of each spindle signal before the low-pass filter, where it passed one.
    pub total_variance: Vec<(Channel, f64)>,
    pub contacts: PerRaceway<ContactExtremes>,
    /// Largest load of any pocket [N].
    pub max_pocket_load: f64,
    /// Sign of the mean speed of ideally rolling balls round the bearing axis.
    pub direction: f64,
    /// Mean speeds over the recorded time [rad/s]. That of a ball is its spin about its own axis in the orbit frame.
    pub speeds: BodySpeeds,
    /// Orbit speed of balls that roll at their loaded contact angles over the shaft speed, both relative to the outer ring, mean of the balls
    /// with load [-]; `None` where too few balls carry load, and where it was not requested.
    pub loaded_orbit_ratio: Option<f64>,
    /// Power means of the loads of the balls on both raceways [N]; `None` where they were not requested.
    pub load_means: Option<PerRaceway<f64>>,
    /// Mean powers; `None` where they were not requested.
    pub powers: Option<PowerBalance>,
    /// How each ball rolls, where one is no sphere and the model knows; else empty.
    pub tracks: Vec<BallTrack>,
    /// Scalar results of consecutive parts of the recorded time.
    pub parts: Vec<Quantities>,
    /// Loads of the first ball over its azimuth, where contacts are requested.
    pub loads: Option<BallLoadCourse>,
    /// Passages of balls over defects in the first window, in the order of their ends.
    pub passages: Vec<Passage>,
    /// Largest distance of a ball from the middle of its pocket, along the orbit [m]; `None` where it was not observed.
    pub largest_pocket_offset: Option<f64>,
}

impl Recording {
    /// The recorded signal of a channel.
    pub fn of(&self, channel: Channel) -> Option<&Signal> {
        self.signals.iter().find(|signal| signal.channel == channel)
    }

    /// Computes levels and spectra of the spindle's signals on two cores, which takes as long as a short run. Runs that keep no signals
    /// belong to a study and run in parallel already. They compute on request.
    pub(crate) fn evaluate(&self, outputs: &Outputs) {
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

    /// Every recorded value of a channel [SI], in a run of one window.
    pub fn signal(&self, channel: Channel) -> Option<&[f64]> {
        self.of(channel)?.values()
    }

    /// Whirl of the cage's centre; `None` where it was not observed.
    pub fn whirl(&self) -> Option<Whirl> {
        self.whirl.or_else(|| self.whirl_of(Channel::CageDisplacement))
    }

    /// Whirl of the spindle's centre; `None` where it was not observed.
    pub fn spindle_whirl(&self) -> Option<Whirl> {
        self.spindle_whirl.or_else(|| self.whirl_of(|axis| Channel::Spindle(axis, Motion::Displacement)))
    }

    fn whirl_of(&self, place: fn(Axis) -> Channel) -> Option<Whirl> {
        Some(Whirl::of(self.signal(place(Axis::Y))?, self.signal(place(Axis::Z))?))
    }

    /// Rms distance of the cage's centre from its mean position [m]; `None` where it was not observed.
    pub fn orbit_radius(&self) -> Option<f64> {
        let rms = |axis| Some(self.of(Channel::CageDisplacement(axis))?.all().rms());
        Some(rms(Axis::Y)?.hypot(rms(Axis::Z)?))
    }

    /// Variance of a signal before any filter.
    pub(crate) fn total_variance(&self, channel: Channel) -> f64 {
        let before = self.total_variance.iter().find(|(of, _)| *of == channel);
        let unfiltered = || self.of(channel).map_or(0.0, |signal| signal.all().rms().powi(2));
        before.map_or_else(unfiltered, |(_, variance)| *variance)
    }

    /// Slip of the cage against rolling at the loaded contact angles [-]; `None` at rest, where too few balls carry load, and where it was not
    /// requested.
    pub fn cage_slip(&self) -> Option<f64> {
        self.speeds.cage_slip(self.loaded_orbit_ratio?)
    }

    /// Scalar results over the whole recorded time.
    pub fn quantities(&self) -> Quantities {
        let loads = self.contacts.inner.max_load.iter().chain(&self.contacts.outer.max_load);
        Quantities {
            max_load: loads.copied().fold(0.0, f64::max),
            cage_speed: self.speeds.cage,
            out_of_plane: self.parts.iter().fold(0.0, |most, part| f64::max(most, part.out_of_plane)),
            max_pocket_load: self.max_pocket_load,
            max_slip: self.contacts.map(|contact| contact.max_slip),
            orbit_radius: self.orbit_radius().unwrap_or_default(),
            cage_slip: self.cage_slip(),
        }
    }
}
