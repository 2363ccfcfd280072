//! The ways to solve a scene, in order of cost.

use crate::numerics::ode::Method;
use crate::simulation::error::codes::NotEligible;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::system::Model;
use crate::simulation::model::terms::{ActiveTerms, UnsupportedChoice};
use crate::simulation::solve::eligibility::{Eligibility, active_terms};
use crate::simulation::solve::fixed_step;

/// One way to solve a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    pub level: ModelLevel,
    pub stepping: CandidateSteps,
    pub reference: Reference,
}

impl Candidate {
    /// True if its reference is the attempt before it.
    pub(crate) fn is_compared_with_previous(&self) -> bool {
        matches!(self.reference, Reference::LooserRun | Reference::IndependentSample)
    }
}

/// Integration steps of a candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CandidateSteps {
    /// The integrator of a reduced model. `None`: the longest step that a trial over a short window allows; else this one [s].
    Own(Option<f64>),
    /// Steps of a fixed length [s].
    Fixed(Method, f64),
    /// Error control at a relative tolerance [-].
    Controlled(Method, f64),
}

/// Reference that verifies a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reference {
    /// A richer model over a window.
    RicherModel,
    /// A repetition with finer steps or a tighter tolerance.
    Refined,
    /// The previous attempt, a sample of the same chaotic motion.
    IndependentSample,
    /// The previous whole run, at a looser tolerance.
    LooserRun,
}

/// Candidates by cost, and the levels that are not eligible.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Candidates still to be tried, the next one last.
    queue: Vec<Candidate>,
    pub not_eligible: Vec<NotEligible>,
}

impl Plan {
    pub fn of(scene: &Scene, settings: &RunSettings) -> Result<Self, UnsupportedChoice> {
        let Eligibility { levels, not_eligible } = Eligibility::of(&settings.seen(scene), settings)?;
        let mut queue = Vec::new();
        for level in levels {
            match level.is_reduced() {
                true => queue.push(Candidate {
                    level,
                    stepping: CandidateSteps::Own(settings.fixed_step),
                    reference: Reference::RicherModel,
                }),
                false => queue.extend(dynamics(scene, settings, level)?),
            }
        }
        queue.reverse();
        Ok(Self { queue, not_eligible })
    }

    /// The candidates that are still to be tried, the next one first.
    pub fn candidates(&self) -> impl Iterator<Item = &Candidate> {
        self.queue.iter().rev()
    }

    /// Levels of the candidates, the leanest first.
    pub fn levels(&self) -> Vec<ModelLevel> {
        let mut levels: Vec<ModelLevel> = self.candidates().map(|candidate| candidate.level).collect();
        levels.dedup();
        levels
    }

    /// Takes the next candidate.
    pub(crate) fn next(&mut self) -> Option<Candidate> {
        self.queue.pop()
    }

    /// Inserts a refined candidate, to be tried next.
    pub(crate) fn insert(&mut self, candidate: Candidate) {
        self.queue.push(candidate);
    }

    /// Drops all remaining candidates.
    pub(crate) fn clear(&mut self) {
        self.queue.clear();
    }

    /// True if no candidate is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }
}

/// Candidates of the dynamics: fixed steps if they are eligible, error control, and a tighter tolerance.
fn dynamics(scene: &Scene, settings: &RunSettings, level: ModelLevel) -> Result<Vec<Candidate>, UnsupportedChoice> {
    let candidate = |stepping| Candidate { level, stepping, reference: Reference::Refined };
    if let Some(step) = settings.fixed_step {
        return Ok(vec![candidate(CandidateSteps::Fixed(settings.method, step))]);
    }
    let terms: ActiveTerms = active_terms(scene, &settings.outputs, Some(level).filter(|_| settings.rung.is_some()))?;
    let model = Model::new(scene, &terms);
    let controlled = |tolerance| candidate(CandidateSteps::Controlled(settings.method, tolerance));
    let in_steps = fixed_step::is_eligible(&model, settings)
        .then(|| candidate(CandidateSteps::Fixed(Method::SemiImplicit, fixed_step::first_step(&model))));
    let tolerances = [Some(settings.relative_tolerance), settings.tightened];
    Ok(in_steps.into_iter().chain(tolerances.into_iter().flatten().map(controlled)).collect())
}

/// Model levels of the candidates, the leanest first.
pub fn model_levels(scene: &Scene, settings: &RunSettings) -> Result<Vec<ModelLevel>, UnsupportedChoice> {
    Plan::of(scene, settings).map(|plan| plan.levels())
}
