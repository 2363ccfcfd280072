//! The limits of each field, in the user's units: those of a scene are defined in `physics`, those of a job here.

use raceway_core::physics::frame::structure::HIGHEST_FREQUENCY;
use raceway_core::physics::limits::limits_of;

use super::problem::FieldError;
use super::{numbers, parameters};

/// Largest number of timed runs of each method at each tolerance of an accuracy job.
pub const MAX_REPETITIONS: u32 = 9;

/// Fewest and most samples of an uncertainty job.
pub const MIN_SAMPLES: u32 = 16;
pub const MAX_SAMPLES: u32 = 4096;

/// The limits of a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldLimits {
    /// From the root of a job.
    pointer: &'static str,
    pub lowest: f64,
    pub highest: f64,
    /// True if the lowest value itself is refused.
    pub exclusive: bool,
    pub unit: &'static str,
}

const fn from(pointer: &'static str, lowest: f64, highest: f64, unit: &'static str) -> FieldLimits {
    FieldLimits { pointer, lowest, highest, exclusive: false, unit }
}

/// Largest number of a distribution, in whatever unit: beyond the limits of every field.
const LARGEST: f64 = 1e15;

/// Tightest and loosest relative tolerance.
const TOLERANCES: (f64, f64) = (1e-12, 1e-2);

/// Recorded time of a job without series.
pub const DURATION: FieldLimits = from("/duration_s", 1e-6, 1000.0, "s");

/// Limits of fields of the job.
const OF_A_JOB: [FieldLimits; 43] = [
    DURATION,
    from("/settle_s", 0.0, 1000.0, "s"),
    from("/priority", 1.0, 4.0, ""),
    from("/keep_for_s", 1.0, 315_360_000.0, "s"),
    from("/repetitions", 1.0, MAX_REPETITIONS as f64, ""),
    from("/samples", MIN_SAMPLES as f64, MAX_SAMPLES as f64, ""),
    from("/statistic/percentile", 1.0, 99.0, "%"),
    from("/inputs/distribution/from", -LARGEST, LARGEST, ""),
    from("/inputs/distribution/to", -LARGEST, LARGEST, ""),
    from("/inputs/distribution/mean", -LARGEST, LARGEST, ""),
    from("/inputs/distribution/standard_deviation", 0.0, LARGEST, ""),
    from("/inputs/distribution/mode", -LARGEST, LARGEST, ""),
    from("/inputs/distribution/nominal", -LARGEST, LARGEST, ""),
    from("/inputs/distribution/plus", -LARGEST, LARGEST, ""),
    from("/inputs/distribution/minus", -LARGEST, LARGEST, ""),
    from("/relative_tolerances", TOLERANCES.0, TOLERANCES.1, ""),
    from("/solver/relative_tolerance", TOLERANCES.0, TOLERANCES.1, ""),
    from("/solver/model_tolerance_db", 0.0, 20.0, "dB"),
    from("/solver/fixed_step_us", 1e-3, 1e3, "µs"),
    from("/scene/operation/loads/at_mm", 0.0, 4e6, "mm"),
    from("/scene/bearing/fits/shaft_interference_um", -1000.0, 1000.0, "µm"),
    from("/scene/bearing/fits/shaft_bore_mm", 0.0, 10_000.0, "mm"),
    from("/scene/bearing/fits/housing_interference_um", -1000.0, 1000.0, "µm"),
    from("/scene/bearing/fits/housing_outer_diameter_mm", 0.1, 100_000.0, "mm"),
    from("/scene/bearing/temperatures/inner_ring_c", -100.0, 400.0, "°C"),
    from("/scene/bearing/temperatures/balls_c", -100.0, 400.0, "°C"),
    from("/scene/bearing/temperatures/outer_ring_c", -100.0, 400.0, "°C"),
    from("/scene/bearing/temperatures/ring_expansion_per_k", 0.0, 1e-4, "1/K"),
    from("/scene/bearing/temperatures/ball_expansion_per_k", 0.0, 1e-4, "1/K"),
    from("/scene/bearing/dynamic_load_rating_n", 1.0, 1e8, "N"),
    from("/scene/bearing/static_load_rating_n", 1.0, 1e8, "N"),
    from("/scene/bearing/f0", 1.0, 100.0, ""),
    from("/scene/bearing/fatigue_load_limit_n", 1e-3, 1e8, "N"),
    from("/scene/bearing/raceway_roughness_um", 1e-4, 100.0, "µm"),
    from("/scene/bearing/ball_roughness_um", 1e-4, 100.0, "µm"),
    from("/scene/contamination_factor", 1e-6, 1.0, ""),
    from("/scene/lubricant/temperature_c", -50.0, 200.0, "°C"),
    from("/scene/lubricant/viscosity_40_mm2_s", 2.0, 10_000.0, "mm²/s"),
    from("/scene/lubricant/viscosity_100_mm2_s", 0.5, 5000.0, "mm²/s"),
    from("/scene/lubricant/density_15_kg_m3", 500.0, 2500.0, "kg/m³"),
    from("/outputs/orders/max_order", 0.1, 1e6, ""),
    from("/outputs/orders/turns_per_block", 1.0, 1e6, ""),
    from("/outputs/orders/overlap", 0.0, 0.9, ""),
];

