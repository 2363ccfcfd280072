//! Names for the entries of `y`. No bare index into a state exists outside this file.
//!
//! Balls come first, one block each, then the cage, then the spindle (balls couple to cage and spindle, so a Jacobian is
//! bordered block-diagonal; contacts of neighbouring balls, where there is no cage, stand outside its blocks). All entries are deviations from ideal rolling, so that a
//! tolerance means the same early and late in a run. Inside SI; arcs are angles times the pitch radius.

use crate::numerics::lanes::{LANES, Lanes, SideBySide, side_by_side};
use crate::numerics::ode::Tolerances;
use crate::numerics::ode::structure::Structure;
use crate::physics::frames::Vector;

/// Deviations of one ball, or their rates.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallState<T = f64> {
    /// Along X [m].
    pub axial: T,
    /// Radial position less the pitch radius [m].
    pub radial: T,
    /// Along the orbit, less the ideal orbit [m].
    pub arc: T,
    pub axial_velocity: T,
    pub radial_velocity: T,
    /// Rate of `arc` [m/s].
    pub arc_velocity: T,
    /// Angular velocity in the orbit frame, less the ideal spin about X [rad/s].
    pub spin: Vector<T>,
}
side_by_side!(BallState { axial, radial, arc, axial_velocity, radial_velocity, arc_velocity, spin });

impl<T: Copy + Default> BallState<T> {
    /// Entries in the order of the state; planar states use the first five.
    #[inline(always)]
    pub fn entries(&self, planar: bool) -> [T; 9] {
        let Self { axial, radial, arc, axial_velocity, radial_velocity, arc_velocity, spin: [x, r, t] } = *self;
        if planar {
            let none = T::default();
            [radial, arc, radial_velocity, arc_velocity, x, none, none, none, none]
        } else {
            [axial, radial, arc, axial_velocity, radial_velocity, arc_velocity, x, r, t]
        }
    }

    /// State from entries in that order.
    #[inline(always)]
    pub(crate) fn from_entries(entries: [T; 9], planar: bool) -> Self {
        if planar {
            let [radial, arc, radial_velocity, arc_velocity, spin, ..] = entries;
            let none = T::default();
            Self {
                axial: none,
                radial,
                arc,
                axial_velocity: none,
                radial_velocity,
                arc_velocity,
                spin: [spin, none, none],
            }
        } else {
            let [axial, radial, arc, axial_velocity, radial_velocity, arc_velocity, x, r, t] = entries;
            Self { axial, radial, arc, axial_velocity, radial_velocity, arc_velocity, spin: [x, r, t] }
        }
    }
}

impl BallState {
    /// `a · self + b · other`.
    #[inline(always)]
    pub(crate) fn combined(&self, a: f64, other: &Self, b: f64) -> Self {
        let both = |one: f64, other: f64| a * one + b * other;
        Self {
            axial: both(self.axial, other.axial),
            radial: both(self.radial, other.radial),
            arc: both(self.arc, other.arc),
            axial_velocity: both(self.axial_velocity, other.axial_velocity),
            radial_velocity: both(self.radial_velocity, other.radial_velocity),
            arc_velocity: both(self.arc_velocity, other.arc_velocity),
            spin: std::array::from_fn(|i| both(self.spin[i], other.spin[i])),
        }
    }
}

/// Deviation of a ball's attitude from that of ideal rolling, or its rates. In the plane the first entry is the angle about X [rad]. Else
/// the four are a rotation of the ball as it was at the start, as a quaternion less 1; they are normalised where they are used.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallAttitude<T = f64>(pub [T; 4]);

impl<const N: usize> SideBySide for BallAttitude<Lanes<N>> {
    type One = BallAttitude;

