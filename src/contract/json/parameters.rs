//! The parameters that physics names in its errors, each with its JSON field and unit.

use raceway_core::physics::InvalidParameter;

use super::numbers::out_of_range;
use super::problem::FieldError;
use super::units::*;

/// Each parameter of physics with its field under `/scene` and the field's unit.
const FIELDS: [(&str, &str, Unit); 165] = [
    ("bearing.outer_diameter", "/bearing/outer_diameter_mm", MM),
    ("bearing.inner_diameter", "/bearing/inner_diameter_mm", MM),
    ("bearing.width", "/bearing/width_mm", MM),
    ("bearing.ball_count", "/bearing/ball_count", NUMBER),
    ("bearing.ball_diameter", "/bearing/ball_diameter_mm", MM),
    ("bearing.pitch_diameter", "/bearing/pitch_diameter_mm", MM),
    ("bearing.inner_groove_curvature", "/bearing/inner_groove_curvature", NUMBER),
    ("bearing.outer_groove_curvature", "/bearing/outer_groove_curvature", NUMBER),
    ("bearing.radial_clearance", "/bearing/radial_clearance_um", UM),
    ("bearing.contact_angle", "/bearing/contact_angle_deg", DEG),
    ("bearing.materials.ball.elastic_modulus", "/bearing/materials/ball/elastic_modulus_gpa", GPA),
    ("bearing.materials.ball.poisson_ratio", "/bearing/materials/ball/poisson_ratio", NUMBER),
    ("bearing.materials.ball.density", "/bearing/materials/ball/density_kg_m3", KG_M3),
    ("bearing.materials.inner_raceway.elastic_modulus", "/bearing/materials/inner_raceway/elastic_modulus_gpa", GPA),
    ("bearing.materials.inner_raceway.poisson_ratio", "/bearing/materials/inner_raceway/poisson_ratio", NUMBER),
    ("bearing.materials.inner_raceway.density", "/bearing/materials/inner_raceway/density_kg_m3", KG_M3),
    ("bearing.materials.outer_raceway.elastic_modulus", "/bearing/materials/outer_raceway/elastic_modulus_gpa", GPA),
    ("bearing.materials.outer_raceway.poisson_ratio", "/bearing/materials/outer_raceway/poisson_ratio", NUMBER),
    ("bearing.materials.outer_raceway.density", "/bearing/materials/outer_raceway/density_kg_m3", KG_M3),
    ("bearing.materials.cage.elastic_modulus", "/bearing/materials/cage/elastic_modulus_gpa", GPA),
    ("bearing.materials.cage.poisson_ratio", "/bearing/materials/cage/poisson_ratio", NUMBER),
    ("bearing.materials.cage.density", "/bearing/materials/cage/density_kg_m3", KG_M3),
    ("bearing.cage.mass", "/bearing/cage/mass_g", G),
    ("bearing.cage.axial_inertia", "/bearing/cage/axial_inertia_kg_m2", KG_M2),
    ("bearing.cage.transverse_inertia", "/bearing/cage/transverse_inertia_kg_m2", KG_M2),
    ("bearing.cage.offset", "/bearing/cage/offset_mm", MM),
    ("bearing.cage.pocket_clearance", "/bearing/cage/pocket_clearance_mm", MM),
    ("bearing.cage.rim_angle", "/bearing/cage/rim_angle_deg", DEG),
    ("bearing.cage.seat_half_width", "/bearing/cage/seat_half_width_mm", MM),
    ("bearing.cage.friction", "/bearing/cage/friction", NUMBER),
    ("bearing.cage.friction_speed", "/bearing/cage/friction_speed_m_s", M_S),
    ("bearing.cage.bar_stiffness", "/bearing/cage/bar_stiffness_n_per_m", N_PER_M),
    ("bearing.cage.land.clearance", "/bearing/cage/land/clearance_mm", MM),
    ("bearing.cage.land.diameter", "/bearing/cage/land/diameter_mm", MM),
    ("bearing.cage.land.width", "/bearing/cage/land/width_mm", MM),
    ("bearing.cage.film.stiffness", "/bearing/cage/film/stiffness_n_per_m", N_PER_M),
    ("bearing.cage.film.damping", "/bearing/cage/film/damping_n_s_per_m", N_S_PER_M),
    ("spindle.mass", "/spindle/mass_kg", KG),
    ("spindle.unbalance", "/spindle/unbalance_g_mm", G_MM),
    ("spindle.balance_grade", "/spindle/balance_grade", MM_S),
    ("spindle.axial", "/spindle/axial", NUMBER),
    ("spindle.axial.offset", "/spindle/axial/offset_um", UM),
    ("spindle.tilt", "/spindle/tilt", NUMBER),
    ("spindle.transverse_inertia", "/spindle/transverse_inertia_kg_m2", KG_M2),
    ("spindle.axial_inertia", "/spindle/axial_inertia_kg_m2", KG_M2),
    ("lubricant.viscosity", "/lubricant/viscosity_pa_s", PA_S),
    ("lubricant.pressure_viscosity", "/lubricant/pressure_viscosity_per_pa", PER_PA),
    ("lubricant.fill", "/lubricant/fill", NUMBER),
    ("lubricant.inlet_distance", "/lubricant/inlet_distance_mm", MM),
    ("lubricant.traction.at_rest", "/lubricant/traction/at_rest", NUMBER),
    ("lubricant.traction.maximum", "/lubricant/traction/maximum", NUMBER),
    ("lubricant.traction.at_slip", "/lubricant/traction/at_slip_m_s", M_S),
    ("lubricant.traction.limit", "/lubricant/traction/limit", NUMBER),
    ("lubricant.traction.a", "/lubricant/traction/a", NUMBER),
    ("lubricant.traction.b", "/lubricant/traction/b", NUMBER),
    ("lubricant.traction.c", "/lubricant/traction/c", NUMBER),
    ("lubricant.traction.d", "/lubricant/traction/d", NUMBER),
    ("lubricant.traction.stress", "/lubricant/traction/stress_pa", PA),
    ("lubricant.traction.coefficient", "/lubricant/traction/coefficient", NUMBER),
    ("lubricant.traction.regularisation", "/lubricant/traction/regularisation_m_s", M_S),
    ("damping.raceway.restitution", "/damping/raceway/restitution", NUMBER),
    ("damping.raceway.at_speed", "/damping/raceway/at_speed_m_s", M_S),
    ("damping.raceway.viscous", "/damping/raceway/viscous_n_s_per_m", N_S_PER_M),
    ("damping.pocket.restitution", "/damping/pocket/restitution", NUMBER),
    ("damping.pocket.at_speed", "/damping/pocket/at_speed_m_s", M_S),
    ("damping.pocket.viscous", "/damping/pocket/viscous_n_s_per_m", N_S_PER_M),
    ("operation.axial_load", "/operation/axial_load_n", N),
    ("operation.radial_load_y", "/operation/radial_load_y_n", N),
    ("operation.radial_load_z", "/operation/radial_load_z_n", N),
    ("operation.loads", "/operation/loads", NUMBER),
    ("operation.loads.direction", "/operation/loads/direction", NUMBER),
    ("operation.loads.points", "/operation/loads/points", NUMBER),
    ("operation.loads.constant", "/operation/loads/constant_n", N),
    ("operation.loads.constant_moment", "/operation/loads/constant_n_m", N_M),
    ("operation.loads.points.at", "/operation/loads/points/at_s", S),
    ("operation.loads.points.force", "/operation/loads/points/n", N),
    ("operation.loads.points.moment", "/operation/loads/points/n_m", N_M),
    ("operation.loads.harmonic.amplitude", "/operation/loads/harmonic/amplitude_n", N),
    ("operation.loads.harmonic.moment_amplitude", "/operation/loads/harmonic/amplitude_n_m", N_M),
    ("operation.loads.harmonic.frequency", "/operation/loads/harmonic/frequency_hz", HZ),
    ("operation.loads.harmonic.order", "/operation/loads/harmonic/order", NUMBER),
    ("operation.loads.harmonic.phase", "/operation/loads/harmonic/phase_deg", DEG),
    ("operation.loads.rotating.amplitude", "/operation/loads/rotating/amplitude_n", N),
    ("operation.loads.rotating.frequency", "/operation/loads/rotating/frequency_hz", HZ),
    ("operation.loads.rotating.order", "/operation/loads/rotating/order", NUMBER),
    ("operation.loads.rotating.phase", "/operation/loads/rotating/phase_deg", DEG),
    ("operation.loads.series", "/operation/loads/series/hash", N),
    ("operation.loads.series_moment", "/operation/loads/series/hash", N_M),
    ("operation.loads.shock.peak", "/operation/loads/shock/peak_n", N),
    ("operation.loads.shock.moment_peak", "/operation/loads/shock/peak_n_m", N_M),
    ("operation.loads.shock.at", "/operation/loads/shock/at_s", S),
    ("operation.loads.shock.duration", "/operation/loads/shock/duration_s", S),
    ("operation.misalignment.y", "/operation/misalignment_mrad/y", MRAD),
    ("operation.misalignment.z", "/operation/misalignment_mrad/z", MRAD),
    ("operation.initial_perturbation.speed", "/operation/initial_perturbation/speed_mm_s", MM_S),
    ("operation.speed", "/operation/speed_rpm", RPM),
    ("operation.speed", "/operation/speed_rpm/rpm", RPM),
    ("operation.speed.at", "/operation/speed_rpm/at_s", S),
    ("operation.outer_speed", "/operation/outer_speed_rpm", RPM),
    ("operation.outer_speed", "/operation/outer_speed_rpm/rpm", RPM),
    ("operation.outer_speed.at", "/operation/outer_speed_rpm/at_s", S),
    ("surfaces.inner.waviness.order", "/surfaces/inner/waviness/order", NUMBER),
    ("surfaces.inner.waviness.amplitude", "/surfaces/inner/waviness/amplitude_nm", NM),
    ("surfaces.inner.waviness.phase", "/surfaces/inner/waviness/phase_deg", DEG),
    ("surfaces.inner.random_waviness.amplitude", "/surfaces/inner/random_waviness/amplitude_nm", NM),
    ("surfaces.inner.random_waviness.at_order", "/surfaces/inner/random_waviness/at_order", NUMBER),
    ("surfaces.inner.random_waviness.exponent", "/surfaces/inner/random_waviness/exponent", NUMBER),
    ("surfaces.inner.random_waviness.from_order", "/surfaces/inner/random_waviness/from_order", NUMBER),
    ("surfaces.inner.random_waviness.to_order", "/surfaces/inner/random_waviness/to_order", NUMBER),
    ("surfaces.inner.waviness", "/surfaces/inner/waviness", NUMBER),
    ("surfaces.inner.axial_waviness.order", "/surfaces/inner/axial_waviness/order", NUMBER),
    ("surfaces.inner.axial_waviness.amplitude", "/surfaces/inner/axial_waviness/amplitude_nm", NM),
    ("surfaces.inner.axial_waviness.phase", "/surfaces/inner/axial_waviness/phase_deg", DEG),
    ("surfaces.inner.axial_waviness", "/surfaces/inner/axial_waviness", NUMBER),
    ("surfaces.inner.defects.azimuth", "/surfaces/inner/defects/azimuth_deg", DEG),
    ("surfaces.inner.defects.length", "/surfaces/inner/defects/length_mm", MM),
    ("surfaces.inner.defects.width", "/surfaces/inner/defects/width_mm", MM),
    ("surfaces.inner.defects.depth", "/surfaces/inner/defects/depth_um", UM),
    ("surfaces.inner.defects.across", "/surfaces/inner/defects/across_mm", MM),
    ("surfaces.inner.defects", "/surfaces/inner/defects", NUMBER),
    ("surfaces.outer.waviness.order", "/surfaces/outer/waviness/order", NUMBER),
    ("surfaces.outer.waviness.amplitude", "/surfaces/outer/waviness/amplitude_nm", NM),
    ("surfaces.outer.waviness.phase", "/surfaces/outer/waviness/phase_deg", DEG),
    ("surfaces.outer.random_waviness.amplitude", "/surfaces/outer/random_waviness/amplitude_nm", NM),
    ("surfaces.outer.random_waviness.at_order", "/surfaces/outer/random_waviness/at_order", NUMBER),
    ("surfaces.outer.random_waviness.exponent", "/surfaces/outer/random_waviness/exponent", NUMBER),
    ("surfaces.outer.random_waviness.from_order", "/surfaces/outer/random_waviness/from_order", NUMBER),
    ("surfaces.outer.random_waviness.to_order", "/surfaces/outer/random_waviness/to_order", NUMBER),
    ("surfaces.outer.waviness", "/surfaces/outer/waviness", NUMBER),
    ("surfaces.outer.axial_waviness.order", "/surfaces/outer/axial_waviness/order", NUMBER),
    ("surfaces.outer.axial_waviness.amplitude", "/surfaces/outer/axial_waviness/amplitude_nm", NM),
    ("surfaces.outer.axial_waviness.phase", "/surfaces/outer/axial_waviness/phase_deg", DEG),
    ("surfaces.outer.axial_waviness", "/surfaces/outer/axial_waviness", NUMBER),
    ("surfaces.outer.defects.azimuth", "/surfaces/outer/defects/azimuth_deg", DEG),
    ("surfaces.outer.defects.length", "/surfaces/outer/defects/length_mm", MM),
    ("surfaces.outer.defects.width", "/surfaces/outer/defects/width_mm", MM),
    ("surfaces.outer.defects.depth", "/surfaces/outer/defects/depth_um", UM),
    ("surfaces.outer.defects.across", "/surfaces/outer/defects/across_mm", MM),
    ("surfaces.outer.defects", "/surfaces/outer/defects", NUMBER),
    ("bearing.cage.pocket_deviations", "/bearing/cage/pocket_spacing_mrad", MRAD),
    ("surfaces.balls.ball", "/surfaces/balls/ball", NUMBER),
    ("surfaces.balls.diameter_deviation", "/surfaces/balls/diameter_um", UM),
    ("surfaces.balls.waviness.order", "/surfaces/balls/waviness/order", NUMBER),
    ("surfaces.balls.waviness.amplitude", "/surfaces/balls/waviness/amplitude_nm", NM),
    ("surfaces.balls.waviness.phase", "/surfaces/balls/waviness/phase_deg", DEG),
    ("surfaces.balls.random_waviness.amplitude", "/surfaces/balls/random_waviness/amplitude_nm", NM),
    ("surfaces.balls.random_waviness.at_order", "/surfaces/balls/random_waviness/at_order", NUMBER),
    ("surfaces.balls.random_waviness.exponent", "/surfaces/balls/random_waviness/exponent", NUMBER),
    ("surfaces.balls.random_waviness.from_order", "/surfaces/balls/random_waviness/from_order", NUMBER),
    ("surfaces.balls.random_waviness.to_order", "/surfaces/balls/random_waviness/to_order", NUMBER),
    ("surfaces.balls.waviness", "/surfaces/balls/waviness", NUMBER),
    ("surfaces.balls.defects.diameter", "/surfaces/balls/defects/diameter_mm", MM),
    ("surfaces.balls.defects.depth", "/surfaces/balls/defects/depth_um", UM),
    ("surfaces.balls.defects.latitude", "/surfaces/balls/defects/latitude_deg", DEG),
    ("surfaces.balls.defects.longitude", "/surfaces/balls/defects/longitude_deg", DEG),
    ("surfaces.balls.defects", "/surfaces/balls/defects", NUMBER),
    ("surfaces.balls", "/surfaces/balls", NUMBER),
    ("surfaces.every_ball.random_waviness.amplitude", "/surfaces/every_ball/random_waviness/amplitude_nm", NM),
    ("surfaces.every_ball.random_waviness.at_order", "/surfaces/every_ball/random_waviness/at_order", NUMBER),
    ("surfaces.every_ball.random_waviness.exponent", "/surfaces/every_ball/random_waviness/exponent", NUMBER),
    ("surfaces.every_ball.random_waviness.from_order", "/surfaces/every_ball/random_waviness/from_order", NUMBER),
    ("surfaces.every_ball.random_waviness.to_order", "/surfaces/every_ball/random_waviness/to_order", NUMBER),
    ("surfaces.every_ball.diameter_spread", "/surfaces/every_ball/diameter_spread_um", UM),
    ("surfaces.seed", "/surfaces/seed", NUMBER),
    ("gravity", "/gravity_m_s2", M_S2),
];

