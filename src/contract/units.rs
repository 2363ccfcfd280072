//! The only place where numbers change units, and the fields that physics names in its errors.

use super::problem::FieldError;
pub use crate::numerics::rounding::significant;
use crate::physics::InvalidParameter;

/// A unit of requests and results: SI value = value · `times` / `over`. A power of ten divides rather
/// than multiplies by its inexact inverse, so that most decimal fractions stay what they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    pub name: &'static str,
    times: f64,
    over: f64,
}

impl Unit {
    pub fn to_si(self, value: f64) -> f64 {
        value * self.times / self.over
    }

    pub fn to_user(self, value: f64) -> f64 {
        value * self.over / self.times
    }
}

const fn si(name: &'static str) -> Unit {
    Unit { name, times: 1.0, over: 1.0 }
}

const fn part(name: &'static str, over: f64) -> Unit {
    Unit { name, times: 1.0, over }
}

const PI: f64 = std::f64::consts::PI;
pub const NUMBER: Unit = si("");
pub const MM: Unit = part("mm", 1e3);
pub const UM: Unit = part("µm", 1e6);
pub const G: Unit = part("g", 1e3);
pub const G_MM: Unit = part("g·mm", 1e6);
pub const MM_S: Unit = part("mm/s", 1e3);
pub const MRAD: Unit = part("mrad", 1e3);
pub const US: Unit = part("µs", 1e6);
pub const GPA: Unit = Unit { name: "GPa", times: 1e9, over: 1.0 };
pub const DEG: Unit = Unit { name: "°", times: PI, over: 180.0 };
pub const RPM: Unit = Unit { name: "r/min", times: PI, over: 30.0 };
const KG: Unit = si("kg");
const KG_M2: Unit = si("kg m²");
const KG_M3: Unit = si("kg/m³");
const N: Unit = si("N");
const N_PER_M: Unit = si("N/m");
const N_S_PER_M: Unit = si("N·s/m");
const M_S: Unit = si("m/s");
const M_S2: Unit = si("m/s²");
const PA: Unit = si("Pa");
const PA_S: Unit = si("Pa·s");
const PER_PA: Unit = si("1/Pa");
const S: Unit = si("s");

/// Each parameter of physics with its field under `/scene` and the field's unit.
const FIELDS: [(&str, &str, Unit); 72] = [
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
    ("operation.misalignment.y", "/operation/misalignment_mrad/y", MRAD),
    ("operation.misalignment.z", "/operation/misalignment_mrad/z", MRAD),
    ("operation.speed", "/operation/speed_rpm", RPM),
    ("operation.speed", "/operation/speed_rpm/rpm", RPM),
    ("operation.speed.at", "/operation/speed_rpm/at_s", S),
    ("gravity", "/gravity_m_s2", M_S2),
];

/// Parameter, field under `/scene` and the field's unit. Where a parameter has several fields, that of its faults is the first;
/// places in lists are left out.
pub fn fields() -> impl Iterator<Item = (&'static str, &'static str, Unit)> {
    FIELDS.iter().copied()
}

/// The field, in the user's unit, of what physics refuses.
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
    FieldError::new(format!("/scene{pointer}"), detail)
}

/// Value, unit and the allowed range in words.
pub fn out_of_range(value: f64, lowest: f64, highest: f64, exclusive: bool, unit: &str) -> String {
    let space = if unit.is_empty() { "" } else { " " };
    // Told to the last digit where rounding would hide what is wrong.
    let told = if [lowest, highest].iter().any(|limit| short(*limit) == short(value)) {
        value.to_string()
    } else {
        short(value)
    };
    format!("{told}{space}{unit}: must be {}", range(lowest, highest, exclusive, unit))
}

/// An allowed range in words.
pub fn range(lowest: f64, highest: f64, exclusive: bool, unit: &str) -> String {
    let space = if unit.is_empty() { "" } else { " " };
    let quantity = |number: f64| format!("{}{space}{unit}", short(number));
    let bounded = |limit: f64| limit.is_finite() && limit.abs() < 1e300;
    match (bounded(lowest), bounded(highest)) {
        (true, true) if exclusive => format!("above {} and at most {}", short(lowest), quantity(highest)),
        (true, true) => format!("from {} to {}", short(lowest), quantity(highest)),
        (true, false) if exclusive => format!("above {}", quantity(lowest)),
        (true, false) => format!("at least {}", quantity(lowest)),
        _ => format!("at most {}", quantity(highest)),
    }
}

/// A number in at most nine significant digits, free of rounding dust.
pub fn short(number: f64) -> String {
    let rounded = significant(number, 9);
    let size = rounded.abs();
    if size == 0.0 || (1e-4..1e9).contains(&size) { format!("{rounded}") } else { format!("{rounded:e}") }
}

/// The number nearest to one of so many significant digits; quick, for many.
pub fn rounded(number: f64, digits: i32) -> f64 {
    if !number.is_finite() {
        return number;
    }
    let (whole, places) = decimal(number, digits);
    of_decimal(whole, places)
}

/// The whole number of so many digits that is nearest to a number whose decimal point is moved by so many places, and these places.
pub fn decimal(number: f64, digits: i32) -> (f64, i32) {
    if number == 0.0 {
        return (number, 0);
    }
    let places = (digits - 1 - number.abs().log10().floor() as i32).min(300);
    // Powers of ten are exact where the factor is a whole number, so that the quotient is the nearest double.
    let whole = if places >= 0 { number * 10_f64.powi(places) } else { number / 10_f64.powi(-places) };
    (whole.round(), places)
}

/// The number whose decimal point was moved.
pub fn of_decimal(whole: f64, places: i32) -> f64 {
    if places >= 0 { whole / 10_f64.powi(places) } else { whole * 10_f64.powi(-places) }
}
