//! Weighted least squares for the estimates of a sample.

use super::known::{COLUMNS, Columns};

/// The sum of products.
pub(super) fn dot(a: &Columns, b: &Columns) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Windows for a column, at least. (Kitchen, `small`, intervals of cycles: with four, those of 24 windows are nearly
/// twice as wide as with six; with eight, those of 12 windows are wider by a third.)
const WINDOWS_A_COLUMN: usize = 6;

/// Weighted least squares, of the columns that are not a combination of those before.
pub(super) struct Regression {
    /// Rows of the normal equations' inverse; zero for a column that is left out.
    inverse: [Columns; COLUMNS],
    used: [bool; COLUMNS],
}

impl Regression {
    /// Of rows with weights; columns in the order in which they are wanted.
    pub(super) fn new(rows: &[Columns], weights: &[f64], order: &[usize]) -> Self {
        let mut normal = [[0.0; COLUMNS]; COLUMNS];
        for (known, weight) in rows.iter().zip(weights) {
            for (row, x) in normal.iter_mut().zip(known) {
                row.iter_mut().zip(known).for_each(|(cell, y)| *cell += weight * x * y);
            }
        }
        // Gauss-Jordan on the matrix beside the unit matrix; a column whose pivot is lost in rounding, or that there
        // are too few windows for, is left out.
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

    /// Columns that are used.
    pub(super) fn rank(&self) -> usize {
        self.used.iter().filter(|&&used| used).count()
    }

    /// How much of its own value the regression takes over for each window; kept below 1.
    pub(super) fn leverage(&self, rows: &[Columns], weights: &[f64]) -> Vec<f64> {
        let of = |(known, weight): (&Columns, &f64)| {
            let used = |at: &usize| self.used[*at];
            let rows = (0..COLUMNS).filter(used).map(|row| {
                let cells = (0..COLUMNS).filter(used).map(|column| self.inverse[row][column] * known[column]);
                known[row] * cells.sum::<f64>()
            });
            (weight * rows.sum::<f64>()).clamp(0.0, 0.9)
        };
        rows.iter().zip(weights).map(of).collect()
    }

    /// How much each window counts beside its weight, so that the sums of the columns that are used are those of `all`.
    pub(super) fn calibration(&self, rows: &[Columns], weights: &[f64], all: &Columns) -> Vec<f64> {
        let mut missing = *all;
        for (known, weight) in rows.iter().zip(weights) {
            missing.iter_mut().zip(known).for_each(|(sum, x)| *sum -= weight * x);
        }
        let used = |at: &usize| self.used[*at];
        let slope = |column: usize| (0..COLUMNS).filter(used).map(|row| missing[row] * self.inverse[row][column]).sum();
        let slopes: Columns = std::array::from_fn(|column| if self.used[column] { slope(column) } else { 0.0 });
        rows.iter().map(|known| 1.0 + dot(&slopes, known)).collect()
    }

    /// What explains `values` best.
    pub(super) fn slopes(&self, rows: &[Columns], weights: &[f64], values: &[f64]) -> Columns {
        let mut right = [0.0; COLUMNS];
        for ((known, weight), value) in rows.iter().zip(weights).zip(values) {
            right.iter_mut().zip(known).for_each(|(cell, x)| *cell += weight * x * value);
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
        // The third column is not asked for.
        let counts = Regression::new(&rows, &weights, &[0, 2]).calibration(&rows, &weights, &all);
        let sum = |column: usize| {
            let all = rows.iter().zip(&weights).zip(&counts);
            all.map(|((row, weight), count)| weight * count * row[column]).sum::<f64>()
        };
        assert!((sum(0) - 2500.0).abs() < 1e-9 && (sum(2) - 260.0).abs() < 1e-9, "{} {}", sum(0), sum(2));
        assert!((sum(5) - 111.0).abs() > 1.0, "{}", sum(5));
    }
}
