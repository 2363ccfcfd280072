//! The axis of a varied quantity: numbers on a linear or logarithmic scale, or names at equal distances.

use super::axis::{Scale, decade, range_of, ticks};

/// The varied quantity: its name and its values; names have equal distances.
pub struct VariedAxis<'a> {
    pub name: &'a str,
    pub values: AxisValues,
}

/// Values of an axis: numbers or names.
#[derive(Debug, Clone, PartialEq)]
pub enum AxisValues {
    Numbers(Vec<f64>),
    Names(Vec<String>),
}

/// Ratio of largest to smallest value from which on logarithmically spaced values get a logarithmic axis [-].
const MIN_RATIO_LOGARITHMIC: f64 = 8.0;

/// Positions of values on the axis, and its ticks.
pub struct Positions {
    pub at: Vec<f64>,
    pub ticks: Vec<(f64, String)>,
    /// Scale of numbers, and whether it is logarithmic.
    scale: Option<(Scale, bool)>,
}

impl Positions {
    /// Position of a number; `None` on an axis of names.
    pub fn of(&self, value: f64) -> Option<f64> {
        let (scale, logarithmic) = self.scale?;
        Some(scale.at(if logarithmic { value.log10() } else { value }))
    }

    pub fn is_logarithmic(&self) -> bool {
        self.scale.is_some_and(|(_, logarithmic)| logarithmic)
    }
}

impl AxisValues {
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Names(names) => names.len(),
        }
    }

    /// Shortest text of the value with this index.
    pub fn text(&self, index: usize) -> String {
        match self {
            Self::Numbers(values) => values.get(index).map_or(String::new(), |value| {
                // Four digits distinguish neighbours.
                let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(*value);
                let plain = rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs());
                let text = if plain { rounded.to_string() } else { format!("{rounded:e}") };
                text.replace('-', "−")
            }),
            Self::Names(names) => names.get(index).map_or(String::new(), |name| name.chars().take(10).collect()),
        }
    }

    /// Ticks along an axis with one field for each value, in fields from its start: at round numbers, at most `most` intervals. Names, and
    /// numbers at unequal distances, are their own ticks.
    pub fn field_ticks(&self, most: usize) -> Vec<(f64, String)> {
        let round = match self {
            Self::Numbers(values) => round_ticks(values, most),
            Self::Names(_) => None,
        };
        round.unwrap_or_else(|| {
            let every = self.len().div_ceil(most).max(1);
            (0..self.len()).step_by(every).map(|place| (place as f64 + 0.5, self.text(place))).collect()
        })
    }

    /// Positions of the values on an axis between two positions.
    pub fn positions(&self, ends: (f64, f64)) -> Positions {
        match self {
            Self::Names(names) => {
                let scale = Scale { values: (-0.5, names.len() as f64 - 0.5), positions: ends };
                let at: Vec<f64> = (0..names.len()).map(|i| scale.at(i as f64)).collect();
                let shown = names.iter().map(|name| name.chars().take(16).collect());
                Positions { ticks: at.iter().copied().zip(shown).collect(), at, scale: None }
            }
            Self::Numbers(values) => {
                let logarithmic = is_logarithmic(values);
                let mapped: Vec<f64> = values.iter().map(|v| if logarithmic { v.log10() } else { *v }).collect();
                let scale = Scale { values: range_of(&mapped), positions: ends };
                let ticks = if logarithmic { log_ticks(scale.values) } else { ticks(scale.values, 8) };
                Positions {
                    at: mapped.iter().map(|value| scale.at(*value)).collect(),
                    ticks: ticks.into_iter().map(|(value, text)| (scale.at(value), text)).collect(),
                    scale: Some((scale, logarithmic)),
                }
            }
        }
    }
}

