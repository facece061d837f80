//! Totals of a population from a stratified sample, by generalised regression (Saerndal, Swensson and Wretman 1992, chapters 6
//! and 7): what a window costs is explained by what is known of all windows, and only what is left over is sampled.

use std::collections::{BTreeMap, BTreeSet};

use super::super::work::Kind;

/// What is known of every window: operations of each kind of units, and lines touched for the first time.
pub const KNOWN: usize = Kind::ALL.len() + 1;

/// A window that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Its stratum.
    pub stratum: usize,
    /// What is known of it.
    pub known: [f64; KNOWN],
    /// What was measured, by name; what is not named is 0.
    pub measured: BTreeMap<String, f64>,
}

/// A population of windows: how many each stratum has, and what is known of all together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Population {
    /// Windows a stratum.
    pub strata: Vec<u64>,
    /// Sums.
    pub known: [f64; KNOWN],
}

/// A total and half the width of its interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Total {
    /// The estimate.
    pub total: f64,
    /// The interval reaches so far to either side; none if there are too few windows to tell.
    pub half_width: Option<f64>,
}

/// Estimates the total of everything that was measured in some window. Intervals are of 95 %.
pub fn estimate(population: &Population, windows: &[Window]) -> BTreeMap<String, Total> {
    let (strata, windows) = joined(&population.strata, windows);
    let mut sampled = vec![0u64; strata.len()];
    windows.iter().for_each(|window| sampled[window.stratum] += 1);
    let weights: Vec<f64> =
        windows.iter().map(|window| strata[window.stratum] as f64 / sampled[window.stratum] as f64).collect();
    let names: BTreeSet<&String> = windows.iter().flat_map(|window| window.measured.keys()).collect();
    let solver = Regression::new(&windows, &weights);
    let freedom = windows.len() as f64 - strata.len() as f64 - solver.rank() as f64 + 1.0;
    let leverage = solver.leverage(&windows, &weights);
    let total = |name: &String| {
        let values: Vec<f64> = windows.iter().map(|w| w.measured.get(name).copied().unwrap_or(0.0)).collect();
        let slopes = solver.slopes(&windows, &weights, &values);
        let left: Vec<f64> = windows.iter().zip(&values).map(|(window, y)| y - dot(&slopes, &window.known)).collect();
        // What the regression fitted away of a window's own residual is given back (MacKinnon and White 1985, HC3).
        let full: Vec<f64> = left.iter().zip(&leverage).map(|(left, leverage)| left / (1.0 - leverage)).collect();
        let total = dot(&slopes, &population.known) + left.iter().zip(&weights).map(|(left, w)| left * w).sum::<f64>();
        let (mut variance, mut squares) = (0.0, 0.0);
        for (stratum, (&all, &some)) in strata.iter().zip(&sampled).enumerate() {
            let here = || windows.iter().zip(&full).filter(|(w, _)| w.stratum == stratum).map(|(_, left)| *left);
            let (all, some) = (all as f64, some as f64);
            if some > 1.0 {
                let mean = here().sum::<f64>() / some;
                let spread = here().map(|left| (left - mean).powi(2)).sum::<f64>() / (some - 1.0);
                let here = all * all * (1.0 - some / all) * spread / some;
                variance += here;
                squares += here * here / (some - 1.0);
            }
        }
        // Strata that vary more than others count for few: Satterthwaite's degrees of freedom (Cochran 1977, section 5.4).
        let freedom = if squares > 0.0 { freedom.min(variance * variance / squares) } else { freedom };
        let complete = strata.iter().zip(&sampled).all(|(all, some)| all == some);
        let half_width = match freedom {
            _ if complete => Some(0.0),
            _ if freedom >= 1.0 => Some(student(freedom) * variance.sqrt()),
            _ => None,
        };
        Total { total, half_width }
    };
    names.into_iter().map(|name| (name.clone(), total(name))).collect()
}

/// Strata of which fewer than two windows were measured are joined with the one before (or, at the beginning, behind).
fn joined(strata: &[u64], windows: &[Window]) -> (Vec<u64>, Vec<Window>) {
    let count = |stratum: usize| windows.iter().filter(|window| window.stratum == stratum).count() as u64;
    let (mut merged, mut place): (Vec<(u64, u64)>, Vec<usize>) = (Vec::new(), Vec::new());
    for (stratum, &all) in strata.iter().enumerate() {
        let some = count(stratum);
        match merged.last_mut() {
            Some(last) if last.1 < 2 || some < 2 && (some < all || all == 0) => *last = (last.0 + all, last.1 + some),
            _ => merged.push((all, some)),
        }
        place.push(merged.len() - 1);
    }
    let windows = windows.iter().map(|w| Window { stratum: place[w.stratum], ..w.clone() }).collect();
    (merged.into_iter().map(|(all, _)| all).collect(), windows)
}

