//! Lines of a spectrum, found and labelled by combinations of the bearing's frequencies.

use std::f64::consts::TAU;

use crate::numerics::spectrum::{Spectrum, interpolated_peak, spread_of_place};
use crate::physics::kinematics::CharacteristicFrequencies;

/// A line of a spectrum.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Frequency of the line [Hz].
    pub frequency: f64,
    /// One-sided amplitude in the channel's unit: a sine of amplitude 1 reads 1.
    pub amplitude: f64,
    /// Nearest small combination, such as `2·BPFO` or `BPFO − f_r`; empty when none is near.
    pub label: String,
    /// Frequency less that of the label [Hz]; 0 without a label.
    pub deviation: f64,
}

/// Largest number of listed lines.
const MAX_LINES: usize = 20;
/// A line is the largest entry within this many bins to both sides: the half width of a Hann window's main lobe.
const LOBE: usize = 2;
/// Bins to both sides whose median is taken for the floor.
const FLOOR_REACH: usize = 25;
/// A line stands this far above the floor. The noise of a single window does so in one bin of 7000, because the floor is estimated, too; above
/// the true median it would in one of 60 000.
const FLOOR_FACTOR: f64 = 4.0;
/// A line has at least this share of the strongest one's amplitude (−60 dB).
pub(crate) const LEAST_SHARE: f64 = 1e-3;

/// A label may be off by this many bins …
pub(super) const TOLERANCE_BINS: f64 = 0.5;
/// … plus this share of the terms that turn with the cage, the uncertainty of the mean slip of a run. The shaft does not slip.
pub(super) const TOLERANCE_SHARE: f64 = 2e-4;
/// A label is never off by more than the place of its line is uncertain, so that few are taken by chance. Steady strong lines deviate by less than a
/// hundredth of a bin; neighbours move weak ones by up to this many bins.
pub(crate) const LEAST_BINS: f64 = 0.1;
/// Smallest frequency of a label in tolerances: closer combs would fit any line.
const SEPARATION: f64 = 6.0;
/// Largest complexity of a label with more than one term.
const LARGEST_COMPLEXITY: f64 = 4.2;
/// Complexity of a sideband of the first order of shaft or outer ball passage.
const PLAIN_SIDEBAND: f64 = 1.0;
/// Cost over complexity of terms that a surface of the scene drives; of others it is 1.
const DRIVEN_SHARE: f64 = 0.5;
/// Share of the tolerance within which a combination fits well.
const GOOD_FIT: f64 = 0.1;
/// Share of the tolerance within which driven lines fit well. Loads and speeds vary while balls meet a defect, which moves its lines. Those of an
/// inner spall of 0.6 mm moved by up to 0.15 bins (6205, 500 N, 0.4 s).
const DRIVEN_FIT: f64 = 0.5;
/// Cost of a deviation at the edge of the tolerance, so that an exact sideband beats a simpler label that deviates. Lines of steady motions
/// deviate by less than a hundredth of a bin. Of 11 scenes of a 6205, labels that named no cause of the scene were off by a fifth of a bin or more.
const DEVIATION_COST: f64 = 6.0;
/// Harmonics of a given wave of the inner raceway.
const WAVE_HARMONICS: std::ops::RangeInclusive<i32> = 1..=2;
/// Highest orders of the sidebands.
const SHAFT_SIDEBANDS: i32 = 4;
const OUTER_SIDEBANDS: i32 = 2;
const CAGE_SIDEBANDS: i32 = 3;
/// Labels of the ball passages of the raceways.
const INNER: &str = "BPFI";
/// Label of the spin of a ball.
const BALL: &str = "BSF";
/// Labels of the rotation of shaft and cage.
const SHAFT: &str = "f_r";
const CAGE: &str = "FTF";
const OUTER: &str = "BPFO";
/// Label of the rotation of the outer ring.
const OUTER_RING: &str = "f_o";
/// Label of a harmonic load.
const LOAD: &str = "load";
/// Cost of the first order of a load: lower than of the shaft, which an order of the load may coincide with.
const LOAD_WEIGHT: f64 = 0.9;
/// Highest order of a load.
const HIGHEST_LOAD_ORDER: i32 = 10;
/// Labels of whirl.
const CAGE_WHIRL: &str = "cage whirl";
const SPINDLE_WHIRL: &str = "spindle whirl";
/// Highest order of a harmonic.
const HIGHEST_ORDER: f64 = 1000.0;
/// Highest order of a harmonic of the cage alone. Higher ones coincide with the ball passage and its sidebands, and would fit any line.
const HIGHEST_CAGE_ORDER: f64 = 20.0;

/// Frequencies [Hz] that name the lines of a spectrum; 0 for one that cannot appear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineSources<'a> {
    /// At the simulated speeds of cage and balls.
    pub frequencies: CharacteristicFrequencies,
    /// Mean rate at which the centre of the cage orbits its mean position.
    pub cage_whirl: f64,
    /// Mean rate at which the centre of the spindle orbits its mean position.
    pub spindle_whirl: f64,
    /// The inner raceway has waves or defects. They turn through the load, so that their lines have several sidebands of the shaft.
    pub uneven_inner: bool,
    /// Orders of the given waves of the inner raceway.
    pub inner_orders: &'a [i32],
    /// The outer ring turns. Balls then pass the load and the outer raceway at different rates, and a defect of it turns through the load if it
    /// has one.
    pub outer_ring: OuterRing,
    /// A raceway has waves or defects.
    pub uneven_raceways: bool,
    /// A ball has odd orders of its spin, too: it has a defect, which the raceways feel differently, or waves that others do not have.
    pub odd_ball_orders: bool,
    /// Balls or pockets differ. Their pattern turns with the cage, so that its sidebands stand beside every ball passage.
    pub unequal_balls: bool,
    /// Frequencies of harmonic loads.
    pub loads: &'a [f64],
}

