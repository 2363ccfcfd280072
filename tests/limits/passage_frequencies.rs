//! A rigid spindle on ideal circles vibrates as the balls pass, and with its unbalance, and in no other way.

use crate::article_run::{Y, Z, balanced, line, lines, unbalanced};

/// Ball passage of the outer raceway at ideal rolling [Hz].
const PASSAGE: f64 = 2293.4;
const SHAFT: f64 = 50_000.0 / 60.0;

/// Varying compliance: the strongest line along Z is the ball passage, within 1 % of its frequency at ideal rolling
/// (the cage lags by its slip), and the other lines of both directions are its harmonics.
#[test]
fn ball_passage_rules_where_nothing_is_unbalanced() {
    let run = balanced();
    let strongest = lines(run, Z)[0];
    assert_eq!(strongest.label, "BPFO");
    assert!((strongest.frequency / PASSAGE - 1.0).abs() < 0.01);
    for channel in [Y, Z] {
        let found = lines(run, channel);
        let strongest = found[0].amplitude;
        for order in ["BPFO", "2·BPFO", "3·BPFO"] {
            let line = line(run, channel, order).unwrap_or_else(|| panic!("no {order} along {channel}"));
            let times = order.chars().next().and_then(|digit| digit.to_digit(10)).unwrap_or(1);
            assert!((line.frequency / (f64::from(times) * PASSAGE) - 1.0).abs() < 0.01, "{line:?}");
        }
        // Whatever stands out by more than a hundredth of the strongest line is a harmonic of the passage.
        for line in found.iter().filter(|line| line.amplitude > 0.01 * strongest) {
            let order = line.frequency / run.summary.frequencies.ball_pass_outer;
            assert!((order - order.round()).abs() < 0.01, "{channel}: {line:?}");
        }
    }
}

/// Amplitude at a frequency over the strongest one of the spectrum: the largest of the three nearest bins.
fn share_at(
    run: &raceway::simulation::result::run_result::RunResult,
    channel: raceway::simulation::input::channel::Channel,
    hz: f64,
) -> f64 {
    let spectrum = &run.spectra.iter().find(|spectra| spectra.channel == channel).unwrap().amplitude;
    let bin = (hz / spectrum.resolution).round() as usize;
    let near = spectrum.amplitude[bin - 1..=bin + 1].iter().copied().fold(0.0, f64::max);
    near / spectrum.amplitude.iter().copied().fold(0.0, f64::max)
}

/// Circles are ideal and nothing is unbalanced: nothing repeats with the shaft, so that no line stands at f_r or 2
/// f_r. What a Hann window leaks there from the passage is below a hundredth of it.
#[test]
fn no_line_at_the_shaft_frequency_without_unbalance() {
    for channel in [Y, Z] {
        for order in [1.0, 2.0] {
            let near = |l: &&raceway::simulation::result::lines::Line| (l.frequency - order * SHAFT).abs() < 60.0;
            assert_eq!(lines(balanced(), channel).into_iter().find(near), None);
            let share = share_at(balanced(), channel, order * SHAFT);
            assert!(share < 0.01, "{channel}, {order} f_r: {share}");
        }
    }
}

/// An unbalance of grade G 6.3 brings the line f_r in both directions, and on a bearing whose stiffness varies with the
/// passage its sum and difference with it.
#[test]
fn unbalance_brings_the_shaft_frequency_and_its_combinations() {
    let run = unbalanced();
    for channel in [Y, Z] {
        let shaft = line(run, channel, "f_r").unwrap_or_else(|| panic!("no f_r along {channel}"));
        assert!((shaft.frequency / SHAFT - 1.0).abs() < 0.01);
        assert!(share_at(run, channel, SHAFT) > 10.0 * share_at(balanced(), channel, SHAFT));
    }
    for label in ["BPFO + f_r", "BPFO − f_r"] {
        assert!(line(run, Z, label).is_some(), "no {label} along Z");
    }
    assert_eq!(lines(run, Z).iter().filter(|line| line.label == "BPFO").count(), 1);
}