/// Limits of fields of jobs of shafts, without indices of lists.
const OF_A_ROTOR: [FieldLimits; 78] = [
    from("/speeds_rpm", 0.0, 500_000.0, "r/min"),
    from("/speeds_rpm/from", 0.0, 500_000.0, "r/min"),
    from("/speeds_rpm/to", 0.0, 500_000.0, "r/min"),
    from("/speeds_rpm/count", 2.0, 1000.0, ""),
    from("/modes", 1.0, 20.0, ""),
    from("/duration_s", 1e-3, 60.0, "s"),
    from("/settle_s", 0.0, 60.0, "s"),
    from("/step_us", 0.1, 20.0, "µs"),
    from("/mode_range", 0.1, 5.0, ""),
    from("/mode_ranges", 0.1, 5.0, ""),
    from("/reference_range", 0.1, 5.0, ""),
    from("/repetitions", 1.0, MAX_REPETITIONS as f64, ""),
    from("/priority", 1.0, 4.0, ""),
    from("/keep_for_s", 1.0, 315_360_000.0, "s"),
    from("/scene/gravity_m_s2", -1000.0, 1000.0, "m/s²"),
    from("/scene/operation/speed_rpm", 0.0, 500_000.0, "r/min"),
    from("/scene/operation/speed_rpm/rpm", 0.0, 500_000.0, "r/min"),
    from("/scene/operation/outer_speed_rpm", -500_000.0, 500_000.0, "r/min"),
    from("/scene/operation/outer_speed_rpm/rpm", -500_000.0, 500_000.0, "r/min"),
    from("/scene/operation/loads/at_mm", 0.0, 4e6, "mm"),
    from("/scene/operation/radial_load_y_n", -1e7, 1e7, "N"),
    from("/scene/operation/radial_load_z_n", -1e7, 1e7, "N"),
    from("/scene/operation/axial_load_n", -1e7, 1e7, "N"),
    from("/scene/spindle/mass_kg", 1e-9, 1e6, "kg"),
    from("/scene/spindle/centre_mm", 0.0, 20_000.0, "mm"),
    from("/scene/spindle/unbalance_g_mm", 0.0, 1e9, "g·mm"),
    from("/scene/spindle/balance_grade", 0.0, 5000.0, "mm/s"),
    from("/scene/spindle/transverse_inertia_kg_m2", 1e-12, 1e6, "kg m²"),
    from("/scene/spindle/axial_inertia_kg_m2", 1e-12, 1e6, "kg m²"),
    from("/scene/shaft/material/elastic_modulus_gpa", 1e-3, 2000.0, "GPa"),
    from("/scene/shaft/material/poisson_ratio", 0.0, 0.5, ""),
    from("/scene/shaft/material/density_kg_m3", 10.0, 30_000.0, "kg/m³"),
    from("/scene/shaft/damping_ratio", 0.0, 0.5, ""),
    from("/scene/shaft/rotating_share", 0.0, 1.0, ""),
    from("/scene/shaft/sections/length_mm", 0.01, 20_000.0, "mm"),
    from("/scene/shaft/sections/outer_diameter_mm", 0.5, 2000.0, "mm"),
    from("/scene/shaft/sections/inner_diameter_mm", 0.0, 2000.0, "mm"),
    from("/scene/shaft/discs/at_mm", 0.0, 4e6, "mm"),
    from("/scene/shaft/discs/mass_kg", 0.0, 1e6, "kg"),
    from("/scene/shaft/discs/transverse_inertia_kg_m2", 0.0, 1e6, "kg m²"),
    from("/scene/shaft/discs/axial_inertia_kg_m2", 0.0, 1e6, "kg m²"),
    from("/scene/shaft/unbalances/at_mm", 0.0, 4e6, "mm"),
    from("/scene/shaft/unbalances/unbalance_g_mm", 0.0, 1e9, "g·mm"),
    from("/scene/shaft/unbalances/phase_deg", -360.0, 360.0, "°"),
    from("/scene/bearings/at_mm", 0.0, 4e6, "mm"),
    from("/scene/bearings/start_azimuth_deg", 0.0, 360.0, "°"),
    from("/scene/sensors/at_mm", -4e6, 4e6, "mm"),
    from("/scene/bearings/outer_ring/offset_um/x", -1000.0, 1000.0, "µm"),
    from("/scene/bearings/outer_ring/offset_um/y", -1000.0, 1000.0, "µm"),
    from("/scene/bearings/outer_ring/offset_um/z", -1000.0, 1000.0, "µm"),
    from("/scene/bearings/outer_ring/tilt_mrad/y", -20.0, 20.0, "mrad"),
    from("/scene/bearings/outer_ring/tilt_mrad/z", -20.0, 20.0, "mrad"),
    from("/scene/bearings/outer_ring/stiffness_n_per_um", 1e-3, 1e6, "N/µm"),
    from("/scene/bearings/outer_ring/tilt_n_m_per_mrad", 1e-6, 1e9, "N·m/mrad"),
    from("/scene/bearings/outer_ring/damping_n_s_per_m", 0.0, 1e9, "N·s/m"),
    from("/scene/bearings/outer_ring/tilt_damping_n_m_s_per_rad", 0.0, 1e9, "N·m·s/rad"),
    from("/scene/bearings/outer_ring/spring_force_n", 0.0, 1e6, "N"),
    from("/scene/bearings/outer_ring/spring_n_per_um", 0.0, 1e6, "N/µm"),
    from("/scene/bearings/outer_ring/mass_kg", 1e-6, 1e6, "kg"),
    from("/scene/housing/bodies/mass_kg", 1e-6, 1e9, "kg"),
    from("/scene/housing/bodies/at_mm", -4e6, 4e6, "mm"),
    from("/scene/housing/bodies/inertia_kg_m2", 1e-12, 1e12, "kg m²"),
    from("/scene/housing/mounts/at_mm", -4e6, 4e6, "mm"),
    from("/scene/housing/mounts/stiffness_n_per_um", 0.0, 1e6, "N/µm"),
    from("/scene/housing/mounts/damping_n_s_per_m", 0.0, 1e9, "N·s/m"),
    from("/scene/housing/mounts/tilt_n_m_per_mrad", 0.0, 1e9, "N·m/mrad"),
    from("/scene/housing/mounts/tilt_damping_n_m_s_per_rad", 0.0, 1e9, "N·m·s/rad"),
    from("/scene/housing/ports/at_mm", -4e6, 4e6, "mm"),
    from("/scene/housing/modes/frequency_hz", 0.0, HIGHEST_FREQUENCY, "Hz"),
    from("/scene/housing/modes/damping_ratio", 0.0, 0.5, ""),
    from("/scene/housing/modes/mass_kg", 1e-12, 1e12, "kg"),
    from("/scene/preloads/force_n", 0.0, 1e6, "N"),
    from("/scene/preloads/offset_um", -500.0, 500.0, "µm"),
    from("/scene/supports/at_mm", 0.0, 4e6, "mm"),
    from("/scene/supports/stiffness_n_per_um", 0.0, 1e6, "N/µm"),
    from("/scene/supports/damping_n_s_per_m", 0.0, 1e9, "N·s/m"),
    from("/scene/supports/tilt_n_m_per_mrad", 0.0, 1e9, "N·m/mrad"),
    from("/scene/supports/tilt_damping_n_m_s_per_rad", 0.0, 1e9, "N·m·s/rad"),
];

