//! Texts of the reasons why a term is not in the equations.

use raceway_core::simulation::model::omission::{Condensation, OmissionReason};

/// The reason as a clause.
pub fn omission(reason: OmissionReason) -> String {
    let text = match reason {
        OmissionReason::SwitchedOff(term) => return format!("switched off by the request (terms.{term})"),
        OmissionReason::Condensed(level, condensation) => {
            return format!("rung {}: {}", level.name(), condensed(condensation));
        }
        OmissionReason::HomogeneousBalls => "a homogeneous ball without surface profile looks the same from every side",
        OmissionReason::BallsStayInPlane => "balls that stay in the plane do not turn about their contact normals",
        OmissionReason::NothingActsAlongX => {
            "nothing acts along X and the cage is symmetric: no ball or cage leaves the plane"
        }
        OmissionReason::PlanarSelected => {
            "tilt and axial motion of cage and balls: the request asks for the planar rung"
        }
        OmissionReason::SpindleHeld => "spindle.axial holds the spindle along X; its balls still move there",
        OmissionReason::NoGravity => "gravity_m_s2 is 0",
        OmissionReason::NoFriction => "its coefficient is 0",
        OmissionReason::NothingFills => "nothing fills the bearing",
        OmissionReason::GuidedByBalls => "the cage is guided by its balls",
        OmissionReason::Balanced => "the spindle has none",
        OmissionReason::NoViscousFilm => "there is no viscous film",
        OmissionReason::NeglectedForGrease => {
            "F_R, F_H and pocket rolling friction are neglected for grease, as in the source of the model; the bound is F_R of the most \
             loaded ball if its base oil flooded the inlet"
        }
        OmissionReason::NoPocketFilm => "bearing.cage.film is none",
        OmissionReason::WedgeNeedsViscosity => "a wedge needs a viscosity above 0",
        OmissionReason::FilmNeedsViscosity => "a film needs a viscosity above 0",
        OmissionReason::NoOutput => "no output asks for it",
        OmissionReason::VibrationHardlyChanges => {
            "by the linear analysis no place changes by more than the bound, all directions together, in any third of an octave under equal forces in every direction"
        }
    };
    text.to_owned()
}

fn condensed(condensation: Condensation) -> &'static str {
    match condensation {
        Condensation::RadialEquilibrium => "balls are in radial equilibrium between their raceways",
        Condensation::StaysInPlane => "no ball or cage leaves the plane",
        Condensation::LinearMoments => "moments of the balls are linear in the tilt of their ring, which moves no ball",
        Condensation::EqualSpacing => "balls orbit at equal spacing, at the speed of ideal rolling",
        Condensation::IdealRolling => "balls roll ideally",
    }
}