fn dot(a: &[f64; KNOWN], b: &[f64; KNOWN]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Weighted least squares, of the columns that are not a combination of those before.
struct Regression {
    /// Rows of the normal equations' inverse; zero for a column that is left out.
    inverse: [[f64; KNOWN]; KNOWN],
    used: [bool; KNOWN],
}

impl Regression {
    fn new(windows: &[Window], weights: &[f64]) -> Self {
        let mut normal = [[0.0; KNOWN]; KNOWN];
        for (window, weight) in windows.iter().zip(weights) {
            for (row, x) in normal.iter_mut().zip(window.known) {
                row.iter_mut().zip(window.known).for_each(|(cell, y)| *cell += weight * x * y);
            }
        }
        // Gauss-Jordan on the matrix beside the unit matrix; a column whose pivot is lost in rounding, or that there are too few
        // windows for, is left out.
        let mut inverse = [[0.0; KNOWN]; KNOWN];
        let mut used = [false; KNOWN];
        let scale: Vec<f64> = (0..KNOWN).map(|column| normal[column][column]).collect();
        let mut rank = 0;
        for column in 0..KNOWN {
            if normal[column][column] <= 1e-6 * scale[column] || 8 * (rank + 1) > windows.len() {
                continue;
            }
            used[column] = true;
            rank += 1;
            inverse[column][column] = 1.0;
            let pivot = normal[column][column];
            normal[column].iter_mut().chain(&mut inverse[column]).for_each(|cell| *cell /= pivot);
            for row in (0..KNOWN).filter(|&row| row != column) {
                let factor = normal[row][column];
                for place in 0..KNOWN {
                    normal[row][place] -= factor * normal[column][place];
                    inverse[row][place] -= factor * inverse[column][place];
                }
            }
        }
        Self { inverse, used }
    }

    fn rank(&self) -> usize {
        self.used.iter().filter(|&&used| used).count()
    }

    /// How much of its own value the regression takes over for each window; kept below 1.
    fn leverage(&self, windows: &[Window], weights: &[f64]) -> Vec<f64> {
        let of = |(window, weight): (&Window, &f64)| {
            let used = |at: &usize| self.used[*at];
            let rows = (0..KNOWN).filter(used).map(|row| {
                let cells = (0..KNOWN).filter(used).map(|column| self.inverse[row][column] * window.known[column]);
                window.known[row] * cells.sum::<f64>()
            });
            (weight * rows.sum::<f64>()).clamp(0.0, 0.9)
        };
        windows.iter().zip(weights).map(of).collect()
    }

    fn slopes(&self, windows: &[Window], weights: &[f64], values: &[f64]) -> [f64; KNOWN] {
        let mut right = [0.0; KNOWN];
        for ((window, weight), value) in windows.iter().zip(weights).zip(values) {
            right.iter_mut().zip(window.known).for_each(|(cell, x)| *cell += weight * x * value);
        }
        std::array::from_fn(|row| {
            let cells = (0..KNOWN).filter(|&column| self.used[column]).map(|c| self.inverse[row][c] * right[c]);
            if self.used[row] { cells.sum() } else { 0.0 }
        })
    }
}

/// The 97.5 % point of Student's t (Hill 1970, algorithm 396's expansion; within 0.1 % from 6 degrees of freedom on; a table below).
fn student(freedom: f64) -> f64 {
    const SMALL: [f64; 5] = [12.706, 4.303, 3.182, 2.776, 2.571];
    const Z: f64 = 1.959_964;
    if freedom < 6.0 {
        return SMALL[freedom as usize - 1];
    }
    let (z2, n) = (Z * Z, freedom);
    let g1 = Z * (z2 + 1.0) / 4.0;
    let g2 = Z * ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
    let g3 = Z * (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0;
    Z + g1 / n + g2 / (n * n) + g3 / (n * n * n)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(stratum: usize, known: [f64; KNOWN], y: f64) -> Window {
        Window { stratum, known, measured: [("y".to_owned(), y)].into() }
    }

    #[test]
    fn students_t_by_the_table() {
        for (freedom, expected) in [(1.0, 12.706), (3.0, 3.182), (10.0, 2.228), (30.0, 2.042), (1000.0, 1.962)] {
            assert!((student(freedom) / expected - 1.0).abs() < 3e-3, "{freedom}: {}", student(freedom));
        }
    }

    #[test]
    fn what_is_known_explains_all_that_it_can() {
        // y = 3 steps + 7 new lines: no sampling error is left, though windows differ.
        let windows: Vec<_> = (0..16u32)
            .map(|i| {
                let known = [f64::from(100 + i * i), 0.0, 0.0, 0.0, f64::from(i % 5)];
                window(i as usize / 4, known, 3.0 * known[0] + 7.0 * known[KNOWN - 1])
            })
            .collect();
        let population = Population { strata: vec![40; 4], known: [20_000.0, 0.0, 0.0, 0.0, 300.0] };
        let Total { total, half_width } = estimate(&population, &windows)["y"];
        assert!((total - 62_100.0).abs() < 1e-6, "{total}");
        assert!(half_width.unwrap() < 1e-6);
    }

    #[test]
    fn a_complete_sample_is_the_sum() {
        let windows: Vec<_> = (0..6).map(|i| window(i / 2, [1.0, 0.0, 0.0, 0.0, 0.0], (i * i) as f64)).collect();
        let total = estimate(&Population { strata: vec![2; 3], known: [6.0, 0.0, 0.0, 0.0, 0.0] }, &windows)["y"];
        assert!((total.total - 55.0).abs() < 1e-9);
        assert_eq!(total.half_width, Some(0.0));
    }

    #[test]
    fn lonely_windows_join_their_neighbours() {
        const ONE: [f64; KNOWN] = [1.0, 0.0, 0.0, 0.0, 0.0];
        let windows = [window(0, ONE, 5.0), window(0, ONE, 5.0), window(1, ONE, 5.0)];
        let (strata, joined) = joined(&[10, 4, 0], &windows);
        assert_eq!(strata, [14]);
        assert!(joined.iter().all(|window| window.stratum == 0));
    }
}
