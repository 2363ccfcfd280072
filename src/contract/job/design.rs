//! Designs of samples by name.

use raceway_core::sampling::design::Design;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How samples are drawn. `sobol`: scrambled Sobol points, a power of two of them. `latin_hypercube`: one in each of equally probable intervals of
/// each input. `pairs`: two Sobol sets, and the first with one input after the other exchanged (Saltelli): `samples` × (inputs + 2) runs, which
/// give total shares, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum DesignName {
    Sobol,
    LatinHypercube,
    Pairs,
}

impl DesignName {
    pub fn in_core(self) -> Design {
        match self {
            Self::Sobol => Design::Sobol,
            Self::LatinHypercube => Design::LatinHypercube,
            Self::Pairs => Design::Pairs,
        }
    }
}
