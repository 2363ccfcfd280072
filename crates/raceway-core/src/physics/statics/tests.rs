//! Numbers of an independent quasi-static program: one angular-contact bearing, and two of them in a pair.

use std::array::from_fn;

use super::ring::{NoBalance, RingState};
use super::shaft::{Faces, Mounted, RigidShaft, Spring};
use super::{Matrix, Pose, RingBearing, Wrench};
use crate::physics::bearing::{Bearing, BearingKind, BearingParameters, Fit, PerRaceway};
use crate::physics::contact::damping::DampingFactor;
use crate::physics::kinematics::LoadedBall;
use crate::physics::material::{GCR15, Material};
use crate::physics::presets;

const ALL: [bool; 5] = [true; 5];
const STEEL: Material = Material { elastic_modulus: 208e9, poisson_ratio: 0.3, density: 7810.0 };
const CERAMIC: Material = Material { elastic_modulus: 310e9, poisson_ratio: 0.26, density: 3240.0 };
/// One revolution per minute [rad/s].
const RPM: f64 = std::f64::consts::TAU / 60.0;

/// 17 balls of 7.938 mm on 54 mm at a free contact angle of 25°.
fn angular(balls: Material) -> Bearing {
    angular_of(balls, STEEL)
}

fn angular_of(balls: Material, rings: Material) -> Bearing {
    Bearing::new(BearingParameters {
        kind: BearingKind::AngularContact,
        outer_diameter: 75e-3,
        inner_diameter: 35e-3,
        width: 14e-3,
        ball_count: 17,
        ball_diameter: 7.938e-3,
        pitch_diameter: 54e-3,
        groove_curvature: PerRaceway { inner: 0.52, outer: 0.53 },
        fit: Fit::ContactAngle(25_f64.to_radians()),
        ball_material: balls,
        raceway_material: PerRaceway { inner: rings, outer: rings },
    })
    .unwrap()
}

fn bearing() -> RingBearing {
    RingBearing::new(&angular(STEEL))
}

fn thrust(force: f64) -> Wrench {
    [force, 0.0, 0.0, 0.0, 0.0]
}

/// A bearing under thrust, all freedoms free.
fn under(bearing: &RingBearing, force: f64, speed: f64) -> RingState {
    let start = [bearing.axial_play(), 0.0, 0.0, 0.0, 0.0];
    bearing.operating_point(&thrust(force), ALL, &start, speed).unwrap()
}

fn assert_close(name: &str, value: f64, expected: f64) {
    assert!((value / expected - 1.0).abs() <= 1e-3, "{name}: {value} for {expected}");
}

/// Displacement [µm], contact angle [°], and stiffness [N/µm, MN, N m/rad] under thrust at rest.
#[test]
fn a_thrust_loads_all_balls_alike() {
    let bearing = bearing();
    for (force, stiffness) in [(100.0, 48.023), (200.0, 61.710), (500.0, 87.346)] {
        assert_close("K_xx", 1e-6 * under(&bearing, force, 0.0).stiffness.mean[0][0], stiffness);
    }
    let state = under(&bearing, 200.0, 0.0);
    assert_close("x", 1e6 * (state.pose[0] - bearing.axial_play()), 4.99575);
    let load = state.largest_loads[0];
    assert_close("angle", (200.0 / (17.0 * load)).asin().to_degrees(), 25.650);
    let k = state.stiffness.mean;
    for (y, tilt, sign) in [(1, 4, -1.0), (2, 3, 1.0)] {
        assert_close("K_yy", 1e-6 * k[y][y], 131.870);
        assert_close("K_yβ", 1e-6 * k[y][tilt], sign * 1.71107);
        assert_close("K_ββ", k[tilt][tilt], 22_721.7);
    }
    assert!(k[0][1].abs() < 1.0 && k[1][2].abs() < 1.0 && k[1][3].abs() < 1e-3, "{k:?}");
    assert_eq!(state.loaded, 1.0);
}

