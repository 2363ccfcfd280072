//! Damping of the contacts.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::shapes::optional_object;
use raceway_core::physics::contact::damping::DampingLaw;
use raceway_core::physics::defaults::{IMPACT_SPEED, POCKET_RESTITUTION, RACEWAY_RESTITUTION};

/// Damping of the raceway contacts and of the pocket contacts.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DampingInput {
    /// Raceway contacts. Default: restitution 0.9 at 0.1 m/s.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub raceway: Option<DampingLawInput>,
    /// Pocket contacts. Default: restitution 0.6 at 0.1 m/s.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub pocket: Option<DampingLawInput>,
}

/// A damping law and its parameters.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DampingLawInput {
    /// Damping law. Default `restitution`.
    #[schema(nullable = false)]
    pub law: Option<DampingLawName>,
    /// Coefficient of restitution: speed after an impact divided by speed before it [-]. Default 0.9 on raceways, 0.6 in pockets.
    #[schema(nullable = false, example = 0.9)]
    pub restitution: Option<f64>,
    /// Impact speed at which the coefficient of restitution holds [m/s]. Default 0.1.
    #[schema(nullable = false, example = 0.1)]
    pub at_speed_m_s: Option<f64>,
    /// Damping coefficient of the law `viscous`, which requires it [N·s/m].
    #[schema(nullable = false)]
    pub viscous_n_s_per_m: Option<f64>,
}

/// `restitution`: the damping factor is solved numerically, so that an impact has the given coefficient of restitution. `hunt_crossley`,
/// `lankarani_nikravesh`, `flores`: published approximations of this factor. `viscous`: a damper that increases with penetration from zero.
/// `none`: no damping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum DampingLawName {
    Restitution,
    HuntCrossley,
    LankaraniNikravesh,
    Flores,
    Viscous,
    None,
}

/// Damping laws in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Damping {
    pub raceway: DampingLaw,
    pub pocket: DampingLaw,
}

impl DampingInput {
    pub fn resolve(&mut self, defaults: &mut Defaults) -> Damping {
        Damping {
            raceway: self.raceway.get_or_insert_default().resolve(
                defaults,
                "/scene/damping/raceway",
                RACEWAY_RESTITUTION,
            ),
            pocket: self.pocket.get_or_insert_default().resolve(defaults, "/scene/damping/pocket", POCKET_RESTITUTION),
        }
    }
}

impl DampingLawInput {
    fn resolve(&mut self, defaults: &mut Defaults, at: &str, default_restitution: f64) -> DampingLaw {
        let law = defaults.fill(format!("{at}/law"), &mut self.law, DampingLawName::Restitution);
        let viscous = law == DampingLawName::Viscous;
        let elastic = !viscous && law != DampingLawName::None;
        let name = law.name();
        defaults.only_used(
            at,
            name,
            &[
                ("restitution", self.restitution.is_some(), elastic),
                ("at_speed_m_s", self.at_speed_m_s.is_some(), elastic),
                ("viscous_n_s_per_m", self.viscous_n_s_per_m.is_some(), viscous),
            ],
        );
        if viscous {
            let pointer = format!("{at}/viscous_n_s_per_m");
            return DampingLaw::Viscous { coefficient: defaults.require(pointer, &self.viscous_n_s_per_m, 0.0) };
        }
        if law == DampingLawName::None {
            return DampingLaw::None;
        }
        let restitution = defaults.fill(format!("{at}/restitution"), &mut self.restitution, default_restitution);
        let at_speed = defaults.fill(format!("{at}/at_speed_m_s"), &mut self.at_speed_m_s, IMPACT_SPEED);
        match law {
            DampingLawName::HuntCrossley => DampingLaw::HuntCrossley { restitution, at_speed },
            DampingLawName::LankaraniNikravesh => DampingLaw::LankaraniNikravesh { restitution, at_speed },
            DampingLawName::Flores => DampingLaw::Flores { restitution, at_speed },
            _ => DampingLaw::Restitution { restitution, at_speed },
        }
    }
}

impl DampingLawName {
    fn name(self) -> &'static str {
        match self {
            Self::Restitution => "restitution",
            Self::HuntCrossley => "hunt_crossley",
            Self::LankaraniNikravesh => "lankarani_nikravesh",
            Self::Flores => "flores",
            Self::Viscous => "viscous",
            Self::None => "none",
        }
    }
}
