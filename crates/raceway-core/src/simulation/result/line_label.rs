//! The label of a line: the simplest combination of frequencies of the scene at its place.

use super::line_combinations::{GOOD_FIT, combinations};
use super::line_sources::{CAGE_WHIRL, LOAD, LineSources, OUTER_RING, SHAFT, SPINDLE_WHIRL, Term};

/// A label may be off by this many bins …
pub(super) const TOLERANCE_BINS: f64 = 0.5;
/// … plus this share of the terms that turn with the cage, the uncertainty of the mean slip of a run. The shaft does not slip.
pub(super) const TOLERANCE_SHARE: f64 = 2e-4;
/// A label is never off by more than the place of its line is uncertain, so that few are taken by chance. Steady strong lines deviate by less than a
/// hundredth of a bin; neighbours move weak ones by up to this many bins.
pub(crate) const LEAST_BINS: f64 = 0.1;
/// Largest complexity of a label with more than one term.
const LARGEST_COMPLEXITY: f64 = 4.2;
/// Complexity of a sideband of the first order of shaft or outer ball passage.
const PLAIN_SIDEBAND: f64 = 1.0;
/// Share of the tolerance within which driven lines fit well. Loads and speeds vary while balls meet a defect, which moves its lines. Those of an
/// inner spall of 0.6 mm moved by up to 0.15 bins (6205, 500 N, 0.4 s).
const DRIVEN_FIT: f64 = 0.5;
/// Cost of a deviation at the edge of the tolerance, so that an exact sideband beats a simpler label that deviates. Lines of steady motions
/// deviate by less than a hundredth of a bin. Of 11 scenes of a 6205, labels that named no cause of the scene were off by a fifth of a bin or more.
const DEVIATION_COST: f64 = 6.0;

/// Place of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub frequency: f64,
    /// Uncertainty of the frequency [Hz].
    pub spread: f64,
}

/// The simplest combination near a frequency and the deviation from it; an empty label and 0 without one.
pub(super) fn label(Place { frequency, spread }: Place, sources: &LineSources<'_>, resolution: f64) -> (String, f64) {
    let of_bins = TOLERANCE_BINS * resolution;
    let largest = of_bins + TOLERANCE_SHARE * frequency;
    let mut best: Option<(f64, [Term; 3], f64)> = None;
    for combination in combinations(frequency, sources, largest) {
        let deviation = frequency - combination.iter().map(Term::at).sum::<f64>();
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
    combination.iter().filter(slips).map(|term| term.at().abs()).sum()
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
    use super::super::line_examples::{seven_balls, without_whirl};
    use super::*;
    use crate::physics::kinematics::CharacteristicFrequencies;

    /// Label of a line whose place is uncertain.
    fn placed(frequency: f64, sources: &LineSources<'_>, resolution: f64) -> (String, f64) {
        label(Place { frequency, spread: resolution }, sources, resolution)
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
}
