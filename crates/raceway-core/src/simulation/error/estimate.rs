//! How far a run can be trusted: does a disturbance die out, and does the level depend on the tolerance?

use crate::numerics::ode::Method;
use crate::numerics::statistics::{level_scatter_db, level_standard_error_db, mean, rms};
use crate::simulation::error::comparison::{
    Distance, LevelErrors, SILENCE, WORST, halves_apart, in_parts, judged, level_errors, quantity_errors, twice,
};
use crate::simulation::error::lyapunov::{divergence_rate, judged_stretch, judging};
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::error::report::Doubt;
use crate::simulation::error::report::MotionKind;
use crate::simulation::error::report::QuantityErrors;
use crate::simulation::error::stationarity::Stretches;
use crate::simulation::input::channel::Channel;
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::Model;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::model::observer::{self};
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::BATCHES;
use crate::simulation::recording::sampling::RATE;
use crate::simulation::recording::sampling::REPEATED;
use crate::simulation::recording::sampling::kept_values;
use crate::simulation::recording::windows::Signal;
use crate::simulation::solve::run::{Attempt, Setup};

/// Step of the repetition over that of a run in steps of a fixed length.
const HALVED: f64 = 0.5;
/// The same of `semi_implicit`, whose long steps damp light oscillations above the band as half of them does: of 7.5 and 3.75 µs
/// both may be off by the same, and a quarter shows it.
const QUARTERED: f64 = 0.25;
/// How much tighter the repetition is.
const TIGHTER: f64 = 10.0;
/// Fewest values that are compared.
const LEAST_VALUES: usize = 200;

/// Change of a level under a tighter tolerance from which the tighter run may be no better: both may be the noise of
/// their steps [dB].
pub(crate) const UNRESOLVED: f64 = 0.5;
/// The same of the difference of the signals, over the level of the whole run [-].
const NOISY: f64 = 0.3;
/// How much tighter the whole run is repeated then, until its level stands still.
const MUCH_TIGHTER: f64 = 100.0;
/// A change that is more than this share of the last one, and of fewer decibels than this, is no noise of the steps.
const STILL: f64 = 0.5;
const DROWNED: f64 = 10.0;
/// Tightest relative tolerance that double precision resolves here.
const LEAST_TOLERANCE: f64 = 1e-13;
/// What judges a run, and what repeats the whole of it, may take this many times its evaluations, and at least of so many.
const JUDGING: u64 = 10;
const REPEATING: u64 = 50;
pub(crate) const LEAST_EVALUATIONS: u64 = 10_000;
/// Growth of a disturbance over the kept time [e-folds] from which on a chaotic motion has forgotten what led to it, and is a sample of its
/// statistics: before, it can be foretold, and both of two runs may err alike (of slip, by a quarter over five e-folds).
pub(crate) const FORGETS: f64 = 10.0;
/// Share of a level's scatter along the kept time that hides an error.
const HIDDEN: f64 = 0.1;
/// Level error from which a result warns of itself [dB], and error of a load, speed or slip [-].
const DOUBTFUL: f64 = 1.0;
const DOUBTFUL_SHARE: f64 = 0.1;

