//! The numbers that an engineer reads first: levels of one acceleration in the units and references of the trade.

use raceway_core::simulation::recording::bands::{Band, BandMetrics};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Standard acceleration of gravity [m/s²].
const G: f64 = 9.806_65;
/// Speed at which vibration of bearings is measured [r/min] (ISO 15242-1), and its tolerance.
const TEST_SPEED_RPM: f64 = 1800.0;
const TEST_SPEED_TOLERANCE: f64 = 0.02;
/// Displacement of one anderon in one radian of rotation, one octave wide [µm]: a microinch.
const ANDERON_UM: f64 = 0.0254;

/// Levels of the first acceleration of a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HeadlineAnswer {
    /// The channel of these numbers: `spindle.y.acceleration`; of a machine its first sensor or, without sensors, its first bearing along y.
    #[schema(example = "spindle.y.acceleration")]
    pub channel: String,
    /// Root mean square from 0 to 20 kHz [m/s²].
    #[schema(minimum = 0)]
    pub rms_m_s2: f64,
    /// The same [g], g = 9.80665 m/s².
    #[schema(minimum = 0)]
    pub rms_g: f64,
    /// Largest magnitude from 0 to 20 kHz [m/s²].
    #[schema(minimum = 0)]
    pub peak_m_s2: f64,
    /// The same [g].
    #[schema(minimum = 0)]
    pub peak_g: f64,
    /// Root mean square of the velocity from 10 to 1000 Hz [mm/s], as in `channels`; absent below 0.2 s of recorded time.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub velocity_10_1000_hz_mm_s: Option<f64>,
    /// Vibration in bands, as in `channels`.
    pub bands: Vec<BandAnswer>,
    /// Levels in decibels, each with its reference.
    pub levels: Vec<LevelAnswer>,
}

/// A level in decibels, 20 lg(rms / reference).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LevelAnswer {
    /// The acceleration from 0 to 20 kHz, or the velocity from 10 to 1000 Hz.
    pub quantity: LevelQuantity,
    /// Who uses the reference.
    pub standard: LevelStandard,
    /// The reference, in `unit`.
    #[schema(minimum = 0, example = 1e-6)]
    pub reference: f64,
    /// Unit of `reference`.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// The level [dB].
    pub db: f64,
}

/// Quantity of a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LevelQuantity {
    Acceleration,
    Velocity,
}

/// `iso1683`: references of ISO 1683, 10⁻⁶ m/s² and 10⁻⁹ m/s. `trade`: 9.81·10⁻³ m/s², that of `level_db`. `vdb_us`: 2.54·10⁻⁸ m/s, 1 µin/s.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LevelStandard {
    Iso1683,
    Trade,
    VdbUs,
}

/// Vibration of a channel in a frequency band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BandAnswer {
    /// Lower end of the band [Hz].
    #[schema(minimum = 0)]
    pub from_hz: f64,
    /// Upper end of the band [Hz].
    #[schema(minimum = 0)]
    pub to_hz: f64,
    /// Root mean square of the velocity [µm/s].
    #[schema(minimum = 0)]
    pub velocity_rms_um_s: f64,
    /// Root mean square of the acceleration [m/s²].
    #[schema(minimum = 0)]
    pub acceleration_rms_m_s2: f64,
    /// The velocity in anderons [-]: over 4.788 µm/s √n, n octaves of the band, which is a microinch per radian at 1800 r/min. Radial accelerations
    /// at a constant speed within 2 % of it only. The standard measures the outer ring, so that no quality class follows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub anderon: Option<f64>,
}

/// Acceleration in multiples of g.
pub fn in_g(acceleration: f64) -> f64 {
    acceleration / G
}

/// Velocity from 10 to 1000 Hz [mm/s].
pub fn velocity_mm_s(metrics: &BandMetrics) -> Option<f64> {
    metrics.severity.map(|velocity| 1e3 * velocity)
}

