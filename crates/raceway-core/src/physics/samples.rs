//! A load as equally spaced values from time 0 on, with cubic polynomials between them.

/// Largest number of values.
pub const MOST_VALUES: usize = 2_000_000;
/// Rates [Hz].
pub const RATES: [f64; 2] = [100.0, 200_000.0];

/// Values of a load at times k/rate. Before the first and after the last, the load is constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    rate: f64,
    values: Vec<f64>,
}

impl Samples {
    /// `None` where the rate [Hz] or a value lies outside the limits, or the number of values.
    pub fn new(rate: f64, values: Vec<f64>) -> Option<Self> {
        let is_valid = (RATES[0]..=RATES[1]).contains(&rate)
            && (2..=MOST_VALUES).contains(&values.len())
            && values.iter().all(|value| value.is_finite());
        is_valid.then_some(Self { rate, values })
    }

    /// [Hz]
    pub fn rate(&self) -> f64 {
        self.rate
    }

    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Time of the last value [s].
    pub fn end(&self) -> f64 {
        (self.values.len() - 1) as f64 / self.rate
    }

    /// Value at a time [s]. The slope at a value is that between its neighbours (Catmull and Rom 1974): exact for parabolas.
    pub fn at(&self, time: f64) -> f64 {
        let last = self.values.len() - 1;
        let place = (time * self.rate).clamp(0.0, last as f64);
        let before = (place as usize).min(last - 1);
        let t = place - before as f64;
        let [a, b, c, d] =
            [before.saturating_sub(1), before, before + 1, (before + 2).min(last)].map(|k| self.values[k]);
        b + 0.5 * t * ((c - a) + t * ((2.0 * a - 5.0 * b + 4.0 * c - d) + t * (3.0 * (b - c) + d - a)))
    }

    /// Largest difference from the first value.
    pub fn largest_change(&self) -> f64 {
        self.values.iter().map(|value| (value - self.values[0]).abs()).fold(0.0, f64::max)
    }

    /// The value of largest magnitude.
    pub fn largest(&self) -> f64 {
        self.values.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_are_exact_and_ends_constant() {
        let of = |time: f64| 3.0 + 2e3 * time - 5e5 * time * time;
        let samples = Samples::new(1000.0, (0..20).map(|k| of(f64::from(k) / 1000.0)).collect()).unwrap();
        for time in [1e-3, 2.3e-3, 9.99e-3, 17.5e-3] {
            assert!((samples.at(time) - of(time)).abs() < 1e-11, "{time}");
        }
        assert_eq!((samples.at(-1.0), samples.at(1.0)), (3.0, of(0.019)));
        assert_eq!(samples.end(), 0.019);
    }

    #[test]
    fn values_that_make_no_load_are_refused() {
        assert!(Samples::new(99.0, vec![0.0; 9]).is_none() && Samples::new(1e3, vec![0.0]).is_none());
        assert!(Samples::new(1e3, vec![0.0, f64::NAN]).is_none() && Samples::new(f64::NAN, vec![0.0; 9]).is_none());
    }
}
