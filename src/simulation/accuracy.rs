//! How far a run can be trusted: does a disturbance die out, and does the level depend on the tolerance?

use super::channel::{Axis, Channel, Motion};
use super::divergence::{divergence_rate, judged_stretch, judging};
use super::metrics::{AccuracyReport, BAND, MotionKind, QuantityErrors};
use super::model::Model;
use super::observe::{self, Quantities, RATE, Recording};
use super::run::{Attempt, Control, Live, Outputs, Phase, RunSettings, Setup, SimulationError, Stepping};
use super::windows::Signal;
use crate::numerics::ode::Method;
use crate::numerics::spectrum::band_limited;
use crate::numerics::statistics::{level_standard_error_db, mean, rms};

/// What a level is made of.
pub(super) const ACCELERATIONS: [Channel; 2] =
    [Channel::Spindle(Axis::Y, Motion::Acceleration), Channel::Spindle(Axis::Z, Motion::Acceleration)];
/// Batches for the sampling error of a level.
pub(super) const BATCHES: usize = 10;
/// A channel whose level lies this far below the stronger one's [dB] is not judged: its motion is a thousandth of the other's
/// at most, adds less than 1e-5 dB to their sum, and is mostly what rounding and tolerances make of a symmetry, which every
/// run makes anew.
pub const FAINT: f64 = 60.0;

/// Stretch that is repeated at a tighter tolerance [s], where disturbances die out and nothing else than at its beginning
/// is to come; else all of the run.
pub(super) const REPEATED: f64 = 0.01;
/// Step of the repetition over that of a run in steps of a fixed length.
const HALVED: f64 = 0.5;
/// The same of `semi_implicit`, whose long steps damp light oscillations above the band as half of them does: of 7.5 and 3.75 µs
/// both may be off by the same, and a quarter shows it.
const QUARTERED: f64 = 0.25;
/// How much tighter the repetition is.
const TIGHTER: f64 = 10.0;
/// Parts of the repeated stretch whose levels are compared one by one.
const PARTS: usize = 5;
/// Fewest values that are compared.
const LEAST_VALUES: usize = 200;

/// Change of a level under a tighter tolerance from which the tighter run may be no better: both may be the noise of
/// their steps [dB].
pub(super) const UNRESOLVED: f64 = 0.5;
/// The same of the difference of the signals, over the level of the whole run [-].
const NOISY: f64 = 0.3;
/// How much tighter the whole run is repeated then, until its level stands still.
const MUCH_TIGHTER: f64 = 100.0;
/// Tightest relative tolerance that double precision resolves here.
const LEAST_TOLERANCE: f64 = 1e-13;
/// What judges a run, and what repeats the whole of it, may take this many times its evaluations, and at least of so many.
const JUDGING: u64 = 10;
const REPEATING: u64 = 50;
const LEAST_EVALUATIONS: u64 = 10_000;
/// Levels below this count as silence [m/s²].
const SILENCE: f64 = 1e-6;
/// Level error from which a result warns of itself [dB], and error of a load or speed [-].
const DOUBTFUL: f64 = 1.0;
const DOUBTFUL_SHARE: f64 = 0.1;
/// How near to the largest contact load the peak of a ball counts as one that may be the largest of a longer run [-].
const NEAR_LARGEST: f64 = 0.01;
/// Contact loads [N] and cage speeds [rad/s] below these count as so large in a relative error.
const LEAST_LOAD: f64 = 0.1;
const LEAST_SPEED: f64 = 0.06;

