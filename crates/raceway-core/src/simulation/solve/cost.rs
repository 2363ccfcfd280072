//! Estimated cost of a plan before it runs. The estimate is an order of magnitude. It does not foresee impacts, loads that grow later, or levels
//! below the noise of the steps.

use crate::numerics::lanes::LANES;
use crate::numerics::ode::Method;
use crate::physics::raceway::RacewayTerms;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::equilibrium::start_state;
use crate::simulation::model::radially_condensed::{RadiallyCondensed, StepRatio};
use crate::simulation::model::stiffness::{FastestMode, fastest_mode};
use crate::simulation::model::system::Model;
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::recording::sampling::kept_values;
use crate::simulation::solve::eligibility::window_time;
use crate::simulation::solve::fixed_step;
use crate::simulation::solve::plan::{Candidate, CandidateSteps, Plan};

/// Time of one ball in one evaluation of the equations [s], and additional time of each point of its two contacts [s]. Measured on one core of a
/// slow shared server with AVX2: `cargo bench --bench contact`. Hydrodynamic forces multiply the time by the last factor [-].
const SECONDS_PER_BALL: f64 = 0.04e-6;
const SECONDS_PER_POINT: f64 = 0.0055e-6;
const HYDRODYNAMIC: f64 = 1.4;
/// Evaluations of a fixed step, implicit parts included, of an explicit step, and of a step of a stiff method [-].
const FIXED_STEP_EVALUATIONS: f64 = 2.5;
const EXPLICIT_EVALUATIONS: f64 = 6.0;
const STIFF_EVALUATIONS: f64 = 6.0;
/// Step of a stiff method in the article's case [s] at this tolerance; it falls with the sixth root of the tolerance.
const STIFF_STEP: f64 = 1e-6;
const STIFF_TOLERANCE: f64 = 1e-5;
/// Longest step that accuracy allows where stability does not bind [s].
const SMOOTH_STEP: f64 = 20e-6;
/// Evaluations for each recorded value [-].
const SAMPLE_EVALUATIONS: f64 = 2.0;
/// Speed of the condensed model on that machine without verification, over real time [-], and factor on the time for general traction [-].
const CONDENSED_REAL_TIME_FACTOR: f64 = 20.0;
const GENERAL_TRACTION: f64 = 12.0;
/// Windows of the dynamics that verify a reduced model, in fixed steps [-]: half steps, and a share of longer windows.
const WINDOW_RUNS: f64 = 3.0;
/// Cost of a verified run of the dynamics over that of the run [-].
const VERIFIED: f64 = 2.0;
/// Largest factor on the cost of error control by impacts and by levels below the noise of the steps [-].
const UNFORESEEN: f64 = 20.0;
/// Exponent of the cost of all candidates over that of the first [-]. Of 406 jobs of `benches/coverage`, 89 % then take 0.1 to 10 times the
/// estimate and half a third to three times; 0.15 has 82 %. Of 183 jobs of `benches/compare`, 95 % take 0.1 to 10 times the estimate with both.
const LIKELY_SHARE: f64 = 0.3;
/// Longest estimate [s]; a run that long never finishes.
const LONGEST: f64 = 1e12;

/// The cost of a plan on one core.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// First-order states of the last candidate.
    pub states: usize,
    /// Likely wall time, and that of all candidates at most [s]; `None`: the run has no equilibrium to start from. The first candidate usually
    /// suffices, and sometimes all are needed.
    pub wall_time: Option<(f64, f64)>,
}

impl Cost {
    pub fn of(scene: &Scene, settings: &RunSettings, terms: &ActiveTerms, plan: &Plan) -> Self {
        let model = Model::new(scene, terms);
        let states = model.mechanism().layout.dimension();
        let rates = Rates::of(scene, settings, terms, &model);
        let wall_time = rates.map(|rates| {
            let first = plan.candidates().next().map_or(0.0, |candidate| rates.candidate(candidate, 1.0));
            let all =
                |unforeseen| plan.candidates().map(|candidate| rates.candidate(candidate, unforeseen)).sum::<f64>();
            let likely = first * (all(1.0) / first).max(1.0).powf(LIKELY_SHARE);
            (likely.min(LONGEST), all(UNFORESEEN).max(2.0 * first).min(LONGEST))
        });
        Self { states, wall_time }
    }

