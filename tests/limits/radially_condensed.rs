//! The radially condensed model, with balls in radial equilibrium, against the full model and against itself.

use raceway::contract::scene_from_json;
use raceway::numerics::ode::Method;
use raceway::numerics::statistics::rms;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::inapplicable::Inapplicable;
use raceway::simulation::model::radially_condensed::{RadiallyCondensed, StepRatio, Stepper, inapplicability};
use raceway::simulation::recording::record::Recording;
use raceway::simulation::solve::run::simulate;

const CONTROL: Control<'static> = Control::until(&|| false);

fn settings(settle: f64, duration: f64) -> RunSettings {
    let axes = [Axis::Y, Axis::Z];
    let series = axes.map(|axis| [Motion::Velocity, Motion::Acceleration].map(|motion| Channel::Spindle(axis, motion)));
    RunSettings {
        method: Method::Auto,
        rung: None,
        relative_tolerance: 1e-7,
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle,
        duration,
        outputs: Outputs { series: series.into_iter().flatten().collect(), ..Outputs::vibration() },
    }
}

fn article(speed: f64, load: [f64; 2], clearance: f64, balls: u32, grade: f64) -> Scene {
    let spindle = if grade > 0.0 { format!(r#"{{ "balance_grade": {grade} }}"#) } else { "{}".into() };
    let [y, z] = load;
    scene_from_json(&format!(
        r#"{{ "bearing": {{ "preset": "article-integrated", "ball_count": {balls}, "radial_clearance_um": {clearance} }},
            "operation": {{ "speed_rpm": {speed}, "radial_load_y_n": {y}, "radial_load_z_n": {z} }},
            "spindle": {spindle} }}"#
    ))
    .unwrap()
}

fn model(scene: &Scene) -> RadiallyCondensed {
    RadiallyCondensed::new(scene, &settings(0.0, 1e-3).outputs).unwrap()
}

fn recorded(scene: &Scene, settle: f64, duration: f64, steps_per_value: usize) -> Recording {
    let mut settings = settings(settle, duration);
    settings.outputs.contacts = true;
    model(scene).run(&settings, StepRatio::of_steps(steps_per_value), &CONTROL).unwrap().0
}

fn spread(signal: &[f64]) -> f64 {
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    rms(&signal.iter().map(|value| value - mean).collect::<Vec<_>>())
}

/// Velocities and accelerations of a short run are those of the full model. Levels agree to 0.1 dB, and the accelerations
/// differ by at most 3 %.
#[test]
fn levels_are_those_of_the_full_model() {
    for (speed, load, clearance, balls, grade) in
        [(50_000.0, 200.0, 5.0, 7, 6.3), (30_000.0, 100.0, 8.0, 8, 0.0), (60_000.0, 300.0, 3.0, 6, 0.0)]
    {
        let scene = article(speed, [load, 0.0], clearance, balls, grade);
        let full = simulate(&scene, &settings(5e-3, 10e-3), &CONTROL).unwrap();
        let condensed = recorded(&scene, 5e-3, 10e-3, 1);
        for series in &full.series {
            let expected: Vec<f64> = series.values.iter().map(|value| value / series.channel.scale()).collect();
            let found = condensed.signal(series.channel).unwrap();
            let decibels = 20.0 * (spread(found) / spread(&expected)).log10();
            let off: Vec<f64> = found.iter().zip(&expected).map(|(a, b)| a - b).collect();
            let rest = spread(&off) / spread(&expected);
            println!("{} at {speed} r/min: {decibels:.3} dB, {rest:.4} of it differs", series.channel);
            assert!(decibels.abs() < 0.1 && rest < 0.03, "{} {decibels} dB {rest}", series.channel);
        }
    }
}

