//! Numbers as messages and results show them: rounded, in decimal digits, and allowed ranges as text.

pub use raceway_core::numerics::rounding::significant;

/// The text that a value is outside its allowed range.
pub fn out_of_range(value: f64, lowest: f64, highest: f64, exclusive: bool, unit: &str) -> String {
    let space = if unit.is_empty() { "" } else { " " };
    // Rounding must not make a value look like the limit that it exceeds.
    let shown = if [lowest, highest].iter().any(|limit| short(*limit) == short(value)) {
        value.to_string()
    } else {
        short(value)
    };
    format!("{shown}{space}{unit}: must be {}", range(lowest, highest, exclusive, unit))
}

/// An allowed range as text.
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

/// A number in at most nine significant digits, without the error of a unit conversion.
pub fn short(number: f64) -> String {
    // A negative zero is a zero.
    let rounded = significant(number, 9) + 0.0;
    let size = rounded.abs();
    if size == 0.0 || (1e-4..1e9).contains(&size) { format!("{rounded}") } else { format!("{rounded:e}") }
}

/// The number rounded to `digits` significant digits; faster than `significant`, for long arrays.
pub fn rounded(number: f64, digits: i32) -> f64 {
    if !number.is_finite() {
        return number;
    }
    let (whole, places) = decimal(number, digits);
    of_decimal(whole, places)
}

/// Decimal form of a number: an integer of `digits` digits, and the number of places that its decimal point was moved by.
pub fn decimal(number: f64, digits: i32) -> (f64, i32) {
    if number == 0.0 {
        return (number, 0);
    }
    let places = (digits - 1 - number.abs().log10().floor() as i32).min(300);
    // Powers of ten are exact where the factor is a whole number, so that the quotient is the nearest double.
    let whole = if places >= 0 { number * 10_f64.powi(places) } else { number / 10_f64.powi(-places) };
    (whole.round(), places)
}

/// The number of a decimal form.
pub fn of_decimal(whole: f64, places: i32) -> f64 {
    if places >= 0 { whole / 10_f64.powi(places) } else { whole * 10_f64.powi(-places) }
}