    /// Wall time of the dynamics of a scene in runs of this simulated time [s].
    pub fn of_dynamics(scene: &Scene, settings: &RunSettings, terms: &ActiveTerms, time: f64) -> Option<f64> {
        let rates = Rates::of(scene, settings, terms, &Model::new(scene, terms))?;
        Some(rates.controlled(settings.method, settings.relative_tolerance, time))
    }
}

/// Wall time of one evaluation of the equations [s].
fn evaluation_time(balls: usize, terms: &RacewayTerms) -> f64 {
    // `LANES` balls are evaluated together.
    let balls = balls.next_multiple_of(LANES) as f64;
    let film = if terms.hydrodynamics { HYDRODYNAMIC } else { 1.0 };
    film * balls * (SECONDS_PER_BALL + 2.0 * terms.strips as f64 * SECONDS_PER_POINT)
}

/// Wall time of a fixed step of the dynamics of a bearing with these terms [s].
pub fn fixed_step_time(balls: usize, terms: &RacewayTerms) -> f64 {
    FIXED_STEP_EVALUATIONS * evaluation_time(balls, terms)
}

/// Costs per simulated time.
struct Rates<'a> {
    scene: &'a Scene,
    settings: &'a RunSettings,
    mode: FastestMode,
    /// Wall time of one evaluation of the equations [s].
    evaluation: f64,
}

impl<'a> Rates<'a> {
    /// `None` where there is no equilibrium.
    fn of(scene: &'a Scene, settings: &'a RunSettings, terms: &ActiveTerms, model: &Model) -> Option<Self> {
        let mode = start_state(model).and_then(|start| fastest_mode(model, &start)).ok()?;
        let evaluation = evaluation_time(scene.bearing.parameters.ball_count, &terms.raceway);
        Some(Self { scene, settings, mode, evaluation })
    }

    /// Wall time of a candidate with its verification [s]. `unforeseen`: factor on the cost of error control [-].
    fn candidate(&self, candidate: &Candidate, unforeseen: f64) -> f64 {
        let time = self.settings.settle + self.settings.duration;
        let samples = SAMPLE_EVALUATIONS * kept_values(self.settings.duration) as f64 * self.evaluation;
        match candidate.stepping {
            CandidateSteps::Own(_) => {
                let window = WINDOW_RUNS * self.fixed(fixed_step::STEP, self.window());
                self.condensed_slowness(candidate.level) * time / CONDENSED_REAL_TIME_FACTOR + window
            }
            CandidateSteps::Fixed(Method::SemiImplicit, step) => VERIFIED * (self.fixed(step, time) + samples),
            CandidateSteps::Fixed(_, step) => {
                VERIFIED * VERIFIED * (time / step * EXPLICIT_EVALUATIONS * self.evaluation + samples)
            }
            CandidateSteps::Controlled(method, tolerance) => {
                unforeseen * VERIFIED * (self.controlled(method, tolerance, time) + samples)
            }
        }
    }

    fn window(&self) -> f64 {
        Some(window_time(self.scene, self.settings)).filter(|time| time.is_finite()).unwrap_or(0.0)
    }

    fn fixed(&self, step: f64, time: f64) -> f64 {
        time / step * FIXED_STEP_EVALUATIONS * self.evaluation
    }

    fn controlled(&self, method: Method, tolerance: f64, time: f64) -> f64 {
        let explicit = EXPLICIT_EVALUATIONS / self.mode.stable_step().min(SMOOTH_STEP);
        let stiff = STIFF_EVALUATIONS / (STIFF_STEP * (tolerance / STIFF_TOLERANCE).powf(1.0 / 6.0));
        let evaluations = match method {
            Method::DormandPrince => explicit,
            Method::Auto => explicit.min(stiff),
            Method::SemiImplicit | Method::Gear | Method::FineAbm | Method::Radau => stiff,
        };
        time * evaluations * self.evaluation
    }

    /// Factor on the usual time of the condensed model [-]: its steps may be shorter, and its traction general.
    fn condensed_slowness(&self, level: ModelLevel) -> f64 {
        let condensed = || RadiallyCondensed::new(self.scene, &self.settings.outputs).ok();
        let Some(model) = Some(level).filter(|level| *level == ModelLevel::RadiallyCondensed).and_then(|_| condensed())
        else {
            return 1.0;
        };
        let step = model.step_ratio_for(self.settings).step();
        let general = if model.has_general_traction() { GENERAL_TRACTION } else { 1.0 };
        general * (StepRatio::of_steps(1).step() / step).max(1.0)
    }
}