/// Judges a run from its first attempt; returns the attempt that the result is made of, which is another one where `auto`
/// may choose and the first has not resolved its level. Instability parts two copies as chaos does; so a fixed step is
/// halved all the same.
pub(crate) fn judge(
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
    let (parted, failure) = or_failure(parted)?;
    let mut failure = failure.map(|why| not_judged(&why));
    (control.progress)(0.88);
    let divergence_rate = parted.map_or(0.0, |parted| parted.rate);
    let motion = parted.and_then(|parted| parted.motion());
    let dies_out = parted.is_some_and(|parted| parted.growth < 0.0);
    // Contacts that lean keep light oscillations along the axis, which long steps damp.
    let leans = setup.model.mechanism().leans();
    let forgets = if leans { dies_out } else { motion != Some(MotionKind::Diverging) };
    if settings.method == Method::SemiImplicit && !forgets {
        // Chaos, a step beyond the limit of stability, or slow motions that keep what steps have damped: error control has to, and
        // nobody reads what a repetition would tell.
        let how = "not judged: a disturbance does not die out".to_owned();
        let doubt = failure.map(Doubt::Failed);
        return Ok((first, AccuracyReport { how, motion, divergence_rate, doubt, ..AccuracyReport::default() }));
    }
    let constant_speed = setup.model.mechanism().speed.is_constant();
    let mut part = if constant_speed && !is_tossed(setup.model) && dies_out {
        settings.duration.min(REPEATED)
    } else {
        settings.duration
    };
    let (mut repeated, mut failed) = or_failure(repeat(setup, &first, part, most, aside))?;
    failure = failure.or(failed.as_deref().map(not_judged));
    if let Some(why) = failed.take()
        && part > REPEATED
    {
        // A part is better than nothing, and the result says that it is one.
        part = REPEATED;
        (repeated, failed) = or_failure(repeat(setup, &first, part, most, aside))?;
        failure = if failed.is_none() { Some(judged_by_a_part(part, &why)) } else { failure };
    }
    let repeated = repeated.flatten();
    (control.progress)(0.95);
    let fixed = settings.fixed_step.is_some();
    let is_sample = part == settings.duration && repeated.as_ref().is_some_and(|repeated| repeated.noise > NOISY);
    let report = |distance: Distance, how: String, attempt: Attempt, failure: Option<&String>| {
        let Distance { levels: level_errors, quantities: quantity_errors } = distance;
        let failed = attempt.integrated.unstable.clone().or(failure.cloned()).map(Doubt::Failed);
        let doubt = Some(failed.unwrap_or(match motion {
            Some(MotionKind::Diverging) => Doubt::Chance { too_short: too_short(divergence_rate, settings.duration) },
            _ => Doubt::Unresolved,
        }));
        let warning = None;
        (
            attempt,
            AccuracyReport { level_errors, quantity_errors, how, motion, divergence_rate, is_sample, doubt, warning },
        )
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
        let scatter = of_repetition.levels.map(|error| share * error);
        let how = format!(
            "the motion is chaotic: standard error of the level by ten batch means, or what {over} differ by if that is more, \
             {WORST}"
        );
        let levels = sampling_errors(&first.recording).larger(scatter);
        return Ok(report(Distance { levels, ..of_repetition }, how, first, failure.as_ref()));
    }
    match repeated {
        // Steps or terms left out: the run is made again with all of them, and judged then.
        Some(repeated) if !fixed && repeated.is_unresolved() && setup.whole.is_some() => {
            let levels = of_repetition.levels.map(|error| error.max(UNRESOLVED));
            let how = format!("level over {over}, {WORST}");
            Ok(report(Distance { levels, ..of_repetition }, how, first, failure.as_ref()))
        }
        // For levels that nobody asked for it is not worth its while.
        Some(repeated) if !fixed && repeated.is_unresolved() && settings.outputs.are_of_levels() => {
            let taken = first.relative_tolerance;
            let (attempt, distance, tightest) = resolve(setup, first, of_repetition, control)?;
            let how = match distance.levels.worst() {
                Some(_) => "whole run repeated at ever tighter tolerances",
                None => "nothing moves: no level is left at ever tighter tolerances",
            };
            // Where all of the run was repeated after all, nothing has failed.
            let failure = failure.as_ref().filter(|_| tightest >= taken);
            Ok(report(distance, format!("{how} down to {tightest:.0e}, {WORST}"), attempt, failure))
        }
        Some(repeated) if repeated.distance.levels.worst().is_some() => {
            Ok(report(of_repetition, format!("level over {over}, {WORST}"), first, failure.as_ref()))
        }
        _ => {
            let is_short = kept_values(settings.duration) < LEAST_VALUES;
            let short = || not_judged_so_short(settings.duration);
            let failure = failure.or_else(|| is_short.then(short));
            let how = match failure {
                Some(_) => "not judged: see the warning",
                None => "no level to compare: nothing moves",
            };
            Ok(report(of_repetition, how.into(), first, failure.as_ref()))
        }
    }
}

