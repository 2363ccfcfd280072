//! One ball between both rings: its potential by its own place and by the pose of the inner ring.

use std::array::from_fn;
use std::f64::consts::TAU;

use super::groove::{Groove, InGroove};
use super::rolling::Rolling;
use crate::physics::bearing::{Bearing, BearingKind, PerRaceway, SpindlePlay};
use crate::physics::contact::damping::{DampingFactor, normal_slopes};
use crate::physics::contact::hertz::{HertzContact, raceway_contacts};
use crate::physics::frames::{Azimuth, Tilt, Vector, add, dot, scale, subtract};
use crate::physics::kinematics::RingSpeeds;

/// Number of freedoms of a ring: x, y, z, β_y, β_z.
pub(super) const FREEDOMS: usize = 5;
/// Freedoms of a ball, along the axis and the radius.
pub(crate) const OF_BALL: usize = 2;
pub(super) const UNKNOWNS: usize = OF_BALL + FREEDOMS;
/// Places in a ball spacing that are averaged.
const PLACES: usize = 8;

/// Pose of a ring [m, m, m, rad, rad].
pub type Pose = [f64; FREEDOMS];
/// Forces and moments along the freedoms of a ring [N, N, N, N m, N m].
pub type Wrench = [f64; FREEDOMS];
/// A stiffness [N/m, N, N m] or a damping [N s/m, N s, N m s] by the freedoms of a ring, row by row.
pub type Matrix = [[f64; FREEDOMS]; FREEDOMS];

/// Constants of a bearing at rest.
#[derive(Debug, Clone)]
pub struct RingBearing {
    inner: Groove,
    outer: Groove,
    pub(super) balls: usize,
    /// Places in a ball spacing that are averaged.
    pub(super) places: usize,
    pub(super) pitch_radius: f64,
    pub(super) rolling: Rolling,
    /// Speed of the outer ring [rad/s].
    outer_speed: f64,
    axial_play: f64,
    play: SpindlePlay,
    /// Thrust along −X finds no shoulder.
    pub(super) has_open_side: bool,
}

/// One contact of a ball.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    /// [N]
    pub(super) load: f64,
    penetration: f64,
    hertz_stiffness: f64,
    /// Change of the penetration with the ball's place and with the pose of the ring.
    pub(super) towards: [f64; UNKNOWNS],
}

/// The potential of a ball's contacts with its derivatives by the ball's place and the pose of the inner ring.
#[derive(Debug, Clone, Copy)]
pub(super) struct BallSlopes {
    /// [J]
    pub(super) energy: f64,
    pub(super) gradient: [f64; UNKNOWNS],
    /// Lower triangle.
    pub(super) hessian: [[f64; UNKNOWNS]; UNKNOWNS],
    pub(super) touch: PerRaceway<Touch>,
}

/// Axial and radial place of a ball relative to a ring, with derivatives by the unknowns.
pub(super) struct Meridian {
    pub(super) axial: f64,
    pub(super) radius: f64,
    pub(super) by: [(f64, f64); UNKNOWNS],
    /// Lower triangle of second derivatives.
    pub(super) bend: [[(f64, f64); UNKNOWNS]; UNKNOWNS],
}

/// A ball at an azimuth, seen from both rings.
pub(super) struct Placed {
    pub(super) azimuth: Azimuth,
    pub(super) meridian: PerRaceway<Meridian>,
}

/// The axis of a tilted ring, with its first and second derivatives by β_y and β_z, in the inertial frame.
pub(super) struct Axis {
    along: Vector,
    by: [Vector; 2],
    /// Second derivatives: by β_y twice, by both angles, by β_z twice.
    bend: [Vector; 3],
}

impl Axis {
    pub(super) fn new(pose: &Pose) -> Self {
        let [along, to_y, _] = Tilt::new(pose[3], pose[4]).columns;
        let (sine_y, cosine_y) = pose[3].sin_cos();
        let (sine_z, cosine_z) = pose[4].sin_cos();
        Self {
            along,
            by: [[-sine_y * cosine_z, 0.0, -cosine_y * cosine_z], to_y],
            bend: [
                [-cosine_y * cosine_z, 0.0, sine_y * cosine_z],
                [sine_y * sine_z, 0.0, cosine_y * sine_z],
                scale(-1.0, along),
            ],
        }
    }

    fn to_orbit(&self, azimuth: Azimuth) -> Self {
        let turned = |v: &Vector| azimuth.to_orbit(*v);
        Self { along: turned(&self.along), by: self.by.each_ref().map(turned), bend: self.bend.each_ref().map(turned) }
    }
}

