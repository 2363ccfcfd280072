//! The integration methods by name.

/// The methods by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Chooses between the others, and may change its mind on the way.
    Auto,
    /// Backward differentiation of variable step and order 1–5.
    Gear,
    /// Precise integration with exponential Adams–Bashforth–Moulton.
    FineAbm,
    /// Explicit Runge–Kutta of order 5.
    DormandPrince,
    /// Implicit Runge–Kutta of order 5: the reference.
    Radau,
    /// A linearly implicit method with fixed steps that the system brings along; only `auto` may choose it.
    SemiImplicit,
}

impl Method {
    /// All that a scene can be run by.
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

    /// Can run with steps of a fixed size.
    pub fn takes_fixed_steps(self) -> bool {
        matches!(self, Self::DormandPrince | Self::FineAbm | Self::SemiImplicit)
    }
}
