//! A bearing by its clearance group, as the bearing with its clearance in operation.

use super::bearing::{BearingInput, BearingType};
use super::mounting::{
    ClearanceGroupName, FITS, GROUP, OperatingClearance, RingsAndBalls, Sizes, TEMPERATURES, operating_clearance,
};
use crate::contract::json::defaults::Defaults;
use raceway_core::physics::clearance::ClearanceGroup;

/// Replaces the group, fits and temperatures of a bearing by its operating clearance. `ordered`: the group that its designation names.
pub fn mount(
    own: &mut BearingInput,
    base: &BearingInput,
    ordered: Option<ClearanceGroup>,
    materials: &RingsAndBalls,
    defaults: &mut Defaults,
) -> Option<OperatingClearance> {
    let named = own.radial_clearance_group.take().map(ClearanceGroupName::in_physics);
    let (fits, temperatures) = (own.fits.take(), own.temperatures.take());
    if defaults.is_substituted() {
        // The sizes are those of another bearing.
        return None;
    }
    let given = [("radial_clearance_um", own.radial_clearance_um), ("contact_angle_deg", own.contact_angle_deg)];
    let other = given.iter().find_map(|(name, value)| value.map(|_| *name));
    if let (Some(_), Some(other)) = (named, other) {
        defaults.refuse(GROUP, format!("give either radial_clearance_group or {other}: both set the clearance"));
        return None;
    }
    let kind = own.kind.or(base.kind).unwrap_or(BearingType::DeepGroove);
    let Some(group) = named.or(ordered.filter(|_| other.is_none())) else {
        let detail = match kind {
            BearingType::DeepGroove => "takes clearance from a group: give radial_clearance_group, too",
            _ => "takes clearance from a group, which only deep-groove bearings have: leave it out",
        };
        for (pointer, is_given) in [(FITS, fits.is_some()), (TEMPERATURES, temperatures.is_some())] {
            if is_given {
                defaults.refuse(pointer, detail);
            }
        }
        return None;
    };
    if kind != BearingType::DeepGroove {
        let instead = if kind == BearingType::AngularContact { "contact_angle_deg" } else { "radial_clearance_um" };
        let detail = format!("{}: groups are those of deep-groove bearings; give {instead} instead", group.name());
        defaults.refuse(GROUP, detail);
        return None;
    }
    let size = |own: Option<f64>, base: Option<f64>| own.or(base).unwrap_or(f64::NAN);
    let sizes = Sizes {
        bore: size(own.inner_diameter_mm, base.inner_diameter_mm),
        outside: size(own.outer_diameter_mm, base.outer_diameter_mm),
        ball: size(own.ball_diameter_mm, base.ball_diameter_mm),
        pitch: size(own.pitch_diameter_mm, base.pitch_diameter_mm),
    };
    let of_bearing = (&sizes, materials);
    let clearance = operating_clearance(group, fits.as_ref(), temperatures.as_ref(), of_bearing, defaults)?;
    own.radial_clearance_um = Some(clearance.operating_um);
    defaults.filled.push("/scene/bearing/radial_clearance_um".to_owned());
    Some(clearance)
}