/// Steps from the sampling interval to 24.4 µs give the same number of samples, and levels of the spindle to 0.1 dB.
#[test]
fn long_steps_preserve_levels() {
    for (speed, balls) in [(30_000.0, 8), (50_000.0, 7), (50_000.0, 9)] {
        let pitch = if balls > 8 {
            r#""pitch_diameter_mm": 14, "outer_diameter_mm": 19, "inner_diameter_mm": 9.5,"#
        } else {
            ""
        };
        let scene = scene_from_json(&format!(
            r#"{{ "bearing": {{ "preset": "article-integrated", {pitch} "ball_count": {balls} }},
                "operation": {{ "speed_rpm": {speed}, "radial_load_y_n": 200 }} }}"#
        ))
        .unwrap();
        let model = model(&scene);
        let mut settings = settings(20e-3, 150e-3);
        settings.outputs.series.push(Channel::CageSpeed);
        let run = |ratio: StepRatio| model.run(&settings, ratio, &CONTROL).unwrap().0;
        let short = run(StepRatio::of_steps(1));
        for ratio in StepRatio::LONG {
            assert_eq!(StepRatio::of(ratio.step()), ratio);
            let long = run(ratio);
            for channel in &settings.outputs.series {
                let (found, expected) = (long.signal(*channel).unwrap(), short.signal(*channel).unwrap());
                assert_eq!(found.len(), expected.len(), "{channel} {ratio:?}");
                let decibels = 20.0 * (spread(found) / spread(expected)).log10();
                println!("{balls} balls at {speed} r/min, {ratio:?}: {channel} {decibels:.3} dB");
                // Such long steps damp the motion of the cage on its films.
                let most = if *channel == Channel::CageSpeed { 4.0 } else { 0.1 };
                assert!(decibels.abs() < most, "{channel} {ratio:?} {decibels} dB");
            }
            assert!((long.speeds.cage / short.speeds.cage - 1.0).abs() < 1e-4, "{ratio:?}");
        }
    }
}