/// Judges a run from its first attempt; returns the attempt that the result is made of, which is another one where `auto`
/// may choose and the first has not resolved its level. Instability parts two copies as chaos does; so a fixed step is
/// halved all the same.
pub(super) fn judge(
    setup: &Setup<'_>,
    first: Attempt,
    control: &Control<'_>,
) -> Result<(Attempt, AccuracyReport), SimulationError> {
    let settings = setup.settings;
    (control.live)(&Live::of(Phase::Judging));
    let aside = &control.aside();
    let (stretch, checkpoint) = (judged_stretch(settings), &first.integrated.checkpoint);
    let most = JUDGING * first.integrated.statistics.rhs_evaluations.max(LEAST_EVALUATIONS);
    let parted = divergence_rate(setup.model, settings, settings.settle, checkpoint, stretch, most, aside);
    let (parted, mut failure) = or_failure(parted)?;
    (control.progress)(0.88);
    let divergence_rate = parted.map_or(0.0, |parted| parted.rate);
    let motion = parted.and_then(|parted| parted.motion());
    let dies_out = parted.is_some_and(|parted| parted.growth < 0.0);
    // Contacts that lean keep light oscillations along the axis, which long steps damp.
    let leans = setup.model.mechanism().layout.axial_spindle;
    let forgets = if leans { dies_out } else { motion != Some(MotionKind::Diverging) };
    if settings.method == Method::SemiImplicit && !forgets {
        // Chaos, a step beyond the limit of stability, or slow motions that keep what steps have damped: error control has to, and
        // nobody reads what a repetition would tell.
        let how = "not judged: a disturbance does not die out".to_owned();
        let (level_error_db, quantity_errors, warning) = (None, None, failure);
        return Ok((first, AccuracyReport { level_error_db, quantity_errors, how, motion, divergence_rate, warning }));
    }
    let constant_speed = setup.model.mechanism().speed.is_constant();
    let mut part = if constant_speed && !is_tossed(setup.model) && dies_out {
        settings.duration.min(REPEATED)
    } else {
        settings.duration
    };
    let (mut repeated, mut failed) = or_failure(repeat(setup, &first, part, most, aside))?;
    if failed.is_some() && part > REPEATED {
        // A part is better than nothing, and the result says that it is one.
        failure = failure.or(failed);
        part = REPEATED;
        (repeated, failed) = or_failure(repeat(setup, &first, part, most, aside))?;
    }
    let repeated = repeated.flatten();
    failure = failure.or(failed);
    (control.progress)(0.95);
    let fixed = settings.fixed_step.is_some();
    let report = |distance: Distance, how: String, attempt: Attempt| {
        let Distance { level_db: level_error_db, quantities: quantity_errors } = distance;
        let by_chance = motion == Some(MotionKind::Diverging);
        let doubts = doubts(level_error_db, quantity_errors.filter(|_| !by_chance));
        let warning = attempt.integrated.unstable.clone().or(failure.clone()).or(doubts);
        (attempt, AccuracyReport { level_error_db, quantity_errors, how, motion, divergence_rate, warning })
    };
    let of_repetition = repeated.as_ref().map_or(Distance::UNKNOWN, |repeated| repeated.distance);
    let at = match judging(settings.method) {
        Method::SemiImplicit => "a quarter of the step".into(),
        _ if fixed => "half of the step".into(),
        method if method == settings.method => "a tenth of the relative tolerance".to_owned(),
        other => format!("a tenth of the relative tolerance by {}", other.name()),
    };
    let at = if setup.whole.is_some() { format!("{at}, with the terms that judgement has left out") } else { at };
    let over = if part < settings.duration {
        format!("the first {:.3} of {:.3} ms repeated at {at}", 1e3 * part, 1e3 * settings.duration)
    } else {
        format!("{:.3} ms repeated at {at}", 1e3 * part)
    };
    if motion == Some(MotionKind::Diverging) {
        // Another sample of the same motion: over a part of the time it scatters more than over all of it.
        let share = if fixed { 1.0 } else { (part / settings.duration).sqrt() };
        let scatter = of_repetition.level_db.map(|error| share * error);
        let how = format!(
            "the motion is chaotic: standard error of the level by ten batch means, or what {over} differ by if that is more, \
             worst of y and z"
        );
        let level_db = larger(sampling_error(&first.recording, &judged(&first.recording)), scatter);
        return Ok(report(Distance { level_db, ..of_repetition }, how, first));
    }
    match repeated {
        // Steps or terms left out: the run is made again with all of them, and judged then.
        Some(repeated) if !fixed && repeated.is_unresolved() && setup.whole.is_some() => {
            let level_db = larger(of_repetition.level_db, Some(UNRESOLVED));
            Ok(report(Distance { level_db, ..of_repetition }, format!("level over {over}, worst of y and z"), first))
        }
        Some(repeated) if !fixed && repeated.is_unresolved() => {
            let (attempt, distance, tightest) = resolve(setup, first, of_repetition, control)?;
            let how = match distance.level_db {
                Some(_) => "whole run repeated at ever tighter tolerances",
                None => "nothing moves: no level is left at ever tighter tolerances",
            };
            Ok(report(distance, format!("{how} down to {tightest:.0e}, worst of y and z"), attempt))
        }
        Some(repeated) if repeated.distance.level_db.is_some() => {
            Ok(report(of_repetition, format!("level over {over}, worst of y and z"), first))
        }
        _ => {
            let how = match failure {
                Some(_) => "not judged: see the warning",
                None => "no level to compare: nothing moves, or the run is too short to repeat a part of it",
            };
            Ok(report(of_repetition, how.into(), first))
        }
    }
}

