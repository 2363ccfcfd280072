//! Time of the hot formulas with each instruction set of this processor: a contact with the raceways, and the whole
//! right-hand side, one ball at a time and several balls in the lanes of a vector.
//!
//! `cargo bench --bench contact` prints medians of 201 short samples, with the range of their middle 80 %.

use std::hint::black_box;
use std::time::Instant;

use raceway::contract::scene_from_json;
use raceway::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide};
use raceway::numerics::ode::OdeSystem;
use raceway::numerics::ode::arrowhead::ArrowheadFactors;
use raceway::numerics::ode::structure::Jacobian;
use raceway::physics::bearing::PerRaceway;
use raceway::physics::pocket::PocketMotion;
use raceway::physics::raceway::{RacewayContact, RacewayLoad, RelativeMotion};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::Outputs;
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::terms::ActiveTerms;

const RUNS: usize = 201;
const COUNT: u32 = 100;
const BALLS: [usize; 5] = [7, 8, 16, 30, 50];

fn main() {
    let article = model(7);
    println!("one contact of the article's bearing at 3 µm of penetration");
    println!("{:>10} {:>9} {:>9} {:>20}", "of", "by", "ns", "range");
    contacts(&article);
    println!(
        "\none evaluation of dy/dt, of its Jacobian J, factors of s − J, a solution with them; the full rung at the start state"
    );
    println!("{:>6} {:>10} {:>9} {:>9} {:>20}", "balls", "of", "by", "ns", "range");
    for balls in BALLS {
        evaluations(balls, &model(balls));
    }
}

/// The article's bearing with more balls at the same distance and the same orbit speed.
fn model(balls: usize) -> Model {
    let (growth, pitch) = (balls as f64 / 7.0, 13.0 * balls as f64 / 7.0);
    let json = serde_json::json!({
        "bearing": {
            "preset": "article-integrated",
            "ball_count": balls,
            "pitch_diameter_mm": pitch,
            "inner_diameter_mm": pitch - 5.0,
            "outer_diameter_mm": pitch + 5.0
        },
        "operation": { "speed_rpm": 50_000.0 / growth, "radial_load_y_n": 200.0 * growth }
    });
    let scene = scene_from_json(&json.to_string()).expect("a grown bearing is a scene");
    let outputs = Outputs { contacts: true, cage: true, ..Outputs::vibration() };
    let needs = ActiveTerms::of(&scene, &outputs, Some(ModelLevel::Full)).expect("the full rung serves every scene");
    Model::new(&scene, &needs)
}

/// Median time of a call and the range of its middle 80 % [ns], because other processes share the machine.
fn time(mut once: impl FnMut()) -> (f64, f64, f64) {
    let mut mean = || {
        let begin = Instant::now();
        (0..COUNT).for_each(|_| once());
        begin.elapsed().as_secs_f64() / f64::from(COUNT) * 1e9
    };
    let mut values: Vec<f64> = (0..RUNS).map(|_| mean()).collect();
    values.sort_by(f64::total_cmp);
    (values[RUNS / 2], values[RUNS / 10], values[RUNS - 1 - RUNS / 10])
}

fn contacts(model: &Model) {
    let m = model.mechanism();
    let row = |of: &str, by: &str, share: f64, (median, least, largest): (f64, f64, f64)| {
        let (median, least, largest) = (median / share, least / share, largest / share);
        println!("{of:>10} {by:>9} {median:>9.1} {least:>9.1} … {largest:<8.1}");
    };
    let one = |outer: bool| {
        let raceway = if outer { &m.raceway.outer } else { &m.raceway.inner };
        let side = if outer { 1.0 } else { -1.0 };
        let reach = raceway.touch_distance() + 3e-6;
        // At the centre of the groove the ball has no contact.
        let centre = (0..60).fold((5e-3, 8e-3), |(low, high), _| {
            let middle = 0.5 * (low + high);
            let outside = raceway.penetration::<true>(0.0, middle).1.1 > 0.0;
            if outside { (low, middle) } else { (middle, high) }
        });
        RelativeMotion {
            radius: centre.0 + side * reach,
            velocity: [0.1, 0.05, 14.0],
            spin: [-11_700.0, 300.0, 200.0],
            raceway_speed: if outer { 0.0 } else { 5236.0 },
            orbit_speed: 2100.0,
            ..RelativeMotion::default()
        }
    };
    let motion = PerRaceway { inner: one(false), outer: one(true) };
    let mut several = PerRaceway { inner: RelativeMotion::<Lanes>::default(), outer: RelativeMotion::default() };
    for lane in 0..LANES {
        several.inner.put(lane, motion.inner);
        several.outer.put(lane, motion.outer);
    }
    row(
        "raceway",
        "one",
        1.0,
        time(|| {
            black_box(m.raceway.inner.load::<false>(black_box(&motion.inner)));
        }),
    );
    let mut loads: PerRaceway<RacewayLoad<Lanes>> = PerRaceway::default();
    for set in InstructionSet::available() {
        row(
            "raceway",
            &format!("{set:?}"),
            2.0 * LANES as f64,
            time(|| {
                RacewayContact::pair_of_loads::<false>(&m.raceway, black_box(&several), &mut loads, set);
                black_box(&loads);
            }),
        );
    }
    let pocket = PocketMotion {
        displacement: [5e-6, 10e-6, 20e-6],
        velocity: [0.1, 0.2, -0.1],
        spin: [-11_700.0, 0.0, 0.0],
        oversize: 0.0,
    };
    row(
        "pocket",
        "one",
        1.0,
        time(|| {
            black_box(m.pocket.load(black_box(&pocket)));
        }),
    );
}

fn evaluations(balls: usize, model: &Model) {
    let state = start_state(model).expect("a grown bearing has an equilibrium");
    let mut rate = state.clone();
    let mut jacobian = Jacobian::new(&model.structure());
    let mut factors = ArrowheadFactors::new(&model.structure());
    let mut right_side = state.clone();
    for set in InstructionSet::available() {
        let model = model.clone().with_instructions(set);
        let row = |of: &str, (median, least, largest): (f64, f64, f64)| {
            println!("{balls:>6} {of:>10} {:>9} {median:>9.0} {least:>9.0} … {largest:<8.0}", format!("{set:?}"));
        };
        row("dy/dt", time(|| model.derivative(black_box(0.0), black_box(&state), &mut rate)));
        row(
            "Jacobian",
            time(|| {
                model.jacobian(black_box(0.0), black_box(&state), &[], &[], &mut jacobian);
            }),
        );
        // The terms of a step of 1 µs.
        factors = factors.with_instructions(set);
        row("factors", time(|| factors.factor(black_box(&jacobian), 1e6).expect("a regular matrix")));
        row(
            "solution",
            time(|| {
                right_side.copy_from_slice(black_box(&state));
                factors.solve(&mut right_side);
            }),
        );
    }
}