/// Whether the unbalance outweighs what holds the spindle in the load zone: then a motion that comes back to itself on the whole
/// may part from itself for a while at any time.
pub fn is_tossed(model: &Model) -> bool {
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

/// A level that a later stretch has within this share of what it changes by along the kept time comes back: what settles has moved on
/// by half of it or more.
const COMES_BACK: f64 = 0.25;

/// Changes of the levels [dB] of judged channels that rise or fall throughout the kept time, and do not come back.
fn trends(recording: &Recording, later: Option<&LevelErrors>) -> Vec<(Channel, f64)> {
    let of = |channel: Channel| {
        let signal = recording.of(channel).filter(|signal| tells_by_parts(signal))?;
        let change = level_change(&in_parts(&signal.in_band().mean_squares, BATCHES))?;
        let apart = later.and_then(|later| later.of(channel));
        apart.is_none_or(|apart| apart > COMES_BACK * change.abs()).then_some((channel, change))
    };
    heard(recording).into_iter().filter_map(of).collect()
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

/// A result, or why there is none: a run is not lost because it could not be judged. Only a stop is passed on.
fn or_failure<T>(result: Result<T, SimulationError>) -> Result<(Option<T>, Option<String>), SimulationError> {
    match result {
        Ok(value) => Ok((Some(value), None)),
        Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
        Err(error) => Ok((None, Some(error.to_string()))),
    }
}

/// What a result says that could not be judged, and one that could over a part of its time [s] alone.
fn not_judged(why: &str) -> String {
    format!("how far the level can be trusted is not known: repeating a part failed, {why}")
}

fn not_judged_so_short(kept: f64) -> String {
    let (kept, least) = (1e3 * kept, 1e3 * LEAST_VALUES as f64 / RATE);
    format!("how far the level can be trusted is not known: {kept:?} ms are too short. Keep {least:.0} ms or more")
}

fn judged_by_a_part(part: f64, why: &str) -> String {
    let part = 1e3 * part;
    format!(
        "how far the level can be trusted is known of the first {part:.0} ms alone: repeating all of it failed, {why}"
    )
}

/// Repeats the whole run at ever tighter tolerances until its level stands still, or shows that no tolerance makes it. `auto` takes the first that stands
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
    let (mut kept, mut last, mut distance, mut before) = (first, None::<Attempt>, of_first, of_first);
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
        // What is silence at the tighter one was the noise of the other.
        let change = Distance { levels: of_heard(&change.levels, &next.recording), ..change };
        last = Some(next);
        let Some(error) = change.levels.worst().filter(|error| *error > UNRESOLVED) else { break };
        // Noise of the steps falls with them, by tens of decibels: what does not is the motion's own, which parts after a while.
        if before.levels.worst().is_some_and(|before| error > STILL * before && error < DROWNED) {
            distance = Distance { levels: distance.levels.larger(before.levels), ..distance };
            break;
        }
        before = change;
    }
    let tightest = last.as_ref().unwrap_or(&kept).relative_tolerance;
    if let Some(last) = last.filter(|_| chooses && distance.levels.worst().is_some_and(|error| error > UNRESOLVED)) {
        kept = last;
    }
    let levels = of_heard(&distance.levels, &kept.recording);
    Ok((kept, Distance { levels, ..distance }, tightest))
}

/// Levels of two samples of a chaotic motion that differ by more than this many standard errors of the difference are not the same.
const SAME: f64 = 3.0;

/// What the second of two samples of a chaotic motion, made in half of the steps of the first, says of itself; `None`: the
/// levels are not the same, steps have made them. `judged`: what is known of the motion; `allowed_db`: what levels may differ by in any case.
pub(crate) fn of_samples(
    first: &Recording,
    second: &Recording,
    judged: &AccuracyReport,
    allowed_db: f64,
) -> Option<AccuracyReport> {
    let (distance, scatter) = (Distance::of_samples(first, second), sampling_errors(second));
    let of_both = scatter.beside(&sampling_errors(first), f64::hypot);
    let are_the_same =
        distance.levels.beside(&of_both, |apart, error| apart / (SAME * error).max(allowed_db)).worst()? <= 1.0;
    let levels = scatter.larger(distance.levels);
    are_the_same.then(|| AccuracyReport {
        level_errors: levels,
        quantity_errors: distance.quantities,
        how: format!(
            "the motion is chaotic: standard error of the level by ten batch means, or what the whole run in twice the step differs \
             by if that is more, {WORST}; single numbers by what two such runs differ by, part by part"
        ),
        doubt: Some(Doubt::Chance { too_short: None }),
        ..judged.clone()
    })
}

