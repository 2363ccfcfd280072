//! A range of values and their spacing.

use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::significant;
use crate::contract::json::problem::listed;

/// A range of values, both ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    pub from: f64,
    pub to: f64,
    pub scale: Scale,
}

/// Spacing of values in a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    Linear,
    Log,
}

/// Significant digits of computed values: further digits are rounding errors.
const DIGITS: usize = 9;

impl Range {
    /// The range of the axis at `pointer` of the request, linear by default; `None` after an error.
    pub fn of(from: f64, to: f64, scale: Option<&str>, pointer: &str, defaults: &mut Defaults) -> Option<Self> {
        let mut refuse = |field: &str, detail: String| {
            defaults.refuse(format!("{pointer}/{field}"), detail);
            None
        };
        if from == to {
            return refuse("to", "the same as `from`".to_owned());
        }
        if !(to - from).is_finite() || scale == Some("log") && from != 0.0 && !(to / from).is_finite() {
            return refuse("to", format!("too far from `from`, {from:e}: the range overflows double precision"));
        }
        match scale.unwrap_or("linear") {
            "linear" => Some(Self { from, to, scale: Scale::Linear }),
            "log" if from > 0.0 && to > 0.0 => Some(Self { from, to, scale: Scale::Log }),
            "log" => refuse("scale", "`log` needs `from` and `to` above 0".to_owned()),
            other => {
                let other: String = other.chars().take(100).collect();
                refuse("scale", format!("unknown scale `{other}`; scales are {}", listed(["linear", "log"])))
            }
        }
    }

    /// The value at a share of the range, 0–1.
    pub fn at(&self, share: f64) -> f64 {
        if share == 0.0 || share == 1.0 {
            return if share == 0.0 { self.from } else { self.to };
        }
        let value = match self.scale {
            Scale::Linear => self.from + share * (self.to - self.from),
            Scale::Log => self.from * (self.to / self.from).powf(share),
        };
        significant(value, DIGITS)
    }
}
