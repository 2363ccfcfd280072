//! An additive expansion of a result in its inputs, and the share of the variance that each input explains (B. Sudret, Reliab. Eng. Syst.
//! Saf. 93, 2008, without products of inputs).

use super::basis::Basis;
use super::order_statistics::percentile;
use crate::numerics::random::SplitMix64;
use crate::numerics::statistics::mean;

/// Largest degree.
const MAX_DEGREE: usize = 6;
/// Columns that repeat others to this share of their length add nothing.
const DEPENDENT: f64 = 1e-9;
/// Points that decide their own fit to this share cannot be left out.
const DECIDES_ITSELF: f64 = 1e-9;
/// Repeated fits for the intervals, and the shares of them at both ends.
pub const REPEATS: usize = 200;
pub const ENDS: [f64; 2] = [0.025, 0.975];

/// Shares of the variance that the inputs explain one by one.
#[derive(Debug, Clone, PartialEq)]
pub struct Expansion {
    pub degree: usize,
    /// 1 less the mean square error of predicting each point from the others over the variance: what is missing to 1 is interaction,
    /// roughness and noise. Negative where the mean predicts better.
    pub q2: f64,
    pub inputs: Vec<InputShare>,
}

/// Effect of one input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InputShare {
    /// Share of the variance.
    pub share: f64,
    /// Interval of the share that contains 95 % of repeated fits with exchanged errors.
    pub interval: [f64; 2],
    /// Coefficient of the first function: positive where the result rises with the input.
    pub slope: f64,
}

/// Orthonormal columns of the points and the rest of the values that they do not explain.
struct Fit {
    /// Orthonormal columns, each with the input of its function, `None` for the constant, and its coefficients of the given functions.
    columns: Vec<Column>,
    rest: Vec<f64>,
    /// Share of each point in its own fit.
    leverage: Vec<f64>,
}

#[derive(Clone)]
struct Column {
    input: Option<usize>,
    unit: Vec<f64>,
    /// Its function in terms of the columns up to this one, the last entry its own length.
    mix: Vec<f64>,
    /// Product with the values.
    amount: f64,
}

impl Fit {
    fn new(values: &[f64]) -> Self {
        let mut fit = Self { columns: Vec::new(), rest: values.to_vec(), leverage: vec![0.0; values.len()] };
        fit.add(None, vec![1.0; values.len()]);
        fit
    }

    /// Adds a function by its values at the points. One that repeats earlier ones is left out.
    fn add(&mut self, input: Option<usize>, mut unit: Vec<f64>) {
        let whole = length(&unit);
        let mut mix = vec![0.0; self.columns.len()];
        // Twice is enough for full orthogonality.
        for _ in 0..2 {
            for (known, part) in self.columns.iter().zip(&mut mix) {
                let amount = dot(&known.unit, &unit);
                *part += amount;
                unit.iter_mut().zip(&known.unit).for_each(|(x, y)| *x -= amount * y);
            }
        }
        let own = length(&unit);
        if own <= DEPENDENT * whole {
            return;
        }
        unit.iter_mut().for_each(|x| *x /= own);
        mix.push(own);
        let amount = dot(&unit, &self.rest);
        for ((rest, leverage), x) in self.rest.iter_mut().zip(&mut self.leverage).zip(&unit) {
            *rest -= amount * x;
            *leverage += x * x;
        }
        self.columns.push(Column { input, unit, mix, amount });
    }

    /// Mean square error of the points, each predicted from all others; `None` where a point cannot be predicted.
    fn left_out_error(&self) -> Option<f64> {
        let errors = self.rest.iter().zip(&self.leverage).map(|(rest, leverage)| {
            let without = 1.0 - leverage;
            (without > DECIDES_ITSELF).then(|| (rest / without).powi(2))
        });
        let errors: Option<Vec<f64>> = errors.collect();
        errors.map(|errors| mean(&errors))
    }

    /// Coefficients of the functions for the amounts of the columns.
    fn coefficients(&self, amounts: &[f64]) -> Vec<f64> {
        let mut left = amounts.to_vec();
        for (place, column) in self.columns.iter().enumerate().rev() {
            left[place] /= column.mix[place];
            let own = left[place];
            for (before, part) in left[..place].iter_mut().zip(&column.mix) {
                *before -= own * part;
            }
        }
        left
    }

