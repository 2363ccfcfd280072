//! Waviness of raceways: waves of whole orders, given or drawn, and what the contact averages of them.

use std::f64::consts::{PI, TAU};

use super::ball::{self, BallSurface, EveryBall, GivenBall};
use super::defects::{Defect, MOST_DEFECTS};
use super::wave::{MOST_WAVES, WaveNames};
pub use super::wave::{RandomWaviness, Wave};
use crate::numerics::angle::sin_cos;
use crate::physics::bearing::{Bearing, PerRaceway};
use crate::physics::limits::Faults;

/// Surface of one raceway.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RacewaySurface {
    pub waviness: Vec<Wave>,
    /// Adds to `waviness`.
    pub random_waviness: Option<RandomWaviness>,
    /// Waves of the groove's place along +X.
    pub axial_waviness: Vec<Wave>,
    pub defects: Vec<Defect>,
}

/// Surfaces as given, unchecked.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceParameters {
    pub raceway: PerRaceway<RacewaySurface>,
    /// Balls with a surface of their own.
    pub balls: Vec<GivenBall>,
    pub every_ball: EveryBall,
    /// Seed of all drawn numbers.
    pub seed: u64,
}

impl Default for SurfaceParameters {
    fn default() -> Self {
        let Surfaces { raceway, seed, .. } = Surfaces::default();
        Self { raceway, balls: Vec::new(), every_ball: EveryBall::default(), seed }
    }
}

/// Surfaces of both raceways and of the balls.
#[derive(Debug, Clone, PartialEq)]
pub struct Surfaces {
    pub raceway: PerRaceway<RacewaySurface>,
    /// Surface of each ball; empty where all are ideal.
    pub balls: Vec<BallSurface>,
    /// Seed of all drawn numbers.
    pub seed: u64,
}

impl Default for Surfaces {
    fn default() -> Self {
        let raceway = PerRaceway { inner: RacewaySurface::default(), outer: RacewaySurface::default() };
        Self { raceway, balls: Vec::new(), seed: 1 }
    }
}

