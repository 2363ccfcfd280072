//! Times at which balls pass the edges of defects.

/// A ball's way over a defect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Time at which its centre passes the first edge [s].
    pub entry: f64,
    /// Time at which its centre passes the other edge [s].
    pub exit: f64,
}

/// Largest number of kept passages, 1 MB: a bearing has some thousand a second.
const MOST_PASSAGES: usize = 1 << 16;

/// Recorder of passages, one way for each pair of a ball and a defect.
#[derive(Debug, Clone)]
pub(crate) struct DefectPassages {
    /// Time after the first sample for which passages are kept [s].
    window: f64,
    /// End of this time [s].
    until: Option<f64>,
    /// Last time [s] and angle from the defect's middle [rad] of each way.
    last: Vec<Option<(f64, f64)>>,
    entry: Vec<Option<f64>>,
    passages: Vec<Passage>,
}

impl DefectPassages {
    pub(crate) fn new(ways: usize, window: f64) -> Self {
        Self { window, until: None, last: vec![None; ways], entry: vec![None; ways], passages: Vec::new() }
    }

    /// Observes the angle of a ball from the middle of a defect, −π … π, and the half angle of the defect [rad].
    pub(crate) fn observe(&mut self, way: usize, time: f64, angle: f64, half: f64) {
        let until = *self.until.get_or_insert(time + self.window);
        let Some((before, from)) = self.last[way].replace((time, angle)) else { return };
        // Opposite the defect the angle jumps by a turn.
        let step = angle - from;
        if time > until || step.abs() > 1.0 || step == 0.0 {
            return;
        }
        let passing = |edge: f64| before + (time - before) * (edge - from) / step;
        let (first, second) = (-half.copysign(step), half.copysign(step));
        let crosses = |edge: f64| (from - edge) * step < 0.0 && (angle - edge) * step >= 0.0;
        if crosses(first) {
            self.entry[way] = Some(passing(first));
        }
        if crosses(second)
            && let Some(entry) = self.entry[way].take()
            && self.passages.len() < MOST_PASSAGES
        {
            self.passages.push(Passage { entry, exit: passing(second) });
        }
    }

    pub(crate) fn finish(self) -> Vec<Passage> {
        self.passages
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Either way round, edges are passed at the times of a steady motion, between samples; a defect that a step passes as a whole, too.
    #[test]
    fn edges_are_passed_between_samples() {
        for (direction, half) in [(1.0, 0.02), (-1.0, 0.02), (1.0, 0.001)] {
            let mut passages = DefectPassages::new(1, 10.0);
            for k in 0..2000 {
                let time = 0.01 * f64::from(k);
                let angle = direction * (time - 2.0);
                let turn = std::f64::consts::TAU;
                passages.observe(0, time, angle - turn * (angle / turn).round(), half);
            }
            let found = passages.finish();
            assert_eq!(found.len(), 2, "{direction}: {found:?}");
            for (passage, middle) in found.iter().zip([2.0, 2.0 + std::f64::consts::TAU]) {
                assert!((passage.entry - middle + half).abs() < 1e-9, "{passage:?}");
                assert!((passage.exit - middle - half).abs() < 1e-9, "{passage:?}");
            }
        }
    }
}
