//! States and rates at the points of the uniform grid.

/// Values kept: after doubling, every other one of them still makes a cubic and an interpolation.
pub(super) const MAX_KEPT: usize = 9;
/// Values that a step and the halving of its grid need.
pub(super) const MIN_KEPT: usize = 5;
/// Values midway between the newest and the next, and between the next two, from the five newest.
const MIDWAY: [[f64; 5]; 2] = [
    [35.0 / 128.0, 140.0 / 128.0, -70.0 / 128.0, 28.0 / 128.0, -5.0 / 128.0],
    [-5.0 / 128.0, 60.0 / 128.0, 90.0 / 128.0, -20.0 / 128.0, 3.0 / 128.0],
];

/// States and `f` at the points of the grid, newest first, and how many of them are known.
pub(super) struct Past {
    pub(super) states: Vec<Vec<f64>>,
    pub(super) rests: Vec<Vec<f64>>,
    pub(super) kept: usize,
}

impl Past {
    pub(super) fn new(dimension: usize) -> Self {
        let vectors = || vec![vec![0.0; dimension]; MAX_KEPT];
        Self { states: vectors(), rests: vectors(), kept: 0 }
    }

    /// The newest state.
    pub(super) fn state(&self) -> &[f64] {
        &self.states[0]
    }

    /// Room for a newer point: its state and its `f`.
    pub(super) fn advance(&mut self) -> (&mut [f64], &mut [f64]) {
        self.states.rotate_right(1);
        self.rests.rotate_right(1);
        self.kept = (self.kept + 1).min(MAX_KEPT);
        (&mut self.states[0], &mut self.rests[0])
    }

    /// Every other point makes a grid of twice the step.
    pub(super) fn double_step(&mut self) {
        for values in [&mut self.states, &mut self.rests] {
            for i in 1..=MAX_KEPT / 2 {
                values.swap(i, 2 * i);
            }
        }
        self.kept = MAX_KEPT.div_ceil(2);
    }

    /// A grid of half the step; the missing values are interpolated between the five newest.
    pub(super) fn halve_step(&mut self) {
        for values in [&mut self.states, &mut self.rests] {
            let [newest, second, third, fourth, fifth, spare, other, ..] = &mut values[..] else { return };
            for i in 0..newest.len() {
                let known = [newest[i], second[i], third[i], fourth[i], fifth[i]];
                let midway = |weights: &[f64; 5]| weights.iter().zip(known).map(|(w, x)| w * x).sum::<f64>();
                (spare[i], other[i]) = (midway(&MIDWAY[0]), midway(&MIDWAY[1]));
            }
            // Newest, midway, second, midway, third.
            values.swap(4, 2);
            values.swap(1, 2);
            values.swap(1, 5);
            values.swap(3, 6);
        }
        self.kept = MIN_KEPT;
    }
}
