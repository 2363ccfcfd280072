//! Balls in the lanes of a vector: the same bits with every instruction set and any number of balls.

use raceway::numerics::lanes::InstructionSet;
use raceway::numerics::ode::Method;
use raceway::numerics::ode::OdeSystem;
use raceway::numerics::ode::structure::Jacobian;
use raceway::simulation::input::control::Control;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::RunSettings;
use raceway::simulation::model::radially_condensed::{RadiallyCondensed, StepRatio};
use serde_json::{Value, json};

use crate::scenes::{
    article, carrying_defects, changed, defects, disturbed, everything, model_on, nothing_asked, rates, scene, unequal,
    uneven_balls, waves,
};

const TIME: f64 = 2.3e-4;

/// Scenes that together contain every law and every term.
fn scenes() -> Vec<(Value, ModelLevel)> {
    let everything_with = |change: Value| changed(everything(), change);
    let traction = |law: Value| everything_with(json!({ "lubricant": { "traction": law } }));
    vec![
        (article(), ModelLevel::Full),
        (article(), ModelLevel::Planar),
        (everything(), ModelLevel::Full),
        (everything_with(json!({ "operation": { "misalignment_mrad": { "y": 0.3 } } })), ModelLevel::Full),
        (changed(article(), json!({ "lubricant": "dry", "bearing": { "ball_count": 8 } })), ModelLevel::Full),
        (everything_with(json!({ "terms": { "drag": "on", "churning": "on" } })), ModelLevel::Full),
        (traction(json!({ "law": "four_parameter", "at_rest": 0.02 })), ModelLevel::Full),
        (traction(json!({ "law": "eyring" })), ModelLevel::Full),
        (traction(json!({ "law": "coulomb" })), ModelLevel::Full),
        (everything_with(waves()), ModelLevel::Full),
        (
            everything_with(changed(waves(), json!({ "operation": { "misalignment_mrad": { "y": 0.3 } } }))),
            ModelLevel::Full,
        ),
        (changed(article(), waves()), ModelLevel::Planar),
        (everything_with(unequal()), ModelLevel::Full),
        (everything_with(defects(0.1)), ModelLevel::Full),
        (changed(article(), defects(0.0)), ModelLevel::Planar),
        (everything_with(uneven_balls(5.0)), ModelLevel::Full),
        (changed(article(), uneven_balls(0.0)), ModelLevel::Planar),
    ]
}

/// Rates and Jacobians to the bit, with every instruction set of this machine.
#[test]
fn every_set_of_instructions_gives_the_same_bits() {
    let crowded = changed(everything(), json!({ "bearing": { "ball_count": 14 }, "terms": { "cage": "off" } }));
    for (json, rung) in scenes().into_iter().chain([(crowded, ModelLevel::Full)]) {
        let model = model_on(&json, Some(rung));
        for seed in 1..=3 {
            let state = disturbed(&model, seed);
            let by = |set: InstructionSet| {
                let model = model.clone().with_instructions(set);
                let mut jacobian = Jacobian::new(&model.structure());
                model.jacobian(TIME, &state, &[], &[], &mut jacobian);
                let bits: Vec<u64> = rates(&model, TIME, &state).iter().map(|rate| rate.to_bits()).collect();
                (bits, format!("{jacobian:?}"))
            };
            let baseline = by(InstructionSet::BASELINE);
            for set in InstructionSet::available() {
                assert!(by(set) == baseline, "{set:?} {rung:?} {json}");
            }
        }
    }
}

/// A run of the radially condensed model to the bit: two groups of balls, pocket walls, slip beyond the range of the fit,
/// viscous raceways, every traction law, waves, defects.
#[test]
fn runs_of_the_condensed_rung_have_the_same_bits() {
    let with = |change: Value| changed(article(), change);
    let scenes = [
        article(),
        with(
            json!({ "bearing": { "ball_count": 9, "pitch_diameter_mm": 14, "outer_diameter_mm": 19, "inner_diameter_mm": 9.5, "cage": { "film": "none" } } }),
        ),
        with(json!({ "lubricant": { "traction": { "law": "four_parameter", "at_slip_m_s": 0.01 } } })),
        with(json!({ "damping": { "raceway": { "law": "viscous", "viscous_n_s_per_m": 50.0 } } })),
        with(json!({ "lubricant": { "kind": "oil" }, "terms": { "hydrodynamics": "on" } })),
        with(waves()),
        with(carrying_defects()),
        with(unequal()),
        with(changed(waves(), json!({ "lubricant": { "traction": { "law": "eyring" } } }))),
    ];
    let settings = RunSettings {
        method: Method::Auto,
        rung: None,
        relative_tolerance: 1e-7,
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: 1e-3,
        duration: 2e-3,
        outputs: nothing_asked(),
    };
    let control = Control::until(&|| false);
    for json in scenes {
        let model = RadiallyCondensed::new(&scene(&json), &settings.outputs).unwrap();
        let by = |set: InstructionSet, ratio: StepRatio| {
            let (recording, _) = model.clone().with_instructions(set).run(&settings, ratio, &control).unwrap();
            assert!(
                recording.signals.iter().filter_map(|signal| signal.values()).flatten().all(|value| value.is_finite())
            );
            format!("{recording:?}")
        };
        for ratio in std::iter::once(model.step_ratio()).chain(model.longer_step_ratios()) {
            let baseline = by(InstructionSet::BASELINE, ratio);
            for set in InstructionSet::available() {
                assert!(by(set, ratio) == baseline, "{set:?} {ratio:?} {json}");
            }
        }
    }
}

/// The rates of a ball do not depend on the other lanes. Cage and spindle keep their places; the reference has the same ball
/// in contact alone.
#[test]
fn a_ball_does_not_depend_on_its_neighbours() {
    for (json, rung) in scenes() {
        let model = model_on(&json, Some(rung));
        let layout = model.mechanism().layout;
        let state = disturbed(&model, 5);
        let together = rates(&model, TIME, &state);
        for ball in 0..layout.balls {
            // The other balls are far from every contact.
            let mut alone = state.clone();
            for other in (0..layout.balls).filter(|other| *other != ball) {
                let mut lonely = layout.ball(&alone, other);
                lonely.radial = 0.0;
                lonely.axial = 0.0;
                layout.set_ball(&mut alone, other, &lonely);
            }
            assert_eq!(
                layout.ball(&rates(&model, TIME, &alone), ball),
                layout.ball(&together, ball),
                "{rung:?} {json}"
            );
        }
    }
}
