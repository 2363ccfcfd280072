//! Model levels that can solve a scene, and the terms that each omits.

use std::f64::consts::TAU;

use crate::numerics::ode::Method;
use crate::physics::bearing::PerRaceway;
use crate::physics::kinematics;
use crate::simulation::error::codes::{Ineligible, NotEligible, NotEligibleReason};
use crate::simulation::error::thresholds::{
    CROWN_MASS, CROWN_OFFSET, LATE_TILT_VISCOSITY, LEAN_SHARE, MIN_WINDOW_S, MIN_WINDOW_SETTLE_S, TILT_VISCOSITY,
    WINDOW_PASSAGES, WINDOW_RUN_SHARE, WINDOW_S, WINDOW_SETTLE_S, WINDOW_SHARE,
};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::{Scene, Term, TermChoice};
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::omission::{Condensation, OmissionReason};
use crate::simulation::model::radially_condensed;
use crate::simulation::model::terms::{ActiveTerms, Justification, LeftOut, UnsupportedChoice};
use crate::simulation::model::{periodic, spindle_only};

/// Ball passages in the time that represents a motion [-], and the range of this time [s].
const REPRESENTATIVE_PASSAGES: f64 = 20.0;
const REPRESENTATIVE_RANGE_S: [f64; 2] = [0.1, 1.0];

/// Terms whose dynamics every reduced model omits.
const DYNAMICS: [Term; 3] = [Term::BallRadialDynamics, Term::BallSpinDynamics, Term::CageTilt];

/// The model levels that are tried, the cheapest first, and those that are not.
#[derive(Debug, Clone)]
pub struct Eligibility {
    pub levels: Vec<ModelLevel>,
    pub not_eligible: Vec<NotEligible>,
}

impl Eligibility {
    /// The selected level alone, or the eligible reduced ones and the dynamics.
    pub fn of(scene: &Scene, settings: &RunSettings) -> Result<Self, UnsupportedChoice> {
        if let Some(level) = settings.rung {
            return Ok(Self { levels: vec![level], not_eligible: Vec::new() });
        }
        let dynamics = ActiveTerms::of(scene, &settings.outputs, None)?;
        let known = |levels: Vec<ModelLevel>, reason| NotEligible { levels, reason: NotEligibleReason::Known(reason) };
        let (mut levels, mut not_eligible) = (Vec::new(), Vec::new());
        if let Some(reason) = no_reduced_model(scene, settings, &dynamics) {
            not_eligible.push(known(ModelLevel::REDUCED.to_vec(), reason));
        } else {
            let tilt = tilt_risk(scene);
            if let Some(reason) = tilt {
                not_eligible.push(known(vec![ModelLevel::Periodic, ModelLevel::SpindleOnly], reason));
            }
            for level in ModelLevel::REDUCED {
                match cannot_represent(level, scene, &dynamics, &settings.outputs) {
                    Some(reason) => {
                        let reason = NotEligibleReason::CannotRepresent(reason);
                        match not_eligible.iter_mut().find(|other: &&mut NotEligible| other.reason == reason) {
                            Some(other) => other.levels.push(level),
                            None => not_eligible.push(NotEligible { levels: vec![level], reason }),
                        }
                    }
                    None if level == ModelLevel::RadiallyCondensed || tilt.is_none() => levels.push(level),
                    None => {}
                }
            }
        }
        levels.push(dynamics.rung);
        Ok(Self { levels, not_eligible })
    }
}

/// Terms of the equations on a selected level, or on the dynamics that the scene needs.
pub fn active_terms(
    scene: &Scene,
    outputs: &Outputs,
    level: Option<ModelLevel>,
) -> Result<ActiveTerms, UnsupportedChoice> {
    let Some(level) = level.filter(|level| level.is_reduced()) else {
        if level == Some(ModelLevel::Full) && scene.terms.get(Term::CageTilt) == TermChoice::Off {
            return Err(UnsupportedChoice::ModelLevel {
                rung: ModelLevel::Full,
                reason: Inapplicable::TermOff(Term::CageTilt),
            });
        }
        return ActiveTerms::of(scene, outputs, level);
    };
    if let Some(reason) =
        cannot_represent(level, scene, &ActiveTerms::of(scene, outputs, Some(ModelLevel::Full))?, outputs)
    {
        return Err(UnsupportedChoice::ModelLevel { rung: level, reason });
    }
    let mut terms = ActiveTerms::of(scene, outputs, Some(ModelLevel::Planar))?;
    let is_tilt = |left_out: &LeftOut| left_out.term == Term::CageTilt.name();
    terms.left_out.retain(|left_out| !is_tilt(left_out) || left_out.by == Justification::Identity);
    let may_tilt = !terms.left_out.iter().any(is_tilt);
    terms.left_out.extend(omissions(level, may_tilt));
    Ok(terms)
}

