//! Terms and degrees of freedom in the equations of a scene, and the reasons against all others. They are decided once per run; a step
//! does not test for omitted terms.

use crate::physics::cage::PocketFilm;
use crate::physics::contact::hertz::{HertzContact, raceway_contacts};
use crate::physics::contact::traction::TractionLaw;
use crate::physics::kinematics;
use crate::physics::lubricant::LubricantKind;
use crate::physics::pocket::PocketTerms;
use crate::physics::raceway::{RacewayTerms, nominal_rolling_friction};
use crate::physics::spindle::{AxialHold, SpindleTilt, Unbalance};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::{Scene, Term, TermChoice};
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::omission::OmissionReason;

/// Justification of an omitted term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Justification {
    /// The result does not change.
    Identity,
    /// The effect is bounded for this scene.
    Judgement,
    /// A named convention, or a choice of the request.
    Convention,
}

/// A term that is not in the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOut {
    /// Name of the term.
    pub term: &'static str,
    pub reason: OmissionReason,
    pub by: Justification,
    /// Bound of the effect, with its unit.
    pub bound: Option<(f64, &'static str)>,
}

/// Terms and degrees of freedom in the model of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ActiveTerms {
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

/// A choice of the request that does not fit the scene.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UnsupportedChoice {
    #[error("rung {rung} cannot represent this scene or its outputs: {reason}", rung = .rung.name())]
    ModelLevel { rung: ModelLevel, reason: Inapplicable },
    #[error("term {term} cannot be {choice}: {reason}", term = .term.name())]
    Term { term: Term, choice: &'static str, reason: &'static str },
}

/// Gauss points of a contact ellipse across the groove: six integrate the traction of a gentle law more accurately than nine equal strips.
const GAUSS_POINTS: usize = 6;
/// Strips for a law that is steep over the ellipse: it saturates within less slip than varies over it.
const STRIPS_OF_STEEP_LAWS: usize = 17;

impl ActiveTerms {
    /// The active terms of a scene with its outputs, at a requested model level or at the one that the scene needs.
    pub fn of(scene: &Scene, outputs: &Outputs, rung: Option<ModelLevel>) -> Result<Self, UnsupportedChoice> {
        let mut decision = Decision { scene, left_out: Vec::new() };
        refuse_unbuilt(scene)?;
        let cage = decision.keep(Term::Cage, true, || None);
        let axial_spindle = decision.axial()?;
        let rung = decision.rung(rung, cage, axial_spindle)?;
        let planar = rung == ModelLevel::Planar;
        decision.orientation();
        let conformity = decision.keep(Term::Conformity, true, || None);
        let spin = decision.keep(Term::Spin, true, || planar.then_some(OmissionReason::BallsStayInPlane));
        let hydrodynamics = decision.hydrodynamics(outputs);
        let film = decision.pocket_film(cage);
        let friction = decision
            .keep(Term::PocketFriction, true, || (scene.cage.friction == 0.0).then_some(OmissionReason::NoFriction));
        let no_mixture = || (scene.lubricant.mixture_density() == 0.0).then_some(OmissionReason::NothingFills);
        let is_steep = saturation_slip(&scene.lubricant.traction) < decision.slip_variation();
        let needs = Self {
            rung,
            raceway: RacewayTerms {
                strips: match (conformity || spin, is_steep) {
                    (true, true) => STRIPS_OF_STEEP_LAWS,
                    (true, false) => GAUSS_POINTS,
                    (false, _) => 1,
                },
                gauss: (conformity || spin) && !is_steep,
                conformity,
                spin,
                hydrodynamics,
            },
            pocket: PocketTerms { film, friction, hydrodynamics: hydrodynamics && cage },
            gravity: decision.keep(Term::Gravity, true, || (scene.gravity == 0.0).then_some(OmissionReason::NoGravity)),
            drag: decision.keep(Term::Drag, true, no_mixture),
            churning: decision.keep(Term::Churning, true, no_mixture),
            cage,
            land: decision
                .keep(Term::Land, true, || scene.cage.land.is_none().then_some(OmissionReason::GuidedByBalls))
                && cage,
            unbalance: decision.keep(Term::Unbalance, true, || {
                (scene.spindle.unbalance == Unbalance::None).then_some(OmissionReason::Balanced)
            }),
            axial_spindle,
            film_thickness: decision.film_thickness(outputs),
            left_out: Vec::new(),
        };
        Ok(Self { left_out: decision.left_out, ..needs })
    }
}

/// Refuses a request to omit terms that every model contains.
fn refuse_unbuilt(scene: &Scene) -> Result<(), UnsupportedChoice> {
    for term in [Term::BallRadialDynamics, Term::BallSpinDynamics] {
        if scene.terms.get(term) == TermChoice::Off {
            let reason = "no model without it is built in yet";
            return Err(UnsupportedChoice::Term { term, choice: "off", reason });
        }
    }
    Ok(())
}