/// A method of order 3: the deviation between steps h and h/2 falls by a factor of 8 for half of h.
///
/// Measured on spindle and azimuths from 12 to 3 µs, over the second half of the run: by at least 7 for the spindle, by 3 for the
/// ball paths, which are 0.1 µm apart. The scene has no clearance and a cage that floats free, because opening contacts hide the order. So does
/// the first half of the run, in which balls reach their slip and the error has order 1.
#[test]
fn steps_are_of_third_order() {
    let text = r#"{ "bearing": { "preset": "article-integrated", "radial_clearance_um": -4,
            "cage": { "pocket_clearance_mm": 1, "film": "none" } },
        "gravity_m_s2": 0, "operation": { "speed_rpm": 50000, "radial_load_y_n": 300 },
        "spindle": { "balance_grade": 40 } }"#;
    let model = model(&scene_from_json(text).unwrap());
    const PLACES: u32 = 100;
    let end = 6e-3;
    let (balls, border) = model.start();
    let mut before = Stepper::new(&model, 0.0, balls, border, 1e-6);
    before.advance(2000, &mut |_: &Stepper<'_>| {});
    let at = |steps: u32| {
        let (begin, step) = (before.time(), end / f64::from(steps));
        let mut stepper = Stepper::new(&model, begin, before.balls().to_vec(), *before.border(), step);
        let to_go = u64::from(steps) - stepper.steps();
        let (every, mut step, mut seen) = (u64::from(steps / PLACES), stepper.steps(), Vec::new());
        stepper.advance(to_go + 1, &mut |stepper: &Stepper<'_>| {
            if step % every == 0 && 2 * step >= u64::from(steps) {
                let [y, z] = stepper.border().spindle_velocity;
                seen.push([y, z, stepper.balls()[0].arc[2]]);
            }
            step += 1;
        });
        seen
    };
    let runs = [500, 1000, 2000].map(at);
    for (value, least) in [7.0, 7.0, 3.0].into_iter().enumerate() {
        // At many times, because the deviation may pass through zero at one of them.
        let distance = |pair: &[Vec<[f64; 3]>]| {
            let squares = pair[0].iter().zip(&pair[1]).map(|(a, b)| (a[value] - b[value]).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let distances: Vec<f64> = runs.windows(2).map(distance).collect();
        println!("value {value}: {} places, {distances:?}", runs[0].len());
        assert!(distances[0] / distances[1] > least, "{distances:?}");
    }
}

/// The mirror image of a motion is a motion. Load along Z and speed change their signs, and so do the motion along Z and the
/// azimuths. Both differ by rounding only, for balls in single precision.
#[test]
fn the_mirror_image_of_a_motion_is_a_motion() {
    let one = recorded(&article(40_000.0, [200.0, 50.0], 5.0, 7, 0.0), 2e-3, 4e-3, 2);
    let other = recorded(&article(-40_000.0, [200.0, -50.0], 5.0, 7, 0.0), 2e-3, 4e-3, 2);
    for (axis, sign) in [(Axis::Y, 1.0), (Axis::Z, -1.0)] {
        let channel = Channel::Spindle(axis, Motion::Acceleration);
        let (a, b) = (one.signal(channel).unwrap(), other.signal(channel).unwrap());
        let off = a.iter().zip(b).fold(0.0, |most, (a, b)| f64::max(most, (a - sign * b).abs()));
        assert!(off < 3e-4 * spread(a), "{channel}: {off:e} of {:e}", spread(a));
    }
}

/// The mean forces of the raceways balance load and weight. Cage and balls turn at almost ideal speeds.
#[test]
fn mean_forces_balance() {
    let scene = article(50_000.0, [200.0, 0.0], 5.0, 7, 0.0);
    let recording = recorded(&scene, 20e-3, 50e-3, 2);
    let y = recording.signal(Channel::Spindle(Axis::Y, Motion::Acceleration)).unwrap();
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    assert!(mean.abs() < 5e-3 * 200.0 / 0.05, "{mean}");
    let model = model(&scene);
    let m = model.mechanism();
    assert!((recording.speeds.cage / (m.orbit_ratio * recording.speeds.shaft) - 1.0).abs() < 0.01);
    assert!(recording.contacts.inner.max_load[0] > 50.0 && recording.max_pocket_load < 10.0);
}

/// Scenes outside the range of the model are rejected with their reason.
#[test]
fn scenes_out_of_the_plane_are_refused() {
    let plain = settings(0.0, 1e-3).outputs;
    let scene = |text: &str| scene_from_json(text).unwrap();
    let reason = |text: &str| inapplicability(&scene(text), &plain);
    assert_eq!(
        reason(r#"{ "bearing": "article-integrated", "operation": { "speed_rpm": 5000, "radial_load_y_n": 9 } }"#),
        None
    );
    let pushed = r#"{ "bearing": "article-integrated", "operation": { "speed_rpm": 5000, "radial_load_y_n": 9, "axial_load_n": 10 }, "spindle": { "axial": "free" } }"#;
    assert_eq!(reason(pushed), Some(Inapplicable::AxialLoad));
    let words = RadiallyCondensed::new(&scene(pushed), &plain).unwrap_err().to_string();
    assert_eq!(words, "rung radially_condensed is not applicable: an axial load acts");
    let free = r#"{ "bearing": "article-integrated", "operation": { "speed_rpm": 5000, "radial_load_y_n": 9 }, "spindle": { "axial": "free" } }"#;
    assert_eq!(reason(free), Some(Inapplicable::SpindleMovesAlongX));
    let along_x = Outputs { series: vec![Channel::Spindle(Axis::X, Motion::Acceleration)], ..plain.clone() };
    let article =
        scene(r#"{ "bearing": "article-integrated", "operation": { "speed_rpm": 5000, "radial_load_y_n": 9 } }"#);
    assert_eq!(inapplicability(&article, &along_x), Some(Inapplicable::ChannelAlongX));
}

/// Traction laws, lubricants and pockets without a short formula use the contacts of the full model.
///
/// An article scene that uses these contacts follows the short formula, except for strips of finite width in place of a
/// quadrature. Wide contacts have the same strips both ways and differ only by the slopes within a step.
#[test]
fn the_general_contact_agrees_with_the_short_form() {
    let narrow = article(50_000.0, [200.0, 0.0], 5.0, 7, 0.0);
    let wide = r#"{
        "bearing": { "preset": "article-integrated", "inner_groove_curvature": 0.51, "outer_groove_curvature": 0.51 },
        "operation": { "speed_rpm": 50000, "radial_load_y_n": 400 }
    }"#;
    for (scene, most) in [(narrow, 4e-3), (scene_from_json(wide).unwrap(), 1e-3)] {
        let short = model(&scene);
        let general = short.clone().with_general_traction();
        let run =
            |model: RadiallyCondensed| model.run(&settings(2e-3, 4e-3), StepRatio::of_steps(2), &CONTROL).unwrap().0;
        let [a, b] = [short, general].map(run);
        for axis in [Axis::Y, Axis::Z] {
            let channel = Channel::Spindle(axis, Motion::Acceleration);
            let (a, b) = (a.signal(channel).unwrap(), b.signal(channel).unwrap());
            let off: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            println!("{channel}: {:e}", spread(&off) / spread(a));
            assert!(spread(&off) < most * spread(a), "{channel}: {:e}", spread(&off) / spread(a));
        }
    }
    let oil =
        r#"{ "bearing": "6205", "lubricant": "oil", "operation": { "speed_rpm": 6000, "radial_load_y_n": 800 } }"#;
    let oil = scene_from_json(oil).unwrap();
    let moving = recorded(&oil, 2e-3, 4e-3, 2);
    assert!(moving.signal(Channel::Spindle(Axis::Y, Motion::Velocity)).unwrap().iter().all(|v| v.abs() < 0.1));
}
