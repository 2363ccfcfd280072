//! One bearing: force and stiffness at a pose of the inner ring, and the pose under loads.

use std::array::from_fn;

use nalgebra::{Complex, Matrix2};

pub use super::balance::NoBalance;
use super::balance::{Balance, Border, Found, Link, Places, balls_of};
use super::ball::{BallSlopes, FREEDOMS, Matrix, OF_BALL, Pose, RingBearing, Touch, Wrench};
use super::stiffness::BallStiffness;
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::damping::DampingFactor;

/// A bearing with its balls in equilibrium at a pose of the inner ring. Values are means over eight places in a ball spacing.
#[derive(Debug, Clone)]
pub struct RingState {
    bearing: RingBearing,
    /// Pose of the inner ring relative to the outer one.
    pub pose: Pose,
    /// Speed of the inner ring [rad/s].
    pub speed: f64,
    balls: Places,
    /// Load below which a ball is loose [N].
    least_load: f64,
    /// Forces and moments of the balls on the inner ring.
    pub wrench: Wrench,
    /// Rise of the forces and moments against a motion of the inner ring.
    pub stiffness: Spread,
    /// Largest load of a ball on the inner and on the outer raceway [N].
    pub largest_loads: [f64; 2],
    /// Share of the balls that the inner raceway presses [-].
    pub loaded: f64,
}

/// Mean, least and most of each entry over the places of the balls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    pub mean: Matrix,
    pub least: Matrix,
    pub most: Matrix,
}

/// Stiffness and damping of a vibration at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DynamicStiffness {
    pub stiffness: Matrix,
    pub damping: Matrix,
}

impl RingBearing {
    /// The bearing at a pose of the inner ring and a speed [rad/s]; the balls find their equilibrium.
    pub fn at(&self, pose: &Pose, speed: f64) -> Result<RingState, NoBalance> {
        self.settled(pose, speed, None)
    }

    /// The bearing at a pose, searched from a state near it.
    pub fn near(&self, pose: &Pose, speed: f64, start: &RingState) -> Result<RingState, NoBalance> {
        self.settled(pose, speed, Some(&start.balls))
    }

    fn settled(&self, pose: &Pose, speed: f64, balls: Option<&Places>) -> Result<RingState, NoBalance> {
        let none = [0.0; _];
        let link = Link { bearing: self, base: *pose, by: [none; FREEDOMS] };
        let balance = Balance { links: vec![link], speed, width: 0, load: none, springs: none };
        let balls = balls.cloned().map(|balls| vec![balls]);
        let Found { balls, least_load, .. } = balance.find(&none, balls.as_deref())?;
        Ok(RingState::of(self, *pose, speed, balls.into_iter().flatten().collect(), least_load))
    }

    /// The bearing with its balls in equilibrium at these places to a residual [N].
    pub(crate) fn with_balls(&self, pose: &Pose, speed: f64, places: &[f64], residual: f64) -> RingState {
        RingState::of(self, *pose, speed, places.as_chunks().0.to_vec(), self.places as f64 * residual)
    }

    /// The pose that balances loads on the inner ring. `free`: freedoms that move; the others stay as in `start`.
    pub fn operating_point(
        &self,
        load: &Wrench,
        free: [bool; FREEDOMS],
        start: &Pose,
        speed: f64,
    ) -> Result<RingState, NoBalance> {
        let (mut by, mut of_load, mut width) = ([[0.0; _]; FREEDOMS], Border::default(), 0);
        for k in (0..FREEDOMS).filter(|&k| free[k]) {
            // Slopes are searched as lengths.
            let unit = if k < 3 { 1.0 } else { 1.0 / self.pitch_radius };
            (by[k][width], of_load[width]) = (unit, unit * load[k]);
            width += 1;
        }
        let none = [0.0; _];
        let link = Link { bearing: self, base: *start, by };
        let balance = Balance { links: vec![link], speed, width, load: of_load, springs: none };
        let Found { border, balls, least_load } = balance.find(&none, None)?;
        let pose = balance.links[0].pose(&border[..width]);
        Ok(RingState::of(self, pose, speed, balls.into_iter().flatten().collect(), least_load))
    }

