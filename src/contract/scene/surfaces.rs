//! Surfaces of raceways and balls.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::preset_names::SurfaceName;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::out_of_range;
use crate::contract::json::problem::listed;
use crate::contract::json::shapes::{
    optional_list, optional_object, required_whole_number, whole_number, wide_whole_number,
};
use crate::contract::json::units::{DEG, MM, NM, NUMBER, UM, Unit};
use raceway_core::physics::bearing::PerRaceway;
use raceway_core::physics::limits::limits_of;
use raceway_core::physics::presets::{self, SurfacePreset};
use raceway_core::physics::surface::ball::{BallDefect, BallSurface, EveryBall, GivenBall};
use raceway_core::physics::surface::defects::{Defect, Shape};
use raceway_core::physics::surface::waviness::{RacewaySurface, RandomWaviness, SurfaceParameters, Wave};

/// Order at which the amplitude of random waviness is given, its exponent and its lowest order, where they are not given. Machined
/// surfaces fall about as 1/n; order 1 is runout.
const AT_ORDER: u32 = 10;
const EXPONENT: f64 = 1.0;
const FROM_ORDER: u32 = 2;
pub(super) const SEED: u64 = 1;

/// Surfaces of the raceways, which are ideal circles by default, and of the balls, which are alike by default.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfacesInput {
    /// Quality of both raceways. It gives `random_waviness` of the raceways that have none: an amplitude of 1 nm (`precision`), 5 nm
    /// (`standard`) or 25 nm (`worn`) at order 10, falling as 1/order. These amplitudes are assumptions; no standard fixes them. Default:
    /// no waviness but the given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<SurfaceName>, example = "standard")]
    pub preset: Option<String>,
    /// Raceway of the inner ring. Azimuths turn with the ring and are those about the bearing at t = 0.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub inner: Option<RacewaySurfaceInput>,
    /// Raceway of the outer ring.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub outer: Option<RacewaySurfaceInput>,
    /// Balls that differ from the others, at most one item for each. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 64)]
    pub balls: Option<Vec<BallSurfaceInput>>,
    /// Drawn differences of all balls, in addition to `balls`. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub every_ball: Option<EveryBallInput>,
    /// Seed of all drawn numbers. A number depends on seed, raceway or ball, kind and order alone. Default 1.
    #[serde(default, deserialize_with = "wide_whole_number")]
    #[schema(nullable = false, value_type = u64, minimum = 0, maximum = 9_007_199_254_740_991_u64, example = 1)]
    pub seed: Option<u64>,
}

/// Surface of one raceway.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RacewaySurfaceInput {
    /// Waves of the height, along the contact normal and out of the material. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 64)]
    pub waviness: Option<Vec<WaveInput>>,
    /// Waves of many orders with drawn phases, in addition to `waviness`. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub random_waviness: Option<RandomWavinessInput>,
    /// Waves of the groove's place along +X, on `full` only. An order of 1 is face runout. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 64)]
    pub axial_waviness: Option<Vec<WaveInput>>,
    /// Local defects, with outlines that do not overlap. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 16)]
    pub defects: Option<Vec<DefectInput>>,
}

/// A recess of the raceway with a rectangular outline: a spall, a pit or a groove.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DefectInput {
    /// Azimuth of its middle on the ring, from +Y towards +Z, on the inner ring as at t = 0 [°]. Default 0.
    #[schema(nullable = false)]
    pub azimuth_deg: Option<f64>,
    /// Length along the raceway [mm]. Between both edges a ball falls by the length squared, times the relative curvature, over 8.
    #[schema(example = 1.0)]
    pub length_mm: f64,
    /// Width across the groove [mm]. A defect narrower than the contact is hardly felt. Default: the whole groove.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub width_mm: Option<f64>,
    /// Depth [µm].
    #[schema(example = 10.0)]
    pub depth_um: f64,
    /// Place of its middle across the groove, from the bottom towards +X [mm]; with `width_mm` only. Default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub across_mm: Option<f64>,
    /// Form of its floor. Default `rectangular`.
    #[schema(nullable = false)]
    pub shape: Option<DefectShape>,
}

/// `rectangular`: the full depth from edge to edge. `half_sine`: the depth in the middle, along the raceway as half a sine wave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum DefectShape {
    Rectangular,
    HalfSine,
}

