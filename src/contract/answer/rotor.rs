//! The result of a rotor job as JSON.

use raceway_core::physics::contact::hertz::STATIC_PRESSURE_LIMIT;
use raceway_core::rotor::analysis::analyse;
use raceway_core::rotor::input::RotorError;
use raceway_core::rotor::result::{
    BearingResult, BodyResult, Complex, Critical, Direction, Mode, ModePoint, RotorResult, SensorResult, SupportForces,
};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::arrangement::{ArrangementAnswer, arrangements};
use super::failure::{DID_NOT_CONVERGE, RunFailure};
use super::messages::{self, MessageAnswer};
use super::rotor_model::RotorModelAnswer;
use crate::contract::job::rotor::RotorJob;
use crate::contract::json::units::{DEG, MM, MRAD, RPM, UM};
use crate::contract::scene::housing::PartInput;
use crate::contract::scene::rotor_bearings::RotorBearingInput;
use crate::contract::scene::sensor::SensorInput;

/// Result of a rotor job. Phases are those of cos(Ωt + phase), t = 0 where the shaft's angle is 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RotorAnswer {
    /// Mass of shaft and discs [kg].
    pub mass_kg: f64,
    /// Place of the mass centre along the shaft [mm].
    pub mass_centre_mm: f64,
    /// Places of the nodes along the shaft [mm]; shapes and the deflection have a value for each.
    pub nodes_mm: Vec<f64>,
    /// Number of coordinates after the modal reduction.
    pub coordinates: u64,
    /// Speeds of `modes`, `response` and the forces [r/min].
    pub speeds_rpm: Vec<f64>,
    /// Natural frequencies over speed, each one followed from speed to speed (Campbell diagram).
    pub modes: Vec<ModeCourseAnswer>,
    /// Natural motions at the operating speed.
    pub operating: OperatingAnswer,
    /// Speeds that equal a damped natural frequency, rising, up to the highest of `speeds_rpm`.
    pub criticals: Vec<CriticalAnswer>,
    /// Response to unbalance at each place where something acts on the shaft.
    pub response: Vec<ResponseAnswer>,
    /// Forces of the shaft on each of `supports`, then on each of `bearings`, in the order of the request.
    pub supports: Vec<SupportForcesAnswer>,
    /// Forces of the bodies on each of `housing.mounts`, in the order of the request; absent without mounts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mounts: Vec<SupportForcesAnswer>,
    /// The bodies and then the ports of the housing; absent without housing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<RotorBodyAnswer>,
    /// The sensors; absent without sensors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<RotorSensorAnswer>,
    /// The bearings at the operating point; absent without bearings.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bearings: Vec<RotorBearingAnswer>,
    /// How neighbouring bearings face each other by `faces`, along the shaft; of bearings that carry thrust one way. Absent with fewer than two.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub arrangements: Vec<ArrangementAnswer>,
    /// Static displacement of the nodes under weight and loads.
    #[serde(rename = "static")]
    pub at_rest: DeflectionAnswer,
    /// Messages about the bearings. See `MessageCode`.
    // Results of builds before the messages have none.
    #[serde(default)]
    #[schema(required = true)]
    pub messages: Vec<MessageAnswer>,
    /// Elements and matrices of the calculation.
    pub model: RotorModelAnswer,
}

/// One natural frequency over speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ModeCourseAnswer {
    /// Damped natural frequency at each speed [Hz]; 0 where the motion no longer oscillates.
    pub frequency_hz: Vec<f64>,
    /// Damping ratio at each speed [-]; negative: the motion grows; 1 where it no longer oscillates.
    pub damping_ratio: Vec<f64>,
    /// Whirl direction at each speed.
    pub whirl: Vec<WhirlName>,
    /// Share of the lateral kinetic energy that whirls forward, at each speed, 0–1 [-].
    pub forward_share: Vec<f64>,
}

/// `forward`: with the rotation. `backward`: against it. `none`: in a plane, as all are at rest. `axial`: more than half of the kinetic energy is
/// along X.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum WhirlName {
    Forward,
    Backward,
    None,
    Axial,
}

/// Natural motions at the operating speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OperatingAnswer {
    /// [r/min]
    pub speed_rpm: f64,
    /// True if every motion decays by this analysis. Tractions of balls and pockets of cages, which can drive a whirl, are left out.
    pub is_stable: bool,
    /// Largest growth rate of a motion, oscillating or not [1/s]; negative: the slowest decay.
    pub growth_rate_per_s: f64,
    /// The lowest natural motions.
    pub modes: Vec<ModeAnswer>,
}

