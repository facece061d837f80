//! Student's t, and variances of sums over strata, for 95 % intervals from few values.

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF, StudentsT};

/// The 97.5 % point of Student's t; infinite without degrees of freedom.
pub(crate) fn student(freedom: f64) -> f64 {
    // From a million degrees of freedom on, the point changes by less than a millionth, and the library's search may
    // not end.
    StudentsT::new(0.0, 1.0, freedom.min(1e6)).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

/// The estimated variance of a sum over strata, from the sampled values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Variance {
    /// The variance.
    pub value: f64,
    /// Degrees of freedom, which are few if some strata vary more than others (Welch 1947, whose -2 and +2 correct for
    /// the variances being estimates). `None` if nothing varies.
    freedom: Option<f64>,
}

impl Variance {
    /// The variance of the sum of values, each with the number of its stratum.
    pub(crate) fn stratified(values: impl IntoIterator<Item = (usize, f64)>) -> Self {
        // Stratum numbers may come from a file: a map's memory depends only on the values.
        let mut strata: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for (stratum, value) in values {
            strata.entry(stratum).or_default().push(value);
        }
        let (mut variance, mut squares) = (0.0, 0.0);
        for here in strata.into_values() {
            let some = here.len() as f64;
            if some > 1.0 {
                let mean = here.iter().sum::<f64>() / some;
                let here = here.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (some - 1.0) * some;
                variance += here;
                squares += here * here / (some + 1.0);
            }
        }
        let freedom = (squares > 0.0).then(|| variance * variance / squares - 2.0);
        Self { value: variance, freedom }
    }

    /// Degrees of freedom, at most `most`.
    pub(crate) fn freedom(&self, most: f64) -> f64 {
        self.freedom.map_or(most, |freedom| most.min(freedom.max(1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strata_that_vary_more_count_for_few() {
        let pairs = |spread: [f64; 4]| {
            let of = |(stratum, spread): (usize, f64)| [(stratum, 5.0), (stratum, 5.0 + spread)];
            Variance::stratified(spread.into_iter().enumerate().flat_map(of))
        };
        // The sum of two values at distance d has a variance of d squared.
        assert_eq!(pairs([1.0, 2.0, 0.0, 3.0]).value, 14.0);
        assert_eq!(pairs([2.0; 4]).freedom(4.0), 4.0);
        assert_eq!(pairs([2.0; 4]).freedom(100.0), 10.0);
        assert_eq!(pairs([9.0, 0.0, 0.0, 0.0]).freedom(4.0), 1.0);
        assert_eq!(pairs([0.0; 4]), Variance::default());
        assert_eq!(Variance::stratified([(usize::MAX, 1.0), (usize::MAX, 3.0)]).value, 4.0);
    }

    #[test]
    fn students_t_by_the_table() {
        for (freedom, expected) in [
            (1.0, 12.706),
            (2.5, 3.5747),
            (3.0, 3.182),
            (7.3, 2.3451),
            (10.0, 2.228),
            (30.0, 2.042),
            (1000.0, 1.962),
            (1e9, 1.960),
        ] {
            assert!((student(freedom) / expected - 1.0).abs() < 1e-3, "{freedom}: {}", student(freedom));
        }
    }
}
