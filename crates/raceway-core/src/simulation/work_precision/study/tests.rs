//! Studies of the article's case, short.

use super::*;
use crate::physics::cage::{CageParameters, PocketFilm};
use crate::physics::contact::damping::DampingLaw;
use crate::physics::examples::{article_bearing, article_cage, article_lubricant};
use crate::physics::lubricant::{Lubricant, LubricantKind};
use crate::physics::operation::{Operation, SpeedProfile};
use crate::physics::spindle::{AxialHold, Spindle, SpindleTilt, Unbalance};
use crate::physics::surface::waviness::SurfaceParameters;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::{SceneParameters, Terms};
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::work_precision::errors::MOST_GROWN;

/// The article's case at a speed [rad/s].
fn article(speed: f64, kind: LubricantKind, film: PocketFilm) -> Scene {
    Scene::new(SceneParameters {
        bearing: article_bearing().parameters,
        cage: CageParameters { film, ..article_cage() },
        spindle: Spindle { mass: 0.05, unbalance: Unbalance::None, axial: AxialHold::Fixed, tilt: SpindleTilt::Held },
        operation: Operation {
            speed: SpeedProfile::constant(speed).unwrap(),
            outer_speed: SpeedProfile::at_rest(),
            load: [0.0, 200.0, 0.0],
            loads: Vec::new(),
            misalignment: [0.0; 2],
            perturbation: None,
        },
        lubricant: Lubricant { kind, ..article_lubricant() },
        raceway_damping: DampingLaw::Restitution { restitution: 0.85, at_speed: 0.1 },
        terms: Terms::default(),
        surfaces: SurfaceParameters::default(),
        pocket_deviations: Vec::new(),
        gravity: 9.81,
    })
    .unwrap()
}

fn greased() -> Scene {
    article(5236.0, LubricantKind::Grease, PocketFilm::Wedge)
}

fn settings(settle: f64, duration: f64) -> RunSettings {
    RunSettings {
        method: Method::Auto,
        rung: Some(ModelLevel::Full),
        relative_tolerance: 1e-5,
        tightened: None,
        model_tolerance_db: 0.05,
        fixed_step: None,
        settle,
        duration,
        outputs: Outputs { contacts: true, cage: true, ..Outputs::vibration() },
    }
}

fn plan(relative_tolerances: &[f64]) -> Plan {
    Plan { methods: vec![Method::DormandPrince], relative_tolerances: relative_tolerances.to_vec(), repetitions: 1 }
}

fn studied(scene: &Scene, settings: &RunSettings, plan: &Plan) -> WorkPrecision {
    study(scene, settings, plan, &Control::until(&|| false)).unwrap()
}

#[test]
fn a_point_at_the_references_tolerance_is_below_the_reference() {
    let found = studied(&greased(), &settings(0.0, 0.001), &plan(&[1e-4, 1e-11]));
    assert_eq!((found.begin, found.states), (0.0, 79));
    let below: Vec<bool> = found.points.iter().map(|p| p.measured.as_ref().unwrap().below_reference).collect();
    assert_eq!(below, [false, true]);
    assert!(found.reference.own_trajectory.unwrap().rms > 0.0);
}

#[test]
fn a_study_repeats_bit_for_bit_but_for_its_times() {
    let once = || {
        let found = studied(&greased(), &settings(0.0005, 0.0005), &plan(&[1e-4]));
        found.points.into_iter().map(|point| point.measured).collect::<Vec<_>>()
    };
    assert_eq!(once(), once());
}

/// Dry and without a film the cage rattles: trajectories part, and are compared only as long as they have something in
/// common; the level is judged by its scatter.
#[test]
fn chaotic_motion_is_compared_over_a_stated_horizon() {
    let scene = article(5236.0, LubricantKind::Dry, PocketFilm::None);
    let found = studied(&scene, &settings(0.01, 0.006), &plan(&[1e-3, 1e-5]));
    assert_eq!(found.motion, Some(MotionKind::Diverging), "{}", found.divergence_rate);
    let compared: Vec<f64> = found
        .points
        .iter()
        .map(|point| point.measured.as_ref().unwrap().errors.trajectory.map_or(0.0, |error| error.compared))
        .collect();
    let horizon = |tolerance: f64| (MOST_GROWN / tolerance).ln() / found.divergence_rate;
    for (compared, tolerance) in compared.iter().zip([1e-3, 1e-5]) {
        let whole = found.grid.0 * found.grid.1 as f64;
        assert!((compared - horizon(tolerance).min(whole)).abs() <= found.grid.0, "{compared} at {tolerance}");
    }
    assert!(found.reference.sampling_error_db > Some(0.0));
    // The reference's own over the whole time would say that trajectories are unknown, not how good the points are.
    assert_eq!(found.reference.own_trajectory, None);
    assert!(found.points[1].measured.as_ref().unwrap().own_trajectory.is_some());
}

#[test]
fn a_run_that_takes_too_many_evaluations_has_failed_and_tighter_ones_are_not_tried() {
    let scene = greased();
    let settings = settings(0.0, 0.0005);
    let needs = ActiveTerms::of(&scene, &settings.outputs, settings.rung).unwrap();
    let model = Model::new(&scene, &needs);
    let control = Control::until(&|| false);
    let course = Course::settled(&model, &needs, &settings, start_state(&model).unwrap(), &control).unwrap();
    let mut references = references(&course, &control).unwrap();
    // References as cheap as possible.
    references.first.statistics.rhs_evaluations = 100;
    references.check = None;
    let comparison = Comparison::new(&scene, &course, &references.first, 0.0);
    let reference = described(&references, &comparison, None);
    assert_eq!((reference.check, reference.own_error_db), (None, None));
    let points = points(&course, &references, &reference, &comparison, &plan(&[1e-4, 1e-3]), &control).unwrap();
    let reasons: Vec<&str> = points.iter().map(|point| point.measured.as_ref().unwrap_err().as_str()).collect();
    assert!(reasons[0].contains("a run may take 2000"), "{reasons:?}");
    assert!(reasons[1].starts_with("not tried"), "{reasons:?}");
    assert_eq!((points[0].taken.len(), points[1].taken.len()), (1, 0));
    assert_eq!(points[0].relative_tolerance, 1e-3);
}

#[test]
fn a_scene_at_rest_has_no_level_to_compare() {
    let scene = article(0.0, LubricantKind::Grease, PocketFilm::Wedge);
    let found = studied(&scene, &settings(0.0, 0.001), &plan(&[1e-4]));
    let measured = found.points[0].measured.as_ref().unwrap();
    assert!(measured.errors.trajectory.is_some() && measured.errors.is_finite());
}
