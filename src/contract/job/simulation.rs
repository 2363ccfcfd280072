//! One simulation, checked. Jobs of every kind have one: the run itself, or what all their runs share.

use raceway_core::physics::bearing::PerRaceway;
use raceway_core::physics::surface::defects::Recess;
use raceway_core::physics::surface::sphere::BallRecess;
use raceway_core::simulation::input::model_level::ModelLevel;
use raceway_core::simulation::input::scene::Scene;
use raceway_core::simulation::input::settings::RunSettings;
use raceway_core::simulation::model::Mechanism;
use raceway_core::simulation::model::surfaces::{AveragedBall, averaged_balls, averaged_surfaces};
use raceway_core::simulation::model::terms::{ActiveTerms, UnsupportedChoice};
use raceway_core::simulation::solve::eligibility::active_terms;
use raceway_core::simulation::solve::plan::model_levels;
use serde_json::{Value, json};

use super::input::JobInput;
use super::kind::JobKind;
use super::outputs::{OutputsInput, USUAL_SPECTRA};
use super::recorded_turns::RecordedTurns;
use super::solver::{Solver, SolverInput};
use super::submission::{Submission, all_errors};
use super::times;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::given_fields::given_fields;
use crate::contract::json::limits;
use crate::contract::json::numbers::short;
use crate::contract::json::problem::{FieldError, Refusal};
use crate::contract::json::typed::typed_with_errors;
use crate::contract::json::units::{MM, US};
use crate::contract::json::uploads::Uploads;
use crate::contract::scene::mounting::OperatingClearance;
use crate::contract::scene::scene_input::ResolvedScene;

/// A checked simulation: scene, settings and model.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    pub submission: Submission,
    pub resolved: ResolvedScene,
    /// For an accuracy job: times, outputs and model level. Method and tolerance are those of its plan.
    pub settings: RunSettings,
    /// Model levels that are tried, the cheapest first.
    pub model_levels: Vec<ModelLevel>,
    /// Terms of the equations on the last of these levels.
    pub terms: ActiveTerms,
    /// Solver and outputs with all defaults, as in a request.
    pub solver: SolverInput,
    pub outputs: OutputsInput,
}

impl Simulation {
    /// The simulation of a request of this kind.
    pub fn of(request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let mut draft = Draft::of(JobKind::Simulation, request, uploads)?;
        let settings = draft.settings();
        draft.simulation(settings, model_levels)
    }

    pub fn scene(&self) -> &Scene {
        &self.resolved.scene
    }

    /// The scene with all defaults, as in a request.
    pub fn scene_json(&self) -> Value {
        given_fields(&self.resolved.input)
    }

    /// The simulation with all defaults, without the fields that concern only the service.
    pub fn complete(&self) -> Value {
        json!({
            "kind": JobKind::Simulation.name(),
            "scene": self.scene_json(),
            "solver": given_fields(&self.solver),
            "outputs": given_fields(&self.outputs),
            "settle_s": self.settings.settle,
            "duration_s": self.settings.duration,
        })
    }

    /// Everything that determines the result, as text: equal for equal work, whichever fields were left to their default.
    pub fn canonical(&self) -> String {
        self.complete().to_string()
    }

    /// Canonical text of the same simulation with the usual spectra; its metrics are the same.
    pub fn canonical_with_usual_spectra(&self) -> String {
        let mut simulation = self.complete();
        simulation["outputs"]["spectra"] = json!(USUAL_SPECTRA);
        simulation.to_string()
    }
}

/// A request while it is checked.
pub struct Draft {
    kind: JobKind,
    pub request: Value,
    pub input: JobInput,
    pub defaults: Defaults,
    /// Fields that could not be read.
    unread: Vec<FieldError>,
    resolved: Option<ResolvedScene>,
    scene_errors: Vec<FieldError>,
}

impl Draft {
    /// Reads a request of this kind and checks its scene.
    pub fn of(kind: JobKind, request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let (input, unread) = typed_with_errors::<JobInput>(&request);
        let unread: Vec<FieldError> = unread.into_iter().map(limits::with_range).collect();
        let Some(input) = input else { return Err(Refusal::Invalid { errors: unread }) };
        let (resolved, scene_errors) = if unread.iter().any(|error| error.concerns("/scene")) {
            (None, input.scene.clone().errors_without(&unread, uploads))
        } else {
            match input.scene.clone().resolve(uploads) {
                Ok(resolved) => (Some(resolved), Vec::new()),
                Err(errors) => (None, errors),
            }
        };
        let mut defaults = Defaults::default();
        kind.refuse_fields_of_other_kinds(&request, &mut defaults);
        Ok(Self { kind, request, input, defaults, unread, resolved, scene_errors })
    }

