//! A flexible shaft: sections, discs, unbalance planes, internal damping.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::material::{MaterialChoice, MaterialInput, material};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::short;
use crate::contract::json::shapes::{NameOr, list, optional_list};
use crate::contract::json::units::{DEG, G_MM, MM};
use raceway_core::physics::frame::beam::Tube;
use raceway_core::physics::frame::disc::{Disc, UnbalancePlane};
use raceway_core::physics::frame::shaft::{Section, Shaft, ShaftMotion, USUAL_DAMPING_RATIO};
use raceway_core::rotor::input::Elements;

const POINTER: &str = "/scene/shaft";
const MAX_SECTIONS: usize = 200;
const MAX_DISCS: usize = 100;

/// A flexible shaft, from its end at 0 mm along +X. Elements: Timoshenko beams with shear after Cowper, rotary inertia and gyroscopic
/// moments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ShaftInput {
    /// Material of all sections. Default `gcr15`.
    #[schema(nullable = false, value_type = Option<MaterialChoice>)]
    pub material: Option<NameOr<String, MaterialInput>>,
    /// Sections of constant diameter, in their order along +X.
    #[serde(deserialize_with = "list")]
    #[schema(min_items = 1, max_items = 200)]
    pub sections: Vec<SectionInput>,
    /// Rigid discs. Default: none.
    #[serde(default, deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 100)]
    pub discs: Option<Vec<DiscInput>>,
    /// Eccentric masses. Default: none.
    #[serde(default, deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 100)]
    pub unbalances: Option<Vec<UnbalanceInput>>,
    /// Damping ratio of the shaft's own free modes [-]. Default 0.005.
    #[schema(nullable = false, example = 0.005)]
    pub damping_ratio: Option<f64>,
    /// Share of this damping that turns with the shaft [-]. It drives forward whirl above a threshold speed. Default 0.
    #[schema(nullable = false, example = 0.0)]
    pub rotating_share: Option<f64>,
    /// Motion and vibration of the shaft along X. Default: `free` with an axial load or a sliding outer ring, whose spring reaches the other
    /// bearings through the shaft; else `fixed`.
    #[schema(nullable = false)]
    pub axial: Option<ShaftAxial>,
    /// Elements of the calculation. Default `auto`.
    #[schema(nullable = false)]
    pub elements: Option<ElementsName>,
}

/// A length of constant diameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SectionInput {
    /// Length [mm].
    #[schema(example = 300.0)]
    pub length_mm: f64,
    /// Outer diameter [mm].
    #[schema(example = 25.0)]
    pub outer_diameter_mm: f64,
    /// Bore [mm], below the outer diameter. Default 0.
    #[schema(nullable = false, example = 0.0)]
    pub inner_diameter_mm: Option<f64>,
}

/// A rigid disc.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscInput {
    /// Place along the shaft [mm].
    #[schema(example = 150.0)]
    pub at_mm: f64,
    /// Mass [kg].
    #[schema(example = 1.2)]
    pub mass_kg: f64,
    /// Moment of inertia about a diameter [kg m²]. Default 0.
    #[schema(nullable = false, example = 8e-4)]
    pub transverse_inertia_kg_m2: Option<f64>,
    /// Moment of inertia about the shaft's axis [kg m²]. Default 0.
    #[schema(nullable = false, example = 1.5e-3)]
    pub axial_inertia_kg_m2: Option<f64>,
}

/// An eccentric mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct UnbalanceInput {
    /// Place along the shaft [mm].
    #[schema(example = 150.0)]
    pub at_mm: f64,
    /// Mass times eccentricity [g·mm].
    #[schema(example = 20.0)]
    pub unbalance_g_mm: f64,
    /// Angle from +Y towards +Z when the shaft's angle is 0 [°]. Default 0.
    #[schema(nullable = false, example = 0.0)]
    pub phase_deg: Option<f64>,
}

/// `fixed`: no motion along X. `free`: supports hold the shaft along X.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ShaftAxial {
    Fixed,
    Free,
}