impl<'a> LineSources<'a> {
    /// Of a shaft without bearings at a speed [rad/s], and harmonic loads [Hz].
    pub(crate) fn of_shaft(speed: f64, loads: &'a [f64]) -> Self {
        Self {
            frequencies: CharacteristicFrequencies { shaft: speed.abs() / TAU, ..CharacteristicFrequencies::default() },
            cage_whirl: 0.0,
            spindle_whirl: 0.0,
            uneven_inner: false,
            inner_orders: &[],
            outer_ring: OuterRing::Stands,
            uneven_raceways: false,
            odd_ball_orders: false,
            unequal_balls: false,
            loads,
        }
    }
}

/// Motion of the outer ring, as lines show it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OuterRing {
    Stands,
    Turns { is_uneven: bool },
}

impl LineSources<'_> {
    fn outer_turns(&self) -> bool {
        self.outer_ring != OuterRing::Stands
    }

    /// Returns true for the passage of the balls under the load.
    fn is_passage(&self, term: &Term) -> bool {
        if self.outer_turns() { term.name == CAGE && term.unit > 1 } else { term.name == OUTER }
    }
}

/// The strongest lines of a spectrum up to `highest` [Hz], strongest first, at most 20. A line is a local maximum above the local
/// floor, interpolated between bins. Its label is the simplest combination of the bearing's frequencies within half a bin plus 0.02 %, and
/// within the uncertainty of its place, or the whirl of cage or spindle.
pub(crate) fn find_lines(spectrum: &Spectrum, sources: &LineSources<'_>, highest: f64) -> Vec<Line> {
    let mut lines: Vec<Line> = line_bins(spectrum, highest)
        // Interpolation raises a line by at most 18 %; a few more are kept until their order is known.
        .take(2 * MAX_LINES)
        .map(|bin| {
            let (frequency, amplitude) = interpolated_peak(spectrum, bin);
            let place = Place { frequency, spread: spread_of_place(spectrum, bin) };
            let (label, deviation) = label(place, sources, spectrum.resolution);
            Line { frequency, amplitude, label, deviation }
        })
        .collect();
    lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    lines.truncate(MAX_LINES);
    lines
}

/// Bins of the lines of a spectrum up to `highest` [Hz], strongest first: local maxima above the local floor and within 60 dB of the strongest.
fn line_bins(spectrum: &Spectrum, highest: f64) -> impl Iterator<Item = usize> {
    let amplitude = &spectrum.amplitude;
    let maxima = local_maxima(spectrum, highest);
    let strongest = maxima.iter().find(|&&bin| stands_out(amplitude, bin)).map_or(0.0, |&bin| amplitude[bin]);
    // Most maxima are too weak. Their floors would take longer than all lines.
    let strong = maxima.into_iter().take_while(move |&bin| amplitude[bin] > LEAST_SHARE * strongest);
    strong.filter(|&bin| stands_out(amplitude, bin))
}

/// Bins of all local maxima above the local floor up to `highest` [Hz], strongest first.
pub(crate) fn peak_bins(spectrum: &Spectrum, highest: f64) -> Vec<usize> {
    let mut bins = local_maxima(spectrum, highest);
    bins.retain(|&bin| stands_out(&spectrum.amplitude, bin));
    bins
}

/// Bins of all local maxima up to `highest` [Hz], strongest first.
fn local_maxima(spectrum: &Spectrum, highest: f64) -> Vec<usize> {
    let amplitude = &spectrum.amplitude;
    // The bins at 0 and 1 hold slow drift, and the last ones have no neighbours.
    let end = amplitude.len().saturating_sub(LOBE);
    let mut bins: Vec<usize> = (LOBE..end)
        .take_while(|&bin| bin as f64 * spectrum.resolution <= highest)
        .filter(|&bin| is_local_maximum(amplitude, bin))
        .collect();
    bins.sort_by(|&a, &b| amplitude[b].total_cmp(&amplitude[a]));
    bins
}

/// Returns true for an entry far above the local floor.
fn stands_out(amplitude: &[f64], bin: usize) -> bool {
    amplitude[bin] > FLOOR_FACTOR * floor(amplitude, bin)
}

fn is_local_maximum(amplitude: &[f64], bin: usize) -> bool {
    let at = amplitude[bin];
    // The first of two equal neighbours is the maximum.
    (1..=LOBE).all(|d| at > amplitude[bin - d] && at >= amplitude[bin + d])
}