    /// The scene with all defaults, as in a request; `None` where it has errors.
    pub fn scene_json(&self) -> Option<Value> {
        self.resolved.as_ref().map(|resolved| given_fields(&resolved.input))
    }

    /// Clearance of a group in operation; `None` where the bearing has none, or the scene has errors.
    pub fn operating_clearance(&self) -> Option<&OperatingClearance> {
        self.resolved.as_ref()?.ordered.clearance.as_ref()
    }

    /// Settings of a run.
    pub fn settings(&mut self) -> RunSettings {
        let scene = self.resolved.as_ref().map(|resolved| &resolved.scene);
        let (input, defaults) = (&mut self.input, &mut self.defaults);
        let solver = input.solver.get_or_insert_default().resolve(defaults);
        let outputs = input.outputs.get_or_insert_default().resolve(defaults, scene);
        let settle = times::settle(&mut input.settle_s, times::default_settle(scene), defaults);
        let default_duration = times::default_duration(scene, settle);
        let duration = times::duration(&mut input.duration_s, default_duration, &outputs, defaults);
        if let (Some(orders), Some(scene)) = (&mut input.outputs.get_or_insert_default().orders, scene) {
            orders.resolve(&RecordedTurns::of(scene, settle, duration), defaults);
        }
        let Solver { method, rung, mut relative_tolerance, mut tightened, model_tolerance_db, fixed_step } = solver;
        if !outputs.series.is_empty() {
            // No verification covers every value of a series.
            relative_tolerance = tightened.take().unwrap_or(relative_tolerance);
        }
        RunSettings {
            method,
            rung,
            relative_tolerance,
            tightened,
            model_tolerance_db,
            fixed_step,
            settle,
            duration,
            outputs,
        }
    }

    /// The checked simulation, or all errors of the request. `levels` returns the model levels to try.
    pub fn simulation(
        mut self,
        settings: RunSettings,
        levels: impl Fn(&Scene, &RunSettings) -> Result<Vec<ModelLevel>, UnsupportedChoice>,
    ) -> Result<Simulation, Refusal> {
        let submission = Submission::of(self.request, &mut self.input.service(), &mut self.defaults);
        // A missing term may be one of the fields that could not be read.
        let readable = self.resolved.as_ref().filter(|_| self.unread.is_empty());
        let model = readable.map(|resolved| model(resolved, &settings, levels));
        let model = match model {
            Some(Err(error)) if !self.defaults.errors.iter().any(|known| known.pointer == error.pointer) => {
                self.defaults.errors.push(error);
                None
            }
            model => model.and_then(Result::ok),
        };
        let mut errors = self.scene_errors;
        errors.append(&mut self.defaults.errors);
        let errors = all_errors(self.unread, errors);
        let (Some(mut resolved), Some((terms, model_levels)), true) = (self.resolved, model, errors.is_empty()) else {
            return Err(Refusal::Invalid { errors });
        };
        resolved.defaults.append(&mut self.defaults.filled);
        let submission = Submission { reuse: self.kind != JobKind::Accuracy && submission.reuse, ..submission };
        Ok(Simulation {
            submission,
            resolved,
            settings,
            model_levels,
            terms,
            solver: self.input.solver.unwrap_or_default(),
            outputs: self.input.outputs.unwrap_or_default(),
        })
    }
}

/// Terms of the equations, and the model levels that are tried.
fn model(
    resolved: &ResolvedScene,
    settings: &RunSettings,
    levels: impl Fn(&Scene, &RunSettings) -> Result<Vec<ModelLevel>, UnsupportedChoice>,
) -> Result<(ActiveTerms, Vec<ModelLevel>), FieldError> {
    let scene = &resolved.scene;
    let needs = active_terms(scene, &settings.outputs, settings.rung).map_err(unmet)?;
    check_defects(resolved, &needs, settings.fixed_step)?;
    Ok((needs, levels(scene, settings).map_err(unmet)?))
}

