//! Waves of the raceways before a run: what the contacts average, what is kept, and what is left out.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::units::{NM, UM};
use raceway_core::physics::bearing::PerRaceway;
use raceway_core::physics::surface::waviness::{KeptWave, Omission, SortedWaves};
use raceway_core::simulation::input::scene::Scene;
use raceway_core::simulation::model::Mechanism;
use raceway_core::simulation::model::surfaces::{RacewayWaves, waves};
use raceway_core::simulation::model::terms::ActiveTerms;

/// Waves of both raceways. A contact averages heights over its width along rolling, 2b. The width is that of the most loaded ball of the
/// static equilibrium at the largest speed, for the whole run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SurfacesAnswer {
    /// Waves of the inner raceway.
    pub inner: RacewayWavesAnswer,
    /// Waves of the outer raceway.
    pub outer: RacewayWavesAnswer,
}

/// Waves of one raceway.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RacewayWavesAnswer {
    /// Load of the most loaded ball [N].
    #[schema(minimum = 0)]
    pub ball_load_n: f64,
    /// Half width b of its contact along rolling [µm].
    #[schema(minimum = 0)]
    pub half_width_um: f64,
    /// Order whose waves are as long as the contact and averaged to zero, π R/b.
    #[schema(minimum = 0)]
    pub first_zero_order: f64,
    /// Number of waves in the model, drawn ones included.
    pub kept: usize,
    /// The first 64 waves in the model, those given in `waviness` first.
    pub waves: Vec<KeptWaveAnswer>,
    /// Ranges of orders that are not in the model.
    pub left_out: Vec<LeftOutOrdersAnswer>,
}

/// A wave in the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct KeptWaveAnswer {
    /// Waves along the circumference.
    pub order: u32,
    /// Amplitude as given or drawn [nm].
    #[schema(minimum = 0)]
    pub amplitude_nm: f64,
    /// Share of the amplitude that the contact's averaging leaves, sin q/q with q = π `order`/`first_zero_order` [-]; negative beyond the
    /// first zero.
    pub averaging: f64,
    /// Frequency at which the wave passes a ball at the largest speed and ideal rolling [Hz].
    #[schema(minimum = 0)]
    pub frequency_hz: f64,
}

/// A range of orders that are not in the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LeftOutOrdersAnswer {
    /// The lowest order.
    pub from_order: u32,
    /// The highest order.
    pub to_order: u32,
    /// Why the model leaves them out.
    pub reason: LeftOutReason,
}

/// `averaged`: beyond three times `first_zero_order` the contact averages a wave to less than 0.11. `fast`: it passes a ball faster than
/// 25.6 kHz.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LeftOutReason {
    Averaged,
    Fast,
}

/// Largest number of listed waves.
const MOST_LISTED: usize = 64;

impl SurfacesAnswer {
    /// `None` where all raceways are ideal circles.
    pub fn of(scene: &Scene, terms: &ActiveTerms) -> Option<Self> {
        let PerRaceway { inner, outer } = waves(&Mechanism::new(scene, terms), scene)?;
        Some(Self { inner: (&inner).into(), outer: (&outer).into() })
    }
}

impl From<&RacewayWaves> for RacewayWavesAnswer {
    fn from(RacewayWaves { load, contact, waves }: &RacewayWaves) -> Self {
        Self {
            ball_load_n: *load,
            half_width_um: UM.to_user(contact.half_width),
            first_zero_order: contact.first_zero(),
            kept: waves.kept.len(),
            waves: waves.kept.iter().take(MOST_LISTED).map(KeptWaveAnswer::from).collect(),
            left_out: ranges(waves),
        }
    }
}

impl From<&KeptWave> for KeptWaveAnswer {
    fn from(kept: &KeptWave) -> Self {
        Self {
            order: kept.wave.order,
            amplitude_nm: NM.to_user(kept.wave.amplitude),
            averaging: kept.share,
            frequency_hz: kept.frequency,
        }
    }
}

/// Left-out orders, consecutive ones with one reason together.
fn ranges(waves: &SortedWaves) -> Vec<LeftOutOrdersAnswer> {
    let mut ranges: Vec<LeftOutOrdersAnswer> = Vec::new();
    for &(order, omission) in &waves.left_out {
        let reason = match omission {
            Omission::Averaged => LeftOutReason::Averaged,
            Omission::Fast => LeftOutReason::Fast,
        };
        match ranges.last_mut() {
            Some(last) if last.reason == reason && last.to_order + 1 == order => last.to_order = order,
            _ => ranges.push(LeftOutOrdersAnswer { from_order: order, to_order: order, reason }),
        }
    }
    ranges
}
