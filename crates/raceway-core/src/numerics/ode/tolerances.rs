//! Error tolerances of a step.

/// Error tolerances: component `i` may err by `absolute[i] + relative[i] · |y_i|` a step.
#[derive(Debug, Clone)]
pub struct Tolerances {
    pub relative: Vec<f64>,
    pub absolute: Vec<f64>,
}

impl Tolerances {
    /// The same relative and absolute tolerance for each of `dimension` components.
    pub fn uniform(dimension: usize, relative: f64, absolute: f64) -> Self {
        Self { relative: vec![relative; dimension], absolute: vec![absolute; dimension] }
    }

    /// Allowed error of each component of a state in a step.
    #[inline(always)]
    pub(crate) fn all_allowed<'a>(&'a self, state: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let each = self.absolute.iter().zip(&self.relative).zip(state);
        each.map(|((absolute, relative), size)| absolute + relative * size.abs())
    }

    /// Allowed error of component `i` of this size in a step.
    #[inline]
    pub fn allowed(&self, i: usize, size: f64) -> f64 {
        self.absolute[i] + self.relative[i] * size.abs()
    }
}