    #[inline(always)]
    fn at(&self, lane: usize) -> BallAttitude {
        BallAttitude(self.0.at(lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: BallAttitude) {
        self.0.put(lane, one.0);
    }
}

impl BallAttitude {
    /// `a · self + b · other`.
    pub(crate) fn combined(&self, a: f64, other: &Self, b: f64) -> Self {
        Self(std::array::from_fn(|i| a * self.0[i] + b * other.0[i]))
    }
}

/// Deviations of the cage, or their rates.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CageState {
    /// Centre of mass less its place when all pockets are centred on ideal balls [m].
    pub centre: Vector,
    /// Rotation about the cage axis, less the ideal orbit, as an arc [m].
    pub arc: f64,
    /// Tilt about Y and about the new Z [rad].
    pub tilt: [f64; 2],
    pub velocity: Vector,
    /// Angular velocity about the cage axis, less the ideal orbit's, times the pitch radius [m/s].
    pub arc_velocity: f64,
    /// Angular velocity about the tilted y and z axes [rad/s].
    pub tilt_rate: [f64; 2],
}

impl CageState {
    /// `a · self + b · other`.
    #[inline(always)]
    pub(crate) fn combined(&self, a: f64, other: &Self, b: f64) -> Self {
        let both = |one: f64, other: f64| a * one + b * other;
        Self {
            centre: std::array::from_fn(|i| both(self.centre[i], other.centre[i])),
            arc: both(self.arc, other.arc),
            tilt: std::array::from_fn(|i| both(self.tilt[i], other.tilt[i])),
            velocity: std::array::from_fn(|i| both(self.velocity[i], other.velocity[i])),
            arc_velocity: both(self.arc_velocity, other.arc_velocity),
            tilt_rate: std::array::from_fn(|i| both(self.tilt_rate[i], other.tilt_rate[i])),
        }
    }
}

/// Displacement, tilt and velocities of the spindle, or their rates.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SpindleState {
    pub position: Vector,
    pub velocity: Vector,
    /// Tilt about Y and about the new Z [rad], and its rates [rad/s].
    pub tilt: [f64; 2],
    pub tilt_rate: [f64; 2],
}

/// Layout of a state: its bodies and their degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    pub balls: usize,
    /// No axial motion, no tilt.
    pub planar: bool,
    pub cage: bool,
    /// The spindle moves along X.
    pub axial_spindle: bool,
    /// The spindle tilts.
    pub tilting_spindle: bool,
    /// Balls have an attitude, because the surface of one is not that of a sphere.
    pub attitude: bool,
}

/// Natural sizes of the entries: the allowed error of a state is the relative tolerance times these.
mod size {
    /// [m]
    pub(crate) const POSITION: f64 = 1e-6;
    /// [m]
    pub(crate) const ARC: f64 = 1e-5;
    /// [m/s]
    pub(crate) const VELOCITY: f64 = 1e-2;
    /// [m/s]
    pub(crate) const ARC_VELOCITY: f64 = 1e-1;
    /// [rad/s]
    pub(crate) const SPIN: f64 = 100.0;
    /// An arc over the radius of a ball [rad]. No entry that does not drift has this size.
    pub(crate) const ATTITUDE: f64 = 5e-3;
    /// [rad]
    pub(crate) const TILT: f64 = 1e-4;
    /// [rad/s]
    pub(crate) const TILT_RATE: f64 = 10.0;
}

