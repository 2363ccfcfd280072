//! Stationarity: batch means, trends and halves show if the recorded time represents other windows of the same motion.

use crate::numerics::statistics::{CentralMoments, level_scatter_db, level_standard_error_db, mean, rms};
use crate::physics::bearing::PerRaceway;
use crate::simulation::error::comparison::{
    Deviation, SILENCE, in_parts, judged, level_difference, quantity_errors, rms_about_zero, standard_error,
};
use crate::simulation::error::errors::{LevelErrors, QuantityErrors};
use crate::simulation::error::thresholds::{
    NOTABLE_CHANGE_DB, OSCILLATION_SHARE, QUIET, STATIONARY_SCATTER_DB, TREND_RESIDUAL, WINDOW_SCATTER_DB,
};
use crate::simulation::input::channel::Channel;
use crate::simulation::input::settings::Outputs;
use crate::simulation::recording::record::{Quantities, Recording};
use crate::simulation::recording::sampling::{BATCHES, REPEATED, kept_values};
use crate::simulation::recording::windows::{InBand, Signal};

/// Batches at each end of the recorded time whose mean levels define a trend.
const END_BATCHES: usize = 3;

/// Standard deviation of a level between windows of one motion [dB], and the deviation of a later window.
#[derive(Debug, Clone, Copy, Default)]
pub struct WindowScatter {
    /// One standard deviation [dB].
    pub scatter: LevelErrors,
    /// Deviation of a later window [dB], where one was recorded.
    pub later: Option<LevelErrors>,
}

/// Standard error of the levels of chaotic motion, by batch means [dB].
pub fn sampling_errors(recording: &Recording) -> LevelErrors {
    of_batches(recording, level_standard_error_db)
}

/// Standard deviation of the levels of windows as long as the recorded time, by blocked batch means [dB]; `None` where the record is
/// shorter than `REPEATED`.
pub fn scatter(recording: &Recording) -> LevelErrors {
    let scatter = of_batches(recording, level_scatter_db);
    LevelErrors::each(|channel| scatter.of(channel).filter(|_| recording.of(channel).is_some_and(has_batches)))
}

/// True if levels and requested single numbers are constant along the recorded time. One window then represents the others.
pub fn is_stationary(recording: &Recording, outputs: &Outputs, tolerance_db: f64) -> bool {
    let levels = scatter(recording);
    let is_steady = |channel: &Channel| levels.of(*channel).is_some_and(|scatter| scatter < STATIONARY_SCATTER_DB);
    let levels_only = !(outputs.contacts || outputs.cage);
    let quantities = halves_deviation(&recording.parts);
    let halves = Deviation { levels: LevelErrors::each(|_| Some(0.0)), quantities };
    moving_channels(recording).iter().all(is_steady) && (levels_only || halves.within(outputs, tolerance_db))
}

/// Changes of the levels [dB] that rise or fall throughout the recorded time, if no later window shows an oscillation.
pub fn trends(recording: &Recording, later: Option<&LevelErrors>) -> Vec<(Channel, f64)> {
    let of = |channel: Channel| {
        let signal = recording.of(channel).filter(|signal| has_batches(signal))?;
        let change = trend(&in_parts(&signal.in_band().mean_squares, BATCHES))?;
        let deviation = later.and_then(|later| later.of(channel));
        deviation.is_none_or(|deviation| deviation > OSCILLATION_SHARE * change.abs()).then_some((channel, change))
    };
    moving_channels(recording).into_iter().filter(|channel| !is_quiet(recording, *channel)).filter_map(of).collect()
}

/// Compared channels whose levels are so low that their changes along the recorded time do not count, each with its rms [m/s²].
pub fn quiet_channels(recording: &Recording) -> Vec<(Channel, f64)> {
    let quiet = judged(recording).into_iter().filter(|channel| is_quiet(recording, *channel));
    let with_rms = |channel| Some((channel, recording.of(channel)?.in_band().moments.rms()));
    quiet.filter_map(with_rms).filter(|(_, rms)| *rms > 0.0).collect()
}

/// True if the level of a channel lies below −20 dB.
pub fn is_quiet(recording: &Recording, channel: Channel) -> bool {
    recording.of(channel).is_some_and(|signal| signal.in_band().moments.rms() < QUIET)
}

/// The channel whose level scatters so much that no window represents the rest, and its scatter [dB].
pub fn scattering_level(recording: &Recording) -> Option<(Channel, f64)> {
    let scatter = |channel: Channel| {
        let parts = in_parts(&recording.of(channel)?.in_band().mean_squares, BATCHES);
        let levels: Vec<f64> = parts.iter().map(|square| 10.0 * square.max(f64::MIN_POSITIVE).log10()).collect();
        Some((channel, CentralMoments::of(&levels).rms()))
    };
    let all = judged(recording).into_iter().filter_map(scatter);
    all.max_by(|(_, a), (_, b)| a.total_cmp(b)).filter(|(_, scatter)| *scatter > WINDOW_SCATTER_DB)
}