/// Names of the parameters of one raceway, in the order of the fields.
struct Names {
    waves: WaveNames,
    axial: WaveNames,
    random: [&'static str; 5],
    defects: &'static str,
    defect: [&'static str; 5],
}

const NAMES: PerRaceway<Names> = PerRaceway {
    inner: Names {
        waves: WaveNames {
            waviness: "surfaces.inner.waviness",
            wave: [
                "surfaces.inner.waviness.order",
                "surfaces.inner.waviness.amplitude",
                "surfaces.inner.waviness.phase",
            ],
        },
        random: [
            "surfaces.inner.random_waviness.amplitude",
            "surfaces.inner.random_waviness.at_order",
            "surfaces.inner.random_waviness.exponent",
            "surfaces.inner.random_waviness.from_order",
            "surfaces.inner.random_waviness.to_order",
        ],
        axial: WaveNames {
            waviness: "surfaces.inner.axial_waviness",
            wave: [
                "surfaces.inner.axial_waviness.order",
                "surfaces.inner.axial_waviness.amplitude",
                "surfaces.inner.axial_waviness.phase",
            ],
        },
        defects: "surfaces.inner.defects",
        defect: [
            "surfaces.inner.defects.azimuth",
            "surfaces.inner.defects.length",
            "surfaces.inner.defects.width",
            "surfaces.inner.defects.depth",
            "surfaces.inner.defects.across",
        ],
    },
    outer: Names {
        waves: WaveNames {
            waviness: "surfaces.outer.waviness",
            wave: [
                "surfaces.outer.waviness.order",
                "surfaces.outer.waviness.amplitude",
                "surfaces.outer.waviness.phase",
            ],
        },
        random: [
            "surfaces.outer.random_waviness.amplitude",
            "surfaces.outer.random_waviness.at_order",
            "surfaces.outer.random_waviness.exponent",
            "surfaces.outer.random_waviness.from_order",
            "surfaces.outer.random_waviness.to_order",
        ],
        axial: WaveNames {
            waviness: "surfaces.outer.axial_waviness",
            wave: [
                "surfaces.outer.axial_waviness.order",
                "surfaces.outer.axial_waviness.amplitude",
                "surfaces.outer.axial_waviness.phase",
            ],
        },
        defects: "surfaces.outer.defects",
        defect: [
            "surfaces.outer.defects.azimuth",
            "surfaces.outer.defects.length",
            "surfaces.outer.defects.width",
            "surfaces.outer.defects.depth",
            "surfaces.outer.defects.across",
        ],
    },
};

impl Surfaces {
    /// Returns true where no height differs from 0.
    pub fn are_ideal(&self) -> bool {
        self.raceway.inner.is_ideal() && self.raceway.outer.is_ideal() && self.balls.is_empty()
    }

    /// Returns true where the place of a groove along the axis is wavy.
    pub(crate) fn have_axial_waves(&self) -> bool {
        self.raceway.inner.has_axial_waves() || self.raceway.outer.has_axial_waves()
    }

    /// Returns true where a raceway or a ball has a defect.
    pub(crate) fn have_defects(&self) -> bool {
        self.raceway.inner.has_defects() || self.raceway.outer.has_defects() || self.balls_have_defects()
    }

    /// Returns true where a ball has a defect.
    pub(crate) fn balls_have_defects(&self) -> bool {
        self.balls.iter().any(BallSurface::has_defects)
    }

    /// Returns true where a ball is no sphere: it has waves or defects.
    pub(crate) fn have_uneven_balls(&self) -> bool {
        !self.balls.iter().all(BallSurface::is_sphere)
    }

    /// For each ball, true if it makes lines of its spin: those with defects, else those with waves. Empty where no ball does.
    pub(crate) fn heard_balls(&self) -> Vec<bool> {
        let all = |is_heard: &dyn Fn(&BallSurface) -> bool| self.balls.iter().map(is_heard).collect::<Vec<bool>>();
        let kinds = [all(&BallSurface::has_defects), all(&|ball| !ball.is_sphere())];
        kinds.into_iter().find(|heard| heard.contains(&true)).unwrap_or_default()
    }

    /// Returns true where balls may show odd orders of their spin: one has a defect, or their waves differ. Drawn phases do.
    pub(crate) fn have_odd_ball_orders(&self) -> bool {
        let differ = self.balls.windows(2).any(|pair| pair[0].waviness != pair[1].waviness);
        differ || self.balls.iter().any(|ball| !ball.random_waviness.is_empty() || ball.has_defects())
    }

    /// Returns true where a defect of a ball lies beside the ball's equator.
    pub(crate) fn have_defects_beside_track(&self) -> bool {
        self.balls.iter().flat_map(|ball| &ball.defects).any(|defect| defect.depth > 0.0 && defect.latitude != 0.0)
    }

    /// Returns true where a defect is not symmetric about the groove's bottom, so that its edge pushes balls along the axis.
    pub(crate) fn push_along_axis(&self) -> bool {
        let PerRaceway { inner, outer } = &self.raceway;
        let is_aside = |defect: &Defect| defect.depth > 0.0 && defect.width.is_some() && defect.across != 0.0;
        inner.defects.iter().chain(&outer.defects).any(is_aside)
    }
}

impl SurfaceParameters {
    pub(crate) fn check(&self, faults: &mut Faults) {
        self.raceway.inner.check(&NAMES.inner, faults);
        self.raceway.outer.check(&NAMES.outer, faults);
        ball::check(&self.balls, &self.every_ball, faults);
        faults.check("surfaces.seed", self.seed as f64);
    }

    /// Refuses defects that do not fit a raceway, or that overlap, and balls that do not fit the bearing.
    pub(crate) fn check_fit(&self, bearing: &Bearing, faults: &mut Faults) {
        let p = &bearing.parameters;
        let (centre, curvature) = (&bearing.groove_centre_radius, &p.groove_curvature);
        let inner = centre.inner - curvature.inner * p.ball_diameter;
        let outer = centre.outer + curvature.outer * p.ball_diameter;
        self.raceway.inner.check_fit(inner, p.ball_diameter, &NAMES.inner, faults);
        self.raceway.outer.check_fit(outer, p.ball_diameter, &NAMES.outer, faults);
        ball::check_fit(&self.balls, &self.every_ball, bearing, faults);
    }

    /// Refuses balls that overlap; `distances`: between the centres of each ball and the next [m], `diameter`: the nominal one [m].
    pub(crate) fn check_neighbours(&self, distances: &[f64], diameter: f64, faults: &mut Faults) {
        let surfaces = ball::surfaces(&self.balls, &self.every_ball, distances.len(), self.seed);
        ball::check_neighbours(&surfaces, distances, diameter, faults);
    }

    /// Refuses balls that their pockets clamp, by the diametral clearance of a nominal ball [m].
    pub(crate) fn check_pockets(&self, balls: usize, clearance: f64, faults: &mut Faults) {
        ball::check_pockets(
            &self.balls,
            &ball::surfaces(&self.balls, &self.every_ball, balls, self.seed),
            clearance,
            faults,
        );
    }

    /// The surfaces in a bearing of some balls.
    pub(crate) fn of_balls(self, count: usize) -> Surfaces {
        let Self { raceway, balls, every_ball, seed } = self;
        Surfaces { raceway, balls: ball::surfaces(&balls, &every_ball, count, seed), seed }
    }
}

impl RacewaySurface {
    /// Returns true where no height differs from 0.
    pub fn is_ideal(&self) -> bool {
        self.waviness.iter().all(|wave| wave.amplitude == 0.0)
            && self.random_waviness.is_none_or(|random| random.amplitude == 0.0)
            && !self.has_defects()
            && !self.has_axial_waves()
    }

    /// Orders of the given waves, without drawn ones.
    pub(crate) fn given_orders(&self) -> Vec<i32> {
        self.waviness.iter().filter(|wave| wave.amplitude != 0.0).map(|wave| wave.order as i32).collect()
    }

    /// Returns true where the groove's place along the axis is wavy.
    pub(crate) fn has_axial_waves(&self) -> bool {
        self.axial_waviness.iter().any(|wave| wave.amplitude != 0.0)
    }

    /// Returns true where a defect has a depth.
    pub(crate) fn has_defects(&self) -> bool {
        self.defects.iter().any(|defect| defect.depth > 0.0)
    }

    /// `radius`: of the groove's bottom [m].
    fn check_fit(&self, radius: f64, ball_diameter: f64, names: &Names, faults: &mut Faults) {
        for (index, defect) in self.defects.iter().enumerate() {
            if defect.length >= TAU * radius {
                let (length, turn) = (1e3 * defect.length, 1e3 * TAU * radius);
                let reason = format!("{length:.4} mm: must be below {turn:.4} mm, the length of the raceway");
                faults.inconsistent_item(names.defect[1], &[index], reason);
            }
            if let Some(width) = defect.width.filter(|width| defect.across.abs() - 0.5 * width >= 0.5 * ball_diameter) {
                let (across, width, most) = (1e3 * defect.across, 1e3 * width, 5e2 * ball_diameter);
                let reason =
                    format!("{across} mm with a width of {width} mm: no ball touches the groove beyond {most:.4} mm");
                faults.inconsistent_item(names.defect[4], &[index], reason);
            }
            let is_other = |(_, other): &(usize, &Defect)| defect.overlaps(other, radius);
            if let Some((other, _)) = self.defects.iter().enumerate().take(index).find(is_other) {
                let reason = format!("the outlines of items {other} and {index} overlap: give them as one defect");
                faults.inconsistent_item(names.defects, &[index], reason);
            }
        }
    }

    fn check(&self, names: &Names, faults: &mut Faults) {
        names.waves.check_waves(&self.waviness, MOST_WAVES, &[], faults);
        names.axial.check_waves(&self.axial_waviness, MOST_WAVES, &[], faults);
        if let Some(random) = &self.random_waviness {
            random.check(&names.random, &[], faults);
        }
        if self.defects.len() > MOST_DEFECTS {
            faults.inconsistent(names.defects, format!("{} defects: at most {MOST_DEFECTS}", self.defects.len()));
        }
        for Defect { azimuth, length, width, depth, across, .. } in &self.defects {
            let values = [Some(*azimuth), Some(*length), *width, Some(*depth), Some(*across)];
            for (name, value) in names.defect.iter().zip(values) {
                if let Some(value) = value {
                    faults.check(name, value);
                }
            }
        }
    }

    /// All waves, those given first. `first_zero`: the order that ends drawn waves by default. `index`: `OUTER` or
    /// `INNER`.
    fn waves(&self, first_zero: f64, index: u64, seed: u64) -> impl Iterator<Item = Wave> + '_ {
        let drawn = self.random_waviness.into_iter().flat_map(move |random| random.waves(first_zero, index, seed));
        self.waviness.iter().copied().chain(drawn).filter(|wave| wave.amplitude != 0.0)
    }
}

/// Numbers of the surfaces in the hash of drawn numbers.
pub(crate) const OUTER: u64 = 0;
pub(crate) const INNER: u64 = 1;

/// The contact of a raceway, over whose width heights are averaged.
///
/// To first order and at constant load, the approach changes by the height averaged with the pressure of a flat punch of the
/// contact's outline (Betti's reciprocity), which along rolling is a plain mean over 2b. A wave of order n keeps the share
/// sin q/q with q = n b/R.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AveragingContact {
    /// Half width of the contact along rolling, b [m].
    pub half_width: f64,
    /// Radius of the groove's bottom, R [m].
    pub radius: f64,
    /// Frequency at which a wave of order 1 passes a ball at the largest speed [Hz].
    pub turns: f64,
}