const BALL_NAMES: [(&str, f64); 9] = [
    ("axial position", size::POSITION),
    ("radial position", size::POSITION),
    ("arc along the orbit", size::ARC),
    ("axial velocity", size::VELOCITY),
    ("radial velocity", size::VELOCITY),
    ("orbit velocity", size::ARC_VELOCITY),
    ("spin about x", size::SPIN),
    ("spin about the radius", size::SPIN),
    ("spin about the orbit", size::SPIN),
];
const PLANAR_BALL: [usize; 5] = [1, 2, 4, 5, 6];
const ATTITUDE_NAMES: [(&str, f64); 4] = [
    ("attitude", size::ATTITUDE),
    ("attitude about x", size::ATTITUDE),
    ("attitude about the radius", size::ATTITUDE),
    ("attitude about the orbit", size::ATTITUDE),
];
const PLANAR_ATTITUDE: [usize; 1] = [1];
const CAGE_NAMES: [(&str, f64); 12] = [
    ("x position", size::POSITION),
    ("y position", size::POSITION),
    ("z position", size::POSITION),
    ("rotation", size::ARC),
    ("tilt about y", size::TILT),
    ("tilt about z", size::TILT),
    ("x velocity", size::VELOCITY),
    ("y velocity", size::VELOCITY),
    ("z velocity", size::VELOCITY),
    ("speed", size::ARC_VELOCITY),
    ("tilt rate about y", size::TILT_RATE),
    ("tilt rate about z", size::TILT_RATE),
];
const PLANAR_CAGE: [usize; 6] = [1, 2, 3, 7, 8, 9];
/// Positions, then velocities.
const SPINDLE_NAMES: [[(&str, f64); 5]; 2] = [
    [
        ("x position", size::POSITION),
        ("y position", size::POSITION),
        ("z position", size::POSITION),
        ("tilt about y", size::TILT),
        ("tilt about z", size::TILT),
    ],
    [
        ("x velocity", size::VELOCITY),
        ("y velocity", size::VELOCITY),
        ("z velocity", size::VELOCITY),
        ("tilt rate about y", size::TILT_RATE),
        ("tilt rate about z", size::TILT_RATE),
    ],
];

/// Largest number of entries of cage and spindle.
pub(crate) const MAX_BORDER: usize = 22;

impl Layout {
    /// Number of entries of a ball's motion.
    #[inline(always)]
    pub(crate) fn motion_size(&self) -> usize {
        if self.planar { PLANAR_BALL.len() } else { BALL_NAMES.len() }
    }

    /// Number of entries of a ball's attitude.
    #[inline(always)]
    pub(crate) fn attitude_size(&self) -> usize {
        match (self.attitude, self.planar) {
            (false, _) => 0,
            (true, true) => 1,
            (true, false) => 4,
        }
    }

    /// Number of entries of a ball.
    #[inline(always)]
    pub(crate) fn ball_size(&self) -> usize {
        self.motion_size() + self.attitude_size()
    }

    /// Number of entries of the cage.
    pub(crate) fn cage_size(&self) -> usize {
        match (self.cage, self.planar) {
            (false, _) => 0,
            (true, true) => 6,
            (true, false) => 12,
        }
    }

    fn spindle_size(&self) -> usize {
        2 * self.freedoms().len()
    }