/// Stiffness along the axis [N/µm] under 200 N at speeds [r/min], in ideal rolling without gyroscopic moments: centrifugal force takes it away,
/// less with ceramic balls.
#[test]
fn centrifugal_force_softens_a_bearing_under_constant_thrust() {
    let cases = [
        (STEEL, [(5e3, 54.100), (10e3, 20.321)].as_slice()),
        (CERAMIC, [(0.0, 68.724), (10e3, 48.078), (20e3, 11.934), (30e3, 7.781)].as_slice()),
    ];
    for (material, of_speeds) in cases {
        let mut bearing = RingBearing::new(&angular(material));
        bearing.rolling.at_loaded_angles = false;
        for &(speed, stiffness) in of_speeds {
            assert_close("K_xx", 1e-6 * under(&bearing, 200.0, speed * RPM).stiffness.mean[0][0], stiffness);
        }
    }
}

/// Stiffness along the axis [N/µm] under 200 N at speeds [r/min], balls rolling at their loaded angles against gyroscopic moments.
#[test]
fn gyroscopic_moments_soften_a_bearing_under_constant_thrust() {
    let cases = [
        (STEEL, [(5e3, 52.9352, 27.2563), (10e3, 14.8394, 32.2880)].as_slice()),
        (CERAMIC, [(10e3, 44.6908, 28.2848), (20e3, 7.8748, 35.6956), (30e3, 7.2320, 39.9425)].as_slice()),
    ];
    for (material, of_speeds) in cases {
        let bearing = RingBearing::new(&angular(material));
        for &(speed, stiffness, angle) in of_speeds {
            let state = under(&bearing, 200.0, speed * RPM);
            assert_close("K_xx", 1e-6 * state.stiffness.mean[0][0], stiffness);
            assert_close("inner angle", state.angles()[0].to_degrees(), angle);
        }
    }
}

/// Stiffness in the full dynamics of the same bearing under 200 N and a small harmonic thrust (`benches/modes/axial_stiffness.py`). Ideal rolling
/// is 3 and 29 % stiffer at 5000 and 10 000 r/min.
#[test]
fn a_bearing_at_speed_is_as_soft_as_in_the_full_dynamics() {
    let mut bearing = RingBearing::new(&angular_of(GCR15, GCR15));
    for (speed, stiffness, error) in [(5e3, 54.26, 0.005), (10e3, 15.9, 0.07)] {
        let found = 1e-6 * under(&bearing, 200.0, speed * RPM).stiffness.mean[0][0];
        assert!((found / stiffness - 1.0).abs() < error, "{found} N/µm for {stiffness}");
    }
    // At 6000 r/min the harmonic thrust at 100, 450 and 900 Hz meets 46.50, 45.33 and 40.02 N/µm: the inertia of the balls takes part.
    let state = under(&bearing, 200.0, 6e3 * RPM);
    for (frequency, stiffness) in [(100.0, 46.50), (450.0, 45.33), (900.0, 40.02)] {
        let undamped = DampingFactor { chi: 0.0, viscous: 0.0 };
        let found = 1e-6 * state.at_frequency(&undamped, std::f64::consts::TAU * frequency).stiffness[0][0];
        assert!((found / stiffness - 1.0).abs() < 0.01, "{found} N/µm for {stiffness}");
    }
    bearing.rolling.at_loaded_angles = false;
    assert!(under(&bearing, 200.0, 10e3 * RPM).stiffness.mean[0][0] > 20e6);
}

fn pair(faces: [Faces; 2]) -> RigidShaft {
    let bearings = vec![Mounted::new(bearing(), -7.5e-3, faces[0]), Mounted::new(bearing(), 7.5e-3, faces[1])];
    RigidShaft { bearings }.preloaded_by_force([0, 1], 200.0).unwrap()
}

const BACK_TO_BACK: [Faces; 2] = [Faces::PlusX, Faces::MinusX];
const FACE_TO_FACE: [Faces; 2] = [Faces::MinusX, Faces::PlusX];

/// Planes 15 mm apart, 200 N of preload: tilt is stiff back to back and soft face to face.
#[test]
fn a_pair_is_stiff_as_its_pressure_centres_are_apart() {
    let one = under(&bearing(), 200.0, 0.0).stiffness.mean;
    let a = 7.5e-3;
    for (faces, tilt, sign) in [(BACK_TO_BACK, 111_611.0, 1.0), (FACE_TO_FACE, 8946.9, -1.0)] {
        let state = pair(faces).operating_point(&thrust(0.0), ALL, 0.0, None).unwrap();
        let k = state.stiffness;
        assert_close("K_xx", 1e-6 * k[0][0], 123.420);
        assert_close("K_yy", 1e-6 * k[1][1], 263.741);
        assert_close("K_ββ", k[3][3], tilt);
        assert_close("K_ββ", k[4][4], tilt);
        assert_close("sum", k[4][4], 2.0 * (one[4][4] + sign * 2.0 * a * one[1][4].abs() + a * a * one[1][1]));
        assert!(state.pose.iter().all(|freedom| freedom.abs() < 1e-15), "{:?}", state.pose);
    }
}

