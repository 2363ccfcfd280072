//! Surfaces before a run: waves that the contacts average, keep or leave out, what a ball feels of each defect, and each ball.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::units::{NM, UM, US};
use raceway_core::physics::bearing::PerRaceway;
use raceway_core::physics::surface::ball::BallSurface;
use raceway_core::physics::surface::defects::Recess;
use raceway_core::physics::surface::waviness::{KeptWave, Omission, SortedWaves};
use raceway_core::simulation::input::scene::Scene;
use raceway_core::simulation::model::Mechanism;
use raceway_core::simulation::model::surfaces::{
    AveragedBall, AveragedSurface, averaged_balls, averaged_surfaces, ball_loads_at,
};
use raceway_core::simulation::model::terms::ActiveTerms;

/// Waves and defects of both raceways, and each ball. A contact averages heights over its width along rolling, 2b. The width is that of the most loaded ball of the
/// static equilibrium at the largest speed, for the whole run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SurfacesAnswer {
    /// Surface of the inner raceway.
    pub inner: RacewaySurfaceAnswer,
    /// Surface of the outer raceway.
    pub outer: RacewaySurfaceAnswer,
    /// Each ball; empty where all are alike.
    pub balls: Vec<BallSurfaceAnswer>,
}

/// Surface of one ball.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BallSurfaceAnswer {
    /// Number of the ball, from 1.
    #[schema(minimum = 1)]
    pub ball: usize,
    /// Deviation of its diameter from `ball_diameter_mm`, given and drawn [µm].
    pub diameter_um: f64,
    /// As the inner raceway averages and feels them; absent for a sphere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub inner: Option<BallContactAnswer>,
    /// As the outer raceway averages and feels them; absent for a sphere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub outer: Option<BallContactAnswer>,
}

/// Waves and defects of a ball at one raceway.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BallContactAnswer {
    /// Order whose waves are as long as the contact and averaged to zero, π d/2b.
    #[schema(minimum = 0)]
    pub first_zero_order: f64,
    /// Number of waves in the model, drawn ones included.
    pub kept: usize,
    /// The first 8 waves in the model, those given in `waviness` first.
    pub waves: Vec<KeptWaveAnswer>,
    /// Ranges of orders that are not in the model.
    pub left_out: Vec<LeftOutOrdersAnswer>,
    /// Defects with a depth above 0, in the order of the request, under the most loaded ball.
    pub defects: Vec<DefectAnswer>,
}

/// Waves and defects of one raceway.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RacewaySurfaceAnswer {
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
    /// Waves of the groove's place along the axis in the model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub axial_waves: Vec<KeptWaveAnswer>,
    /// Ranges of orders of `axial_waviness` that are not in the model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub axial_left_out: Vec<LeftOutOrdersAnswer>,
    /// Defects with a depth above 0, in the order of the request.
    pub defects: Vec<DefectAnswer>,
}

/// Passage of a ball over a defect at the largest speed and ideal rolling. Times are absent at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DefectAnswer {
    /// Drop of a ball that rests on both edges, by length and relative curvature alone [µm].
    #[schema(minimum = 0)]
    pub edge_drop_um: f64,
    /// True if the ball reaches the floor: the drop exceeds the depth, and the defect is wide enough for the ball.
    pub reaches_floor: bool,
    /// Deepest fall of the ball on its path [µm].
    #[schema(minimum = 0)]
    pub fall_um: f64,
    /// Width over that of the contact [-]; absent if the defect takes the whole groove. Below 1 the raceway beside the defect carries the ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub width_over_contact: Option<f64>,
    /// Speed of the contact along the raceway [m/s].
    #[schema(minimum = 0)]
    pub contact_speed_m_s: f64,
    /// Time from the entry, where the middle of the contact passes the first edge, to the last impact [µs]: that to the middle and
    /// `impact_beside_middle_us`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub entry_to_impact_us: Option<f64>,
    /// Times of the strongest impacts before and after the middle [µs], where the ball meets and leaves the floor, or the ground beside a
    /// narrow defect; 0 if it stays on both edges, with one impact in the middle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub impact_beside_middle_us: Option<f64>,
    /// Load of a ball in the middle of the defect, on ideal raceways [N]; of raceways and balls that turn through the load, the largest.
    #[schema(minimum = 0)]
    pub ball_load_n: f64,
    /// True if the inner raceway presses a ball into the defect at some time. Outside the load zone, balls hardly feel a defect.
    pub in_load_zone: bool,
    /// Load above which a ball follows an edge and does not fly [N].
    #[schema(minimum = 0)]
    pub following_load_n: f64,
    /// Longest step that resolves the path [µs].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub longest_step_us: Option<f64>,
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

