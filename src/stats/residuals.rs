//! What a sample's windows leave over: for intervals of what differs between samples of the same windows.

use serde::{Deserialize, Serialize};

use crate::student::{Variance, student};

/// What a sample's windows are off from what is known of them: samples of the same windows are often off alike, and
/// what differs between them is known better than either.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Residuals {
    /// Pixels of a window. Samples of the same frames with the same ones, and the same seed, are of the same windows.
    pub window_pixels: u64,
    /// The seed of the windows.
    pub seed: u64,
    /// Degrees of freedom of the intervals of cycles, L2 and DRAM bytes.
    pub freedom: [f64; 3],
    /// The points of the sample, in the order of the stream. Where the machine was measured beside a baseline: those of
    /// the baseline's sample, and what that is off in what is told of the machine.
    pub points: Vec<Residual>,
    /// What is otherwise than with the baseline.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<Change>,
}

/// What a sample's windows are off otherwise than those of its baseline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Half the widths of the 95 % intervals of what is otherwise: of cycles, L2 and DRAM bytes, as shares.
    pub half_widths: [f64; 3],
    /// Degrees of freedom.
    pub freedom: [f64; 3],
    /// The points of the sample.
    pub points: Vec<Residual>,
}

/// What a point of a sample is off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// Where it lies: windows are of length 1.
    pub place: f64,
    /// Its stratum.
    pub stratum: usize,
    /// Windows that it stands for.
    pub weight: f64,
    /// How far cycles, L2 and DRAM bytes are off, as shares of the stream's.
    pub errors: [f64; 3],
}

impl Residuals {
    /// Windows that were measured: several points may lie in one.
    pub fn windows(&self) -> u64 {
        let points = self.change.as_ref().map_or(&self.points, |change| &change.points);
        let mut windows: Vec<u64> = points.iter().map(|point| point.place as u64).collect();
        windows.dedup();
        windows.len() as u64
    }

    /// Half the width of the 95 % interval of the ratio of a figure to that of another sample, as a share of the ratio;
    /// `figure` is 0 for cycles, 1 for L2 and 2 for DRAM bytes. `None` if the samples are not of the same windows.
    ///
    /// Where one sample has points that the other has not, both vary alike as much as in the points that both have; the
    /// variance that they share shrinks as that of the larger sample does. What is otherwise than with a baseline has
    /// nothing to do with what that is off.
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

/// Half the width of the interval of what two samples are apart, each with degrees of freedom and its points. One
/// without points is exact.
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

    /// A sample of `strata` strata of two points, each off by what `error` says.
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

    /// A sample that went on until its strata were halved tells more, and takes with it what both are off alike.
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
