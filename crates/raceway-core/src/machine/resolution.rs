//! Whether steps resolve a motion, by the forces at the ports.

use crate::physics::frame::support::PORT;

/// Sums of squares over the forces at the ports and all steps [N²].
#[derive(Debug, Clone, Default)]
pub(crate) struct Resolution {
    /// Of what the extrapolation missed.
    missed: f64,
    /// Of the changes from step to step.
    changed: f64,
    /// Of the forces.
    size: f64,
}

impl Resolution {
    /// Adds a step. Forces and moments at each port: what the extrapolation missed, the new ones, and those of the step before.
    #[inline(always)]
    pub(crate) fn add(&mut self, missed: &[f64], new: &[f64], before: &[f64]) {
        let ports = [missed, new, before].map(|values| values.as_chunks::<PORT>().0);
        for ((missed, new), before) in ports[0].iter().zip(ports[1]).zip(ports[2]) {
            for axis in 0..3 {
                let change = new[axis] - before[axis];
                self.missed += missed[axis] * missed[axis];
                self.changed += change * change;
                self.size += new[axis] * new[axis];
            }
        }
    }

    /// True if the extrapolation foretold forces better than those of the step before, or to rounding. At ω h = 1 both are as good. Forces that
    /// change their sign at each step, as those of a step beyond stability, are missed by four times their change.
    pub(crate) fn is_resolved(&self) -> bool {
        self.missed <= self.changed || self.missed <= f64::EPSILON * self.size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Through parabolas, of a vibration with a number of radians in a step.
    fn of_vibration(radians: f64) -> Resolution {
        let force = |step: i32| 5.0 + (radians * f64::from(step)).sin();
        let mut resolution = Resolution::default();
        for step in 3..1000 {
            let [new, before, second, third] = [0, 1, 2, 3].map(|back| force(step - back));
            let port = |value: f64| [value, 0.0, 0.0, 0.0, 0.0];
            resolution.add(&port(new - 3.0 * before + 3.0 * second - third), &port(new), &port(before));
        }
        resolution
    }

    /// A parabola misses the third difference, (2 sin ½ω h)² changes.
    #[test]
    fn steps_resolve_up_to_one_radian() {
        for (radians, is_resolved) in [(0.1, true), (1.0, true), (1.1, false), (3.1, false), (0.0, true)] {
            assert_eq!(of_vibration(radians).is_resolved(), is_resolved, "{radians}");
        }
        let sawtooth = of_vibration(std::f64::consts::PI - 1e-3);
        assert!((sawtooth.missed / sawtooth.changed - 16.0).abs() < 0.05);
    }

    /// Rounding of a constant force is no motion.
    #[test]
    fn rounding_counts_as_resolved() {
        let mut resolution = Resolution::default();
        resolution.add(&[3e-10, 0.0, 0.0, 0.0, 9.0], &[100.0, 0.0, 0.0, 0.0, 0.0], &[100.0, 0.0, 0.0, 0.0, 0.0]);
        assert!(resolution.is_resolved());
    }
}