impl AccuracyReport {
    /// With what depends on the stretch that is kept, and, last of all, in words what is in doubt of it. `stretches`: what the levels of others
    /// differ by; `None`: they need not stand still. Where that is more than `SETTLING`, no other stretch has them closer than that, nor
    /// loads and speeds closer than the halves of this one have them, and where a level rises or falls throughout, it is no nearer to that of
    /// the steady motion than it changes by.
    pub(crate) fn of_stretch(self, recording: &Recording, stretches: Option<&Stretches>, outputs: &Outputs) -> Self {
        let Some(stretches) = stretches.filter(|_| self.level_error_db().is_some()) else {
            return self.in_words(None, outputs);
        };
        let by_chance = self.motion == Some(MotionKind::Diverging);
        let trends = if by_chance { Vec::new() } else { trends(recording, stretches.later.as_ref()) };
        let left = LevelErrors::each(|channel| Some(trends.iter().find(|(of, _)| *of == channel)?.1.abs()));
        let uneven = LevelErrors::each(|channel| stretches.scatter.of(channel).filter(|scatter| *scatter > SETTLING));
        let is_uneven = uneven.worst().is_some();
        let worst = trends.iter().max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
        let settling = worst.map(|(channel, change)| {
            format!(
                "still settling: {channel} changes by {change:+.1} dB from the beginning to the end of the kept time. Try a longer \
                 settle_s, or, if it comes back, a longer duration_s"
            )
        });
        let halves = halves_apart(&recording.parts).filter(|_| is_uneven);
        let mut how = self.how.clone();
        if settling.is_some() {
            how.push_str("; or what the level changes by along the kept time, if that is more");
        }
        if is_uneven {
            how.push_str(
                "; or what the kept time, which is uneven, and a later stretch tell of another one, if that is more",
            );
        }
        if let Some(failure) = &stretches.failure {
            how.push_str(&format!("; what another stretch shows is not known: a later one failed, {failure}"));
        }
        let doubt = if is_uneven && self.words(outputs).is_none() { Some(Doubt::Uneven) } else { self.doubt };
        Self {
            level_errors: self.level_errors.raised_to(left).raised_to(uneven),
            quantity_errors: self.quantity_errors.map(|errors| halves.map_or(errors, |halves| errors.larger(&halves))),
            how,
            doubt,
            ..self
        }
        .in_words(settling, outputs)
    }

    /// With its warning. `settling`: what is said of levels that rise or fall throughout.
    fn in_words(self, settling: Option<String>, outputs: &Outputs) -> Self {
        let words = match (&self.doubt, &settling) {
            // One number of an error is enough.
            (Some(Doubt::Uneven), Some(_)) => {
                Self { level_errors: LevelErrors::default(), ..self.clone() }.words(outputs)
            }
            _ => self.words(outputs),
        };
        let all: Vec<String> = words.into_iter().chain(settling).collect();
        Self { warning: (!all.is_empty()).then(|| all.join("; ")), ..self }
    }

    /// What is in doubt of what is stated, and what to do about it, in words.
    fn words(&self, outputs: &Outputs) -> Option<String> {
        self.in_doubt(outputs).map(|(what, advice)| what + advice)
    }

    /// What is in doubt of what is stated, in words, and what whoever reads of it should do.
    pub(crate) fn in_doubt(&self, outputs: &Outputs) -> Option<(String, &'static str)> {
        let by_chance = self.motion == Some(MotionKind::Diverging);
        let level = self.level_error_db();
        let doubtful = |chance: bool| {
            // Of chaos levels tell by themselves that the sample is a short one.
            let quantities = self.quantity_errors.filter(|_| !chance || !outputs.are_of_levels());
            doubtful(level, quantities, outputs)
        };
        match self.doubt.as_ref()? {
            Doubt::Failed(words) => Some((words.clone(), "")),
            Doubt::Unresolved => {
                let what = format!("not resolved: {}", doubtful(false)?);
                Some((what, ". Try a tighter relative tolerance, or keep more time"))
            }
            Doubt::Sensitive => {
                let doubtful = doubtful(false)?;
                let what = format!(
                    "sensitive: the least disturbance leads the motion another way, with other peaks: {doubtful}"
                );
                Some((what, ". Keep more time"))
            }
            Doubt::Chance { too_short } => match (doubtful(true), too_short) {
                (Some(doubtful), _) => {
                    let what =
                        format!("not resolved: {doubtful}, for the motion is chaotic and the run a short sample of it");
                    Some((what, ". Keep more time"))
                }
                (None, too_short) => Some((too_short.clone()?, "")),
            },
            Doubt::Uneven => {
                let doubtful = doubtful(by_chance)?;
                let what = format!("uneven along the kept time, so that another stretch may differ: {doubtful}");
                Some((what, ". Keep more time, or settle longer"))
            }
        }
    }