/// The limits of a field of a rotor job, whose pointer may have indices of lists.
pub fn of_rotor_field(pointer: &str) -> Option<&'static FieldLimits> {
    let is_index = |part: &&str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let parts: Vec<&str> = pointer.split('/').filter(|part| !is_index(part)).collect();
    let named = parts.join("/");
    OF_A_ROTOR.iter().find(|limits| limits.pointer == named)
}

/// Every field of a rotor job that has limits.
pub fn all_of_rotor() -> impl Iterator<Item = &'static FieldLimits> {
    OF_A_ROTOR.iter()
}

impl FieldLimits {
    /// Pointer from the root of a job, without indices of lists.
    pub fn pointer(&self) -> &'static str {
        self.pointer
    }
}

/// The limits of a field of a job, or of an item of a list by those of the list; `None` for fields of the scene and fields without limits.
pub fn of_field(pointer: &str) -> Option<&'static FieldLimits> {
    let is_it = |rest: &str| rest.is_empty() || rest.starts_with('/');
    OF_A_JOB.iter().find(|limits| pointer.strip_prefix(limits.pointer).is_some_and(is_it))
}

/// Every field that has limits, by its pointer from the root of a job, without indices of lists.
pub fn all() -> impl Iterator<Item = (String, FieldLimits)> {
    let of_scene = parameters::fields().filter_map(|(parameter, pointer, unit)| {
        let limits = limits_of(parameter)?;
        // Without the rounding error of the conversion.
        let in_user_unit = |value| numbers::significant(unit.to_user(value), 9);
        let (lowest, highest, exclusive) =
            (in_user_unit(limits.lowest), in_user_unit(limits.highest), limits.exclusive);
        Some((format!("/scene{pointer}"), FieldLimits { pointer, lowest, highest, exclusive, unit: unit.name }))
    });
    OF_A_JOB.iter().map(|limits| (limits.pointer.to_owned(), *limits)).chain(of_scene)
}

