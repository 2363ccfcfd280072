//! A shaft as a chain of elements, with the matrices of one plane and of the axis.

use super::beam::{BeamElement, ElementMatrix};
use super::shaft::Shaft;
use crate::numerics::banded::SymmetricBand;

/// Nodes closer than this share of the shaft's length are one [-].
const SAME_PLACE: f64 = 1e-9;

/// Elements and matrices of a shaft. Unknowns of a plane: displacement and slope of node 0, of node 1, …; of the axis: x of each
/// node.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Places along the shaft, rising [m].
    pub nodes: Vec<f64>,
    pub elements: Vec<BeamElement>,
    pub(crate) bending: Matrices,
    /// Polar inertia over the slopes [kg m²].
    pub(crate) polar: SymmetricBand,
    pub(crate) axial: Matrices,
}

/// Matrices of a free chain.
#[derive(Debug, Clone)]
pub(crate) struct Matrices {
    pub stiffness: SymmetricBand,
    pub mass: SymmetricBand,
    /// Rigid motions, for which the stiffness is zero.
    pub rigid: Vec<Vec<f64>>,
    /// Square of an angular frequency of the size of the lowest flexible mode [1/s²].
    pub shift: f64,
}

impl Mesh {
    /// Elements of at most this length [m], with a node at each end of a section, at each disc and at each of `places`.
    pub fn new(shaft: &Shaft, places: &[f64], longest: f64) -> Self {
        let ends = shaft.section_ends();
        let breaks = breaks(shaft, &ends, places);
        let mut elements = Vec::new();
        let mut nodes = vec![0.0];
        for pair in breaks.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            let section = ends[1..].iter().position(|end| middle < *end).unwrap_or(shaft.sections.len() - 1);
            let count = ((pair[1] - pair[0]) / longest).ceil().max(1.0) as usize;
            let length = (pair[1] - pair[0]) / count as f64;
            for index in 1..=count {
                elements.push(BeamElement { length, section: shaft.sections[section].tube, material: shaft.material });
                nodes.push(if index == count { pair[1] } else { pair[0] + index as f64 * length });
            }
        }
        let (bending, polar) = of_plane(shaft, &elements, &nodes);
        let axial = of_axis(shaft, &elements, &nodes);
        Self { nodes, elements, bending, polar, axial }
    }

    /// The node at a place that the mesh was made for.
    pub fn node(&self, at: f64) -> usize {
        nearest(&self.nodes, at)
    }

    /// Forces on the nodes' displacements and slopes that stand for 1 N across the shaft at any place.
    pub fn force_at(&self, at: f64) -> Vec<f64> {
        let mut force = vec![0.0; 2 * self.nodes.len()];
        let last = self.elements.len() - 1;
        let index = self.nodes[1..].iter().position(|end| at <= *end).unwrap_or(last);
        let element = &self.elements[index];
        let shapes = element.displacement_shapes(((at - self.nodes[index]) / element.length).clamp(0.0, 1.0));
        force[2 * index..2 * index + 4].copy_from_slice(&shapes);
        force
    }
}

/// Places of nodes that the shaft and the things on it require, rising.
fn breaks(shaft: &Shaft, ends: &[f64], places: &[f64]) -> Vec<f64> {
    let length = shaft.length();
    let inside = |at: f64| at.clamp(0.0, length);
    let of_discs = shaft.discs.iter().map(|disc| disc.at);
    let mut breaks: Vec<f64> = ends.to_vec();
    for at in of_discs.chain(places.iter().copied()).map(inside) {
        if breaks.iter().all(|known| (known - at).abs() > SAME_PLACE * length) {
            breaks.push(at);
        }
    }
    breaks.sort_by(f64::total_cmp);
    breaks
}

fn of_plane(shaft: &Shaft, elements: &[BeamElement], nodes: &[f64]) -> (Matrices, SymmetricBand) {
    let size = 2 * nodes.len();
    let [mut stiffness, mut mass, mut polar] = std::array::from_fn(|_| SymmetricBand::zeros(size));
    for (index, element) in elements.iter().enumerate() {
        add(&mut stiffness, 2 * index, &element.stiffness());
        add(&mut mass, 2 * index, &element.mass());
        add(&mut polar, 2 * index, &element.polar_inertia());
    }
    for disc in &shaft.discs {
        let slope = 2 * nearest(nodes, disc.at) + 1;
        mass.add(slope - 1, slope - 1, disc.mass);
        mass.add(slope, slope, disc.transverse_inertia);
        polar.add(slope, slope, disc.axial_inertia);
    }
    let centre = shaft.mass_centre();
    let translation = (0..size).map(|i| if i % 2 == 0 { 1.0 } else { 0.0 }).collect();
    let rotation = (0..size).map(|i| if i % 2 == 0 { nodes[i / 2] - centre } else { 1.0 }).collect();
    let length = shaft.length();
    // Compliances of the elements in a row: a thin neck counts by its length.
    let compliance: f64 =
        elements.iter().map(|e| e.length / (e.material.elastic_modulus * e.section.second_moment())).sum();
    let shift = 500.0 / (compliance * length * length * shaft.mass());
    (Matrices { stiffness, mass, rigid: vec![translation, rotation], shift }, polar)
}

fn of_axis(shaft: &Shaft, elements: &[BeamElement], nodes: &[f64]) -> Matrices {
    let [mut stiffness, mut mass] = std::array::from_fn(|_| SymmetricBand::zeros(nodes.len()));
    for (index, element) in elements.iter().enumerate() {
        let (k, m) = (element.axial_stiffness(), element.weight());
        for (row, column, sign, share) in [(0, 0, 1.0, 1.0 / 3.0), (1, 0, -1.0, 1.0 / 6.0), (1, 1, 1.0, 1.0 / 3.0)] {
            stiffness.add(index + row, index + column, sign * k);
            mass.add(index + row, index + column, share * m);
        }
    }
    for disc in &shaft.discs {
        let node = nearest(nodes, disc.at);
        mass.add(node, node, disc.mass);
    }
    let compliance: f64 = elements.iter().map(|element| 1.0 / element.axial_stiffness()).sum();
    let shift = 10.0 / (compliance * shaft.mass());
    Matrices { stiffness, mass, rigid: vec![vec![1.0; nodes.len()]], shift }
}

fn nearest(nodes: &[f64], at: f64) -> usize {
    let distance = |node: f64| (node - at).abs();
    (1..nodes.len()).fold(0, |best, node| if distance(nodes[node]) < distance(nodes[best]) { node } else { best })
}

fn add(band: &mut SymmetricBand, first: usize, element: &ElementMatrix) {
    for (row, values) in element.iter().enumerate() {
        for (column, value) in values.iter().enumerate().take(row + 1) {
            band.add(first + row, first + column, *value);
        }
    }
}
