//! Coordinates of a rotor: free modes and residual vectors of its shaft, along X and in two planes, and the motions of its housing.

use nalgebra::{DMatrix, DVector, Vector3};

use super::housing::HousingCoordinates;
use super::input::{PlacedLoad, Rotor, RotorBearing, RotorError};
use super::sensor::{Part, Sensor};
use crate::physics::frame::disc::Disc;
use crate::physics::frame::mesh::{Matrices, Mesh};
use crate::physics::frame::modes::FreeModes;
use crate::physics::frame::shaft::ShaftMotion;
use crate::physics::frame::support::{PORT, PortMatrix};
use crate::physics::loads::LoadDirection;

/// The coordinates: first those of the shaft along X, then those in the plane of Y, then the same in that of Z, then those of the housing.
/// The mass is 1.
#[derive(Debug, Clone)]
pub struct Coordinates {
    pub mesh: Mesh,
    axial: Option<FreeModes>,
    bending: FreeModes,
    is_rigid: bool,
    /// Polar inertia over the shapes of a plane.
    pub polar: DMatrix<f64>,
    pub housing: HousingCoordinates,
    /// True if something acts against the rotation otherwise than with it: gyroscopic moments, or damping that turns along.
    pub has_sense: bool,
}

impl Coordinates {
    /// At most `count` flexible modes in each plane, and the static answers to supports, loads and gyroscopic moments.
    pub fn of(rotor: &Rotor, mesh: Mesh, count: usize) -> Result<Self, RotorError> {
        let Loads { axial: along, bending: mut across } = Loads::of(rotor, &mesh);
        let is_rigid = rotor.shaft.motion != ShaftMotion::Bends;
        let axial = match rotor.shaft.is_axially_free {
            true if is_rigid => Some(FreeModes::of(&mesh.axial, 0).ok_or(RotorError::Singular)?),
            true => Some(modes(&mesh.axial, count, |_| along)?),
            false => None,
        };
        let bending = match rotor.shaft.motion {
            ShaftMotion::Bends => modes(&mesh.bending, count, |modes| {
                // Gyroscopic moments of the lower half of the modes, rotation included.
                let turning = if rotor.shaft.has_gyroscopic_moments { count / 2 } else { 0 };
                let turning = modes.shapes[1..].iter().take(turning);
                across.extend(turning.map(|shape| mesh.polar.times(shape)));
                across
            })?,
            ShaftMotion::Rigid => FreeModes::of(&mesh.bending, 0).ok_or(RotorError::Singular)?,
            ShaftMotion::Upright => FreeModes::of(&mesh.bending, 0).ok_or(RotorError::Singular)?.of_translation(),
        };
        let mut polar = bending.projected(&mesh.polar);
        if !rotor.shaft.has_gyroscopic_moments {
            polar.fill(0.0);
        }
        let of_shaft = axial.as_ref().map_or(0, FreeModes::len) + 2 * bending.len();
        let turns_along = rotor.shaft.damping_ratio * rotor.shaft.rotating_share > 0.0;
        let has_sense = polar.amax() > 0.0 || turns_along || rotor.bearings.iter().any(RotorBearing::turns_in_own_seat);
        Ok(Self { mesh, axial, bending, is_rigid, polar, housing: HousingCoordinates::of(rotor, of_shaft), has_sense })
    }

    pub fn len(&self) -> usize {
        self.housing.end()
    }

    /// Number of coordinates of the shaft.
    pub fn of_shaft(&self) -> usize {
        self.axials() + 2 * self.laterals()
    }

