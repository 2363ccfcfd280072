//! Signals whose lines are known.

use std::f64::consts::TAU;

use super::lines::lines_of;
use super::partners::{PredictedLine, Shifts, partners};
use super::record::{Division, Record, Turning};
use super::tachometer::{Tachometer, middle, pulses_of};
use crate::simulation::input::settings::ENVELOPE;
use crate::simulation::recording::sampling::RATE;

const SPEED: f64 = 50.0;
const ORDERS: [f64; 3] = [1.0, 3.585, 7.17];

/// Tones at three orders of a shaft that turns at `speed` [Hz].
fn bearing(rate: f64, speed: f64, duration: f64) -> Vec<f64> {
    let at = |time: f64| ORDERS.iter().map(|order| (TAU * order * speed * time + order).sin() / order).sum();
    (0..(duration * rate) as usize).map(|k| at(k as f64 / rate)).collect()
}

fn orders(values: &[f64], rate: f64, turning: Turning) -> Vec<(f64, f64)> {
    let record = Record { values, rate, turning };
    let division = Division::of(1.0, 4, Some(ENVELOPE));
    let spectra = record.spectra(&division, &|| false).expect("a window");
    let mut found: Vec<(f64, f64)> = lines_of(&spectra.amplitude, record.highest_frequency())
        .iter()
        .map(|line| (line.frequency / record.turning.speed(), line.amplitude))
        .collect();
    found.truncate(3);
    found.sort_by(|one, other| one.0.total_cmp(&other.0));
    found
}

fn worst(found: &[(f64, f64)], shift: f64) -> (f64, f64) {
    let pairs = found.iter().zip(ORDERS);
    pairs.fold((0.0, 0.0), |(order, amplitude): (f64, f64), (line, expected)| {
        (order.max((line.0 / (shift * expected) - 1.0).abs()), amplitude.max((line.1 * expected - 1.0).abs()))
    })
}

#[test]
fn lines_have_the_orders_of_the_measured_shaft_at_any_rate() {
    for rate in [RATE, 48_828.0, 12_000.0, 200_000.0] {
        let found = orders(&bearing(rate, SPEED, 2.1), rate, Turning::Even(SPEED));
        let (order, amplitude) = worst(&found, 1.0);
        assert!(found.len() == 3 && order < 1e-4 && amplitude < 1e-3, "{rate} Hz: {found:?}");
    }
}

/// A record that runs 1 % faster: with its tachometer the orders are the same, with the nominal speed they are off by 1 %.
#[test]
fn a_tachometer_takes_a_stretched_time_back() {
    let fast = 1.01 * SPEED;
    let values = bearing(48_828.0, fast, 2.5);
    let pulses = (0..120).map(|k| 0.01 + f64::from(k) / fast).collect();
    let found = orders(&values, 48_828.0, Turning::Pulses(Tachometer::new(pulses, 1).unwrap()));
    assert!(worst(&found, 1.0).0 < 1e-4, "{found:?}");
    let found = orders(&values, 48_828.0, Turning::Even(SPEED));
    assert!(worst(&found, 1.01).0 < 1e-4, "{found:?}");
}

/// A shaft that runs up from 45 to 55 Hz in 2 s: in angle its lines do not smear.
#[test]
fn a_run_up_is_resampled_by_angle() {
    let rate = 48_828.0;
    let turns = |time: f64| 45.0 * time + 2.5 * time * time;
    let values: Vec<f64> = (0..(2.0 * rate) as usize)
        .map(|k| ORDERS.iter().map(|order| (TAU * order * turns(k as f64 / rate)).sin() / order).sum())
        .collect();
    // 45 t + 2.5 t² = n.
    let pulses = (0..=100).map(|n| (-45.0 + (2025.0 + 10.0 * f64::from(n)).sqrt()) / 5.0).collect();
    let tachometer = Tachometer::new(pulses, 1).unwrap();
    assert!((tachometer.mean_speed() - 50.0).abs() < 1e-9 && (tachometer.lowest_speed() - 45.0).abs() < 0.1);
    let record = Record { values: &values, rate, turning: Turning::Pulses(tachometer.clone()) };
    assert!((record.highest_frequency() / (0.4 * rate * 0.9) - 1.0).abs() < 2e-3);
    let found = orders(&values, rate, Turning::Pulses(tachometer));
    let (order, amplitude) = worst(&found, 1.0);
    assert!(order < 1e-4 && amplitude < 2e-3, "{found:?}");
    let plain = orders(&values, rate, Turning::Even(50.0));
    assert!(plain.iter().all(|line| line.1 < 0.9), "without it they do: {plain:?}");
}

