//! The Cholesky factor of a symmetric positive definite matrix.

/// The lower factor, row by row: row `i` has `i + 1` cells.
#[derive(Clone, Debug)]
pub(super) struct Cholesky {
    rows: Vec<Vec<f64>>,
}

impl Cholesky {
    /// Factors the matrix whose lower half `cell(row, column)` gives; `None` if it is not positive definite.
    pub(super) fn new(size: usize, cell: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(size);
        for row in 0..size {
            let mut cells: Vec<f64> = Vec::with_capacity(row + 1);
            for column in 0..row {
                let above: &Vec<f64> = &rows[column];
                cells.push((cell(row, column) - dot(&cells, &above[..column])) / above[column]);
            }
            let rest = cell(row, row) - dot(&cells, &cells);
            if rest.is_nan() || rest <= 0.0 {
                return None;
            }
            cells.push(rest.sqrt());
            rows.push(cells);
        }
        Some(Self { rows })
    }

    /// The solution of `L x = right`.
    pub(super) fn forward(&self, right: &[f64]) -> Vec<f64> {
        let mut found: Vec<f64> = Vec::with_capacity(right.len());
        for (row, &value) in self.rows.iter().zip(right) {
            let at = found.len();
            found.push((value - dot(&row[..at], &found)) / row[at]);
        }
        found
    }

    /// The solution of `L^T x = right`.
    pub(super) fn backward(&self, right: &[f64]) -> Vec<f64> {
        let mut rest = right.to_vec();
        for at in (0..rest.len()).rev() {
            let row = &self.rows[at];
            let value = rest[at] / row[at];
            rest[at] = value;
            rest[..at].iter_mut().zip(row).for_each(|(cell, factor)| *cell -= factor * value);
        }
        rest
    }

    /// The logarithm of the matrix's determinant.
    pub(super) fn log_determinant(&self) -> f64 {
        2.0 * self.rows.iter().enumerate().map(|(at, row)| row[at].ln()).sum::<f64>()
    }

    /// The diagonal of the matrix's inverse.
    pub(super) fn inverse_diagonal(&self) -> Vec<f64> {
        let size = self.rows.len();
        let unit = |at: usize| -> Vec<f64> { (0..size).map(|place| f64::from(u8::from(place == at))).collect() };
        (0..size).map(|at| self.forward(&unit(at)).iter().map(|cell| cell * cell).sum()).collect()
    }
}

/// The dot product.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_solves_and_inverts() {
        let matrix = [[4.0, 2.0, 0.6], [2.0, 5.0, 1.5], [0.6, 1.5, 3.8]];
        let factor = Cholesky::new(3, |row, column| matrix[row][column]).unwrap();
        let solved = factor.backward(&factor.forward(&[1.0, 2.0, 3.0]));
        let product = matrix.map(|row| dot(&row, &solved));
        product.iter().zip([1.0, 2.0, 3.0]).for_each(|(found, wanted)| assert!((found - wanted).abs() < 1e-12));
        // 4 (5 * 3.8 - 1.5 * 1.5) - 2 (2 * 3.8 - 1.5 * 0.6) + 0.6 (2 * 1.5 - 5 * 0.6).
        assert!((factor.log_determinant() - 53.6f64.ln()).abs() < 1e-12, "{}", factor.log_determinant().exp());
        for at in 0..3 {
            let unit: Vec<f64> = (0..3).map(|place| f64::from(u8::from(place == at))).collect();
            let column = factor.backward(&factor.forward(&unit));
            assert!((column[at] - factor.inverse_diagonal()[at]).abs() < 1e-12);
        }
        assert!(Cholesky::new(2, |row, column| if row == column { 1.0 } else { 2.0 }).is_none(), "it is not positive");
    }
}