/// Terms that a reduced model leaves out; the bound of all together is the error that its verification shows.
pub(crate) fn omissions(level: ModelLevel, may_tilt: bool) -> Vec<LeftOut> {
    let one = |term: Term, condensation| LeftOut {
        term: term.name(),
        reason: OmissionReason::Condensed(level, condensation),
        by: Justification::Judgement,
        bound: None,
    };
    let mut all = vec![one(Term::BallRadialDynamics, Condensation::RadialEquilibrium)];
    if may_tilt {
        all.push(one(Term::CageTilt, Condensation::StaysInPlane));
    }
    if level != ModelLevel::RadiallyCondensed {
        all.push(one(Term::Cage, Condensation::EqualSpacing));
        all.push(one(Term::BallSpinDynamics, Condensation::IdealRolling));
    }
    all
}

/// Share of the tolerance that the deviation of a model from the next richer one may take [dB].
pub fn allowed_deviation(level: ModelLevel, model_tolerance_db: f64) -> f64 {
    match level {
        ModelLevel::SpindleOnly | ModelLevel::Periodic => LEAN_SHARE * model_tolerance_db,
        _ => model_tolerance_db,
    }
}

/// Reason why a reduced model cannot represent a scene or its outputs; `None` if it can.
fn cannot_represent(level: ModelLevel, scene: &Scene, terms: &ActiveTerms, outputs: &Outputs) -> Option<Inapplicable> {
    // The leaner models are verified by the condensed one.
    let condensed = || radially_condensed::inapplicability(scene, outputs);
    match level {
        ModelLevel::Full | ModelLevel::Planar => None,
        ModelLevel::RadiallyCondensed => condensed(),
        ModelLevel::SpindleOnly => spindle_only::inapplicability(scene, terms, outputs).or_else(condensed),
        ModelLevel::Periodic => periodic::inapplicability(scene, terms, outputs).or_else(condensed),
    }
}

fn no_reduced_model(scene: &Scene, settings: &RunSettings, terms: &ActiveTerms) -> Option<Ineligible> {
    if settings.method != Method::Auto || settings.fixed_step.is_some() {
        Some(Ineligible::MethodSelected)
    } else if settings.model_tolerance_db == 0.0 {
        Some(Ineligible::NoModelError)
    } else if DYNAMICS.iter().any(|term| scene.terms.get(*term) == TermChoice::On) {
        Some(Ineligible::TermOn)
    } else if terms.raceway.hydrodynamics {
        Some(Ineligible::Hydrodynamics)
    } else if !scene.operation.has_constant_speeds() {
        Some(Ineligible::SpeedChanges)
    } else if !scene.operation.is_steady() {
        Some(Ineligible::LoadsChange)
    } else if window_time(scene, settings) > WINDOW_SHARE * (settings.settle + settings.duration) {
        Some(Ineligible::ShortRun)
    } else {
        None
    }
}

/// Reason why the planar verification of the leanest models does not show tilt; `None` if tilt is not expected.
pub fn tilt_risk(scene: &Scene) -> Option<Ineligible> {
    if may_tilt(scene) {
        Some(Ineligible::MayTilt)
    } else if is_heavy_crown(scene) {
        Some(Ineligible::HeavyCage)
    } else {
        None
    }
}

/// True if the lubricant is so viscous at this speed that cage and balls may tilt.
pub fn may_tilt(scene: &Scene) -> bool {
    can_tilt(scene) && scene.lubricant.viscosity > TILT_VISCOSITY * scene.operating_speeds().relative().abs()
}

/// True if cage and balls may begin to tilt late in a run.
pub fn may_tilt_late(scene: &Scene) -> bool {
    can_tilt(scene) && scene.lubricant.viscosity > LATE_TILT_VISCOSITY * scene.operating_speeds().relative().abs()
}

/// True if something moves the cage out of the plane: the seats of a crown, or a push at the start.
fn can_tilt(scene: &Scene) -> bool {
    !scene.cage.is_symmetric() || scene.operation.perturbation.is_some()
}