#[test]
fn windows_are_those_of_the_prediction() {
    let values = bearing(RATE, SPEED, 2.5);
    let record = Record { values: &values, rate: RATE, turning: Turning::Even(SPEED) };
    let division = |resolution, count| Division::of(resolution, count, None);
    assert_eq!(record.windows(&division(1.0, 9)), 2);
    assert_eq!(record.windows(&division(10.0, 9)), 9);
    assert_eq!(record.windows(&division(0.3, 9)), 0);
    let spectra = record.spectra(&division(10.0, 3), &|| false).unwrap();
    assert_eq!((spectra.amplitude.averages, spectra.envelope), (3, None));
    assert!((spectra.amplitude.resolution - 10.0).abs() < 1e-12);
    assert_eq!(record.spectra(&division(0.3, 9), &|| false), None);
    assert_eq!(record.spectra(&division(1.0, 1), &|| true), None);
}

/// 60 pulses a turn with noise at their edges.
#[test]
fn pulses_are_counted_once() {
    let rate = 20_000.0;
    let signal: Vec<f64> = (0..20_000)
        .map(|k| (TAU * 60.0 * 5.0 * f64::from(k) / rate).sin().signum() + 0.05 * f64::from(k * 7919 % 13 - 6) / 6.0)
        .collect();
    let pulses = pulses_of(&signal, rate, middle(&signal));
    assert!((299..=301).contains(&pulses.len()), "{}", pulses.len());
    let tachometer = Tachometer::new(pulses, 60).unwrap();
    assert!((tachometer.mean_speed() - 5.0).abs() < 0.01);
    assert!(Tachometer::new(vec![0.0, 1.0], 1).is_none() && Tachometer::new(vec![0.0, 1.0, 1.0], 1).is_none());
    assert!(pulses_of(&[], rate, 0.0).is_empty() && pulses_of(&[1.0; 9], rate, 1.0).is_empty());
}

/// Partners of predicted lines (order, amplitude, label) among measured orders, strongest first.
fn paired(predicted: &[(f64, f64, &str)], measured: &[f64], reach: f64) -> Vec<Option<usize>> {
    let predicted: Vec<PredictedLine<'_>> =
        predicted.iter().map(|&(order, amplitude, label)| PredictedLine { order, amplitude, label }).collect();
    partners(&predicted, measured, &Shifts::of(&predicted, measured, reach), reach)
}

#[test]
fn lines_without_labels_find_their_partners() {
    let predicted = [(4.0, 1.0, ""), (4.2, 0.5, ""), (9.0, 0.2, ""), (16.0, 0.2, ""), (40.0, 0.1, "")];
    // Strongest first: a line of the rig, then four shifted by 1 %, and a weak one nearer to the first.
    let measured = [6.0, 3.96, 4.158, 15.84, 39.6, 4.01];
    assert_eq!(paired(&predicted, &measured, 0.015), [Some(1), Some(2), None, Some(3), Some(4)]);
    // Bins that tell nothing apart take what is near.
    assert_eq!(paired(&[(1.0, 0.1, "")], &[1.03], 0.033), [Some(0)]);
    assert!(paired(&[], &measured, 0.03).is_empty());
}

/// Harmonics of BPFO at their places, and beside three of them stronger lines of the machine, 1.2 to 1.8 % away.
#[test]
fn a_series_shares_its_shift() {
    let labels = ["BPFO", "2·BPFO", "3·BPFO", "8·BPFO", "11·BPFO", "15·BPFO"];
    let orders = [1.0, 2.0, 3.0, 8.0, 11.0, 15.0].map(|harmonic| 3.585 * harmonic);
    let predicted: Vec<(f64, f64, &str)> =
        orders.iter().zip(labels).map(|(order, label)| (*order, 1.0 / order, label)).collect();
    let stray = [(8.0, 1.018), (11.0, 0.988), (15.0, 1.012)].map(|(harmonic, away)| 3.585 * harmonic * away);
    for shift in [1.0, 1.00001, 0.994, 1.013] {
        let measured: Vec<f64> = stray.into_iter().chain(orders.map(|order| shift * order)).collect();
        let expected: Vec<Option<usize>> = (3..9).map(Some).collect();
        assert_eq!(paired(&predicted, &measured, 0.015), expected, "{shift}");
    }
}