    /// Axial displacement from the centred position under a thrust at rest [m], the ring straight and centred.
    pub fn under_thrust(&self, thrust: f64) -> Result<f64, NoBalance> {
        let mut start = [0.0; FREEDOMS];
        start[0] = self.axial_play();
        let load = from_fn(|k| if k == 0 { thrust } else { 0.0 });
        let at_rest = self.clone().with_outer_speed(0.0);
        Ok(at_rest.operating_point(&load, from_fn(|k| k == 0), &start, 0.0)?.pose[0])
    }
}

impl RingState {
    /// The state with balls in equilibrium at these places.
    pub(super) fn of(bearing: &RingBearing, pose: Pose, speed: f64, balls: Places, least_load: f64) -> Self {
        let mut of_places = vec![Matrix::default(); bearing.places];
        let (mut wrench, mut largest_loads, mut pressed) = (Wrench::default(), [0.0_f64; 2], 0);
        let speeds = bearing.speeds(speed);
        for (index, (ball, slopes)) in balls_of(bearing, &pose, balls.iter().copied()).enumerate() {
            let PerRaceway { inner, outer } = slopes.touch;
            largest_loads = [largest_loads[0].max(inner.load), largest_loads[1].max(outer.load)];
            if inner.load <= least_load {
                continue;
            }
            pressed += 1;
            let stiffness = bearing.stiffness_of_ball(&ball, &slopes.hessian, speeds);
            add_to(&mut of_places[index / bearing.balls], &stiffness.condensed(), 1.0);
            let rolling = bearing.rolling_forces(&ball, speeds);
            for (k, force) in wrench.iter_mut().enumerate() {
                *force -= bearing.share() * (slopes.gradient[OF_BALL + k] - rolling[OF_BALL + k]);
            }
        }
        Self {
            bearing: bearing.clone(),
            pose,
            speed,
            balls,
            least_load,
            wrench,
            stiffness: Spread::of(&of_places),
            largest_loads,
            loaded: f64::from(pressed) / bearing.entries() as f64,
        }
    }

    /// Places of the balls.
    pub(crate) fn balls(&self) -> &Places {
        &self.balls
    }

    /// Largest contact angle of a pressed ball on the inner and on the outer raceway [rad].
    #[cfg(test)]
    pub(crate) fn angles(&self) -> [f64; 2] {
        let balls = balls_of(&self.bearing, &self.pose, self.balls.iter().copied());
        balls.filter(|(_, slopes)| slopes.touch.inner.load > self.least_load).fold([0.0; 2], |most, (ball, _)| {
            let (of, groove) = (&ball.meridian, self.bearing.grooves());
            let inner = groove.inner.at(of.inner.axial, of.inner.radius).direction;
            let outer = groove.outer.at(of.outer.axial, of.outer.radius).direction;
            [most[0].max((inner.0 / inner.1).atan()), most[1].max((outer.0 / outer.1).atan())]
        })
    }

    /// Thrust in the direction in which the rings of an angular-contact bearing come apart [N]; `None` where there is none.
    pub fn thrust_over_open_side(&self) -> Option<f64> {
        // In the bearing's own axes, in which the balls push a ring that carries thrust along −X.
        let load = self.wrench[0];
        (self.bearing.has_open_side && load > 0.0).then_some(load)
    }

    /// Largest pressure of a ball on a raceway [Pa], with the load that makes it [N].
    pub fn largest_pressure(&self) -> (f64, f64) {
        let grooves = self.bearing.grooves();
        let [inner, outer] = self.largest_loads;
        let [on_inner, on_outer] =
            [(grooves.inner, inner), (grooves.outer, outer)].map(|(groove, load)| (groove.max_pressure(load), load));
        if on_inner.0 > on_outer.0 { on_inner } else { on_outer }
    }