/// Round numbers between the edges of the fields of evenly or logarithmically spaced values; `None` for others.
fn round_ticks(values: &[f64], most: usize) -> Option<Vec<(f64, String)>> {
    let logarithms: Vec<f64> = values.iter().map(|value| value.log10()).collect();
    let (values, step, is_logarithmic) = match (even_step(values), even_step(&logarithms)) {
        (Some(step), _) => (values, step, false),
        (None, Some(step)) => (&logarithms[..], step, true),
        (None, None) => return None,
    };
    let (from, to) = (values[0] - 0.5 * step, values[values.len() - 1] + 0.5 * step);
    let range = (from.min(to), from.max(to));
    let found = if is_logarithmic { log_ticks(range) } else { ticks(range, most) };
    (found.len() > 1).then(|| found.into_iter().map(|(value, text)| ((value - from) / step, text)).collect())
}

/// Largest deviation from equal distances [-] of values that were computed with rounding or sent with four digits.
const UNEVEN: f64 = 1e-3;

/// Distance of evenly spaced values.
fn even_step(values: &[f64]) -> Option<f64> {
    let [first, .., last] = values else { return None };
    let step = (last - first) / (values.len() - 1) as f64;
    let is_even = |(place, value): (usize, &f64)| (value - first - place as f64 * step).abs() <= UNEVEN * step.abs();
    (step != 0.0 && step.is_finite() && values.iter().enumerate().all(is_even)).then_some(step)
}

/// True if the values are spaced logarithmically, over a wide enough range.
fn is_logarithmic(values: &[f64]) -> bool {
    let (least, most) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    if values.len() < 3 || least <= 0.0 || most / least < MIN_RATIO_LOGARITHMIC {
        return false;
    }
    let spread = |mapped: &[f64]| {
        let steps: Vec<f64> = mapped.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
        let (least, most) = steps.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), s| (a.min(*s), b.max(*s)));
        most / least.max(f64::MIN_POSITIVE)
    };
    spread(&values.iter().map(|value| value.ln()).collect::<Vec<_>>()) < spread(values)
}

fn log_ticks((from, to): (f64, f64)) -> Vec<(f64, String)> {
    let multiples: &[i32] = if to - from < 2.5 { &[1, 2, 5] } else { &[1] };
    let mut ticks = Vec::new();
    for exponent in from.floor() as i32..=to.ceil() as i32 {
        for &multiple in multiples {
            let at = f64::from(multiple).log10() + f64::from(exponent);
            if (from..=to).contains(&at) {
                let plain = f64::from(multiple) * 10_f64.powi(exponent);
                let text = if multiple == 1 { decade(exponent) } else { format!("{plain}") };
                ticks.push((at, text));
            }
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_have_ticks_at_round_numbers() {
        let texts = |values: &[f64]| -> Vec<(f64, String)> {
            let found = AxisValues::Numbers(values.to_vec()).field_ticks(4).into_iter();
            found.map(|(place, text)| ((1e6 * place).round() / 1e6, text)).collect()
        };
        let of = |pairs: &[(f64, &str)]| -> Vec<(f64, String)> {
            pairs.iter().map(|(place, text)| (*place, (*text).to_owned())).collect()
        };
        assert_eq!(texts(&[3.0, 8.0, 13.0]), of(&[(0.9, "5"), (1.9, "10"), (2.9, "15")]));
        assert_eq!(texts(&[13.0, 8.0, 3.0]), of(&[(2.1, "5"), (1.1, "10"), (0.1, "15")]));
        assert_eq!(texts(&[1.0, 10.0, 100.0]).len(), 3);
        assert_eq!(texts(&[1.0, 2.0, 7.0]), of(&[(0.5, "1"), (1.5, "2"), (2.5, "7")]));
        assert_eq!(texts(&[4.0]), of(&[(0.5, "4")]));
        assert_eq!(AxisValues::Names(vec!["a".into()]).field_ticks(4), of(&[(0.5, "a")]));
    }

    #[test]
    fn logarithmic_spacing_is_recognized() {
        assert!(
            is_logarithmic(&[0.01, 0.1, 1.0])
                && !is_logarithmic(&[1.0, 10.0, 19.0])
                && !is_logarithmic(&[0.0, 9.0, 99.0])
        );
    }
}
