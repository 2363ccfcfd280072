//! Message about the forces that a friction moment needs.

use super::answer::{MessageAnswer, MessageCode, Severity, message};

/// Hydrodynamic forces act in grease, because a friction moment is asked for.
pub fn friction_adds_forces() -> MessageAnswer {
    let text = "The friction moment is asked for, so that hydrodynamic forces act. A run in grease without it leaves them out, and its vibration \
                differs. Set terms.hydrodynamics to on or off in both runs to compare them."
        .to_owned();
    message(MessageCode::FrictionAddsForces, Severity::Warning, text, [])
}
