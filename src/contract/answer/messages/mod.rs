//! Every sentence about a result that a user reads: one code, one text.

use serde_json::json;

use raceway_core::simulation::error::codes::Warning;
use raceway_core::simulation::result::metrics::SolverReport;

mod answer;
mod bands;
mod basis;
mod bearing;
mod candidates;
mod friction;
mod machine;
mod omissions;
pub mod spread;
mod warnings;
mod words;

use answer::message;
pub use answer::{MessageAnswer, MessageCode, Severity};
pub use bands::of_bands;
pub use basis::{check, choice_text, how};
pub use bearing::{open_side, overloaded};
pub use candidates::of_not_eligible;
use candidates::of_rejection;
pub use friction::friction_adds_forces;
pub use machine::of_machine;
pub use omissions::omission;
pub use warnings::of_warning;

/// The messages of a result: warnings first, then how it was made.
pub fn of_result(warnings: &[Warning], solver: &SolverReport) -> Vec<MessageAnswer> {
    let chosen = solver.choice.iter().map(|reason| {
        let text = format!("Integrator {}: {}.", solver.method, choice_text(reason));
        message(MessageCode::MethodChosen, Severity::Info, text, [("method", json!(solver.method))])
    });
    let warnings = warnings.iter().map(of_warning);
    let rejections = solver.rejections.iter().map(of_rejection);
    let not_eligible = solver.not_eligible.iter().map(of_not_eligible);
    warnings.chain(rejections).chain(not_eligible).chain(chosen).collect()
}