/// A thrust of 589.2 N relieves the second bearing, 2.946 times the preload.
#[test]
fn a_thrust_lifts_the_relieved_bearing() {
    let shaft = pair(BACK_TO_BACK);
    let loaded = |force: f64| {
        let state = shaft.operating_point(&thrust(force), ALL, 0.0, None).unwrap();
        [state.bearings[0].ring.loaded, state.bearings[1].ring.loaded]
    };
    assert_eq!(loaded(589.2 * 0.999), [1.0, 1.0]);
    assert_eq!(loaded(589.2 * 1.001), [1.0, 0.0]);
}

/// In ideal rolling stiffness knows the orbit speed alone: an outer ring that turns counts as an inner one with the same orbit. At rest both stand.
#[test]
fn outer_rings_that_turn_count_by_the_orbit() {
    let angular = angular(STEEL);
    let (ratio, mut bearing) = (crate::physics::kinematics::ideal_orbit_ratio(&angular), bearing());
    bearing.rolling.at_loaded_angles = false;
    let (inner, outer) = (6000.0 * RPM, -2500.0 * RPM);
    let alike = (outer + ratio * (inner - outer)) / ratio;
    let turning = under(&bearing.clone().with_outer_speed(outer), 200.0, inner).stiffness.mean[0][0];
    let standing = under(&bearing, 200.0, alike).stiffness.mean[0][0];
    assert!((turning / standing - 1.0).abs() < 1e-9, "{turning} {standing}");
    let rest = bearing.clone().with_outer_speed(outer).under_thrust(200.0).unwrap();
    assert_eq!(rest, bearing.under_thrust(200.0).unwrap());
}

/// A pose without symmetry, at speed.
const SKEW: Pose = [4e-6, 9e-6, -6e-6, 0.3e-3, -0.2e-3];

fn skew(bearing: &RingBearing) -> Pose {
    from_fn(|k| SKEW[k] + if k == 0 { bearing.axial_play() } else { 0.0 })
}

/// Differences of the forces over 2 nm and 0.2 µrad agree with the stiffness within 10⁻⁵ of its largest entries.
#[test]
fn stiffness_is_the_slope_of_the_forces() {
    let bearing = bearing();
    let state = bearing.at(&skew(&bearing), 4000.0 * RPM).unwrap();
    let k = state.stiffness.mean;
    for column in 0..5 {
        let step = if column < 3 { 1e-9 } else { 1e-7 };
        let moved = |by: f64| {
            let pose = from_fn(|other| state.pose[other] + if other == column { by } else { 0.0 });
            bearing.near(&pose, state.speed, &state).unwrap().wrench
        };
        let (after, before) = (moved(step), moved(-step));
        for row in 0..5 {
            let slope = (before[row] - after[row]) / (2.0 * step);
            let scale = (k[row][row] * k[column][column]).sqrt();
            assert!((slope - k[row][column]).abs() < 1e-5 * scale, "{row} {column}: {slope} for {}", k[row][column]);
        }
    }
}

/// Radial load, thrust and a moment in one plane, the ring free to tilt: the balls carry them to the residual of the search.
#[test]
fn forces_at_the_operating_point_balance_the_loads() {
    let bearing = bearing();
    let load = [300.0, 400.0, -100.0, 0.5, 1.0];
    let start = [bearing.axial_play(), 0.0, 0.0, 0.0, 0.0];
    let state = bearing.operating_point(&load, ALL, &start, 3000.0 * RPM).unwrap();
    for (force, load) in state.wrench.iter().zip(load) {
        assert!((force + load).abs() < 1e-6, "{force} for {load}");
    }
    // A held ring stays in place.
    let held = bearing.operating_point(&load, [true, true, true, false, false], &start, 0.0).unwrap();
    assert_eq!(held.pose[3..], [0.0; 2]);
    assert!(held.stiffness.least[1][1] < held.stiffness.mean[1][1]);
}

