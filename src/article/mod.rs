//! The article's figures made again, each beside what the article says of it, and judged by what an honest run shows. Knows what to
//! run and how to read it; runs nothing itself.

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
