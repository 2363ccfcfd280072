//! Kinds of stored signals.

use crate::contract::{JobKind, SpectrumKind};

/// Kinds of jobs that keep signals.
pub(super) const WITH_SIGNALS: [JobKind; 2] = [JobKind::Simulation, JobKind::Machine];

/// Kind of a stored signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    Amplitude,
    Envelope,
    Series,
}

impl From<SpectrumKind> for Signal {
    fn from(kind: SpectrumKind) -> Self {
        match kind {
            SpectrumKind::Amplitude => Self::Amplitude,
            SpectrumKind::Envelope => Self::Envelope,
        }
    }
}

impl Signal {
    pub fn name(self) -> &'static str {
        match self {
            Self::Amplitude => "amplitude",
            Self::Envelope => "envelope",
            Self::Series => "series",
        }
    }
}