/// Refuses defects that leave no ideal part of their raceway, and steps that would pass over a defect.
fn check_defects(resolved: &ResolvedScene, terms: &ActiveTerms, fixed_step: Option<f64>) -> Result<(), FieldError> {
    let scene = &resolved.scene;
    let rings = &scene.surfaces.raceway;
    let of_balls = scene.surfaces.balls.iter().any(|ball| !ball.defects.is_empty());
    if rings.inner.defects.is_empty() && rings.outer.defects.is_empty() && !of_balls {
        return Ok(());
    }
    let mechanism = Mechanism::new(scene, terms);
    let Some(surfaces) = averaged_surfaces(&mechanism, scene) else { return Ok(()) };
    if of_balls {
        check_ball_defects(&averaged_balls(&mechanism, scene), resolved, fixed_step)?;
    }
    for (ring, given, averaged) in [("inner", &rings.inner, &surfaces.inner), ("outer", &rings.outer, &surfaces.outer)]
    {
        for recess in &averaged.defects {
            if recess.leaves_no_raceway() {
                let index = given.defects.iter().position(|defect| *defect == recess.defect).unwrap_or_default();
                let (length, longest) = (MM.to_user(recess.defect.length), MM.to_user(recess.longest_length()));
                let pointer = format!("/scene/surfaces/{ring}/defects/{index}/length_mm");
                let detail =
                    format!("{} mm: must be below {} mm, the raceway less two contacts", short(length), short(longest));
                return Err(FieldError::new(pointer, detail));
            }
        }
        let longest = averaged.defects.iter().map(Recess::longest_step).fold(f64::INFINITY, f64::min);
        if let Some(step) = fixed_step.filter(|step| *step > longest) {
            let (step, longest) = (short(US.to_user(step)), short(US.to_user(longest)));
            let detail =
                format!("{step} µs: at most {longest} µs resolve the defects of the {ring} raceway at this speed");
            return Err(FieldError::new("/solver/fixed_step_us", detail));
        }
    }
    Ok(())
}

/// Refuses defects of balls that leave no ideal part of their hemisphere, and steps that would pass over a defect.
fn check_ball_defects(
    balls: &[PerRaceway<AveragedBall>],
    resolved: &ResolvedScene,
    fixed_step: Option<f64>,
) -> Result<(), FieldError> {
    for (index, ball) in balls.iter().enumerate() {
        for BallRecess { recess, .. } in ball.inner.defects.iter().chain(&ball.outer.defects) {
            let longest = 2.0 * recess.contact.radius - 4.0 * recess.contact.half_width;
            if recess.defect.length >= longest {
                let (diameter, longest) = (short(MM.to_user(recess.defect.length)), short(MM.to_user(longest)));
                let detail = format!("{diameter} mm: must be below {longest} mm, the ball less two contacts");
                let given = resolved.input.surfaces.iter().flat_map(|surfaces| surfaces.balls.iter().flatten());
                let item = given.map(|given| given.ball as usize).position(|ball| ball == index + 1);
                let defects = &resolved.scene.surfaces.balls[index].defects;
                let defect = defects.iter().position(|defect| defect.diameter == recess.defect.length);
                let (item, defect) = (item.unwrap_or_default(), defect.unwrap_or_default());
                let pointer = format!("/scene/surfaces/balls/{item}/defects/{defect}/diameter_mm");
                return Err(FieldError::new(pointer, detail));
            }
            let longest = recess.longest_step();
            if let Some(step) = fixed_step.filter(|step| *step > longest) {
                let (step, longest) = (short(US.to_user(step)), short(US.to_user(longest)));
                let detail =
                    format!("{step} µs: at most {longest} µs resolve the defects of ball {} at this speed", index + 1);
                return Err(FieldError::new("/solver/fixed_step_us", detail));
            }
        }
    }
    Ok(())
}

/// Least and greatest magnitude of the shaft speed of a request [r/min]; `None` where it is constant.
pub fn varying_speed_rpm(request: &Value) -> Option<[f64; 2]> {
    let points = request.pointer("/scene/operation/speed_rpm")?.as_array()?;
    let speeds: Vec<f64> = points.iter().filter_map(|point| point.get("rpm")?.as_f64()).collect();
    let (first, has) = (*speeds.first()?, |sign: f64| speeds.iter().any(|speed| sign * speed > 0.0));
    let most = speeds.iter().fold(0.0, |most: f64, speed| most.max(speed.abs()));
    let least =
        if has(1.0) && has(-1.0) { 0.0 } else { speeds.iter().fold(most, |least, speed| least.min(speed.abs())) };
    speeds.iter().any(|speed| *speed != first).then_some([least, most])
}

/// The field whose value the scene or the outputs exclude.
fn unmet(unmet: UnsupportedChoice) -> FieldError {
    let pointer = match &unmet {
        UnsupportedChoice::ModelLevel { .. } => "/solver/rung".to_owned(),
        UnsupportedChoice::Term { term, .. } => format!("/scene/terms/{}", term.name()),
    };
    FieldError::new(pointer, unmet.to_string())
}
