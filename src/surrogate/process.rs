//! A Gaussian process conditioned on values at points, and its predictions elsewhere.

use super::cholesky::{Cholesky, dot};
use super::kernel::Kernel;
use crate::student::student;

/// A Gaussian process conditioned on values at points.
#[derive(Clone, Debug)]
pub(crate) struct Process {
    kernel: Kernel,
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    factor: Cholesky,
    /// The inverse of the covariance matrix times the values.
    weights: Vec<f64>,
    /// Factor by which intervals are wider than the process itself predicts, from its leave-one-out residuals; at
    /// least 1.
    width: f64,
}

/// The prediction at a point.
#[derive(Clone, Debug)]
pub(crate) struct Prediction {
    /// The expected value.
    pub(crate) mean: f64,
    /// The standard deviation.
    pub(crate) deviation: f64,
    /// The covariances of the point with the known points, solved by the Cholesky factor.
    known: Vec<f64>,
}

impl Process {
    /// The process with `kernel` and these values at these points; `None` if rounding makes the covariance matrix not
    /// positive definite.
    pub(super) fn new(kernel: Kernel, points: &[Vec<f64>], values: &[f64]) -> Option<Self> {
        let noise = kernel.noise * kernel.noise;
        let cell = |row: usize, column: usize| {
            let own = if row == column { noise } else { 0.0 };
            kernel.covariance(&points[row], &points[column]) + own
        };
        let factor = Cholesky::new(points.len(), cell)?;
        let weights = factor.backward(&factor.forward(values));
        Some(Self { kernel, points: points.to_vec(), values: values.to_vec(), factor, weights, width: 1.0 })
    }

    /// Widens the intervals to fit the leave-one-out residuals, and never narrows them.
    pub(super) fn widened(mut self) -> Self {
        let left_out = self.left_out();
        let square = |((mean, deviation), value): (&(f64, f64), &f64)| ((value - mean) / deviation).powi(2);
        let squares: f64 = left_out.iter().zip(&self.values).map(square).sum();
        self.width = (squares / self.values.len().max(1) as f64).sqrt().max(1.0);
        self
    }

    /// The process's kernel.
    pub(crate) fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// The logarithm of the values' likelihood (2.30), but for a constant.
    pub(super) fn log_likelihood(&self) -> f64 {
        -0.5 * (dot(&self.values, &self.weights) + self.factor.log_determinant())
    }

    /// Predicts the value at a point, with noise.
    pub(crate) fn predict(&self, point: &[f64]) -> Prediction {
        let shared: Vec<f64> = self.points.iter().map(|known| self.kernel.covariance(known, point)).collect();
        let known = self.factor.forward(&shared);
        let own = self.kernel.covariance(point, point) + self.kernel.noise * self.kernel.noise;
        let variance = (own - dot(&known, &known)).max(0.0);
        Prediction { mean: dot(&shared, &self.weights), deviation: self.width * variance.sqrt(), known }
    }

    /// Narrows the prediction at `other` as if the value at `point` were known. The mean stays as it is.
    pub(crate) fn count_in(
        &self,
        (point, at_point): (&[f64], &Prediction),
        (other, at_other): (&[f64], &mut Prediction),
    ) {
        let [own, left] = [at_point.deviation, at_other.deviation].map(|deviation| (deviation / self.width).powi(2));
        if own > 0.0 {
            let shared = self.kernel.covariance(point, other) - dot(&at_point.known, &at_other.known);
            let known = shared / own.sqrt();
            at_other.known.push(known);
            at_other.deviation = self.width * (left - known * known).max(0.0).sqrt();
        }
    }

    /// Standard deviations on each side of the expected value that hold 95 % of values: by Student's t, since the
    /// width comes from few residuals.
    pub(crate) fn student(&self) -> f64 {
        let freedom = self.values.len().saturating_sub(1).max(1) as f64;
        student(freedom)
    }

    /// The leave-one-out error at each known point, and the predicted standard deviation there.
    pub(crate) fn left_out_errors(&self) -> Vec<(f64, f64)> {
        self.left_out().iter().zip(&self.values).map(|((mean, deviation), value)| (mean - value, *deviation)).collect()
    }

    /// Leave-one-out prediction of each known value: expected value and standard deviation (5.12).
    pub(super) fn left_out(&self) -> Vec<(f64, f64)> {
        let inverse = self.factor.inverse_diagonal();
        let of = |((value, weight), inverse): ((&f64, &f64), &f64)| {
            (value - weight / inverse, self.width * inverse.recip().sqrt())
        };
        self.values.iter().zip(&self.weights).zip(&inverse).map(of).collect()
    }
}
