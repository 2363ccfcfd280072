//! Scales and their ticks.

/// A linear scale from values to positions; the range may be descending.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    pub values: (f64, f64),
    pub positions: (f64, f64),
}

impl Scale {
    pub fn at(&self, value: f64) -> f64 {
        let share = (value - self.values.0) / (self.values.1 - self.values.0);
        self.positions.0 + share * (self.positions.1 - self.positions.0)
    }
}

/// Multiples of 1, 2 or 5 times a power of ten within the range, at most `most` (at least 2) intervals, with their labels.
pub fn ticks((from, to): (f64, f64), most: usize) -> Vec<(f64, String)> {
    let rough = (to - from) / most as f64;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|step| *step >= 0.999 * rough);
    let step = step.unwrap_or(10.0 * power);
    let largest = from.abs().max(to.abs());
    let decimals = (-(step * 1.001).log10().floor()).max(0.0) as usize;
    let first = (from / step - 1e-9).ceil() as i64;
    let last = (to / step + 1e-9).floor() as i64;
    (first..=last)
        .map(|i| {
            let value = i as f64 * step;
            let plain = value == 0.0 || (decimals <= 4 && largest < 1e6);
            let text = if plain { format!("{value:.decimals$}") } else { format!("{value:.1e}") };
            // A minus sign instead of a hyphen.
            let text = if value == 0.0 { "0".to_owned() } else { text.replace('-', "−") };
            (value, text)
        })
        .collect()
}

/// A power of ten as text: 0.001 to 1000 written out, others as 10⁻⁶.
pub fn decade(exponent: i32) -> String {
    match exponent {
        0..=3 => format!("{}", 10i32.pow(exponent as u32)),
        -3..=-1 => format!("{:.*}", exponent.unsigned_abs() as usize, 10f64.powi(exponent)),
        _ => {
            let digits = exponent.to_string();
            let raised = digits.chars().map(|c| match c {
                '-' => '⁻',
                digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize - '0' as usize],
            });
            "10".chars().chain(raised).collect()
        }
    }
}

/// The range of all finite values, with a margin; −1 … 1 where there are none.
pub fn range_of<'a>(values: impl IntoIterator<Item = &'a f64>) -> (f64, f64) {
    let finite = values.into_iter().filter(|value| value.is_finite());
    let (least, largest) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    let scale = least.abs().max(largest.abs());
    if least > largest || scale == 0.0 {
        return (-1.0, 1.0);
    }
    // A constant value gets an axis centred on it.
    let margin = (0.06 * (largest - least)).max(1e-3 * scale).max(f64::MIN_POSITIVE);
    (least - margin, largest + margin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        let texts = |range, most| ticks(range, most).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(texts((0.0, 20.0), 10), ["0", "2", "4", "6", "8", "10", "12", "14", "16", "18", "20"]);
        assert_eq!(texts((-0.31, 0.28), 5), ["−0.2", "0", "0.2"]);
        assert_eq!(texts((0.02, 0.12), 5), ["0.02", "0.04", "0.06", "0.08", "0.10", "0.12"]);
        assert_eq!(texts((-3e-7, 3e-7), 4), ["−2.0e−7", "0", "2.0e−7"]);
    }

    #[test]
    fn decades_read_as_numbers_or_powers() {
        assert_eq!([-4, -3, -1, 0, 2, 3, 12].map(decade), ["10⁻⁴", "0.001", "0.1", "1", "100", "1000", "10¹²"]);
    }

    #[test]
    fn range_of_nothing_of_zeros_and_of_a_constant_is_not_empty() {
        assert_eq!(range_of(&[]), (-1.0, 1.0));
        assert_eq!(range_of(&[0.0, 0.0, f64::NAN]), (-1.0, 1.0));
        let (from, to) = range_of(&[5.0, 5.0]);
        assert!(from < 5.0 && 5.0 < to);
    }
}