/// Median of the entries around a bin, without its main lobe and without other lines. In a comb of lines, a median of all entries would
/// be one of the lines.
pub(crate) fn floor(amplitude: &[f64], bin: usize) -> f64 {
    let from = bin.saturating_sub(FLOOR_REACH);
    let to = (bin + FLOOR_REACH + 1).min(amplitude.len());
    let mut around: Vec<f64> = (from..to).filter(|other| other.abs_diff(bin) > LOBE).map(|i| amplitude[i]).collect();
    around.sort_by(f64::total_cmp);
    let mut rest = around.as_slice();
    while let Some(&median) = rest.get(rest.len() / 2) {
        let noise = rest.partition_point(|&entry| entry <= FLOOR_FACTOR * median);
        if noise == rest.len() {
            return median;
        }
        rest = &rest[..noise];
    }
    0.0
}

/// One term `order · name` of a combination.
#[derive(Debug, Clone, Copy)]
struct Term {
    name: &'static str,
    frequency: f64,
    /// Cost of the first order.
    weight: f64,
    order: i32,
    /// Order of the name in the first order of the term.
    unit: i32,
    /// A surface of the scene drives it.
    driven: bool,
}

impl Term {
    fn times(self, order: i32) -> Self {
        Self { order, ..self }
    }

    fn driven(self, driven: bool) -> Self {
        Self { driven, ..self }
    }

    /// Grows slowly with the order, so that a high harmonic is simpler than a sideband of sidebands.
    fn complexity(&self) -> f64 {
        if self.order == 0 { 0.0 } else { self.weight * (1.0 + f64::from(self.order.abs()).ln()) }
    }

    fn cost(&self) -> f64 {
        let share = if self.driven { DRIVEN_SHARE } else { 1.0 };
        share * self.complexity()
    }
}

/// Place of a line.
#[derive(Debug, Clone, Copy)]
struct Place {
    frequency: f64,
    /// Uncertainty of the frequency [Hz].
    spread: f64,
}

/// The simplest combination near a frequency and the deviation from it; an empty label and 0 without one.
fn label(Place { frequency, spread }: Place, sources: &LineSources<'_>, resolution: f64) -> (String, f64) {
    let of_bins = TOLERANCE_BINS * resolution;
    let largest = of_bins + TOLERANCE_SHARE * frequency;
    let mut best: Option<(f64, [Term; 3], f64)> = None;
    for combination in combinations(frequency, sources, largest) {
        let deviation = frequency - combination.iter().map(|term| f64::from(term.order) * term.frequency).sum::<f64>();
        let complexity: f64 = combination.iter().map(Term::complexity).sum();
        let terms = combination.iter().filter(|term| term.order != 0).count();
        // A carrier of any order may have one plain sideband, if that fits well, and any driven ones.
        let sides: f64 = combination[1..].iter().map(Term::complexity).sum();
        let are_driven = combination[1..].iter().all(|term| term.order == 0 || term.driven);
        let of_slip = TOLERANCE_SHARE * frequency.min(slipping(&combination));
        let tolerance = of_bins + of_slip;
        // Whirl has only a mean rate.
        let is_whirl = [CAGE_WHIRL, SPINDLE_WHIRL].contains(&combination[0].name);
        let of_place = LEAST_BINS * resolution + spread + of_slip;
        let widest = if is_whirl { tolerance } else { tolerance.min(of_place) };
        let is_near = |share: f64| deviation.abs() <= share * tolerance;
        let plain = sides <= PLAIN_SIDEBAND && is_near(GOOD_FIT) || are_driven && is_near(DRIVEN_FIT);
        if deviation.abs() > widest || (terms > 1 && complexity > LARGEST_COMPLEXITY && !plain) {
            continue;
        }
        let cost = combination.iter().map(Term::cost).sum::<f64>() + DEVIATION_COST * deviation.abs() / tolerance;
        if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
            best = Some((cost, combination, deviation));
        }
    }
    best.map_or_else(Default::default, |(_, combination, deviation)| (written(&combination), deviation))
}

/// Frequencies of the terms that turn with the cage, without signs [Hz].
fn slipping(combination: &[Term; 3]) -> f64 {
    let slips = |term: &&Term| ![SHAFT, OUTER_RING, LOAD].contains(&term.name);
    combination.iter().filter(slips).map(|term| f64::from(term.order.abs()) * term.frequency).sum()
}