    /// Freedoms of the spindle: x, y, z, tilt about Y, tilt about Z.
    pub(crate) fn freedoms(&self) -> &'static [usize] {
        match (self.axial_spindle, self.tilting_spindle) {
            (false, false) => &[1, 2],
            (true, false) => &[0, 1, 2],
            (false, true) => &[1, 2, 3, 4],
            (true, true) => &[0, 1, 2, 3, 4],
        }
    }

    /// Layout of cage and spindle alone.
    pub(crate) fn without_balls(self) -> Self {
        Self { balls: 0, ..self }
    }

    /// Entries of cage and spindle in their order.
    #[inline(always)]
    pub fn border(&self, cage: &CageState, spindle: &SpindleState) -> [f64; MAX_BORDER] {
        let mut entries = [0.0; MAX_BORDER];
        self.without_balls().set_cage(&mut entries, cage);
        self.without_balls().set_spindle(&mut entries, spindle);
        entries
    }

    /// Number of entries of cage and spindle.
    pub(crate) fn border_size(&self) -> usize {
        self.cage_size() + self.spindle_size()
    }

    /// Number of entries.
    pub fn dimension(&self) -> usize {
        self.balls * self.ball_size() + self.cage_size() + self.spindle_size()
    }

    #[inline(always)]
    pub fn ball(&self, y: &[f64], ball: usize) -> BallState {
        let (mut entries, y) = ([0.0; 9], &y[ball * self.ball_size()..]);
        // Sizes that the compiler knows, for copies without a call.
        match self.planar {
            true => entries[..PLANAR_BALL.len()].copy_from_slice(&y[..PLANAR_BALL.len()]),
            false => entries.copy_from_slice(&y[..BALL_NAMES.len()]),
        }
        BallState::from_entries(entries, self.planar)
    }

    #[inline(always)]
    pub fn set_ball(&self, y: &mut [f64], ball: usize, s: &BallState) {
        let size = self.motion_size();
        y[ball * self.ball_size()..][..size].copy_from_slice(&s.entries(self.planar)[..size]);
    }

    /// Attitude of a ball; that of ideal rolling where the layout has none.
    #[inline(always)]
    pub fn attitude(&self, y: &[f64], ball: usize) -> BallAttitude {
        let (mut entries, size) = ([0.0; 4], self.attitude_size());
        entries[..size].copy_from_slice(&y[ball * self.ball_size() + self.motion_size()..][..size]);
        BallAttitude(entries)
    }

    #[inline(always)]
    pub fn set_attitude(&self, y: &mut [f64], ball: usize, attitude: &BallAttitude) {
        let size = self.attitude_size();
        y[ball * self.ball_size() + self.motion_size()..][..size].copy_from_slice(&attitude.0[..size]);
    }

    /// Attitudes of the balls from `first` on, side by side; lanes beyond the last ball repeat it.
    pub(crate) fn attitudes(&self, y: &[f64], first: usize) -> BallAttitude<Lanes> {
        let mut attitudes = BallAttitude::default();
        for lane in 0..LANES {
            attitudes.put(lane, self.attitude(y, (first + lane).min(self.balls - 1)));
        }
        attitudes
    }

    /// Writes attitudes back into the state; lanes beyond the last ball are dropped.
    pub(crate) fn set_attitudes(&self, y: &mut [f64], first: usize, attitudes: &BallAttitude<Lanes>) {
        for lane in 0..LANES.min(self.balls - first) {
            self.set_attitude(y, first + lane, &attitudes.at(lane));
        }
    }

    /// Balls from `first` on, side by side; lanes beyond the last ball repeat it.
    #[inline(always)]
    pub(crate) fn side_by_side<const PLANAR: bool>(&self, y: &[f64], first: usize) -> BallState<Lanes> {
        let layout = Self { planar: PLANAR, ..*self };
        let mut states = BallState::default();
        for lane in 0..LANES {
            states.put(lane, layout.ball(y, (first + lane).min(self.balls - 1)));
        }
        states
    }

    /// Writes balls back into the state; lanes beyond the last ball are dropped.
    #[inline(always)]
    pub(crate) fn set_side_by_side<const PLANAR: bool>(&self, y: &mut [f64], first: usize, s: &BallState<Lanes>) {
        let layout = Self { planar: PLANAR, ..*self };
        let (size, block) = (layout.motion_size(), layout.ball_size());
        let balls = y[first * block..self.balls * block].chunks_exact_mut(block);
        for (lane, ball) in balls.take(LANES).enumerate() {
            ball[..size].copy_from_slice(&s.at(lane).entries(PLANAR)[..size]);
        }
    }

    /// State of the cage; at rest in its place where the layout has no cage.
    #[inline(always)]
    pub fn cage(&self, y: &[f64]) -> CageState {
        let at = self.balls * self.ball_size();
        match (self.cage, self.planar) {
            (false, _) => CageState::default(),
            (true, true) => {
                let [cy, cz, arc, vy, vz, arc_velocity] = block(y, at);
                CageState { centre: [0.0, cy, cz], arc, velocity: [0.0, vy, vz], arc_velocity, ..CageState::default() }
            }
            (true, false) => {
                let [cx, cy, cz, arc, about_y, about_z, vx, vy, vz, arc_velocity, rate_y, rate_z] = block(y, at);
                CageState {
                    centre: [cx, cy, cz],
                    arc,
                    tilt: [about_y, about_z],
                    velocity: [vx, vy, vz],
                    arc_velocity,
                    tilt_rate: [rate_y, rate_z],
                }
            }
        }
    }

    #[inline(always)]
    pub fn set_cage(&self, y: &mut [f64], s: &CageState) {
        let at = self.balls * self.ball_size();
        let ([cx, cy, cz], [vx, vy, vz]) = (s.centre, s.velocity);
        match (self.cage, self.planar) {
            (false, _) => {}
            (true, true) => set_block(y, at, [cy, cz, s.arc, vy, vz, s.arc_velocity]),
            (true, false) => {
                let ([ty, tz], [ry, rz]) = (s.tilt, s.tilt_rate);
                set_block(y, at, [cx, cy, cz, s.arc, ty, tz, vx, vy, vz, s.arc_velocity, ry, rz]);
            }
        }
    }

    #[inline(always)]
    pub fn spindle(&self, y: &[f64]) -> SpindleState {
        let at = self.balls * self.ball_size() + self.cage_size();
        let still = SpindleState::default();
        match (self.axial_spindle, self.tilting_spindle) {
            (true, false) => {
                let [x, sy, z, vx, vy, vz] = block(y, at);
                SpindleState { position: [x, sy, z], velocity: [vx, vy, vz], ..still }
            }
            (false, false) => {
                let [sy, z, vy, vz] = block(y, at);
                SpindleState { position: [0.0, sy, z], velocity: [0.0, vy, vz], ..still }
            }
            (true, true) => {
                let [x, sy, z, ty, tz, vx, vy, vz, ry, rz] = block(y, at);
                SpindleState { position: [x, sy, z], velocity: [vx, vy, vz], tilt: [ty, tz], tilt_rate: [ry, rz] }
            }
            (false, true) => {
                let [sy, z, ty, tz, vy, vz, ry, rz] = block(y, at);
                let (position, velocity) = ([0.0, sy, z], [0.0, vy, vz]);
                SpindleState { position, velocity, tilt: [ty, tz], tilt_rate: [ry, rz] }
            }
        }
    }

    #[inline(always)]
    pub fn set_spindle(&self, y: &mut [f64], s: &SpindleState) {
        let at = self.balls * self.ball_size() + self.cage_size();
        let ([x, sy, z], [vx, vy, vz]) = (s.position, s.velocity);
        let ([ty, tz], [ry, rz]) = (s.tilt, s.tilt_rate);
        match (self.axial_spindle, self.tilting_spindle) {
            (true, false) => set_block(y, at, [x, sy, z, vx, vy, vz]),
            (false, false) => set_block(y, at, [sy, z, vy, vz]),
            (true, true) => set_block(y, at, [x, sy, z, ty, tz, vx, vy, vz, ry, rz]),
            (false, true) => set_block(y, at, [sy, z, ty, tz, vy, vz, ry, rz]),
        }
    }

    /// Structure of the Jacobian: balls as blocks, cage and spindle as border. The cage's angles form pairs with their velocities,
    /// because the effect of its tilt on their rates is of second order.
    pub fn structure(&self) -> Structure {
        let pairs = |at: usize, count: usize| (0..count).map(move |i| (at + i, at + count + i));
        let half_cage = self.cage_size() / 2;
        let half_spindle = self.spindle_size() / 2;
        Structure {
            blocks: self.balls,
            block: self.ball_size(),
            border: self.border_size(),
            block_pairs: pairs(0, if self.planar { 2 } else { 3 }).collect(),
            border_pairs: pairs(0, half_cage).chain(pairs(self.cage_size(), half_spindle)).collect(),
        }
    }

    /// Name and size of each entry, in order.
    fn entries(&self) -> impl Iterator<Item = (String, f64)> + '_ {
        let pick = |all: &'static [(&'static str, f64)], some: &'static [usize], whole: bool| {
            let chosen: Vec<(&str, f64)> = if whole { all.to_vec() } else { some.iter().map(|&i| all[i]).collect() };
            chosen
        };
        let mut ball = pick(&BALL_NAMES, &PLANAR_BALL, !self.planar);
        if self.attitude {
            ball.extend(pick(&ATTITUDE_NAMES, &PLANAR_ATTITUDE, !self.planar));
        }
        let cage = if self.cage { pick(&CAGE_NAMES, &PLANAR_CAGE, !self.planar) } else { Vec::new() };
        let spindle: Vec<(&str, f64)> =
            SPINDLE_NAMES.iter().flat_map(|half| self.freedoms().iter().map(|&freedom| half[freedom])).collect();
        let balls = (1..=self.balls)
            .flat_map(move |n| ball.clone().into_iter().map(move |(name, size)| (format!("{name} of ball {n}"), size)));
        balls
            .chain(cage.into_iter().map(|(name, size)| (format!("{name} of the cage"), size)))
            .chain(spindle.into_iter().map(|(name, size)| (format!("{name} of the spindle"), size)))
    }

    /// Name of an entry, such as "radial velocity of ball 3"; entries of several concatenated states repeat the names.
    pub fn name(&self, entry: usize) -> String {
        self.entries().nth(entry % self.dimension()).map_or_else(|| format!("entry {entry}"), |(name, _)| name)
    }

    /// Natural sizes of the entries.
    pub fn sizes(&self) -> Vec<f64> {
        self.entries().map(|(_, size)| size).collect()
    }

    /// Tolerances of a step: the relative tolerance times the larger of an entry and its size. Arcs, spins and attitudes drift with the cage,
    /// and therefore use their size alone.
    pub fn tolerances(&self, relative: f64) -> Tolerances {
        let sizes = self.sizes();
        let drifting = |size: f64| [size::ARC, size::SPIN, size::ARC_VELOCITY, size::ATTITUDE].contains(&size);
        Tolerances {
            relative: sizes.iter().map(|&size| if drifting(size) { 0.0 } else { relative }).collect(),
            absolute: sizes.iter().map(|&size| relative * size).collect(),
        }
    }
}

