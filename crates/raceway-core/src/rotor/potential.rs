//! The potential of a shaft and of the balls of its bearings together.

use nalgebra::{DMatrix, DVector};

use super::input::RotorBearing;
use crate::numerics::bordered::Bordered;
use crate::numerics::minimum::{Potential, Slopes};
use crate::physics::frame::support::PORT;
use crate::physics::statics::{OF_BALL, Pose};

/// The linear part of the equilibrium: stiffness and load over the coordinates, and the displacements of each bearing's place.
pub struct Frame<'a> {
    pub stiffness: &'a DMatrix<f64>,
    pub load: &'a DVector<f64>,
    pub ports: &'a [DMatrix<f64>],
}

/// Places: axial and radial of each ball, bearing after bearing, then the coordinates of the shaft as lengths.
pub(super) struct RotorPotential<'a> {
    bearings: &'a [RotorBearing],
    speed: f64,
    /// Length of a unit of the coordinates.
    unit: f64,
    /// Stiffness and load of the shaft by its coordinates as lengths.
    stiffness: DMatrix<f64>,
    load: DVector<f64>,
    /// Motion of each inner ring in its bearing's own axes.
    rings: Vec<DMatrix<f64>>,
}

impl<'a> RotorPotential<'a> {
    /// `mass`: of the shaft [kg]. A translation by 1 m is its root in the coordinates, whose mass is 1.
    pub(super) fn new(frame: &Frame<'_>, bearings: &'a [RotorBearing], speed: f64, mass: f64) -> Self {
        let unit = mass.sqrt();
        let rings = bearings.iter().zip(frame.ports).map(|(bearing, port)| {
            let signs = bearing.mounted.wrench_on_shaft(&[1.0; PORT]);
            DMatrix::from_fn(PORT, port.ncols(), |row, column| unit * signs[row] * port[(row, column)])
        });
        Self {
            bearings,
            speed,
            unit,
            stiffness: frame.stiffness * (unit * unit),
            load: frame.load * unit,
            rings: rings.collect(),
        }
    }

    /// Number of coordinates of the shaft.
    pub(super) fn len(&self) -> usize {
        self.load.len()
    }

    /// The place with these coordinates of the shaft, and with balls at theirs or else between the grooves.
    pub(super) fn place(&self, coordinates: &DVector<f64>, balls: Option<Vec<f64>>) -> Vec<f64> {
        let lengths = coordinates / self.unit;
        let between = || {
            let poses = (0..self.bearings.len()).map(|index| (index, self.pose(index, &lengths)));
            poses.flat_map(|(index, pose)| self.bearings[index].mounted.bearing.all_between_grooves(&pose)).collect()
        };
        let mut place: Vec<f64> = balls.unwrap_or_else(between);
        place.extend(lengths.iter());
        place
    }

    /// The coordinates of the shaft at a place.
    pub(super) fn coordinates(&self, place: &[f64]) -> DVector<f64> {
        self.lengths(place) * self.unit
    }

    /// The pose of each inner ring at a place, and the places of its balls.
    pub(super) fn rings<'p>(&self, place: &'p [f64]) -> impl Iterator<Item = (Pose, &'p [f64])> {
        let lengths = self.lengths(place);
        let mut rest = place;
        (0..self.bearings.len()).map(move |index| {
            let (balls, others) = rest.split_at(OF_BALL * self.bearings[index].mounted.bearing.entries());
            rest = others;
            (self.pose(index, &lengths), balls)
        })
    }

    /// Size of all forces at a place [N]: loads, and forces on the balls.
    pub(super) fn force(&self, place: &[f64]) -> f64 {
        let of_ring = |(bearing, (pose, balls)): (&RotorBearing, (Pose, &[f64]))| {
            bearing.mounted.bearing.force(&pose, self.speed, balls)
        };
        self.load.amax() + self.bearings.iter().zip(self.rings(place)).map(of_ring).fold(0.0, f64::max)
    }

    fn lengths(&self, place: &[f64]) -> DVector<f64> {
        DVector::from_column_slice(&place[place.len() - self.len()..])
    }

    fn pose(&self, index: usize, lengths: &DVector<f64>) -> Pose {
        let at_rest = self.bearings[index].mounted.ring_pose(&[0.0; PORT], 0.0);
        let moved = &self.rings[index] * lengths;
        std::array::from_fn(|k| at_rest[k] + moved[k])
    }
}

