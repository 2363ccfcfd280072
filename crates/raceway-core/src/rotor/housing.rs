//! Coordinates of housing bodies and of outer rings that move in their seats. They stand behind those of the shaft; the mass is 1 over
//! them.

use nalgebra::{Complex, DMatrix, DVector};

use super::input::{Rotor, RotorBearing, Seat};
use crate::physics::frame::support::PORT;

/// Number of coordinates of a rigid body: along X, displacement and slope in the plane of Y, the same in the plane of Z.
const OF_BODY: usize = 5;

/// Rigid motions of bodies and outer rings.
#[derive(Debug, Clone)]
pub struct HousingCoordinates {
    bodies: Vec<Solid>,
    /// Of the bearings, in their order.
    rings: Vec<OuterRing>,
    /// Number of coordinates, those of the shaft included.
    end: usize,
}

/// A rigid body among the coordinates.
#[derive(Debug, Clone, Copy)]
struct Solid {
    /// Place of the mass centre [m].
    at: f64,
    /// First of its coordinates.
    first: usize,
    mass: f64,
    /// About Y and Z.
    inertia: [f64; 2],
}

/// The motion of an outer ring: that of what carries it, or its own.
#[derive(Debug, Clone, Copy)]
struct OuterRing {
    on: Option<usize>,
    own: OwnMotion,
}

#[derive(Debug, Clone, Copy)]
enum OwnMotion {
    None,
    Whole(Solid),
    /// Along X, by its coordinate and its mass.
    Along(usize, f64),
}

impl HousingCoordinates {
    /// Behind a number of coordinates of the shaft.
    pub fn of(rotor: &Rotor, shaft: usize) -> Self {
        let mut end = shaft;
        let mut take = |count: usize| {
            end += count;
            end - count
        };
        let bodies = rotor.housing.bodies.iter().map(|body| Solid {
            at: body.at,
            first: take(OF_BODY),
            mass: body.mass,
            inertia: body.inertia,
        });
        let bodies = bodies.collect();
        let mut own = |bearing: &RotorBearing| match bearing.seat {
            Seat::Rigid => OwnMotion::None,
            Seat::Elastic { mass, inertia, .. } => {
                OwnMotion::Whole(Solid { at: bearing.outer_ring(), first: take(OF_BODY), mass, inertia: [inertia; 2] })
            }
            Seat::Sliding { mass, .. } => OwnMotion::Along(take(1), mass),
        };
        let rings = rotor.bearings.iter().map(|bearing| OuterRing { on: bearing.on, own: own(bearing) }).collect();
        Self { bodies, rings, end }
    }

    /// Number of all coordinates, those of the shaft included.
    pub fn end(&self) -> usize {
        self.end
    }

    /// Displacements x, y, z, β_y, β_z of a place of a body, a row each, of all coordinates; of the ground zeros.
    pub fn body(&self, on: Option<usize>, at: f64) -> DMatrix<f64> {
        on.map_or_else(|| DMatrix::zeros(PORT, self.end), |body| self.bodies[body].rows(at, self.end))
    }

    /// Displacements of the mass centres of the bodies.
    pub fn displacements(&self, vector: &DVector<Complex<f64>>) -> Vec<[Complex<f64>; PORT]> {
        let of_body = |body: &Solid| {
            let moved = body.rows(body.at, self.end).map(Complex::from) * vector;
            std::array::from_fn(|row| moved[row])
        };
        self.bodies.iter().map(of_body).collect()
    }

    /// Displacements of the outer ring of a bearing, as a rigid body at a place.
    pub fn outer_ring(&self, bearing: usize, at: f64) -> DMatrix<f64> {
        let OuterRing { on, own } = self.rings[bearing];
        match own {
            OwnMotion::None => self.body(on, at),
            OwnMotion::Whole(ring) => ring.rows(at, self.end),
            OwnMotion::Along(coordinate, mass) => {
                let mut rows = self.body(on, at);
                rows.row_mut(0).fill(0.0);
                rows[(0, coordinate)] = mass.sqrt().recip();
                rows
            }
        }
    }

    /// Displacement along X of what the outer ring of a bearing is a part of, across the axis.
    fn carrier(&self, bearing: usize) -> DMatrix<f64> {
        let OuterRing { on, own } = self.rings[bearing];
        match own {
            OwnMotion::Whole(ring) => ring.rows(ring.at, self.end),
            _ => self.body(on, 0.0),
        }
    }

    /// Distance along X [m] by which a place has moved along what carries the outer ring of a bearing; `rows`: displacements of the place.
    pub fn slipped(&self, bearing: usize, rows: &DMatrix<f64>, coordinates: &DVector<f64>) -> f64 {
        ((rows.row(0) - self.carrier(bearing).row(0)) * coordinates)[0]
    }

    /// Coordinates of motions along X.
    pub fn axial(&self) -> impl Iterator<Item = usize> + '_ {
        let along = self.rings.iter().filter_map(|ring| match ring.own {
            OwnMotion::Along(coordinate, _) => Some(coordinate),
            _ => None,
        });
        self.solids().map(|solid| solid.first).chain(along)
    }

    /// Coordinates of the same motion in the planes of Y and of Z.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.solids().flat_map(|Solid { first, .. }| [(first + 1, first + 3), (first + 2, first + 4)])
    }

    /// Forces on the coordinates along Y of the weight by 1 m/s².
    pub fn weights(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.solids().map(|solid| (solid.first + 1, solid.mass.sqrt()))
    }

    /// The body or bearing, by its number, whose motion a coordinate is, and the displacement.
    pub fn owner(&self, coordinate: usize) -> Option<(Owner, usize)> {
        let of = |solid: &Solid| coordinate.checked_sub(solid.first).filter(|place| *place < OF_BODY);
        // Slopes follow their displacements: y, β_z, z, β_y.
        let displacement = |place: usize| [0, 1, 4, 2, 3][place];
        let bodies = self.bodies.iter().enumerate().map(|(index, body)| (Owner::Body(index), of(body)));
        let rings = self.rings.iter().enumerate().map(|(index, ring)| {
            let place = match &ring.own {
                OwnMotion::None => None,
                OwnMotion::Whole(solid) => of(solid),
                OwnMotion::Along(own, _) => (*own == coordinate).then_some(0),
            };
            (Owner::OuterRing(index), place)
        });
        bodies.chain(rings).find_map(|(owner, place)| Some((owner, displacement(place?))))
    }

    fn solids(&self) -> impl Iterator<Item = &Solid> {
        let rings = self.rings.iter().filter_map(|ring| match &ring.own {
            OwnMotion::Whole(solid) => Some(solid),
            _ => None,
        });
        self.bodies.iter().chain(rings)
    }
}

/// What moves beside the shaft, by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    Body(usize),
    OuterRing(usize),
}

impl Solid {
    /// y + a β_z and z − a β_y at a distance a from the mass centre.
    fn rows(&self, at: f64, columns: usize) -> DMatrix<f64> {
        let (first, arm) = (self.first, at - self.at);
        let [moved, about_y, about_z] = [self.mass, self.inertia[0], self.inertia[1]].map(|mass| mass.sqrt().recip());
        let mut rows = DMatrix::zeros(PORT, columns);
        rows[(0, first)] = moved;
        (rows[(1, first + 1)], rows[(1, first + 2)]) = (moved, arm * about_z);
        (rows[(2, first + 3)], rows[(2, first + 4)]) = (moved, arm * about_y);
        (rows[(3, first + 4)], rows[(4, first + 2)]) = (-about_y, about_z);
        rows
    }
}
