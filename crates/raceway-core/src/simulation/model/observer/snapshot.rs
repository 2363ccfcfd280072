//! Loads of one sample, and the extremes of all samples so far.

use crate::physics::bearing::PerRaceway;
use crate::physics::contact::film::ThinnestFilm;
use crate::physics::pocket::PocketLoad;
use crate::physics::raceway::{RacewayContact, RacewayLoad, RelativeMotion};
use crate::simulation::input::channel::BallContact;
use crate::simulation::model::dynamics::Watch;
use crate::simulation::model::system::Model;
use crate::simulation::recording::off_raceway::OffShare;
use crate::simulation::recording::record::ContactExtremes;

/// Loads of one sample and extremes of the run.
pub(super) struct Snapshot {
    /// True if minimum film thickness is recorded.
    pub film: bool,
    pub inner: Vec<f64>,
    pub outer: Vec<f64>,
    pub pocket: Vec<f64>,
    /// Sine and cosine of the contact angles of each ball.
    pub angle: Vec<PerRaceway<(f64, f64)>>,
    /// Extremes of the recorded time so far, updated only while `is_recording` is set.
    pub extremes: PerRaceway<RunningExtremes>,
    /// Peaks of the current part of the recorded time.
    pub peaks: Peaks,
    pub is_recording: bool,
}

/// Largest values over a part of a run.
#[derive(Clone, Copy, Default)]
pub(super) struct Peaks {
    /// Largest load of any raceway contact [N].
    pub load: f64,
    /// Largest load of any pocket [N].
    pub pocket_load: f64,
    /// Sine of the largest contact angle, magnitude [-].
    pub out_of_plane: f64,
    /// Square of the largest slip [m²/s²].
    pub slip_square: PerRaceway<f64>,
}

/// Extremes of the contacts on one raceway so far, in the form that is cheapest to compare.
#[derive(Clone)]
pub(super) struct RunningExtremes {
    max_load: Vec<f64>,
    /// Sine and cosine of the least and the largest contact angle, between ±90°: the sine grows with the angle.
    angles: Option<[(f64, f64); 2]>,
    film: ThinnestFilm,
}

impl RunningExtremes {
    pub(super) fn new(balls: usize) -> Self {
        Self { max_load: vec![0.0; balls], angles: None, film: ThinnestFilm::NONE }
    }

    pub(super) fn extremes(self, max_slip: f64, off: Option<OffShare>) -> ContactExtremes {
        ContactExtremes {
            max_load: self.max_load,
            angle: self.angles.map(|[least, most]| (least.0.atan2(least.1), most.0.atan2(most.1))),
            max_slip,
            least_film: Some(self.film.thickness).filter(|film| film.is_finite()),
            off,
        }
    }
}

/// Load, slip and angle of one raceway contact.
pub(super) struct Contact {
    /// Normal load [N].
    pub load: f64,
    /// Square of the slip at the centre [m²/s²].
    pub slip_square: f64,
    /// Sine and cosine of its angle.
    pub angle: (f64, f64),
}

impl Snapshot {
    /// Records a raceway contact; `rolling_speed` [m/s] is evaluated only where film thickness is recorded.
    #[inline(always)]
    pub(crate) fn record_contact(
        &mut self,
        raceway: &PerRaceway<RacewayContact>,
        (ball, side): (usize, BallContact),
        &Contact { load, slip_square, angle }: &Contact,
        rolling_speed: impl FnOnce(&RacewayContact) -> f64,
    ) {
        let (extremes, peaks) = (&mut self.extremes, &mut self.peaks);
        let (loads, angle_of, extremes, largest_slip, contact) = match side {
            BallContact::Inner => (
                &mut self.inner,
                &mut self.angle[ball].inner,
                &mut extremes.inner,
                &mut peaks.slip_square.inner,
                &raceway.inner,
            ),
            _ => (
                &mut self.outer,
                &mut self.angle[ball].outer,
                &mut extremes.outer,
                &mut peaks.slip_square.outer,
                &raceway.outer,
            ),
        };
        loads[ball] = load;
        *angle_of = angle;
        if !self.is_recording || load <= 0.0 {
            return;
        }
        extremes.max_load[ball] = extremes.max_load[ball].max(load);
        *largest_slip = largest_slip.max(slip_square);
        peaks.load = peaks.load.max(load);
        peaks.out_of_plane = peaks.out_of_plane.max(angle.0.abs());
        let [least, most] = extremes.angles.get_or_insert([angle; 2]);
        if angle.0 < least.0 {
            *least = angle;
        }
        if angle.0 > most.0 {
            *most = angle;
        }
        if self.film {
            contact.meet_film(rolling_speed(contact), load, &mut extremes.film);
        }
    }

    /// Records the load of a pocket [N].
    pub(crate) fn record_pocket(&mut self, ball: usize, load: f64) {
        self.pocket[ball] = load;
        if self.is_recording {
            self.peaks.pocket_load = self.peaks.pocket_load.max(load);
        }
    }
}

/// Receiver of the loads of one sample, with the observed model.
pub(super) struct SnapshotWatch<'a> {
    pub model: &'a Model,
    pub snapshot: &'a mut Snapshot,
}

impl Watch for SnapshotWatch<'_> {
    fn raceway(&mut self, ball: usize, side: BallContact, motion: &RelativeMotion, load: &RacewayLoad) {
        let slip_square = load.slip.0 * load.slip.0 + load.slip.1 * load.slip.1;
        let seen = Contact { load: load.normal, slip_square, angle: load.angle };
        let rolling_speed = |contact: &RacewayContact| contact.rolling_speed(motion);
        self.snapshot.record_contact(&self.model.mechanism().raceway, (ball, side), &seen, rolling_speed);
    }

    fn pocket(&mut self, ball: usize, load: &PocketLoad) {
        self.snapshot.record_pocket(ball, load.normal);
    }
}
