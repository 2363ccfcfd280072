//! What a scene needs: which terms and degrees of freedom are in its equations, and why the others are not.
//! Decided once per run; what is left out is not tested for in the step.

use crate::physics::cage::PocketFilm;
use crate::physics::contact::traction::TractionLaw;
use crate::physics::lubricant::LubricantKind;
use crate::physics::pocket::PocketTerms;
use crate::physics::raceway::{RacewayTerms, nominal_rolling_friction};
use crate::physics::spindle::{AxialHold, Unbalance};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::{Scene, Term, TermChoice};
use crate::simulation::input::settings::Outputs;

/// Why a term may be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grounds {
    /// The result is the same.
    Identity,
    /// The effect is bounded for this scene.
    Judgement,
    /// By a named convention, or because the request switched it off.
    Convention,
}

/// A term that is not in the model.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// Name of the term.
    pub term: &'static str,
    pub reason: String,
    pub by: Grounds,
    /// Size of the effect, with its unit.
    pub bound: Option<(f64, &'static str)>,
}

/// What the model of a scene contains.
#[derive(Debug, Clone, PartialEq)]
pub struct Needs {
    pub rung: ModelLevel,
    pub raceway: RacewayTerms,
    pub pocket: PocketTerms,
    pub gravity: bool,
    pub drag: bool,
    pub churning: bool,
    pub cage: bool,
    pub land: bool,
    pub unbalance: bool,
    /// The spindle moves along X.
    pub axial_spindle: bool,
    /// Minimum film thickness is evaluated where the motion is observed.
    pub film_thickness: bool,
    pub left_out: Vec<LeftOut>,
}

/// A choice of the request that this scene cannot be given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unmet {
    #[error("rung {rung} cannot represent this scene or its outputs: {reason}", rung = .rung.name())]
    ModelLevel { rung: ModelLevel, reason: String },
    #[error("term {term} cannot be {choice}: {reason}", term = .term.name())]
    Term { term: Term, choice: &'static str, reason: &'static str },
}

/// Strips a contact ellipse is cut into across the groove. Nine give the traction of a gentle law to 1e-3
/// of its maximum; a law that saturates within less slip than conformity spreads over the ellipse needs more.
const STRIPS: usize = 9;
const STRIPS_OF_STEEP_LAWS: usize = 17;
/// A law is steep when it saturates within this slip speed [m/s].
const STEEP_SLIP: f64 = 0.02;

impl Needs {
    /// Decides for a scene, the asked-for outputs and, when given, a rung asked for by name.
    pub fn of(scene: &Scene, outputs: &Outputs, rung: Option<ModelLevel>) -> Result<Self, Unmet> {
        let mut decision = Decision { scene, left_out: Vec::new() };
        refuse_unbuilt(scene)?;
        let cage = decision.keep(Term::Cage, true, || None);
        let axial_spindle = decision.axial()?;
        let rung = decision.rung(rung, cage, axial_spindle)?;
        let planar = rung == ModelLevel::Planar;
        decision.orientation();
        let conformity = decision.keep(Term::Conformity, true, || None);
        let spin = decision.keep(Term::Spin, true, || {
            planar.then(|| "balls that stay in the plane do not turn about their contact normals".into())
        });
        let hydrodynamics = decision.hydrodynamics();
        let film = decision.pocket_film(cage);
        let friction = decision.keep(Term::PocketFriction, true, || {
            if !cage {
                Some("there is no cage".into())
            } else {
                (scene.cage.friction == 0.0).then(|| "its coefficient is 0".into())
            }
        });
        let no_mixture = || (scene.lubricant.mixture_density() == 0.0).then(|| "nothing fills the bearing".into());
        let needs = Self {
            rung,
            raceway: RacewayTerms {
                strips: if conformity || spin { strips(&scene.lubricant.traction) } else { 1 },
                gauss: false,
                conformity,
                spin,
                hydrodynamics,
            },
            pocket: PocketTerms { film, friction, hydrodynamics: hydrodynamics && cage },
            gravity: decision.keep(Term::Gravity, true, || (scene.gravity == 0.0).then(|| "gravity_m_s2 is 0".into())),
            drag: decision.keep(Term::Drag, true, no_mixture),
            churning: decision.keep(Term::Churning, true, no_mixture),
            cage,
            land: decision
                .keep(Term::Land, true, || scene.cage.land.is_none().then(|| "the cage is guided by its balls".into()))
                && cage,
            unbalance: decision.keep(Term::Unbalance, true, || {
                (scene.spindle.unbalance == Unbalance::None).then(|| "the spindle has none".into())
            }),
            axial_spindle,
            film_thickness: decision.film_thickness(outputs),
            left_out: Vec::new(),
        };
        Ok(Self { left_out: decision.left_out, ..needs })
    }
}

