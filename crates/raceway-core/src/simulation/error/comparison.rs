//! Deviation between two runs of a scene: levels of the spindle's accelerations, loads, speeds and the orbit of the cage.

use crate::numerics::spectrum::band_limited;
use crate::numerics::statistics::{CentralMoments, mean, rms};
use crate::simulation::error::codes::Quantity;
use crate::simulation::error::errors::{LevelErrors, QuantityErrors};
use crate::simulation::error::thresholds::DETAIL_SHARE;
use crate::simulation::input::channel::{Axis, Channel};
use crate::simulation::input::settings::Outputs;
use crate::simulation::recording::record::Quantities;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::ACCELERATIONS;
use crate::simulation::recording::sampling::BAND;
use crate::simulation::recording::sampling::RATE;
use crate::simulation::recording::windows::Signal;

/// Distance below the strongest level from which a channel is not compared [dB]. Its motion is at most a thousandth of the strongest one and adds
/// less than 1e-5 dB to their sum. Rounding and tolerances on a symmetry cause most of it, differently in every run.
pub const FAINT: f64 = 60.0;

/// Parts of the repeated window whose levels are compared one by one.
const PARTS: usize = 5;
/// Acceleration below which a level counts as silence [m/s²]. It is a hundredth of the resolution of a good accelerometer. Noise of the steps and
/// rests of the initial transient stay below it.
pub const SILENCE: f64 = 1e-5;
/// Distance from the largest contact load within which the peak of a ball may be the largest of a longer run [-].
const NEAR_LARGEST: f64 = 0.01;
/// Contact load [N] and cage speed [rad/s] that a relative error is at least divided by.
const LEAST_LOAD: f64 = 0.1;
const LEAST_SPEED: f64 = 0.06;
/// Pocket load [N], slip [m/s] and cage orbit [m] that a relative error is at least divided by.
const LEAST_POCKET_LOAD: f64 = 1e-3;
const LEAST_SLIP: f64 = 1e-3;
const LEAST_ORBIT: f64 = 1e-8;

/// Mean squares of `parts` equal parts of a run, from the mean squares of the batches of its windows.
pub(crate) fn in_parts(mean_squares: &[f64], parts: usize) -> Vec<f64> {
    mean_squares.chunks(mean_squares.len().div_ceil(parts).max(1)).map(mean).collect()
}

/// 20 lg(a / b) [dB] of root mean squares, silence counted as `SILENCE`; `None` if both are silent.
pub(crate) fn level_difference((a, b): (f64, f64)) -> Option<f64> {
    (a.max(b) > SILENCE).then(|| 20.0 * (a.max(SILENCE) / b.max(SILENCE)).log10())
}

/// Root mean squares [m/s²], in the band of levels, of a signal that was recorded twice.
pub(crate) struct Twice {
    /// Rms over the repeated window, of the first and of the second recording.
    stretch: (f64, f64),
    /// Rms over each part of the repeated window, likewise.
    parts: Vec<(f64, f64)>,
    /// Rms of the difference of both recordings.
    difference: f64,
    /// Rms over the whole first recording.
    whole: f64,
}

impl Twice {
    /// Comparison of the values of a repeated window.
    fn of_values(first: &[f64], again: &[f64], whole: f64) -> Self {
        let [first, again] = [first, again].map(|values| band_limited(values, RATE, BAND));
        let part = first.len().div_ceil(PARTS).max(1);
        let difference: Vec<f64> = first.iter().zip(&again).map(|(a, b)| a - b).collect();
        Self {
            stretch: (rms(&first), rms(&again)),
            parts: first.chunks(part).zip(again.chunks(part)).map(|(a, b)| (rms(a), rms(b))).collect(),
            difference: rms(&difference),
            whole,
        }
    }

    /// Comparison of two runs that recorded the same windows.
    fn of_windows(first: &Signal, again: &Signal) -> Self {
        let parts = |signal: &Signal| in_parts(&signal.in_band().mean_squares, PARTS);
        let both = parts(first).into_iter().zip(parts(again));
        let excerpts = first.excerpts.iter().zip(&again.excerpts);
        let squares: Vec<f64> = excerpts.map(|(a, b)| Self::of_values(a, b, 0.0).difference.powi(2)).collect();
        let (whole, of_again) = (first.in_band().moments.rms(), again.in_band().moments.rms());
        Self {
            stretch: (whole, of_again),
            parts: both.map(|(a, b)| (a.sqrt(), b.sqrt())).collect(),
            difference: mean(&squares).sqrt(),
            whole,
        }
    }

    pub fn level_difference(&self) -> Option<f64> {
        level_difference(self.stretch)
    }