/// Whether the unbalance outweighs what holds the spindle in the load zone: then a motion that comes back to itself on the whole
/// may part from itself for a while at any time.
fn is_tossed(model: &Model) -> bool {
    let m = model.mechanism();
    let speed = m.speed.largest();
    let held = (m.load[1] + m.spindle_mass * m.gravity).hypot(m.load[2]);
    m.unbalance != 0.0 && m.unbalance * speed * speed > held
}

/// Batches at either end of the kept time whose levels are compared, least difference that counts [dB], and largest scatter of the
/// batches about their straight line, as a share of that.
const ENDS: usize = 3;
const SETTLING: f64 = 0.5;
const SCATTER: f64 = 0.25;

/// Change of the level [dB] where it rises or falls throughout the kept time: worst of the judged channels.
fn trend(recording: &Recording) -> Option<f64> {
    let of = |channel| level_change(&in_parts(&recording.of(channel)?.in_band().mean_squares, BATCHES));
    judged(recording).into_iter().filter_map(of).max_by(|a: &f64, b: &f64| a.abs().total_cmp(&b.abs()))
}

/// Change of the level along equal parts of a run [dB], where it is one.
fn level_change(mean_squares: &[f64]) -> Option<f64> {
    if mean_squares.len() < BATCHES || mean_squares.iter().any(|square| *square <= 0.0) {
        return None;
    }
    let levels: Vec<f64> = mean_squares.iter().map(|square| 10.0 * square.log10()).collect();
    let change = mean(&levels[BATCHES - ENDS..]) - mean(&levels[..ENDS]);
    let slope = change / (BATCHES - ENDS) as f64;
    let middle = 0.5 * (BATCHES - 1) as f64;
    let off: Vec<f64> = levels.iter().enumerate().map(|(i, level)| level - slope * (i as f64 - middle)).collect();
    (change.abs() > SETTLING && rms(&off) < SCATTER * change.abs()).then_some(change)
}

/// A result, or why there is none in words: a run is not lost because it could not be judged. Only a stop is passed on.
fn or_failure<T>(result: Result<T, SimulationError>) -> Result<(Option<T>, Option<String>), SimulationError> {
    match result {
        Ok(value) => Ok((Some(value), None)),
        Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
        Err(error) => {
            Ok((None, Some(format!("how far the level can be trusted is not known: repeating a part failed, {error}"))))
        }
    }
}

/// Repeats the whole run at ever tighter tolerances until its level stands still. `auto` takes the first that stands
/// still; any other method is left as it was asked for. Returns the attempt that is kept, its distance from the
/// tightest, and the tolerance of that. `of_first`: what is known of the first.
fn resolve(
    setup: &Setup<'_>,
    first: Attempt,
    of_first: Distance,
    control: &Control<'_>,
) -> Result<(Attempt, Distance, f64), SimulationError> {
    let chooses = setup.settings.method == Method::Auto;
    let most = REPEATING * first.integrated.statistics.rhs_evaluations.max(LEAST_EVALUATIONS);
    let (mut kept, mut last, mut distance) = (first, None::<Attempt>, of_first);
    loop {
        let latest = last.as_ref().unwrap_or(&kept);
        let tolerance = (latest.relative_tolerance / MUCH_TIGHTER).max(LEAST_TOLERANCE);
        if tolerance >= latest.relative_tolerance {
            break;
        }
        let stepping =
            Stepping { relative_tolerance: tolerance, most_evaluations: Some(most), ..Stepping::of(setup.settings) };
        // A tolerance too tight for its cost or for double precision: what is known has to do.
        let (Some(next), _) = or_failure(setup.attempt(&stepping, (0.95, 0.95), control))? else { break };
        let change = Distance::of_runs(&latest.recording, &next.recording);
        if chooses {
            if let Some(last) = last.take() {
                kept = last;
            }
            distance = change;
        } else {
            distance = Distance::of_runs(&kept.recording, &next.recording);
        }
        last = Some(next);
        if change.level_db.is_none_or(|change| change <= UNRESOLVED) {
            break;
        }
    }
    let tightest = last.as_ref().unwrap_or(&kept).relative_tolerance;
    if let Some(last) = last.filter(|_| chooses && distance.level_db.is_some_and(|error| error > UNRESOLVED)) {
        kept = last;
    }
    Ok((kept, distance, tightest))
}

