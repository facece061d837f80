//! From figures of scale models to that of the large machine.
//!
//! A scale model is off for two reasons, and both shrink with its cores. Rays of one pixel meet in one of its `n` cores
//! with a probability of 1/n, where they share lines, but of 1/N in the large machine. And a burst takes N/n times as
//! long. So figures are nearly lines over 1/n, and nothing of both is left at 1/N.

use crate::report::extrapolate::Prediction;

/// The figure of a machine with `cores`, from those of scale models of it: their cores, fewest first, and figures. It
/// is not below `least`.
///
/// The law is the line through the two largest models. The range reaches as far to both sides as other laws are away:
/// the largest model as it is, and the line through the smallest and the largest.
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

    /// Models of 1, 2 and 4 cores of one of 16.
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
            // The largest model as it is: as far on the other side.
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
            // The line is off by the bend times the distances of both its models.
            assert!((value - truth + bend * 0.1875 * 0.4375).abs() < 1e-9, "{value} {truth}");
        }
    }

    #[test]
    fn no_prediction_is_below_what_any_machine_takes() {
        let found = predict(&[(2, 900.0), (4, 500.0)], 64, 400);
        assert_eq!((found.value, found.low, found.least), (400.0, 400.0, 400));
    }
}
