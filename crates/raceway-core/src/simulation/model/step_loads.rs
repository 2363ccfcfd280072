//! What a step of the own method (`semi_implicit.rs`) has found at its end besides the state: who looks on need not evaluate the
//! equations again.

use crate::numerics::lanes::{LANES, Lanes, side_by_side};
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::Vector;

/// What presses on a ball, and how it slips and rolls.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen<T = f64> {
    /// Normal loads [N].
    pub load: PerRaceway<T>,
    pub pocket: T,
    /// Squares of the slip at the contacts' centres [m²/s²].
    pub slip_square: PerRaceway<T>,
    /// Sine and cosine of the contact angles.
    pub angle: PerRaceway<(T, T)>,
    /// Mean rolling speeds at the contacts' centres [m/s].
    pub rolling_speed: PerRaceway<T>,
}
side_by_side!(Seen { load, pocket, slip_square, angle, rolling_speed });

/// Numbers of a ball in a row of them.
const COLUMNS: usize = 11;

/// All that is seen, as numbers in a row: the form in which an integrator hands it on.
#[derive(Debug, Clone, Copy)]
pub struct Sight<'a>(pub &'a [f64]);

impl Sight<'_> {
    /// Numbers of so many groups of balls.
    pub fn numbers(groups: usize) -> usize {
        3 + groups * COLUMNS * LANES
    }

    /// Acceleration of the spindle [m/s²].
    pub fn acceleration(&self) -> Vector {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// What is seen of a ball.
    #[inline]
    pub fn of(&self, ball: usize) -> Seen {
        let first = 3 + ball / LANES * COLUMNS * LANES + ball % LANES;
        let row = &self.0[first..=first + (COLUMNS - 1) * LANES];
        let [inner, outer, pocket, slip_i, slip_e, sine_i, cosine_i, sine_e, cosine_e, rolling_i, rolling_e] =
            std::array::from_fn(|column| row[column * LANES]);
        Seen {
            load: PerRaceway { inner, outer },
            pocket,
            slip_square: PerRaceway { inner: slip_i, outer: slip_e },
            angle: PerRaceway { inner: (sine_i, cosine_i), outer: (sine_e, cosine_e) },
            rolling_speed: PerRaceway { inner: rolling_i, outer: rolling_e },
        }
    }
}

impl Seen<Lanes> {
    /// Puts a group of balls into its place of the row.
    #[inline(always)]
    pub fn put_into(&self, numbers: &mut [f64], group: usize) {
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
    fn what_is_put_in_comes_out_ball_by_ball() {
        let one = |ball: usize| {
            let number = |column: usize| (10 * ball + column) as f64;
            Seen {
                load: PerRaceway { inner: number(0), outer: number(1) },
                pocket: number(2),
                slip_square: PerRaceway { inner: number(3), outer: number(4) },
                angle: PerRaceway { inner: (number(5), number(6)), outer: (number(7), number(8)) },
                rolling_speed: PerRaceway { inner: number(9), outer: number(10) },
            }
        };
        let mut numbers = vec![0.0; Sight::numbers(2)];
        for group in 0..2 {
            let mut seen = Seen::<Lanes>::default();
            for lane in 0..LANES {
                seen.put(lane, one(group * LANES + lane));
            }
            seen.put_into(&mut numbers, group);
        }
        numbers[..3].copy_from_slice(&[1.0, 2.0, 3.0]);
        let sight = Sight(&numbers);
        assert_eq!(sight.acceleration(), [1.0, 2.0, 3.0]);
        for ball in 0..2 * LANES {
            assert_eq!(format!("{:?}", sight.of(ball)), format!("{:?}", one(ball)));
        }
    }
}
