//! Several bearings on a rigid shaft: positions, facing, preload, and the pose of the shaft under loads.

use std::array::from_fn;

use super::balance::{BORDER, Balance, Found, Link, NoBalance, Places};
use super::ball::{FREEDOMS, Matrix, Pose, RingBearing, Wrench};
use super::ring::{RingState, add_to};

/// Direction along which a thrust of the shaft loads a bearing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Faces {
    PlusX,
    /// The mirror image.
    MinusX,
}

/// Spring that pushes an outer ring against its balls; the ring slides along the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Force with the ring at its place [N].
    pub force: f64,
    /// [N/m]
    pub stiffness: f64,
}

/// A bearing on a shaft.
#[derive(Debug, Clone)]
pub struct Mounted {
    pub bearing: RingBearing,
    /// Position along the shaft from the reference point [m].
    pub at: f64,
    pub faces: Faces,
    /// Pose of the outer ring.
    pub outer: Pose,
    /// `None`: the outer ring is held.
    pub spring: Option<Spring>,
}

/// A rigid shaft on bearings.
#[derive(Debug, Clone)]
pub struct RigidShaft {
    pub bearings: Vec<Mounted>,
}

/// Balance of a shaft.
#[derive(Debug, Clone)]
pub struct ShaftState {
    /// Pose of the shaft at the reference point.
    pub pose: Pose,
    pub bearings: Vec<MountedState>,
    /// Stiffness of all bearings by the pose of the shaft; sliding outer rings give way.
    pub stiffness: Matrix,
}

/// A bearing in balance.
#[derive(Debug, Clone)]
pub struct MountedState {
    /// In the bearing's own axes, in which a thrust along +X loads it.
    pub ring: RingState,
    /// Displacement of a sliding outer ring along the shaft [m].
    pub outer_shift: f64,
}

impl Faces {
    /// Sign of each freedom in the bearing's own axes.
    fn signs(self) -> [f64; FREEDOMS] {
        match self {
            Self::PlusX => [1.0; FREEDOMS],
            Self::MinusX => [-1.0, 1.0, 1.0, -1.0, -1.0],
        }
    }
}

impl Mounted {
    /// Sets the outer ring so that the inner one is displaced by a length [m] in its own axes while the shaft is centred.
    fn set_apart(&mut self, displaced: f64) {
        self.outer[0] = -self.faces.signs()[0] * displaced;
    }

    /// A bearing with its outer ring held in the middle.
    pub fn new(bearing: RingBearing, at: f64, faces: Faces) -> Self {
        Self { bearing, at, faces, outer: [0.0; FREEDOMS], spring: None }
    }

    /// Pose of the inner ring relative to the outer one in the bearing's own axes. Slopes are small: the pose is linear in that of the shaft.
    pub fn ring_pose(&self, shaft: &Pose, outer_shift: f64) -> Pose {
        let (lever, signs) = (self.lever(), self.faces.signs());
        from_fn(|k| {
            let moved: f64 = lever[k].iter().zip(shaft).map(|(by, freedom)| by * freedom).sum();
            signs[k] * (moved - self.outer[k] - if k == 0 { outer_shift } else { 0.0 })
        })
    }

    /// Motion of the inner ring's centre by that of the reference point: y + a β_z, z − a β_y.
    fn lever(&self) -> Matrix {
        let mut lever: Matrix = from_fn(|row| from_fn(|column| if row == column { 1.0 } else { 0.0 }));
        (lever[1][4], lever[2][3]) = (self.at, -self.at);
        lever
    }

    /// Forces and moments on the inner ring along the shaft's axes.
    pub fn wrench_on_shaft(&self, own: &Wrench) -> Wrench {
        let signs = self.faces.signs();
        from_fn(|k| signs[k] * own[k])
    }

    /// A stiffness or damping of the rings along the shaft's axes, about the bearing's centre.
    pub fn along_shaft(&self, own: &Matrix) -> Matrix {
        let signs = self.faces.signs();
        from_fn(|row| from_fn(|column| signs[row] * own[row][column] * signs[column]))
    }

    /// Stiffness between shaft and housing along the shaft's axes, about the bearing's centre: a sliding outer ring gives way.
    pub fn stiffness_on_shaft(&self, own: &Matrix) -> Matrix {
        let between = self.along_shaft(own);
        let Some(spring) = self.spring else { return between };
        let sum = between[0][0] + spring.stiffness;
        if sum == 0.0 {
            return between;
        }
        from_fn(|row| from_fn(|column| between[row][column] - between[row][0] * between[0][column] / sum))
    }

    /// A matrix about the bearing's centre by the pose of the shaft.
    pub fn about_reference(&self, matrix: &Matrix) -> Matrix {
        let lever = self.lever();
        from_fn(|row| {
            from_fn(|column| {
                let mut sum = 0.0;
                for k in 0..FREEDOMS {
                    for l in 0..FREEDOMS {
                        sum += lever[k][row] * matrix[k][l] * lever[l][column];
                    }
                }
                sum
            })
        })
    }
}

