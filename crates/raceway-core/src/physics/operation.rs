//! Speeds, loads and misalignment of the bearing.

use std::array::from_fn;
use std::f64::consts::TAU;

use super::frames::{Azimuth, Vector, scale};
use super::kinematics::RingSpeeds;
use super::limits::{Faults, InvalidParameter, MOST_POINTS, SHORTEST_RAMP};
use super::loads::{
    Load, LoadDirection, MOST_LOADS, SpindleLoad, VaryingLoads, end_of_transients, start_and_largest_change,
};
use crate::numerics::random::SplitMix64;

/// Spindle speed over time: constant, or straight lines between points, constant outside them.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedProfile {
    /// (time [s], angular speed [rad/s]), times strictly rising, at least one point.
    points: Vec<(f64, f64)>,
    /// Angle turned at each point since the first [rad].
    angles: Vec<f64>,
    /// Angle at time 0 since the first point [rad].
    first_angle: f64,
}

impl SpeedProfile {
    /// A constant angular speed [rad/s]; negative turns the other way.
    pub fn constant(speed: f64) -> Result<Self, Vec<InvalidParameter>> {
        Self::new(vec![(0.0, speed)])
    }

    /// Speed 0.
    pub fn at_rest() -> Self {
        Self::of_points(vec![(0.0, 0.0)])
    }

    /// Straight lines between points of (time [s], angular speed [rad/s]).
    pub fn new(points: Vec<(f64, f64)>) -> Result<Self, Vec<InvalidParameter>> {
        let mut faults = Faults::default();
        let mut refuse = |reason: String| faults.inconsistent("operation.speed", reason);
        if points.is_empty() {
            refuse("needs at least one point".into());
        } else if points.len() > MOST_POINTS {
            refuse(format!("{} points; at most {MOST_POINTS}", points.len()));
        }
        if let Some(pair) = points.windows(2).find(|pair| pair[1].0 < pair[0].0 + SHORTEST_RAMP) {
            refuse(format!("times must rise by at least 1 ns: {} s is followed by {} s", pair[0].0, pair[1].0));
        }
        for &(time, speed) in points.iter().take(MOST_POINTS) {
            faults.check("operation.speed", speed);
            faults.check("operation.speed.at", time);
        }
        faults.or(|| Self::of_points(points))
    }

    /// Profile of checked points.
    fn of_points(points: Vec<(f64, f64)>) -> Self {
        let mut angles = vec![0.0];
        for pair in points.windows(2) {
            let turned = 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0);
            angles.push(angles[angles.len() - 1] + turned);
        }
        let mut profile = Self { points, angles, first_angle: 0.0 };
        profile.first_angle = profile.since_first_point(0.0).0;
        profile
    }

    /// The profile of a run that ends at a time [s]: later points do not count.
    pub fn until(&self, end: f64) -> Self {
        if self.end() <= end {
            return self.clone();
        }
        let before = self.points.iter().filter(|point| point.0 < end - SHORTEST_RAMP);
        let points: Vec<_> = before.copied().chain([(end, self.at(end).1)]).collect();
        match points.iter().all(|point| point.1 == points[0].1) {
            true => Self::of_points(vec![(0.0, points[0].1)]),
            false => Self::of_points(points),
        }
    }

    /// Angle turned since time 0 [rad], angular speed [rad/s] and angular acceleration [rad/s²].
    #[inline(always)]
    pub fn at(&self, time: f64) -> (f64, f64, f64) {
        let (angle, speed, acceleration) = self.since_first_point(time);
        (angle - self.first_angle, speed, acceleration)
    }

    #[inline(always)]
    fn since_first_point(&self, time: f64) -> (f64, f64, f64) {
        match self.points[..] {
            [(at, speed)] => (speed * (time - at), speed, 0.0),
            _ => self.along_points(time),
        }
    }

    /// The same for several points.
    fn along_points(&self, time: f64) -> (f64, f64, f64) {
        // At a kink the slope before it counts; a run begins with the slope after it.
        let next = self.points.partition_point(|&(at, _)| at < time || at <= 0.0);
        if next == 0 {
            let (at, speed) = self.points[0];
            return (speed * (time - at), speed, 0.0);
        }
        let (at, speed) = self.points[next - 1];
        let elapsed = time - at;
        let slope = self.points.get(next).map_or(0.0, |&(end, end_speed)| (end_speed - speed) / (end - at));
        (self.angles[next - 1] + (speed + 0.5 * slope * elapsed) * elapsed, speed + slope * elapsed, slope)
    }

    /// The rotation at a time [s].
    #[inline(always)]
    pub fn turn(&self, time: f64) -> Turn {
        let (angle, speed, acceleration) = self.at(time);
        Turn { angle, speed, acceleration }
    }

    /// Times after 0 at which the angular acceleration jumps [s]. Those closer to 0 than a ramp may be count as 0.
    pub fn kinks(&self) -> impl Iterator<Item = f64> + '_ {
        let several = self.points.len() > 1;
        self.points.iter().map(|point| point.0).filter(move |&at| several && at >= SHORTEST_RAMP)
    }

    /// Time of the last point [s].
    pub fn end(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.0)
    }

    /// Largest |speed| over all time [rad/s].
    pub fn largest(&self) -> f64 {
        self.points.iter().fold(0.0, |most, point| most.max(point.1.abs()))
    }

    /// True if the speed has both signs, so that its mean says nothing about rolling.
    pub fn reverses(&self) -> bool {
        let has = |sign: f64| self.points.iter().any(|point| sign * point.1 > 0.0);
        has(1.0) && has(-1.0)
    }

    /// True when the speed never changes.
    pub fn is_constant(&self) -> bool {
        self.points.iter().all(|point| point.1 == self.points[0].1)
    }

    /// The points (time [s], angular speed [rad/s]) as given.
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }
}

