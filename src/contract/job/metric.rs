//! Metrics by their pointers: which part of the results contains them, and which scenes have them.

use raceway_core::simulation::input::scene::{Scene, Term, TermChoice};

use super::outputs::{MetricsPart, channel};
use crate::contract::json::problem::listed;

/// The metric of jobs that name none.
pub const LEVEL: &str = "/channels/spindle.y.acceleration/level_db";

/// Metrics as examples.
pub fn examples() -> String {
    listed([LEVEL, "/channels/spindle.z.velocity/rms", "/contacts/inner/max_load_n", "/cage/orbit_radius_um"])
}

/// The part of the metrics that contains a metric; `None` for an unknown one.
pub fn part_of(metric: &str) -> Option<MetricsPart> {
    const OF_CHANNEL: [&str; 5] = ["rms", "peak", "crest_factor", "kurtosis", "above_band"];
    const OF_RACEWAY: [&str; 8] = [
        "max_load_n",
        "max_pressure_mpa",
        "min_contact_angle_deg",
        "max_contact_angle_deg",
        "max_slip_m_s",
        "min_film_thickness_um",
        "mean_off_share",
        "max_off_share",
    ];
    const RATES: [&str; 5] = ["shaft", "cage", "ball_pass_outer", "ball_pass_inner", "double_ball_spin"];
    const HARMONICS: [&str; 4] = ["first", "second", "third", "first_over_rms"];
    let parts: Vec<&str> = metric.strip_prefix('/')?.split('/').collect();
    let is_channel = |channel: &str| match &channel.split('.').collect::<Vec<_>>()[..] {
        ["spindle", axis, quantity] => {
            ["x", "y", "z"].contains(axis) && ["displacement", "velocity", "acceleration"].contains(quantity)
        }
        _ => false,
    };
    match parts[..] {
        ["channels", channel, "level_db"] if is_channel(channel) && channel.ends_with("acceleration") => {
            Some(MetricsPart::Vibration)
        }
        ["channels", channel, name] if is_channel(channel) && OF_CHANNEL.contains(&name) => {
            Some(MetricsPart::Vibration)
        }
        ["channels", channel, "rms_g" | "peak_g" | "velocity_10_1000_hz_mm_s" | "parseval_ratio"]
            if is_channel(channel) && channel.ends_with("acceleration") =>
        {
            Some(MetricsPart::Vibration)
        }
        ["channels", channel, "bands", band, "velocity_rms_um_s" | "acceleration_rms_m_s2" | "anderon"]
            if is_channel(channel) && channel.ends_with("acceleration") && band.parse::<u8>().is_ok() =>
        {
            Some(MetricsPart::Vibration)
        }
        ["channels", channel, "envelope", rate, harmonic]
            if is_channel(channel)
                && channel.ends_with("acceleration")
                && RATES.contains(&rate)
                && HARMONICS.contains(&harmonic) =>
        {
            Some(MetricsPart::Vibration)
        }
        ["contacts", "inner" | "outer", name] if OF_RACEWAY.contains(&name) => Some(MetricsPart::Contacts),
        [
            "life",
            "basic_l10h"
            | "reference_l10h_static"
            | "reference_l10h_dynamic"
            | "equivalent_load_n"
            | "kappa"
            | "lambda"
            | "a_iso",
        ] => Some(MetricsPart::Life),
        [
            "friction",
            "total_n_mm" | "power_loss_w" | "pockets_n_mm" | "neighbours_n_mm" | "land_n_mm" | "drag_n_mm"
            | "churning_n_mm" | "drive_n_mm",
        ]
        | ["friction", "inner" | "outer", "sliding_n_mm" | "rolling_n_mm" | "normal_n_mm"] => {
            Some(MetricsPart::Friction)
        }
        ["contacts", "pocket", "max_load_n"]
        | ["kinematics", "cage_speed_hz" | "cage_slip" | "cage_slip_free_angle" | "ball_spin_hz"]
        | ["cage", "orbit_radius_um" | "whirl_ratio"] => Some(MetricsPart::Cage),
        _ => None,
    }
}

/// Reason why results of a scene never contain the metric; `None`: they may.
pub fn unavailable(metric: &str, scene: &Scene) -> Option<String> {
    let parts: Vec<&str> = metric.split('/').skip(1).collect();
    match parts[..] {
        ["channels", _, "envelope", ..] | ["contacts", _, "mean_off_share" | "max_off_share"]
            if scene.surfaces.are_ideal() =>
        {
            Some(format!("`{metric}` exists only with `surfaces` that are not ideal"))
        }
        ["channels", name, ..] => channel(name, scene).err(),
        ["contacts", "pocket", _] | ["cage", _] if scene.terms.get(Term::Cage) == TermChoice::Off => {
            Some(format!("`{metric}` exists only with a cage (/scene/terms/cage is off)"))
        }
        _ => None,
    }
}