    /// Estimated error of the level of the whole run [dB]. `unseen`: root of the share of the run that was not repeated.
    pub fn error_db(&self, unseen: f64) -> Option<f64> {
        let whole = self.level_difference()?;
        // Differences of opposite sign can cancel by chance. Their scatter shows the possible deviation of the rest of the run.
        let parts: Vec<f64> = self.parts.iter().copied().filter_map(level_difference).collect();
        Some(whole.abs().max(mean_or_luck(&parts)).hypot(unseen * standard_error(&parts)))
    }

    /// Rms of the difference of the signals [m/s²]; `None` if both are silent.
    pub fn difference(&self) -> Option<f64> {
        self.level_difference().map(|_| self.difference)
    }

    /// Rms of the difference of the signals over that of the whole run [-].
    pub fn noise(&self) -> f64 {
        self.difference / self.whole.max(SILENCE)
    }
}

/// Deviation of the level of a signal that was recorded twice [dB]; `None` if both are silent.
pub(crate) fn level_of_both(first: &[f64], again: &[f64]) -> Option<f64> {
    Twice::of_values(first, again, 0.0).error_db(0.0)
}

/// The compared accelerations: all that are not faint.
pub(crate) fn judged(recording: &Recording) -> Vec<Channel> {
    let level = |channel: &Channel| recording.of(*channel).map_or(0.0, |signal| signal.in_band().moments.rms());
    let strongest = ACCELERATIONS.iter().map(level).fold(0.0, f64::max);
    let faint = 10_f64.powf(-FAINT / 20.0) * strongest;
    ACCELERATIONS.into_iter().filter(|channel| level(channel) >= faint).collect()
}

/// Compared accelerations of a recording and of its repetition, over the whole time or over the first window.
pub(crate) fn twice(first: &Recording, again: &Recording) -> Vec<(Channel, Twice)> {
    let both = |channel: Channel| {
        let (first, again) = (first.of(channel)?, again.of(channel)?);
        let Some(repeated) = again.values() else { return Some((channel, Twice::of_windows(first, again))) };
        let stretch = first.excerpts.first()?.get(..repeated.len())?;
        Some((channel, Twice::of_values(stretch, repeated, first.in_band().moments.rms())))
    };
    // A channel that is faint in one recording may be noise in the other, so either recording can select it.
    let (of_first, of_again) = (judged(first), judged(again));
    let either = |channel: &Channel| of_first.contains(channel) || of_again.contains(channel);
    ACCELERATIONS.into_iter().filter(either).filter_map(both).collect()
}

/// Level errors from pairs of recordings of the same signal.
pub(crate) fn level_errors(both: &[(Channel, Twice)], error: impl Fn(&Twice) -> Option<f64>) -> LevelErrors {
    LevelErrors::each(|channel| both.iter().find(|(of, _)| *of == channel).and_then(|(_, twice)| error(twice)))
}

/// Deviation between two runs of a scene.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deviation {
    pub levels: LevelErrors,
    /// Deviations of single numbers; `None`: unknown.
    pub quantities: Option<QuantityErrors>,
}

impl Deviation {
    pub const UNKNOWN: Self = Self { levels: LevelErrors([None; 3]), quantities: None };

    /// Each requested error over its allowed value [-]; `None` if one is unknown. A level may deviate by `tolerance_db`. Other numbers may deviate
    /// by the same ratio as a share, or by `DETAIL_SHARE`.
    fn of_allowed(&self, outputs: &Outputs, tolerance_db: f64) -> Option<Vec<(Quantity, f64)>> {
        let mut all = vec![(Quantity::Level, self.levels.worst()? / tolerance_db)];
        if !(outputs.contacts || outputs.cage) {
            return Some(all);
        }
        let share = 10_f64.powf(tolerance_db / 20.0) - 1.0;
        let errors = self.quantities?;
        if outputs.contacts {
            all.extend([
                (Quantity::MaxLoad, errors.max_load / share),
                (Quantity::Slip, errors.max_slip / DETAIL_SHARE),
            ]);
        }
        if outputs.cage {
            all.extend([
                (Quantity::CageSpeed, errors.cage_speed / share),
                (Quantity::PocketLoad, errors.max_pocket_load / DETAIL_SHARE),
                (Quantity::CageOrbit, errors.orbit_radius / DETAIL_SHARE),
            ]);
        }
        Some(all)
    }

    /// The largest error over its allowed value [-]; `None` if one is unknown.
    pub fn excess(&self, outputs: &Outputs, tolerance_db: f64) -> Option<f64> {
        self.of_allowed(outputs, tolerance_db)?.into_iter().map(|(_, excess)| excess).reduce(f64::max)
    }

