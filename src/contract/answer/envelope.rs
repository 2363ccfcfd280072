//! Envelope of a channel at the rates at which defects are felt.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use raceway_core::simulation::result::envelope_harmonics::{EnvelopeHarmonics, Harmonics};

/// Amplitudes of the envelope spectrum (`outputs.envelope_band_hz`, `outputs.envelope`) at the rates of the bearing at the simulated speeds:
/// columns of a study, or the metric of an optimum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EnvelopeAnswer {
    /// At the speed of the shaft: a defect of the inner raceway turns through the load.
    pub shaft: HarmonicsAnswer,
    /// At the speed of the cage, which carries a faulty ball through the load.
    pub cage: HarmonicsAnswer,
    /// At the ball pass frequency of the outer raceway.
    pub ball_pass_outer: HarmonicsAnswer,
    /// At the ball pass frequency of the inner raceway.
    pub ball_pass_inner: HarmonicsAnswer,
    /// At twice the spin of uneven balls: a defect of a ball meets both raceways in a turn.
    pub double_ball_spin: HarmonicsAnswer,
}

/// Amplitudes at a rate and its multiples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HarmonicsAnswer {
    /// At the rate, in the unit of the envelope; absent where a line of another rate hides the place, or the record is too short for a line of
    /// its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub first: Option<f64>,
    /// At twice the rate; absent in the same way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub second: Option<f64>,
    /// At three times the rate; absent in the same way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub third: Option<f64>,
    /// `first` over the rms of the channel, or over its square for a squared envelope [-]; absent without motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub first_over_rms: Option<f64>,
}

impl EnvelopeAnswer {
    /// `reference`: rms of the channel in the unit of the envelope.
    pub fn of(of: &EnvelopeHarmonics, reference: f64) -> Self {
        let harmonics = |&[first, second, third]: &Harmonics| HarmonicsAnswer {
            first,
            second,
            third,
            first_over_rms: first.filter(|_| reference > 0.0).map(|first| first / reference),
        };
        Self {
            shaft: harmonics(&of.shaft),
            cage: harmonics(&of.cage),
            ball_pass_outer: harmonics(&of.ball_pass_outer),
            ball_pass_inner: harmonics(&of.ball_pass_inner),
            double_ball_spin: harmonics(&of.double_ball_spin),
        }
    }
}
