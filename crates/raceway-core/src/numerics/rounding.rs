//! Decimal rounding.

/// The number rounded to `digits` significant decimal digits.
pub fn significant(number: f64, digits: usize) -> f64 {
    format!("{number:.*e}", digits.saturating_sub(1)).parse().unwrap_or(number)
}
