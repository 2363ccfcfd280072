//! Numbers and names in messages.

use serde_json::{Value, json};

use crate::contract::json::numbers::significant;
use raceway_core::simulation::error::codes::{Quantity, QuantityError};
use raceway_core::simulation::error::errors::{LevelErrors, QuantityErrors};

/// Deviations of a verification, as a list.
pub fn deviation(levels: &LevelErrors, quantities: Option<&QuantityErrors>) -> String {
    let mut all: Vec<String> = levels.worst().iter().map(|level| format!("{level:.4} dB of a level")).collect();
    if let Some(errors) = quantities {
        let shares = [
            ("the largest load", errors.max_load),
            ("the cage speed", errors.cage_speed),
            ("the slip", errors.max_slip),
            ("the pocket load", errors.max_pocket_load),
            ("the cage orbit", errors.orbit_radius),
        ];
        let named = |(name, share): (&str, f64)| format!("{} % of {name}", significant(100.0 * share, 3));
        all.extend(shares.into_iter().filter(|(_, share)| *share > 0.0).map(named));
    }
    if all.is_empty() { "an unknown amount".into() } else { all.join(", ") }
}

pub fn exceeded(beyond: &[Quantity]) -> String {
    let names: Vec<&str> = beyond.iter().map(|quantity| name(*quantity)).collect();
    if names.is_empty() { String::new() } else { format!("; too much for {}", names.join(", ")) }
}

pub fn listed(errors: &[QuantityError]) -> String {
    let one = |QuantityError { quantity, error, channel }: &QuantityError| match quantity {
        Quantity::Level => {
            let of = channel.map_or(String::new(), |channel| format!(" of {channel}"));
            format!("{}{of} ({error:.1} dB or more)", name(*quantity))
        }
        _ => format!("{} ({:.0} % or more)", name(*quantity), 100.0 * error),
    };
    errors.iter().map(one).collect::<Vec<String>>().join(", ")
}

fn name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Level => "the level",
        Quantity::MaxLoad => "the largest contact load",
        Quantity::Slip => "the largest slip",
        Quantity::CageSpeed => "the cage speed",
        Quantity::PocketLoad => "the largest pocket load",
        Quantity::CageOrbit => "the orbit of the cage",
    }
}

pub fn field(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Level => "level_error_db",
        Quantity::MaxLoad => "max_load_error",
        Quantity::Slip => "max_slip_error",
        Quantity::CageSpeed => "cage_speed_error",
        Quantity::PocketLoad => "max_pocket_load_error",
        Quantity::CageOrbit => "orbit_radius_error",
    }
}

pub fn time(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{} ms", significant(1e3 * seconds, 4))
    } else {
        format!("{} s", significant(seconds, 4))
    }
}

/// A number with one decimal and a minus sign.
pub fn signed(value: f64) -> String {
    format!("{value:.1}").replace('-', "−")
}

pub fn numbers<'a>(values: &[(&'a str, f64)]) -> Vec<(&'a str, Value)> {
    values.iter().map(|(name, value)| (*name, json!(significant(*value, 3)))).collect()
}
