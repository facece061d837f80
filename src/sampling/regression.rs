//! Weighted least squares for the estimates of a sample.

use super::covariates::{COLUMNS, Columns};

/// The scalar product.
pub(super) fn dot(a: &Columns, b: &Columns) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Minimum windows for each column. (Kitchen, `small`, intervals of cycles: with four, those of 24 windows are nearly
/// twice as wide as with six; with eight, those of 12 windows are wider by a third.)
const WINDOWS_A_COLUMN: usize = 6;

/// Weighted least squares, of columns that are linearly independent of those used before.
pub(super) struct Regression {
    /// Rows of the normal equations' inverse; 0 for unused columns.
    inverse: [Columns; COLUMNS],
    used: [bool; COLUMNS],
}

impl Regression {
    /// The regression on weighted rows; `order` has the columns, most wanted first.
    pub(super) fn new(rows: &[Columns], weights: &[f64], order: &[usize]) -> Self {
        let mut normal = [[0.0; COLUMNS]; COLUMNS];
        for (covariates, weight) in rows.iter().zip(weights) {
            for (row, x) in normal.iter_mut().zip(covariates) {
                row.iter_mut().zip(covariates).for_each(|(cell, y)| *cell += weight * x * y);
            }
        }
        // Gauss-Jordan with the unit matrix beside the matrix. A column is left out if its pivot is lost in rounding,
        // or if there are too few windows for it.
        let mut inverse = [[0.0; COLUMNS]; COLUMNS];
        let mut used = [false; COLUMNS];
        let scale: Vec<f64> = (0..COLUMNS).map(|column| normal[column][column]).collect();
        let mut rank = 0;
        for &column in order {
            if normal[column][column] <= 1e-6 * scale[column] || WINDOWS_A_COLUMN * (rank + 1) > rows.len() {
                continue;
            }
            used[column] = true;
            rank += 1;
            inverse[column][column] = 1.0;
            let pivot = normal[column][column];
            normal[column].iter_mut().chain(&mut inverse[column]).for_each(|cell| *cell /= pivot);
            for row in (0..COLUMNS).filter(|&row| row != column) {
                let factor = normal[row][column];
                for place in 0..COLUMNS {
                    normal[row][place] -= factor * normal[column][place];
                    inverse[row][place] -= factor * inverse[column][place];
                }
            }
        }
        Self { inverse, used }
    }

    /// Number of used columns.
    pub(super) fn rank(&self) -> usize {
        self.used.iter().filter(|&&used| used).count()
    }

    /// The leverage of each window: the share of its own value in its fitted value; limited to 0.9.
    pub(super) fn leverage(&self, rows: &[Columns], weights: &[f64]) -> Vec<f64> {
        let of = |(covariates, weight): (&Columns, &f64)| {
            let used = |at: &usize| self.used[*at];
            let rows = (0..COLUMNS).filter(used).map(|row| {
                let cells = (0..COLUMNS).filter(used).map(|column| self.inverse[row][column] * covariates[column]);
                covariates[row] * cells.sum::<f64>()
            });
            (weight * rows.sum::<f64>()).clamp(0.0, 0.9)
        };
        rows.iter().zip(weights).map(of).collect()
    }

    /// A factor for each window's weight, with which the sums of the used columns are those of `all`.
    pub(super) fn calibration(&self, rows: &[Columns], weights: &[f64], all: &Columns) -> Vec<f64> {
        let mut missing = *all;
        for (covariates, weight) in rows.iter().zip(weights) {
            missing.iter_mut().zip(covariates).for_each(|(sum, x)| *sum -= weight * x);
        }
        let used = |at: &usize| self.used[*at];
        let slope = |column: usize| (0..COLUMNS).filter(used).map(|row| missing[row] * self.inverse[row][column]).sum();
        let slopes: Columns = std::array::from_fn(|column| if self.used[column] { slope(column) } else { 0.0 });
        rows.iter().map(|covariates| 1.0 + dot(&slopes, covariates)).collect()
    }

    /// The slopes that fit `values` best; 0 for unused columns.
    pub(super) fn slopes(&self, rows: &[Columns], weights: &[f64], values: &[f64]) -> Columns {
        let mut right = [0.0; COLUMNS];
        for ((covariates, weight), value) in rows.iter().zip(weights).zip(values) {
            right.iter_mut().zip(covariates).for_each(|(cell, x)| *cell += weight * x * value);
        }
        std::array::from_fn(|row| {
            let cells = (0..COLUMNS).filter(|&column| self.used[column]).map(|c| self.inverse[row][c] * right[c]);
            if self.used[row] { cells.sum() } else { 0.0 }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calibrated_windows_have_the_sums_of_all() {
        let row = |at: u32| {
            let mut row = [0.0; COLUMNS];
            (row[0], row[2], row[5]) = (f64::from(at), f64::from(at * at % 7), f64::from(at % 3));
            row
        };
        let rows: Vec<Columns> = (1..=40).map(row).collect();
        let weights: Vec<f64> = (1..=40).map(|at| 1.0 + f64::from(at % 4)).collect();
        let mut all = [0.0; COLUMNS];
        (all[0], all[2], all[5]) = (2500.0, 260.0, 111.0);
        // The third column (5) is not used.
        let counts = Regression::new(&rows, &weights, &[0, 2]).calibration(&rows, &weights, &all);
        let sum = |column: usize| {
            let all = rows.iter().zip(&weights).zip(&counts);
            all.map(|((row, weight), count)| weight * count * row[column]).sum::<f64>()
        };
        assert!((sum(0) - 2500.0).abs() < 1e-9 && (sum(2) - 260.0).abs() < 1e-9, "{} {}", sum(0), sum(2));
        assert!((sum(5) - 111.0).abs() > 1.0, "{}", sum(5));
    }
}
