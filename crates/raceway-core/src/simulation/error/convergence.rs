//! Error of a run from its changes by finer and by coarser steps.
//!
//! With an error C h^p, a repetition in steps h/b deviates from the run by the share 1 − b^−p of the run's error, because the
//! repetition errs, too. A third run in steps a h shows the order p: its deviation from the run is a^p − 1 of that error. The same
//! holds for tolerances.

/// Refinement of a repetition over the coarsening of the third run, as powers: b = a or b = a².
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Spacing {
    Equal,
    Squared,
}

/// Highest order that is counted [-]. Coarse steps are far from the limit in which errors are C h^p: there, orders of up to 5 were seen
/// of runs whose errors were those of order 1 (`benches/compare/compare.py`).
const HIGHEST_ORDER: f64 = 1.0;

/// Error of a run over its deviation from one in finer steps, where errors fall with the highest order that is counted [-]. `ratio`: the
/// steps over the finer ones.
pub(crate) fn error_of_counted_order(ratio: f64) -> f64 {
    let finer = ratio.powf(HIGHEST_ORDER);
    finer / (finer - 1.0)
}

/// Error of a run over its deviation from a repetition in finer steps [-]. `ratio`: deviation of a run in coarser steps, over that of
/// the finer one. `coarser`: a. `None`: the deviations do not fall with the steps, and show no order.
pub(crate) fn error_over_deviation(ratio: f64, coarser: f64, spacing: Spacing) -> Option<f64> {
    // Growth a^p of the error in coarser steps, from ratio = (a^p − 1)/(1 − b^−p).
    let growth = match spacing {
        Spacing::Equal => ratio,
        Spacing::Squared => 0.5 * (ratio + (ratio * (ratio + 4.0)).sqrt()),
    };
    (growth > 1.0).then(|| {
        let growth = growth.min(coarser.powf(HIGHEST_ORDER));
        let finer = match spacing {
            Spacing::Equal => growth,
            Spacing::Squared => growth * growth,
        };
        finer / (finer - 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors h^p of orders up to 1 are found from three runs.
    #[test]
    fn the_order_gives_the_error_back() {
        for (coarser, spacing, finer) in
            [(2.0, Spacing::Squared, 4.0_f64), (2.0, Spacing::Equal, 2.0), (10.0, Spacing::Equal, 10.0)]
        {
            for order in [0.1, 0.5, 0.9, 1.0] {
                let (error, up, down) = (1.0, f64::powf(coarser, order), finer.powf(-order));
                let found = error_over_deviation((up - error) / (error - down), coarser, spacing).unwrap();
                assert!((found * (error - down) / error - 1.0).abs() < 1e-12, "{coarser} {order}: {found}");
            }
        }
    }

    #[test]
    fn a_higher_order_counts_as_the_first_and_no_order_gives_no_error() {
        assert_eq!(error_over_deviation(30.0, 2.0, Spacing::Squared), Some(4.0 / 3.0));
        assert_eq!(error_over_deviation(30.0, 10.0, Spacing::Equal), Some(10.0 / 9.0));
        for (ratio, spacing) in
            [(0.5, Spacing::Squared), (0.1, Spacing::Squared), (1.0, Spacing::Equal), (f64::NAN, Spacing::Equal)]
        {
            assert_eq!(error_over_deviation(ratio, 2.0, spacing), None, "{ratio}");
        }
    }
}
