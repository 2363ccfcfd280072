//! Messages about one of several bearings.

use raceway_core::physics::contact::hertz::STATIC_PRESSURE_LIMIT;
use serde_json::json;

use super::answer::{MessageAnswer, MessageCode, Severity, message};
use crate::contract::json::numbers::significant;

/// A pressure [Pa] by a ball load [N] that deforms a raceway permanently.
pub fn overloaded(bearing: &str, load: f64, pressure: f64) -> MessageAnswer {
    let (load_n, pressure_mpa) = (significant(load, 3), significant(pressure / 1e6, 3));
    let text = format!(
        "The largest pressure in bearing {bearing} was {pressure_mpa} MPa, at a ball load of {load_n} N. Above {:.0} MPa the raceway deforms \
         permanently, and the model is elastic. Reduce the load, or take a larger bearing.",
        STATIC_PRESSURE_LIMIT / 1e6
    );
    let values = [("bearing", json!(bearing)), ("pressure_mpa", json!(pressure_mpa)), ("ball_load_n", json!(load_n))];
    message(MessageCode::Overloaded, Severity::Warning, text, values)
}

/// A thrust [N] over the open side of an angular-contact bearing.
pub fn open_side(bearing: &str, load: f64) -> MessageAnswer {
    let load_n = significant(load, 3);
    let text = format!(
        "Bearing {bearing} carries {load_n} N over its open side, where real rings come apart; the groove of the model has no end. Turn it \
         round by `faces`, raise the preload, or reduce the thrust."
    );
    let values = [("bearing", json!(bearing)), ("thrust_n", json!(load_n))];
    message(MessageCode::OpenSide, Severity::Warning, text, values)
}