/// A natural motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ModeAnswer {
    /// Damped natural frequency [Hz].
    pub frequency_hz: f64,
    /// Damping ratio [-].
    pub damping_ratio: f64,
    /// Whirl direction.
    pub whirl: WhirlName,
    /// Shape.
    pub shape: ShapeAnswer,
}

/// A critical speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CriticalAnswer {
    /// [r/min]
    pub speed_rpm: f64,
    /// Damping ratio [-]. Unbalance excites a forward motion about 1/(2 ζ) times as much as at rest; on equal supports it excites no
    /// backward one.
    pub damping_ratio: f64,
    /// Whirl direction.
    pub whirl: WhirlName,
    /// Shape.
    pub shape: ShapeAnswer,
    /// Longest half axis of the orbit by unbalance at this speed, at each place of `response` [µm]: peaks between the requested speeds.
    pub major_um: Vec<f64>,
}

/// Displacements of the nodes, as amplitudes and phases; the largest is 1 with phase 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ShapeAnswer {
    /// Amplitude along X [-]; absent without motion along X.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub x: Option<Vec<f64>>,
    /// Amplitude along Y [-].
    pub y: Vec<f64>,
    /// Phase along Y [°].
    pub y_phase_deg: Vec<f64>,
    /// Amplitude along Z [-].
    pub z: Vec<f64>,
    /// Phase along Z [°].
    pub z_phase_deg: Vec<f64>,
    /// Motion of the bodies and ports of the housing in the same scale; absent without housing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<BodyShapeAnswer>,
}

/// Motion of a body or port of the housing in a natural motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BodyShapeAnswer {
    /// Name.
    pub name: String,
    /// Amplitudes of the mass centre, or of the port, along x, y and z [-].
    pub amplitude: [f64; 3],
    /// Their phases [°].
    pub phase_deg: [f64; 3],
    /// Amplitudes of the tilt about y and z [rad/m].
    pub tilt_per_m: [f64; 2],
    /// Their phases [°].
    pub tilt_phase_deg: [f64; 2],
}

/// A body or port of the housing: its static place, and its response to unbalance, with a value for each speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RotorBodyAnswer {
    /// Name.
    pub name: String,
    /// Place of its mass centre, or of the port, along the shaft [mm].
    pub at_mm: f64,
    /// Static displacement along x, y and z [µm].
    pub static_um: [f64; 3],
    /// Static tilt about y and z [mrad].
    pub static_tilt_mrad: [f64; 2],
    /// Amplitude along X [µm].
    pub x_um: Vec<f64>,
    /// Phase along X [°].
    pub x_phase_deg: Vec<f64>,
    /// Amplitude along Y [µm].
    pub y_um: Vec<f64>,
    /// Phase along Y [°].
    pub y_phase_deg: Vec<f64>,
    /// Amplitude along Z [µm].
    pub z_um: Vec<f64>,
    /// Phase along Z [°].
    pub z_phase_deg: Vec<f64>,
}

/// A sensor: its static reading, and its response to unbalance, with a value for each speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RotorSensorAnswer {
    /// Name.
    pub name: String,
    /// Static displacement at the operating speed [µm].
    pub static_um: f64,
    /// Amplitude of the displacement [µm].
    pub displacement_um: Vec<f64>,
    /// Phase of the displacement [°].
    pub phase_deg: Vec<f64>,
    /// Amplitude of the acceleration [m/s²].
    pub acceleration_m_s2: Vec<f64>,
}

/// Response to unbalance at one place, with a value for each speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResponseAnswer {
    /// Place along the shaft [mm].
    pub at_mm: f64,
    /// Amplitude along Y [µm].
    pub y_um: Vec<f64>,
    /// Phase along Y [°].
    pub y_phase_deg: Vec<f64>,
    /// Amplitude along Z [µm].
    pub z_um: Vec<f64>,
    /// Phase along Z [°].
    pub z_phase_deg: Vec<f64>,
    /// Longest half axis of the orbit [µm].
    pub major_um: Vec<f64>,
}

