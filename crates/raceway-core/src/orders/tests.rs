//! A signal whose orders are known, over a run-up from 10 to 50 Hz within 8 s.

use std::f64::consts::TAU;

use super::analysis::{OrderAnalysis, Orders, Value};
use super::angle::ShaftAngle;
use super::rotations::{Combination, Ratios, RotationCourse, SimulatedSpeeds};
use super::settings::{OrderSettings, Reference, highest_order};
use super::waterfall::{OrderRows, Row, TimeRows, TimeWindows, sharpest_window, smear_bins};
use crate::numerics::spectrum::{Spectrum, amplitude_spectrum, interpolated_peak};
use crate::physics::operation::SpeedProfile;

const RATE: f64 = 25_600.0;
const DURATION: f64 = 8.0;
const OUTER: f64 = 3.585;
const VALUES: usize = (RATE * DURATION) as usize;
/// A bearing whose cage turns 0.4 times and whose balls spin 2.3 times in a turn of the shaft.
const RATIOS: Ratios = Ratios { cage: 0.4, ball: 2.3, ball_pass_inner: 5.415 };
/// 64 samples a turn.
const SETTINGS: OrderSettings =
    OrderSettings { reference: Reference::Shaft, max_order: 25.0, turns_per_block: 32, overlap: 0.5 };

fn run_up(direction: f64) -> SpeedProfile {
    SpeedProfile::new(vec![(0.0, direction * TAU * 10.0), (DURATION, direction * TAU * 50.0)]).unwrap()
}

fn angle() -> ShaftAngle {
    ShaftAngle::new(&run_up(1.0), 0.0, DURATION).unwrap()
}

fn course() -> RotationCourse {
    RotationCourse::new(angle(), vec![RATIOS], 0.0, RATE.recip())
}

/// sin(2π·3.585 θ) + 0.5 (f_r/50)² sin(2πθ + 0.4), and `tone` · sin(2π·1000 t).
fn signal(tone: f64) -> impl Iterator<Item = f64> {
    (0..VALUES).map(move |i| {
        let time = i as f64 / RATE;
        let (turns, speed) = (10.0 * time + 2.5 * time * time, 10.0 + 5.0 * time);
        let unbalance = 0.5 * (speed / 50.0).powi(2) * (TAU * turns + 0.4).sin();
        (TAU * OUTER * turns).sin() + unbalance + tone * (TAU * 1000.0 * time).sin()
    })
}

fn analysed(settings: OrderSettings, orders: &[Combination], signal: impl Iterator<Item = f64>) -> Orders {
    let mut analysis = OrderAnalysis::new(settings, course(), orders.to_vec());
    signal.for_each(|signal| analysis.push(Value { signal, bearings: &[SimulatedSpeeds::default()] }));
    analysis.finish()
}

fn whole_run(signal: impl Iterator<Item = f64>) -> Orders {
    analysed(OrderSettings { turns_per_block: 239, ..SETTINGS }, &[], signal)
}

fn line(spectrum: &Spectrum, at: f64) -> (f64, f64) {
    let near = (at / spectrum.resolution).round() as usize;
    let strongest = (near - 2..=near + 2).max_by(|a, b| spectrum.amplitude[*a].total_cmp(&spectrum.amplitude[*b]));
    interpolated_peak(spectrum, strongest.unwrap())
}

fn order(shaft: f64) -> Combination {
    Combination { shaft, ..Combination::default() }
}

#[test]
fn angle_of_a_run_up_is_exact() {
    assert!((angle().total() - 240.0).abs() < 1e-10);
    assert_eq!((angle().speeds().0, angle().speeds().1), (10.0, 50.0));
    assert!((angle().steepest() - 5.0).abs() < 1e-12);
    let backward = ShaftAngle::new(&run_up(-1.0), 2.0, DURATION).unwrap();
    assert!((backward.turns(3.0) - 22.5).abs() < 1e-10 && (backward.speed(3.0) - 25.0).abs() < 1e-12);
    let reversal = SpeedProfile::new(vec![(0.0, 10.0), (1.0, -10.0)]).unwrap();
    assert!(ShaftAngle::new(&reversal, 0.0, 1.0).is_none() && ShaftAngle::new(&reversal, 0.5, 1.0).is_some());
}

#[test]
fn orders_of_the_whole_run_are_lines() {
    assert_eq!((SETTINGS.samples_per_turn(), SETTINGS.blocks(240.0), SETTINGS.bins()), (64, 14, 801));
    let orders = whole_run(signal(0.2));
    assert!((orders.turns - 240.0).abs() < 0.01, "{}", orders.turns);
    let spectrum = orders.spectrum.unwrap();
    let (outer, amplitude) = line(&spectrum, OUTER);
    assert!((outer - OUTER).abs() < 1e-4 && (amplitude - 1.0).abs() < 1e-3, "{outer} {amplitude}");
    let (shaft, _) = line(&spectrum, 1.0);
    assert!((shaft - 1.0).abs() < 1e-4, "{shaft}");
}

#[test]
fn tracks_follow_the_amplitude_over_speed() {
    let orders = analysed(SETTINGS, &[order(OUTER), order(1.0)], signal(0.2));
    assert_eq!(orders.points.len(), 13);
    for (speed, unbalance) in [(20.49, 0.0840), (30.00, 0.1800), (39.24, 0.3080)] {
        let point = orders.points.iter().find(|point| (point.middle.speed - speed).abs() < 0.01).unwrap();
        let [outer, shaft] = point.amplitudes[..] else { panic!("two orders") };
        assert!((outer - 1.0).abs() < 0.005 && (shaft / unbalance - 1.0).abs() < 0.005, "{outer} {shaft}");
    }
}