/// Reason why a wave is not in the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Omission {
    /// The contact averages it to less than a ninth.
    Averaged,
    /// It passes faster than the recorded range.
    Fast,
}

/// A wave in the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeptWave {
    /// As given or drawn.
    pub wave: Wave,
    /// Share that the contact's averaging leaves, negative beyond the first zero [-].
    pub share: f64,
    /// Frequency at which it passes a ball at the largest speed [Hz].
    pub frequency: f64,
}

/// Waves of one raceway: those in the model, and the orders that are not.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SortedWaves {
    pub kept: Vec<KeptWave>,
    /// In the order of the waves.
    pub left_out: Vec<(u32, Omission)>,
    /// Mean square of the heights that averaging removes from all waves [m²]: what is short beside the contact.
    pub removed_square: f64,
}

/// Highest order over that of the first zero of the averaging [-]: beyond, less than 0.11 of a wave is left.
const HIGHEST_OVER_ZERO: f64 = 3.0;
/// Highest frequency of a wave that is kept [Hz].
pub const HIGHEST_FREQUENCY: f64 = 25_600.0;
/// Highest order that a table of heights resolves. It exceeds 3 n₀ of the narrowest contact that heights are averaged over.
pub(super) const HIGHEST_ORDER: u32 = 1 << 14;
/// Smallest share of the circumference that a contact is averaged over [-]: unloaded contacts average nothing.
const SMALLEST_SHARE: f64 = 1e-4;

