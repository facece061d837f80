//! The residuals of a sample's windows, for intervals of differences between samples of the same windows.

use serde::{Deserialize, Serialize};

use crate::student::{Variance, student};

/// The residuals of a sample's windows. In samples of the same windows they are often correlated: the difference is
/// then known better than either.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Residuals {
    /// Pixels of a window. Samples of the same frames with equal `window_pixels` and `seed` have the same windows.
    pub window_pixels: u64,
    /// The seed that draws the windows.
    pub seed: u64,
    /// Degrees of freedom of the intervals of cycles, L2 and DRAM bytes.
    pub freedom: [f64; 3],
    /// The points of the sample, in the order of the stream. Of a machine measured beside a baseline: the points of the
    /// baseline's sample, with the errors shared with it.
    pub points: Vec<Residual>,
    /// The error that is not shared with the baseline.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<Change>,
}

/// The residuals of a sample that are not shared with its baseline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Relative half widths of the 95 % intervals of the error not shared: of cycles, L2 and DRAM bytes.
    pub half_widths: [f64; 3],
    /// Degrees of freedom.
    pub freedom: [f64; 3],
    /// The points of the sample.
    pub points: Vec<Residual>,
}

/// The residuals at a point of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// Its position on the axis, on which windows have length 1.
    pub place: f64,
    /// Its stratum.
    pub stratum: usize,
    /// Number of windows that it stands for.
    pub weight: f64,
    /// Residuals of cycles, L2 and DRAM bytes, as shares of the stream's totals.
    pub errors: [f64; 3],
}

impl Residuals {
    /// Number of measured windows; several points may lie in one.
    pub fn windows(&self) -> u64 {
        let points = self.change.as_ref().map_or(&self.points, |change| &change.points);
        let mut windows: Vec<u64> = points.iter().map(|point| point.place as u64).collect();
        windows.dedup();
        windows.len() as u64
    }

    /// Half the width of the 95 % interval of the ratio of a figure to another sample's, as a share of the ratio.
    /// `figure` is 0 for cycles, 1 for L2 and 2 for DRAM bytes. `None` if the samples are not of the same windows.
    ///
    /// Where one sample has additional points, the covariance is that of the common points; it shrinks as the variance
    /// of the larger sample does. Errors not shared with a baseline are independent of the baseline's.
    pub fn of_ratio<'a>(&'a self, other: &'a Self, figure: usize) -> Option<f64> {
        if (self.window_pixels, self.seed) != (other.window_pixels, other.seed) {
            return None;
        }
        let points = apart([self, other].map(|it| (it.freedom[figure], it.points.as_slice())), figure)?;
        let change = |it: &'a Self| it.change.as_ref().map_or((f64::INFINITY, &[][..]), |it| it.of(figure));
        Some(points.hypot(apart([change(self), change(other)], figure)?))
    }
}

impl Change {
    fn of(&self, figure: usize) -> (f64, &[Residual]) {
        (self.freedom[figure], &self.points)
    }
}

/// Half the width of the interval of the difference of two samples, each with its degrees of freedom and points. A
/// sample without points is exact.
fn apart(samples: [(f64, &[Residual]); 2], figure: usize) -> Option<f64> {
    let most = samples.iter().filter(|(_, points)| !points.is_empty()).map(|(freedom, _)| *freedom);
    let most = most.fold(f64::INFINITY, f64::min);
    let [one, other] = samples.map(|(_, points)| points);
    let [few, many] = if one.len() > other.len() { [other, one] } else { [one, other] };
    let mut rest = many.iter();
    let both = few.iter().map(|point| Some((point, rest.find(|it| it.place == point.place)?)));
    let both: Vec<_> = both.collect::<Option<_>>()?;
    let of_both = |value: fn(f64, f64) -> f64| {
        let value = |&(few, many): &(&Residual, &Residual)| {
            (few.stratum, few.weight * value(few.errors[figure], many.errors[figure]))
        };
        Variance::stratified(both.iter().map(value))
    };
    let [difference, sum] = [of_both(|few, many| few - many), of_both(|few, many| few + many)];
    let [alone, with] = [of_both(|few, _| few), of_both(|_, many| many)];
    let all = many.iter().map(|point| (point.stratum, point.weight * point.errors[figure]));
    let all = Variance::stratified(all).value;
    let shrunk = if with.value > 0.0 { (all / with.value).min(1.0) } else { 1.0 };
    let alike = (sum.value - difference.value) / 2.0 * shrunk;
    let variance = (alone.value + all - alike).max(0.0);
    Some(student(difference.freedom(most)) * variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sample with `strata` strata of two points each, with residuals `error`.
    fn sample(strata: usize, error: impl Fn(usize) -> f64) -> Residuals {
        let point = |at: usize| Residual { place: at as f64, stratum: at / 2, weight: 2.0, errors: [error(at); 3] };
        let points = (0..2 * strata).map(point).collect();
        Residuals { window_pixels: 512, seed: 0, freedom: [strata as f64; 3], points, change: None }
    }

    #[test]
    fn what_two_samples_are_off_alike_is_in_no_difference() {
        let one = sample(8, |at| (at % 3) as f64);
        let more = sample(8, |at| (at % 3) as f64 + if at % 2 == 0 { 0.1 } else { 0.0 });
        assert_eq!(one.of_ratio(&one, 0), Some(0.0));
        // Each of 8 strata: two points, 0.1 apart, with a weight of 2.
        let expected = student(8.0) * (8.0f64 * 0.04).sqrt();
        for half in [one.of_ratio(&more, 1), more.of_ratio(&one, 2)] {
            assert!((half.unwrap() - expected).abs() < 1e-9, "{half:?} {expected}");
        }
    }

    #[test]
    fn other_windows_are_not_compared() {
        let one = sample(8, |at| at as f64);
        assert_eq!(one.of_ratio(&Residuals { seed: 1, ..one.clone() }, 0), None);
        assert_eq!(one.of_ratio(&Residuals { window_pixels: 8192, ..one.clone() }, 0), None);
        let mut moved = one.clone();
        moved.points[3].place = 3.5;
        assert_eq!(one.of_ratio(&moved, 0), None);
    }

    /// A sample that continued until its strata were halved has a smaller error, and reduces the shared one.
    #[test]
    fn a_larger_sample_narrows_the_difference() {
        let few = sample(8, |at| (at % 5) as f64);
        let halved = |at: usize| {
            let point = few.points[at];
            let other = Residual { place: point.place + 0.5, ..point };
            [point, other].map(|it| Residual { weight: 1.0, stratum: at, errors: it.errors.map(|it| it * 1.1), ..it })
        };
        let mut many = Residuals { points: (0..16).flat_map(halved).collect(), ..few.clone() };
        many.points.iter_mut().skip(1).step_by(4).for_each(|point| point.errors = point.errors.map(|it| it + 0.5));
        let paired = few.of_ratio(&many, 0).unwrap();
        let alone = |of: &Residuals| {
            let values = of.points.iter().map(|it| (it.stratum, it.weight * it.errors[0]));
            student(8.0) * Variance::stratified(values).value.sqrt()
        };
        assert!(paired > 0.0 && paired <= alone(&few) + alone(&many), "{paired} {} {}", alone(&few), alone(&many));
    }
}
