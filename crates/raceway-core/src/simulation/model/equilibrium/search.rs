//! The minimum of the potential of raceway contacts, applied loads, gravity and centrifugal force over the places of spindle and balls.

use nalgebra::Matrix3;

use crate::numerics::bordered::Bordered;
use crate::numerics::minimum::{Potential, Search, Slopes};
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Azimuth, Tilt, Vector, add, cross, dot, scale, subtract, turn_about};
use crate::physics::kinematics::RingSpeeds;
use crate::physics::raceway::RacewayContact;
use crate::physics::statics::{FIRST_STEP, MAX_RELATIVE_DEPTH};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::mechanism::Mechanism;

/// Static equilibrium of spindle and balls.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Displacement of the spindle [m].
    pub spindle: Vector,
    /// Tilt of the spindle about Y and about the new Z [rad].
    pub tilt: [f64; 2],
    /// Axial position and radius less the pitch radius of each ball [m].
    pub balls: Vec<(f64, f64)>,
    /// Normal load of each ball on each raceway [N].
    pub loads: Vec<PerRaceway<f64>>,
    /// Sine and cosine of the contact angles of each ball, positive where the outer contact lies towards +X.
    pub angles: Vec<PerRaceway<(f64, f64)>>,
}

/// Minimum of the potential at speeds of the rings [rad/s], balls at their start azimuths on the ideal orbit.
pub fn equilibrium(mechanism: &Mechanism, speeds: impl Into<RingSpeeds>) -> Result<Equilibrium, SimulationError> {
    let potential = RacewayPotential::new(mechanism, speeds.into());
    let rest = potential.at(&potential.minimum()?);
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

/// Stiffness of the spindle on its balls about the equilibrium at speeds of the rings [rad/s], along X, Y, Z [N/m]. Balls follow the spindle without
/// inertia, and the spindle does not tilt. Held directions are 0.
pub fn spindle_stiffness(
    mechanism: &Mechanism,
    speeds: impl Into<RingSpeeds>,
) -> Result<Matrix3<f64>, SimulationError> {
    let potential = RacewayPotential::new(mechanism, speeds.into());
    let condensed = potential.slopes(&potential.minimum()?).hessian.condensed();
    let mut stiffness = Matrix3::zeros();
    let translations = || potential.free.iter().enumerate().filter(|(_, freedom)| **freedom < 3);
    for (row, &direction) in translations() {
        for (column, &other) in translations() {
            stiffness[(direction, other)] = condensed[row][column];
        }
    }
    Ok(stiffness)
}

/// Equilibrium of the balls at a pose of the inner ring, x, y, z and tilts about Y and the new Z, and speeds of the rings [rad/s]. `force`: size
/// of the loads on the ring [N].
pub(crate) fn on_ring(
    mechanism: &Mechanism,
    speeds: RingSpeeds,
    pose: [f64; DIRECTIONS],
    force: f64,
) -> Result<Equilibrium, SimulationError> {
    let potential = RacewayPotential { free: &[], held: pose, force, ..RacewayPotential::new(mechanism, speeds) };
    Ok(potential.at(&potential.minimum()?))
}

/// Most directions in which a spindle moves.
const DIRECTIONS: usize = 5;

/// The potential over [axial, radial] of each ball, then the free directions of the spindle.
struct RacewayPotential<'a> {
    mechanism: &'a Mechanism,
    orbit_speed: f64,
    azimuths: Vec<Azimuth>,
    /// Freedoms of the spindle: along X, Y, Z, and about Y and the new Z.
    free: &'static [usize],
    /// Pose of the spindle where its freedoms are 0.
    held: [f64; DIRECTIONS],
    /// Size of the loads on the spindle [N].
    force: f64,
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
    /// From the centre of the ring to the ball [m].
    lever: Vector,
    /// Sine and cosine of the contact angle.
    angle: (f64, f64),
}

impl<'a> RacewayPotential<'a> {
    fn new(mechanism: &'a Mechanism, speeds: RingSpeeds) -> Self {
        let balls = mechanism.layout.balls;
        let [about_y, about_z] = mechanism.misalignment;
        let [x, y, z, about_y_force, about_z_force] = spindle_force(mechanism);
        let tilting = about_y_force.hypot(about_z_force);
        Self {
            held: [mechanism.axial_offset, 0.0, 0.0, about_y, about_z],
            force: dot([x, y, z], [x, y, z]).sqrt() + tilting,
            mechanism,
            orbit_speed: speeds.carried(mechanism.orbit_ratio),
            azimuths: mechanism.start.angle[..balls].iter().map(|angle| Azimuth::new(*angle)).collect(),
            free: mechanism.layout.freedoms(),
        }
    }