    /// Coordinates of motions along X.
    pub fn axial(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.axials()).chain(self.housing.axial())
    }

    /// Coordinates of the same motion in the planes of Y and of Z.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let (y, z) = (self.axials(), self.axials() + self.laterals());
        (0..self.laterals()).map(move |k| (y + k, z + k)).chain(self.housing.pairs())
    }

    /// Number of coordinates along X.
    pub fn axials(&self) -> usize {
        self.axial.as_ref().map_or(0, FreeModes::len)
    }

    /// Number of coordinates in a plane.
    pub fn laterals(&self) -> usize {
        self.bending.len()
    }

    /// Stiffness of the shaft alone and of an imported structure alone, which is diagonal [1/s²].
    pub fn squares(&self) -> impl Iterator<Item = f64> {
        let axial = self.axial.iter().flat_map(|modes| &modes.squares);
        let of_shaft = axial.chain(&self.bending.squares).chain(&self.bending.squares).map(|square| square.max(0.0));
        of_shaft.chain(self.housing.squares(self.of_shaft()))
    }

    /// Angular frequency of the highest true mode in a plane [rad/s]; infinite where every mode is kept, as of a rigid spindle.
    pub fn highest(&self) -> f64 {
        let is_complete = self.is_rigid || self.bending.true_modes == 2 * self.mesh.nodes.len();
        if is_complete { f64::INFINITY } else { self.bending.squares[self.bending.true_modes - 1].max(0.0).sqrt() }
    }

    /// Angular frequencies of the true modes of a plane, rigid motions included, rising [rad/s].
    pub fn frequencies(&self) -> Vec<f64> {
        let squares = self.bending.squares.iter().take(self.bending.true_modes);
        squares.map(|square| square.max(0.0).sqrt()).collect()
    }

    /// Displacements x, y, z, β_y, β_z of a node, a row each, of the coordinates.
    pub fn port(&self, node: usize) -> DMatrix<f64> {
        let mut rows = DMatrix::zeros(PORT, self.len());
        for (index, value) in self.axial.iter().flat_map(|modes| modes.row(node)).enumerate() {
            rows[(0, index)] = value;
        }
        let (y, z) = (self.axials(), self.axials() + self.laterals());
        for (index, (displacement, slope)) in self.bending.row(2 * node).zip(self.bending.row(2 * node + 1)).enumerate()
        {
            rows[(1, y + index)] = displacement;
            rows[(2, z + index)] = displacement;
            rows[(3, z + index)] = -slope;
            rows[(4, y + index)] = slope;
        }
        rows
    }

    /// Largest slope of the shaft [rad], and its place [m].
    pub fn largest_slope(&self, coordinates: &DVector<f64>) -> (f64, f64) {
        let (y, z) = (self.axials(), self.axials() + self.laterals());
        let slope = |node: usize| {
            let by = || self.bending.row(2 * node + 1).enumerate();
            let along_y: f64 = by().map(|(index, slope)| slope * coordinates[y + index]).sum();
            let along_z: f64 = by().map(|(index, slope)| slope * coordinates[z + index]).sum();
            along_y.hypot(along_z)
        };
        let slopes = self.mesh.nodes.iter().enumerate().map(|(node, place)| (slope(node), *place));
        slopes.fold((0.0, 0.0), |most, slope| if slope.0 > most.0 { slope } else { most })
    }

    /// Reading of a sensor by each coordinate [m].
    pub fn reading(&self, sensor: &Sensor) -> DVector<f64> {
        let of = |part: Part| match part {
            // Forces and displacements of a place are the same shares of the coordinates.
            Part::Shaft => DVector::from_vec(self.force(sensor.at, sensor.along)),
            Part::Housing(part) => {
                let rows = self.housing.part(Some(part), sensor.at);
                rows.rows(0, 3).transpose() * Vector3::from(sensor.along)
            }
        };
        match sensor.relative_to {
            None => of(sensor.on),
            Some(other) => of(sensor.on) - of(other),
        }
    }

    /// Forces on the coordinates of the weight of the shaft along Y [N]. The first shape of a plane, its translation, takes all of it: the
    /// others are orthogonal to a translation in the mass.
    pub fn weight(&self, weight: f64) -> Vec<f64> {
        let mut forces = vec![0.0; self.len()];
        forces[self.axials()] = weight * self.bending.shapes[0][0];
        forces
    }

    /// Forces on the coordinates of a force along X, Y, Z at any place of the shaft [N].
    pub fn force(&self, at: f64, force: [f64; 3]) -> Vec<f64> {
        let along = self.axial.iter().flat_map(|modes| modes.forces(&along(&self.mesh, at)));
        let across = self.bending.forces(&self.mesh.force_at(at));
        let mut forces: Vec<f64> = along.map(|share| share * force[0]).collect();
        forces.extend(across.iter().map(|share| share * force[1]));
        forces.extend(across.iter().map(|share| share * force[2]));
        forces.resize(self.len(), 0.0);
        forces
    }
}