/// Largest number of listed waves, of a raceway and of a ball.
const MOST_LISTED: usize = 64;
const MOST_OF_BALL: usize = 8;

impl SurfacesAnswer {
    /// `None` where all raceways are ideal circles and all balls are alike.
    pub fn of(scene: &Scene, terms: &ActiveTerms) -> Option<Self> {
        let mechanism = Mechanism::new(scene, terms);
        let PerRaceway { inner, outer } = averaged_surfaces(&mechanism, scene)?;
        let mass = scene.bearing.ball_mass;
        let on_inner = inner.defects.iter().map(|recess| DefectAnswer::of(recess, mass, inner.load, inner.load));
        let on_outer = outer.defects.iter().map(|recess| {
            let loads = match scene.operation.rotation().outer_stands() {
                true => ball_loads_at(&mechanism, scene, recess.defect.azimuth),
                false => PerRaceway { inner: inner.load, outer: outer.load },
            };
            DefectAnswer::of(recess, mass, loads.outer, loads.inner)
        });
        Some(Self {
            inner: RacewaySurfaceAnswer::of(&inner, on_inner.collect()),
            outer: RacewaySurfaceAnswer::of(&outer, on_outer.collect()),
            balls: balls(&mechanism, scene, PerRaceway { inner: inner.load, outer: outer.load }),
        })
    }
}

/// Each ball, where they differ; `load`: of the most loaded ball [N].
fn balls(mechanism: &Mechanism, scene: &Scene, load: PerRaceway<f64>) -> Vec<BallSurfaceAnswer> {
    let mass = scene.bearing.ball_mass;
    let averaged = averaged_balls(mechanism, scene);
    let one = |(index, surface): (usize, &BallSurface)| {
        let uneven = averaged.get(index).filter(|_| !surface.is_sphere());
        BallSurfaceAnswer {
            ball: index + 1,
            diameter_um: UM.to_user(surface.diameter_deviation),
            inner: uneven.map(|ball| BallContactAnswer::of(&ball.inner, mass, load.inner)),
            outer: uneven.map(|ball| BallContactAnswer::of(&ball.outer, mass, load.outer)),
        }
    };
    scene.surfaces.balls.iter().enumerate().map(one).collect()
}

impl BallContactAnswer {
    fn of(AveragedBall { contact, waves, defects }: &AveragedBall, ball_mass: f64, load: f64) -> Self {
        Self {
            first_zero_order: contact.first_zero(),
            kept: waves.kept.len(),
            waves: waves.kept.iter().take(MOST_OF_BALL).map(KeptWaveAnswer::from).collect(),
            left_out: ranges(waves),
            defects: defects.iter().map(|of| DefectAnswer::of(&of.recess, ball_mass, load, load)).collect(),
        }
    }
}

impl RacewaySurfaceAnswer {
    fn of(averaged: &AveragedSurface, defects: Vec<DefectAnswer>) -> Self {
        let AveragedSurface { load, contact, waves, axial_waves, .. } = averaged;
        Self {
            ball_load_n: *load,
            half_width_um: UM.to_user(contact.half_width),
            first_zero_order: contact.first_zero(),
            kept: waves.kept.len(),
            waves: waves.kept.iter().take(MOST_LISTED).map(KeptWaveAnswer::from).collect(),
            left_out: ranges(waves),
            axial_waves: axial_waves.kept.iter().map(KeptWaveAnswer::from).collect(),
            axial_left_out: ranges(axial_waves),
            defects,
        }
    }
}

impl DefectAnswer {
    /// `ball_mass` [kg], `load` of a ball in its middle [N], `pressed`: by the inner raceway [N].
    fn of(recess: &Recess, ball_mass: f64, load: f64, pressed: f64) -> Self {
        let time = |of: fn(&Recess) -> f64| Some(US.to_user(of(recess))).filter(|time| time.is_finite());
        Self {
            edge_drop_um: UM.to_user(recess.edge_drop()),
            reaches_floor: recess.is_bottomed(),
            fall_um: UM.to_user(recess.deepest()),
            width_over_contact: recess.width_over_contact(),
            contact_speed_m_s: recess.contact.speed,
            entry_to_impact_us: time(Recess::entry_to_impact),
            impact_beside_middle_us: time(Recess::impact_beside_middle),
            ball_load_n: load,
            in_load_zone: pressed > 0.0,
            following_load_n: ball_mass * recess.edge_acceleration(),
            longest_step_us: time(Recess::longest_step),
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