/// Slip shifts the ball passages and leaves the shaft where it is; a wrong speed shifts both. Two bearings slip by different amounts.
#[test]
fn sidebands_of_the_shaft_do_not_slip() {
    let (one, other) = (3.585, 5.415);
    let predicted = [
        (10.0 * one, 0.9, "10·BPFO@A"),
        (10.0 * one - 4.0, 0.5, "10·BPFO − 4·f_r@A"),
        (8.0 * one + 2.0, 0.4, "8·BPFO + 2·f_r@A"),
        (7.0 * other, 0.8, "7·BPFO@B"),
        (8.0 * other, 0.7, "8·BPFO@B"),
        (1.0, 0.6, "f_r"),
        (3.0, 0.3, "3·f_r"),
    ];
    let expected: Vec<Option<usize>> = (0..7).map(Some).collect();
    let slipped = [9.94 * one, 9.94 * one - 4.0, 7.952 * one + 2.0, 7.091 * other, 8.104 * other, 1.0, 3.0];
    assert_eq!(paired(&predicted, &slipped, 0.01), expected);
    let fast = predicted.map(|(order, ..)| 0.993 * order);
    assert_eq!(paired(&predicted, &fast, 0.01), expected);
}

/// A peak of the prediction without a label lies at its own order or where the best known series says, and not at a stronger line elsewhere.
#[test]
fn unlabelled_peaks_follow_the_best_shift() {
    let predicted = [(30.0, 1.0, "6·BPFO"), (40.0, 0.9, "8·BPFO"), (25.0, 0.1, "")];
    assert_eq!(paired(&predicted, &[25.4, 29.85, 39.8, 24.875], 0.02), [Some(1), Some(2), Some(3)]);
    assert_eq!(paired(&predicted, &[25.4, 29.85, 39.8], 0.02), [Some(1), Some(2), None]);
}

/// The only line of its series stands at its order, and a stronger one beside it does not take its place: eight other lines show no shift.
#[test]
fn a_single_line_follows_the_others() {
    let mut predicted: Vec<(f64, f64, &str)> = (1..9).map(|k| (3.585 * f64::from(k), 1.0, "BPFO")).collect();
    predicted.push((12.8138, 0.5, "2·BPFI + 2·f_r"));
    let orders: Vec<f64> = predicted.iter().map(|line| line.0).collect();
    let measured: Vec<f64> = [12.62].into_iter().chain(orders).collect();
    assert_eq!(paired(&predicted, &measured, 0.03), (1..10).map(Some).collect::<Vec<_>>());
}

/// At a low speed harmonics stand closer than the largest shift. A resonance above them makes the next ones stronger, which shows no shift.
#[test]
fn close_harmonics_stay_in_place() {
    let labels: Vec<String> = (90..110).map(|k| format!("{k}·BPFO")).collect();
    let orders: Vec<f64> = (90..110).map(|k| 3.585 * f64::from(k)).collect();
    let predicted: Vec<(f64, f64, &str)> =
        orders.iter().zip(&labels).map(|(order, label)| (*order, *order, label.as_str())).collect();
    let measured: Vec<f64> = orders.iter().rev().copied().collect();
    let expected: Vec<Option<usize>> = (0..20).rev().map(Some).collect();
    assert_eq!(paired(&predicted, &measured, 0.5), expected);
}

/// One of twenty lines that meets a measured one proves nothing, nor do lines shifted by more than the largest shift.
#[test]
fn chance_makes_no_partner() {
    let labels: Vec<String> = (9..29).map(|k| format!("{k}·BPFO")).collect();
    let line = |(label, k): (&String, i32)| (3.585 * f64::from(k), 1.0, label.clone());
    let predicted: Vec<(f64, f64, String)> = labels.iter().zip(9..29).map(line).collect();
    let predicted: Vec<(f64, f64, &str)> =
        predicted.iter().map(|(order, amplitude, label)| (*order, *amplitude, label.as_str())).collect();
    let none = vec![None; predicted.len()];
    for shift in [1.022, 1.031, 1.043, 0.97] {
        let measured: Vec<f64> = predicted.iter().map(|line| shift * line.0).collect();
        assert_eq!(paired(&predicted, &measured, 0.03), none, "{shift}");
    }
    assert_eq!(paired(&predicted, &[3.585 * 16.0 * 0.9921], 0.03), none);
    let measured: Vec<f64> = predicted.iter().map(|line| 1.019 * line.0).collect();
    assert_eq!(paired(&predicted, &measured, 0.03), (0..predicted.len()).map(Some).collect::<Vec<_>>());
}

/// Thousands of lines and peaks are compared in time that a request can wait for, and none is lost.
#[test]
fn many_peaks_are_compared() {
    let orders: Vec<f64> = (0..4000).map(|k| 1.0 + 0.1 * f64::from(k)).collect();
    let peaks: Vec<PredictedLine<'_>> =
        orders.iter().map(|&order| PredictedLine { order, amplitude: 1.0, label: "" }).collect();
    let shifts = Shifts::default().of_peaks(&peaks, &orders, 0.01);
    let found = partners(&peaks, &orders, &shifts, 0.01);
    assert_eq!(found, (0..4000).map(Some).collect::<Vec<_>>());
}
