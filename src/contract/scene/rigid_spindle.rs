//! A rigid spindle on several bearings.

use super::rotor_bearings::ResolvedBearing;
use super::shaft::check_place;
use super::spindle::{AxialInput, SpindleInput, TiltInput};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::significant;
use crate::contract::json::units::MM;
use raceway_core::physics::defaults::spindle_inertia;
use raceway_core::physics::frame::disc::UnbalancePlane;
use raceway_core::physics::frame::shaft::{Shaft, ShaftMotion, SpindleBody};
use raceway_core::physics::spindle::{AxialHold, SpindleTilt};
use raceway_core::rotor::input::Seat;

const POINTER: &str = "/scene/spindle";

impl SpindleInput {
    /// The spindle as a rigid shaft of a length [mm], and its unbalance. On several bearings it tilts unless it is held. Errors are noted in
    /// `defaults`.
    pub(super) fn resolve_on(
        &mut self,
        bearings: &[ResolvedBearing],
        (length_mm, axial_load, largest_speed): (f64, f64, f64),
        defaults: &mut Defaults,
    ) -> (Shaft, Vec<UnbalancePlane>) {
        let usual = if bearings.len() > 1 { TiltInput::Free } else { TiltInput::Held };
        defaults.fill(format!("{POINTER}/tilt"), &mut self.tilt, usual);
        let mass: f64 = bearings.iter().map(|bearing| bearing.scene.scene.spindle.mass).sum();
        let has_spring = bearings.iter().any(|bearing| matches!(bearing.rotor.seat, Seat::Sliding { .. }));
        let spindle = self.resolve(defaults, significant(mass, 12), axial_load != 0.0 || has_spring);
        let inertias = match spindle.tilt {
            SpindleTilt::Free(inertia) => Some(inertia),
            SpindleTilt::Held => None,
        };
        let fields = [
            ("mass_kg", Some(spindle.mass)),
            ("unbalance_g_mm", self.unbalance_g_mm),
            ("balance_grade", self.balance_grade),
            ("transverse_inertia_kg_m2", inertias.map(|inertia| inertia.transverse)),
            ("axial_inertia_kg_m2", inertias.map(|inertia| inertia.axial)),
        ];
        for (name, value) in fields {
            if let Some(value) = value {
                defaults.check_of_rotor(&format!("{POINTER}/{name}"), value);
            }
        }
        if inertias.is_some_and(|inertia| inertia.axial > 2.0 * inertia.transverse) {
            let detail = "at most twice the inertia about a diameter; a flat disc has twice";
            defaults.refuse(format!("{POINTER}/axial_inertia_kg_m2"), detail);
        }
        let places = || bearings.iter().map(|bearing| MM.to_user(bearing.rotor.at));
        let (first, last) = (places().fold(f64::INFINITY, f64::min), places().fold(0.0, f64::max));
        let middle = significant(0.5 * (first.min(last) + last), 12);
        let centre = defaults.fill(format!("{POINTER}/centre_mm"), &mut self.centre_mm, middle);
        check_place(defaults, (POINTER, "centre_mm"), centre, length_mm);
        let is_axially_free = match spindle.axial {
            AxialHold::Free => true,
            AxialHold::Fixed => false,
            AxialHold::Offset(_) => {
                let detail = "an offset is that of the rings: give `bearings[].outer_ring.offset_um`, or `preloads`";
                defaults.refuse(format!("{POINTER}/axial"), detail);
                false
            }
        };
        if axial_load != 0.0 && self.axial == Some(AxialInput::Fixed) {
            defaults.refuse(format!("{POINTER}/axial"), "`fixed` takes no axial load: give `free`");
        }
        let (inertia, motion) = match inertias {
            Some(inertia) => (inertia, ShaftMotion::Rigid),
            None => (spindle_inertia(spindle.mass), ShaftMotion::Upright),
        };
        let bores = bearings.iter().map(|bearing| bearing.scene.scene.bearing.parameters.inner_diameter);
        let (length, bore) = (MM.to_si(length_mm), bores.fold(0.0, f64::max));
        let body = SpindleBody { mass: spindle.mass, centre: MM.to_si(centre), inertia };
        let product = spindle.unbalance_product(largest_speed);
        let unbalance = (product != 0.0).then_some(UnbalancePlane { at: body.centre, product, phase: 0.0 });
        (Shaft::rigid(body, (length, bore), motion, is_axially_free), unbalance.into_iter().collect())
    }
}