impl Meridian {
    /// Relative to the outer ring, for a ball at an axial and a radial place [m].
    fn of_outer(axial: f64, radius: f64) -> Self {
        let mut by = [(0.0, 0.0); UNKNOWNS];
        (by[0].0, by[1].1) = (1.0, 1.0);
        Self { axial, radius, by, bend: [[(0.0, 0.0); UNKNOWNS]; UNKNOWNS] }
    }

    /// Relative to the inner ring. Vectors in the orbit frame; `from_centre`: from the ring's centre to the ball.
    fn of_inner(from_centre: Vector, azimuth: Azimuth, axis: &Axis) -> Self {
        let Axis { along, by, bend } = axis.to_orbit(azimuth);
        let axial = dot(from_centre, along);
        let radial = subtract(from_centre, scale(axial, along));
        let radius = dot(radial, radial).sqrt();
        let unit = |k: usize| -> Vector { from_fn(|other| if other == k { 1.0 } else { 0.0 }) };
        let ring = |k: usize| scale(-1.0, azimuth.to_orbit(unit(k)));
        let none = [0.0; 3];
        // Changes of `from_centre` and of the axis by each unknown.
        let moves = [unit(0), unit(1), ring(0), ring(1), ring(2), none, none];
        let turns = [none, none, none, none, none, by[0], by[1]];
        let axial_by: [f64; UNKNOWNS] = from_fn(|i| dot(moves[i], along) + dot(from_centre, turns[i]));
        let radius_by: [f64; UNKNOWNS] = from_fn(|i| (dot(from_centre, moves[i]) - axial * axial_by[i]) / radius);
        let second = |i: usize, j: usize| {
            let of_axis = if j < OF_BALL + 3 { 0.0 } else { dot(from_centre, bend[i + j - 2 * (OF_BALL + 3)]) };
            let axial_bend = dot(moves[i], turns[j]) + dot(moves[j], turns[i]) + of_axis;
            let squares = dot(moves[i], moves[j]) - axial_by[i] * axial_by[j] - radius_by[i] * radius_by[j];
            (axial_bend, (squares - axial * axial_bend) / radius)
        };
        let mut bends = [[(0.0, 0.0); UNKNOWNS]; UNKNOWNS];
        for (i, row) in bends.iter_mut().enumerate() {
            for (j, entry) in row[..=i].iter_mut().enumerate() {
                *entry = second(i, j);
            }
        }
        Self { axial, radius, by: from_fn(|i| (axial_by[i], radius_by[i])), bend: bends }
    }
}

impl RingBearing {
    pub fn new(bearing: &Bearing) -> Self {
        let (parameters, hertz, centre) =
            (&bearing.parameters, raceway_contacts(bearing), bearing.groove_centre_radius);
        let diameter = parameters.ball_diameter;
        let groove = |side: f64, hertz: HertzContact, centre_radius: f64, curvature: f64| Groove {
            side,
            centre_radius,
            touch_distance: (curvature - 0.5) * diameter,
            hertz,
        };
        Self {
            inner: groove(-1.0, hertz.inner, centre.inner, parameters.groove_curvature.inner),
            outer: groove(1.0, hertz.outer, centre.outer, parameters.groove_curvature.outer),
            balls: parameters.ball_count,
            places: PLACES,
            pitch_radius: 0.5 * parameters.pitch_diameter,
            rolling: Rolling::new(bearing),
            outer_speed: 0.0,
            axial_play: bearing.groove_centre_distance * bearing.free_contact_angle.sin(),
            play: bearing.largest_displacement(),
            has_open_side: parameters.kind == BearingKind::AngularContact,
        }
    }

    /// The bearing with an outer ring that turns at a speed [rad/s].
    pub fn with_outer_speed(self, outer_speed: f64) -> Self {
        Self { outer_speed, ..self }
    }

    /// Speed of the outer ring [rad/s].
    pub fn outer_speed(&self) -> f64 {
        self.outer_speed
    }

    /// Axial displacement of the centred inner ring at which a thrust first meets the balls, A sin α₀ [m].
    pub fn axial_play(&self) -> f64 {
        self.axial_play
    }

    /// Largest displacement of the inner ring at which a ball may still hold it [m].
    pub(crate) fn play(&self) -> SpindlePlay {
        self.play
    }

    pub(crate) fn pitch_radius(&self) -> f64 {
        self.pitch_radius
    }

    /// Number of balls at all places.
    pub(crate) fn entries(&self) -> usize {
        self.places * self.balls
    }

    /// Share of one place [-].
    pub(super) fn share(&self) -> f64 {
        1.0 / self.places as f64
    }