/// `auto`: halved until no asked-for frequency changes by 10⁻⁴. `sections`: one for each section, divided only where a disc, an
/// unbalance or a support acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ElementsName {
    Auto,
    Sections,
}

impl From<ElementsName> for Elements {
    fn from(name: ElementsName) -> Self {
        match name {
            ElementsName::Auto => Self::Auto,
            ElementsName::Sections => Self::Sections,
        }
    }
}

impl ShaftInput {
    /// The shaft and its unbalance planes in SI. `has_spring`: a spring presses on an outer ring. Errors are noted in `defaults`.
    pub fn resolve(
        &mut self,
        defaults: &mut Defaults,
        axial_load: f64,
        has_spring: bool,
    ) -> (Shaft, Vec<UnbalancePlane>) {
        let material = self.material(defaults);
        let sections = self.sections(defaults);
        let length_mm: f64 = self.sections.iter().map(|section| section.length_mm).sum();
        let discs = self.discs(defaults, length_mm);
        let unbalances = self.unbalances(defaults, length_mm);
        let damping = defaults.fill(format!("{POINTER}/damping_ratio"), &mut self.damping_ratio, USUAL_DAMPING_RATIO);
        defaults.check_of_rotor(&format!("{POINTER}/damping_ratio"), damping);
        let share = defaults.fill(format!("{POINTER}/rotating_share"), &mut self.rotating_share, 0.0);
        defaults.check_of_rotor(&format!("{POINTER}/rotating_share"), share);
        let usual = if axial_load != 0.0 || has_spring { ShaftAxial::Free } else { ShaftAxial::Fixed };
        let axial = defaults.fill(format!("{POINTER}/axial"), &mut self.axial, usual);
        if axial == ShaftAxial::Fixed && axial_load != 0.0 {
            defaults.refuse(format!("{POINTER}/axial"), "`fixed` takes no axial load: give `free`");
        }
        defaults.fill(format!("{POINTER}/elements"), &mut self.elements, ElementsName::Auto);
        let shaft = Shaft {
            material,
            sections,
            discs,
            damping_ratio: damping,
            rotating_share: share,
            is_axially_free: axial == ShaftAxial::Free,
            motion: ShaftMotion::Bends,
            has_gyroscopic_moments: true,
        };
        (shaft, unbalances)
    }

    fn material(&mut self, defaults: &mut Defaults) -> raceway_core::physics::material::Material {
        let pointer = format!("{POINTER}/material");
        let given = material(defaults, pointer.clone(), &mut self.material, &None);
        if let Some(NameOr::Object(constants)) = &self.material {
            let fields = [
                ("elastic_modulus_gpa", constants.elastic_modulus_gpa),
                ("poisson_ratio", constants.poisson_ratio),
                ("density_kg_m3", constants.density_kg_m3),
            ];
            for (name, value) in fields {
                defaults.check_of_rotor(&format!("{pointer}/{name}"), value);
            }
        }
        given
    }

    fn sections(&mut self, defaults: &mut Defaults) -> Vec<Section> {
        let count = self.sections.len();
        if count == 0 || count > MAX_SECTIONS {
            defaults
                .refuse(format!("{POINTER}/sections"), format!("{count} sections: must be from 1 to {MAX_SECTIONS}"));
        }
        let mut sections = Vec::with_capacity(count);
        for (index, section) in self.sections.iter_mut().enumerate() {
            let at = format!("{POINTER}/sections/{index}");
            let bore = defaults.fill(format!("{at}/inner_diameter_mm"), &mut section.inner_diameter_mm, 0.0);
            let outer = section.outer_diameter_mm;
            let fields = [("length_mm", section.length_mm), ("outer_diameter_mm", outer), ("inner_diameter_mm", bore)];
            let inside = fields.map(|(name, value)| defaults.check_of_rotor(&format!("{at}/{name}"), value));
            if inside == [true; 3] && bore >= outer {
                let detail = format!("{} mm: must be below the outer diameter, {} mm", short(bore), short(outer));
                defaults.refuse(format!("{at}/inner_diameter_mm"), detail);
            }
            sections.push(Section {
                length: MM.to_si(section.length_mm),
                tube: Tube { outer_diameter: MM.to_si(outer), inner_diameter: MM.to_si(bore) },
            });
        }
        sections
    }

