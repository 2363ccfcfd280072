//! Loads on places of a shaft.

use super::loads::{LoadInput, LoadedBody, POINTER};
use super::shaft::check_place;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::significant;
use crate::contract::json::parameters::field_error;
use crate::contract::json::units::MM;
use raceway_core::physics::InvalidParameter;
use raceway_core::physics::frame::shaft::{Shaft, ShaftMotion};
use raceway_core::physics::loads::{LoadDirection, MOST_LOADS};
use raceway_core::rotor::input::PlacedLoad;

/// Loads on a shaft of a length [mm] that turns at most with a speed [rad/s]. A load with an error is left out. `body`: what requests call the shaft.
pub fn resolve(
    loads: &mut Option<Vec<LoadInput>>,
    (body, shaft, length_mm): (LoadedBody, &Shaft, f64),
    largest_speed: f64,
    defaults: &mut Defaults,
) -> Vec<PlacedLoad> {
    let count = loads.as_ref().map_or(0, Vec::len);
    if count > MOST_LOADS {
        defaults.refuse(POINTER, format!("{count} loads: at most {MOST_LOADS}"));
    }
    let mut placed = Vec::with_capacity(count.min(MOST_LOADS));
    for (index, load) in loads.iter_mut().flatten().enumerate().take(MOST_LOADS) {
        let at = format!("{POINTER}/{index}");
        if load.on.is_some_and(|on| on != body) {
            let detail = match body {
                LoadedBody::Shaft => "the scene has a `shaft` in place of a spindle: leave it out, or give `shaft`",
                LoadedBody::Spindle => {
                    "the scene has a rigid spindle in place of a `shaft`: leave it out, or give `spindle`"
                }
            };
            defaults.refuse(format!("{at}/on"), detail);
        }
        defaults.fill(format!("{at}/on"), &mut load.on, body);
        let centre = significant(MM.to_user(shaft.mass_centre()), 12);
        let place = defaults.fill(format!("{at}/at_mm"), &mut load.at_mm, centre);
        check_place(defaults, (&at, "at_mm"), place, length_mm);
        let Some(resolved) = load.resolve(&at, defaults) else { continue };
        if resolved.direction() == Some(LoadDirection::X) && !shaft.is_axially_free {
            defaults.refuse(format!("{at}/direction"), held_along_x(body));
        }
        let is_moment = resolved.direction().is_some_and(LoadDirection::is_moment);
        if is_moment && shaft.motion == ShaftMotion::Upright {
            let detail = "the spindle does not tilt: give `spindle.tilt` as `free`";
            defaults.refuse(format!("{at}/direction"), detail);
        }
        // Values by themselves were checked already.
        let faults = resolved.faults(index, largest_speed);
        let joint = faults.iter().filter(|fault| matches!(fault, InvalidParameter::Inconsistent { .. }));
        defaults.errors.extend(joint.map(field_error));
        placed.push(PlacedLoad { at: MM.to_si(place), load: resolved });
    }
    placed
}

/// The error of a load or a sensor along X.
pub(super) fn held_along_x(body: LoadedBody) -> &'static str {
    match body {
        LoadedBody::Shaft => "the shaft does not move along X: give `shaft.axial` as `free`",
        LoadedBody::Spindle => "the spindle does not move along X: give `spindle.axial` as `free`",
    }
}
