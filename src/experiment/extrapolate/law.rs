//! Extrapolates a figure of the large machine from figures of its scale models.
//!
//! A scale model has two errors, which shrink as its cores grow. Rays of one pixel are on the same one of `n` cores,
//! and share its lines, with probability 1/n; in the large machine with 1/N. And a burst takes N/n times as long. So
//! figures are nearly linear in 1/n, and both errors vanish at 1/N.

use crate::report::extrapolate::Prediction;

/// Predicts the figure of a machine with `cores` cores from its scale models: their cores, in ascending order, and
/// their figures. The prediction is at least `least`.
///
/// The law is the line through the two largest models. The range is symmetric; its half width is the largest distance
/// to two other laws: the largest model as it is, and the line through the smallest and the largest.
pub(super) fn predict(models: &[(u64, f64)], cores: u64, least: u64) -> Prediction {
    let points: Vec<(f64, f64)> =
        models.iter().rev().map(|&(model, figure)| (1.0 / model as f64 - 1.0 / cores as f64, figure)).collect();
    let [largest, second, ..] = points.as_slice() else { unreachable!("two models make a law") };
    let law = at_zero(largest, second);
    let others = [largest.1, points.last().map_or(law, |smallest| at_zero(largest, smallest))];
    let reach = others.into_iter().map(|other| (other - law).abs()).fold(0.0, f64::max);
    let [value, low, high] = [law, law - reach, law + reach].map(|figure| figure.max(least as f64));
    Prediction { value, low, high, least }
}

/// The value at 0 of the line through two points.
fn at_zero((x, y): &(f64, f64), (other_x, other_y): &(f64, f64)) -> f64 {
    y - (other_y - y) / (other_x - x) * x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Models with 1, 2 and 4 cores, of a machine with 16.
    fn models(law: impl Fn(f64) -> f64) -> Vec<(u64, f64)> {
        [1, 2, 4].map(|cores| (cores, law(1.0 / cores as f64))).to_vec()
    }

    #[test]
    fn a_line_over_the_inverse_of_cores_is_met() {
        let law = |inverse: f64| 1000.0 + 80.0 * inverse;
        for models in [&models(law)[..], &models(law)[1..]] {
            let Prediction { value, low, high, .. } = predict(models, 16, 0);
            let truth = law(1.0 / 16.0);
            assert!((value - truth).abs() < 1e-9, "{value}");
            // The largest model as it is is one end of the range; the other end is as far away.
            assert!((high - law(0.25)).abs() < 1e-9 && (low - (2.0 * truth - law(0.25))).abs() < 1e-9, "{low} {high}");
        }
    }

    #[test]
    fn what_bends_is_within_the_range_of_three_models() {
        for bend in [-300.0, 300.0] {
            let law = |inverse: f64| 1000.0 + 80.0 * inverse + bend * inverse * inverse;
            let Prediction { value, low, high, .. } = predict(&models(law), 16, 0);
            let truth = law(1.0 / 16.0);
            assert!(low <= truth && truth <= high, "{low} {truth} {high}");
            // The error of the line: the bend times the distances of both models.
            assert!((value - truth + bend * 0.1875 * 0.4375).abs() < 1e-9, "{value} {truth}");
        }
    }

    #[test]
    fn no_prediction_is_below_what_any_machine_takes() {
        let found = predict(&[(2, 900.0), (4, 500.0)], 64, 400);
        assert_eq!((found.value, found.low, found.least), (400.0, 400.0, 400));
    }
}