/// Surface of one ball. Its frame at t = 0: axis 2 from its centre to its outer contact, axis 3 along the orbit from +Y towards +Z,
/// axis 1 = 2 × 3.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BallSurfaceInput {
    /// Number of the ball, from 1. Ball 1 starts at azimuth 0, the others follow from +Y towards +Z.
    #[serde(deserialize_with = "required_whole_number::<_, 1, 64>")]
    #[schema(value_type = u64, example = 1)]
    pub ball: u32,
    /// Deviation of its diameter from `ball_diameter_mm`, at most a hundredth of that [µm]. Default 0.
    #[schema(nullable = false, example = 0.5)]
    pub diameter_um: Option<f64>,
    /// Waves round its equator, the great circle of axes 2 and 3. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 64)]
    pub waviness: Option<Vec<WaveInput>>,
    /// Waves of many orders with drawn phases, in addition to `waviness`. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub random_waviness: Option<RandomWavinessInput>,
    /// Local defects. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 4)]
    pub defects: Option<Vec<BallDefectInput>>,
}

/// A round recess of a ball.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BallDefectInput {
    /// Diameter [mm].
    #[schema(example = 0.5)]
    pub diameter_mm: f64,
    /// Depth [µm].
    #[schema(example = 10.0)]
    pub depth_um: f64,
    /// Angle of its middle from the ball's equator towards axis 1 [°]. Default 0.
    #[schema(nullable = false)]
    pub latitude_deg: Option<f64>,
    /// Angle of its middle along the equator, from axis 2 towards axis 3 [°]. Default 0.
    #[schema(nullable = false)]
    pub longitude_deg: Option<f64>,
}

/// Drawn differences of all balls.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct EveryBallInput {
    /// Waves of many orders on each ball, with drawn phases. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub random_waviness: Option<RandomWavinessInput>,
    /// Largest less smallest of drawn diameters, whose mean is `ball_diameter_mm` [µm]; at most a hundredth of that. Default 0.
    #[schema(nullable = false, example = 0.2)]
    pub diameter_spread_um: Option<f64>,
}

/// A wave of the height: amplitude · cos(order · azimuth + phase), azimuth from +Y towards +Z.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WaveInput {
    /// Periods round the ring: 1 is runout, 2 ovality. Waves shorter than the contact are averaged away.
    #[serde(deserialize_with = "required_whole_number::<_, 1, 100_000>")]
    #[schema(value_type = u64, example = 8)]
    pub order: u32,
    /// Amplitude [nm].
    #[schema(example = 10.0)]
    pub amplitude_nm: f64,
    /// Phase [°]. Default 0.
    #[schema(nullable = false)]
    pub phase_deg: Option<f64>,
}

/// Waves of all orders of a range with random phases and the amplitudes `amplitude_nm` · (order/`at_order`)^−`exponent`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomWavinessInput {
    /// Amplitude of the wave of order `at_order` [nm]. Raceways usually have 1 to 100 nm.
    #[schema(example = 5.0)]
    pub amplitude_nm: f64,
    /// Order to which the amplitude belongs. Default 10.
    #[serde(default, deserialize_with = "whole_number::<_, 1, 100_000>")]
    #[schema(nullable = false, value_type = u64)]
    pub at_order: Option<u32>,
    /// Exponent by which amplitudes fall with the order [-]. Default 1.
    #[schema(nullable = false)]
    pub exponent: Option<f64>,
    /// Lowest order. Default 2.
    #[serde(default, deserialize_with = "whole_number::<_, 1, 100_000>")]
    #[schema(nullable = false, value_type = u64)]
    pub from_order: Option<u32>,
    /// Highest order. Default: the order whose waves are as long as the contact of the most loaded ball, which averages them to zero.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "whole_number::<_, 1, 100_000>")]
    #[schema(nullable = false, value_type = u64)]
    pub to_order: Option<u32>,
}

/// Refuses numbers outside their limits, each by its own pointer. `fields`: the parameter's last name, its field, value and unit.
pub(super) fn are_within_limits(
    defaults: &mut Defaults,
    (at, parameters): (&str, &str),
    fields: &[(&str, &str, f64, Unit)],
) -> bool {
    let known_errors = defaults.errors.len();
    for &(parameter, field, value, unit) in fields {
        let Some(limits) = limits_of(&format!("{parameters}.{parameter}")) else { continue };
        let si = unit.to_si(value);
        let is_inside = si <= limits.highest && if limits.exclusive { si > limits.lowest } else { si >= limits.lowest };
        if !is_inside {
            let (lowest, highest) = (unit.to_user(limits.lowest), unit.to_user(limits.highest));
            let detail = out_of_range(value, lowest, highest, limits.exclusive, unit.name);
            defaults.refuse(format!("{at}/{field}"), detail);
        }
    }
    defaults.errors.len() == known_errors
}