/// Smallest half width that a contact averages over [m], on a raceway of some radius [m].
pub fn smallest_half_width(radius: f64) -> f64 {
    TAU * radius * SMALLEST_SHARE
}

impl AveragingContact {
    /// Order of the wave that is as long as the contact, π R/b.
    pub fn first_zero(&self) -> f64 {
        PI * self.radius / self.half_width.max(smallest_half_width(self.radius))
    }

    /// Share of a wave that is left [-].
    pub fn share(&self, order: u32) -> f64 {
        let q = PI * f64::from(order) / self.first_zero();
        sin_cos(q).0 / q
    }

    /// Reason why a wave of an order is not in the model; `None`: it is.
    pub(crate) fn omission(&self, order: u32) -> Option<Omission> {
        let n = f64::from(order);
        if n > HIGHEST_OVER_ZERO * self.first_zero() || order > HIGHEST_ORDER {
            Some(Omission::Averaged)
        } else {
            (n * self.turns > HIGHEST_FREQUENCY).then_some(Omission::Fast)
        }
    }

    /// The waves of a surface. `index`: `OUTER` or `INNER`.
    pub fn sorted(&self, surface: &RacewaySurface, index: u64, seed: u64) -> SortedWaves {
        self.sorted_waves(surface.waves(self.first_zero(), index, seed))
    }

