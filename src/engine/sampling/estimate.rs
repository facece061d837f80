//! Totals of a population from a stratified sample, by generalised regression (Saerndal, Swensson and Wretman 1992, chapters 6
//! and 7): what a window costs is explained by what is known of all windows, and only what is left over is sampled.

use std::collections::{BTreeMap, BTreeSet};

use super::super::work::Kind;

/// Columns of what is known of every window; see [`Known`].
pub const KNOWN: usize = 1 + 2 * Kind::ALL.len();

/// What is known of a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// Operations of each kind of units.
    pub operations: [u64; Kind::ALL.len()],
    /// Lines that tags alone would move between the L1s of each kind and the L2.
    pub moved: [u64; Kind::ALL.len()],
    /// Lines that they would move between L2 and DRAM.
    pub dram: u64,
}

impl Known {
    /// As columns: all operations, lines of the DRAM, all lines of the L2, then operations and lines of each kind but the first.
    pub fn columns(&self) -> [f64; KNOWN] {
        let mut columns = [0.0; KNOWN];
        columns[1] = self.dram as f64;
        columns[2] = self.moved.iter().sum::<u64>() as f64;
        columns[2 + Kind::ALL.len()..]
            .iter_mut()
            .zip(&self.moved[1..])
            .for_each(|(column, &moved)| *column = moved as f64);
        with_operations(columns, self.operations)
    }
}

/// The same columns with other operations.
pub fn with_operations(mut columns: [f64; KNOWN], operations: [u64; Kind::ALL.len()]) -> [f64; KNOWN] {
    columns[0] = operations.iter().sum::<u64>() as f64;
    columns[3..].iter_mut().zip(&operations[1..]).for_each(|(column, &operations)| *column = operations as f64);
    columns
}

/// The columns that explain a figure, the best first: few windows allow for few columns.
fn order(name: &str) -> impl Iterator<Item = usize> {
    let below = ["=bytes.dram", "bytes.dram", "dram", "caches.l2"].iter().any(|prefix| name.starts_with(prefix));
    let moved = ["=bytes.l2", "bytes.l2", "caches.l1"].iter().any(|prefix| name.starts_with(prefix));
    let first = if below { 1 } else { 2 * usize::from(moved) };
    std::iter::once(first).chain((0..KNOWN).filter(move |&column| column != first))
}

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

impl Window {
    /// Adds another part of the same window.
    pub fn add(&mut self, part: Self) {
        self.known.iter_mut().zip(part.known).for_each(|(sum, known)| *sum += known);
        part.measured.into_iter().for_each(|(name, value)| *self.measured.entry(name).or_default() += value);
    }
}

/// A population of windows: how many each stratum has, and what is known of all together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Population {
    /// Windows a stratum.
    pub strata: Vec<u64>,
    /// Sums.
    pub known: [f64; KNOWN],
}

impl Population {
    /// Adds what is known of something.
    pub fn add(&mut self, known: &[f64; KNOWN]) {
        self.known.iter_mut().zip(known).for_each(|(sum, known)| *sum += known);
    }
}

/// A total and half the width of its interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Total {
    /// The estimate.
    pub total: f64,
    /// The interval reaches so far to either side; none if there are too few windows to tell.
    pub half_width: Option<f64>,
}

impl Total {
    /// Half the interval's width over the total.
    pub fn share(&self) -> Option<f64> {
        let half_width = self.half_width?;
        Some(if self.total > 0.0 { half_width / self.total } else { 0.0 })
    }
}

/// Estimates the total of everything that was measured in some window. Intervals are of 95 %.
pub fn estimate(population: &Population, windows: &[Window]) -> BTreeMap<String, Total> {
    let (strata, windows) = joined(&population.strata, windows);
    let mut sampled = vec![0u64; strata.len()];
    windows.iter().for_each(|window| sampled[window.stratum] += 1);
    let weights: Vec<f64> =
        windows.iter().map(|window| strata[window.stratum] as f64 / sampled[window.stratum] as f64).collect();
    let names: BTreeSet<&String> = windows.iter().flat_map(|window| window.measured.keys()).collect();
    let mut solvers: BTreeMap<Vec<usize>, (Regression, Vec<f64>)> = BTreeMap::new();
    let mut total = |name: &String| {
        let (solver, leverage) = solvers.entry(order(name).collect()).or_insert_with_key(|order| {
            let solver = Regression::new(&windows, &weights, order);
            let leverage = solver.leverage(&windows, &weights);
            (solver, leverage)
        });
        let freedom = windows.len() as f64 - strata.len() as f64 - solver.rank() as f64 + 1.0;
        let values: Vec<f64> = windows.iter().map(|w| w.measured.get(name).copied().unwrap_or(0.0)).collect();
        let slopes = solver.slopes(&windows, &weights, &values);
        let left: Vec<f64> = windows.iter().zip(&values).map(|(window, y)| y - dot(&slopes, &window.known)).collect();
        // What the regression fitted away of a window's own residual is given back (MacKinnon and White 1985, HC2).
        let full: Vec<f64> =
            left.iter().zip(leverage.iter()).map(|(left, leverage)| left / (1.0 - leverage).sqrt()).collect();
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
                squares += here * here / (some + 1.0);
            }
        }
        // Strata that vary more than others count for few: degrees of freedom by Welch 1947, whose -2 and +2 set right that the
        // variances are estimates themselves.
        let freedom = if squares > 0.0 && freedom >= 1.0 {
            freedom.min(variance * variance / squares - 2.0).max(1.0)
        } else {
            freedom
        };
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
    fn new(windows: &[Window], weights: &[f64], order: &[usize]) -> Self {
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
        for &column in order {
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

    /// Operations and lines of the DRAM.
    fn known(operations: f64, lines: f64) -> [f64; KNOWN] {
        let mut known = [0.0; KNOWN];
        (known[0], known[1]) = (operations, lines);
        known
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
                let known = known(f64::from(100 + i * i), f64::from(i % 5));
                window(i as usize / 4, known, 3.0 * known[0] + 7.0 * known[1])
            })
            .collect();
        let population = Population { strata: vec![40; 4], known: known(20_000.0, 300.0) };
        let Total { total, half_width } = estimate(&population, &windows)["y"];
        assert!((total - 62_100.0).abs() < 1e-6, "{total}");
        assert!(half_width.unwrap() < 1e-6);
    }

    #[test]
    fn a_complete_sample_is_the_sum() {
        let windows: Vec<_> = (0..6).map(|i| window(i / 2, known(1.0, 0.0), (i * i) as f64)).collect();
        let total = estimate(&Population { strata: vec![2; 3], known: known(6.0, 0.0) }, &windows)["y"];
        assert!((total.total - 55.0).abs() < 1e-9);
        assert_eq!(total.half_width, Some(0.0));
    }

    #[test]
    fn lonely_windows_join_their_neighbours() {
        let one = known(1.0, 0.0);
        let windows = [window(0, one, 5.0), window(0, one, 5.0), window(1, one, 5.0)];
        let (strata, joined) = joined(&[10, 4, 0], &windows);
        assert_eq!(strata, [14]);
        assert!(joined.iter().all(|window| window.stratum == 0));
    }
}