impl SurfacesInput {
    /// The surfaces of `physics`. An item with an error is left out.
    pub fn resolve(&mut self, defaults: &mut Defaults) -> SurfaceParameters {
        self.fill_from_preset(defaults);
        let mut of = |name: &str, surface: &mut Option<RacewaySurfaceInput>| {
            surface.as_mut().map(|surface| surface.resolve(name, defaults)).unwrap_or_default()
        };
        let raceway = PerRaceway { inner: of("inner", &mut self.inner), outer: of("outer", &mut self.outer) };
        let balls = self.balls.iter_mut().flatten().enumerate();
        let balls = balls.filter_map(|(index, ball)| ball.resolve(index, defaults)).collect();
        let every_ball = self.every_ball.as_mut().map(|every| every.resolve(defaults)).unwrap_or_default();
        let seed = defaults.fill("/scene/surfaces/seed", &mut self.seed, SEED);
        SurfaceParameters { raceway, balls, every_ball, seed }
    }

    /// Gives raceways without random waviness that of the preset.
    fn fill_from_preset(&mut self, defaults: &mut Defaults) {
        let Some(name) = &self.preset else { return };
        let Some(preset) = presets::surface(name) else {
            let known = listed(presets::SURFACES.map(|preset| preset.name));
            defaults.refuse("/scene/surfaces/preset", format!("`{name}` is no preset; known: {known}"));
            return;
        };
        for (ring, surface) in [("inner", &mut self.inner), ("outer", &mut self.outer)] {
            if defaults.is_unread(&format!("/scene/surfaces/{ring}")) {
                continue;
            }
            let random = &mut surface.get_or_insert_default().random_waviness;
            if random.is_none() {
                defaults.filled.push(format!("/scene/surfaces/{ring}/random_waviness/amplitude_nm"));
                *random = Some(RandomWavinessInput::of(preset));
            }
        }
    }
}

impl RandomWavinessInput {
    /// That of a preset, all other fields left to their defaults.
    pub(super) fn of(preset: &SurfacePreset) -> Self {
        let amplitude_nm = NM.to_user(preset.amplitude);
        Self { amplitude_nm, at_order: None, exponent: None, from_order: None, to_order: None }
    }

    /// The waviness of `physics`, after its defaults have been filled in; `at`: its pointer.
    pub(super) fn fill(&mut self, at: &str, defaults: &mut Defaults) -> RandomWaviness {
        RandomWaviness {
            amplitude: NM.to_si(self.amplitude_nm),
            at_order: defaults.fill(format!("{at}/at_order"), &mut self.at_order, AT_ORDER),
            exponent: defaults.fill(format!("{at}/exponent"), &mut self.exponent, EXPONENT),
            from_order: defaults.fill(format!("{at}/from_order"), &mut self.from_order, FROM_ORDER),
            to_order: self.to_order,
        }
    }
}

impl RacewaySurfaceInput {
    fn resolve(&mut self, name: &str, defaults: &mut Defaults) -> RacewaySurface {
        let waviness = resolve_waves(&mut self.waviness, (name, name, "waviness"), defaults);
        let axial_waviness = resolve_waves(&mut self.axial_waviness, (name, name, "axial_waviness"), defaults);
        let random_waviness =
            self.random_waviness.as_mut().map(|random| random.fill(&random_waviness_of(name), defaults));
        RacewaySurface { waviness, random_waviness, axial_waviness, defects: self.resolve_defects(name, defaults) }
    }
}

/// Pointer to the random waviness of a surface.
fn random_waviness_of(surface: &str) -> String {
    format!("/scene/surfaces/{surface}/random_waviness")
}

/// Waves given one by one, without those that have an error. `at`: the pointer under `/scene/surfaces` of what has them, `name`: its name
/// in `physics`, `field`: that of the waves.
fn resolve_waves(
    waves: &mut Option<Vec<WaveInput>>,
    (at, name, field): (&str, &str, &str),
    defaults: &mut Defaults,
) -> Vec<Wave> {
    let mut resolved = Vec::new();
    for (index, wave) in waves.iter_mut().flatten().enumerate() {
        let at = format!("/scene/surfaces/{at}/{field}/{index}");
        let phase = defaults.fill(format!("{at}/phase_deg"), &mut wave.phase_deg, 0.0);
        let fields = [
            ("order", "order", f64::from(wave.order), NUMBER),
            ("amplitude", "amplitude_nm", wave.amplitude_nm, NM),
            ("phase", "phase_deg", phase, DEG),
        ];
        if are_within_limits(defaults, (&at, &format!("surfaces.{name}.{field}")), &fields) {
            resolved.push(Wave { order: wave.order, amplitude: NM.to_si(wave.amplitude_nm), phase: DEG.to_si(phase) });
        }
    }
    resolved
}

