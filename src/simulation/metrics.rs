//! Summary metrics of a run, in the units in which results show them.

use super::channel::Channel;
use super::lines::Line;
use crate::physics::bearing::PerRaceway;
use crate::physics::kinematics::CharacteristicFrequencies;

/// Statistics of one channel over the kept time, mean removed, 0–20 kHz, in the channel's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelMetrics {
    pub rms: f64,
    pub peak: f64,
    /// peak / rms; absent where rms is 0.
    pub crest_factor: Option<f64>,
    /// Fourth moment over squared variance (3 for Gaussian noise); absent where rms is 0.
    pub kurtosis: Option<f64>,
    /// 20 lg(rms / 9.81e-3 m/s²) [dB], accelerations that are not 0 only.
    pub level_db: Option<f64>,
    /// Share of the signal's power above 20 kHz [-].
    pub above_band: f64,
}

/// One kind of raceway contact over all balls and the kept time.
#[derive(Debug, Clone, PartialEq)]
pub struct RacewayContactMetrics {
    /// [N]
    pub max_load: f64,
    /// [MPa]
    pub max_pressure: f64,
    /// Range of the contact angles under load [deg]; `None`: never in contact.
    pub contact_angle: Option<(f64, f64)>,
    /// Largest slip speed at a contact's centre under load [m/s].
    pub max_slip: f64,
    /// Least minimum film thickness under load [µm]; absent where the film was not asked for or there is none.
    pub min_film_thickness: Option<f64>,
    /// Largest load of each ball [N].
    pub max_load_per_ball: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct ContactMetrics {
    pub raceway: PerRaceway<RacewayContactMetrics>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct CageMetrics {
    /// Mean speed [Hz].
    pub speed: f64,
    /// 1 − speed/FTF; absent at rest.
    pub slip: Option<f64>,
    /// Mean spin of the balls about X, as a magnitude [Hz].
    pub ball_spin: f64,
    /// Rms distance of the cage centre from its mean position [µm].
    pub orbit_radius: f64,
    /// Mean orbit rate of the cage centre over the cage speed; absent at rest.
    pub whirl_ratio: Option<f64>,
    /// Largest pocket load [N]; film included.
    pub max_pocket_load: f64,
}

/// How the solver worked.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverReport {
    pub method: &'static str,
    pub method_reason: String,
    pub rung: &'static str,
    /// How the rung was checked, in words.
    pub check: String,
    pub statistics: crate::numerics::ode::Statistics,
    /// [s]
    pub wall_time: f64,
    /// [s]
    pub simulated_time: f64,
    /// Number of first-order states.
    pub states: usize,
    /// Strips a raceway contact is cut into for traction.
    pub strips: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionKind {
    Decaying,
    Diverging,
}

/// How far the result can be trusted.
#[derive(Debug, Clone, PartialEq)]
pub struct AccuracyReport {
    /// Estimated error of the worst acceleration level [dB]; absent where no level exists.
    pub level_error_db: Option<f64>,
    pub how: String,
    pub motion: MotionKind,
    /// Rate at which two runs 1e-10 apart part (negative: meet) [1/s].
    pub divergence_rate: f64,
}

/// Everything a user reads first.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// In the order x, y, z; velocity and acceleration (and displacement) of the spindle; empty when vibration was not asked for.
    pub channels: Vec<(Channel, ChannelMetrics)>,
    /// Absent when not asked for.
    pub contacts: Option<ContactMetrics>,
    /// Absent when not asked for, or when the scene has no cage.
    pub cage: Option<CageMetrics>,
    /// From the simulated cage and ball speed [Hz].
    pub frequencies: CharacteristicFrequencies,
    /// Strongest first within a channel.
    pub lines: Vec<(Channel, Line)>,
    pub solver: SolverReport,
    pub accuracy: AccuracyReport,
}