    fn discs(&mut self, defaults: &mut Defaults, length_mm: f64) -> Vec<Disc> {
        let discs = self.discs.get_or_insert_default();
        if discs.len() > MAX_DISCS {
            defaults.refuse(format!("{POINTER}/discs"), format!("{} discs: at most {MAX_DISCS}", discs.len()));
        }
        let mut resolved = Vec::with_capacity(discs.len());
        for (index, disc) in discs.iter_mut().enumerate() {
            let at = format!("{POINTER}/discs/{index}");
            check_place(defaults, (&at, "at_mm"), disc.at_mm, length_mm);
            let mut inertia = |name: &str, field: &mut Option<f64>| defaults.fill(format!("{at}/{name}"), field, 0.0);
            let transverse_inertia = inertia("transverse_inertia_kg_m2", &mut disc.transverse_inertia_kg_m2);
            let axial_inertia = inertia("axial_inertia_kg_m2", &mut disc.axial_inertia_kg_m2);
            let fields = [
                ("mass_kg", disc.mass_kg),
                ("transverse_inertia_kg_m2", transverse_inertia),
                ("axial_inertia_kg_m2", axial_inertia),
            ];
            for (name, value) in fields {
                defaults.check_of_rotor(&format!("{at}/{name}"), value);
            }
            if axial_inertia > 2.0 * transverse_inertia {
                let detail = format!(
                    "{} kg m²: at most twice the transverse inertia, {} kg m²; a flat disc has twice",
                    short(axial_inertia),
                    short(transverse_inertia)
                );
                defaults.refuse(format!("{at}/axial_inertia_kg_m2"), detail);
            }
            resolved.push(Disc { at: MM.to_si(disc.at_mm), mass: disc.mass_kg, transverse_inertia, axial_inertia });
        }
        resolved
    }

    fn unbalances(&mut self, defaults: &mut Defaults, length_mm: f64) -> Vec<UnbalancePlane> {
        let planes = self.unbalances.get_or_insert_default();
        if planes.len() > MAX_DISCS {
            defaults.refuse(format!("{POINTER}/unbalances"), format!("{} planes: at most {MAX_DISCS}", planes.len()));
        }
        let mut resolved = Vec::with_capacity(planes.len());
        for (index, plane) in planes.iter_mut().enumerate() {
            let at = format!("{POINTER}/unbalances/{index}");
            check_place(defaults, (&at, "at_mm"), plane.at_mm, length_mm);
            let phase = defaults.fill(format!("{at}/phase_deg"), &mut plane.phase_deg, 0.0);
            defaults.check_of_rotor(&format!("{at}/phase_deg"), phase);
            defaults.check_of_rotor(&format!("{at}/unbalance_g_mm"), plane.unbalance_g_mm);
            resolved.push(UnbalancePlane {
                at: MM.to_si(plane.at_mm),
                product: G_MM.to_si(plane.unbalance_g_mm),
                phase: DEG.to_si(phase),
            });
        }
        resolved
    }
}

/// Refuses a place beyond the ends of the shaft; `at`: pointer to the object that has it, and its field.
pub(super) fn check_place(defaults: &mut Defaults, (at, field): (&str, &str), at_mm: f64, length_mm: f64) {
    // A sum of lengths is not exact.
    if !(0.0..=length_mm * (1.0 + 1e-12)).contains(&at_mm) {
        let detail = format!("{} mm: must be from 0 to {} mm, the length of the shaft", short(at_mm), short(length_mm));
        defaults.refuse(format!("{at}/{field}"), detail);
    }
}
