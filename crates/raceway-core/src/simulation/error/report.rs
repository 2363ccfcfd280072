//! How far a result can be trusted.

use crate::simulation::error::comparison::LevelErrors;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionKind {
    Decaying,
    Diverging,
}

/// Estimated errors of single numbers, as shares of them [-].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuantityErrors {
    pub max_load: f64,
    pub cage_speed: f64,
    pub max_pocket_load: f64,
    /// Of the raceway where it is the larger.
    pub max_slip: f64,
    /// Of the cage's centre about its mean position.
    pub orbit_radius: f64,
}

impl QuantityErrors {
    /// The larger of both of each.
    pub(crate) fn larger(&self, other: &Self) -> Self {
        Self {
            max_load: self.max_load.max(other.max_load),
            cage_speed: self.cage_speed.max(other.cage_speed),
            max_pocket_load: self.max_pocket_load.max(other.max_pocket_load),
            max_slip: self.max_slip.max(other.max_slip),
            orbit_radius: self.orbit_radius.max(other.orbit_radius),
        }
    }
}

/// Why what a run states may be in doubt; whether it is, and by how much, its errors tell in the end.
#[derive(Debug, Clone, PartialEq)]
pub enum Doubt {
    /// They are not known, or not of all of it; in words.
    Failed(String),
    /// Steps may be to blame.
    Unresolved,
    /// Finer steps lead the motion another way, with other peaks.
    Sensitive,
    /// The motion is chaotic, and the run a sample. `too_short`: in words, where it is too short to be one.
    Chance { too_short: Option<String> },
    /// Another stretch shows something else.
    Uneven,
}

/// How far the result can be trusted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AccuracyReport {
    /// Estimated errors of the levels [dB].
    pub level_errors: LevelErrors,
    /// What a repetition of a part, or of the whole, differed by; absent where nothing was repeated.
    pub quantity_errors: Option<QuantityErrors>,
    pub how: String,
    /// `None`: the run is too short to tell.
    pub motion: Option<MotionKind>,
    /// Rate at which two runs 1e-10 apart part (negative: meet) [1/s].
    pub divergence_rate: f64,
    /// A repetition of the whole run went another way: its signals are others.
    pub is_sample: bool,
    /// Why it may not be trusted; `None`: that was never asked.
    pub doubt: Option<Doubt>,
    /// In words, where the result is not to be trusted; made last, of what is stated in the end.
    pub warning: Option<String>,
}

impl AccuracyReport {
    /// Error of the worst level [dB]; `None` where there is none.
    pub fn level_error_db(&self) -> Option<f64> {
        self.level_errors.worst()
    }
}