impl RigidShaft {
    /// The shaft with the outer rings of two bearings set apart so that a force [N] loads both at rest, the shaft centred and unloaded. The bearings
    /// face opposite directions.
    pub fn preloaded_by_force(mut self, between: [usize; 2], force: f64) -> Result<Self, NoBalance> {
        for index in between {
            let displaced = self.bearings[index].bearing.under_thrust(force)?;
            self.bearings[index].set_apart(displaced);
        }
        Ok(self)
    }

    /// The shaft with the outer rings of two bearings set apart by a length [m] beyond the place where all balls just touch; half of it acts in each
    /// bearing.
    pub fn preloaded_by_offset(mut self, between: [usize; 2], offset: f64) -> Self {
        for index in between {
            let displaced = self.bearings[index].bearing.axial_play() + 0.5 * offset;
            self.bearings[index].set_apart(displaced);
        }
        self
    }

    /// Balance under forces and moments on the shaft, about the reference point, at a speed [rad/s]. `free`: freedoms of the shaft that move; the
    /// others stay 0. `start`: a balance near it.
    pub fn operating_point(
        &self,
        load: &Wrench,
        free: [bool; FREEDOMS],
        speed: f64,
        start: Option<&ShaftState>,
    ) -> Result<ShaftState, NoBalance> {
        let slide: Vec<usize> =
            (0..self.bearings.len()).filter(|&index| self.bearings[index].spring.is_some()).collect();
        let moving: Vec<usize> = (0..FREEDOMS).filter(|&freedom| free[freedom]).collect();
        let width = moving.len() + slide.len();
        // Slopes are searched as lengths.
        let radius = self.bearings.iter().map(|mounted| mounted.bearing.pitch_radius).fold(0.0, f64::max);
        let unit = |freedom: usize| if freedom < 3 { 1.0 } else { 1.0 / radius };
        let (mut forces, mut springs, mut guess) = ([0.0; BORDER], [0.0; BORDER], [0.0; BORDER]);
        for (place, &freedom) in moving.iter().enumerate() {
            forces[place] = unit(freedom) * load[freedom];
            guess[place] = start.map_or(0.0, |start| start.pose[freedom] / unit(freedom));
        }
        for (place, &index) in slide.iter().enumerate().map(|(place, index)| (moving.len() + place, index)) {
            let mounted = &self.bearings[index];
            let Some(spring) = mounted.spring else { continue };
            let towards = mounted.faces.signs()[0];
            (forces[place], springs[place]) = (-towards * spring.force, spring.stiffness);
            guess[place] = match start {
                Some(start) => start.bearings[index].outer_shift,
                None => -towards * (mounted.bearing.under_thrust(spring.force)? - mounted.ring_pose(&[0.0; _], 0.0)[0]),
            };
        }
        let links = self.bearings.iter().enumerate().map(|(index, mounted)| {
            let (lever, signs) = (mounted.lever(), mounted.faces.signs());
            let mut by = [[0.0; BORDER]; FREEDOMS];
            for (k, row) in by.iter_mut().enumerate() {
                for (place, &freedom) in moving.iter().enumerate() {
                    row[place] = signs[k] * lever[k][freedom] * unit(freedom);
                }
            }
            if let Some(place) = slide.iter().position(|&slides| slides == index) {
                by[0][moving.len() + place] = -signs[0];
            }
            Link { bearing: &mounted.bearing, base: mounted.ring_pose(&[0.0; _], 0.0), by }
        });
        let balance = Balance { links: links.collect(), speed, width, load: forces, springs };
        let balls: Option<Vec<Places>> =
            start.map(|start| start.bearings.iter().map(|state| state.ring.balls().clone()).collect());
        let Found { border, balls, least_load } = balance.find(&guess, balls.as_deref())?;
        let mut pose = [0.0; FREEDOMS];
        for (place, &freedom) in moving.iter().enumerate() {
            pose[freedom] = unit(freedom) * border[place];
        }
        let states = balance.links.iter().zip(balls).enumerate().map(|(index, (link, balls))| {
            let place = slide.iter().position(|&slides| slides == index);
            MountedState {
                ring: RingState::of(link.bearing, link.pose(&border[..width]), speed, balls, least_load),
                outer_shift: place.map_or(0.0, |place| border[moving.len() + place]),
            }
        });
        let bearings: Vec<MountedState> = states.collect();
        let mut stiffness = Matrix::default();
        for (mounted, state) in self.bearings.iter().zip(&bearings) {
            let on_shaft = mounted.stiffness_on_shaft(&state.ring.stiffness.mean);
            add_to(&mut stiffness, &mounted.about_reference(&on_shaft), 1.0);
        }
        Ok(ShaftState { pose, bearings, stiffness })
    }
}
