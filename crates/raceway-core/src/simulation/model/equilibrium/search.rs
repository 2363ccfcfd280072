//! The minimum of the potential of raceway contacts, applied loads, gravity and centrifugal force over the places of spindle and balls.

use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x3, Matrix3};

use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Azimuth, Tilt, Vector, add, cross, dot, scale, subtract, turn_about};
use crate::physics::raceway::RacewayContact;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::mechanism::Mechanism;

/// Static equilibrium of spindle and balls.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Displacement of the spindle [m].
    pub spindle: Vector,
    /// Axial position and radius less the pitch radius of each ball [m].
    pub balls: Vec<(f64, f64)>,
    /// Normal load of each ball on each raceway [N].
    pub loads: Vec<PerRaceway<f64>>,
    /// Sine and cosine of the contact angles of each ball, positive where the outer contact lies towards +X.
    pub angles: Vec<PerRaceway<(f64, f64)>>,
}

/// Minimum of the potential at a spindle speed [rad/s], balls at their start azimuths on the ideal orbit.
pub fn equilibrium(mechanism: &Mechanism, speed: f64) -> Result<Equilibrium, SimulationError> {
    let mut search = Search::new(mechanism, speed);
    search.minimise()?;
    let rest = search.result();
    let raceway = &mechanism.raceway;
    for load in &rest.loads {
        let depth = raceway.inner.relative_depth(load.inner).max(raceway.outer.relative_depth(load.outer));
        if depth > MAX_RELATIVE_DEPTH {
            let most = load.inner.max(load.outer);
            let reason = format!("{most:.1e} N press a ball into its raceways by {depth:.2} of its radius");
            return Err(SimulationError::NoEquilibrium(reason));
        }
    }
    Ok(rest)
}

/// Stiffness of the spindle on its balls about the equilibrium at a spindle speed [rad/s], along X, Y, Z [N/m]. Balls follow the spindle without
/// inertia. Held directions are 0.
pub fn spindle_stiffness(mechanism: &Mechanism, speed: f64) -> Result<Matrix3<f64>, SimulationError> {
    let mut search = Search::new(mechanism, speed);
    search.minimise()?;
    Ok(search.condensed_stiffness())
}

/// Largest penetration over the ball's radius [-]: a little deeper, balls would pass through the raceways.
const MAX_RELATIVE_DEPTH: f64 = 0.5;

/// Largest number of iterations of the minimiser; a loaded bearing needs ten to thirty.
const MAX_ITERATIONS: usize = 2000;
/// First step of the search under the applied load [m]: of the size of clearances, because a longer step would penetrate the contacts far
/// too deep and be rejected.
const FIRST_STEP: f64 = 1e-5;

/// A damped Newton search (Levenberg–Marquardt) over [axial, radial] of each ball, then the free
/// directions of the spindle.
struct Search<'a> {
    mechanism: &'a Mechanism,
    orbit_speed: f64,
    azimuths: Vec<Azimuth>,
    axis: Vector,
    /// Directions in which the spindle moves.
    free: &'static [usize],
    place: DVector<f64>,
}

/// One raceway contact of one ball, in the ball's meridian plane.
struct Touch {
    load: f64,
    slope: f64,
    /// Transverse stiffness Q/|l| [N/m].
    turning: f64,
    /// Potential [J].
    energy: f64,
    /// In the orbit frame: change of the penetration with the ball's place, towards the contact but for the lean of a surface profile,
    /// and unit vector across the contact.
    towards: Vector,
    across: Vector,
    /// Sine and cosine of the contact angle.
    angle: (f64, f64),
}

impl<'a> Search<'a> {
    fn new(mechanism: &'a Mechanism, speed: f64) -> Self {
        let balls = mechanism.layout.balls;
        let [about_y, about_z] = mechanism.misalignment;
        let free: &[usize] = if mechanism.layout.axial_spindle { &[0, 1, 2] } else { &[1, 2] };
        Self {
            mechanism,
            orbit_speed: mechanism.orbit_ratio * speed,
            azimuths: mechanism.start.angle[..balls].iter().map(|angle| Azimuth::new(*angle)).collect(),
            axis: Tilt::new(about_y, about_z).columns[0],
            free,
            place: DVector::zeros(2 * balls + free.len()),
        }
    }

    fn spindle(&self, place: &DVector<f64>) -> Vector {
        let mut spindle = [self.mechanism.axial_offset, 0.0, 0.0];
        for (k, &direction) in self.free.iter().enumerate() {
            spindle[direction] += place[2 * self.azimuths.len() + k];
        }
        spindle
    }