impl AccuracyReport {
    /// With what settling leaves behind, where the level rises or falls throughout the kept time although nothing drives it to: it is
    /// no nearer to that of the steady motion than it changes by. `steady`: whether it should stand still.
    pub(super) fn with_settling(self, recording: &Recording, steady: bool) -> Self {
        let by_chance = self.motion == Some(MotionKind::Diverging);
        let Some(change) = trend(recording).filter(|_| steady && !by_chance) else {
            return self;
        };
        let warning = || {
            format!(
                "still settling: the level changes by {change:+.1} dB from the beginning to the end of the kept time. Try a longer \
                 settle_s"
            )
        };
        Self {
            level_error_db: self.level_error_db.map(|error| error.max(change.abs())),
            how: format!("{}; or what the level changes by along the kept time, if that is more", self.how),
            warning: self.warning.or_else(|| Some(warning())),
            ..self
        }
    }

    /// Whether a tighter tolerance would tell nothing that was asked for any better: what is stated is within so many decibels,
    /// or the motion is chaotic and the error, a small one, is that of any sample of it.
    pub(super) fn within(&self, outputs: &Outputs, tolerance_db: f64) -> bool {
        let stated = Distance { level_db: self.level_error_db, quantities: self.quantity_errors };
        let by_chance =
            self.motion == Some(MotionKind::Diverging) && self.level_error_db.is_some_and(|e| e <= DOUBTFUL);
        by_chance || stated.within(outputs, tolerance_db)
    }
}

/// What a result says where level, largest load or cage speed are not resolved.
fn doubts(level_error_db: Option<f64>, quantities: Option<QuantityErrors>) -> Option<String> {
    let level = level_error_db
        .filter(|error| *error > DOUBTFUL)
        .map(|error| format!("the level (an error of {error:.0} dB or more)"));
    let share = |name: &str, error: Option<f64>| {
        error
            .filter(|error| *error > DOUBTFUL_SHARE)
            .map(|error| format!("{name} (an error of {:.0} % or more)", 100.0 * error))
    };
    let load = share("the largest contact load", quantities.map(|errors| errors.max_load));
    let speed = share("the cage speed", quantities.map(|errors| errors.cage_speed));
    let all: Vec<String> = [level, load, speed].into_iter().flatten().collect();
    (!all.is_empty()).then(|| {
        format!(
            "not resolved: {}. Try a tighter relative tolerance, the method `auto`, or keep more time",
            all.join(", ")
        )
    })
}

fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::max)
}

/// What another run of the same length would scatter by if the motion is chaotic, worst of some channels [dB].
pub(super) fn sampling_error(recording: &Recording, channels: &[Channel]) -> Option<f64> {
    let signals = channels.iter().filter_map(|&channel| recording.of(channel));
    let error = |signal: &Signal| level_standard_error_db(&in_parts(&signal.in_band().mean_squares, BATCHES));
    signals.filter_map(error).reduce(f64::max)
}

/// Mean squares of so many equal parts of a run, from those of the batches of its windows.
fn in_parts(mean_squares: &[f64], parts: usize) -> Vec<f64> {
    mean_squares.chunks(mean_squares.len().div_ceil(parts).max(1)).map(mean).collect()
}

/// 20 lg(a / b) [dB] of root mean squares, silence counted as `SILENCE`; `None` where both are silent.
fn level_difference((a, b): (f64, f64)) -> Option<f64> {
    (a.max(b) > SILENCE).then(|| 20.0 * (a.max(SILENCE) / b.max(SILENCE)).log10())
}

