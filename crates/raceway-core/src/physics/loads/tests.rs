//! Loads at given times.

use super::*;
use crate::physics::spindle::unbalance_force;

fn along_y(course: LoadCourse) -> Load {
    Load::Along(LoadDirection::Y, course)
}

/// Points: 10 N at the start, 30 N at 2 s, then constant. The change counts from the start.
#[test]
fn loads_change_from_their_start() {
    let points = along_y(LoadCourse::Points(vec![(1.0, 10.0), (2.0, 30.0)]));
    let shock = along_y(LoadCourse::Shock(Shock { peak: 8.0, at: 1.0, duration: 1.0 }));
    let loads = [points, shock, along_y(LoadCourse::Constant(5.0))];
    let (start, change) = start_and_largest_change(&loads);
    assert_eq!((start[1], change[1]), (15.0, 28.0));
    let varying = VaryingLoads::of(&loads, 0.0).unwrap();
    assert_eq!(varying.at(0.0, 0.0), [0.0; 5]);
    assert!((varying.at(1.5, 0.0)[1] - (10.0 + 8.0)).abs() < 1e-12);
    assert_eq!(varying.at(3.0, 0.0)[1], 20.0);
    assert_eq!(varying.kinks().collect::<Vec<_>>(), [1.0, 2.0, 1.0, 2.0]);
    assert_eq!(end_of_transients(&loads), Some(2.0));
    assert_eq!((varying.longest_step_from(0.5), varying.longest_step_from(1.0)), (f64::INFINITY, 0.2));
    assert!(VaryingLoads::of(&loads[2..], 0.0).is_none());
}

/// A run of 1.5 s sees half of the rise, no later shock, and of constant points no change.
#[test]
fn loads_end_with_their_run() {
    let rise = along_y(LoadCourse::Points(vec![(1.0, 10.0), (2.0, 30.0)])).until(1.5);
    let shock = along_y(LoadCourse::Shock(Shock { peak: 8.0, at: 2.0, duration: 1.0 })).until(1.5);
    let later = along_y(LoadCourse::Points(vec![(0.0, 5.0), (4.0, 5.0), (5.0, 6.0)])).until(1.5);
    let (start, change) = start_and_largest_change(&[rise.clone(), shock, later.clone()]);
    assert_eq!((start[1], change[1]), (15.0, 10.0));
    assert_eq!((rise.end(), later.end()), (Some(1.5), None));
}

/// Of order 1 and amplitude m e ω² it is the force of an unbalance, to the last bit.
#[test]
fn a_rotating_load_is_an_unbalance() {
    let (product, speed, angle) = (3e-6, 5236.0, 1234.567);
    let harmonic = Harmonic { amplitude: product * speed * speed, rate: LoadRate::Order(1.0), phase: 0.0 };
    let varying = VaryingLoads::of(&[Load::Rotating(harmonic)], speed).unwrap();
    let [x, y, z, ..] = varying.at(0.1, angle);
    assert_eq!([x, y, z], unbalance_force(product, angle, speed, 0.0));
}

/// cos(2πft + phase): 60° before the first maximum at time 0 it has half of its amplitude.
#[test]
fn a_harmonic_load_is_a_cosine_from_time_zero() {
    let harmonic = Harmonic { amplitude: 4.0, rate: LoadRate::Frequency(50.0), phase: -PI / 3.0 };
    let load = Load::Along(LoadDirection::AboutZ, LoadCourse::Harmonic(harmonic));
    let varying = VaryingLoads::of(&[load], 0.0).unwrap();
    assert!((varying.at(0.0, 9.0)[4] - 2.0).abs() < 1e-12);
    assert!((varying.at(1.0 / 300.0, 9.0)[4] - 4.0).abs() < 1e-12);
    assert_eq!(varying.longest_fixed_step(), 0.002);
}