/// Forces of the shaft on a support, or of a body on a mount.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SupportForcesAnswer {
    /// Place along the shaft [mm].
    pub at_mm: f64,
    /// Static force along x, y and z at the operating speed [N].
    pub static_force_n: [f64; 3],
    /// Static moment about y and z [N·m].
    pub static_moment_n_m: [f64; 2],
    /// Amplitude of the force along Y from unbalance, for each speed [N].
    pub unbalance_force_y_n: Vec<f64>,
    /// Amplitude of the force along Z from unbalance, for each speed [N].
    pub unbalance_force_z_n: Vec<f64>,
}

/// A bearing at the operating point. Matrices are over x, y, z, β_y, β_z, along the shaft's axes and about the bearing's centre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RotorBearingAnswer {
    /// Name.
    pub name: String,
    /// Place along the shaft [mm].
    pub at_mm: f64,
    /// Displacement of the inner ring from the outer one along x, y and z, in the bearing's own axes, where it carries a thrust along +X
    /// [µm].
    pub displacement_um: [f64; 3],
    /// Tilt of the inner ring about y and z in the same axes [mrad].
    pub tilt_mrad: [f64; 2],
    /// Stiffness, mean over a ball spacing [N/m, N/rad, N·m/m, N·m/rad].
    #[schema(value_type = Vec<Vec<f64>>)]
    pub stiffness: [[f64; 5]; 5],
    /// Least of each entry over a ball spacing.
    #[schema(value_type = Vec<Vec<f64>>)]
    pub least_stiffness: [[f64; 5]; 5],
    /// Most of each entry over a ball spacing.
    #[schema(value_type = Vec<Vec<f64>>)]
    pub most_stiffness: [[f64; 5]; 5],
    /// Damping of the contacts for slow motions [N·s/m, N·s/rad, N·m·s/m, N·m·s/rad]. The lubricant film's own damping is left out.
    #[schema(value_type = Vec<Vec<f64>>)]
    pub damping: [[f64; 5]; 5],
    /// Largest load of a ball on the inner raceway [N].
    pub largest_inner_load_n: f64,
    /// Largest load of a ball on the outer raceway [N].
    pub largest_outer_load_n: f64,
    /// Share of the balls that the inner raceway presses, 0–1 [-].
    pub loaded_share: f64,
}

/// Static displacement of the nodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DeflectionAnswer {
    /// Along X [µm].
    pub x_um: Vec<f64>,
    /// Along Y [µm].
    pub y_um: Vec<f64>,
    /// Along Z [µm].
    pub z_um: Vec<f64>,
}

impl RotorAnswer {
    /// Analyses the rotor of a job.
    pub fn of(job: &RotorJob, stop: &dyn Fn() -> bool) -> Result<Self, RunFailure> {
        let result = analyse(&job.rotor, &job.request, stop).map_err(failure)?;
        let model = RotorModelAnswer::of(job, &result);
        Ok(answer(job, &result, model))
    }
}

fn failure(error: RotorError) -> RunFailure {
    match error {
        RotorError::Stopped => RunFailure::Cancelled,
        error => RunFailure::Failed { cause: DID_NOT_CONVERGE, detail: error.to_string() },
    }
}

fn answer(job: &RotorJob, result: &RotorResult, model: RotorModelAnswer) -> RotorAnswer {
    let um = |axis: usize| result.deflection.iter().map(|node| UM.to_user(node[axis])).collect();
    RotorAnswer {
        mass_kg: result.mass,
        mass_centre_mm: MM.to_user(result.mass_centre),
        nodes_mm: result.nodes.iter().map(|at| MM.to_user(*at)).collect(),
        coordinates: result.coordinates as u64,
        speeds_rpm: job.speeds_rpm.clone(),
        modes: result.modes.iter().map(|course| course_answer(&course.points)).collect(),
        operating: OperatingAnswer {
            speed_rpm: RPM.to_user(job.rotor.speed),
            is_stable: result.growth_rate < 0.0,
            growth_rate_per_s: result.growth_rate,
            modes: result.operating_modes.iter().map(|mode| mode_answer(job, mode)).collect(),
        },
        criticals: result.criticals.iter().map(|critical| critical_answer(job, critical)).collect(),
        response: result.stations.iter().map(|station| response_answer(station.at, &station.displacement)).collect(),
        supports: result.supports.iter().map(forces_answer).collect(),
        mounts: result.mounts.iter().map(forces_answer).collect(),
        bodies: bodies(job, result),
        sensors: sensors(job, result),
        bearings: bearings(job, result),
        arrangements: arrangements(&job.input.scene),
        at_rest: DeflectionAnswer { x_um: um(0), y_um: um(1), z_um: um(2) },
        messages: messages(job, result),
        model,
    }
}