/// Angle turned since time 0 [rad], angular speed [rad/s] and angular acceleration [rad/s²] of a rotation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Turn {
    pub angle: f64,
    pub speed: f64,
    pub acceleration: f64,
}

impl Turn {
    /// Rotation of a body that turns with this one and, relative to it, with a ratio of the rotation of `other` relative to it.
    #[inline(always)]
    pub fn carried(self, ratio: f64, other: Self) -> Self {
        Self {
            angle: self.angle + ratio * (other.angle - self.angle),
            speed: self.speed + ratio * (other.speed - self.speed),
            acceleration: self.acceleration + ratio * (other.acceleration - self.acceleration),
        }
    }
}

/// Rotation of both rings over time.
#[derive(Debug, Clone, PartialEq)]
pub struct RingRotation {
    /// Of the inner ring, which turns with the shaft.
    pub inner: SpeedProfile,
    pub outer: SpeedProfile,
}

impl RingRotation {
    /// Rotations of inner and outer ring at a time [s].
    #[inline(always)]
    pub fn at(&self, time: f64) -> (Turn, Turn) {
        (self.inner.turn(time), self.outer.turn(time))
    }

    /// Speeds at a time [s], in rad/s.
    pub fn speeds(&self, time: f64) -> RingSpeeds {
        RingSpeeds { inner: self.inner.at(time).1, outer: self.outer.at(time).1 }
    }

    pub fn is_constant(&self) -> bool {
        self.inner.is_constant() && self.outer.is_constant()
    }

    /// True where the outer ring never turns.
    pub fn outer_stands(&self) -> bool {
        self.outer.largest() == 0.0
    }

    /// Times after 0 at which an angular acceleration jumps [s].
    pub fn kinks(&self) -> impl Iterator<Item = f64> + '_ {
        self.inner.kinks().chain(self.outer.kinks())
    }

    /// Speeds at each point of both profiles [rad/s]. Between them all speeds are linear.
    fn corners(&self) -> impl Iterator<Item = RingSpeeds> + '_ {
        let of_inner = self.inner.points.iter().map(|&(at, inner)| RingSpeeds { inner, outer: self.outer.at(at).1 });
        let of_outer = self.outer.points.iter().map(|&(at, outer)| RingSpeeds { inner: self.inner.at(at).1, outer });
        of_inner.chain(of_outer)
    }

    /// Speeds at which the rings turn fastest relative to each other [rad/s]. A shaft that turns backwards is seen from its other side.
    pub fn operating(&self) -> RingSpeeds {
        let size = |speeds: &RingSpeeds| (speeds.relative().abs(), speeds.outer.abs());
        let fastest = self.corners().fold(RingSpeeds::default(), |most, one| match size(&one) > size(&most) {
            true => one,
            false => most,
        });
        fastest.forward()
    }

    /// True if the relative speed has both signs, so that its mean says nothing about rolling.
    pub fn reverses(&self) -> bool {
        let has = |sign: f64| self.corners().any(|speeds| sign * speeds.relative() > 0.0);
        has(1.0) && has(-1.0)
    }
}

/// Initial velocities of balls and cage in random directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialPerturbation {
    /// Magnitude of each velocity [m/s].
    pub speed: f64,
    /// Seed of the directions.
    pub seed: u64,
}