impl BallSurfaceInput {
    /// `None` where a number is wrong, which would be reported twice.
    fn resolve(&mut self, index: usize, defaults: &mut Defaults) -> Option<GivenBall> {
        let of = format!("balls/{index}");
        let at = format!("/scene/surfaces/{of}");
        let deviation = defaults.fill(format!("{at}/diameter_um"), &mut self.diameter_um, 0.0);
        let fields =
            [("ball", "ball", f64::from(self.ball), NUMBER), ("diameter_deviation", "diameter_um", deviation, UM)];
        let is_valid = are_within_limits(defaults, (&at, "surfaces.balls"), &fields);
        let surface = BallSurface {
            diameter_deviation: UM.to_si(deviation),
            waviness: resolve_waves(&mut self.waviness, (&of, "balls", "waviness"), defaults),
            random_waviness: self
                .random_waviness
                .iter_mut()
                .map(|random| random.fill(&random_waviness_of(&of), defaults))
                .collect(),
            defects: self.resolve_defects(&at, defaults),
        };
        is_valid.then_some(GivenBall { ball: self.ball, surface })
    }

    fn resolve_defects(&mut self, at: &str, defaults: &mut Defaults) -> Vec<BallDefect> {
        let mut defects = Vec::new();
        for (index, defect) in self.defects.iter_mut().flatten().enumerate() {
            let at = format!("{at}/defects/{index}");
            let latitude = defaults.fill(format!("{at}/latitude_deg"), &mut defect.latitude_deg, 0.0);
            let longitude = defaults.fill(format!("{at}/longitude_deg"), &mut defect.longitude_deg, 0.0);
            let fields = [
                ("diameter", "diameter_mm", defect.diameter_mm, MM),
                ("depth", "depth_um", defect.depth_um, UM),
                ("latitude", "latitude_deg", latitude, DEG),
                ("longitude", "longitude_deg", longitude, DEG),
            ];
            if are_within_limits(defaults, (&at, "surfaces.balls.defects"), &fields) {
                defects.push(BallDefect {
                    diameter: MM.to_si(defect.diameter_mm),
                    depth: UM.to_si(defect.depth_um),
                    latitude: DEG.to_si(latitude),
                    longitude: DEG.to_si(longitude),
                });
            }
        }
        defects
    }
}

impl EveryBallInput {
    fn resolve(&mut self, defaults: &mut Defaults) -> EveryBall {
        let at = "/scene/surfaces/every_ball";
        let spread = defaults.fill(format!("{at}/diameter_spread_um"), &mut self.diameter_spread_um, 0.0);
        let random_waviness =
            self.random_waviness.as_mut().map(|random| random.fill(&random_waviness_of("every_ball"), defaults));
        EveryBall { random_waviness, diameter_spread: UM.to_si(spread) }
    }
}

impl RacewaySurfaceInput {
    fn resolve_defects(&mut self, name: &str, defaults: &mut Defaults) -> Vec<Defect> {
        let mut defects = Vec::new();
        for (index, defect) in self.defects.iter_mut().flatten().enumerate() {
            let at = format!("/scene/surfaces/{name}/defects/{index}");
            let azimuth = defaults.fill(format!("{at}/azimuth_deg"), &mut defect.azimuth_deg, 0.0);
            let shape = defaults.fill(format!("{at}/shape"), &mut defect.shape, DefectShape::Rectangular);
            let across = match defect.width_mm {
                Some(_) => defaults.fill(format!("{at}/across_mm"), &mut defect.across_mm, 0.0),
                None => defect.across_mm.unwrap_or_default(),
            };
            if defect.width_mm.is_none() && across != 0.0 {
                defaults.refuse(
                    format!("{at}/across_mm"),
                    "a defect over the whole groove has no place across: give width_mm",
                );
                continue;
            }
            let mut fields = vec![
                ("azimuth", "azimuth_deg", azimuth, DEG),
                ("length", "length_mm", defect.length_mm, MM),
                ("depth", "depth_um", defect.depth_um, UM),
                ("across", "across_mm", across, MM),
            ];
            fields.extend(defect.width_mm.map(|width| ("width", "width_mm", width, MM)));
            if are_within_limits(defaults, (&at, &format!("surfaces.{name}.defects")), &fields) {
                defects.push(Defect {
                    azimuth: DEG.to_si(azimuth),
                    length: MM.to_si(defect.length_mm),
                    width: defect.width_mm.map(|width| MM.to_si(width)),
                    depth: UM.to_si(defect.depth_um),
                    across: MM.to_si(across),
                    shape: match shape {
                        DefectShape::Rectangular => Shape::Rectangular,
                        DefectShape::HalfSine => Shape::HalfSine,
                    },
                });
            }
        }
        defects
    }
}