/// Free modes and the residual vectors of loads, which may depend on the modes.
fn modes(
    chain: &Matrices,
    count: usize,
    loads: impl FnOnce(&FreeModes) -> Vec<Vec<f64>>,
) -> Result<FreeModes, RotorError> {
    let free = FreeModes::of(chain, count).ok_or(RotorError::Singular)?;
    let loads = loads(&free);
    free.with_residuals(chain, &loads).ok_or(RotorError::Singular)
}

/// Forces that stand for 1 N along X at a place, by its distance from the two neighbouring nodes.
fn along(mesh: &Mesh, at: f64) -> Vec<f64> {
    let shares = mesh.force_at(at);
    (0..mesh.nodes.len()).map(|node| shares[2 * node]).collect()
}

/// Unit loads whose static answers the coordinates must hold.
struct Loads {
    axial: Vec<Vec<f64>>,
    bending: Vec<Vec<f64>>,
}

impl Loads {
    fn of(rotor: &Rotor, mesh: &Mesh) -> Self {
        let unit = |size: usize, place: usize| (0..size).map(|i| f64::from(i == place)).collect::<Vec<f64>>();
        let count = mesh.nodes.len();
        let mut loads = Self { axial: Vec::new(), bending: Vec::new() };
        for support in &rotor.supports {
            let node = mesh.node(support.at);
            let acts = |places: &[usize]| acts(&support.stiffness, places) || acts(&support.damping, places);
            if acts(&[0]) {
                loads.axial.push(unit(count, node));
            }
            if acts(&[1, 2]) {
                loads.bending.push(unit(2 * count, 2 * node));
            }
            if acts(&[3, 4]) {
                loads.bending.push(unit(2 * count, 2 * node + 1));
            }
        }
        for bearing in &rotor.bearings {
            let node = mesh.node(bearing.at);
            loads.axial.push(unit(count, node));
            loads.bending.push(unit(2 * count, 2 * node));
            if bearing.has_moments {
                loads.bending.push(unit(2 * count, 2 * node + 1));
            }
        }
        // A disc at high speed holds its plane.
        let is_turning = |disc: &&Disc| rotor.shaft.has_gyroscopic_moments && disc.axial_inertia > 0.0;
        let turning = rotor.shaft.discs.iter().filter(is_turning);
        loads.bending.extend(turning.map(|disc| unit(2 * count, 2 * mesh.node(disc.at) + 1)));
        loads.bending.extend(rotor.unbalances.iter().map(|plane| unit(2 * count, 2 * mesh.node(plane.at))));
        let centre = rotor.shaft.mass_centre();
        if rotor.load[1] != 0.0 || rotor.load[2] != 0.0 {
            loads.bending.push(mesh.force_at(centre));
        }
        if rotor.load[0] != 0.0 {
            loads.axial.push(along(mesh, centre));
        }
        for PlacedLoad { at, load } in &rotor.loads {
            let node = mesh.node(*at);
            match load.direction() {
                Some(LoadDirection::X) => loads.axial.push(unit(count, node)),
                Some(LoadDirection::AboutY | LoadDirection::AboutZ) => {
                    loads.bending.push(unit(2 * count, 2 * node + 1));
                }
                Some(LoadDirection::Y | LoadDirection::Z) | None => loads.bending.push(unit(2 * count, 2 * node)),
            }
        }
        loads
    }
}

/// True if a matrix has an entry in these rows or columns.
fn acts(matrix: &PortMatrix, places: &[usize]) -> bool {
    places.iter().any(|&place| (0..PORT).any(|other| matrix[place][other] != 0.0 || matrix[other][place] != 0.0))
}
