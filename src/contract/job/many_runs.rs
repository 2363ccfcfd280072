//! Rules that studies and optimum jobs share.

use super::input::JobInput;
use super::kind::JobKind;
use super::varied::Varied;
use crate::contract::json::defaults::Defaults;

/// Reason why an axis conflicts with another.
pub fn already_varied(varied: &Varied, other: &Varied) -> String {
    if varied.name == other.name {
        format!("`{}` is already varied by another axis", varied.name)
    } else {
        format!("`{}` sets the field of the axis `{}`, or a part of it", varied.name, other.name)
    }
}

/// Refuses spectra and series: a job of many simulations keeps none.
pub fn refuse_signals(kind: JobKind, input: &JobInput, defaults: &mut Defaults) {
    let outputs = input.outputs.clone().unwrap_or_default();
    let keeps = |channels: Option<Vec<String>>| channels.is_some_and(|channels| !channels.is_empty());
    let signals = [
        ("/outputs/spectra", keeps(outputs.spectra)),
        ("/outputs/series", keeps(outputs.series)),
        ("/outputs/orders", outputs.orders.is_some()),
    ];
    for (pointer, given) in signals {
        if given {
            defaults.refuse(
                pointer,
                format!("a job of kind `{}` keeps no signals: run the point as a simulation", kind.name()),
            );
        }
    }
}
