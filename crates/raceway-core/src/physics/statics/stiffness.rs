//! Stiffness of a ball between both rings: that of its contacts, and the rise of its forces of rolling.

use super::ball::{FREEDOMS, Matrix, Meridian, OF_BALL, Placed, RingBearing, Touch, UNKNOWNS};
use super::groove::InGroove;
use super::rolling::RollingForces;
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::damping::DampingFactor;
use crate::physics::kinematics::RingSpeeds;

/// Rise of the forces on a ball and on the inner ring against their motions.
pub(super) struct BallStiffness(pub(super) [[f64; UNKNOWNS]; UNKNOWNS]);

/// Step of the numerical derivatives [m]: small beside penetrations, and far above the rounding of places.
const STEP: f64 = 1e-9;

impl RingBearing {
    /// Forces of rolling along the freedoms of a ball and of the inner ring.
    pub(super) fn rolling_forces(&self, ball: &Placed, speeds: RingSpeeds) -> [f64; UNKNOWNS] {
        if speeds == RingSpeeds::default() {
            return [0.0; UNKNOWNS];
        }
        let at = self.in_grooves(ball, [0.0; 4]);
        let RollingForces { centrifugal, traction } = self.rolling.forces(speeds, ball.meridian.outer.radius, &at);
        let (inner, outer) = (across(&ball.meridian.inner, &at.inner), across(&ball.meridian.outer, &at.outer));
        let arm = self.arm(ball);
        std::array::from_fn(|k| {
            let along_radius = if k == 1 { centrifugal } else { 0.0 };
            along_radius - traction.inner * (inner[k] + arm[k]) - traction.outer * outer[k]
        })
    }

    /// Rise of the forces of rolling [N/m, N, N m], row by row.
    fn rise_of_rolling_forces(&self, ball: &Placed, speeds: RingSpeeds) -> [[f64; UNKNOWNS]; UNKNOWNS] {
        let mut rise = [[0.0; UNKNOWNS]; UNKNOWNS];
        if speeds == RingSpeeds::default() {
            return rise;
        }
        let at = self.in_grooves(ball, [0.0; 4]);
        let forces = |shift: [f64; 4]| {
            let radius = ball.meridian.outer.radius + shift[3];
            self.rolling.forces(speeds, radius, &self.in_grooves(ball, shift))
        };
        let here = forces([0.0; 4]);
        let arm = self.arm(ball);
        let [inner, outer] = [(&ball.meridian.inner, &at.inner), (&ball.meridian.outer, &at.outer)]
            .map(|(meridian, at)| across(meridian, at));
        // By the axial and radial places in the inner and in the outer groove.
        for place in 0..4 {
            let moved = |by: f64| forces(std::array::from_fn(|other| if other == place { by } else { 0.0 }));
            let (after, before) = (moved(STEP), moved(-STEP));
            let slope = |of: fn(&RollingForces) -> f64| (of(&after) - of(&before)) / (2.0 * STEP);
            let centrifugal = slope(|of| of.centrifugal);
            let (on_inner, on_outer) = (slope(|of| of.traction.inner), slope(|of| of.traction.outer));
            let by = if place < 2 { &ball.meridian.inner.by } else { &ball.meridian.outer.by };
            for (column, &(axial, radius)) in by.iter().enumerate() {
                let moves = if place % 2 == 0 { axial } else { radius };
                rise[1][column] += centrifugal * moves;
                for (row, entries) in rise.iter_mut().enumerate() {
                    entries[column] -= moves * (on_inner * (inner[row] + arm[row]) + on_outer * outer[row]);
                }
            }
        }
        // Tractions turn with the contact angle, and with the axis of the ring.
        let tractions = [
            (&ball.meridian.inner, at.inner, inner, here.traction.inner),
            (&ball.meridian.outer, at.outer, outer, here.traction.outer),
        ];
        for (meridian, at, across, traction) in tractions {
            let (sine, cosine) = at.direction;
            for (row, entries) in rise.iter_mut().enumerate() {
                let (axial, radius) = meridian.by[row];
                let towards = sine * axial + cosine * radius;
                for (column, entry) in entries.iter_mut().enumerate() {
                    let (axial, radius) = meridian.bend[row.max(column)][row.min(column)];
                    *entry -= traction * (cosine * axial - sine * radius - towards * across[column] / at.distance);
                }
            }
        }
        rise
    }