/// A mirrored bearing in a mirrored pose carries mirrored forces.
#[test]
fn the_mirror_image_carries_mirrored_forces() {
    let [plus, minus] = [Faces::PlusX, Faces::MinusX].map(|faces| Mounted::new(bearing(), 0.0, faces));
    let pose = skew(&plus.bearing);
    let mirrored = [-pose[0], pose[1], pose[2], -pose[3], -pose[4]];
    let one = plus.bearing.at(&plus.ring_pose(&pose, 0.0), 0.0).unwrap();
    let other = minus.bearing.at(&minus.ring_pose(&mirrored, 0.0), 0.0).unwrap();
    let [x, y, z, about_y, about_z] = plus.wrench_on_shaft(&one.wrench);
    assert_eq!(minus.wrench_on_shaft(&other.wrench), [-x, y, z, -about_y, -about_z]);
    assert_eq!(minus.along_shaft(&other.stiffness.mean)[0][1], -one.stiffness.mean[0][1]);
}

/// A soft spring on a sliding outer ring keeps the preload where a thrust moves the shaft, and takes part along the axis only.
#[test]
fn a_spring_preloads_a_pair() {
    let shaft = RigidShaft {
        bearings: vec![
            Mounted::new(bearing(), 0.0, Faces::PlusX),
            Mounted {
                spring: Some(Spring { force: 200.0, stiffness: 50e3 }),
                ..Mounted::new(bearing(), 0.1, Faces::MinusX)
            },
        ],
    };
    let free = ALL;
    let state = shaft.operating_point(&thrust(0.0), free, 0.0, None).unwrap();
    let axial = |index: usize, state: &super::shaft::ShaftState| state.bearings[index].ring.wrench[0].abs();
    // The first ring gives way by its play and its deflection, which the spring follows.
    let force = 200.0 - 50e3 * state.bearings[1].outer_shift;
    assert_close("first", axial(0, &state), force);
    assert_close("second", axial(1, &state), force);
    let ring = |index: usize| state.bearings[index].ring.stiffness.mean;
    let series = 50e3 * ring(1)[0][0] / (50e3 + ring(1)[0][0]);
    assert_close("K_xx", state.stiffness[0][0], ring(0)[0][0] + series);
    // Started from this balance, the search ends at the same one.
    let pushed = shaft.operating_point(&thrust(100.0), free, 0.0, Some(&state)).unwrap();
    let afresh = shaft.operating_point(&thrust(100.0), free, 0.0, None).unwrap();
    assert!(pushed.pose.iter().zip(afresh.pose).all(|(one, other)| (one - other).abs() < 1e-12));
    assert_close("under thrust", axial(0, &pushed), axial(1, &pushed) + 100.0);
    // The balls do not bear everything.
    assert!(matches!(shaft.operating_point(&thrust(1e8), free, 0.0, None), Err(NoBalance::TooDeep { .. })));
}

/// Two contacts in series, of damping χ Q each, share the rate as their flexibilities: c = χ Q (s² + (1 − s)²) in their common normal.
#[test]
fn damping_is_that_of_two_contacts_in_series() {
    let (bearing, damping) = (bearing(), DampingFactor { chi: 2.0, viscous: 0.0 });
    let state = under(&bearing, 200.0, 0.0);
    let hertz =
        crate::physics::contact::hertz::raceway_contacts(&angular(STEEL)).map(|of| of.stiffness.powf(-2.0 / 3.0));
    let share = hertz.inner / (hertz.inner + hertz.outer);
    let load = state.largest_loads[0];
    let one = 2.0 * load * (share * share + (1.0 - share) * (1.0 - share));
    let sine = 200.0 / (17.0 * load);
    let c = state.damping(&damping);
    assert_close("C_xx", c[0][0], 17.0 * one * sine * sine);
    assert_close("C_yy", c[1][1], 17.0 * one * 0.5 * (1.0 - sine * sine));
    // The vibration of a slow shaft has the same matrices; at 20 kHz the inertia of the balls takes part.
    let slow = state.at_frequency(&damping, 100.0);
    let near = |one: &Matrix, other: &Matrix, share: f64| (0..5).all(|k| (one[k][k] / other[k][k] - 1.0).abs() < share);
    assert!(near(&slow.damping, &c, 1e-5) && near(&slow.stiffness, &state.stiffness.mean, 1e-5));
    let fast = state.at_frequency(&damping, 1.3e5);
    assert!(!near(&fast.stiffness, &state.stiffness.mean, 0.1));
}