/// Combinations with a physical cause that come near the frequency. Each source has sidebands of the motions that its line comes from:
/// - Harmonics of the shaft and of the ball passage under the load have those of shaft, passage and cage.
/// - The ball passage of an outer raceway that turns has those of its ring, and that of the inner raceway those of the shaft.
/// - Orders of given waves of the inner raceway have those of the ball passage under the load.
/// - Even orders of a ball's spin, and odd ones where it has them, have those of the cage.
/// - The ball passage under the load has those of harmonic loads, which also stand alone.
/// - Whirl of cage and spindle has none, because it follows from their motion.
fn combinations(frequency: f64, sources: &LineSources<'_>, tolerance: f64) -> Vec<[Term; 3]> {
    let term = |name, frequency, weight| Term { name, frequency, weight, order: 0, unit: 1, driven: false };
    let all = &sources.frequencies;
    let shaft = term(SHAFT, all.shaft, 1.0);
    let outer = term(OUTER, all.ball_pass_outer, 1.0);
    let ring = term(OUTER_RING, all.outer_ring, 1.0);
    let outer_turns = sources.outer_turns();
    // Balls pass under the load at this rate, which is a multiple of the cage's.
    let balls = (all.ball_pass / all.cage).round();
    let passage = match outer_turns {
        true => Term { unit: balls as i32, ..term(CAGE, all.ball_pass, 1.0) },
        false => outer,
    };
    let inner = term(INNER, all.ball_pass_inner, 1.1);
    // The cage carries uneven balls through the load.
    let any_ball = term(BALL, all.ball_spin, 1.3).driven(true);
    let cage = term(CAGE, all.cage, 1.6).driven(sources.unequal_balls);
    let cage_of_ball = cage.driven(true);
    // A ball meets both raceways in a turn.
    let ball = Term { unit: 2, frequency: 2.0 * all.ball_spin, ..any_ball };
    let usable = |term: &Term| term.frequency >= SEPARATION * tolerance;
    let side = |term: &Term, reach: i32| if usable(term) { -reach..=reach } else { 0..=0 };

    let mut found = Vec::new();
    if usable(&passage) && usable(&shaft) {
        let waves = sources.inner_orders.iter().flat_map(|order| WAVE_HARMONICS.map(move |harmonic| harmonic * order));
        found.extend(waves.map(|order| {
            let passages = ((frequency - f64::from(order) * shaft.frequency) / passage.frequency).round();
            [passage.driven(true).times(passages as i32), shaft.driven(true).times(order), cage]
        }));
    }
    // A carrier's order follows from the frequency once the sidebands are chosen.
    let mut carry = |carrier: Term, sides: [Term; 2]| {
        let rest = frequency - sides.iter().map(|term| f64::from(term.order) * term.frequency).sum::<f64>();
        let order = (rest / carrier.frequency).round();
        let highest = match carrier.name {
            // From the number of balls on, its harmonics are passages with sidebands.
            CAGE if carrier.unit == 1 => HIGHEST_CAGE_ORDER.min(balls - 1.0),
            LOAD => f64::from(HIGHEST_LOAD_ORDER),
            _ => HIGHEST_ORDER,
        };
        if usable(&carrier) && (1.0..=highest).contains(&order) {
            found.push([carrier.times(order as i32), sides[0], sides[1]]);
        }
    };
    // Unequal balls drive every multiple of the cage speed.
    let half_passage = (0.5 * all.ball_pass / all.cage) as i32;
    let of_cage = if sources.unequal_balls { CAGE_SIDEBANDS.max(half_passage) } else { CAGE_SIDEBANDS };
    for k in side(&cage, of_cage) {
        let cage = cage.times(k);
        for n in side(&shaft, SHAFT_SIDEBANDS) {
            carry(passage, [shaft.times(n), cage]);
        }
        for m in side(&passage, OUTER_SIDEBANDS) {
            carry(shaft, [passage.times(m), cage]);
        }
    }
    for k in side(&cage, balls as i32) {
        carry(ball, [shaft, cage_of_ball.times(k)]);
        if sources.odd_ball_orders {
            carry(any_ball, [shaft, cage_of_ball.times(k)]);
        }
    }
    // The load zone has as many harmonics as there are balls; those beyond belong to the next passage.
    let of_shaft = if sources.uneven_inner { SHAFT_SIDEBANDS.max(balls as i32) } else { SHAFT_SIDEBANDS };
    for n in side(&shaft, of_shaft) {
        carry(inner, [shaft.driven(sources.uneven_inner).times(n), cage]);
    }
    if outer_turns {
        let is_uneven = sources.outer_ring == OuterRing::Turns { is_uneven: true };
        let of_ring = if is_uneven { SHAFT_SIDEBANDS.max(balls as i32 - 1) } else { SHAFT_SIDEBANDS };
        for n in side(&ring, of_ring) {
            carry(outer, [ring.driven(is_uneven).times(n), cage]);
        }
        carry(ring, [shaft, cage]);
    }
    carry(cage, [shaft, outer]);
    for load in sources.loads.iter().map(|&frequency| term(LOAD, frequency, LOAD_WEIGHT)) {
        carry(load, [shaft, cage]);
        for k in side(&load, HIGHEST_LOAD_ORDER).filter(|k| *k != 0) {
            carry(passage, [load.driven(true).times(k), cage]);
        }
    }
    // A whirling cage drives the spindle round at its own rate, so it has precedence.
    let whirls = [term(CAGE_WHIRL, sources.cage_whirl, 1.6), term(SPINDLE_WHIRL, sources.spindle_whirl, 1.6)];
    // Unequal balls drive the spindle round at multiples of the cage speed.
    let is_driven = |whirl: &Term| {
        let order = (frequency / cage.frequency).round();
        sources.unequal_balls
            && usable(&cage)
            && order <= HIGHEST_CAGE_ORDER
            && (whirl.frequency - order * cage.frequency).abs() <= tolerance
    };
    // So do uneven balls, and uneven raceways at any combination of shaft and ball passages.
    let at = |of: &[Term; 3]| of.iter().map(|term| f64::from(term.order) * term.frequency).sum::<f64>();
    let is_of_surface = |of: &[Term; 3]| {
        let is_of_raceway = |term: &Term| term.name != CAGE || term.order == 0 || sources.is_passage(term);
        let of_raceway = sources.uneven_raceways && of.iter().all(is_of_raceway);
        (of[0].name == BALL || of_raceway) && (frequency - at(of)).abs() <= GOOD_FIT * tolerance
    };
    let surfaces_drive = found.iter().any(is_of_surface);
    let near = |whirl: &Term| {
        let is_near = usable(whirl) && (frequency - whirl.frequency).abs() <= tolerance;
        // Passing balls move spindle and cage round at their own rate.
        let is_passage = (whirl.frequency - passage.frequency).abs() <= tolerance;
        let of_surfaces = surfaces_drive && whirl.name == SPINDLE_WHIRL;
        is_near && !(is_passage || of_surfaces || is_driven(whirl))
    };
    found.extend(whirls.into_iter().find(near).map(|whirl| [whirl.times(1), shaft, cage]));
    found
}

