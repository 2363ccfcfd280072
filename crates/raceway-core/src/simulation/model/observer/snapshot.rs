//! Loads as they are seen, and the extremes of what was met.

use crate::physics::bearing::PerRaceway;
use crate::physics::contact::film::ThinnestFilm;
use crate::physics::pocket::PocketLoad;
use crate::physics::raceway::{RacewayContact, RacewayLoad, RelativeMotion};
use crate::simulation::input::channel::BallContact;
use crate::simulation::model::{Model, Watch};
use crate::simulation::recording::record::ContactExtremes;

/// Loads of one look.
pub(super) struct Snapshot {
    pub film: bool,
    pub inner: Vec<f64>,
    pub outer: Vec<f64>,
    pub pocket: Vec<f64>,
    /// What was met so far; it grows only while `counts` is set.
    pub met: PerRaceway<Met>,
    /// The same since the last part ended.
    pub peaks: Peaks,
    pub counts: bool,
}

/// Largest values over a part of a run.
#[derive(Clone, Copy, Default)]
pub(super) struct Peaks {
    /// Of any raceway contact [N].
    pub load: f64,
    /// Of any pocket [N].
    pub pocket_load: f64,
    /// Sine of the contact angle, either way.
    pub out_of_plane: f64,
    /// Square of the slip [m²/s²].
    pub slip_square: PerRaceway<f64>,
}

/// Extremes of one kind of contact on the way, in the form that costs least to compare.
#[derive(Clone)]
pub(super) struct Met {
    max_load: Vec<f64>,
    /// Sine and cosine of the least and the largest contact angle, between ±90°: the sine grows with the angle.
    angles: Option<[(f64, f64); 2]>,
    film: ThinnestFilm,
}

impl Met {
    pub fn new(balls: usize) -> Self {
        Self { max_load: vec![0.0; balls], angles: None, film: ThinnestFilm::NONE }
    }

    pub fn extremes(self, max_slip: f64) -> ContactExtremes {
        ContactExtremes {
            max_load: self.max_load,
            angle: self.angles.map(|[least, most]| (least.0.atan2(least.1), most.0.atan2(most.1))),
            max_slip,
            least_film: Some(self.film.thickness).filter(|film| film.is_finite()),
        }
    }
}

/// What is seen of one raceway contact.
pub(super) struct Contact {
    /// [N]
    pub load: f64,
    /// [m²/s²]
    pub slip_square: f64,
    /// Sine and cosine of its angle.
    pub angle: (f64, f64),
}

impl Snapshot {
    /// Meets a raceway contact; `rolling_speed` [m/s] is asked for where films are looked at.
    #[inline(always)]
    pub fn meet(
        &mut self,
        raceway: &PerRaceway<RacewayContact>,
        (ball, side): (usize, BallContact),
        &Contact { load, slip_square, angle }: &Contact,
        rolling_speed: impl FnOnce(&RacewayContact) -> f64,
    ) {
        let (met, peaks) = (&mut self.met, &mut self.peaks);
        let (loads, met, largest_slip, contact) = match side {
            BallContact::Inner => (&mut self.inner, &mut met.inner, &mut peaks.slip_square.inner, &raceway.inner),
            _ => (&mut self.outer, &mut met.outer, &mut peaks.slip_square.outer, &raceway.outer),
        };
        loads[ball] = load;
        if !self.counts || load <= 0.0 {
            return;
        }
        met.max_load[ball] = met.max_load[ball].max(load);
        *largest_slip = largest_slip.max(slip_square);
        peaks.load = peaks.load.max(load);
        peaks.out_of_plane = peaks.out_of_plane.max(angle.0.abs());
        let [least, most] = met.angles.get_or_insert([angle; 2]);
        if angle.0 < least.0 {
            *least = angle;
        }
        if angle.0 > most.0 {
            *most = angle;
        }
        if self.film {
            contact.meet_film(rolling_speed(contact), load, &mut met.film);
        }
    }

    /// Meets the load of a pocket [N].
    pub fn meet_pocket(&mut self, ball: usize, load: f64) {
        self.pocket[ball] = load;
        if self.counts {
            self.peaks.pocket_load = self.peaks.pocket_load.max(load);
        }
    }
}

/// The watch of one look, with the model it looks at.
pub(super) struct Look<'a> {
    pub model: &'a Model,
    pub snapshot: &'a mut Snapshot,
}

impl Watch for Look<'_> {
    fn raceway(&mut self, ball: usize, side: BallContact, motion: &RelativeMotion, load: &RacewayLoad) {
        let slip_square = load.slip.0 * load.slip.0 + load.slip.1 * load.slip.1;
        let seen = Contact { load: load.normal, slip_square, angle: load.angle };
        let rolling_speed = |contact: &RacewayContact| contact.rolling_speed(motion);
        self.snapshot.meet(&self.model.mechanism().raceway, (ball, side), &seen, rolling_speed);
    }

    fn pocket(&mut self, ball: usize, load: &PocketLoad) {
        self.snapshot.meet_pocket(ball, load.normal);
    }
}
