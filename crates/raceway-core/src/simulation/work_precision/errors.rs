//! Deviation of a run from the reference: trajectory, levels and lines.

use super::course::{Course, Finished};
use crate::numerics::spectrum::{Spectrum, interpolated_peak};
use crate::simulation::error::comparison::FAINT;
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::input::channel::Channel;
use crate::simulation::input::scene::Scene;
use crate::simulation::recording::sampling::ACCELERATIONS;
use crate::simulation::recording::spectra::ChannelSpectra;
use crate::simulation::result::lines::Line;
use crate::simulation::result::metrics;

/// Largest error up to which trajectories are compared: the tolerance, grown at the divergence rate [-].
pub const MOST_GROWN: f64 = 0.1;

/// Smallest scale of a component, in units of its natural size, so that a component at rest is not divided by nearly 0.
pub const LEAST_SCALE: f64 = 0.01;
/// Lines that are compared of a channel.
const LINES: usize = 3;
/// A line is looked for within this many bins of its place in the reference.
const LINE_REACH: usize = 2;

/// Deviations of the states over their scales [-]. The scale of a component is its standard deviation in the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrajectoryError {
    /// Root mean square over components and output grid.
    pub rms: f64,
    /// Largest of any component at any point.
    pub largest: f64,
    /// Root mean square over the components at the last point compared.
    pub end: f64,
    /// Time compared, from the common start [s].
    pub compared: f64,
}

/// All errors of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// `None`: the motion is chaotic and diverges from the reference before the first point of the grid.
    pub trajectory: Option<TrajectoryError>,
    /// Largest deviation of an acceleration that is not faint [dB]; `None` where the spindle stands still.
    pub level_db: Option<f64>,
    /// Worst over the compared lines [Hz]; `None` where there are none.
    pub line_frequency: Option<f64>,
    /// Relative, worst over the compared lines [-].
    pub line_amplitude: Option<f64>,
}

impl Errors {
    pub fn is_finite(&self) -> bool {
        let trajectory = self.trajectory.is_none_or(|e| [e.rms, e.largest, e.end].iter().all(|x| x.is_finite()));
        let others = [self.level_db, self.line_frequency, self.line_amplitude];
        trajectory && others.iter().flatten().all(|error| error.is_finite())
    }
}

/// The larger of the known values; `None` where neither is known.
pub fn largest(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::max)
}

/// Levels of the accelerations [dB].
fn levels(run: &Finished) -> Vec<(Channel, Option<f64>)> {
    let level = |channel: Channel| {
        let recording = &run.recording;
        let variance = recording.total_variance(channel);
        recording.of(channel).and_then(|signal| metrics::in_band_metrics(channel, signal.in_band(), variance).level_db)
    };
    ACCELERATIONS.into_iter().map(|channel| (channel, level(channel))).collect()
}

/// Channels whose levels are compared, from all levels [dB]: those that move and are not faint.
fn judged(levels: &[(Channel, Option<f64>)]) -> Vec<Channel> {
    let strongest = levels.iter().filter_map(|(_, level)| *level).fold(f64::NEG_INFINITY, f64::max);
    levels.iter().filter(|(_, level)| level.is_some_and(|level| level >= strongest - FAINT)).map(|of| of.0).collect()
}

/// The reference, made ready to be compared with.
pub struct Comparison<'a> {
    course: &'a Course<'a>,
    reference: &'a Finished,
    /// One for each entry of the state.
    scales: Vec<f64>,
    /// Rate at which trajectories diverge [1/s]; 0 where they do not.
    growth: f64,
    pub levels: Vec<(Channel, Option<f64>)>,
    /// Channels whose levels and lines are judged.
    pub judged: Vec<Channel>,
    pub lines: Vec<(Channel, Line)>,
}

impl<'a> Comparison<'a> {
    pub fn new(scene: &Scene, course: &'a Course<'a>, reference: &'a Finished, growth: f64) -> Self {
        let sizes = course.sizes();
        let spread = standard_deviations(&reference.trajectory, course.dimension());
        let scales = spread.iter().zip(&sizes).map(|(spread, size)| spread.max(LEAST_SCALE * size)).collect();
        let spectra = metrics::spectra(&reference.recording, &course.settings);
        let levels = levels(reference);
        let judged = judged(&levels);
        let mut lines: Vec<(Channel, Line)> = Vec::new();
        for (channel, line) in metrics::lines(
            scene,
            &reference.recording,
            &spectra,
            metrics::Spectra::Amplitude,
            &AccuracyReport::default(),
        ) {
            if judged.contains(&channel) && lines.iter().filter(|(other, _)| *other == channel).count() < LINES {
                lines.push((channel, line));
            }
        }
        Self { course, reference, scales, growth, levels, judged, lines }
    }

    /// Errors of a run made at a relative tolerance.
    pub fn errors(&self, run: &Finished, relative_tolerance: f64) -> Errors {
        let spectra = metrics::spectra(&run.recording, &self.course.settings);
        let lines: Vec<(f64, f64)> = self.lines.iter().filter_map(|line| line_error(line, &spectra)).collect();
        Errors {
            trajectory: self.trajectory(run, relative_tolerance),
            level_db: self.level_error(run),
            line_frequency: lines.iter().map(|error| error.0).reduce(f64::max),
            line_amplitude: lines.iter().map(|error| error.1).reduce(f64::max),
        }
    }

