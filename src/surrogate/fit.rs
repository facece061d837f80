//! Finds the kernel parameters that fit given values best.

use super::kernel::Kernel;
use super::process::Process;

/// The most points that the parameter search uses, since its time grows with the cube of their number. Assumed.
const SEARCHED: usize = 120;
/// Factors by which the search changes a parameter, coarse to fine, two rounds each. Assumed.
const FACTORS: [f64; 3] = [3.0, 1.6, 1.2];
/// Rounds over all parameters. Assumed.
const ROUNDS: usize = 6;

/// The process of `values` at `points`. Its kernel parameters have the highest posterior density that a search one
/// parameter at a time finds from `kernel` on.
///
/// # Panics
/// A value or a coordinate is not a number.
pub(crate) fn fit(kernel: Kernel, points: &[Vec<f64>], values: &[f64]) -> Process {
    let every = points.len().div_ceil(SEARCHED).max(1);
    let some: Vec<Vec<f64>> = points.iter().step_by(every).cloned().collect();
    let of_some: Vec<f64> = values.iter().step_by(every).copied().collect();
    let mut best = kernel;
    let mut score = likely(&best, &some, &of_some);
    for round in 0..ROUNDS {
        let factor = FACTORS[(round / 2).min(FACTORS.len() - 1)];
        for parameter in 0..best.parameters().len() {
            for factor in [factor, factor.recip()] {
                // Repeats the step while it helps.
                loop {
                    let mut other = best.clone();
                    *other.parameters()[parameter].0 *= factor;
                    let of_other = likely(&other, &some, &of_some);
                    if of_other <= score + 1e-9 {
                        break;
                    }
                    (best, score) = (other, of_other);
                }
            }
        }
    }
    // Doubles the noise until the covariance matrix stays positive definite despite rounding.
    loop {
        match Process::new(best.clone(), points, values) {
            Some(process) => return process.widened(),
            None => best.noise *= 2.0,
        }
        assert!(best.noise.is_finite(), "points and values are numbers");
    }
}

/// The logarithm of a kernel's posterior density, but for a constant: likelihood of the values times prior of the
/// parameters.
fn likely(kernel: &Kernel, points: &[Vec<f64>], values: &[f64]) -> f64 {
    let beforehand: f64 = kernel.clone().parameters().into_iter().map(|(value, prior)| prior.log_density(*value)).sum();
    let process = Process::new(kernel.clone(), points, values);
    process.map_or(f64::NEG_INFINITY, |process| process.log_likelihood() + beforehand)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{mix, unit};
    use crate::surrogate::Group;

    /// Points in a cube, and the function to fit: a linear term plus the larger of two terms, without noise.
    fn sample(first: u64, count: u64) -> (Vec<Vec<f64>>, Vec<f64>) {
        let point = |at: u64| -> Vec<f64> { (0..3).map(|input| unit(mix(at * 7 + input)) * 2.0 - 1.0).collect() };
        let points: Vec<Vec<f64>> = (first..first + count).map(point).collect();
        let value = |point: &Vec<f64>| 3.0 + 0.2 * point[0] + 0.3 * (point[1] - 0.3 * point[2]).max(0.0);
        let values = points.iter().map(value).collect();
        (points, values)
    }

    fn fitted(count: u64) -> Process {
        let (points, values) = sample(0, count);
        fit(Kernel::new((0..3).map(|at| Group { inputs: at..at + 1 }).collect()), &points, &values)
    }

    #[test]
    fn it_predicts_what_it_has_not_seen() {
        let process = fitted(40);
        let (points, values) = sample(1000, 200);
        let mut errors: Vec<f64> =
            points.iter().zip(&values).map(|(point, value)| (process.predict(point).mean - value).abs()).collect();
        errors.sort_by(f64::total_cmp);
        assert!(errors[180] < 0.02, "nine of ten are within {}", errors[180]);
    }

    #[test]
    fn its_intervals_hold_and_are_no_wider_than_its_errors() {
        let process = fitted(40);
        let (points, values) = sample(1000, 400);
        let found: Vec<_> = points.iter().map(|point| process.predict(point)).collect();
        let errors: Vec<f64> = found.iter().zip(&values).map(|(found, value)| (found.mean - value).abs()).collect();
        let within = found.iter().zip(&errors).filter(|(found, error)| **error <= 2.0 * found.deviation).count();
        assert!(within > 368, "{within} of 400 intervals hold");
        let root = |squares: f64| (squares / 400.0).sqrt();
        let error = root(errors.iter().map(|error| error * error).sum());
        let deviation = root(found.iter().map(|found| found.deviation * found.deviation).sum());
        assert!(deviation < 2.0 * error, "deviations of {deviation} for errors of {error}");
    }

    #[test]
    fn a_value_left_out_is_that_of_a_process_without_it() {
        let (points, values) = sample(0, 12);
        let process = fit(Kernel::new(vec![Group { inputs: 0..3 }]), &points, &values);
        let others = |all: usize| -> Vec<usize> { (0..12).filter(|&at| at != all).collect() };
        for (at, (mean, deviation)) in process.left_out().into_iter().enumerate() {
            let points_of: Vec<_> = others(at).into_iter().map(|other| points[other].clone()).collect();
            let values_of: Vec<_> = others(at).into_iter().map(|other| values[other]).collect();
            let without = Process::new(process.kernel().clone(), &points_of, &values_of).unwrap();
            let found = without.predict(&points[at]);
            assert!((found.mean - mean).abs() < 1e-6, "{} {mean}", found.mean);
            assert!(deviation > 0.0);
        }
    }

    #[test]
    fn what_will_be_known_narrows_others_as_if_it_were() {
        let (points, values) = sample(0, 20);
        let process = fit(Kernel::new(vec![Group { inputs: 0..3 }]), &points, &values);
        let [a, b, other] = [[0.2, 0.2, 0.2], [0.4, -0.5, 0.1], [0.25, 0.1, 0.2]].map(|point| point.to_vec());
        let [at_a, mut at_b, mut found] = [&a, &b, &other].map(|point| process.predict(point));
        process.count_in((&a, &at_a), (&b, &mut at_b));
        process.count_in((&a, &at_a), (&other, &mut found));
        process.count_in((&b, &at_b), (&other, &mut found));
        let (more, any) = ([points, vec![a, b]].concat(), [values, vec![0.0; 2]].concat());
        let known = Process::new(process.kernel().clone(), &more, &any).unwrap().predict(&other);
        // The ratio of intervals with and without the factor from residuals.
        let width = process.predict(&other).deviation
            / Process::new(process.kernel().clone(), &more[..20], &any[..20]).unwrap().predict(&other).deviation;
        assert!((found.deviation / width / known.deviation - 1.0).abs() < 1e-6);
    }
}
