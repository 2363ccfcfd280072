//! Resonances of the spindle on its loaded contacts, with the band of the envelope that holds each.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::job::outputs::ENVELOPE_LIMITS;
use crate::contract::json::numbers::significant;
use raceway_core::simulation::model::contact_resonance::ContactResonance;

/// A resonance of the spindle on its loaded contacts, about the static equilibrium at the operating speed. Impacts excite it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResonanceAnswer {
    /// Frequency without damping [Hz].
    #[schema(minimum = 0, example = 1700)]
    pub frequency_hz: f64,
    /// Unit vector of the motion along X, Y, Z [-].
    #[schema(example = json!([0, 1, 0]))]
    pub direction: [f64; 3],
    /// Band within an octave of it, for `outputs.envelope_band_hz` [Hz].
    #[schema(example = json!([850, 3400]))]
    pub envelope_band_hz: [f64; 2],
}

impl From<&ContactResonance> for ResonanceAnswer {
    fn from(of: &ContactResonance) -> Self {
        let (low, high) = of.band();
        Self {
            frequency_hz: of.frequency,
            direction: of.direction.map(|part| (1e6 * part).round() / 1e6 + 0.0),
            envelope_band_hz: envelope_band(low, high),
        }
    }
}

/// A band that a request accepts [Hz].
pub fn envelope_band(low: f64, high: f64) -> [f64; 2] {
    let [least, most] = ENVELOPE_LIMITS;
    [low, high].map(|edge| significant(edge.clamp(least, most), 2))
}