/// The reason for orders: in a plain spectrum the line is smeared over 36 to 179 Hz.
#[test]
fn a_plain_spectrum_of_the_run_has_no_order_lines() {
    let signal: Vec<f64> = signal(0.2).collect();
    let spectrum = amplitude_spectrum(&signal, RATE);
    let smeared = spectrum.amplitude[(30.0 * DURATION) as usize..(200.0 * DURATION) as usize].iter();
    assert!(smeared.fold(0.0, |most: f64, amplitude| most.max(*amplitude)) <= 0.06);
    assert!((line(&spectrum, 1000.0).1 - 0.2).abs() < 1e-3);
}

/// 1000 Hz pass the orders from 100 down to 20: those beyond 32 would fold.
#[test]
fn a_tone_of_constant_frequency_is_no_order() {
    let with_tone = |tone: f64| {
        let only = (0..VALUES).map(move |i| tone * (TAU * 1000.0 * i as f64 / RATE).sin());
        whole_run(only).spectrum.unwrap().amplitude
    };
    let most = with_tone(0.2).into_iter().fold(0.0, f64::max);
    assert!(most <= 0.008, "{most}");
}

/// By 80 dB.
#[test]
fn orders_that_would_fold_are_suppressed() {
    let angle = angle();
    for folding in [39.0, 64.0, 250.0] {
        let turns = |i: usize| angle.turns(i as f64 / RATE);
        let high = (0..VALUES).map(|i| (TAU * folding * turns(i)).sin());
        let most = whole_run(high).spectrum.unwrap().amplitude[3..].iter().fold(0.0, |a: f64, b| a.max(*b));
        assert!(most < 1e-4, "order {folding}: {most}");
    }
    assert!((highest_order(RATE, 50.0) - 200.0).abs() < 1e-9);
}

fn time_rows(windows: TimeWindows) -> Vec<Row> {
    let (mut rows, mut course) = (TimeRows::new(windows), course());
    signal(0.2).filter_map(|value| rows.push(course.next(&[SimulatedSpeeds::default()]), value)).collect()
}

#[test]
fn a_waterfall_by_frequency_shows_the_tone() {
    let window = sharpest_window(RATIOS.ball_pass_inner, angle().steepest());
    assert!((smear_bins(RATIOS.ball_pass_inner, 5.0, window) - 1.0).abs() < 1e-12);
    let windows =
        TimeWindows { length: (window * RATE).round() as usize, overlap: 0.5, step: RATE.recip(), max_frequency: 2e3 };
    let rows = time_rows(windows);
    assert_eq!(rows.len(), windows.rows(VALUES));
    assert!(rows.len() > 50 && rows.iter().all(|row| row.spectrum.amplitude.len() == windows.bins()));
    for row in &rows {
        assert!((row.middle.speed - (10.0 + 5.0 * row.middle.time)).abs() < 1e-9);
        assert!((line(&row.spectrum, 1000.0).1 - 0.2).abs() < 2e-3);
    }
}

#[test]
fn a_waterfall_by_order_has_a_straight_line() {
    let (mut rows, mut course, mut all) = (OrderRows::new(SETTINGS), course(), Vec::new());
    signal(0.0).for_each(|value| {
        rows.push(course.next(&[SimulatedSpeeds::default()]), RATE.recip(), value, |row| all.push(row))
    });
    rows.finish(|row| all.push(row));
    assert_eq!(all.len(), 13);
    for row in &all {
        let (order, amplitude) = line(&row.spectrum, OUTER);
        assert!((order - OUTER).abs() < 1e-3 && (amplitude - 1.0).abs() < 3e-3, "{order} {amplitude}");
    }
}

/// A cage that slips by up to 3 %: seven balls pass the outer raceway exactly seven times in its turn.
#[test]
fn orders_of_the_simulated_cage_are_exact_despite_slip() {
    let settings = OrderSettings { reference: Reference::Cage, turns_per_block: 32, ..SETTINGS };
    let outer = Combination { cage: 7.0, ..Combination::default() };
    let mut analysis = OrderAnalysis::new(settings, course(), vec![outer]);
    let (mut turns, mut before) = (0.0, None);
    for i in 0..VALUES {
        let time = i as f64 / RATE;
        let cage = 0.4 * (10.0 + 5.0 * time) * (1.0 - 0.03 * (3.0 * time).sin().powi(2));
        turns += before.map_or(0.0, |before| 0.5 * (before + cage) / RATE);
        before = Some(cage);
        let simulated = SimulatedSpeeds { cage: Some(cage), ball: None };
        analysis.push(Value { signal: (TAU * 7.0 * turns).sin(), bearings: &[simulated] });
    }
    let orders = analysis.finish();
    assert!((orders.orders[0] - 7.0).abs() < 1e-12 && (orders.turns - turns).abs() < 1e-9);
    let (order, amplitude) = line(&orders.spectrum.unwrap(), 7.0);
    assert!((order - 7.0).abs() < 1e-4 && (amplitude - 1.0).abs() < 2e-3, "{order} {amplitude}");
    assert!(orders.points.len() >= 3 && orders.points.iter().all(|point| (point.amplitudes[0] - 1.0).abs() < 1e-3));
}

#[test]
fn orders_that_are_too_close_beat() {
    let orders = analysed(SETTINGS, &[order(1.0), order(3.585), order(3.64)], signal(0.0));
    assert_eq!(orders.beating, [(1, 2)]);
}
