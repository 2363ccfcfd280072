//! Traction of a lubricated contact with slip, spin and conformity.

use crate::physics::{InvalidParameter, above, within};

/// Traction coefficient μ as a function of slip speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TractionLaw {
    /// μ = (A + B|u|) e^(−C|u|) + D from μ at rest, its maximum, the slip speed [m/s] where it is
    /// reached, and its limit at high slip.
    FourParameter { at_rest: f64, maximum: f64, at_slip: f64, limit: f64 },
    /// The same form over the slide/roll ratio s = u / max(ū, 0.1 m/s), coefficients given.
    SlideRoll { a: f64, b: f64, c: f64, d: f64 },
    /// τ = min(τ_E asinh(η(p) u / (h τ_E)), Λ p), Eyring stress τ_E [Pa], limit Λ.
    Eyring { stress: f64, limit: f64 },
    /// μ tanh(u / u_r), regularisation speed u_r [m/s].
    Coulomb { coefficient: f64, regularisation: f64 },
}

impl TractionLaw {
    /// Refuses coefficients that no contact has.
    pub fn check(&self) -> Result<(), InvalidParameter> {
        match *self {
            Self::FourParameter { at_rest, maximum, at_slip, limit } => {
                within("lubricant.traction.at_rest", at_rest, 0.0, 2.0)?;
                within("lubricant.traction.maximum", maximum, 0.0, 2.0)?;
                within("lubricant.traction.at_slip", at_slip, 1e-5, 1000.0)?;
                within("lubricant.traction.limit", limit, 0.0, 2.0)?;
                if maximum < at_rest || maximum < limit {
                    return Err(InvalidParameter::Inconsistent {
                        parameter: "lubricant.traction.maximum",
                        reason: format!(
                            "{maximum} must be at least the value at rest ({at_rest}) and the limit ({limit})"
                        ),
                    });
                }
                Ok(())
            }
            Self::SlideRoll { a, b, c, d } => {
                for (parameter, value) in
                    [("lubricant.traction.a", a), ("lubricant.traction.b", b), ("lubricant.traction.d", d)]
                {
                    within(parameter, value, -1e4, 1e4)?;
                }
                within("lubricant.traction.c", c, 0.0, 1e6)
            }
            Self::Eyring { stress, limit } => {
                above("lubricant.traction.stress", stress, 0.0, 1e9)?;
                within("lubricant.traction.limit", limit, 0.0, 2.0)
            }
            Self::Coulomb { coefficient, regularisation } => {
                within("lubricant.traction.coefficient", coefficient, 0.0, 2.0)?;
                within("lubricant.traction.regularisation", regularisation, 1e-5, 100.0)
            }
        }
    }
}
