//! Terms of the equations that a scene switches on or off.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use raceway_core::simulation::input::scene::{Term, TermChoice, Terms};

/// `auto` (default): included where the scene needs it; an omission is reported with its reason. `on`, `off`: always or never included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum TermChoiceName {
    Auto,
    On,
    Off,
}

impl From<TermChoiceName> for TermChoice {
    fn from(name: TermChoiceName) -> Self {
        match name {
            TermChoiceName::Auto => Self::Auto,
            TermChoiceName::On => Self::On,
            TermChoiceName::Off => Self::Off,
        }
    }
}

macro_rules! terms {
    ($($(#[$doc:meta])* $name:ident: $term:ident),* $(,)?) => {
        /// A choice for each term of the equations. Default `auto`.
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
        #[serde(deny_unknown_fields)]
        pub struct TermsInput {
            $($(#[$doc])* #[schema(nullable = false)] pub $name: Option<TermChoiceName>,)*
        }

        impl TermsInput {
            fn fields(&mut self) -> [(Term, &mut Option<TermChoiceName>); Term::ALL.len()] {
                [$((Term::$term, &mut self.$name)),*]
            }
        }
    };
}

terms! {
    /// Weight of every body.
    gravity: Gravity,
    /// Drag of the lubricant–air mixture against the orbiting balls.
    drag: Drag,
    /// Churning moment on the spinning balls.
    churning: Churning,
    /// Rolling friction and pressure force of the inlet film.
    hydrodynamics: Hydrodynamics,
    /// The cage as a body.
    cage: Cage,
    /// Tilting of the cage.
    cage_tilt: CageTilt,
    /// Axial motion of balls and cage.
    axial: Axial,
    /// Spin friction about the contact normals.
    spin: Spin,
    /// Variation of slip over the curved contact area.
    conformity: Conformity,
    /// Lubricant film in the pockets.
    pocket_film: PocketFilm,
    /// Friction in the pockets.
    pocket_friction: PocketFriction,
    /// Unbalance of the spindle.
    unbalance: Unbalance,
    /// Guiding land of the cage.
    land: Land,
    /// Film thickness as an output.
    film_thickness: FilmThickness,
    /// Radial motion of the balls between their raceways.
    ball_radial_dynamics: BallRadialDynamics,
    /// Spin of the balls as a state.
    ball_spin_dynamics: BallSpinDynamics,
}

impl TermsInput {
    pub fn resolve(&mut self, defaults: &mut Defaults) -> Terms {
        let mut terms = Terms::default();
        for (term, field) in self.fields() {
            let pointer = format!("/scene/terms/{}", term.name());
            let choice = defaults.fill(pointer.clone(), field, TermChoiceName::Auto);
            let needed = matches!(term, Term::BallRadialDynamics | Term::BallSpinDynamics);
            if needed && choice == TermChoiceName::Off {
                defaults.refuse(pointer, "cannot be switched off separately; a reduced model level omits it (/solver/rung, such as `radially_condensed`)");
            }
            terms.set(term, choice.into());
        }
        terms
    }
}