impl InitialPerturbation {
    /// Velocities of as many bodies as are taken [m/s], one after the other; each direction is equally likely.
    pub(crate) fn velocities(&self) -> impl Iterator<Item = Vector> {
        let (speed, mut random) = (self.speed, SplitMix64::new(self.seed));
        std::iter::repeat_with(move || {
            // A slice of a sphere has an area in proportion to its thickness.
            let along = 2.0 * random.uniform() - 1.0;
            let Azimuth { cosine, sine } = Azimuth::new(TAU * random.uniform());
            let across = (1.0 - along * along).sqrt();
            scale(speed, [along, across * cosine, across * sine])
        })
    }
}

/// Speed, loads, misalignment and initial perturbation.
#[derive(Debug, Clone, PartialEq)]
pub struct Operation {
    /// Speed of the inner ring, with the spindle.
    pub speed: SpeedProfile,
    /// Speed of the outer ring about its axis.
    pub outer_speed: SpeedProfile,
    /// Constant load on the spindle along X, Y, Z [N].
    pub load: [f64; 3],
    /// Loads beside it.
    pub loads: Vec<Load>,
    /// Imposed tilt of the spindle about Y and about Z [rad].
    pub misalignment: [f64; 2],
    /// `None`, or with a speed of 0: a run starts from equilibrium.
    pub perturbation: Option<InitialPerturbation>,
}

impl Operation {
    /// The operation of a run that ends at a time [s]: later points of speeds and loads do not count.
    pub fn until(&self, end: f64) -> Self {
        Self {
            speed: self.speed.until(end),
            outer_speed: self.outer_speed.until(end),
            loads: self.loads.iter().map(|load| load.until(end)).collect(),
            ..self.clone()
        }
    }

    /// Records loads and tilts outside the limits.
    pub(crate) fn check(&self, faults: &mut Faults) {
        faults.check("operation.axial_load", self.load[0]);
        faults.check("operation.radial_load_y", self.load[1]);
        faults.check("operation.radial_load_z", self.load[2]);
        if self.loads.len() > MOST_LOADS {
            faults.inconsistent("operation.loads", format!("{} loads; at most {MOST_LOADS}", self.loads.len()));
        }
        for (place, load) in self.loads.iter().enumerate().take(MOST_LOADS) {
            load.check(place, self.speed.largest(), faults);
        }
        faults.check("operation.misalignment.y", self.misalignment[0]);
        faults.check("operation.misalignment.z", self.misalignment[1]);
        if let Some(perturbation) = self.perturbation {
            faults.check("operation.initial_perturbation.speed", perturbation.speed);
        }
    }

    /// Loads at the start: forces along X, Y, Z [N], moments about Y and the new Z [N m]. Harmonic loads count with their mean.
    pub fn start_load(&self) -> SpindleLoad {
        let [x, y, z] = self.load;
        let (start, _) = start_and_largest_change(&self.loads);
        from_fn(|axis| [x, y, z, 0.0, 0.0][axis] + start[axis])
    }

    /// Largest differences of the loads from those at the start, in the order of `start_load`.
    pub fn largest_change(&self) -> SpindleLoad {
        start_and_largest_change(&self.loads).1
    }

    /// Largest magnitudes of the loads, in the order of `start_load`.
    pub fn largest_load(&self) -> SpindleLoad {
        let (start, change) = (self.start_load(), self.largest_change());
        from_fn(|axis| start[axis].abs() + change[axis])
    }

    /// Returns true where a load acts along X.
    pub fn acts_along_x(&self) -> bool {
        self.load[0] != 0.0 || self.loads.iter().any(|load| load.direction() == Some(LoadDirection::X))
    }

    /// Changes of the loads since the start; `None`: they are constant.
    pub fn varying_loads(&self) -> Option<VaryingLoads> {
        VaryingLoads::of(&self.loads, self.speed.largest())
    }

    /// Rotation of both rings.
    pub fn rotation(&self) -> RingRotation {
        RingRotation { inner: self.speed.clone(), outer: self.outer_speed.clone() }
    }

    /// True where no speed ever changes.
    pub fn has_constant_speeds(&self) -> bool {
        self.speed.is_constant() && self.outer_speed.is_constant()
    }

    /// True where neither speeds nor loads change but periodically, so that a part of the time can stand for all of it.
    pub fn is_steady(&self) -> bool {
        self.has_constant_speeds() && end_of_transients(&self.loads).is_none()
    }

    /// Time of the last change of loads that are neither constant nor periodic [s]; `None`: there are none.
    pub fn end_of_load_changes(&self) -> Option<f64> {
        end_of_transients(&self.loads)
    }