    fn level_error(&self, run: &Finished) -> Option<f64> {
        let both = self.levels.iter().zip(levels(run)).filter(|((channel, _), _)| self.judged.contains(channel));
        let errors = both.filter_map(|((_, reference), (_, level))| Some((level? - (*reference)?).abs()));
        errors.reduce(f64::max)
    }

    /// Over the time in which a run at that tolerance has something in common with the reference.
    pub fn trajectory(&self, run: &Finished, relative_tolerance: f64) -> Option<TrajectoryError> {
        let count = self.compared(relative_tolerance);
        let n = self.course.dimension();
        if count == 0 || n == 0 {
            return None;
        }
        let (mut squares, mut worst, mut end) = (0.0, 0.0, 0.0);
        for point in 0..count {
            let at = point * n..(point + 1) * n;
            let pairs = run.trajectory[at.clone()].iter().zip(&self.reference.trajectory[at]);
            end = 0.0;
            for ((value, reference), scale) in pairs.zip(&self.scales) {
                let error = ((value - reference) / scale).abs();
                end += error * error;
                // A NaN must not get lost in a maximum.
                worst = if error > worst || error.is_nan() { error } else { worst };
            }
            squares += end;
        }
        Some(TrajectoryError {
            rms: (squares / (count * n) as f64).sqrt(),
            largest: worst,
            end: (end / n as f64).sqrt(),
            compared: count as f64 * self.course.grid_step,
        })
    }

    /// Points of the grid at which `tolerance · e^(growth · time)` is below `MOST_GROWN`.
    fn compared(&self, relative_tolerance: f64) -> usize {
        if self.growth <= 0.0 {
            return self.course.grid_count;
        }
        let horizon = (MOST_GROWN / relative_tolerance).ln() / self.growth;
        ((horizon / self.course.grid_step).max(0.0) as usize).min(self.course.grid_count)
    }
}

/// Frequency error [Hz] and relative amplitude error of a line of the reference; `None` where the run has no such
/// spectrum.
fn line_error((channel, line): &(Channel, Line), spectra: &[ChannelSpectra]) -> Option<(f64, f64)> {
    let spectrum = &spectra.iter().find(|spectra| spectra.channel == *channel)?.amplitude;
    let (frequency, amplitude) = peak_near(spectrum, line.frequency)?;
    Some(((frequency - line.frequency).abs(), (amplitude / line.amplitude - 1.0).abs()))
}

/// Frequency [Hz] and amplitude of the strongest peak near a frequency.
fn peak_near(spectrum: &Spectrum, frequency: f64) -> Option<(f64, f64)> {
    let bin = (frequency / spectrum.resolution).round() as usize;
    let bins = bin.saturating_sub(LINE_REACH)..(bin + LINE_REACH + 1).min(spectrum.amplitude.len());
    let strongest = bins.max_by(|&a, &b| spectrum.amplitude[a].total_cmp(&spectrum.amplitude[b]))?;
    Some(interpolated_peak(spectrum, strongest))
}

/// Standard deviation of each component over the points of the grid.
fn standard_deviations(trajectory: &[f64], dimension: usize) -> Vec<f64> {
    let count = (trajectory.len() / dimension.max(1)).max(1) as f64;
    let component = |i: usize| trajectory.iter().skip(i).step_by(dimension.max(1));
    (0..dimension)
        .map(|i| {
            let mean = component(i).sum::<f64>() / count;
            (component(i).map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standard_deviations_are_those_of_each_component() {
        // Components 1, 3 and 5, 5 at two points.
        assert_eq!(standard_deviations(&[1.0, 5.0, 3.0, 5.0], 2), [1.0, 0.0]);
    }

    #[test]
    fn a_line_is_found_again_where_it_has_moved_to() {
        let amplitude = vec![0.0, 0.0, 0.1, 1.0, 0.5, 0.0, 9.0];
        let spectrum = Spectrum { resolution: 10.0, amplitude, window: "hann", averages: 1 };
        let (frequency, amplitude) = peak_near(&spectrum, 29.0).unwrap();
        assert!((30.0..35.0).contains(&frequency) && amplitude >= 1.0, "{frequency} {amplitude}");
        assert_eq!(peak_near(&spectrum, 1e6), None);
    }

    #[test]
    fn a_channel_far_below_the_other_is_not_judged() {
        use crate::simulation::recording::sampling::ACCELERATIONS;
        let [_, y, z] = ACCELERATIONS;
        let judged = |a: Option<f64>, b: Option<f64>| judged(&[(y, a), (z, b)]);
        assert_eq!(judged(Some(3.0), Some(-130.0)), [y]);
        assert_eq!(judged(Some(-130.0), Some(3.0)), [z]);
        assert_eq!(judged(Some(3.0), Some(-56.9)), [y, z]);
        assert_eq!(judged(Some(-200.0), None), [y]);
        assert!(judged(None, None).is_empty());
    }

    #[test]
    fn the_larger_of_two_is_that_which_is_there() {
        assert_eq!((largest(None, Some(1.0)), largest(Some(2.0), Some(1.0))), (Some(1.0), Some(2.0)));
        assert_eq!(largest(None, None), None);
    }
}
