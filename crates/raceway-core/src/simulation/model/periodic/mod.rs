//! Model level `periodic`: the steady motion of the spindle alone, which repeats with every ball. Shooting finds one passage, which is
//! extended over the recorded time. Knows no unbalance and no changing speed.

mod applicability;

mod passage;

mod run;

pub use applicability::inapplicability;
pub use passage::{Passage, passage};
pub use run::simulate;