#[inline(always)]
fn block<const N: usize>(y: &[f64], at: usize) -> [f64; N] {
    let mut entries = [0.0; N];
    entries.copy_from_slice(&y[at..at + N]);
    entries
}

#[inline(always)]
fn set_block<const N: usize>(y: &mut [f64], at: usize, entries: [f64; N]) {
    y[at..at + N].copy_from_slice(&entries);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_states_are_read_back_and_named() {
        for (planar, axial_spindle, tilting_spindle, attitude, dimension) in [
            (false, false, false, false, 79),
            (false, true, false, false, 81),
            (true, false, false, false, 45),
            (false, true, false, true, 109),
            (true, false, false, true, 52),
            (false, false, true, false, 83),
            (false, true, true, true, 113),
        ] {
            let layout = Layout { balls: 7, planar, cage: true, axial_spindle, tilting_spindle, attitude };
            assert_eq!(layout.dimension(), dimension);
            assert_eq!(layout.sizes().len(), dimension);
            let y: Vec<f64> = (0..dimension).map(|i| i as f64 + 1.0).collect();
            let mut copy = vec![0.0; dimension];
            for ball in 0..7 {
                layout.set_ball(&mut copy, ball, &layout.ball(&y, ball));
                layout.set_attitude(&mut copy, ball, &layout.attitude(&y, ball));
            }
            layout.set_cage(&mut copy, &layout.cage(&y));
            layout.set_spindle(&mut copy, &layout.spindle(&y));
            assert_eq!(copy, y);
        }
        let layout = Layout {
            balls: 7,
            planar: false,
            cage: true,
            axial_spindle: false,
            tilting_spindle: false,
            attitude: false,
        };
        assert_eq!(layout.name(9 * 2 + 4), "radial velocity of ball 3");
        assert_eq!(layout.name(78), "z velocity of the spindle");
        assert_eq!(layout.name(63 + 4), "tilt about y of the cage");
    }
}
