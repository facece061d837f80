//! Student's t, for 95 % intervals of what few values tell.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// The 97.5 % point of Student's t; nothing is within it where there is no degree of freedom.
pub(crate) fn student(freedom: f64) -> f64 {
    // From a million degrees on the point stays within a millionth, and the library's search may not end.
    StudentsT::new(0.0, 1.0, freedom.min(1e6)).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn students_t_by_the_table() {
        for (freedom, expected) in [
            (1.0, 12.706),
            (2.5, 3.5747),
            (3.0, 3.182),
            (7.3, 2.3451),
            (10.0, 2.228),
            (30.0, 2.042),
            (1000.0, 1.962),
            (1e9, 1.960),
        ] {
            assert!((student(freedom) / expected - 1.0).abs() < 1e-3, "{freedom}: {}", student(freedom));
        }
    }
}