    /// What a run states that no finer steps would make better, for they are within so many decibels, or hidden by what its own stretches differ
    /// by; and why. `None`: finer ones might.
    pub(crate) fn good_as_any(
        &self,
        recording: &Recording,
        outputs: &Outputs,
        allowed_db: f64,
    ) -> Option<(Self, &'static str)> {
        let is_doubtful = self.words(outputs).is_some();
        let serves = |excess: Option<f64>| !is_doubtful && excess.is_some_and(|excess| excess <= 1.0);
        if serves(self.excess(outputs, allowed_db)) {
            return Some((self.clone(), "what finer steps tell lies within half of model_tolerance_db"));
        }
        if serves(self.excess_beside_scatter(recording, outputs, allowed_db)) {
            return Some((
                self.clone(),
                "what finer steps tell lies within a tenth of what stretches of the level differ by",
            ));
        }
        let sample = self.of_sample(recording, allowed_db)?;
        Some((sample, "finer steps lead another way, to levels as stretches of the motion have them"))
    }

    /// [`Self::excess`] where an error of a level may also be a tenth of what stretches of the motion differ by: nobody will miss it.
    fn excess_beside_scatter(&self, recording: &Recording, outputs: &Outputs, tolerance_db: f64) -> Option<f64> {
        let scatter = scatter(recording);
        let over = |channel| tolerance_db / tolerance_db.max(HIDDEN * scatter.of(channel).unwrap_or(0.0));
        let level_errors = LevelErrors::each(|channel| Some(self.level_errors.of(channel)? * over(channel)));
        Self { level_errors, ..self.clone() }.excess(outputs, tolerance_db)
    }

    /// The same of a motion that finer steps lead another way, where the levels of both differ by no more than those of its own stretches do, or
    /// than is allowed [dB]: each is a sample as good as the other. `None`: steps have made the difference, or it is not known.
    fn of_sample(&self, recording: &Recording, allowed_db: f64) -> Option<Self> {
        let scatter = scatter(recording);
        let apart = self.level_errors.beside(&scatter, |error, scatter| error / scatter.max(allowed_db));
        let nothing_else = matches!(self.doubt, Some(Doubt::Unresolved));
        let is_as_good = self.is_sample && nothing_else && apart.worst()? <= 1.0;
        is_as_good.then(|| Self {
            how: format!(
                "{}; finer steps lead the motion another way, and to the same levels as stretches of it have",
                self.how
            ),
            doubt: Some(Doubt::Sensitive),
            ..self.clone()
        })
    }

    /// Whether a tighter tolerance would tell nothing that was asked for any better: what is stated is within so many decibels,
    /// or the motion is chaotic and the error, a small one, is that of any sample of it.
    pub(crate) fn within(&self, outputs: &Outputs, tolerance_db: f64) -> bool {
        let by_chance =
            self.motion == Some(MotionKind::Diverging) && self.level_error_db().is_some_and(|e| e <= DOUBTFUL);
        by_chance || self.excess(outputs, tolerance_db).is_some_and(|excess| excess <= 1.0)
    }

    /// The largest of the stated errors over what is allowed of it; `None` where one is not known.
    pub(crate) fn excess(&self, outputs: &Outputs, tolerance_db: f64) -> Option<f64> {
        // Silence, both times: no level, and none that could be off.
        let silent = self.quantity_errors.is_some() && self.level_errors.worst().is_none();
        let levels = if silent { LevelErrors::each(|_| Some(0.0)) } else { self.level_errors };
        Distance { levels, ..self.errors() }.excess(outputs, tolerance_db)
    }

    /// The stated errors of what was asked for, and which are beyond what is allowed.
    pub(crate) fn words_beyond(&self, outputs: &Outputs, tolerance_db: f64) -> String {
        self.errors().of_asked(outputs).words_beyond(outputs, tolerance_db)
    }

    fn errors(&self) -> Distance {
        Distance { levels: self.level_errors, quantities: self.quantity_errors }
    }
}

/// What a result says of a chaotic motion that has forgotten too little over the kept time [s] for batches to tell its error. `rate`: of
/// divergence [1/s].
fn too_short(rate: f64, duration: f64) -> Option<String> {
    (rate * duration < FORGETS).then(|| {
        format!(
            "uncertain: the motion is chaotic, but disturbances take {:.3} s to grow e-fold, and the kept time is too short to be a sample \
             of it: another may differ by more than is stated. Keep {:.2} s or more",
            1.0 / rate,
            FORGETS / rate
        )
    })
}