/// The terms that are there, those added before those taken away: `2·BPFO + f_r − FTF`.
fn written(combination: &[Term; 3]) -> String {
    let mut text = String::new();
    let there = |sign: i32| combination.iter().filter(move |term| term.order.signum() == sign);
    for term in there(1).chain(there(-1)) {
        text += match (text.is_empty(), term.order > 0) {
            (true, true) => "",
            (true, false) => "−",
            (false, true) => " + ",
            (false, false) => " − ",
        };
        let order = term.order.abs() * term.unit;
        if order > 1 {
            text += &format!("{order}·");
        }
        text += term.name;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::SplitMix64;
    use crate::numerics::spectrum::amplitude_spectrum;

    const RATE: f64 = 102_400.0;

    /// Label of a line whose place is uncertain.
    fn placed(frequency: f64, sources: &LineSources<'_>, resolution: f64) -> (String, f64) {
        label(Place { frequency, spread: resolution }, sources, resolution)
    }

    /// The bearing of the article with seven balls at 50 000 r/min.
    fn seven_balls() -> CharacteristicFrequencies {
        let (shaft, cage) = (833.333, 327.634);
        CharacteristicFrequencies {
            shaft,
            cage,
            outer_ring: 0.0,
            ball_pass: 7.0 * cage,
            ball_pass_outer: 7.0 * cage,
            ball_pass_inner: 7.0 * (shaft - cage),
            ball_spin: 1860.8,
        }
    }

    fn without_whirl(frequencies: CharacteristicFrequencies) -> LineSources<'static> {
        LineSources { frequencies, ..LineSources::of_shaft(0.0, &[]) }
    }

    fn labelled(frequency: f64) -> String {
        placed(frequency, &without_whirl(seven_balls()), 10.0).0
    }

    /// A load has precedence over the order of the shaft at its frequency, and sidebands beside the ball passage.
    #[test]
    fn a_harmonic_load_names_its_lines() {
        let f = seven_balls();
        let loads = [1666.666, 432.1];
        let loaded = LineSources { loads: &loads, ..without_whirl(f) };
        let of = |frequency: f64| placed(frequency, &loaded, 1.0).0;
        assert_eq!([of(1666.666), of(864.2), of(833.333)], ["load", "2·load", "f_r"]);
        assert_eq!(of(f.ball_pass_outer - 432.1), "BPFO − load");
        assert_eq!(of(2.0 * f.ball_pass_outer + 5.0 * 432.1), "2·BPFO + 5·load");
        assert_eq!(of(f.ball_pass_outer), "BPFO");
    }

    /// Tones (frequency, amplitude) over 0.1 s in Gaussian-like noise of the given rms.
    fn spectrum_of(tones: &[(f64, f64)], noise: f64) -> Spectrum {
        let mut seed = 0x2545_f491_4f6c_dd1d_u64;
        let mut uniform = || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let signal: Vec<f64> = (0..10_240)
            .map(|i| {
                let time = i as f64 / RATE;
                let tones: f64 = tones.iter().map(|(f, a)| a * (std::f64::consts::TAU * f * time + f).sin()).sum();
                tones + noise * (0..12).map(|_| uniform()).sum::<f64>()
            })
            .collect();
        amplitude_spectrum(&signal, RATE)
    }

    #[test]
    fn simplest_combination_gives_the_label() {
        for (frequency, label) in [
            (2293.0, "BPFO"),
            (4587.0, "2·BPFO"),
            (6880.0, "3·BPFO"),
            (18347.0, "8·BPFO"),
            (833.3, "f_r"),
            (1666.7, "2·f_r"),
            (16666.7, "20·f_r"),
            (3126.7, "BPFO + f_r"),
            (1460.0, "BPFO − f_r"),
            (3960.0, "BPFO + 2·f_r"),
            (3540.0, "BPFI"),
            (7080.0, "2·BPFI"),
            (4373.2, "BPFI + f_r"),
            (2706.6, "BPFI − f_r"),
            (327.6, "FTF"),
            (655.3, "2·FTF"),
            (2621.1, "BPFO + FTF"),
            (505.7, "f_r − FTF"),
            (3721.6, "2·BSF"),
            (7443.2, "4·BSF"),
            (4049.2, "2·BSF + FTF"),
            (5833.3, "7·f_r"),
        ] {
            assert_eq!(labelled(frequency), label, "{frequency} Hz");
        }
    }

    #[test]
    fn of_two_simple_labels_the_one_that_is_met_is_given() {
        // Eight balls of 15.081 mm on 65 mm at 3000 r/min, seen in bins of 9 Hz: 5·BPFI lies 0.2 Hz beside 8·BPFO.
        let (shaft, passage) = (50.0, 153.829_9);
        let frequencies = CharacteristicFrequencies {
            shaft,
            cage: passage / 8.0,
            outer_ring: 0.0,
            ball_pass: passage,
            ball_pass_outer: passage,
            ball_pass_inner: 8.0 * shaft - passage,
            ball_spin: 0.0,
        };
        assert_eq!(placed(1230.6387, &without_whirl(frequencies), 9.0).0, "8·BPFO");
        assert_eq!(placed(1230.85, &without_whirl(frequencies), 9.0).0, "5·BPFI");
    }

    /// A steady tone 0.3 bins beside 4·BSF is not labelled by it; a line whose frequency wanders by as much is.
    #[test]
    fn no_label_by_chance() {
        let f = CharacteristicFrequencies { ball_spin: 200.225, ..seven_balls() };
        let sources = without_whirl(f);
        let beside = 4.0 * f.ball_spin + 3.0;
        let of = |spread: f64| label(Place { frequency: beside, spread }, &sources, 10.0).0;
        assert_eq!([of(0.0), of(0.5), of(3.0)], ["", "", "4·BSF"]);
        let steady = find_lines(&spectrum_of(&[(beside, 1.0)], 0.0), &sources, 5000.0);
        assert!((steady[0].frequency - beside).abs() < 0.05 && steady[0].label.is_empty(), "{steady:?}");
        let wandering = find_lines(&spectrum_of(&[(beside, 1.0), (beside - 5.0, 0.8)], 0.0), &sources, 5000.0);
        assert_eq!(wandering[0].label, "4·BSF", "{wandering:?}");
    }

    #[test]
    fn frequency_near_no_combination_has_no_label() {
        let (label, deviation) = placed(2400.0, &without_whirl(seven_balls()), 10.0);
        assert_eq!((label.as_str(), deviation), ("", 0.0));
    }

    /// A hybrid bearing at 20 000 r/min: the cage whirls at 13.70 times its speed.
    #[test]
    fn whirl_gives_a_label_where_no_simpler_combination_does() {
        let (shaft, cage) = (333.333, 143.2);
        let frequencies = CharacteristicFrequencies {
            shaft,
            cage,
            outer_ring: 0.0,
            ball_pass: 17.0 * cage,
            ball_pass_outer: 17.0 * cage,
            ball_pass_inner: 17.0 * (shaft - cage),
            ball_spin: 0.0,
        };
        let whirling = LineSources { cage_whirl: 13.7 * cage, spindle_whirl: 900.0, ..without_whirl(frequencies) };
        assert_eq!(placed(1962.0, &whirling, 10.0).0, "cage whirl");
        assert_eq!(placed(901.0, &whirling, 10.0).0, "spindle whirl");
        let driven = LineSources { spindle_whirl: 1962.0, ..whirling };
        assert_eq!(placed(1962.0, &driven, 10.0).0, "cage whirl");
        let together = LineSources { cage_whirl: 17.0 * cage, ..whirling };
        assert_eq!(placed(17.0 * cage, &together, 10.0).0, "BPFO", "the ball passage makes this orbit");
    }

    /// Without the defect, a sideband of second order beside a high harmonic has no label.
    #[test]
    fn an_inner_defect_has_sidebands_of_the_shaft() {
        let f = seven_balls();
        let defect = LineSources { uneven_inner: true, ..without_whirl(f) };
        for (q, n, text) in [(6.0, -2.0, "6·BPFI − 2·f_r"), (5.0, 3.0, "5·BPFI + 3·f_r")] {
            let frequency = q * f.ball_pass_inner + n * f.shaft;
            assert_eq!(placed(frequency, &defect, 1.0).0, text);
            assert_ne!(placed(frequency, &without_whirl(f), 1.0).0, text);
        }
        assert_eq!(placed(6.0 * f.ball_pass_inner - 2.0 * f.shaft + 6.0, &defect, 1.0).0, "");
        // A tenth of a bin beside the formula, as in a run of 0.4 s.
        let motor = CharacteristicFrequencies {
            shaft: 29.95,
            cage: 11.938,
            outer_ring: 0.0,
            ball_pass: 107.442,
            ball_pass_outer: 107.442,
            ball_pass_inner: 162.108,
            ball_spin: 70.509,
        };
        let defect = LineSources { frequencies: motor, ..defect };
        assert_eq!(placed(11.0 * 162.108 - 29.95 + 0.24, &defect, 2.5).0, "11·BPFI − f_r");
    }

    /// Lines of a 6205 at 1797 r/min under 500 N, which simpler combinations nearly meet. An outer ring without defect has no line 0.4 bins
    /// beside its ball passage.
    #[test]
    fn the_cause_that_fits_is_named() {
        let motor = CharacteristicFrequencies {
            shaft: 29.95,
            outer_ring: 0.0,
            cage: 11.937_41,
            ball_pass: 107.436_67,
            ball_pass_outer: 107.436_67,
            ball_pass_inner: 162.113_33,
            ball_spin: 0.0,
        };
        let ideal = without_whirl(motor);
        let spall = LineSources { uneven_inner: true, ..ideal };
        let of = |sources: &LineSources<'_>, frequency: f64| placed(frequency, sources, 1.0).0;
        assert_eq!(of(&spall, 1074.867), "7·BPFI − 2·f_r");
        assert_eq!(of(&spall, 1182.286), "6·BPFI + 7·f_r");
        assert_eq!(of(&spall, 12.30), "BPFI − 5·f_r");
        assert_eq!(of(&ideal, 1074.367), "10·BPFO");
        let balls = LineSources { unequal_balls: true, ..ideal };
        assert_eq!(of(&balls, 59.686), "5·FTF");
        assert_eq!(of(&balls, 167.126), "2·BPFO − 4·FTF");
        assert_eq!(of(&balls, 59.9), "2·f_r");
        let wave = LineSources { inner_orders: &[64], ..spall };
        assert_eq!(of(&wave, 1057.3), "64·f_r − 8·BPFO");
        assert_eq!(of(&wave, 1164.737), "7·BPFI + f_r");
        assert_eq!(of(&wave, 90.361), "64·f_r − 17·BPFO");
        assert_eq!(of(&wave, 2007.161), "128·f_r − 17·BPFO");
    }

    /// Waves of orders next to a multiple of the number of balls move the spindle round in a circle, and ovality nearly does under a light load.
    #[test]
    fn waves_of_raceways_drive_the_spindle_round() {
        let f = seven_balls();
        for (text, frequency) in [
            ("2·BPFO", 2.0 * f.ball_pass_outer),
            ("BPFI + f_r", f.ball_pass_inner + f.shaft),
            ("2·BPFI − f_r", 2.0 * f.ball_pass_inner - f.shaft),
            ("2·f_r", 2.0 * f.shaft),
        ] {
            let ideal = LineSources { spindle_whirl: frequency, ..without_whirl(f) };
            assert_eq!(placed(frequency, &ideal, 1.0).0, "spindle whirl");
            assert_eq!(placed(frequency, &LineSources { uneven_raceways: true, ..ideal }, 1.0).0, text);
        }
    }

    /// Waves alike on all balls have even orders, a defect of one ball all of them.
    #[test]
    fn an_uneven_ball_has_sidebands_of_the_cage() {
        let f = seven_balls();
        let even = without_whirl(f);
        let all = LineSources { odd_ball_orders: true, ..even };
        for (n, k, text) in [(2.0, -1.0, "2·BSF − FTF"), (6.0, 2.0, "6·BSF + 2·FTF"), (10.0, -1.0, "10·BSF − FTF")]
        {
            let frequency = n * f.ball_spin + k * f.cage;
            assert_eq!(placed(frequency, &even, 1.0).0, text);
            assert_eq!(placed(frequency, &all, 1.0).0, text);
            let whirling = LineSources { spindle_whirl: frequency + 0.2, ..even };
            assert_eq!(placed(frequency, &whirling, 1.0).0, text, "the ball drives the spindle round");
        }
        let odd = 3.0 * f.ball_spin + f.cage;
        assert_eq!(placed(odd, &all, 1.0).0, "3·BSF + FTF");
        assert_ne!(placed(odd, &even, 1.0).0, "3·BSF + FTF");
    }

    /// Without unequal balls, a sideband of the cage beside a high harmonic has no label.
    #[test]
    fn unequal_balls_have_sidebands_of_the_cage() {
        let f = seven_balls();
        let unequal = LineSources { unequal_balls: true, ..without_whirl(f) };
        for (q, n, text) in [(6.0, -2.0, "6·BPFO − 2·FTF"), (7.0, 1.0, "7·BPFO + FTF")] {
            let frequency = q * f.ball_pass_outer + n * f.cage;
            assert_eq!(placed(frequency, &unequal, 1.0).0, text);
            assert_ne!(placed(frequency, &without_whirl(f), 1.0).0, text);
        }
        for (order, text) in [(1.0, "FTF"), (2.0, "2·FTF"), (3.0, "3·FTF"), (8.0, "BPFO + FTF")] {
            assert_eq!(placed(order * f.cage, &unequal, 1.0).0, text);
            let whirling = LineSources { spindle_whirl: order * f.cage, ..unequal };
            assert_eq!(placed(order * f.cage, &whirling, 1.0).0, text, "the balls drive the spindle round");
        }
    }

    #[test]
    fn few_frequencies_get_a_label_by_chance() {
        let by_chance = (0..2000).filter(|i| !labelled(10.0 * f64::from(*i) + 5.0).is_empty()).count();
        assert!(by_chance < 400, "{by_chance} of 2000");
    }

    /// Ringing at 3199.9 Hz beside a cage of 82.03 Hz and twelve balls.
    #[test]
    fn no_high_harmonic_of_the_cage_stands_for_ringing() {
        let of_twelve = CharacteristicFrequencies {
            shaft: 0.0,
            cage: 82.034,
            outer_ring: 0.0,
            ball_pass: 984.41,
            ball_pass_outer: 984.41,
            ball_pass_inner: 1415.6,
            ball_spin: 0.0,
        };
        assert_eq!(placed(3199.9, &without_whirl(of_twelve), 25.0).0, "");
        assert_eq!(placed(164.07, &without_whirl(of_twelve), 2.0).0, "2·FTF");
    }

    #[test]
    fn combs_closer_than_the_resolution_label_nothing() {
        // A cage at 12 Hz seen with bins of 10 Hz.
        let slow = CharacteristicFrequencies {
            shaft: 30.0,
            cage: 12.0,
            outer_ring: 0.0,
            ball_pass: 108.0,
            ball_pass_outer: 108.0,
            ball_pass_inner: 162.0,
            ball_spin: 70.0,
        };
        assert_eq!(placed(108.0, &without_whirl(slow), 10.0).0, "BPFO");
        assert_eq!(placed(120.0, &without_whirl(slow), 10.0).0, "");
        let standing = CharacteristicFrequencies {
            shaft: 0.0,
            cage: 0.0,
            outer_ring: 0.0,
            ball_pass: 0.0,
            ball_pass_outer: 0.0,
            ball_pass_inner: 0.0,
            ball_spin: 0.0,
        };
        assert_eq!(placed(120.0, &without_whirl(standing), 10.0), (String::new(), 0.0));
    }

    #[test]
    fn two_tones_off_bin_in_noise_are_the_two_strongest_lines() {
        let bpfo = seven_balls().ball_pass_outer;
        let lines =
            find_lines(&spectrum_of(&[(bpfo, 2.0), (2.0 * bpfo, 0.5)], 0.05), &without_whirl(seven_balls()), 20_000.0);
        assert_eq!(lines[0].label, "BPFO");
        assert_eq!(lines[1].label, "2·BPFO");
        assert!((lines[0].amplitude / 2.0 - 1.0).abs() < 0.01 && (lines[1].amplitude / 0.5 - 1.0).abs() < 0.02);
        assert!((lines[0].frequency - bpfo).abs() < 0.2 && lines[0].deviation.abs() < 0.2);
        assert!(lines.iter().all(|line| line.label != "f_r"), "no line where nothing turns unbalanced");
        assert!(lines.len() <= 4, "noise makes hardly any line: {lines:?}");
        assert!(lines.windows(2).all(|pair| pair[0].amplitude >= pair[1].amplitude));
    }

    #[test]
    fn leakage_of_a_pure_tone_makes_no_second_line() {
        let lines = find_lines(&spectrum_of(&[(2293.44, 1.0)], 0.0), &without_whirl(seven_balls()), 20_000.0);
        assert_eq!(lines.len(), 1);
    }

    /// Lines 8.3 bins apart, whose amplitudes differ by up to 40 dB: skirts of strong ones neither hide weak ones nor make lines.
    #[test]
    fn all_lines_of_a_dense_comb_are_found() {
        let golden = 0.618_034;
        let tones: Vec<(f64, f64)> =
            (1..=200).map(f64::from).map(|n| (83.0 * n, 10_f64.powf(-2.0 * (golden * n).fract()))).collect();
        let spectrum = spectrum_of(&tones, 1e-5);
        let mut bins = peak_bins(&spectrum, 16_650.0);
        bins.sort_unstable();
        let expected: Vec<usize> = tones.iter().map(|(frequency, _)| (frequency / 10.0).round() as usize).collect();
        assert_eq!(bins.len(), expected.len(), "{bins:?}");
        assert!(bins.iter().zip(&expected).all(|(bin, line)| bin.abs_diff(*line) <= 1), "{bins:?}");
    }

    /// 84 of 600 000 bins in another simulation.
    #[test]
    fn noise_makes_a_line_in_one_bin_of_7000() {
        let mut random = SplitMix64::new(3);
        let mut normal = || (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
        let noise: Vec<f64> = (0..1 << 20).map(|_| normal()).collect();
        let lines = peak_bins(&amplitude_spectrum(&noise, RATE), RATE).len();
        // 73 expected of 524 288 bins; their scatter is 9.
        assert!((45..=105).contains(&lines), "{lines}");
    }

    /// Lines and their skirts fill more than half of the entries: the median is a skirt, the floor is not.
    #[test]
    fn lines_of_a_comb_are_not_its_floor() {
        let mut amplitude = vec![0.1; 200];
        for (entry, amplitude) in amplitude.iter_mut().enumerate() {
            match entry % 20 {
                0 | 2 | 4 | 6 | 8 | 10 | 12 | 14 | 16 => *amplitude = 5.0,
                1 | 3 | 5 => *amplitude = 1.0,
                _ => (),
            }
        }
        assert_eq!(floor(&amplitude, 100), 0.1);
    }

    #[test]
    fn lines_above_the_highest_frequency_are_not_listed() {
        let spectrum = spectrum_of(&[(2293.44, 1.0), (25_000.0, 5.0)], 0.0);
        let lines = find_lines(&spectrum, &without_whirl(seven_balls()), 20_000.0);
        assert!(lines.iter().all(|line| line.frequency < 20_000.0));
        assert_eq!(lines[0].label, "BPFO");
    }

    #[test]
    fn many_tones_give_at_most_twenty_lines() {
        let tones: Vec<(f64, f64)> = (1..50).map(|i| (397.0 * f64::from(i), 1.0 / f64::from(i))).collect();
        assert_eq!(find_lines(&spectrum_of(&tones, 0.0), &without_whirl(seven_balls()), 20_000.0).len(), MAX_LINES);
    }

    #[test]
    fn silent_and_short_spectra_have_no_lines() {
        for entries in [0, 1, 2, 3, 5, 100] {
            let spectrum = Spectrum { resolution: 10.0, amplitude: vec![0.0; entries], window: "hann", averages: 1 };
            assert!(find_lines(&spectrum, &without_whirl(seven_balls()), 20_000.0).is_empty());
        }
    }
}