    /// Displacement of the spindle [m], and its tilt about Y and the new Z [rad]. The unknowns of the tilt are arcs at the pitch radius.
    fn spindle(&self, place: &[f64]) -> (Vector, [f64; 2]) {
        let mut unknowns = [0.0; DIRECTIONS];
        for (k, &freedom) in self.free.iter().enumerate() {
            unknowns[freedom] = place[2 * self.azimuths.len() + k];
        }
        let [x, y, z, about_y, about_z] = unknowns;
        let per_radius = 1.0 / self.mechanism.pitch_radius;
        let [held_x, held_y, held_z, held_about_y, held_about_z] = self.held;
        (
            [held_x + x, held_y + y, held_z + z],
            [held_about_y + per_radius * about_y, held_about_z + per_radius * about_z],
        )
    }

    /// Motion of the ring at a lever under each unknown of the spindle, in the inertial frame [-].
    fn carried(&self, tilt: &Tilt, lever: Vector) -> [Vector; DIRECTIONS] {
        let per_radius = 1.0 / self.mechanism.pitch_radius;
        let about = |axis: Vector| scale(per_radius, cross(axis, lever));
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], about([0.0, 1.0, 0.0]), about(tilt.columns[2])]
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
            lever: from_centre,
            angle: (a * 1.0_f64.copysign(r), r.abs()),
        }
    }

    fn touches(&self, place: &[f64], ball: usize) -> PerRaceway<Touch> {
        let m = self.mechanism;
        let at = [place[2 * ball], m.pitch_radius + place[2 * ball + 1], 0.0];
        let ((angle, oversize), azimuth) = (m.start_and_oversize(ball), self.azimuths[ball]);
        let (centre, [about_y, about_z]) = self.spindle(place);
        let centre = azimuth.to_orbit(centre);
        let height = m.uneven_balls.get(ball).map(|ball| ball.heights).unwrap_or_default();
        let axis = azimuth.to_orbit(Tilt::new(about_y, about_z).columns[0]);
        let raised = |height: f64| (angle, oversize + height);
        PerRaceway {
            inner: self.touch(&m.raceway.inner, raised(height.inner), subtract(at, centre), axis),
            outer: self.touch(&m.raceway.outer, raised(height.outer), at, [1.0, 0.0, 0.0]),
        }
    }

    /// Radial body force on a ball, weight and centrifugal force [N], and its slope [N/m].
    fn body_force(&self, ball: usize, radius: f64) -> (f64, f64) {
        let (m, mass) = (self.mechanism, self.mechanism.body(ball).mass);
        let spring = mass * self.orbit_speed * self.orbit_speed;
        (mass * m.gravity * self.azimuths[ball].cosine + spring * radius, spring)
    }

    /// The place of least energy.
    fn minimum(&self) -> Result<Vec<f64>, SimulationError> {
        let m = self.mechanism;
        let scale = self.force + self.body_force(0, m.pitch_radius).0.abs();
        let search = Search {
            converged: 1e-11 * scale + 1e-12,
            longest_step: 0.01 * m.pitch_radius,
            first_damping: scale / FIRST_STEP,
        };
        let mut place = vec![0.0; 2 * self.azimuths.len() + self.free.len()];
        let residual = search.minimise(self, &mut place).residual();
        // Rounding of places at a stiffness near 1 m/kN leaves at most this residual.
        if residual <= 1e-6 * scale + 1e-9 {
            return Ok(place);
        }
        Err(SimulationError::NoEquilibrium(format!("{residual:.3e} N stay unbalanced of {scale:.3e} N applied")))
    }

    fn at(&self, place: &[f64]) -> Equilibrium {
        let touches = |ball| self.touches(place, ball);
        let (loads, angles) = (0..self.azimuths.len())
            .map(touches)
            .map(|PerRaceway { inner, outer }| {
                let load = PerRaceway { inner: inner.load, outer: outer.load };
                (load, PerRaceway { inner: inner.angle, outer: outer.angle })
            })
            .unzip();
        let (spindle, tilt) = self.spindle(place);
        Equilibrium {
            spindle: subtract(spindle, [self.mechanism.axial_offset, 0.0, 0.0]),
            tilt,
            balls: (0..self.azimuths.len()).map(|ball| (place[2 * ball], place[2 * ball + 1])).collect(),
            loads,
            angles,
        }
    }
}