/// True if weight and inertia of the cage, which act outside the plane of the balls, may move the balls out of this plane.
fn is_heavy_crown(scene: &Scene) -> bool {
    let (cage, bearing) = (&scene.cage, &scene.bearing);
    let balls = bearing.parameters.ball_count as f64 * bearing.ball_mass;
    !cage.is_symmetric()
        && (cage.mass > CROWN_MASS * balls || cage.offset.abs() > CROWN_OFFSET * bearing.parameters.ball_diameter)
}

/// Time from one ball passage under the load to the next [s]; infinite at rest.
pub fn ball_passage(scene: &Scene) -> f64 {
    let orbit = scene.operating_speeds().carried(kinematics::ideal_orbit_ratio(&scene.bearing)).abs();
    TAU / (scene.bearing.parameters.ball_count as f64 * orbit)
}

/// Recorded time that represents a motion at constant speed [s]: 20 ball passages, at least 0.1 s and at most 1 s; 0.1 s at rest. At least a turn
/// of the cage whose balls differ, and a period of each harmonic load up to 1 s.
pub fn representative_time(scene: &Scene) -> f64 {
    let [least, most] = REPRESENTATIVE_RANGE_S;
    let time = REPRESENTATIVE_PASSAGES * ball_passage(scene);
    let passages = if time.is_finite() { time.clamp(least, most) } else { least };
    passages.max(turn_of_unequal_balls(scene)).max(longest_load_period(scene).min(most))
}

/// Time after which the motion meets the same events again [s]: a ball passage, or a turn of the ring or of the cage that carries a defect
/// through the load.
pub fn longest_passage(scene: &Scene) -> f64 {
    let on = |has_defects: bool, turn: f64| if has_defects { turn } else { 0.0 };
    let shaft = on(scene.surfaces.raceway.inner.has_defects(), TAU / scene.operating_speed().abs());
    let outer = turn_of_outer_ring(scene, scene.surfaces.raceway.outer.has_defects());
    let cage = on(scene.surfaces.balls_have_defects(), cage_turn(scene));
    ball_passage(scene).max(shaft).max(outer).max(cage)
}

/// Time of a turn of the cage [s]; infinite at rest.
fn cage_turn(scene: &Scene) -> f64 {
    scene.bearing.parameters.ball_count as f64 * ball_passage(scene)
}

/// Times of a verification against a richer model: before its window, and of the window [s].
pub fn window_times(scene: &Scene, settings: &RunSettings) -> (f64, f64) {
    let passage = longest_passage(scene);
    let share = WINDOW_RUN_SHARE * (settings.settle + settings.duration);
    let settle = share.clamp(MIN_WINDOW_SETTLE_S, WINDOW_SETTLE_S);
    let turns = turn_of_waves(scene).max(turn_of_unequal_balls(scene));
    let window = share.clamp(MIN_WINDOW_S, WINDOW_S).max(turns).max(longest_load_period(scene));
    (passage.max(settle), (WINDOW_PASSAGES * passage).max(window))
}

/// Time in which every wave of rings that turn has passed the load [s]; 0 on ideal rings. Waves of an outer ring that stands repeat with each
/// ball passage.
fn turn_of_waves(scene: &Scene) -> f64 {
    let PerRaceway { inner, outer } = &scene.surfaces.raceway;
    let shaft = if inner.is_ideal() { 0.0 } else { TAU / scene.operating_speed().abs() };
    shaft.max(turn_of_outer_ring(scene, !outer.is_ideal()))
}

/// Time of a turn of the outer ring [s]; 0 where it stands, or is not uneven.
fn turn_of_outer_ring(scene: &Scene, is_uneven: bool) -> f64 {
    let speed = scene.operation.outer_speed.largest();
    if is_uneven && speed > 0.0 { TAU / speed } else { 0.0 }
}

/// Time in which every ball has passed the load, a turn of the cage [s]; 0 where all balls are alike and equally spaced.
pub fn turn_of_unequal_balls(scene: &Scene) -> f64 {
    let turn = cage_turn(scene);
    if scene.has_unequal_balls() && turn.is_finite() { turn } else { 0.0 }
}

/// Period of the slowest harmonic load [s]; 0 without one.
pub fn longest_load_period(scene: &Scene) -> f64 {
    scene.operation.longest_load_period()
}

/// Time that the richer model simulates to verify a reduced one [s].
pub fn window_time(scene: &Scene, settings: &RunSettings) -> f64 {
    let (settle, window) = window_times(scene, settings);
    settle + window
}