fn forces_answer(support: &SupportForces) -> SupportForcesAnswer {
    SupportForcesAnswer {
        at_mm: MM.to_user(support.at),
        static_force_n: [0, 1, 2].map(|axis| support.at_rest[axis]),
        static_moment_n_m: [3, 4].map(|axis| support.at_rest[axis]),
        unbalance_force_y_n: support.dynamic.iter().map(|force| force[0].norm()).collect(),
        unbalance_force_z_n: support.dynamic.iter().map(|force| force[1].norm()).collect(),
    }
}

/// Bodies and ports of the request.
fn parts_of(job: &RotorJob) -> impl Iterator<Item = PartInput<'_>> {
    job.input.scene.housing.iter().flat_map(|housing| housing.parts())
}

fn bodies(job: &RotorJob, result: &RotorResult) -> Vec<RotorBodyAnswer> {
    let of = |(part, moved): (PartInput<'_>, &BodyResult)| {
        let amplitude = |axis: usize| moved.response.iter().map(|value| UM.to_user(value[axis].norm())).collect();
        let phase = |axis: usize| moved.response.iter().map(|value| phase_deg(value[axis])).collect();
        RotorBodyAnswer {
            name: part.name.to_owned(),
            at_mm: part.at_mm,
            static_um: [0, 1, 2].map(|axis| UM.to_user(moved.at_rest[axis])),
            static_tilt_mrad: [3, 4].map(|axis| MRAD.to_user(moved.at_rest[axis])),
            x_um: amplitude(0),
            x_phase_deg: phase(0),
            y_um: amplitude(1),
            y_phase_deg: phase(1),
            z_um: amplitude(2),
            z_phase_deg: phase(2),
        }
    };
    parts_of(job).zip(&result.bodies).map(of).collect()
}

fn sensors(job: &RotorJob, result: &RotorResult) -> Vec<RotorSensorAnswer> {
    let of = |(sensor, seen): (&SensorInput, &SensorResult)| {
        let speeds = seen.response.iter().zip(&job.request.speeds);
        RotorSensorAnswer {
            name: sensor.name.clone(),
            static_um: UM.to_user(seen.at_rest),
            displacement_um: seen.response.iter().map(|value| UM.to_user(value.norm())).collect(),
            phase_deg: seen.response.iter().map(|value| phase_deg(*value)).collect(),
            acceleration_m_s2: speeds.map(|(value, speed)| value.norm() * speed * speed).collect(),
        }
    };
    job.input.scene.sensors.iter().flatten().zip(&result.sensors).map(of).collect()
}

fn bearings(job: &RotorJob, result: &RotorResult) -> Vec<RotorBearingAnswer> {
    let names = job.input.scene.bearings.iter().flatten().map(|bearing| bearing.name.clone());
    let of = |(name, bearing): (String, &BearingResult)| RotorBearingAnswer {
        name,
        at_mm: MM.to_user(bearing.at),
        displacement_um: [0, 1, 2].map(|axis| UM.to_user(bearing.pose[axis])),
        tilt_mrad: [3, 4].map(|axis| MRAD.to_user(bearing.pose[axis])),
        stiffness: bearing.stiffness,
        least_stiffness: bearing.least_stiffness,
        most_stiffness: bearing.most_stiffness,
        damping: bearing.damping,
        largest_inner_load_n: bearing.largest_loads[0],
        largest_outer_load_n: bearing.largest_loads[1],
        loaded_share: bearing.loaded,
    };
    names.zip(&result.bearings).map(of).collect()
}

/// Reasons to doubt the bearings.
fn messages(job: &RotorJob, result: &RotorResult) -> Vec<MessageAnswer> {
    let named = job.input.scene.bearings.iter().flatten().zip(&result.bearings);
    let of = |(RotorBearingInput { name, .. }, bearing): (&RotorBearingInput, &BearingResult)| {
        let (pressure, load) = bearing.largest_pressure;
        let overloaded = (pressure > STATIC_PRESSURE_LIMIT).then(|| messages::overloaded(name, load, pressure));
        let open = bearing.thrust_over_open_side.map(|thrust| messages::open_side(name, thrust));
        overloaded.into_iter().chain(open)
    };
    named.flat_map(of).collect()
}