    /// The requested numbers that deviate by more than is allowed.
    pub fn beyond(&self, outputs: &Outputs, tolerance_db: f64) -> Vec<Quantity> {
        let all = self.of_allowed(outputs, tolerance_db).unwrap_or_default();
        all.into_iter().filter(|(_, excess)| *excess > 1.0).map(|(quantity, _)| quantity).collect()
    }

    /// True if every requested number deviates by no more than is allowed.
    pub fn within(&self, outputs: &Outputs, tolerance_db: f64) -> bool {
        self.excess(outputs, tolerance_db).is_some_and(|excess| excess <= 1.0)
    }

    /// Deviation between two recordings of the same window. `unseen`: root of the share of the run outside this window.
    pub fn of_recordings(a: &Recording, b: &Recording, unseen: f64) -> Self {
        let of_all = quantity_errors(&[a.quantities()], &[b.quantities()]);
        Self {
            levels: level_errors(&twice(a, b), |twice| twice.error_db(unseen)),
            quantities: Some(QuantityErrors {
                max_load: of_all.max_load.max(peaks_apart(a, b)),
                orbit_radius: of_all.orbit_radius.max(orbits_apart(a, b)),
                ..of_all
            }),
        }
    }

    /// The larger of both errors for each number; unknown if one of them is unknown.
    pub fn larger(&self, other: &Self) -> Self {
        Self {
            levels: self.levels.zip(&other.levels, f64::max),
            quantities: self.quantities.zip(other.quantities).map(|(one, other)| one.larger(&other)),
        }
    }

    /// All errors times a factor.
    pub fn times(&self, factor: f64) -> Self {
        Self {
            levels: self.levels.map(|error| factor * error),
            quantities: self.quantities.map(|errors| errors.times(factor)),
        }
    }

    /// The deviation without errors of single numbers that were not requested.
    pub fn of_asked(&self, outputs: &Outputs) -> Self {
        let of = |asked: bool, error: f64| if asked { error } else { 0.0 };
        let quantities = self.quantities.filter(|_| outputs.contacts || outputs.cage).map(|errors| QuantityErrors {
            max_slip: of(outputs.contacts, errors.max_slip),
            max_pocket_load: of(outputs.cage, errors.max_pocket_load),
            orbit_radius: of(outputs.cage, errors.orbit_radius),
            cage_slip: of(outputs.cage, errors.cage_slip),
            ..errors
        });
        Self { quantities, ..*self }
    }

    /// Deviation between two samples of a chaotic motion.
    pub fn of_samples(a: &Recording, b: &Recording) -> Self {
        Self { quantities: Some(sampled_errors(a, b)), ..Self::of_runs(a, b) }
    }

    /// Deviation between two whole runs.
    pub fn of_runs(a: &Recording, b: &Recording) -> Self {
        Self {
            levels: level_errors(&twice(a, b), |twice| twice.level_difference().map(f64::abs)),
            quantities: Some(quantity_errors(&[a.quantities()], &[b.quantities()])),
        }
    }
}

/// Deviations of single numbers between two samples of a chaotic motion, from the scatter of their parts. The scatter of a maximum or a mean falls
/// with the number of parts. Each deviation is at least the difference of the whole samples.
fn sampled_errors(a: &Recording, b: &Recording) -> QuantityErrors {
    let (parts, whole) = (quantity_errors(&a.parts, &b.parts), quantity_errors(&[a.quantities()], &[b.quantities()]));
    let share = 1.0 / (a.parts.len().min(b.parts.len()).max(1) as f64).sqrt();
    let of = |of: fn(&QuantityErrors) -> f64| of(&whole).max(share * of(&parts));
    QuantityErrors {
        max_load: of(|errors| errors.max_load),
        cage_speed: whole.cage_speed.max(parts.cage_speed),
        max_pocket_load: of(|errors| errors.max_pocket_load),
        max_slip: of(|errors| errors.max_slip),
        orbit_radius: of(|errors| errors.orbit_radius),
        cage_slip: whole.cage_slip.max(parts.cage_slip),
    }
}