    /// Azimuth of a ball; the balls of one place after those of another, the first one beyond +Y by a share of the ball spacing.
    pub(super) fn azimuth(&self, index: usize) -> Azimuth {
        let beyond = (index / self.balls) as f64 * self.share();
        Azimuth::new(TAU * ((index % self.balls) as f64 + beyond) / self.balls as f64)
    }

    /// Speeds of both rings at a speed of the inner one [rad/s].
    pub(super) fn speeds(&self, speed: f64) -> RingSpeeds {
        RingSpeeds { inner: speed, outer: self.outer_speed }
    }

    /// Penetration under a load over the ball's radius, the larger of both raceways [-].
    pub(super) fn relative_depth(&self, load: f64) -> f64 {
        let softest = self.inner.hertz.stiffness.min(self.outer.hertz.stiffness);
        (load / softest).powf(2.0 / 3.0) / self.rolling.ball_radius
    }

    /// Place of a ball [m], axial and radius less the pitch radius, on the line between both grooves' centres.
    pub(super) fn between_grooves(&self, azimuth: Azimuth, pose: &Pose) -> [f64; OF_BALL] {
        let axis = azimuth.to_orbit(Axis::new(pose).along);
        let centre = azimuth.to_orbit([pose[0], pose[1], pose[2]]);
        // The circle of the inner groove's centres leans with the axis.
        let inner = add(centre, scale(self.inner.centre_radius, [-axis[1], axis[0], 0.0]));
        let share = self.outer.touch_distance / (self.outer.touch_distance + self.inner.touch_distance);
        let radius = self.outer.centre_radius + share * (inner[1] - self.outer.centre_radius);
        [share * inner[0], radius - self.pitch_radius]
    }

    /// A ball at a place [m], axial and radial less the pitch radius.
    pub(super) fn placed(&self, azimuth: Azimuth, axis: &Axis, pose: &Pose, [axial, radial]: [f64; OF_BALL]) -> Placed {
        let radius = self.pitch_radius + radial;
        let centre = azimuth.to_orbit([pose[0], pose[1], pose[2]]);
        let from_centre = subtract([axial, radius, 0.0], centre);
        let inner = Meridian::of_inner(from_centre, azimuth, axis);
        Placed { azimuth, meridian: PerRaceway { inner, outer: Meridian::of_outer(axial, radius) } }
    }

    /// The grooves.
    pub(super) fn grooves(&self) -> PerRaceway<&Groove> {
        PerRaceway { inner: &self.inner, outer: &self.outer }
    }

    /// Potential of the contacts of a ball.
    pub(super) fn contacts(&self, ball: &Placed) -> BallSlopes {
        let mut slopes = BallSlopes {
            energy: 0.0,
            gradient: [0.0; UNKNOWNS],
            hessian: [[0.0; UNKNOWNS]; UNKNOWNS],
            touch: PerRaceway { inner: Touch::NONE, outer: Touch::NONE },
        };
        let PerRaceway { inner, outer } = &ball.meridian;
        slopes.touch.outer = slopes.add(&self.outer, outer);
        slopes.touch.inner = slopes.add(&self.inner, inner);
        slopes
    }
}

impl BallSlopes {
    /// Adds a contact: Q δ_i to the gradient, Q' δ_i δ_j + Q δ_ij to the Hessian.
    fn add(&mut self, groove: &Groove, at: &Meridian) -> Touch {
        let InGroove { distance, penetration, load, direction: (sine, cosine) } = groove.at(at.axial, at.radius);
        if load == 0.0 {
            return Touch::NONE;
        }
        let slope = 1.5 * groove.hertz.stiffness * penetration.sqrt();
        let towards = at.by.map(|(axial, radius)| sine * axial + cosine * radius);
        let across = at.by.map(|(axial, radius)| cosine * axial - sine * radius);
        self.energy += 0.4 * load * penetration;
        for i in 0..UNKNOWNS {
            self.gradient[i] += load * towards[i];
            for j in 0..=i {
                let (axial, radius) = at.bend[i][j];
                let bend = across[i] * across[j] / distance + sine * axial + cosine * radius;
                self.hessian[i][j] += slope * towards[i] * towards[j] + load * bend;
            }
        }
        Touch { load, penetration, hertz_stiffness: groove.hertz.stiffness, towards }
    }
}

impl Touch {
    const NONE: Self = Self { load: 0.0, penetration: 0.0, hertz_stiffness: 0.0, towards: [0.0; UNKNOWNS] };

    /// Force against the rate of penetration at rest [N s/m].
    pub(super) fn damping(&self, damping: &DampingFactor) -> f64 {
        normal_slopes(self.hertz_stiffness, self.penetration, 0.0, damping).1
    }
}
