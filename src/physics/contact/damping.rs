//! Dissipation in a contact.

use crate::physics::{InvalidParameter, within};

/// Laws for the damping of an elastic contact `Q = K δ^1.5 (1 + χ δ̇)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DampingLaw {
    /// χ solved so that an impact at `at_speed` [m/s] really returns with `restitution` times its speed.
    Restitution {
        restitution: f64,
        at_speed: f64,
    },
    /// χ = 3 (1 − e) / (2 v₀), as published by Hunt & Crossley.
    HuntCrossley {
        restitution: f64,
        at_speed: f64,
    },
    /// χ = 3 (1 − e²) / (4 v₀), as published by Lankarani & Nikravesh.
    LankaraniNikravesh {
        restitution: f64,
        at_speed: f64,
    },
    /// χ = 8 (1 − e) / (5 e v₀), as published by Flores et al.
    Flores {
        restitution: f64,
        at_speed: f64,
    },
    /// A damper [N s/m] that fades in over the first 0.1 µm of penetration.
    Viscous {
        coefficient: f64,
    },
    None,
}

impl DampingLaw {
    /// Refuses what no contact has; `path` names restitution, speed and coefficient in the error.
    pub fn check(&self, path: [&'static str; 3]) -> Result<(), InvalidParameter> {
        match *self {
            Self::Restitution { restitution, at_speed }
            | Self::HuntCrossley { restitution, at_speed }
            | Self::LankaraniNikravesh { restitution, at_speed }
            | Self::Flores { restitution, at_speed } => {
                within(path[0], restitution, 0.05, 1.0)?;
                within(path[1], at_speed, 1e-6, 100.0)
            }
            Self::Viscous { coefficient } => within(path[2], coefficient, 0.0, 1e9),
            Self::None => Ok(()),
        }
    }
}