/// What of these is in doubt, and by how much.
fn doubtful(level_error_db: Option<f64>, quantities: Option<QuantityErrors>, outputs: &Outputs) -> Option<String> {
    let level = level_error_db
        .filter(|error| *error > DOUBTFUL && outputs.are_of_levels())
        .map(|error| format!("the level (an error of {error:.1} dB or more)"));
    let share = |name: &str, error: Option<f64>| {
        error
            .filter(|error| *error > DOUBTFUL_SHARE)
            .map(|error| format!("{name} (an error of {:.0} % or more)", 100.0 * error))
    };
    let load = share("the largest contact load", quantities.map(|errors| errors.max_load));
    let speed = share("the cage speed", quantities.map(|errors| errors.cage_speed));
    let pocket = share("the largest pocket load", quantities.filter(|_| outputs.cage).map(|e| e.max_pocket_load));
    let slip = share("the largest slip", quantities.filter(|_| outputs.contacts).map(|e| e.max_slip));
    let orbit = share("the orbit of the cage", quantities.filter(|_| outputs.cage).map(|e| e.orbit_radius));
    let all: Vec<String> = [level, load, speed, pocket, slip, orbit].into_iter().flatten().collect();
    (!all.is_empty()).then(|| all.join(", "))
}

/// What the levels of another run of the same length would scatter by if the motion is chaotic.
pub(crate) fn sampling_errors(recording: &Recording) -> LevelErrors {
    of_batches(recording, level_standard_error_db)
}

/// What the levels of another stretch of the same length may differ by, whatever the motion is; of none that is shorter than `REPEATED`.
pub(crate) fn scatter(recording: &Recording) -> LevelErrors {
    let scatter = of_batches(recording, level_scatter_db);
    LevelErrors::each(|channel| scatter.of(channel).filter(|_| recording.of(channel).is_some_and(tells_by_parts)))
}

/// Whether a signal is long enough for its parts to tell of other stretches.
fn tells_by_parts(signal: &Signal) -> bool {
    signal.in_band().moments.count() >= kept_values(REPEATED)
}

/// The judged accelerations that are no silence.
fn heard(recording: &Recording) -> Vec<Channel> {
    let is_heard = |channel: &Channel| recording.of(*channel).is_some_and(|of| of.in_band().moments.rms() > SILENCE);
    judged(recording).into_iter().filter(is_heard).collect()
}

/// Errors of levels that are no silence.
fn of_heard(errors: &LevelErrors, recording: &Recording) -> LevelErrors {
    let heard = heard(recording);
    LevelErrors::each(|channel| errors.of(channel).filter(|_| heard.contains(&channel)))
}

fn of_batches(recording: &Recording, error: impl Fn(&[f64]) -> Option<f64>) -> LevelErrors {
    let heard = heard(recording);
    LevelErrors::each(|channel| {
        let signal = recording.of(channel).filter(|_| heard.contains(&channel))?;
        error(&in_parts(&signal.in_band().mean_squares, BATCHES))
    })
}

/// What repeating a part of a run has shown.
struct Repeated {
    distance: Distance,
    /// Rms of the signals' difference over that of the whole run, worst of the judged accelerations [-].
    noise: f64,
}

impl Repeated {
    /// The level may be that of the noise which the integrator's steps leave.
    fn is_unresolved(&self) -> bool {
        self.distance.levels.worst().is_some_and(|error| error > UNRESOLVED || self.noise > NOISY)
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
    let values = kept_values(time);
    if values < LEAST_VALUES {
        return Ok(None);
    }
    let shortened = if settings.method == Method::SemiImplicit { QUARTERED } else { HALVED };
    // Looked at as often as its own steps ask for: peaks lie between the looks at longer ones.
    let again = RunSettings {
        duration: time,
        fixed_step: settings.fixed_step.map(|step| shortened * step),
        outputs: Outputs { spectra: Vec::new(), series: Vec::new(), ..settings.outputs.clone() },
        ..settings.clone()
    };
    let stepping = Stepping {
        method: judging(settings.method),
        relative_tolerance: (settings.relative_tolerance / TIGHTER).max(LEAST_TOLERANCE),
        fixed_step: again.fixed_step,
        most_evaluations: Some(most_evaluations),
    };
    let (model, needs) = setup.whole.unwrap_or((setup.model, setup.needs));
    let again = Setup { model, needs, settings: &again, ..*setup }.attempt(&stepping, (0.88, 0.95), control)?.recording;
    let signals = twice(&run.recording, &again);
    let unseen = (1.0 - time / settings.duration).max(0.0).sqrt();
    let distance = Distance {
        levels: level_errors(&signals, |twice| twice.error_db(unseen)),
        quantities: Some(quantity_errors(&run.recording.parts, &again.parts)),
    };
    Ok(Some(Repeated { distance, noise: signals.iter().map(|(_, twice)| twice.noise()).fold(0.0, f64::max) }))
}