    /// Some waves.
    pub(crate) fn sorted_waves(&self, waves: impl Iterator<Item = Wave>) -> SortedWaves {
        let mut sorted = SortedWaves::default();
        for wave in waves {
            let share = self.share(wave.order);
            sorted.removed_square += 0.5 * wave.amplitude * wave.amplitude * (1.0 - share * share);
            match self.omission(wave.order) {
                Some(omission) => sorted.left_out.push((wave.order, omission)),
                None => sorted.kept.push(KeptWave { wave, share, frequency: f64::from(wave.order) * self.turns }),
            }
        }
        sorted
    }
}

impl SortedWaves {
    /// The kept waves as the ball feels them.
    pub fn averaged(&self) -> Vec<Wave> {
        let felt = |kept: &KeptWave| Wave { amplitude: kept.share * kept.wave.amplitude, ..kept.wave };
        self.kept.iter().map(felt).collect()
    }

    /// Highest frequency of a kept wave [Hz]; 0 without any.
    pub fn highest_frequency(&self) -> f64 {
        self.kept.iter().map(|kept| kept.frequency).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONTACT: AveragingContact = AveragingContact { half_width: 1e-5, radius: 2e-3, turns: 100.0 };

    fn random(to_order: Option<u32>) -> RacewaySurface {
        let random = RandomWaviness { amplitude: 1e-8, at_order: 10, exponent: 1.0, from_order: 2, to_order };
        RacewaySurface { random_waviness: Some(random), ..RacewaySurface::default() }
    }

    /// sin q/q: 1 for long waves, 2/π at half the first zero, 0 at the zero, −2/(3π) at 1½ of it.
    #[test]
    fn a_contact_averages_over_its_width() {
        assert!((CONTACT.first_zero() - 200.0 * PI).abs() < 1e-9);
        let round = AveragingContact { half_width: PI * 1e-5, ..CONTACT };
        assert!((round.first_zero() - 200.0).abs() < 1e-9);
        for (order, expected) in [(1, 1.0), (100, 2.0 / PI), (200, 0.0), (300, -2.0 / (3.0 * PI))] {
            assert!((round.share(order) - expected).abs() < 1e-4, "{order}");
        }
        let unloaded = AveragingContact { half_width: 0.0, ..CONTACT };
        assert!((unloaded.first_zero() - 5000.0).abs() < 1e-9);
    }

    /// Orders up to 3 n₀ and 25.6 kHz are kept, the others named with the reason.
    #[test]
    fn orders_that_are_averaged_away_or_fast_are_left_out() {
        let waves = |order| Wave { order, amplitude: 1e-8, phase: 0.0 };
        let surface =
            RacewaySurface { waviness: [1, 256, 257, 1885, 90_000].map(waves).to_vec(), ..RacewaySurface::default() };
        let sorted = CONTACT.sorted(&surface, 0, 1);
        assert_eq!(sorted.kept.iter().map(|kept| kept.wave.order).collect::<Vec<_>>(), [1, 256]);
        assert_eq!(sorted.left_out, [(257, Omission::Fast), (1885, Omission::Averaged), (90_000, Omission::Averaged)]);
        assert_eq!(sorted.highest_frequency(), 25_600.0);
    }

    /// A drawn phase depends on seed, surface and order only; amplitudes follow the power law.
    #[test]
    fn drawn_waves_keep_their_phases() {
        let slow = AveragingContact { turns: 1.0, ..CONTACT };
        let all = slow.sorted(&random(None), 0, 1);
        assert_eq!(all.kept.len(), 627);
        let few = slow.sorted(&random(Some(50)), 0, 1);
        assert_eq!(all.kept[..few.kept.len()], few.kept[..]);
        assert!((all.kept[98].wave.amplitude / 1e-9 - 1.0).abs() < 1e-14, "order 100 at 1/n");
        for (index, seed) in [(1, 1), (0, 2)] {
            assert_ne!(slow.sorted(&random(Some(50)), index, seed).kept[0].wave.phase, few.kept[0].wave.phase);
        }
        // Phases fill the circle evenly: the mean direction of 627 is within a few times 1/√627 of 0.
        let (s, c) =
            all.kept.iter().fold((0.0, 0.0), |(s, c), kept| (s + kept.wave.phase.sin(), c + kept.wave.phase.cos()));
        assert!(f64::hypot(s, c) / 627.0 < 0.12);
    }
}