/// Slip at which a law saturates [m/s]; infinite for laws that rise smoothly.
fn saturation_slip(law: &TractionLaw) -> f64 {
    match *law {
        TractionLaw::FourParameter { at_rest, at_slip, .. } => {
            if at_rest > 0.0 {
                0.0
            } else {
                at_slip
            }
        }
        TractionLaw::Coulomb { regularisation, .. } => regularisation,
        TractionLaw::SlideRoll { .. } | TractionLaw::Eyring { .. } => f64::INFINITY,
    }
}

/// Decision over all terms, with the omitted ones so far.
struct Decision<'a> {
    scene: &'a Scene,
    left_out: Vec<LeftOut>,
}

impl Decision<'_> {
    fn leave_out(&mut self, term: Term, by: Justification, reason: OmissionReason) -> bool {
        self.left_out.push(LeftOut { term: term.name(), reason, by, bound: None });
        false
    }

    /// Returns whether a term is active. A term without effect is omitted by identity even where the request asks for it. Otherwise the
    /// request decides, then the default.
    fn keep(&mut self, term: Term, default: bool, absent: impl FnOnce() -> Option<OmissionReason>) -> bool {
        if let Some(reason) = absent() {
            return self.leave_out(term, Justification::Identity, reason);
        }
        match self.scene.terms.get(term) {
            TermChoice::Off => self.switched_off(term),
            TermChoice::On => true,
            TermChoice::Auto => default,
        }
    }

    fn switched_off(&mut self, term: Term) -> bool {
        self.leave_out(term, Justification::Convention, OmissionReason::SwitchedOff(term.name()))
    }

    /// Returns whether the spindle moves along X.
    fn axial(&mut self) -> Result<bool, UnsupportedChoice> {
        let free = self.scene.spindle.axial == AxialHold::Free;
        let unmet = |choice, reason| Err(UnsupportedChoice::Term { term: Term::Axial, choice, reason });
        match self.scene.terms.get(Term::Axial) {
            TermChoice::Off if self.scene.operation.acts_along_x() => unmet("off", "an axial load acts"),
            TermChoice::Off => {
                self.switched_off(Term::Axial);
                Ok(false)
            }
            TermChoice::On if !free => unmet("on", "spindle.axial holds the spindle"),
            _ if free => Ok(true),
            _ => {
                self.leave_out(Term::Axial, Justification::Identity, OmissionReason::SpindleHeld);
                Ok(false)
            }
        }
    }

    /// Model level: planar where nothing can leave the plane, or where the request chooses it.
    fn rung(
        &mut self,
        asked: Option<ModelLevel>,
        cage: bool,
        axial_spindle: bool,
    ) -> Result<ModelLevel, UnsupportedChoice> {
        let scene = self.scene;
        let out_of_plane = if axial_spindle {
            Some(Inapplicable::SpindleMovesAlongX)
        } else if matches!(scene.spindle.axial, AxialHold::Offset(offset) if offset != 0.0) {
            Some(Inapplicable::SpindleOffCentre)
        } else if scene.operation.misalignment != [0.0; 2] {
            Some(Inapplicable::Misaligned)
        } else if scene.spindle.tilt != SpindleTilt::Held {
            Some(Inapplicable::SpindleTilts)
        } else if scene.surfaces.push_along_axis() {
            Some(Inapplicable::DefectBesideBottom)
        } else if scene.surfaces.have_axial_waves() {
            Some(Inapplicable::AxialWaves)
        } else if scene.surfaces.have_defects_beside_track() {
            Some(Inapplicable::DefectBesideTrack)
        } else {
            None
        };
        let symmetric_cage = !cage || scene.cage.is_symmetric();
        let choice = scene.terms.get(Term::CageTilt);
        let planar = ModelLevel::Planar;
        match (asked, out_of_plane) {
            (Some(ModelLevel::Planar), Some(reason)) => {
                return Err(UnsupportedChoice::ModelLevel { rung: planar, reason });
            }
            (Some(ModelLevel::Planar), None) if choice == TermChoice::On => {
                let reason = Inapplicable::TermOn(Term::CageTilt);
                return Err(UnsupportedChoice::ModelLevel { rung: planar, reason });
            }
            (_, Some(_)) if choice == TermChoice::Off => {
                let reason = "the scene moves along X; only a planar scene can do without";
                return Err(UnsupportedChoice::Term { term: Term::CageTilt, choice: "off", reason });
            }
            (Some(ModelLevel::Full), _) => return Ok(ModelLevel::Full),
            (None, Some(_)) => return Ok(ModelLevel::Full),
            _ => {}
        }
        // A push at the start moves balls and cage along X, too.
        let stays_in_plane = symmetric_cage && scene.operation.perturbation.is_none();
        if stays_in_plane && choice != TermChoice::On {
            self.leave_out(Term::CageTilt, Justification::Identity, OmissionReason::NothingActsAlongX);
            return Ok(ModelLevel::Planar);
        }
        if asked == Some(ModelLevel::Planar) {
            self.leave_out(Term::CageTilt, Justification::Convention, OmissionReason::PlanarSelected);
            return Ok(ModelLevel::Planar);
        }
        if choice == TermChoice::Off {
            self.switched_off(Term::CageTilt);
            return Ok(ModelLevel::Planar);
        }
        Ok(ModelLevel::Full)
    }

    fn orientation(&mut self) {
        if self.scene.surfaces.have_uneven_balls() {
            return;
        }
        self.left_out.push(LeftOut {
            term: "ball_orientation",
            reason: OmissionReason::HomogeneousBalls,
            by: Justification::Identity,
            bound: None,
        });
    }

    /// Rolling friction F_R, pressure force F_H and the hydrodynamic terms of the pocket. A friction moment needs them in grease, too: they are most
    /// of it.
    fn hydrodynamics(&mut self, outputs: &Outputs) -> bool {
        let lubricant = &self.scene.lubricant;
        let choice = self.scene.terms.get(Term::Hydrodynamics);
        if lubricant.kind == LubricantKind::Dry || lubricant.viscosity == 0.0 {
            return self.leave_out(Term::Hydrodynamics, Justification::Identity, OmissionReason::NoViscousFilm);
        }
        if choice == TermChoice::Off {
            return self.switched_off(Term::Hydrodynamics);
        }
        if lubricant.kind == LubricantKind::Grease && choice == TermChoice::Auto && !outputs.friction {
            self.left_out.push(LeftOut {
                term: Term::Hydrodynamics.name(),
                reason: OmissionReason::NeglectedForGrease,
                by: Justification::Convention,
                bound: Some((
                    nominal_rolling_friction(
                        &self.scene.bearing,
                        lubricant,
                        self.largest_ball_load(),
                        self.scene.operating_speeds().relative(),
                    ),
                    "N",
                )),
            });
            return false;
        }
        true
    }

    /// Variation of the slip over the ellipse of the most loaded ball [m/s]: a² Ω/(2 R_d) by conformity and a Ω sin α by spin about
    /// the normal, with the ball's spin Ω of ideal rolling.
    ///
    /// Down to a saturation slip of this variation six Gauss points err by less than nine strips (`tests/limits/contact_points.rs`).
    fn slip_variation(&self) -> f64 {
        let Scene { bearing, operation, .. } = self.scene;
        let speeds = operation.rotation().operating();
        let spin = (kinematics::ideal_spin_ratio(bearing) * speeds.relative()).abs();
        let orbit = speeds.carried(kinematics::ideal_orbit_ratio(bearing));
        let centrifugal = bearing.ball_mass * 0.5 * bearing.parameters.pitch_diameter * orbit * orbit;
        let is_axial = operation.acts_along_x() || self.scene.spindle.axial != AxialHold::Fixed;
        let sine = if is_axial { bearing.free_contact_angle.sin().abs() } else { 0.0 };
        let of = |contact: &HertzContact, load: f64| {
            let (semi_major, _) = contact.semi_axes(load);
            semi_major * spin * (0.5 * semi_major / contact.deformed_radius + sine)
        };
        let (contacts, load) = (raceway_contacts(bearing), self.largest_ball_load());
        of(&contacts.inner, load).max(of(&contacts.outer, load + centrifugal))
    }

    /// Stribeck's estimate of the most loaded ball, axial load shared [N].
    fn largest_ball_load(&self) -> f64 {
        let [x, y, z, ..] = self.scene.operation.largest_load();
        let balls = self.scene.bearing.parameters.ball_count as f64;
        (4.37 * y.hypot(z) + x.abs()) / balls
    }

    fn pocket_film(&mut self, cage: bool) -> bool {
        let film = self.scene.cage.film;
        // Between balls lubricant is squeezed out, whichever film the pockets would have.
        let needs_viscosity = film == PocketFilm::Wedge || !cage;
        let dry = self.scene.lubricant.viscosity == 0.0 && needs_viscosity;
        self.keep(Term::PocketFilm, true, || {
            if film == PocketFilm::None {
                Some(OmissionReason::NoPocketFilm)
            } else {
                let needed =
                    if cage { OmissionReason::WedgeNeedsViscosity } else { OmissionReason::FilmNeedsViscosity };
                dry.then_some(needed)
            }
        })
    }

    /// Film thickness as an output. Forces that depend on it evaluate it independently.
    fn film_thickness(&mut self, outputs: &Outputs) -> bool {
        let viscous = self.scene.lubricant.viscosity > 0.0 && self.scene.lubricant.kind != LubricantKind::Dry;
        self.keep(Term::FilmThickness, true, || {
            if !viscous {
                Some(OmissionReason::NoViscousFilm)
            } else {
                (!outputs.contacts).then_some(OmissionReason::NoOutput)
            }
        })
    }
}