/// Root mean squares [m/s²] of a signal that was recorded twice, first and again, in the band of levels.
struct Twice {
    /// Of all that was recorded again.
    stretch: (f64, f64),
    /// Of its parts.
    parts: Vec<(f64, f64)>,
    /// Of the difference of the two.
    difference: f64,
    /// Of all that was recorded first.
    whole: f64,
}

impl Twice {
    /// From the values of the stretch that was recorded again.
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

    /// Of two runs of the same windows.
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

    fn level_difference(&self) -> Option<f64> {
        level_difference(self.stretch)
    }

    /// What the levels of the whole run may differ by [dB]. `unseen`: root of the share of it that was not recorded again.
    fn error_db(&self, unseen: f64) -> Option<f64> {
        let whole = self.level_difference()?;
        // Differences of either sign can cancel, here by luck, and their scatter tells by how much the rest may differ.
        let parts: Vec<f64> = self.parts.iter().copied().filter_map(level_difference).collect();
        Some(whole.abs().max(mean_or_luck(&parts)).hypot(unseen * standard_error(&parts)))
    }

    fn noise(&self) -> f64 {
        self.difference / self.whole.max(SILENCE)
    }
}

/// The accelerations that are judged: those that are not faint.
fn judged(recording: &Recording) -> Vec<Channel> {
    let level = |channel: &Channel| recording.of(*channel).map_or(0.0, |signal| signal.in_band().moments.rms());
    let strongest = ACCELERATIONS.iter().map(level).fold(0.0, f64::max);
    let faint = 10_f64.powf(-FAINT / 20.0) * strongest;
    ACCELERATIONS.into_iter().filter(|channel| level(channel) >= faint).collect()
}

/// Accelerations of a recording, and what was recorded again of all of it or of its first window.
fn twice(first: &Recording, again: &Recording) -> Vec<Twice> {
    let both = |channel: Channel| {
        let (first, again) = (first.of(channel)?, again.of(channel)?);
        let Some(repeated) = again.values() else { return Some(Twice::of_windows(first, again)) };
        let stretch = first.excerpts.first()?.get(..repeated.len())?;
        Some(Twice::of_values(stretch, repeated, first.in_band().moments.rms()))
    };
    judged(again).into_iter().filter_map(both).collect()
}

/// By how much two runs of a scene differ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Distance {
    /// Levels, worst of y and z [dB]; `None` where nothing moves.
    pub level_db: Option<f64>,
    /// Largest load and cage speed; `None` where they are not known.
    pub quantities: Option<QuantityErrors>,
}

impl Distance {
    pub const UNKNOWN: Self = Self { level_db: None, quantities: None };

    /// Whether level, and largest load and cage speed where they are asked for, differ by no more than so many decibels.
    pub fn within(&self, outputs: &Outputs, tolerance_db: f64) -> bool {
        let share = 10_f64.powf(tolerance_db / 20.0) - 1.0;
        let within = |asked: bool, error: Option<f64>| !asked || error.is_some_and(|error| error <= share);
        self.level_db.is_some_and(|error| error <= tolerance_db)
            && within(outputs.contacts, self.quantities.map(|errors| errors.max_load))
            && within(outputs.cage, self.quantities.map(|errors| errors.cage_speed))
    }

    /// Of two recordings of the same stretch. `unseen`: root of the share of a run that they do not show.
    pub fn of_recordings(a: &Recording, b: &Recording, unseen: f64) -> Self {
        let levels = twice(a, b);
        let of_all = quantity_errors(&[a.quantities()], &[b.quantities()]);
        Self {
            level_db: levels.iter().filter_map(|twice| twice.error_db(unseen)).reduce(f64::max),
            quantities: Some(QuantityErrors { max_load: of_all.max_load.max(peaks_apart(a, b)), ..of_all }),
        }
    }

    /// Of two whole runs.
    fn of_runs(a: &Recording, b: &Recording) -> Self {
        let levels = twice(a, b);
        Self {
            level_db: levels.iter().filter_map(Twice::level_difference).map(f64::abs).reduce(f64::max),
            quantities: Some(quantity_errors(&[a.quantities()], &[b.quantities()])),
        }
    }
}