/// Terms that no rung of this version does without.
fn refuse_unbuilt(scene: &Scene) -> Result<(), Unmet> {
    for term in [Term::BallRadialDynamics, Term::BallSpinDynamics] {
        if scene.terms.get(term) == TermChoice::Off {
            let reason = "no model without it is built in yet";
            return Err(Unmet::Term { term, choice: "off", reason });
        }
    }
    Ok(())
}

fn strips(law: &TractionLaw) -> usize {
    let saturates_within = match *law {
        TractionLaw::FourParameter { at_rest, at_slip, .. } => {
            if at_rest > 0.0 {
                0.0
            } else {
                at_slip
            }
        }
        TractionLaw::Coulomb { regularisation, .. } => regularisation,
        TractionLaw::SlideRoll { .. } | TractionLaw::Eyring { .. } => f64::INFINITY,
    };
    if saturates_within < STEEP_SLIP { STRIPS_OF_STEEP_LAWS } else { STRIPS }
}

/// A decision in the making.
struct Decision<'a> {
    scene: &'a Scene,
    left_out: Vec<LeftOut>,
}

impl Decision<'_> {
    fn leave_out(&mut self, term: Term, by: Grounds, reason: String) -> bool {
        self.left_out.push(LeftOut { term: term.name(), reason, by, bound: None });
        false
    }

    /// Whether a term is in: switched off by the request, absent by identity (even when asked for: it would
    /// add nothing), or in by default.
    fn keep(&mut self, term: Term, default: bool, absent: impl FnOnce() -> Option<String>) -> bool {
        if let Some(reason) = absent() {
            return self.leave_out(term, Grounds::Identity, reason);
        }
        match self.scene.terms.get(term) {
            TermChoice::Off => self.switched_off(term),
            TermChoice::On => true,
            TermChoice::Auto => default,
        }
    }

    fn switched_off(&mut self, term: Term) -> bool {
        self.leave_out(term, Grounds::Convention, format!("switched off by the request (terms.{})", term.name()))
    }

    /// Whether the spindle moves along X.
    fn axial(&mut self) -> Result<bool, Unmet> {
        let free = self.scene.spindle.axial == AxialHold::Free;
        let unmet = |choice, reason| Err(Unmet::Term { term: Term::Axial, choice, reason });
        match self.scene.terms.get(Term::Axial) {
            TermChoice::Off if self.scene.operation.load[0] != 0.0 => unmet("off", "an axial load acts"),
            TermChoice::Off => {
                self.switched_off(Term::Axial);
                Ok(false)
            }
            TermChoice::On if !free => unmet("on", "spindle.axial holds the spindle"),
            _ if free => Ok(true),
            _ => {
                let reason = "spindle.axial holds the spindle along X; its balls still move there".into();
                self.leave_out(Term::Axial, Grounds::Identity, reason);
                Ok(false)
            }
        }
    }

    /// The rung: planar where nothing can leave the plane, or where the request says so.
    fn rung(&mut self, asked: Option<ModelLevel>, cage: bool, axial_spindle: bool) -> Result<ModelLevel, Unmet> {
        let scene = self.scene;
        let out_of_plane = if axial_spindle {
            Some("the spindle moves along X")
        } else if matches!(scene.spindle.axial, AxialHold::Offset(offset) if offset != 0.0) {
            Some("the spindle is held off its centre along X")
        } else if scene.operation.misalignment != [0.0; 2] {
            Some("the spindle is misaligned")
        } else {
            None
        };
        let symmetric_cage = !cage || scene.cage.is_symmetric();
        let choice = scene.terms.get(Term::CageTilt);
        let planar = ModelLevel::Planar;
        match (asked, out_of_plane) {
            (Some(ModelLevel::Planar), Some(reason)) => {
                return Err(Unmet::ModelLevel { rung: planar, reason: reason.into() });
            }
            (Some(ModelLevel::Planar), None) if choice == TermChoice::On => {
                return Err(Unmet::ModelLevel { rung: planar, reason: "terms.cage_tilt is on".into() });
            }
            (_, Some(_)) if choice == TermChoice::Off => {
                let reason = "the scene moves along X; only a planar scene can do without";
                return Err(Unmet::Term { term: Term::CageTilt, choice: "off", reason });
            }
            (Some(ModelLevel::Full), _) => return Ok(ModelLevel::Full),
            (None, Some(_)) => return Ok(ModelLevel::Full),
            _ => {}
        }
        if symmetric_cage && choice != TermChoice::On {
            let reason = "nothing acts along X and the cage is symmetric: no ball or cage leaves the plane";
            self.leave_out(Term::CageTilt, Grounds::Identity, reason.into());
            return Ok(ModelLevel::Planar);
        }
        if asked == Some(ModelLevel::Planar) {
            let reason = "tilt and axial motion of cage and balls: the request asks for the planar rung".into();
            self.leave_out(Term::CageTilt, Grounds::Convention, reason);
            return Ok(ModelLevel::Planar);
        }
        if choice == TermChoice::Off {
            self.switched_off(Term::CageTilt);
            return Ok(ModelLevel::Planar);
        }
        Ok(ModelLevel::Full)
    }

    fn orientation(&mut self) {
        self.left_out.push(LeftOut {
            term: "ball_orientation",
            reason: "a homogeneous ball without surface profile looks the same from every side".into(),
            by: Grounds::Identity,
            bound: None,
        });
    }

    /// Rolling friction F_R, pressure force F_H and the hydrodynamic terms of the pocket.
    fn hydrodynamics(&mut self) -> bool {
        let lubricant = &self.scene.lubricant;
        let choice = self.scene.terms.get(Term::Hydrodynamics);
        if lubricant.kind == LubricantKind::Dry || lubricant.viscosity == 0.0 {
            return self.leave_out(Term::Hydrodynamics, Grounds::Identity, "there is no viscous film".into());
        }
        if choice == TermChoice::Off {
            return self.switched_off(Term::Hydrodynamics);
        }
        if lubricant.kind == LubricantKind::Grease && choice == TermChoice::Auto {
            self.left_out.push(LeftOut {
                term: Term::Hydrodynamics.name(),
                reason: "F_R, F_H and pocket rolling friction are neglected for grease, as in the source of the \
                         model; the bound is F_R of the most loaded ball if its base oil flooded the inlet"
                    .into(),
                by: Grounds::Convention,
                bound: Some((
                    nominal_rolling_friction(
                        &self.scene.bearing,
                        lubricant,
                        self.largest_ball_load(),
                        self.scene.operating_speed(),
                    ),
                    "N",
                )),
            });
            return false;
        }
        true
    }

    /// Stribeck's estimate of the most loaded ball, axial load shared [N].
    fn largest_ball_load(&self) -> f64 {
        let [x, y, z] = self.scene.operation.load;
        let balls = self.scene.bearing.parameters.ball_count as f64;
        (4.37 * y.hypot(z) + x.abs()) / balls
    }

    fn pocket_film(&mut self, cage: bool) -> bool {
        let film = self.scene.cage.film;
        let dry = self.scene.lubricant.viscosity == 0.0 && film == PocketFilm::Wedge;
        self.keep(Term::PocketFilm, true, || {
            if !cage {
                Some("there is no cage".into())
            } else if film == PocketFilm::None {
                Some("bearing.cage.film is none".into())
            } else {
                dry.then(|| "a wedge needs a viscosity above 0".into())
            }
        })
    }

    /// Film thickness as an output; forces that need it evaluate it by themselves.
    fn film_thickness(&mut self, outputs: &Outputs) -> bool {
        let viscous = self.scene.lubricant.viscosity > 0.0 && self.scene.lubricant.kind != LubricantKind::Dry;
        self.keep(Term::FilmThickness, true, || {
            if !viscous {
                Some("there is no viscous film".into())
            } else {
                (!outputs.contacts).then(|| "no output asks for it".into())
            }
        })
    }
}