/// A 6205 at 3000 r/min under thrust: contact angles [°], and the cage speed [Hz] and outer ball-pass frequency [Hz] of rolling at them, from inner to
/// outer control. A calculation with exact Hertz contacts and centrifugal force.
#[test]
fn a_6205_under_thrust_rolls_at_its_loaded_angles() {
    let preset = presets::bearing("6205").unwrap();
    let parameters = preset.defaults.parameters(&preset.dimensions);
    let ball_radius = 0.5 * parameters.ball_diameter;
    let bearing = RingBearing::new(&Bearing::new(parameters).unwrap());
    for (thrust, angles, cage, pass) in [
        (50.0, [11.88, 11.61], [20.019, 20.024], [180.17, 180.22]),
        (200.0, [13.51, 13.42], [20.054, 20.056], [180.49, 180.50]),
        (1000.0, [17.16, 17.13], [20.141, 20.141], [181.27, 181.27]),
        (3000.0, [21.07, 21.06], [20.255, 20.255], [182.29, 182.29]),
    ] {
        let state = under(&bearing, thrust, 3000.0 * RPM);
        let found = state.angles();
        for (found, expected) in found.iter().zip(angles) {
            assert!((found.to_degrees() - expected).abs() < 0.02, "{thrust} N: {} for {expected}°", found.to_degrees());
        }
        let orbit_radius = bearing.pitch_radius() + state.balls()[0][1];
        let angle = PerRaceway { inner: found[0].sin_cos(), outer: found[1].sin_cos() };
        let ball = LoadedBall { orbit_radius, ball_radius, angle };
        for (k, axis) in [ball.inner_control(), ball.outer_control()].into_iter().enumerate() {
            let hertz = 50.0 * ball.orbit_ratio(axis).unwrap();
            assert!((hertz - cage[k]).abs() < 1e-3, "{thrust} N: {hertz} for {} Hz", cage[k]);
            assert!((9.0 * hertz - pass[k]).abs() < 1e-2, "{thrust} N: {} for {} Hz", 9.0 * hertz, pass[k]);
        }
    }
}

/// Seven balls under 1 kN along and across the axis, free to tilt, one ball below the load: displacements and stiffness of an exact calculation
/// beside ISO/TS 16281.
#[test]
fn a_deep_groove_bearing_tilts_under_both_loads() {
    let steel = Material { elastic_modulus: 210e9, poisson_ratio: 0.3, density: 7810.0 };
    let mut bearing = RingBearing::new(
        &Bearing::new(BearingParameters {
            kind: BearingKind::DeepGroove,
            outer_diameter: 72e-3,
            inner_diameter: 20e-3,
            width: 19e-3,
            ball_count: 7,
            ball_diameter: 11.5e-3,
            pitch_diameter: 43.5e-3,
            groove_curvature: PerRaceway { inner: 0.52, outer: 0.53 },
            fit: Fit::RadialClearance(10e-6),
            ball_material: steel,
            raceway_material: PerRaceway { inner: steel, outer: steel },
        })
        .unwrap(),
    );
    bearing.places = 1;
    let start = [bearing.axial_play(), 0.0, 0.0, 0.0, 0.0];
    let state = bearing.operating_point(&[1e3, 1e3, 0.0, 0.0, 0.0], ALL, &start, 0.0).unwrap();
    let [x, y, z, about_y, about_z] = state.pose;
    for (name, value, expected) in [("x", 1e6 * x, 146.418), ("y", 1e6 * y, 19.898), ("tilt", 1e3 * about_z, 2.715)] {
        assert_close(name, value, expected);
    }
    assert!(z.abs() < 1e-12 && about_y.abs() < 1e-12);
    let k = state.stiffness.mean.map(|row| row.map(|entry| 1e-6 * entry));
    let entries = [(0, 0, 34.278), (1, 1, 205.52), (2, 2, 195.97), (0, 1, -13.020), (1, 4, -1.08177)];
    entries.iter().for_each(|&(row, column, expected)| assert_close("K", k[row][column], expected));
}