/// Sampling errors of single numbers of chaotic motion, by batches: the scatter of the batches' maxima, and standard errors of means. `None`: the run
/// has fewer than two batches.
pub fn sampling_errors_of_quantities(parts: &[Quantities]) -> Option<QuantityErrors> {
    let batches: Vec<&[Quantities]> = parts.chunks(parts.len().div_ceil(BATCHES).max(1)).collect();
    let of_peaks = |of: &dyn Fn(&Quantities) -> f64| {
        let most = |batch: &&[Quantities]| batch.iter().map(of).fold(0.0, f64::max);
        let maxima: Vec<f64> = batches.iter().map(most).collect();
        let largest = maxima.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        CentralMoments::of(&maxima).rms() / largest
    };
    let means = |of: fn(&Quantities) -> Option<f64>| -> Vec<f64> {
        batches.iter().filter_map(|batch| mean_of_known(batch, of)).collect()
    };
    let of_mean = |of: fn(&Quantities) -> Option<f64>| {
        let means = means(of);
        standard_error(&means) / mean(&means).abs().max(f64::MIN_POSITIVE)
    };
    (batches.len() > 1).then(|| QuantityErrors {
        max_load: of_peaks(&|part| part.max_load),
        cage_speed: of_mean(|part| Some(part.cage_speed)),
        max_pocket_load: of_peaks(&|part| part.max_pocket_load),
        max_slip: of_peaks(&|part| part.max_slip.inner).max(of_peaks(&|part| part.max_slip.outer)),
        orbit_radius: of_mean(|part| Some(part.orbit_radius)),
        cage_slip: standard_error(&means(|part| part.cage_slip)),
    })
}

/// Deviation of the second half of a run from the first; `None`: the run has fewer than two parts.
pub fn halves_deviation(parts: &[Quantities]) -> Option<QuantityErrors> {
    let (first, second) = parts.split_at(parts.len() / 2);
    (!first.is_empty()).then(|| quantity_errors(&[together(first)], &[together(second)]))
}

/// Single numbers of several parts of a recording together: the largest of peaks, and means.
pub(crate) fn together(parts: &[Quantities]) -> Quantities {
    let most = |of: fn(&Quantities) -> f64| parts.iter().map(of).fold(0.0, f64::max);
    let mean = |of: fn(&Quantities) -> f64| parts.iter().map(of).sum::<f64>() / parts.len() as f64;
    Quantities {
        max_load: most(|part| part.max_load),
        cage_speed: mean(|part| part.cage_speed),
        out_of_plane: most(|part| part.out_of_plane),
        max_pocket_load: most(|part| part.max_pocket_load),
        max_slip: PerRaceway { inner: most(|part| part.max_slip.inner), outer: most(|part| part.max_slip.outer) },
        orbit_radius: mean(|part| part.orbit_radius),
        cage_slip: mean_of_known(parts, |part| part.cage_slip),
    }
}

/// Mean over the parts that have a number; `None` where none has.
fn mean_of_known(parts: &[Quantities], of: fn(&Quantities) -> Option<f64>) -> Option<f64> {
    let known: Vec<f64> = parts.iter().filter_map(of).collect();
    (!known.is_empty()).then(|| mean(&known))
}

/// Rms deviation of the levels of equal parts of a later record, each as long as the recorded time, from its level [dB].
pub fn deviation_of_parts(recorded: &Recording, later: &Recording) -> LevelErrors {
    let parts = |recording: &Recording, channel| {
        recording.of(channel).map(|signal| in_parts(&signal.in_band().mean_squares, BATCHES))
    };
    LevelErrors::each(|channel| {
        let level = mean(&parts(recorded, channel)?).sqrt();
        let deviation = |part: &f64| level_difference((part.sqrt(), level));
        let deviations: Vec<f64> = parts(later, channel)?.iter().filter_map(deviation).collect();
        (!deviations.is_empty()).then(|| rms_about_zero(&deviations))
    })
}

/// Errors of the levels that are not silent.
pub fn of_moving(errors: &LevelErrors, recording: &Recording) -> LevelErrors {
    let moving = moving_channels(recording);
    LevelErrors::each(|channel| errors.of(channel).filter(|_| moving.contains(&channel)))
}

/// Change of a level along equal parts of a run [dB]; `None` if it is not a trend.
fn trend(mean_squares: &[f64]) -> Option<f64> {
    if mean_squares.len() < BATCHES || mean_squares.iter().any(|square| *square <= 0.0) {
        return None;
    }
    let levels: Vec<f64> = mean_squares.iter().map(|square| 10.0 * square.log10()).collect();
    let change = mean(&levels[BATCHES - END_BATCHES..]) - mean(&levels[..END_BATCHES]);
    let slope = change / (BATCHES - END_BATCHES) as f64;
    let middle = 0.5 * (BATCHES - 1) as f64;
    let residual: Vec<f64> = levels.iter().enumerate().map(|(i, level)| level - slope * (i as f64 - middle)).collect();
    (change.abs() > NOTABLE_CHANGE_DB && rms(&residual) < TREND_RESIDUAL * change.abs()).then_some(change)
}

/// Change of the level of one signal along the recorded time [dB]; `None` if it is quiet, too short, or has no trend.
pub(crate) fn trend_of(in_band: &InBand) -> Option<f64> {
    let is_judged = in_band.moments.count() >= kept_values(REPEATED) && in_band.moments.rms() >= QUIET;
    if is_judged { trend(&in_parts(&in_band.mean_squares, BATCHES)) } else { None }
}

/// True if a signal is long enough for batch means.
fn has_batches(signal: &Signal) -> bool {
    signal.in_band().moments.count() >= kept_values(REPEATED)
}

/// The compared accelerations that are not silent.
fn moving_channels(recording: &Recording) -> Vec<Channel> {
    let moves = |channel: &Channel| recording.of(*channel).is_some_and(|of| of.in_band().moments.rms() > SILENCE);
    judged(recording).into_iter().filter(moves).collect()
}

fn of_batches(recording: &Recording, error: impl Fn(&[f64]) -> Option<f64>) -> LevelErrors {
    let moving = moving_channels(recording);
    LevelErrors::each(|channel| {
        let signal = recording.of(channel).filter(|_| moving.contains(&channel))?;
        error(&in_parts(&signal.in_band().mean_squares, BATCHES))
    })
}
