//! A process given values at points: what it is elsewhere.

use super::cholesky::{Cholesky, dot};
use super::kernel::Kernel;
use crate::student::student;

/// A process given values at points.
#[derive(Clone, Debug)]
pub(crate) struct Process {
    kernel: Kernel,
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    factor: Cholesky,
    /// The covariances' inverse times the values.
    weights: Vec<f64>,
    /// How much wider intervals are than the process says, by its cross-validated residuals.
    width: f64,
}

/// What a process is at a point.
#[derive(Clone, Debug)]
pub(crate) struct Prediction {
    /// The expected value.
    pub(crate) mean: f64,
    /// The standard deviation.
    pub(crate) deviation: f64,
    /// What the point shares with the points known.
    known: Vec<f64>,
}

impl Process {
    /// The process with `kernel` and these values at these points; none if rounding loses it.
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

    /// The process with intervals as wide as its own cross-validated residuals want them, and never narrower than it
    /// says itself.
    pub(super) fn widened(mut self) -> Self {
        let left_out = self.left_out();
        let square = |((mean, deviation), value): (&(f64, f64), &f64)| ((value - mean) / deviation).powi(2);
        let squares: f64 = left_out.iter().zip(&self.values).map(square).sum();
        self.width = (squares / self.values.len().max(1) as f64).sqrt().max(1.0);
        self
    }

    /// Its kernel.
    pub(crate) fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// The logarithm of the values' likelihood (2.30), but for a constant.
    pub(super) fn log_likelihood(&self) -> f64 {
        -0.5 * (dot(&self.values, &self.weights) + self.factor.log_determinant())
    }

    /// What the process is at a point: its value with noise.
    pub(crate) fn predict(&self, point: &[f64]) -> Prediction {
        let shared: Vec<f64> = self.points.iter().map(|known| self.kernel.covariance(known, point)).collect();
        let known = self.factor.forward(&shared);
        let own = self.kernel.covariance(point, point) + self.kernel.noise * self.kernel.noise;
        let variance = (own - dot(&known, &known)).max(0.0);
        Prediction { mean: dot(&shared, &self.weights), deviation: self.width * variance.sqrt(), known }
    }

    /// The value at a point will be known, whatever it is: what is said of the one at `other` becomes surer.
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

    /// So many standard deviations on each side of the expected value hold 95 % of values: by Student's t, as there are
    /// few residuals to know the width by.
    pub(crate) fn student(&self) -> f64 {
        let freedom = self.values.len().saturating_sub(1).max(1) as f64;
        student(freedom)
    }

    /// The error at each known value of the process without it, and the standard deviation that it has there.
    pub(crate) fn left_out_errors(&self) -> Vec<(f64, f64)> {
        self.left_out().iter().zip(&self.values).map(|((mean, deviation), value)| (mean - value, *deviation)).collect()
    }

    /// Each known value as the process without it would have it: expected value and standard deviation (5.12).
    pub(super) fn left_out(&self) -> Vec<(f64, f64)> {
        let inverse = self.factor.inverse_diagonal();
        let of = |((value, weight), inverse): ((&f64, &f64), &f64)| {
            (value - weight / inverse, self.width * inverse.recip().sqrt())
        };
        self.values.iter().zip(&self.weights).zip(&inverse).map(of).collect()
    }
}