/// Differences of two runs' numbers as shares of the larger ones, from those of equal parts of both. A largest load may be
/// that of any part; differences in a mean partly cancel, and may do so by luck.
fn quantity_errors(a: &[Quantities], b: &[Quantities]) -> QuantityErrors {
    let relative = |a: f64, b: f64, least: f64| (a - b) / a.max(b).max(least);
    // One may be of a part of the time of the other.
    let a = &a[..a.len().min(b.len())];
    let both = || a.iter().zip(b);
    let loads: Vec<f64> = both().map(|(a, b)| relative(a.max_load, b.max_load, LEAST_LOAD)).collect();
    let speeds: Vec<f64> = both().map(|(a, b)| relative(a.cage_speed, b.cage_speed, LEAST_SPEED)).collect();
    let largest = |of: &[Quantities]| of.iter().fold(0.0, |most, part| f64::max(most, part.max_load));
    QuantityErrors {
        max_load: rms_about_zero(&loads).max(relative(largest(a), largest(b), LEAST_LOAD).abs()),
        cage_speed: mean_or_luck(&speeds),
    }
}

/// What the peaks of single balls on a raceway differ by at most, as a share of the largest, of those that come near it: any of them
/// may be the largest of a longer run, and in the largest alone two short runs may agree by luck.
fn peaks_apart(a: &Recording, b: &Recording) -> f64 {
    let largest = a.quantities().max_load.max(b.quantities().max_load).max(LEAST_LOAD);
    let peaks = |of: &Recording| [of.contacts.inner.max_load.clone(), of.contacts.outer.max_load.clone()].concat();
    let both = peaks(a).into_iter().zip(peaks(b));
    let near = both.filter(|(a, b)| a.max(*b) > (1.0 - NEAR_LARGEST) * largest);
    near.map(|(a, b)| (a - b).abs() / largest).fold(0.0, f64::max)
}

/// Size of the mean of some differences; at least what it would be if their signs were a matter of chance.
fn mean_or_luck(differences: &[f64]) -> f64 {
    let n = (differences.len() as f64).max(1.0);
    (differences.iter().sum::<f64>() / n).abs().max(rms_about_zero(differences) / n.sqrt())
}

fn rms_about_zero(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / (values.len() as f64).max(1.0)).sqrt()
}

/// What repeating a part of a run has shown.
struct Repeated {
    distance: Distance,
    /// Rms of the signals' difference over that of the whole run, worst of y and z [-].
    noise: f64,
}

impl Repeated {
    /// The level may be that of the noise which the integrator's steps leave.
    fn is_unresolved(&self) -> bool {
        self.distance.level_db.is_some_and(|error| error > UNRESOLVED || self.noise > NOISY)
    }
}

/// Repeats the run from its start, for what settling leaves behind, over a time of the kept one [s], at a tighter tolerance;
/// `None` where the run is too short.
fn repeat(
    setup: &Setup<'_>,
    run: &Attempt,
    time: f64,
    most_evaluations: u64,
    control: &Control<'_>,
) -> Result<Option<Repeated>, SimulationError> {
    let settings = setup.settings;
    let values = observe::kept_values(time);
    if values < LEAST_VALUES {
        return Ok(None);
    }
    let again = RunSettings {
        duration: time,
        outputs: Outputs { spectra: Vec::new(), series: Vec::new(), ..settings.outputs.clone() },
        ..settings.clone()
    };
    let shortened = if settings.method == Method::SemiImplicit { QUARTERED } else { HALVED };
    let stepping = Stepping {
        method: judging(settings.method),
        relative_tolerance: (settings.relative_tolerance / TIGHTER).max(LEAST_TOLERANCE),
        fixed_step: settings.fixed_step.map(|step| shortened * step),
        most_evaluations: Some(most_evaluations),
    };
    let (model, needs) = setup.whole.unwrap_or((setup.model, setup.needs));
    let again = Setup { model, needs, settings: &again, ..*setup }.attempt(&stepping, (0.88, 0.95), control)?.recording;
    let signals = twice(&run.recording, &again);
    let unseen = (1.0 - time / settings.duration).max(0.0).sqrt();
    let distance = Distance {
        level_db: signals.iter().filter_map(|twice| twice.error_db(unseen)).reduce(f64::max),
        quantities: Some(quantity_errors(&run.recording.parts, &again.parts)),
    };
    Ok(Some(Repeated { distance, noise: signals.iter().map(Twice::noise).fold(0.0, f64::max) }))
}

/// Standard error of the mean of a few values.
fn standard_error(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    if n < 2.0 {
        return 0.0;
    }
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt()
}
