//! What a scene needs: which terms and degrees of freedom are in its equations, and why the others are not.

use super::scene::Term;

/// Why a term may be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grounds {
    /// The result is the same.
    Identity,
    /// The effect is bounded for this scene.
    Judgement,
    /// By a named convention, or because the request switched it off.
    Convention,
}

/// A term that is not in the model.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    pub term: Term,
    pub reason: String,
    pub by: Grounds,
    /// Size of the effect, with its unit.
    pub bound: Option<(f64, &'static str)>,
}