    /// A ball with its places in the inner and in the outer groove shifted [m].
    fn in_grooves(&self, ball: &Placed, shift: [f64; 4]) -> PerRaceway<InGroove> {
        let (groove, PerRaceway { inner, outer }) = (self.grooves(), &ball.meridian);
        PerRaceway {
            inner: groove.inner.at(inner.axial + shift[0], inner.radius + shift[1]),
            outer: groove.outer.at(outer.axial + shift[2], outer.radius + shift[3]),
        }
    }

    /// Motion of the inner contact across the groove, beyond that of the ball's centre, as the ring tilts [m/rad].
    fn arm(&self, ball: &Placed) -> [f64; UNKNOWNS] {
        let mut arm = [0.0; UNKNOWNS];
        for (k, about) in [(OF_BALL + 3, [0.0, 1.0, 0.0]), (OF_BALL + 4, [0.0, 0.0, 1.0])] {
            arm[k] = self.rolling.ball_radius * ball.azimuth.to_orbit(about)[2];
        }
        arm
    }

    /// Stiffness of a ball in equilibrium.
    pub(super) fn stiffness_of_ball(
        &self,
        ball: &Placed,
        hessian: &[[f64; UNKNOWNS]; UNKNOWNS],
        speeds: RingSpeeds,
    ) -> BallStiffness {
        let rise = self.rise_of_rolling_forces(ball, speeds);
        BallStiffness(std::array::from_fn(|row| {
            std::array::from_fn(|column| hessian[row.max(column)][row.min(column)] - rise[row][column])
        }))
    }
}

/// Motion of a ball across a groove by its own place and by the pose of the ring.
fn across(meridian: &Meridian, at: &InGroove) -> [f64; UNKNOWNS] {
    let (sine, cosine) = at.direction;
    meridian.by.map(|(axial, radius)| cosine * axial - sine * radius)
}

impl BallStiffness {
    /// Stiffness by the pose of the inner ring alone, a pressed ball in equilibrium: the Schur complement A_rr − A_rb A_bb⁻¹ A_br.
    pub(super) fn condensed(&self) -> Matrix {
        let follows = self.follows();
        std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let by_ball: f64 = (0..OF_BALL).map(|k| self.0[OF_BALL + row][k] * follows[column][k]).sum();
                self.0[OF_BALL + row][OF_BALL + column] - by_ball
            })
        })
    }

    /// Damping by the pose of the inner ring alone at rates that leave a pressed ball in equilibrium.
    pub(super) fn condensed_damping(&self, touch: &PerRaceway<Touch>, damping: &DampingFactor) -> Matrix {
        let (follows, passes) = (self.follows(), self.passes());
        let mut sum = Matrix::default();
        for touch in [&touch.inner, &touch.outer] {
            let coefficient = touch.damping(damping);
            let by = |motion: &[[f64; OF_BALL]; FREEDOMS]| -> [f64; FREEDOMS] {
                std::array::from_fn(|k| {
                    let [axial, radial] = motion[k];
                    touch.towards[OF_BALL + k] - axial * touch.towards[0] - radial * touch.towards[1]
                })
            };
            let (rate, force) = (by(&follows), by(&passes));
            for row in 0..FREEDOMS {
                for column in 0..FREEDOMS {
                    sum[row][column] += coefficient * force[row] * rate[column];
                }
            }
        }
        sum
    }

    /// Motion of the ball by each freedom of the inner ring with the sign changed, A_bb⁻¹ A_br.
    fn follows(&self) -> [[f64; OF_BALL]; FREEDOMS] {
        let [[first, between, ..], [across, second, ..], ..] = self.0;
        let determinant = first * second - between * across;
        std::array::from_fn(|k| {
            let (axial, radial) = (self.0[0][OF_BALL + k], self.0[1][OF_BALL + k]);
            [(second * axial - between * radial) / determinant, (first * radial - across * axial) / determinant]
        })
    }

    /// Force on each freedom of the inner ring by a force on the ball, A_rb A_bb⁻¹.
    fn passes(&self) -> [[f64; OF_BALL]; FREEDOMS] {
        let [[first, between, ..], [across, second, ..], ..] = self.0;
        let determinant = first * second - between * across;
        std::array::from_fn(|k| {
            let [axial, radial, ..] = self.0[OF_BALL + k];
            [(axial * second - radial * across) / determinant, (radial * first - axial * between) / determinant]
        })
    }
}