/// Bands of an acceleration; with anderons where it is `radial` and the shaft turns at a constant speed [r/min] of the test.
pub fn bands(metrics: &BandMetrics, radial_at_rpm: Option<f64>) -> Vec<BandAnswer> {
    let speed = radial_at_rpm.filter(|speed| (speed.abs() / TEST_SPEED_RPM - 1.0).abs() <= TEST_SPEED_TOLERANCE);
    let of = |band: &Band| {
        let velocity = 1e6 * band.velocity;
        BandAnswer {
            from_hz: band.from,
            to_hz: band.to,
            velocity_rms_um_s: velocity,
            acceleration_rms_m_s2: band.acceleration,
            anderon: speed.map(|_| velocity / anderon_um_s(band)),
        }
    };
    metrics.bands.iter().map(of).collect()
}

/// Velocity of one anderon in a band at the speed of the test [µm/s].
fn anderon_um_s(band: &Band) -> f64 {
    let radians_per_second = TEST_SPEED_RPM * std::f64::consts::TAU / 60.0;
    ANDERON_UM * radians_per_second * (band.to / band.from).log2().sqrt()
}

impl HeadlineAnswer {
    /// The headline of an acceleration with its root mean square and peak [m/s²]; `None` of one that is silent.
    pub fn of(channel: String, rms: f64, peak: f64, metrics: &BandMetrics, bands: Vec<BandAnswer>) -> Option<Self> {
        (rms > 0.0).then(|| Self {
            channel,
            rms_m_s2: rms,
            rms_g: in_g(rms),
            peak_m_s2: peak,
            peak_g: in_g(peak),
            velocity_10_1000_hz_mm_s: velocity_mm_s(metrics),
            bands,
            levels: levels(rms, metrics.severity),
        })
    }
}

/// Levels of an acceleration [m/s²] and of a velocity [m/s] about every reference.
fn levels(acceleration: f64, velocity: Option<f64>) -> Vec<LevelAnswer> {
    use LevelQuantity::{Acceleration, Velocity};
    use LevelStandard::{Iso1683, Trade, VdbUs};
    let rows = [
        (Acceleration, Iso1683, 1e-6, Some(acceleration)),
        (Acceleration, Trade, 9.81e-3, Some(acceleration)),
        (Velocity, Iso1683, 1e-9, velocity),
        (Velocity, VdbUs, 2.54e-8, velocity),
    ];
    let level = |(quantity, standard, reference, value): (LevelQuantity, LevelStandard, f64, Option<f64>)| {
        let unit = if quantity == Acceleration { "m/s²" } else { "m/s" };
        let value = value.filter(|value| *value > 0.0)?;
        Some(LevelAnswer {
            quantity,
            standard,
            reference,
            unit: unit.to_owned(),
            db: 20.0 * (value / reference).log10(),
        })
    };
    rows.into_iter().filter_map(level).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.1 m/s² and 1 mm/s.
    #[test]
    fn levels_have_their_references() {
        let found = levels(0.1, Some(1e-3));
        let db = found.iter().map(|level| level.db).collect::<Vec<_>>();
        for (db, expected) in db.iter().zip([100.0, 20.167, 120.0, 91.903]) {
            assert!((db - expected).abs() < 1e-3, "{found:?}");
        }
        assert!((db[0] - db[1] - 79.833).abs() < 1e-3);
        assert_eq!(levels(0.1, None).len(), 2);
    }

    #[test]
    fn an_anderon_is_a_microinch_per_radian() {
        let band = |from, to| Band { from, to, velocity: 7.698e-6, acceleration: 0.0 };
        for (of, expected) in
            [(band(50.0, 300.0), 7.698), (band(300.0, 1800.0), 7.698), (band(1800.0, 10_000.0), 7.531)]
        {
            assert!((anderon_um_s(&of) / expected - 1.0).abs() < 1e-4, "{}", anderon_um_s(&of));
        }
        let metrics =
            BandMetrics { resolution: 1.0, bands: vec![band(50.0, 300.0)], severity: None, parseval_ratio: None };
        let anderon = |speed| bands(&metrics, speed)[0].anderon;
        assert!((anderon(Some(-1797.0)).unwrap() - 1.0).abs() < 1e-4);
        assert_eq!([anderon(Some(1750.0)), anderon(None)], [None, None]);
    }
}
