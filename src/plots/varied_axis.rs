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

/// Whether the values are spaced logarithmically, over a wide enough range.
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
    fn logarithmic_spacing_is_recognized() {
        assert!(
            is_logarithmic(&[0.01, 0.1, 1.0])
                && !is_logarithmic(&[1.0, 10.0, 19.0])
                && !is_logarithmic(&[0.0, 9.0, 99.0])
        );
    }
}