/// Differences of the numbers of two runs as shares of the larger ones, from equal parts of both. A maximum may lie in any part. Differences in a
/// mean partly cancel, possibly by chance.
pub(crate) fn quantity_errors(a: &[Quantities], b: &[Quantities]) -> QuantityErrors {
    let relative = |a: f64, b: f64, least: f64| (a - b) / a.max(b).max(least);
    // One run may cover only a part of the time of the other.
    let a = &a[..a.len().min(b.len())];
    let differences = |of: &dyn Fn(&Quantities) -> f64, least: f64| -> Vec<f64> {
        a.iter().zip(b).map(|(a, b)| relative(of(a), of(b), least)).collect()
    };
    let slips: Vec<f64> = a.iter().zip(b).filter_map(|(a, b)| Some(a.cage_slip? - b.cage_slip?)).collect();
    let of_peaks = |of: &dyn Fn(&Quantities) -> f64, least: f64| {
        let largest = |parts: &[Quantities]| parts.iter().map(of).fold(0.0, f64::max);
        rms_about_zero(&differences(of, least)).max(relative(largest(a), largest(b), least).abs())
    };
    QuantityErrors {
        max_load: of_peaks(&|part| part.max_load, LEAST_LOAD),
        cage_speed: cage_speed_error(a, b),
        max_pocket_load: of_peaks(&|part| part.max_pocket_load, LEAST_POCKET_LOAD),
        max_slip: of_peaks(&|part| part.max_slip.inner, LEAST_SLIP)
            .max(of_peaks(&|part| part.max_slip.outer, LEAST_SLIP)),
        orbit_radius: rms_about_zero(&differences(&|part| part.orbit_radius, LEAST_ORBIT)),
        cage_slip: mean_or_luck(&slips),
    }
}

/// Difference of the mean cage speeds of equal parts of two runs, as a share of the mean over all parts: near a standstill, a share of the speed of one
/// part says nothing.
fn cage_speed_error(a: &[Quantities], b: &[Quantities]) -> f64 {
    let speeds = |of: &[Quantities]| -> Vec<f64> { of.iter().map(|part| part.cage_speed).collect() };
    let (a, b) = (speeds(a), speeds(b));
    let differences: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
    mean_or_luck(&differences) / mean(&a).abs().max(mean(&b[..a.len()]).abs()).max(LEAST_SPEED)
}

/// Numbers so small that their errors are no shares of them.
pub(crate) fn minute_numbers(of: &Quantities) -> Vec<Quantity> {
    let all = [
        (Quantity::MaxLoad, of.max_load < LEAST_LOAD),
        (Quantity::CageSpeed, of.cage_speed < LEAST_SPEED),
        (Quantity::PocketLoad, of.max_pocket_load < LEAST_POCKET_LOAD),
        (Quantity::Slip, of.max_slip.inner.max(of.max_slip.outer) < LEAST_SLIP),
        (Quantity::CageOrbit, of.orbit_radius < LEAST_ORBIT),
    ];
    all.into_iter().filter(|(_, is_minute)| *is_minute).map(|(quantity, _)| quantity).collect()
}

/// Largest difference of the peak loads of single balls on a raceway, as a share of the largest load. Only balls near the largest load count,
/// because any of them may be the largest of a longer run. The maxima alone may agree by chance in two short runs.
fn peaks_apart(a: &Recording, b: &Recording) -> f64 {
    let largest = a.quantities().max_load.max(b.quantities().max_load).max(LEAST_LOAD);
    let peaks = |of: &Recording| [of.contacts.inner.max_load.clone(), of.contacts.outer.max_load.clone()].concat();
    let both = peaks(a).into_iter().zip(peaks(b));
    let near = both.filter(|(a, b)| a.max(*b) > (1.0 - NEAR_LARGEST) * largest);
    near.map(|(a, b)| (a - b).abs() / largest).fold(0.0, f64::max)
}

/// Difference of the orbit radii of the cage over parts of two recordings, as a share. Over the whole recording the radii may agree by chance.
fn orbits_apart(a: &Recording, b: &Recording) -> f64 {
    let radii = |of: &Recording| -> Option<Vec<f64>> {
        let part = |values: &[f64]| -> Vec<f64> {
            values.chunks(values.len().div_ceil(PARTS).max(1)).map(|part| CentralMoments::of(part).rms()).collect()
        };
        let [y, z] = [Axis::Y, Axis::Z].map(|axis| of.signal(Channel::CageDisplacement(axis)).map(part));
        Some(y?.iter().zip(&z?).map(|(y, z)| y.hypot(*z)).collect())
    };
    let Some((a, b)) = radii(a).zip(radii(b)) else { return 0.0 };
    let relative: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a - b) / a.max(*b).max(LEAST_ORBIT)).collect();
    mean_or_luck(&relative)
}

/// Magnitude of the mean of some differences; at least the value that random signs would give.
fn mean_or_luck(differences: &[f64]) -> f64 {
    let n = (differences.len() as f64).max(1.0);
    (differences.iter().sum::<f64>() / n).abs().max(rms_about_zero(differences) / n.sqrt())
}

pub(crate) fn rms_about_zero(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / (values.len() as f64).max(1.0)).sqrt()
}

/// Standard error of the mean of a few values.
pub(crate) fn standard_error(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    if n < 2.0 {
        return 0.0;
    }
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt()
}