    /// `azimuth`: of the ball on a raceway that has not turned, about the bearing axis [rad]; `raised`: its radius less the nominal one with the
    /// height of its surface [m].
    fn touch(
        &self,
        contact: &RacewayContact,
        (azimuth, raised): (f64, f64),
        from_centre: Vector,
        axis: Vector,
    ) -> Touch {
        let mut axial = dot(from_centre, axis);
        let radial = subtract(from_centre, scale(axial, axis));
        let radius = dot(radial, radial).sqrt();
        let (of, place_by_ball) = if contact.is_circle() {
            Default::default()
        } else {
            let on_ring = azimuth + turn_about(axis, radial);
            axial -= contact.groove_place(on_ring);
            contact.height(on_ring, axial, radius)
        };
        let radial = scale(1.0 / radius, radial);
        let (ideal, (a, r)) = if self.mechanism.layout.planar {
            contact.penetration::<true>(axial, radius)
        } else {
            contact.penetration::<false>(axial, radius)
        };
        let penetration = ideal + (of.height + raised);
        let (load, stiffness) = contact.elastic_load(penetration);
        let mut towards = add(scale(a, axis), scale(r, radial));
        if of.along != 0.0 {
            towards = add(towards, scale(of.along / radius, cross(axis, radial)));
        }
        if of.across != 0.0 {
            let (by_axial, by_radial) = place_by_ball;
            towards = add(towards, scale(of.across, add(scale(by_axial, axis), scale(by_radial, radial))));
        }
        Touch {
            load,
            slope: stiffness,
            turning: load / (ideal + contact.touch_distance()),
            energy: 0.4 * load * penetration.max(0.0),
            towards,
            across: subtract(scale(r, axis), scale(a, radial)),
            angle: (a * 1.0_f64.copysign(r), r.abs()),
        }
    }

    fn touches(&self, place: &DVector<f64>, ball: usize) -> PerRaceway<Touch> {
        let m = self.mechanism;
        let at = [place[2 * ball], m.pitch_radius + place[2 * ball + 1], 0.0];
        let ((angle, oversize), azimuth) = (m.start_and_oversize(ball), self.azimuths[ball]);
        let centre = azimuth.to_orbit(self.spindle(place));
        let height = m.uneven_balls.get(ball).map(|ball| ball.heights).unwrap_or_default();
        let axis = azimuth.to_orbit(self.axis);
        let raised = |height: f64| (angle, oversize + height);
        PerRaceway {
            inner: self.touch(&m.raceway.inner, raised(height.inner), subtract(at, centre), axis),
            outer: self.touch(&m.raceway.outer, raised(height.outer), at, [1.0, 0.0, 0.0]),
        }
    }

    /// Constant force on the spindle [N].
    fn spindle_force(&self) -> Vector {
        let m = self.mechanism;
        [m.load[0], m.load[1] + m.spindle_mass * m.gravity, m.load[2]]
    }

    /// Radial body force on a ball, weight and centrifugal force [N], and its slope [N/m].
    fn body_force(&self, ball: usize, radius: f64) -> (f64, f64) {
        let (m, mass) = (self.mechanism, self.mechanism.body(ball).mass);
        let spring = mass * self.orbit_speed * self.orbit_speed;
        (mass * m.gravity * self.azimuths[ball].cosine + spring * radius, spring)
    }

    fn energy(&self, place: &DVector<f64>) -> f64 {
        let m = self.mechanism;
        let spindle = self.spindle(place);
        let mut energy = -dot(self.spindle_force(), spindle);
        for ball in 0..self.azimuths.len() {
            let radial = place[2 * ball + 1];
            let (force, spring) = self.body_force(ball, m.pitch_radius);
            let touches = self.touches(place, ball);
            energy += touches.inner.energy + touches.outer.energy - (force + 0.5 * spring * radial) * radial;
        }
        energy
    }

