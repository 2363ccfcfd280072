//! Loads at the end of a step of the semi-implicit integrator, so that the observer need not evaluate the equations again.

use crate::numerics::lanes::{LANES, Lanes, side_by_side};
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::Vector;

/// Loads, slip and rolling speeds of a ball at the end of a step.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StepLoads<T = f64> {
    /// Normal loads of the raceways [N].
    pub load: PerRaceway<T>,
    /// Normal load of the pocket [N].
    pub pocket: T,
    /// Squares of the slip at the contacts' centres [m²/s²].
    pub slip_square: PerRaceway<T>,
    /// Sine and cosine of the contact angles.
    pub angle: PerRaceway<(T, T)>,
    /// Mean rolling speeds at the contacts' centres [m/s].
    pub rolling_speed: PerRaceway<T>,
}
side_by_side!(StepLoads { load, pocket, slip_square, angle, rolling_speed });

/// Packed numbers of a ball.
const COLUMNS: usize = 11;

/// Loads of all balls and the acceleration of the spindle, packed into one row of numbers for the integrator interface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PackedStepLoads<'a>(pub &'a [f64]);

impl PackedStepLoads<'_> {
    /// Length of the row for a number of groups of balls.
    pub(crate) fn numbers(groups: usize) -> usize {
        3 + groups * COLUMNS * LANES
    }

    /// Acceleration of the spindle [m/s²].
    pub(crate) fn acceleration(&self) -> Vector {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// Loads of a ball.
    #[inline]
    pub(crate) fn of(&self, ball: usize) -> StepLoads {
        let first = 3 + ball / LANES * COLUMNS * LANES + ball % LANES;
        let row = &self.0[first..=first + (COLUMNS - 1) * LANES];
        let [inner, outer, pocket, slip_i, slip_e, sine_i, cosine_i, sine_e, cosine_e, rolling_i, rolling_e] =
            std::array::from_fn(|column| row[column * LANES]);
        StepLoads {
            load: PerRaceway { inner, outer },
            pocket,
            slip_square: PerRaceway { inner: slip_i, outer: slip_e },
            angle: PerRaceway { inner: (sine_i, cosine_i), outer: (sine_e, cosine_e) },
            rolling_speed: PerRaceway { inner: rolling_i, outer: rolling_e },
        }
    }
}

impl StepLoads<Lanes> {
    /// Writes a group of balls into its place of the row.
    #[inline(always)]
    pub(crate) fn put_into(&self, numbers: &mut [f64], group: usize) {
        let Self { load, pocket, slip_square, angle, rolling_speed } = self;
        let columns: [&Lanes; COLUMNS] = [
            &load.inner,
            &load.outer,
            pocket,
            &slip_square.inner,
            &slip_square.outer,
            &angle.inner.0,
            &angle.inner.1,
            &angle.outer.0,
            &angle.outer.1,
            &rolling_speed.inner,
            &rolling_speed.outer,
        ];
        let row = &mut numbers[3 + group * COLUMNS * LANES..][..COLUMNS * LANES];
        for (place, column) in row.chunks_exact_mut(LANES).zip(columns) {
            place.copy_from_slice(&column.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::lanes::SideBySide;

    #[test]
    fn packed_loads_are_read_back_ball_by_ball() {
        let one = |ball: usize| {
            let number = |column: usize| (10 * ball + column) as f64;
            StepLoads {
                load: PerRaceway { inner: number(0), outer: number(1) },
                pocket: number(2),
                slip_square: PerRaceway { inner: number(3), outer: number(4) },
                angle: PerRaceway { inner: (number(5), number(6)), outer: (number(7), number(8)) },
                rolling_speed: PerRaceway { inner: number(9), outer: number(10) },
            }
        };
        let mut numbers = vec![0.0; PackedStepLoads::numbers(2)];
        for group in 0..2 {
            let mut seen = StepLoads::<Lanes>::default();
            for lane in 0..LANES {
                seen.put(lane, one(group * LANES + lane));
            }
            seen.put_into(&mut numbers, group);
        }
        numbers[..3].copy_from_slice(&[1.0, 2.0, 3.0]);
        let packed = PackedStepLoads(&numbers);
        assert_eq!(packed.acceleration(), [1.0, 2.0, 3.0]);
        for ball in 0..2 * LANES {
            assert_eq!(format!("{:?}", packed.of(ball)), format!("{:?}", one(ball)));
        }
    }
}
