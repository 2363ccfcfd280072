//! Coordinates of housing bodies, of outer rings that move in their seats, and of an imported structure. They stand behind those of the shaft;
//! the mass is 1 over them.

use nalgebra::{Complex, DMatrix, DVector};

use super::input::{Rotor, RotorBearing, Seat};
use crate::physics::frame::structure::Structure;
use crate::physics::frame::support::PORT;

/// Number of coordinates of a rigid body: along X, displacement and slope in the plane of Y, the same in the plane of Z.
const OF_BODY: usize = 5;

/// Rigid motions of bodies and outer rings, and motions of a structure. Bodies and then ports are the parts of the housing, by their number.
#[derive(Debug, Clone)]
pub struct HousingCoordinates {
    bodies: Vec<Solid>,
    /// Of the bearings, in their order.
    rings: Vec<OuterRing>,
    structure: Option<Structure>,
    /// First coordinate of the structure; all after it are its own.
    first_of_structure: usize,
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
        let structure = rotor.housing.structure.clone();
        let first_of_structure = end;
        end += structure.as_ref().map_or(0, |structure| structure.squares.len());
        Self { bodies, rings, structure, first_of_structure, end }
    }

    /// Number of all coordinates, those of the shaft included.
    pub fn end(&self) -> usize {
        self.end
    }

    /// Displacements x, y, z, β_y, β_z of a place of a part, a row each, of all coordinates; of the ground zeros.
    pub fn part(&self, on: Option<usize>, at: f64) -> DMatrix<f64> {
        match on {
            None => DMatrix::zeros(PORT, self.end),
            Some(part) if part < self.bodies.len() => self.bodies[part].rows(at, self.end),
            Some(part) => self.port(part - self.bodies.len(), at),
        }
    }

    /// Displacements of a place that a rigid arm joins to a port of the structure.
    fn port(&self, port: usize, at: f64) -> DMatrix<f64> {
        let mut rows = DMatrix::zeros(PORT, self.end);
        let Some(port) = self.structure.iter().flat_map(|structure| &structure.ports).nth(port) else { return rows };
        let arm = at - port.at;
        let mut own = port.rows.clone();
        for column in 0..own.ncols() {
            own[(1, column)] += arm * own[(4, column)];
            own[(2, column)] -= arm * own[(3, column)];
        }
        rows.view_mut((0, self.first_of_structure), own.shape()).copy_from(&own);
        rows
    }

    /// Stiffness of the structure alone, over the coordinates behind those of a number of the shaft; zero of all others [1/s²].
    pub fn squares(&self, shaft: usize) -> impl Iterator<Item = f64> {
        let others = std::iter::repeat_n(0.0, self.first_of_structure - shaft);
        others.chain(self.structure.iter().flat_map(|structure| structure.squares.iter().copied()))
    }

    /// Adds the damping of the structure to a matrix over all coordinates.
    pub fn add_damping(&self, whole: &mut DMatrix<f64>) {
        let first = self.first_of_structure;
        if let Some(structure) = &self.structure {
            let mut own = whole.view_mut((first, first), structure.damping.shape());
            own += &structure.damping;
        }
    }

    /// Displacements of the mass centres of the bodies, and of the ports.
    pub fn displacements(&self, vector: &DVector<Complex<f64>>) -> Vec<[Complex<f64>; PORT]> {
        let of_part = |rows: DMatrix<f64>| {
            let moved = rows.map(Complex::from) * vector;
            std::array::from_fn(|row| moved[row])
        };
        self.parts().map(of_part).collect()
    }

    /// Displacements of the mass centres of the bodies, and of the ports, of all coordinates.
    pub fn parts(&self) -> impl Iterator<Item = DMatrix<f64>> + '_ {
        let bodies = self.bodies.iter().map(|body| body.rows(body.at, self.end));
        let ports = self.structure.iter().flat_map(|structure| &structure.ports).enumerate();
        bodies.chain(ports.map(|(index, port)| self.port(index, port.at)))
    }

    /// Displacements of the outer ring of a bearing, as a rigid body at a place.
    pub fn outer_ring(&self, bearing: usize, at: f64) -> DMatrix<f64> {
        let OuterRing { on, own } = self.rings[bearing];
        match own {
            OwnMotion::None => self.part(on, at),
            OwnMotion::Whole(ring) => ring.rows(at, self.end),
            OwnMotion::Along(coordinate, mass) => {
                let mut rows = self.part(on, at);
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
            _ => self.part(on, 0.0),
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

    /// Number of the bodies; ports follow.
    pub fn bodies(&self) -> usize {
        self.bodies.len()
    }

    /// True if a coordinate is one of the structure.
    pub fn is_of_structure(&self, coordinate: usize) -> bool {
        coordinate >= self.first_of_structure
    }

    /// The body or bearing, by its number, whose motion a coordinate is, and the displacement.
    pub fn owner(&self, coordinate: usize) -> Option<(Owner, usize)> {
        let of = |solid: &Solid| coordinate.checked_sub(solid.first).filter(|place| *place < OF_BODY);
        // Slopes follow their displacements: y, β_z, z, β_y.
        let displacement = |place: usize| [0, 1, 4, 2, 3][place];
        let bodies = self.bodies.iter().enumerate().map(|(index, body)| (Owner::Part(index), of(body)));
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

/// A part that moves beside the shaft, by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// A part of the housing: a body or a port.
    Part(usize),
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