    /// Frequencies of the harmonic loads at a speed of the spindle [rad/s], each above 0 [Hz].
    pub fn load_frequencies(&self, speed: f64) -> impl Iterator<Item = f64> + '_ {
        let harmonics = self.loads.iter().filter_map(Load::harmonic).filter(|harmonic| harmonic.amplitude != 0.0);
        harmonics.map(move |harmonic| harmonic.frequency(speed)).filter(|frequency| *frequency > 0.0)
    }

    /// Period of the slowest harmonic load at the largest speed [s]; 0 without one.
    pub fn longest_load_period(&self) -> f64 {
        self.load_frequencies(self.speed.largest()).map(|frequency| 1.0 / frequency).fold(0.0, f64::max)
    }

    /// Perturbation of the start; `None` where it is 0.
    pub(crate) fn start_perturbation(&self) -> Option<InitialPerturbation> {
        self.perturbation.filter(|perturbation| perturbation.speed != 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::frames::dot;

    /// The angle is the integral of the speed: 0 → 10 rad/s within 2 s turns 10 rad, then 10 rad/s.
    #[test]
    fn angle_is_the_integral_of_the_speed() {
        let ramp = SpeedProfile::new(vec![(1.0, 0.0), (3.0, 10.0)]).unwrap();
        assert_eq!(ramp.at(0.5), (0.0, 0.0, 0.0));
        assert_eq!(ramp.at(2.0), (2.5, 5.0, 5.0));
        assert_eq!(ramp.at(4.0), (20.0, 10.0, 0.0));
        assert_eq!(ramp.kinks().collect::<Vec<_>>(), [1.0, 3.0]);
    }

    /// Points after the end of a run do not count: neither a faster speed nor a change. Up to the end the motion is the same.
    #[test]
    fn a_profile_ends_with_its_run() {
        let profile = SpeedProfile::new(vec![(1.0, 2.0), (3.0, 10.0), (5.0, 90.0)]).unwrap();
        let cut = profile.until(4.0);
        assert_eq!((cut.largest(), cut.end()), (50.0, 4.0));
        for time in [0.0, 0.5, 1.0, 2.5, 3.5, 4.0] {
            assert_eq!(cut.at(time), profile.at(time), "{time} s");
        }
        assert_eq!(profile.until(5.0), profile);
        let steady = SpeedProfile::new(vec![(100.0, 2.0), (200.0, 6.0)]).unwrap().until(0.5);
        assert!(steady.is_constant() && steady.at(0.25) == (0.5, 2.0, 0.0), "{steady:?}");
    }

    /// A change nearer to the start than a ramp may be is one at the start.
    #[test]
    fn no_kink_is_nearer_to_the_start_than_a_ramp() {
        let profile = SpeedProfile::new(vec![(5e-324, 2.0), (1.0, 3.0)]).unwrap();
        assert_eq!(profile.kinks().collect::<Vec<_>>(), [1.0]);
    }

    /// Rings that turn against each other turn fastest relative to each other at a point of either profile.
    #[test]
    fn operating_speeds_are_those_of_the_fastest_rolling() {
        let ramp = |points: &[(f64, f64)]| SpeedProfile::new(points.to_vec()).unwrap();
        let rotation = RingRotation { inner: ramp(&[(0.0, 5.0), (4.0, 9.0)]), outer: ramp(&[(1.0, -8.0), (2.0, 8.0)]) };
        assert_eq!(rotation.operating(), RingSpeeds { inner: 6.0, outer: -8.0 });
        assert!(rotation.reverses() && !rotation.is_constant() && !rotation.outer_stands());
        let back = RingRotation { inner: ramp(&[(0.0, -3.0)]), outer: SpeedProfile::at_rest() };
        assert_eq!(back.operating(), RingSpeeds { inner: 3.0, outer: 0.0 });
    }

    /// The mean of many velocities vanishes and each component has a third of the square: all directions are equally likely.
    #[test]
    fn velocities_have_one_magnitude_and_any_direction() {
        let all: Vec<Vector> = InitialPerturbation { speed: 2.0, seed: 7 }.velocities().take(30_000).collect();
        assert!(all.iter().all(|v| (dot(*v, *v) - 4.0).abs() < 1e-12));
        for axis in 0..3 {
            let mean = |of: fn(f64) -> f64| all.iter().map(|v| of(v[axis])).sum::<f64>() / all.len() as f64;
            assert!(mean(|x| x).abs() < 0.03 && (mean(|x| x * x) - 4.0 / 3.0).abs() < 0.03);
        }
        let other = InitialPerturbation { speed: 2.0, seed: 8 }.velocities().next();
        assert_ne!(Some(all[0]), other);
    }

    #[test]
    fn times_that_do_not_rise_are_refused() {
        assert!(SpeedProfile::new(vec![(1.0, 0.0), (1.0, 10.0)]).is_err());
        assert!(SpeedProfile::new(vec![]).is_err());
        assert!(SpeedProfile::constant(f64::NAN).is_err());
    }
}
