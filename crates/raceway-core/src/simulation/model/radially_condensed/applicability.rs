//! Applicability of the radially condensed model to a scene and its outputs.

use super::carried_balls::ball_leaves;
use crate::physics::cage::PocketFilm;
use crate::physics::spindle::{AxialHold, SpindleTilt};
use crate::simulation::input::channel::{Axis, Channel};
use crate::simulation::input::scene::{Scene, Term, TermChoice};
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::inapplicable::Inapplicable;

/// Reason why the radially condensed model cannot represent a scene and its outputs; `None`: it can.
pub fn inapplicability(scene: &Scene, outputs: &Outputs) -> Option<Inapplicable> {
    let term_on = |term| scene.terms.get(term) == TermChoice::On;
    let along_x =
        |channel: &Channel| matches!(channel, Channel::Spindle(Axis::X, _) | Channel::CageDisplacement(Axis::X));
    if !scene.operation.rotation().outer_stands() {
        Some(Inapplicable::OuterRingTurns)
    } else if scene.surfaces.balls_have_defects() {
        Some(Inapplicable::BallDefects)
    } else if scene.surfaces.push_along_axis() {
        Some(Inapplicable::DefectBesideBottom)
    } else if scene.surfaces.have_axial_waves() {
        Some(Inapplicable::AxialWaves)
    } else if scene.operation.acts_along_x() {
        Some(Inapplicable::AxialLoad)
    } else if scene.spindle.axial == AxialHold::Free {
        Some(Inapplicable::SpindleMovesAlongX)
    } else if matches!(scene.spindle.axial, AxialHold::Offset(offset) if offset != 0.0) {
        Some(Inapplicable::SpindleOffCentre)
    } else if scene.operation.misalignment != [0.0; 2] {
        Some(Inapplicable::Misaligned)
    } else if scene.spindle.tilt != SpindleTilt::Held {
        Some(Inapplicable::SpindleTilts)
    } else if scene.terms.get(Term::Cage) == TermChoice::Off {
        Some(Inapplicable::NoCage)
    } else if scene.operation.start_perturbation().is_some() {
        Some(Inapplicable::InitialPerturbation)
    } else if scene.cage.film == PocketFilm::Empirical11 {
        Some(Inapplicable::StiffPocketFilm)
    } else if term_on(Term::CageTilt) {
        Some(Inapplicable::TermOn(Term::CageTilt))
    } else if term_on(Term::Axial) {
        Some(Inapplicable::TermOn(Term::Axial))
    } else if term_on(Term::BallRadialDynamics) {
        Some(Inapplicable::TermOn(Term::BallRadialDynamics))
    } else if outputs.spectra.iter().chain(&outputs.series).any(along_x) {
        Some(Inapplicable::ChannelAlongX)
    } else if outputs.friction {
        Some(Inapplicable::FrictionRequested)
    } else {
        ball_leaves(scene, outputs)
    }
}
