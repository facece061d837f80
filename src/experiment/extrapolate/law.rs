//! From figures of scale models to that of the large machine.
//!
//! A scale model is off for two reasons, and both shrink with its cores. Rays of one pixel meet in one of its `n` cores
//! with a probability of 1/n, where they share lines, but of 1/N in the large machine. And a burst takes N/n times as
//! long. So figures are lines over 1/n, and where the line crosses 1/N nothing of both is left.

use crate::report::extrapolate::Prediction;

/// The figure of a machine with `cores`, from those of scale models of it: their cores, fewest first, and figures. It
/// is not below `least`.
///
/// The law is the line through the two largest models. The others say how far it may be off: the parabola through the
/// three largest, and the largest model as it is.
pub(super) fn predict(models: &[(u64, f64)], cores: u64, least: u64) -> Prediction {
    let points: Vec<(f64, f64)> =
        models.iter().rev().map(|&(model, figure)| (1.0 / model as f64 - 1.0 / cores as f64, figure)).collect();
    let of = |count: usize| at_zero(&points[..count.min(points.len())]).max(least as f64);
    let laws = [of(1), of(2), of(3)];
    let [low, high] = [laws.into_iter().fold(f64::INFINITY, f64::min), laws.into_iter().fold(0.0, f64::max)];
    Prediction { value: of(2), low, high, least }
}

/// The value at 0 of the polynomial through all points (Lagrange).
fn at_zero(points: &[(f64, f64)]) -> f64 {
    let weight = |at: usize| {
        let others = points.iter().enumerate().filter(|(other, _)| *other != at);
        others.map(|(_, (x, _))| x / (x - points[at].0)).product::<f64>()
    };
    points.iter().enumerate().map(|(at, (_, y))| y * weight(at)).sum()
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
        let Prediction { value, low, high, .. } = predict(&models(law), 16, 0);
        assert!((value - law(1.0 / 16.0)).abs() < 1e-9, "{value}");
        assert!((low - value).abs() < 1e-9 && (high - law(0.25)).abs() < 1e-9, "{low} {high}");
    }

    #[test]
    fn what_is_curved_is_within_what_other_laws_say() {
        for bend in [-300.0, 300.0] {
            let law = |inverse: f64| 1000.0 + 80.0 * inverse + bend * inverse * inverse;
            let Prediction { value, low, high, .. } = predict(&models(law), 16, 0);
            let truth = law(1.0 / 16.0);
            assert!(low - 1e-9 <= truth && truth <= high + 1e-9, "{low} {truth} {high}");
            // The line is off by the bend times both distances.
            assert!((value - truth + bend * 0.1875 * 0.4375).abs() < 1e-9, "{value} {truth}");
        }
    }

    #[test]
    fn no_prediction_is_below_what_any_machine_takes() {
        let found = predict(&[(2, 900.0), (4, 500.0)], 64, 400);
        assert_eq!(found, Prediction { value: 400.0, low: 400.0, high: 500.0, least: 400 });
    }

    #[test]
    fn two_models_have_one_line_and_no_parabola() {
        let found = predict(&[(2, 130.0), (4, 120.0)], 16, 0);
        assert!((found.value - 112.5).abs() < 1e-9 && (found.low - 112.5).abs() < 1e-9, "{found:?}");
    }
}
