//! The article's figures, reproduced by simulations and compared with its statements. Contains the jobs and the evaluation of their
//! results; runs nothing itself.

mod claims;
mod figures;
mod pocket;
mod report;
mod robustness;
mod robustness_report;

pub use claims::{Claim, Finding, Verdict};
pub use figures::{Compared, Figure, Lines, Subject, figures};
pub use pocket::forces;
pub use report::{Evidence, document, document_of_one, pictures};
pub use robustness::{Judged, sampled, studies};
pub use robustness_report::{Chosen, SEED, SETS, robustness_csv, robustness_document};