/// Parameter, field under `/scene` and the field's unit. Where a parameter has several fields, its errors point to the first;
/// places in lists are omitted.
pub fn fields() -> impl Iterator<Item = (&'static str, &'static str, Unit)> {
    FIELDS.iter().copied()
}

/// The error of a parameter that physics refuses, at its JSON field and in the user's unit.
pub fn field_error(error: &InvalidParameter) -> FieldError {
    let parameter = match error {
        InvalidParameter::OutOfRange { parameter, .. } | InvalidParameter::Inconsistent { parameter, .. } => *parameter,
    };
    let (pointer, unit) =
        FIELDS.iter().find(|field| field.0 == parameter).map_or(("", NUMBER), |field| (field.1, field.2));
    let detail = match error {
        InvalidParameter::OutOfRange { value, lowest, highest, exclusive, .. } => {
            out_of_range(unit.to_user(*value), unit.to_user(*lowest), unit.to_user(*highest), *exclusive, unit.name)
        }
        InvalidParameter::Inconsistent { reason, .. } => reason.clone(),
    };
    let items: &[usize] = match error {
        InvalidParameter::Inconsistent { items, .. } => items,
        InvalidParameter::OutOfRange { .. } => &[],
    };
    FieldError::new(format!("/scene{}", with_items(pointer, items)), detail)
}

/// Lists of the scene whose items are objects.
const LISTS: [&str; 5] = ["waviness", "axial_waviness", "defects", "balls", "loads"];

/// A pointer with the places of items behind the lists on its path.
fn with_items(pointer: &str, items: &[usize]) -> String {
    let mut items = items.iter();
    let with_item = |token: &str| match LISTS.contains(&token).then(|| items.next()).flatten() {
        Some(item) => format!("{token}/{item}"),
        None => token.to_owned(),
    };
    pointer.split('/').map(with_item).collect::<Vec<_>>().join("/")
}
