//! Applicability of the radially condensed model to a scene and its outputs.

use crate::physics::cage::PocketFilm;
use crate::physics::spindle::AxialHold;
use crate::simulation::input::channel::{Axis, Channel};
use crate::simulation::input::scene::{Scene, Term, TermChoice};
use crate::simulation::input::settings::Outputs;

/// Reason why the radially condensed model cannot represent a scene and its outputs; `None`: it can.
pub fn inapplicability(scene: &Scene, outputs: &Outputs) -> Option<&'static str> {
    let term_on = |term| scene.terms.get(term) == TermChoice::On;
    let along_x =
        |channel: &Channel| matches!(channel, Channel::Spindle(Axis::X, _) | Channel::CageDisplacement(Axis::X));
    if scene.operation.load[0] != 0.0 {
        Some("an axial load acts")
    } else if scene.spindle.axial == AxialHold::Free {
        Some("the spindle moves along X")
    } else if matches!(scene.spindle.axial, AxialHold::Offset(offset) if offset != 0.0) {
        Some("the spindle is held off its centre along X")
    } else if scene.operation.misalignment != [0.0; 2] {
        Some("the spindle is misaligned")
    } else if scene.terms.get(Term::Cage) == TermChoice::Off {
        Some("without a cage balls touch each other, and this model has no contact between balls")
    } else if scene.operation.start_perturbation().is_some() {
        Some(
            "operation.initial_perturbation moves balls along their radius, where this model keeps them in equilibrium",
        )
    } else if scene.cage.film == PocketFilm::Empirical11 {
        Some("the pocket film empirical-11 is stiff and undamped, so that fixed steps are unstable")
    } else if term_on(Term::CageTilt) {
        Some("terms.cage_tilt is on")
    } else if term_on(Term::Axial) {
        Some("terms.axial is on")
    } else if term_on(Term::BallRadialDynamics) {
        Some("terms.ball_radial_dynamics is on")
    } else if outputs.spectra.iter().chain(&outputs.series).any(along_x) {
        Some("an output asks for motion along X")
    } else {
        None
    }
}