impl Potential for RotorPotential<'_> {
    /// Of the balls of each bearing and of its ring; the shaft's own is its stiffness.
    type Curvature = Vec<Bordered<PORT>>;

    fn slopes(&self, place: &[f64]) -> Slopes<Self::Curvature> {
        let lengths = self.lengths(place);
        let elastic = &self.stiffness * &lengths;
        let mut value = lengths.dot(&(&elastic * 0.5 - &self.load));
        // Damping that turns along, and supports given by a matrix, have stiffness without a potential. So have rolling balls.
        let mut turning_of_shaft = (&elastic - self.stiffness.tr_mul(&lengths)) * 0.5;
        let mut of_shaft = elastic - &self.load;
        let [mut gradient, mut without_potential] = [(); 2].map(|()| Vec::with_capacity(place.len()));
        let mut hessian = Vec::new();
        for ((bearing, (pose, balls)), by) in self.bearings.iter().zip(self.rings(place)).zip(&self.rings) {
            let ring = bearing.mounted.bearing.slopes(&pose, self.speed, balls);
            value += ring.value;
            for (sums, sums_of_shaft, of_bearing) in [
                (&mut gradient, &mut of_shaft, ring.gradient),
                (&mut without_potential, &mut turning_of_shaft, ring.without_potential),
            ] {
                let (of_balls, of_ring) = of_bearing.split_at(balls.len());
                sums.extend_from_slice(of_balls);
                *sums_of_shaft += by.tr_mul(&DVector::from_column_slice(of_ring));
            }
            hessian.push(ring.hessian);
        }
        gradient.extend(of_shaft.iter());
        without_potential.extend(turning_of_shaft.iter());
        Slopes { value, gradient, without_potential, hessian }
    }

    /// Balls are eliminated onto their ring, and rings onto the shaft.
    fn step(&self, slopes: &Slopes<Self::Curvature>, damping: f64) -> Option<Vec<f64>> {
        let (mut of_balls, of_shaft) = slopes.gradient.split_at(slopes.gradient.len() - self.len());
        let mut matrix = self.stiffness.clone();
        for place in 0..self.len() {
            matrix[(place, place)] += damping;
        }
        let mut force = -DVector::from_column_slice(of_shaft);
        let mut eliminated = Vec::with_capacity(self.bearings.len());
        for (of_bearing, by) in slopes.hessian.iter().zip(&self.rings) {
            let own;
            (own, of_balls) = of_balls.split_at(OF_BALL * of_bearing.blocks.len());
            let factor = of_bearing.clone().with_shifted_blocks(damping).eliminated()?;
            let mut values: Vec<f64> = own.iter().map(|slope| -slope).chain([0.0; PORT]).collect();
            factor.reduce(&mut values);
            force += by.tr_mul(&DVector::from_column_slice(&values[own.len()..]));
            let border = factor.border();
            let of_ring = DMatrix::from_fn(PORT, PORT, |row, column| border[row.max(column)][row.min(column)]);
            matrix += by.tr_mul(&(of_ring * by));
            eliminated.push((factor, values));
        }
        ((&matrix + matrix.transpose()) * 0.5).cholesky()?;
        let lengths = matrix.lu().solve(&force)?;
        let mut step = Vec::with_capacity(slopes.gradient.len());
        for ((factor, mut values), by) in eliminated.into_iter().zip(&self.rings) {
            let balls = values.len() - PORT;
            values[balls..].copy_from_slice((by * &lengths).as_slice());
            factor.restore(&mut values);
            step.extend_from_slice(&values[..balls]);
        }
        step.extend(lengths.iter());
        Some(step)
    }
}