    /// Damping of the contacts against slow motions of the inner ring, in which the balls stay in equilibrium.
    pub fn damping(&self, damping: &DampingFactor) -> Matrix {
        self.mean(|touch, stiffness| stiffness.condensed_damping(touch, damping))
    }

    /// Stiffness and damping of the contacts for a vibration of the inner ring [rad/s], in which the inertia and the damping of the balls act
    /// along the axis and the radius.
    pub fn at_frequency(&self, damping: &DampingFactor, frequency: f64) -> DynamicStiffness {
        if frequency == 0.0 {
            return DynamicStiffness { stiffness: self.stiffness.mean, damping: self.damping(damping) };
        }
        let inertia = self.bearing.rolling.ball_mass * frequency * frequency;
        let part = |part: fn(Complex<f64>) -> f64| {
            self.mean(|touch, stiffness| {
                stiffness.condensed_at(touch, damping, frequency, inertia).map(|row| row.map(part))
            })
        };
        let by_rate = part(|entry| entry.im);
        DynamicStiffness {
            stiffness: part(|entry| entry.re),
            damping: by_rate.map(|row| row.map(|entry| entry / frequency)),
        }
    }

    /// Mean over the places of a sum over the pressed balls.
    fn mean(&self, of_ball: impl Fn(&PerRaceway<Touch>, &BallStiffness) -> Matrix) -> Matrix {
        let (mut sum, speeds) = (Matrix::default(), self.bearing.speeds(self.speed));
        for (ball, BallSlopes { hessian, touch, .. }) in balls_of(&self.bearing, &self.pose, self.balls.iter().copied())
        {
            if touch.inner.load > self.least_load {
                let stiffness = self.bearing.stiffness_of_ball(&ball, &hessian, speeds);
                add_to(&mut sum, &of_ball(&touch, &stiffness), self.bearing.share());
            }
        }
        sum
    }
}

impl Spread {
    fn of(places: &[Matrix]) -> Self {
        let entry = |of: &dyn Fn(&mut dyn Iterator<Item = f64>) -> f64| -> Matrix {
            from_fn(|row| from_fn(|column| of(&mut places.iter().map(|place| place[row][column]))))
        };
        Self {
            mean: entry(&|values| values.sum::<f64>() / places.len() as f64),
            least: entry(&|values| values.fold(f64::INFINITY, f64::min)),
            most: entry(&|values| values.fold(f64::NEG_INFINITY, f64::max)),
        }
    }
}

impl BallStiffness {
    /// Complex stiffness by the pose of the inner ring at a frequency [rad/s]; `inertia`: of the ball times the frequency squared [N/m].
    fn condensed_at(
        &self,
        touch: &PerRaceway<Touch>,
        damping: &DampingFactor,
        frequency: f64,
        inertia: f64,
    ) -> [[Complex<f64>; FREEDOMS]; FREEDOMS] {
        let touches = [&touch.inner, &touch.outer].map(|touch| (touch.damping(damping), touch.towards));
        let entry = |row: usize, column: usize| {
            let rate = touches.iter().map(|(coefficient, towards)| coefficient * towards[row] * towards[column]);
            Complex::new(self.0[row][column], frequency * rate.sum::<f64>())
        };
        let of_ball = Matrix2::from_fn(|row, column| {
            entry(row, column) - if row == column { Complex::from(inertia) } else { Complex::default() }
        });
        // A resonance without damping has no stiffness.
        let inverse = of_ball.try_inverse().unwrap_or_default();
        from_fn(|row| {
            from_fn(|column| {
                let mut sum = entry(OF_BALL + row, OF_BALL + column);
                for k in 0..OF_BALL {
                    for l in 0..OF_BALL {
                        sum -= entry(OF_BALL + row, k) * inverse[(k, l)] * entry(l, OF_BALL + column);
                    }
                }
                sum
            })
        })
    }
}

pub(super) fn add_to(sum: &mut Matrix, matrix: &Matrix, factor: f64) {
    for (sum, row) in sum.iter_mut().zip(matrix) {
        for (sum, entry) in sum.iter_mut().zip(row) {
            *sum += factor * entry;
        }
    }
}