    /// Gradient and (nearly exact) Hessian of the energy.
    fn slopes(&self, place: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let n = place.len();
        let (mut gradient, mut hessian) = (DVector::zeros(n), DMatrix::zeros(n, n));
        let border = 2 * self.azimuths.len();
        let force = self.spindle_force();
        for (k, &direction) in self.free.iter().enumerate() {
            gradient[border + k] -= force[direction];
        }
        for ball in 0..self.azimuths.len() {
            let at = 2 * ball;
            let (body, spring) = self.body_force(ball, self.mechanism.pitch_radius + place[at + 1]);
            gradient[at + 1] -= body;
            hessian[(at + 1, at + 1)] -= spring;
            let touches = self.touches(place, ball);
            for (touch, moves_spindle) in [(touches.inner, true), (touches.outer, false)] {
                if touch.load == 0.0 {
                    continue;
                }
                // Indices of the unknowns that move this contact, with their directions.
                let spindle_towards = self.azimuths[ball].to_inertial(touch.towards);
                let spindle_across = self.azimuths[ball].to_inertial(touch.across);
                let mut entries = [(at, touch.towards[0], touch.across[0]); 5];
                entries[1] = (at + 1, touch.towards[1], touch.across[1]);
                let moved = if moves_spindle { self.free } else { &[] };
                for (k, &direction) in moved.iter().enumerate() {
                    entries[2 + k] = (border + k, -spindle_towards[direction], -spindle_across[direction]);
                }
                let entries = &entries[..2 + moved.len()];
                for &(i, towards_i, across_i) in entries {
                    gradient[i] += touch.load * towards_i;
                    for &(j, towards_j, across_j) in entries {
                        hessian[(i, j)] += touch.slope * towards_i * towards_j + touch.turning * across_i * across_j;
                    }
                }
            }
        }
        if self.mechanism.layout.planar {
            for ball in 0..self.azimuths.len() {
                hessian[(2 * ball, 2 * ball)] += 1.0;
            }
        }
        (gradient, hessian)
    }

    /// Stiffness of the free directions of the spindle with balls in equilibrium: the Schur complement of the balls' blocks.
    fn condensed_stiffness(&self) -> Matrix3<f64> {
        let (_, hessian) = self.slopes(&self.place);
        let border = 2 * self.azimuths.len();
        let mut stiffness = Matrix3::zeros();
        for (i, &row) in self.free.iter().enumerate() {
            for (j, &column) in self.free.iter().enumerate() {
                stiffness[(row, column)] = hessian[(border + i, border + j)];
            }
        }
        for ball in 0..self.azimuths.len() {
            let block: Matrix2<f64> = hessian.fixed_view::<2, 2>(2 * ball, 2 * ball).into_owned();
            let mut coupling = Matrix2x3::zeros();
            for (i, &direction) in self.free.iter().enumerate() {
                coupling.set_column(direction, &hessian.fixed_view::<2, 1>(2 * ball, border + i));
            }
            // A ball that the spindle does not touch has no coupling.
            if coupling != Matrix2x3::zeros()
                && let Some(compliance) = block.try_inverse()
            {
                stiffness -= coupling.transpose() * compliance * coupling;
            }
        }
        stiffness
    }

    fn minimise(&mut self) -> Result<(), SimulationError> {
        let m = self.mechanism;
        let scale = dot(self.spindle_force(), self.spindle_force()).sqrt() + self.body_force(0, m.pitch_radius).0.abs();
        let converged = 1e-11 * scale + 1e-12;
        let longest_step = 0.01 * m.pitch_radius;
        let mut damping = scale / FIRST_STEP;
        let mut energy = self.energy(&self.place);
        let mut residual = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let (gradient, hessian) = self.slopes(&self.place);
            residual = gradient.amax();
            if residual <= converged {
                return Ok(());
            }
            let mut damped = hessian;
            for i in 0..damped.nrows() {
                damped[(i, i)] += damping;
            }
            let Some(factor) = damped.cholesky() else {
                damping *= 10.0;
                continue;
            };
            let mut step = factor.solve(&-&gradient);
            let longest = step.amax();
            if !longest.is_finite() {
                break;
            }
            if longest > longest_step {
                step *= longest_step / longest;
            }
            let next = &self.place + &step;
            let next_energy = self.energy(&next);
            // Close to the minimum the energy no longer resolves the step, and the force decides.
            let better = next_energy < energy || self.slopes(&next).0.amax() < residual;
            if better {
                self.place = next;
                energy = next_energy;
                damping = (0.1 * damping).max(1e-9);
            } else {
                damping *= 10.0;
                if damping > 1e25 {
                    break;
                }
            }
        }
        // Rounding of places at a stiffness near 1 m/kN leaves at most this residual.
        if residual <= 1e-6 * scale + 1e-9 {
            return Ok(());
        }
        Err(SimulationError::NoEquilibrium(format!("{residual:.3e} N stay unbalanced of {scale:.3e} N applied")))
    }

    fn result(&self) -> Equilibrium {
        let touches = |ball| self.touches(&self.place, ball);
        let (loads, angles) = (0..self.azimuths.len())
            .map(touches)
            .map(|PerRaceway { inner, outer }| {
                let load = PerRaceway { inner: inner.load, outer: outer.load };
                (load, PerRaceway { inner: inner.angle, outer: outer.angle })
            })
            .unzip();
        Equilibrium {
            spindle: {
                let mut spindle = self.spindle(&self.place);
                spindle[0] -= self.mechanism.axial_offset;
                spindle
            },
            balls: (0..self.azimuths.len()).map(|ball| (self.place[2 * ball], self.place[2 * ball + 1])).collect(),
            loads,
            angles,
        }
    }
}
