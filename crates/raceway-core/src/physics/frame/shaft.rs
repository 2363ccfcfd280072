//! A shaft: sections of constant diameter, discs and internal damping; or a rigid spindle.

use super::beam::Tube;
use super::disc::Disc;
use crate::physics::material::{GCR15, Material};
use crate::physics::spindle::SpindleInertia;

/// Usual damping ratio of a steel shaft in one piece [-].
pub const USUAL_DAMPING_RATIO: f64 = 0.005;

/// A length of the shaft with constant section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// [m]
    pub length: f64,
    pub tube: Tube,
}

/// Motions that a shaft has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShaftMotion {
    /// It bends and moves as a rigid body.
    Bends,
    /// It moves as a rigid body.
    Rigid,
    /// It moves as a rigid body that is held against tilt.
    Upright,
}

/// A shaft, from its end at 0 along +X.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaft {
    pub material: Material,
    /// At least one.
    pub sections: Vec<Section>,
    pub discs: Vec<Disc>,
    /// Damping ratio of the shaft's own free modes [-].
    pub damping_ratio: f64,
    /// Share of this damping that turns with the shaft, 0 … 1 [-].
    pub rotating_share: f64,
    /// True where the shaft may move and vibrate along X.
    pub is_axially_free: bool,
    pub motion: ShaftMotion,
    /// True if the inertia of its turning parts acts against a tilt.
    pub has_gyroscopic_moments: bool,
}

/// Mass of a rigid spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleBody {
    /// [kg]
    pub mass: f64,
    /// Place of the mass centre [m].
    pub centre: f64,
    pub inertia: SpindleInertia,
}

/// Young's modulus of a rigid spindle over that of steel [-]. Only exported models see it: here a rigid spindle has no bending coordinates.
const RIGID: f64 = 1e4;

impl Shaft {
    /// A rigid spindle of a length and a diameter [m], which are those of its outline: its mass stands at its centre.
    pub fn rigid(
        body: SpindleBody,
        (length, diameter): (f64, f64),
        motion: ShaftMotion,
        is_axially_free: bool,
    ) -> Self {
        let SpindleBody { mass, centre, inertia } = body;
        let outline = Tube { outer_diameter: diameter, inner_diameter: 0.0 };
        let elastic_modulus = RIGID * GCR15.elastic_modulus;
        Self {
            material: Material { elastic_modulus, density: 0.0, ..GCR15 },
            sections: vec![Section { length, tube: outline }],
            discs: vec![Disc {
                at: centre,
                mass,
                transverse_inertia: inertia.transverse,
                axial_inertia: inertia.axial,
            }],
            damping_ratio: 0.0,
            rotating_share: 0.0,
            is_axially_free,
            motion,
            has_gyroscopic_moments: true,
        }
    }

    /// [m]
    pub fn length(&self) -> f64 {
        self.sections.iter().map(|section| section.length).sum()
    }

    /// Mass, discs included [kg].
    pub fn mass(&self) -> f64 {
        self.masses().map(|(mass, _)| mass).sum()
    }

    /// Place of the mass centre [m].
    pub fn mass_centre(&self) -> f64 {
        self.masses().map(|(mass, at)| mass * at).sum::<f64>() / self.mass()
    }

    /// Masses of sections and discs [kg], each with the place of its centre [m].
    fn masses(&self) -> impl Iterator<Item = (f64, f64)> {
        let mut end = 0.0;
        let of_sections = self.sections.iter().map(move |section| {
            let centre = end + 0.5 * section.length;
            end += section.length;
            (self.material.density * section.tube.area() * section.length, centre)
        });
        of_sections.chain(self.discs.iter().map(|disc| (disc.mass, disc.at)))
    }

    /// Ends of the sections, from 0 to the length [m].
    pub fn section_ends(&self) -> Vec<f64> {
        let mut ends = vec![0.0];
        for section in &self.sections {
            ends.push(ends[ends.len() - 1] + section.length);
        }
        ends
    }
}