/// Force on the spindle at the start [N], and its moments over the pitch radius, forces on the unknowns of the tilt [N].
fn spindle_force(m: &Mechanism) -> [f64; DIRECTIONS] {
    let [about_y, about_z] = m.moment.map(|moment| moment / m.pitch_radius);
    [m.load[0], m.load[1] + m.spindle_mass * m.gravity, m.load[2], about_y, about_z]
}

impl Potential for RacewayPotential<'_> {
    type Curvature = Bordered<DIRECTIONS>;

    fn step(&self, slopes: &Slopes<Self::Curvature>, damping: f64) -> Option<Vec<f64>> {
        slopes.bordered_step(damping)
    }

    /// Energy, gradient and (nearly exact) Hessian.
    fn slopes(&self, place: &[f64]) -> Slopes<Self::Curvature> {
        let balls = self.azimuths.len();
        let force = spindle_force(self.mechanism);
        let (spindle, [about_y, about_z]) = self.spindle(place);
        let tilt = Tilt::new(about_y, about_z);
        let [x, y, z, moment_y, moment_z] = force;
        let turned = self.mechanism.pitch_radius * (moment_y * about_y + moment_z * about_z);
        let mut value = -dot([x, y, z], spindle) - turned;
        let mut hessian = Bordered::zeros(balls, self.free.len());
        let mut gradient = vec![0.0; place.len()];
        let (of_balls, of_spindle) = gradient.split_at_mut(2 * balls);
        for (slope, &direction) in of_spindle.iter_mut().zip(self.free) {
            *slope -= force[direction];
        }
        for (ball, of_ball) in of_balls.chunks_exact_mut(2).enumerate() {
            let radial = place[2 * ball + 1];
            let (body, spring) = self.body_force(ball, self.mechanism.pitch_radius);
            let touches = self.touches(place, ball);
            value += touches.inner.energy + touches.outer.energy - (body + 0.5 * spring * radial) * radial;
            of_ball[1] -= self.body_force(ball, self.mechanism.pitch_radius + radial).0;
            let block = &mut hessian.blocks[ball];
            block.diagonal[1] -= spring;
            for touch in [&touches.inner, &touches.outer].into_iter().filter(|touch| touch.load != 0.0) {
                let ([axial, outwards, _], [across_axial, across_outwards, _]) = (touch.towards, touch.across);
                of_ball[0] += touch.load * axial;
                of_ball[1] += touch.load * outwards;
                block.diagonal[0] += touch.stiffness((axial, across_axial), (axial, across_axial));
                block.between += touch.stiffness((outwards, across_outwards), (axial, across_axial));
                block.diagonal[1] += touch.stiffness((outwards, across_outwards), (outwards, across_outwards));
            }
            let touch = touches.inner;
            if touch.load != 0.0 {
                let azimuth = self.azimuths[ball];
                let (towards, across) = (azimuth.to_inertial(touch.towards), azimuth.to_inertial(touch.across));
                let carried = self.carried(&tilt, azimuth.to_inertial(touch.lever));
                let moved =
                    |row: usize| (-dot(carried[self.free[row]], towards), -dot(carried[self.free[row]], across));
                for (row, slope) in of_spindle.iter_mut().enumerate() {
                    *slope += touch.load * moved(row).0;
                    for column in 0..2 {
                        let of_column = (touch.towards[column], touch.across[column]);
                        block.border[column][row] += touch.stiffness(moved(row), of_column);
                    }
                    for column in 0..=row {
                        hessian.border[row][column] += touch.stiffness(moved(row), moved(column));
                    }
                }
            }
            if self.mechanism.layout.planar {
                block.diagonal[0] += 1.0;
            }
        }
        Slopes { value, gradient, without_potential: Vec::new(), hessian }
    }
}

impl Touch {
    /// Stiffness [N/m] between two unknowns, each with the shares of its motion towards the contact and across it.
    fn stiffness(&self, row: (f64, f64), column: (f64, f64)) -> f64 {
        self.slope * row.0 * column.0 + self.turning * row.1 * column.1
    }
}