    /// Shares of the inputs, not limited to 0 … 1, and the coefficients of their first functions.
    fn shares(&self, amounts: &[f64], inputs: usize, variance: f64) -> (Vec<f64>, Vec<f64>) {
        let (mut shares, mut slopes) = (vec![0.0; inputs], vec![None; inputs]);
        for (column, coefficient) in self.columns.iter().zip(self.coefficients(amounts)) {
            if let Some(input) = column.input {
                shares[input] += coefficient * coefficient / variance;
                slopes[input].get_or_insert(coefficient);
            }
        }
        (shares, slopes.into_iter().map(Option::unwrap_or_default).collect())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn length(of: &[f64]) -> f64 {
    dot(of, of).sqrt()
}

/// The expansion of values at points of the unit cube, whose degree has the least error of points left out among those with at most half
/// as many coefficients as points. `None` where all values are equal, or too few for any degree.
pub fn expansion(bases: &[Basis], points: &[&[f64]], values: &[f64], seed: u64) -> Option<Expansion> {
    expansion_up_to(MAX_DEGREE, bases, points, values, seed)
}

/// [`expansion`] of no more than a degree.
pub(super) fn expansion_up_to(
    most: usize,
    bases: &[Basis],
    points: &[&[f64]],
    values: &[f64],
    seed: u64,
) -> Option<Expansion> {
    let middle = mean(values);
    let variance = mean(&values.iter().map(|value| (value - middle).powi(2)).collect::<Vec<_>>());
    if variance <= (f64::EPSILON * middle).powi(2) {
        return None;
    }
    let mut fit = Fit::new(values);
    let mut best: Option<(f64, usize, usize)> = None;
    for degree in 1..=most {
        let count = |degree: usize| bases.iter().map(|basis| basis.count(degree)).sum::<usize>();
        let grows = degree == 1 || count(degree) > count(degree - 1);
        if !grows || 2 * (1 + count(degree)) > values.len() {
            break;
        }
        for (input, basis) in bases.iter().enumerate() {
            let known = if degree == 1 { 0 } else { basis.count(degree - 1) };
            for function in known..basis.count(degree) {
                fit.add(Some(input), points.iter().map(|point| basis.value(function, point[input])).collect());
            }
        }
        if let Some(error) = fit.left_out_error()
            && best.is_none_or(|(least, ..)| error < least)
        {
            best = Some((error, degree, fit.columns.len()));
        }
    }
    let (error, degree, columns) = best?;
    let fit = of_columns(values, &fit.columns[..columns]);
    let amounts: Vec<f64> = fit.columns.iter().map(|column| column.amount).collect();
    let (shares, slopes) = fit.shares(&amounts, bases.len(), variance);
    let repeats = repeats(&fit, &amounts, bases.len(), values, seed);
    let inputs = shares.iter().zip(slopes).enumerate().map(|(input, (share, slope))| {
        let repeated: Vec<f64> = repeats.iter().map(|shares| shares[input]).collect();
        InputShare { share: *share, interval: interval(*share, repeated), slope }
    });
    Some(Expansion { degree, q2: 1.0 - error / variance, inputs: inputs.collect() })
}

/// The fit of the first columns of a larger one.
fn of_columns(values: &[f64], columns: &[Column]) -> Fit {
    let (mut rest, mut leverage) = (values.to_vec(), vec![0.0; values.len()]);
    for column in columns {
        for ((rest, leverage), x) in rest.iter_mut().zip(&mut leverage).zip(&column.unit) {
            *rest -= column.amount * x;
            *leverage += x * x;
        }
    }
    Fit { columns: columns.to_vec(), rest, leverage }
}

/// Shares of fits to the fitted values with errors drawn among those of all points (B. Efron & R. J. Tibshirani, An Introduction to the
/// Bootstrap, 1993, §9.4, errors enlarged to what they are without their own point).
fn repeats(fit: &Fit, amounts: &[f64], inputs: usize, values: &[f64], seed: u64) -> Vec<Vec<f64>> {
    let enlarged = fit.rest.iter().zip(&fit.leverage).map(|(rest, leverage)| rest / (1.0 - leverage).max(0.01).sqrt());
    let mut errors: Vec<f64> = enlarged.collect();
    let middle = mean(&errors);
    errors.iter_mut().for_each(|error| *error -= middle);
    let fitted: Vec<f64> = values.iter().zip(&fit.rest).map(|(value, rest)| value - rest).collect();
    let mut random = SplitMix64::new(seed);
    let mut repeat = || {
        let drawn: Vec<f64> = errors.iter().map(|_| errors[(random.next() % errors.len() as u64) as usize]).collect();
        let new: Vec<f64> =
            fit.columns.iter().zip(amounts).map(|(column, amount)| amount + dot(&column.unit, &drawn)).collect();
        let values: Vec<f64> = fitted.iter().zip(&drawn).map(|(value, error)| value + error).collect();
        let middle = mean(&values);
        let variance = mean(&values.iter().map(|value| (value - middle).powi(2)).collect::<Vec<_>>());
        fit.shares(&new, inputs, variance.max(f64::MIN_POSITIVE)).0
    };
    (0..REPEATS).map(|_| repeat()).collect()
}

/// Interval of a share from repeated ones. These have the errors twice, which only add to squares, so their mean is moved to the share.
pub fn interval(share: f64, mut repeated: Vec<f64>) -> [f64; 2] {
    let off = share - mean(&repeated);
    repeated.sort_by(f64::total_cmp);
    ENDS.map(|end| (percentile(&repeated, end).unwrap_or(share) + off).clamp(0.0, 1.0))
}