/// The error; where a number was expected, with the unit and the range of the field.
pub fn with_range(error: FieldError) -> FieldError {
    if !error.detail.contains("expected a number") {
        return error;
    }
    match all().find(|(pointer, _)| *pointer == error.pointer) {
        Some((_, FieldLimits { lowest, highest, exclusive, unit, .. })) => {
            let range = numbers::range(lowest, highest, exclusive, unit);
            FieldError { detail: format!("{}, {range}", error.detail), ..error }
        }
        None => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_of_physics_has_limits() {
        let without: Vec<_> =
            parameters::fields().filter(|field| limits_of(field.0).is_none()).map(|field| field.0).collect();
        // A choice and a list have no range.
        let lists = ["inner", "outer"]
            .map(|ring| ["waviness", "axial_waviness", "defects"].map(|list| format!("surfaces.{ring}.{list}")));
        let of_loads = ["operation.loads", "operation.loads.direction", "operation.loads.points"];
        assert_eq!(without[..2], ["spindle.axial", "spindle.tilt"]);
        assert_eq!(without[2..5], of_loads);
        let of_balls = ["balls.waviness", "balls.defects", "balls"].map(|list| format!("surfaces.{list}"));
        assert_eq!(without[5..], [lists.concat(), of_balls.to_vec()].concat());
        // A limit as it is shown is allowed, to the last bit, when it is sent back in the user's unit.
        for (parameter, pointer, unit) in parameters::fields() {
            let Some(limits) = limits_of(parameter) else { continue };
            let shown =
                [limits.lowest, limits.highest].map(|limit| unit.to_si(numbers::significant(unit.to_user(limit), 9)));
            let inside = shown.map(|limit| (limits.lowest..=limits.highest).contains(&limit));
            assert_eq!(inside, [true, true], "{pointer}: {shown:?}");
        }
        assert!(of_field("/relative_tolerances/3").is_some() && of_field("/duration_series").is_none());
    }
}
