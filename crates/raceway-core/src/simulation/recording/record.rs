//! What a run has shown, in SI units.

use crate::numerics::parallel::both;
use crate::physics::bearing::PerRaceway;
use crate::simulation::input::channel::{Axis, Channel};
use crate::simulation::input::settings::Outputs;
use crate::simulation::recording::load_course::LoadsAlong;
use crate::simulation::recording::windows::{Signal, Whirl};

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