fn course_answer(points: &[Option<ModePoint>]) -> ModeCourseAnswer {
    let of = |value: &dyn Fn(&ModePoint) -> f64, without: f64| {
        points.iter().map(|point| point.as_ref().map_or(without, value)).collect()
    };
    ModeCourseAnswer {
        frequency_hz: of(&|point| hertz(point.frequency), 0.0),
        damping_ratio: of(&|point| point.damping_ratio, 1.0),
        whirl: points.iter().map(|point| point.map_or(WhirlName::None, |point| point.direction.into())).collect(),
        forward_share: of(&|point| point.forward_share, 0.5),
    }
}

impl From<Direction> for WhirlName {
    fn from(direction: Direction) -> Self {
        match direction {
            Direction::Forward => Self::Forward,
            Direction::Backward => Self::Backward,
            Direction::Planar => Self::None,
            Direction::Axial => Self::Axial,
        }
    }
}

fn hertz(frequency: f64) -> f64 {
    frequency / (2.0 * std::f64::consts::PI)
}

fn mode_answer(job: &RotorJob, mode: &Mode) -> ModeAnswer {
    ModeAnswer {
        frequency_hz: hertz(mode.point.frequency),
        damping_ratio: mode.point.damping_ratio,
        whirl: mode.point.direction.into(),
        shape: shape_answer(job, mode),
    }
}

fn critical_answer(job: &RotorJob, critical: &Critical) -> CriticalAnswer {
    CriticalAnswer {
        speed_rpm: RPM.to_user(critical.speed),
        damping_ratio: critical.mode.point.damping_ratio,
        whirl: critical.mode.point.direction.into(),
        shape: shape_answer(job, &critical.mode),
        major_um: critical.displacement.iter().map(longest_um).collect(),
    }
}

/// Longest half axis of an orbit [µm]. y + i z is the sum of a forward and a backward circle.
fn longest_um(displacement: &[Complex<f64>; 2]) -> f64 {
    let (y, turned) = (displacement[0], Complex::<f64>::i() * displacement[1]);
    UM.to_user(0.5 * ((y + turned).norm() + (y - turned).norm()))
}

fn shape_answer(job: &RotorJob, Mode { shape, bodies, .. }: &Mode) -> ShapeAnswer {
    let of_body = |(part, moved): (PartInput<'_>, &[Complex<f64>; 5])| BodyShapeAnswer {
        name: part.name.to_owned(),
        amplitude: [0, 1, 2].map(|axis| moved[axis].norm()),
        phase_deg: [0, 1, 2].map(|axis| phase_deg(moved[axis])),
        tilt_per_m: [3, 4].map(|axis| moved[axis].norm()),
        tilt_phase_deg: [3, 4].map(|axis| phase_deg(moved[axis])),
    };
    let amplitude = |axis: usize| shape.iter().map(|node| node[axis].norm()).collect::<Vec<_>>();
    let phase = |axis: usize| shape.iter().map(|node| phase_deg(node[axis])).collect();
    ShapeAnswer {
        x: job.rotor.shaft.is_axially_free.then(|| amplitude(0)),
        y: amplitude(1),
        y_phase_deg: phase(1),
        z: amplitude(2),
        z_phase_deg: phase(2),
        bodies: parts_of(job).zip(bodies).map(of_body).collect(),
    }
}

fn response_answer(at: f64, displacement: &[[Complex<f64>; 2]]) -> ResponseAnswer {
    let amplitude = |axis: usize| displacement.iter().map(|value| UM.to_user(value[axis].norm())).collect();
    let phase = |axis: usize| displacement.iter().map(|value| phase_deg(value[axis])).collect();
    ResponseAnswer {
        at_mm: MM.to_user(at),
        y_um: amplitude(0),
        y_phase_deg: phase(0),
        z_um: amplitude(1),
        z_phase_deg: phase(1),
        major_um: displacement.iter().map(longest_um).collect(),
    }
}

/// Phase [°]; 0 of nothing.
fn phase_deg(value: Complex<f64>) -> f64 {
    if value == Complex::ZERO { 0.0 } else { DEG.to_user(value.arg()) }
}
