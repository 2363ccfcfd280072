//! The integration methods by name.

/// The methods by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Chooses between explicit and stiff, and may change during the run.
    Auto,
    /// Backward differentiation of variable step and order 1–5.
    Gear,
    /// Precise integration with exponential Adams–Bashforth–Moulton.
    FineAbm,
    /// Explicit Runge–Kutta of order 5.
    DormandPrince,
    /// Implicit Runge–Kutta of order 5: the reference.
    Radau,
    /// The system's own linearly implicit method with fixed steps; only `auto` may choose it.
    SemiImplicit,
}

impl Method {
    /// The methods that a scene may name.
    pub const NAMED: [Self; 4] = [Self::Gear, Self::FineAbm, Self::DormandPrince, Self::Radau];

    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gear => "gear",
            Self::FineAbm => "fine_abm",
            Self::DormandPrince => "dormand_prince",
            Self::Radau => "radau",
            Self::SemiImplicit => "semi_implicit",
        }
    }

    /// Returns true where the method can run with fixed steps.
    pub fn takes_fixed_steps(self) -> bool {
        matches!(self, Self::DormandPrince | Self::FineAbm | Self::SemiImplicit)
    }
}
